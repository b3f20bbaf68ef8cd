"""Rectification: a rectangle seen in perspective becomes an upright picture.

The person marks the four corners of something that is a rectangle in the world (a wall, a poster, a block of tiles).
The one homography that takes them to an upright rectangle undoes the perspective of the whole plane.
"""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from jaxtex.core.errors import InputError
from jaxtex.photo.pictures import check_picture

Points = npt.NDArray[np.floating]

_FLATTEST = math.radians(1.0)  # a corner nearer to straight than this makes the homography meaningless
_LARGEST_SIDE = 32768
_BAND = 1 << 21  # samples taken at a time: bounds memory, whatever the sizes


def rectify(
    pixels: npt.ArrayLike,
    corners: npt.ArrayLike,
    *,
    size: tuple[int, int] | None = None,
) -> tuple[npt.NDArray[np.float32], Points]:
    """Take the quadrilateral between four corners of a photograph to an upright picture.

    Each output pixel is the mean over its own footprint in the photograph, so that what shrinks does not alias, also
    where perspective makes one end shrink more than the other.

    Args:
        pixels: linear light, ``[H, W]`` or ``[H, W, C]`` with C 1 or 3.
        corners: ``[4, 2]`` points (x right, y down) in pixels of the photograph, in any order; pixel (row r, column c)
            has its centre at (c + 0.5, r + 0.5), so that the photograph's own corners are (0, 0) and (W, H).
        size: (width, height) of the output; by default the longer of each pair of opposite edges, so that no detail
            is lost.

    Returns:
        The picture, float32, of as many dimensions as `pixels`; and the 3 x 3 homography from points of the photograph
        to points of the new picture, scaled so that w is 1 at the top left corner.

    Raises:
        InputError: not four points, outside the photograph, no convex quadrilateral, or a size out of range.

    Source: Heckbert, "Fundamentals of Texture Mapping and Image Warping" (1989), section 2.2.

    Examples:
        >>> import numpy as np
        >>> wall = np.linspace(0, 1, 48).reshape(6, 8)
        >>> upright, homography = rectify(wall, [(8, 0), (0, 6), (0, 0), (8, 6)])
        >>> upright.shape, bool(np.allclose(upright, wall, atol=1e-6))
        ((6, 8), True)
    """
    picture = check_picture(pixels)
    quad = sort_corners(corners)
    _check_inside(quad, picture.shape[1], picture.shape[0])
    width, height = _edge_lengths(quad) if size is None else _check_size(size)
    target = np.array([(0, 0), (width, 0), (width, height), (0, height)], float)
    homography = homography_from_corners(quad, target)
    upright = _resample(picture, np.linalg.inv(homography), width, height)
    return (upright[..., 0] if np.ndim(pixels) == 2 else upright), homography


def sort_corners(corners: npt.ArrayLike) -> Points:
    """Order four corners top left, top right, bottom right, bottom left.

    Top left is the corner with the least x + y (the upper one of two); from there clockwise on the screen.

    Raises:
        InputError: not four finite points, or they bound no convex quadrilateral.

    Examples:
        >>> sort_corners([(9, 8), (1, 0), (0, 9), (10, 1)]).tolist()
        [[1.0, 0.0], [10.0, 1.0], [9.0, 8.0], [0.0, 9.0]]
    """
    points = np.asarray(corners, float)
    if points.shape != (4, 2):
        raise InputError(f"corners: need four points (x, y), got an array of shape {list(points.shape)}")
    if not np.isfinite(points).all():
        raise InputError("corners: every x and y must be a finite number")
    x, y = (points - points.mean(axis=0)).T
    around = points[np.argsort(np.arctan2(y, x), kind="stable")]
    first = min(range(4), key=lambda k: (round(around[k].sum(), 6), around[k, 1]))
    quad = np.roll(around, -first, axis=0)
    _check_convex(quad)
    return quad


def homography_from_corners(corners: npt.ArrayLike, target: npt.ArrayLike) -> Points:
    """The homography that takes four points, in their order, to four others.

    Args:
        corners: ``[4, 2]`` points, going around a convex quadrilateral.
        target: ``[4, 2]`` points, going around another.

    Returns:
        ``[3, 3]``, scaled so that w is 1 at the first corner (and so positive in the whole quadrilateral).

    Raises:
        InputError: one of them is no convex quadrilateral.

    Source: Heckbert (1989), section 2.2.3, the unit square to a quadrilateral; applied once forward, once inverted.

    Examples:
        >>> homography_from_corners([(0, 0), (1, 0), (1, 1), (0, 1)], [(2, 2), (4, 2), (4, 4), (2, 4)]).tolist()
        [[2.0, 0.0, 2.0], [0.0, 2.0, 2.0], [0.0, 0.0, 1.0]]
    """
    source, goal = np.asarray(corners, float), np.asarray(target, float)
    for quad in (source, goal):
        if quad.shape != (4, 2):
            raise InputError(f"corners: need four points (x, y), got an array of shape {list(quad.shape)}")
        _check_convex(quad)
    homography = _from_unit_square(goal) @ np.linalg.inv(_from_unit_square(source))
    return homography / (homography[2] @ [*source[0], 1.0])


