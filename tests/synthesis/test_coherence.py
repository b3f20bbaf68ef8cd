"""Tests of `jaxtex.synthesis.coherence`: on textures whose continuation is known, and by what holds for all."""

from functools import cache
from typing import Any

import jax
import numpy as np
import pytest
import skimage.data

from jaxtex.synthesis.coherence import coherence_steps, inpaint_coherence, inpaint_steps, synthesise_coherence
from jaxtex.synthesis.sources import copy_sources

KEY = jax.random.key(3)


def noise(*shape: int) -> np.ndarray:
    return np.random.default_rng(0).random(shape)


@cache
def photograph(name: str) -> np.ndarray:
    return getattr(skimage.data, name)()[:64, :64, None] / np.float32(255)


@cache
def made_of(name: str, seed: int = 3) -> np.ndarray:
    sources = synthesise_coherence(photograph(name), (64, 64), key=jax.random.key(seed))
    sources.setflags(write=False)
    return sources


def stripes(rows: int, columns: int) -> np.ndarray:
    """Bright and dark, at a period of 8 pixels."""
    return np.resize(np.float32([0, 0, 0.3, 1, 1, 1, 0.3, 0]), columns)[None, :, None].repeat(rows, axis=0)


def weave(rows: int, columns: int) -> np.ndarray:
    """At a period of 8 pixels along both axes, with no axis of symmetry."""
    tile = np.random.default_rng(5).random((8, 8, 1), np.float32)
    return np.tile(tile, (rows // 8 + 1, columns // 8 + 1, 1))[:rows, :columns]


@pytest.mark.parametrize("shape", [(1, 1), (1, 50), (37, 61), (64, 64)])
def test_any_size_is_made(shape: tuple[int, int]) -> None:
    sources = synthesise_coherence(photograph("grass"), shape, key=KEY)
    assert sources.shape == (*shape, 2)
    assert sources.dtype == np.int32
    assert sources.min() >= 3
    assert sources.max() <= 60


@pytest.mark.parametrize("channels", [2, 3, 5])
@pytest.mark.parametrize("shape", [(9, 40), (7, 7)])
def test_any_exemplar_will_do(shape: tuple[int, int], channels: int) -> None:
    sources = synthesise_coherence(noise(*shape, channels), (20, 20), key=KEY)
    limits = np.array(shape)
    assert (sources >= 3).all()
    assert (sources < limits - 3).all()


def test_the_same_key_makes_the_same() -> None:
    again = synthesise_coherence(photograph("grass"), (64, 64), key=KEY)
    np.testing.assert_array_equal(again, made_of("grass"))
    other = made_of("grass", seed=4)
    assert (other != again).any(axis=2).mean() > 0.9


def test_double_precision_makes_no_difference() -> None:
    again = synthesise_coherence(photograph("grass").astype(np.float64), (64, 64), key=KEY)
    np.testing.assert_array_equal(again, made_of("grass"))


@pytest.mark.parametrize("name", ["grass", "gravel"])
def test_neighbourhoods_are_the_exemplars(name: str) -> None:
    """Those of 5 x 5 pixels are far nearer to some of the exemplar than the exemplar's are to each other, and still
    farther from those that pixels in random order have."""
    exemplar = photograph(name)
    made = copy_sources(exemplar, made_of(name))
    shuffled = np.random.default_rng(1).permutation(exemplar.reshape(-1, 1)).reshape(exemplar.shape)

    def windows(picture: np.ndarray) -> np.ndarray:
        return np.lib.stride_tricks.sliding_window_view(picture[..., 0], (5, 5)).reshape(-1, 25)

    def distance(picture: np.ndarray) -> float:
        seen, there = windows(picture)[::7], windows(exemplar)
        squares = np.square(seen).sum(axis=1)[:, None] - 2 * seen @ there.T + np.square(there).sum(axis=1)
        return float(np.maximum(squares.min(axis=1), 0).mean())

    assert distance(made) < 0.15 * distance(shuffled)
    assert (made_of(name) != np.moveaxis(np.indices((64, 64)), 0, -1)).any(axis=2).mean() > 0.5


@pytest.mark.parametrize("name", ["grass", "gravel"])
def test_it_repeats_without_a_seam(name: str) -> None:
    """Steps across the border are not above those of all other lines."""
    made = copy_sources(photograph(name), made_of(name))[..., 0]
    for axis in (0, 1):
        steps = np.square(made - np.roll(made, 1, axis)).mean(axis=1 - axis)
        assert steps[0] <= steps[1:].max()


@pytest.mark.parametrize("seed", range(3))
def test_stripes_go_on_across_the_border(seed: int) -> None:
    sources = synthesise_coherence(stripes(64, 64), (64, 64), key=jax.random.key(seed))
    made = copy_sources(stripes(64, 64), sources)
    for shifted in (np.roll(made, 8, axis=1), np.roll(made, 1, axis=0)):
        assert (made == shifted).mean() > 0.95
    assert made.std() == pytest.approx(stripes(64, 64).std(), rel=0.01)


def test_what_is_regular_stays_in_step() -> None:
    made = copy_sources(weave(64, 64), synthesise_coherence(weave(64, 64), (64, 64), key=KEY))
    for axis in (0, 1):
        assert np.isclose(made, np.roll(made, 8, axis)).mean() > 0.9


@pytest.mark.parametrize("name", ["grass", "gravel"])
def test_no_part_of_the_exemplar_starves(name: str) -> None:
    """No quarter of it has less than a tenth of the pixels, or more than half."""
    quarter = (made_of(name) // 32) @ [2, 1]
    shares = np.bincount(quarter.ravel(), minlength=4) / quarter.size
    assert shares.min() > 0.1
    assert shares.max() < 0.5


def test_guides_tell_where_things_go() -> None:
    """The exemplar's left half is dark and its right half bright, both noisy; in the texture bright is above."""
    exemplar = 0.3 * noise(64, 64, 1)
    exemplar[:, 32:] += 0.7
    ours, theirs = np.zeros((64, 64, 1)), np.zeros((64, 48, 1))
    ours[:, 32:], theirs[:32] = 1, 1
    sources = synthesise_coherence(exemplar, (64, 48), key=KEY, guides=(ours, theirs))
    made = copy_sources(exemplar, sources)[..., 0]
    assert (made[2:30] > 0.5).mean() > 0.99
    assert (made[34:62] < 0.5).mean() > 0.99


def test_what_a_guide_leaves_open_is_varied() -> None:
    """Two kinds, in spots as large as many neighbourhoods; one of them is asked for everywhere."""
    exemplar = noise(96, 96, 1)
    kinds = ((np.indices((96, 96)) // 16).sum(axis=0) % 2)[..., None].astype(float)
    sources = synthesise_coherence(exemplar, (64, 64), key=KEY, guides=(kinds, np.ones((64, 64, 1))))
    assert (copy_sources(kinds, sources) == 1).mean() > 0.9
    _, counts = np.unique(sources.reshape(-1, 2), axis=0, return_counts=True)
    assert np.median(np.repeat(counts, counts)) <= 10


def test_colours_of_a_guide_are_all_looked_at() -> None:
    """Three kinds, in three channels of a guide, of an exemplar that is all noise."""
    exemplar = noise(64, 64, 2)
    kinds = np.eye(3)[np.indices((64, 64))[0] * 3 // 64]
    wanted = np.eye(3)[np.indices((64, 48))[1] // 16]
    sources = synthesise_coherence(exemplar, (64, 48), key=KEY, guides=(kinds, wanted))
    assert (copy_sources(kinds, sources) == wanted).all(axis=2).mean() > 0.85


def holes() -> dict[str, np.ndarray]:
    masks = {name: np.zeros((64, 64), bool) for name in ("middle", "border", "corner", "several")}
    masks["middle"][20:36, 24:40] = True
    masks["border"][24:40, 52:] = True
    masks["corner"][:14, :12] = True
    for top, left in ((8, 10), (40, 5), (30, 44)):
        masks["several"][top : top + 9, left : left + 11] = True
    return masks


@pytest.mark.parametrize("where", list(holes()))
@pytest.mark.parametrize("pattern", [stripes, weave])
def test_holes_in_patterns_are_restored(pattern: Any, where: str) -> None:
    hole = holes()[where]
    picture = pattern(64, 64)
    sources = inpaint_coherence(np.where(hole[..., None], 0.5, picture), hole, key=KEY)
    np.testing.assert_allclose(copy_sources(picture, sources), picture, atol=1e-6)


@pytest.mark.parametrize("where", list(holes()))
def test_what_is_known_stays_and_nothing_comes_from_the_hole(where: str) -> None:
    hole = holes()[where]
    picture = np.where(hole[..., None], np.float32(1e3), photograph("gravel"))
    sources = inpaint_coherence(picture, hole, key=KEY)
    own = np.moveaxis(np.indices((64, 64)), 0, -1)
    np.testing.assert_array_equal(sources[~hole], own[~hole])
    assert not hole[sources[..., 0], sources[..., 1]].any()


def test_what_a_hole_holds_does_not_matter() -> None:
    hole = holes()["middle"]
    made = [
        inpaint_coherence(np.where(hole[..., None], fill, photograph("grass")), hole, key=KEY)
        for fill in (0.0, 0.5, noise(64, 64, 1), np.nan)
    ]
    for other in made[1:]:
        np.testing.assert_array_equal(made[0], other)


def test_filled_holes_meet_what_is_around() -> None:
    """Steps across the hole's outline are like those elsewhere."""
    hole = holes()["middle"]
    made = copy_sources(photograph("grass"), inpaint_coherence(photograph("grass"), hole, key=KEY))[..., 0]
    steps = np.abs(np.diff(made, axis=1))
    outline = np.diff(hole.astype(int), axis=1) != 0
    assert steps[outline].mean() < 1.5 * steps.mean()


def test_a_picture_without_a_hole_stays() -> None:
    sources = inpaint_coherence(photograph("grass"), np.zeros((64, 64), bool), key=KEY)
    np.testing.assert_array_equal(sources, np.moveaxis(np.indices((64, 64)), 0, -1))


def check_steps(steps: list[Any], shape: tuple[int, int], limits: tuple[int, int]) -> None:
    assert [step.done for step in steps] == list(range(1, steps[0].total + 1))
    assert {step.total for step in steps} == {len(steps)}
    for step in steps:
        assert step.sources.shape == (*shape, 2)
        assert step.sources.dtype == np.int32
        assert (step.sources >= 0).all()
        assert (step.sources < limits).all()


def test_steps_are_counted_and_lead_to_the_result() -> None:
    exemplar = photograph("grass")[:, :63]
    steps = list(coherence_steps(exemplar, (37, 61), key=KEY))
    check_steps(steps, (37, 61), (64, 63))
    steps = list(coherence_steps(photograph("grass"), (64, 64), key=KEY))
    check_steps(steps, (64, 64), (64, 64))
    np.testing.assert_array_equal(steps[-1].sources, made_of("grass"))
    first = copy_sources(photograph("grass"), steps[0].sources)
    assert first.std() > 0.3 * photograph("grass").std()  # from the first step on there is something to look at


def test_steps_of_filling_keep_what_is_known() -> None:
    hole = holes()["several"]
    steps = list(inpaint_steps(photograph("gravel"), hole, key=KEY))
    check_steps(steps, (64, 64), (64, 64))
    own = np.moveaxis(np.indices((64, 64)), 0, -1)
    np.testing.assert_array_equal(steps[-1].sources[~hole], own[~hole])


def test_radii_are_looked_at() -> None:
    small = synthesise_coherence(photograph("grass"), (64, 64), key=KEY, radius=1)
    assert small.min() >= 1
    assert (small != made_of("grass")).any()


GRASS = np.zeros((20, 20, 1))


@pytest.mark.parametrize(
    ("exemplar", "shape", "options", "told"),
    [
        (np.zeros((20, 20)), (9, 9), {}, r"exemplar of shape \(20, 20\): give \[row, col, channel\]"),
        (np.full((20, 20, 1), np.nan), (9, 9), {}, "exemplar: some values are NaN or infinite"),
        (np.zeros((6, 20, 1)), (9, 9), {}, "exemplar of 20 x 6 pixels holds no neighbourhood of 7 x 7"),
        (GRASS, (0, 9), {}, "each at least 1"),
        (GRASS, (9, -1), {}, "each at least 1"),
        (GRASS, (9, 9, 9), {}, "is no size"),
        (GRASS, (9, 9), {"radius": 0}, "radius: 0 leaves no neighbours"),
        (GRASS, (9, 9), {"radius": 10}, "holds no neighbourhood of 21 x 21"),
        (GRASS, (9, 9), {"guides": (GRASS[:19], np.zeros((9, 9, 1)))}, "guides of shapes"),
        (GRASS, (9, 9), {"guides": (GRASS, np.zeros((9, 8, 1)))}, "guides of shapes"),
        (GRASS, (9, 9), {"guides": (GRASS, np.zeros((9, 9, 2)))}, "guides of shapes"),
        (GRASS, (9, 9), {"guides": (GRASS[..., 0], np.zeros((9, 9, 1)))}, "guide of shape"),
        (GRASS, (9, 9), {"guides": (GRASS, np.full((9, 9, 1), np.inf))}, "guide: some values are NaN"),
    ],
)
def test_what_cannot_be_used_is_told(exemplar: Any, shape: Any, options: Any, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        coherence_steps(exemplar, shape, key=KEY, **options)


def test_holes_that_cannot_be_filled_are_told() -> None:
    frame = np.ones((20, 20), bool)
    frame[:6], frame[:, :6] = False, False
    with pytest.raises(ValueError, match="no neighbourhood of 7 x 7 pixels may be copied from"):
        inpaint_steps(GRASS, frame, key=KEY)
    with pytest.raises(ValueError, match="no neighbourhood of 7 x 7 pixels may be copied from"):
        inpaint_steps(GRASS, np.ones((20, 20), bool), key=KEY)
    with pytest.raises(ValueError, match=r"hole of shape \(20, 19\): give the picture's, \(20, 20\)"):
        inpaint_steps(GRASS, frame[:, :19], key=KEY)
    frame[6, 6] = False  # now the corner's 7 x 7 pixels are known
    sources = inpaint_coherence(GRASS, frame, key=KEY)
    assert (sources[frame] == 3).all()
