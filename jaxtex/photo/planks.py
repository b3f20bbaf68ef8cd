"""Photograph of a floor -> its planks: straight joints along the grain, and the ends between them.

A joint is straight over the whole floor, which rings and cracks are not: averaged along a few stretches of it, it is
still there in most of them.
"""

import itertools
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, signal

from jaxtex.photo.directions import main_direction, measure_directions

Array = NDArray[np.float64]

_FIBRES = 0.7 / 512  # of the picture's longer side: the scale at which fibres are seen
_FIBROUS = 0.3  # how clearly all fibres run one way, unless the floor is laid crosswise
_TURNS = np.radians(np.arange(-1.5, 1.51, 0.25))  # about the direction of the fibres
_FINER = 12  # times smaller, about the best of these
_BREADTH = 3 / 512  # of the longer side: twice that, at most, is a joint wide
_LEAST = 3  # pixels: the same
_STRETCHES, _ENDS = 12, 4  # into which joints and ends are divided
_SEEN = 0.4  # quantile of how clearly the stretches show a joint
_NEAR = 0.08  # of the longer side: what a joint must stand out from
_SURE = 15.0  # times the typical response
_WEAK = 0.35  # of the clearest joint: joints too
_FAINT = 1.0  # where even spacing expects a joint
_EVEN = 0.012  # of the span: how far evenly spaced joints stray
_NARROWEST = 0.02  # of the span


class Planks(NamedTuple):
    """``turn``: radians, across the planks is (cos, sin); ``joints``: their places across, pixels from the picture's
    middle; ``corners`` (N, 4, 2): each plank's, (x, y) from the picture's corner, in order around it; ``evidence``:
    how clearly the clearest joint stands out."""

    turn: float
    joints: Array
    corners: Array
    evidence: float


def find_planks(light: Array) -> Planks:
    """The planks of a picture's lightness (H, W), evened out; none where it shows no joints."""
    height, width = light.shape
    even = light / np.sqrt(ndimage.gaussian_filter(light**2, max(light.shape) / 10) + 1e-9)
    directions = measure_directions(even, max(0.7, _FIBRES * max(light.shape)))
    turn, fibrous = main_direction(directions)
    crosswise = fibrous < _FIBROUS
    if crosswise:
        # Grain runs both ways: at four times their angle these are the same.
        turn = float(np.angle((directions.across**2 / (np.abs(directions.across) + 1e-12)).sum()) / 4)
    turn = (turn + np.pi / 4) % np.pi - np.pi / 4
    turned, turn = _turn_straight(even, turn)
    joints, evidence = _find_lines(turned, _STRETCHES, _SURE, even=not crosswise)
    shared = _find_lines(turned.T, _STRETCHES, _SURE)[0] if crosswise else np.empty(0)
    corners = []
    for left, right in _between(joints, turned.shape[1]):
        ends = shared if crosswise else _find_lines(_strip(turned, left, right), _ENDS, 2 * _SURE)[0]
        corners += [_corners(left, right, top, end) for top, end in _between(ends, turned.shape[0])]
    middle = np.array([turned.shape[1] / 2, turned.shape[0] / 2])
    c, s = np.cos(turn), np.sin(turn)
    placed = (np.array(corners).reshape(-1, 4, 2) - middle) @ np.array([[c, s], [-s, c]]) + [width / 2, height / 2]
    return Planks(turn, joints - middle[0], placed, evidence)


def turn_picture(picture: Array, turn: float) -> Array:
    """A picture (H, W, ...) resampled so that the direction (cos, sin) lies along its rows; NaN beyond its border."""
    height, width = picture.shape[:2]
    c, s = np.cos(turn), np.sin(turn)
    across = 2 * int(0.5 * (abs(c) * width + abs(s) * height))
    along = 2 * int(0.5 * (abs(s) * width + abs(c) * height))
    x, y = np.meshgrid(np.arange(across) + 0.5 - across / 2, np.arange(along) + 0.5 - along / 2)
    place = [x * s + y * c + height / 2 - 0.5, x * c - y * s + width / 2 - 0.5]
    outside = (place[0] < -0.5) | (place[0] > height - 0.5) | (place[1] < -0.5) | (place[1] > width - 0.5)
    channels = picture.reshape(height, width, -1)
    turned = [
        ndimage.map_coordinates(channels[..., n], place, order=1, mode="nearest") for n in range(channels.shape[2])
    ]
    stacked = np.where(outside[..., None], np.nan, np.stack(turned, axis=-1))
    return stacked.reshape(*outside.shape, *picture.shape[2:])


