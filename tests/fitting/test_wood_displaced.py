"""Rings and turbulence on the mask itself: as near to the truth as can be, and as uncertain as said."""

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from turbulent_plank import FREQUENCY, RMS, SHAPE, TRUTH, distance, draw_turbulence

from jaxtex.fitting import wood_displaced
from jaxtex.fitting.rings import lay_plank
from jaxtex.fitting.wood_displaced import Displaced, bound_errors, fit_displaced
from jaxtex.fitting.wood_turbulence import Turbulence, fit_turbulence

Floats = NDArray[np.float64]

SPACING = float(np.exp(TRUTH[4]))
FRACTION = 0.4
LOGIT = float(np.log(FRACTION / (1 - FRACTION)))
CLEAR = np.ones(SHAPE, bool)
CLEAR[:, :100] = False  # as if rings could be followed on a half of the picture only


class Found(NamedTuple):
    """``fit``; ``field`` (H, W), by how much rings were displaced; ``bound`` (6,), standard deviations."""

    fit: Displaced
    field: Floats
    bound: Floats


def draw(seed: int, truth: Floats = TRUTH, strength: float = 1.0) -> tuple[Floats, Floats, Floats]:
    """Rings, their displacement, and the mask of early wood (H, W)."""
    field = strength * draw_turbulence(seed)
    rings = (distance(truth, *lay_plank(*SHAPE)) + field) / SPACING
    return rings, field, (np.sin(2 * np.pi * rings) > np.cos(np.pi * FRACTION)).astype(float)


def begin(seed: int, held: dict[int, float]) -> Turbulence:
    fitted = fit_turbulence(draw(seed)[0], CLEAR, TRUTH, held)
    assert fitted is not None
    return fitted


def fit(seed: int, fitted: Turbulence, held: dict[int, float] | None = None) -> Displaced:
    rings, _, early = draw(seed)
    return fit_displaced(early, rings, CLEAR, fitted, 0.0, held or {})


@pytest.fixture(scope="module")
def begun() -> list[Turbulence]:
    return [begin(seed, {}) for seed in range(16)]


@pytest.fixture(scope="module")
def found(begun: list[Turbulence]) -> list[Found]:
    results = []
    for seed, fitted in enumerate(begun):
        field = draw_turbulence(seed)
        covariance = bound_errors(np.append(TRUTH, LOGIT), field, rms=RMS, frequency=FREQUENCY)
        results.append(Found(fit(seed, fitted), field, np.sqrt(np.diag(covariance))))
    return results


@pytest.mark.slow
def test_the_rings_are_found_as_well_as_can_be(found: list[Found]) -> None:
    errors = np.array([(each.fit.free - np.append(TRUTH, LOGIT)) / each.bound for each in found])
    ratio = np.sqrt((errors**2).mean(0))[:5]
    # Sixteen draws tell a standard deviation to 18 %.
    assert ((ratio > 0.5) & (ratio < 1.6)).all(), ratio
    assert (np.abs(errors.mean(0))[:5] < 0.8).all(), errors.mean(0)


@pytest.mark.slow
@pytest.mark.parametrize(("known", "most"), [(True, 1.6), (False, 2.2)])
def test_the_covariance_is_as_large_as_the_errors(
    found: list[Found], begun: list[Turbulence], known: bool, most: float
) -> None:
    """Strength and frequency of so few waves as the picture holds are uncertain, for which it does not account."""
    fits = [each.fit for each in found]
    if known:
        fits = [fit(seed, each._replace(rms=RMS, frequency=FREQUENCY)) for seed, each in enumerate(begun)]
    normalised = [(each.free - np.append(TRUTH, LOGIT))[:5] / np.sqrt(np.diag(each.covariance)[:5]) for each in fits]
    spread = np.sqrt((np.array(normalised) ** 2).mean(0))
    assert ((spread > 0.5) & (spread < most)).all(), spread


