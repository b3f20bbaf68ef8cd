"""Masks by value: thresholds and picked colours."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra import numpy as hnp

from jaxtex.core.errors import InputError
from jaxtex.photo.pictures import lightness, to_lab
from jaxtex.photo.segment import colour_mask, pick_colours, threshold_mask

pictures = hnp.arrays(np.float32, (6, 7, 3), elements=st.floats(0, 1, width=32))


def wall(*, joint: float, tile: float) -> tuple[np.ndarray, np.ndarray]:
    """A noisy picture of 48 x 60 pixels and its true mask."""
    rows, columns = np.indices((48, 60))
    truth = (rows % 12 >= 2) & ((columns + 10 * (rows // 12)) % 20 >= 2)
    return np.where(truth, tile, joint) + np.random.default_rng(0).normal(0, 0.01, truth.shape), truth


@pytest.mark.parametrize(("joint", "tile", "joints"), [(0.05, 0.3, "dark"), (0.6, 0.2, "light")])
def test_otsu_finds_the_valley_between_tiles_and_joints(joint: float, tile: float, joints: str) -> None:
    picture, truth = wall(joint=joint, tile=tile)
    assert np.array_equal(threshold_mask(picture, joints=joints), truth)  # type: ignore[arg-type]


@given(pictures, st.floats(0, 100))
def test_a_level_parts_by_lightness(picture: np.ndarray, level: float) -> None:
    mask = threshold_mask(picture, level=level)
    assert np.array_equal(mask, lightness(picture) > level)
    assert np.array_equal(threshold_mask(picture, level=level, joints="light"), ~mask)


def test_a_picture_of_one_lightness_has_no_valley_but_can_be_cut() -> None:
    with pytest.raises(InputError, match=r"one single lightness, 49\.5"):
        threshold_mask(np.full((4, 4), 0.18))
    assert threshold_mask(np.full((4, 4), 0.18), level=40).all()


@pytest.mark.parametrize("tolerance", [0, 5, 20, 60, 200])
def test_colours_within_the_tolerance_of_any_pick_are_alike(tolerance: float) -> None:
    picture = np.random.default_rng(0).random((20, 20, 3))
    picks = picture[0, :2]
    mask = colour_mask(picture, picks, tolerance=tolerance, picked="tiles")
    lab = to_lab(picture)
    for row, column in np.ndindex(mask.shape):
        nearest = min(np.linalg.norm(lab[row, column] - lab[0, k]) for k in (0, 1))
        assert mask[row, column] == (nearest <= tolerance)
    assert np.array_equal(colour_mask(picture, picks, tolerance=tolerance), ~mask)


def test_more_picks_take_in_what_each_takes_in() -> None:
    picture = np.random.default_rng(0).random((9, 9, 3))
    one, other = (colour_mask(picture, picture[k, k], tolerance=40) for k in (2, 7))
    assert np.array_equal(colour_mask(picture, picture[[2, 7], [2, 7]], tolerance=40), one & other)


def test_joints_as_light_as_the_tiles_are_told_by_colour() -> None:
    tile, joint = np.array([0.42, 0.15, 0.10]), np.array([0.15, 0.22, 0.17])
    grey, truth = wall(joint=1, tile=1)
    picture = np.where(truth[..., None], tile, joint) * grey[..., None]
    assert np.ptp(lightness(np.stack([tile, joint])[None])) < 1
    assert np.array_equal(colour_mask(picture, pick_colours(picture, [(30, 1)], radius=0)), truth)


def test_one_channel_takes_picks_of_one_channel() -> None:
    picture, truth = wall(joint=0.05, tile=0.4)
    assert np.array_equal(colour_mask(picture, [[0.05]], tolerance=15), truth)


def test_points_are_x_then_y_and_pick_the_pixel_they_lie_in() -> None:
    picture = np.arange(12, dtype=float).reshape(3, 4)
    points = [(2.0, 1.0), (2.9, 1.9), (0, 0), (4, 3)]
    assert pick_colours(picture, points, radius=0).ravel().tolist() == [6, 6, 0, 11]


def test_grain_does_not_decide_a_pick() -> None:
    picture = np.full((9, 9, 3), 0.5)
    picture[4, 4] = 0
    assert pick_colours(picture, (4.5, 4.5)).tolist() == [[0.5, 0.5, 0.5]]


PICTURE = np.ones((4, 6, 3))


@pytest.mark.parametrize("level", [-1, 101, float("nan")])
def test_levels_out_of_range_are_refused(level: float) -> None:
    with pytest.raises(InputError, match=r"level: .* 0 \(black\) to 100 \(white\)"):
        threshold_mask(PICTURE, level=level)


def test_other_words_than_the_choices_are_refused() -> None:
    with pytest.raises(InputError, match="joints: must be one of dark, light, not 'black'"):
        threshold_mask(PICTURE, joints="black")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="picked: must be one of joints, tiles"):
        colour_mask(PICTURE, PICTURE[0], picked="both")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("picks", "told"),
    [
        (np.zeros((0, 3)), "none given"),
        (np.zeros((2, 1)), r"\[n, 3\] like the picture, not \[2, 1\]"),
        (np.zeros((1, 2, 3)), r"not \[1, 2, 3\]"),
    ],
)
def test_picks_that_are_no_colours_are_refused(picks: np.ndarray, told: str) -> None:
    with pytest.raises(InputError, match=told):
        colour_mask(PICTURE, picks)


def test_negative_tolerance_is_refused() -> None:
    with pytest.raises(InputError, match="tolerance: -1"):
        colour_mask(PICTURE, PICTURE[0], tolerance=-1)


@pytest.mark.parametrize("point", [(-0.1, 1), (6.1, 1), (1, 4.1), (1, float("nan"))])
def test_points_outside_are_refused(point: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="outside the picture, which is 6 x 4"):
        pick_colours(PICTURE, point)


def test_points_of_another_shape_are_refused() -> None:
    with pytest.raises(InputError, match=r"not \[1, 3\]"):
        pick_colours(PICTURE, (1, 2, 3))
