"""Particles placed anew, against the arrangements that their pictures were drawn in."""

import jax
import numpy as np
import pytest
from drawn_lattices import draw_things, lattice, measure_lattice, nearest_distances, poisson_disc, turn
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from jaxtex.particles.arrangement import learn_arrangement
from jaxtex.particles.boxes import form_of, overlap_share
from jaxtex.particles.composition import Composition, check_exemplar
from jaxtex.particles.cooccurrences import Arrangement, Listed
from jaxtex.particles.plane import Plane
from jaxtex.particles.seeding import MOST_OVERLAP, seed_composition
from jaxtex.particles.things import Decomposition, describe_particles

SIZE, LARGE = (220, 200), (700, 700)
SQUARE = [(24.7, 0.0), (0.0, 24.7)]
HEXAGONAL = [(26.3, 0.0), (13.15, 22.78), (-13.15, 22.78)]
BRICKS = [(40.4, 0.0), (20.2, 17.6), (-20.2, 17.6)]


def seed(things: Decomposition, size: tuple[int, int] = LARGE, number: int = 0, **choices) -> Composition:
    return seed_composition(things, learn_arrangement(things), size, key=jax.random.key(number), **choices)


def places(composition: Composition) -> np.ndarray:
    return np.stack([composition.x, composition.y], axis=1)


def count_inside(placed: np.ndarray) -> int:
    return int(((placed >= 0) & (placed < np.array(LARGE)[None])).all(axis=1).sum())


@pytest.mark.parametrize("angle", [0, 11, 30])
@pytest.mark.parametrize(
    ("vectors", "shape"),
    [
        (SQUARE, {"width": 15, "height": 15, "discs": True}),
        (SQUARE, {"width": 17, "height": 15}),
        (HEXAGONAL, {"width": 18, "height": 18, "discs": True}),
        (HEXAGONAL, {"width": 6, "height": 6, "discs": True}),
        (BRICKS, {"width": 34, "height": 12}),
    ],
    ids=["square discs", "square bricks", "hexagonal discs", "hexagonal dots", "bricks"],
)
def test_lattices_are_kept(vectors: list, shape: dict, angle: float) -> None:
    vectors = turn(vectors, angle)
    leaning = 0.0 if "discs" in shape else angle
    placed = places(seed(draw_things(lattice(*vectors[:2], SIZE), SIZE, angles=leaning, **shape)))
    turned, stretched, missing = measure_lattice(placed, vectors, LARGE)
    assert turned < 2
    assert stretched < 0.02
    assert missing < 0.05
    assert count_inside(placed) == pytest.approx(np.prod(LARGE) / abs(np.linalg.det(vectors[:2])), rel=0.06)


def test_jittered_lattices_are_kept_nearby() -> None:
    points = lattice(*SQUARE, SIZE)
    jittered = points + np.random.default_rng(0).normal(0, 1, points.shape)
    placed = places(seed(draw_things(jittered, SIZE, width=15, height=15, discs=True)))
    turned, stretched, missing = measure_lattice(placed, SQUARE, LARGE)
    assert turned < 2
    assert stretched < 0.02
    # What each step is off by adds up, so that columns and rows end somewhere.
    assert missing < 0.2


@pytest.mark.parametrize("width", [14, 6])
def test_random_things_keep_their_distance(width: float) -> None:
    exemplar = poisson_disc(SIZE, 21, np.random.default_rng(1))
    made = seed(draw_things(exemplar, SIZE, width=width, height=width, discs=True))
    found, known = nearest_distances(places(made), LARGE), nearest_distances(exemplar, SIZE)
    assert found.min() > 0.8 * known.min()
    assert found.mean() == pytest.approx(known.mean(), rel=0.1)
    density = len(exemplar) / ((SIZE[0] + 60) * (SIZE[1] + 60))
    assert count_inside(places(made)) == pytest.approx(density * np.prod(LARGE), rel=0.15)


def test_things_anywhere_are_not_crowded() -> None:
    exemplar = np.random.default_rng(1).uniform(-20, 220, (140, 2))
    made = seed(draw_things(exemplar, SIZE, width=4, height=4, discs=True))
    found, known = nearest_distances(places(made), LARGE), nearest_distances(exemplar, SIZE)
    assert found.mean() == pytest.approx(known.mean(), rel=0.2)
    assert found.std() == pytest.approx(known.std(), rel=0.3)
    assert count_inside(places(made)) == pytest.approx(140 / 240**2 * np.prod(LARGE), rel=0.15)


