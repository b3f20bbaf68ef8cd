"""How large and how compact the elements of a picture are, and how far two pictures are apart in that.

Which pixels are elements is learnt from an exemplar's mask by colour alone, and asked of the exemplar and of what is
made of it in the same way; so neither gains by knowing where its pixels come from. Whether colours are taken as they
are, less those around (coins lie on ground that is as bright elsewhere), or both, is what tells the elements of either
half of the exemplar best by what was learnt from the other: nothing that is made of it has a say.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage
from scipy.cluster.vq import kmeans2
from scipy.stats import wasserstein_distance
from skimage.measure import regionprops
from skimage.morphology import remove_small_objects
from skimage.segmentation import clear_border

from jaxtex.particles.ground import split_touching
from jaxtex.photo.pictures import to_lab

_BLURS = 1.0, 3.0  # pixels, at which colours are looked at
_AROUND = 16.0  # pixels: standard deviation of what colours around are the mean of
_VIEWS = (True, False), (False, True), (True, True)  # colours as they are, and less those around
_COLOURS = 48  # classes of them
_SAMPLE = 20_000  # pixels that these are learnt from
_WHOLE = 0.9  # of an element's pixels are from one, side by side as there, if it is whole
_SPECK = 0.03  # of the exemplar's median element: less is noise of the classes

Floats = npt.NDArray[np.floating]


class Classes(NamedTuple):
    """Attributes:
    view: whether colours are looked at as they are, and less those around.
    centres: colours, [class, feature].
    element: whether most of a class is of elements, [class].
    speck: the smallest area that is told as an element, in pixels.
    """

    view: tuple[bool, bool]
    centres: Floats
    element: npt.NDArray[np.bool_]
    speck: float


class Elements(NamedTuple):
    """Attributes:
    areas: in pixels, of elements that do not touch the picture's border, [element].
    compactness: perimeter² over area, [element]; 4 pi of a disk.
    mask: bool [row, col].
    """

    areas: Floats
    compactness: Floats
    mask: npt.NDArray[np.bool_]


def learn_classes(picture: Floats, mask: npt.NDArray[np.bool_]) -> Classes:
    """What colours the elements of an exemplar have.

    Args:
        picture: linear light [row, col, channel].
        mask: of its elements, [row, col].
    """
    half = mask.shape[1] // 2
    halves = [(picture[:, part], mask[:, part]) for part in (slice(half), slice(half, None))]

    def rate(view: tuple[bool, bool]) -> float:
        rates = []
        for one, other in (halves, halves[::-1]):
            told, true = _tell_elements(other[0], _learn_view(*one, view)), other[1]
            rates.append((told & true).sum() / max(1, (told | true).sum()))
        return float(np.mean(rates))

    return _learn_view(picture, mask, max(_VIEWS, key=rate))


def find_elements(picture: Floats, classes: Classes, scale: Floats | None = None) -> Elements:
    """The elements of a picture, those that touch parted where they are narrow.

    Args:
        picture: linear light [row, col, channel].
        classes: of its exemplar.
        scale: how many times as large as there things are, [row, col]; areas are as they would be there.
    """
    mask, speck = _tell_elements(picture, classes), max(1, int(classes.speck))
    whole = regionprops(clear_border(split_touching(mask)))
    times = [1.0 if scale is None else float(scale[tuple(each.coords.T)].mean()) for each in whole]
    told = [
        (each.area / size**2, each.perimeter_crofton**2 / each.area) for each, size in zip(whole, times, strict=True)
    ]
    areas, compactness = np.array([each for each in told if each[0] > speck], float).reshape(-1, 2).T
    return Elements(areas, compactness, mask)


def join_elements(pictures: Sequence[Elements]) -> Elements:
    """Elements of some pictures; their masks lie side by side."""
    return Elements(*(np.concatenate(each, axis=-1) for each in zip(*pictures, strict=True)))


def share_whole(mask: npt.NDArray[np.bool_], sources: npt.NDArray[np.integer]) -> float:
    """The share of a texture's elements that are one of its exemplar's, as that is, but for a tenth of either.

    Args:
        mask: of the exemplar's elements, [row, col].
        sources: where the texture's pixels come from, [row, col, 2].
    """
    own = ndimage.label(mask)[0]
    sizes = np.bincount(own.ravel())
    shown, steps = own[tuple(np.moveaxis(sources, 2, 0))], sources - np.moveaxis(np.indices(sources.shape[:2]), 0, 2)
    whole = []
    for each in regionprops(clear_border(ndimage.label(shown > 0)[0])):
        inside = tuple(each.coords.T)
        pieces, counts = np.unique(np.column_stack([shown[inside], steps[inside]]), axis=0, return_counts=True)
        most = np.argmax(counts)
        whole.append(counts[most] >= _WHOLE * max(each.area, sizes[pieces[most, 0]]))
    return float(np.mean(whole)) if whole else np.nan


def measure_apart(one: Elements, other: Elements) -> tuple[float, float]:
    """Wasserstein distances between areas, and between perimeter² over area, both in octaves."""
    if not (len(one.areas) and len(other.areas)):
        return np.inf, np.inf
    areas = wasserstein_distance(np.log2(one.areas), np.log2(other.areas))
    return float(areas), float(wasserstein_distance(np.log2(one.compactness), np.log2(other.compactness)))


def _learn_view(picture: Floats, mask: npt.NDArray[np.bool_], view: tuple[bool, bool]) -> Classes:
    values = _features(picture, view)
    rng = np.random.default_rng(0)
    sample = rng.permutation(mask.size)[:_SAMPLE]
    centres = kmeans2(values.reshape(-1, values.shape[2])[sample], _COLOURS, minit="++", seed=0, iter=30)[0]
    share = ndimage.mean(mask, _nearest(values, centres), np.arange(_COLOURS))
    areas = np.bincount(split_touching(mask).ravel())[1:]
    return Classes(view, centres, np.nan_to_num(share) > 0.5, _SPECK * (float(np.median(areas)) if len(areas) else 0.0))


def _tell_elements(picture: Floats, classes: Classes) -> npt.NDArray[np.bool_]:
    mask = ndimage.median_filter(classes.element[_nearest(_features(picture, classes.view), classes.centres)], 3)
    speck = max(1, int(classes.speck))
    return remove_small_objects(~remove_small_objects(~mask, max_size=speck), max_size=speck)


def _features(picture: Floats, view: tuple[bool, bool]) -> Floats:
    lab = to_lab(np.asarray(picture, np.float32))

    def blur(size: float) -> Floats:
        return ndimage.gaussian_filter(lab, (size, size, 0), mode="nearest")

    around = blur(_AROUND)
    looks = [blur(each) - less for less, used in zip((0, around), view, strict=True) if used for each in _BLURS]
    return np.concatenate(looks, axis=2)


def _nearest(values: Floats, centres: Floats) -> npt.NDArray[np.intp]:
    flat = values.reshape(-1, values.shape[2])
    apart = np.square(centres).sum(axis=1)[None] - 2 * flat @ centres.T
    return np.argmin(apart, axis=1).reshape(values.shape[:2])
