"""Least squares of the rendered soft mask against the observed one, by optimistix.

The residual is a module-level function with its data in ``args``, and every choice that varies from fit to fit (which
parameters move, blur, robustness, number of pixels used) is data too: one compilation per size of problem serves all.
"""

from collections.abc import Callable
from contextvars import ContextVar
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import optimistix as optx
from jax import Array
from jax.scipy.linalg import solve_triangular

from jaxtex.fitting.parameters import place
from jaxtex.fitting.rows import coverage_rows

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


class Solution(eqx.Module):
    """``free`` (P,) found; ``cost``: sum of squared residuals, not robust, so that solutions which take more for dirt
    do not look better; ``variance`` (P,) of ``free`` from the curvature at the solution; ``count``: pixels used;
    ``steps`` taken."""

    free: Array
    cost: Array
    variance: Array
    count: Array
    steps: Array


class Sums(NamedTuple):
    """All that Gauss-Newton needs of N residuals r with Jacobian J by a step (P,) in pixels: ``curvature`` J^T J
    (P, P), ``gradient`` J^T r (P,), ``robust`` r^T r; and ``cost``, the same sum before it was made robust."""

    curvature: Array
    gradient: Array
    robust: Array
    cost: Array


def sum_residuals(step: Array, problem: Problem) -> Sums:
    """Sums over all pixels, and over the weak pull to the start, after a ``step`` (P,)."""
    seen, to_free = problem.observation, problem.scale * problem.moving
    free = problem.free + step * to_free
    tile, rows = coverage_rows(free, problem.course_lengths, problem.centre, seen.points, seen.blur)
    contrast = free[place("contrast")]
    difference = (free[place("level")] + contrast * (1.0 - tile) - seen.joint) * seen.weight
    rows = (-contrast * rows).at[place("level")].set(1.0).at[place("contrast")].set(1.0 - tile)
    shrunk = jax.lax.rsqrt(1.0 + (difference / seen.tolerance) ** 2)
    robust, rows = difference * shrunk, rows * (seen.weight * shrunk**3)[None]
    return Sums(
        curvature=(rows @ rows.T) * jnp.outer(to_free, to_free) + _PULL**2 * jnp.eye(len(step), dtype=step.dtype),
        gradient=(rows @ robust) * to_free + _PULL**2 * step,
        robust=jnp.sum(robust**2) + jnp.sum((_PULL * step) ** 2),
        cost=jnp.sum(difference**2),
    )


def mask_residuals(step: Array, problem: Problem) -> tuple[Array, Sums]:
    """The residuals of the mask, turned into P + 1 numbers that a least-squares solver cannot tell from all N.

    With J = Q R, turning the residuals r by Q gives the P numbers Q^T r = R^-T J^T r, whose derivative is R, and a rest
    that no small step changes. A turn leaves the sum of squares, the gradient and J^T J as they are, so the solver
    takes the same steps, and handles some dozen numbers instead of a million. Q belongs to the step asked for and is
    held while differentiating.
    """
    here = jax.lax.stop_gradient(step)
    sums = sum_residuals(here, problem)
    root = jnp.linalg.cholesky(sums.curvature)
    turned = solve_triangular(root, sums.gradient, lower=True)
    rest = jnp.sqrt(jnp.maximum(sums.robust - turned @ turned, 0.0))
    return jnp.append(turned + root.T @ (step - here), rest), sums


# In pixels of joints. Rounding in the single-precision error functions shows at steps twenty times smaller.
_SOLVER: optx.LevenbergMarquardt[Array, Array, Sums] = optx.LevenbergMarquardt(rtol=1e-4, atol=5e-4)


def solve(problem: Problem) -> Solution:
    """Levenberg-Marquardt from the problem's start. Never raises: a poor end is seen in the cost."""
    fn: Any = mask_residuals
    start = jnp.zeros_like(problem.free)
    answer: optx.Solution[Array, Sums] = optx.least_squares(
        fn, _SOLVER, start, problem, has_aux=True, max_steps=30, throw=False
    )
    step, sums = answer.value, answer.state.aux
    to_free = problem.scale * problem.moving
    count = jnp.sum(problem.observation.weight > 0)
    # Blur ties neighbouring pixels: only so many are independent.
    together = jnp.maximum(4 * jnp.pi * problem.observation.blur**2, 1.0)
    curvature = sums.curvature + jnp.diag(1.0 - problem.moving)
    variance = jnp.diag(jnp.linalg.inv(curvature)) * sums.cost / count * together
    return Solution(
        free=problem.free + step * to_free,
        cost=sums.cost,
        variance=variance * to_free**2,
        count=count,
        steps=answer.stats["num_steps"],
    )


_solve_alone = eqx.filter_jit(solve)
SOLVER: ContextVar[Callable[[Problem], Solution]] = ContextVar("SOLVER", default=_solve_alone)
"""How :func:`solve_one` solves: compiled and alone, unless a batch of fits sets another way."""


def solve_one(problem: Problem) -> Solution:
    """:func:`solve`, compiled."""
    return SOLVER.get()(problem)
