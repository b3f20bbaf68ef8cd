"""Maps of likely joints -> families of parallel, evenly spaced courses, also seen in perspective.

The spectrum of a tiling peaks where the courses repeat (Lefebvre & Poulin 2000, section 2.1, equations 1 and 2). An
oblique view smears that peak; but among all views of the plane the one that undoes the perspective gathers it again. So
the search runs over the two numbers of perspective and keeps the sharpest peaks. Shear does not blur courses, and is
left to the scanlines.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import fft, ndimage

from jaxtex.photo.peaks import parabola_top

Map = NDArray[np.float32]
Array = NDArray[np.float64]

_SIZE = 128  # longer side of the map that is searched
_BOX = 256  # side of the transform: room for the picture seen straight, and half-bin steps in frequency
_HARMONICS = 4
_UPRIGHT = 0.1  # sine of how far from upright two directions of a tiling may be seen
_FEWEST, _MOST = 2.2, 40.0  # courses along the longer side
# Strongest perspective tried: the scale changes by these factors from the centre to the ends of the longer side.
_TILTS = np.linspace(-0.6, 0.6, 9)


class Courses(NamedTuple):
    """A family of courses, in pixels of the map it was found in, relative to the map's centre.

    ``tilt`` (2,): plane point p = x / (1 + tilt . x) for image point x, both from the centre. ``angle``: direction of
    the courses in the plane, radians. ``height``: their pitch. ``strength``: share of the map's energy that repeats
    with them. ``evidence``: name of the map.
    """

    tilt: NDArray[np.float64]
    angle: float
    height: float
    strength: float
    evidence: str


def all_views(perspective: bool) -> list[Array]:
    """Views to search, as the tilt times half the longer side: straight on first, then, if wanted, all oblique ones."""
    oblique = [np.array([x, y]) for x in _TILTS for y in _TILTS if 0 < np.hypot(x, y) <= 0.75]
    return [np.zeros(2), *(oblique if perspective else [])]


def find_courses(joints: dict[str, Map], *, views: list[Array], per_map: int = 2, most: int = 12) -> list[Courses]:
    """Likely course families in maps of joints (all H, W), the strongest first, near-duplicates left out.

    The best of the ``views`` is kept beside the straight one, never instead of it, because only the full fit can tell
    them apart when courses are few.
    """
    found: list[Courses] = []
    small = {name: _reduce(whole) for name, whole in joints.items()}
    shape = next(iter(small.values())).shape
    scale = max(shape) / max(next(iter(joints.values())).shape)
    rays = [_trace(shape, view) for view in views]
    for name, reduced in small.items():
        if np.ptp(reduced) > 0:
            found += _search_map(name, reduced, scale, rays, per_map)
    found.sort(key=lambda courses: -courses.strength)
    kept: list[Courses] = []
    extent = max(next(iter(joints.values())).shape)
    for courses in found:
        if not any(same_courses(courses, other, extent) for other in kept):
            kept.append(courses)
    return kept[:most]


class _Rays(NamedTuple):
    """What a ``view`` of the plane sees of a map: sample n of the transform's box, ``at`` (N,), is a mean of four
    pixels, ``pixels`` (4, N) by ``shares`` (4, N), counted along the flattened box and map; ``taper`` (N,) falls to
    nought at the map's border."""

    view: Array
    at: NDArray[np.intp]
    pixels: NDArray[np.intp]
    shares: Map
    taper: Map


def _trace(shape: tuple[int, int], view: Array) -> _Rays:
    height, width = shape
    tilt = view / (_SIZE / 2)
    p = np.arange(_BOX) + 0.5 - _BOX / 2
    depth = 1.0 - (tilt[0] * p[None, :] + tilt[1] * p[:, None])
    depth = np.where(depth > 0.3, depth, np.inf)
    x, y = p[None, :] / depth, p[:, None] / depth
    inside = (np.abs(x) < width / 2) & (np.abs(y) < height / 2) & np.isfinite(depth)
    x, y = x[inside], y[inside]
    taper = (np.cos(np.pi * x / width) * np.cos(np.pi * y / height)) ** 2
    column, row = (np.clip(v + n / 2 - 0.5, 0, n - 1.001) for v, n in ((x, width), (y, height)))
    left, top = column.astype(np.intp), row.astype(np.intp)
    pixels = top * width + left + np.array([[0], [1], [width], [width + 1]])
    right, down = column - left, row - top
    shares = np.stack([(1 - right) * (1 - down), right * (1 - down), (1 - right) * down, right * down])
    return _Rays(view, np.flatnonzero(inside), pixels, shares.astype(np.float32), taper.astype(np.float32))


def _search_map(name: str, small: Map, scale: float, rays: list[_Rays], per_map: int) -> list[Courses]:
    """Course families of one map, reduced by ``scale``; the first of the views is the straight one."""
    scored = [(_find_peaks(_power(small, each), 1)[0], each) for each in rays]
    best_peak, best = max(scored, key=lambda item: item[0][0])
    kept = [rays[0]]
    if best_peak[0] > 1.1 * scored[0][0][0]:
        kept.append(_refine_view(small, best))
    found = []
    for each in kept:
        tilt = each.view / (_SIZE / 2)
        for strength, fx, fy in _find_peaks(_power(small, each), per_map):
            # The frequency points across the courses; any of its two senses will do.
            angle = np.arctan2(fy, fx) - np.pi / 2
            height = _BOX / np.hypot(fx, fy) / scale
            found.append(Courses(tilt * scale, float(angle), float(height), strength, name))
    return found


