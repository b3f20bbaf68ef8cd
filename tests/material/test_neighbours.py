"""Colours of neighbouring tiles: alike as they were drawn, and drawn as alike as they were measured."""

import jax
import numpy as np
import pytest
from scipy.ndimage import convolve1d

from jaxtex.core.colour import srgb_to_linear
from jaxtex.material.appearance import Appearance, quantise
from jaxtex.material.draw import draw_tiles, pad_table, to_logit
from jaxtex.material.neighbours import measure_neighbours

KEY = jax.random.key(4)
ROWS, COLUMNS = 40, 40
NONE = ((0.0, 0.0), (0.0, 0.0, 0.0))


def places_of(rows, columns, first=(0, 0)):
    return np.stack(np.indices((rows, columns)), axis=-1).reshape(-1, 2) + first


def draw_field(along=0.0, across=0.0, seed=0):
    """A Gaussian field over the tiles with these correlations between neighbours, as sums of independent numbers."""
    field = np.random.default_rng(seed).normal(size=(ROWS, COLUMNS))
    for axis, correlation in ((1, along), (0, across)):
        # a + b times the next: the correlation is ab / (aa + bb)
        share = np.tan(0.5 * np.arcsin(2 * correlation))
        field = convolve1d(field, [1 / np.hypot(1, share), share / np.hypot(1, share), 0.0], axis=axis, mode="wrap")
    return field.ravel()


def colour_of(field, spread=0.3):
    logit = spread * field[:, None] * np.array([1.0, 0.8, 0.6]) + np.array([0.0, -0.5, -1.0])
    return srgb_to_linear(1 / (1 + np.exp(-logit)))


@pytest.mark.parametrize(("along", "across"), [(0.45, 0.0), (0.0, 0.4), (-0.4, 0.3), (0.3, -0.3)])
def test_correlation_between_neighbours_is_measured(along, across):
    field = draw_field(along, across)
    (found, above), trend = measure_neighbours(places_of(ROWS, COLUMNS), colour_of(field), ((0,),))
    assert found == pytest.approx(along, abs=0.07)
    assert above == pytest.approx(across, abs=0.07)
    assert trend == (0.0, 0.0, 0.0)


def test_what_chance_may_have_made_is_nothing():
    found = [measure_neighbours(places_of(8, 8), colour_of(draw_field(seed=n)[:64]), ((0,),)) for n in range(20)]
    assert sum(each != NONE for each in found) <= 1
    assert measure_neighbours(places_of(2, 5), colour_of(np.arange(10.0)), ((0,),)) == NONE
    assert measure_neighbours(places_of(6, 6), np.full((36, 3), 0.4), ((0,),)) == NONE


def test_it_is_the_ranks_that_correlate():
    field = draw_field(0.45)
    (found, _), _ = measure_neighbours(places_of(ROWS, COLUMNS), colour_of(np.exp(2 * field), spread=0.02), ((0,),))
    assert found == pytest.approx(0.45, abs=0.07)


def test_a_pattern_is_no_correlation():
    places = places_of(20, 20)
    chess = (places.sum(axis=1) % 2) * 4.0
    colours = colour_of(chess + 0.1 * np.random.default_rng(0).normal(size=400))
    assert measure_neighbours(places, colours, ((0, 1), (1, 0))) == NONE
    (along, across), _ = measure_neighbours(places, colours, ((0,),))
    assert max(along, across) < -0.5


def test_a_trend_is_measured_and_is_no_correlation():
    places = places_of(20, 10, first=(7, 3))
    noise = np.random.default_rng(0).normal(size=200)
    (along, across), trend = measure_neighbours(places, colour_of(noise + 0.2 * places[:, 0]), ((0,),))
    np.testing.assert_allclose(trend, 0.3 * 0.2 * np.array([1.0, 0.8, 0.6]), rtol=0.1)
    assert (along, across) == (0.0, 0.0)
    # Along the courses nothing changes steadily.
    assert measure_neighbours(places[:, ::-1], colour_of(noise + 0.2 * places[:, 0]), ((0,),))[1] == (0.0, 0.0, 0.0)


