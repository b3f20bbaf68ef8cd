"""How turbulence displaces rings, estimated together with the rings that it displaces.

What was measured is the rings' count; the model's distance and a smooth random displacement add up to it. Both are
estimated at once by generalised least squares: the displacement is a Gaussian process with the covariance that the
model's own turbulence has, plane waves from all sides whose frequencies lie around one, and its strength and frequency
are those of greatest restricted likelihood.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import NDArray
from scipy import linalg

from jaxtex.fitting.rings import GEOMETRY, Held, Plank, ring_distance

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_CELLS = 26  # along the picture's longer side: as many points as a factorisation takes in a moment
_FEWEST = 0.3  # of a cell's pixels must be clear
_SPREAD = 0.3  # of the logarithm of frequencies, as in the model
_WAVELENGTHS = np.geomspace(0.12, 1.2, 13)  # of the picture's longer side
_NOISE = 0.03  # pixels: of a cell's mean, where nothing is seen to be worse
_STEPS = 4


class Turbulence(NamedTuple):
    """``free`` (5,) and its ``covariance`` (5, 5), turbulence accounted for; ``rms`` of the displacement within the
    picture, its mean left aside, pixels; ``frequency``, cycles per pixel."""

    free: Floats
    covariance: Floats
    rms: float
    frequency: float


class _Cells(NamedTuple):
    """Means over cells of the picture, where it is clear: ``place`` (N, 2), and to which of the ``rings`` (N,)."""

    place: Floats
    rings: Floats


def fit_turbulence(count: Floats, clear: Mask, free: Floats, held: Held) -> Turbulence | None:
    """Fit rings and turbulence to the rings counted (H, W) where that is clear, from a vector (5,); None where too
    little is."""
    cells = _average(count, clear)
    if len(cells.rings) < 4 * GEOMETRY:
        return None
    loose = [n for n in range(GEOMETRY) if n not in held]
    wavelengths = _WAVELENGTHS * max(count.shape)
    correlations = [correlate_turbulence(cells.place, 1 / each) for each in wavelengths]
    found = free[:GEOMETRY].copy()
    for _ in range(_STEPS):
        off, rows = _linearise(found, cells)
        best = max((_likelihood(each, off, rows[:, loose]) for each in correlations), key=lambda fit: fit.likelihood)
        if not np.isfinite(best.step).all():
            return None
        found[loose] -= best.step
    number = next(n for n, each in enumerate(correlations) if each is best.correlation)
    off, rows = _linearise(found, cells)
    covariance = np.zeros((GEOMETRY, GEOMETRY))
    covariance[np.ix_(loose, loose)] = best.covariance
    # What the rings took up of the displacement counts as well, as much as their numbers are uncertain.
    centred = rows - rows.mean(0)
    taken = np.einsum("nk,kl,nl->n", centred, covariance, centred).mean()
    return Turbulence(found, covariance, float(np.sqrt(off.var() + taken)), float(1 / wavelengths[number]))


def correlate_turbulence(place: Floats, frequency: float) -> Floats:
    """Correlation (N, N) of turbulence of one frequency (cycles per pixel) between places (N, 2) of a plank.

    Plane waves from all sides of space correlate as sin(x) / x, x their phase over the distance.
    """
    nodes, weights = np.polynomial.hermite_e.hermegauss(9)
    distance = np.hypot(*(place[:, None] - place[None]).transpose(2, 0, 1))
    waves = [w * np.sinc(2 * frequency * np.exp(_SPREAD * x) * distance) for x, w in zip(nodes, weights, strict=True)]
    return np.sum(waves, axis=0) / weights.sum()


class _Fit(NamedTuple):
    likelihood: float
    step: Floats
    covariance: Floats
    correlation: Floats


def _likelihood(correlation: Floats, off: Floats, rows: Floats) -> _Fit:
    """Generalised least squares of rows (N, K) to off (N,) under a correlation (N, N), whose strength follows."""
    number, numbers = rows.shape
    scale = np.linalg.norm(rows, axis=0)
    rows = rows / np.where(scale > 0, scale, 1.0)
    # Cells are means of a measurement that is itself uncertain, by a share of what it measures.
    noise = _NOISE**2 / max(float(off.var()), _NOISE**2) + 1e-4
    factor = linalg.cholesky(correlation + noise * np.eye(number), lower=True)
    white = linalg.solve_triangular(factor, np.column_stack([off, rows]), lower=True)
    normal = white[:, 1:].T @ white[:, 1:]
    step = np.linalg.lstsq(normal, white[:, 1:].T @ white[:, 0], rcond=None)[0]
    strength = float(((white[:, 0] - white[:, 1:] @ step) ** 2).sum()) / (number - numbers)
    _, log_normal = np.linalg.slogdet(normal)
    likelihood = -(number - numbers) * np.log(strength) - 2 * np.log(np.diag(factor)).sum() - log_normal
    spread = np.where(scale > 0, 1 / np.where(scale > 0, scale, 1.0), 0.0)
    covariance = strength * np.linalg.pinv(normal, hermitian=True) * np.outer(spread, spread)
    return _Fit(float(likelihood), step * spread, covariance, correlation)


def _average(count: Floats, clear: Mask) -> _Cells:
    height, width = count.shape
    side = max(1, -(-max(height, width) // _CELLS))
    rows, columns = (np.arange(n) // side for n in count.shape)
    cell = (rows[:, None] * (columns[-1] + 1) + columns[None]).ravel()
    weight = clear.ravel().astype(float)
    v, u = np.mgrid[0:height, 0:width] + 0.5
    total, *sums = (
        np.bincount(cell, weight * each.ravel())
        for each in (np.ones(count.shape), u - width / 2, v - height / 2, count)
    )
    kept = total > _FEWEST * side**2
    x, y, mean = (each[kept] / total[kept] for each in sums)
    return _Cells(np.stack([x, y], axis=1), mean)


def _linearise(free: Floats, cells: _Cells) -> tuple[Floats, Floats]:
    """How far the rings seen lie outside a vector's (N,), pixels, and how that changes with its numbers (N, 5)."""
    with jax.enable_x64():
        plank = Plank(*(jnp.asarray(each) for each in cells.place.T))
        off, rows = _off(jnp.asarray(free), plank, jnp.asarray(cells.rings))
        return np.asarray(off), np.asarray(rows)


@jax.jit
def _off(free: Array, plank: Plank, count: Array) -> tuple[Array, Array]:
    def off(free: Array) -> Array:
        return count * jnp.exp(free[4]) - ring_distance(free, plank)[0]

    return off(free), jax.jacfwd(off)(free)
