"""One way to write a tiling down, of the many that draw the same picture.

A wall is the same when it is turned by 180 degrees, when its origin moves to another lattice node, when its rows are
numbered from another course. Model files, and comparisons of one fit with another, need one of these. All of this runs
on the host in double precision; a tiling's leaves come back as NumPy arrays in the precision they had.
"""

import dataclasses
import math
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike, NDArray

from jaxtex.models.tiling import Tiling

# Courses after which a pattern of shifts must have come round again to be written as course_offsets.
_LONGEST_CYCLE = 64


def canonical(tiling: Tiling) -> Tiling:
    """Write a tiling in the form that model files hold; its coverage is unchanged everywhere.

    - The homography has H33 = 1.
    - The longest tile is 1 `tile_width`; course 0 is a course with the longest tiles.
    - `angle` is in (-pi/2, pi/2]; in (-pi/4, pi/4] for a stack bond, where either direction could be the course.
    - `offset` is in [0, 1), `course_offsets[0]` is 0 and the others are in [0, length of the course's pattern).
    - Patterns are as short as they can be.

    Raises:
        ValueError: for numbers that are not finite; for a homography with H33 = 0, whose horizon goes through the
            picture's corner; and where tiles of different lengths leave no way to bring `offset` into [0, 1).

    Examples:
        >>> from jaxtex.models.tiling import make_tiling
        >>> upright = canonical(make_tiling(tile_width=20.0, tile_height=60.0, angle=np.pi / 2, bond="stack"))
        >>> float(upright.tile_width), round(float(upright.angle), 6)
        (60.0, 0.0)
    """
    exact = _in_double(tiling)
    if not all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(exact)):
        raise ValueError("the tiling holds numbers that are not finite")
    if exact.homography[2, 2] == 0:
        raise ValueError("homography has H33 = 0: its horizon goes through the picture's corner (0, 0)")
    exact = dataclasses.replace(exact, homography=exact.homography / exact.homography[2, 2])
    exact = _turn(_shorten(_in_longest_tiles(exact)), _rounding(tiling))
    exact = _start_at(exact, course=_longest_course(exact), repeat=0)
    return _in_precision_of(tiling, _wrap(exact, _rounding(tiling)))


def nearest_node(tiling: Tiling, point: ArrayLike) -> Tiling:
    """Move `origin` to the lattice node nearest to an image point; the coverage is unchanged everywhere.

    Nodes are the starts of the courses' patterns, in courses with the longest tiles. Nearest is measured in the
    plane.

    Args:
        point: image point (x, y), as a rule the middle of the picture: there a fit knows the origin best.

    Examples:
        >>> from jaxtex.models.tiling import make_tiling
        >>> nearest_node(make_tiling(tile_width=40.0, tile_height=20.0, offset=0.5), (130.0, 55.0)).origin.tolist()
        [140.0, 60.0]
    """
    exact = _in_double(tiling)
    with jax.enable_x64():
        q = np.asarray(exact.to_lattice(jnp.asarray(np.asarray(point, dtype=np.float64))))
    cycle, first = exact.course_lengths.shape[0], _longest_course(exact)
    period = float(exact.course_lengths[first].sum())
    below = first + cycle * math.floor((q[1] / exact.tile_height - first) / cycle)
    # A node further off than half a pattern along a course cannot be the nearest.
    reach = cycle * math.ceil(0.5 * period * float(exact.tile_width / exact.tile_height) / cycle)

    def nearest_in(course: int) -> tuple[float, int, int]:
        shift = _shift(exact, course)
        repeat = round((float(q[0] / exact.tile_width) - shift) / period)
        along = (shift + repeat * period) * exact.tile_width - q[0]
        return math.hypot(along, course * exact.tile_height - q[1]), course, repeat

    _, course, repeat = min(map(nearest_in, range(below - reach, below + reach + cycle + 1, cycle)))
    return _in_precision_of(tiling, _wrap(_start_at(exact, course=course, repeat=repeat), _rounding(tiling)))


def _in_double(tiling: Tiling) -> Any:
    return jax.tree.map(lambda leaf: np.asarray(leaf, dtype=np.float64), tiling)


def _in_precision_of(tiling: Tiling, exact: Tiling) -> Tiling:
    return jax.tree.map(lambda leaf, given: np.asarray(leaf, dtype=np.asarray(given).dtype), exact, tiling)


def _rounding(tiling: Tiling) -> float:
    """What numbers of order 1 may be off by, in the precision of the tiling."""
    return 4.0 * float(np.finfo(np.asarray(tiling.tile_width).dtype).eps)


def _shift(t: Any, course: int) -> float:
    return float(t.offset * course + t.course_offsets[course % t.course_offsets.size])


def _longest_course(t: Any) -> int:
    """The first course that holds the longest tiles."""
    longest = t.course_lengths.max(axis=1)
    return int(np.argmax(longest >= longest.max() * (1 - 1e-12)))


def _in_longest_tiles(t: Any) -> Any:
    longest = t.course_lengths.max()
    return dataclasses.replace(
        t,
        tile_width=t.tile_width * longest,
        offset=t.offset / longest,
        course_offsets=t.course_offsets / longest,
        course_lengths=t.course_lengths / longest,
    )


