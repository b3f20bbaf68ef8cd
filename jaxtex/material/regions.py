"""Where in a photograph interiors may be learnt from, as the user says."""

from collections.abc import Sequence
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.material.cells import Cell, cut_box
from jaxtex.models.tiling import Tiling

_MOST_KINDS = 16
_LARGEST = 1.2  # times a tile's size, joint included: larger rectangles are meant for several
_SMALLEST = 3  # pixels to a side of a rectangle, once it is inside of its tile

Rectangle = tuple[float, float, float, float]
"""x, y, width, height in pixels of the photograph."""


class Regions(NamedTuple):
    """Regions chosen by the user; where there are none of a sort, they are chosen automatically.

    Attributes:
        tiles, joints: rectangles, each inside of one tile or joint.
        painted: [row, col], whole numbers: 0 where nothing is to be learnt, and elsewhere the kind of the tile, from 1.
    """

    tiles: tuple[Rectangle, ...] = ()
    joints: tuple[Rectangle, ...] = ()
    painted: npt.NDArray[np.int32] | None = None


def read_painted(levels: npt.NDArray[np.floating], shape: tuple[int, int], source: str) -> npt.NDArray[np.int32]:
    """Kinds of tiles from a painted picture: black is 0, and each other grey a kind of its own, from the darkest.

    Args:
        levels: [row, col], 0 to 1.
        shape: (rows, columns) of the photograph.
        source: the picture's file, to name it in complaints.

    Raises:
        InputError: it has another size than the photograph, nothing is painted, or too many greys.
    """
    if levels.shape != shape:
        told = f"{levels.shape[1]} x {levels.shape[0]} pixels, and the photograph {shape[1]} x {shape[0]}"
        raise InputError(f"{source}: has {told}; paint over the photograph itself")
    steps = np.rint(255 * levels).astype(np.int32)
    greys = np.unique(steps[steps > 0])
    if not len(greys):
        raise InputError(f"{source}: is all black; paint white, or a grey for each kind, over tiles to learn from")
    if len(greys) > _MOST_KINDS:
        raise InputError(
            f"{source}: has {len(greys)} greys, each a kind of tile; paint with {_MOST_KINDS} at most, and hard edges"
        )
    return (np.searchsorted(greys, steps) + 1).astype(np.int32) * (steps > 0)


def check_rectangles(regions: Regions, shape: tuple[int, int]) -> None:
    """Refuse rectangles that leave the photograph.

    Args:
        shape: (rows, columns) of the photograph.

    Raises:
        InputError: there is such a one.
    """
    for sort, rectangles in (("tile", regions.tiles), ("joint", regions.joints)):
        for rectangle in rectangles:
            x, y, width, height = rectangle
            if min(x, y) < 0 or x + width > shape[1] or y + height > shape[0]:
                told = f"the photograph, which has {shape[1]} x {shape[0]} pixels"
                raise InputError(f"{sort} region {_told(rectangle)}: leaves {told}")


def find_tiles(tiling: Tiling, cells: Sequence[Cell], rectangles: Sequence[Rectangle]) -> npt.NDArray[np.int_]:
    """Numbers of the tiles in which rectangles have their middles.

    Raises:
        InputError: one has it in no tile.
    """
    number = {cell.place: n for n, cell in enumerate(cells)}
    found = []
    for rectangle in rectangles:
        place = tiling.locate(jnp.asarray(np.mean(_in_lattice(tiling, rectangle), axis=0), jnp.float32))
        if (int(place.course), int(place.tile)) not in number:
            raise InputError(f"tile region {_told(rectangle)}: is in no tile that the photograph shows as a whole")
        found.append(number[int(place.course), int(place.tile)])
    return np.array(found)


