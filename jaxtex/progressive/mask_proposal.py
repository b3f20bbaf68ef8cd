"""A texton mask with nothing picked: the colours whose regions make the best elements.

A departure from J. Zhang et al., "Synthesis of Progressively-Variant Textures on Arbitrary Surfaces" (SIGGRAPH 2003),
section 4.2, where a person picks colours. Pixels are parted into two to four classes of smoothed colours, and each
class, and all but each, is tried: elements are compact, many, of another colour than the rest, end where
colours change, and cover from 10 to 70 % of the picture. Of things that lie close, with no ground between them (leaves,
pebbles), what is marked may be the gaps: the parts are the same, and change places by `invert_texton_mask`.
"""

import itertools

import numpy as np
import numpy.typing as npt
from scipy import ndimage
from scipy.cluster.vq import kmeans2
from skimage.measure import regionprops

from jaxtex.core.errors import InputError
from jaxtex.photo.evidence import shrink
from jaxtex.photo.morphology import open_mask, outline_mask, remove_small_regions
from jaxtex.photo.pictures import check_picture, to_lab

Mask = npt.NDArray[np.bool_]
Map = npt.NDArray[np.floating]

_GLANCE = 256  # pixels along the longer side at which colours are chosen
_SMOOTHING = 1.0, 2.0, 3.0  # pixels there
_CLASSES = 2, 3, 4
_SLOW = 1 / 6  # of the longer side: standard deviation of what is taken for light
_LEAST_AREA = 6.0  # pixels, times the square of the smoothing: less is a speck
_LEAST, _MOST = 0.1, 0.7  # of the picture: what elements cover
_ENOUGH = 8  # elements: fewer speak the less for a mask
_LEAST_SOLID = 0.4  # of its convex hull: what fills no more is no element
_PLAIN = 1.0  # steps of CIE Lab: a picture that varies by no more is of one colour


def propose_texton_mask(pixels: npt.ArrayLike) -> npt.NDArray[np.uint8]:
    """Find the elements of a texture with nothing said about them.

    Args:
        pixels: linear light, [row, col] or [row, col, channel] of 1 or 3 channels.

    Returns:
        uint8 [row, col], 1 in elements and 0 elsewhere.

    Raises:
        InputError: no picture, one that is too small or of one colour, or in which nothing stands out.

    Examples:
        >>> row, column = np.indices((96, 96)) % 24 - 12
        >>> spots = np.hypot(row, column) < 7
        >>> bool((propose_texton_mask(np.where(spots, 0.1, 0.6)) == spots).mean() > 0.95)
        True
    """
    picture = check_picture(pixels)
    if min(picture.shape[:2]) < 16:
        raise InputError(f"picture of {picture.shape[1]} x {picture.shape[0]} pixels: is too small; give at least 16")
    lab = to_lab(picture)
    small = shrink(lab, _GLANCE)
    if np.ptp(small, axis=(0, 1)).max() < _PLAIN:
        raise InputError("picture: is all of one colour, so there are no elements to be told from it")
    scale = max(lab.shape[:2]) / max(small.shape[:2])
    best, most = None, 0.0
    for smoothing in _SMOOTHING:
        values = _even(small, smoothing)
        slopes = _slopes(values)
        for count in _CLASSES:
            centres = _learn_classes(values, count)
            nearest = _nearest(values, centres)
            for chosen in _choices(count):
                quality = _rate(_clean(np.isin(nearest, chosen), smoothing), values, slopes)
                if quality > most:
                    best, most = (smoothing * scale, centres, chosen), quality
    if best is None:
        raise InputError("picture: no elements stand out in it; pick their colours, or paint them")
    smoothing, centres, chosen = best
    elements = np.isin(_nearest(_even(lab, smoothing), centres), chosen)
    return _clean(elements, smoothing).astype(np.uint8)


def _even(lab: Map, smoothing: float) -> Map:
    """Colours without grain, and without slow changes of light."""
    slow = _SLOW * max(lab.shape)
    evened = lab - ndimage.gaussian_filter(lab, (slow, slow, 0)) + lab.mean(axis=(0, 1))
    return ndimage.gaussian_filter(evened, (smoothing, smoothing, 0))


def _learn_classes(values: Map, count: int) -> Map:
    return kmeans2(values.reshape(-1, 3), count, minit="++", seed=0, iter=20)[0]


def _nearest(values: Map, centres: Map) -> npt.NDArray[np.intp]:
    """The nearest centre [centre, channel] to each value [row, col, channel]."""
    return np.argmin(np.stack([np.square(values - each).sum(axis=-1) for each in centres]), axis=0)


def _choices(count: int) -> list[tuple[int, ...]]:
    """Each class, and all but each."""
    return sorted({*itertools.combinations(range(count), 1), *itertools.combinations(range(count), count - 1)})


def _clean(elements: Mask, smoothing: float) -> Mask:
    """Without specks and holes, and without the bridges that smoothing leaves between elements that lie close."""
    least = int(_LEAST_AREA * (1 + smoothing**2))
    return remove_small_regions(open_mask(remove_small_regions(elements, least), smoothing), least)


def _slopes(values: Map) -> Map:
    """How fast colours change at each pixel [row, col], beside the mean of the picture."""
    down, across = np.gradient(values, axis=(0, 1))
    slopes = np.sqrt(np.square(down).sum(axis=-1) + np.square(across).sum(axis=-1))
    return slopes / slopes.mean()


def _rate(elements: Mask, values: Map, slopes: Map) -> float:
    """How good elements these are; more is better, and 0 is none."""
    share = float(elements.mean())
    if not _LEAST <= share <= _MOST:
        return 0.0
    regions, _ = ndimage.label(elements)
    things = regionprops(regions)
    areas = np.array([each.area for each in things])
    solidity = areas / np.array([each.area_convex for each in things])
    compact = areas @ np.maximum(0.0, (solidity - _LEAST_SOLID) / (1 - _LEAST_SOLID)) / areas.sum()
    # As many as there were if all were as large as a pixel's is on average.
    effective = areas.sum() ** 2 / np.square(areas).sum()
    apart = np.square(values[elements].mean(axis=0) - values[~elements].mean(axis=0)).sum()
    told = share * (1 - share) * apart / values.var(axis=(0, 1)).sum()
    border = slopes[outline_mask(elements)].mean()
    return float(compact * min(1.0, effective / _ENOUGH) * told * border * np.sqrt(share))
