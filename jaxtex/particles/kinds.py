"""Classes of things by colour."""

import itertools

import numpy as np
import numpy.typing as npt
from scipy import ndimage
from scipy.cluster.vq import kmeans2

from jaxtex.core.errors import InputError

Map = npt.NDArray[np.float32]
Labels = npt.NDArray[np.int32]

_MOST_KINDS = 4
_VISIBLE = 10.0  # steps of CIE Lab that they are apart at least
_SEPARATE = 2.0  # how many times as far apart as wide are classes of things at least


def class_things(lab: Map, labels: Labels, kinds: int | None = None) -> npt.NDArray[np.intp]:
    """Sort things into classes by their mean colours.

    Args:
        lab: the picture in CIE Lab, [row, col, channel].
        labels: [row, col], the number of the thing that a pixel belongs to; 0 is none.
        kinds: how many classes there are. Unless told, as many, up to 4, as are clearly apart: the two nearest mean
            colours of classes at least 10 steps, and twice the width of classes (twice their standard deviation).

    Returns:
        The class of each thing from 0, in the order of their numbers, [thing].

    Raises:
        InputError: there are not so many colours.

    Examples:
        >>> lab = np.full((4, 6, 3), 50, np.float32)
        >>> lab[1, 1] = lab[1, 3] = 80
        >>> labels = np.zeros((4, 6), np.int32)
        >>> labels[1, 1], labels[1, 3], labels[3, 3] = 1, 2, 3
        >>> class_things(lab, labels).tolist() in ([0, 0, 1], [1, 1, 0])
        True
    """
    numbers = np.unique(labels[labels > 0])
    means = np.stack([ndimage.mean(lab[..., i], labels, numbers) for i in range(3)], axis=1).astype(np.float32)
    classes = np.zeros(len(numbers), np.intp)
    distinct = len(np.unique(means.round(2), axis=0))
    if kinds is not None and kinds > distinct:
        raise InputError(f"classes: {kinds} are asked for, but things have only {distinct} colours; give fewer")
    for count in range(2, min(_MOST_KINDS, distinct) + 1) if kinds is None else [kinds]:
        centres = kmeans2(means, count, minit="++", seed=0, iter=50)[0]
        tried = nearest_centre(means, centres)
        apart = min(np.linalg.norm(a - b) for a, b in itertools.combinations(centres, 2)) if count > 1 else np.inf
        width = np.sqrt(np.mean(np.sum(np.square(means - centres[tried]), axis=1)))
        if kinds is not None or apart > max(_SEPARATE * 2 * width, _VISIBLE):
            classes = tried
    return np.unique(classes, return_inverse=True)[1]


def nearest_centre(values: Map, centres: Map) -> npt.NDArray[np.intp]:
    """The number of the nearest centre [centre, feature] to each value [..., feature]."""
    return np.argmin(np.stack([np.square(values - each).sum(axis=-1) for each in centres]), axis=0)
