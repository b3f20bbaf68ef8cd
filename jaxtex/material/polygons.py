"""Planar polygons in space: which way is right and up on each, where two of them share an edge, and triangles."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from jaxtex.core.errors import InputError

Floats = npt.NDArray[np.float64]

TOLERANCE = 1e-5
"""Share of the scene's extent by which points may miss each other and still be one: meshes hold single precision."""

_FLAT = 2e-3  # radians: what differs by less is level, upright or coplanar


class Frame(NamedTuple):
    """Directions on a polygon as seen from outside.

    Attributes:
        normal: outwards.
        right: level, to the right.
        up: steepest upwards within the polygon.
        rise: ``point @ rise`` is how high a point lies, in the measure that courses follow: the world's up on walls,
            ``up`` on floors.
        is_floor: whether the polygon is level, so that nothing but choice says which way is up.
    """

    normal: Floats
    right: Floats
    up: Floats
    rise: Floats
    is_floor: bool


class SharedEdge(NamedTuple):
    """A stretch of line where the edges of two polygons lie on each other.

    Attributes:
        first, second: the polygons. Along an upright edge ``first`` lies to the left, seen from outside; it is the one
            that runs upwards there.
        ends: the stretch's two ends, [2, 3], as it runs round ``first``.
    """

    first: int
    second: int
    ends: Floats

    @property
    def direction(self) -> Floats:
        """Unit vector from end to end."""
        return _unit(self.ends[1] - self.ends[0])

    @property
    def length(self) -> float:
        """From end to end."""
        return float(np.linalg.norm(self.ends[1] - self.ends[0]))


def check_polygons(polygons: Sequence[npt.ArrayLike]) -> list[Floats]:
    """Polygons as float64 arrays [corner, 3].

    Raises:
        InputError: no polygons; one of another shape, not finite, without area, or not planar.
    """
    checked = [np.asarray(polygon, np.float64) for polygon in polygons]
    if not checked:
        raise InputError("no polygons were given; give at least one")
    for number, polygon in enumerate(checked):
        if polygon.ndim != 2 or polygon.shape[1] != 3 or len(polygon) < 3:
            raise InputError(f"polygon {number}: has shape {polygon.shape}; give 3 or more corners of x, y, z")
        if not np.isfinite(polygon).all():
            raise InputError(f"polygon {number}: has corners that are not finite")
        area = find_area(polygon)
        extent = float(np.ptp(polygon, axis=0).max())
        if np.linalg.norm(area) <= TOLERANCE * extent**2:
            raise InputError(f"polygon {number}: has no area; leave it out")
        if np.abs((polygon - polygon[0]) @ _unit(area)).max() > 1e-3 * extent:
            raise InputError(f"polygon {number}: is not planar; cut it into triangles")
    return checked


def find_area(polygon: Floats) -> Floats:
    """The vector area of a polygon: as long as it is large, along its outward normal."""
    return 0.5 * np.cross(polygon - polygon[0], np.roll(polygon, -1, axis=0) - polygon[0]).sum(axis=0)


def find_frame(polygon: Floats, up: Floats) -> Frame:
    """The frame of a polygon whose corners run counter-clockwise as seen from outside.

    A level polygon looks as if one stood on it, or lay under it, with world x (or the axis next to it) to the right.

    Examples:
        >>> wall = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]], float)
        >>> frame = find_frame(wall, np.array([0.0, 1.0, 0.0]))
        >>> frame.right.tolist(), frame.up.tolist()
        ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    """
    normal = _unit(find_area(polygon))
    right = np.cross(up, normal)
    if np.linalg.norm(right) < _FLAT:
        aside = np.eye(3)[0] if abs(up[0]) < 0.9 else np.eye(3)[1]
        return turn_floor(normal, _unit(aside - (aside @ normal) * normal))
    right = _unit(right)
    return Frame(normal, right, np.cross(normal, right), up, is_floor=False)


def turn_floor(normal: Floats, right: Floats) -> Frame:
    """The frame of a level polygon that is to have a given direction to its right."""
    ahead = np.cross(normal, right)
    return Frame(normal, right, ahead, ahead, is_floor=True)


