"""Rectification: known warps are undone, nothing aliases, corners may come in any order."""

from itertools import permutations

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from jaxtex.core.errors import InputError
from jaxtex.photo import rectify as module
from jaxtex.photo.rectify import apply_homography, homography_from_corners, rectify, sort_corners

SQUARE = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
QUAD = np.array([(22.0, 15.0), (101.0, 30.0), (90.0, 80.0), (10.0, 71.0)])

shifts = st.lists(st.floats(-0.2, 0.2), min_size=8, max_size=8).map(lambda flat: np.reshape(flat, (4, 2)))


def wall(points: np.ndarray) -> np.ndarray:
    """A smooth pattern on the plane, three channels, at points (x, y) of a picture of 80 x 50."""
    x, y = points[..., 0], points[..., 1]
    waves = [np.sin(x / 4) * np.cos(y / 5), np.cos(x / 6 + y / 7), np.sin(x / 20) + y / 50]
    return 0.5 + 0.2 * np.stack(waves, axis=-1)


def centres(width: int, height: int) -> np.ndarray:
    return np.stack(np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5), axis=-1)


def test_a_known_warp_is_undone_to_a_fraction_of_a_pixel() -> None:
    to_wall = homography_from_corners(QUAD, SQUARE * (80, 50))
    photo = wall(apply_homography(to_wall, centres(110, 90)))
    upright, homography = rectify(photo, QUAD, size=(80, 50))
    truth = wall(centres(80, 50))
    assert np.abs(upright - truth).max() < 0.01
    assert np.abs(upright[:, 1:] - truth[:, :-1]).max() > 0.04, "half a pixel beside would show"
    assert np.allclose(apply_homography(homography, QUAD), SQUARE * (80, 50))


def test_corners_in_any_order_give_the_same_picture() -> None:
    photo = wall(centres(110, 90))
    upright, homography = rectify(photo, QUAD)
    for order in permutations(range(4)):
        again, matrix = rectify(photo, QUAD[list(order)])
        assert np.array_equal(upright, again)
        assert np.array_equal(homography, matrix)


@pytest.mark.parametrize("turn", np.radians([0, 20, 44, 46, 90, 200]))
def test_corners_go_clockwise_from_the_top_left(turn: float) -> None:
    matrix = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    quad = sort_corners((SQUARE - 0.5) * (4, 3) @ matrix)
    x, y = (np.roll(quad, -1, axis=0) - quad).T
    before_x, before_y = np.roll(x, 1), np.roll(y, 1)
    assert (before_x * y - before_y * x > 0).all()
    assert quad.sum(axis=1).argmin() == 0


def test_a_diamond_begins_at_its_top() -> None:
    assert sort_corners([(0, 5), (5, 10), (10, 5), (5, 0)])[0].tolist() == [5, 0]


def test_the_whole_frame_gives_the_picture_back() -> None:
    photo = np.random.default_rng(0).random((17, 23)).astype(np.float32)
    upright, homography = rectify(photo, SQUARE * (23, 17))
    assert upright.shape == photo.shape
    assert np.allclose(upright, photo, atol=1e-5)
    assert np.allclose(homography, np.eye(3))


@pytest.mark.parametrize("period", [2, 3, 4])
def test_what_shrinks_does_not_alias(period: int) -> None:
    columns = np.arange(96) // (period / 2) % 2
    upright, _ = rectify(np.tile(columns, (48, 1)), SQUARE * (96, 48), size=(8, 48))
    assert np.abs(upright - columns.mean()).max() < 0.02


def test_shrinking_keeps_the_mean_of_each_block() -> None:
    photo = np.random.default_rng(1).random((40, 60, 3))
    upright, _ = rectify(photo, SQUARE * (60, 40), size=(12, 10))
    blocks = photo.reshape(10, 4, 12, 5, 3).mean(axis=(1, 3))
    assert np.abs(upright - blocks).max() < 1e-5


def test_light_does_not_overshoot() -> None:
    photo = np.zeros((20, 20))
    photo[:, 10:] = 1
    upright, _ = rectify(photo, SQUARE * 20, size=(77, 77))
    assert upright.min() >= 0
    assert upright.max() <= 1


