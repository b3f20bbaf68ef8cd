"""Statistics of arrangements, against plain loops, known distributions and linear programs."""

import jax
import numpy as np
import pytest
from drawn_lattices import draw_things, lattice, poisson_disc
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from jaxtex.particles.arrangement import learn_arrangement
from jaxtex.particles.patterns import Pattern, find_nearest, pattern_of_picture
from jaxtex.particles.seeding import seed_composition
from jaxtex.particles.statistics import (
    Sample,
    circular_wasserstein,
    compare_statistics,
    measure_composition,
    measure_picture,
)


@given(st.integers(0, 1000), st.integers(1, 12))
def test_circular_distances_are_those_of_the_best_assignment(seed: int, count: int) -> None:
    one, other = np.random.default_rng(seed).uniform(-9, 9, (2, count))
    apart = (one[:, None] - other[None] + 1) % 2 - 1
    pairs = linear_sum_assignment(np.abs(apart))
    found = circular_wasserstein(Sample(one, np.ones(count)), Sample(other, np.full(count, 3.0)), 2.0)
    assert found == pytest.approx(np.abs(apart)[pairs].mean(), abs=1e-9)


def test_nothing_is_no_distance_from_nothing() -> None:
    nothing, one = Sample(np.zeros(0), np.zeros(0)), Sample(np.ones(1), np.ones(1))
    assert np.isnan(circular_wasserstein(nothing, one, 2.0))


@given(st.integers(0, 1000), st.booleans(), st.integers(1, 4))
def test_neighbours_are_those_of_a_plain_search(seed: int, periodic: bool, count: int) -> None:
    rng = np.random.default_rng(seed)
    points, kinds = rng.uniform(0, 100, (23, 2)), rng.integers(0, 2, 23)
    pattern = Pattern(
        points, kinds, np.ones(23, bool), (0.0, 0.0), (100.0, 100.0), (100.0, 100.0) if periodic else None
    )
    for kind, other in ((0, 0), (0, 1)):
        found = find_nearest(pattern, kind, other, count)
        for row, point in enumerate(found.around):
            ways = points - points[point]
            ways = (ways + 50) % 100 - 50 if periodic else ways
            candidates = [j for j in np.flatnonzero(kinds == other) if j != point]
            candidates.sort(key=lambda j, ways=ways: np.hypot(*ways[j]))
            assert found.which[row, : len(candidates)].tolist() == candidates[:count]
            np.testing.assert_allclose(found.ways[row, : len(candidates)], ways[candidates[:count]])
            border = min(*points[point], *(100 - points[point]))
            for rank, j in enumerate(candidates[:count]):
                distance = np.hypot(*ways[j])
                area = (1 - distance / 50) ** 2
                known = distance <= border and distance < 50
                assert found.weights[row, rank] == pytest.approx(1.0 if periodic else 1 / area if known else 0.0)


def test_the_border_shortens_no_distances() -> None:
    # Of points strewn at random, the mean distance is half of the root of the area that each has.
    found = []
    for seed in range(300):
        points = np.random.default_rng(seed).uniform(0, 100, (40, 2))
        pattern = Pattern(points, np.zeros(40, int), np.ones(40, bool), (0.0, 0.0), (100.0, 100.0), None)
        neighbours = find_nearest(pattern, 0, 0, 1)
        found.append(np.stack([np.hypot(*neighbours.ways[:, 0].T), neighbours.weights[:, 0]]))
    distances, weights = np.concatenate(found, axis=1)
    assert np.average(distances, weights=weights) == pytest.approx(0.5 * (10000 / 40) ** 0.5, rel=0.02)


def test_a_composition_of_a_lattice_has_its_statistics() -> None:
    size = (220, 200)
    things = draw_things(lattice((20, 0), (0, 25), size), size, width=13, height=11)
    made = seed_composition(things, learn_arrangement(things), (300, 250), key=jax.random.key(0), tileable=True)
    (picture,) = measure_picture(things)
    assert picture.distances.mean == pytest.approx(20, abs=0.1)
    off = compare_statistics(picture, *measure_composition(made, things))
    assert off.distance < 0.01
    assert off.direction < 1
    assert off.size < 0.05
    assert off.area < 0.1


def test_distances_tell_other_arrangements() -> None:
    size = (220, 200)
    square = draw_things(lattice((20, 0), (0, 25), size), size, width=13, height=11)
    strewn = draw_things(poisson_disc(size, 14, np.random.default_rng(0)), size, width=7, height=6)
    (one,), (other,) = measure_picture(square), measure_picture(strewn)
    off = compare_statistics(one, other)
    assert off.distance > 0.1
    assert off.direction > 20
    assert off.size > 0.3


def test_cut_particles_are_no_known_points() -> None:
    size = (220, 200)
    things = draw_things(lattice((21.3, 0), (0, 23.7), size), size, width=13, height=11)
    pattern = pattern_of_picture(things)
    assert pattern.low == pytest.approx((6.5, 6.5), abs=0.5)
    assert 0 < pattern.known.sum() < len(pattern.known)