def find_shared_edges(polygons: Sequence[Floats], up: Floats) -> list[SharedEdge]:
    """Every stretch of line that edges of two polygons share, also where corners of one lie inside an edge of another.

    Raises:
        InputError: two polygons run the same way along it: one is turned inside out, or more than two meet there.
    """
    owner = np.repeat(np.arange(len(polygons)), [len(polygon) for polygon in polygons])
    start = np.concatenate(list(polygons))
    end = np.concatenate([np.roll(polygon, -1, axis=0) for polygon in polygons])
    near = TOLERANCE * float(np.ptp(start, axis=0).max())
    long = np.linalg.norm(end - start, axis=1) > 10 * near
    owner, start, end = owner[long], start[long], end[long]
    shared = []
    for i, j in _pairs_on_one_line(start, end):
        if owner[i] == owner[j]:
            continue
        along = _unit(end[i] - start[i])
        other = np.stack([start[j], end[j]]) - start[i]
        if np.linalg.norm(other - (other @ along)[:, None] * along, axis=1).max() > near:
            continue
        begin, finish = other @ along
        low = max(0.0, min(begin, finish))
        high = min(float(np.linalg.norm(end[i] - start[i])), max(begin, finish))
        if high - low <= 10 * near:
            continue
        if begin < finish:
            raise InputError(
                f"polygons {owner[i]} and {owner[j]}: run the same way along an edge they share; turn one over if it "
                "is inside out, or leave out one of those that meet there"
            )
        ends = start[i] + np.array([[low], [high]]) * along
        pair = int(owner[i]), int(owner[j])
        shared.append(SharedEdge(*pair, ends) if along @ up >= 0 else SharedEdge(*pair[::-1], ends[::-1]))
    return shared


def _pairs_on_one_line(start: Floats, end: Floats) -> list[tuple[int, int]]:
    """Pairs of edges (i < j) that may lie on one line."""
    centre, extent = start.mean(axis=0), float(np.ptp(start, axis=0).max())
    along = (end - start) / np.linalg.norm(end - start, axis=1, keepdims=True)
    foot = (start - centre) - ((start - centre) * along).sum(axis=1, keepdims=True) * along
    line = np.concatenate([along, foot / extent], axis=1)
    back = line * np.repeat([-1.0, 1.0], 3)
    # Short edges know their direction but roughly; the caller looks closely at what is found here.
    reach = max(1e-4, 4 * TOLERANCE * extent / float(np.linalg.norm(end - start, axis=1).min()))
    tree = cKDTree(line)
    same = tree.query_pairs(reach)
    opposite = {(i, j) for i, found in enumerate(tree.query_ball_point(back, reach)) for j in found if i < j}
    return sorted(same | opposite)


def is_level(edge: SharedEdge, up: Floats) -> bool:
    """Whether an edge runs at one height."""
    return bool(abs(edge.direction @ up) < _FLAT)


def is_upright(edge: SharedEdge, *frames: Frame) -> bool:
    """Whether an edge runs along the steepest direction of all polygons with the given frames."""
    return all(abs(edge.direction @ frame.right) < _FLAT for frame in frames)


def is_flush(first: Frame, second: Frame) -> bool:
    """Whether two polygons that meet lie in one plane and face the same way."""
    facing = float(first.normal @ second.normal)
    return facing > 0 and bool(np.linalg.norm(np.cross(first.normal, second.normal)) < _FLAT)


def triangulate(polygon: Floats) -> npt.NDArray[np.int64]:
    """Triangles [corner - 2, 3] that make up a planar polygon, which need not be convex: ears are cut off it.

    (G. Meisters, Polygons have ears, 1975.)

    Examples:
        >>> triangulate(np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [1, 0.5, 0]], float)).tolist()
        [[1, 2, 3], [0, 1, 3]]
    """
    normal = _unit(find_area(polygon))
    rest, triangles = list(range(len(polygon))), []
    while len(rest) > 3:
        ears = [_ear_quality(polygon, normal, rest, place) for place in range(len(rest))]
        best = int(np.argmax(ears))
        triangles.append([rest[best - 1], rest[best], rest[(best + 1) % len(rest)]])
        del rest[best]
    return np.array([*triangles, rest], np.int64)


def _ear_quality(polygon: Floats, normal: Floats, rest: list[int], place: int) -> float:
    """How round a triangle is that may be cut off at a corner; negative where none may."""
    corners = rest[place - 1], rest[place], rest[(place + 1) % len(rest)]
    a, b, c = polygon[list(corners)]
    area = float(np.cross(b - a, c - a) @ normal)
    others = polygon[[number for number in rest if number not in corners]]
    sides = [np.cross(q - p, others - p) @ normal for p, q in ((a, b), (b, c), (c, a))]
    # A corner that coincides with one of the ear's own (a bridge to a hole) is not inside it.
    apart = np.min([np.linalg.norm(others - p, axis=1) for p in (a, b, c)], axis=0) > 0
    inside = np.all(np.array(sides) >= 0, axis=0) & apart
    size = float(np.square(b - a).sum() + np.square(c - b).sum() + np.square(a - c).sum())
    return -1.0 if inside.any() else area / size


def _unit(vector: Floats) -> Floats:
    return vector / np.linalg.norm(vector)
