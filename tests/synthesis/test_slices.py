"""One slice made to look like a view: the closed form of the paper's loop, energies, and histograms."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jaxtex.synthesis.slices import (
    BINS,
    REGIONS,
    SliceStatistics,
    analyse_crops,
    coerce_amplitudes,
    equalise_histogram,
    equalise_regions,
    process_slice,
)

RANDOM = np.random.default_rng(0)


def halve_until_in_range(amplitude: float, average: float, lowest: float, highest: float) -> float:
    """The paper's loop (section 4.1, step 2)."""
    for _ in range(50):
        if lowest <= amplitude <= highest:
            break
        amplitude = (amplitude + average) / 2
    return amplitude


def analyse(side: int, channels: int = 2, crops: int = 6) -> SliceStatistics:
    pixels = RANDOM.random((crops, side, side, channels)) ** 2
    return analyse_crops(pixels, pixels.reshape(-1, channels))


amplitudes = st.floats(0, 1e3, width=32)


@settings(max_examples=300, deadline=None)
@given(amplitude=amplitudes, bounds=st.tuples(amplitudes, amplitudes, amplitudes))
def test_amplitudes_are_those_of_the_papers_loop(amplitude: float, bounds: tuple) -> None:
    lowest, average, highest = sorted(bounds)
    with jax.enable_x64(True):
        found = float(
            coerce_amplitudes(*(jnp.asarray(np.float64(each)) for each in (amplitude, average, lowest, highest)))
        )
    expected = halve_until_in_range(amplitude, average, lowest, highest)
    # Where a halving ends exactly on the border, rounding decides whether another follows.
    border = highest if amplitude > average else lowest
    on_border = min(abs(found - border), abs(expected - border)) <= 1e-9 * max(1, border)
    assert on_border or found == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_a_range_of_no_width_is_met() -> None:
    assert float(coerce_amplitudes(*(jnp.float32(each) for each in (8.0, 2.0, 2.0, 2.0)))) == pytest.approx(2.0)


@pytest.mark.parametrize("side", [12, 13])
def test_regions_hold_the_energy_of_the_view(side: int) -> None:
    statistics = analyse(side)
    amplitude = jnp.asarray(RANDOM.random(statistics.average.shape[1:]), jnp.float32)
    scaled = np.asarray(equalise_regions(amplitude, statistics.region[0], statistics.energy[0]))
    weights = np.full(scaled.shape[1], 2.0)
    weights[0] = 1
    if side % 2 == 0:
        weights[-1] = 1
    sums = np.bincount(np.asarray(statistics.region[0]).ravel(), (scaled * weights).ravel(), REGIONS)
    np.testing.assert_allclose(sums, statistics.energy[0], rtol=1e-5, atol=1e-7)


def fill_boxes(values: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Section 4.2, figure 3: the bins of a slice are filled, in order, into those of the view, and each is given the
    mean number of those that it went into."""
    edges = np.linspace(values.min(), values.max(), BINS + 1)
    own = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, BINS - 1)
    room, at, mean = counts / counts.sum() * len(values), 0, np.zeros(BINS)
    for number in range(BINS):
        left = held = float((own == number).sum())
        while left > 1e-9 and at < BINS:
            part = min(left, room[at])
            mean[number] += part * at / held
            left, room[at] = left - part, room[at] - part
            at += room[at] <= 1e-9
    return mean[own]


@pytest.mark.parametrize("power", [0.5, 1.0, 3.0])
def test_histograms_are_filled_as_in_the_paper(power: float) -> None:
    view = RANDOM.random(40_000) ** power
    values = RANDOM.normal(size=10_000).astype(np.float32)
    statistics = analyse_crops(np.broadcast_to(RANDOM.random((2, 8, 8, 1)), (2, 8, 8, 1)), view[:, None])
    made = np.asarray(equalise_histogram(jnp.asarray(values), statistics.cumulative[0], statistics.edges[0]))
    counts, edges = np.histogram(view, BINS)
    expected = edges[0] + (fill_boxes(values, counts) + 0.5) * (edges[1] - edges[0])
    # Within a bin of the slice, the paper gives one value and this a slope.
    assert np.abs(made - expected).mean() < 2 * (edges[1] - edges[0])
    assert (np.diff(made[np.argsort(values)]) >= -1e-6).all()
    shares = np.linspace(0.01, 0.99, 99)
    np.testing.assert_allclose(np.quantile(made, shares), np.quantile(view, shares), atol=0.01)


def test_values_that_are_all_equal_become_the_median() -> None:
    view = RANDOM.random(10_001) ** 3
    statistics = analyse_crops(RANDOM.random((2, 8, 8, 1)), view[:, None])
    made = equalise_histogram(jnp.ones((8, 8)), statistics.cumulative[0], statistics.edges[0])
    np.testing.assert_allclose(made, np.median(view), atol=1 / BINS)


@pytest.mark.parametrize("spread", [0.0, 1e-9])
def test_a_channel_of_one_value_stays_that(spread: float) -> None:
    crops = 0.14 + spread * RANDOM.random((3, 8, 8, 1))
    statistics = analyse_crops(crops, crops.reshape(-1, 1))
    noise = jnp.asarray(0.14 + 1e-7 * RANDOM.random((1, 8, 8)), jnp.float32)
    np.testing.assert_allclose(process_slice(noise, statistics), 0.14, atol=1e-5)


@pytest.mark.parametrize("side", [16, 17])
def test_a_processed_slice_has_the_views_amplitudes_and_values(side: int) -> None:
    statistics = analyse(side)
    noise = jnp.asarray(RANDOM.normal(size=(2, side, side)), jnp.float32)
    made = np.asarray(process_slice(noise, statistics))
    assert made.shape == (2, side, side)
    for channel in range(2):
        least, most = np.asarray(statistics.edges[channel])
        assert made[channel].min() == pytest.approx(least, abs=0.02)
        assert made[channel].max() == pytest.approx(most, abs=0.02)
        amplitude = np.abs(np.fft.rfft2(made[channel])) / side**2
        near = amplitude / np.asarray(statistics.average[channel])
        assert np.median(near) == pytest.approx(1.0, abs=0.25)


def test_slices_shifted_are_results_shifted() -> None:
    """As spectra have it, a slice goes on at its opposite border."""
    statistics = analyse(16)
    noise = jnp.asarray(RANDOM.normal(size=(2, 16, 16)), jnp.float32)
    shifted = process_slice(jnp.roll(noise, (3, 5), (1, 2)), statistics)
    np.testing.assert_allclose(shifted, jnp.roll(process_slice(noise, statistics), (3, 5), (1, 2)), atol=2e-3)


def test_crops_lose_the_step_between_their_borders() -> None:
    slope = np.broadcast_to(np.linspace(0, 1, 32)[None, :, None], (1, 32, 32, 1))
    statistics = analyse_crops(slope, slope.reshape(-1, 1))
    raw = np.abs(np.fft.rfft2(slope[0, ..., 0])) / 32**2
    assert statistics.average[0, 0, 1:].sum() < 0.25 * raw[0, 1:].sum()
    assert statistics.average[0, 0, 0] == pytest.approx(0.5, abs=1e-6)
