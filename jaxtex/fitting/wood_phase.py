"""From a guess at the rings to all rings: how far the observed ones are from it, unwrapped, and a fit to that.

Rings are alike, so that a mask compared with a guess that is one ring off looks right. Multiplied by the guess's own
wave the picture shows by which part of a ring it is off, place by place; unwrapped, that is a map of whole and broken
rings, and fitting to it has one minimum.
"""

import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jax import Array
from numpy.typing import NDArray
from scipy import ndimage
from skimage.restoration import unwrap_phase

from jaxtex.fitting.rings import GEOMETRY, Held, Plank, lay_plank, loosen, model_count, ring_count

Floats = NDArray[np.float64]

_STEPS = 7
_STEP = 4  # every so many pixels along a side are fitted to
_WIDE = 8.0  # pixels: rings that every second pixel shows
_WHOLE_RINGS = (0, -1, 1, -2, 2)  # by which the count may be off
_OUTLIER = 0.5  # rings

_SOLVER: optx.LevenbergMarquardt = optx.LevenbergMarquardt(rtol=1e-5, atol=1e-5)


def follow_rings(rings: Floats, start: Floats, held: Held) -> Floats:
    """Carry a start (5,) on until it has all the rings of a map (H, W) of zero mean."""
    free, (height, width) = start, rings.shape
    # Wide rings are seen as well in every second pixel, in a quarter of the time.
    every = 2 if np.exp(start[4]) > _WIDE else 1
    near = np.s_[:: _STEP // every, :: _STEP // every]
    plank = tuple(each[near].ravel() for each in lay_plank(height, width, every))
    for number in range(_STEPS):
        spacing = float(np.exp(free[4]))
        off, strength, count = compare_rings(rings, free, blur=(0.9 if number < 2 else 0.5) * spacing, every=every)
        weight = (strength / max(float(strength.max()), 1e-12)) ** 2
        # Around the pith rings bend too sharply for one wave.
        weight = weight * (count > 1.0)
        seen = (count + off)[near].ravel()
        found = _fit_count(free, plank, seen, weight[near].ravel(), held, _WHOLE_RINGS if number else (0,))
        if not np.isfinite(found).all():
            break
        moved = np.abs(found - free) / [1.0, 1.0, 0.003, 0.003, 0.003]
        free = found
        if moved.max() < 0.3:
            break
    return free


def compare_rings(rings: Floats, free: Floats, *, blur: float, every: int = 1) -> tuple[Floats, Floats, Floats]:
    """By how many rings the observed ones (H, W) lie further out than those of a vector (5,), unwrapped; how clearly
    they are seen; and the vector's own count of rings; all three at ``every`` so many pixels."""
    count = model_count(free, rings.shape, every)
    turned = rings[every // 2 :: every, every // 2 :: every] * np.exp(-2j * np.pi * (count - 0.25))
    sigma = max(blur, 3.0) / every
    mean = ndimage.gaussian_filter(turned.real, sigma) + 1j * ndimage.gaussian_filter(turned.imag, sigma)
    angle, strength = np.angle(mean), np.abs(mean)
    clear = strength > 0.5 * strength.max()
    whole = np.asarray(unwrap_phase(angle))
    whole = whole - 2 * np.pi * np.round(np.median((whole - angle)[clear]) / (2 * np.pi))
    return whole / (2 * np.pi), strength, count


def _fit_count(
    free: Floats, plank: tuple[Floats, ...], seen: Floats, weight: Floats, held: Held, offsets: tuple[int, ...]
) -> Floats:
    """The vector (5,) whose count of rings is nearest to the one seen (N,), give or take whole rings."""
    size = 2 * max(float(np.abs(plank[0]).max()), float(np.abs(plank[1]).max()))
    scale = loosen([1.0, 1.0, 2 / size, 2 / size, 2 / size], held)
    best: tuple[float, Floats] = (np.inf, np.full(GEOMETRY, np.nan))
    with jax.enable_x64():
        points = Plank(*(jnp.asarray(each) for each in plank))
        for offset in offsets:
            problem = (jnp.asarray(free[:GEOMETRY]), jnp.asarray(scale), points, jnp.asarray(seen + offset), weight)
            found, cost = jax.device_get(_solve_count(problem))
            # Another count must be clearly better.
            if np.isfinite(found).all() and float(cost) < 0.98 * best[0]:
                best = float(cost), np.asarray(found)
    return best[1]


@jax.jit
def _solve_count(problem: tuple[Array, Array, Plank, Array, Array]) -> tuple[Array, Array]:
    start, scale, *_ = problem
    answer: optx.Solution = optx.least_squares(
        _count_residuals, _SOLVER, jnp.zeros_like(start), problem, max_steps=40, throw=False
    )
    return start + answer.value * scale, jnp.sum(_count_residuals(answer.value, problem) ** 2)


def _count_residuals(step: Array, problem: tuple[Array, Array, Plank, Array, Array]) -> Array:
    start, scale, plank, seen, weight = problem
    aside = (ring_count(start + step * scale, plank) - seen) * weight
    return aside * jax.lax.rsqrt(1.0 + (aside / _OUTLIER) ** 2)
