"""How well a tiling laid over polygons meets at their edges, measured as whoever draws them sees it."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt

from jaxtex.material.adjacent import Layout
from jaxtex.material.polygons import Floats
from jaxtex.material.sheet import Sheet
from jaxtex.models.tiling import TilePlace, Tiling

_SAMPLES = 257  # along an edge: prime, so that they do not fall in with the courses


class Mismatch(NamedTuple):
    """How far joints are from meeting, for each shared edge.

    Attributes:
        bed: largest distance between the courses' joints of the two sides, in courses; NaN at loose edges.
        head: largest distance between what the head joints of the two sides are and what they should be, in tiles;
            NaN at loose edges and those that are cut. 1 where the two sides show parts of different tiles that should
            be one.
    """

    bed: Floats
    head: Floats

    @property
    def worst(self) -> float:
        """The largest of all, in tiles; 0 if nothing meets."""
        return float(np.nanmax(np.concatenate([self.bed, self.head, [0.0]])))


def measure_mismatch(layout: Layout, *, samples: int = _SAMPLES) -> Mismatch:
    """Measure how far joints are from meeting at the edges that polygons share.

    Nothing is taken from the layout but what is drawn: polygons, texture coordinates rounded to single precision, the
    sheet. Both sides are looked up at points along each edge, with `Tiling.locate` and the sheet's ids:

    * the lattice heights of the two sides are the same, modulo the sheet;
    * flush, level, and at corners that tiles wrap: so are the places along the courses;
    * at joints: both sides lie in the middle of a head joint;
    * at quoins: both sides show the same tile, one of them from end to end, and the other as much of it as quoins of
      this bond are wide.

    Args:
        layout: what to measure.
        samples: points along each edge, evenly spaced.

    Examples:
        >>> from jaxtex.material.adjacent import lay_adjacent
        >>> from jaxtex.material.sheet import lay_sheet
        >>> from jaxtex.models.tiling import make_tiling
        >>> tiles = lay_sheet(make_tiling(tile_width=30, tile_height=30), tiles=(3, 3), seamless=True)
        >>> front = [[0, 0, 1], [2, 0, 1], [2, 3, 1], [0, 3, 1]]
        >>> side = [[2, 0, 1], [2, 0, -1], [2, 3, -1], [2, 3, 1]]
        >>> measure_mismatch(lay_adjacent([front, side], tiles, tiles=5)).worst < 1e-5
        True
    """
    sheet = layout.sheet
    bed, head = np.full((2, len(layout.meetings)), np.nan)
    for number, meeting in enumerate(layout.meetings):
        if meeting.kind == "loose":
            continue
        share = np.linspace(0, 1, samples)[:, None]
        points = (1 - share) * meeting.edge.ends[0] + share * meeting.edge.ends[1]
        left, right = (_look_up(layout, polygon, points) for polygon in (meeting.edge.first, meeting.edge.second))
        bed[number] = _distance(left[:, 1] - right[:, 1], sheet.height).max() / float(sheet.tiling.tile_height)
        if meeting.kind == "corner" and layout.turn.style != "wrap":
            measure = _measure_quoins if layout.turn.style == "quoin" else _measure_joints
            head[number] = measure(layout, left, right) / layout.turn.pitch
        elif meeting.kind != "cut":
            head[number] = _distance(left[:, 0] - right[:, 0], sheet.width).max() / layout.turn.pitch
    return Mismatch(bed, head)


def _look_up(layout: Layout, polygon: int, points: Floats) -> Floats:
    """The lattice points that a polygon shows at points on it."""
    uv = layout.texture_coordinates(polygon).astype(np.float32).astype(np.float64)
    corners = layout.polygons[polygon]
    by_place = np.linalg.lstsq(corners - corners.mean(axis=0), uv - uv.mean(axis=0), rcond=1e-9)[0]
    shown = (points - corners.mean(axis=0)) @ by_place + uv.mean(axis=0)
    sheet = layout.sheet
    return sheet.corner + np.array([sheet.width, sheet.height]) * (shown * [1, -1] + [0, 1])


def _measure_joints(layout: Layout, left: Floats, right: Floats) -> float:
    """How far from a head joint's middle the two sides are."""
    places = [_locate(layout.sheet, side)[0] for side in (left, right)]
    return float(max(np.minimum(place.left, place.right).max() for place in places))


def _measure_quoins(layout: Layout, left: Floats, right: Floats) -> float:
    """How far what both sides show of the tiles at a corner is from a whole tile and a quoin's width."""
    tiling, turn = layout.sheet.tiling, layout.turn
    gap, inwards = float(tiling.mortar_x), 0.25 * turn.header
    (at_left, id_left), (at_right, id_right) = (
        _locate(layout.sheet, side + np.array([step, 0.0])) for side, step in ((left, -inwards), (right, inwards))
    )
    seen_left = np.asarray(at_left.left) + inwards - 0.5 * gap
    seen_right = np.asarray(at_right.right) + inwards - 0.5 * gap
    whole = turn.pitch - gap
    off = [
        np.maximum(abs(one - whole), abs(other - turn.header))
        for one, other in ((seen_left, seen_right), (seen_right, seen_left))
    ]
    worst = np.where(id_left == id_right, np.minimum(*off), turn.pitch)
    # Between courses there are no tiles to look at.
    margin = max(0.5 * float(tiling.mortar_y), 0.01 * float(tiling.tile_height))
    to_bed = [np.minimum(place.top, place.bottom) for place in (at_left, at_right)]
    return float(worst[np.minimum(*to_bed) > margin].max(initial=0.0))


def _locate(sheet: Sheet, points: Floats) -> tuple[TilePlace, npt.NDArray[np.int32]]:
    """The tiles at lattice points (n, 2) of the repeated sheet, and their ids."""
    points = sheet.corner + (points - sheet.corner) % (sheet.width, sheet.height)
    tiling = jax.tree.map(lambda leaf: jnp.asarray(leaf, jnp.float32), sheet.tiling)
    places = _locate_all(tiling, jnp.asarray(points, jnp.float32))
    table = sheet.table()
    row = np.asarray(places.course, int) - (sheet.first_course - 1)
    return places, table.identity[row, np.asarray(places.tile, int) - table.first[row]]


_locate_all = jax.jit(jax.vmap(Tiling.locate, in_axes=(None, 0)))


def _distance(values: Floats, period: float) -> Floats:
    """From the nearest multiple of the period."""
    return np.abs((values + 0.5 * period) % period - 0.5 * period)
