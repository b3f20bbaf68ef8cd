"""Where tiles really end: bricks are not all of one size, and their outlines are not straight."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.ndimage import uniform_filter1d

from jaxtex.material.cells import Cell

SIDES = ("left", "right", "top", "bottom")

_SMOOTH = 3  # pixels along an edge over which the mask is averaged before the edge is looked for
_FEWEST = 8  # pixels of an edge that must be found


class Outline(NamedTuple):
    """How tiles' edges stray from the tiling's, in plane pixels, outwards positive.

    Attributes:
        shift: of each tile's sides on the average, [tile, side] in the order of `SIDES`.
        wobble: standard deviation of what is left along a side.
        length: distance along a side after which the wobble's correlation has fallen to 1/e.
    """

    shift: npt.NDArray[np.float32]
    wobble: float
    length: float


def measure_outlines(cells: Sequence[Cell], masks: Sequence[npt.NDArray[np.float32]], *, reach: float) -> Outline:
    """Measure the outlines of tiles in a mask.

    Args:
        cells: the tiles.
        masks: of each cell, [row, col]: 1 = tile, 0 = joint.
        reach: how far from the tiling's edges they are looked for, in plane pixels.
    """
    found = [[_edge_along(cell, mask, side, reach) for side in SIDES] for cell, mask in zip(cells, masks, strict=True)]
    shift = np.array([[np.median(edge) if len(edge) >= _FEWEST else 0.0 for edge in edges] for edges in found])
    rest = [edge - edge.mean() for edges in found for edge in edges if len(edge) >= 2 * _FEWEST]
    if not rest:
        return Outline(shift.astype(np.float32), 0.0, 1.0)
    # By medians, as a mask errs by much in few places.
    wobble = float(np.median([1.4826 * np.median(np.abs(edge)) for edge in rest]))
    return Outline(shift.astype(np.float32), wobble, _correlation_length(rest))


def _edge_along(cell: Cell, mask: npt.NDArray[np.float32], side: str, reach: float) -> npt.NDArray[np.float64]:
    """How far outside of its nominal place an edge is found, pixel by pixel along it; less where it is not found."""
    across, first, last = (
        (mask, cell.top, cell.bottom) if side in ("left", "right") else (mask.T, cell.left, cell.right)
    )
    inside = getattr(cell, side)
    order = np.argsort(-inside)  # from within outwards
    near = order[(inside[order] < max(reach, 0.25 * inside.max())) & (inside[order] > -reach)]
    # Away from the corners, which are rounded.
    middle = (first > 0.15 * first.max()) & (last > 0.15 * last.max())
    seen = uniform_filter1d(across[middle][:, near], _SMOOTH, axis=0, mode="nearest") > 0.5
    step = float(np.abs(np.diff(inside)).mean())
    solid = np.cumsum(seen, axis=1) >= 2  # the tile itself, before a joint after it counts
    joint = ~seen & solid
    ends = joint.any(axis=1)
    at = inside[near][np.argmax(joint, axis=1)]
    return -(at[ends] + 0.5 * step).astype(np.float64)


def _correlation_length(rest: Sequence[npt.NDArray[np.float64]]) -> float:
    longest = max(map(len, rest))
    total, count = np.zeros(longest), np.zeros(longest)
    for edge in rest:
        own = np.correlate(edge, edge, mode="full")[len(edge) - 1 :]
        total[: len(own)] += own
        count[: len(own)] += np.arange(len(edge), 0, -1)
    correlation = (total / np.maximum(count, 1)) / max(total[0] / count[0], 1e-12)
    below = np.flatnonzero(correlation < np.exp(-1.0))
    return float(below[0]) if len(below) else float(longest)
