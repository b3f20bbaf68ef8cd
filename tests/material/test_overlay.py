"""The overlay: lines where the joints are, on any ground, and nowhere else."""

import jax.numpy as jnp
import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.material.overlay import draw_overlay
from jaxtex.models.tiling import make_tiling

VIEW = ((1.02, 0.05, -3.0), (-0.03, 0.98, 2.0), (8e-4, -5e-4, 1.0))


def is_line(pixels):
    return (pixels[..., 0] < 0.1) & (pixels[..., 1] > 0.6) & (pixels[..., 2] > 0.5)


@pytest.mark.parametrize("ground", [0.0, 0.5, 1.0])
def test_thick_joints_have_a_line_on_either_side(ground):
    wall = make_tiling(tile_width=50.0, tile_height=40.0, mortar_x=11.0, mortar_y=9.0, origin=(-30.0, -30.0))
    row = is_line(draw_overlay(np.full((120, 200, 3), ground), wall))[20]
    # Lattice lines at 20, 70, 120, 170; edges 5.5 to either side.
    expected = np.array([20, 70, 120, 170])[:, None] + [-5.5, 5.5]
    for x in expected.ravel():
        assert row[int(x - 1) : int(x + 1)].any()
    assert row.sum() <= 2 * expected.size


def test_thin_joints_have_one_line():
    wall = make_tiling(tile_width=50.0, tile_height=40.0, mortar_x=2.0, mortar_y=2.0, origin=(-30.0, -30.0))
    row = is_line(draw_overlay(np.full((120, 200), 0.5), wall))[25]
    assert row.sum() in range(4, 9)
    assert all(row[x - 1 : x + 1].any() for x in (20, 70, 120, 170))


def test_lines_show_on_every_ground():
    wall = make_tiling(tile_width=50.0, tile_height=40.0, mortar_x=8.0, mortar_y=8.0)
    for ground in (np.zeros(3), np.ones(3), np.array([0.0, 0.9, 0.75])):
        drawn = draw_overlay(np.broadcast_to(ground, (80, 100, 3)), wall)
        assert np.abs(drawn - ground).max(axis=-1).max() > 0.3
        assert np.array_equal(drawn[14, 10], ground.astype(np.float32))


def test_lines_are_equally_broad_in_perspective():
    wall = make_tiling(tile_width=60.0, tile_height=60.0, homography=VIEW, angle=0.1)
    lines = is_line(draw_overlay(np.full((400, 400, 3), 0.5), wall))
    near, far = lines[:, :130].mean(), lines[:, 270:].mean()
    assert 0.015 < near < 0.1
    assert 0.015 < far < 0.1


def test_marks_lie_where_the_model_says():
    wall = make_tiling(tile_width=60.0, tile_height=50.0, homography=VIEW, angle=0.1, origin=(40.0, 40.0))
    drawn = draw_overlay(np.full((300, 300, 3), 0.5), wall)
    for node, mark in (((90.0, 75.0), 1), ((30.0, 0.0), 0)):
        x, y = np.asarray(wall.from_lattice(jnp.array(node)))
        colour = drawn[int(y), int(x)]
        assert colour.argmax() == mark  # a dot (more green than all else) or the arrow along (red)


def test_nothing_is_drawn_beyond_the_horizon():
    steep = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1 / 100, 1.0))
    floor = make_tiling(tile_width=30.0, tile_height=30.0, homography=steep, origin=(0.0, -900.0))
    drawn = draw_overlay(np.full((300, 80, 3), 0.5), floor)
    # The horizon is row 100, and the picture has its middle below it.
    assert np.array_equal(drawn[:98], np.full_like(drawn[:98], 0.5))
    assert is_line(drawn[200:]).any()
    assert np.isfinite(drawn).all()


def test_the_photograph_is_left_alone():
    photo = np.random.default_rng(0).uniform(0, 1, (60, 80, 3)).astype(np.float32)
    before = photo.copy()
    drawn = draw_overlay(photo, make_tiling(tile_width=40.0, tile_height=30.0, mortar_x=8.0, mortar_y=8.0))
    assert np.array_equal(photo, before)
    assert (drawn == photo).all(axis=-1).mean() > 0.5
    assert drawn.dtype == np.float32


def test_no_picture_is_refused():
    with pytest.raises(InputError, match="picture"):
        draw_overlay(np.zeros((4, 4, 2)), make_tiling(tile_width=4.0, tile_height=4.0))