def make_appearance(field, **changes):
    colours = colour_of(field)
    tiles = {(n // 10, n % 10): quantise(colour) for n, colour in enumerate(colours)}
    return Appearance(tiles=tiles, joint=quantise((0.5, 0.5, 0.5)), **changes)


@pytest.mark.parametrize("neighbours", [(0.0, 0.0), (0.6, 0.0), (0.0, 0.5), (-0.5, 0.4), (0.7, -0.7)])
def test_drawn_tiles_are_as_alike_as_asked(neighbours):
    appearance = make_appearance(draw_field()[:100], neighbours=neighbours)
    colours = appearance.colours(*np.indices((64, 64)) + 500, key=KEY)
    score = to_logit(colours.astype(np.float64)).sum(axis=-1)
    score = score - score.mean()
    along = np.mean(score[:, 1:] * score[:, :-1]) / np.mean(score**2)
    across = np.mean(score[1:] * score[:-1]) / np.mean(score**2)
    # Straying by a fifth of a standard deviation is each tile's own.
    np.testing.assert_allclose([along, across], neighbours, atol=0.07)
    (found, above), _ = measure_neighbours(places_of(64, 64), colours.reshape(-1, 3), ((0,),))
    np.testing.assert_allclose([found, above], neighbours, atol=0.07)


def test_correlated_tiles_have_the_same_colours_as_others():
    seen = draw_field()[:100]
    drawn = [
        to_logit(make_appearance(seen, neighbours=pair).colours(*np.indices((64, 64)) + 500, key=KEY)).reshape(-1, 3)
        for pair in ((0.0, 0.0), (0.7, 0.7))
    ]
    own = to_logit(np.array(list(make_appearance(seen).tiles.values())))
    for values in drawn:
        np.testing.assert_allclose(values.mean(axis=0), own.mean(axis=0), atol=0.03)
        np.testing.assert_allclose(values.std(axis=0), own.std(axis=0), rtol=0.1)


def test_a_trend_goes_on_in_drawn_tiles_and_ends_where_the_photograph_does():
    change = np.array([0.12, 0.1, 0.07])
    field = draw_field()[:100]
    trend = tuple(change.tolist())
    logits = to_logit(colour_of(field, 0.1)) + change * (np.arange(100)[:, None] // 10)
    tiles = {(n // 10, n % 10): quantise(colour) for n, colour in enumerate(srgb_to_linear(1 / (1 + np.exp(-logits))))}
    appearance = Appearance(tiles=tiles, joint=(0.5, 0.5, 0.5), trend=trend)
    course = np.arange(-30, 40)
    drawn = to_logit(appearance.colours(course[:, None], np.arange(300) + 100, key=KEY)).mean(axis=1)
    middle = logits.mean(axis=0)
    expected = middle + change * (np.clip(course, 0, 9)[:, None] - 4.5)
    np.testing.assert_allclose(drawn, expected, atol=0.04)


def test_what_a_tile_is_like_is_itself_or_one_of_its_colour():
    appearance = make_appearance(draw_field()[:100])
    course, tile = np.indices((14, 12)) - 2
    drawn = draw_tiles(appearance, course, tile, key=KEY)
    seen = (course >= 0) & (course < 10) & (tile >= 0) & (tile < 10)
    assert np.array_equal(drawn.like[seen], (10 * course + tile)[seen])
    own = to_logit(np.array(list(appearance.tiles.values())))
    off = np.abs(to_logit(drawn.colour) - own[drawn.like])
    assert off[~seen].max() < 1.2 * own.std()
    assert len(np.unique(drawn.like[~seen])) > 30


def test_tables_are_padded_to_powers_of_four():
    for length, padded in ((1, 256), (256, 256), (257, 1024), (1024, 1024), (1025, 4096)):
        table = pad_table(np.ones((length, 2)))
        assert table.shape == (padded, 2)
        assert table.sum() == 2 * length
