"""Compositions relaxed, against arrangements that their pictures were drawn in."""

import dataclasses

import jax
import numpy as np
import pytest
from drawn_lattices import draw_things, lattice, measure_lattice, poisson_disc
from scipy.spatial import cKDTree

from jaxtex.core.errors import InputError
from jaxtex.particles.arrangement import learn_arrangement
from jaxtex.particles.composition import Composition
from jaxtex.particles.relaxation import relax_composition
from jaxtex.particles.seeding import seed_composition
from jaxtex.particles.statistics import compare_statistics, measure_composition, measure_picture
from jaxtex.particles.things import Decomposition, describe_particles

SIZE, LARGE = (220, 200), (500, 500)
SQUARE = [(24.7, 0.0), (0.0, 24.7)]
WAY = (11.0, 3.0)  # from each large disc to its dot
COLUMNS = ("kinds", "particles", "angles", "scales", "gains")


def seed(things: Decomposition, number: int = 0, size: tuple[int, int] = LARGE, tileable: bool = False) -> Composition:
    return seed_composition(things, learn_arrangement(things), size, key=jax.random.key(number), tileable=tileable)


def places(composition: Composition, kind: int = 0) -> np.ndarray:
    return np.stack([composition.x, composition.y], axis=1)[composition.kinds == kind]


def draw_discs_with_dots() -> Decomposition:
    """Large discs anywhere at some distance, and a dot at the same place beside each."""
    points = poisson_disc(SIZE, 25, np.random.default_rng(1))
    row, column = np.indices(SIZE[::-1]) + 0.5
    labels, kinds = np.zeros(SIZE[::-1], int), []
    for number, (x, y) in enumerate(points):
        for kind, (radius, dx, dy) in enumerate([(6.0, 0.0, 0.0), (2.5, *WAY)]):
            inside = np.hypot(column - x - dx, row - y - dy) < radius
            if inside.any():
                labels[inside] = 2 * number + kind + 1
                kinds.append(kind)
    return describe_particles(labels, kinds)


def share_with_dots(made: Composition) -> float:
    """Of the dots, how many are where the picture has them beside a disc."""
    tree = cKDTree(places(made, 0), boxsize=(made.width, made.height))
    dots = (places(made, 1) - np.array([WAY])) % np.array([[made.width, made.height]])
    return float((tree.query(dots)[0] < 2).mean())


def test_what_one_class_is_to_another_is_brought_back() -> None:
    things = draw_discs_with_dots()
    made = seed(things, tileable=True)
    assert share_with_dots(made) < 0.15
    assert share_with_dots(relax_composition(made, things)) > 0.3


def jittered(share: float) -> Decomposition:
    points = lattice(*SQUARE, SIZE)
    noise = np.random.default_rng(0).normal(0, share * SQUARE[0][0], points.shape)
    return draw_things(points + noise, SIZE, width=15, height=15, discs=True)


@pytest.mark.parametrize("tileable", [False, True])
def test_statistics_come_closer_to_the_pictures(tileable: bool) -> None:
    things = draw_things(poisson_disc(SIZE, 21, np.random.default_rng(1)), SIZE, width=14, height=14, discs=True)
    made = seed(things, tileable=tileable)
    (picture,) = measure_picture(things)
    before, after = (
        compare_statistics(picture, *measure_composition(each, things))
        for each in (made, relax_composition(made, things))
    )
    assert after.distance < 0.6 * before.distance
    assert after.direction < before.direction + 3  # of so few particles, chance alone makes more


def test_lattices_are_not_torn() -> None:
    things = jittered(0.0)
    turned, stretched, missing = measure_lattice(places(relax_composition(seed(things), things)), SQUARE, LARGE)
    assert turned < 0.5
    assert stretched < 0.02
    assert missing < 0.01


def test_jittered_lattices_are_mended() -> None:
    things = jittered(0.07)
    made = seed(things)
    before = measure_lattice(places(made), SQUARE, LARGE)
    after = measure_lattice(places(relax_composition(made, things)), SQUARE, LARGE)
    assert after[2] < 0.75 * before[2]
    assert after[0] < 2


