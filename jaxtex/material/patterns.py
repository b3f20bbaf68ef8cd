"""Colour patterns: which tiles of a tiling share a colour, as a small table that repeats over the lattice.

Tile i of course j belongs to the class `pattern[j mod b][i mod a]`. A chessboard floor is `((0, 1), (1, 0))`, a wall of
one sort of brick is `((0,),)`.
"""

import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

Pattern = tuple[tuple[int, ...], ...]

ONE_CLASS: Pattern = ((0,),)

_LONGEST = 4  # tiles or courses after which a pattern repeats, at most
_FEWEST = 4  # tiles that a class must be seen on
_LEFT = 0.4  # share of the tiles' variance that a pattern may leave within its classes and still be believed


def class_of(pattern: Pattern, course: npt.ArrayLike, tile: npt.ArrayLike) -> npt.NDArray[np.int_]:
    """The class of each tile.

    Args:
        pattern: the table, [b][a].
        course, tile: integer numbers of the tiles, of one shape.

    Examples:
        >>> class_of(((0, 1), (1, 0)), [0, 0, 1, -1], [0, 1, 1, 0]).tolist()
        [0, 1, 0, 1]
    """
    table = np.asarray(pattern)
    return table[np.asarray(course) % table.shape[0], np.asarray(tile) % table.shape[1]]


def choose_pattern(
    course: npt.NDArray[np.int_], tile: npt.NDArray[np.int_], values: npt.NDArray[np.floating]
) -> Pattern:
    """The colour pattern that explains best how tiles differ: one class, unless a pattern explains most of it.

    Tried are all patterns that alternate along the courses with up to four colours, those from course to course, those
    of two by two tiles, and chessboards and diagonals. The best has the least Bayesian information criterion
    (G. Schwarz, 1978) of Gaussian residuals around the classes' means.

    Args:
        course, tile: numbers of the tiles seen, [n].
        values: their colours in a space where equal steps are about equally visible, [n, channel].

    Returns:
        The table [b][a] of class numbers; `ONE_CLASS` where nothing repeats.

    Examples:
        >>> j, i = np.indices((4, 4)).reshape(2, -1)
        >>> choose_pattern(j, i, np.where((i + j) % 2, 0.9, 0.1)[:, None])
        ((0, 1), (1, 0))
    """
    n = len(values)
    total = _spread(values, np.zeros(n, dtype=int))
    best, least = ONE_CLASS, _criterion(total, values, classes=1)
    for pattern in _patterns():
        label = class_of(pattern, course, tile)
        classes = 1 + max(map(max, pattern))
        if np.bincount(label, minlength=classes).min() < _FEWEST:
            continue
        left = _spread(values, label)
        criterion = _criterion(left, values, classes)
        # Of the variances, not the sums: chance alone explains (classes - 1) / (n - 1) of the sum.
        if left / (n - classes) <= _LEFT * total / (n - 1) and criterion < least:
            best, least = pattern, criterion
    return best


def _patterns() -> Iterator[Pattern]:
    for a in range(2, _LONGEST + 1):
        yield tuple((j,) for j in range(a))
        for step in range(a):
            courses = a // math.gcd(step, a)
            yield tuple(tuple((i + step * j) % a for i in range(a)) for j in range(courses))
    yield (0, 1), (2, 3)


def _spread(values: npt.NDArray[np.floating], label: npt.NDArray[np.int_]) -> float:
    """Sum of squares around the classes' means."""
    count = np.maximum(np.bincount(label), 1)
    means = np.stack([np.bincount(label, weights=channel) / count for channel in values.T], axis=-1)
    return float(np.sum((values - means[label]) ** 2))


def _criterion(spread: float, values: npt.NDArray[np.floating], classes: int) -> float:
    # A thousandth of the range of a channel is below what 8 bits can tell apart: no pattern is better than that.
    variance = spread / values.size + 1e-6
    return values.size * math.log(variance) + classes * values.shape[1] * math.log(len(values))
