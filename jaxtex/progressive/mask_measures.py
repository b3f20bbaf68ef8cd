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
_ENOUGH = 1 / 4  # of what is of a type lies in whole elements, if these tell how large all are


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


def measure_element_area(mask: npt.ArrayLike, kind: int = 1) -> float:
    """How large elements of a type are: half of what they cover lies in elements no larger than this.

    Args:
        mask: labels [row, col].
        kind: the type, a label.

    Returns:
        Pixels. Elements are connected regions of the type; what the picture cuts is left out. 0 where those that are
        whole are less than a quarter of all that is of the type, as with stripes and gaps, which have no area.

    Raises:
        InputError: no mask.

    Examples:
        >>> measure_element_area(np.pad([[1, 0, 1, 1], [0, 0, 1, 1]], 1))
        4.0
    """
    regions, count = ndimage.label(check_texton_mask(mask) == kind)
    area = np.bincount(regions.ravel(), minlength=count + 1)
    whole = np.ones(count + 1, bool)
    whole[[0, *regions[0], *regions[-1], *regions[:, 0], *regions[:, -1]]] = False
    areas = np.sort(area[whole])
    covered = np.cumsum(areas)
    if not len(areas) or covered[-1] < _ENOUGH * area[1:].sum():
        return 0.0
    return float(areas[np.searchsorted(covered, 0.5 * covered[-1])])


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


def count_small_regions(mask: npt.ArrayLike, area: int) -> int:
    """How many regions of one value, elements and holes alike, have fewer pixels: those that despeckling drops.

    Args:
        mask: labels [row, col].
        area: in pixels.

    Raises:
        InputError: no mask.

    Examples:
        >>> count_small_regions([[1, 0, 1, 1, 0, 0, 2, 0]], 2)
        4
    """
    labels = check_texton_mask(mask)
    regions = [np.bincount(ndimage.label(labels == each)[0].ravel())[1:] for each in np.unique(labels)]
    return int(np.sum(np.concatenate(regions) < area))


def count_vanished(before: npt.ArrayLike, after: npt.ArrayLike) -> tuple[int, int]:
    """How many elements of a mask are gone where it was shrunk, and how many it had.

    Args:
        before, after: labels [row, col], of one size; elements are connected regions of any type but 0.

    Raises:
        InputError: no masks, or of two sizes.

    Examples:
        >>> count_vanished([[1, 0, 1, 1, 1]], [[0, 0, 0, 1, 0]])
        (1, 2)
    """
    whole = check_texton_mask(before)
    left = check_texton_mask(after, (whole.shape[1], whole.shape[0])) > 0
    elements, count = ndimage.label(whole > 0)
    return count - len(np.unique(elements[left & (elements > 0)])), count
