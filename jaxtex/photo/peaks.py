"""Where a peak lies between samples."""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def parabola_top(before: ArrayLike, here: ArrayLike, after: ArrayLike) -> NDArray[np.float64]:
    """Offset, within half a sample, of the top of the parabola through three neighbouring samples; 0 where it has none.

    Examples:
        >>> round(float(parabola_top(1.0, 2.0, 2.0)), 3)
        0.5
    """
    first, middle, last = (np.asarray(each, np.float64) for each in (before, here, after))
    bend = first - 2 * middle + last
    return np.where(bend < 0, np.clip(0.5 * (first - last) / np.where(bend < 0, bend, -1.0), -0.5, 0.5), 0.0)