@pytest.mark.slow
def test_the_displacement_and_the_share_are_found(found: list[Found]) -> None:
    off = [each.fit.displacement - each.field for each in found]
    assert np.median([each.std() for each in off]) < 0.4 * RMS
    assert np.median([each.fit.rms / each.field.std() for each in found]) == pytest.approx(1.0, abs=0.1)
    assert np.mean([each.fit.believed.mean() for each in found]) > 0.99
    share = [1 / (1 + np.exp(-each.fit.free[5])) for each in found]
    np.testing.assert_allclose(share, FRACTION, atol=0.01)


@pytest.mark.parametrize("miscounted", [-1, 1])
def test_rings_that_were_miscounted_are_counted_again(miscounted: int) -> None:
    """Where the axis is out of sight, but rings bend enough to tell how far away it is."""
    truth = TRUTH - 50 * np.eye(5)[1]
    rings, _, early = draw(3, truth, 0.3)
    clear = np.ones(SHAPE, bool)
    fitted = fit_turbulence(rings + miscounted, clear, truth, {})
    assert fitted is not None
    assert abs(fitted.free[4] - truth[4]) > 0.03
    again = fit_displaced(early, rings + miscounted, clear, fitted, 0.0, {})
    assert again.free[4] == pytest.approx(truth[4], abs=0.02)
    np.testing.assert_allclose(again.free[:2], truth[:2], atol=2.0)


def test_what_is_held_stays_and_has_no_error() -> None:
    held = {1: float(TRUTH[1]), 3: float(TRUTH[3])}
    ours = fit(3, begin(3, held), held)
    np.testing.assert_array_equal(ours.free[[1, 3]], TRUTH[[1, 3]])
    np.testing.assert_array_equal(ours.covariance[[1, 3]], 0.0)


def test_a_place_that_was_painted_over_does_not_count() -> None:
    rings, field, early = draw(5)
    early[50:90, 150:200] = 1.0
    fitted = fit_turbulence(rings, CLEAR, TRUTH, {})
    assert fitted is not None
    ours = fit_displaced(early, rings, CLEAR, fitted, 0.0, {})
    assert not ours.believed[60:80, 165:185].any()
    assert ours.believed[:, :120].all()
    assert (ours.displacement - field)[:, :120].std() < 0.5 * RMS


@settings(max_examples=10, deadline=None)
@given(rms=st.floats(0.3, 3.0), more=st.floats(1.1, 3.0))
def test_the_bound_grows_with_the_displacement(rms: float, more: float) -> None:
    free = np.append(TRUTH, LOGIT)
    less, greater = (bound_errors(free, np.zeros((60, 80)), rms=each, frequency=0.02) for each in (rms, more * rms))
    assert (np.diag(less) > 0).all()
    assert (np.diag(greater)[:5] > np.diag(less)[:5]).all()
    # By no more than the square of it, which is what there is where nothing else is uncertain.
    assert (np.diag(greater) < 1.001 * more**2 * np.diag(less)).all()


def test_the_normal_equations_are_those_of_plain_sums() -> None:
    """On a picture so small that every pixel's own row can be written down."""
    random = np.random.default_rng(0)
    rows, columns, m, n = random.normal(size=(7, 4)), random.normal(size=(9, 5)), 4, 5
    splines = wood_displaced._Splines(rows, columns)
    off, weight = random.normal(size=(7, 9)), random.uniform(0, 2, (7, 9))
    slopes, vector = random.normal(size=(7, 7, 9)), random.normal(size=6 + m * n)
    precision = np.diag(random.uniform(1, 2, m * n))
    curvature, gradient = wood_displaced._add_up(off, slopes, weight, splines, precision, vector)
    expected, slope = np.zeros((6 + m * n,) * 2), np.zeros(6 + m * n)
    expected[6:, 6:] = precision
    slope[6:] = precision @ vector[6:]
    for y in range(7):
        for x in range(9):
            row = np.concatenate([slopes[:6, y, x], slopes[6, y, x] * np.outer(rows[y], columns[x]).ravel()])
            expected += weight[y, x] * np.outer(row, row)
            slope += weight[y, x] * off[y, x] * row
    np.testing.assert_allclose(curvature, expected, atol=1e-10)
    np.testing.assert_allclose(gradient, slope, atol=1e-10)
