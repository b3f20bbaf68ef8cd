"""One tiling laid over many polygons, so that courses and joints meet at the edges they share.

(Lefebvre & Poulin 2000, sections 2.3 and 4.2 and figure 10, which show a tower and do not say how it was done.) All
polygons repeat one seamless sheet; what is computed is where on it each of their corners lies.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.io.meshes import TexturedMesh
from jaxtex.material.corners import CornerStyle, Turn, choose_turn, place_walls
from jaxtex.material.patterns import ONE_CLASS, Pattern
from jaxtex.material.polygons import Floats, check_polygons, find_area, triangulate
from jaxtex.material.sheet import Sheet, lay_sheet
from jaxtex.material.walls import Meeting, Walls, find_meetings, join_walls, lay_courses
from jaxtex.models.tiling import Tiling

_COLUMNS = range(4, 13)  # of a sheet: fewer look alike from afar, more take large textures
_MOST_STRETCH = 2.0  # or as little as its inverse


@dataclasses.dataclass(frozen=True)
class Layout:
    """A tiling laid over polygons.

    Attributes:
        sheet: the seamless sheet that all of them repeat.
        polygons: [corner, 3] each.
        lattice: for each polygon the lattice points of its corners, [corner, 2], plane pixels.
        stretch: [polygon, 2], how much longer and higher tiles are on each polygon than ``tile_length`` and the
            tiling's proportions have it; their ratio is the error of the aspect.
        meetings: the edges they share.
        turn: how tiles turn corners.
        tile_length: pitch of the tiles in the polygons' unit, on the mean of all walls.
        asked_length: the pitch that was asked for, or that follows from the number of tiles asked for.
    """

    sheet: Sheet
    polygons: tuple[Floats, ...]
    lattice: tuple[Floats, ...]
    stretch: Floats
    meetings: tuple[Meeting, ...]
    turn: Turn
    tile_length: float
    asked_length: float

    def texture_coordinates(self, polygon: int) -> Floats:
        """Where the corners of a polygon lie on the sheet, [corner, 2]: u right, v up, 1 to a repeat.

        Each polygon starts within the first repeat, so that single precision will do.
        """
        uv = (self.lattice[polygon] - self.sheet.corner) / (self.sheet.width, self.sheet.height) * [1, -1] + [0, 1]
        return uv - np.floor(uv.min(axis=0) + 1e-9)


def lay_adjacent(
    polygons: Sequence[npt.ArrayLike],
    sheet: Sheet,
    *,
    tiles: float | None = None,
    along: int = 0,
    tile_length: float | None = None,
    corners: CornerStyle | None = None,
    up: npt.ArrayLike = (0.0, 1.0, 0.0),
    whole_courses: bool = False,
) -> Layout:
    """Lay one tiling over polygons so that courses meet at every edge and tiles turn the corners.

    Courses are level and of one height on all walls. Where walls join in a row, each is stretched a little so that
    tiles turn its corners (`choose_turn`), and rings close in whole repeats of the sheet. What that takes on the mean
    goes into the size of the tiles, so that the aspect is right on the mean of all walls. Walls that lean and meet in
    an edge neither level nor upright share the heights of their courses, as is right for their mean slope. A floor or
    flat roof goes on from the wall with which it shares its longest edge.

    Args:
        polygons: planar, [corner, 3] each, counter-clockwise as seen from outside, in any unit. Neighbours in one
            plane are laid as one: the triangles of a mesh, ``vertices[faces]``, will do.
        sheet: a seamless sheet of the tiling. Rings close best if its columns divide the tiles around them.
        tiles: how many tiles stand in a row along polygon ``along`` and what lies flush beside it (section 2.3). To
            within half a tile where quoins turn its corners, as a row has a header more than whole tiles.
        along: number of that polygon.
        tile_length: instead of ``tiles``, the pitch of the tiles in the polygons' unit.
        corners: ``quoin``, ``joint`` or ``wrap``; default: what suits the bond.
        up: the world's upward direction; glTF's is y.
        whole_courses: let all that is joined hold a whole number of courses.

    Raises:
        InputError: polygons that are not planar or run against each other; a bond that cannot turn corners in this
            style; corners that contradict each other; walls too short for their tiles.

    Examples:
        >>> from jaxtex.material.sheet import lay_sheet
        >>> from jaxtex.models.tiling import make_tiling
        >>> bricks = make_tiling(tile_width=60, tile_height=20, mortar_x=4, mortar_y=4, offset=0.5)
        >>> front = [[0, 0, 1], [2, 0, 1], [2, 3, 1], [0, 3, 1]]
        >>> side = [[2, 0, 1], [2, 0, -1], [2, 3, -1], [2, 3, 1]]
        >>> layout = lay_adjacent([front, side], lay_sheet(bricks, tiles=(4, 8), seamless=True), tiles=8)
        >>> layout.turn.style, round(layout.tile_length, 3), [meeting.kind for meeting in layout.meetings]
        ('quoin', 0.25, ['corner'])
    """
    shapes, upwards = check_polygons(polygons), np.asarray(up, np.float64)
    _check(sheet, len(shapes), tiles, along, tile_length, upwards)
    turn = choose_turn(sheet, corners)
    frames, meetings = find_meetings(shapes, upwards / np.linalg.norm(upwards))
    walls = join_walls(shapes, frames, meetings)
    kept = int(walls.of[along]) if tiles is not None else None
    length = tile_length if tile_length is not None else _length_for(tiles or 1.0, int(walls.of[along]), walls, turn)
    scale = turn.pitch / length
    walls = walls.scale(scale)
    placed = place_walls(walls, turn, kept=kept)
    _check_stretch(placed[:, 0], walls)
    area = np.array([np.linalg.norm(find_area(shape)) for shape in shapes])
    mean = float(np.exp(area @ np.log(placed[walls.of, 0]) / area.sum()))
    course = float(sheet.tiling.tile_height) if whole_courses else None
    courses = lay_courses(shapes, frames, meetings, scale=scale * mean, course=course)
    lattice, stretch = [], []
    for shape, frame, wall, shift, (per_rise, foot) in zip(shapes, frames, walls.of, walls.shift, courses, strict=True):
        x = placed[wall, 0] * (scale * shape @ frame.right + shift) + placed[wall, 1]
        y = sheet.corner[1] + sheet.height - per_rise * (shape @ frame.rise) - foot
        lattice.append(np.stack([x, y], axis=-1))
        stretch.append([mean / placed[wall, 0], scale * mean / (per_rise * (frame.up @ frame.rise))])
    return Layout(
        sheet=sheet,
        polygons=tuple(shapes),
        lattice=tuple(lattice),
        stretch=np.array(stretch),
        meetings=tuple(meetings),
        turn=turn,
        tile_length=length / mean,
        asked_length=length,
    )


def lay_tiling(
    polygons: Sequence[npt.ArrayLike],
    tiling: Tiling,
    *,
    tiles: float,
    along: int = 0,
    rows: int = 8,
    pattern: Pattern = ONE_CLASS,
    corners: CornerStyle | None = None,
    up: npt.ArrayLike = (0.0, 1.0, 0.0),
) -> Layout:
    """`lay_adjacent` with a sheet of its own: of 4 to 12 columns, the one with which tiles on all walls are nearest to
    the length that was asked for; where several do as well, the widest.

    Args:
        tiling: any tiling.
        rows: courses of the sheet, at least.
        pattern: the colours' pattern, as in `lay_sheet`.
        polygons, tiles, along, corners, up: as in `lay_adjacent`.

    Raises:
        InputError: as `lay_adjacent` and `lay_sheet`, if no sheet will do.

    Examples:
        >>> from jaxtex.models.tiling import make_tiling
        >>> bricks = make_tiling(tile_width=60, tile_height=20, mortar_x=4, mortar_y=4, offset=0.5)
        >>> plan = np.array([[-1, 1], [1, 1], [1, -1], [-1, -1]])
        >>> tower = [[(*a, 0), (*b, 0), (*b, 5), (*a, 5)] for a, b in zip(np.roll(plan, -1, 0), plan)]
        >>> layout = lay_tiling(tower, bricks, tiles=7, up=(0, 0, 1))
        >>> layout.sheet.columns, bool(np.allclose(layout.stretch, 1))
        (7.0, True)
    """
    best, least, complaint = None, np.inf, InputError("")
    for columns in reversed(_COLUMNS):
        try:
            sheet = lay_sheet(tiling, tiles=(columns, rows), seamless=True, pattern=pattern)
            layout = lay_adjacent(polygons, sheet, tiles=tiles, along=along, corners=corners, up=up)
        except InputError as error:
            complaint = error
            continue
        off = float(np.abs(np.log(layout.stretch[:, 0] * layout.tile_length / layout.asked_length)).max())
        if off < least - 1e-4:
            best, least = layout, off
    if best is None:
        raise complaint
    return best


def polygon_mesh(layout: Layout) -> TexturedMesh:
    """The polygons as triangles with texture coordinates: what engines draw, with one repeating texture for all.

    Vertices are those of the polygons in their order, none shared; faces run as the polygons do.

    Examples:
        >>> from jaxtex.material.sheet import lay_sheet
        >>> from jaxtex.models.tiling import make_tiling
        >>> sheet = lay_sheet(make_tiling(tile_width=60, tile_height=20), tiles=(2, 3), seamless=True)
        >>> layout = lay_adjacent([[[0, 0, 0], [4, 0, 0], [4, 1, 0], [0, 1, 0]]], sheet, tiles=4)
        >>> polygon_mesh(layout).uv.round(3).tolist()
        [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]
    """
    firsts = np.cumsum([0, *map(len, layout.polygons[:-1])])
    normals = [find_area(polygon) / np.linalg.norm(find_area(polygon)) for polygon in layout.polygons]
    return TexturedMesh(
        vertices=np.concatenate(layout.polygons),
        faces=np.concatenate([triangulate(polygon) + at for polygon, at in zip(layout.polygons, firsts, strict=True)]),
        uv=np.concatenate([layout.texture_coordinates(number) for number in range(len(layout.polygons))]),
        normals=np.repeat(normals, [len(polygon) for polygon in layout.polygons], axis=0),
    )


def _check(sheet: Sheet, polygons: int, tiles: float | None, along: int, tile_length: float | None, up: Floats) -> None:
    if not sheet.seamless:
        raise InputError("the sheet does not repeat; lay it with seamless=True")
    sizes = [size for size in (tiles, tile_length) if size is not None]
    if len(sizes) != 1 or not (np.isfinite(sizes[0]) and sizes[0] > 0):
        raise InputError("give the number of tiles in a row or their length: one of them, and more than 0")
    if not 0 <= along < polygons:
        raise InputError(f"polygon {along}: does not exist; there are {polygons}, counted from 0")
    if up.shape != (3,) or not np.isfinite(up).all() or not up.any():
        raise InputError(f"upward direction {up.tolist()}: give x, y, z that are not all 0")


def _length_for(tiles: float, wall: int, walls: Walls, turn: Turn) -> float:
    """The tiles' pitch, in the polygons' unit, so that a wall holds a number of them without stretch."""
    at_corners = [{corner.first for corner in walls.corners}, {corner.second for corner in walls.corners}]
    if all(wall in at for at in at_corners):
        header = turn.header / turn.pitch
        tiles = {"quoin": max(round(tiles - header), 0) + header, "joint": max(round(tiles), 1)}.get(turn.style, tiles)
    return float(walls.extents[wall, 1] - walls.extents[wall, 0]) / tiles


def _check_stretch(factors: Floats, walls: Walls) -> None:
    for wall, factor in enumerate(factors):
        if not 1 / _MOST_STRETCH <= factor <= _MOST_STRETCH:
            raise InputError(
                f"polygon {walls.polygon_of(wall)}: holds too few tiles to turn its corners, as they would have to be "
                f"{1 / max(factor, 1e-9):.2g} times as long; give more tiles in a row, or a sheet of fewer columns"
            )
