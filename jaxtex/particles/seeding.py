"""Particles placed anew as they were arranged in the picture: propagated over a plane from one germ.

J.-M. Dischler, K. Maritaud, B. Lévy and D. Ghazanfarpour, "Texture particles" (Eurographics 2002), section 2.2.
"""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from math import cos, hypot, sin, tau
from random import Random
from typing import NamedTuple

import jax
import numpy as np
from jax import Array

from jaxtex.particles.boxes import Form, form_of, overlap_share
from jaxtex.particles.composition import Composition, identify_exemplar
from jaxtex.particles.cooccurrences import Arrangement, Listed, Scattered, place_neighbour
from jaxtex.particles.plane import Grid, Plane
from jaxtex.particles.things import Decomposition

MOST_OVERLAP = 0.12
"""Of the smaller of two boxes with their clearance, along the axis that tells them apart best: by how much they may
overlap at most (see `overlap_share`), beyond how much they do in the picture. Section 2.2 says: not too much."""

LEAST_DISTANCE = 0.85
"""Of how far neighbours are from each other as a rule, centre to centre: how close they may come."""

_LEAST_ROOM = 0.25
"""Of the side of the square that each particle has on average: how close none comes to another. Things strewn at random
keep no distance at all, and would find room without end."""

_SURPLUS = 1.15  # times the picture's density: where more have found room, some are taken away
_STALE = 0.01  # of all placed: if fewer than that are new in a round, it is the last

_TRIES = 12  # places that are tried around each particle of a class whose arrangement is not known

Admit = Callable[[int, float, float], bool]
"""Whether particles of a class may be seen at a place (x, y)."""


_Propose = Callable[[int, float, float], Iterator[tuple[int, float, float]]]
"""From a particle to those that may stand around it; each is its index in the class, x and y."""


class _Placed(NamedTuple):
    x: float
    y: float
    which: int
    footprint: Form


class _Sowing(NamedTuple):
    """What the particles of one class are placed by.

    `apart` is how close centres may come, `most` how much footprints may overlap, `reach` how far away those can be.
    """

    plane: Plane
    grid: Grid[_Placed]
    forms: tuple[Form, ...]
    footprints: tuple[Form, ...]
    apart: float
    most: float
    reach: float
    rng: Random


