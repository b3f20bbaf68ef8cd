"""Grounds: learnt of what is seen between things, filled in several ways."""

import jax
import numpy as np
import pytest
from scipy import ndimage

from jaxtex.particles.grounds import Fill, choose_fill, even_ground, make_ground
from jaxtex.particles.things import Decomposition, describe_particles

KEY = jax.random.key(0)
ROW, COLUMN = np.indices((72, 96))
LABELS = np.zeros((72, 96), int)
for number, (row, column) in enumerate([(18, 20), (18, 70), (54, 45), (56, 84)]):
    LABELS[np.hypot(ROW - row, COLUMN - column) < 8] = number + 1
THINGS = describe_particles(LABELS, [0] * 4)
GRAIN = np.random.default_rng(0).uniform(0.3, 0.5, (72, 96, 3)).astype(np.float32)
PICTURE = np.where(LABELS[..., None] > 0, 0.9, GRAIN).astype(np.float32)


def tile_squares() -> Decomposition:
    tight = np.where((ROW % 8 > 1) & (COLUMN % 8 > 1), 1 + ROW // 8 * 12 + COLUMN // 8, 0)
    return describe_particles(tight, [0] * 108)


@pytest.mark.parametrize("fill", [None, "coherence", "patches", "noise"])
def test_grounds_are_learnt_of_the_ground_alone(fill: Fill | None) -> None:
    ground = make_ground(PICTURE, THINGS, (64, 50), key=KEY, fill=fill)
    assert ground.shape == (50, 64, 3)
    assert ground.dtype == np.float32
    assert ground.min() > 0.25
    assert ground.max() < 0.55
    np.testing.assert_allclose(ground.mean(axis=(0, 1)), 0.4, atol=0.02)
    assert ground.std() == pytest.approx(GRAIN.std(), rel=0.25)


@pytest.mark.parametrize("fill", ["coherence", "patches"])
def test_rims_of_things_are_not_taken_for_ground(fill: Fill) -> None:
    away = ndimage.distance_transform_edt(LABELS == 0)
    rimmed = np.where(((away > 0) & (away < 7))[..., None], 0.05, PICTURE)
    assert make_ground(rimmed, THINGS, (64, 50), key=KEY, fill=fill).min() > 0.2


def test_grounds_repeat_without_a_seam() -> None:
    smooth = ndimage.gaussian_filter(GRAIN, (2, 2, 0))
    for fill in ("coherence", "patches", "noise", "heap"):
        ground = make_ground(smooth, THINGS, (64, 50), key=KEY, fill=fill)
        step = np.abs(np.diff(ground, axis=0)).mean(axis=(1, 2))
        assert np.abs(ground[0] - ground[-1]).mean() < 2 * step.max()


def test_heaps_have_the_gaps_colour_and_the_things_in_it() -> None:
    squares = tile_squares()
    gaps = np.where(squares.labels[..., None] > 0, [0.8, 0.6, 0.4], [0.2, 0.1, 0.2]).astype(np.float32)
    heap = make_ground(gaps, squares, (60, 60), key=KEY)
    np.testing.assert_allclose(heap.mean(axis=(0, 1)), [0.2, 0.1, 0.2], rtol=0.2)
    assert heap.std() > 0.02


def test_what_fills_follows_from_how_much_ground_is_seen() -> None:
    squares = tile_squares()
    bright = np.where(squares.labels[..., None] > 0, 0.2, 0.8).astype(np.float32)
    assert choose_fill(PICTURE, THINGS) == "coherence"
    assert choose_fill(bright, squares) == "patches"
    assert choose_fill(1 - bright, squares) == "heap"
    np.testing.assert_allclose(make_ground(bright, squares, (40, 40), key=KEY), 0.8, atol=1e-3)


def test_light_on_the_ground_is_evened_and_its_grain_stays() -> None:
    slope = (COLUMN[..., None] / 96 - 0.5) * 0.4
    evened = even_ground(PICTURE + slope.astype(np.float32), THINGS)
    columns = np.where(LABELS == 0, evened[..., 0], np.nan)
    fit = np.polyfit(np.arange(96), np.nanmean(columns, axis=0), 1)
    assert abs(fit[0] * 96) < 0.15
    plain = even_ground(PICTURE, THINGS)[LABELS == 0]
    assert np.corrcoef(plain[:, 0], GRAIN[LABELS == 0][:, 0])[0, 1] > 0.99


def test_wrong_requests_are_told() -> None:
    with pytest.raises(ValueError, match="'sand' is none; give one of coherence, patches, noise, heap"):
        make_ground(PICTURE, THINGS, (20, 20), key=KEY, fill="sand")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="picture of shape"):
        make_ground(PICTURE[1:], THINGS, (20, 20), key=KEY)
    with pytest.raises(ValueError, match="scale is 0"):
        make_ground(PICTURE, THINGS, (20, 20), key=KEY, scale=0.0)


def test_a_picture_without_ground_is_made_anew_as_a_heap() -> None:
    mosaic = describe_particles(1 + np.indices((72, 96))[1] // 48, [0, 0])
    made = make_ground(PICTURE, mosaic, (50, 40), key=KEY)
    assert made.shape == (40, 50, PICTURE.shape[2])
    assert made.mean() == pytest.approx(PICTURE.mean(), rel=0.2)


def test_grain_is_as_many_times_larger_as_is_said() -> None:
    plain, large = (make_ground(PICTURE, THINGS, size, key=KEY, scale=s) for size, s in (((60, 45), 1), ((120, 90), 2)))
    for axis in (0, 1):  # linear interpolation, then the mean of two pixels
        plain = ndimage.convolve1d(plain, [0.125, 0.75, 0.125], axis=axis, mode="wrap")
    np.testing.assert_allclose(large.reshape(45, 2, 60, 2, -1).mean(axis=(1, 3)), plain, atol=1e-5)
    steps = np.abs(np.diff(np.concatenate([large, large[:1]]), axis=0)).mean(axis=(1, 2))
    assert steps[-1] < 2 * np.median(steps)
