"""Wood as maps, voxels and carvings: all of one solid, in any pieces and resolution."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.io.meshes import Mesh
from jaxtex.material import bands
from jaxtex.material import wood as module
from jaxtex.material.carving import place_mesh
from jaxtex.material.wood import (
    WoodMaps,
    carve_mesh,
    count_parts,
    render_block,
    render_points,
    render_wood,
)
from jaxtex.models.wood import make_wood

OAK = make_wood(
    ring_spacing=12.0,
    center=(30.0, 9.0),
    tilt=0.5,
    rotation=0.7,
    early_fraction=0.6,
    turbulence_rms=1.0,
    turbulence_frequency=0.02,
)


def render(wood, across: float, size: tuple[int, int]) -> WoodMaps:
    return WoodMaps(*map(np.concatenate, zip(*render_wood(wood, across=across, size=size), strict=True)))


def block(wood, shape: tuple[int, int, int]) -> np.ndarray:
    return np.concatenate(list(render_block(wood, shape=shape))).reshape(*shape, 3)


def test_pixels_of_the_photograph_are_plank_points_from_its_middle():
    maps = render(OAK, 60, (60, 40))
    for row, column in np.random.default_rng(0).integers((0, 0), (40, 60), (20, 2)):
        point = jnp.array([column + 0.5 - 30, row + 0.5 - 20])
        early = OAK.early_on_plank(point, blur=0.5)
        expected = OAK.late_rgb + early * (OAK.early_rgb - OAK.late_rgb)
        np.testing.assert_allclose(maps.base_colour[row, column], expected, atol=2e-4)
        assert maps.roughness[row, column] == pytest.approx(0.5 + 0.15 * float(early), abs=1e-3)


def test_larger_maps_show_the_same_plank_and_longer_ones_more_of_it():
    small, large, tall = (render(OAK, 60, size) for size in ((60, 40), (240, 160), (60, 100)))
    halved = large.base_colour.reshape(40, 4, 60, 4, 3).mean(axis=(1, 3))
    assert np.abs(halved - small.base_colour).mean() < 0.01
    np.testing.assert_allclose(tall.base_colour[30:70], small.base_colour, atol=1e-3)


def test_late_wood_stands_higher():
    maps = render(make_wood(ring_spacing=20.0, early_fraction=0.5), 80, (320, 8))
    early = maps.roughness > 0.649
    late = maps.roughness < 0.501
    assert maps.height[late].min() > 0.2
    assert maps.height[early].max() < 0.2
    assert maps.height.max() == pytest.approx(0.02 * 20, abs=1e-3)
    assert maps.height.min() >= 0


def test_normals_are_those_of_the_height():
    maps = render(OAK, 60, (240, 160))
    down, right = np.gradient(maps.height, 60 / 240)
    expected = np.stack([-right, down, np.ones_like(right)], axis=-1)
    expected /= np.linalg.norm(expected, axis=-1, keepdims=True)
    np.testing.assert_allclose(np.linalg.norm(maps.normal, axis=-1), 1, atol=1e-5)
    np.testing.assert_allclose(maps.normal[1:-1, 1:-1], expected[1:-1, 1:-1], atol=0.02)


def test_maps_in_pieces_are_the_maps_in_one_go(monkeypatch):
    whole = render(OAK, 60, (60, 50))
    monkeypatch.setattr(bands, "_BLOCK", (7, 31))
    for one, other in zip(whole, render(OAK, 60, (60, 50)), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-5)


@pytest.mark.parametrize("size", [(0, 4), (4, 0), (70_000, 2)])
def test_sizes_that_cannot_be_made_are_refused(size):
    with pytest.raises(InputError, match=r"size .* (holds no pixels|is too large)"):
        render_wood(OAK, across=60, size=size)


def test_the_first_slice_of_a_block_is_the_photographed_face():
    # Upright cuts see rings unstretched, so that a spot on the plank is one in the solid.
    wood = make_wood(ring_spacing=12.0, center=(30.0, 0.0), turbulence_rms=1.0, turbulence_frequency=0.02)
    np.testing.assert_allclose(block(wood, (2, 40, 60))[0], render(wood, 60, (60, 40)).base_colour, atol=2e-3)


def test_a_block_is_the_solid_voxel_by_voxel():
    voxels = block(OAK, (5, 6, 7))
    s, c = math.sin(0.7), math.cos(0.7)
    for z, y, x in np.ndindex(5, 6, 7):
        u, v = x + 0.5 - 3.5, y + 0.5 - 3
        across, along = c * u + s * v, c * v - s * u
        trunk = [across, along * math.sin(0.5) + z * math.cos(0.5), along * math.cos(0.5) - z * math.sin(0.5)]
        np.testing.assert_allclose(voxels[z, y, x], OAK.colour(jnp.array(trunk), blur=0.5), atol=2e-4)


def test_blocks_of_other_sizes_are_not_compiled_again_and_meet():
    large = block(OAK, (4, 140, 150))
    before = module._colours._cached._cache_size()
    small = block(OAK, (3, 20, 30))
    block(make_wood(ring_spacing=3.0), (1, 1, 1))
    assert module._colours._cached._cache_size() == before
    np.testing.assert_allclose(large[:3, 60:80, 60:90], small, atol=1e-6)
    parts = list(render_block(OAK, shape=(4, 140, 150)))
    assert len(parts) == count_parts((4, 140, 150)) == 6


@pytest.mark.parametrize("shape", [(0, 4, 4), (2000, 2000, 2000)])
def test_blocks_that_cannot_be_made_are_refused(shape):
    with pytest.raises(InputError, match=r"block .* (holds no voxels|is too large)"):
        render_block(OAK, shape=shape)


def test_a_mesh_lies_in_the_wood_by_its_bounding_box():
    box = np.array(list(np.ndindex(2, 2, 2))) * np.array([4.0, 2.0, 1.0]) + 100.0
    placed = place_mesh(Mesh(box, np.array([[0, 1, 2]])), longest=200)
    np.testing.assert_allclose(placed.min(axis=0), [-100, -50, -25])
    np.testing.assert_allclose(placed.max(axis=0), [100, 50, 25])
    # Up in the mesh is up in the picture; towards the viewer is out of the plank.
    np.testing.assert_allclose(placed[0], [-100, 50, 25])


def test_a_flat_mesh_shows_the_plank():
    wood = make_wood(ring_spacing=12.0, center=(50.0, 0.0))
    column, row = np.meshgrid(np.arange(61), np.arange(41))
    vertices = np.stack([column, -row, np.zeros_like(row)], axis=-1).reshape(-1, 3).astype(float)
    number = np.arange(41 * 61).reshape(41, 61)
    faces = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:]], axis=-1).reshape(-1, 3)
    colours = carve_mesh(wood, Mesh(vertices, faces), image=(60, 40)).reshape(41, 61, 3)
    placed = place_mesh(Mesh(vertices, faces), longest=60)
    spot = 0.5 * (2 + math.sqrt(2)) / 3
    np.testing.assert_allclose(colours.reshape(-1, 3), render_points(wood, placed, spot=spot), atol=1e-5)
    expected = jax.vmap(lambda u: wood.early_on_plank(jnp.stack([u, 0.0 * u]), blur=spot))(jnp.arange(-30.0, 31.0))
    seen = (colours[20] - wood.late_rgb[None]) / (wood.early_rgb - wood.late_rgb)[None]
    np.testing.assert_allclose(seen, np.repeat(expected[:, None], 3, axis=1), atol=5e-3)


def test_rings_finer_than_the_mesh_fade():
    coarse = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    wood = make_wood(ring_spacing=5.0, early_fraction=0.5, early_rgb=(0.6,) * 3, late_rgb=(0.2,) * 3)
    np.testing.assert_allclose(carve_mesh(wood, coarse, image=(200, 200)), 0.4, atol=1e-5)


def test_a_mesh_without_extent_is_refused():
    with pytest.raises(InputError, match="all vertices of the mesh lie at one point"):
        carve_mesh(OAK, Mesh(np.ones((3, 3)), np.array([[0, 1, 2]])), image=(60, 40))