def test_what_is_fixed_stays() -> None:
    things = jittered(0.07)
    made = seed(things)
    fixed = np.arange(len(made)) % 3 == 0
    relaxed = relax_composition(made, things, fixed=fixed)
    np.testing.assert_array_equal(relaxed.x[fixed], made.x[fixed])
    np.testing.assert_array_equal(relaxed.y[fixed], made.y[fixed])
    assert (np.abs(relaxed.x - made.x)[~fixed] > 0.1).mean() > 0.5
    for name in ("kinds", "particles", "angles", "scales"):
        np.testing.assert_array_equal(getattr(relaxed, name), getattr(made, name))


def test_boxes_that_overlap_are_pressed_apart() -> None:
    things = jittered(0.0)
    made = seed(things)
    moved = dataclasses.replace(made, x=made.x + np.random.default_rng(0).normal(0, 6, len(made)))

    def overlaps(composition: Composition) -> int:
        return len(cKDTree(places(composition)).query_pairs(15.0))

    assert overlaps(moved) > 20
    assert overlaps(relax_composition(moved, things)) < 0.2 * overlaps(moved)


def test_moved_across_the_border_of_a_plane_that_repeats() -> None:
    things = jittered(0.04)
    made = seed(things, size=(247, 247), tileable=True)
    shifted = dataclasses.replace(made, x=(made.x + 91.3) % 247, y=(made.y + 55.1) % 247)
    # What rounding makes of ties grows from round to round.
    one, other = (relax_composition(each, things, rounds=1) for each in (made, shifted))
    away = (places(other) - places(one) - np.array([[91.3, 55.1]]) + 123.5) % 247 - 123.5
    moved = np.hypot(one.x - made.x, one.y - made.y)
    assert np.median(np.hypot(*away.T)) < 0.2 * np.median(moved)


def test_few_or_none_are_left_as_they_are() -> None:
    things = jittered(0.0)
    made = seed(things)
    one = dataclasses.replace(made, **{name: getattr(made, name)[:1] for name in NAMES})
    assert relax_composition(one, things) is one
    np.testing.assert_array_equal(relax_composition(made, things, rounds=0).x, made.x)


NAMES = ("kinds", "particles", "x", "y", "angles", "scales", "gains")


def test_what_cannot_be_done_is_told() -> None:
    things = jittered(0.0)
    made = seed(things)
    with pytest.raises(ValueError, match="one to each of the"):
        relax_composition(made, things, fixed=[True])
    with pytest.raises(ValueError, match="rounds is -1"):
        relax_composition(made, things, rounds=-1)
    with pytest.raises(InputError, match="give the ones it was made of"):
        relax_composition(made, jittered(0.07))


def test_pairs_that_lie_anyhow_are_turned_as_in_the_picture() -> None:
    pairs = poisson_disc(SIZE, 30, np.random.default_rng(3))
    half = np.array([[5.0, 5.0]])
    things = draw_things(np.concatenate([pairs - half, pairs + half]), SIZE, width=6, height=6, discs=True)
    rng = np.random.default_rng(4)
    middles = poisson_disc((300, 300), 30, rng)
    angles = rng.uniform(0, np.pi, len(middles))
    ways = 50**0.5 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    made = seed(things, size=(300, 300), tileable=True)
    x, y = (np.concatenate([middles - ways, middles + ways]) % (300, 300)).T
    count = min(len(x), len(made))
    turned = dataclasses.replace(
        made, x=x[:count], y=y[:count], **{name: getattr(made, name)[:count] for name in COLUMNS}
    )
    (picture,) = measure_picture(things)
    before, after = (
        compare_statistics(picture, *measure_composition(each, things)).direction
        for each in (turned, relax_composition(turned, things))
    )
    assert after < 0.2 * before  # without directions of their own 0.28
