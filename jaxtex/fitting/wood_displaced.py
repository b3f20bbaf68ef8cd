"""Least squares of rings and of the turbulence that displaces them, both at once, on the mask of early wood itself.

Lines of rings can be followed only where each is seen apart from its mirror image, and not around the pith, which
tells most of where the axis is. Given rings and turbulence that are nearly right, the mask can be compared pixel by
pixel everywhere. Turbulence is a spline through nodes, a Gaussian process of known correlation between these.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import NDArray
from scipy import interpolate, linalg, ndimage

from jaxtex.fitting.end_grain import from_ellipses, to_ellipses
from jaxtex.fitting.rings import GEOMETRY, NAMES, Held, Plank, lay_plank, model_count, ring_count
from jaxtex.fitting.wood_outcome import is_early
from jaxtex.fitting.wood_turbulence import Turbulence, correlate_turbulence, fit_turbulence, predict_turbulence
from jaxtex.models.wood import early_share

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Blur of the mask, at least so many spacings and so many pixels, and every so many pixels compared: coarse first.
_LEVELS = ((0.12, 1.5, 2), (0.0, 0.7, 1))
_ROUNDS = 16  # at each
_SHARES = (1.0, 0.5, 0.25, 0.1, 0.02)  # of a step, that are tried
_END_GRAIN = 0.87  # sine of the tilt, at least
_LITTLE = 0.1  # of the cost: a step that gains less is the last
_NODES = 10.0  # of the spline, along one wave of the turbulence
_FEWEST, _MOST = 8, 36  # nodes along the longer side
_JITTER = 1e-4  # of turbulence's variance, from node to node
_PIXEL = np.sqrt(1 / 12)  # a pixel's own blur
_SHARPEST = 1e-3  # rings: an edge's width, at least
_AGREES = 0.35  # share of the mask's variance left around a place where rings are believed, at most
_CLOSE = 60.0  # of the cost: counts that differ by less are told apart by every pixel
_COUNTED = 1.0  # rings: nearer to the pith there is no room for another


class Displaced(NamedTuple):
    """``free`` (6,) and its ``covariance`` (6, 6), displacement accounted for; ``displacement`` (H, W), pixels;
    ``rms``, of that and of what may be displacement but went to the rings; ``believed`` (H, W), where the rings agree
    with the mask. The turbulence's strength and frequency are taken to be known, which few waves in a picture do not
    tell well: the covariance is the smaller for it."""

    free: Floats
    covariance: Floats
    displacement: Floats
    rms: float
    believed: Mask


class _Splines(NamedTuple):
    """Cubic splines: ``rows`` (H, M) and ``columns`` (W, N), what each node adds to each pixel."""

    rows: Floats
    columns: Floats

    def spread(self, nodes: Floats) -> Floats:
        """The displacement (H, W) through its values at the nodes (M N,)."""
        return self.rows @ nodes.reshape(self.rows.shape[1], -1) @ self.columns.T


class _Level(NamedTuple):
    """The mask (H, W) at ``every`` so many pixels, blurred by ``blur`` pixels, and the splines there."""

    early: Floats
    splines: _Splines
    shape: tuple[int, ...]
    blur: float
    every: int


class _Problem(NamedTuple):
    """``splines`` over the picture and the ``place`` (M N, 2) of their nodes; ``precision`` (M N, M N), the inverse of
    the nodes' covariance; the mask at its ``levels``."""

    splines: _Splines
    place: Floats
    precision: Floats
    levels: tuple[_Level, ...]


class _State(NamedTuple):
    """Where a level ended: ``vector`` (6 + M N,), rings and nodes, and its ``covariance``; ``believed``, where at its
    pixels they agree with the mask; what is ``left`` of that, squared and summed; the ``variance`` to be expected of
    it; how many of the nodes' combinations it has ``told``; ``curvature``, the logarithm of its determinant."""

    vector: Floats
    covariance: Floats
    believed: Mask
    left: float
    variance: float
    told: float
    curvature: float


