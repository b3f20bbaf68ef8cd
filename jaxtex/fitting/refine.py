"""From the starts to one fitted tiling: coarse to fine, with the Bayesian information criterion as the judge.

Double precision is switched on here, and here only, for as long as a solve lasts.
"""

from collections.abc import Iterable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from jaxtex.fitting.outcome import tiling_seen
from jaxtex.fitting.parameters import SCALARS, VIEW, place, read_free, to_free
from jaxtex.fitting.solve import Observation, Problem, solve_one
from jaxtex.fitting.start import Fitted, Start
from jaxtex.fitting.verdict import find_wrong_sizes
from jaxtex.fitting.wrap import repeat_with_picture
from jaxtex.photo.lattice import MEASUREMENTS

Array = NDArray[np.float64]

# Most pixels used by a solve, from coarse to fine: few sizes, so that pictures of all sizes share compilations.
_BUDGETS = (1 << 12, 1 << 14, 1 << 16)
# A seamless picture's own period is believed unless it explains the mask worse than this ratio of squared residuals.
_REPEATS = 1.2
# The likeliest lattice of a mask is taken without a look at others if fewer joints than this are out of place in it,
# and if less than this of the map's variance is left.
_CERTAIN, _UNEXPLAINED = 0.05, 0.35
# Shares of joints missing, and of tiles split in the middle, that a right lattice may have; and what each further share
# adds to the criterion of a wrong one.
_MISSING, _SPLIT, _DOUBT = 0.2, 0.25, 3.0


def refine_coarsely(starts: list[Start], joint: NDArray[np.float32], *, sharp: bool) -> list[Fitted]:
    """Where several starts end on a blurred map of joints (H, W) of the working picture, best first.

    ``sharp``: the map is a mask whose borders are where they should be to the pixel, and its errors come pixel by
    pixel. A first start that is certain then ends the search.
    """
    if not starts:
        return []
    pitch = min(shortest_pitch(start) for start in starts)
    blur = float(np.clip(0.08 * pitch, 1.5, 6.0))
    seen = observe(joint, starts[0].size, blur=blur, tolerance=0.5, budget=_BUDGETS[_level(joint) - 1])
    ended: list[Fitted] = []
    for start in starts:
        ended.append(_doubt(refine(start, seen), joint))
        if sharp and is_certain(ended):
            break
    return sorted(ended, key=lambda fitted: fitted.criterion)


def is_certain(ended: list[Fitted]) -> bool:
    """Whether the first explains the map, and nearly every joint of it is where it should be."""
    return bool(ended) and ended[0].doubt < _CERTAIN and ended[0].unexplained < _UNEXPLAINED


def refine_finely(
    ended: list[Fitted], joint: NDArray[np.float32], *, wraps: tuple[bool, bool] = (False, False), sharp: bool = False
) -> Fitted:
    """The best of several ends of the coarse level, carried on to the map of joints (H, W) as it is.

    ``wraps``: whether the picture is seamless in x and y. ``sharp``: see :func:`refine_coarsely`; the last solve then
    uses every pixel as it is.
    """
    budget = _BUDGETS[_level(joint)]
    blur = float(np.clip(0.04 * shortest_pitch(ended[0].start), 0.8, 1.5))
    seen = observe(joint, ended[0].start.size, blur=blur, tolerance=0.3, budget=budget)
    # Only ends that the coarse level can hardly tell apart are worth the fine one.
    close = [fitted for fitted in ended[:2] if fitted.criterion < ended[0].criterion + 0.1]
    best = _best(_doubt(_go_on(fitted, seen), joint) for fitted in close)
    best = best._replace(criterion=criterion(best.mean_square, best.start))
    repeated = _repeat(best, seen, wraps)
    best = repeated if repeated is not None else _choose_view(_choose_bond(best, seen), seen)
    if sharp and joint.size <= budget:
        best = _go_on(best, observe(joint, best.start.size, blur=0.0, tolerance=1.0, budget=budget))
    return best


def refine_again(fitted: Fitted, joint: NDArray[np.float32]) -> Fitted:
    """The same fit carried on to a better map of joints (H, W), whose thickness is right already."""
    level = _level(joint)
    blur = float(np.clip(0.02 * shortest_pitch(fitted.start), 0.8, 1.5))
    values = read_free(fitted.free)[0]
    held = {name: values[name] for name in ("mortar_x", "mortar_y")}
    seen = observe(joint, fitted.start.size, blur=blur, tolerance=0.5, budget=_BUDGETS[level])
    again = _go_on(fitted, seen, **held)
    thickness = [place(name) for name in held]
    variance = again.variance.copy()
    variance[thickness] = fitted.variance[thickness]
    return again._replace(variance=variance)


def _level(joint: NDArray[np.float32]) -> int:
    """Which of the budgets lets the last solve see every pixel, or nearly."""
    return next((n for n in (1, 2) if joint.size <= _BUDGETS[n]), 2)


def refine(start: Start, seen: Observation) -> Fitted:
    """One solve from one start."""
    with jax.enable_x64():
        problem = Problem(
            free=jnp.asarray(start.free, float),
            scale=jnp.asarray(start.scale, float),
            moving=jnp.asarray(start.moving, float),
            centre=jnp.asarray(np.asarray(start.size) / 2, float),
            course_lengths=jnp.asarray(start.course_lengths, float),
            observation=Observation(*(jnp.asarray(part, float) for part in seen)),
        )
        solution = jax.device_get(solve_one(problem))
    free = np.asarray(solution.free)
    # A picture of which nothing is known is explained by nothing.
    mean_square = float(solution.cost) / int(solution.count) if solution.count else np.inf
    unexplained = mean_square / max(float(np.var(seen.joint[seen.weight > 0])), 1e-12) if solution.count else np.inf
    return Fitted(free, np.asarray(solution.variance), start, criterion(mean_square, start), mean_square, unexplained)


