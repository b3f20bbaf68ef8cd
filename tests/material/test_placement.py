"""Placements: which of a picture's pixels maps see, against plain loops."""

import jax.numpy as jnp
import numpy as np
import pytest

from jaxtex.material.placement import look_at_picture, over_photograph, over_picture, over_plank
from jaxtex.material.sheet import lay_sheet
from jaxtex.models.tiling import make_tiling

OBLIQUE = {"angle": 0.3, "origin": (31.0, 17.0), "homography": [[1.1, 0.1, 3.0], [0.05, 0.9, -4.0], [6e-4, 1e-3, 1.0]]}


def look(picture, placement, size, **options):
    shown = look_at_picture(picture, placement, rows=range(size[1]), width=size[0], **options)
    assert shown.shape == (size[1], size[0], picture.shape[2])
    return shown


def bilinear(picture, x, y):
    """At one point, by hand; pixels beyond the border are those at the border."""
    height, width = picture.shape[:2]
    left, top = int(np.floor(x - 0.5)), int(np.floor(y - 0.5))
    right, down = x - 0.5 - left, y - 0.5 - top
    total = 0.0
    for row, share_y in ((top, 1 - down), (top + 1, down)):
        for col, share_x in ((left, 1 - right), (left + 1, right)):
            total = total + share_y * share_x * picture[np.clip(row, 0, height - 1), np.clip(col, 0, width - 1)]
    return total


@pytest.mark.parametrize("changes", [{}, OBLIQUE])
def test_maps_see_the_photograph_where_the_tiling_has_them(changes):
    wall = make_tiling(tile_width=30.0, tile_height=20.0, offset=0.5, **changes)
    size, image = (135, 120), (97, 71)
    x, y = np.asarray(wall.to_lattice(jnp.array([48.5, 35.5]))) - np.array([45.0, 40.0])
    sheet = lay_sheet(wall, tiles=(3, 4), near=(x, y))
    placement = over_photograph(sheet, wall, image=image, size=size)
    picture = np.random.default_rng(0).random((image[1], image[0], 2)).astype(np.float32)
    shown = look(picture, placement, size)
    inside = 0
    for row, col in np.random.default_rng(1).integers((0, 0), size[::-1], (300, 2)):
        q = np.array([(col + 0.5) * sheet.width / size[0], (row + 0.5) * sheet.height / size[1]]) + sheet.corner
        x, y = np.asarray(wall.from_lattice(jnp.asarray(q, jnp.float32)), float)
        if 0.01 < x < image[0] - 0.01 and 0.01 < y < image[1] - 0.01:
            inside += 1
            # Both placements magnify, so that a pixel sees one place.
            np.testing.assert_allclose(shown[row, col], bilinear(picture, x, y), atol=2e-4)
        elif not (-0.01 < x < image[0] + 0.01 and -0.01 < y < image[1] + 0.01):
            assert not shown[row, col].any()
    assert inside > 100


def test_nothing_behind_the_camera_is_seen():
    wall = make_tiling(tile_width=30.0, tile_height=20.0, homography=[[1, 0, 0], [0, 1, 0], [0, 8e-3, 1]])
    sheet = lay_sheet(wall, tiles=(3, 40))  # of all heights up to 125 pixels the horizon is nearest
    size = (90, 800)
    shown = look(np.ones((60, 90, 1), np.float32), over_photograph(sheet, wall, image=(90, 60), size=size), size)
    depth = 1 / (1 - 8e-3 * (np.arange(800) + 0.5))
    behind = depth < 0
    assert behind.any()
    assert not shown[behind].any()
    assert shown[:30, :50].all()


def test_smaller_maps_see_the_mean_of_what_each_pixel_covers():
    picture = np.random.default_rng(0).random((60, 84, 1)).astype(np.float32)
    shown = look(picture, over_picture((84, 60), size=(12, 10)), (12, 10))
    blocks = picture.reshape(10, 6, 12, 7, 1).mean(axis=(1, 3))
    # Seven samples a side are the picture's own pixels across, and lie between them along.
    np.testing.assert_allclose(shown, blocks, atol=0.03)
    chess = np.indices((64, 64)).sum(0)[..., None] % 2
    np.testing.assert_allclose(look(chess.astype(np.float32), over_picture((64, 64), size=(8, 8)), (8, 8)), 0.5)


def test_larger_maps_are_bilinear_and_the_same_in_any_pieces():
    picture = np.random.default_rng(0).random((5, 7, 1)).astype(np.float32)
    placement = over_picture((7, 5), size=(28, 20))
    shown = look(picture, placement, (28, 20))
    for row, col in np.ndindex(20, 28):
        expected = bilinear(picture, (col + 0.5) / 4, (row + 0.5) / 4)
        np.testing.assert_allclose(shown[row, col], expected, atol=1e-6)
    np.testing.assert_array_equal(look_at_picture(picture, placement, rows=range(9, 13), width=28), shown[9:13])


def test_beyond_the_border_there_is_nothing_or_the_border():
    picture = np.full((4, 4, 1), 0.75, np.float32)
    placement = over_picture((8, 8), size=(8, 8))
    shown = look(picture, placement, (8, 8))
    np.testing.assert_array_equal(shown[..., 0], np.pad(np.full((4, 4), 0.75), (0, 4)))
    assert (look(picture, placement, (8, 8), goes_on=True) == 0.75).all()


def test_the_middle_of_a_planks_maps_is_that_of_the_photograph():
    placement = over_plank((100, 60), size=(200, 300))
    np.testing.assert_allclose(placement @ [100, 150, 1], [50, 30, 1])
    np.testing.assert_allclose(placement @ [0, 90, 1], [0, 0, 1])
