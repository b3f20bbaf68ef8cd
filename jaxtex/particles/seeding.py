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

from jaxtex.particles.arrangement import Arrangement, Listed, Scattered, place_neighbour
from jaxtex.particles.boxes import Form, form_of, overlap_share
from jaxtex.particles.composition import Composition, identify_exemplar
from jaxtex.particles.plane import Grid, Plane
from jaxtex.particles.things import Decomposition

MOST_OVERLAP = 0.3
"""Of the smaller of two boxes with their clearance, along the axis that tells them apart best: by how much they may
overlap at most (see `overlap_share`). Section 2.2 says: not too much."""

_TRIES = 12  # places that are tried around each particle of a class whose arrangement is not known

Admit = Callable[[int, float, float], bool]
"""Whether particles of a class may be seen at a place (x, y)."""


class _Placed(NamedTuple):
    x: float
    y: float
    member: int
    footprint: Form


class _Sowing(NamedTuple):
    """What the particles of one class are placed by."""

    plane: Plane
    grid: Grid[_Placed]
    members: tuple[int, ...]
    forms: tuple[Form, ...]
    footprints: tuple[Form, ...]
    apart: float
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

    Each class begins with a particle at the germ. Around every particle that is placed, neighbours come where a list of
    its class, chosen at random, has them, each of them a complete particle chosen at random, unless it would overlap one
    of its class by too much (`MOST_OVERLAP`). That goes on until nothing more can be placed. Classes whose arrangement
    is not known have neighbours in any direction, as far away as in the picture, no closer, and no more of them per
    pixel. As in the paper, classes know nothing of each other, so particles of several classes may overlap.

    Args:
        decomposition: the picture taken apart.
        arrangement: what `learn_arrangement` learnt of it.
        size: width and height of the plane in pixels.
        key: of all random choices.
        tileable: whether the plane repeats to all sides. Lattices only do so well in sizes that are multiples of theirs.
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
        particles=np.array([each.member for _, each in placed], np.intp),
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
    clearance, apart = (rule.clearance, 0.0) if isinstance(rule, Listed) else (0.0, min(rule.distances))
    footprints = tuple(form.grown(0.5 * clearance) for form in forms)
    widest = 2.0 * max(hypot(form.across, form.down) for form in footprints)
    if plane.periodic and widest > min(plane.width, plane.height):
        raise ValueError(
            f"size {plane.width} x {plane.height}: too small to repeat, as a particle and what it keeps free "
            f"take {widest:.0f} pixels; give a larger one"
        )
    grid: Grid[_Placed] = Grid(plane, max(widest, apart))
    sowing = _Sowing(plane, grid, rule.members, forms, footprints, apart, rng)
    propose = _listed_places(rule, sowing) if isinstance(rule, Listed) else _scattered_places(rule, sowing)
    found = _propagate(sowing, germ, propose)
    if isinstance(rule, Scattered):
        # Close pairs in a large picture would else fill the plane.
        most = round(rule.density * plane.width * plane.height)
        return sorted(rng.sample(found, max(1, min(most, len(found)))), key=found.index)
    return found


def _propagate(
    sowing: _Sowing, germ: tuple[float, float], propose: Callable[[int, float, float], Iterator]
) -> list[_Placed]:
    """All particles that follow from the one at the germ, in the order in which they were placed."""
    plane, grid, forms = sowing.plane, sowing.grid, sowing.forms
    queue: deque[tuple[int, float, float]] = deque()
    found: list[_Placed] = []

    def place(index: int, x: float, y: float) -> None:
        each = _Placed(x, y, sowing.members[index], sowing.footprints[index])
        grid.add(x, y, each)
        found.append(each)
        queue.append((index, x, y))

    reaches = [hypot(form.across, form.down) for form in forms]
    place(_pick(sowing.rng, len(forms)), *germ)
    while queue:
        for index, x, y in propose(*queue.popleft()):
            if plane.contains(x, y, reaches[index]):
                x, y = plane.wrap(x, y)
                if not _is_taken(sowing, x, y, sowing.footprints[index]):
                    place(index, x, y)
    return found


def _is_taken(sowing: _Sowing, x: float, y: float, footprint: Form) -> bool:
    """Whether a particle would overlap one that is there by too much, or come too close to one."""
    plane, apart = sowing.plane, sowing.apart
    for each in sowing.grid.near(x, y):
        dx, dy = plane.difference(each.x, each.y, x, y)
        if dx * dx + dy * dy < apart * apart or overlap_share(dx, dy, each.footprint, footprint) > MOST_OVERLAP:
            return True
    return False


def _listed_places(rule: Listed, sowing: _Sowing) -> Callable[[int, float, float], Iterator]:
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


def _scattered_places(rule: Scattered, sowing: _Sowing) -> Callable[[int, float, float], Iterator]:
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
    if len(set(kinds)) < len(kinds) or not set(kinds) <= set(range(len(arrangement.classes))):
        raise ValueError(f"order {list(kinds)}: name classes from 0 to {len(arrangement.classes) - 1}, each at most once")
    if not any(arrangement.classes[kind].members for kind in kinds):
        raise ValueError("no particle is complete, so there is none to place; give a picture with a whole one")
