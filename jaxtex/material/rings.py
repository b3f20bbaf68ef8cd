"""Rings of wood drawn over their photograph: one by one, so that they can be counted, or as outlines of early wood."""

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.material.overlay import paint_lines
from jaxtex.photo.pictures import check_picture

_LATE = 0.75  # the turn of each ring at which late wood has its middle
_EARLY = 0.25
_HEAVY = 5  # every so many rings a line is heavier
_COUNTED = np.array([1.0, 0.5, 0.0], np.float32)  # linear light: an amber, which no light line is mistaken for
_BREADTH = 1 / 700  # of a line, as a fraction of the picture's longer side
_ROOM = 0.2  # of the way from line to line: half a line is no broader
_FAINT = 0.3  # opacity of lines where the rings are not to be trusted
_LEVEL = 1e-6  # rings per pixel: a count that changes less does not change
_CROWDED = 10.0  # pixels from outline to outline: closer ones are drawn fainter, or nothing else were to be seen

Floats = npt.NDArray[np.float64]


def draw_rings(
    pixels: npt.ArrayLike, rings: npt.ArrayLike, *, clear: npt.ArrayLike | None = None
) -> npt.NDArray[np.float32]:
    """Draw a count of rings over a picture: a line along the late wood of each, every fifth heavier and of another
    colour.

    Args:
        pixels: linear light, [row, col] or [row, col, channel] with 1 or 3 channels.
        rings: how many rings lie further in, [row, col]; late wood has its middle at three quarters of each.
        clear: whether the count can be trusted, [row, col]; where not, lines are faint. By default it can everywhere.

    Returns:
        float32 [row, col, 3], linear light.

    Raises:
        InputError: no picture, or a count of another size.

    Examples:
        >>> count = np.broadcast_to(np.arange(60) / 20, (40, 60))
        >>> drawn = draw_rings(np.full((40, 60), 0.5), count)
        >>> np.flatnonzero(drawn[0, :, 0] < 0.1).tolist()
        [15, 35, 55]
    """
    shown, count, opacity = _prepare(pixels, rings, clear)
    line = np.round(count - _LATE)
    distance, apart = _measure(count - _LATE - line, count, spacing=1.0)
    heavy = (line + 1) % _HEAVY == 0
    half = 0.5 * _breadth(shown)
    light_ones, heavy_ones = np.where(heavy, np.inf, distance), np.where(heavy, distance, np.inf)
    paint_lines(shown, light_ones, np.minimum(half, _ROOM * apart), opacity=opacity)
    paint_lines(shown, heavy_ones, np.minimum(1.7 * half, 1.7 * _ROOM * apart), _COUNTED, opacity=opacity)
    return shown


def draw_early_wood(
    pixels: npt.ArrayLike, rings: npt.ArrayLike, early_fraction: float, *, clear: npt.ArrayLike | None = None
) -> npt.NDArray[np.float32]:
    """Draw the outlines of early wood, as a count of rings has it, over a picture.

    Args:
        pixels, rings, clear: as `draw_rings` takes them.
        early_fraction: share of early wood, around a quarter of each ring, 0 to 1.

    Returns:
        float32 [row, col, 3], linear light.

    Raises:
        InputError: as `draw_rings`.

    Examples:
        >>> count = np.broadcast_to(np.arange(60) / 20, (40, 60))
        >>> drawn = draw_early_wood(np.full((40, 60), 0.5), count, 0.4)
        >>> np.flatnonzero(drawn[0, :, 0] < 0.1).tolist()
        [1, 9, 21, 29, 41, 49]
    """
    shown, count, opacity = _prepare(pixels, rings, clear)
    aside = np.abs(count - _EARLY - np.round(count - _EARLY)) - 0.5 * early_fraction
    distance, apart = _measure(aside, count, spacing=min(early_fraction, 1.0 - early_fraction))
    opacity = opacity * np.clip(apart / _CROWDED, _FAINT, 1.0)
    paint_lines(shown, distance, np.minimum(0.4 * _breadth(shown), 0.5 * _ROOM * apart), opacity=opacity)
    return shown


def _prepare(
    pixels: npt.ArrayLike, rings: npt.ArrayLike, clear: npt.ArrayLike | None
) -> tuple[npt.NDArray[np.float32], Floats, Floats]:
    """A picture to paint on, the count, and how opaque lines are."""
    picture, count = check_picture(pixels), np.asarray(rings, dtype=float)
    trusted = np.ones(count.shape, bool) if clear is None else np.asarray(clear, dtype=bool)
    for name, each in (("rings", count), ("clear", trusted)):
        if each.shape != picture.shape[:2]:
            raise InputError(f"{name}: has the shape {each.shape}; it must be that of the picture, {picture.shape[:2]}")
    shown = np.repeat(picture, 3, axis=2) if picture.shape[2] == 1 else picture.copy()
    return shown, count, np.where(trusted, 1.0, _FAINT)


def _measure(aside: Floats, count: Floats, *, spacing: float) -> tuple[Floats, Floats]:
    """Pixels to where `aside`, in rings, is 0; and pixels to which `spacing` rings are stretched there."""
    down, right = np.gradient(count)
    rings_per_pixel = np.hypot(down, right)
    changing = np.maximum(rings_per_pixel, _LEVEL)
    # A count that stays the same has no lines, even where it is that of one.
    return np.where(rings_per_pixel < _LEVEL, np.inf, np.abs(aside) / changing), spacing / changing


def _breadth(shown: npt.NDArray[np.float32]) -> float:
    return max(1.4, _BREADTH * max(shown.shape[:2]))
