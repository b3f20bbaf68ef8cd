"""Least squares of a fit: rows against the model differentiated as a whole, steps against plain residuals."""

import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
import pytest

from jaxtex.fitting.parameters import SCALARS, build_tiling, free_scales, place, to_free
from jaxtex.fitting.rows import coverage_rows
from jaxtex.fitting.solve import Observation, Problem, mask_residuals, solve_one, sum_residuals

SIZE = 96.0
VALUES = dict.fromkeys(SCALARS, 0.0) | {
    "contrast": 1.0,
    "tile_width": 23.0,
    "tile_height": 11.0,
    "angle": 0.1,
    "mortar_x": 3.0,
    "mortar_y": 2.0,
    "offset": 0.4,
    "origin_x": 2.0,
    "origin_y": -3.0,
}
OBLIQUE = VALUES | {"tilt_x": 8e-4, "tilt_y": -5e-4, "shear": 0.07}
LENGTHS = {"plain": [[1.0, 1.0], [1.0, 1.0]], "flemish": [[1.0, 0.5], [1.0, 0.5]], "english": [[1.0, 1.0], [0.5, 0.5]]}
HELD = ("corner_radius", "tilt_x", "tilt_y", "shear")
ROWS = jax.jit(coverage_rows)


def pixels(step: int = 1) -> np.ndarray:
    rows, columns = np.mgrid[0 : int(SIZE) : step, 0 : int(SIZE) : step] + 0.5
    return np.stack([columns.ravel(), rows.ravel()], 1)


@jax.jit
def render(free, lengths, points, blur=1.2):
    tiling = build_tiling(jnp.asarray(free), jnp.asarray(lengths), jnp.full(2, SIZE / 2))
    return jax.vmap(lambda point: tiling.square_coverage(point, blur=blur))(jnp.asarray(points))


SLOPES = jax.jit(jax.jacfwd(render))


def pose(values=VALUES, start=VALUES, *, lengths="plain", noise=0.0, held=HELD) -> Problem:
    """The problem of finding ``values`` again from ``start``."""
    rng = np.random.default_rng(0)
    points, table = pixels(), np.array(LENGTHS[lengths])
    joint = 1.0 - np.asarray(render(to_free(values, np.zeros(2)), table, points))
    moving = np.ones(len(SCALARS) + 2)
    moving[[place(name) for name in held]] = 0.0
    moving[len(SCALARS) :] = 0.0
    seen = Observation(
        points, joint + noise * rng.standard_normal(len(joint)), np.ones(len(joint)), np.array(1.2), np.array(0.3)
    )
    problem = Problem(
        to_free(start, np.zeros(2)), free_scales(start, 2, SIZE), moving, np.full(2, SIZE / 2), table, seen
    )
    return jax.tree.map(lambda leaf: jnp.asarray(leaf, float), problem)


@jax.jit
def plain_residuals(step, problem):
    """What :func:`mask_residuals` stands for, pixel by pixel."""
    free = problem.free + step * problem.scale * problem.moving
    seen = problem.observation
    tile = render(free, problem.course_lengths, seen.points, seen.blur)
    difference = (free[place("level")] + free[place("contrast")] * (1.0 - tile) - seen.joint) * seen.weight
    robust = difference / jnp.sqrt(1.0 + (difference / seen.tolerance) ** 2)
    return jnp.concatenate([robust, 1e-3 * step])


@pytest.mark.parametrize("lengths", LENGTHS)
@pytest.mark.parametrize("values", [VALUES, OBLIQUE], ids=["straight", "oblique"])
@pytest.mark.parametrize("courses", [1, 2, 16])
def test_rows_are_the_derivatives_of_the_model(values, lengths, courses):
    with jax.enable_x64():
        table, points = jnp.asarray(LENGTHS[lengths]), pixels(3)
        free = jnp.asarray(to_free(values, np.linspace(0.0, 0.3, courses)))
        tile, rows = ROWS(free, table, jnp.full(2, SIZE / 2), jnp.asarray(points), jnp.asarray(1.2))
        np.testing.assert_allclose(tile, render(free, table, points), atol=5e-7)
        jacobian = np.asarray(SLOPES(free, table, points)).T
        size = np.maximum(np.abs(jacobian).max(1, keepdims=True), 1e-9)
        np.testing.assert_allclose(rows / size, jacobian / size, atol=1e-4)


