"""Colours in words, distances, draws, and wavefronts."""

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plain_synthesis import draw, mix
from plain_synthesis import draw_place as draw_plainly

from jaxtex.synthesis.neighbourhoods import (
    causal_taps,
    check_exemplar,
    choose_place,
    draw_bits,
    draw_place,
    measure_places,
    mix_bits,
    pack_colours,
    quantise,
    square_offsets,
    squared_difference,
)
from jaxtex.synthesis.wavefront import Wavefronts


@pytest.mark.parametrize("channels", [1, 3, 4, 5, 9])
def test_differences_of_packed_colours(channels: int) -> None:
    first, second = np.random.default_rng(0).integers(0, 256, (2, 50, channels), dtype=np.uint8)
    words = zip(pack_colours(first), pack_colours(second), strict=True)
    seen = sum(np.asarray(squared_difference(jnp.asarray(a), jnp.asarray(b))) for a, b in words)
    np.testing.assert_array_equal(seen, np.square(first.astype(int) - second.astype(int)).sum(axis=1))


@pytest.mark.parametrize("radius", [1, 3])  # taps unrolled, and in a loop
def test_distances_of_neighbourhoods(radius: int) -> None:
    random, offsets = np.random.default_rng(0), square_offsets(radius)
    levels = random.integers(0, 256, (12, 15, 3), dtype=np.uint8)
    window = random.integers(0, 256, (len(offsets), 4, 3), dtype=np.uint8)
    weight = random.random((len(offsets), 4)) < 0.7
    row, column = random.integers(radius, 12 - radius, (6, 4)), random.integers(radius, 15 - radius, (6, 4))
    around = levels[row[..., None] + offsets[:, 0], column[..., None] + offsets[:, 1]].astype(int)
    expected = (np.square(around - window.swapaxes(0, 1)).sum(axis=-1) * weight.T).sum(axis=-1)
    words = [jnp.asarray(each.reshape(-1)) for each in pack_colours(levels)]
    packed = [jnp.asarray(each) for each in pack_colours(window)]
    places = jnp.asarray(row * 15 + column)
    seen = measure_places(words, places, offsets @ np.array([15, 1], np.int32), packed, jnp.asarray(weight))
    np.testing.assert_array_equal(seen, expected)


def test_of_equally_near_places_the_first() -> None:
    chosen = choose_place(jnp.array([[7, 1], [3, 2], [5, 0]]), jnp.array([[4, 1], [4, 9], [6, 2]]))
    assert chosen.tolist() == [3, 1]


def test_values_beyond_the_range_are_clipped() -> None:
    assert quantise(np.array([-1.0, 0.0, 0.5, 1.0, 7.0])).tolist() == [0, 0, 128, 255, 255]


@given(word=st.integers(0, 2**32 - 1), number=st.integers(0, 100))
def test_draws(word: int, number: int) -> None:
    assert int(mix_bits(jnp.uint32(word))) == mix(word)
    assert int(draw_bits(jnp.uint32(word), number)) == draw(word, number)


def test_random_places_cover_all_whole_neighbourhoods_evenly() -> None:
    bits = draw_bits(jnp.arange(20000, dtype=jnp.uint32), 1)
    places = np.asarray(draw_place(bits, (9, 8), 2))
    row, column = divmod(places, 8)
    counts = np.histogram2d(row, column, bins=(np.arange(10), np.arange(9)))[0]
    assert counts[2:7, 2:6].sum() == 20000
    assert np.abs(counts[2:7, 2:6] / 1000 - 1).max() < 0.15
    assert divmod(int(places[0]), 8) == draw_plainly(int(bits[0]), (9, 8), 2)


@pytest.mark.parametrize(("size", "radius"), [((1, 1), 2), ((1, 9), 1), ((9, 1), 4), ((5, 17), 2), ((16, 6), 3)])
def test_wavefronts_visit_each_pixel_once_and_see_its_neighbours(size: tuple[int, int], radius: int) -> None:
    shape = (size[0] + 2 * radius, size[1] + 2 * radius)
    fronts, offsets = Wavefronts(shape, radius), square_offsets(radius)
    numbers = jnp.arange(shape[0] * shape[1]).reshape(shape)
    centre = causal_taps(radius)

    def visit(starts, row, column, state):
        cells, visits, right = state
        near = fronts.read(cells, starts) % 10**6
        down, across = row[None] + offsets[:, :1], column[None] + offsets[:, 1:]
        there = (down + radius) * shape[1] + across + radius
        # What comes before in scanline order has been visited, what comes after has not.
        done = fronts.read(cells, starts) >= 10**6
        inner = (down >= 0) & (down < size[0]) & (across >= 0) & (across < size[1])
        order = (done == (inner & (jnp.arange(len(offsets)) < centre)[:, None])).all(axis=0)
        right &= jnp.where(row >= 0, (near == there).all(axis=0) & order, True).all()
        own = fronts.read(cells, starts[centre : centre + 1])[0]
        new = jnp.where(row >= 0, own + 10**6, own)
        return cells.at[starts[centre] + jnp.arange(len(new))].set(new), visits + (row >= 0).sum(), right

    cells, visits, right = fronts.run(visit, (fronts.skew(numbers, -1), jnp.int32(0), jnp.bool_(True)), offsets)
    assert bool(right)
    assert int(visits) == size[0] * size[1]
    inside = numbers[radius : radius + size[0], radius : radius + size[1]] + 10**6
    np.testing.assert_array_equal(fronts.unskew(cells), inside)


@pytest.mark.parametrize(
    ("shape", "radius", "complaint"),
    [
        ((5, 5, 0), 1, "none of them empty"),
        ((5, 5), 1, "give .row, col, channel."),
        ((2, 9, 1), 1, "9 x 2 pixels holds no neighbourhood of 3 x 3"),
        ((1, 32769, 1), 0, "radius: 0"),
        ((3, 32769, 1), 1, "too many"),
        ((41, 41, 30), 20, "too large"),
    ],
)
def test_exemplars_that_cannot_be_used(shape: tuple, radius: int, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        check_exemplar(np.zeros(shape), radius)
