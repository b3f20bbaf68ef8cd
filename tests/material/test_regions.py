"""Where interiors are learnt from, as the user says: the right tiles, and what cannot be meant."""

import jax.numpy as jnp
import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.material.cells import cut_box, cut_cells
from jaxtex.material.regions import Regions, _in_lattice, check_rectangles, cut_grain, cut_joints, read_painted
from jaxtex.models.tiling import make_tiling

WALL = {"tile_width": 46.0, "tile_height": 22.0, "mortar_x": 5.0, "mortar_y": 5.0, "origin": (20.3, 11.7)}
PLACES = [(course, tile) for course in range(5) for tile in range(3)]


@pytest.mark.parametrize("offset", [0.0, 0.5])
@pytest.mark.parametrize("angle", [0.0, 0.05])
def test_a_rectangle_cuts_out_what_is_there(angle, offset):
    wall = make_tiling(**WALL, angle=angle, offset=offset)
    y, x = np.indices((140, 190)) + 0.5
    picture = np.stack([x, y, 0 * x], axis=-1).astype(np.float32)
    cells = cut_cells(picture, wall, PLACES)
    centred = [cell.values[6:-6, 8:-8] for cell in cells]
    tile_middle = wall.from_lattice(jnp.array([(1.5 + 2 * offset) * 46, 2.5 * 22]))
    left, top = np.asarray(tile_middle) - [9, 4]
    cut = cut_grain(wall, cells, centred, (left, top, 16.0, 7.0))
    assert cut[..., 0].min() >= left - 0.8
    assert cut[..., 0].max() <= left + 16 + 0.8
    assert cut[..., 1].min() >= top - 0.8
    assert cut[..., 1].max() <= top + 7 + 0.8
    assert 13 <= cut.shape[1] <= 17
    assert 5 <= cut.shape[0] <= 8


@pytest.mark.parametrize(
    ("rectangle", "complaint"),
    [
        ((186.0, 2.0, 4.0, 4.0), "is in no tile that the photograph shows as a whole"),
        ((40.0, 20.0, 2.0, 2.0), "shows too little of a tile"),
        ((20.3, 11.7, 1.0, 20.0), "shows too little of a tile; put it inside of one"),
    ],
)
def test_rectangles_that_show_no_tile_are_named(rectangle, complaint):
    wall = make_tiling(**WALL)
    cells = cut_cells(np.zeros((140, 190, 3), np.float32), wall, PLACES)
    with pytest.raises(InputError, match=complaint) as error:
        cut_grain(wall, cells, [cell.values for cell in cells], rectangle)
    assert str(error.value).startswith("tile region {:g},{:g},{:g}x{:g}: ".format(*rectangle))


def test_pieces_of_joints_lie_along_the_rows_around_nothing():
    random = np.random.default_rng(0)
    picture = (0.5 + 0.02 * random.normal(size=(140, 190, 3))).astype(np.float32)
    picture[:, 60:64] += np.array([0.0, 0.1, 0.2, 0.1], np.float32)[None, :, None]
    strips = cut_joints(picture, make_tiling(**WALL), [(60.3, 14.7, 4.0, 18.0), (20.3, 30.7, 30.0, 5.0)])
    assert strips.shape == (2, 4, 18, 3)
    assert np.abs(np.median(strips, axis=2)).max() < 0.015
    with pytest.raises(InputError, match=r"^joint region 60,14,2x18: is too thin; give at least 3 pixels"):
        cut_joints(picture, make_tiling(**WALL), [(60.0, 14.0, 2.0, 18.0)])


@pytest.mark.parametrize("rectangle", [(60.0, 14.0, 0.2, 18.0), (60.0, 14.0, 18.0, 0.2)])
def test_a_sliver_is_too_thin(rectangle):
    with pytest.raises(InputError, match="is too thin"):
        cut_joints(np.zeros((140, 190, 3), np.float32), make_tiling(**WALL), [rectangle])


@pytest.mark.parametrize("size", [(40.0, 4.0), (4.0, 40.0), (30.0, 30.0), (40.0, 20.0)])
def test_what_is_cut_on_a_turned_wall_lies_inside_of_the_rectangle(size):
    y, x = np.indices((140, 190)) + 0.5
    inside = np.minimum.reduce([x - 60, 60 + size[0] - x, y - 50, 50 + size[1] - y])
    picture = np.repeat(inside[..., None], 3, axis=2).astype(np.float32)
    for angle in (0.1, 0.4, np.pi / 4, 1.0, np.pi / 2, 2.0):
        box = _in_lattice(make_tiling(**WALL, angle=angle), (60.0, 50.0, *size))
        piece = cut_box(picture, make_tiling(**WALL, angle=angle), *box)
        assert piece.size > 0
        assert piece.min() > -0.3
        assert np.prod(piece.shape[:2]) >= 6


@pytest.mark.parametrize(
    ("tiles", "joints", "told"),
    [
        ([(-1.0, 0.0, 5.0, 5.0)], [], "tile region -1,0,5x5"),
        ([(0.0, 0.0, 5.0, 5.0), (186.0, 0.0, 5.0, 5.0)], [], "tile region 186,0,5x5"),
        ([], [(0.0, 137.5, 5.0, 3.0)], "joint region 0,137.5,5x3"),
    ],
)
def test_rectangles_that_leave_the_photograph_are_refused(tiles, joints, told):
    with pytest.raises(InputError) as error:
        check_rectangles(Regions(tuple(tiles), tuple(joints)), (140, 190))
    assert str(error.value) == f"{told}: leaves the photograph, which has 190 x 140 pixels"


def test_rectangles_that_fill_the_photograph_do_not_leave_it():
    check_rectangles(Regions(((0.0, 0.0, 190.0, 140.0),), ((100.0, 0.0, 90.0, 5.0),)), (140, 190))
    check_rectangles(Regions(), (1, 1))


def test_greys_are_kinds_from_the_darkest():
    levels = np.array([[0, 128, 255], [0, 60, 60], [255, 0, 128]]) / 255
    painted = read_painted(levels, (3, 3), "kinds.png")
    assert painted.tolist() == [[0, 2, 3], [0, 1, 1], [3, 0, 2]]
    assert painted.dtype == np.int32
    assert read_painted(np.ones((2, 3)), (2, 3), "white.png").tolist() == [[1, 1, 1]] * 2


@pytest.mark.parametrize(
    ("levels", "complaint"),
    [
        (np.ones((2, 5)), "has 5 x 2 pixels, and the photograph 3 x 2; paint over the photograph itself"),
        (np.zeros((2, 3)), "is all black; paint white"),
        (np.arange(6).reshape(2, 3) / 255, None),
    ],
)
def test_pictures_that_do_not_fit_are_refused(levels, complaint):
    if complaint is None:
        assert read_painted(levels, (2, 3), "kinds.png").max() == 5
        return
    with pytest.raises(InputError) as error:
        read_painted(levels, (2, 3), "kinds.png")
    assert str(error.value).startswith(f"kinds.png: {complaint}")


def test_blurred_paint_is_refused():
    with pytest.raises(InputError, match="has 17 greys, each a kind of tile; paint with 16 at most"):
        read_painted(np.arange(18)[None] / 255, (1, 18), "soft.png")
    assert read_painted(np.arange(17)[None] / 255, (1, 17), "hard.png").max() == 16
