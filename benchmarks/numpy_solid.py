"""One iteration of Dischler, Ghazanfarpour and Freydier's relaxation in NumPy, all slices of an axis at once."""

import numpy as np
from scipy import fft

from jaxtex.synthesis.slices import BINS, REGIONS, SliceStatistics


def process_axis(voxels: np.ndarray, statistics: SliceStatistics, axis: int) -> np.ndarray:
    """All slices across one axis of voxels [channel, z, y, x]; as `jaxtex.synthesis.solid_relaxation.process_axis`."""
    slices = np.moveaxis(voxels, axis + 1, 1)
    made = [_process(each, statistics, channel) for channel, each in enumerate(slices)]
    return np.ascontiguousarray(np.moveaxis(np.stack(made), 1, axis + 1))


def _process(slices: np.ndarray, statistics: SliceStatistics, channel: int) -> np.ndarray:
    average, lowest, highest, region, energy, cumulative, edges = (
        np.asarray(getattr(statistics, name)[channel])
        for name in ("average", "lowest", "highest", "region", "energy", "cumulative", "edges")
    )
    side = slices.shape[-1]
    spectrum = fft.rfft2(slices, workers=2) / side**2
    amplitude = np.abs(spectrum)
    distance = amplitude - average
    allowed = np.where(distance > 0, highest - average, average - lowest)
    out = np.abs(distance) > allowed
    times = np.ceil(np.log2(np.abs(distance[out]) / np.maximum(allowed[out], np.finfo(np.float32).tiny)))
    wanted = amplitude.copy()
    wanted[out] = (np.broadcast_to(average, wanted.shape)[out]) + distance[out] * np.exp2(-np.clip(times, 1, 50))
    weights = np.full(side // 2 + 1, 2.0)
    weights[0] = 1
    if side % 2 == 0:
        weights[-1] = 1
    for number in range(len(slices)):
        sums = np.bincount(region.ravel(), (wanted[number] * weights).ravel(), REGIONS)
        wanted[number] *= (energy / np.where(sums > 0, sums, 1))[region]
    phase = np.divide(spectrum, amplitude, out=np.ones_like(spectrum), where=amplitude > 0)
    moved = fft.irfft2((phase * wanted).astype(np.complex64), (side, side), workers=2) * side**2
    return np.stack([_equalise(each, cumulative, edges) for each in moved])


def _equalise(values: np.ndarray, cumulative: np.ndarray, edges: np.ndarray) -> np.ndarray:
    counts, borders = np.histogram(values, BINS)
    below = np.append(0, np.cumsum(counts)) / values.size
    moved = np.interp(below, cumulative, np.linspace(edges[0], edges[1], BINS + 1))
    return np.interp(values, borders, moved).astype(np.float32)
