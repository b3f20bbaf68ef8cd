"""Cleaning a mask: eroding, dilating, opening, closing, and dropping small regions.

All act with a disk, whose radius need not be whole: a pixel belongs to the disk when its centre is no farther from the
disk's centre than the radius. What lies beyond the frame is unknown and never counts, so tiles cut by the frame neither
shrink nor grow along it. Names speak of tiles (True): eroding thins the tiles and widens the joints.

Distances to the nearest pixel of the other kind give erosion and dilation at once, at a cost that does not depend on
the radius.
"""

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from jaxtex.core.errors import InputError

Mask = npt.NDArray[np.bool_]


def check_mask(mask: npt.ArrayLike) -> Mask:
    """Give a mask as bool ``[H, W]``, or say what is wrong with it.

    Raises:
        InputError: not bool, not two-dimensional, or no pixels.

    Examples:
        >>> check_mask([[True, False]]).shape
        (1, 2)
    """
    checked = np.asarray(mask)
    if checked.dtype != np.bool_:
        raise InputError(f"mask: must be bool (True = tile), not {checked.dtype}; compare with a level first")
    if checked.ndim != 2 or checked.size == 0:
        raise InputError(f"mask: must have shape [H, W] with at least one pixel, not {list(checked.shape)}")
    return checked


def erode_mask(mask: npt.ArrayLike, radius: float) -> Mask:
    """Thin the tiles: keep those pixels whose whole disk is tile.

    Args:
        mask: bool ``[H, W]``, True = tile.
        radius: of the disk in pixels, 0 or more.

    Raises:
        InputError: no mask, or a radius below 0.

    Source: Serra, "Image Analysis and Mathematical Morphology" (1982).

    Examples:
        >>> import numpy as np
        >>> erode_mask(np.array([[True, True, True, False]]), 1).astype(int).tolist()
        [[1, 1, 0, 0]]
    """
    tiles = check_mask(mask)
    if not radius >= 0:
        raise InputError(f"radius: {radius:g} is out of range; give 0 pixels or more")
    if tiles.all():
        return tiles.copy()
    # Squared distances between pixel centres are whole numbers: the half keeps rounding away from the comparison.
    return ndimage.distance_transform_edt(tiles) ** 2 > np.floor(radius**2) + 0.5


def dilate_mask(mask: npt.ArrayLike, radius: float) -> Mask:
    """Widen the tiles: take in those pixels whose disk meets a tile. The dual of `erode_mask`.

    Args:
        mask: bool ``[H, W]``, True = tile.
        radius: of the disk in pixels, 0 or more.

    Raises:
        InputError: no mask, or a radius below 0.

    Examples:
        >>> import numpy as np
        >>> dilate_mask(np.array([[True, False, False, False]]), 1).astype(int).tolist()
        [[1, 1, 0, 0]]
    """
    return ~erode_mask(~check_mask(mask), radius)


def open_mask(mask: npt.ArrayLike, radius: float) -> Mask:
    """Erode, then dilate: specks of tile, and bridges across joints, that hold no disk become joint.

    Args:
        mask: bool ``[H, W]``, True = tile.
        radius: of the disk in pixels, 0 or more.

    Raises:
        InputError: no mask, or a radius below 0.

    Examples:
        >>> import numpy as np
        >>> open_mask(np.array([[True, False, True, True, True]]), 1).astype(int).tolist()
        [[0, 0, 1, 1, 1]]
    """
    return dilate_mask(erode_mask(mask, radius), radius)


def close_mask(mask: npt.ArrayLike, radius: float) -> Mask:
    """Dilate, then erode: pits and cracks in the tiles that hold no disk become tile. The dual of `open_mask`.

    Args:
        mask: bool ``[H, W]``, True = tile.
        radius: of the disk in pixels, 0 or more; keep it below half the joint or the joints close too.

    Raises:
        InputError: no mask, or a radius below 0.

    Examples:
        >>> import numpy as np
        >>> close_mask(np.array([[True, False, True, True, False, False, False]]), 1).astype(int).tolist()
        [[1, 1, 1, 1, 0, 0, 0]]
    """
    return erode_mask(dilate_mask(mask, radius), radius)


def remove_small_regions(mask: npt.ArrayLike, area: int) -> Mask:
    """Drop every region below an area: first the specks of joint within tiles, then the specks of tile within joints.

    Tiles hang together by the four sides of a pixel, joints also by its corners, so that a thin slanting joint is one
    region. Afterwards no region of either kind is smaller than `area`.

    Args:
        mask: bool ``[H, W]``, True = tile.
        area: in pixels; regions of at least this many stay.

    Raises:
        InputError: no mask, or an area not between 0 and the whole picture.

    Examples:
        >>> import numpy as np
        >>> remove_small_regions(np.array([[True, True, False, True, False, False, False]]), 2).astype(int).tolist()
        [[1, 1, 1, 1, 0, 0, 0]]
    """
    tiles = check_mask(mask)
    if not 0 <= area <= tiles.size:
        raise InputError(f"area: {area} is out of range; give 0 to {tiles.size} pixels, which is the whole picture")
    tiles = ~_keep_large(~tiles, area, ndimage.generate_binary_structure(2, 2))
    return _keep_large(tiles, area, ndimage.generate_binary_structure(2, 1))


def outline_mask(mask: npt.ArrayLike, width: float = 1.0) -> Mask:
    """The tiles' outline: joint pixels and tile pixels within `width` of a change of kind.

    Args:
        mask: bool ``[H, W]``, True = tile.
        width: half the breadth of the line in pixels, 1 or more for a line without gaps.

    Raises:
        InputError: no mask, or a width below 0.

    Examples:
        >>> import numpy as np
        >>> outline_mask(np.array([[True, True, True, False, False, False]])).astype(int).tolist()
        [[0, 0, 1, 1, 0, 0]]
    """
    return dilate_mask(mask, width) & ~erode_mask(mask, width)


def _keep_large(regions: Mask, area: int, neighbours: Mask) -> Mask:
    labels, _ = ndimage.label(regions, structure=neighbours)
    large = np.bincount(labels.ravel()) >= area
    large[0] = False
    return large[labels]
