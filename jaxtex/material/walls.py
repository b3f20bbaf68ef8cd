"""From polygons to walls: which of them a tiling crosses as if they were one, and how high its courses lie on each."""

from collections import defaultdict
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.material.polygons import (
    TOLERANCE,
    Floats,
    Frame,
    SharedEdge,
    find_area,
    find_frame,
    find_shared_edges,
    is_flush,
    is_level,
    is_upright,
    turn_floor,
)

Kind = Literal["flush", "level", "corner", "cut", "loose"]
Link = tuple[int, int, float | Floats]


class Meeting(NamedTuple):
    """An edge that two polygons share, and how the tiling crosses it.

    Attributes:
        edge: where.
        kind: ``flush``, in one plane: as if there were no edge. ``level``: one polygon above the other; the tiling
            goes on as over a fold. ``corner``: upright; tiles turn it. ``cut``: neither level nor upright, as between
            walls that lean; courses meet, tiles are cut. ``loose``: at ridges and around floors, where nothing is made
            to meet.
    """

    edge: SharedEdge
    kind: Kind


class Corner(NamedTuple):
    """An upright edge between two walls.

    Attributes:
        first, second: the wall to its left and the one to its right, seen from outside.
        end, start: where the first wall ends, and where the second starts, along each of them.
        polygons: the two polygons that meet there, for complaints.
    """

    first: int
    second: int
    end: float
    start: float
    polygons: tuple[int, int]


class Walls(NamedTuple):
    """Polygons joined to walls, each with one way of measuring to the right.

    Attributes:
        of: the wall that each polygon is part of, [polygon].
        shift: added to ``points @ right`` of a polygon it gives places along its wall, [polygon].
        extents: from where to where each wall goes, [wall, 2].
        corners: where they meet.
    """

    of: npt.NDArray[np.int_]
    shift: Floats
    extents: Floats
    corners: list[Corner]

    def scale(self, factor: float) -> "Walls":
        """The same in another unit of length."""
        corners = [corner._replace(end=factor * corner.end, start=factor * corner.start) for corner in self.corners]
        return Walls(self.of, factor * self.shift, factor * self.extents, corners)

    def polygon_of(self, wall: int) -> int:
        """The first polygon of a wall."""
        return int(np.argmax(self.of == wall))


def find_meetings(polygons: Sequence[Floats], up: Floats) -> tuple[list[Frame], list[Meeting]]:
    """The frames of all polygons, and how a tiling crosses each edge that two of them share.

    A floor is turned so that it goes on from the wall with which it shares its longest edge.
    """
    frames = [find_frame(polygon, up) for polygon in polygons]
    edges = find_shared_edges(polygons, up)
    flush = [is_flush(frames[edge.first], frames[edge.second]) for edge in edges]
    anchors = _turn_floors(frames, edges, flush)
    meetings = []
    for number, edge in enumerate(edges):
        pair = frames[edge.first], frames[edge.second]
        kind: Kind
        if flush[number]:
            kind = "flush"
        elif any(frame.is_floor for frame in pair):
            kind = "level" if number in anchors else "loose"
        elif is_level(edge, up):
            kind = "level" if pair[0].right @ pair[1].right > 0 else "loose"
        else:
            kind = "corner" if is_upright(edge, *pair) else "cut"
        meetings.append(Meeting(edge, kind))
    return frames, meetings


def _turn_floors(frames: list[Frame], edges: list[SharedEdge], flush: list[bool]) -> set[int]:
    """Turn floors to go on from walls, in place; the edges across which they do."""
    joined = [(edge.first, edge.second, 0.0) for edge, one in zip(edges, flush, strict=True) if one]
    group = chain(len(frames), joined)[1]
    best: dict[int, int] = {}
    for number, edge in enumerate(edges):
        floor, wall = edge.first, edge.second
        if frames[wall].is_floor:
            floor, wall = wall, floor
        if frames[wall].is_floor or not frames[floor].is_floor:
            continue
        if group[floor] not in best or edge.length > edges[best[group[floor]]].length * (1 + TOLERANCE):
            best[group[floor]] = number
    turned = {}
    for label, number in best.items():
        pair = frames[edges[number].first], frames[edges[number].second]
        turned[label] = (pair[1] if pair[0].is_floor else pair[0]).right
    for number, frame in enumerate(frames):
        if frame.is_floor and group[number] in turned:
            frames[number] = turn_floor(frame.normal, turned[group[number]])
    return set(best.values())


