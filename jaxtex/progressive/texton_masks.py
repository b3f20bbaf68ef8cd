"""Texton masks: which pixels of an exemplar belong to its elements, and to which type of them.

J. Zhang et al., "Synthesis of Progressively-Variant Textures on Arbitrary Surfaces" (SIGGRAPH 2003), section 4.2 and
figure 4: colours are picked, each with a threshold, and the mask is refined by morphology; or it is painted. Masks are
uint8 [row, col], 0 where there is no element, and types of elements from 1 to 3.

Departures: colours are compared where steps look even (CIE Lab), and a pixel within reach of two types belongs to that
whose threshold it is farther below. `jaxtex.progressive.mask_proposal` makes a mask with nothing picked.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from jaxtex.core.errors import InputError
from jaxtex.io.masks import read_mask, write_mask
from jaxtex.photo.morphology import close_mask, dilate_mask, erode_mask, open_mask
from jaxtex.photo.pictures import check_picture, to_lab

Labels = npt.NDArray[np.uint8]

MOST_LABEL = 3
"""Masks have up to four values."""

Operation = Literal["open", "close", "dilate", "erode"]

_OPERATIONS = {"open": open_mask, "close": close_mask, "dilate": dilate_mask, "erode": erode_mask}
_SAME = 4 / 255  # grey levels that lossy files change one into the other
_COUNTS = 2, 3, 4


class ColourPick(NamedTuple):
    """A colour that elements have.

    Attributes:
        colour: linear light, [channel]; `photo.segment.pick_colours` takes it from a place in the picture.
        tolerance: the largest distance in CIE Lab (Delta E 1976) of what is of that colour: 2 is just visible, 10 a
            shade, 50 another colour.
        label: the type of these elements, 1 to 3.
    """

    colour: npt.ArrayLike
    tolerance: float = 12.0
    label: int = 1


def pick_texton_mask(pixels: npt.ArrayLike, picks: Sequence[ColourPick], *, smoothing: float = 1.0) -> Labels:
    """Make a mask by picked colours.

    Args:
        pixels: linear light, [row, col] or [row, col, channel] of 1 or 3 channels.
        picks: colours of elements; several may be of one type.
        smoothing: standard deviation in pixels of the Gaussian filter that takes grain away first; 0 is none.

    Returns:
        uint8 [row, col], the type of the element that each pixel belongs to, or 0.

    Raises:
        InputError: no picture, no picks, a colour of other channels, a tolerance below 0, a label that is not from 1 to
            3, or nothing that has these colours.
        ValueError: a smoothing below 0.

    Examples:
        >>> pick_texton_mask(np.array([[0.02, 0.03, 0.5, 0.9]]), [ColourPick([0.02]), ColourPick([0.9], 5, 2)],
        ...                  smoothing=0)
        array([[1, 1, 0, 2]], dtype=uint8)
    """
    picture = check_picture(pixels)
    if not (np.isfinite(smoothing) and smoothing >= 0):
        raise ValueError(f"smoothing is {smoothing}; give pixels, 0 or more")
    if not picks:
        raise InputError("picks: none given; pick a colour at least")
    lab = ndimage.gaussian_filter(to_lab(picture), (smoothing, smoothing, 0))
    best = np.full(picture.shape[:2], np.inf)
    mask = np.zeros(picture.shape[:2], np.uint8)
    for number, pick in enumerate(picks, 1):
        colour = np.asarray(pick.colour, np.float32)
        if colour.shape != picture.shape[2:]:
            raise InputError(f"pick {number}: a colour of shape {colour.shape}; give {picture.shape[2]} channels")
        if not pick.tolerance > 0:
            raise InputError(f"pick {number}: tolerance {pick.tolerance:g} is out of range; give more than 0, in Lab")
        if pick.label not in range(1, MOST_LABEL + 1):
            raise InputError(f"pick {number}: type {pick.label} is out of range; give 1 to {MOST_LABEL}")
        part = np.linalg.norm(lab - to_lab(colour[None, None]), axis=-1) / pick.tolerance
        nearer = (part <= 1) & (part < best)
        mask[nearer], best[nearer] = pick.label, part[nearer]
    if not mask.any():
        raise InputError("picks: nothing has these colours; pick others, or raise their tolerance")
    return mask


def check_texton_mask(mask: npt.ArrayLike, size: tuple[int, int] | None = None) -> Labels:
    """Give a texton mask as uint8 [row, col], or say what is wrong with it.

    Args:
        mask: labels 0 to 3, or bool, [row, col].
        size: width and height that it must have, where that matters.

    Raises:
        InputError: another shape or size, no pixels, or other values.

    Examples:
        >>> check_texton_mask([[True, False]])
        array([[1, 0]], dtype=uint8)
    """
    labels = np.asarray(mask)
    if labels.ndim != 2 or labels.size == 0:
        raise InputError(f"texton mask of shape {labels.shape}: give [row, col], not empty")
    if labels.dtype.kind not in "fiub" or not np.isin(labels, range(MOST_LABEL + 1)).all():
        raise InputError(f"texton mask: holds values beside the labels 0 to {MOST_LABEL}")
    if size is not None and labels.shape != size[::-1]:
        raise InputError(
            f"texton mask is {labels.shape[1]} x {labels.shape[0]} pixels, its picture {size[0]} x {size[1]};"
            " give them one size"
        )
    return labels.astype(np.uint8)


def refine_texton_mask(mask: npt.ArrayLike, operation: Operation, radius: float) -> Labels:
    """Refine elements by morphology. It acts on the border of elements, whatever their types, and what they gain is of
    the nearest type: borders between types stay.

    Args:
        mask: labels [row, col].
        operation: "open": elements lose specks and bridges that hold no disk; "close": they gain pits and cracks that
            hold none; "dilate": they gain a rim; "erode": they lose one.
        radius: of the disk, or breadth of the rim, in pixels, 0 or more.

    Raises:
        ValueError: another operation.
        InputError: no mask, or a radius below 0.

    Examples:
        >>> refine_texton_mask([[1, 0, 2, 2, 2]], "open", 1)
        array([[0, 0, 2, 2, 2]], dtype=uint8)
        >>> refine_texton_mask([[2, 2, 0, 2, 2, 0, 0, 0]], "close", 1)
        array([[2, 2, 2, 2, 2, 0, 0, 0]], dtype=uint8)
        >>> refine_texton_mask([[1, 0, 0, 0, 2]], "dilate", 1)
        array([[1, 1, 0, 2, 2]], dtype=uint8)
        >>> refine_texton_mask([[1, 1, 2, 2, 0]], "erode", 1)
        array([[1, 1, 2, 0, 0]], dtype=uint8)
    """
    if operation not in _OPERATIONS:
        raise ValueError(f"operation: {operation!r} is not known; give {', '.join(_OPERATIONS)}")
    labels = check_texton_mask(mask)
    return _fit_to(labels, _OPERATIONS[operation](labels > 0, radius))


def despeckle_texton_mask(mask: npt.ArrayLike, area: int) -> Labels:
    """Regions of one value, elements and holes alike, that are smaller than an area become what is nearest to them.

    Args:
        mask: labels [row, col].
        area: in pixels; regions of at least this many stay.

    Raises:
        InputError: no mask, an area below 0, or no region that stays.

    Examples:
        >>> despeckle_texton_mask([[1, 0, 1, 1, 0, 0, 2, 0]], 2)
        array([[1, 1, 1, 1, 0, 0, 0, 0]], dtype=uint8)
    """
    labels = check_texton_mask(mask)
    if area < 0:
        raise InputError(f"area: {area} is out of range; give 0 pixels or more")
    stays = np.zeros(labels.shape, bool)
    for label in np.unique(labels):
        regions, _ = ndimage.label(labels == label)
        large = np.bincount(regions.ravel()) >= area
        large[0] = False
        stays |= large[regions]
    if not stays.any():
        raise InputError(f"area: no region of the mask has {area} pixels; give fewer")
    return _spread(labels, stays)


def fill_texton_mask(mask: npt.ArrayLike) -> Labels:
    """Holes that an element goes all around become part of it.

    Examples:
        >>> fill_texton_mask([[2, 2, 2, 0], [2, 0, 2, 0], [2, 2, 2, 0]])
        array([[2, 2, 2, 0], [2, 2, 2, 0], [2, 2, 2, 0]], dtype=uint8)
    """
    labels = check_texton_mask(mask)
    return _fit_to(labels, ndimage.binary_fill_holes(labels > 0))


def invert_texton_mask(mask: npt.ArrayLike) -> Labels:
    """Elements, of whatever type, and what is none change places.

    Examples:
        >>> invert_texton_mask([[0, 1, 2]])
        array([[1, 0, 0]], dtype=uint8)
    """
    return (check_texton_mask(mask) == 0).astype(np.uint8)


def read_texton_mask(path: Path | str, size: tuple[int, int] | None = None) -> Labels:
    """Read a painted mask, or a label image, from an image file.

    Two values are black (0) and white (1), three have grey (1) between them, four two greys. Any other two to four
    values are labels from the darkest on; the numbers 0 to 3 as they stand are such values.

    Args:
        path: the file.
        size: width and height that it must have, where that matters.

    Raises:
        InputError: as `read_mask`; or it holds one value, more than four, or has another size.

    Examples:
        >>> write_texton_mask("mask.png", [[0, 1, 2]])
        >>> read_texton_mask("mask.png")
        array([[0, 1, 2]], dtype=uint8)
    """
    grey = read_mask(path)
    values = np.unique(grey.round(4))
    if len(values) == 1:
        raise InputError(f"{path}: holds one value alone and so no elements; paint these white, what is none black")
    labels = None
    for count in _COUNTS:
        spread = np.rint(grey * (count - 1))
        if np.ptp(spread) and np.abs(grey * (count - 1) - spread).max() <= _SAME * (count - 1):
            labels = spread
            break
    if labels is None and len(values) <= MOST_LABEL + 1:
        labels = np.searchsorted(values, grey.round(4))
    if labels is None:
        raise InputError(
            f"{path}: holds {len(values)} grey levels, a texton mask up to four; paint without soft edges,"
            " and save it as .png"
        )
    try:
        return check_texton_mask(labels, size)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def write_texton_mask(path: Path | str, mask: npt.ArrayLike) -> None:
    """Write a mask to an image file: black where no element is, and types from there to white.

    Types that are not in it are not kept apart: one type alone is white, whatever its number.

    Args:
        path: the file; its extension tells the format.
        mask: labels [row, col].

    Raises:
        InputError: no mask, or as `write_mask`.
    """
    labels = check_texton_mask(mask)
    write_mask(path, labels / max(1, int(labels.max())))


def _fit_to(labels: Labels, elements: npt.NDArray[np.bool_]) -> Labels:
    """Labels where elements are to be; where there were none, the nearest one's."""
    known = labels > 0
    if not known.any():
        return labels
    return np.where(elements, _spread(labels, known), 0).astype(np.uint8)


def _spread(labels: Labels, known: npt.NDArray[np.bool_]) -> Labels:
    """Labels that are known, and elsewhere the nearest of them."""
    row, column = ndimage.distance_transform_edt(~known, return_distances=False, return_indices=True)
    return labels[row, column]
