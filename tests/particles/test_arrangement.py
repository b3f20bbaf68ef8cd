"""Neighbours found and lists learnt, against plain repeated dilation and against arrangements that are known."""

from math import cos, sin

import numpy as np
import pytest
from drawn_lattices import draw_things, lattice, turn
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import binary_dilation, find_objects

from jaxtex.particles.arrangement import grow_to_others, learn_arrangement
from jaxtex.particles.boxes import form_of
from jaxtex.particles.cooccurrences import Cooccurrence, Listed, Scattered, cooccurrence_of, place_neighbour
from jaxtex.particles.things import Box, Decomposition, describe_particles

SIZE = (220, 200)
boxes = st.builds(
    Box, st.floats(-50, 50), st.floats(-50, 50), st.floats(1, 30), st.floats(1, 30), st.floats(-1.57, 1.57)
)


def grow_plainly(labels: np.ndarray, number: int, most: int) -> dict[int, int]:
    steps: dict[int, int] = {}
    grown = labels == number
    for step in range(1, most + 1):
        grown = binary_dilation(grown, np.ones((3, 3), bool))
        for other in np.unique(labels[grown]):
            if other not in (0, number):
                steps.setdefault(int(other), step)
    return steps


@given(st.integers(0, 2**32 - 1), st.integers(1, 12))
def test_growth_is_repeated_dilation(seed: int, most: int) -> None:
    rng = np.random.default_rng(seed)
    labels = rng.integers(1, 9, (24, 31)) * (rng.random((24, 31)) < 0.03)
    labels = describe_particles(labels, np.zeros(len(np.unique(labels[labels > 0])), int)).labels
    for number, around in enumerate(find_objects(labels), 1):
        assert grow_to_others(labels, number, around, most) == grow_plainly(labels, number, most)


@given(boxes, boxes, st.floats(-1.57, 1.57))
def test_neighbours_are_put_back_where_they_were(box: Box, other: Box, angle: float) -> None:
    entry = cooccurrence_of(box, other, angle)
    way = place_neighbour(entry, form_of(box), form_of(other), cos(angle), sin(angle))
    assert way == pytest.approx((other.x - box.x, other.y - box.y), abs=1e-9)
    assert 0 <= entry.quadrant <= 3
    assert min(entry.dx, entry.dy) >= -1


def test_all_neighbours_of_a_picture_are_put_back() -> None:
    rng = np.random.default_rng(3)
    found = draw_things(
        rng.uniform(0, 200, (30, 2)), SIZE, width=24, height=7, angles=rng.uniform(-90, 90, 30)
    ).particles
    for one in found:
        for other in found:
            for angle in (0.0, one.box.angle):
                entry = cooccurrence_of(one.box, other.box, angle)
                way = place_neighbour(entry, form_of(one.box), form_of(other.box), cos(angle), sin(angle))
                assert way == pytest.approx((other.box.x - one.box.x, other.box.y - one.box.y), abs=1e-9)


@pytest.mark.parametrize(("x", "y", "quadrant"), [(9, 0, 0), (0, 9, 1), (-9, 0, 2), (0, -9, 3), (9, -1, 3), (-9, 1, 1)])
def test_each_axis_lies_in_one_quadrant(x: float, y: float, quadrant: int) -> None:
    assert cooccurrence_of(Box(0, 0, 4, 2, 0), Box(x, y, 4, 2, 0), 0.0).quadrant == quadrant


def test_distances_are_between_boxes() -> None:
    entry = cooccurrence_of(Box(10, 10, 8, 4, 0), Box(21, 13, 6, 6, 0), 0.0)
    assert entry == Cooccurrence(0, 4.0, pytest.approx(3 / 5 - 1))


