"""What a seamless picture adds: its tiling must repeat with it."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_NEAR_WHOLE = 0.12  # tiles: further from a whole number of tiles per picture than this is no repetition
_SAME_OFFSET = 0.01  # tiles


def repeat_with_picture(
    values: dict[str, float], size: tuple[float, float], wraps: tuple[bool, bool], kind: str
) -> dict[str, float] | None:
    """The pitches, angle and offset nearest to ``values`` for which the picture's repetition is the tiling's too.

    The tiling repeats along a = (one period along a course) and b = (one or two courses across); the picture repeats
    along its sides. So each side must be a whole combination of a and b, which fixes them exactly. Where the tiles of
    the courses do not come out even, at least the courses must. None where no side comes near to that.
    """
    direction = np.array([np.cos(values["angle"]), np.sin(values["angle"])])
    across = np.array([-direction[1], direction[0]])
    period = 1.5 if kind == "flemish" else 1.0
    courses = 2 if kind == "english" else 1
    a = period * values["tile_width"] * direction
    b = courses * (values["tile_height"] * across + values["offset"] * values["tile_width"] * direction)
    sides = [np.array(side) for side, wrapping in zip(((size[0], 0.0), (0.0, size[1])), wraps, strict=True) if wrapping]
    counts = np.array([np.linalg.solve(np.stack([a, b], 1), side) for side in sides])
    whole = np.round(counts)
    if np.abs(counts - whole)[:, 1].max() > _NEAR_WHOLE:
        return None
    if kind == "irregular" or np.abs(counts - whole)[:, 0].max() > _NEAR_WHOLE:
        whole[:, 0] = counts[:, 0]
    basis = np.stack([a, b])
    basis = basis + np.linalg.pinv(whole) @ (np.array(sides) - whole @ basis)
    return _read_basis(basis, values, period, courses)


def _read_basis(basis: Array, values: dict[str, float], period: float, courses: int) -> dict[str, float]:
    a, b = basis
    width = float(np.hypot(*a)) / period
    angle = float(np.arctan2(a[1], a[0]))
    direction = np.array([np.cos(angle), np.sin(angle)])
    across = np.array([-direction[1], direction[0]])
    height, offset = float(b @ across) / courses, float(b @ direction) / width / courses
    # A picture that repeats one way only leaves some of the offset to be measured.
    half = round(2 * offset) / 2
    offset = half if abs(offset - half) < _SAME_OFFSET else offset
    return values | {"tile_width": width, "tile_height": height, "angle": angle, "offset": offset}
