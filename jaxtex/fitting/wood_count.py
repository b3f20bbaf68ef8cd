"""Least squares of the model's count of rings against the one read off a photograph.

Rings were counted from anywhere, so where the count begins is free as well. Straight rings and bent ones are both
tried. Bent ones must explain clearly more, and agree better with the directions of the grain: rings are of uneven
width and wavy, and neither is to pass for the roundness of a trunk.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jax import Array
from numpy.typing import NDArray

from jaxtex.fitting.rings import GEOMETRY, Held, Plank, hold, lay_plank, model_count, ring_count
from jaxtex.fitting.wood_grain import Grain
from jaxtex.photo.directions import compare_directions

Floats = NDArray[np.float64]

_STEP = 8  # every so many pixels along a side are fitted to
_TOGETHER = 64  # pixels along which grain strays together: what lies within counts as one observation
_OUTLIER = 1.0  # rings
_ROTATION = np.radians(2.0)  # how far a board's rings may be turned against its fibres
_TILTS = np.arcsin([0.02, 0.1, 0.4])
_AXES = (-1.5, -0.6, 0.6, 1.5)  # picture widths from the middle
_MIDDLES = (-0.3, -0.1, 0.1, 0.3)  # likewise, where rings turn back around the axis
_END_GRAIN = np.pi / 2
_BENT = 0.04  # by which bent rings must agree better with the grain's directions
_END_GRAIN_TILT = np.radians(15)  # how far from upright a cut without fibres may be
_PITH = 0.025  # of the shorter side: how far off a pith is where rays and rings show it
_NO_TILT = 1e-6  # radians: none that could be seen, but a number
_MORE = 3  # numbers of bent rings that straight ones do not have

_SOLVER: optx.LevenbergMarquardt = optx.LevenbergMarquardt(rtol=1e-5, atol=1e-5)


class CountedRings(NamedTuple):
    """``free`` (5,) as :mod:`jaxtex.fitting.rings` has it; its ``covariance`` (5, 5), infinite for what straight grain
    does not tell; ``rings`` (H, W), those seen, followed place by place and counted as the model counts them."""

    free: Floats
    covariance: Floats
    rings: Floats


class _Start(NamedTuple):
    """``free`` (5,); ``loose`` (5,), True where a number may move; ``sense``, -1 where rings are counted inwards."""

    free: Floats
    loose: NDArray[np.bool_]
    sense: float


class _Problem(NamedTuple):
    start: Array  # (6,): the vector, and where the count begins
    scale: Array  # (6,), 0 for what is held
    plank: Plank
    seen: Array
    weight: Array
    turn: Array  # where rotation is expected
    stiff: Array  # what a radian off it costs


class _End(NamedTuple):
    vector: Floats  # (6,)
    cost: float
    curvature: Floats
    start: _Start


def fit_count(grain: Grain, held: Held) -> CountedRings:
    """Fit the rings that were counted in a photograph; held numbers stay."""
    independent = max(grain.rings.size / _TOGETHER**2, 2.0 * GEOMETRY)
    starts = [_held(start, held) for start in _list_bent(grain)]
    ends = [_solve(grain, start, independent) for start in starts]
    bent = min(ends, key=lambda end: end.cost)
    if bent.vector[2] < 0 and 1 in held:
        # Written with a positive tilt it would change its sign: as near as it comes to that is no tilt.
        bent = _solve(grain, _held(bent.start, {**held, 2: _NO_TILT}), independent)
    if grain.pith is not None or grain.across is None or {0, 1, 2} & held.keys():
        return _settle(grain, bent, independent, held)
    straight = _solve(grain, _held(_straight(grain), held), independent)
    if grain.folded:
        # A trunk that fits one side only of where rings turn back, and that well, is not the one.
        return _settle(grain, min([straight, *ends], key=lambda end: _stray(grain, end)), independent, held)
    worth = np.exp(_MORE * np.log(independent) / independent)  # by Schwarz's criterion
    agreement = [
        compare_directions(grain.directions, model_count(end.vector, grain.rings.shape))[0] for end in (straight, bent)
    ]
    clearly = bent.cost * worth < straight.cost and agreement[1] > agreement[0] + _BENT
    return _settle(grain, bent if clearly else straight, independent, held)


def _stray(grain: Grain, end: _End) -> float:
    """By how many pixels rings typically lie elsewhere than where a trunk has them."""
    off = _count_from(grain.rings, end.start.sense) - model_count(end.vector[:GEOMETRY], grain.rings.shape)
    return float(off.std() * np.exp(end.vector[4])) if np.isfinite(end.vector).all() else np.inf


def _straight(grain: Grain) -> _Start:
    """Rings of a trunk whose axis lies just beside the picture, along the plank, on the side that late wood tells."""
    turn = _across(grain)
    height, width = grain.rings.shape
    edge = 0.5 * (abs(np.cos(turn)) * width + abs(np.sin(turn)) * height)
    sense = 1.0 if grain.outwards else -1.0
    free = np.array([-sense * (edge + grain.spacing), 0.0, 0.0, turn, np.log(grain.spacing)])
    return _Start(free, np.array([False, False, False, True, True]), sense)


def _held(start: _Start, held: Held) -> _Start:
    return start._replace(free=hold(start.free, held), loose=start.loose & [n not in held for n in range(GEOMETRY)])


def _list_bent(grain: Grain) -> list[_Start]:
    spacing, turn, width = np.log(grain.spacing), _across(grain), max(grain.rings.shape)
    end_grain = np.array([True, True, False, False, True])
    if grain.pith is not None:
        # Rays and rings together tell the pith better than rings do that were counted on weathered wood.
        pith, rotation = grain.pith, grain.across or 0.0
        xc = pith.u * np.cos(rotation) + pith.v * np.sin(rotation)
        yc = np.sin(pith.tilt) * (pith.v * np.cos(rotation) - pith.u * np.sin(rotation))
        spaced = np.array([False, False, False, False, True])
        # The map of a board's figure climbs towards the pith as often as away from it.
        senses = (1.0, -1.0) if grain.folded else (1.0,)
        return [_Start(np.array([xc, yc, pith.tilt, rotation, spacing]), spaced, sense) for sense in senses]
    if grain.across is None:
        toward = np.array([np.cos(turn), np.sin(turn)])
        return [
            _Start(np.array([*(axis * width * toward), _END_GRAIN, 0.0, spacing]), end_grain, -np.sign(axis))
            for axis in _AXES
        ]
    sides = [(axis, -np.sign(axis)) for axis in _AXES]
    if grain.folded:
        sides += [(axis, sense) for axis in _MIDDLES for sense in (-1.0, 1.0)]
    return [
        _Start(np.array([axis * width, 0.0, tilt, turn, spacing]), np.full(GEOMETRY, True), sense)
        for axis, sense in sides
        for tilt in _TILTS
    ]


def _across(grain: Grain) -> float:
    """Across the rings, so that their count rises along (cos, sin)."""
    down, right = (float(slope.mean()) for slope in np.gradient(grain.rings))
    if grain.across is None:
        return float(np.arctan2(down, right))
    rises = np.cos(grain.across) * right + np.sin(grain.across) * down >= 0
    return grain.across if rises else grain.across + np.pi


def _count_from(rings: Floats, sense: float) -> Floats:
    """The rings counted outwards; counted the other way, late wood still lies before the whole number."""
    return rings if sense > 0 else 0.5 - rings


def _solve(grain: Grain, start: _Start, independent: float, begin: float | None = None) -> _End:
    """Where a start ends; the count begins at ``begin``, or wherever fits best."""
    height, width = grain.rings.shape
    near = np.s_[_STEP // 2 :: _STEP, _STEP // 2 :: _STEP]
    seen = _count_from(grain.rings, start.sense)[near].ravel()
    size = 2 / max(height, width)
    loose = np.append(start.loose, begin is None)
    scale = np.array([1.0, 1.0, size, size, size, 1 / grain.spacing]) * loose
    with jax.enable_x64():
        plank = Plank(*(jnp.asarray(each.ravel()) for each in lay_plank(height, width, _STEP)))
        if begin is None:
            begin = float(np.median(seen - np.asarray(ring_count(jnp.asarray(start.free), plank))))
        fibres = 0.0 if grain.across is None else np.sqrt(len(seen) / independent) / _ROTATION
        problem = _Problem(
            start=jnp.asarray([*start.free, begin]),
            scale=jnp.asarray(scale),
            plank=plank,
            seen=jnp.asarray(seen),
            weight=jnp.asarray(grain.clear[near].ravel().astype(float)),
            turn=jnp.asarray(start.free[3] if grain.across is None else _across(grain)),
            stiff=jnp.asarray(fibres * grain.spacing / max(height, width)),
        )
        vector, cost, curvature = jax.device_get(_least_squares(problem))
    cost = float(cost) if np.isfinite(vector).all() else np.inf
    return _End(np.asarray(vector), cost, np.asarray(curvature), start)


def _settle(grain: Grain, end: _End, independent: float, held: Held) -> CountedRings:
    """From where the count begins to whole rings: the remainder is for the axis to take up."""
    begin, bent = float(np.round(end.vector[5])), bool(end.start.free[2])
    free = end.vector[:GEOMETRY].copy()
    if bent:
        end = _solve(grain, end.start._replace(free=free), independent, begin)
        free = end.vector[:GEOMETRY]
    elif 0 not in held:
        free[0] -= end.start.sense * (end.vector[5] - begin) * np.exp(free[4])
    spread = np.asarray(np.linalg.pinv(end.curvature, hermitian=True), float) * end.cost / independent
    covariance = spread[:GEOMETRY, :GEOMETRY]
    if grain.across is None:
        # That it is end grain was seen by the lack of fibres; around the axis it looks the same however it is turned.
        covariance[2, 2], covariance[3, 3] = _END_GRAIN_TILT**2, np.inf
    if grain.pith is not None:
        covariance[0, 0] = covariance[1, 1] = (_PITH * min(grain.rings.shape)) ** 2
    if not bent:
        covariance[np.arange(3), np.arange(3)] = np.inf
    return CountedRings(free, covariance, _count_from(grain.followed, end.start.sense) - begin)


@jax.jit
def _least_squares(problem: _Problem) -> tuple[Array, Array, Array]:
    """The vector (6,), the cost, and the curvature (6, 6) in the vector's own units."""
    answer: optx.Solution = optx.least_squares(
        _residuals, _SOLVER, jnp.zeros_like(problem.start), problem, max_steps=60, throw=False
    )
    residuals = _residuals(answer.value, problem)
    rows = jax.jacfwd(_residuals)(answer.value, problem) / jnp.where(problem.scale > 0, problem.scale, jnp.inf)[None]
    return problem.start + answer.value * problem.scale, jnp.sum(residuals**2), rows.T @ rows


def _residuals(step: Array, problem: _Problem) -> Array:
    vector = problem.start + step * problem.scale
    aside = (ring_count(vector[:GEOMETRY], problem.plank) + vector[GEOMETRY] - problem.seen) * problem.weight
    aside = aside * jax.lax.rsqrt(1.0 + (aside / _OUTLIER) ** 2)
    # What is held costs a little to move: it makes no difference, and leaves no direction without a slope.
    idle = 1e-3 * step * (problem.scale == 0)
    return jnp.concatenate([aside, problem.stiff * (vector[3:4] - problem.turn), idle])