def test_quadrants_without_neighbours_take_their_opposites() -> None:
    # The middle one is whole, and so are those to its right and below; the others are cut off or not there.
    labels = np.zeros((40, 60), int)
    for number, (x, y) in enumerate([(22, 14), (40, 15), (21, 30), (0, 33)], 1):
        labels[y : y + 6, x : x + 8] = number
    rule = learn_arrangement(describe_particles(labels, [0] * 4)).classes[0]
    assert isinstance(rule, Listed)
    assert rule.members == (0, 1, 2)
    first = sorted(rule.lists[0])
    assert [entry.quadrant for entry in first] == [0, 1, 2, 3]
    assert first[2][1:] == first[0][1:]
    assert first[3][1:] == first[1][1:]


def test_a_single_row_fills_a_plane_too() -> None:
    labels = np.zeros((30, 100), int)
    for number in range(6):
        labels[10:16, 5 + 15 * number : 13 + 15 * number] = number + 1
    rule = learn_arrangement(describe_particles(labels, [0] * 6)).classes[0]
    assert isinstance(rule, Listed)
    assert all({entry.quadrant for entry in entries} == {0, 1, 2, 3} for entries in rule.lists)


def test_neighbours_are_of_the_same_class() -> None:
    row, column = np.indices((96, 96))
    labels = np.where((row % 12 < 6) & (column % 12 < 6), 1 + row // 12 * 8 + column // 12, 0)
    chessboard = (np.arange(64) // 8 + np.arange(64)) % 2
    learnt = learn_arrangement(describe_particles(labels, chessboard))
    for rule in learnt.classes:
        assert isinstance(rule, Listed)
        nearest = {entry for entries in rule.lists for entry in entries}
        assert {abs(entry.dx) for entry in nearest} <= {6.0, 18.0, 1.0}
        assert rule.rooms == pytest.approx([12 * 2**0.5] * len(rule.members))
        assert rule.density == pytest.approx(32 / 96**2)


def test_few_particles_know_only_how_far_apart_they_are() -> None:
    labels = np.zeros((50, 70), int)
    labels[10:14, 10:20] = 1
    single = learn_arrangement(describe_particles(labels, [0])).classes[0]
    assert single == Scattered((0,), (70.0, 50.0), pytest.approx(1 / 3500))
    labels[30:34, 40:50] = 2
    two = learn_arrangement(describe_particles(labels, [0, 0])).classes[0]
    assert two == Scattered((0, 1), (pytest.approx(np.hypot(30, 20)),), pytest.approx(2 / 3500))


def test_a_class_without_whole_particles_has_no_members() -> None:
    labels = np.zeros((20, 20), int)
    labels[:5, :5] = 1
    assert learn_arrangement(describe_particles(labels, [1])).classes == (
        Scattered((), (20.0, 20.0), 0.0),
        Scattered((), (20.0, 20.0), pytest.approx(1 / 400)),
    )


def test_patches_that_lie_crosswise_have_their_own_frames() -> None:
    rng = np.random.default_rng(1)
    steps = np.arange(-2, 3)
    around = [(16.0 * i, 10.0 * j) for i in steps for j in steps]
    places, angles = [], []
    for x in range(60, 480, 120):
        for y in range(60, 480, 120):
            angle = rng.uniform(-70, 70)
            places += [(x + u, y + v) for u, v in turn(around, angle)]
            angles += [angle] * len(around)
    patches = draw_things(np.array(places), (480, 480), width=12, height=6, angles=np.array(angles))
    rule = learn_arrangement(patches).classes[0]
    assert isinstance(rule, Listed)
    assert rule.turned


def draw_wobbling() -> Decomposition:
    rng = np.random.default_rng(2)
    points = lattice((26.3, 0), (13.15, 22.78), SIZE)
    return draw_things(points, SIZE, width=19, height=13, angles=rng.uniform(-90, 90, len(points)))


def test_a_lattice_of_things_that_lie_anyhow_has_the_pictures_frame() -> None:
    rule = learn_arrangement(draw_wobbling()).classes[0]
    assert isinstance(rule, Listed)
    assert not rule.turned
