"""Fitting many masks: the same fits as one by one, whichever way they are solved."""

import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.fitting import batch
from jaxtex.fitting.batch import fit_tiling_masks, gathered_solves
from jaxtex.fitting.tiling import fit_tiling

NUMBERS = ("tile_width", "tile_height", "angle", "mortar_x", "mortar_y", "offset", "origin")


def lay_mask(width: float, height: float, offset: float, size: int = 64) -> np.ndarray:
    y, x = np.mgrid[0:size, 0:size] + 0.5
    along = x / width - offset * np.floor(y / height)
    clear = (along % 1.0 * width > 3) & (y % height > 3)
    flipped = np.random.default_rng(0).random(clear.shape) < 0.03
    return (clear ^ flipped).astype(np.float32)


@pytest.fixture(scope="module")
def masks() -> np.ndarray:
    return np.stack([lay_mask(18, 10, 0.5), lay_mask(16, 12, 0.0), lay_mask(22, 11, 0.3)])


@pytest.fixture(scope="module")
def alone(masks):
    return [fit_tiling(mask, mask=mask, perspective=False) for mask in masks]


def test_threads_give_the_single_fits_bit_for_bit(masks, alone):
    seen = []
    fits = fit_tiling_masks(masks, report=lambda done, total: seen.append((done, total)))
    for fit, single in zip(fits, alone, strict=True):
        assert (fit.ok, fit.reason, fit.tiling.bond, fit.iou) == (
            single.ok,
            single.reason,
            single.tiling.bond,
            single.iou,
        )
        for name in NUMBERS:
            np.testing.assert_array_equal(getattr(fit.tiling, name), getattr(single.tiling, name))
    assert seen == [(1, 3), (2, 3), (3, 3)]


def test_solves_gathered_from_threads_give_the_single_fits(masks, alone, monkeypatch):
    sizes = []
    real = batch.solve_many
    monkeypatch.setattr(batch, "solve_many", lambda problems: (sizes.append(len(problems.free)), real(problems))[1])
    with gathered_solves():
        fits = fit_tiling_masks(masks)
    assert sizes
    assert set(sizes) <= {1, 4, 16, 64}
    for fit, single in zip(fits, alone, strict=True):
        assert (fit.ok, fit.tiling.bond) == (single.ok, single.tiling.bond)
        for name in NUMBERS:
            np.testing.assert_allclose(getattr(fit.tiling, name), getattr(single.tiling, name), atol=2e-3)


def test_failures_of_gathered_solves_reach_whoever_asked(masks, monkeypatch):
    def fail(problems):
        raise RuntimeError("out of memory")

    monkeypatch.setattr(batch, "solve_many", fail)
    with gathered_solves(), pytest.raises(RuntimeError, match="out of memory"):
        fit_tiling_masks(masks[:1])


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (np.zeros((64, 64)), r"shape \(64, 64\)"),
        (np.zeros((2, 8, 64)), "64 x 8 pixels"),
        (np.full((2, 64, 64), 2.0), "mask 0 must lie"),
        (np.full((2, 64, 64), np.nan), "mask 0 must lie"),
        (np.ones((2, 64, 64)), "mask 0 is the same everywhere"),
    ],
)
def test_what_is_no_stack_of_masks_is_refused(wrong, message):
    with pytest.raises(InputError, match=message):
        fit_tiling_masks(wrong)


def test_a_bad_mask_among_good_ones_is_named_before_any_fit(masks):
    seen = []
    with pytest.raises(InputError, match="mask 1 is the same everywhere"):
        fit_tiling_masks(np.stack([masks[0], np.ones_like(masks[0])]), report=lambda *at: seen.append(at))
    assert not seen


def test_no_masks_are_no_fits():
    assert fit_tiling_masks(np.zeros((0, 64, 64))) == []
