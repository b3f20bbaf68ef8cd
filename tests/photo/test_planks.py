"""Planks drawn by plain arithmetic -> their joints and corners are found, whichever way they run."""

import numpy as np
import pytest

from jaxtex.photo.planks import find_planks, turn_picture

EDGES = (-150, -110, -30, 20, 95, 150)


def draw_floor(turn=0.0, size=(300, 300), edges=EDGES, ends=(), seed=0):
    """Lightness of planks across (cos, sin); the ``ends`` are (plank, place along it)."""
    random = np.random.default_rng(seed)
    height, width = size
    v, u = np.indices(size) + 0.5
    u, v = u - width / 2, v - height / 2
    across, along = u * np.cos(turn) + v * np.sin(turn), v * np.cos(turn) - u * np.sin(turn)
    number = np.searchsorted(edges, across)
    wavy = across + 2.5 * np.sin(along / 37 + number)
    light = 60 + 6 * np.sin(2 * np.pi * wavy / 9 + 5 * number) + random.normal(0, 1, size)
    for edge in edges:
        light[np.abs(across - edge) < 1.2] = 25
    for plank, place in ends:
        light[(number == plank) & (np.abs(along - place) < 1.2)] = 25
    return light - light.mean()


@pytest.mark.parametrize("turn", [0.0, 0.3, np.pi / 2, 2.2])
def test_uneven_planks_are_found_in_any_direction(turn):
    found = find_planks(draw_floor(turn))
    assert abs((found.turn - turn + np.pi / 2) % np.pi - np.pi / 2) < np.radians(0.3)
    sense = 1 if np.cos(found.turn - turn) > 0 else -1
    for edge in EDGES[1:-1]:
        assert np.abs(sense * found.joints - edge).min() < 2


def test_corners_go_around_each_plank_and_planks_fill_the_picture():
    found = find_planks(draw_floor())
    sides = np.roll(found.corners, -1, axis=1) - found.corners
    x, y = found.corners[..., 0], found.corners[..., 1]
    areas = 0.5 * np.abs((x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1))
    assert len(found.corners) == len(EDGES) - 1
    assert areas.sum() == pytest.approx(300 * 300, rel=0.02)
    # Right angles all around.
    assert np.abs((sides * np.roll(sides, -1, axis=1)).sum(-1)).max() < 1e-6 * areas.max()


def test_ends_of_planks_are_found_in_their_row_alone():
    found = find_planks(draw_floor(ends=[(2, 40.0), (4, -60.0)]))
    assert len(found.corners) == len(EDGES) - 1 + 2
    along = found.corners[..., 1] - 150
    assert any(np.abs(row - 40).min() < 2 and row.max() > 140 for row in along)


def test_one_board_and_noise_have_no_joints():
    board = draw_floor(edges=(-200, 200))
    noise = np.random.default_rng(0).normal(size=(200, 200))
    for light in (board, noise):
        assert len(find_planks(light).joints) == 0


def test_a_turned_picture_keeps_what_it_shows():
    picture = np.random.default_rng(0).uniform(size=(40, 60))
    np.testing.assert_allclose(turn_picture(picture, 0.0), picture)
    upright = turn_picture(picture, np.pi / 2)
    np.testing.assert_allclose(upright, np.rot90(picture), atol=1e-9)
    assert np.isnan(turn_picture(picture, 0.5)).any()
