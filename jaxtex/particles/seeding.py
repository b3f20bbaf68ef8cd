"""Particles placed anew as they were arranged in the picture: propagated over a plane from one germ.

J.-M. Dischler, K. Maritaud, B. Lévy and D. Ghazanfarpour, "Texture particles" (Eurographics 2002), section 2.2.
"""

from collections.abc import Sequence
from math import hypot
from random import Random
from typing import Any

import jax
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.core.errors import InputError
from jaxtex.particles.boxes import Form, form_of
from jaxtex.particles.companions import Companion
from jaxtex.particles.composition import Composition, identify_exemplar
from jaxtex.particles.controls import Control, combine_controls, controls_of
from jaxtex.particles.cooccurrences import Arrangement, Listed, Scattered, usual_distance
from jaxtex.particles.plane import Grid, Plane
from jaxtex.particles.sowing import Sowing, count_inside, sow_class, sow_groups
from jaxtex.particles.stock import EvenStock, Placed, Stock, UnevenStock
from jaxtex.particles.terrain import Terrain
from jaxtex.particles.things import Decomposition

MOST_OVERLAP = 0.12
"""Of the smaller of two boxes with their clearance, along the axis that tells them apart best: by how much they may
overlap at most (see `overlap_share`), beyond how much they do in the picture. Section 2.2 says: not too much.
Two that were neighbours in the picture may lie as they did there."""

LEAST_DISTANCE = 0.85
"""Of how far a particle is from the nearest one in the picture, centre to centre: how close others come by lists."""

_LEAST_ROOM = 0.25
"""Of the side of the square that each particle has on average: how close none comes to another by lists. Things strewn
at random keep no distance at all, and would find room without end."""

_MOST = 1 << 20  # particles of a class
_SURPLUS = 1.15  # times the picture's density: where more find room, lists do not tell how the class is arranged
_DEARTH = 0.3  # times that density: where fewer do, neither
_CLOSENESS = (
    0.999,
    0.9,
    0.8,
    0.6,
    0.4,
)  # of the room that particles have in the picture: what groups keep, if they can


