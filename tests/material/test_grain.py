"""Grain: shades towards edges are told from it, and it is left alone."""

import numpy as np
import pytest
from drawn_cells import draw_cell, draw_mask

from jaxtex.material.edges import SIDES
from jaxtex.material.grain import (
    at_distance,
    face_colour,
    joint_profile,
    joint_strips,
    stack_regions,
    tile_grain,
    tile_profile,
)

DEPTHS = (0.2, 0.1, -0.15, 0.05)  # of the shades of the four sides
LENGTH = 2.5  # pixels, after which they fall to 1/e


def shade_of(side, distance):
    return DEPTHS[side] * np.exp(-np.clip(distance, 0, None) / LENGTH)


def draw_shaded(count=12, **options):
    """Tiles of different colours that change towards each side."""
    cells = []
    for n in range(count):
        cell = draw_cell(height=60, width=100, colour=0.3 + 0.02 * n, seed=n, **options)
        x = shade_of(0, cell.left) + shade_of(1, cell.right)
        y = shade_of(2, cell.top) + shade_of(3, cell.bottom)
        change = (x[None, :] + y[:, None]) * (draw_mask(cell) > 0)
        cells.append(cell._replace(values=(cell.values + change[..., None]).astype(np.float32)))
    return cells


def test_shades_towards_the_sides_are_recovered():
    profile = tile_profile(draw_shaded(grain=0.02))
    reach = profile.shape[1]
    assert profile.shape == (4, reach, 3)
    assert 8 <= reach <= 32
    at = np.arange(reach) + 0.5
    for side in range(4):
        np.testing.assert_allclose(profile[side, :6], np.repeat(shade_of(side, at)[:6, None], 3, axis=1), atol=0.012)
        assert np.abs(profile[side, -1]).max() < 1e-6
        assert np.abs(profile[side, reach - 3 :]).max() < 0.012


def test_grain_has_no_shade_left_and_is_not_touched_otherwise():
    cells = draw_shaded(grain=0.02)
    profile = tile_profile(cells)
    grains = [tile_grain(cell, profile) for cell in cells]
    mean = np.mean(grains, axis=0)[..., 0]
    assert np.abs(mean.mean(axis=0)).max() < 0.01
    assert np.abs(mean.mean(axis=1)).max() < 0.01
    assert np.std(grains) == pytest.approx(0.02, rel=0.03)
    # Pixel by pixel it is the noise that was drawn.
    noise = 0.02 * np.random.default_rng(3).normal(size=(68, 108))[4:-4, 4:-4]
    rows, columns = grains[3].shape[:2]
    first = (60 - rows) // 2, (100 - columns) // 2
    drawn = noise[first[0] : first[0] + rows, first[1] : first[1] + columns]
    assert np.corrcoef(drawn.ravel(), grains[3][..., 0].ravel())[0, 1] > 0.98


def test_grain_keeps_away_from_edges():
    cell = draw_cell(height=60, width=100)
    cell.values[(np.minimum(cell.top, cell.bottom) < 1)] = 9.0
    cell.values[:, (np.minimum(cell.left, cell.right) < 1)] = 9.0
    grain = tile_grain(cell, np.zeros((4, 4, 3), np.float32))
    assert np.abs(grain).max() == 0
    small = tile_grain(draw_cell(height=4, width=5, grain=0.1), np.zeros((4, 4, 3), np.float32))
    assert min(small.shape) >= 1


def test_a_faces_colour_is_its_own_whatever_stands_around_and_on_it():
    cell = draw_cell(colour=0.37)
    cell.values[10:14, 10:30] = 1.0
    np.testing.assert_allclose(face_colour(cell), [0.37] * 3, atol=1e-6)


def test_even_tiles_have_no_profile():
    assert np.abs(tile_profile([draw_cell(height=60, width=100, colour=0.1 * n) for n in range(1, 6)])).max() < 1e-6


def test_profiles_are_looked_up_between_pixels_and_end_in_nothing():
    profile = np.stack([[4.0, 2.0, 1.0], [1.0, 0.0, 0.0]], axis=-1)
    found = at_distance(profile, np.array([-3.0, 0.5, 1.0, 1.5, 2.5, 2.6, 40.0]))
    np.testing.assert_allclose(found[:, 0], [4, 4, 3, 2, 1, 0, 0])
    np.testing.assert_allclose(found[:, 1], [1, 1, 0.5, 0, 0, 0, 0])
    assert at_distance(profile, np.zeros((3, 5))).shape == (3, 5, 2)


