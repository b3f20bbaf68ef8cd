"""The correlation of turbulence is the model's own, and rings displaced by it are found as well as they can be."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import least_squares
from turbulent_plank import FREQUENCY, SHAPE, TRUTH, distance, draw_turbulence, turbulence_at

from jaxtex.fitting.rings import lay_plank
from jaxtex.fitting.wood_turbulence import Turbulence, correlate_turbulence, fit_turbulence
from jaxtex.models.wood import make_wood

Floats = NDArray[np.float64]

DRAWN = 20
STRAY = 0.3  # pixels: of each pixel's count, so that a cell of a hundred is known to 0.03


class Found(NamedTuple):
    """``fit``; ``plain`` (5,), what plain least squares come to; ``field`` (H, W), by how much rings were displaced."""

    fit: Turbulence
    plain: Floats
    field: Floats


def fit_plainly(rings: Floats) -> Floats:
    """Least squares that take each pixel's displacement for its own."""
    u, v = (each[::8, ::8].ravel() for each in lay_plank(*SHAPE))
    seen = rings[::8, ::8].ravel()
    return least_squares(lambda free: seen * np.exp(free[4]) - distance(free, u, v), TRUTH, x_scale="jac").x


@pytest.fixture(scope="module", params=[0.0, STRAY], ids=["exact", "stray"])
def found(request: pytest.FixtureRequest) -> list[Found]:
    u, v = lay_plank(*SHAPE)
    results = []
    for seed in range(DRAWN):
        field = draw_turbulence(seed)
        stray = request.param * np.random.default_rng(seed).normal(size=SHAPE)
        rings = (distance(TRUTH, u, v) + field + stray) / np.exp(TRUTH[4])
        plain = fit_plainly(rings)
        fit = fit_turbulence(rings, np.ones(SHAPE, bool), plain, {})
        assert fit is not None
        results.append(Found(fit, plain, field))
    return results


@given(frequency=st.floats(1e-3, 0.2), seed=st.integers(0, 99))
def test_it_is_a_correlation(frequency: float, seed: int) -> None:
    place = np.random.default_rng(seed).uniform(-150, 150, (60, 2))
    correlation = correlate_turbulence(place, frequency)
    np.testing.assert_allclose(np.diag(correlation), 1.0, atol=1e-12)
    np.testing.assert_array_equal(correlation, correlation.T)
    assert np.abs(correlation).max() <= 1 + 1e-12
    assert np.linalg.eigvalsh(correlation).min() > -1e-9


def test_places_of_a_regular_grid_leave_it_one() -> None:
    """Where neighbours lie so close that rounding could make it indefinite."""
    place = np.stack(np.meshgrid(np.arange(20.0), np.arange(15.0)), axis=-1).reshape(-1, 2)
    assert np.linalg.eigvalsh(correlate_turbulence(place, 1 / 300)).min() > -1e-9


@pytest.mark.parametrize("frequency", [1 / 40, 1 / 120])
@pytest.mark.parametrize("tilt", [1.4, np.pi / 2])
def test_it_is_that_of_the_model(frequency: float, tilt: float) -> None:
    """On end grain, where the model's turbulence is alike all around: over many seeds, at pairs of places."""
    drawn = 1200
    place = np.array([[0.0, 0], [6, 2], [-15, 9], [30, 30], [-60, 10], [20, -90], [100, 70]])
    points = jnp.asarray(place, jnp.float32)
    fields = [
        turbulence_at(
            make_wood(ring_spacing=9.0, tilt=tilt, rotation=0.8, turbulence_rms=3.0, turbulence_frequency=frequency,
                      seed=seed), points
        )
        for seed in range(drawn)
    ]  # fmt: skip
    field = np.asarray(fields, float)
    expected = correlate_turbulence(place, frequency)
    # Means of squares and products of normal numbers stray by this much.
    stray = np.sqrt((1 + expected**2) / drawn)
    assert np.abs((field.T @ field / drawn / 3.0**2 - expected) / stray).max() < 4.0


