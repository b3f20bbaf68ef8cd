"""Particles in groups, on small planes, and where chance or controls change them: what lists alone do not settle."""

import jax
import numpy as np
import pytest
from drawn_lattices import draw_things

from jaxtex.particles.arrangement import learn_arrangement
from jaxtex.particles.boxes import form_of, overlap_share
from jaxtex.particles.companions import learn_companions
from jaxtex.particles.composition import Composition
from jaxtex.particles.controls import Control
from jaxtex.particles.plane import Plane
from jaxtex.particles.seeding import MOST_OVERLAP, seed_composition
from jaxtex.particles.things import Decomposition, describe_particles

SIZE = (220, 200)


def strewn() -> Decomposition:
    """Dots anywhere."""
    points = np.random.default_rng(0).uniform(-20, 240, (85, 2))
    return draw_things(points, SIZE, width=4, height=4, discs=True)


def pairs() -> Decomposition:
    """Large discs, each with a small one beside it."""
    rng = np.random.default_rng(2)
    labels, number = np.zeros((300, 300), int), 0
    row, column = np.indices(labels.shape) + 0.5
    for x, y in rng.permutation(np.mgrid[30:300:60, 30:300:60].reshape(2, -1).T)[:14] + rng.uniform(-9, 9, (14, 2)):
        for radius, away in ((7, 0), (3, 14)):
            number += 1
            labels[np.hypot(column - x - away, row - y) < radius] = number
    return describe_particles(labels, [0] * number)


def bricks(lengths: tuple[int, ...]) -> Decomposition:
    row, column = np.indices((120, 144))
    starts = np.cumsum([0, *(each + 2 for each in lengths)])
    place = column % starts[-1]
    which = np.searchsorted(starts, place, side="right") - 1
    inside = (row % 12 < 9) & (place < starts[which] + np.array(lengths)[which])
    labels = np.where(inside, 1 + (row // 12 * 60 + column // starts[-1] * len(lengths) + which), 0)
    _, packed = np.unique(labels, return_inverse=True)
    return describe_particles(packed.reshape(labels.shape), [0] * int(packed.max()))


def most_overlap(made: Composition, things: Decomposition) -> float:
    plane = Plane(made.width, made.height, made.periodic)
    forms = [
        form_of(things.particles[number].box).changed(scale, angle)
        for number, scale, angle in zip(made.particles, made.scales, made.angles, strict=True)
    ]
    ways = (
        (i, j, plane.difference(made.x[i], made.y[i], made.x[j], made.y[j])) for i in range(len(made)) for j in range(i)
    )
    return max((overlap_share(*way, forms[i], forms[j]) for i, j, way in ways), default=0.0)


@pytest.mark.parametrize("tileable", [False, True])
def test_small_planes_are_about_as_full_as_large_ones(tileable: bool) -> None:
    things = strewn()
    learnt = learn_arrangement(things)
    counts = [
        len(seed_composition(things, learnt, (90, 90), key=jax.random.key(number), tileable=tileable))
        for number in range(12)
    ]
    wanted = learnt.classes[0].density * 90 * 90
    assert min(counts) >= 0.3 * wanted
    assert np.mean(counts) == pytest.approx(wanted, rel=0.3)


def test_the_smallest_plane_has_one() -> None:
    labels = np.zeros((100, 100), int)
    labels[45:55, 45:55] = 1
    things = describe_particles(labels, [0])
    assert len(seed_composition(things, learn_arrangement(things), (60, 60), key=jax.random.key(0), tileable=True)) == 1
    two = pairs()
    assert len(seed_composition(two, learn_arrangement(two), (40, 40), key=jax.random.key(0), tileable=True)) >= 1


def test_strewn_things_are_as_dense_as_is_asked_for() -> None:
    things, size = strewn(), (600, 300)
    dense = Control(density=lambda x, y: np.where(np.asarray(x) < 300, 4.0, 1.0))
    made = seed_composition(things, learn_arrangement(things), size, key=jax.random.key(1), controls=[dense])
    here = int(((made.x >= 0) & (made.x < 300)).sum())
    there = int(((made.x >= 300) & (made.x <= 600)).sum())
    assert here / there == pytest.approx(4, rel=0.25)


@pytest.mark.parametrize("control", [Control(orientation_variation=0.7), Control(size_variation=0.5)])
def test_what_chance_has_changed_is_not_excused_from_overlapping(control: Control) -> None:
    for things in (bricks((16,)), pairs()):
        learnt = learn_arrangement(things)
        made = seed_composition(things, learnt, (240, 240), key=jax.random.key(0), controls=[control])
        assert len(made) > 10
        assert most_overlap(made, things) <= MOST_OVERLAP + learnt.classes[0].overlap + 1e-9


@pytest.mark.parametrize("side", [34, 37, 41])
def test_no_neighbour_comes_around_a_small_plane_onto_its_own(side: int) -> None:
    things = bricks((28, 8))
    learnt = learn_arrangement(things)
    made = seed_composition(things, learnt, (side, side), key=jax.random.key(0), tileable=True)
    assert most_overlap(made, things) <= MOST_OVERLAP + learnt.classes[0].overlap + 1e-9


def test_a_loner_keeps_the_room_that_is_seen_around_it() -> None:
    points = np.array([(10.0 + 8 * number, 10.0) for number in range(6)] + [(200.0, 200.0)])
    things = draw_things(points, (400, 400), width=4, height=4, discs=True)
    rooms = learn_companions(things, 0, range(len(things.particles))).rooms
    assert max(rooms) > 190
    assert sorted(rooms)[-2] == pytest.approx(8)


def test_members_are_in_one_group_with_their_nearest() -> None:
    things = pairs()
    learnt = learn_companions(things, 0, range(len(things.particles)))
    assert sorted(each.which for group in learnt.groups for each in group) == list(range(len(things.particles)))
    assert {len(group) for group in learnt.groups} == {2}
    assert learnt.rooms == pytest.approx([14] * len(things.particles), abs=0.6)
