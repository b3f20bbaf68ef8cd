"""Sheets: the upright rectangle of a tiling that maps are made of, and how to make one that repeats without a seam."""

import dataclasses
import math
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.material.patterns import ONE_CLASS, Pattern, class_of
from jaxtex.models.files import ModelFile, need_tiling
from jaxtex.models.tiling import Tiling

_TOLERANCE = 0.01  # of a tile: what a length or a course's shift may give way so that the bond repeats
_SLACK = 0.05  # of a repeat: by so much a sheet may be narrower than the tiles asked for
_LONGEST = 64  # repeats to search for a period


class TileTable(NamedTuple):
    """Every tile that a sheet shows or touches, by the course's row in the table and the tile's place in the row.

    Attributes:
        first: number of the first tile of each row, [rows + 2]; row 0 is the course above the sheet.
        course, tile: numbers under which each tile gets its colour, [rows + 2, tiles]. In a seamless sheet the tiles
            beyond an edge are those at the other edge.
        identity: the tiles' ids in the maps, [rows + 2, tiles], from 0, each tile its own.
    """

    first: npt.NDArray[np.int32]
    course: npt.NDArray[np.int32]
    tile: npt.NDArray[np.int32]
    identity: npt.NDArray[np.int32]


@dataclasses.dataclass(frozen=True)
class Sheet:
    """A rectangle of a tiling laid upright: courses horizontal, perspective gone.

    Attributes:
        tiling: the tiling with angle 0, origin (0, 0) and no homography; tiles and courses keep their numbers. Its
            leaves are NumPy arrays in double precision.
        corner: lattice point (x, y) of the sheet's upper left corner, in plane pixels.
        along: its width in units of ``tile_width``.
        rows: its height in courses.
        seamless: whether it repeats in both directions.
        changes: what had to give way for that, in words.
    """

    tiling: Tiling
    corner: tuple[float, float]
    along: float
    rows: int
    seamless: bool = False
    changes: tuple[str, ...] = ()

    @property
    def width(self) -> float:
        """In plane pixels."""
        return self.along * float(self.tiling.tile_width)

    @property
    def columns(self) -> float:
        """Its width in tiles of mean length; a whole number unless the sheet is seamless."""
        return round(self.along / float(np.mean(self.tiling.course_lengths)), 6)

    @property
    def height(self) -> float:
        """In plane pixels."""
        return self.rows * float(self.tiling.tile_height)

    @property
    def natural_size(self) -> tuple[int, int]:
        """(width, height) in pixels of maps that are as large as the tiles are in the photograph."""
        return max(1, round(self.width)), max(1, round(self.height))

    def as_picture(self) -> Tiling:
        """The tiling as maps of natural size show it: a picture whose upper left corner is the sheet's."""
        leaves: dict[str, Any] = {"origin": -np.array(self.corner)}
        return dataclasses.replace(self.tiling, **leaves)

    @property
    def first_course(self) -> int:
        """Number of the uppermost course."""
        return round(self.corner[1] / float(self.tiling.tile_height))

    def table(self) -> TileTable:
        """All tiles of the sheet, with one more around it."""
        lattice = _Lattice(self.tiling)
        left = self.corner[0] / lattice.tile_width
        courses = range(self.first_course - 1, self.first_course + self.rows + 1)
        first = np.array([lattice.tile_at(course, left) - 1 for course in courses])
        last = np.array([lattice.tile_at(course, left + self.along) + 1 for course in courses])
        tile = first[:, None] + np.arange(int((last - first).max()) + 1)
        course = np.broadcast_to(np.array(courses)[:, None], tile.shape)
        if self.seamless:
            course, tile = self._wrap(lattice, course, tile)
        row, place = course - self.first_course, tile - first[course - courses[0]]
        inside = (row >= 0) & (row < self.rows)
        identity = np.where(inside, row * tile.shape[1] + place, -1)
        return TileTable(*(array.astype(np.int32) for array in (first, course, tile, identity)))

    def _wrap(
        self, lattice: "_Lattice", course: npt.NDArray[np.int_], tile: npt.NDArray[np.int_]
    ) -> tuple[npt.NDArray[np.int_], npt.NDArray[np.int_]]:
        """The tiles of the sheet itself that stand for those beyond its edges."""
        rounds, row = np.divmod(course - self.first_course, self.rows)
        wrapped = self.first_course + row
        left = self.corner[0] / lattice.tile_width
        first = np.array([lattice.tile_at(j, left) for j in range(self.first_course, self.first_course + self.rows)])
        slip = np.array([lattice.tiles_in(j, self.rows * lattice.offset) for j in wrapped[:, 0]])
        count = np.array([lattice.tiles_in(j, self.along) for j in wrapped[:, 0]])
        start = first[row]
        return wrapped, start + (tile + rounds * slip[:, None] - start) % count[:, None]