def fit_displaced(early: Floats, rings: Floats, clear: Mask, fitted: Turbulence, logit: float, held: Held) -> Displaced:
    """Carry rings and turbulence, fitted to the rings seen (H, W) where that is clear, on to the mask (H, W).

    Where the pith is out of the picture, rings may be miscounted: one more and one less are tried.
    """
    problem = _pose(early, fitted)
    coarse, fine = problem.levels
    states = [_solve(coarse, _begin(rings, clear, fitted, logit, problem.place), problem.precision, held)]
    if (model_count(states[0].vector[:GEOMETRY], early.shape) > _COUNTED).all():
        for more in (-1, 1):
            # Whichever the count, the same turbulence displaces the rings.
            other = fit_turbulence(rings + more, clear, fitted.free, held, fitted.frequency)
            if other is not None:
                start = _begin(rings + more, clear, other._replace(rms=fitted.rms), logit, problem.place)
                states.append(_solve(coarse, start, problem.precision, held))
    costs = _weigh(states, problem.precision)
    close = [each for each, cost in zip(states, costs, strict=True) if cost < min(costs) + _CLOSE]
    states = [_solve(fine, each.vector, problem.precision, held) for each in close]
    costs = _weigh(states, problem.precision)
    state = states[int(np.argmin(costs))]
    likely = np.exp((costs.min() - costs) / 2)
    apart = np.array([_turn_like(state.vector[: len(NAMES)], each.vector[: len(NAMES)]) for each in states])
    apart = apart - state.vector[: len(NAMES)]
    free, nodes = np.split(state.vector, [len(NAMES)])
    displacement = problem.splines.spread(nodes)
    return Displaced(
        free=free,
        # Counts that are nearly as likely are a part of how uncertain the rings are.
        covariance=state.covariance[: len(NAMES), : len(NAMES)] + (apart.T * (likely / likely.sum())) @ apart,
        displacement=displacement,
        rms=float(np.sqrt(displacement.var() + _mean_variance(state.covariance[len(NAMES) :, len(NAMES) :]))),
        believed=state.believed,
    )


def bound_errors(free: Floats, displacement: Floats, *, rms: float, frequency: float) -> Floats:
    """The least covariance (6, 6) of a vector (6,) in a picture whose rings a ``displacement`` (H, W) moves (Cramér &
    Rao): what the mask tells, drawn in pixels, their rounding taken for noise."""
    early = is_early(model_count(free, displacement.shape) + displacement * np.exp(-free[4]), float(free[5]))
    problem = _pose(early.astype(float), Turbulence(free[:GEOMETRY], np.zeros(()), rms, frequency))
    where = [problem.place[:, 1 - n] + displacement.shape[n] / 2 - 0.5 for n in range(2)]
    vector = np.append(free, ndimage.map_coordinates(displacement, where, order=1, mode="nearest"))
    fine = problem.levels[-1]
    off, slopes = _compare(fine, vector)
    weight = np.full(off.shape, 1 / _variance(fine, off, slopes[-1] ** 2))
    curvature, _ = _add_up(off, slopes, weight, fine.splines, problem.precision, vector)
    curvature[: len(NAMES), : len(NAMES)] += np.diag(_reach(displacement.shape) ** -2.0)
    return np.asarray(np.linalg.inv(curvature), float)[: len(NAMES), : len(NAMES)]


