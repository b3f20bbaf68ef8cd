"""Particles cut out of their picture: turned, made larger, and where on a plane they come to lie."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage

Floats = npt.NDArray[np.float32]
Window = tuple[slice, slice]
Places = tuple[npt.NDArray[Any], ...]


class Cut(NamedTuple):
    """A piece of a picture, and where in it the centre of its particle's box is.

    Attributes:
        planes: [row, col, plane].
        x, y: pixels from its upper left corner.
    """

    planes: Floats
    x: float
    y: float


def transform_cut(cut: Cut, angle: float, scale: float) -> Cut:
    """A piece turned about its particle's centre, clockwise as seen, and made larger. Around it all planes are 0.

    Args:
        cut: the piece.
        angle: radians.
        scale: above 0.

    Examples:
        >>> bar = Cut(np.ones((2, 6, 1), np.float32), 3.0, 1.0)
        >>> transform_cut(bar, np.pi / 2, 1.0).planes[..., 0].sum(axis=1).round(3)
        array([0., 2., 2., 2., 2., 2., 2., 0.], dtype=float32)
    """
    if angle == 0 and scale == 1:
        return cut
    height, width, count = cut.planes.shape
    forward = scale * np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])  # of (row, col)
    corners = np.array([[y - cut.y, x - cut.x] for y in (0, height) for x in (0, width)]) @ forward.T
    low, high = np.floor(corners.min(axis=0) - 0.5), np.ceil(corners.max(axis=0) + 0.5)
    backward = np.linalg.inv(forward)
    offset = backward @ (low + 0.5) + np.array([cut.y, cut.x]) - 0.5
    turned = np.empty((*(high - low).astype(int), count), np.float32)
    # Larger steps than a pixel would leave out what lies between.
    blur = max(0.0, 0.5 * (1 / scale - 1))
    for number in range(count):
        plane = np.pad(cut.planes[..., number], 1)
        smooth = ndimage.gaussian_filter(plane, blur, mode="constant") if blur else plane
        ndimage.affine_transform(smooth, backward, offset + 1, output=turned[..., number], order=1)
    return Cut(turned, -low[1], -low[0])


def find_places(cut: Cut, x: float, y: float, size: tuple[int, int], periodic: bool) -> tuple[Window, Places]:
    """Where a piece lies whose centre is at (x, y), to the nearest pixel.

    Args:
        cut: the piece.
        x, y: pixels.
        size: width and height of the plane.
        periodic: whether what leaves it at one side comes in at the other; otherwise it is cut off.

    Returns:
        The part of the piece that is on the plane, and the plane's pixels that are that part's, as `numpy.ix_` makes
        them.
    """
    height, width = cut.planes.shape[:2]
    top, left = round(y - cut.y), round(x - cut.x)
    if periodic:
        row, column = np.arange(top, top + height) % size[1], np.arange(left, left + width) % size[0]
        return (slice(0, height), slice(0, width)), np.ix_(row, column)
    rows = slice(max(0, -top), max(0, min(height, size[1] - top)))
    columns = slice(max(0, -left), max(0, min(width, size[0] - left)))
    row, column = np.arange(top + rows.start, top + rows.stop), np.arange(left + columns.start, left + columns.stop)
    return (rows, columns), np.ix_(row, column)
