"""Solid textures as colours: points, carved meshes, plane cuts, and the block with a corner cut away."""

import math

import jax.numpy as jnp
import numpy as np
import pytest
from scipy import ndimage

from jaxtex.core.errors import InputError
from jaxtex.io.meshes import Mesh
from jaxtex.material import bands
from jaxtex.material import solid as module
from jaxtex.material.solid import carve_solid, cut_solid, draw_block, evaluate_solid
from jaxtex.models.solid import Solid, make_solid

RANDOM = np.random.default_rng(0)
VOXELS = RANDOM.random((5, 6, 7, 3)).astype(np.float32)
SOLID = make_solid(VOXELS)
TRIANGLE = np.array([[0, 1, 2]])
AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}


def test_points_in_chunks_are_the_points_one_by_one(monkeypatch):
    points = RANDOM.uniform(-20, 20, (250, 3))
    whole = evaluate_solid(SOLID, points)
    monkeypatch.setattr(bands, "CHUNK", 100)
    np.testing.assert_array_equal(evaluate_solid(SOLID, points), whole)
    for point, colour in zip(points[:5], whole, strict=False):
        np.testing.assert_allclose(SOLID.colour(jnp.asarray(point, jnp.float32)), colour, atol=1e-6)
    assert evaluate_solid(SOLID, points[:0]).shape == (0, 3)


def test_numbers_of_points_and_values_of_voxels_are_not_compiled_again():
    evaluate_solid(SOLID, np.zeros((9, 3)))
    before = module._colours._cache_size()
    evaluate_solid(make_solid(VOXELS**2), np.zeros((20_000, 3)))
    assert module._colours._cache_size() == before


def test_points_of_another_shape_are_refused():
    with pytest.raises(ValueError, match=r"give \[point, 3\]"):
        evaluate_solid(SOLID, np.zeros((4, 2)))


@pytest.mark.parametrize(
    ("across", "down", "slices"), [("x", "y", VOXELS), ("x", "z", VOXELS.swapaxes(0, 1)), ("y", "z", None)]
)
def test_cuts_across_an_axis_are_slices_of_the_block(across, down, slices):
    slices = VOXELS.transpose(2, 0, 1, 3) if slices is None else slices
    normal = np.array(AXES[next(iter({*"xyz"} - {across, down}))])
    rows, columns = slices.shape[1:3]
    for number, each in enumerate(slices):
        cut = cut_solid(
            SOLID, origin=(number + 0.5) * normal, across=AXES[across], down=AXES[down], size=(columns, rows)
        )
        np.testing.assert_allclose(cut, each, atol=1e-6)


def test_an_oblique_cut_is_as_scipy_has_it():
    origin, across, down = np.array([1.0, -2, 3]), np.array([0.6, 0.2, -0.3]), np.array([0.1, 0.5, 0.9])
    cut = cut_solid(SOLID, origin=origin, across=across, down=down, size=(40, 150))
    row, column = np.indices((150, 40))[..., None] + 0.5
    at = np.moveaxis(origin + column * across + row * down - 0.5, -1, 0)[::-1]
    expected = [ndimage.map_coordinates(VOXELS[..., n], at, order=1, mode="grid-wrap") for n in range(3)]
    np.testing.assert_allclose(cut, np.stack(expected, axis=-1), atol=1e-4)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"down": (2, 0, 0)}, "span no plane"),
        ({"across": (0, 0, 0)}, "span no plane"),
        ({"origin": (0, math.nan, 0)}, "origin: .* three finite numbers"),
        ({"across": (1, 0)}, "across: .* three finite numbers"),
        ({"size": (0, 4)}, "holds no pixels"),
    ],
)
def test_what_is_no_cut_is_refused(change, told):
    with pytest.raises(InputError, match=told):
        cut_solid(SOLID, **({"origin": (0, 0, 0), "across": (1, 0, 0), "down": (0, 1, 0), "size": (4, 4)} | change))


def grid_mesh(columns: int, rows: int) -> Mesh:
    """A flat, upright mesh of square cells, of half the size of its numbers."""
    column, row = np.meshgrid(np.arange(columns), np.arange(rows))
    vertices = np.stack([column, -row, np.zeros_like(row)], axis=-1).reshape(-1, 3) / 2
    number = np.arange(rows * columns).reshape(rows, columns)
    faces = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:]], axis=-1).reshape(-1, 3)
    return Mesh(vertices, faces)


def test_a_flat_mesh_shows_the_middle_of_the_block():
    # 29 x 21 vertices span the 7 voxels of the longest side, 0.25 apart.
    carved = carve_solid(SOLID, grid_mesh(29, 21)).reshape(21, 29, 3)
    cut = cut_solid(SOLID, origin=(-0.125, 0.5 - 0.125, 2.5), across=(0.25, 0, 0), down=(0, 0.25, 0), size=(29, 21))
    np.testing.assert_allclose(carved, cut, atol=1e-5)


