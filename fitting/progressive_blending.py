"""Feature-based blending beside what it is better than, and measures of it; `progressive.py` draws and tells them.

Plain cross-fading; masks that are averaged alike everywhere (figure 7, bottom); masks blended as labels, blurred and
thresholded (figures 7 and 8, middle); and L.-Y. Wei's mixture (Ph.D. thesis, Stanford 2001; figure 7, top): the
neighbourhood of each pixel is looked up in each exemplar, by exhaustive search in reduced dimensions, and the pixel
becomes the weighted mean of the colours found. Here that is done from coarse to fine, for all pixels of a resolution at
once, a few times, where Wei goes through them in scanline order once.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.lib.stride_tricks import sliding_window_view
from scipy import ndimage
from scipy.spatial import cKDTree
from scipy.stats import qmc
from skimage.measure import perimeter, regionprops
from skimage.transform import resize

BLUR = 2.0  # pixels, of labels that are blended
GRAIN = 1.5  # pixels: standard deviation of what smooths grain away
STRIPS = 8
SHIFTS = 64  # of masks against each other, over which measures are means
_LEAST_AREA = 6  # pixels of an element that is measured
_MIXTURE_LEVELS, _MIXTURE_PASSES, _MIXTURE_RADIUS, _MIXTURE_DIMENSIONS = 4, 3, 3, 12

Floats = npt.NDArray[np.floating]
Labels = npt.NDArray[np.uint8]


class Strips(NamedTuple):
    """What elements are like, strip by strip from left to right: [strip] each."""

    area: Floats
    elements: Floats
    roundness: Floats


def blend_labels(masks: list[Labels], weights: Floats) -> tuple[Floats, Floats, Labels]:
    """The paper's way: labels 0 and 1 blended, that blurred, and that thresholded at a half."""
    blended = np.sum(weights * np.stack(masks), axis=0)
    blurred = ndimage.gaussian_filter(blended, BLUR, mode="nearest")
    return blended, blurred, (blurred > 0.5).astype(np.uint8)


def measure_strips(mask: Labels) -> Strips:
    """Per strip: the share that elements cover, how many there are in 100 x 100 pixels, perimeter²/(4 pi area)."""
    found = []
    for columns in np.array_split(np.arange(mask.shape[1]), STRIPS):
        strip = mask[:, columns] > 0
        regions = [each for each in regionprops(ndimage.label(strip)[0]) if each.area >= _LEAST_AREA]
        shapes = [perimeter(np.pad(each.image, 1)) ** 2 / (4 * np.pi * each.area) for each in regions]
        found.append((strip.mean(), len(regions) / strip.size * 1e4, np.mean(shapes) if shapes else np.nan))
    return Strips(*np.array(found).T)


def measure_blend(masks: list[Labels], weights: Floats, blend: Callable[[list[Labels], Floats], Labels]) -> Strips:
    """The same for a way of blending masks, as the mean over masks that are shifted against each other.

    Shifts are spread evenly: of as many that are drawn, what masks have more of here than there is left in the means.
    """
    total = []
    for shifts in qmc.Sobol(2 * len(masks), rng=np.random.default_rng(0)).random(SHIFTS):
        pairs = zip(masks, shifts.reshape(-1, 2), strict=True)
        moved = [np.roll(each, tuple((shift * each.shape).astype(int)), (0, 1)) for each, shift in pairs]
        total.append(measure_strips(blend(moved, weights)))
    return Strips(*np.nanmean(np.array(total), axis=0))


def turning_back(values: Floats) -> float:
    """By how much of the way from the first to the last value others go back or beyond; 0 for monotonic ones."""
    way = values[-1] - values[0]
    steps = np.diff(values) * np.sign(way)
    return float(np.maximum(-steps, 0).sum() / abs(way))


def going_beyond(values: Floats) -> float:
    """How far values go beyond the first and the last, at most, over these; where the two are alike, what is gone back
    of the way between them tells nothing."""
    ends = values[[0, -1]]
    return float(max(values.max() / ends.max(), ends.min() / values.min()) - 1)


def kept_edges(layers: Floats, weights: Floats, columns: slice) -> float:
    """Squared gradients of layers that are blended, beside the weighted mean of each one's own, in some columns.

    Where edges of two layers lie in the same places, they are as strong as before, 1; where all lie apart, each is a
    ghost at half its strength, and a half is left in the middle. Grain is smoothed away: it lies apart in any case.
    """
    energies = [edge_energy(each) for each in (*layers, np.einsum("nrc,nrck->rck", weights, layers))]
    own = np.sum(weights.mean(axis=1) * np.stack(energies[:-1]), axis=0)
    return float(energies[-1][columns].mean() / own[columns].mean())


def edge_energy(picture: Floats) -> Floats:
    """Squared gradients of a picture that is smoothed, the mean of each column."""
    smooth = ndimage.gaussian_filter(picture, (GRAIN, GRAIN, 0))
    return np.sum([np.square(np.gradient(smooth, axis=axis)).sum(axis=2).mean(axis=0) for axis in (0, 1)], axis=0)


def mix_textures(exemplars: list[Floats], weights: Floats, seed: int = 0) -> Floats:
    """Wei's mixture."""
    rng = np.random.default_rng(seed)
    made = None
    for level in reversed(range(_MIXTURE_LEVELS)):
        shape = [-(-side >> level) for side in weights.shape[1:]]
        shares = resize(weights, (len(weights), *shape), anti_aliasing=True)
        pictures = [resize(each, [side >> level for side in each.shape[:2]], anti_aliasing=True) for each in exemplars]
        if made is None:
            drawn = [each.reshape(-1, 3)[rng.integers(each.shape[0] * each.shape[1], size=shape)] for each in pictures]
            made = np.einsum("nrc,nrck->rck", shares, np.stack(drawn))
        else:
            made = resize(made, (*shape, 3), order=1)
        trees = [_index_neighbourhoods(each) for each in pictures]
        for _ in range(_MIXTURE_PASSES):
            padded = np.pad(made, [(_MIXTURE_RADIUS,) * 2] * 2 + [(0, 0)], mode="symmetric")
            seen = _neighbourhoods(padded)
            found = [
                colours[tree.query((seen - middle) @ basis)[1]].reshape(*shape, 3)
                for tree, middle, basis, colours in trees
            ]
            made = np.einsum("nrc,nrck->rck", shares, np.stack(found))
    return made


def _neighbourhoods(picture: Floats) -> Floats:
    side = 2 * _MIXTURE_RADIUS + 1
    windows = sliding_window_view(picture, (side, side), axis=(0, 1))
    return windows.reshape(windows.shape[0] * windows.shape[1], -1)


def _index_neighbourhoods(picture: Floats) -> tuple[cKDTree, Floats, Floats, Floats]:
    """Neighbourhoods to look up, in few dimensions: the tree, what is subtracted, the basis, colours in the middle."""
    seen = _neighbourhoods(picture)
    middle = seen.mean(axis=0)
    values, vectors = np.linalg.eigh((seen - middle).T @ (seen - middle))
    basis = vectors[:, np.argsort(values)[-_MIXTURE_DIMENSIONS:]]
    inner = picture[_MIXTURE_RADIUS:-_MIXTURE_RADIUS, _MIXTURE_RADIUS:-_MIXTURE_RADIUS]
    return cKDTree((seen - middle) @ basis), middle, basis, inner.reshape(-1, 3)
