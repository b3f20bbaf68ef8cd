"""Grain: what is left of tiles and joints once their colours, and how these change towards edges, are taken away."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from jaxtex.material.cells import Cell
from jaxtex.material.edges import SIDES

MARGIN = 2.0, 0.15
"""Pixels, and share of a face's shorter side: so far inside of the edges grain is the same all over."""

_STEP = 1 / 255
_MOST_PIXELS = 1 << 18  # of all examples of one kind
_REACH = 0.4, 4, 64  # of the shorter side of a face, and in pixels: how far edges show in a tile's colour
_THINNEST = 4  # pixels: nothing can be learnt from the inside of thinner joints
_MIDDLE = 0.65  # of a joint: towards tiles there are shadows and what tiles have lost
_LONG = 8  # times its thickness: how long an example of a joint is
_DIRT = 10.0  # times as uneven does a strip count that the mask calls all tile
_FEWEST = 8  # examples of joints


def to_steps(grain: npt.NDArray[np.float32]) -> npt.NDArray[np.int8]:
    """Grain in steps of 1/255, up to half of the range of values either way: photographs have no finer."""
    return np.clip(np.rint(grain / _STEP), -127, 127).astype(np.int8)


def from_steps(steps: npt.NDArray[np.int8]) -> npt.NDArray[np.float32]:
    """The grain that `to_steps` has made steps of."""
    return steps.astype(np.float32) * np.float32(_STEP)


