"""Picture of wood -> where rings are, and which way and how densely they run, piece by piece.

In each piece of the picture the rings are nearly straight and evenly spaced: its spectrum has one peak (Lefebvre &
Poulin 2000, section 3.2, use the one of the whole picture). That its sense is unknown, rings running out or in, does no
harm to those who use its square, the outer product of the wave vector with itself.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import fft, ndimage
from skimage import transform
from skimage.filters import threshold_otsu

from jaxtex.photo.evidence import shrink
from jaxtex.photo.peaks import parabola_top
from jaxtex.photo.pictures import lightness

Map = NDArray[np.float32]
Array = NDArray[np.float64]

_TWO_TONES = 0.97  # of the variance, that two tones explain of a drawing: no shadow parts a photograph so clearly
_SLOW = 512  # pixels along the longer side: pictures no larger are evened out as they are
_SMALLEST, _LARGEST = 24, 128  # side of a piece, pixels
FINEST = 5.0  # pixels from ring to ring: finer ones cannot be told from grain and noise
_RINGS = 2.6  # at least, in a piece
_FEWEST = 2.5  # periods along the shorter side, for the picture as a whole


class LocalWaves(NamedTuple):
    """The strongest wave of each of N pieces: ``place`` (N, 2), its middle (u, v) from the picture's middle; ``wave``
    (N, 2), cycles per pixel along u and v; ``weight`` (N,), up to 1, how much of the piece it explains."""

    place: Array
    wave: Array
    weight: Array


def flatten_light(pixels: NDArray[np.floating]) -> Array:
    """Lightness (H, W), 0 to 100, of a linear picture (H, W, 1 or 3), less the slow illumination."""
    light = lightness(pixels).astype(float)
    # What is as slow as that is seen as well from afar, in a hundredth of the time.
    small = shrink(light, _SLOW)
    slow = ndimage.gaussian_filter(small, max(small.shape) / 8, mode="nearest")
    return light - (slow if small.shape == light.shape else transform.resize(slow, light.shape, order=1))


def find_early_wood(pixels: NDArray[np.floating]) -> NDArray[np.bool_]:
    """Mask (H, W) of early wood, the lighter, in a linear picture (H, W, 1 or 3).

    Its light is evened out, unless the picture is all of two tones as it is: it has been drawn.
    """
    mask, explained = _part_in_two(lightness(pixels).astype(float))
    return mask if explained > _TWO_TONES else _part_in_two(flatten_light(pixels))[0]


def _part_in_two(light: Array) -> tuple[NDArray[np.bool_], float]:
    """Which pixels (H, W) are of the lighter kind, and how much of the variance it explains that there are two."""
    lighter = light > threshold_otsu(light)
    share = float(lighter.mean())
    if share in (0.0, 1.0):
        return lighter, 0.0
    between = share * (1 - share) * (light[lighter].mean() - light[~lighter].mean()) ** 2
    return lighter, float(between / light.var())


def find_period(rings: Array) -> float:
    """Pixels from ring to ring where they are most regular, in a map (H, W) of zero mean."""
    height, width = rings.shape
    taper = np.outer(np.hanning(height), np.hanning(width))
    power = np.abs(fft.rfft2(rings * taper)) ** 2
    radius = np.hypot(fft.fftfreq(height)[:, None], fft.rfftfreq(width)[None])
    power[(radius < _FEWEST / min(height, width)) | (radius > 1 / FINEST)] = 0.0
    bins = max(height, width)
    profile = np.bincount((radius * bins).astype(int).ravel(), weights=power.ravel())
    return bins / (float(np.argmax(ndimage.gaussian_filter1d(profile, 1.0))) + 0.5)


def measure_waves(rings: Array, period: float, *, finer: int = 1) -> LocalWaves:
    """The waves of a map (H, W) of zero mean, in pieces that hold a few periods, or ``finer`` times smaller ones."""
    side = 2 ** int(np.ceil(np.log2(_RINGS * period)))
    side = max(int(np.clip(side, _SMALLEST, _LARGEST)) // finer, _SMALLEST)
    side = min(side, *rings.shape)
    taper = np.outer(np.hanning(side + 2)[1:-1], np.hanning(side + 2)[1:-1])
    step = max(side // 4, 1)
    pieces = np.lib.stride_tricks.sliding_window_view(rings, (side, side))[::step, ::step]
    rows, columns = (
        step * np.arange(n) + (side - whole) / 2 for n, whole in zip(pieces.shape, rings.shape, strict=False)
    )
    place = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    pieces = pieces.reshape(-1, side, side)
    pieces = (pieces - (pieces * taper).sum((1, 2), keepdims=True) / taper.sum()) * taper
    size = 2 * side
    power = np.abs(fft.rfft2(pieces, s=(size, size))) ** 2
    wave, weight = _find_peaks(power, size)
    told = np.isfinite(wave).all(1) & (np.hypot(*wave.T) > 0) & (weight > 0)
    weight = weight[told] / max(float(weight.max(initial=0.0)), 1e-12)
    return LocalWaves(place[told], wave[told], weight)


def _find_peaks(power: Array, size: int) -> tuple[Array, Array]:
    """Peak of each spectrum (N, size, size // 2 + 1) in cycles per pixel (N, 2), and its share of the energy (N,)."""
    whole = power.sum((1, 2))
    fy = fft.fftfreq(size) * size
    radius = np.hypot(fy[:, None], np.arange(size // 2 + 1)[None])
    inner = np.where((radius >= 3) & (radius <= 0.45 * size), power, 0.0)
    number = np.arange(len(power))
    row, column = np.unravel_index(inner.reshape(len(power), -1).argmax(1), power.shape[1:])

    def at(down: int, right: int) -> Array:
        # Left of the first column a real map's spectrum goes on mirrored through the origin.
        y, x = row + down, column + right
        y = np.where(x < 0, -y, y)
        return inner[number, y % size, np.minimum(np.abs(x), size // 2)]

    floor = 1e-12 * max(float(inner.max(initial=0.0)), 1e-30)
    logs = {(dy, dx): np.log(at(dy, dx) + floor) for dy, dx in ((0, 0), (-1, 0), (1, 0), (0, -1), (0, 1))}
    down = parabola_top(logs[-1, 0], logs[0, 0], logs[1, 0])
    right = parabola_top(logs[0, -1], logs[0, 0], logs[0, 1])
    near = sum((at(dy, dx) for dy in range(-2, 3) for dx in range(-2, 3)), np.zeros(len(power)))
    wave = np.stack([column + right, fy[row] + down], axis=1) / size
    return wave, np.where(whole > 1e-6 * whole.max(initial=0.0), near / np.maximum(whole, 1e-30), 0.0)
