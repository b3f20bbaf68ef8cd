"""Elements of a mask made no more ragged than they may be: parted where they are narrow, and smoothed.

What blending of masks needs (J. Zhang et al., "Synthesis of Progressively-Variant Textures on Arbitrary Surfaces",
SIGGRAPH 2003, section 4.3): between two masks elements of one run together with those of the other, and their borders
follow both, so they are more ragged in the middle than on either side. The paper leaves their cleaning to a person, by
the tools of section 4.2.
"""

import numpy as np
import numpy.typing as npt
from scipy import ndimage
from skimage.morphology import h_maxima
from skimage.segmentation import watershed

SPECK = 6  # pixels: the shape of what is smaller is not told

_NECKS = 8.0, 4.0, 2.0, 1.0, 0.5  # pixels by which elements are narrower, on either side, where they are parted
_BLURS = 1.0, 2.0, 3.0  # pixels, by which they are smoothed until they are compact
_REACH = 2.0  # times the blur: how far from an element it is smoothed
_DIRECTIONS = (0, 1, 1.0), (1, 0, 1.0), (1, 1, 0.5**0.5), (1, -1, 0.5**0.5)  # steps, and how far lines lie apart

Mask = npt.NDArray[np.bool_]
Numbers = npt.NDArray[np.integer]
Floats = npt.NDArray[np.floating]


def measure_raggedness(elements: Numbers) -> Floats:
    """Perimeter² over 4 pi times the area, of each element: 1 of a disk.

    Args:
        elements: numbered from 1, [row, col]; 0 is none.

    Returns:
        [1 + element], 0 of none and of specks. Perimeters are by the Cauchy-Crofton formula in four directions.

    Examples:
        >>> disk = np.hypot(*(np.indices((64, 64)) - 31.5)) < 25
        >>> round(float(measure_raggedness(disk.astype(int))[1]), 1)
        1.0
    """
    padded = np.pad(elements, 1)
    count = int(elements.max()) + 1
    perimeters = np.zeros(count)
    for down, right, apart in _DIRECTIONS:
        beside = np.roll(padded, (down, right), (0, 1))
        crossed = padded != beside
        ends = np.bincount(padded[crossed], minlength=count) + np.bincount(beside[crossed], minlength=count)
        perimeters += np.pi / 8 * apart * ends
    areas = np.bincount(elements.ravel(), minlength=count)
    told = areas >= SPECK
    told[0] = False
    return np.where(told, np.square(perimeters) / (4 * np.pi * np.maximum(areas, 1)), 0)


def keep_compact(mask: npt.ArrayLike, most: npt.ArrayLike) -> Mask:
    """Part elements that are too ragged where they are narrow, and smooth those that still are.

    Args:
        mask: bool [row, col].
        most: how ragged elements may be by `measure_raggedness`, the mean over each, [row, col].

    Returns:
        bool [row, col]. Some may still be too ragged: rings, and what is as wide all along.

    Raises:
        ValueError: arrays of several shapes.

    Examples:
        >>> row, column = np.indices((40, 80))
        >>> two = np.hypot(row - 20, np.abs(column - 40) - 20) < 12
        >>> bridged = two | ((np.abs(row - 20) < 2) & (np.abs(column - 40) < 20))
        >>> parted = keep_compact(bridged, np.full(bridged.shape, 1.3))
        >>> ndimage.label(bridged)[1], ndimage.label(parted)[1]
        (1, 2)
    """
    there, limit = np.asarray(mask, bool), np.asarray(most, float)
    if there.ndim != 2 or limit.shape != there.shape:
        raise ValueError(f"mask of shape {there.shape}, most {limit.shape}: give both as [row, col]")
    there = _part(there, limit)
    for blur in _BLURS:
        elements, ragged = _find_ragged(there, limit)
        if not ragged.any():
            break
        away, nearest = ndimage.distance_transform_edt(elements == 0, return_indices=True)
        smoothed = ndimage.gaussian_filter(there.astype(np.float32), blur) > 0.5
        near = ragged[elements[tuple(nearest)]] & (away <= _REACH * blur)
        there = _part(np.where(near, smoothed, there), limit)
    return there


def _find_ragged(mask: Mask, limit: Floats) -> tuple[Numbers, Mask]:
    """Elements, numbered from 1, and which of them are too ragged, [1 + element]."""
    elements, count = ndimage.label(mask)
    limits = ndimage.mean(limit, elements, np.arange(1, count + 1))
    return elements, measure_raggedness(elements) > np.append(np.inf, limits)


def _part(mask: Mask, limit: Floats) -> Mask:
    """Elements that are too ragged, cut across: first where necks are the narrowest beside what they join."""
    for neck in _NECKS:
        elements, ragged = _find_ragged(mask, limit)
        if not ragged.any():
            break
        depth = ndimage.gaussian_filter(ndimage.distance_transform_edt(mask), 1.0)
        parts = watershed(-depth, ndimage.label(h_maxima(depth, neck))[0], mask=mask)
        beside = np.where(parts > 0, parts, parts.max() + 1)
        cut = ndimage.minimum_filter(beside, footprint=ndimage.generate_binary_structure(2, 1)) < parts
        mask = mask & ~(ragged[elements] & cut)
    return mask
