"""What every tool for photographs asks of a picture first: a checked array, its luminance, its place in CIE Lab, and
the value that parts its histogram.

Tools that compare colours or set thresholds work in CIE L*a*b* (D65), where a step of equal size is about equally
visible anywhere; linear light would give nearly all of a threshold's range to the highlights.
"""

import numpy as np
import numpy.typing as npt
from skimage.color import xyz2lab
from skimage.filters import threshold_otsu

from jaxtex.core.errors import InputError

# Linear sRGB primaries to CIE XYZ under D65 (IEC 61966-2-1).
_XYZ_FROM_RGB = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
_LUMINANCE = _XYZ_FROM_RGB[1]


def check_picture(pixels: npt.ArrayLike) -> npt.NDArray[np.float32]:
    """Give a picture as float32 ``[H, W, C]``, C being 1 or 3, or say what is wrong with it.

    Args:
        pixels: linear light, ``[H, W]``, ``[H, W, 1]`` or ``[H, W, 3]``, finite.

    Raises:
        InputError: another shape, no pixels, no numbers, or values that are not finite.

    Examples:
        >>> import numpy as np
        >>> check_picture(np.zeros((4, 6))).shape
        (4, 6, 1)
    """
    picture = np.asarray(pixels)
    if picture.dtype.kind not in "fiub":
        raise InputError(f"picture: must hold real numbers, not {picture.dtype}")
    if picture.ndim == 2:
        picture = picture[..., None]
    if picture.ndim != 3 or picture.shape[2] not in (1, 3):
        raise InputError(f"picture: must have shape [H, W], [H, W, 1] or [H, W, 3], not {list(np.shape(pixels))}")
    if picture.size == 0:
        raise InputError(f"picture: holds no pixels, its shape is {list(np.shape(pixels))}")
    picture = picture.astype(np.float32, copy=False)
    bad = ~np.isfinite(picture)
    if bad.any():
        row, column, _ = np.argwhere(bad)[0]
        raise InputError(
            f"picture: {int(bad.sum())} values are NaN or infinite, the first at row {row}, column {column};"
            " replace them before measuring"
        )
    return picture


def luminance(pixels: npt.ArrayLike) -> npt.NDArray[np.float32]:
    """Relative luminance (CIE Y) of a linear picture, ``[H, W]``; a picture of one channel is its own luminance.

    Raises:
        InputError: see `check_picture`.

    Examples:
        >>> import numpy as np
        >>> luminance(np.ones((2, 2, 3))).round(3).tolist()
        [[1.0, 1.0], [1.0, 1.0]]
    """
    picture = check_picture(pixels)
    if picture.shape[2] == 1:
        return picture[..., 0]
    return picture @ _LUMINANCE.astype(np.float32)


def to_lab(pixels: npt.ArrayLike) -> npt.NDArray[np.float32]:
    """CIE L*a*b* (D65) of a linear picture, ``[H, W, 3]``: L from 0 (black) to 100 (white), a and b 0 for greys.

    Raises:
        InputError: see `check_picture`.

    Examples:
        >>> import numpy as np
        >>> to_lab(np.full((1, 1), 0.18)).round(1).tolist()
        [[[49.5, 0.0, 0.0]]]
    """
    picture = check_picture(pixels)
    if picture.shape[2] == 1:
        lab = np.zeros((*picture.shape[:2], 3), np.float32)
        lab[..., 0] = lightness(picture)
        return lab
    return xyz2lab(picture @ _XYZ_FROM_RGB.T.astype(np.float32)).astype(np.float32)


def lightness(pixels: npt.ArrayLike) -> npt.NDArray[np.float32]:
    """CIE lightness L* of a linear picture, ``[H, W]``, from 0 (black) to 100 (white).

    Raises:
        InputError: see `check_picture`.

    Examples:
        >>> import numpy as np
        >>> lightness(np.array([[0.0, 0.18, 1.0]])).round(1).tolist()
        [[0.0, 49.5, 100.0]]
    """
    light = luminance(pixels)
    # CIE 15:2004: the cube root, continued by its tangent near black.
    cube = np.where(light > (6 / 29) ** 3, np.cbrt(light), light / (3 * (6 / 29) ** 2) + 4 / 29)
    return (116 * cube - 16).astype(np.float32)


def part_histogram(values: npt.ArrayLike) -> float:
    """The value that parts numbers into two groups, each as close together as can be (Otsu's method).

    Where nothing lies between the groups Otsu's criterion is flat there; the value given is midway between the two
    means, which meets the criterion too and does not hug one group.

    Args:
        values: numbers of any shape, not all equal.

    Source: Otsu, "A threshold selection method from gray-level histograms" (1979).

    Examples:
        >>> round(part_histogram([1.0, 1.1, 0.9, 5.0, 5.1, 4.9]), 6)
        3.0
    """
    numbers = np.asarray(values, np.float64)
    low = numbers <= threshold_otsu(numbers)
    return float(numbers[low].mean() + numbers[~low].mean()) / 2
