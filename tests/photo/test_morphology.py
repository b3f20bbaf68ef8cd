"""Cleaning masks: against plain loops, and by the laws that morphology obeys."""

from itertools import pairwise

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra import numpy as hnp

from jaxtex.core.errors import InputError
from jaxtex.photo.morphology import (
    check_mask,
    close_mask,
    dilate_mask,
    erode_mask,
    open_mask,
    outline_mask,
    remove_small_regions,
)

masks = hnp.arrays(bool, st.tuples(st.integers(1, 8), st.integers(1, 8)))
radii = st.one_of(st.sampled_from([0.0, 1.0, 2.0, 5**0.5, 2**0.5, 20.0]), st.floats(0, 5))
CLEANERS = [erode_mask, dilate_mask, open_mask, close_mask, outline_mask]


def erode_by_loop(mask: np.ndarray, radius: float) -> np.ndarray:
    """Every pixel whose disk, so far as it lies in the frame, is tile."""
    places = list(np.ndindex(mask.shape))
    eroded = np.empty_like(mask)
    for r, c in places:
        # radius**2 of, say, sqrt(5) is not quite 5
        eroded[r, c] = all(mask[i, j] for i, j in places if (i - r) ** 2 + (j - c) ** 2 <= np.floor(radius**2 + 1e-9))
    return eroded


@given(masks, radii)
def test_eroding_agrees_with_a_plain_loop(mask: np.ndarray, radius: float) -> None:
    assert np.array_equal(erode_mask(mask, radius), erode_by_loop(mask, radius))


@given(masks, radii)
def test_dilating_is_eroding_the_joints(mask: np.ndarray, radius: float) -> None:
    assert np.array_equal(dilate_mask(mask, radius), ~erode_by_loop(~mask, radius))
    assert np.array_equal(close_mask(mask, radius), ~open_mask(~mask, radius))


@given(masks, radii)
def test_opening_and_closing_twice_change_nothing_more(mask: np.ndarray, radius: float) -> None:
    for clean in (open_mask, close_mask):
        once = clean(mask, radius)
        assert np.array_equal(clean(once, radius), once)


@given(masks, radii)
def test_results_lie_one_within_the_other(mask: np.ndarray, radius: float) -> None:
    ladder = [erode_mask, open_mask, lambda same, _: same, close_mask, dilate_mask]
    steps = [clean(mask, radius) for clean in ladder]
    for smaller, larger in pairwise(steps):
        assert (larger | ~smaller).all()


@given(hnp.arrays(np.int8, (2, 7, 7), elements=st.integers(0, 2)), radii)
def test_larger_masks_stay_larger(levels: np.ndarray, radius: float) -> None:
    small, large = levels[0] > 1, levels[0] + levels[1] > 1
    for clean in (erode_mask, dilate_mask, open_mask, close_mask):
        assert (clean(large, radius) | ~clean(small, radius)).all()


@given(masks)
def test_radius_zero_changes_nothing(mask: np.ndarray) -> None:
    for clean in (erode_mask, dilate_mask, open_mask, close_mask):
        assert np.array_equal(clean(mask, 0), mask)


def test_the_frame_is_no_joint() -> None:
    full = np.ones((5, 6), bool)
    assert erode_mask(full, 3).all()
    assert not dilate_mask(~full, 3).any()


def test_opening_joins_the_two_edges_of_a_joint() -> None:
    edges = np.ones((40, 40), bool)
    edges[17] = edges[23] = False
    opened = open_mask(edges, 4)
    assert not opened[17:24].any()
    assert opened[:17].all()
    assert opened[24:].all()


def test_an_outline_runs_along_every_change_and_nowhere_else() -> None:
    mask = np.zeros((9, 9), bool)
    mask[3:6, 3:6] = True
    changes = np.zeros_like(mask)
    for axis in (0, 1):
        for shift in (1, -1):
            changes |= np.roll(mask, shift, axis) != mask
    assert np.array_equal(outline_mask(mask), changes)


def regions_by_loop(mask: np.ndarray, value: bool) -> list[list[tuple[int, int]]]:
    """Connected pixels of one kind: by four sides where they are tile, also by corners where they are joint."""
    steps = [(0, 1), (1, 0), (0, -1), (-1, 0)]
    if not value:
        steps += [(1, 1), (1, -1), (-1, 1), (-1, -1)]
    left = {(int(r), int(c)) for r, c in np.argwhere(mask == value)}
    found = []
    while left:
        front = [left.pop()]
        region = []
        while front:
            r, c = front.pop()
            region.append((r, c))
            beside = {(r + dr, c + dc) for dr, dc in steps} & left
            left -= beside
            front += beside
        found.append(region)
    return found


@given(masks, st.integers(0, 12))
def test_small_regions_go_as_in_a_plain_loop(mask: np.ndarray, area: int) -> None:
    area = min(area, mask.size)
    expected = mask.copy()
    for value in (False, True):
        for region in regions_by_loop(expected, value):
            if len(region) < area:
                expected[tuple(np.transpose(region))] = not value
    cleaned = remove_small_regions(mask, area)
    assert np.array_equal(cleaned, expected)
    for value in (False, True):
        assert all(len(region) >= area for region in regions_by_loop(cleaned, value))


def test_masks_given_are_left_as_they_are() -> None:
    mask = np.random.default_rng(0).random((12, 12)) > 0.3
    before = mask.copy()
    for clean in (*CLEANERS, remove_small_regions):
        clean(mask, 3)
        cleaned = clean(np.ones((3, 3), bool), 0)
        cleaned[:] = False
    assert np.array_equal(mask, before)


@pytest.mark.parametrize("clean", CLEANERS, ids=lambda clean: clean.__name__)
@pytest.mark.parametrize("radius", [-1, float("nan")])
def test_radii_out_of_range_are_refused(clean, radius: float) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match=r"radius: .* out of range; give 0 pixels or more"):
        clean(np.eye(3, dtype=bool), radius)


@pytest.mark.parametrize("area", [-1, 10])
def test_areas_out_of_range_are_refused(area: int) -> None:
    with pytest.raises(InputError, match=f"area: {area} is out of range; give 0 to 9 pixels"):
        remove_small_regions(np.eye(3, dtype=bool), area)


@pytest.mark.parametrize(
    ("mask", "told"),
    [
        (np.eye(3), "must be bool .* not float64"),
        (np.ones(3, bool), r"shape \[H, W\] .* not \[3\]"),
        (np.ones((0, 3), bool), r"at least one pixel, not \[0, 3\]"),
    ],
)
def test_what_is_no_mask_is_refused(mask: np.ndarray, told: str) -> None:
    with pytest.raises(InputError, match=told):
        check_mask(mask)
    for clean in (*CLEANERS, remove_small_regions):
        with pytest.raises(InputError, match=told):
            clean(mask, 1)
