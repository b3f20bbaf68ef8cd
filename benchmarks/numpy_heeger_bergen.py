"""Heeger and Bergen's texture synthesis in plain NumPy, in single precision, as one writes it without JAX: the
comparison of the benchmark. The same pyramid, exemplars extended by reflection, colours matched along four sets of
axes; histograms matched by sorting."""

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
    rotated = np.moveaxis((exemplar - mean) @ axes, -1, 0).astype(np.float32)
    reflected = np.pad(rotated, [(0, 0)] + [(0, side) for side in exemplar.shape[:2]], mode="symmetric")
    there, here = (Pyramid(size, scales, orientations) for size in (reflected.shape[1:], shape))
    wanted = [
        [np.sort(band[: -(-band.shape[0] // 2), : -(-band.shape[1] // 2)], axis=None) for band in there.build(channel)]
        for channel in reflected
    ]
    random = np.random.default_rng(seed)
    count = len(rotated)
    views = [np.linalg.qr(random.standard_normal((count, count)))[0].astype(np.float32) for _ in range(3)]
    views.append(np.eye(count, dtype=np.float32))
    colours = [np.sort(np.tensordot(view, rotated, axes=1).reshape(count, -1), axis=1) for view in views]

    def match_colours(channels: Array) -> Array:
        for view, tables in zip(views, colours, strict=True):
            seen = np.tensordot(view, channels, axes=1)
            channels = np.tensordot(view.T, np.stack([match(*each) for each in zip(seen, tables, strict=True)]), axes=1)
        return channels

    made = match_colours(random.standard_normal((count, *shape), np.float32))
    for _ in range(iterations):
        for channel, tables in enumerate(wanted):
            bands = here.build(made[channel])
            made[channel] = here.collapse([match(*each) for each in zip(bands, tables, strict=True)])
        made = match_colours(made)
    return np.moveaxis(made, 0, -1) @ axes.T.astype(np.float32) + mean


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