def seed_composition(
    decomposition: Decomposition,
    arrangement: Arrangement,
    size: tuple[int, int],
    *,
    key: Array,
    tileable: bool = False,
    germ: tuple[float, float] | None = None,
    order: Sequence[int] | None = None,
    admit: Admit | None = None,
) -> Composition:
    """Place particles on a plane as those of the picture are arranged.

    Each class begins with a particle at the germ. Around every particle that is placed, neighbours come where a list
    of its class, chosen at random, has them. Each is a complete particle chosen at random, and is left out where it and
    what particles of its class keep free would overlap one that is there by too much (`MOST_OVERLAP`). That goes on
    until nothing more can be placed. Classes whose arrangement is not known have neighbours in any direction, as far
    away as in the picture and no closer. As in the paper, classes know nothing of each other, so that particles of
    several classes may overlap.

    Departures from section 2.2: boxes count with the clearance that they have in the picture, and centres keep a
    distance too, so that small things far apart are not crowded. All particles get another turn where there are still
    fewer per pixel than in the picture. Where there are clearly more, boxes that overlap in the picture keep more
    apart, and then some particles are taken away at random.

    Args:
        decomposition: the picture taken apart.
        arrangement: what `learn_arrangement` learnt of it.
        size: width and height of the plane in pixels.
        key: of all random choices.
        tileable: whether the plane repeats to all sides. Lattices do so well in sizes that are multiples of theirs.
        germ: (x, y) of the first particle of each class; at random by default, another place for each class.
        order: of the classes, from below; by default by their numbers. Those that are not named are left out.
        admit: which particles are seen, by class and place. Others still have neighbours, so that the arrangement goes
            on behind a place that is kept free.

    Returns:
        The composition. Particles that only reach into the plane are there too.

    Raises:
        ValueError: a size below 1, a germ that is not on the plane, an order with classes that are not there or twice,
            no complete particle in any of them, or a tileable plane too small to hold one with its clearance.

    Examples:
        >>> from jaxtex.particles.arrangement import learn_arrangement
        >>> from jaxtex.particles.things import describe_particles
        >>> row, column = np.indices((60, 80))
        >>> labels = np.where((row % 12 < 8) & (column % 20 < 15), 1 + row // 12 * 4 + column // 20, 0)
        >>> bricks = describe_particles(labels, [0] * 20)
        >>> wall = seed_composition(
        ...     bricks, learn_arrangement(bricks), (200, 120), key=jax.random.key(0), tileable=True
        ... )
        >>> len(wall)
        100
    """
    kinds = range(len(arrangement.classes)) if order is None else order
    plane = Plane(*size, tileable)
    _check_request(plane, arrangement, kinds, germ)
    placed: list[tuple[int, _Placed]] = []
    for kind in kinds:
        rng = Random(np.asarray(jax.random.key_data(jax.random.fold_in(key, kind))).tobytes())
        first = germ or (rng.uniform(0.0, plane.width), rng.uniform(0.0, plane.height))
        found = _sow_class(decomposition, arrangement.classes[kind], plane, first, rng)
        placed += [(kind, each) for each in found if admit is None or admit(kind, each.x, each.y)]
    return Composition(
        width=size[0],
        height=size[1],
        periodic=tileable,
        exemplar=identify_exemplar(decomposition),
        kinds=np.array([kind for kind, _ in placed], np.intp),
        particles=np.array([arrangement.classes[kind].members[each.which] for kind, each in placed], np.intp),
        x=np.array([each.x for _, each in placed]),
        y=np.array([each.y for _, each in placed]),
        angles=np.zeros(len(placed)),
        scales=np.ones(len(placed)),
    )


def _sow_class(
    decomposition: Decomposition, rule: Listed | Scattered, plane: Plane, germ: tuple[float, float], rng: Random
) -> list[_Placed]:
    if not rule.members:
        return []
    forms = tuple(form_of(decomposition.particles[member].box) for member in rule.members)
    if isinstance(rule, Listed):
        room = _LEAST_ROOM * rule.density**-0.5
        apart, clearance, overlap = max(LEAST_DISTANCE * rule.apart, room), rule.clearance, rule.overlap
    else:
        apart, clearance, overlap = min(rule.distances), 0.0, 0.0
    footprints = tuple(form.grown(0.5 * clearance) for form in forms)
    widest = 2.0 * max(hypot(form.across, form.down) for form in footprints)
    if plane.periodic and widest > min(plane.width, plane.height):
        raise ValueError(
            f"size {plane.width} x {plane.height}: too small to repeat, as a particle and what it keeps free "
            f"take {widest:.0f} pixels; give a larger one"
        )
    enough = rule.density * plane.width * plane.height
    # Things that interlock in the picture do not elsewhere: where too many find room, their boxes keep more apart.
    for allowed in (overlap, 0.5 * overlap, 0.0) if overlap > 0 else (0.0,):
        grid: Grid[_Placed] = Grid(plane, max(widest, apart))
        sowing = _Sowing(plane, grid, forms, footprints, apart, MOST_OVERLAP + allowed, widest, rng)
        propose = _listed_places(rule, sowing) if isinstance(rule, Listed) else _scattered_places(rule, sowing)
        found = _propagate(sowing, germ, propose, enough)
        there = _count_inside(plane, found)
        if there <= _SURPLUS * enough:
            return found
    # Particles that keep little distance find much room between others.
    kept = rng.sample(range(len(found)), max(1, round(len(found) * enough / there)))
    return [found[index] for index in sorted(kept)]