def test_a_larger_scale_shows_more_periods():
    one, two = (carve_solid(SOLID, grid_mesh(113, 113), scale=scale).reshape(113, 113, 3) for scale in (1, 2))
    np.testing.assert_allclose(one[::2, ::2], two[28:85, 28:85], atol=1e-4)


def test_what_is_finer_than_the_mesh_fades():
    coarse = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), TRIANGLE)
    checks = make_solid((np.indices((8, 8, 8)).sum(axis=0) % 2)[..., None].astype(np.float32))
    carved = carve_solid(checks, coarse)
    np.testing.assert_allclose(carved, 0.5, atol=1e-4)
    assert carved.shape == (3, 3)


@pytest.mark.parametrize(
    ("solid", "mesh", "scale", "told"),
    [
        (SOLID, Mesh(np.ones((3, 3)), TRIANGLE), 1.0, "lie at one point"),
        (SOLID, grid_mesh(3, 3), 0.0, "scale: 0 is none"),
        (SOLID, grid_mesh(3, 3), math.inf, "scale: inf is none"),
        (make_solid(VOXELS[..., :2]), grid_mesh(3, 3), 1.0, "has 2 channels"),
    ],
)
def test_what_cannot_be_carved_is_refused(solid, mesh, scale, told):
    with pytest.raises(InputError, match=told):
        carve_solid(solid, mesh, scale=scale)


def faces_block() -> Solid:
    """Dark, with coloured outer faces: red where x ends, green where y begins, blue where z begins."""
    voxels = np.zeros((16, 16, 16, 3), np.float32)
    voxels[:, :, -1, 0] = voxels[:, 0, :, 1] = voxels[0, :, :, 2] = 1
    return make_solid(voxels)


def test_the_block_is_drawn_with_its_corner_cut():
    picture = draw_block(faces_block(), size=(120, 120))
    assert picture.shape == (120, 120, 3)
    background = np.isclose(picture, module._BACKGROUND).all(-1)
    assert background[[0, 0, -1, -1], [0, -1, 0, -1]].all()
    right, down, away = module._view_axes()
    np.testing.assert_allclose(np.array([right, down, away]) @ np.array([right, down, away]).T, np.eye(3), atol=1e-12)
    assert down[1] > 0  # upright

    voxels = max(np.abs(right).sum(), np.abs(down).sum()) * 16 / (1 - 2 * module._MARGIN) / 120

    def seen(x: float, y: float, z: float) -> np.ndarray:
        """The picture where a point of the block, from 0 to 1, is drawn."""
        from_middle = 16 * (np.array([x, y, z]) - 0.5)
        column, row = (int(60 + axis @ from_middle / voxels) for axis in (right, down))
        return picture[row, column]

    across, upright, front = module._LIGHT
    np.testing.assert_allclose(seen(1, 0.75, 0.6), [across, 0, 0], atol=1e-5)
    np.testing.assert_allclose(seen(0.2, 0, 0.7), [0, upright, 0], atol=1e-5)
    np.testing.assert_allclose(seen(0.2, 0.6, 0), [0, 0, front], atol=1e-5)
    # The faces within the cut are dark: nothing of the outer ones hangs in the air.
    for inside in ((0.53, 0.25, 0.2), (0.75, 0.53, 0.2), (0.75, 0.25, 0.53)):
        np.testing.assert_allclose(seen(*inside), 0, atol=1e-5)


@pytest.mark.parametrize(("shape", "size"), [((4, 16, 8), (90, 61)), ((1, 1, 1), (30, 300)), ((30, 3, 3), (300, 40))])
def test_a_block_of_any_sides_fills_pictures_of_any_size(shape, size):
    picture = draw_block(make_solid(np.zeros((*shape, 1), np.float32)), size=size)
    assert picture.shape == (size[1], size[0], 3)
    shown = np.argwhere((picture < module._BACKGROUND - 1e-3).any(-1))
    lost = 1 - (np.ptp(shown, axis=0) + 1) / picture.shape[:2]
    assert 0.03 < lost.min() < 0.13 + 2 / min(size)
    middle = shown.min(axis=0) + np.ptp(shown, axis=0) / 2
    np.testing.assert_allclose(middle, (np.array(picture.shape[:2]) - 1) / 2, atol=1)


def test_edges_are_smooth():
    grey = draw_block(make_solid(np.zeros((4, 4, 4, 1), np.float32)), size=(80, 80))[..., 0]
    between = (grey > 0.01) & (grey < module._BACKGROUND - 0.01)
    assert 40 < between.sum() < 400


def test_blocks_that_are_no_colours_are_not_drawn():
    with pytest.raises(InputError, match="has 2 channels"):
        draw_block(make_solid(VOXELS[..., :2]))
    with pytest.raises(InputError, match="holds no pixels"):
        draw_block(SOLID, size=(0, 4))
