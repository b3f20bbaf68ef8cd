"""Which particles of a picture are each other's nearest, and how much room each has around it."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from jaxtex.particles.patterns import Pattern, find_nearest, pattern_of_picture
from jaxtex.particles.things import Decomposition

Floats = npt.NDArray[np.floating]


class Companion(NamedTuple):
    """A particle of a group.

    Attributes:
        which: its index among the members of its class.
        x, y: the way to it from the first of its group, centre to centre, in pixels.
    """

    which: int
    x: float
    y: float


class Companions(NamedTuple):
    """What is known of the nearest ones of a class's members.

    Attributes:
        rooms: how far each is from its nearest one, centre to centre, in pixels.
        groups: members, so that each has what is nearest to it in its own group, as far as that is known; each member
            is in one.
    """

    rooms: tuple[float, ...]
    groups: tuple[tuple[Companion, ...], ...]


def learn_companions(decomposition: Decomposition, kind: int, members: Sequence[int]) -> Companions:
    """Learn how far the particles of a class are from their nearest ones, and which these are.

    What is nearest may be out of sight where the picture's border is nearer than what is seen. Then it is taken to be
    as far as the median of those known distances that are possible.

    Args:
        decomposition: the picture taken apart.
        kind: a class.
        members: numbers of particles of that class.

    Examples:
        >>> from jaxtex.particles.things import describe_particles
        >>> labels = np.zeros((30, 50), int)
        >>> labels[10:13, 13:16], labels[10:13, 19:22], labels[24:27, 33:36] = 1, 2, 3
        >>> learnt = learn_companions(describe_particles(labels, [0, 0, 0]), 0, [0, 1, 2])
        >>> learnt.rooms
        (6.0, 6.0, 6.0)
        >>> learnt.groups[0]
        (Companion(which=0, x=0.0, y=0.0), Companion(which=1, x=6.0, y=0.0))
    """
    pattern = pattern_of_picture(decomposition)
    nearest = _know_nearest(pattern, kind)
    known = np.array([distance for _, distance in nearest.values()])
    points = pattern.points[pattern.known & (pattern.kinds == kind)]
    rooms = (nearest[each][1] if each in nearest else _guess_room(pattern, each, points, known) for each in members)
    return Companions(tuple(rooms), _group(pattern.points, members, nearest))


def _group(
    points: Floats, members: Sequence[int], nearest: dict[int, tuple[int, float]]
) -> tuple[tuple[Companion, ...], ...]:
    index = {number: place for place, number in enumerate(members)}
    links = [(index[each], index[other]) for each, (other, _) in nearest.items() if {each, other} <= index.keys()]
    graph = csr_array((np.ones(len(links)), np.array(links, int).reshape(-1, 2).T), (len(members), len(members)))
    count, belongs = connected_components(graph, directed=False)
    places, groups = points[list(members)], []
    for number in range(count):
        whiches = np.flatnonzero(belongs == number)
        ways = places[whiches] - places[whiches[:1]]
        groups.append(tuple(Companion(*each) for each in zip(whiches.tolist(), *ways.T.tolist(), strict=True)))
    return tuple(groups)


def _know_nearest(pattern: Pattern, kind: int) -> dict[int, tuple[int, float]]:
    """To the points whose nearest one of their class is certain, which that is and how far."""
    found = find_nearest(pattern, kind, kind, 1)
    certain = found.weights[:, 0] > 0
    distances = np.hypot(found.ways[certain, 0, 0], found.ways[certain, 0, 1]).tolist()
    others = zip(found.which[certain, 0].tolist(), distances, strict=True)
    return dict(zip(found.around[certain].tolist(), others, strict=True))


def _guess_room(pattern: Pattern, number: int, points: Floats, known: Floats) -> float:
    here, low, high = pattern.points[number], np.array(pattern.low), np.array(pattern.high)
    border = max(0.0, float(np.minimum(here - low, high - here).min()))
    seen = np.sort(np.hypot(*(points - here[None]).T))[1:2]  # the first is the point itself
    furthest = float(seen[0]) if len(seen) else np.inf
    possible = known[(known >= border) & (known <= furthest)]
    usual = float(np.median(possible if len(possible) else known)) if len(known) else 1.0
    return min(max(usual, border), furthest)