def in_steps(grain: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Grain as a file keeps it, so that what is rendered of a file is what was rendered when it was measured."""
    return from_steps(to_steps(grain))


def face_colour(cell: Cell) -> npt.NDArray[np.float32]:
    """The median colour of a tile's face, [channel]."""
    rows, columns = _rows_and_columns(cell)
    return np.median(cell.values[rows][:, columns].reshape(-1, cell.values.shape[2]), axis=0)


def tile_profile(cells: Sequence[Cell]) -> npt.NDArray[np.float32]:
    """How tiles' colours change towards their sides, [side, pixel from the edge inwards, channel].

    It is the median over tiles of the mean along a side, of the differences from the tile's own colour; the four sides
    add up. It ends level with 0.
    """
    shortest = min(min(cell.left.max(), cell.top.max()) for cell in cells)
    reach = int(np.clip(round(_REACH[0] * shortest), *_REACH[1:]))
    profile = np.zeros((len(SIDES), reach, cells[0].values.shape[2]), np.float32)
    for side, name in enumerate(SIDES):
        profile[side] = np.median([_along_side(cell, name, reach) - face_colour(cell) for cell in cells], axis=0)
    profile -= profile[:, -1:]
    fade = np.clip(2.0 - 2.0 * (np.arange(reach) + 0.5) / reach, 0, 1)
    return profile * fade[:, None].astype(np.float32)


def tile_grain(cell: Cell, profile: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """The grain of a tile's face, [row, col, channel], around 0; without the outermost pixels."""
    grain = cell.values - face_colour(cell)
    for side, name in enumerate(SIDES):
        shade = at_distance(profile[side], getattr(cell, name))
        grain = grain - (shade[None, :] if name in ("left", "right") else shade[:, None])
    rows, columns = _rows_and_columns(cell)
    return grain[rows][:, columns]


def at_distance(profile: npt.NDArray[np.float32], distance: npt.NDArray[np.floating]) -> npt.NDArray[np.float32]:
    """A side's profile at distances from the edge in pixels, [..., channel]; 0 beyond it."""
    known = np.arange(len(profile)) + 0.5
    values = [np.interp(distance, known, channel, right=0.0) for channel in profile.T]
    return np.stack(values, axis=-1).astype(np.float32)


def stack_regions(grains: Sequence[npt.NDArray[np.float32]], *, all_of_them: bool = False) -> npt.NDArray[np.float32]:
    """Regions of one size, [region, row, col, channel], the middles of such as are large enough.

    The size is that of the smallest but for a fifth of them, which are left out, or of the smallest if all of them are
    to be kept. Of very many, some are taken that are spread evenly over them.
    """
    sizes = np.array([grain.shape[:2] for grain in grains])
    height, width = np.quantile(sizes, 0.0 if all_of_them else 0.2, axis=0, method="lower")
    large = [grain for grain in grains if grain.shape[0] >= height and grain.shape[1] >= width]
    large = large or [min(grains, key=lambda grain: grain.size)]
    height, width = np.min([grain.shape[:2] for grain in large], axis=0)
    step = max(1, -(-len(large) * height * width // _MOST_PIXELS))
    return np.stack([_middle(grain, height, width) for grain in large[::step]])


def joint_profile(
    cells: Sequence[Cell], masks: Sequence[npt.NDArray[np.float32]], colour: npt.NDArray[np.float32], reach: float
) -> npt.NDArray[np.float32]:
    """How the joints' colour changes towards tiles, [side, pixel from the edge outwards, channel].

    Args:
        cells: tiles with the joints around them.
        masks: of each cell: 1 = tile, 0 = joint.
        colour: of joints, [channel].
        reach: half the joints' thickness, in pixels.
    """
    pixels = max(1, round(reach))
    profile = np.zeros((len(SIDES), pixels, len(colour)), np.float32)
    for side, name in enumerate(SIDES):
        for n in range(pixels):
            seen = [_joint_at(cell, mask, name, n + 0.5) for cell, mask in zip(cells, masks, strict=True)]
            found = np.concatenate(seen)
            if len(found):
                profile[side, n] = np.median(found, axis=0) - colour
    return profile


def joint_strips(
    cells: Sequence[Cell], masks: Sequence[npt.NDArray[np.float32]], thickness: tuple[float, float]
) -> npt.NDArray[np.float32]:
    """Pieces of joints, [region, row, col, channel], laid along the rows, around 0: those the mask shows cleanest.

    Args:
        cells: tiles with the joints around them.
        masks: of each cell: 1 = tile, 0 = joint.
        thickness: of the joints between tiles, and between courses, in pixels.
    """
    across = _MIDDLE * thickness[1] < _THINNEST  # joints between courses are longer, if they are thick enough
    thick = thickness[0] if across else thickness[1]
    high = int(_MIDDLE * thick)
    channels = cells[0].values.shape[2]
    if high < _THINNEST:
        return np.zeros((0, 1, 1, channels), np.float32)
    shortest = min(cell.values.shape[0 if across else 1] for cell in cells)
    long = min(_LONG * high, shortest)
    pieces, dirt = [], []
    for cell, mask in zip(cells, masks, strict=True):
        values, shown, inside = (
            (cell.values.transpose(1, 0, 2), mask.T, cell.right) if across else (cell.values, mask, cell.bottom)
        )
        start = int(np.argmin(np.abs(inside + 0.5 * (thick - high) + 0.5)))
        for first in range(0, values.shape[1] - long + 1, long):
            window = slice(start, start + high), slice(first, first + long)
            if values[window].shape[0] == high:
                pieces.append(values[window])
                dirt.append(float(shown[window].mean()))
    if not pieces:
        return np.zeros((0, 1, 1, channels), np.float32)
    strips = np.stack(pieces)
    # How a joint's colour changes across it is not its grain.
    strips = strips - np.median(strips, axis=(0, 2), keepdims=True)
    # What reaches into a joint from its tiles makes it uneven, whether the mask knows of it or not.
    unevenness = np.sqrt(np.mean(np.square(strips - strips.mean(axis=(1, 2), keepdims=True)), axis=(1, 2, 3)))
    order = np.argsort(unevenness * (1.0 + _DIRT * np.array(dirt)), kind="stable")
    most = max(1, _MOST_PIXELS // (long * high))
    return strips[np.sort(order[: min(max(len(order) // 2, _FEWEST), most)])]


def _rows_and_columns(cell: Cell) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Those of a face, without a margin as far as it is large enough."""
    depths = [np.minimum(one, other) for one, other in ((cell.top, cell.bottom), (cell.left, cell.right))]
    shorter = 2.0 * min(float(depth.max()) for depth in depths)
    margin = max(MARGIN[0], MARGIN[1] * shorter)
    rows, columns = (depth > min(margin, 0.5 * float(depth.max())) for depth in depths)
    return rows, columns


def _along_side(cell: Cell, side: str, reach: int) -> npt.NDArray[np.floating]:
    """The mean along a side, at each pixel from the edge inwards, [pixel, channel]."""
    upright = side in ("left", "right")
    first, last = (cell.top, cell.bottom) if upright else (cell.left, cell.right)
    values = cell.values if upright else cell.values.transpose(1, 0, 2)
    middle = np.minimum(first, last) > 0.25 * np.minimum(first, last).max()
    mean = values[middle].mean(axis=0)
    inside = getattr(cell, side)
    order = np.argsort(inside)
    return np.stack([np.interp(np.arange(reach) + 0.5, inside[order], each[order]) for each in mean.T], axis=-1)


def _joint_at(cell: Cell, mask: npt.NDArray[np.float32], side: str, depth: float) -> npt.NDArray[np.float32]:
    """Colours of the joint at a distance outside of a tile's side, [pixel, channel]."""
    upright = side in ("left", "right")
    line = int(np.argmin(np.abs(getattr(cell, side) + depth)))
    first, last = (cell.top, cell.bottom) if upright else (cell.left, cell.right)
    values, shown = (cell.values[:, line], mask[:, line]) if upright else (cell.values[line], mask[line])
    return values[(shown < 0.5) & (first > 0) & (last > 0)]


def _middle(grain: npt.NDArray[np.float32], height: int, width: int) -> npt.NDArray[np.float32]:
    row, column = (grain.shape[0] - height) // 2, (grain.shape[1] - width) // 2
    return grain[row : row + height, column : column + width]
