"""Point functions on pixel centres: which points, in which precision, how often compiled, in how much memory."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxtex.models import grids
from jaxtex.models.grids import coverage_grid, on_grid
from jaxtex.models.tiling import Tiling, make_tiling

WALL = {"tile_width": 13.0, "tile_height": 7.0, "mortar_x": 2.0, "mortar_y": 1.5, "offset": 0.37, "angle": 0.2}


def test_points_are_pixel_centres_x_first():
    points = np.asarray(on_grid(lambda point: point, 3, 5))
    assert points.shape == (3, 5, 2)
    for row, column in np.ndindex(3, 5):
        assert points[row, column].tolist() == [column + 0.5, row + 0.5]


def test_any_tree_of_arrays_is_returned_with_two_leading_axes():
    wall = make_tiling(**WALL)
    place = on_grid(eqx.Partial(lambda wall, point: wall.locate(wall.to_lattice(point)), wall), 4, 6)
    assert {leaf.shape for leaf in place} == {(4, 6)}
    one = wall.locate(wall.to_lattice(jnp.array([2.5, 3.5])))
    np.testing.assert_allclose([leaf[3, 2] for leaf in place], one, rtol=1e-5)


@pytest.mark.parametrize("shape", [(1, 1), (37, 53), (20, 64)])
def test_coverage_grid_is_coverage_point_by_point(shape, monkeypatch):
    monkeypatch.setattr(grids, "_BLOCK", 256)  # several blocks of rows, and rows left over
    wall = make_tiling(**WALL, corner_radius=1.0)
    mask = coverage_grid(wall, *shape, blur=0.6)
    assert mask.shape == shape
    point = jax.jit(lambda point: wall.coverage(point, blur=0.6))
    for row, column in np.random.default_rng(0).integers((0, 0), shape, (40, 2)):
        assert abs(mask[row, column] - point(jnp.array([column + 0.5, row + 0.5]))) < 1e-5


def test_precision_is_that_of_the_leaves():
    exact = jax.tree.map(lambda leaf: np.asarray(leaf, np.float64), make_tiling(**WALL))
    assert coverage_grid(exact, 4, 4).dtype == jnp.float32
    with jax.enable_x64():
        assert coverage_grid(exact, 4, 4).dtype == jnp.float64
        assert coverage_grid(make_tiling(**WALL), 4, 4, blur=np.float32(0.5)).dtype == jnp.float64
        single = jax.tree.map(lambda leaf: leaf.astype(jnp.float32), make_tiling(**WALL))
        assert coverage_grid(single, 4, 4).dtype == jnp.float32
        assert on_grid(lambda point: point, 2, 2).dtype == jnp.float64


def test_new_values_are_not_compiled_again():
    traced = []

    class Counting(eqx.Module):
        scale: jax.Array

        def __call__(self, point):
            traced.append(point)
            return self.scale * point[0]

    for scale in (1.0, 2.0, np.float32(3.0)):
        on_grid(Counting(jnp.asarray(scale, jnp.float32)), 6, 5)
    assert len(traced) == 1
    on_grid(Counting(jnp.float32(1.0)), 5, 6)
    assert len(traced) == 2


def test_coverage_is_compiled_once_for_all_tilings_of_one_shape():
    before = grids._evaluate._cached._cache_size()
    for step in range(3):
        wall = make_tiling(**{**WALL, "tile_width": 13.0 + step, "angle": 0.1 * step})
        coverage_grid(wall, 11, 9, blur=0.5 + 0.1 * step)
        coverage_grid(dataclasses.replace(wall, corner_radius=np.float32(step)), 11, 9, blur=1)
    assert grids._evaluate._cached._cache_size() == before + 1


def test_gradients_pass_through_the_grid():
    wall = make_tiling(**WALL)
    along = jax.tree.map(lambda leaf: jnp.full_like(leaf, 1e-3), wall)
    points = jnp.asarray(np.stack(np.meshgrid(np.arange(30) + 0.5, np.arange(20) + 0.5), -1), jnp.float32)
    draw = jax.vmap(jax.vmap(lambda wall, point: wall.square_coverage(point, blur=0.5), (None, 0)), (None, 0))
    grid = lambda wall: on_grid(eqx.Partial(Tiling.square_coverage, wall, blur=0.5), 20, 30)  # noqa: E731
    _, through_grid = jax.jvp(grid, (wall,), (along,))
    _, plain = jax.jvp(lambda wall: draw(wall, points), (wall,), (along,))
    np.testing.assert_allclose(through_grid, plain, atol=1e-5)


def test_memory_is_bounded_beyond_the_picture_itself():
    function = eqx.Partial(Tiling.coverage, make_tiling(**WALL), blur=jnp.float32(0.5))
    beyond = []
    for height in (1024, 4096):
        needed = grids._evaluate.lower(function, height, 1024).compile().compiled.memory_analysis()
        assert needed.output_size_in_bytes >= 4 * height * 1024
        beyond.append(needed.temp_size_in_bytes)
    assert abs(beyond[1] - beyond[0]) < 1e5


@pytest.mark.parametrize("blur", [0.0, -1.0, np.nan])
def test_a_blur_that_is_none_is_refused(blur):
    with pytest.raises(ValueError, match=r"blur is (0|-1|nan) pixels; it must be > 0"):
        coverage_grid(make_tiling(**WALL), 4, 4, blur=blur)


@pytest.mark.parametrize("shape", [(0, 5), (5, 0), (-1, 3)])
def test_a_picture_without_pixels_is_refused(shape):
    with pytest.raises(ValueError, match="has no points; both must be at least 1"):
        on_grid(lambda point: point, *shape)