def _turn_straight(even: Array, turn: float) -> tuple[Array, float]:
    """The picture with its joints upright, and the turn that does it: the one that shows them most sharply."""

    def sharpness(trial: float) -> float:
        response = _respond(turn_picture(even, trial), _STRETCHES, stray=0)
        return float((np.sort(response)[-len(response) // 25 :] ** 2).sum())

    best = max((turn + step for step in _TURNS), key=sharpness)
    best = max((best + step for step in _TURNS / _FINER), key=sharpness)
    return turn_picture(even, best), best


def _respond(turned: Array, stretches: int, *, stray: int) -> Array:
    """How clearly most stretches of each column (W,), give or take some pixels, differ from the columns beside it."""
    known = ~np.isnan(turned)
    light = np.where(known, np.clip(turned, -3, 3), 0.0)
    edges = np.linspace(0, len(turned), stretches + 1).astype(int)[:-1]
    count = np.add.reduceat(known.astype(float), edges, axis=0)
    mean = np.add.reduceat(light, edges, axis=0) / np.maximum(count, 1)
    breadth = 2 * max(_LEAST, int(_BREADTH * max(turned.shape))) + 1
    aside = ndimage.maximum_filter1d(
        np.abs(mean - ndimage.median_filter(mean, size=(1, breadth))), 2 * stray + 1, axis=1
    )
    whole = np.diff(np.append(edges, len(turned)))[:, None]
    aside = np.where(count > 0.5 * whole, aside, np.nan)
    empty = np.isnan(aside).all(0)
    return np.where(empty, 0.0, np.nanquantile(np.where(empty, 0.0, aside), _SEEN, axis=0))


def _find_lines(turned: Array, stretches: int, sure: float, *, even: bool = False) -> tuple[Array, float]:
    """Columns where straight lines run from top to bottom, and how clearly the clearest does.

    Where they are ``even`` but for gaps, fainter ones fill these.
    """
    span = turned.shape[1]
    response = _respond(turned, stretches, stray=1)
    above = response - ndimage.median_filter(response, 2 * int(0.5 * _NEAR * span) + 1)
    clear = above / (1.4826 * float(np.median(np.abs(above - np.median(above)))) + 1e-6)
    lines, found = signal.find_peaks(clear, height=_FAINT, distance=max(2, int(_NARROWEST * span)))
    # At the border a picture may end with a joint, which parts nothing.
    inner = (lines > _NARROWEST * span) & (lines < (1 - _NARROWEST) * span)
    lines, heights = lines[inner], found["peak_heights"][inner]
    evidence = float(heights.max(initial=0.0))
    if evidence < sure:
        return np.empty(0), evidence
    strong = lines[heights > _WEAK * evidence]
    return np.sort(_complete(strong, lines, span) if even else strong) + 0.5, evidence


def _complete(strong: NDArray[np.intp], lines: NDArray[np.intp], span: int) -> Array:
    """The strong lines, and where these are evenly spaced with gaps, fainter ones in the gaps."""
    gaps = np.sort(np.diff(strong))
    # Any lines at all are evenly spaced by a pitch as small as what they may stray.
    for pitch in gaps[gaps > 5 * _EVEN * span] if len(strong) > 2 else ():
        steps = (strong - strong[0]) / pitch
        number = np.round(steps)
        pitch, begin = np.polyfit(number, strong, 1) if np.ptp(number) > 0 else (float(pitch), float(strong[0]))
        even = begin + pitch * np.arange(np.ceil(-begin / pitch), np.floor((span - begin) / pitch) + 1)
        if np.abs(begin + pitch * number - strong).max() < _EVEN * span and len(even) > len(strong):
            nearest = [lines[np.argmin(np.abs(lines - place))] for place in even]
            close = [line for line, place in zip(nearest, even, strict=True) if abs(line - place) < _EVEN * span]
            filled = [float(line) for line in close if np.abs(strong - line).min() > _EVEN * span]
            return np.concatenate([strong.astype(float), filled])
    return strong.astype(float)


def _strip(turned: Array, left: float, right: float) -> Array:
    """What lies between two joints, turned on its side, without the joints themselves."""
    inset = 0.08 * (right - left)
    return turned[:, int(left + inset) : max(int(right - inset), int(left + inset) + 1)].T


def _between(lines: Array, span: int) -> list[tuple[float, float]]:
    """From line to line, and to the border; nothing too narrow for a plank."""
    ends = np.concatenate([[0.0], lines, [float(span)]])
    pairs = itertools.pairwise(ends)
    return [(float(low), float(high)) for low, high in pairs if high - low > _NARROWEST * span]


def _corners(left: float, right: float, top: float, end: float) -> list[list[float]]:
    return [[left, top], [right, top], [right, end], [left, end]]