def lay_sheet(
    tiling: Tiling,
    *,
    tiles: tuple[int, int],
    seamless: bool = False,
    near: tuple[float, float] = (0.0, 0.0),
    pattern: Pattern = ONE_CLASS,
) -> Sheet:
    """Lay a sheet of a tiling.

    Args:
        tiling: any tiling; its angle and homography are left out.
        tiles: (columns, rows), each >= 1: the width in tiles (of mean length, where they differ), the height in
            courses.
        seamless: take whole periods of bond and colour pattern, at least the tiles asked for. What no whole period
            fits (an offset fitted as 0.4998, say) gives way by up to a hundredth of a tile; `Sheet.changes` tells.
        near: lattice point; the sheet's upper left corner is the start of a course's pattern nearest to it.
        pattern: the colours' pattern, which must repeat as well.

    Raises:
        InputError: no tiles, or courses that do not come round in a reasonable number of tiles.

    Examples:
        >>> from jaxtex.models.tiling import make_tiling
        >>> wall = make_tiling(tile_width=60, tile_height=20, offset=0.4998)
        >>> sheet = lay_sheet(wall, tiles=(4, 5), seamless=True)
        >>> sheet.columns, sheet.rows, sheet.changes
        (4.0, 6, ('5 courses became 6', 'the offset 0.4998 became 0.5'))
    """
    columns, rows = tiles
    if min(columns, rows) < 1:
        raise InputError(f"a sheet of {columns} x {rows} tiles shows nothing; give at least 1 x 1")
    upright = dataclasses.replace(
        jax.tree.map(lambda leaf: np.asarray(leaf, dtype=np.float64), tiling),
        angle=np.zeros(()),
        origin=np.zeros(2),
        homography=np.eye(3),
    )
    along = columns * float(np.mean(upright.course_lengths))
    changes: tuple[str, ...] = ()
    if seamless:
        upright, along, rows, changes = _close(upright, columns, rows, pattern)
    lattice = _Lattice(upright)
    course = round(near[1] / float(tiling.tile_height))
    corner = (lattice.nearest_start(course, near[0] / lattice.tile_width), course)
    return Sheet(
        tiling=upright,
        corner=(corner[0] * lattice.tile_width, corner[1] * float(tiling.tile_height)),
        along=along,
        rows=rows,
        seamless=seamless,
        changes=changes,
    )


def lay_photographed_sheet(
    file: ModelFile, *, tiles: tuple[int, int] | None = None, seamless: bool = False, pattern: Pattern = ONE_CLASS
) -> Sheet:
    """Lay the sheet that the photograph of a model file shows.

    Args:
        file: the model file's content.
        tiles: (columns, rows), from the photograph's upper left tile on. Default: as many as the photograph shows.
        seamless, pattern: as in `lay_sheet`.

    Raises:
        InputError: as `lay_sheet`, or the model is no tiling.
    """
    file = need_tiling(file)
    shown = (file.columns, file.rows)
    x, y = file.tiling.to_lattice(jnp.array([0.5 * file.image.width, 0.5 * file.image.height])).tolist()
    mean_length = float(file.tiling.tile_width) * float(np.mean(file.tiling.course_lengths))
    pitch = mean_length, float(file.tiling.tile_height)
    near = x - 0.5 * shown[0] * pitch[0], y - 0.5 * shown[1] * pitch[1]
    return lay_sheet(file.tiling, tiles=tiles or shown, seamless=seamless, near=near, pattern=pattern)


