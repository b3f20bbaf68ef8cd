"""The particles of one class on a plane: each around another as lists have it, or in groups that are strewn."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from math import cos, sin, tau
from random import Random
from typing import NamedTuple

from jaxtex.particles.boxes import Form, overlap_share
from jaxtex.particles.companions import Companion
from jaxtex.particles.cooccurrences import Listed, Scattered, place_neighbour
from jaxtex.particles.plane import Grid, Plane
from jaxtex.particles.stock import Placed, Stock, Way, pick

_STALE = 0.01  # of all placed: if fewer than that are new in a round, it is the last
_PATIENCE = 30  # more rounds of that kind, where there are hardly any particles: some lists may lead nowhere
_HARDLY_ANY = 0.1  # of as many as there are in the picture

_TRIES = 12  # places that are tried around each particle of a class whose arrangement is not known
_THROWS = 200  # places that are tried for each group


class Sowing(NamedTuple):
    """What the particles of one class are placed by.

    Attributes:
        plane: the plane.
        grid: what is placed on it; it reaches as far as particles matter to each other.
        stock: the particles to choose from.
        most: how much footprints may overlap.
        rng: of all choices.
    """

    plane: Plane
    grid: Grid[Placed]
    stock: Stock
    most: float
    rng: Random


def sow_class(
    sowing: Sowing,
    rule: Listed | Scattered,
    forms: Sequence[Form],
    germ: tuple[float, float],
    enough: float,
    too_many: float,
) -> list[Placed]:
    """All particles that follow from the one at the germ, in the order in which they were placed.

    Two that were neighbours in the picture may be so again, however much their boxes overlap.

    Args:
        sowing: what they are placed by.
        rule: how the class is arranged.
        forms: the boxes of its particles, as in the picture.
        germ: the first one's place.
        enough: particles on the plane. Where there are fewer, each gets another turn, with another list.
        too_many: particles on the plane, upon which it is given up.
    """
    plane, grid, stock, rng = sowing.plane, sowing.grid, sowing.stock, sowing.rng
    ways = _listed_ways(rule, forms, rng) if isinstance(rule, Listed) else _scattered_ways(rule, rng)
    found = [stock.stand(*germ)]
    stock.settle()
    grid.add(*germ, found[0])
    idle, there = 0, 1
    while True:
        before, queue = len(found), deque(found)
        while queue:
            parent = queue.popleft()
            for way in ways(parent):
                child = stock.step(parent, way)
                seen = plane.contains(child.x, child.y, child.thing.reach * child.local.size)
                if seen and not _is_taken(sowing, child, parent if way.which >= 0 else None):
                    stock.settle()
                    grid.add(child.x, child.y, child)
                    found.append(child)
                    queue.append(child)
                    there += plane.contains(child.x, child.y)
            if there > too_many:
                return found
        idle = idle + 1 if len(found) - before <= _STALE * len(found) else 0
        if there >= enough or idle > (_PATIENCE if there < _HARDLY_ANY * enough else 0):
            return found


def sow_groups(
    sowing: Sowing,
    groups: Sequence[Sequence[Companion]],
    germ: tuple[float, float],
    count: int,
    margin: float,
) -> list[Placed]:
    """Groups strewn at random, the first at the germ, each as often, those before others that come before them.

    Args:
        sowing: what they are placed by.
        groups: of particles, each as they are to each other.
        germ: the first one's place.
        count: particles, if there is room.
        margin: how far from the plane particles may be that are seen on it, in pixels.
    """
    plane, stock, rng = sowing.plane, sowing.stock, sowing.rng
    found: list[Placed] = []
    place: tuple[float, float] | None = germ
    for group, copies in zip(groups, _share_out(groups, count, rng), strict=True):
        tries = _THROWS * copies
        while copies and tries:
            x, y = place or (
                rng.uniform(-margin, plane.width + margin),
                rng.uniform(-margin, plane.height + margin),
            )
            if place is None and rng.random() >= stock.abundance(x, y):
                continue
            place, tries = None, tries - 1
            placed = _stand_together(stock, group, x, y)
            if not any(_is_taken(sowing, each) for each in placed):
                for each in placed:
                    sowing.grid.add(each.x, each.y, each)
                found += placed
                copies -= 1
    return found


def count_inside(plane: Plane, found: Sequence[Placed]) -> int:
    """How many have their centres on the plane."""
    return sum(plane.contains(each.x, each.y) for each in found)


def _share_out(groups: Sequence[Sequence[Companion]], count: int, rng: Random) -> list[int]:
    """How often each group comes, so that there are about so many particles and each group as often."""
    each, rest = divmod(count, sum(map(len, groups)))
    copies = [each] * len(groups)
    for number in rng.sample(range(len(groups)), len(groups)):
        if rest >= len(groups[number]):
            copies[number] += 1
            rest -= len(groups[number])
    return copies


def _stand_together(stock: Stock, group: Sequence[Companion], x: float, y: float) -> list[Placed]:
    first = stock.stand(x, y, group[0].which)
    ways = (Way(lambda _, way=(each.x, each.y): way, each.which) for each in group[1:])  # type: ignore[misc]
    return [first, *(stock.step(first, way) for way in ways)]


def _is_taken(sowing: Sowing, child: Placed, parent: Placed | None = None) -> bool:
    """Whether a particle would overlap one that is there, but for its parent, by too much, or come too close to it."""
    x, y, footprint, reach, room = child.x, child.y, child.footprint, child.reach, child.room
    difference, most = sowing.plane.difference, sowing.most
    for each in sowing.grid.near(x, y):
        if each is parent:
            continue
        dx, dy = difference(each.x, each.y, x, y)
        square = dx * dx + dy * dy
        if square < max(each.room, room) ** 2 or (
            square < (each.reach + reach) ** 2 and overlap_share(dx, dy, each.footprint, footprint) > most
        ):
            return True
    return False


def _listed_ways(rule: Listed, forms: Sequence[Form], rng: Random) -> Callable[[Placed], Iterator[Way]]:
    """Around a particle, the places that a list of its class has for neighbours: its own list, if it comes with those
    that were around it in the picture, or any."""
    common = (cos(rule.angle), sin(rule.angle))
    own_list = {owner: number for number, owner in enumerate(rule.owners)} if rule.coherent else {}

    def ways(parent: Placed) -> Iterator[Way]:
        own, which = parent.thing.form, parent.thing.which
        frame = (forms[which].cosine, forms[which].sine) if rule.turned else common
        number = own_list.get(which, -1)
        others: Sequence[int] | None = rule.neighbours[number] if number >= 0 else None
        entries = rule.lists[number if number >= 0 else pick(rng, len(rule.lists))]
        for index, entry in enumerate(entries):
            follow = partial(place_neighbour, entry, own, cosine=frame[0], sine=frame[1])
            yield Way(follow, -1 if others is None else others[index])

    return ways


def _scattered_ways(rule: Scattered, rng: Random) -> Callable[[Placed], Iterator[Way]]:
    """Around a particle, places in any direction, as far away as one of the picture's distances."""

    def ways(parent: Placed) -> Iterator[Way]:
        for _ in range(_TRIES):
            angle, distance = tau * rng.random(), rule.distances[pick(rng, len(rule.distances))]
            way = (distance * cos(angle), distance * sin(angle))
            yield Way(lambda form, way=way: way)  # type: ignore[misc]

    return ways
