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
from scipy import interpolate, linalg

from jaxtex.fitting.rings import GEOMETRY, Held, Plank, model_count, ring_count

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_CELLS = 26  # along the picture's longer side: as many points as a factorisation takes in a moment
_FEWEST = 0.3  # of a cell's pixels must be clear
_SPREAD = 0.3  # of the logarithm of frequencies, as in the model
_WAVELENGTHS = np.geomspace(0.12, 1.2, 13)  # of the picture's longer side
_NOISE = 0.03  # pixels: of a cell's mean, where nothing is seen to be worse
_DISTANCES = 2048  # at which correlation is computed
_ROUNDS = 3  # of choosing the frequency
_STEPS = 10


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


def fit_turbulence(
    rings: Floats, clear: Mask, free: Floats, held: Held, frequency: float | None = None
) -> Turbulence | None:
    """Fit rings and turbulence to the rings seen (H, W) where that is clear, from a vector (5,); None where too
    little is. The turbulence's ``frequency`` may be known.

    The count is taken as it is. One ring more or less around a pith that lies deeper than rings can be followed would
    explain the others nearly as well, and which count is likelier tells little of which is right.
    """
    cells = _average_about(rings, clear, free)
    if len(cells.rings) < 4 * GEOMETRY:
        return None
    loose = [n for n in range(GEOMETRY) if n not in held]
    wavelengths = _WAVELENGTHS * max(rings.shape) if frequency is None else np.array([1 / frequency])
    correlations = [correlate_turbulence(cells.place, 1 / each) for each in wavelengths]
    found, unit = free[:GEOMETRY].copy(), float(np.exp(free[4]))
    for _ in range(_ROUNDS):
        cells = _average_about(rings, clear, found)
        off, rows = _linearise(found, cells, unit)
        fits = [_likelihood(each, off, rows[:, loose]) for each in correlations]
        number = int(np.argmax([fit.likelihood for fit in fits]))
        found = _descend(found, cells, loose, fits[number], unit)
    off, rows = _linearise(found, cells, unit)
    covariance = np.zeros((GEOMETRY, GEOMETRY))
    covariance[np.ix_(loose, loose)] = _likelihood(correlations[number], off, rows[:, loose]).covariance
    # What the rings took up of the displacement counts as well, as much as their numbers are uncertain.
    centred = rows - rows.mean(0)
    taken = np.einsum("nk,kl,nl->n", centred, covariance, centred).mean()
    return Turbulence(found, covariance, float(np.sqrt(off.var() + taken)), float(1 / wavelengths[number]))


def _average_about(rings: Floats, clear: Mask, free: Floats) -> _Cells:
    """Means over cells of the rings seen (H, W), as if a vector's own rings were straight within a cell."""
    cells = _average(rings - model_count(free, rings.shape), clear)
    return cells._replace(rings=cells.rings + _count(free, cells.place))


def predict_turbulence(rings: Floats, clear: Mask, fitted: Turbulence, place: Floats) -> Floats:
    """The displacement (N,), pixels, at places (N, 2) of a picture, as fitted to the rings seen (H, W)."""
    cells = _average_about(rings, clear, fitted.free)
    off, _ = _linearise(fitted.free, cells, float(np.exp(fitted.free[4])))
    every = correlate_turbulence(np.concatenate([place, cells.place]), fitted.frequency)
    among = every[len(place) :, len(place) :] + ((_NOISE / fitted.rms) ** 2 + 1e-4) * np.eye(len(off))
    return every[: len(place), len(place) :] @ linalg.solve(among, off, assume_a="pos")


def correlate_turbulence(place: Floats, frequency: float) -> Floats:
    """Correlation (N, N) of turbulence of one frequency (cycles per pixel) between places (N, 2) of a plank.

    Plane waves from all sides of space correlate as sin(x) / x, x their phase over the distance. So does the model's
    turbulence on end grain. Along the trunk that is slower, by how much nobody knows of the wood in a picture: the
    correlation supposes no more than the distance.
    """
    distance = np.hypot(*(place[:, None] - place[None]).transpose(2, 0, 1))
    nodes, weights = np.polynomial.hermite_e.hermegauss(9)
    far = np.linspace(0, float(distance.max()), _DISTANCES)
    waves = [w * np.sinc(2 * frequency * np.exp(_SPREAD * x) * far) for x, w in zip(nodes, weights, strict=True)]
    return interpolate.CubicSpline(far, np.sum(waves, axis=0) / weights.sum())(distance)


class _Fit(NamedTuple):
    likelihood: float
    covariance: Floats
    factor: Floats  # of the correlation of what is measured


