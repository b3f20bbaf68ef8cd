"""Appearance read off pictures whose colours are known."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest
from skimage import data

from jaxtex.core.colour import linear_to_srgb
from jaxtex.core.errors import InputError
from jaxtex.material import measure
from jaxtex.material.measure import measure_appearance
from jaxtex.models.grids import coverage_grid, on_grid
from jaxtex.models.tiling import make_tiling

VIEW = ((1.02, 0.05, -3.0), (-0.03, 0.98, 2.0), (4e-4, -2e-4, 1.0))
WALL = {
    "tile_width": 46.0,
    "tile_height": 22.0,
    "mortar_x": 5.0,
    "mortar_y": 4.0,
    "offset": 0.5,
    "origin": (80.3, 61.7),
}
JOINT = np.array([0.4, 0.38, 0.35], np.float32)


def paint(tiling, height, width, colour_of, *, joint=JOINT):
    """A photograph of a tiling, its tiles' colours given by (course, tile) arrays."""

    def number(point):
        place = tiling.locate(tiling.to_lattice(point))
        return place.course, place.tile

    course, tile = (np.asarray(part).astype(int) for part in on_grid(number, height, width))
    cover = np.asarray(coverage_grid(tiling, height, width, blur=0.6))[..., None]
    return cover * colour_of(course, tile) + (1 - cover) * joint


def colour_by_number(course, tile):
    return 0.1 + 0.5 * np.stack([(course % 7) / 7, (tile % 5) / 5, ((course + tile) % 3) / 3], axis=-1)


def assert_nearly_equal(colours, expected):
    # Half a step of 8 bits, and what rounding in single precision makes of it.
    np.testing.assert_allclose(
        linear_to_srgb(np.asarray(colours)), linear_to_srgb(np.asarray(expected)), atol=0.6 / 255
    )


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"angle": 0.3},
        {"homography": VIEW, "angle": -0.2},
        {"corner_radius": 5.0},
        {"course_lengths": ((1.0, 0.5),), "offset": 0.25},
    ],
)
def test_colours_of_a_known_wall_are_recovered(changes):
    tiling = make_tiling(**{**WALL, **changes})
    photo = paint(tiling, 140, 190, colour_by_number)
    appearance = measure_appearance(photo, tiling)
    assert len(appearance.tiles) >= 20
    course, tile = np.array(list(appearance.tiles)).T
    assert_nearly_equal(list(appearance.tiles.values()), colour_by_number(course, tile))
    assert_nearly_equal(appearance.joint, JOINT)


def test_speckles_and_stains_do_not_count():
    tiling = make_tiling(**WALL)
    photo = paint(tiling, 140, 190, colour_by_number)
    rng = np.random.default_rng(0)
    photo[rng.random(photo.shape[:2]) < 0.2] = 1.0
    appearance = measure_appearance(photo, tiling)
    course, tile = np.array(list(appearance.tiles)).T
    assert_nearly_equal(list(appearance.tiles.values()), colour_by_number(course, tile))


def test_the_mask_says_what_is_dirt():
    tiling = make_tiling(**WALL)
    photo = paint(tiling, 140, 190, lambda course, tile: np.broadcast_to([0.2, 0.1, 0.1], (*course.shape, 3)))
    mask = np.array(coverage_grid(tiling, 140, 190) > 0.5)
    dirty = np.zeros_like(mask)
    dirty[62:75, 82:126] = True  # more than half of tile 0 of course 0
    photo[dirty] = 0.9
    assert measure_appearance(photo, tiling, mask=mask).tiles[0, 0][0] > 0.8
    assert_nearly_equal(measure_appearance(photo, tiling, mask=mask & ~dirty).tiles[0, 0], [0.2, 0.1, 0.1])


def test_a_mask_that_blackens_whole_tiles_is_wrong_about_them():
    tiling = make_tiling(**WALL)
    photo = paint(tiling, 140, 190, colour_by_number)
    black = np.zeros(photo.shape[:2])
    assert measure_appearance(photo, tiling, mask=black).tiles == measure_appearance(photo, tiling).tiles


def test_joints_overgrown_with_tile_colour_are_told_by_the_mask():
    tiling = make_tiling(**WALL)
    photo = paint(tiling, 140, 190, colour_by_number)
    clean = np.array(coverage_grid(tiling, 140, 190) > 0.5)
    photo[:, :150] = 0.05
    joint_seen = clean | (np.arange(190) < 150)
    assert_nearly_equal(measure_appearance(photo, tiling, mask=joint_seen).joint, JOINT)


def test_a_chessboard_comes_out_as_one():
    floor = make_tiling(tile_width=20.0, tile_height=20.0, origin=(30.0, 50.0))

    def chess(course, tile):
        return np.where((course + tile) % 2, 0.75, 0.1)[..., None] * np.array([1.0, 0.9, 0.8])

    appearance = measure_appearance(paint(floor, 120, 120, chess), floor)
    assert appearance.pattern in (((0, 1), (1, 0)), ((1, 0), (0, 1)))
    assert (appearance.joint_depth, appearance.edge_width) == (0.0, 0.0)


def test_grey_photographs_give_grey_tiles():
    tiling = make_tiling(tile_width=60.0, tile_height=30.0, mortar_x=5.0, mortar_y=5.0)
    photo = data.brick()[..., None] / 255.0
    appearance = measure_appearance(photo, tiling)
    colours = np.array(list(appearance.tiles.values()))
    assert np.array_equal(colours, np.broadcast_to(colours[:, :1], colours.shape))


def test_tiles_at_the_frame_count_when_enough_of_them_is_seen():
    floor = make_tiling(tile_width=20.0, tile_height=20.0, origin=(12.0, 3.0))
    tiles = measure_appearance(np.full((43, 60, 3), 0.5), floor).tiles
    # 12 columns of tile -1 are seen, 8 of tile 2; 3 rows of course -1 are too few.
    assert {tile for _, tile in tiles} == {-1, 0, 1, 2}
    assert {course for course, _ in tiles} == {0, 1}


def test_very_many_tiles_are_thinned(monkeypatch):
    monkeypatch.setattr(measure, "MOST_TILES", 30)
    floor = make_tiling(tile_width=10.0, tile_height=10.0)
    tiles = measure_appearance(np.full((100, 100, 3), 0.5), floor).tiles
    assert 15 <= len(tiles) <= 30
    assert {course for course, _ in tiles} == set(range(10))


def test_what_cannot_be_measured_is_said():
    tiling = make_tiling(**WALL)
    with pytest.raises(InputError, match="shape"):
        measure_appearance(np.zeros((4, 4, 2)), tiling)
    with pytest.raises(InputError, match=r"mask: has the shape \[3, 4\], and the picture \[4, 4\]"):
        measure_appearance(np.zeros((4, 4, 3)), tiling, mask=np.zeros((3, 4)))
    beside = dataclasses.replace(tiling, origin=jnp.array([-1.0, -1.0]))
    with pytest.raises(InputError, match="no tile"):
        measure_appearance(np.zeros((2, 2, 3)), beside)