def test_bands_of_rows_do_not_show(monkeypatch: pytest.MonkeyPatch) -> None:
    photo = wall(centres(110, 90))
    whole, _ = rectify(photo, QUAD, size=(31, 27))
    monkeypatch.setattr(module, "_BAND", 200)
    assert np.array_equal(rectify(photo, QUAD, size=(31, 27))[0], whole)


@pytest.mark.parametrize(("edge", "size"), [(0, (60, 40)), (1, (50, 50))])
def test_the_size_is_that_of_the_longer_edges(edge: int, size: tuple[int, int]) -> None:
    quad = np.array([(10, 10), (60, 10), (60, 50), (10, 50)], float)
    quad[edge] += (-10, 0) if edge == 0 else (0, -10)
    upright, _ = rectify(np.zeros((100, 100)), quad)
    assert (upright.shape[1], upright.shape[0]) == pytest.approx(size, abs=1.5)


@given(shifts, shifts)
def test_homographies_take_corners_to_corners_and_back(first: np.ndarray, second: np.ndarray) -> None:
    source, target = 300 * (SQUARE + first) + 50, 40 * (SQUARE + second)
    there = homography_from_corners(source, target)
    back = homography_from_corners(target, source)
    inside = source.mean(axis=0) + 0.3 * (source - source.mean(axis=0))
    assert np.allclose(apply_homography(there, source), target, atol=1e-8)
    assert np.allclose(apply_homography(back, apply_homography(there, inside)), inside, atol=1e-7)


@given(shifts)
def test_straight_lines_stay_straight(shift: np.ndarray) -> None:
    homography = homography_from_corners(SQUARE + shift, SQUARE)
    a, b, c = apply_homography(homography, [(0.2, 0.3), (0.4, 0.4), (0.8, 0.6)])
    assert abs(np.linalg.det(np.array([b - a, c - a]))) < 1e-9


def test_points_of_any_leading_shape_are_mapped() -> None:
    assert apply_homography(np.eye(3), np.zeros((2, 5, 2))).shape == (2, 5, 2)
    assert np.isinf(apply_homography([[1, 0, 0], [0, 1, 0], [1, 0, 0]], (0.0, 1.0))).any()


@pytest.mark.parametrize(
    ("corners", "told"),
    [
        (QUAD[:3], r"four points \(x, y\), got an array of shape \[3, 2\]"),
        (np.zeros((4, 3)), r"shape \[4, 3\]"),
        ([(0, 0), (9, 0), (9, np.nan), (0, 9)], "finite"),
        ([(0, 0), (9, 0), (9, 9), (9, 9)], "same point"),
        ([(5, 5)] * 4, "same point"),
        ([(0, 0), (5, 0), (10, 0), (5, 9)], r"\(5, 0\) lies in line"),
        ([(0, 0), (20, 0), (10, 20), (10, 5)], r"inwards at \(10, 5\)"),
        ([(0, 0), (111, 0), (100, 50), (0, 50)], r"\(111, 0\) lies outside .* 110 x 90"),
        ([(0, -1), (100, 0), (100, 50), (0, 50)], r"\(0, -1\) lies outside"),
    ],
)
def test_corners_of_no_rectangle_are_refused(corners: np.ndarray, told: str) -> None:
    with pytest.raises(InputError, match=told):
        rectify(np.zeros((90, 110)), corners)


@pytest.mark.parametrize("size", [(0, 5), (5, -1), (40000, 5)])
def test_sizes_out_of_range_are_refused(size: tuple[int, int]) -> None:
    with pytest.raises(InputError, match=f"{size[0]} x {size[1]} is out of range"):
        rectify(np.zeros((90, 110)), QUAD, size=size)


def test_wrong_shapes_of_homographies_and_points_are_refused() -> None:
    with pytest.raises(InputError, match="3 x 3"):
        apply_homography(np.eye(2), (0, 0))
    with pytest.raises(InputError, match=r"\[..., 2\]"):
        apply_homography(np.eye(3), (0, 0, 1))
    with pytest.raises(InputError, match="four points"):
        homography_from_corners(QUAD[:3], QUAD)
    with pytest.raises(InputError, match="convex"):
        homography_from_corners(QUAD[[0, 2, 1, 3]], QUAD)