def join_walls(polygons: Sequence[Floats], frames: Sequence[Frame], meetings: Sequence[Meeting]) -> Walls:
    """Join what lies flush or one above the other, so that tiles on it are shared or in line.

    Raises:
        InputError: polygons that join in a circle and do not agree where they are.
    """
    links, near = [], TOLERANCE * max(float(np.ptp(np.concatenate(list(polygons)), axis=0).max()), 1e-300)
    for (first, second, ends), kind in meetings:
        if kind in ("flush", "level"):
            links.append((first, second, float(ends[0] @ (frames[first].right - frames[second].right))))
    shift, of = chain(len(polygons), links)
    _check_links(shift, links, near)
    places = [polygon @ frame.right + at for polygon, frame, at in zip(polygons, frames, shift, strict=True)]
    extents = np.tile([np.inf, -np.inf], (of.max() + 1, 1))
    # Floors reach beyond the walls that they go on from; they count where there is nothing else.
    for floors in (False, True):
        known = np.isfinite(extents[:, 0])
        for number, place in enumerate(places):
            if frames[number].is_floor == floors and not (floors and known[of[number]]):
                wall = extents[of[number]]
                wall[:] = min(wall[0], place.min()), max(wall[1], place.max())
    corners = []
    for (first, second, ends), kind in meetings:
        if kind == "corner":
            end, start = (float(ends.mean(axis=0) @ frames[i].right + shift[i]) for i in (first, second))
            corners.append(Corner(int(of[first]), int(of[second]), end, start, (first, second)))
    return Walls(of, shift, extents, corners)


def lay_courses(
    polygons: Sequence[Floats],
    frames: Sequence[Frame],
    meetings: Sequence[Meeting],
    *,
    scale: float,
    course: float | None = None,
) -> Floats:
    """How high each polygon's points lie, in plane pixels above the foot of all that is joined to it.

    Polygons that meet in an edge that is not level share one measure of height; across level edges it may change, so
    that a roof's courses are not those of the walls below it seen from the side.

    Args:
        scale: plane pixels to a unit of length.
        course: height of a course in plane pixels, if all that is joined is to hold a whole number of them.

    Returns:
        [polygon, 2], c and d such that ``c (point @ rise) + d`` is the height.

    Raises:
        InputError: polygons that join in a circle and do not agree about heights.
    """
    joined = [(edge.first, edge.second, 0.0) for edge, kind in meetings if kind in ("flush", "corner", "cut")]
    tier = chain(len(polygons), joined)[1]
    area = np.array([np.linalg.norm(find_area(polygon)) for polygon in polygons])
    slope = np.array([frame.up @ frame.rise for frame in frames])
    per_rise = (scale * np.bincount(tier, area / slope) / np.bincount(tier, area))[tier]
    # All heights of a tier are measured alike: a link between any of its polygons holds for the tier.
    links = list(joined)
    for (first, second, ends), kind in meetings:
        if kind == "level":
            foot = ends.mean(axis=0)
            rises = [per_rise[i] * float(foot @ frames[i].rise) for i in (first, second)]
            links.append((first, second, rises[0] - rises[1]))
    summand, component = chain(len(polygons), links)
    _check_links(summand, links, max(TOLERANCE * scale * float(np.ptp(np.concatenate(list(polygons)))), 1e-300))
    heights = [
        c * (polygon @ frame.rise) + d for polygon, frame, c, d in zip(polygons, frames, per_rise, summand, strict=True)
    ]
    lowest, highest = np.full(component.max() + 1, np.inf), np.full(component.max() + 1, -np.inf)
    np.minimum.at(lowest, component, [height.min() for height in heights])
    np.maximum.at(highest, component, [height.max() for height in heights])
    stretch = np.ones(len(lowest))
    if course is not None:
        stretch = np.maximum(np.round((highest - lowest) / course), 1) * course / (highest - lowest)
    return np.stack([per_rise, summand - lowest[component]], axis=-1) * stretch[component, None]


def chain(count: int, links: Sequence[Link]) -> tuple[Floats, npt.NDArray[np.int_]]:
    """Numbers that differ by given steps: of a link (i, j, step), number j is number i plus step.

    Steps may be arrays, all of one shape, and the numbers are then such arrays.

    Returns:
        The numbers, [count, ...], 0 for the first that hang together; and which hang together, labels from 0, [count].
        Links that close a circle are not looked at.

    Examples:
        >>> [found.tolist() for found in chain(4, [(0, 2, 5.0), (3, 2, 1.0)])]
        [[0.0, 0.0, 5.0, 4.0], [0, 1, 0, 0]]
    """
    onwards: dict[int, list[tuple[int, float | Floats]]] = defaultdict(list)
    for first, second, step in links:
        onwards[first].append((second, step))
        onwards[second].append((first, -step))
    shape = np.shape(links[0][2]) if links else ()
    numbers, labels = np.zeros((count, *shape)), np.full(count, -1)
    for start in range(count):
        if labels[start] >= 0:
            continue
        labels[start] = labels.max() + 1
        reached = [start]
        for here in reached:
            for there, step in onwards[here]:
                if labels[there] < 0:
                    labels[there], numbers[there] = labels[here], numbers[here] + step
                    reached.append(there)
    return numbers, labels


def _check_links(numbers: Floats, links: Sequence[Link], near: float) -> None:
    for first, second, step in links:
        if abs(numbers[first] + step - numbers[second]) > 10 * near:
            raise InputError(
                f"polygons {first} and {second}: cannot meet at the edge they share, as they also join by way of "
                "others that ask for another place; leave one of them out"
            )
