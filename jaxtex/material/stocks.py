"""Stocks of grain, made at the resolution of the maps, from which every tile takes a piece of its own."""

import math
from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array
from scipy.ndimage import gaussian_filter

from jaxtex.core.pyramids import most_scales
from jaxtex.synthesis.heeger_bergen import analyse_texture, synthesise_texture

SIDES_OF_STOCKS = (256, 512, 1024, 2048)
"""Few sizes, so that what is compiled once serves many maps."""

_SCALES = 5
_EXTENDED = 192  # pixels
_ORIENTATIONS = 4
_SMALLEST = 8  # pixels to a side: smaller examples show no grain at the maps' resolution
_SAME = 0.03  # a change of scale that nobody sees
_FULL = 8  # times a tile's area that its stock has, where memory allows
_STEEPNESS, _STEEPEST = 3.0, 0.25  # slope for a contrast of 1, and at most
_SOFT = 0.7  # pixels: grain is smoothed by so much before it is taken for relief


def choose_side(height: float, width: float) -> int:
    """The side of a square stock for tiles of a size in pixels."""
    wanted = max(math.sqrt(_FULL * height * width), 1.25 * max(height, width))
    return next((side for side in SIDES_OF_STOCKS if side >= wanted), SIDES_OF_STOCKS[-1])


def make_grain(
    examples: npt.NDArray[np.float32], pixel: tuple[float, float], side: int, *, key: Array
) -> npt.NDArray[np.float32]:
    """Make a stock of grain by Heeger and Bergen's algorithm.

    Args:
        examples: [region, row, col, 3], one pixel to a plane pixel.
        pixel: breadth and height of the maps' pixels in plane pixels. Where they are smaller than the examples', the
            octaves that no example shows are extrapolated.
        side: of the stock.
        key: random key.

    Returns:
        [side, side, 3]; it repeats seamlessly. All zeros where there is no example large enough to show anything.
    """
    octaves = round(math.log2(1.0 / math.sqrt(pixel[0] * pixel[1])))
    finer = min(max(0, octaves), most_scales((side, side)))
    seen = _resample(examples, (1.0 / (pixel[1] * 2**finer), 1.0 / (pixel[0] * 2**finer)))
    if not len(seen) or seen.shape[1] * seen.shape[2] < _SMALLEST**2 or min(seen.shape[1:3]) < 2:
        return np.zeros((side, side, 3), np.float32)
    seen = _extend(seen)
    scales = min(_SCALES, most_scales(seen.shape[1:3]), most_scales((side, side)) - finer)
    statistics = analyse_texture(seen, scales=scales, orientations=_ORIENTATIONS)
    return np.asarray(synthesise_texture(statistics, (side, side), key=key, finer=finer))


def _extend(examples: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Examples made larger by reflection: change over the whole of a tile is grain, too."""
    height, width = examples.shape[1:3]
    wanted = min(2 * max(height, width), _EXTENDED)
    return np.pad(
        examples, [(0, 0), (0, max(wanted - height, 0)), (0, max(wanted - width, 0)), (0, 0)], mode="symmetric"
    )


def make_wobble(deviation: float, length: float, pixel: tuple[float, float], side: int, *, key: Array) -> npt.NDArray:
    """A field by which outlines stray, [side, side], in plane pixels: Gaussian, with Matérn's covariance of order 3/2,
    so that outlines are rough and yet lines.

    Args:
        deviation, length: its standard deviation and correlation length, in plane pixels.
        pixel, side, key: as `make_grain` takes them.
    """
    noise = np.asarray(jax.random.normal(key, (side, side)))
    frequency = np.hypot(np.fft.fftfreq(side)[:, None] / pixel[1], np.fft.rfftfreq(side)[None, :] / pixel[0])
    # The covariance's spectrum in the plane; it falls to 1/e at 1.24 of its scale.
    amplitude = (1.0 + (2.0 * np.pi * length / 1.24 * frequency) ** 2 / 3.0) ** -1.25
    amplitude[0, 0] = 0.0
    field = np.fft.irfft2(np.fft.rfft2(noise) * amplitude, s=noise.shape)
    return np.clip(deviation * field / max(float(field.std()), 1e-12), -2.5 * deviation, 2.5 * deviation)


def relief_of(grain: npt.NDArray[np.float32], examples: Sequence[npt.NDArray[np.float32]], slope: float) -> npt.NDArray:
    """Heights [row, col] in plane pixels that go with grain: what is darker lies deeper.

    Args:
        grain: the stock, [row, col, 3].
        examples: of all kinds together, whose slopes, as the photograph shows them, are made to be `slope` in the root
            mean square: a kind of less contrast is the smoother. At a finer resolution finer slopes join them.
        slope: 0 for none.
    """
    seen = [each for each in examples if each.any()]
    if not seen or not slope > 0:
        return np.zeros(grain.shape[:2], np.float32)
    light = [gaussian_filter(each.mean(axis=3), (0, _SOFT, _SOFT), mode="nearest") for each in seen]
    changes = [sum(np.mean(np.square(np.diff(each, axis=axis))) for axis in (1, 2)) for each in light]
    steepness = math.sqrt(float(np.mean(changes)))
    return slope / max(steepness, 1e-6) * gaussian_filter(grain.mean(axis=2), _SOFT, mode="wrap")


def choose_slope(examples: Sequence[npt.NDArray[np.float32]]) -> float:
    """How uneven a surface is taken to be, as the root mean square of its slopes, by the contrast of its grain."""
    contrasts = [float(np.std(each)) for each in examples if each.size]
    return round(min(_STEEPEST, _STEEPNESS * math.sqrt(np.mean(np.square(contrasts)))), 3) if contrasts else 0.0


def _resample(examples: npt.NDArray[np.float32], scale: tuple[float, float]) -> npt.NDArray[np.float32]:
    if not len(examples) or max(abs(math.log(each)) for each in scale) < _SAME:
        return examples
    regions, height, width, channels = examples.shape
    shape = (regions, max(1, round(height * scale[0])), max(1, round(width * scale[1])), channels)
    return np.asarray(jax.image.resize(jnp.asarray(examples), shape, method="lanczos3"))