def cut_grain(
    tiling: Tiling, cells: Sequence[Cell], grains: Sequence[npt.NDArray[np.float32]], rectangle: Rectangle
) -> npt.NDArray[np.float32]:
    """The part of a tile's grain that lies in a rectangle.

    Args:
        cells: the tiles.
        grains: of each, [row, col, channel], in the middle of the cell.

    Raises:
        InputError: the rectangle's middle is in no tile, or too little of the rectangle.
    """
    low, high = _in_lattice(tiling, rectangle)
    (number,) = find_tiles(tiling, cells, [rectangle])
    place = tiling.locate(jnp.asarray(0.5 * (low + high), jnp.float32))
    cell, grain = cells[number], grains[number]
    if ((high - low) > _LARGEST * np.array([float(place.left + place.right), float(place.top + place.bottom)])).any():
        raise InputError(f"tile region {_told(rectangle)}: covers more than one tile; put it inside of one")
    middle = 0.5 * (low + high)
    start = middle - np.array([float(place.left), float(place.top)])  # the tile's corner, joints included
    half = 0.5 * np.array([float(tiling.mortar_x), float(tiling.mortar_y)])
    x, y = (np.asarray(cell.left) + start[0] + half[0], np.asarray(cell.top) + start[1] + half[1])
    rows, columns = (_middle_of(at, count) for at, count in ((y, grain.shape[0]), (x, grain.shape[1])))
    cut = grain[(rows > low[1]) & (rows < high[1])][:, (columns > low[0]) & (columns < high[0])]
    if min(cut.shape[:2]) < _SMALLEST:
        raise InputError(f"tile region {_told(rectangle)}: shows too little of a tile; put it inside of one")
    return cut


def cut_joints(
    picture: npt.NDArray[np.float32], tiling: Tiling, rectangles: Sequence[Rectangle]
) -> npt.NDArray[np.float32]:
    """Pieces of joints in rectangles, [region, row, col, channel], around 0, along the rows, and all of one size.

    Raises:
        InputError: a rectangle is too small.
    """
    pieces = []
    for rectangle in rectangles:
        piece = cut_box(picture, tiling, *_in_lattice(tiling, rectangle))
        piece = piece.transpose(1, 0, 2) if piece.shape[0] > piece.shape[1] else piece
        if piece.shape[0] < _SMALLEST:
            raise InputError(f"joint region {_told(rectangle)}: is too thin; give at least {_SMALLEST} pixels")
        pieces.append(piece - np.median(piece, axis=1, keepdims=True))
    height, width = np.min([piece.shape[:2] for piece in pieces], axis=0)
    return np.stack([piece[:height, :width] for piece in pieces])


def _in_lattice(tiling: Tiling, rectangle: Rectangle) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """The least and the greatest lattice coordinates of the largest upright box inside of a rectangle, (2,) each."""
    x, y, width, height = rectangle
    corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]
    q = np.array([tiling.to_lattice(jnp.asarray(corner, jnp.float32)) for corner in corners], np.float64)
    one, other = 0.5 * (q[1] - q[0] + q[2] - q[3]), 0.5 * (q[3] - q[0] + q[2] - q[1])
    long, short = sorted((float(np.hypot(*one)), float(np.hypot(*other))), reverse=True)
    cosine, sine = np.abs(one if long == np.hypot(*one) else other) / max(long, 1e-9)
    if short <= 2.0 * sine * cosine * long:  # two corners of the box touch the long sides, and none the short ones
        size = 0.5 * short / np.array([sine, cosine])
    else:
        size = np.array([long * cosine - short * sine, short * cosine - long * sine]) / (cosine**2 - sine**2)
    middle = q.mean(axis=0)
    return middle - 0.5 * size, middle + 0.5 * size


def _middle_of(at: npt.NDArray[np.floating], count: int) -> npt.NDArray[np.floating]:
    first = (len(at) - count) // 2
    return at[first : first + count]


def _told(rectangle: Rectangle) -> str:
    return "{:g},{:g},{:g}x{:g}".format(*rectangle)
