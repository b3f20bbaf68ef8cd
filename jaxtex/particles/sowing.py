"""The particles of one class on a plane: each around another as lists have it, or in groups that are strewn."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
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
_THROWS = 50  # places that are tried for each group
_NEARLY = 0.98  # of the particles that are asked for in groups: enough


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

    The boxes of two that were neighbours in the picture may overlap as they do there.

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
                known = (parent,) if child.thing.which == way.which and _is_as_known(plane, parent, child, way) else ()
                if _is_seen(plane, child) and not _is_taken(sowing, child, grid.near(child.x, child.y), known):
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
) -> tuple[list[Placed], bool]:
    """Groups strewn at random, the first at the germ, each about as often; those before others come before them.

    Args:
        sowing: what they are placed by.
        groups: of particles, each as they are to each other.
        germ: the first one's place.
        count: about so many particles.
        margin: how far from the plane groups are placed, too, in pixels.

    Returns:
        Those that are seen, and whether there was room for nearly as many as were asked for; if not, it was given up.
    """
    throw = sowing.stock.throws(margin)
    copies = _share_out(groups, count, sowing.rng)
    missing = (1 - _NEARLY) * sum(len(group) * wanted for group, wanted in zip(groups, copies, strict=True))
    found: list[Placed] = []
    place = germ
    for group, wanted in zip(groups, copies, strict=True):
        left, tries = wanted, _THROWS * wanted
        while left and tries:
            placed = _stand_together(sowing, group, *place)
            for each in placed:
                sowing.grid.add(each.x, each.y, each)
            found += placed
            left, tries, place = left - bool(placed), tries - 1, throw()
        missing -= left * len(group)
        if missing < 0:
            break
    return [each for each in found if _is_seen(sowing.plane, each)], missing >= 0


def count_inside(plane: Plane, found: Sequence[Placed]) -> int:
    """How many have their centres on the plane."""
    return sum(plane.contains(each.x, each.y) for each in found)


def _share_out(groups: Sequence[Sequence[Companion]], count: int, rng: Random) -> list[int]:
    """How often each group comes, so that there are about so many particles and each group as often."""
    each, rest = divmod(count, sum(map(len, groups)))
    copies = [each] * len(groups)
    for number in rng.sample(range(len(groups)), len(groups)):
        # A group that is too long comes as often as not, so that small planes are not without long groups.
        if rest >= len(groups[number]) or rng.random() * len(groups[number]) < rest:
            copies[number] += 1
            rest -= min(rest, len(groups[number]))
    return copies if any(copies) else [1, *copies[1:]]


def _stand_together(sowing: Sowing, group: Sequence[Companion], x: float, y: float) -> list[Placed]:
    """A group whose first particle is at a place; nothing if any of it has no room."""
    stock, placed = sowing.stock, list[Placed]()
    for which, dx, dy in group:
        # All are sought from the first.
        each = stock.step(placed[0], _make_way(dx, dy, which)) if placed else stock.stand(x, y, which)
        known = [
            other
            for other, companion in zip(placed, group, strict=False)
            if (other.thing.which, each.thing.which) == (companion.which, which)
            and _is_as_known(sowing.plane, other, each, _make_way(dx - companion.x, dy - companion.y, which))
        ]
        if _is_taken(sowing, each, sowing.grid.near(each.x, each.y)) or _is_taken(sowing, each, placed, known):
            return []
        placed.append(each)
    return placed


def _make_way(dx: float, dy: float, which: int) -> Way:
    return Way(lambda _: (dx, dy), which)


def _is_as_known(plane: Plane, parent: Placed, child: Placed, way: Way) -> bool:
    """Whether two are beside each other as in the picture: unchanged by chance, and not around the plane."""
    unchanged = all(each.thing.scale == 1 and each.thing.turn == 0 for each in (parent, child))
    return unchanged and not plane.turns_back(*(child.local.spacing * each for each in way.follow(child.thing.form)))


def _is_seen(plane: Plane, placed: Placed) -> bool:
    return plane.contains(placed.x, placed.y, placed.thing.reach * placed.local.size)


def _is_taken(sowing: Sowing, child: Placed, others: Iterable[Placed], known: Sequence[Placed] = ()) -> bool:
    """Whether a particle would come too close to one of others, or overlap one by too much that is not a known one."""
    x, y, footprint, reach, room = child.x, child.y, child.footprint, child.reach, child.room
    difference, most = sowing.plane.difference, sowing.most
    for each in others:
        dx, dy = difference(each.x, each.y, x, y)
        square = dx * dx + dy * dy
        if square < max(each.room, room) ** 2:
            return True
        if (
            square < (each.reach + reach) ** 2
            and overlap_share(dx, dy, each.footprint, footprint) > most
            and not any(each is other for other in known)
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
            yield _make_way(distance * cos(angle), distance * sin(angle), -1)

    return ways
