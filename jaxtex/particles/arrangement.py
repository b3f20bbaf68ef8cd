"""How particles are arranged: where each one has its nearest neighbours of the same class.

J.-M. Dischler, K. Maritaud, B. Lévy and D. Ghazanfarpour, "Texture particles" (Eurographics 2002), section 2.2.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations
from math import cos, hypot, sin
from typing import NamedTuple

import numpy as np
from scipy.ndimage import distance_transform_cdt, find_objects
from scipy.spatial import cKDTree

from jaxtex.particles.boxes import form_of, gap_between, overlap_share
from jaxtex.particles.companions import learn_companions
from jaxtex.particles.cooccurrences import (
    Arrangement,
    Cooccurrence,
    Listed,
    Scattered,
    cooccurrence_of,
    place_neighbour,
)
from jaxtex.particles.things import Box, Decomposition, Labels

_MOST_GROWTH = 2.0
"""Steps by which a particle grows at most, in its sizes. Its size is its box's longer side, or the side of the square
that each particle of its class has on average, if that is more: sparse things have neighbours too."""

_DENSE = 0.4  # of the picture: where things cover so much, they nearly touch
_FEWEST = 4  # particles of a class that have an arrangement (section 2.2: one, two or three have none)
_CLOSEST = 0.1  # of all neighbours that are nearest to a particle: how many are closer than what they keep as a rule
_COMPARED = 16  # other particles whose lists are tried at each particle
_CLEARLY = 0.95  # of the error in the picture's frame: what another frame has at most to be taken


class _Seen(NamedTuple):
    """A neighbour as the picture shows it: its number, and after how many steps growth reaches it."""

    number: int
    steps: int


def learn_arrangement(decomposition: Decomposition) -> Arrangement:
    """Learn where the particles of a picture have their neighbours.

    Every complete particle grows by a pixel all around (dilation by a square of 3 x 3), until there is a neighbour of
    its class in each quadrant; all that it has reached then are its neighbours. Where they lie is its list. Particles
    that the picture's border cuts off are reached, but how large they are is not known; so a quadrant that has no whole
    particle takes its opposite's, mirrored. If that has none either, it takes the cut ones, and else its neighbour
    quadrant's, turned by a right angle.

    Departures from section 2.2: quadrants that growth does not reach in time do not prolong it; frames are the
    picture's, common to a class or each particle's own, as predicts best where other particles of the class are. A
    class of fewer than four particles, or without a list, is only told how far apart they are.

    Args:
        decomposition: the picture taken apart.

    Examples:
        >>> from jaxtex.particles.things import describe_particles
        >>> row, column = np.indices((60, 80))
        >>> labels = np.where((row % 12 < 8) & (column % 20 < 15), 1 + row // 12 * 4 + column // 20, 0)
        >>> learnt = learn_arrangement(describe_particles(labels, [0] * 20))
        >>> learnt.classes[0].lists[0][0]
        Cooccurrence(quadrant=1, dx=-1.0, dy=4.0)
    """
    kinds = [particle.kind for particle in decomposition.particles]
    return Arrangement(tuple(_learn_class(decomposition, kinds, kind) for kind in range(decomposition.kinds)))


def grow_to_others(labels: Labels, number: int, around: Sequence[slice], most: int) -> dict[int, int]:
    """After how many dilations by a square of 3 x 3 a particle reaches each of the others.

    That is the least chessboard distance between their pixels; it is taken from a distance transform of what is around.

    Args:
        labels: int [row, col], particles from 1, 0 is the background.
        number: of the particle that grows.
        around: the rows and columns that it lies in.
        most: dilations.

    Returns:
        Steps by the number of each particle that is reached.

    Examples:
        >>> grow_to_others(np.array([[1, 0, 0, 2, 0, 0, 0, 3]], np.int32), 1, (slice(0, 1), slice(0, 1)), 5)
        {2: 3}
    """
    window = labels[tuple(slice(max(0, each.start - most), each.stop + most) for each in around)]
    distance = distance_transform_cdt(window != number, "chessboard")
    near = (window > 0) & (window != number) & (distance <= most)
    others, which = np.unique(window[near], return_inverse=True)
    steps = np.full(len(others), most, np.intp)
    np.minimum.at(steps, which, distance[near])
    return dict(zip(others.tolist(), steps.tolist(), strict=True))


def find_neighbours(decomposition: Decomposition) -> dict[int, tuple[int, ...]]:
    """The neighbours of each complete particle, those that its list is made of, but for what is mirrored.

    Returns:
        By the particle's number, from 0, its neighbours' numbers, nearest first.

    Examples:
        >>> from jaxtex.particles.things import describe_particles
        >>> labels = np.zeros((9, 20), int)
        >>> labels[3:6, 3:6], labels[3:6, 9:12], labels[3:6, 15:18] = 1, 2, 3
        >>> find_neighbours(describe_particles(labels, [0, 0, 0]))
        {0: (1,), 1: (0, 2), 2: (1,)}
    """
    where = find_objects(decomposition.labels)
    by_kind: dict[int, list[int]] = {}
    for number, particle in enumerate(decomposition.particles):
        by_kind.setdefault(particle.kind, []).append(number)
    neighbours = {}
    for number, particle in enumerate(decomposition.particles):
        if particle.complete:
            seen = _find_neighbours(decomposition, by_kind[particle.kind], number, where[number])
            neighbours[number] = tuple(other for other, _ in _direct(decomposition, number, seen, 0.0))
    return neighbours


def _learn_class(decomposition: Decomposition, kinds: Sequence[int], kind: int) -> Listed | Scattered:
    boxes = [particle.box for particle in decomposition.particles]
    numbers = [number for number, each in enumerate(kinds) if each == kind]
    members = tuple(number for number in numbers if decomposition.particles[number].complete)
    density = _measure_density(decomposition, numbers, members)
    if len(numbers) >= _FEWEST:
        where = find_objects(decomposition.labels)
        seen = {number: _find_neighbours(decomposition, numbers, number, where[number]) for number in members}
        frames = _choose_frames(decomposition, numbers, seen)
        listed = {
            number: pairs
            for number in seen
            if (pairs := _list_neighbours(decomposition, number, seen[number], frames.of(boxes[number])))
        }
        if listed:
            index = {number: place for place, number in enumerate(members)}
            lists = tuple(tuple(entry for _, entry in pairs) for pairs in listed.values())
            neighbours = tuple(tuple(index.get(other, -1) for other, _ in pairs) for pairs in listed.values())
            owners = tuple(index[number] for number in listed)
            coherent = bool(np.mean(decomposition.labels > 0) >= _DENSE)
            closeness = _measure_closeness(decomposition, seen)
            companions = learn_companions(decomposition, kind, members)
            return Listed(members, lists, owners, neighbours, coherent, *frames, *closeness, *companions, density)
    height, width = decomposition.labels.shape
    apart = [hypot(boxes[i].x - boxes[j].x, boxes[i].y - boxes[j].y) for i, j in combinations(numbers, 2)]
    # Of a ring and what is in its middle, no distance is known.
    known = tuple(each for each in apart if each >= 1)
    return Scattered(members, known or (float(width), float(height)), density)


def _measure_density(decomposition: Decomposition, numbers: Sequence[int], members: Sequence[int]) -> float:
    """Particles per pixel; what the border cuts off counts by how much of it is there."""
    areas = [decomposition.particles[number].area for number in numbers]
    whole = [decomposition.particles[number].area for number in members]
    return sum(areas) / float(np.mean(whole or areas or [1])) / decomposition.labels.size


def _measure_closeness(decomposition: Decomposition, seen: dict[int, list[_Seen]]) -> tuple[float, float]:
    """How close neighbours are as a rule: pixels between boxes, and their overlap as a share."""
    particles = decomposition.particles
    forms = {number: form_of(particles[number].box) for number in seen}
    closest = []
    for number, found in seen.items():
        box = particles[number].box
        ways = [
            (
                particles[each.number].box.x - box.x,
                particles[each.number].box.y - box.y,
                forms[number],
                forms[each.number],
            )
            for each in found
            if each.number in forms
        ]
        if ways:
            closest.append((min(gap_between(*way) for way in ways), max(overlap_share(*way) for way in ways)))
    if not closest:
        return 0.0, 0.0
    gaps, shares = np.transpose(closest)
    return max(0.0, float(np.quantile(gaps, _CLOSEST))), max(0.0, float(np.median(shares)))


def _find_neighbours(
    decomposition: Decomposition, numbers: Sequence[int], number: int, around: Sequence[slice]
) -> list[_Seen]:
    """All others of the class that growth reaches in time, nearest first."""
    box = decomposition.particles[number].box
    most = int(_MOST_GROWTH * max(box.width, (decomposition.labels.size / len(numbers)) ** 0.5))
    reached = grow_to_others(decomposition.labels, number + 1, around, most)
    kind = decomposition.particles[number].kind
    same = [(after, other - 1) for other, after in reached.items() if decomposition.particles[other - 1].kind == kind]
    return [_Seen(other, after) for after, other in sorted(same)]


class _Frames(NamedTuple):
    turned: bool
    angle: float

    def of(self, box: Box) -> float:
        return box.angle if self.turned else self.angle


def _direct(decomposition: Decomposition, number: int, seen: Sequence[_Seen], angle: float) -> Iterator[tuple]:
    """Each neighbour reached by the time that the last quadrant is, with its co-occurrence."""
    box = decomposition.particles[number].box
    entries = [cooccurrence_of(box, decomposition.particles[each.number].box, angle) for each in seen]
    first = {entry.quadrant: each.steps for each, entry in reversed(list(zip(seen, entries, strict=True)))}
    last = max(first.values(), default=0)
    return ((each.number, entry) for each, entry in zip(seen, entries, strict=True) if each.steps <= last)


def _list_neighbours(
    decomposition: Decomposition, number: int, seen: Sequence[_Seen], angle: float
) -> tuple[tuple[int, Cooccurrence], ...]:
    """Co-occurrences, each with the number of the particle that it was seen of; -1 where it was made up."""
    found = list(_direct(decomposition, number, seen, angle))
    whole = [entry for other, entry in found if decomposition.particles[other].complete]
    cut = [entry for other, entry in found if not decomposition.particles[other].complete]
    pairs = [(other, entry) for other, entry in found if decomposition.particles[other].complete]
    for turn, source in ((2, whole), (0, cut), (2, cut), (1, None)):
        there = {entry.quadrant for _, entry in pairs}
        for entry in [each for _, each in pairs] if source is None else source:
            quadrant = (entry.quadrant + turn) % 4
            if quadrant not in there:
                gaps = (entry.dx, entry.dy) if turn != 1 else (entry.dy, entry.dx)
                pairs.append((-1, Cooccurrence(quadrant, *gaps)))
    return tuple(pairs)


def _choose_frames(decomposition: Decomposition, numbers: Sequence[int], seen: dict[int, list[_Seen]]) -> _Frames:
    """The frames in which the list of one particle tells best where others of its class have neighbours."""
    particles = decomposition.particles
    common = 0.5 * np.angle(sum(np.exp(2j * particles[number].box.angle) for number in seen) or 1.0)
    choices = [_Frames(False, 0.0), _Frames(False, float(common)), _Frames(True, 0.0)]
    tree = cKDTree([(particles[number].box.x, particles[number].box.y) for number in numbers])
    errors = [_predict(decomposition, tree, seen, frames) for frames in choices]
    best = int(np.argmin(errors))
    return choices[best if errors[best] < _CLEARLY * errors[0] else 0]


def _predict(decomposition: Decomposition, tree: cKDTree, seen: dict[int, list[_Seen]], frames: _Frames) -> float:
    """How far from any particle places are, as a rule, that one particle's list has for neighbours of another one."""
    height, width = decomposition.labels.shape
    boxes, around = [particle.box for particle in decomposition.particles], list(seen)
    forms = [form_of(box) for box in boxes]
    places = []
    for index, number in enumerate(around):
        found = list(_direct(decomposition, number, seen[number], frames.of(boxes[number])))
        for other in around[index + 1 : index + 1 + _COMPARED]:
            angle = frames.of(boxes[other])
            for neighbour, entry in found:
                dx, dy = place_neighbour(entry, forms[other], forms[neighbour], cos(angle), sin(angle))
                x, y = boxes[other].x + dx, boxes[other].y + dy
                if 0 <= x <= width and 0 <= y <= height:
                    places.append((x, y))
    return float(np.median(tree.query(places)[0])) if places else 0.0
