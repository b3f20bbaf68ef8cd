"""Where the rings of a plank may have their axis: the starts of a fit.

Two ways, one after the other. Local waves tell spacing, rotation, tilt and axis at once, as long as rings bend: their
outer products are smooth in all parameters, with none of the false minima that counting rings has. Where rings run
straight on both sides of the pith they do not tell on which side it lies; then all places in the picture are tried.
"""

from collections.abc import Iterator

import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jax import Array
from numpy.typing import NDArray
from scipy import ndimage

from jaxtex.fitting.rings import (
    GEOMETRY,
    Held,
    Plank,
    canonical_rings,
    hold,
    lay_plank,
    loosen,
    ring_count,
    square_waves,
    wave_squares,
)
from jaxtex.models.waves import cosine
from jaxtex.photo.grain import FINEST, LocalWaves, find_period, measure_waves

Floats = NDArray[np.float64]

_LEANS = (0.03, 0.15, 0.5, 0.93)  # sines of the tilt that fits begin at
_AXES = (-1.05, -0.35, 0.0, 0.35, 1.05)  # places of the axis across the grain, in picture widths
_MIDDLES = (-1.0, -0.35, 0.02, 0.35, 1.0)  # and of the ellipses' middle along it, in picture heights
_MOST = 3  # starts of each kind
_WORTH = 4.0  # times the least cost, and 1 more: starts that end higher are not worth following
_OUTLIER = 0.3  # of the squared frequency: pieces that differ by more count less and less
_APART = np.array([50.0, 50.0, 0.17, 0.17, 0.1])  # starts that differ by less end alike
_PITH_LEANS = (0.02, 0.06, 0.15, 0.3, 0.5, 0.75)
_MOST_AXES = 64  # to either side of the middle: so many places can be tried in the time there is
_PIECES = 64  # of a picture: their number is rounded up to a multiple of this
_POINTS = 12_288  # of the picture, on which places are compared
_BLOCKS = 8  # parts of the picture along a side, each coherent by itself

_SOLVER: optx.LevenbergMarquardt = optx.LevenbergMarquardt(rtol=1e-5, atol=1e-5)


def list_starts(rings: Floats, held: Held) -> Iterator[list[Floats]]:
    """Batches of starts, each a vector of `GEOMETRY` numbers, for a map of rings (H, W) of zero mean, best first."""
    period = find_period(rings)
    for finer in (1, 2):
        waves = measure_waves(rings, period, finer=finer)
        if len(waves.weight) < GEOMETRY:
            continue
        starts = read_waves(waves, rings.shape, held)
        if starts:
            yield starts
            yield scan_for_pith(rings, *_main_wave(waves), held)


def read_waves(waves: LocalWaves, shape: tuple[int, ...], held: Held) -> list[Floats]:
    """Starts whose local waves are those measured in a picture of ``shape`` (H, W)."""
    height, width = shape
    across, spacing = _main_wave(waves)
    begin = [
        hold(np.array([axis * width, lean * middle * height, np.arcsin(lean), across + turn, np.log(spacing)]), held)
        for turn in (0.0, np.pi / 2)
        for lean in _LEANS
        for axis in _AXES
        for middle in _MIDDLES
    ]
    scale = loosen([width, height * 0.5, 0.3, 0.3, 0.3], held)
    unit = spacing**2
    # How many pieces tell depends on the picture; few lengths share few compilations.
    place, wave, weight = (np.pad(each, [(0, -len(each) % _PIECES), *[(0, 0)] * (each.ndim - 1)]) for each in waves)
    with jax.enable_x64():
        plank = Plank(*(jnp.asarray(each) for each in place.T))
        seen = jnp.asarray(square_waves(jnp.asarray(wave))) * unit
        ends, costs = jax.device_get(
            _solve_waves(jnp.asarray(np.array(begin)), jnp.asarray(scale), plank, seen, jnp.asarray(weight), unit)
        )
    # Rings finer than pixels tell, or wider than the picture, are the way out of fits that find none.
    spaced = (np.log(FINEST) <= ends[:, 4]) & (ends[:, 4] <= np.log(max(shape)))
    costs = np.where(spaced & np.isfinite(costs), costs, np.inf)
    worth = [n for n in np.argsort(costs) if costs[n] <= _WORTH * costs.min() + 1.0 and spaced[n]]
    return _differing(ends[n] if held else canonical_rings(ends[n])[0] for n in worth)


