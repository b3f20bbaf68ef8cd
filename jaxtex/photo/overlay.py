"""A mask shown over its photograph, so that a person can judge it at a glance."""

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.photo.morphology import check_mask, outline_mask
from jaxtex.photo.pictures import check_picture

_OUTLINE = np.array(
    [0.0, 0.9, 0.75], np.float32
)  # linear light; a cyan that brick, stone, wood and glazing seldom have
_VEIL = 0.3  # of the outline's colour over the joints: tells the two sides of the line apart
_LINE = 1 / 1200  # half the line's breadth as a fraction of the longer side, so that it shows on large photographs too


def overlay_mask(pixels: npt.ArrayLike, mask: npt.ArrayLike) -> npt.NDArray[np.float32]:
    """Draw the outline of a mask's tiles over a picture and veil its joints.

    Args:
        pixels: linear light, ``[H, W]`` or ``[H, W, C]`` with C 1 or 3.
        mask: bool ``[H, W]``, True = tile.

    Returns:
        float32 ``[H, W, 3]``, linear light.

    Raises:
        InputError: no picture, no mask, or two of different sizes.

    Examples:
        >>> import numpy as np
        >>> overlay_mask(np.full((4, 4), 0.5), np.ones((4, 4), bool))[0, 0].tolist()
        [0.5, 0.5, 0.5]
    """
    picture, tiles = check_picture(pixels), check_mask(mask)
    if picture.shape[:2] != tiles.shape:
        height, width = tiles.shape
        raise InputError(
            f"mask: is {width} x {height} pixels, but its picture {picture.shape[1]} x {picture.shape[0]};"
            " they must be of one size"
        )
    shown = np.repeat(picture, 3, axis=2) if picture.shape[2] == 1 else picture.copy()
    shown[~tiles] += _VEIL * (_OUTLINE - shown[~tiles])
    shown[outline_mask(tiles, max(1.0, _LINE * max(tiles.shape)))] = _OUTLINE
    return shown
