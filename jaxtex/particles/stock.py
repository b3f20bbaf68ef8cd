"""The particles of a class to choose from: which one stands at a place, how large, and what it keeps free there."""

from collections.abc import Callable, Sequence
from math import cos, hypot, remainder, sin, tau
from random import Random
from typing import NamedTuple, Protocol

from jaxtex.particles.boxes import Form
from jaxtex.particles.plane import Plane
from jaxtex.particles.terrain import EVEN, Local, Terrain

_BEYOND = 1 + 1e-6  # times the least distance: how far a neighbour goes, so that rounding does not matter
_TINY = 1e-6  # pixels


class Thing(NamedTuple):
    """A particle that may be placed, in the picture's pixels.

    Attributes:
        which: its index among the members of its class.
        form: its box as it is in the picture, from which neighbours are sought.
        footprint: its box, as chance has made it, with half of what boxes keep free between them.
        reach: how far that box reaches from its centre.
        room: how far its centre is from others' at least.
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
        room: how far its centre is from others' at least there.
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
        self._card, self._place = -1, -1  # the last one, and where it is among the cards, if that is known

    def draw(self) -> int:
        """A card of chance, which stays in the deck for now."""
        self._place = pick(self._rng, len(self._cards))
        return self._cards[self._place]

    def choose(self, which: int) -> int:
        """A certain card, which need not be in the deck any more."""
        self._card, self._place = which, -1
        return which

    def take(self) -> None:
        """Take away the card that was drawn or chosen last, if it is there. Before only those are left that hardly ever
        find room, the deck is filled up."""
        if self._place < 0 and self._card in self._cards:
            self._place = self._cards.index(self._card)
        if self._place >= 0:
            self._cards[self._place] = self._cards[-1]
            self._cards.pop()
            if 2 * len(self._cards) < self._count:
                self._cards += range(self._count)
        self._place = -1


class Stock(Protocol):
    """Particles that are chosen at places of a plane."""

    def stand(self, x: float, y: float, which: int = -1) -> Placed:
        """A particle at a place, that one, or one of chance."""

    def step(self, parent: Placed, way: Way) -> Placed:
        """A particle at the end of a way from another: the one that the way leads to, or one of chance."""

    def settle(self) -> None:
        """The last of these has found room."""

    def throws(self, margin: float) -> Callable[[], tuple[float, float]]:
        """What gives places at random, as often as particles are asked for there, up to a margin around the plane."""


class EvenStock:
    """All particles are as in the picture, and as likely.

    Args:
        plane: the plane.
        forms: the boxes of the class's particles.
        clearance: pixels between boxes.
        rooms: how far each one's centre is from others' at least, in pixels.
        rng: of the choices.
    """

    def __init__(
        self, plane: Plane, forms: Sequence[Form], clearance: float, rooms: Sequence[float], rng: Random
    ) -> None:
        self._plane, self._rng, self._deck = plane, rng, Deck(len(forms), rng)
        self._things = [
            make_thing(which, form, clearance, room)
            for which, (form, room) in enumerate(zip(forms, rooms, strict=True))
        ]
        self._reaches = [hypot(thing.footprint.across, thing.footprint.down) for thing in self._things]

    def stand(self, x: float, y: float, which: int = -1) -> Placed:
        return self._place(self._draw(which), x, y)

    def step(self, parent: Placed, way: Way) -> Placed:
        thing = self._draw(way.which)
        dx, dy = way.follow(thing.form)
        return self._place(thing, *self._plane.wrap(parent.x + dx, parent.y + dy))

    def settle(self) -> None:
        self._deck.take()

    def throws(self, margin: float) -> Callable[[], tuple[float, float]]:
        plane, rng = self._plane, self._rng
        return lambda: (rng.uniform(-margin, plane.width + margin), rng.uniform(-margin, plane.height + margin))

    def _draw(self, which: int) -> Thing:
        return self._things[self._deck.draw() if which < 0 else self._deck.choose(which)]

    def _place(self, thing: Thing, x: float, y: float) -> Placed:
        return Placed(x, y, thing, EVEN, thing.footprint, self._reaches[thing.which], thing.room)


class UnevenStock:
    """Particles are as controls ask for at each place.

    Lists are followed in the picture's pixels. What is asked for at a place turns and scales the way from there, as if
    the picture were laid out on a plane of other measures; of a way's two ends, the mean counts.

    Args:
        plane: the plane.
        forms: the boxes of the class's particles.
        clearance: pixels between boxes.
        rooms: how far each one's centre is from others' at least, in pixels.
        rng: of the choices.
        terrain: what controls ask for.
    """

    def __init__(
        self,
        plane: Plane,
        forms: Sequence[Form],
        clearance: float,
        rooms: Sequence[float],
        rng: Random,
        terrain: Terrain,
    ) -> None:
        self._wrap, self._rng, self._terrain = plane.wrap, rng, terrain
        self._deck = Deck(len(forms), rng)
        self._forms, self._clearance, self._rooms = forms, clearance, rooms

    def stand(self, x: float, y: float, which: int = -1) -> Placed:
        return self._place(self._choose(self._terrain.at(x, y), which), x, y)

    def step(self, parent: Placed, way: Way) -> Placed:
        # Whoever is chosen, it will be about where one like the parent would be.
        there = self._terrain.at(*_follow(parent, parent.local, *way.follow(parent.thing.form)))
        thing = self._choose(there, way.which)
        return self._place(thing, *self._wrap(*_follow(parent, there, *way.follow(thing.form))))

    def settle(self) -> None:
        self._deck.take()

    def throws(self, margin: float) -> Callable[[], tuple[float, float]]:
        return self._terrain.throws(margin, self._rng)

    def _choose(self, local: Local, which: int) -> Thing:
        rng = self._rng
        if local.regions:  # weights may speak against the one that was there
            (which,) = rng.choices(range(len(self._forms)), cum_weights=self._terrain.chances(local.regions))
        which = self._deck.draw() if which < 0 else self._deck.choose(which)
        form = self._forms[which]
        if local.size_variation == 0 and local.orientation_variation == 0:
            return make_thing(which, form, self._clearance, self._rooms[which])
        scale = 1.0 + local.size_variation * rng.uniform(-1.0, 1.0)
        turn = local.orientation_variation * rng.uniform(-1.0, 1.0)
        # Neighbours are sought as if nothing were changed, so that the arrangement stays what it is.
        varied = make_thing(which, form.changed(scale, turn), self._clearance, self._rooms[which], scale, turn)
        return varied._replace(form=form)

    def _place(self, thing: Thing, x: float, y: float) -> Placed:
        local = self._terrain.at(x, y)
        footprint = thing.footprint.changed(local.spacing, local.orientation)
        room = max(thing.room * local.spacing, local.least_distance)
        return Placed(x, y, thing, local, footprint, hypot(footprint.across, footprint.down), room)


def make_thing(which: int, form: Form, clearance: float, room: float, scale: float = 1.0, turn: float = 0.0) -> Thing:
    """A particle of a form that chance has already changed."""
    return Thing(which, form, form.grown(0.5 * clearance), hypot(form.across, form.down), room, scale, turn)


def pick(rng: Random, count: int) -> int:
    """A number below a count."""
    return int(rng.random() * count)


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