def _pose(early: Floats, fitted: Turbulence) -> _Problem:
    splines, place = _lay_splines(early.shape, fitted.frequency)
    correlation = correlate_turbulence(place, fitted.frequency) + _JITTER * np.eye(len(place))
    precision = linalg.cho_solve(linalg.cho_factor(fitted.rms**2 * correlation), np.eye(len(place)))
    levels = []
    for least, pixels, every in _LEVELS:
        blur = max(least * float(np.exp(fitted.free[4])), pixels)
        near = slice(every // 2, None, every)
        smooth = ndimage.gaussian_filter(early, blur, mode="nearest")[near, near]
        levels.append(_Level(smooth, _Splines(splines.rows[near], splines.columns[near]), early.shape, blur, every))
    return _Problem(splines, place, precision, tuple(levels))


def _begin(rings: Floats, clear: Mask, fitted: Turbulence, logit: float, place: Floats) -> Floats:
    """The vector (6 + M N,) of rings and turbulence fitted to the rings seen (H, W)."""
    return np.concatenate([fitted.free, [logit], predict_turbulence(rings, clear, fitted, place)])


def _turn_like(free: Floats, other: Floats) -> Floats:
    """Another vector (6,), its axis turned by half a turn where that is nearer to the first one's: the same rings."""
    turns = round((other[3] - free[3]) / np.pi)
    sign = -1.0 if turns % 2 else 1.0
    return np.array([sign * other[0], sign * other[1], other[2], other[3] - turns * np.pi, *other[4:]])


def _weigh(states: list[_State], precision: Floats) -> Floats:
    """Minus twice the logarithm of how likely each is, give or take the same for all (Laplace's approximation).

    That is what is left of the mask, how rough the displacement is, and how narrowly all else is tied to that: where
    rings are thought to be wider, the same waviness takes more pixels of displacement, but also more of them would do.
    """
    nodes = np.array([each.vector[len(NAMES) :] for each in states])
    rough = np.einsum("sn,nm,sm->s", nodes, precision, nodes)
    # All by the noise of the one that agrees best, whatever they themselves thought of it.
    left = np.array([each.left for each in states])
    variance = np.array([each.variance for each in states])
    noise = variance[left.argmin()]
    tied = [each.curvature + each.told * np.log(each.variance / noise) for each in states]
    return left / noise + rough + tied


def _mean_variance(covariance: Floats) -> float:
    """Of numbers with a covariance (N, N), the mean of their variances about their common mean."""
    return float(np.diag(covariance).mean() - covariance.mean())


def _lay_splines(shape: tuple[int, ...], frequency: float) -> tuple[_Splines, Floats]:
    """Splines over a picture (H, W) for turbulence of one frequency, and where their nodes are (M N, 2)."""
    number = int(np.clip(_NODES * max(shape) * frequency, _FEWEST, _MOST))
    step = max(shape) / (number - 1)
    axes = [np.linspace(-n / 2, n / 2, max(round(n / step) + 1, 4)) for n in shape]
    rows, columns = (
        interpolate.make_interp_spline(axis, np.eye(len(axis)))(np.arange(n) + 0.5 - n / 2)
        for axis, n in zip(axes, shape, strict=True)
    )
    v, u = np.meshgrid(*axes, indexing="ij")
    return _Splines(rows, columns), np.stack([u.ravel(), v.ravel()], axis=1)


def _solve(level: _Level, vector: Floats, precision: Floats, held: Held) -> _State:
    """Gauss and Newton on one blur of the mask.

    How well rings can agree with the mask follows from how well they do, and is taken anew at each step: the mask
    counts for the more, the nearer they are. How wide edges are is taken to stay, while a step is sought.
    """
    moving = np.array([n for n in range(len(vector)) if n not in held])
    # Rings of end grain are moved as ellipses.
    as_ellipses = not held.keys() - {GEOMETRY} and abs(np.sin(vector[2])) > _END_GRAIN
    for _ in range(_ROUNDS):
        here = _linearise(level, vector, precision, moving, as_ellipses=as_ellipses)
        if not here.weight.any():
            break
        cost = _cost(here.off, here.weight, precision, here.vector)
        trials = [_move(here, share * here.step, as_ellipses=as_ellipses) for share in _SHARES]
        costs = [_cost(_compare(level, each)[0], here.weight, precision, each) for each in trials]
        best = int(np.argmin(costs))
        if costs[best] < cost:
            vector = trials[best]
        if cost - costs[best] < _LITTLE:
            break
    here = _linearise(level, vector, precision, moving, as_ellipses=as_ellipses)
    covariance = np.zeros((len(vector),) * 2)
    covariance[np.ix_(moving, moving)] = linalg.cho_solve((here.factor, True), np.eye(len(moving)))
    told = len(precision) - float((precision * covariance[len(NAMES) :, len(NAMES) :]).sum())
    covariance[: len(NAMES), : len(NAMES)] = here.turn @ covariance[: len(NAMES), : len(NAMES)] @ here.turn.T
    tied = 2 * float(np.log(np.diag(here.factor)).sum())
    # A place that rings do not explain, such as a knot, counts no more than that.
    left = float(np.minimum(here.off**2, _AGREES * level.early.var()).sum())
    return _State(here.vector, covariance, here.weight > 0, left, here.variance, told, tied)


class _Linear(NamedTuple):
    """What a picture says of a ``vector`` whose ``rings`` (6,) may be written as ellipses, ``turn`` (6, 6) leading back
    from these: what is ``off`` (H, W) and by which ``weight``; the ``step`` towards the least, and the lower ``factor``
    of the curvature among what moves."""

    vector: Floats
    rings: Floats
    turn: Floats
    off: Floats
    weight: Floats
    variance: float
    step: Floats
    factor: Floats


def _linearise(
    level: _Level, vector: Floats, precision: Floats, moving: NDArray[np.int_], *, as_ellipses: bool
) -> _Linear:
    rings, turn = vector[: len(NAMES)], np.eye(len(NAMES))
    if as_ellipses:
        rings = to_ellipses(rings)
        free, turn = from_ellipses(rings)
        vector = np.concatenate([free, vector[len(NAMES) :]])
    off, slopes = _compare(level, vector)
    believed = _believe(level, off, float(np.exp(vector[4])))
    variance = _variance(level, off, believed * slopes[-1] ** 2)
    weight = believed / variance
    slopes = np.concatenate([np.tensordot(turn.T, slopes[:-1], 1), slopes[-1:]])
    curvature, gradient = _add_up(off, slopes, weight, level.splines, precision, vector)
    # What the picture does not tell stays where it is.
    curvature[: len(NAMES), : len(NAMES)] += np.diag(_reach(level.shape) ** -2.0)
    factor = linalg.cholesky(curvature[np.ix_(moving, moving)], lower=True)
    step = np.zeros_like(vector)
    step[moving] = linalg.cho_solve((factor, True), gradient[moving])
    return _Linear(vector, rings, turn, off, weight, variance, step, factor)


def _reach(shape: tuple[int, ...]) -> Floats:
    """How far rings (6,) may be from where they are thought to be in a picture (H, W)."""
    return np.array([10.0 * max(shape)] * 2 + [np.pi, np.pi, 1.0, 3.0])


def _move(here: _Linear, step: Floats, *, as_ellipses: bool) -> Floats:
    moved = here.rings - step[: len(NAMES)]
    if as_ellipses:
        moved, _ = from_ellipses(moved)
    return np.concatenate([moved, here.vector[len(NAMES) :] - step[len(NAMES) :]])


def _compare(level: _Level, vector: Floats) -> tuple[Floats, Floats]:
    """By how much the mask (H, W) that a vector draws is too early, and how that changes (7, H, W) with the six
    numbers of the rings and with the displacement."""
    free, displacement = vector[: len(NAMES)], level.splines.spread(vector[len(NAMES) :])
    # Displacement turns rings, and decides how wide their edges are where they pass slowly.
    count = model_count(free, level.shape, level.every) + displacement * np.exp(-free[4])
    slope = np.hypot(*np.gradient(count)) / level.every
    with jax.enable_x64():
        plank = Plank(*(jnp.asarray(each.ravel()) for each in lay_plank(level.shape[0], level.shape[1], level.every)))
        width = jnp.asarray(np.hypot(level.blur, _PIXEL) * slope.ravel() + _SHARPEST)
        drawn, slopes = _draw(jnp.asarray(free), plank, jnp.asarray(displacement.ravel()), width)
    shape = level.early.shape
    return np.asarray(drawn).reshape(shape) - level.early, np.asarray(slopes).reshape(-1, *shape)


@jax.jit
def _draw(free: Array, plank: Plank, displacement: Array, width: Array) -> tuple[Array, Array]:
    def draw(free: Array, further: Array) -> Array:
        count = ring_count(free, plank) + (displacement + further) * jnp.exp(-free[4])
        return early_share(count, jax.nn.sigmoid(free[5]), width)

    still = jnp.zeros_like(displacement)
    drawn, push = jax.linearize(draw, free, still)
    slopes = jax.vmap(lambda each: push(each, still))(jnp.eye(len(free), dtype=free.dtype))
    return drawn, jnp.concatenate([slopes, push(jnp.zeros_like(free), jnp.ones_like(displacement))[None]])


def _believe(level: _Level, off: Floats, spacing: float) -> Floats:
    """1 where rings and mask (H, W) agree around a place, else 0."""
    left = ndimage.gaussian_filter(off**2, spacing / level.every, mode="nearest")
    return (left < _AGREES * level.early.var()).astype(float)


def _variance(level: _Level, off: Floats, strength: Floats) -> float:
    """Of what is off (H, W), where edges are: as if every pixel by itself had it."""
    # Blur ties neighbouring pixels: only so many are independent.
    together = max(4 * np.pi * (level.blur / level.every) ** 2, 1.0)
    return max(together * float((off**2 * strength).sum()) / max(float(strength.sum()), 1e-12), 1e-9)


def _add_up(
    off: Floats, slopes: Floats, weight: Floats, splines: _Splines, precision: Floats, vector: Floats
) -> tuple[Floats, Floats]:
    """Curvature (K, K) and gradient (K,) of half the cost."""
    rows, columns = splines
    geometry, push = slopes[:-1].reshape(len(NAMES), -1), slopes[-1]
    weighed = geometry * weight.ravel()
    cross = np.stack([(rows.T @ (weight * push * each) @ columns).ravel() for each in slopes[:-1]])
    m, n = rows.shape[1], columns.shape[1]
    pairs = [(each[:, :, None] * each[:, None, :]).reshape(len(each), -1) for each in (rows, columns)]
    nodes = (pairs[0].T @ (weight * push**2) @ pairs[1]).reshape(m, m, n, n).transpose(0, 2, 1, 3).reshape(m * n, -1)
    curvature = np.block([[weighed @ geometry.T, cross], [cross.T, nodes + precision]])
    gradient = np.concatenate([weighed @ off.ravel(), (rows.T @ (weight * push * off) @ columns).ravel()])
    gradient[len(NAMES) :] += precision @ vector[len(NAMES) :]
    return curvature, gradient


def _cost(off: Floats, weight: Floats, precision: Floats, vector: Floats) -> float:
    nodes = vector[len(NAMES) :]
    return float((weight * off**2).sum() + nodes @ precision @ nodes)
