"""Making a mask by edges: Sobel's detector, and one that follows edges down a pyramid.

Both look at all of a colour's change in CIE L*a*b*, so that tiles told apart by hue alone have edges too. Edges come
out as joints (False). The two edges of one joint grow together under `jaxtex.photo.morphology.open_mask` with a radius
a little over half the joint.
"""

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from jaxtex.core.errors import InputError
from jaxtex.photo.pictures import part_histogram, to_lab

Mask = npt.NDArray[np.bool_]
Plane = npt.NDArray[np.float32]

_GRAIN = 1.0  # pixels: standard deviation of the Gaussian that each level of the pyramid is seen through
_LEAST = 8  # pixels: a level of the pyramid smaller than this shows no lattice


def sobel_edges(pixels: npt.ArrayLike, *, smooth: float = 1.0, strength: float | None = None) -> Mask:
    """Mark as joint every pixel where colour changes fast.

    Args:
        pixels: linear light, ``[H, W]`` or ``[H, W, C]`` with C 1 or 3.
        smooth: standard deviation in pixels of the Gaussian applied first; 0 for none. More of it passes over grain.
        strength: the change, in units of Lab per pixel, from which on it is an edge; by default where Otsu's method
            parts the histogram of all changes.

    Returns:
        bool ``[H, W]``, False on edges.

    Raises:
        InputError: no picture, a value out of range, or a picture of one single colour.

    Source: Lefebvre & Poulin, section 2; change of a colour as in Di Zenzo, "A note on the gradient of a multi-image"
    (1986), which the paper's grey-level detector does not need.

    Examples:
        >>> import numpy as np
        >>> sobel_edges(np.array([[0, 0, 0, 1, 1, 1]] * 3), smooth=0)[1].astype(int).tolist()
        [1, 1, 0, 0, 1, 1]
    """
    if not smooth >= 0:
        raise InputError(f"smooth: {smooth:g} is out of range; give 0 pixels or more")
    _check_strength(strength)
    lab = _blur(to_lab(pixels), smooth)
    change, _ = _gradient(lab)
    return change < _choose_strength(change, strength)


def pyramid_edges(pixels: npt.ArrayLike, *, levels: int = 2, strength: float | None = None) -> Mask:
    """Mark as joint the edges that are seen from afar, each placed as finely as the picture allows.

    Edges are found on the picture reduced `levels` times by two, where grain has averaged out. Going down, an edge is
    looked for only about where the level above has one, and its crest is kept.

    Args:
        pixels: linear light, ``[H, W]`` or ``[H, W, C]`` with C 1 or 3.
        levels: reductions; features narrower than about 2**levels pixels are passed over. 0 keeps crests at full size.
        strength: the change, in units of Lab per pixel of the coarsest level, from which on it is an edge; by default
            where Otsu's method parts the histogram of that level's changes.

    Returns:
        bool ``[H, W]``, False on edges.

    Raises:
        InputError: no picture, a value out of range, a picture too small for so many levels or of one single colour.

    Source: Lefebvre & Poulin, section 2; Tanimoto & Pavlidis, "A hierarchical data structure for picture processing"
    (1975); crests as in Canny (1986), so that edges stay thin where the 1975 method gives bands.

    Examples:
        >>> import numpy as np
        >>> step = np.repeat([[0.1] * 32 + [0.6] * 32], 64, axis=0)
        >>> np.flatnonzero(~pyramid_edges(step)[32]).tolist()
        [31, 32]
    """
    lab = to_lab(pixels)
    if levels < 0 or min(lab.shape[:2]) < _LEAST * 2**levels:
        most = int(np.log2(max(1, min(lab.shape[:2]) / _LEAST)))
        raise InputError(f"levels: {levels} is out of range; a picture of this size has 0 to {most}")
    _check_strength(strength)
    pyramid = [lab]
    for _ in range(levels):
        pyramid.append(_halve(pyramid[-1]))
    change, direction = _gradient(_blur(pyramid.pop(), _GRAIN))
    strength = _choose_strength(change, strength)
    edges = (change >= strength) & _crests(change, direction)
    for level in reversed(pyramid):
        change, direction = _gradient(_blur(level, _GRAIN))
        strength /= 2  # a blunt edge is spread over twice as many pixels
        edges = _children(edges, change.shape) & (change >= strength) & _crests(change, direction)
    return ~edges


def _check_strength(strength: float | None) -> None:
    if strength is not None and not strength > 0:
        raise InputError(f"strength: {strength:g} is out of range; give a change in Lab per pixel above 0")


def _choose_strength(change: Plane, strength: float | None) -> float:
    if strength is not None:
        return strength
    if change.max() <= 1e-3:
        raise InputError("picture: has one single colour, so it has no edges")
    return part_histogram(change)


def _blur(lab: Plane, sigma: float) -> Plane:
    return ndimage.gaussian_filter(lab, (sigma, sigma, 0), mode="nearest") if sigma else lab


def _gradient(lab: Plane) -> tuple[Plane, Plane]:
    """Size of the fastest change of colour, in Lab per pixel, and its direction (radians, up to a half turn)."""
    dx = ndimage.sobel(lab, axis=1, mode="nearest") / 8
    dy = ndimage.sobel(lab, axis=0, mode="nearest") / 8
    xx, yy, xy = (dx * dx).sum(-1), (dy * dy).sum(-1), (dx * dy).sum(-1)
    spread = np.hypot(xx - yy, 2 * xy)
    return np.sqrt((xx + yy + spread) / 2), np.arctan2(2 * xy, xx - yy) / 2


def _crests(change: Plane, direction: Plane) -> Mask:
    """Pixels whose change is no less than one pixel on and one pixel back along the gradient."""
    rows, columns = np.indices(change.shape, np.float32)
    dy, dx = np.sin(direction), np.cos(direction)
    beside = [
        ndimage.map_coordinates(change, [rows + side * dy, columns + side * dx], order=1, mode="nearest")
        for side in (-1, 1)
    ]
    return change >= np.maximum(*beside) * (1 - 1e-5)


def _halve(lab: Plane) -> Plane:
    """Half the size: each pixel is the mean of its four children; an odd last row or column is repeated."""
    height, width, channels = lab.shape
    even = np.pad(lab, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
    return even.reshape((height + 1) // 2, 2, (width + 1) // 2, 2, channels).mean(axis=(1, 3))


def _children(edges: Mask, shape: tuple[int, ...]) -> Mask:
    """Where a finer level may have the edges of a coarser one: their pixels' children and those right beside."""
    children = np.repeat(np.repeat(edges, 2, axis=0), 2, axis=1)[: shape[0], : shape[1]]
    return ndimage.binary_dilation(children, np.ones((3, 3), bool))