def _likelihood(correlation: Floats, off: Floats, rows: Floats) -> _Fit:
    """Generalised least squares of rows (N, K) to off (N,) under a correlation (N, N), whose strength follows."""
    number, numbers = rows.shape
    # Cells are means of a measurement that is itself uncertain, by a share of what it measures.
    noise = _NOISE**2 / max(float(off.var()), _NOISE**2) + 1e-4
    # Cells that hardly stray tell of the noise that is assumed, not of how strong turbulence is.
    strongest = float(off.var())
    factor = linalg.cholesky(correlation + noise * np.eye(number), lower=True)
    off, rows = _whiten(factor, off), _whiten(factor, rows)
    scale = np.maximum(np.linalg.norm(rows, axis=0), 1e-12)
    normal = (rows / scale).T @ (rows / scale)
    step = np.linalg.lstsq(rows / scale, off, rcond=None)[0]
    strength = float(((off - rows / scale @ step) ** 2).sum()) / (number - numbers)
    _, log_normal = np.linalg.slogdet(normal)
    likelihood = -(number - numbers) * np.log(strength) - 2 * np.log(np.diag(factor)).sum() - log_normal
    covariance = max(strength, strongest) * np.linalg.pinv(normal, hermitian=True) / np.outer(scale, scale)
    return _Fit(float(likelihood), covariance, factor)


def _descend(free: Floats, cells: _Cells, loose: list[int], fit: _Fit, unit: float) -> Floats:
    """A few steps of Levenberg and Marquardt from a vector (5,) towards the least squares of whitened displacement."""
    off, rows = _linearise(free, cells, unit)
    cost, damping = float((_whiten(fit.factor, off) ** 2).sum()), 1e-4
    for _ in range(_STEPS):
        white, slopes = _whiten(fit.factor, off), _whiten(fit.factor, rows[:, loose])
        scale = np.maximum(np.linalg.norm(slopes, axis=0), 1e-12)
        normal = (slopes / scale).T @ (slopes / scale)
        trial = free.copy()
        trial[loose] -= np.linalg.solve(normal + damping * np.eye(len(loose)), (slopes / scale).T @ white) / scale
        there = _linearise(trial, cells, unit)
        lower = float((_whiten(fit.factor, there[0]) ** 2).sum())
        if lower < cost:
            free, (off, rows), cost, damping = trial, there, lower, damping / 5
        else:
            damping *= 10
    return free


def _whiten(factor: Floats, rows: Floats) -> Floats:
    return linalg.solve_triangular(factor, rows, lower=True)


def _average(rings: Floats, clear: Mask) -> _Cells:
    height, width = rings.shape
    side = max(1, -(-max(height, width) // _CELLS))
    rows, columns = (np.arange(n) // side for n in rings.shape)
    cell = (rows[:, None] * (columns[-1] + 1) + columns[None]).ravel()
    weight = clear.ravel().astype(float)
    v, u = np.mgrid[0:height, 0:width] + 0.5
    total, *sums = (
        np.bincount(cell, weight * each.ravel())
        for each in (np.ones(rings.shape), u - width / 2, v - height / 2, rings)
    )
    kept = total > _FEWEST * side**2
    x, y, mean = (each[kept] / total[kept] for each in sums)
    return _Cells(np.stack([x, y], axis=1), mean)


def _linearise(free: Floats, cells: _Cells, unit: float) -> tuple[Floats, Floats]:
    """How far the rings seen lie outside a vector's (N,), pixels, and how that changes with its numbers (N, 5)."""
    count, rows = _count_and_slopes(free, cells.place)
    return unit * (cells.rings - count), -unit * rows


def _count(free: Floats, place: Floats) -> Floats:
    return _count_and_slopes(free, place)[0]


def _count_and_slopes(free: Floats, place: Floats) -> tuple[Floats, Floats]:
    """The rings (N,) of a vector at places (N, 2), and how they change with its numbers (N, 5)."""
    # How many cells are clear depends on the picture; few lengths share few compilations.
    u, v = np.pad(place, ((0, -len(place) % _CELLS), (0, 0))).T
    with jax.enable_x64():
        count, rows = _differentiate(jnp.asarray(free[:GEOMETRY]), Plank(jnp.asarray(u), jnp.asarray(v)))
        return np.asarray(count)[: len(place)], np.asarray(rows)[: len(place)]


@jax.jit
def _differentiate(free: Array, plank: Plank) -> tuple[Array, Array]:
    return ring_count(free, plank), jax.jacfwd(ring_count)(free, plank)