@pytest.mark.slow
def test_rings_are_found_better_than_by_plain_least_squares(found: list[Found]) -> None:
    errors = np.array([[each.plain - TRUTH, each.fit.free - TRUTH] for each in found])
    plain, ours = np.sqrt((errors**2).mean(0))
    assert (ours < 1.05 * plain).all(), ours / plain
    assert np.exp(np.log(ours / plain).mean()) < 0.75


@pytest.mark.slow
def test_the_covariance_is_as_large_as_the_errors(found: list[Found]) -> None:
    normalised = [(each.fit.free - TRUTH) / np.sqrt(np.diag(each.fit.covariance)) for each in found]
    spread = np.sqrt((np.array(normalised) ** 2).mean(0))
    # Twenty draws tell a standard deviation to 16 %, and strength and frequency are themselves uncertain.
    assert ((spread > 0.55) & (spread < 1.7)).all(), spread
    aside = [each.fit.free - TRUTH for each in found]
    squares = [off @ np.linalg.solve(each.fit.covariance, off) for off, each in zip(aside, found, strict=True)]
    assert 2.5 < np.mean(squares) < 10


@pytest.mark.slow
def test_the_rings_are_not_biased(found: list[Found]) -> None:
    errors = np.array([each.fit.free - TRUTH for each in found])
    # The mean of twenty strays by 0.22 standard deviations.
    assert (np.abs(errors.mean(0)) < 0.7 * errors.std(0)).all(), errors.mean(0) / errors.std(0)


@pytest.mark.slow
def test_strength_and_frequency_are_found(found: list[Found]) -> None:
    strength = [each.fit.rms / each.field.std() for each in found]
    assert np.median(strength) == pytest.approx(1.0, abs=0.1)
    assert 0.7 < min(strength) <= max(strength) < 1.4
    assert np.median([each.fit.frequency for each in found]) == pytest.approx(FREQUENCY, rel=0.25)


def test_what_is_held_stays_and_has_no_error() -> None:
    u, v = lay_plank(*SHAPE)
    rings = (distance(TRUTH, u, v) + draw_turbulence(3)) / np.exp(TRUTH[4])
    held = {1: float(TRUTH[1]), 3: float(TRUTH[3])}
    fit = fit_turbulence(rings, np.ones(SHAPE, bool), TRUTH, held)
    assert fit is not None
    np.testing.assert_array_equal(fit.free[[1, 3]], TRUTH[[1, 3]])
    np.testing.assert_array_equal(fit.covariance[[1, 3]], 0.0)
    np.testing.assert_array_equal(fit.covariance[:, [1, 3]], 0.0)
    free = fit_turbulence(rings, np.ones(SHAPE, bool), TRUTH, {})
    assert free is not None
    loose = [0, 2, 4]
    assert (np.diag(fit.covariance)[loose] <= 1.01 * np.diag(free.covariance)[loose]).all()


def test_what_is_not_clear_does_not_count() -> None:
    u, v = lay_plank(*SHAPE)
    rings = (distance(TRUTH, u, v) + draw_turbulence(4)) / np.exp(TRUTH[4])
    clear = np.ones(SHAPE, bool)
    clear[40:80, 80:150] = False
    spoilt = np.where(clear, rings, 1e3)
    ours, spoilt_fit = (fit_turbulence(each, clear, TRUTH, {}) for each in (rings, spoilt))
    assert ours is not None
    assert spoilt_fit is not None
    np.testing.assert_allclose(spoilt_fit.free, ours.free, rtol=1e-9)
    np.testing.assert_allclose(spoilt_fit.covariance, ours.covariance, rtol=1e-9)


def test_too_little_that_is_clear_tells_nothing() -> None:
    clear = np.zeros(SHAPE, bool)
    clear[:20, :20] = True
    assert fit_turbulence(np.ones(SHAPE), clear, TRUTH, {}) is None