def criterion(mean_square: float, start: Start) -> float:
    """Bayesian information criterion of a fit with this mean squared residual, per measurement."""
    return float(np.log(max(mean_square, 1e-12)) + start.moving.sum() * np.log(MEASUREMENTS) / MEASUREMENTS)


def observe(
    joint: NDArray[np.float32], size: tuple[float, float], *, blur: float, tolerance: float, budget: int
) -> Observation:
    """At most ``budget`` points of a map (H, W) that stands for a picture of ``size`` (width, height) pixels."""
    height, width = joint.shape
    smooth = ndimage.gaussian_filter(np.asarray(joint, float), blur, mode="nearest", truncate=4.0)
    stride = int(np.ceil(np.sqrt(height * width / budget)))
    while len(range(stride // 2, height, stride)) * len(range(stride // 2, width, stride)) > budget:
        stride += 1
    rows, columns = np.mgrid[stride // 2 : height : stride, stride // 2 : width : stride]
    x = (columns.ravel() + 0.5) * (size[0] / width)
    y = (rows.ravel() + 0.5) * (size[1] / height)
    # Beyond the border the blur had to guess.
    margin = 1.5 * blur
    known = (x > margin) & (y > margin) & (x < size[0] - margin) & (y < size[1] - margin)
    extra = budget - len(x)
    # A pixel is itself a blur: a box of unit variance 1/12.
    parts: dict[str, Any] = {
        "points": np.pad(np.stack([x, y], 1), ((0, extra), (0, 0))),
        "joint": np.pad(smooth[rows, columns].ravel(), (0, extra)),
        "weight": np.pad(known.astype(float), (0, extra)),
        "blur": np.sqrt(blur**2 + 1 / 12),
        "tolerance": np.asarray(tolerance),
    }
    return Observation(**parts)


def shortest_pitch(start: Start) -> float:
    """The shortest side of a tile, in pixels."""
    width, height = np.exp(start.free[place("tile_width")]), np.exp(start.free[place("tile_height")])
    return float(min(width * start.course_lengths.min(), height))


def _doubt(fitted: Fitted, joint: NDArray[np.float32]) -> Fitted:
    """Put back what takes two tiles for one, or one for two.

    The criterion alone forgives joints too many or too few where they are faint, or hidden among few others.
    """
    rows, columns = joint.shape
    missing, split = find_wrong_sizes(tiling_seen(fitted.free, fitted.start, (columns, rows)), joint)
    doubt = max(missing - _MISSING, 0.0) + max(split - _SPLIT, 0.0)
    return fitted._replace(criterion=fitted.criterion + _DOUBT * doubt, doubt=missing + split)


def _best(candidates: Iterable[Fitted]) -> Fitted:
    return min(candidates, key=lambda fitted: fitted.criterion)


def _go_on(fitted: Fitted, seen: Observation, **held: float) -> Fitted:
    """Solve again from where a solve ended, with some parameters now held at natural values."""
    values, offsets = read_free(fitted.free)
    moving = fitted.start.moving.copy()
    moving[[place(name) for name in held]] = 0.0
    free = np.where(np.isin(SCALARS + ("",) * len(offsets), list(held)), to_free(values | held, offsets), fitted.free)
    return refine(fitted.start._replace(free=free, moving=moving), seen)


def _repeat(fitted: Fitted, seen: Observation, wraps: tuple[bool, bool]) -> Fitted | None:
    """The fit that repeats with a seamless picture, if it explains the mask about as well."""
    values = read_free(fitted.free)[0]
    start = fitted.start
    if not any(wraps) or any(values[name] for name in VIEW):
        return None
    period = repeat_with_picture(values, start.size, wraps, start.kind)
    names = ("tile_width", "tile_height", "angle", "offset")
    free = names if start.kind == "regular" else names[:3]
    if period is None or not all(start.moving[place(name)] for name in free):
        return None
    repeated = _go_on(fitted, seen, **{name: period[name] for name in names})
    return repeated if repeated.mean_square < _REPEATS * fitted.mean_square else None


def _choose_view(fitted: Fitted, seen: Observation) -> Fitted:
    """Let perspective and shear move where they were held, and keep that only if the criterion says so."""
    view = [place(name) for name in VIEW]
    if not fitted.start.perspective or fitted.start.moving[view].any():
        return fitted
    moving = fitted.start.moving.copy()
    moving[view] = 1.0
    return _best([fitted, refine(fitted.start._replace(free=fitted.free, moving=moving), seen)])


def _choose_bond(fitted: Fitted, seen: Observation) -> Fitted:
    """Hold the offset at none or a half if the criterion finds that as good as a free one."""
    at = place("offset")
    half = np.round(2 * fitted.free[at]) / 2
    if fitted.start.kind != "regular" or not fitted.start.moving[at] or abs(fitted.free[at] - half) > 0.06:
        return fitted
    return _best([fitted, _go_on(fitted, seen, offset=float(half))])
