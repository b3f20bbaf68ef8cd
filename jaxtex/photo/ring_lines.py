"""The dark lines of late wood: how far apart they are, and which ring each place of the picture belongs to."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, signal

from jaxtex.photo.directions import Directions, measure_directions, smooth_along

Array = NDArray[np.float64]
Ray = tuple[Array, Array]  # rows and columns of points one pixel apart, across the grain

_EVEN = 0.78  # of the variance: what a threshold explains of two kinds of lines; of lines of all depths it is 0.75
_TWICE = 2.0  # as deep, at least, are lines of the deeper kind
_FAINT = 0.05  # standard deviations: shallower lines are noise
_VISIBLE = 0.5  # deep enough for a line to be seen, where all depths occur
_NEAREST = 0.4  # of the spacing, between lines
_SHALLOW = 0.02  # standard deviations: shallower lines are none, once averaged along the grain
_LATE = 0.75  # of a ring: where late wood has its middle, as the model counts
_TOGETHER = 0.6  # of the spacing: a Gaussian over which rings are moved together
_MOVES = 6
_ARC = 12.0  # pixels of a ring around the pith that are seen together
_FINE = 6.0  # pixels: rings around a pith in the picture are fine
_WEATHERED = 0.25  # deep enough on end grain, which is seldom planed
_SHORTEST = 20  # points on a ray


def even_out_rings(light: Array, spacing: float) -> Array:
    """Rings without what is slower or finer (H, W): zero mean and unit variance, place by place."""
    band = ndimage.gaussian_filter(light, max(0.12 * spacing, 0.7)) - ndimage.gaussian_filter(light, spacing)
    return band / np.sqrt(ndimage.gaussian_filter(band**2, 2 * spacing) + 1e-12)


def measure_spacing(light: Array, rays: Sequence[Ray], known: Directions | None = None) -> float:
    """Pixels from one dark line to the next, along rays across the grain of a picture (H, W), whose directions are
    measured where they are not ``known``.

    Where lines are of two kinds, deep and shallow, the deep ones are the rings; else all that a person would see.
    """
    if known is not None:
        band = light - ndimage.gaussian_filter(light, _FINE)
        depths, length = _find_depths(band, known, _ARC, rays)
        return length / max(int((depths > _WEATHERED).sum()), 1)
    depths, length = _find_depths(light, measure_directions(light, 2.0), 30.0, rays)
    deep = _count_deep(depths)
    if deep:
        return length / deep
    depths, length = _find_depths(light, measure_directions(light, 1.5), 12.0, rays)
    return length / max(int((depths > _VISIBLE).sum()), 1)


def count_lines(rings: Array, levels: Array, spacing: float) -> Array:
    """To which ring each place (H, W) belongs, whole at the inner end of its early wood.

    Rings, evened out (H, W), are averaged along the ``levels`` (H, W), pixels across the grain; the darkest lines of
    that, about a ``spacing`` apart, are where the count is a whole number and three quarters.
    """
    low = float(levels.min())
    number = (levels - low).astype(int).ravel()
    pixels = ndimage.gaussian_filter1d(np.bincount(number).astype(float), 1.0)
    profile = -ndimage.gaussian_filter1d(np.bincount(number, rings.ravel()), 1.0) / np.maximum(pixels, 1e-9)
    lines, depth = signal.find_peaks(profile, prominence=_SHALLOW, distance=max(_NEAREST * spacing, 1.0))
    deepest = np.argsort(-depth["prominences"])[: int(np.ceil(len(profile) / spacing))]
    if len(deepest) < 2:
        return levels / spacing
    kept = np.sort(lines[deepest]) + 0.5
    turn = np.arange(len(kept)) + _LATE
    reach = len(kept)
    place = np.concatenate([[kept[0] - spacing * reach], kept, [kept[-1] + spacing * reach]])
    return np.interp(levels - low, place, np.concatenate([[turn[0] - reach], turn, [turn[-1] + reach]]))


def follow_lines(rings: Array, count: Array, spacing: float) -> Array:
    """The count (H, W), moved place by place to where the rings, evened out (H, W), are seen.

    Multiplied by the count's own wave, they show by which part of a ring it is off. It is followed as far as places
    half a ``spacing`` away agree: what is finer than rings are wide is not a place where they lie.
    """
    reach = _TOGETHER * spacing
    for _ in range(_MOVES):
        turned = rings * np.exp(-2j * np.pi * (count - 0.25))
        mean = ndimage.gaussian_filter(turned.real, reach) + 1j * ndimage.gaussian_filter(turned.imag, reach)
        sure = np.minimum(np.abs(mean) / np.median(np.abs(mean)), 1.0)
        # Half a ring off may be either way: there the count stays, or it would tear.
        count = count + sure * np.sin(np.angle(mean)) / (2 * np.pi)
    return count


def _count_deep(depths: Array) -> int:
    """How many lines are deep, where they are of two kinds; else 0. The limit is Otsu's, found among the depths."""
    if len(depths) < 2:
        return 0
    ordered = np.sort(depths)
    number = np.arange(1, len(ordered))
    total = np.cumsum(ordered)
    low, high = total[:-1] / number, (total[-1] - total[:-1]) / number[::-1]
    share = number / len(ordered)
    between = share * (1 - share) * (high - low) ** 2
    best = int(np.argmax(between))
    two = between[best] > _EVEN * ordered.var() and high[best] > _TWICE * low[best]
    return len(ordered) - 1 - best if two else 0


def _find_depths(light: Array, directions: Directions, reach: float, rays: Sequence[Ray]) -> tuple[Array, int]:
    """Of all dark lines that the rays pass, in standard deviations of the picture nearby; and how long the rays are.

    What they pass is averaged over ``reach`` pixels along the grain.
    """
    height, width = light.shape
    inside = [
        np.stack([rows, columns])[:, (rows >= 0) & (rows <= height - 1) & (columns >= 0) & (columns <= width - 1)]
        for rows, columns in rays
    ]
    inside = [points for points in inside if points.shape[1] >= _SHORTEST]
    if not inside:
        return np.empty(0), 0
    smooth = smooth_along(light, directions, reach, at=np.concatenate(inside, axis=1))
    profiles = np.split(smooth, np.cumsum([points.shape[1] for points in inside])[:-1])
    depths = []
    for profile in profiles:
        near = ndimage.gaussian_filter1d(profile**2, max(light.shape) / 8) + 1e-12
        lines = ndimage.gaussian_filter1d(-profile / np.sqrt(near), 1.0)
        depths.append(signal.find_peaks(lines, prominence=_FAINT)[1]["prominences"])
    return np.concatenate(depths), len(smooth)
