"""The particles of one class, each placed around another as lists have it, where there is room."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from math import cos, hypot, remainder, sin, tau
from random import Random
from typing import NamedTuple, Protocol

from jaxtex.particles.boxes import Form, overlap_share
from jaxtex.particles.cooccurrences import Listed, Scattered, place_neighbour
from jaxtex.particles.plane import Grid, Plane
from jaxtex.particles.terrain import EVEN, Local, Terrain

_STALE = 0.01  # of all placed: if fewer than that are new in a round, it is the last
_PATIENCE = 30  # more rounds of that kind, where there are hardly any particles: some lists may lead nowhere
_HARDLY_ANY = 0.1  # of as many as there are in the picture

_TRIES = 12  # places that are tried around each particle of a class whose arrangement is not known
_BEYOND = 1 + 1e-6  # times the least distance: how far a neighbour goes, so that rounding does not matter
_TINY = 1e-6  # pixels


class Thing(NamedTuple):
    """A particle that may be placed, in the picture's pixels.

    Attributes:
        which: its index in the class.
        form: its box as it is in the picture, from which neighbours are sought.
        footprint: its box, as chance has made it, with half of what boxes keep free between them.
        reach: how far that box reaches from its centre.
        room: half of how far centres are from each other.
        scale, turn: what chance has made of it: a factor and radians.
    """

    which: int
    form: Form
    footprint: Form
    reach: float
    room: float
    scale: float
    turn: float


class Placed(NamedTuple):
    """A thing on the plane.

    Attributes:
        x, y: its centre.
        thing: what it is.
        local: what is asked for there.
        footprint: what it keeps free there, and `reach`, how far that goes from its centre.
        room: half of how far centres are from each other there.
    """

    x: float
    y: float
    thing: Thing
    local: Local
    footprint: Form
    reach: float
    room: float


class Way(NamedTuple):
    """From a particle to a neighbour.

    Attributes:
        follow: to one of a form, along x and y, in the picture's pixels.
        which: the neighbour's index in the class; -1 is any.
    """

    follow: Callable[[Form], tuple[float, float]]
    which: int = -1


class Deck:
    """Particles to choose from, as cards. Who finds no room is put back, so that large ones, which seldom do, become as
    many as in the picture.

    Args:
        count: how many there are.
        rng: of the choices.
    """

    def __init__(self, count: int, rng: Random) -> None:
        self._count, self._rng = count, rng
        self._cards = list(range(count))
        self._drawn = -1

    def draw(self) -> int:
        """A card of chance, which stays in the deck for now."""
        self._drawn = pick(self._rng, len(self._cards))
        return self._cards[self._drawn]

    def pass_by(self) -> None:
        """Nothing was drawn: someone was chosen otherwise."""
        self._drawn = -1

    def take(self) -> None:
        """Take away the card that was drawn last. Before only those are left that hardly ever find room, the deck is
        filled up."""
        if self._drawn >= 0:
            self._cards[self._drawn] = self._cards[-1]
            self._cards.pop()
            if 2 * len(self._cards) < self._count:
                self._cards += range(self._count)
        self._drawn = -1


class Ground(Protocol):
    """How a class stands on the plane: which particles are chosen at a place, and how large and far apart they are."""

    def stand(self, x: float, y: float) -> Placed:
        """A particle of chance at a place."""

    def step(self, parent: Placed, way: Way) -> Placed:
        """A particle at the end of a way from another: the one that the way leads to, or one of chance."""

    def settle(self) -> None:
        """The last of these has found room."""


class EvenGround:
    """All particles are as in the picture, and as likely.

    Args:
        plane: the plane.
        forms: the boxes of the class's particles.
        clearance: pixels between boxes.
        apart: pixels between centres.
        rng: of the choices.
    """

    def __init__(self, plane: Plane, forms: Sequence[Form], clearance: float, apart: float, rng: Random) -> None:
        self._wrap, self._deck = plane.wrap, Deck(len(forms), rng)
        self._things = [make_thing(which, form, clearance, 0.5 * apart) for which, form in enumerate(forms)]
        self._reaches = [hypot(thing.footprint.across, thing.footprint.down) for thing in self._things]

    def stand(self, x: float, y: float) -> Placed:
        return self._place(self._things[self._deck.draw()], x, y)

    def step(self, parent: Placed, way: Way) -> Placed:
        which = way.which
        if which < 0:
            which = self._deck.draw()
        else:
            self._deck.pass_by()
        thing = self._things[which]
        dx, dy = way.follow(thing.form)
        return self._place(thing, *self._wrap(parent.x + dx, parent.y + dy))

    def settle(self) -> None:
        self._deck.take()

    def _place(self, thing: Thing, x: float, y: float) -> Placed:
        return Placed(x, y, thing, EVEN, thing.footprint, self._reaches[thing.which], thing.room)


class UnevenGround:
    """Particles are as controls ask for at each place.

    Lists are followed in the picture's pixels. What is asked for at a place turns and scales the way from there, as if
    the picture were laid out on a plane of other measures; of a way's two ends, the mean counts.

    Args:
        plane: the plane.
        forms: the boxes of the class's particles.
        clearance: pixels between boxes.
        apart: pixels between centres.
        rng: of the choices.
        terrain: what controls ask for.
    """

    def __init__(
        self, plane: Plane, forms: Sequence[Form], clearance: float, apart: float, rng: Random, terrain: Terrain
    ) -> None:
        self._wrap, self._rng, self._terrain = plane.wrap, rng, terrain
        self._deck = Deck(len(forms), rng)
        self._forms, self._clearance, self._room = forms, clearance, 0.5 * apart

    def stand(self, x: float, y: float) -> Placed:
        return self._place(self._choose(self._terrain.at(x, y), -1), x, y)

    def step(self, parent: Placed, way: Way) -> Placed:
        # Whoever is chosen, it will be about where one like the parent would be.
        there = self._terrain.at(*_follow(parent, parent.local, *way.follow(parent.thing.form)))
        thing = self._choose(there, way.which)
        return self._place(thing, *self._wrap(*_follow(parent, there, *way.follow(thing.form))))

    def settle(self) -> None:
        self._deck.take()

    def _choose(self, local: Local, which: int) -> Thing:
        rng = self._rng
        self._deck.pass_by()
        if local.regions:  # weights may speak against the one that was there
            (which,) = rng.choices(range(len(self._forms)), cum_weights=self._terrain.chances(local.regions))
        elif which < 0:
            which = self._deck.draw()
        form = self._forms[which]
        if local.size_variation == 0 and local.orientation_variation == 0:
            return make_thing(which, form, self._clearance, self._room)
        scale = 1.0 + local.size_variation * rng.uniform(-1.0, 1.0)
        turn = local.orientation_variation * rng.uniform(-1.0, 1.0)
        # Neighbours are sought as if nothing were changed, so that the arrangement stays what it is.
        varied = make_thing(which, form.changed(scale, turn), self._clearance, self._room, scale, turn)
        return varied._replace(form=form)

    def _place(self, thing: Thing, x: float, y: float) -> Placed:
        local = self._terrain.at(x, y)
        footprint = thing.footprint.changed(local.spacing, local.orientation)
        room = max(thing.room * local.spacing, 0.5 * local.least_distance)
        return Placed(x, y, thing, local, footprint, hypot(footprint.across, footprint.down), room)


class Sowing(NamedTuple):
    """What the particles of one class are placed by.

    Attributes:
        plane: the plane.
        grid: what is placed on it; it reaches as far as particles matter to each other.
        ground: how particles stand there.
        most: how much footprints may overlap.
        rng: of all choices.
    """

    plane: Plane
    grid: Grid[Placed]
    ground: Ground
    most: float
    rng: Random


def make_thing(which: int, form: Form, clearance: float, room: float, scale: float = 1.0, turn: float = 0.0) -> Thing:
    """A particle of a form that chance has already changed."""
    return Thing(which, form, form.grown(0.5 * clearance), hypot(form.across, form.down), room, scale, turn)


def sow_class(
    sowing: Sowing, rule: Listed | Scattered, forms: Sequence[Form], germ: tuple[float, float], enough: float
) -> list[Placed]:
    """All particles that follow from the one at the germ, in the order in which they were placed.

    Args:
        sowing: what they are placed by.
        rule: how the class is arranged.
        forms: the boxes of its particles, as in the picture.
        germ: the first one's place.
        enough: particles on the plane. Where there are fewer, each gets another turn, with another list.
    """
    plane, grid, ground, rng = sowing.plane, sowing.grid, sowing.ground, sowing.rng
    ways = _listed_ways(rule, forms, rng) if isinstance(rule, Listed) else _scattered_ways(rule, rng)
    found = [ground.stand(*germ)]
    ground.settle()
    grid.add(*germ, found[0])
    idle = 0
    while True:
        before, queue = len(found), deque(found)
        while queue:
            parent = queue.popleft()
            for way in ways(parent):
                child = ground.step(parent, way)
                seen = plane.contains(child.x, child.y, child.thing.reach * child.local.size)
                if seen and not _is_taken(sowing, child):
                    ground.settle()
                    grid.add(child.x, child.y, child)
                    found.append(child)
                    queue.append(child)
        there = count_inside(plane, found)
        idle = idle + 1 if len(found) - before <= _STALE * len(found) else 0
        if there >= enough or idle > (_PATIENCE if there < _HARDLY_ANY * enough else 0):
            return found


def count_inside(plane: Plane, found: Sequence[Placed]) -> int:
    """How many have their centres on the plane."""
    return sum(plane.contains(each.x, each.y) for each in found)


def pick(rng: Random, count: int) -> int:
    """A number below a count."""
    return int(rng.random() * count)


def _is_taken(sowing: Sowing, child: Placed) -> bool:
    """Whether a particle would overlap one that is there by too much, or come too close to one."""
    x, y, footprint, reach, room = child.x, child.y, child.footprint, child.reach, child.room
    difference, most = sowing.plane.difference, sowing.most
    for each in sowing.grid.near(x, y):
        dx, dy = difference(each.x, each.y, x, y)
        square = dx * dx + dy * dy
        if square < (each.room + room) ** 2 or (
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


def _follow(parent: Placed, there: Local, dx: float, dy: float) -> tuple[float, float]:
    """Where a way ends that is turned and scaled as is asked for at its ends, on average, and long enough."""
    here = parent.local
    angle = here.orientation + 0.5 * remainder(there.orientation - here.orientation, tau)
    spacing = 0.5 * (here.spacing + there.spacing)
    least = 0.5 * (here.least_distance + there.least_distance)
    if least > 0.0:
        # Neighbours that would come too close go further away, as else particles would not spread.
        spacing = max(spacing, _BEYOND * least / max(hypot(dx, dy), _TINY))
    along, aslant = spacing * cos(angle), spacing * sin(angle)
    return parent.x + dx * along - dy * aslant, parent.y + dx * aslant + dy * along
