"""Fields: a number for each place of the plane, which is what controls take.

A field is any function of x and y, arrays of one shape in pixels, that gives an array of that shape. Here are the ones
that are wanted most; a plain number stands for itself everywhere.
"""

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

Values = npt.NDArray[np.floating]
Field = Callable[[Values, Values], npt.ArrayLike]
Amount = float | Field
"""A number that is the same everywhere, or a field."""

Point = Sequence[float]


def field_values(name: str, amount: Amount, x: Values, y: Values) -> Values:
    """What an amount is at places.

    Args:
        name: what it is called in complaints.
        amount: a number or a field.
        x, y: pixels, of one shape.

    Raises:
        ValueError: a field that gives an array of another shape, or numbers that are not finite.

    Examples:
        >>> field_values("size", 2.0, np.zeros(3), np.zeros(3))
        array([2., 2., 2.])
        >>> field_values("size", lambda x, y: x + y, np.arange(3.0), np.ones(3))
        array([1., 2., 3.])
    """
    values = np.asarray(amount(x, y) if callable(amount) else amount, float)
    if values.shape not in ((), x.shape):
        raise ValueError(
            f"{name}: the field gives shape {values.shape} for places of shape {x.shape}; give one number each"
        )
    if not np.isfinite(values).all():
        raise ValueError(f"{name}: holds a number that is not finite")
    return np.broadcast_to(values, x.shape)


def linear_field(start: Point, end: Point, first: float, last: float) -> Field:
    """A field that goes evenly from one number to another.

    Args:
        start, end: (x, y) in pixels.
        first: the number at the start, and on that side of it.
        last: the number at the end, and beyond.

    Raises:
        ValueError: a start that is the end too.

    Examples:
        >>> linear_field((0, 0), (100, 0), 1.0, 3.0)(np.array([-9.0, 50.0, 100.0]), np.zeros(3))
        array([1., 2., 3.])
    """
    way = np.subtract(end, start, dtype=float)
    square = float(way @ way)
    if not square > 0:
        raise ValueError(f"start and end: both are {tuple(start)}; give two places")

    def field(x: Values, y: Values) -> Values:
        part = ((x - start[0]) * way[0] + (y - start[1]) * way[1]) / square
        return first + (last - first) * np.clip(part, 0.0, 1.0)

    return field


def radial_field(centre: Point, radius: float, inside: float, outside: float, *, softness: float = 1.0) -> Field:
    """A field that is one number in the middle of a disc and another outside of it.

    Args:
        centre: (x, y) in pixels.
        radius: of the disc, pixels.
        inside: the number in its middle.
        outside: the number from its rim on.
        softness: over which part of the radius, from the rim inward, one changes evenly into the other: 1 from the
            centre on, 0 at the rim alone.

    Raises:
        ValueError: a radius that is not above 0, a softness that is not from 0 to 1.

    Examples:
        >>> radial_field((50, 50), 20, 0.0, 1.0)(np.array([50.0, 60.0, 90.0]), np.full(3, 50.0))
        array([0. , 0.5, 1. ])
    """
    if not radius > 0:
        raise ValueError(f"radius is {radius}; give a number above 0")
    if not 0 <= softness <= 1:
        raise ValueError(f"softness is {softness}; give a number from 0 to 1")

    def field(x: Values, y: Values) -> Values:
        within = radius - np.hypot(x - centre[0], y - centre[1])
        part = np.clip(within / (softness * radius), 0.0, 1.0) if softness > 0 else within > 0
        return outside + (inside - outside) * part

    return field


def map_field(values: npt.ArrayLike, size: tuple[int, int], *, low: float = 0.0, high: float = 1.0) -> Field:
    """A field painted as a picture, which is stretched over the plane.

    Args:
        values: [row, col]. Numbers are interpolated between pixels' centres. Yes or no is taken of the pixel that a
            place is in, so that a region ends exactly where it is painted.
        size: width and height of the plane in pixels.
        low: the number for 0 (black), or for no.
        high: the number for 1 (white), or for yes.

    Raises:
        ValueError: no picture of one channel, or one with values that are not finite.

    Examples:
        >>> half = map_field([[False, True]], (100, 80), low=1.0, high=3.0)
        >>> half(np.array([49.9, 50.1]), np.array([0.0, 79.0]))
        array([1., 3.])
        >>> map_field([[0.0, 1.0]], (100, 80))(np.array([25.0, 50.0]), np.zeros(2))
        array([0. , 0.5])
    """
    painted = np.asarray(values)
    if painted.ndim != 2 or 0 in painted.shape or not np.isfinite(painted).all():
        raise ValueError(f"map of shape {painted.shape}: give finite numbers [row, col], not empty")
    sharp = painted.dtype == bool
    numbers = low + (high - low) * painted.astype(float)
    rows, columns = numbers.shape

    def field(x: Values, y: Values) -> Values:
        across, down = x * (columns / size[0]), y * (rows / size[1])
        if sharp:
            return numbers[_within(np.floor(down), rows), _within(np.floor(across), columns)]
        top, left = np.floor(down - 0.5), np.floor(across - 0.5)
        below, beside = down - 0.5 - top, across - 0.5 - left
        upper, lower = (
            (1 - beside) * numbers[row, _within(left, columns)] + beside * numbers[row, _within(left + 1, columns)]
            for row in (_within(top, rows), _within(top + 1, rows))
        )
        return (1 - below) * upper + below * lower

    return field


def _within(index: Values, count: int) -> npt.NDArray[np.intp]:
    return np.clip(index, 0, count - 1).astype(np.intp)