def apply_homography(homography: npt.ArrayLike, points: npt.ArrayLike) -> Points:
    """Map points ``[..., 2]`` by a ``[3, 3]`` homography; points on its vanishing line give infinities.

    Raises:
        InputError: wrong shapes.

    Examples:
        >>> apply_homography([[2, 0, 1], [0, 2, 0], [0, 0, 1]], [(3, 4), (0, 0)]).tolist()
        [[7.0, 8.0], [1.0, 0.0]]
    """
    matrix, place = np.asarray(homography, float), np.asarray(points, float)
    if matrix.shape != (3, 3):
        raise InputError(f"homography: must be 3 x 3, not {list(matrix.shape)}")
    if place.ndim == 0 or place.shape[-1] != 2:
        raise InputError(f"points: must have shape [..., 2], not {list(place.shape)}")
    mapped = place @ matrix[:, :2].T + matrix[:, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        return mapped[..., :2] / mapped[..., 2:]


def _from_unit_square(quad: Points) -> Points:
    """The homography from the unit square (0, 0), (1, 0), (1, 1), (0, 1) to `quad`, with 1 in its last place."""
    p0, p1, p2, p3 = quad
    bend = p0 - p1 + p2 - p3
    g, h = np.linalg.solve(np.column_stack([p1 - p2, p3 - p2]), bend)
    return np.vstack([np.column_stack([p1 - p0 + g * p1, p3 - p0 + h * p3, p0]), [g, h, 1.0]])


def _check_convex(quad: Points) -> None:
    edges = np.roll(quad, -1, axis=0) - quad
    lengths = np.hypot(*edges.T)
    if lengths.min() <= 1e-9 * max(lengths.max(), 1e-300):
        raise InputError("corners: two of the four corners are the same point; mark four different ones")
    before = np.roll(edges, 1, axis=0)
    turns = (before[:, 0] * edges[:, 1] - before[:, 1] * edges[:, 0]) / (np.roll(lengths, 1) * lengths)
    flat = np.abs(turns) < math.sin(_FLATTEST)
    if flat.any():
        x, y = quad[np.argmax(flat)]
        raise InputError(f"corners: the corner at ({x:g}, {y:g}) lies in line with two others; mark a real rectangle")
    if np.ptp(np.sign(turns)) != 0:
        x, y = quad[np.argmax(np.sign(turns) != np.sign(turns.sum()))]
        raise InputError(
            f"corners: the outline turns inwards at ({x:g}, {y:g}); the four must bound a convex quadrilateral,"
            " as a rectangle seen from anywhere does"
        )


def _check_inside(quad: Points, width: int, height: int) -> None:
    for x, y in quad:
        if not (0 <= x <= width and 0 <= y <= height):
            raise InputError(f"corners: ({x:g}, {y:g}) lies outside the photograph, which is {width} x {height} pixels")


def _check_size(size: Sequence[int]) -> tuple[int, int]:
    width, height = (int(side) for side in size)
    if not (1 <= width <= _LARGEST_SIDE and 1 <= height <= _LARGEST_SIDE):
        raise InputError(f"size: {width} x {height} is out of range; give 1 to {_LARGEST_SIDE} pixels a side")
    return width, height


def _edge_lengths(quad: Points) -> tuple[int, int]:
    top, right, bottom, left = np.hypot(*(np.roll(quad, -1, axis=0) - quad).T)
    return max(1, round(max(top, bottom))), max(1, round(max(left, right)))


def _resample(picture: npt.NDArray[np.float32], back: Points, width: int, height: int) -> npt.NDArray[np.float32]:
    """Mean of `picture` over each output pixel's footprint; `back` takes output points to points of `picture`."""
    across, down = _samples_per_pixel(back, width, height)
    splines = [
        ndimage.spline_filter(channel, 3, output=np.float32, mode="reflect") for channel in np.moveaxis(picture, 2, 0)
    ]
    lowest, highest = picture.min(axis=(0, 1)), picture.max(axis=(0, 1))
    x = (np.arange(width * across) + 0.5) / across
    rows_at_once = max(1, _BAND // (width * across * down))
    upright = np.empty((height, width, picture.shape[2]), np.float32)
    for top in range(0, height, rows_at_once):
        bottom = min(height, top + rows_at_once)
        y = (np.arange(top * down, bottom * down) + 0.5) / down
        place = apply_homography(back, np.stack(np.meshgrid(x, y), axis=-1)) - 0.5
        for k, spline in enumerate(splines):
            samples = ndimage.map_coordinates(
                spline, [place[..., 1], place[..., 0]], order=3, mode="reflect", prefilter=False
            )
            # A cubic spline overshoots at sharp edges; light does not.
            samples = np.clip(samples, lowest[k], highest[k])
            upright[top:bottom, :, k] = samples.reshape(bottom - top, down, width, across).mean(axis=(1, 3))
    return upright


def _samples_per_pixel(back: Points, width: int, height: int) -> tuple[int, int]:
    """How many samples one output pixel needs in x and y where the photograph shrinks most, which is at a corner."""
    corner = np.array([(0, 0), (width, 0), (width, height), (0, height)], float)
    inward = np.where(corner > 0, -1.0, 1.0)
    steps = []
    for axis in (0, 1):
        step = np.zeros((4, 2))
        step[:, axis] = inward[:, axis]
        shrink = np.hypot(*(apply_homography(back, corner + step) - apply_homography(back, corner)).T).max()
        steps.append(math.ceil(shrink - 0.05))  # a shrink of a few percent shows no aliasing and need not blur
    return max(1, steps[0]), max(1, steps[1])
