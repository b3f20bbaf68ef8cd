"""Tests of `jaxtex.synthesis.exemplars`: against plain loops."""

from functools import cache

import numpy as np
import pytest

from jaxtex.synthesis.exemplars import (
    ExemplarLevel,
    analyse_levels,
    choose_candidates,
    halve,
    halve_mask,
    look_around,
    neighbourhood_weights,
)

RADIUS = 2


def picture(*shape: int) -> np.ndarray:
    return np.random.default_rng(0).random(shape, np.float32)


def halve_by_hand(picture: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Of an even picture, sides rounded up, that is mirrored at its borders."""
    taps = np.outer([1, 3, 3, 1], [1, 3, 3, 1]) / 64
    rows, columns, channels = picture.shape
    result = np.zeros((-(-rows // 2), -(-columns // 2), channels))

    def mirror(index: int, side: int) -> int:
        return min(max(index, -1 - index), 2 * side - 1 - index)

    for row, column in np.ndindex(result.shape[:2]):
        weights = 0.0
        for (down, right), weight in np.ndenumerate(taps):
            at = mirror(2 * row - 1 + down, rows), mirror(2 * column - 1 + right, columns)
            result[row, column] += weight * picture[at] * known[at]
            weights += weight * known[at]
        result[row, column] = result[row, column] / weights if weights else 0
    return result


@pytest.mark.parametrize("shape", [(8, 6), (7, 9), (2, 3), (1, 8), (5, 1), (1, 1)])
def test_halving_is_that_of_a_plain_loop(shape: tuple[int, int]) -> None:
    pixels, known = picture(*shape, 3), np.random.default_rng(1).random(shape) > 0.6
    for mask in (known, np.ones(shape, bool)):
        made = halve(pixels, mask)
        assert made.dtype == np.float32
        np.testing.assert_allclose(made, halve_by_hand(pixels, mask), atol=1e-6)


@pytest.mark.parametrize("shape", [(8, 6), (7, 9), (1, 8)])
def test_a_constant_stays_whatever_is_unknown(shape: tuple[int, int]) -> None:
    known = np.random.default_rng(1).random(shape) > 0.3
    pixels = np.where(known[..., None], np.float32(0.37), np.float32(1e6))
    made = halve(pixels, known)
    near = halve(known[..., None].astype(np.float32), np.ones(shape, bool))[..., 0] > 0
    np.testing.assert_allclose(made[near], 0.37, rtol=1e-5)
    assert (made[~near] == 0).all()


@pytest.mark.parametrize("shape", [(8, 6), (7, 9), (1, 8), (1, 1)])
def test_half_masks_hold_only_whole_pixels(shape: tuple[int, int]) -> None:
    mask = np.random.default_rng(1).random(shape) > 0.3
    made = halve_mask(mask)
    assert made.shape == halve(picture(*shape, 1), mask).shape[:2]
    for row, column in np.ndindex(made.shape):
        assert made[row, column] == mask[2 * row : 2 * row + 2, 2 * column : 2 * column + 2].all()


def test_weights_are_gaussian() -> None:
    weights = np.square(neighbourhood_weights(3).astype(np.float64)).reshape(7, 7)
    assert weights.sum() == pytest.approx(1, abs=1e-6)
    steps = np.arange(-3, 4)
    expected = np.exp(-(steps[:, None] ** 2 + steps[None] ** 2) / (2 * 1.5**2))
    np.testing.assert_allclose(weights, expected / expected.sum(), rtol=1e-5)


def test_neighbourhoods_are_in_scanline_order() -> None:
    pixels = picture(4, 5, 2)
    seen = look_around(pixels, 1)
    assert seen.shape == (20, 9, 2)
    for row, column, tap in np.ndindex(4, 5, 9):
        at = min(max(row + tap // 3 - 1, 0), 3), min(max(column + tap % 3 - 1, 0), 4)
        np.testing.assert_array_equal(seen[row * 5 + column, tap], pixels[at])
    some = np.array([7, 0, 19, 7])
    np.testing.assert_array_equal(look_around(pixels, 1, some), seen[some])


@cache
def analysed() -> list[ExemplarLevel]:
    """Blotches of about four pixels, a hole among them; two levels."""
    from scipy.ndimage import gaussian_filter

    pixels = gaussian_filter(np.random.default_rng(2).normal(size=(34, 41, 2)), (1.5, 1.5, 0)).astype(np.float32)
    usable = np.ones((34, 41), bool)
    usable[20:24, 26:30] = False
    return analyse_levels(pixels, usable, radius=RADIUS, coarsest=16)


def test_levels_go_from_fine_to_coarse() -> None:
    fine, coarse = analysed()
    assert fine.pixels.shape == (34, 41, 2)
    usable = np.ones((34, 41), bool)
    usable[20:24, 26:30] = False
    np.testing.assert_array_equal(coarse.pixels, halve(fine.pixels, usable))


def test_there_are_levels_as_long_as_one_is_large_enough() -> None:
    pixels = picture(65, 40, 1)
    sizes = [
        [each.pixels.shape[:2] for each in analyse_levels(pixels, np.ones((65, 40), bool), radius=1, coarsest=least)]
        for least in (41, 20, 10)
    ]
    assert sizes == [[(65, 40)], [(65, 40), (33, 20)], [(65, 40), (33, 20), (17, 10)]]


def test_levels_without_a_valid_place_are_left_out() -> None:
    usable = np.zeros((40, 40), bool)
    usable[10:16, 10:16] = True
    assert len(analyse_levels(picture(40, 40, 1), usable, radius=2, coarsest=10)) == 1


def test_places_are_valid_where_the_neighbourhood_is_whole() -> None:
    usable = np.ones((34, 41), bool)
    usable[20:24, 26:30] = False
    for level, mask in zip(analysed(), (usable, halve_mask(usable)), strict=True):
        expected = np.zeros(mask.shape, bool)
        for row, column in np.ndindex(*mask.shape):
            window = mask[max(0, row - 2) : row + 3, max(0, column - 2) : column + 3]
            expected[row, column] = window.shape == (5, 5) and window.all()
        np.testing.assert_array_equal(level.valid, expected)


def test_nearest_valid_places_are_the_nearest() -> None:
    for level in analysed():
        places = np.argwhere(level.valid)
        for number, (row, column) in enumerate(np.ndindex(*level.valid.shape)):
            found = np.array(divmod(level.nearest_valid[number], level.valid.shape[1]))
            assert level.valid[tuple(found)]
            least = np.square(places - [row, column]).sum(axis=1).min()
            assert np.square(found - [row, column]).sum() == least


def test_features_are_neighbourhoods_in_few_numbers() -> None:
    """All that a neighbourhood of 25 pixels of 2 channels holds but a few hundredths, for valid ones."""
    for level in analysed():
        valid = level.valid.ravel()
        values = (look_around(level.pixels, RADIUS) * neighbourhood_weights(RADIUS)[:, None]).reshape(valid.size, -1)
        basis, features = np.asarray(level.basis, np.float64), np.asarray(level.features)
        np.testing.assert_allclose(basis.T @ basis, np.eye(24), atol=1e-5)
        np.testing.assert_allclose(features, values @ basis, atol=1e-5)
        seen = values[valid] - values[valid].mean(axis=0)
        kept = np.square(seen @ basis).sum() / np.square(seen).sum()
        best = np.sort(np.linalg.eigvalsh(np.cov(seen.T, bias=True)))[::-1]
        assert kept == pytest.approx(best[:24].sum() / best.sum(), abs=1e-4)
        assert kept > 0.95


def test_small_neighbourhoods_keep_all_their_numbers() -> None:
    (level,) = analyse_levels(picture(12, 12, 1), np.ones((12, 12), bool), radius=1, coarsest=32)
    assert level.features.shape == (144, 9)
    square = np.square(look_around(level.pixels, 1)[..., 0] * neighbourhood_weights(1)).sum(axis=1)
    np.testing.assert_allclose(np.square(np.asarray(level.features)).sum(axis=1), square, rtol=1e-4)


def beside(first: int, second: int, columns: int) -> bool:
    rows_apart = abs(first // columns - second // columns)
    return rows_apart <= 1 and abs(first % columns - second % columns) <= 1


def test_similar_places_are_valid_and_apart() -> None:
    for level in analysed():
        columns = level.valid.shape[1]
        similar = np.asarray(level.similar)
        np.testing.assert_array_equal(similar[:, 0], np.arange(level.valid.size))
        assert level.valid.ravel()[similar[:, 1:]].mean() > 0.999
        for place, found in enumerate(similar):
            for first in range(len(found)):
                for second in range(first):
                    assert not beside(found[first], found[second], columns) or found[first] == place


def test_at_the_coarsest_level_they_are_the_nearest() -> None:
    level = analysed()[-1]
    columns = level.valid.shape[1]
    features, similar = np.asarray(level.features, np.float64), np.asarray(level.similar)
    distances = np.square(features[:, None] - features[None]).sum(axis=2)
    distances[:, ~level.valid.ravel()] = np.inf
    for place in range(level.valid.size):
        left = distances[place].copy()
        taken = [place]
        for found in similar[place, 1:]:
            for other in range(len(left)):
                if beside(other, taken[-1], columns):
                    left[other] = np.inf
            assert left[found] == pytest.approx(left.min(), rel=1e-4, abs=1e-9)
            taken.append(int(found))


def test_at_finer_levels_they_are_nearly_the_nearest() -> None:
    """Far nearer than others are, and often the same as a search of all places finds."""
    level = analysed()[0]
    features, similar = np.asarray(level.features), np.asarray(level.similar)
    valid = np.flatnonzero(level.valid)
    distances = np.square(features[valid, None] - features[None, valid]).sum(axis=2)
    rows, columns = np.divmod(valid, level.valid.shape[1])
    apart = np.maximum(np.abs(rows[:, None] - rows[None]), np.abs(columns[:, None] - columns[None]))
    best = np.where(apart > 1, distances, np.inf).min(axis=1)
    found = np.square(features[valid] - features[similar[valid, 1]]).sum(axis=1)
    assert (found >= best * (1 - 1e-4)).all()
    assert np.median(found / best) < 1.5
    assert np.median(found) < 0.2 * np.median(distances)


def test_candidates_are_valid_and_spread_over_all() -> None:
    valid = np.random.default_rng(0).random((200, 150)) > 0.3
    chosen = choose_candidates(valid)
    assert len(chosen) == len(np.unique(chosen)) == 2**12
    assert valid.ravel()[chosen].all()
    shares = np.histogram(chosen, bins=8, range=(0, valid.size))[0] / len(chosen)
    np.testing.assert_allclose(shares, 1 / 8, atol=0.01)
    few = valid[:60, :60]
    np.testing.assert_array_equal(choose_candidates(few), np.flatnonzero(few))
    assert len(choose_candidates(np.zeros((5, 5), bool))) == 0


def test_where_nothing_else_is_the_place_itself_stands_again() -> None:
    (level,) = analyse_levels(picture(7, 7, 1), np.ones((7, 7), bool), radius=3, coarsest=32)
    assert level.valid.sum() == 1
    np.testing.assert_array_equal(np.asarray(level.similar)[24], [24] * 7)
    assert (np.asarray(level.similar)[0, 1:] == [24] + [0] * 5).all()


def test_periodic_places_look_alike() -> None:
    stripes = np.tile(np.float32([0, 0.2, 1, 0.4, 0.7, 0.9]), (40, 7))[..., None]
    for level in analyse_levels(stripes, np.ones((40, 42), bool), radius=2, coarsest=40):
        row, column = np.divmod(np.asarray(level.similar), 42)
        inside = level.valid.ravel()
        assert ((column[:, 1:] - column[:, :1])[inside] % 6 == 0).all()
        assert row.shape == (40 * 42, 7)


def test_no_whole_neighbourhood_is_an_error() -> None:
    for usable in (np.zeros((20, 20), bool), np.arange(400).reshape(20, 20) % 4 > 0):
        with pytest.raises(ValueError, match="no neighbourhood of 5 x 5 pixels may be copied from"):
            analyse_levels(picture(20, 20, 1), usable, radius=2, coarsest=32)
