"""Which way stripes run is known; so is what becomes of them when they are averaged, followed and compared."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from jaxtex.photo.directions import (
    compare_directions,
    directions_of,
    follow_grain,
    main_direction,
    measure_directions,
    smooth_along,
)

Array = NDArray[np.float64]

SHAPE = 96, 128
SPACING = 12.0
# At the border the picture goes on mirrored, and so do its directions.
INNER = np.s_[12:-12, 12:-12]

turns = st.floats(-np.pi, 2 * np.pi)


def lay(turn: float, shape: tuple[int, int] = SHAPE) -> tuple[Array, Array]:
    """Across and along stripes of a direction, from the picture's middle."""
    v, u = np.indices(shape) + 0.5 - np.array(shape).reshape(2, 1, 1) / 2
    return u * np.cos(turn) + v * np.sin(turn), v * np.cos(turn) - u * np.sin(turn)


def stripes(level: Array) -> Array:
    return np.sin(2 * np.pi * level / SPACING + 0.3)


def noise(seed: int = 0, shape: tuple[int, int] = SHAPE) -> Array:
    return np.random.default_rng(seed).normal(size=shape)


def apart(a: Array | float, b: Array | float) -> Array:
    """Degrees between directions that have no sense."""
    return np.abs(np.degrees((a - b + np.pi / 2) % np.pi - np.pi / 2))


def slopes(level: Array) -> Array:
    down, right = np.gradient(level)
    return np.arctan2(down, right)


def displaced(turn: float, shape: tuple[int, int]) -> tuple[Array, Array]:
    """Straight rings, and the same displaced by a smooth map that turns them by up to 27 degrees."""
    across, along = lay(turn, shape)
    bent = 8 * np.sin(2 * np.pi * along / 150 + 0.4) + 5 * np.sin(2 * np.pi * (across + 0.5 * along) / 180)
    return across, across + bent


@given(turn=turns)
def test_the_direction_of_stripes_is_measured_everywhere(turn: float) -> None:
    measured = measure_directions(stripes(lay(turn)[0]), 2.0)
    assert apart(np.angle(measured.across) / 2, turn)[INNER].max() < 1.0
    clear = np.abs(measured.across) / measured.energy
    assert clear[INNER].min() > 0.95
    assert clear.max() <= 1 + 1e-9


@given(turn=turns)
def test_the_main_direction_is_that_of_the_stripes(turn: float) -> None:
    main, clear = main_direction(measure_directions(stripes(lay(turn)[0]), 2.0))
    assert 0 <= main < np.pi
    assert apart(main, turn) < 0.5
    assert 0.97 < clear <= 1 + 1e-9


def test_directions_on_both_sides_of_a_half_turn_do_not_cancel() -> None:
    picture = stripes(lay(np.radians(2))[0])
    picture[:, 64:] = stripes(lay(np.radians(178))[0])[:, 64:]
    main, clear = main_direction(measure_directions(picture, 2.0))
    assert apart(main, 0.0) < 0.5
    assert clear > 0.97


@pytest.mark.parametrize("seed", range(4))
def test_noise_has_no_main_direction(seed: int) -> None:
    assert main_direction(measure_directions(noise(seed), 1.0))[1] < 0.08


@given(turn=turns)
def test_the_directions_of_a_map_are_those_of_its_slope(turn: float) -> None:
    across, bent = displaced(turn, SHAPE)
    straight = directions_of(across)
    np.testing.assert_allclose(straight.across, np.exp(2j * turn), atol=1e-9)
    assert apart(np.angle(directions_of(bent).across) / 2, slopes(bent)).max() < 1e-6


@given(turn=turns)
def test_stripes_averaged_along_themselves_stay_and_noise_on_them_goes(turn: float) -> None:
    clean = stripes(lay(turn)[0])
    directions = measure_directions(clean, 2.0)
    assert np.abs(smooth_along(clean, directions, 8.0) - clean)[INNER].max() < 0.1
    rough = smooth_along(clean + noise(), directions, 8.0) - clean
    # A Gaussian of 8 pixels averages 28 of them: a fifth of the noise stays.
    assert rough[INNER].std() < 0.25


def test_the_average_is_gaussian_along_the_grain() -> None:
    """A point is spread along straight stripes as a Gaussian of the reach, and not across them."""
    across, _ = lay(np.pi / 2)
    point = np.zeros(SHAPE)
    point[48, 64] = 1.0
    spread = smooth_along(point, directions_of(across), 6.0)
    assert np.abs(np.delete(spread, 48, axis=0)).max() < 1e-12
    steps = np.arange(-12, 13)
    weights = np.exp(-0.5 * (steps / 6.0) ** 2)
    np.testing.assert_allclose(spread[48, 52:77], weights / weights.sum(), atol=1e-9)
    assert np.abs(spread[48, :52]).max() < 1e-12


def test_an_average_of_one_value_is_that_value_up_to_the_border() -> None:
    flat = np.full(SHAPE, 3.0)
    np.testing.assert_allclose(smooth_along(flat, measure_directions(noise(), 2.0), 9.0), 3.0)


