"""Colour patterns: found where they are, not where they are not."""

import numpy as np
import pytest

from jaxtex.material.patterns import ONE_CLASS, choose_pattern, class_of


def lattice(rows, columns, first=(0, 0)):
    course, tile = np.indices((rows, columns)).reshape(2, -1)
    return course + first[0], tile + first[1]


PATTERNS = {
    "chessboard": ((0, 1), (1, 0)),
    "columns": ((0, 1),),
    "courses": ((0,), (1,)),
    "three diagonals": ((0, 1, 2), (1, 2, 0), (2, 0, 1)),
    "four to a course": ((0, 1, 2, 3),),
    "two by two": ((0, 1), (2, 3)),
}


@pytest.mark.parametrize("pattern", PATTERNS.values(), ids=PATTERNS)
@pytest.mark.parametrize("first", [(0, 0), (-3, -5)])
def test_a_pattern_is_found_through_the_tiles_own_variation(pattern, first):
    course, tile = lattice(7, 8, first)
    rng = np.random.default_rng(1)
    colours = rng.permutation(np.linspace(0.15, 0.85, 4))[:, None] * np.array([1.0, 0.8, 0.7])
    values = colours[class_of(pattern, course, tile)] + 0.03 * rng.standard_normal((len(course), 3))
    found = choose_pattern(course, tile, values)
    # The same tiles share a class, whatever the classes' numbers.
    expected, label = class_of(pattern, course, tile), class_of(found, course, tile)
    pairs = {(int(a), int(b)) for a, b in zip(expected, label, strict=True)}
    assert len(pairs) == len(set(expected.tolist())) == len(set(label.tolist()))


@pytest.mark.parametrize(("rows", "columns", "allowed"), [(3, 3, 10), (3, 4, 10), (4, 4, 10), (6, 6, 0), (14, 5, 0)])
def test_tiles_that_merely_differ_have_no_pattern(rows, columns, allowed):
    # A handful of tiles can alternate by chance; that must be rare.
    lightness = np.random.default_rng(4).uniform(0, 1, (150, rows * columns, 1))
    found = [choose_pattern(*lattice(rows, columns), values * np.array([1.0, 0.9, 0.8])) for values in lightness]
    assert sum(pattern != ONE_CLASS for pattern in found) <= allowed


def test_equal_tiles_and_a_single_tile_have_no_pattern():
    course, tile = lattice(4, 4)
    assert choose_pattern(course, tile, np.full((16, 3), 0.5)) == ONE_CLASS
    assert choose_pattern(course[:1], tile[:1], np.full((1, 3), 0.5)) == ONE_CLASS


def test_a_pattern_is_not_believed_that_explains_less_than_half():
    course, tile = lattice(12, 12)
    rng = np.random.default_rng(3)
    values = np.where((course + tile) % 2, 0.45, 0.55)[:, None] + 0.2 * rng.standard_normal((144, 1))
    assert choose_pattern(course, tile, values) == ONE_CLASS


def test_classes_of_negative_numbers_repeat_like_the_others():
    course, tile = lattice(6, 6, (-3, -3))
    pattern = PATTERNS["three diagonals"]
    assert np.array_equal(class_of(pattern, course, tile), class_of(pattern, course + 9, tile - 6))
