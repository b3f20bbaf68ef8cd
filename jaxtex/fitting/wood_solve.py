"""Least squares of the rendered soft mask of early wood against the observed one, coarse to fine."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jax import Array
from numpy.typing import NDArray
from scipy import ndimage

from jaxtex.fitting.rings import NAMES, Held, Plank, early_wood, lay_plank, loosen

Floats = NDArray[np.float64]

_PIXEL = np.sqrt(1 / 12)  # a pixel's own blur
# Shares of the mask's variance left after a blurred fit, above which no rings explain it unless they are displaced.
_FAR, _NEAR = 0.2, 0.1
_WEIGHT = 100.0  # of residuals: the damping of 1 that the solver begins with is a light one for these

_SOLVER: optx.LevenbergMarquardt = optx.LevenbergMarquardt(rtol=1e-4, atol=1e-4)


class Problem(NamedTuple):
    """``free`` (6,), where it starts; ``scale`` (6,), what moves a ring by about a pixel; ``plank``, the points;
    ``early`` (N,), how much of each is early wood, blurred by ``blur`` pixels."""

    free: Array
    scale: Array
    plank: Plank
    early: Array
    blur: Array


class Rings(NamedTuple):
    """``free`` (6,); its ``covariance`` (6, 6); ``unexplained``: share of the mask's variance that is left."""

    free: Floats
    covariance: Floats
    unexplained: float


def fit_mask(early: Floats, free: Floats, held: Held) -> Rings:
    """Carry a vector (6,) on to the mask of early wood (H, W)."""
    spacing = float(np.exp(free[4]))
    rings = Rings(free, np.zeros((len(NAMES),) * 2), 1.0)
    for blur, step, most in ((max(0.12 * spacing, 1.5), 4, _FAR), (1.5, 2, _NEAR), (0.0, 1, 1.0)):
        rings = _solve_level(early, rings.free, held, blur=blur, step=step)
        if not np.isfinite(rings.free).all() or rings.unexplained > most:
            break
    return rings


def _solve_level(early: Floats, free: Floats, held: Held, *, blur: float, step: int) -> Rings:
    height, width = early.shape
    smooth = ndimage.gaussian_filter(early, blur, mode="nearest") if blur else early
    near = slice(step // 2, None, step)
    seen = smooth[near, near].ravel()
    size = 2 / max(height, width)
    with jax.enable_x64():
        problem = Problem(
            free=jnp.asarray(free),
            scale=jnp.asarray(loosen([1.0, 1.0, size, size, size, 0.05], held)),
            plank=Plank(*(jnp.asarray(each.ravel()) for each in lay_plank(height, width, step))),
            early=jnp.asarray(seen),
            blur=jnp.asarray(np.hypot(blur, _PIXEL)),
        )
        found, cost, curvature = jax.device_get(_solve(problem))
    mean_square = float(cost) / len(seen)
    # Blur ties neighbouring pixels: only so many are independent.
    together = max(4 * np.pi * blur**2 / step**2, 1.0)
    covariance = np.linalg.pinv(np.asarray(curvature), hermitian=True) * mean_square * together
    scale = np.asarray(problem.scale)
    return Rings(
        free=np.asarray(found),
        covariance=covariance * np.outer(scale, scale),
        unexplained=mean_square / max(float(seen.var()), 1e-12),
    )


@jax.jit
def _solve(problem: Problem) -> tuple[Array, Array, Array]:
    """The vector (6,) found, its sum of squares, and the curvature (6, 6) there by scaled steps."""
    start = jnp.zeros_like(problem.free)
    answer: optx.Solution = optx.least_squares(_residuals, _SOLVER, start, problem, max_steps=40, throw=False)
    residuals = _residuals(answer.value, problem) / _WEIGHT
    rows = jax.jacfwd(_residuals)(answer.value, problem) / _WEIGHT
    return problem.free + answer.value * problem.scale, jnp.sum(residuals**2), rows.T @ rows


def _residuals(step: Array, problem: Problem) -> Array:
    free = problem.free + step * problem.scale
    return _WEIGHT * (early_wood(free, problem.plank, problem.blur) - problem.early)