def _shorten(t: Any) -> Any:
    lengths = _shortest_cycle(_shortest_cycle(t.course_lengths).T).T
    return dataclasses.replace(t, course_lengths=lengths, course_offsets=_shortest_cycle(t.course_offsets))


def _shortest_cycle(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """The shortest piece that repeats to give all rows."""
    n = len(rows)
    return next(rows[:k] for k in range(1, n + 1) if n % k == 0 and np.array_equal(rows, np.roll(rows, k, axis=0)))


def _turn(t: Any, rounding: float) -> Any:
    """Turn the lattice by quarter (stack) or half turns so that the angle is in its range."""
    steps = np.concatenate([t.offset[None], t.course_offsets - t.course_offsets[0]])
    if t.bond == "stack" and t.course_lengths.size == 1 and np.abs(steps - np.round(steps)).max() <= rounding:
        turns = math.ceil((t.angle - math.pi / 4 - rounding) / (math.pi / 2))
        # The lattice of a stack bond has its nodes where shifts by whole tiles leave them.
        t = _start_at(dataclasses.replace(t, offset=np.zeros(())), course=0, repeat=0)
        t = dataclasses.replace(t, angle=t.angle - turns * math.pi / 2, course_offsets=np.zeros(1))
        if turns % 2 == 0:
            return t
        return dataclasses.replace(
            t, tile_width=t.tile_height, tile_height=t.tile_width, mortar_x=t.mortar_y, mortar_y=t.mortar_x
        )
    turns = math.ceil((t.angle - math.pi / 2 - rounding) / math.pi)
    t = dataclasses.replace(t, angle=t.angle - turns * math.pi)
    if turns % 2 == 0:
        return t
    # Seen from the other side, course j is course -1 - j and its tiles run backwards.
    return dataclasses.replace(
        t, course_lengths=t.course_lengths[::-1, ::-1], course_offsets=t.offset - t.course_offsets[::-1]
    )


def _start_at(t: Any, *, course: int, repeat: int) -> Any:
    """Move the origin to where the pattern of one course starts for the `repeat`-th time."""
    t = _with_own_offsets(t)
    along = _shift(t, course) + repeat * t.course_lengths[course % len(t.course_lengths)].sum()
    c, s = np.cos(t.angle), np.sin(t.angle)
    q_x, q_y = along * t.tile_width, course * t.tile_height
    course_offsets = np.roll(t.course_offsets, -course) + (t.offset * course - along)
    course_offsets[0] = 0.0  # exactly so: whole repeats are no shift
    return dataclasses.replace(
        t,
        origin=t.origin + np.stack([c * q_x - s * q_y, s * q_x + c * q_y]),
        course_offsets=course_offsets,
        course_lengths=np.roll(t.course_lengths, -course, axis=0),
    )


def _with_own_offsets(t: Any, cycle: int = 1) -> Any:
    """Repeat the course offsets so that each belongs to courses of one pattern only, and `cycle` divides them."""
    if np.ptp(t.course_lengths.sum(axis=1)) > 0:
        cycle = math.lcm(cycle, len(t.course_lengths))
    repeats = math.lcm(cycle, t.course_offsets.size) // t.course_offsets.size
    return dataclasses.replace(t, course_offsets=np.tile(t.course_offsets, repeats))


def _wrap(t: Any, rounding: float) -> Any:
    """Bring the offset into [0, 1) and the course offsets into [0, length of their course's pattern)."""
    t = _with_own_offsets(_wrap_offset(t, rounding))
    periods = np.resize(t.course_lengths.sum(axis=1), t.course_offsets.size)
    wrapped = np.mod(t.course_offsets, periods)
    wrapped = np.where(periods - wrapped <= rounding * periods, 0.0, wrapped)
    return dataclasses.replace(t, course_offsets=_shortest_cycle(wrapped))


def _wrap_offset(t: Any, rounding: float) -> Any:
    offset = float(t.offset)
    if abs(offset - round(offset)) <= rounding:
        offset = round(offset)
    if 0 <= offset < 1:
        return dataclasses.replace(t, offset=np.asarray(float(offset)))
    periods = t.course_lengths.sum(axis=1)
    longest = float(periods.max())
    for whole in (longest * math.floor(offset / longest), math.floor(offset)):
        cycle = _cycle_of(whole, periods)
        if cycle and 0 <= offset - whole < 1:
            t = _with_own_offsets(t, cycle)
            moved = t.course_offsets + whole * np.arange(t.course_offsets.size)
            return dataclasses.replace(t, offset=np.asarray(offset - whole), course_offsets=moved)
    raise ValueError(
        f"offset {offset:g} cannot be brought into [0, 1) with courses that repeat every {longest:g} tile widths; "
        "put the courses' shifts into course_offsets and leave offset 0"
    )


def _cycle_of(step: float, periods: NDArray[np.float64]) -> int | None:
    """The number of courses after which shifts of `step` per course have come round in all of them."""
    for cycle in range(len(periods), _LONGEST_CYCLE + 1, len(periods)):
        rounds = cycle * step / periods
        if np.abs(rounds - np.round(rounds)).max() < 1e-9:
            return cycle
    return None