def test_interlocking_things_leave_no_holes() -> None:
    points = poisson_disc(SIZE, 18, np.random.default_rng(1))
    row, column = np.indices(SIZE[::-1]) + 0.5
    (nearest, next_one), owner = (
        each.reshape(-1, 2).T.reshape(2, *row.shape)
        for each in cKDTree(points).query(np.stack([column, row], axis=-1), 2)
    )
    labels = np.where(next_one - nearest > 2, owner[0] + 1, 0)
    made = seed(describe_particles(labels, np.zeros(len(np.unique(labels[labels > 0])), int)))
    anywhere = np.random.default_rng(0).uniform(0, LARGE, (5000, 2))
    assert cKDTree(places(made)).query(anywhere)[0].max() < 2.5 * nearest.max()
    density = len(points) / ((SIZE[0] + 60) * (SIZE[1] + 60))
    assert count_inside(places(made)) == pytest.approx(density * np.prod(LARGE), rel=0.2)


def draw_mixed(seed: int) -> Decomposition:
    """Bricks of many sizes and angles of two classes."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(0, 200, (60, 2))
    row, column = np.indices(SIZE[::-1])
    labels = np.zeros(SIZE[::-1], int)
    for number, (x, y) in enumerate(points, 1):
        angle, (width, height) = rng.uniform(0, 3), rng.uniform(4, 20, 2)
        along, across = (
            (column - x) * np.cos(angle) + (row - y) * np.sin(angle),
            (row - y) * np.cos(angle) - (column - x) * np.sin(angle),
        )
        labels[(np.abs(along) < 0.5 * width) & (np.abs(across) < 0.5 * height) & (labels == 0)] = number
    count = len(np.unique(labels[labels > 0]))
    return describe_particles(labels, rng.integers(0, 2, count))


@given(st.integers(0, 1000), st.booleans())
def test_nothing_overlaps_too_much(number: int, tileable: bool) -> None:
    things = draw_mixed(number)
    arrangement = learn_arrangement(things)
    size = (150, 130)
    made = seed_composition(things, arrangement, size, key=jax.random.key(number), tileable=tileable)
    plane = Plane(*size, tileable)
    for kind, rule in enumerate(arrangement.classes):
        assert isinstance(rule, Listed)
        forms = [form_of(things.particles[each].box).grown(0.5 * rule.clearance) for each in made.particles]
        chosen = np.flatnonzero(made.kinds == kind)
        for i in chosen:
            for j in chosen[chosen > i]:
                dx, dy = plane.difference(made.x[i], made.y[i], made.x[j], made.y[j])
                one, other = (things.particles[made.particles[each]].box for each in (i, j))
                if np.hypot(other.x - one.x - dx, other.y - one.y - dy) < 1e-6:
                    continue  # as in the picture
                assert overlap_share(dx, dy, forms[i], forms[j]) <= MOST_OVERLAP + rule.overlap + 1e-9
                rooms = [rule.rooms[rule.members.index(made.particles[each])] for each in (i, j)]
                assert np.hypot(dx, dy) >= 0.4 * max(rooms) - 1e-9
    check_exemplar(made, things)
    assert all(things.particles[each].complete for each in made.particles)
    if tileable:
        assert ((made.x >= 0) & (made.x <= size[0]) & (made.y >= 0) & (made.y <= size[1])).all()


def test_lattices_that_fit_repeat_without_a_seam() -> None:
    things = draw_things(lattice((20, 0), (0, 25), SIZE), SIZE, width=13, height=11)
    made = seed(things, (300, 250), tileable=True)
    assert len(made) == 150
    grid = np.stack([np.round(made.x / 20 - made.x[0] / 20) % 15, np.round(made.y / 25 - made.y[0] / 25) % 10], axis=1)
    assert len(np.unique(grid, axis=0)) == 150


def test_the_same_key_places_the_same() -> None:
    things = draw_mixed(1)
    one, two, three = seed(things, SIZE), seed(things, SIZE), seed(things, SIZE, number=1)
    for name in ("kinds", "particles", "x", "y"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    assert not np.array_equal(one.x[:10], three.x[:10])


def test_classes_come_in_order_from_the_germ() -> None:
    made = seed(draw_mixed(2), SIZE, germ=(50.0, 60.0), order=[1, 0])
    change = int(np.argmin(made.kinds))
    assert (made.kinds[:change] == 1).all()
    assert (made.kinds[change:] == 0).all()
    assert set(seed(draw_mixed(2), SIZE, order=[1]).kinds) == {1}
    first = seed(draw_things(lattice(*SQUARE, SIZE), SIZE, width=15, height=15), germ=(50.0, 60.0))
    assert (first.x[0], first.y[0]) == (50.0, 60.0)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_things_lie_anywhere_at_their_distances(count: int) -> None:
    labels = np.zeros((60, 80), int)
    for number, (x, y) in enumerate([(10, 10), (50, 20), (20, 40)][:count], 1):
        labels[y : y + 8, x : x + 8] = number
    things = describe_particles(labels, [0] * count)
    rule = learn_arrangement(things).classes[0]
    made = seed(things)
    apart = nearest_distances(places(made), LARGE)
    assert apart.min() >= min(rule.distances)
    assert count_inside(places(made)) == pytest.approx(count * np.prod(LARGE) / (60 * 80), rel=0.3)


def test_a_close_pair_does_not_crowd_the_plane() -> None:
    labels = np.zeros((200, 200), int)
    labels[100:105, 100:105], labels[100:105, 107:112] = 1, 2
    made = seed(describe_particles(labels, [0, 0]))
    assert count_inside(places(made)) == pytest.approx(2 * np.prod(LARGE) / 200**2, rel=0.35)


def test_a_class_that_died_out_gets_another_turn() -> None:
    # Three lists of four lead nowhere, as what they name is too close; one of them may be the first to be chosen.
    things = draw_things(lattice(*SQUARE, SIZE), SIZE, width=15, height=15)
    (rule,) = learn_arrangement(things).classes
    blind = tuple(entry._replace(dx=-1.0, dy=-1.0) for entry in rule.lists[0])
    halved = Arrangement((rule._replace(lists=rule.lists + len(rule.lists) * 3 * (blind,)),))
    for number in range(8):
        made = seed_composition(things, halved, LARGE, key=jax.random.key(number))
        assert count_inside(places(made)) > 0.9 * np.prod(LARGE) / 24.7**2


@pytest.mark.parametrize(
    ("choices", "complaint"),
    [
        ({"size": (0, 100)}, "size 0 x 100"),
        ({"germ": (900.0, 10.0)}, "germ 900,10: is not on the plane; give a place within 700 x 700"),
        ({"order": [0, 0]}, "each at most once"),
        ({"order": [1]}, "name classes from 0 to 0"),
        ({"size": (10, 10), "tileable": True}, "too small to repeat"),
    ],
)
def test_what_cannot_be_done_is_told(choices: dict, complaint: str) -> None:
    things = draw_things(lattice(*SQUARE, SIZE), SIZE, width=15, height=15)
    with pytest.raises(ValueError, match=complaint):
        seed(things, **choices)


def test_nothing_to_place_is_told() -> None:
    labels = np.zeros((20, 20), int)
    labels[:5] = 1
    with pytest.raises(ValueError, match="no particle is complete"):
        seed(describe_particles(labels, [0]))
    with pytest.raises(ValueError, match="no particle is complete"):
        seed(describe_particles(np.zeros((20, 20), int), []))


def test_where_things_nearly_touch_neighbours_are_those_of_the_picture() -> None:
    """A mosaic of wide and narrow tiles in turn: who stands beside whom is no matter of chance."""
    column, row = np.arange(220)[None, :], np.arange(200)[:, None]
    pair, along = np.divmod(column, 32)
    wide, narrow = along < 20, (along >= 22) & (along < 30)
    tiles = (row % 12 < 10) & (wide | narrow)
    labels = np.where(tiles, 1 + row // 12 * 14 + 2 * pair + narrow, 0)
    mosaic = describe_particles(labels, [0] * (len(np.unique(labels)) - 1))
    learnt = learn_arrangement(mosaic)
    (rule,) = learnt.classes
    assert isinstance(rule, Listed)
    assert rule.coherent
    in_turn = []
    for arrangement in (learnt, Arrangement((rule._replace(coherent=False),))):
        made = seed_composition(mosaic, arrangement, (640, 480), key=jax.random.key(0), tileable=True)
        widths = np.array([mosaic.particles[number].box.width for number in made.particles])
        to_the_right = (made.x[None, :] - made.x[:, None]) % 640
        beside = (np.abs(made.y[None, :] - made.y[:, None]) < 4) & (to_the_right > 0) & (to_the_right < 24)
        first, second = np.nonzero(beside)
        assert len(first) > 0.7 * len(made)
        in_turn.append(np.mean(widths[first] != widths[second]))
    assert in_turn[0] > 0.8
    assert in_turn[1] < 0.65


def test_pairs_stay_pairs_and_lie_anywhere() -> None:
    rng = np.random.default_rng(5)
    pairs = poisson_disc(SIZE, 36, rng)
    turned = rng.uniform(0, np.pi, len(pairs))
    half = 5 * np.stack([np.cos(turned), np.sin(turned)], axis=1)
    exemplar = np.concatenate([pairs - half, pairs + half])
    made = seed(draw_things(exemplar, SIZE, width=6, height=6, discs=True), tileable=True)
    apart = cKDTree(places(made) % LARGE, boxsize=LARGE).query(places(made) % LARGE, 3)[0]
    assert np.median(apart[:, 1]) == pytest.approx(10, abs=1)
    assert np.mean(np.abs(apart[:, 1] - 10) < 1.5) > 0.75
    assert apart[:, 2].mean() > 20
    density = len(exemplar) / ((SIZE[0] + 60) * (SIZE[1] + 60))
    assert len(made) == pytest.approx(density * np.prod(LARGE), rel=0.15)