def seed_composition(
    decomposition: Decomposition,
    arrangement: Arrangement,
    size: tuple[int, int],
    *,
    key: Array,
    tileable: bool = False,
    germ: tuple[float, float] | None = None,
    order: Sequence[int] | None = None,
    controls: Sequence[Control] = (),
) -> Composition:
    """Place particles on a plane as those of the picture are arranged.

    Each class begins with a particle at the germ. Around every particle that is placed, neighbours come where a list
    of its class, chosen at random, has them. Each is a complete particle chosen at random, from a deck to which those
    go back that find no room, so that sizes are as often as in the picture. It is left out where it and what particles
    of its class keep free would overlap one that is there by too much (`MOST_OVERLAP`). That goes on until nothing more
    can be placed. Classes whose arrangement is not known have neighbours in any direction, as far away as in the
    picture. As in the paper, classes know nothing of each other, so that particles of several classes may
    overlap.

    Departures from section 2.2: where things nearly touch, each comes with its own list and with those that were
    around it, as which of them fit together is no matter of chance then; so mosaics hold. Boxes count with the
    clearance that they have in the picture, and each keeps about the distance from others that it has there, so that
    loners stay alone. All particles get another turn where there are still fewer per pixel than in the picture. Where
    clearly more would find room, as in what is strewn at random or in clusters, lists do not say where nothing is; then
    particles come in groups, each with what is nearest to it in the picture, strewn with the distance that they have
    there, or less if there is no room for all of them, those with most room first.

    Args:
        decomposition: the picture taken apart.
        arrangement: what `learn_arrangement` learnt of it.
        size: width and height of the plane in pixels.
        key: of all random choices.
        tileable: whether the plane repeats to all sides. Lattices do so well in sizes that are multiples of theirs.
        germ: (x, y) of the first particle of each class; at random by default, another place for each class.
        order: of the classes, from below; by default by their numbers. Those that are not named are left out.
        controls: what is asked of particles by class and place, all together.

    Returns:
        The composition. Particles that only reach into the plane are there too.

    Raises:
        InputError: a size below 1, a germ that is not on the plane, an order with classes that are not there or twice,
            no complete particle in any of them, a tileable plane too small to hold one with its clearance, or a control
            of what is not there or with numbers that are out of range.

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
    _check_controls(decomposition, arrangement, controls)
    parts = []
    for kind in kinds:
        rng = Random(np.asarray(jax.random.key_data(jax.random.fold_in(key, kind))).tobytes())
        first = germ or (rng.uniform(0.0, plane.width), rng.uniform(0.0, plane.height))
        wanted = controls_of(controls, kind)
        found = _sow_kind(decomposition, arrangement.classes[kind], plane, first, wanted, rng)
        parts.append(_shape(found, kind, arrangement.classes[kind].members, plane, wanted, rng))
    columns: dict[str, Any] = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return Composition(
        width=size[0], height=size[1], periodic=tileable, exemplar=identify_exemplar(decomposition), **columns
    )


def _sow_kind(
    decomposition: Decomposition,
    rule: Listed | Scattered,
    plane: Plane,
    germ: tuple[float, float],
    controls: Sequence[Control],
    rng: Random,
) -> list[Placed]:
    if not rule.members:
        return []
    forms = tuple(form_of(decomposition.particles[member].box) for member in rule.members)
    terrain = Terrain(plane, controls, rule.members, usual_distance(rule, forms)) if controls else None
    clearance = rule.clearance if isinstance(rule, Listed) else 0.0
    widest = _measure_widest(plane, forms, clearance, terrain)
    enough = rule.density * (terrain.abundance if terrain else 1.0) * plane.width * plane.height
    if enough > _MOST:
        raise InputError(
            f"size {plane.width} x {plane.height}: takes {enough:.0f} particles of a class, and {_MOST} are the most; "
            f"give a smaller one{', or a lower density' if terrain else ''}"
        )

    def prepare(rooms: Sequence[float], overlap: float) -> Sowing:
        stock: Stock
        if terrain is None:
            reach, stock = max(widest, *rooms), EvenStock(plane, forms, clearance, rooms, rng)
        else:
            reach = max(widest, terrain.largest * max(rooms), terrain.furthest)
            stock = UnevenStock(plane, forms, clearance, rooms, rng, terrain)
        return Sowing(plane, Grid(plane, reach), stock, MOST_OVERLAP + overlap, rng)

    if isinstance(rule, Listed):
        rooms, groups, overlap = rule.rooms, rule.groups, rule.overlap
        least = _LEAST_ROOM * rule.density**-0.5
        sowing = prepare([max(LEAST_DISTANCE * room, least) for room in rooms], overlap)
    else:
        rooms, overlap = (min(rule.distances),) * len(forms), 0.0
        groups = tuple((Companion(which, 0.0, 0.0),) for which in range(len(forms)))
        sowing = prepare(rooms, overlap)
    found = sow_class(sowing, rule, forms, germ, enough, _SURPLUS * enough)
    there = count_inside(plane, found)
    if _DEARTH * enough <= there <= _SURPLUS * enough:
        return found
    # Where there is room for more, what lists say of each neighbour does not tell where there is none.
    extent = max(hypot(each.x, each.y) for group in groups for each in group) * (terrain.largest if terrain else 1.0)
    margin = 0.0 if plane.periodic else 0.5 * widest + extent
    count = max(1, round(enough * (1 + 2 * margin / plane.width) * (1 + 2 * margin / plane.height)))
    ranked = sorted(groups, key=lambda group: -max(rooms[each.which] for each in group))
    for closeness in _CLOSENESS:
        sowing = prepare([closeness * room for room in rooms], overlap)
        strewn, complete = sow_groups(sowing, ranked, germ, count, margin)
        if complete:
            return strewn
    return max(strewn, found, key=len) if there < enough else strewn


def _measure_widest(plane: Plane, forms: Sequence[Form], clearance: float, terrain: Terrain | None) -> float:
    """The widest of the footprints, in pixels."""
    grown = (form.grown(0.5 * clearance) for form in forms)
    widest = 2.0 * (terrain.largest if terrain else 1.0) * max(hypot(form.across, form.down) for form in grown)
    if plane.periodic and widest > min(plane.width, plane.height):
        raise InputError(
            f"size {plane.width} x {plane.height}: too small to repeat, as a particle and what it keeps free "
            f"take {widest:.0f} pixels; give a larger one"
        )
    return widest


def _shape(
    found: Sequence[Placed],
    kind: int,
    members: Sequence[int],
    plane: Plane,
    controls: Sequence[Control],
    rng: Random,
) -> dict[str, npt.NDArray[Any]]:
    """The columns of a composition for the particles of a class that are seen."""
    x, y = (np.array([getattr(each, name) for each in found], float) for name in ("x", "y"))
    # Fields need not know of what is outside of the plane.
    effects = combine_controls(controls, np.clip(x, 0, plane.width), np.clip(y, 0, plane.height))
    columns = {
        "kinds": np.full(len(found), kind, np.intp),
        "particles": np.array([members[each.thing.which] for each in found], np.intp),
        "x": x,
        "y": y,
        "angles": effects.orientation + np.array([each.thing.turn for each in found], float),
        "scales": effects.size * np.array([each.thing.scale for each in found], float),
        "gains": effects.gains,
    }
    seen = np.array([rng.random() for _ in found]) < effects.probability
    return {name: values[seen] for name, values in columns.items()}


def _check_request(
    plane: Plane, arrangement: Arrangement, kinds: Sequence[int], germ: tuple[float, float] | None
) -> None:
    if min(plane.width, plane.height) < 1:
        raise InputError(f"size {plane.width} x {plane.height}: give whole numbers of pixels, at least 1")
    if germ is not None and not (0 <= germ[0] <= plane.width and 0 <= germ[1] <= plane.height):
        told = f"germ {germ[0]:g},{germ[1]:g}: is not on the plane"
        raise InputError(f"{told}; give a place within {plane.width} x {plane.height} pixels")
    count = len(arrangement.classes)
    if len(set(kinds)) < len(kinds) or not set(kinds) <= set(range(count)):
        raise InputError(f"order {list(kinds)}: name classes from 0 to {count - 1}, each at most once")
    if not any(arrangement.classes[kind].members for kind in kinds):
        raise InputError("no particle is complete, so there is none to place; give a picture with a whole one")


def _check_controls(decomposition: Decomposition, arrangement: Arrangement, controls: Sequence[Control]) -> None:
    kinds, count = len(arrangement.classes), len(decomposition.particles)
    for number, control in enumerate(controls, 1):
        if not set(control.classes or ()) <= set(range(kinds)):
            told = f"classes {list(control.classes or ())} of control {number}"
            raise InputError(f"controls: {told}: name classes from 0 to {kinds - 1}")
        if not set(control.weights) <= set(range(count)):
            told = f"weights of particles {sorted(control.weights)} in control {number}"
            raise InputError(f"controls: {told}: name particles from 0 to {count - 1}")