@given(turn=turns, seed=st.integers(0, 99))
def test_some_places_are_averaged_as_in_the_whole_picture(turn: float, seed: int) -> None:
    picture = stripes(lay(turn)[0]) + 0.5 * noise()
    directions = measure_directions(picture, 2.0)
    row, column = np.random.default_rng(seed).integers(0, SHAPE, (40, 2)).T
    some = smooth_along(picture, directions, 5.0, at=np.stack([row, column]).astype(float))
    np.testing.assert_allclose(some, smooth_along(picture, directions, 5.0)[row, column], atol=1e-12)


def test_places_asked_for_are_not_moved() -> None:
    at = np.array([[10.0, 20.5], [30.0, 40.25]])
    kept = at.copy()
    smooth_along(noise(), measure_directions(noise(), 2.0), 5.0, at=at)
    np.testing.assert_array_equal(at, kept)


@pytest.mark.parametrize("shape", [(192, 256), (130, 97), (64, 200)])
@pytest.mark.parametrize("degrees", [0, 30, 77, 120, 179])
def test_displaced_stripes_are_followed(shape: tuple[int, int], degrees: float) -> None:
    straight, bent = displaced(np.radians(degrees), shape)
    found = follow_grain(measure_directions(stripes(bent), 1.5), straight)
    assert apart(slopes(straight), slopes(bent)).mean() > 10
    aside = apart(slopes(found), slopes(bent))[8:-8, 8:-8]
    assert aside.mean() < 1.0
    assert aside.max() < 4.0
    # Along each level of the map, the stripes keep their place to a small part of their spacing.
    level = np.round(found - found.min()).astype(int).ravel()
    mean = np.bincount(level, bent.ravel()) / np.maximum(np.bincount(level), 1)
    assert (bent.ravel() - mean[level]).std() < 0.06 * SPACING


@given(turn=turns)
def test_a_map_that_runs_along_the_grain_already_stays(turn: float) -> None:
    straight, bent = displaced(turn, SHAPE)
    for rings in (straight, bent):
        np.testing.assert_allclose(follow_grain(directions_of(rings), rings), rings, atol=1e-6)
        found = follow_grain(measure_directions(stripes(rings), 1.5), rings)
        assert apart(slopes(found), slopes(rings))[INNER].max() < 2.0


def test_a_map_is_not_bent_by_what_is_not_clear() -> None:
    """A patch that runs another way does not count where it is known to."""
    across, _ = lay(0.3)
    picture = stripes(across)
    picture[36:60, 50:80] = stripes(lay(1.5)[0])[36:60, 50:80]
    directions, clear = measure_directions(picture, 1.5), np.ones(SHAPE, bool)
    clear[26:70, 40:90] = False
    wrong, right = (follow_grain(directions, across, clear=where) for where in (None, clear))
    near = np.s_[30:66, 44:86]
    assert apart(slopes(right), 0.3)[near].max() < 2.0
    assert apart(slopes(wrong), 0.3)[near].max() > 5.0


@given(turn=turns)
def test_stripes_agree_with_their_own_direction(turn: float) -> None:
    across, along = lay(turn)
    directions = measure_directions(stripes(across), 2.0)
    agreement, crossing, clear = compare_directions(directions, across)
    assert 0.95 < agreement <= 1 + 1e-9
    assert crossing < 0.01
    assert clear.mean() > 0.99
    # All of it runs across a map that is turned by a right angle.
    agreement, crossing, clear = compare_directions(directions, along)
    assert -1 - 1e-9 <= agreement < -0.95
    assert crossing > 0.99
    # What is strong is above the median.
    assert clear.mean() == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize("seed", range(4))
def test_noise_agrees_with_no_map(seed: int) -> None:
    agreement, crossing, _ = compare_directions(measure_directions(noise(seed), 1.0), lay(0.7)[0])
    assert abs(agreement) < 0.05
    assert crossing == pytest.approx(25 / 90, abs=0.07)


def test_the_head_joints_of_bricks_run_across_their_courses() -> None:
    y, x = np.indices((192, 256)) + 0.5
    course = np.floor(y / 16)
    head, bed = (x / 40 - 0.5 * course) % 1 * 40, y - 16 * course
    joint = (np.minimum(head, 40 - head) < 1.5) | (np.minimum(bed, 16 - bed) < 1.5)
    directions = measure_directions(-joint.astype(float), 0.7, reach=2.0)
    agreement, crossing, _ = compare_directions(directions, y)
    # Of 56 pixels of joint around each brick, 16 are head joints; and where both meet, neither direction is clear.
    assert 0.10 < crossing < 16 / 56
    assert agreement < 0.7
    assert compare_directions(measure_directions(stripes(y), 0.7, reach=2.0), y)[1] < 0.01


def test_a_crack_weighs_less_than_it_is_strong() -> None:
    across, along = lay(0.4)
    directions = measure_directions(stripes(across) - 30.0 * (np.abs(along) < 1), 1.0)
    everything = np.sum((directions.across * np.exp(-0.8j)).real) / directions.energy.sum()
    agreement, _, clear = compare_directions(directions, across)
    assert everything < -0.9
    assert agreement > everything + 0.4
    assert not clear[np.abs(along) < 1].any()
    assert clear[np.abs(along) > 20].mean() > 0.95
