"""The tiles of a photograph cut out of it and laid upright, each with the joints around it."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.ndimage import map_coordinates

from jaxtex.material.appearance import Place
from jaxtex.models.tiling import Tiling


class Cell(NamedTuple):
    """A tile as the photograph shows it, upright, one pixel to a plane pixel.

    Attributes:
        place: (course, tile).
        values: [row, col, channel], the picture's.
        left, right, top, bottom: how far the pixels' centres lie inside of the tile's edges, in plane pixels, negative
            in joints; left and right [col], top and bottom [row].
    """

    place: Place
    values: npt.NDArray[np.float32]
    left: npt.NDArray[np.float32]
    right: npt.NDArray[np.float32]
    top: npt.NDArray[np.float32]
    bottom: npt.NDArray[np.float32]


def tile_bounds(
    tiling: Tiling, course: npt.NDArray[np.int_], tile: npt.NDArray[np.int_]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Where tiles begin and end along their courses, joints included, in plane pixels of the lattice.

    Examples:
        >>> from jaxtex.models.tiling import make_tiling
        >>> wall = make_tiling(tile_width=60, tile_height=20, offset=0.5)
        >>> tile_bounds(wall, np.array([0, 1]), np.array([2, 2]))
        (array([120., 150.]), array([180., 210.]))
    """
    width, offset = float(tiling.tile_width), float(tiling.offset)
    offsets, lengths = (np.asarray(each, np.float64) for each in (tiling.course_offsets, tiling.course_lengths))
    row = lengths[course % len(lengths)]
    repeat, number = np.divmod(tile, lengths.shape[1])
    ends = np.cumsum(row, axis=-1)
    length = np.take_along_axis(row, number[..., None], axis=-1)[..., 0]
    end = np.take_along_axis(ends, number[..., None], axis=-1)[..., 0]
    along = offset * course + offsets[course % len(offsets)] + repeat * ends[..., -1] + end
    start = np.asarray(width * (along - length), np.float64)
    return start, start + width * length


def cut_cells(picture: npt.NDArray[np.float32], tiling: Tiling, places: Sequence[Place]) -> list[Cell]:
    """Cut tiles out of a picture; those of which a part lies outside of it are passed over.

    Args:
        picture: [row, col, channel].
        tiling: fitted to the picture.
        places: (course, tile) of the tiles wanted.
    """
    numbers = np.array(places, dtype=int).reshape(-1, 2)
    starts, ends = tile_bounds(tiling, numbers[:, 0], numbers[:, 1])
    height, joint = float(tiling.tile_height), (float(tiling.mortar_x), float(tiling.mortar_y))
    limits = np.array(picture.shape[1::-1])
    kept, points = [], []
    origin = np.asarray(tiling.origin, float)
    for place, start, end in zip(places, starts, ends, strict=True):
        top = place[0] * height
        x = _pixels(start, end, joint[0], origin[0])
        y = _pixels(top, top + height, joint[1], origin[1])
        grid = np.stack(np.broadcast_arrays(x[None, :], y[:, None]), axis=-1)
        at = _to_image(tiling, grid.reshape(-1, 2))
        if (at >= 0).all() and (at <= limits).all():
            sides = [x - start, end - x, y - top, top + height - y]
            kept.append((place, [side - 0.5 * joint[n // 2] for n, side in enumerate(sides)]))
            points.append(at)
    if not kept:
        return []
    values = _sample(picture, np.concatenate(points))
    cells, first = [], 0
    for place, sides in kept:
        shape = len(sides[2]), len(sides[0])
        own = values[first : first + shape[0] * shape[1]].reshape(*shape, -1)
        cells.append(Cell(place, own, *(side.astype(np.float32) for side in sides)))
        first += shape[0] * shape[1]
    return cells


def cut_box(
    picture: npt.NDArray[np.float32], tiling: Tiling, low: npt.NDArray[np.float64], high: npt.NDArray[np.float64]
) -> npt.NDArray[np.float32]:
    """A rectangle of the lattice cut out of a picture, one pixel to a plane pixel, [row, col, channel].

    Args:
        low, high: lattice coordinates of its upper left and lower right corner, (2,).
    """
    x, y = (np.arange(start + 0.5, end, 1.0) for start, end in zip(low, high, strict=True))
    grid = np.stack(np.meshgrid(x, y), axis=-1)
    at = _to_image(tiling, grid.reshape(-1, 2))
    return _sample(picture, at).reshape(len(y), len(x), picture.shape[2])


def _pixels(start: float, end: float, joint: float, origin: float) -> npt.NDArray[np.float64]:
    """Places a pixel apart from one end of a tile to the other, and half a joint beyond. Where the tiling is not turned
    they are the picture's own pixels, which no interpolation can blur."""
    first, last = start - 0.5 * joint, end + 0.5 * joint
    pixels = np.arange(math.ceil(first + origin - 0.5), math.floor(last + origin - 0.5) + 1)
    return np.asarray(pixels + 0.5 - origin, np.float64)


def _sample(picture: npt.NDArray[np.float32], points: npt.NDArray[np.floating]) -> npt.NDArray[np.float32]:
    """The picture at points (x, y) [n, 2], by cubic splines, which keep fine grain better than straight lines do."""
    at = points.T[::-1] - 0.5
    channels = [map_coordinates(channel, at, order=3, mode="mirror") for channel in np.moveaxis(picture, 2, 0)]
    return np.stack(channels, axis=-1).astype(np.float32)


def _to_image(tiling: Tiling, points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """`Tiling.from_lattice` of many points [n, 2], without compiling for each number of them."""
    cosine, sine = math.cos(float(tiling.angle)), math.sin(float(tiling.angle))
    plane = points @ np.array([[cosine, sine], [-sine, cosine]]) + np.asarray(tiling.origin, np.float64)
    image = (
        np.concatenate([plane, np.ones((len(plane), 1))], axis=1)
        @ np.linalg.inv(np.asarray(tiling.homography, np.float64)).T
    )
    return np.asarray(image[:, :2] / image[:, 2:])
