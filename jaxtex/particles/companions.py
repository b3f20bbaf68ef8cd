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


def measure_rooms(decomposition: Decomposition, kind: int, members: Sequence[int]) -> tuple[float, ...]:
    """How far particles are from the nearest ones of their class, centre to centre, in pixels.

    What is nearest may be out of sight where the picture's border is nearer than what is seen. Then it is taken to be
    as far as the median of those known distances that are possible.

    Args:
        decomposition: the picture taken apart.
        kind: a class.
        members: numbers of particles of that class.

    Examples:
        >>> from jaxtex.particles.things import describe_particles
        >>> labels = np.zeros((30, 40), int)
        >>> labels[14:17, 10:13], labels[14:17, 16:19], labels[14:17, 23:26] = 1, 2, 3
        >>> measure_rooms(describe_particles(labels, [0, 0, 0]), 0, [0, 1, 2])
        (6.0, 6.0, 7.0)
    """
    pattern = pattern_of_picture(decomposition)
    nearest = _know_nearest(pattern, kind)
    known = np.array([distance for _, distance in nearest.values()])
    points = pattern.points[pattern.known & (pattern.kinds == kind)]
    return tuple(nearest[each][1] if each in nearest else _guess_room(pattern, each, points, known) for each in members)


def group_companions(
    decomposition: Decomposition, kind: int, members: Sequence[int]
) -> tuple[tuple[Companion, ...], ...]:
    """Particles in groups, so that each has what is nearest to it in its own, as far as that is known.

    Args:
        decomposition: the picture taken apart.
        kind: a class.
        members: numbers of particles of that class.

    Returns:
        Groups, of which each member is in one.

    Examples:
        >>> from jaxtex.particles.things import describe_particles
        >>> labels = np.zeros((30, 50), int)
        >>> labels[10:13, 13:16], labels[10:13, 19:22], labels[24:27, 33:36] = 1, 2, 3
        >>> (pair, single) = group_companions(describe_particles(labels, [0, 0, 0]), 0, [0, 1, 2])
        >>> pair
        (Companion(which=0, x=0.0, y=0.0), Companion(which=1, x=6.0, y=0.0))
    """
    pattern, index = pattern_of_picture(decomposition), {number: place for place, number in enumerate(members)}
    links = [
        (index[each], index[other])
        for each, (other, _) in _know_nearest(pattern, kind).items()
        if each in index and other in index
    ]
    graph = csr_array((np.ones(len(links)), np.array(links, int).reshape(-1, 2).T), (len(members), len(members)))
    count, belongs = connected_components(graph, directed=False)
    points = pattern.points[list(members)]
    groups = []
    for number in range(count):
        whiches = np.flatnonzero(belongs == number)
        ways = points[whiches] - points[whiches[:1]]
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
    usual = float(np.median(possible if len(possible) else known)) if len(known) else max(border, 1.0)
    return min(usual, furthest)
