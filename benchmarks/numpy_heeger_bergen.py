"""Heeger and Bergen's texture synthesis in plain NumPy, in single precision, as one writes it without JAX: the
comparison of the benchmark. The same pyramid, exemplars extended by reflection, histograms matched by sorting."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]


def synthesise_numpy(
    exemplar: Array,
    shape: tuple[int, int],
    *,
    scales: int = 4,
    orientations: int = 4,
    iterations: int = 5,
    seed: int = 0,
) -> Array:
    """A texture [row, col, channel] like the exemplar [row, col, channel]."""
    mean = exemplar.mean((0, 1))
    _, axes = np.linalg.eigh(np.cov((exemplar - mean).reshape(-1, exemplar.shape[-1]).T))
    rotated = (exemplar - mean) @ axes
    reflected = np.pad(rotated, [(0, side) for side in exemplar.shape[:2]] + [(0, 0)], mode="symmetric")
    noise = np.random.default_rng(seed).standard_normal((exemplar.shape[-1], *shape), np.float32)
    there = Pyramid(reflected.shape[:2], scales, orientations)
    here = Pyramid(shape, scales, orientations)
    made = []
    for channel, image in enumerate(noise):
        pixels = np.sort(rotated[..., channel], axis=None)
        bands = there.build(reflected[..., channel].astype(np.float32))
        wanted = [np.sort(band[: -(-band.shape[0] // 2), : -(-band.shape[1] // 2)], axis=None) for band in bands]
        image = match(image, pixels)
        for _ in range(iterations):
            image = here.collapse([match(*each) for each in zip(here.build(image), wanted, strict=True)])
            image = match(image, pixels)
        made.append(image)
    return np.stack(made, axis=-1) @ axes.T.astype(np.float32) + mean


def match(values: Array, target: Array) -> Array:
    """Values with the distribution of a sorted array."""
    order = np.argsort(values, axis=None)
    ranks = np.linspace(0, len(target) - 1, len(order), dtype=np.float32)
    matched = np.empty(values.size, np.float32)
    matched[order] = target if len(target) == len(order) else np.interp(ranks, np.arange(len(target)), target)
    return matched.reshape(values.shape)


class Pyramid:
    """The steerable pyramid of pictures of one size; its sub-bands as a list, from highpass to lowpass."""

    def __init__(self, shape: tuple[int, int], scales: int, orientations: int) -> None:
        self.shapes = [shape]
        for _ in range(scales):
            self.shapes.append(tuple(-(-side // 2) for side in self.shapes[-1]))
        constant = np.sqrt(np.mean(np.cos(np.pi * np.arange(orientations) / orientations) ** (2 * orientations - 2)))
        self.turn = (-1j) ** (orientations - 1)
        radius, _ = self._polar(shape)
        self.high, self.low, self.bands = high(radius), [low(radius)], []
        for scale in range(scales):
            radius, angle = self._polar(self.shapes[scale])
            axes = np.pi * np.arange(orientations)[:, None, None] / orientations
            angular = np.cos(angle - axes) ** (orientations - 1) / (constant * np.sqrt(orientations))
            self.bands.append((high(2 ** (scale + 1) * radius) * angular).astype(np.float32))
            self.low.append(low(2 ** (scale + 1) * self._polar(self.shapes[scale + 1])[0]))

    def build(self, image: Array) -> list[Array]:
        spectrum = np.fft.rfft2(image, norm="forward")
        parts = [self._back(spectrum * self.high, 0)]
        spectrum = spectrum * self.low[0]
        for scale, filters in enumerate(self.bands):
            parts += [self._back(self.turn * spectrum * each, scale) for each in filters]
            rows, columns = self.shapes[scale + 1]
            cut = np.concatenate([spectrum[: (rows + 1) // 2], spectrum[-(rows // 2) :]])[:, : columns // 2 + 1]
            spectrum = cut * self.low[scale + 1]
        return [*parts, self._back(spectrum, len(self.bands))]

    def collapse(self, parts: list[Array]) -> Array:
        spectrum = np.fft.rfft2(parts[-1], norm="forward")
        count = len(self.bands[0])
        for scale in reversed(range(len(self.bands))):
            rows, columns = self.shapes[scale + 1]
            whole = np.zeros(self.bands[scale].shape[1:], np.complex64)
            cut = spectrum * self.low[scale + 1]
            whole[: (rows + 1) // 2, : columns // 2 + 1] = cut[: (rows + 1) // 2]
            whole[-(rows // 2) :, : columns // 2 + 1] = cut[-(rows // 2) :]
            for each, part in zip(self.bands[scale], parts[1 + scale * count :], strict=False):
                whole += self.turn.conjugate() * each * np.fft.rfft2(part, norm="forward")
            spectrum = whole
        return self._back(spectrum * self.low[0] + self.high * np.fft.rfft2(parts[0], norm="forward"), 0)

    def _back(self, spectrum: NDArray[np.complex64], scale: int) -> Array:
        return np.fft.irfft2(spectrum, self.shapes[scale], norm="forward")

    def _polar(self, cropped: tuple[int, int]) -> tuple[Array, Array]:
        y = np.fft.fftfreq(cropped[0], 0.5 * self.shapes[0][0] / cropped[0])[:, None]
        x = np.fft.rfftfreq(cropped[1], 0.5 * self.shapes[0][1] / cropped[1])[None, :]
        return np.maximum(np.hypot(x, y), 1e-9), np.arctan2(y, x)


def high(radius: Array) -> Array:
    return np.cos(0.5 * np.pi * np.clip(np.log2(radius), -1, 0)).astype(np.float32)


def low(radius: Array) -> Array:
    return np.sin(-0.5 * np.pi * np.clip(np.log2(radius), -1, 0)).astype(np.float32)