def test_regions_are_stacked_by_their_middles():
    def ramp(rows, columns):
        y, x = np.indices((rows, columns)) - [[[0.5 * (rows - 1)]], [[0.5 * (columns - 1)]]]
        return np.stack([y, x], axis=-1)

    sizes = [(4, 9), (20, 40), (22, 40), (20, 42), (24, 44), (20, 40)]
    stack = stack_regions([ramp(*size) for size in sizes])
    assert stack.shape == (5, 20, 40, 2)  # the smallest was left out
    np.testing.assert_allclose(stack, np.broadcast_to(ramp(20, 40), stack.shape), atol=1.01)
    assert stack_regions([ramp(*size) for size in sizes], all_of_them=True).shape == (6, 4, 9, 2)
    assert stack_regions([ramp(8, 5)]).shape == (1, 8, 5, 2)


def test_very_many_regions_are_thinned_evenly():
    stack = stack_regions([np.full((128, 128, 1), n, np.float32) for n in range(100)])
    assert stack[0].size * len(stack) <= 1 << 18
    numbers = stack[:, 0, 0, 0]
    assert (numbers[0], len(set(np.diff(numbers)))) == (0, 1)
    assert numbers[-1] > 80


def draw_joints(joint=8):
    """Cells whose joints darken towards the tile, and have grain."""
    cells, masks = [], []
    for n in range(6):
        cell = draw_cell(height=40, width=100, joint=joint, seed=n)
        depth = np.minimum(np.minimum(cell.left, cell.right)[None, :], np.minimum(cell.top, cell.bottom)[:, None])
        noise = 0.03 * np.random.default_rng(n).normal(size=(*depth.shape, 1))
        dark = -0.3 * np.exp(depth / 2.0)[..., None]
        cells.append(
            cell._replace(
                values=np.where(depth[..., None] < 0, 0.6 + dark + noise, 0.2).astype(np.float32).repeat(3, 2)
            )
        )
        masks.append(draw_mask(cell))
    return cells, masks


def test_joints_darken_towards_tiles_as_drawn():
    cells, masks = draw_joints()
    profile = joint_profile(cells, masks, np.full(3, 0.6, np.float32), 4.0)
    assert profile.shape == (len(SIDES), 4, 3)
    expected = -0.3 * np.exp(-(np.arange(4) + 0.5) / 2.0)
    np.testing.assert_allclose(profile, np.broadcast_to(expected[:, None], profile.shape), atol=0.012)
    assert (joint_profile(cells, [np.ones_like(mask) for mask in masks], np.zeros(3), 4.0) == 0).all()


@pytest.mark.parametrize("thickness", [(4.0, 8.0), (8.0, 4.0)])
def test_pieces_of_joints_lie_along_the_rows_around_nothing(thickness):
    cells, masks = draw_joints()
    strips = joint_strips(cells, masks, thickness)
    # Where joints between courses are too thin, those between tiles are taken.
    assert strips.shape[1] in (5, 6)
    assert strips.shape[2] >= 3 * strips.shape[1]
    assert len(strips) >= 6
    assert np.abs(np.median(strips, axis=(0, 2))).max() < 0.01  # not how they darken
    assert strips.std() == pytest.approx(0.03, rel=0.3)


def test_thin_joints_have_no_examples():
    cells, masks = draw_joints(joint=4)
    assert joint_strips(cells, masks, (4.0, 4.0)).shape == (0, 1, 1, 3)
    assert joint_strips(cells, masks, (0.0, 0.0)).shape[0] == 0


def test_the_cleanest_pieces_of_joints_are_taken():
    cells, masks = draw_joints()
    for cell, mask in zip(cells[:2], masks, strict=False):
        mask[-8:] = 1  # the mask says that tiles reach into these
        cell.values[-8:] = 5.0
    strips = joint_strips(cells, masks, (8.0, 8.0))
    assert np.abs(strips).max() < 0.5