def test_sums_are_those_of_the_plain_residuals():
    with jax.enable_x64():
        problem = pose(start=VALUES | {"tile_width": 23.2, "mortar_x": 2.5}, noise=0.1)
        step = jnp.linspace(-0.2, 0.2, len(problem.free))
        residuals = plain_residuals(step, problem)
        jacobian = jax.jit(jax.jacfwd(plain_residuals))(step, problem)
        sums = jax.jit(sum_residuals)(step, problem)
        np.testing.assert_allclose(sums.curvature, jacobian.T @ jacobian, rtol=1e-5, atol=1e-5)
        np.testing.assert_allclose(sums.gradient, residuals @ jacobian, rtol=1e-5, atol=1e-5)
        np.testing.assert_allclose(sums.robust, residuals @ residuals, rtol=1e-7)


def test_turned_residuals_keep_what_a_solver_sees():
    with jax.enable_x64():
        problem = pose(start=VALUES | {"tile_width": 23.2}, noise=0.1)
        step = jnp.linspace(-0.2, 0.2, len(problem.free))
        turned, sums = jax.jit(mask_residuals)(step, problem)
        slopes, _ = jax.jit(jax.jacfwd(mask_residuals, has_aux=True))(step, problem)
        assert turned.shape == (len(step) + 1,)
        np.testing.assert_allclose(turned @ turned, sums.robust, rtol=1e-9)
        np.testing.assert_allclose(turned @ slopes, sums.gradient, rtol=1e-7, atol=1e-9)
        np.testing.assert_allclose(slopes.T @ slopes, sums.curvature, rtol=1e-7, atol=1e-9)


def test_ends_where_plain_least_squares_ends():
    with jax.enable_x64():
        problem = pose(start=VALUES | {"tile_width": 23.1, "mortar_y": 2.6, "origin_x": 2.7}, noise=0.2)
        found = solve_one(problem)
        plain = optx.least_squares(
            plain_residuals, optx.LevenbergMarquardt(rtol=1e-9, atol=1e-9), jnp.zeros_like(problem.free), problem,
            max_steps=100, throw=False,
        )  # fmt: skip
        steps = (np.asarray(found.free) - problem.free) / problem.scale
        np.testing.assert_allclose(steps, plain.value * problem.moving, atol=2e-3)


@pytest.mark.parametrize("lengths", LENGTHS)
def test_finds_the_truth_again(lengths):
    truth = OBLIQUE | {"tile_width": 23.3, "origin_x": 2.4, "angle": 0.103}
    with jax.enable_x64():
        found = solve_one(pose(truth, OBLIQUE, lengths=lengths, held=("corner_radius",)))
        assert float(found.cost) < 1e-4
        at = [place(name) for name in SCALARS if name != "corner_radius"]
        np.testing.assert_allclose(found.free[jnp.array(at)], to_free(truth, np.zeros(2))[at], atol=2e-3)


def test_held_parameters_do_not_move_and_have_no_variance():
    with jax.enable_x64():
        problem = pose(VALUES | {"angle": 0.11}, VALUES, held=(*HELD, "angle"))
        found = solve_one(problem)
        still = np.asarray(problem.moving) == 0
        np.testing.assert_array_equal(np.asarray(found.free)[still], np.asarray(problem.free)[still])
        assert not np.asarray(found.variance)[still].any()
        assert (np.asarray(found.variance)[~still] > 0).all()


def test_pixels_of_no_weight_do_not_count():
    with jax.enable_x64():
        problem = pose(VALUES | {"tile_width": 23.2}, VALUES)
        seen = problem.observation
        half = seen.points[:, 0] < SIZE / 2
        spoilt = seen._replace(weight=half.astype(float), joint=jnp.where(half, seen.joint, 7.0))
        clean = seen._replace(weight=half.astype(float))
        ends = [solve_one(problem._replace(observation=each)) for each in (spoilt, clean)]
        assert int(ends[0].count) == int(half.sum())
        np.testing.assert_array_equal(ends[0].free, ends[1].free)


def test_numbers_that_are_not_finite_end_at_the_start():
    with jax.enable_x64():
        problem = pose()
        seen = problem.observation
        found = solve_one(problem._replace(observation=seen._replace(joint=seen.joint.at[5].set(jnp.nan))))
        np.testing.assert_array_equal(found.free, problem.free)
        assert not np.isfinite(float(found.cost))
