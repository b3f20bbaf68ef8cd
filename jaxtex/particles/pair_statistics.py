"""Where particles have others around them, as distributions that are matched by gradient.

Two distributions of ways (vectors from particle to particle) speak for each ordered pair of classes: those to the
nearest particle, and those to all that are near, which count less the further away they are. Both are soft: ways to
particles that are about as near count about the same, as in lattices, which of several is the nearest means nothing.

They are compared by sliced Wasserstein distances (J. Rabin, G. Peyré, J. Delon and M. Bernot, "Wasserstein barycenter
and its application to texture mixing", 2011), of projections along axes, of directions (modulo pi, as unit vectors of
twice the angle) along the same axes, and of lengths. Departure: differences are
limited (R. E. Welsch), as what is far off is of another place of a lattice, and no step there is a small one.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.particles.patterns import Pattern, find_nearest

Floats = npt.NDArray[np.floating]

_CANDIDATES = 10  # nearest particles of a class that are looked at
_NEAREST = 3  # of them: how many may count as the nearest
_REACHED = 6  # of them: how many are near
_BEYOND = 1.2  # times their mean distance: from where nothing counts
_SOFT = 0.05  # of the mean distance to the nearest one: by how much further away another one is that counts 1/e
_TOLERANCE = 0.35  # of that distance: differences beyond have little weight
_LENGTHS = 0.5  # how much lengths count beside all projections together
_DIRECTIONS = 2.0  # how much directions do, all projections together
_ARM = 0.5  # of the mean distance to the nearest one: half of how far apart directions at right angles count as
_QUANTILES = 256
_LEAST_KNOWN = 4  # particles of which it is known what is nearest; fewer tell nothing


class Candidates(NamedTuple):
    """What may be near, for each ordered pair of classes (set), padded to the same length.

    Attributes:
        around: numbers of points, [set, asked].
        which: of their nearest ones, [set, asked, candidate].
        wraps: what is added to the way to these where the plane repeats, [set, asked, candidate, (x, y)].
        there: whether there is one, bool [set, asked, candidate].
        low, high: corners of the window, [(x, y)].
        bounded: 1 where the window has a border, 0 where it repeats, scalar.
    """

    around: Array
    which: Array
    wraps: Array
    there: Array
    low: Array
    high: Array
    bounded: Array


class Scales(NamedTuple):
    """Lengths of each ordered pair of classes.

    Attributes:
        unit: the mean distance to the nearest one, pixels, [set].
        reach: how far away what is near is at most, pixels, [set].
    """

    unit: Array
    reach: Array


class Ways(NamedTuple):
    """Ways [set, way, (x, y)], their lengths [set, way], and how much each counts [set, way]."""

    vectors: Array
    lengths: Array
    weights: Array


class Goal(NamedTuple):
    """What compositions are to be like.

    Attributes:
        axes: unit vectors, [axis, (x, y)].
        nearest, near: quantiles of ways along each axis, and of lengths, [set, 2 axes + 1, quantile].
        strengths: how much each of them counts, [set, 2].
        scales: of the sets.
    """

    axes: Array
    nearest: Array
    near: Array
    strengths: Array
    scales: Scales


def list_candidates(pattern: Pattern, kinds: int, room: int) -> Candidates:
    """The nearest points of each class to each point of each class.

    Args:
        pattern: points.
        kinds: how many classes there are.
        room: length that sets are padded to, at least the number of points of the largest class.
    """
    columns: list[tuple[npt.NDArray, ...]] = []
    for kind in range(kinds):
        for other in range(kinds):
            found = find_nearest(pattern, kind, other, _CANDIDATES)
            plain = pattern.points[found.which] - pattern.points[found.around][:, None]
            there = found.which != found.around[:, None]
            columns.append(
                tuple(pad_rows(each, room) for each in (found.around, found.which, found.ways - plain, there))
            )
    around, which, wraps, there = (as_device(np.stack(each)) for each in zip(*columns, strict=True))
    low, high = (as_device(np.array(each)) for each in (pattern.low, pattern.high))
    return Candidates(around, which, wraps, there, low, high, as_device(np.array(float(pattern.period is None))))


def pad_rows(values: npt.NDArray, room: int) -> npt.NDArray:
    """An array with rows of zeros up to a length."""
    padded = np.zeros((room, *values.shape[1:]), values.dtype)
    padded[: len(values)] = values
    return padded


def as_device(values: npt.NDArray) -> Array:
    """An array for JAX: real numbers in its default precision."""
    real = np.issubdtype(values.dtype, np.floating)
    return jnp.asarray(values, jnp.zeros(()).dtype if real else None)


def measure_scales(pattern: Pattern, kinds: int) -> Scales:
    """How far away the nearest and the near ones are on average; 1 pixel where nothing is known of it."""
    scales = []
    for kind in range(kinds):
        for other in range(kinds):
            found = find_nearest(pattern, kind, other, _REACHED)
            there = found.which != found.around[:, None]
            distances = np.hypot(found.ways[..., 0], found.ways[..., 1])
            last = int(there.sum(axis=1).min(initial=_REACHED)) - 1
            if last < 0 or not found.weights[:, 0].any():
                scales.append((1.0, 1.0))
                continue
            unit = np.average(distances[:, 0], weights=found.weights[:, 0])
            known = found.weights[:, last]
            furthest = np.average(distances[:, last], weights=known if known.any() else None)
            scales.append((float(unit), _BEYOND * float(furthest)))
    unit, reach = np.array(scales).T
    return Scales(as_device(unit), as_device(reach))


def make_goal(points: Array, candidates: Candidates, scales: Scales, axes: Floats, counts: npt.NDArray) -> Goal:
    """The distributions that a picture has.

    Args:
        points: the picture's, [point, (x, y)].
        candidates: of them.
        scales: of them.
        axes: unit vectors, [axis, (x, y)].
        counts: how much each set counts, [set].
    """
    tables, strengths = [], []
    for ways in _find_ways(points, candidates, scales):
        along, weights = (
            np.asarray(each, float) for each in (_project(ways, as_device(axes), scales.unit), ways.weights)
        )
        enough = (weights > 0).sum(axis=1) >= _LEAST_KNOWN
        tables.append(np.stack([_quantiles(*each) for each in zip(along, weights, strict=True)]))
        strengths.append(enough * counts)
    nearest, near = (as_device(each) for each in tables)
    return Goal(as_device(axes), nearest, near, as_device(np.stack(strengths, axis=1).astype(float)), scales)


def miss_goal(points: Array, candidates: Candidates, goal: Goal) -> Array:
    """By how much points miss a goal: square pixels, summed over points; differentiable in `points`."""
    tables = (goal.nearest, goal.near)
    found = _find_ways(points, candidates, goal.scales)
    return sum(
        (
            _miss_table(ways, goal.axes, table, goal.strengths[:, index], goal.scales.unit)
            for index, (ways, table) in enumerate(zip(found, tables, strict=True))
        ),
        jnp.zeros(()),
    )


def _find_ways(points: Array, candidates: Candidates, scales: Scales) -> tuple[Ways, Ways]:
    """Ways to the nearest, and to all that are near."""
    here = points[candidates.around]
    vectors = points[candidates.which] - here[:, :, None] + candidates.wraps
    lengths = jnp.sqrt(jnp.square(vectors).sum(axis=-1) + 1e-12)
    fixed = jax.lax.stop_gradient((here, vectors, lengths))
    nearest, near = _weigh(*fixed, candidates, scales)
    sets = vectors.shape[0]

    def flatten(count: int, weights: Array) -> Ways:
        return Ways(
            vectors[:, :, :count].reshape(sets, -1, 2),
            lengths[:, :, :count].reshape(sets, -1),
            weights[:, :, :count].reshape(sets, -1),
        )

    return flatten(_NEAREST, nearest), flatten(_CANDIDATES, near)


def _weigh(here: Array, vectors: Array, lengths: Array, candidates: Candidates, scales: Scales) -> tuple[Array, Array]:
    """How much ways count: as ways to the nearest by Hanisch's weights (see `patterns`), as pairs by translation.

    Pairs of a window are the rarer the further apart they are; J. Ohser's weights are one over the area in which the
    first of two may lie so that both are in the window.
    """
    width, height = candidates.high - candidates.low
    low, high = candidates.low[None, None], candidates.high[None, None]
    lengths = jnp.where(candidates.there, lengths, jnp.inf)
    least = lengths[:, :, :_NEAREST].min(axis=-1, keepdims=True)
    # Sets without any candidate have no least length either.
    further = jnp.where(candidates.there, lengths - jnp.where(jnp.isfinite(least), least, 0.0), jnp.inf)
    soft = jnp.exp(-jnp.maximum(further, 0.0) / (_SOFT * scales.unit[:, None, None]))
    soft = soft.at[:, :, _NEAREST:].set(0.0)
    share = soft / jnp.maximum(soft.sum(axis=-1, keepdims=True), 1e-9)
    border = jnp.minimum(here - low, high - here).min(axis=-1)[..., None]
    room = (1 - 2 * least / width) * (1 - 2 * least / height)
    taken = (least <= border) & (room > 0)
    bounded = candidates.bounded > 0
    nearest = share * jnp.where(bounded, taken / jnp.where(taken, room, 1.0), 1.0)
    kernel = jnp.square(jnp.maximum(0.0, 1 - jnp.square(lengths / scales.reach[:, None, None])))
    there = here[:, :, None] + vectors
    beyond = jnp.minimum(there - low[None], high[None] - there).min(axis=-1)
    both = jnp.maximum(0.1, (1 - jnp.abs(vectors[..., 0]) / width) * (1 - jnp.abs(vectors[..., 1]) / height))
    inside = (border >= 0) & (beyond >= 0)
    return nearest, kernel * jnp.where(bounded, inside / both, 1.0)


def _project(ways: Ways, axes: Array, unit: Array) -> Array:
    """What is compared: ways along axes, their directions modulo pi likewise, and lengths, [set, 2 axes + 1, way]."""
    x, y = ways.vectors[..., 0] / ways.lengths, ways.vectors[..., 1] / ways.lengths
    doubled = jnp.stack([x * x - y * y, 2 * x * y], axis=-1) * (_ARM * unit[:, None, None])
    along = [jnp.einsum("snc,dc->sdn", each, axes) for each in (ways.vectors, doubled)]
    return jnp.concatenate([*along, ways.lengths[:, None]], axis=1)


def _quantiles(along: Floats, weights: Floats) -> Floats:
    """Evenly spaced quantiles of weighted values [axis, way] along each axis; 0 where nothing has weight."""
    counted = weights > 0
    if not counted.any():
        return np.zeros((len(along), _QUANTILES))
    levels, rows = (np.arange(_QUANTILES) + 0.5) / _QUANTILES, []
    for values in along[:, counted]:
        order = np.argsort(values)
        ranked = weights[counted][order]
        rows.append(np.interp(levels, (np.cumsum(ranked) - 0.5 * ranked) / ranked.sum(), values[order]))
    return np.stack(rows)


def _miss_table(ways: Ways, axes: Array, table: Array, strengths: Array, unit: Array) -> Array:
    """Each way's difference to the quantile of its rank, squared and limited."""
    along = _project(ways, axes, unit)
    weights = jnp.broadcast_to(ways.weights[:, None], along.shape)
    order = jnp.argsort(jax.lax.stop_gradient(jnp.where(weights > 0, along, jnp.inf)), axis=-1)
    ranked = jnp.take_along_axis(weights, order, axis=-1)
    total = ranked.sum(axis=-1, keepdims=True)
    share = ranked / jnp.where(total > 0, total, 1.0)
    place = jnp.clip((jnp.cumsum(share, axis=-1) - 0.5 * share) * _QUANTILES - 0.5, 0.0, _QUANTILES - 1.0)
    below = jnp.minimum(place.astype(jnp.int32), _QUANTILES - 2)
    part = place - below
    wanted = (1 - part) * jnp.take_along_axis(table, below, axis=-1)
    wanted += part * jnp.take_along_axis(table, below + 1, axis=-1)
    off = jnp.where(ranked > 0, jnp.take_along_axis(along, order, axis=-1) - wanted, 0.0)
    limit = _TOLERANCE * unit[:, None, None]
    limited = -jnp.square(limit) * jnp.expm1(-jnp.square(off / limit))
    counts = jnp.array([*[1.0 / len(axes)] * len(axes), *[_DIRECTIONS / len(axes)] * len(axes), _LENGTHS], off.dtype)
    return 0.5 * (strengths[:, None, None] * counts[None, :, None] * share * limited).sum()
