"""Is it a tiling at all? Every joint that the fit predicts is looked up in the mask."""

from typing import NamedTuple

import jax
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from jaxtex.models.grids import coverage_grid
from jaxtex.models.tiling import Tiling

Array = NDArray[np.float64]

_SEEN = 0.25  # contrast, of a perfect 1, that three quarters of the predicted joints must have
_FEWEST_TILES = 4


class Verdict(NamedTuple):
    """``ok`` and the ``reason``; ``beds`` and ``heads``: typical (lower-quartile) contrast between a predicted joint of
    either kind and the tiles beside it, on the mask's scale of 0 to 1; ``tiles``: how many were looked at; ``iou``:
    intersection over union of mask and fit, mean of tiles and joints."""

    ok: bool
    reason: str
    beds: float
    heads: float
    tiles: int
    iou: float


def judge_fit(tiling: Tiling, joint: NDArray[np.float32]) -> Verdict:
    """Judge a tiling in the pixels of a map of joints (H, W)."""
    beds, heads, tiles = measure_joints(tiling, joint)
    with jax.enable_x64():
        rendered = np.asarray(coverage_grid(tiling, *joint.shape, blur=0.5))
    found = [float(np.nanquantile(each, 0.25)) if np.isfinite(each).any() else 0.0 for each in (beds, heads)]
    reason = _find_fault(found[0], found[1], tiles)
    return Verdict(not reason, reason or "", *found, tiles, mean_iou(joint < 0.5, rendered > 0.5))


def _find_fault(beds: float, heads: float, tiles: int) -> str:
    if tiles < _FEWEST_TILES:
        return f"only {tiles} whole tiles would lie in the picture: too few to tell a tiling from chance"
    if beds < _SEEN:
        return f"the courses' joints are not where they should be (contrast {beds:.2f}, {_SEEN} needed)"
    if heads < _SEEN:
        return f"joints between the tiles of a course are not where they should be (contrast {heads:.2f}, {_SEEN} needed)"
    return ""


def measure_joints(tiling: Tiling, joint: NDArray[np.float32]) -> tuple[Array, Array, int]:
    """Contrast of every predicted bed and head joint of the tiles inside the map (H, W) against the tiles beside."""
    height, width = joint.shape
    pitch = float(min(tiling.tile_width * np.min(tiling.course_lengths), tiling.tile_height))
    smooth = ndimage.gaussian_filter(joint, 0.03 * pitch)
    tiles = list_tiles(tiling, width, height)
    x0, length, y0 = tiles.T
    h = float(tiling.tile_height)
    t, u = np.linspace(0.2, 0.8, 9), np.linspace(-0.35, 0.35, 5)

    def read(qx: Array, qy: Array) -> Array:
        x, y = from_lattice(tiling, qx, qy)
        values = ndimage.map_coordinates(smooth, [y - 0.5, x - 0.5], order=1, mode="constant", cval=np.nan)
        return np.nanmean(values.reshape(len(tiles), -1), axis=1)

    s, v = (g.ravel() for g in np.meshgrid(np.linspace(0.3, 0.7, 5), np.linspace(0.3, 0.7, 5)))
    tile = read(x0[:, None] + s * length[:, None], y0[:, None] + v * h)
    tt, uu = (g.ravel() for g in np.meshgrid(t, u))
    bed = read(x0[:, None] + tt * length[:, None], y0[:, None] + uu * float(tiling.mortar_y))
    head = read(x0[:, None] + uu * float(tiling.mortar_x), y0[:, None] + tt * h)
    return bed - tile, head - tile, len(tiles)


def list_tiles(tiling: Tiling, width: int, height: int) -> Array:
    """(N, 3): start q_x, length and top q_y of each tile whose start and end lie in the picture."""
    corners = np.array([[0.0, 0.0], [width, 0], [width, height], [0, height]])
    q = np.stack(to_lattice(tiling, corners[:, 0], corners[:, 1]), 1)
    w, h = float(tiling.tile_width), float(tiling.tile_height)
    offsets, rows = np.asarray(tiling.course_offsets), np.asarray(tiling.course_lengths)
    found = []
    for course in range(int(np.floor(q[:, 1].min() / h)), int(np.ceil(q[:, 1].max() / h))):
        lengths = rows[course % len(rows)] * w
        shift = (float(tiling.offset) * course + offsets[course % len(offsets)]) * w
        period = lengths.sum()
        first, last = np.floor((q[:, 0].min() - shift) / period), np.ceil((q[:, 0].max() - shift) / period)
        starts = np.arange(first, last)[:, None] * period + shift + np.cumsum(lengths) - lengths
        for start, length in zip(starts.T, lengths, strict=True):
            found.append(np.stack([start, np.full(len(start), length), np.full(len(start), course * h)], 1))
    tiles = np.concatenate(found)
    x, y = from_lattice(tiling, tiles[:, 0] + tiles[:, 1] / 2, tiles[:, 2] + h / 2)
    return tiles[(x > 0) & (y > 0) & (x < width) & (y < height)]


def to_lattice(tiling: Tiling, x: Array, y: Array) -> tuple[Array, Array]:
    """Image points to lattice coordinates, as :meth:`Tiling.to_lattice`, for arrays on the host."""
    px, py = _project(np.asarray(tiling.homography, float), x, y)
    c, s = np.cos(float(tiling.angle)), np.sin(float(tiling.angle))
    px, py = px - float(tiling.origin[0]), py - float(tiling.origin[1])
    return c * px + s * py, c * py - s * px


def from_lattice(tiling: Tiling, qx: Array, qy: Array) -> tuple[Array, Array]:
    """Lattice coordinates to image points, as :meth:`Tiling.from_lattice`, for arrays on the host."""
    c, s = np.cos(float(tiling.angle)), np.sin(float(tiling.angle))
    px, py = float(tiling.origin[0]) + c * qx - s * qy, float(tiling.origin[1]) + s * qx + c * qy
    return _project(np.linalg.inv(np.asarray(tiling.homography, float)), px, py)


def mean_iou(observed: NDArray[np.bool_], fitted: NDArray[np.bool_]) -> float:
    """Intersection over union of two masks, mean of the class True and the class False."""
    shares = []
    for a, b in ((observed, fitted), (~observed, ~fitted)):
        union = int((a | b).sum())
        shares.append(int((a & b).sum()) / union if union else 1.0)
    return float(np.mean(shares))


def _project(h: Array, x: Array, y: Array) -> tuple[Array, Array]:
    depth = h[2, 0] * x + h[2, 1] * y + h[2, 2]
    return (h[0, 0] * x + h[0, 1] * y + h[0, 2]) / depth, (h[1, 0] * x + h[1, 1] * y + h[1, 2]) / depth
