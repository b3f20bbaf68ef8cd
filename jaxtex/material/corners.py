"""How a bond turns a corner, and how long that lets each wall of a row be."""

from typing import Literal, NamedTuple, get_args

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.material.sheet import Sheet
from jaxtex.material.walls import Corner, Walls, chain

Floats = npt.NDArray[np.float64]
CornerStyle = Literal["quoin", "joint", "wrap"]

CORNER_STYLES: tuple[CornerStyle, ...] = get_args(CornerStyle)

_STYLE_FOR: dict[int, CornerStyle] = {1: "joint", 2: "quoin"}  # by the number of places where courses start
_ALIKE = 0.005  # of a tile: by so much courses may be shifted against each other and count as in line


class Turn(NamedTuple):
    """What a bond asks of the two walls at a corner; lengths in plane pixels along the courses.

    Attributes:
        style: of the corner.
        pitch: of the tiles.
        period: after which the sheet repeats.
        end: where, modulo the pitch, the wall to the left of a corner ends.
        header: how far before the place where the wall on the left ended the wall on the right begins. Of the tile
            that turns the corner, so much is seen on both walls in turn.
    """

    style: CornerStyle
    pitch: float
    period: float
    end: float
    header: float

    @property
    def period_tiles(self) -> int:
        """Tiles to a period."""
        return round(self.period / self.pitch)


def choose_turn(sheet: Sheet, style: CornerStyle | None) -> Turn:
    """How the bond of a sheet turns corners.

    * ``quoin``, for bonds whose courses start at one of two places: a tile at the corner shows its length on one wall
      and its width on the other, by turns from course to course. Its width follows from the bond, as masons have it
      the other way round: courses shifted by half a tile show tiles half as wide as they are long (joint included).
      With tiles of pitch L, joints of g, and courses shifted by f L (f at most 1/2) the width seen is f L - g.
    * ``joint``, for head joints in line: the corner is the middle of a joint.
    * ``wrap``, for any bond: tiles go round the corner as if they were paper.

    Args:
        sheet: a seamless sheet.
        style: default: quoin or joint where the bond allows it, else wrap.

    Raises:
        InputError: the bond does not allow that style.
    """
    tiling = sheet.tiling
    pitch = float(tiling.tile_width * np.mean(tiling.course_lengths))
    places = _find_starts(sheet) if tiling.course_lengths.size == 1 else []
    fitting = _STYLE_FOR.get(len(places), "wrap")
    style = style or fitting
    if style not in CORNER_STYLES:
        raise InputError(f"corner style {style!r} is not one of {', '.join(CORNER_STYLES)}")
    if style not in ("wrap", fitting):
        raise InputError(
            f"corner style {style!r} does not go with this {tiling.bond} bond: quoins take courses that start at one "
            "of two places, joints head joints in line, all of one tile length; use wrap"
        )
    if style == "wrap":
        return Turn(style, pitch, sheet.width, 0.0, 0.0)
    if style == "joint":
        return Turn(style, pitch, sheet.width, places[0] * pitch, 0.0)
    gap = float(tiling.mortar_x)
    fraction = (places[1] - places[0]) % 1.0
    # Whole tiles end at the corner in the courses after which the others are shifted by the larger part.
    whole, width = (places[0], 1 - fraction) if fraction >= 0.5 else (places[1], fraction)
    if width * pitch <= gap:
        raise InputError("the courses' shift leaves no width for bricks at corners; use wrap")
    return Turn(style, pitch, sheet.width, whole * pitch - 0.5 * gap, width * pitch - gap)


def _find_starts(sheet: Sheet) -> list[float]:
    """Where, in tiles modulo 1, courses start: one number for all that are in line."""
    courses = sheet.first_course + np.arange(sheet.rows)
    offsets = sheet.tiling.course_offsets
    shifts = (float(sheet.tiling.offset) * courses + offsets[courses % len(offsets)]) % 1.0
    places: list[float] = []
    for shift in shifts.tolist():
        if all(abs((shift - place + 0.5) % 1.0 - 0.5) > _ALIKE for place in places):
            places.append(shift)
    return places


def place_walls(walls: Walls, turn: Turn, *, kept: int | None) -> Floats:
    """Stretch and shift walls so that tiles turn all corners and rings close.

    Args:
        walls: in plane pixels.
        turn: how tiles turn corners.
        kept: a wall whose number of tiles is wanted.

    Returns:
        [wall, 2]: factor a and summand b for each wall, so that its coordinates along the courses are a u + b.

    Raises:
        InputError: corners contradict each other.
    """
    placed = _wrap_walls(walls, turn) if turn.style == "wrap" else _snap_walls(walls, turn, kept)
    for corner in walls.corners:
        end, start = (
            placed[wall] @ [at, 1] for wall, at in ((corner.first, corner.end), (corner.second, corner.start))
        )
        step = end - turn.header - start
        off = [_distance(step, turn.period)]
        off += [] if turn.style == "wrap" else [_distance(end - turn.end, turn.pitch)]
        if max(off) > _ALIKE * turn.pitch:
            i, j = corner.polygons
            raise InputError(
                f"polygons {i} and {j}: tiles cannot turn their corner, as other edges of the same walls ask for "
                f"another place ({max(off) / turn.pitch:.2g} tiles away); use wrap, or leave out polygons"
            )
    return placed


def _distance(value: float, period: float) -> float:
    """From the nearest multiple of the period."""
    return abs((value + 0.5 * period) % period - 0.5 * period)


