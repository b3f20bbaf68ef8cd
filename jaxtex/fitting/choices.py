"""Parameters that the user holds or starts by hand."""

from collections.abc import Mapping

import numpy as np

from jaxtex.core.errors import InputError
from jaxtex.fitting.parameters import place, read_free, to_free
from jaxtex.fitting.start import Start
from jaxtex.models.tiling import Tiling

CHOOSABLE = ("tile_width", "tile_height", "angle_deg", "mortar_x", "mortar_y", "offset", "origin_x", "origin_y")
_POSITIVE = ("tile_width", "tile_height")
_LENGTHS = ("tile_width", "tile_height", "mortar_x", "mortar_y")


def check_choices(fix: Mapping[str, float], init: Mapping[str, float], size: tuple[int, int]) -> None:
    """Refuse parameters that do not exist, values out of range in a photograph of ``size`` (width, height), and
    parameters both held and started."""
    for name, value in [*fix.items(), *init.items()]:
        if name not in CHOOSABLE:
            raise InputError(f"there is no parameter {name!r} to choose; there are {', '.join(CHOOSABLE)}")
        if not isinstance(value, int | float | np.number):
            raise InputError(f"{name}={value!r} is not a number")
        if not np.isfinite(value):
            raise InputError(f"{name}={value} is not a finite number")
        if name in _POSITIVE and value < 4:
            raise InputError(f"{name}={value:g} is too small; tiles are at least 4 pixels long and high")
        if name in ("mortar_x", "mortar_y") and value < 0:
            raise InputError(f"{name}={value:g} is negative; joints are 0 pixels thick or more")
        if name in _LENGTHS and value > 2 * max(size):
            raise InputError(
                f"{name}={value:g} is more than twice the photograph, which has {size[0]} x {size[1]} pixels"
            )
    both = sorted(set(fix) & set(init))
    if both:
        raise InputError(f"{both[0]} is both fixed and started by hand; choose one of the two")


def check_joints(tiling: Tiling, fix: Mapping[str, float]) -> None:
    """Refuse joints held so thick that they leave nothing of the tiles that were found."""
    sides = {"mortar_x": tiling.tile_width * np.min(tiling.course_lengths), "mortar_y": tiling.tile_height}
    for name, side in sides.items():
        if name in fix and fix[name] >= side:
            raise InputError(f"{name}={fix[name]:g} leaves nothing of tiles of {float(side):.1f} pixels")


def apply_choices(start: Start, size: tuple[int, int], fix: Mapping[str, float], init: Mapping[str, float]) -> Start:
    """A start with the user's values, given in pixels of the photograph of ``size`` (width, height)."""
    if not fix and not init:
        return start
    scale = max(start.size) / max(size)
    values, offsets = read_free(start.free)
    moving = start.moving.copy()
    for name, value in [*init.items(), *fix.items()]:
        inner = "angle" if name == "angle_deg" else name
        if name == "angle_deg":
            # Of the two senses of one direction, the one the start was read in.
            value = np.radians(value)
            value += np.pi * np.round((values["angle"] - value) / np.pi)
        elif name in _LENGTHS:
            value *= scale
        elif name.startswith("origin"):
            value = value * scale - start.size[name == "origin_y"] / 2
        values[inner] = float(value)
        if name in fix:
            moving[place(inner)] = 0.0
    free = to_free(values, offsets)
    return start._replace(free=free, first=free, moving=moving)
