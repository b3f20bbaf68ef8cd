"""Does a picture repeat without a seam? Then its tiling repeats with it, exactly."""

import numpy as np
from numpy.typing import NDArray


def find_wrap(pixels: NDArray[np.floating]) -> tuple[bool, bool]:
    """Whether a picture [H, W, C] continues from its right border to its left one, and from its bottom to its top.

    The step across the border must look like a step between neighbouring columns (rows) inside, and unlike one between
    columns (rows) far apart. A picture that is nearly the same everywhere tells nothing and counts as not wrapping.
    """
    return _wraps(np.swapaxes(pixels, 0, 1)), _wraps(pixels)


def _wraps(pixels: NDArray[np.floating]) -> bool:
    """Whether the last row continues in the first."""
    if len(pixels) < 16:
        return False
    rows = pixels.reshape(len(pixels), -1)
    step = np.abs(np.diff(rows, axis=0)).mean(1)
    seam = float(np.abs(rows[0] - rows[-1]).mean())
    half = len(rows) // 2
    apart = float(np.median(np.abs(rows[:half] - rows[half : 2 * half]).mean(1)))
    if seam < 1.35 * float(np.quantile(step, 0.75)) and seam < 0.6 * apart:
        return True
    # A joint on the border makes a rough step even where nothing was cut; then the pattern along it must go on.
    pattern = rows - rows.mean(1, keepdims=True)
    pattern = pattern / np.maximum(np.sqrt((pattern**2).mean(1, keepdims=True)), 1e-6)
    alike = np.quantile((pattern[1:] * pattern[:-1]).mean(1), [0.05, 0.5])
    strangers = float(np.quantile((pattern[:half] * pattern[half : 2 * half]).mean(1), 0.9))
    goes_on = float((pattern[0] * pattern[-1]).mean()) > min(0.5 * (alike[1] + strangers), alike[0])
    return bool(goes_on and alike[1] - strangers > 0.3 and seam <= float(np.quantile(step, 0.99)))