def _snap_walls(walls: Walls, turn: Turn, kept: int | None) -> Floats:
    """Walls between two corners get a whole number of tiles (and a header); rows are walked from left to right."""
    placed = np.full((len(walls.extents), 2), np.nan)
    for row, links in _walk_rows(walls):
        closed = len(links) == len(row)
        starts = [links[k - 1].start if closed or k else None for k in range(len(row))]
        ends = [links[k].end if k < len(links) else None for k in range(len(row))]
        spans = [e - s if s is not None and e is not None else np.nan for s, e in zip(starts, ends, strict=True)]
        counts = _count_tiles(np.array(spans), turn, closed, row.index(kept) if kept in row else None)
        here = turn.end - turn.header
        for wall, start, end, span, count in zip(row, starts, ends, spans, counts, strict=True):
            if start is None and end is not None:
                placed[wall] = 1.0, turn.end - end
                here = turn.end - turn.header
                continue
            goes = count * turn.pitch + turn.header
            factor = goes / span if end is not None else 1.0
            begin = start if start is not None else walls.extents[wall, 0]
            placed[wall] = factor, here - factor * begin
            here += goes - turn.header
        _join_row(placed, row, walls.corners, turn)
    return placed


def _join_row(placed: Floats, row: list[int], corners: list[Corner], turn: Turn) -> None:
    """Shift a row by whole tiles to where a row that was placed before asks for it."""
    for corner in corners:
        inside = corner.first in row, corner.second in row
        if inside[0] == inside[1] or np.isnan(placed[[corner.first, corner.second]]).any():
            continue
        end, start = placed[corner.first] @ [corner.end, 1], placed[corner.second] @ [corner.start, 1]
        tiles = round((end - turn.header - start) / turn.pitch)
        placed[row, 1] += tiles * turn.pitch if inside[1] else -tiles * turn.pitch
        return


def _count_tiles(spans: Floats, turn: Turn, closed: bool, kept: int | None) -> npt.NDArray[np.int_]:
    """Whole tiles on each wall of a row; around a ring they make up whole periods."""
    exact = (np.nan_to_num(spans) - turn.header) / turn.pitch
    least = 0 if turn.header else 1
    counts = np.maximum(np.round(exact).astype(int), least)
    if not closed:
        return counts
    period = turn.period_tiles
    wanted = max(1, round(float(exact.sum()) / period)) * period
    free = np.ones(len(counts), bool)
    if kept is not None and len(counts) > 1:
        free[kept] = False
    while counts.sum() != wanted:
        step = int(np.sign(wanted - counts.sum()))
        stretched = np.maximum(counts + step, 1e-9) * turn.pitch + turn.header
        cost = np.abs(np.log(stretched / spans))
        cost[~free | (counts + step < least)] = np.inf
        if np.isinf(cost).all():
            raise InputError(
                f"a ring of {len(counts)} walls is too short for a sheet that repeats after {period} tiles; "
                "give a sheet of fewer columns, or more tiles"
            )
        counts[int(np.argmin(cost))] += step
    return counts


def _walk_rows(walls: Walls) -> list[tuple[list[int], list[Corner]]]:
    """Walls in rows from left to right, and the corners between them: as many as walls where a row is a ring."""
    onwards: dict[int, Corner] = {}
    entered = set()
    for corner in walls.corners:
        if corner.first not in onwards and corner.second not in entered:
            onwards[corner.first] = corner
            entered.add(corner.second)
    rows, seen = [], set()
    for first in sorted(range(len(walls.extents)), key=lambda wall: (wall in entered, wall)):
        if first in seen:
            continue
        row, links = [first], []
        while row[-1] in onwards:
            links.append(onwards[row[-1]])
            if links[-1].second == first:
                break
            row.append(links[-1].second)
        seen.update(row)
        rows.append((row, links))
    return rows


def _wrap_walls(walls: Walls, turn: Turn) -> Floats:
    """Coordinates run on round every corner; the least stretch that closes all rings in whole periods."""
    placed = np.stack([np.ones(len(walls.extents)), -walls.extents[:, 0]], axis=-1)
    if not walls.corners:
        return placed
    joined = np.unique([[corner.first, corner.second] for corner in walls.corners])
    # Each wall's summand is a sum of the factors of those before it: a row of numbers, by which to multiply these.
    links = []
    for corner in walls.corners:
        first, second = np.searchsorted(joined, [corner.first, corner.second])
        step = np.zeros(len(joined))
        step[first] += corner.end
        step[second] -= corner.start
        links.append((int(first), int(second), step))
    summands, label = chain(len(joined), links)
    round_ring = np.array([summands[first] + step - summands[second] for first, second, step in links])
    length = round_ring.sum(axis=1)
    periods = np.round(length / turn.period)
    periods = np.where((periods == 0) & (np.abs(length) > _ALIKE * turn.pitch), np.sign(length), periods)
    # Factors 1 + x / weight with the least sum of x squared: all walls of a plain ring are then stretched alike.
    weight = np.sqrt(np.maximum(np.ptp(walls.extents[joined], axis=1), 1e-9))
    x = np.linalg.lstsq(round_ring / weight, periods * turn.period - length, rcond=1e-9)[0]
    factors = 1 + x / weight
    starts = walls.extents[joined[np.unique(label, return_index=True)[1]], 0]
    placed[joined] = np.stack([factors, summands @ factors - starts[label]], axis=-1)
    return placed