class _Lattice:
    """A tiling's numbers on the host, in double precision; lengths along the courses in units of ``tile_width``."""

    def __init__(self, tiling: Tiling) -> None:
        self.tile_width = float(tiling.tile_width)
        self.offset = float(tiling.offset)
        self.offsets = np.asarray(tiling.course_offsets, dtype=np.float64)
        self.lengths = np.asarray(tiling.course_lengths, dtype=np.float64)
        self.totals = self.lengths.sum(axis=1)

    def shift(self, course: int) -> float:
        return float(self.offset * course + self.offsets[course % len(self.offsets)])

    def total(self, course: int) -> float:
        return float(self.totals[course % len(self.totals)])

    def tile_at(self, course: int, along: float) -> int:
        """Number of the tile of a course at a place along it."""
        lengths = self.lengths[course % len(self.lengths)]
        # What rounding puts a hair before a tile's start is meant to be its start.
        repeat, rest = divmod(along - self.shift(course) + 1e-6, self.total(course))
        return int(repeat) * len(lengths) + int(np.searchsorted(np.cumsum(lengths)[:-1], rest, side="right"))

    def tiles_in(self, course: int, length: float) -> int:
        """How many tiles a length of whole repeats of the course's pattern holds."""
        return round(length / self.total(course)) * self.lengths.shape[1]

    def nearest_start(self, course: int, along: float) -> float:
        """Where a repeat of the course's pattern starts, nearest to a place along it."""
        return self.shift(course) + round((along - self.shift(course)) / self.total(course)) * self.total(course)


def _close(tiling: Tiling, columns: int, rows: int, pattern: Pattern) -> tuple[Tiling, float, int, tuple[str, ...]]:
    """Change a tiling as little as possible so that a sheet of it repeats.

    Returns:
        The tiling, the sheet's width in units of ``tile_width``, its courses, and what changed.
    """
    lattice = _Lattice(tiling)
    mean = float(lattice.lengths.mean())
    repeats = _repeats_along(lattice, columns * mean, pattern)
    along = float(repeats[0] * lattice.totals[0])
    lengths = lattice.lengths * (along / (repeats * lattice.totals))[:, None]
    step = along / math.gcd(*repeats.tolist())
    cycle, slips = _courses_to_repeat(lattice, step, along / repeats, pattern)
    closed_rows = -(-rows // cycle) * cycle
    offset = slips * step / cycle
    leaves: dict[str, Any] = {"offset": np.asarray(offset), "course_lengths": lengths}
    closed = dataclasses.replace(tiling, **leaves)
    tiles = along / float(lengths.mean())
    changes = [f"{columns} columns became {tiles:.4g}"] if abs(tiles - columns) > 1e-6 else []
    changes += [f"{rows} courses became {closed_rows}"] if closed_rows != rows else []
    changes += [f"the offset {lattice.offset:.4g} became {offset:.4g}"] if abs(offset - lattice.offset) > 1e-6 else []
    if not np.allclose(lengths, lattice.lengths, rtol=1e-6):
        changes.append(f"tile lengths changed by up to {100 * np.abs(lengths / lattice.lengths - 1).max():.2g} %")
    return closed, along, closed_rows, tuple(changes)


def _repeats_along(lattice: _Lattice, along: float, pattern: Pattern) -> npt.NDArray[np.int_]:
    """How often the pattern of each kind of course stands in the shortest sheet that is `along` wide or wider."""
    fewest = max(1, math.ceil(along / lattice.totals[0] - _SLACK))
    for first in range(fewest, fewest + _LONGEST):
        width = first * lattice.totals[0]
        repeats = np.maximum(1, np.round(width / lattice.totals)).astype(int)
        stretch = np.abs(width / (repeats * lattice.totals) - 1).max()
        if stretch <= _TOLERANCE and np.all(repeats * lattice.lengths.shape[1] % len(pattern[0]) == 0):
            return repeats
    raise InputError(
        f"the courses' tile lengths do not come round together within {width:.0f} tiles; render without seamless"
    )


def _courses_to_repeat(
    lattice: _Lattice, step: float, totals: npt.NDArray[np.float64], pattern: Pattern
) -> tuple[int, int]:
    """After how many courses bond and pattern repeat, and how many times `step` the courses have moved until then."""
    kinds = math.lcm(len(lattice.offsets), len(lattice.lengths))
    for cycle in range(kinds, _LONGEST * kinds + 1, kinds):
        slips = round(lattice.offset * cycle / step)
        tiles = np.round(slips * step / totals).astype(int) * lattice.lengths.shape[1]
        held = abs(lattice.offset - slips * step / cycle) <= _TOLERANCE
        if held and all(_matches(pattern, cycle, slip) for slip in set(tiles.tolist())):
            return cycle, slips
    raise InputError("the courses' shifts and colours do not come round together; render without seamless")


def _matches(pattern: Pattern, cycle: int, slip: int) -> bool:
    """Whether tile i of course j + cycle is of the class of tile i + slip of course j."""
    course, tile = np.indices((len(pattern), len(pattern[0])))
    return bool(np.all(class_of(pattern, course + cycle, tile) == class_of(pattern, course, tile + slip)))