def scan_for_pith(rings: Floats, across: float, spacing: float, held: Held) -> list[Floats]:
    """Starts with the axis inside the picture (H, W), ``across`` the grain (radians) and ``spacing`` being known."""
    height, width = rings.shape
    step = max(2, int(spacing / 6))
    smooth = ndimage.gaussian_filter(rings, step / 2)[step // 2 :: step, step // 2 :: step]
    u, v = lay_plank(height, width, step)
    rows, columns = (_BLOCKS * n // whole for n, whole in zip(np.indices(smooth.shape), smooth.shape, strict=True))
    few = _choose_few((_BLOCKS * rows + columns).ravel())
    reach = float(np.hypot(height, width)) / 2
    places = [
        hold(np.array([axis, lean * middle, np.arcsin(lean), across, np.log(spacing)]), held)
        for lean in _PITH_LEANS
        for middle in np.linspace(-reach, reach, 9)
        for axis in np.arange(-reach, reach, max(spacing / 3, reach / _MOST_AXES))
    ]
    # Their number depends on the spacing; few lengths share few compilations.
    places += places[:1] * (-len(places) % 2048)
    with jax.enable_x64():
        plank = Plank(*(jnp.asarray(each.ravel()[few]) for each in (u, v)))
        scores = jax.device_get(_score_places(jnp.asarray(np.array(places)), plank, jnp.asarray(smooth.ravel()[few])))
    return _differing(places[n] if held else canonical_rings(places[n])[0] for n in np.argsort(-scores))


@jax.jit
def _solve_waves(
    starts: Array, scale: Array, plank: Plank, seen: Array, weight: Array, unit: Array
) -> tuple[Array, Array]:
    """Where each of the starts (S, 5) ends (S, 5), and at what cost (S,)."""

    def solve(start: Array) -> tuple[Array, Array]:
        problem = (start, scale, plank, seen, weight, unit)
        answer: optx.Solution = optx.least_squares(
            _wave_residuals, _SOLVER, jnp.zeros_like(start), problem, max_steps=40, throw=False
        )
        residuals = _wave_residuals(answer.value, problem)
        return start + answer.value * scale, jnp.sum(residuals**2)

    return jax.lax.map(solve, starts)


def _wave_residuals(step: Array, problem: tuple[Array, Array, Plank, Array, Array, Array]) -> Array:
    start, scale, plank, seen, weight, unit = problem
    aside = (wave_squares(start + step * scale, plank) * unit - seen) * weight[:, None]
    return aside * jax.lax.rsqrt(1.0 + jnp.sum(aside**2, axis=1, keepdims=True) / _OUTLIER**2)


def _choose_few(blocks: NDArray[np.int_]) -> NDArray[np.int_]:
    """Numbers of as many points (blocks, N) of each block, by the block (P,) of every point."""
    random = np.random.default_rng(0)
    number = _POINTS // _BLOCKS**2
    places = [np.flatnonzero(blocks == block) for block in np.unique(blocks)]
    return np.array([random.choice(each, number, replace=len(each) < number) for each in places])


@jax.jit
def _score_places(places: Array, plank: Plank, rings: Array) -> Array:
    """How well rings around each of the places (S, 5) agree with a map (B, N), block by block of the picture."""

    def score(place: Array) -> Array:
        count = ring_count(place, plank)
        real, imaginary = (jnp.sum(rings * cosine(count - lag), axis=1) for lag in (0.0, 0.25))
        return jnp.sum(jnp.sqrt(real**2 + imaginary**2))

    return jax.lax.map(score, places, batch_size=16)


def _main_wave(waves: LocalWaves) -> tuple[float, float]:
    """Across the grain, radians: the mean of the waves' directions, their sense left aside; and pixels from ring to
    ring, where the plank cuts them most nearly at right angles."""
    x, y = waves.wave.T
    length = np.hypot(x, y)
    weight = waves.weight / length
    sure = waves.weight >= 0.5 * waves.weight.max()
    across = 0.5 * float(np.arctan2((weight * 2 * x * y).sum(), (weight * (x * x - y * y)).sum()))
    return across, 1 / float(np.quantile(length[sure], 0.8))


def _differing(candidates: Iterator[Floats]) -> list[Floats]:
    kept: list[Floats] = []
    for candidate in candidates:
        if all(np.abs((candidate - other)[:GEOMETRY] / _APART).max() > 1 for other in kept):
            kept.append(candidate)
        if len(kept) == _MOST:
            break
    return kept
