"""Masked synthesis: elements that colours hardly tell stay whole; depths in masks."""

import jax
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import ndimage

from jaxtex.progressive.masked import mark_elements, masked_steps, measure_depths, synthesise_masked
from jaxtex.synthesis.coherence import synthesise_coherence

KEY = jax.random.key(0)


def draw_disks(side: int = 96) -> np.ndarray:
    """A disk of radius 7 in each square of 24 pixels, somewhere."""
    rng = np.random.default_rng(0)
    count = side // 24
    middles = (np.indices((count, count)).reshape(2, -1).T + 0.5) * 24 + rng.uniform(-3, 3, (count**2, 2))
    place = np.moveaxis(np.indices((side, side)), 0, -1)[..., None, :]
    return np.sqrt(np.square(place - middles).sum(axis=-1)).min(axis=-1) < 7


def areas_of(mask: np.ndarray) -> np.ndarray:
    labels, _ = ndimage.label(np.pad(mask, 1, mode="wrap"))
    whole = np.setdiff1d(labels, np.concatenate([labels[[0, -1]].ravel(), labels[:, [0, -1]].ravel()]))
    return np.bincount(labels.ravel())[whole]


def test_elements_stay_whole_that_colours_hardly_tell() -> None:
    mask = draw_disks()
    exemplar = np.random.default_rng(0).random((96, 96, 3)) + 0.1 * mask[..., None]
    disk, whole = np.median(areas_of(mask)), []
    for seed in range(2):
        key = jax.random.key(seed)
        for sources in (
            synthesise_masked(exemplar, mask, (96, 96), key=key),
            synthesise_coherence(exemplar, (96, 96), key=key),
        ):
            areas = areas_of(mask[sources[..., 0], sources[..., 1]])
            whole.append(np.mean(np.abs(areas / disk - 1) < 0.25))
    assert min(whole[::2]) > 0.7
    assert np.mean(whole[::2]) > np.mean(whole[1::2]) + 0.3


def test_steps_end_with_what_is_made() -> None:
    exemplar = np.random.default_rng(0).random((40, 44, 1))
    mask = np.indices((40, 44)).sum(axis=0) // 8 % 3
    *_, last = masked_steps(exemplar, mask, (33, 50), key=KEY)
    np.testing.assert_array_equal(last.sources, synthesise_masked(exemplar, mask, (33, 50), key=KEY))
    assert last.done == last.total
    assert last.sources.shape == (33, 50, 2)


@settings(max_examples=50, deadline=None)
@given(arrays(np.uint8, st.tuples(st.integers(2, 12), st.integers(2, 12)), elements=st.integers(0, 3)))
def test_depths_tell_labels_apart(mask: np.ndarray) -> None:
    values = np.unique(mask)
    if len(values) < 2:
        with pytest.raises(ValueError, match="has 1 values"):
            measure_depths(mask)
        return
    depths = measure_depths(mask)
    shown = values[1:] if len(values) == 2 else values
    assert depths.shape == (*mask.shape, len(shown))
    assert np.abs(depths).max() <= 1
    for depth, value in zip(np.moveaxis(depths, -1, 0), shown, strict=True):
        np.testing.assert_array_equal(depth > 0, mask == value)


def test_depth_grows_towards_the_middle_and_is_cut_there() -> None:
    mask = np.zeros((9, 41), bool)
    mask[:, 10:31] = True
    row = measure_depths(mask)[4, :, 0]
    assert (np.diff(row[:21]) >= 0).all()
    assert row[20] == 1
    assert row[0] < -0.8
    np.testing.assert_allclose(row, row[::-1])


def test_the_mask_counts_as_much_as_told() -> None:
    exemplar = np.random.default_rng(0).random((30, 30, 3))
    mask = draw_disks(48)[:30, :30]
    for weight in (0.5, 2.0):
        marked = mark_elements(exemplar, mask, weight)
        spread = marked[..., 3].std() / np.sqrt(exemplar.var(axis=(0, 1)).sum())
        assert spread == pytest.approx(weight, rel=1e-4)


def test_masks_that_cannot_be() -> None:
    exemplar = np.zeros((30, 30, 3))
    mask = draw_disks(48)
    with pytest.raises(ValueError, match="give the exemplar's"):
        mark_elements(exemplar, mask)
    with pytest.raises(ValueError, match=r"give \[row, col\]"):
        measure_depths(np.zeros((4, 4, 1)))
    with pytest.raises(ValueError, match="has 5 values"):
        measure_depths(np.arange(25).reshape(5, 5) % 5)
    with pytest.raises(ValueError, match="guide_weight"):
        synthesise_masked(exemplar, mask[:30, :30], (30, 30), key=KEY, mask_weight=0)
