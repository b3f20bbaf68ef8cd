"""One slice of a solid texture made to look like a view of it: J.-M. Dischler, D. Ghazanfarpour and R. Freydier,
"Anisotropic solid texture synthesis using orthogonal 2D views" (Eurographics 1998), section 4.

What a view looks like is told by its Fourier amplitudes, which vary from crop to crop within a range, and by the
histogram of its values. A slice keeps its phases; its amplitudes are moved into the range, the energy in each region of
the frequency plane to the view's, and its values, in order, to the view's histogram.

Departures: of each crop the periodic part is taken (L. Moisan, "Periodic plus smooth image decomposition", 2011), as
the step between its opposite borders would put a cross into every spectrum; the mean value, which would stretch the
intervals of amplitudes, has no part in their division; and histograms are linear within their bins, so that values do
not gather at 256 levels.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

BINS = 256
REGIONS = 16
_MOST_HALVINGS = 50

Floats = npt.NDArray[np.floating]


class SliceStatistics(eqx.Module):
    """What slices of a solid should be like. Frequencies are those of `rfft2`, as many as n x n pixels have.

    Attributes:
        average: mean amplitude of the crops, [channel, row, col].
        lowest, highest: the range of their amplitudes, [channel, row, col].
        region: number of the region of each frequency, [channel, row, col].
        energy: sum of the average amplitudes of each region, [channel, region].
        cumulative: share of the view's values that are below each edge between bins, [channel, BINS + 1].
        edges: the least and the greatest of these edges, [channel, 2].
    """

    average: Array
    lowest: Array
    highest: Array
    region: Array
    energy: Array
    cumulative: Array
    edges: Array


def analyse_crops(crops: Floats, values: Floats) -> SliceStatistics:
    """The statistics of a view.

    Args:
        crops: of the view, [crop, row, col, channel], all of the slices' size.
        values: all of the view's, [value, channel].

    Examples:
        >>> grain = np.random.default_rng(0).random((5, 16, 16, 1))
        >>> statistics = analyse_crops(grain, grain.reshape(-1, 1))
        >>> statistics.average.shape, statistics.energy.shape
        ((1, 16, 9), (1, 16))
    """
    amplitude = np.stack([np.abs(_periodic_spectrum(np.moveaxis(crop, -1, 0))) for crop in crops])
    average = amplitude.mean(axis=0)
    region = np.stack([_divide_by_amplitude(each) for each in average])
    doubled = _weights(crops.shape[2])
    energy = np.stack(
        [np.bincount(r.ravel(), (a * doubled).ravel(), REGIONS) for r, a in zip(region, average, strict=True)]
    )
    histograms = [np.histogram(channel, BINS, range=_range_of(channel)) for channel in values.T]
    cumulative = np.stack([np.append(0, np.cumsum(counts)) / counts.sum() for counts, _ in histograms])
    edges = np.stack([each[[0, -1]] for _, each in histograms])
    arrays = (average, amplitude.min(axis=0), amplitude.max(axis=0), region, energy, cumulative, edges)
    return SliceStatistics(*(jnp.asarray(each, np.int32 if each is region else np.float32) for each in arrays))


def _range_of(channel: Floats) -> tuple[float, float]:
    """From the least value to the greatest, and a little more where all are the same but for rounding."""
    least, greatest = float(channel.min()), float(channel.max())
    rounding = float(np.finfo(np.float32).eps) * max(abs(least), abs(greatest), 1.0)
    return (least, greatest) if greatest - least > 4 * rounding else (least - 2 * rounding, greatest + 2 * rounding)


def _periodic_spectrum(planes: Floats) -> npt.NDArray[np.complexfloating]:
    """The spectra of pictures [..., row, col] without the step between their opposite borders, divided by the number of
    pixels: what remains when the smoothest picture that has that step is taken away."""
    rows, columns = planes.shape[-2:]
    step = np.zeros(planes.shape)
    down, across = planes[..., -1, :] - planes[..., 0, :], planes[..., -1] - planes[..., 0]
    step[..., 0, :] += down
    step[..., -1, :] -= down
    step[..., 0] += across
    step[..., -1] -= across
    curvature = 2 * np.cos(2 * np.pi * np.fft.fftfreq(rows))[:, None] + 2 * np.cos(2 * np.pi * np.fft.rfftfreq(columns))
    curvature -= 4
    curvature[0, 0] = 1
    smooth = np.fft.rfft2(step) / curvature
    smooth[..., 0, 0] = 0
    return (np.fft.rfft2(planes) - smooth) / (rows * columns)


def _divide_by_amplitude(average: Floats) -> npt.NDArray[np.int_]:
    """The region of each frequency: intervals of equal length in the logarithm of the average amplitude. The mean value
    of the slice, which would stretch them, has no part in their division."""
    logarithm = np.log(np.maximum(average, np.finfo(np.float32).tiny))
    inside = np.delete(logarithm.ravel(), 0)
    least, most = inside.min(), inside.max()
    number = np.floor((logarithm - least) / max(most - least, np.finfo(np.float32).tiny) * REGIONS)
    return np.clip(number, 0, REGIONS - 1).astype(int)


def _weights(columns: int) -> Floats:
    """How often each column of `rfft2` stands in the whole spectrum."""
    weights = np.full(columns // 2 + 1, 2.0)
    weights[0] = 1
    if columns % 2 == 0:
        weights[-1] = 1
    return weights


def coerce_amplitudes(amplitude: Array, average: Array, lowest: Array, highest: Array) -> Array:
    """Amplitudes that are out of range come nearer to the average, by half the distance each time, until they are in.

    After n times a distance is 2^-n of what it was; so the number of times is the logarithm of how many times too large
    the distance is, rounded up. As in the paper, at most 50.

    Examples:
        >>> coerce_amplitudes(*jnp.array([[9.0, 2.5], [2.0, 2.0], [1.0, 1.0], [4.0, 4.0]])).tolist()
        [3.75, 2.5]
    """
    distance = amplitude - average
    allowed = jnp.where(distance > 0, highest - average, average - lowest)
    out = jnp.abs(distance) > allowed
    times = jnp.ceil(jnp.log2(jnp.abs(distance) / jnp.maximum(allowed, jnp.finfo(amplitude.dtype).tiny)))
    nearer = average + distance * jnp.exp2(-jnp.clip(times, 1, _MOST_HALVINGS))
    return jnp.where(out, nearer, amplitude)


def equalise_regions(amplitude: Array, region: Array, energy: Array) -> Array:
    """Scale the amplitudes of each region so that they sum to the energy that the view has there.

    Args:
        amplitude: of a square slice, by `rfft2`, [row, col].
        region: [row, col].
        energy: [region].
    """
    weighted = amplitude * jnp.asarray(_weights(amplitude.shape[0]), amplitude.dtype)[None]
    sums = jnp.zeros_like(energy).at[region].add(weighted)
    return amplitude * (energy / jnp.where(sums > 0, sums, 1.0))[region]


def equalise_histogram(values: Array, cumulative: Array, edges: Array) -> Array:
    """Move values so that they are distributed as a histogram says; their order stays (section 4.2, figure 3).

    Args:
        values: of any shape; all of it is one distribution. Values that are all equal become its median.
        cumulative: share below each edge between bins, [BINS + 1].
        edges: the least and the greatest, [2].
    """
    least, most = jnp.min(values), jnp.max(values)
    place = (values.ravel() - least) * (BINS / jnp.where(most > least, most - least, 1.0))
    number = jnp.clip(place.astype(jnp.int32), 0, BINS - 1)
    counts = jnp.zeros(BINS, values.dtype).at[number].add(1.0)
    below = jnp.concatenate([jnp.zeros(1, values.dtype), jnp.cumsum(counts)]) / values.size
    moved = edges[0] + (edges[1] - edges[0]) / BINS * _interpolate(below, cumulative)
    start, end = (moved.at[number + step].get(mode="promise_in_bounds") for step in (0, 1))
    middle = edges[0] + (edges[1] - edges[0]) / BINS * _interpolate(jnp.full(1, 0.5, values.dtype), cumulative)
    return jnp.where(most > least, start + (place - number) * (end - start), middle).reshape(values.shape)


def _interpolate(at: Array, ascending: Array) -> Array:
    """Where values lie in an ascending table, as fractional numbers of its entries; between equal ones, at the last."""
    number = jnp.searchsorted(ascending, at, side="right", method="compare_all") - 1
    number = jnp.clip(number, 0, ascending.size - 2)
    span = ascending[number + 1] - ascending[number]
    return number + jnp.clip((at - ascending[number]) / jnp.where(span > 0, span, 1.0), 0.0, 1.0)


def process_slice(pixels: Array, statistics: SliceStatistics) -> Array:
    """A square slice [channel, row, col] made to look like the view: first its spectrum, then its histogram."""

    def process(channel: Array, here: SliceStatistics) -> Array:
        spectrum = jnp.fft.rfft2(channel) / channel.size
        amplitude = jnp.sqrt(jnp.square(spectrum.real) + jnp.square(spectrum.imag))
        wanted = coerce_amplitudes(amplitude, here.average, here.lowest, here.highest)
        wanted = equalise_regions(wanted, here.region, here.energy)
        changed = jnp.where(amplitude > 0, spectrum * (wanted / jnp.where(amplitude > 0, amplitude, 1.0)), wanted)
        moved = jnp.fft.irfft2(changed, channel.shape) * channel.size
        return equalise_histogram(moved, here.cumulative, here.edges)

    return jax.vmap(process)(pixels, statistics)


def measure_slice(pixels: Array, statistics: SliceStatistics) -> tuple[Array, Array]:
    """How much a slice [channel, row, col] is like the view.

    Returns:
        The share of its frequencies whose amplitudes are in the view's range, and the 1-Wasserstein distance of its
        histogram from the view's, as a share of the range of the view's values; both [channel].
    """

    def measure(channel: Array, here: SliceStatistics) -> tuple[Array, Array]:
        amplitude = jnp.abs(jnp.fft.rfft2(channel)) / channel.size
        weights = jnp.broadcast_to(jnp.asarray(_weights(channel.shape[0]), channel.dtype), amplitude.shape)
        # Rounding, of transforms there and back, must not count.
        slack = 1e-3 * here.average
        inside = (amplitude >= here.lowest - slack) & (amplitude <= here.highest + slack)
        span = here.edges[1] - here.edges[0]
        place = jnp.clip((channel.ravel() - here.edges[0]) / span * BINS, 0, BINS - 1).astype(jnp.int32)
        below = jnp.cumsum(jnp.zeros(BINS, channel.dtype).at[place].add(1.0)) / channel.size
        return jnp.sum(inside * weights) / jnp.sum(weights), jnp.mean(jnp.abs(below - here.cumulative[1:]))

    return jax.vmap(measure)(pixels, statistics)
