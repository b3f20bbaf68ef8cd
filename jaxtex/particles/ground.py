"""Things found by their ground: what it is, and what lies on it, thing by thing.

J.-M. Dischler, K. Maritaud, B. Lévy and D. Ghazanfarpour, "Texture particles" (Eurographics 2002), section 2.1: colours
are smoothed and quantised to a few classes, whose connected parts are the things; a person says which colours count.

Departures: colours are compared where steps look even (CIE Lab), and slow light is taken away first. Things that touch
are parted where they are narrow. And where nobody says what the ground is, each class is tried for it, at some amounts
of smoothing and with how rough a place is as one more channel: on the right ground things are compact and free all
around, the ground goes on between them everywhere, and colours change where things end. What is called the ground is
all around the things; they may be of any colours, and their classes follow from their mean ones.
"""

import itertools
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage
from scipy.cluster.vq import kmeans2
from skimage.measure import regionprops
from skimage.morphology import disk, h_maxima, opening, remove_small_objects
from skimage.segmentation import watershed

from jaxtex.particles.kinds import nearest_centre
from jaxtex.photo.evidence import shrink

Mask = npt.NDArray[np.bool_]
Map = npt.NDArray[np.float32]
Labels = npt.NDArray[np.int32]

_GLANCE = 256  # pixels along the longer side at which the ground is chosen
_SMOOTHING = 1.0, 2.0, 4.0  # pixels
_COLOURS = 2, 3, 4  # classes of pixels
_SLOW = 1 / 6  # of the longer side: standard deviation of what is taken for light
_ROUGHNESS = 2.0  # how much it counts beside colours
_SAMPLE = 20_000  # pixels that classes are learnt from
_LEAST_AREA = 8.0  # pixels, times the square of the smoothing: less is no thing
_HOLES = 4  # times that: ground that is smaller is part of the thing around it
_DEEP = 0.25  # pixels, times the smoothing, and twice that: how much narrower a neck is than what it joins
_LEAST_SOLID = 0.6  # of its convex hull: what fills no more is no thing
_FEW = 8  # things: fewer speak the less for a ground


class _Way(NamedTuple):
    """How the ground is told from things: which class of pixels it is, and what these are told by."""

    smoothing: float
    rough: bool
    centres: Map
    ground: int


def find_by_ground(lab: Map) -> Labels:
    """Number what lies on the ground that tells things best, in a picture in CIE Lab, [row, col, channel].

    Returns:
        Labels [row, col], 0 being the ground; nothing but 0 where no ground will do.
    """
    small = shrink(lab, _GLANCE)
    way = _choose_ground(small)
    if way is None:
        return np.zeros(lab.shape[:2], np.int32)
    scale = max(lab.shape[:2]) / max(small.shape[:2])
    return _part_things(_features(lab, way.smoothing * scale, way.rough), way, scale)


def split_touching(things: Mask, *, smoothing: float = 1.0) -> Labels:
    """Number things, those that touch apart: by watershed of the distance from their borders.

    Args:
        things: bool [row, col].
        smoothing: standard deviation in pixels by which distances are smoothed; two parts are two things where the
            neck between them is narrower by half a pixel and a quarter of that, on either side.

    Examples:
        >>> row, column = np.indices((20, 40))
        >>> int(split_touching(np.hypot(row - 10, (column % 16) - 8) < 8.5).max())
        3
    """
    inside = ndimage.distance_transform_edt(np.pad(things, 1, mode="edge"))[1:-1, 1:-1]
    depth = ndimage.gaussian_filter(inside, smoothing)
    tops, _ = ndimage.label(h_maxima(depth, _DEEP * (2 + smoothing)))
    return watershed(-depth, tops, mask=things).astype(np.int32)


