"""Floors drawn by plain arithmetic -> planks with the wood of each."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxtex.fitting.floor import _placed, fit_floor
from jaxtex.models.wood import make_wood
from jaxtex.models.wood_detail import Displacement

EDGES = (-120, -40, 40, 120)


def draw_floor(spacings=(8.0, 12.0, 10.0)):
    """Linear planks with upright grain, and dark joints."""
    random = np.random.default_rng(1)
    v, u = np.indices((256, 240)) + 0.5 - np.array([128, 120])[:, None, None]
    number = np.clip(np.searchsorted(EDGES, u) - 1, 0, 2)
    spacing = np.array(spacings)[number]
    wavy = u + 1.5 * np.sin(v / 30 + 2 * number)
    early = np.sin(2 * np.pi * wavy / spacing) > 0
    light = np.where(early, 0.4, 0.25) * np.array([0.8, 1.0, 1.2])[number] * (1 + random.normal(0, 0.06, u.shape))
    for edge in EDGES[1:-1]:
        light[np.abs(u - edge) < 1.5] = 0.02
    return light[..., None] * np.array([1.0, 0.7, 0.45])


@pytest.fixture(scope="module")
def floor():
    return fit_floor(draw_floor())


def test_every_plank_has_its_own_wood(floor):
    assert floor.ok, floor.reason
    assert len(floor.planks) == 3
    for plank, spacing in zip(floor.planks, (8.0, 12.0, 10.0), strict=True):
        assert plank.own
        assert float(plank.wood.ring_spacing) == pytest.approx(spacing, rel=0.12)
        across = np.degrees(float(plank.wood.rotation))
        assert abs((across + 90) % 180 - 90) < 5
    light = [float(plank.wood.early_rgb[0]) for plank in floor.planks]
    assert light[0] < light[1] < light[2]


def test_joints_lie_where_they_were_drawn(floor):
    np.testing.assert_allclose(np.sort(floor.joints), EDGES[1:-1], atol=2)


def test_another_photographs_wood_lies_along_every_plank():
    board = make_wood(ring_spacing=13.0, rotation=1.2, early_rgb=(0.9, 0.1, 0.1))
    planks = fit_floor(draw_floor(), wood=board, seed=3).planks
    again = fit_floor(draw_floor(), wood=board, seed=3).planks
    for plank, same in zip(planks, again, strict=True):
        assert not plank.own
        assert float(plank.wood.ring_spacing) == pytest.approx(13.0)
        assert abs((np.degrees(float(plank.wood.rotation)) + 90) % 180 - 90) < 1
        np.testing.assert_array_equal(np.asarray(plank.wood.center), np.asarray(same.wood.center))
    assert len({float(plank.wood.center[0]) for plank in planks}) == len(planks)


@pytest.mark.parametrize("picture", [np.full((96, 96), 0.3), np.random.default_rng(0).uniform(0, 1, (96, 96))])
def test_what_shows_no_joints_is_no_floor(picture):
    fit = fit_floor(picture)
    assert not fit.ok
    assert fit.reason


def test_tiles_are_no_floor_of_wood():
    v, u = np.indices((256, 256))
    tiles = np.where((u % 64 < 3) | (v % 64 < 3), 0.1, 0.6) + np.random.default_rng(0).normal(0, 0.02, u.shape)
    assert not fit_floor(np.clip(tiles, 0, 1)).ok


@pytest.mark.parametrize("turn", [0.0, 0.4, np.pi / 2])
def test_a_plank_has_its_pieces_rings_where_it_lies(turn):
    """Wood read off an upright piece, displacement and all, seen at the same places in the photograph."""
    with jax.enable_x64():
        cosines = jnp.asarray(np.random.default_rng(0).normal(size=(4, 3)))
        field = Displacement(cosines, jnp.array([60.0, 200.0]), jnp.zeros(2), jnp.zeros(()))
        wood = make_wood(ring_spacing=13.0, rotation=0.3, tilt=0.2, center=(40.0, 9.0), displacement=field)
        off = np.array([7.0, -30.0])
        placed = _placed(wood, turn, off)
        c, s = np.cos(turn), np.sin(turn)
        for point in np.random.default_rng(1).uniform(-25, 25, (8, 2)):
            there = np.array([[c, -s], [s, c]]) @ (point + off)
            one, other = (
                each.ring_count(each.to_trunk(jnp.asarray(at))) for each, at in ((wood, point), (placed, there))
            )
            assert one == pytest.approx(float(other), abs=1e-9)
