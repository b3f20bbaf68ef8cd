"""Least squares of the rendered soft mask against the observed one, by optimistix.

The residual is a module-level function with its data in ``args``, and every choice that varies from fit to fit (which
parameters move, blur, robustness, number of pixels used) is data too: one compilation per size of problem serves all.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import optimistix as optx
from jax import Array

from jaxtex.fitting.parameters import build_tiling, place
from jaxtex.fitting.tall import TallCholesky

_PULL = 1e-3  # residual per pixel of departure from the start: keeps unseen directions where they are


class Observation(NamedTuple):
    """What a fit is to explain: ``points`` (N, 2) of the picture; ``joint`` (N,), how much each is joint, blurred by a
    Gaussian of ``blur`` pixels; ``weight`` (N,), 0 where nothing is known; ``tolerance``: residuals beyond it count
    less and less (Geman-McClure), so that dirt and missing joints do not pull."""

    points: Array
    joint: Array
    weight: Array
    blur: Array
    tolerance: Array


class Problem(NamedTuple):
    """One least-squares problem. ``free`` (P,): the start; ``scale`` (P,): see ``free_scales``; ``moving`` (P,): 1 for
    parameters to be found, 0 for those held; ``centre`` (2,); ``course_lengths`` (D, L)."""

    free: Array
    scale: Array
    moving: Array
    centre: Array
    course_lengths: Array
    observation: Observation


class Solution(NamedTuple):
    """``free`` (P,) found; ``cost``: sum of squared residuals, not robust, so that solutions which take more for dirt
    do not look better; ``variance`` (P,) of ``free`` from the curvature at the solution; ``count``: pixels used;
    ``steps`` taken."""

    free: Array
    cost: Array
    variance: Array
    count: Array
    steps: Array


def mask_residuals(step: Array, problem: Problem) -> Array:
    """Robust residuals (N + P,) of the mask, and of the weak pull to the start, for a step (P,) in pixels."""
    difference = _differences(step, problem)
    robust = difference * jax.lax.rsqrt(1.0 + (difference / problem.observation.tolerance) ** 2)
    return jnp.concatenate([robust, _PULL * step])


def _differences(step: Array, problem: Problem) -> Array:
    free = problem.free + step * problem.scale * problem.moving
    seen = problem.observation
    tiling = build_tiling(free, problem.course_lengths, problem.centre)
    tile = jax.vmap(lambda point: tiling.square_coverage(point, blur=seen.blur))(seen.points)
    expected = free[place("level")] + free[place("contrast")] * (1.0 - tile)
    return (expected - seen.joint) * seen.weight


_SOLVER = optx.LevenbergMarquardt(rtol=1e-5, atol=1e-5, linear_solver=TallCholesky())


def solve(problem: Problem) -> Solution:
    """Levenberg-Marquardt from the problem's start. Never raises: a poor end is seen in the cost."""
    answer = optx.least_squares(
        mask_residuals, _SOLVER, jnp.zeros_like(problem.free), problem, max_steps=30, throw=False
    )
    step = jnp.where(jnp.all(jnp.isfinite(answer.value)), answer.value, 0.0)
    jacobian = jax.jacfwd(mask_residuals)(step, problem)
    cost = jnp.sum(_differences(step, problem) ** 2)
    count = jnp.sum(problem.observation.weight > 0)
    # Blur ties neighbouring pixels: only so many are independent.
    together = jnp.maximum(4 * jnp.pi * problem.observation.blur**2, 1.0)
    curvature = jacobian.T @ jacobian + jnp.diag(1.0 - problem.moving)
    variance = jnp.diag(jnp.linalg.inv(curvature)) * cost / count * together
    return Solution(
        free=problem.free + step * problem.scale * problem.moving,
        cost=cost,
        variance=variance * (problem.scale * problem.moving) ** 2,
        count=count,
        steps=answer.stats["num_steps"],
    )


solve_one = eqx.filter_jit(solve)
