"""What elements of texton masks are like: how light and how large, and what holes they have.

Textures of J. Zhang et al., "Synthesis of Progressively-Variant Textures on Arbitrary Surfaces" (SIGGRAPH 2003),
section 4.3, are as good as their masks; these measures tell beforehand what will not go well.
"""

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from jaxtex.photo.pictures import check_picture, to_lab
from jaxtex.progressive.texton_masks import check_texton_mask

PINHOLE = 25
"""Pixels: holes that are hardly meant have fewer."""

_PART = 1 / 50  # of what is around it: a pinhole is less


def measure_contrast(pixels: npt.ArrayLike, mask: npt.ArrayLike) -> float:
    """How much lighter elements are than what is around them, on average.

    Args:
        pixels: linear light, [row, col] or [row, col, channel] of 1 or 3 channels.
        mask: labels [row, col].

    Returns:
        The difference of CIE Lab lightness, -100 to 100; below 0 where elements are darker. 0 where either is missing.

    Raises:
        InputError: no picture, no mask, or a mask of another size.

    Examples:
        >>> round(measure_contrast([[0.0, 1.0]], [[0, 1]]))
        100
    """
    picture = check_picture(pixels)
    elements = check_texton_mask(mask, (picture.shape[1], picture.shape[0])) > 0
    if elements.all() or not elements.any():
        return 0.0
    lightness = to_lab(picture)[..., 0]
    return float(lightness[elements].mean() - lightness[~elements].mean())


def measure_element_area(mask: npt.ArrayLike) -> float:
    """How large elements are: half of what they cover lies in elements no larger than this.

    Args:
        mask: labels [row, col].

    Returns:
        Pixels. Connected regions that reach from one side of the picture to the opposite one, as stripes and gaps, are
        left out; 0 where there are no others.

    Raises:
        InputError: no mask.

    Examples:
        >>> measure_element_area([[0, 1, 0, 1, 1, 0], [0, 0, 0, 1, 1, 0], [0, 0, 0, 0, 0, 0]])
        4.0
    """
    labels = check_texton_mask(mask)
    regions, _ = ndimage.label(labels > 0)
    whole = [slice(0, side) for side in labels.shape]
    places = ndimage.find_objects(regions)
    seen = np.array([all(found != side for found, side in zip(place, whole, strict=True)) for place in places], bool)
    areas = np.sort(np.bincount(regions.ravel(), minlength=len(places) + 1)[1:][seen])
    covered = np.cumsum(areas)
    return float(areas[np.searchsorted(covered, 0.5 * covered[-1])]) if len(areas) else 0.0


def count_holes(mask: npt.ArrayLike) -> tuple[int, int]:
    """How many holes elements go all around, and how many of these are pinholes, which are hardly meant.

    Args:
        mask: labels [row, col].

    Returns:
        All holes, and those of fewer than `PINHOLE` pixels that are less than a fiftieth of what goes around them.

    Raises:
        InputError: no mask.

    Examples:
        >>> disk = np.hypot(*(np.indices((20, 20)) - 10)) < 8
        >>> disk[10, 10] = False
        >>> count_holes(disk)
        (1, 1)
    """
    elements = check_texton_mask(mask) > 0
    filled = ndimage.binary_fill_holes(elements)
    holes, count = ndimage.label(filled & ~elements)
    around, _ = ndimage.label(filled)
    numbers = np.arange(1, count + 1)
    areas = np.bincount(holes.ravel(), minlength=count + 1)[1:]
    outer = np.bincount(around.ravel())[ndimage.maximum(around, holes, numbers).astype(int)] if count else areas
    return count, int(np.sum((areas < PINHOLE) & (areas < _PART * outer)))
