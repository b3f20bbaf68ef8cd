"""Blocks of voxels sampled at any point: trilinear, periodic, and repeated without a visible period."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.test_util import check_grads
from scipy import ndimage

from jaxtex.core.hashing import hash_cell
from jaxtex.models.solid import Solid, make_solid

SHAPE = (5, 6, 7, 3)  # z, y, x, channel
VOXELS = np.random.default_rng(0).random(SHAPE).astype(np.float32)
POINTS = np.random.default_rng(1).uniform(-30, 30, (200, 3)).astype(np.float32)


@jax.jit
def evaluate_colours(solid: Solid, points: jax.Array) -> jax.Array:
    return jax.vmap(solid.colour)(points)


def colours(solid: Solid, points: np.ndarray) -> np.ndarray:
    return np.asarray(evaluate_colours(solid, jnp.asarray(points)))


def centres(shape: tuple[int, ...]) -> np.ndarray:
    """Of all voxels [z, y, x, 3]."""
    z, y, x = np.indices(shape[:3]) + 0.5
    return np.stack([x, y, z], axis=-1).astype(np.float32)


def smooth_noise(side: int, width: float) -> np.ndarray:
    """A periodic block of one colour that differs from voxel to voxel over such a width; skewed, not Gaussian."""
    noise = ndimage.gaussian_filter(np.random.default_rng(2).normal(size=(side,) * 3), width, mode="wrap")
    return np.exp(noise / noise.std())[..., None].astype(np.float32) * np.array([1.0, 0.5], np.float32)


def test_centres_of_voxels_have_their_colours_in_every_period():
    points = centres(SHAPE).reshape(-1, 3)
    for periods in ((0, 0, 0), (1, -2, 3)):
        moved = points + np.array(periods) * [7, 6, 5]
        np.testing.assert_array_equal(colours(make_solid(VOXELS), moved).reshape(SHAPE), VOXELS)


def test_between_centres_it_is_as_scipy_has_it():
    at = POINTS[:, ::-1].T - 0.5
    expected = [ndimage.map_coordinates(VOXELS[..., n], at, order=1, mode="grid-wrap") for n in range(3)]
    np.testing.assert_allclose(colours(make_solid(VOXELS), POINTS), np.stack(expected, axis=-1), atol=2e-5)


def test_sides_may_be_one_voxel_long():
    stripes = make_solid(VOXELS[:1, :, :1])
    moved = colours(stripes, POINTS + np.array([0.3, 0, 40.7], np.float32))
    np.testing.assert_allclose(colours(stripes, POINTS), moved, atol=1e-5)


@pytest.mark.parametrize("seed", [None, 4])
def test_gradients_in_point_and_voxels_are_the_numeric_ones(seed):
    with jax.enable_x64(True):
        voxels = jnp.asarray(VOXELS, jnp.float64)
        point = jnp.array([2.3, -4.9, 11.2])
        solid = make_solid(voxels, offsets_seed=seed)
        colour = jax.jit(lambda point, voxels: dataclasses.replace(solid, voxels=voxels).colour(point))
        check_grads(colour, (point, voxels), order=1)
        assert colour(point, voxels).dtype == jnp.float64


@pytest.mark.parametrize("kind", [jnp.float16, jnp.bfloat16])
def test_voxels_of_half_precision_are_read_in_the_points_precision(kind):
    for seed in (None, 4):
        half = colours(make_solid(jnp.asarray(VOXELS, kind), offsets_seed=seed), POINTS)
        assert half.dtype == np.float32
        np.testing.assert_allclose(half, colours(make_solid(VOXELS, offsets_seed=seed), POINTS), atol=0.02)


def test_a_solid_is_a_pytree_and_compiled_code_knows_nothing_of_its_values():
    evaluate = jax.jit(lambda solid, points: jax.vmap(solid.colour)(points))
    for seed in (1, 2**32 - 1):
        solid = make_solid(VOXELS * seed / 2**32, offsets_seed=seed)
        leaves, structure = jax.tree.flatten(solid)
        again = jax.tree.unflatten(structure, leaves)
        eager = jax.vmap(solid.colour)(POINTS)
        np.testing.assert_allclose(evaluate(again, POINTS), eager, rtol=1e-5, atol=1e-6)
    assert evaluate._cache_size() == 1


@pytest.mark.parametrize(
    ("voxels", "told"),
    [
        (np.zeros((4, 4, 4)), "are no block"),
        (np.zeros((4, 0, 4, 3)), "are no block"),
        (np.zeros((4, 4, 4, 3), int), "give linear light"),
    ],
)
def test_what_is_no_block_is_refused(voxels, told):
    with pytest.raises(ValueError, match=told):
        make_solid(voxels)


@pytest.mark.parametrize("seed", [-1, 2**32])
def test_what_is_no_seed_is_refused(seed):
    with pytest.raises(ValueError, match=r"offsets_seed: .* out of range"):
        make_solid(VOXELS, offsets_seed=seed)


def test_corners_of_the_lattice_read_the_block_at_offsets_of_whole_voxels():
    solid = make_solid(VOXELS[:, :5, :5], offsets_seed=3)
    block = {tuple(colour) for colour in VOXELS[:, :5, :5].reshape(-1, 3)}
    # At a corner its reading alone counts; those of odd numbers of edges, 2.5 voxels long, lie on centres of voxels.
    corners = 2.5 * (2 * np.stack(np.indices((3, 3, 3)), axis=-1).reshape(-1, 3) + 1)
    read = colours(solid, corners)
    assert all(min(np.abs(colour - each).max() for each in block) < 1e-5 for colour in read)
    assert len(np.unique(read, axis=0)) > 20


def read_plainly(voxels: np.ndarray, point: np.ndarray, offset: np.ndarray) -> np.ndarray:
    first = np.floor(point - 0.5).astype(int)
    part = point - 0.5 - first
    total = np.zeros(voxels.shape[-1])
    for corner in np.ndindex(2, 2, 2):
        weight = np.where(np.array(corner) == 1, part, 1 - part).prod()
        x, y, z = (first + corner + offset) % voxels.shape[2::-1]
        total += weight * voxels[z, y, x]
    return total


def vary_plainly(voxels: np.ndarray, point: np.ndarray, seed: int) -> np.ndarray:
    """By a loop over all points of the lattice near by: those of three even or three odd half edges."""
    edge = min(voxels.shape[:3]) / 2
    at, mean = point / edge, voxels.mean((0, 1, 2), dtype=float)
    total, squares = np.zeros_like(mean), 0.0
    for near in np.ndindex(6, 6, 6):
        corner = 2 * np.floor(at).astype(int) + near - 2
        if len(set(corner % 2)) > 1:
            continue
        weight = max(0.5 - ((at - corner / 2) ** 2).sum(), 0) ** 4
        if weight > 0:
            drawn = [int(hash_cell(jnp.array(corner), salt=(3 * seed + axis) % 2**32)) for axis in range(3)]
            total += weight * (read_plainly(voxels, point, np.array(drawn) % voxels.shape[2::-1]) - mean)
            squares += weight**2
    return mean + total / np.sqrt(squares)


def test_random_offsets_are_blended_as_a_plain_loop_does():
    # Places where many decisions are ties: on the lattice's faces and on centres of voxels.
    points = np.concatenate([POINTS[:30], np.random.default_rng(4).integers(-9, 9, (30, 3)) / 2])
    varied = colours(make_solid(VOXELS, offsets_seed=5), points.astype(np.float32))
    expected = [vary_plainly(VOXELS, point, 5) for point in points.astype(float)]
    np.testing.assert_allclose(varied, expected, atol=1e-4)


@pytest.mark.parametrize("seed", [None, 5])
def test_colours_do_not_depend_on_where_points_are_computed(seed):
    """Points computed in the same compiled code are rounded in several ways, and some lie on borders of voxels."""
    solid = make_solid(VOXELS, offsets_seed=seed)
    origin, across, down = (jnp.array(v) for v in ([1.0, -2.0, 3.0], [0.6, 0.2, -0.3], [0.1, 0.5, 0.9]))

    def place(step: jax.Array) -> jax.Array:
        return origin + step[0] * across + step[1] * down

    steps = jnp.stack(jnp.meshgrid(jnp.arange(150.0), jnp.arange(150.0)), axis=-1).reshape(-1, 2) + 0.5
    fused = jax.jit(jax.vmap(lambda step: solid.colour(place(step))))(steps)
    in_rows = jax.jit(lambda steps: jax.lax.map(lambda step: solid.colour(place(step)), steps, batch_size=1500))(steps)
    apart = colours(solid, np.asarray(jax.vmap(place)(steps)))
    np.testing.assert_allclose(fused, apart, atol=2e-4)
    np.testing.assert_allclose(in_rows, apart, atol=2e-4)


def test_random_offsets_keep_mean_and_deviation_and_show_no_period():
    voxels = smooth_noise(16, 1.0)
    line = np.arange(64, dtype=np.float32) + 0.5
    points = np.stack(np.meshgrid(line, line, line), axis=-1).reshape(-1, 3)
    plain, varied = (
        colours(make_solid(voxels, offsets_seed=seed), points).reshape(64, 64, 64, 2) for seed in (None, 9)
    )
    np.testing.assert_allclose(varied.mean((0, 1, 2)), plain.mean((0, 1, 2)), rtol=0.03)
    np.testing.assert_allclose(varied.std((0, 1, 2)), plain.std((0, 1, 2)), rtol=0.04)

    def repeats(field: np.ndarray, axis: int) -> float:
        near, far = np.split(field[..., 0].take(range(48), axis), 1)[0], field[..., 0].take(range(16, 64), axis)
        return float(np.corrcoef(near.ravel(), far.ravel())[0, 1])

    for axis in range(3):
        assert repeats(plain, axis) > 0.999
        assert abs(repeats(varied, axis)) < 0.05


def test_seeds_differ_and_come_back():
    one, other, again = (colours(make_solid(VOXELS, offsets_seed=seed), POINTS) for seed in (1, 2, 1))
    np.testing.assert_array_equal(one, again)
    assert np.corrcoef(one.ravel(), other.ravel())[0, 1] < 0.3