def _refine_view(small: Map, best: _Rays) -> _Rays:
    """Climb to the view of the sharpest peak by halving steps around the best of the coarse search."""
    step = (_TILTS[1] - _TILTS[0]) / 2
    score = _find_peaks(_power(small, best), 1)[0][0]
    for _ in range(3):
        turns = [np.array([x, y]) for x in (-1, 0, 1) for y in (-1, 0, 1) if x or y]
        around = [_trace(small.shape, best.view + step * turn) for turn in turns]
        scores = [_find_peaks(_power(small, each), 1)[0][0] for each in around]
        if max(scores) > score:
            best, score = around[int(np.argmax(scores))], max(scores)
        step /= 2
    return best


def _reduce(whole: Map) -> Map:
    scale = min(1.0, _SIZE / max(whole.shape))
    if scale == 1.0:
        return whole
    smooth = ndimage.gaussian_filter(whole, 0.4 / scale)
    shape = [max(round(n * scale), 2) for n in whole.shape]
    zoom = [n / m for n, m in zip(shape, whole.shape, strict=True)]
    return ndimage.zoom(smooth, zoom, order=1, grid_mode=True, mode="nearest")


def _power(small: Map, rays: _Rays) -> Map:
    """Power spectrum (BOX, BOX // 2 + 1) of the map as the plane shows it, tapered in the picture, unit energy."""
    values = (np.take(small.ravel(), rays.pixels) * rays.shares).sum(0)
    box = np.zeros(_BOX * _BOX, np.float32)
    box[rays.at] = (values - np.average(values, weights=rays.taper)) * rays.taper
    power = np.abs(fft.rfft2(box.reshape(_BOX, _BOX))) ** 2
    # Columns other than the first stand for two frequencies each.
    return power / max(float(power.sum() - 0.5 * power[:, 0].sum()), 1e-30)


def _comb_frequencies() -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Half-plane of frequencies (fy, fx) in bins, from the fewest to the most courses."""
    most = int(_MOST * _BOX / _SIZE)
    fy, fx = np.mgrid[-most : most + 1, 0 : most + 1]
    radius = np.hypot(fy, fx)
    wanted = (radius >= _FEWEST * _BOX / _SIZE) & (radius <= most) & ~((fx == 0) & (fy < 0))
    return fy[wanted], fx[wanted]


_FY, _FX = _comb_frequencies()


def _find_peaks(power: Map, count: int) -> list[tuple[float, float, float]]:
    """The ``count`` strongest (strength, fx, fy): energy at a frequency and its harmonics, with sub-bin position.

    If more than one is wanted, also the strongest across the first.
    """
    comb = np.zeros(_FY.shape, np.float32)
    for k in range(1, _HARMONICS + 1):
        fy, fx = k * _FY, k * _FX
        inside = (np.abs(fy) < _BOX // 2) & (fx <= _BOX // 2)
        comb += np.where(inside, power[fy % _BOX, np.minimum(fx, _BOX // 2)], 0.0)
    peaks: list[tuple[float, float, float]] = []

    def take(candidates: NDArray[np.float32]) -> None:
        best = int(np.argmax(candidates))
        fy, fx = int(_FY[best]), int(_FX[best])
        peaks.append((float(comb[best]), fx + _vertex(power, fy, fx, 1), fy + _vertex(power, fy, fx, 0)))
        comb[np.hypot(_FY - fy, _FX - fx) < 4] = 0.0

    for _ in range(count):
        take(comb)
    if count > 1:
        # Narrow tiles repeat more strongly along the courses than across: the other direction is always worth a look.
        _, x, y = peaks[0]
        across = np.abs(_FX * x + _FY * y) < _UPRIGHT * np.hypot(_FX, _FY) * np.hypot(x, y)
        take(np.where(across, comb, 0.0))
    return peaks[:count] + [peak for peak in peaks[count:] if peak[0] > 0]


def _vertex(power: Map, fy: int, fx: int, axis: int) -> float:
    """Offset in bins, within +-1/2, of the parabola's top through a bin and its neighbours along one axis."""

    def log_power(y: int, x: int) -> float:
        # Negative fx mirrors through the origin: the transform of a real map.
        y, x = (y, x) if x >= 0 else (-y, -x)
        return float(np.log(power[y % _BOX, min(x, _BOX // 2)] + 1e-12))

    return float(parabola_top(*(log_power(fy + d * (axis == 0), fx + d * (axis == 1)) for d in (-1, 0, 1))))


def same_courses(a: Courses, b: Courses, extent: int, *, slack: float = 1.0) -> bool:
    """Whether two families cannot be told apart over a picture of this extent; ``slack`` below 1 asks for closer
    agreement than the spectrum's own precision."""
    turn = abs((a.angle - b.angle + np.pi / 2) % np.pi - np.pi / 2)
    per_picture = extent / a.height
    tilt = np.abs(a.tilt - b.tilt).max() * extent / 2
    return bool(
        turn * per_picture < 0.3 * slack and abs(per_picture - extent / b.height) < 0.6 * slack and tilt < 0.08 * slack
    )
