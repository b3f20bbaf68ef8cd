"""Pictures with known tilings -> the fit finds them; pictures of other things -> it says so."""

import numpy as np
import pytest
from skimage import data

from jaxtex.core.errors import InputError
from jaxtex.fitting.tiling import fit_tiling


def paint_wall(size=192, width=48.0, height=24.0, angle=0.0, joint=4.0, offset=0.5, tile=0.2, mortar=0.6):
    """A wall with a colour for each tile and grain, painted by a hard point-in-tile test."""
    y, x = np.mgrid[0:size, 0:size] + 0.5 - size / 2
    along = np.cos(angle) * x + np.sin(angle) * y + 3.0
    across = np.cos(angle) * y - np.sin(angle) * x + 5.0
    course = np.floor(across / height)
    place = along / width - offset * course
    number = np.floor(place)
    inside = np.abs(place - np.round(place)) * width > joint / 2
    inside &= np.abs(across / height - np.round(across / height)) * height > joint / 2
    shade = tile * (1 + 0.3 * np.sin(12.9898 * number + 78.233 * course))
    grain = np.random.default_rng(0).normal(0, 0.02, (size, size))
    return np.clip(np.where(inside, shade, mortar) + grain, 0, 1), inside


@pytest.mark.parametrize(
    ("angle", "offset", "tile", "mortar", "bond"),
    [(0.0, 0.5, 0.2, 0.6, "running"), (0.3, 0.0, 0.6, 0.1, "stack"), (-0.4, 0.3, 0.5, 0.15, "raking")],
)
def test_a_painted_wall_is_found(angle, offset, tile, mortar, bond):
    picture, inside = paint_wall(angle=angle, offset=offset, tile=tile, mortar=mortar)
    fit = fit_tiling(picture)
    assert fit.ok, fit.reason
    assert fit.tiling.bond == bond
    assert float(fit.tiling.tile_width) == pytest.approx(48.0, rel=5e-3)
    assert float(fit.tiling.tile_height) == pytest.approx(24.0, rel=5e-3)
    assert np.degrees(float(fit.tiling.angle)) == pytest.approx(np.degrees(angle), abs=0.1)
    aside = float(fit.tiling.offset) - offset
    assert abs(aside - round(aside)) < 0.02
    assert np.array_equal(fit.tiling.homography, np.eye(3))
    assert np.mean((fit.mask > 0.5) == inside) > 0.9


def test_a_mask_gives_the_joints_too_and_more_exactly():
    picture, inside = paint_wall(angle=0.2)
    fit = fit_tiling(picture, mask=inside.astype(float))
    assert fit.ok, fit.reason
    assert float(fit.tiling.tile_width) == pytest.approx(48.0, rel=5e-4)
    assert float(fit.tiling.mortar_x) == pytest.approx(4.0, abs=0.15)
    assert float(fit.tiling.mortar_y) == pytest.approx(4.0, abs=0.15)
    assert fit.iou > 0.9
    assert 0 < fit.standard_errors["tile_width"] < 0.1


def test_the_same_picture_gives_the_same_fit():
    picture, _ = paint_wall()
    one, other = fit_tiling(picture), fit_tiling(picture)
    assert float(one.tiling.tile_width) == float(other.tiling.tile_width)
    assert np.array_equal(one.mask, other.mask)


def test_a_fixed_parameter_is_kept():
    picture, inside = paint_wall()
    fit = fit_tiling(picture, mask=inside.astype(float), fix={"mortar_y": 5.0})
    assert float(fit.tiling.mortar_y) == pytest.approx(5.0)
    assert "mortar_y" not in fit.standard_errors


@pytest.mark.parametrize(("width", "height"), [(40.0, 40.0), (24.0, 36.0), (36.0, 24.0)])
@pytest.mark.parametrize("name", ["mortar_x", "mortar_y", "tile_width"])
def test_what_is_fixed_on_a_stack_bond_is_kept_under_its_own_name(width, height, name):
    picture, inside = paint_wall(width=width, height=height, offset=0.0, joint=5.0)
    value = {"mortar_x": 4.0, "mortar_y": 4.0, "tile_width": width * 1.002}[name]
    fit = fit_tiling(picture, mask=inside.astype(float), fix={name: value})
    assert float(getattr(fit.tiling, name)) == pytest.approx(value, rel=1e-6)
    assert float(fit.tiling.tile_height) == pytest.approx(height, rel=1e-2)


def test_a_fixed_offset_is_kept_in_a_seamless_picture():
    picture, _ = paint_wall()
    fit = fit_tiling(picture, fix={"offset": 0.49})
    assert float(fit.tiling.offset) == pytest.approx(0.49)


def test_errors_of_the_joints_are_told_for_photographs_too():
    picture, _ = paint_wall(angle=0.2)
    errors = fit_tiling(picture).standard_errors
    assert 0 < errors["mortar_x"] < 1
    assert 0 < errors["tile_width"] < 0.5


def test_joints_that_leave_no_tiles_are_refused():
    picture, inside = paint_wall()
    with pytest.raises(InputError, match="leaves nothing of tiles"):
        fit_tiling(picture, mask=inside.astype(float), fix={"mortar_x": 100.0})


def test_tiles_twice_too_long_are_no_tiling():
    picture, inside = paint_wall(offset=0.0)
    fit = fit_tiling(picture, mask=inside.astype(float), fix={"tile_width": 96.0})
    assert not fit.ok


def test_exposure_does_not_matter():
    picture, _ = paint_wall(angle=0.2)
    assert fit_tiling(picture * 1e3).ok


@pytest.mark.parametrize("name", ["grass", "gravel"])
def test_what_is_no_tiling_is_said_to_be_none(name):
    fit = fit_tiling(getattr(data, name)()[:256, :256] / 255.0)
    assert not fit.ok
    assert fit.reason


@pytest.mark.slow
def test_the_shipped_brick_wall_is_found_obliquely():
    fit = fit_tiling((data.brick() / 255.0) ** 2.2)
    assert fit.ok, fit.reason
    # Courses run nearly vertically, 14 of them across the middle of the picture, seen in perspective.
    assert fit.rows == 14
    assert abs(abs(np.degrees(float(fit.tiling.angle))) - 90) < 3
    assert abs(float(fit.tiling.homography[2, 1])) > 3e-4


@pytest.mark.parametrize(
    ("photo", "mask", "told"),
    [
        (np.zeros((8, 8)), None, "32 x 32"),
        (np.zeros((64, 64, 2)), None, r"must have shape \[H, W\]"),
        (np.full((64, 64), np.nan), None, "NaN or infinite"),
        (np.zeros((64, 64)), np.zeros((32, 32)), "mask has shape"),
        (np.zeros((64, 64)), np.ones((64, 64)), "same everywhere"),
        (np.zeros((64, 64)), np.full((64, 64), 7.0), "between 0"),
    ],
)
def test_pictures_that_cannot_be_fitted_are_refused(photo, mask, told):
    with pytest.raises(InputError, match=told):
        fit_tiling(photo, mask=mask)


def test_an_even_picture_is_no_tiling():
    fit = fit_tiling(np.full((64, 64), 0.5))
    assert not fit.ok