def _choose_ground(lab: Map) -> _Way | None:
    best, most = None, 0.0
    for smoothing, rough in itertools.product(_SMOOTHING, (False, True)):
        features = _features(lab, smoothing, rough)
        for count in _COLOURS:
            centres = _learn_classes(features.reshape(-1, features.shape[2]), count)
            for ground in range(len(centres)):
                way = _Way(smoothing, rough, centres, ground)
                labels = _part_things(features, way, 1.0)
                quality = _rate(labels, lab)
                if quality > most:
                    best, most = way, quality
    return best


def _features(lab: Map, smoothing: float, rough: bool) -> Map:
    """What pixels are told apart by, [row, col, feature]: evened colours, and how rough it is there."""
    slow = _SLOW * max(lab.shape)
    evened = lab - ndimage.gaussian_filter(lab, (slow, slow, 0)) + lab.mean(axis=(0, 1))
    smooth = ndimage.gaussian_filter(evened, (smoothing, smoothing, 0))
    if not rough:
        return smooth
    light = lab[..., 0]
    fine = np.square(light - ndimage.gaussian_filter(light, 1.5))
    roughness = _ROUGHNESS * np.sqrt(ndimage.gaussian_filter(fine, 2 * smoothing))
    return np.concatenate([smooth, roughness[..., None]], axis=2)


def _learn_classes(values: Map, count: int) -> Map:
    rng = np.random.default_rng(0)
    sample = values[rng.permutation(len(values))[:_SAMPLE]]
    return kmeans2(sample, count, minit="++", seed=0, iter=30)[0].astype(np.float32)


def _part_things(features: Map, way: _Way, scale: float) -> Labels:
    smoothing = way.smoothing * scale
    ground = nearest_centre(features, way.centres) == way.ground
    small = int(_LEAST_AREA * (1 + smoothing**2))
    # Large holes are ground that touching things surround.
    things = ~remove_small_objects(ground, max_size=_HOLES * small)
    things = opening(remove_small_objects(things, max_size=small), disk(round(smoothing)))
    return split_touching(things, smoothing=smoothing)


def _rate(labels: Labels, lab: Map) -> float:
    """How well things are told from the ground, from 0 to 1."""
    things = regionprops(labels)
    area = sum(each.area for each in things)
    if not 0 < area < labels.size:
        return 0.0
    free = _free_share(labels)
    solid = [max(0.0, (each.area / each.area_convex - _LEAST_SOLID) / (1 - _LEAST_SOLID)) for each in things]
    compact = sum(each.area * share * free[each.label] for each, share in zip(things, solid, strict=True)) / area
    ground, _ = ndimage.label(ndimage.binary_dilation(labels == 0))
    reach = max(
        (rows.stop - rows.start) * (columns.stop - columns.start) for rows, columns in ndimage.find_objects(ground)
    )
    few = min(1.0, len(things) / _FEW)
    covered = area / labels.size  # what surrounds is seldom more than what it surrounds, where both would do
    return float(compact * np.sqrt(_told_by_colour(labels > 0, lab) * covered) * (reach / labels.size) * few)


def _told_by_colour(things: Mask, lab: Map) -> float:
    """The share of the variance of colours that is between things and ground."""
    share = things.mean()
    apart = np.square(lab[things].mean(axis=0) - lab[~things].mean(axis=0)).sum()
    return float(share * (1 - share) * apart / lab.var(axis=(0, 1)).sum())


def _free_share(labels: Labels) -> npt.NDArray[np.float64]:
    """Of each thing's border, the share that is against the ground rather than other things; by number, from 0."""
    count = int(labels.max()) + 1
    free, whole = np.zeros(count), np.zeros(count)
    for one, other in ((labels[1:], labels[:-1]), (labels[:, 1:], labels[:, :-1])):
        for own, beyond in ((one, other), (other, one)):
            border = (own != beyond) & (own > 0)
            whole += np.bincount(own[border], minlength=count)
            free += np.bincount(own[border & (beyond == 0)], minlength=count)
    return free / np.maximum(whole, 1)
