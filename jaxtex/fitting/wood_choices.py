"""Parameters of wood that the user holds, as numbers of the vector that is fitted."""

import math
from collections.abc import Mapping

import numpy as np

from jaxtex.core.errors import InputError
from jaxtex.fitting.rings import GEOMETRY, Held

# Place in the vector, least, most, and what is asked for.
_PLACES = {
    "xc": (0, -math.inf, math.inf, "pixels"),
    "yc": (1, -math.inf, math.inf, "pixels"),
    "tilt_deg": (2, 0.0, 90.0, "degrees"),
    "rotation_deg": (3, 0.0, 180.0, "degrees"),
    "ring_spacing": (4, 2.0, math.inf, "pixels"),
    "early_fraction": (GEOMETRY, 0.02, 0.98, "a share"),
}


def hold_wood(
    fix: Mapping[str, float], ellipse_center: tuple[float, float] | None, *, shape: tuple[int, ...], scale: float
) -> tuple[Held, tuple[float, float] | None]:
    """What is held, and where ellipses have their middle (u, v), in pixels that are ``scale`` times as large as those
    of a photograph of a ``shape`` (H, W).

    Raises:
        InputError: an unknown parameter, a value out of range, or both the ellipses' middle and the axis.
    """
    held: dict[int, float] = {}
    for name, value in fix.items():
        if name not in _PLACES:
            raise InputError(f"{name}: no such parameter can be held; there are {', '.join(_PLACES)}")
        place, low, high, unit = _PLACES[name]
        high = min(high, float(max(shape))) if name == "ring_spacing" else high
        if not (math.isfinite(value) and low <= value <= high):
            raise InputError(f"{name} is {value:g}; give {unit} from {low:g} to {high:g}")
        held[place] = value
    if ellipse_center is None:
        return {place: _to_vector(place, value, scale) for place, value in held.items()}, None
    if {0, 1} & held.keys():
        raise InputError("the ellipses' middle and xc, yc say the same; give one of them")
    height, width = shape
    x, y = ellipse_center
    if not (0 <= x <= width and 0 <= y <= height):
        raise InputError(f"the ellipses' middle ({x:g}, {y:g}) is not in the picture of {width} x {height} pixels")
    middle = (x - width / 2) / scale, (y - height / 2) / scale
    return {place: _to_vector(place, value, scale) for place, value in held.items()}, middle


def _to_vector(place: int, value: float, scale: float) -> float:
    if place in (0, 1):
        return value / scale
    if place in (2, 3):
        return math.radians(value)
    if place == GEOMETRY:
        return math.log(value / (1 - value))
    return float(np.log(value / scale))
