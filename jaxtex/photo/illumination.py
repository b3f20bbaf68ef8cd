"""Evening out: slow illumination is divided out of a photograph.

A photograph is what the material reflects times the light that falls on it, so their logarithms add. What varies slowly
in the logarithm (a window to one side, the falling off of a flash, vignetting) is taken for light; what varies faster,
and everything that stands out from its surroundings (joints, stains, odd tiles), is the material's and does not count.
"""

import math

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from jaxtex.core.errors import InputError
from jaxtex.photo.pictures import check_picture, luminance

_GRID = 96  # cells along the longer side on which light is estimated: it is slow, more would be waste
_ROUNDS = 6  # of each kind of weight
_OUTLIER = 4.685  # Tukey's constant: 95 % efficient where the material's variation is Gaussian
_FINEST = 0.02  # in log luminance; what stands out by less than a few of these is never an outlier
_BLACKEST = 1e-3  # of the median luminance; below it a pixel says nothing about light


def even_out(pixels: npt.ArrayLike, *, scale: float = 0.25) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """Divide slow illumination out of a photograph; its mean luminance and all hues stay.

    A robust cubic in log luminance takes the general slope, a robust Gaussian mean of what is left takes the rest.
    Both settle on what most of the surface is, so that joints, dark or pale, do not bias the light.

    Args:
        pixels: linear light, ``[H, W]`` or ``[H, W, C]`` with C 1 or 3.
        scale: standard deviation of the Gaussian as a fraction of the picture's longer side. Variation well below it is
            kept as the material's own: let it span several tiles.

    Returns:
        The evened picture, shaped like `pixels`, and the illumination, ``[H, W]``, positive; their product is the
        photograph.

    Raises:
        InputError: no picture (see `check_picture`), scale not in 0.02 to 10, or a picture black nearly everywhere.

    Examples:
        >>> import numpy as np
        >>> slope = np.linspace(1, 3, 60) * np.ones((40, 1))
        >>> evened, light = even_out(0.2 * slope)
        >>> bool(np.ptp(evened) < 0.01), bool(np.allclose(evened * light, 0.2 * slope, rtol=1e-4))
        (True, True)
    """
    picture = check_picture(pixels)
    if not 0.02 <= scale <= 10:
        raise InputError(f"scale: {scale:g} is out of range; give 0.02 to 10 of the picture's longer side")
    light = luminance(picture)
    positive = light > _BLACKEST * np.median(light)
    if positive.mean() < 0.5:
        raise InputError(
            "picture: more than half of it is black, so it says nothing about the light; check the exposure"
        )
    step = math.ceil(max(light.shape) / _GRID)
    cells = _block_medians(np.where(positive, light, np.nan), step)
    slow = _slow_part(cells, sigma=scale * max(light.shape) / step)
    field = np.exp(_enlarge(slow, step, light.shape)).astype(np.float32)
    field *= np.mean(light / field) / np.mean(light)
    evened = picture / field[..., None]
    return evened.reshape(np.shape(pixels)), field


def _block_medians(light: npt.NDArray[np.float32], step: int) -> npt.NDArray[np.float64]:
    """Log of the median of each step x step block, NaN where the block is black; the last ones may be smaller."""
    height, width = light.shape
    padded = np.pad(light, ((0, -height % step), (0, -width % step)), constant_values=np.nan)
    rows, columns = padded.shape[0] // step, padded.shape[1] // step
    blocks = padded.reshape(rows, step, columns, step).swapaxes(1, 2).reshape(rows, columns, step * step)
    known = np.isfinite(blocks).sum(axis=2, keepdims=True) > 0
    medians = np.nanmedian(np.where(known, blocks, 1.0), axis=2)
    return np.where(known[..., 0], np.log(medians), np.nan)


def _slow_part(cells: npt.NDArray[np.float64], sigma: float) -> npt.NDArray[np.float64]:
    """Cubic trend plus large Gaussian mean of log luminance, both blind to outliers: first by L1, then by Tukey."""
    known = ~np.isnan(cells)
    filled = np.where(known, cells, 0.0)
    y, x = np.indices(cells.shape)
    x, y = (2 * axis / max(axis.max(), 1) - 1 for axis in (x, y))
    terms = np.stack([x**i * y**j for i in range(4) for j in range(4 - i)], axis=-1)
    slow = np.zeros(cells.shape)
    weight = known.astype(np.float64)
    for done in range(2 * _ROUNDS):
        weighted = terms * np.sqrt(weight)[..., None]
        target = filled * np.sqrt(weight)
        trend = terms @ np.linalg.lstsq(weighted.reshape(-1, terms.shape[-1]), target.ravel(), rcond=None)[0]
        rest = _gaussian_mean(filled - trend, weight, sigma)
        slow = trend + rest
        residual = np.where(known, filled - slow, np.inf)
        weight = _l1_weight(residual) if done < _ROUNDS else _biweight(residual)
    return slow


def _l1_weight(residual: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Weights under which a mean tends to the median, which up to half of all cells cannot carry away."""
    return _FINEST / np.maximum(np.abs(residual), _FINEST)


def _biweight(residual: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Tukey's weights, 0 for what stands out too far: they finish what the median has begun."""
    deviation = max(float(np.median(np.abs(residual[np.isfinite(residual)]))) / 0.6745, _FINEST)
    return np.clip(1 - (residual / (_OUTLIER * deviation)) ** 2, 0, None) ** 2


def _gaussian_mean(
    values: npt.NDArray[np.float64], weight: npt.NDArray[np.float64], sigma: float
) -> npt.NDArray[np.float64]:
    """Weighted Gaussian mean that knows nothing beyond the frame (normalised convolution, Knutsson & Westin 1993)."""
    above = ndimage.gaussian_filter(values * weight, sigma, mode="constant", truncate=3.0)
    below = ndimage.gaussian_filter(weight, sigma, mode="constant", truncate=3.0)
    return above / np.maximum(below, 1e-9)


def _enlarge(cells: npt.NDArray[np.float64], step: int, shape: tuple[int, ...]) -> npt.NDArray[np.float64]:
    """Values at cell centres, interpolated (and at the frame extrapolated by the nearest) to every pixel."""
    rows = (np.arange(shape[0]) + 0.5) / step - 0.5
    columns = (np.arange(shape[1]) + 0.5) / step - 0.5
    return ndimage.map_coordinates(cells, np.meshgrid(rows, columns, indexing="ij"), order=3, mode="nearest")