def _propagate(sowing: _Sowing, germ: tuple[float, float], propose: _Propose, enough: float) -> list[_Placed]:
    """All particles that follow from the one at the germ, in the order in which they were placed.

    Where they end with fewer on the plane than `enough`, each gets another turn, with another list.
    """
    plane, forms, footprints = sowing.plane, sowing.forms, sowing.footprints
    reaches = [hypot(form.across, form.down) for form in forms]
    first = _pick(sowing.rng, len(forms))
    found = [_Placed(*germ, first, footprints[first])]
    sowing.grid.add(*germ, found[0])
    while True:
        before, queue = len(found), deque(found)
        while queue:
            parent = queue.popleft()
            for index, x, y in propose(parent.which, parent.x, parent.y):
                if plane.contains(x, y, reaches[index]):
                    x, y = plane.wrap(x, y)
                    if not _is_taken(sowing, x, y, footprints[index]):
                        child = _Placed(x, y, index, footprints[index])
                        sowing.grid.add(x, y, child)
                        found.append(child)
                        queue.append(child)
        if len(found) - before <= _STALE * len(found) or _count_inside(plane, found) >= enough:
            return found


def _count_inside(plane: Plane, found: Sequence[_Placed]) -> int:
    return sum(plane.contains(each.x, each.y) for each in found)


def _is_taken(sowing: _Sowing, x: float, y: float, footprint: Form) -> bool:
    """Whether a particle would overlap one that is there by too much, or come too close to one."""
    difference, most = sowing.plane.difference, sowing.most
    nearest, furthest = sowing.apart**2, sowing.reach**2
    for each in sowing.grid.near(x, y):
        dx, dy = difference(each.x, each.y, x, y)
        square = dx * dx + dy * dy
        if square < nearest or (square < furthest and overlap_share(dx, dy, each.footprint, footprint) > most):
            return True
    return False


def _listed_places(rule: Listed, sowing: _Sowing) -> _Propose:
    """Around a particle, the places that a list of its class has for neighbours."""
    forms, rng = sowing.forms, sowing.rng
    common = (cos(rule.angle), sin(rule.angle))

    def propose(index: int, x: float, y: float) -> Iterator[tuple[int, float, float]]:
        form = forms[index]
        frame = (form.cosine, form.sine) if rule.turned else common
        for entry in rule.lists[_pick(rng, len(rule.lists))]:
            other = _pick(rng, len(forms))
            dx, dy = place_neighbour(entry, form, forms[other], *frame)
            yield other, x + dx, y + dy

    return propose


def _scattered_places(rule: Scattered, sowing: _Sowing) -> _Propose:
    """Around a particle, places in any direction, as far away as one of the picture's distances."""
    rng = sowing.rng

    def propose(index: int, x: float, y: float) -> Iterator[tuple[int, float, float]]:
        for _ in range(_TRIES):
            angle, distance = tau * rng.random(), rule.distances[_pick(rng, len(rule.distances))]
            yield _pick(rng, len(sowing.forms)), x + distance * cos(angle), y + distance * sin(angle)

    return propose


def _pick(rng: Random, count: int) -> int:
    return int(rng.random() * count)


def _check_request(
    plane: Plane, arrangement: Arrangement, kinds: Sequence[int], germ: tuple[float, float] | None
) -> None:
    if min(plane.width, plane.height) < 1:
        raise ValueError(f"size {plane.width} x {plane.height}: give whole numbers of pixels, at least 1")
    if germ is not None and not (0 <= germ[0] <= plane.width and 0 <= germ[1] <= plane.height):
        raise ValueError(f"germ {germ[0]}, {germ[1]}: is not on the plane of {plane.width} x {plane.height} pixels")
    count = len(arrangement.classes)
    if len(set(kinds)) < len(kinds) or not set(kinds) <= set(range(count)):
        raise ValueError(f"order {list(kinds)}: name classes from 0 to {count - 1}, each at most once")
    if not any(arrangement.classes[kind].members for kind in kinds):
        raise ValueError("no particle is complete, so there is none to place; give a picture with a whole one")
