"""Is it a tiling at all? Every joint that the fit predicts is looked up in the mask."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from jaxtex.models.tiling import Tiling

Array = NDArray[np.float64]

# Contrast, of a perfect 1, that half of the predicted joints must have. Heads are shorter and often shallower.
_BEDS_SEEN, _HEADS_SEEN = 0.42, 0.17
_FEWEST_TILES = 4
_MOST_SPLIT = 0.6  # of the longest tiles, with a joint in their middle
_SEEN = 3.0  # pixels: tiles smaller than this, far off in an oblique view, show nothing
_MOST_TILES = 200_000
_HORIZON = 0.05  # depth, that of the middle being 1, beyond which the plane is not looked at
_ASTRAY = 0.12  # thinnest band, in tiles, in which a joint is looked for when counting


class Verdict(NamedTuple):
    """``ok`` and the ``reason``; ``beds`` and ``heads``: median contrast between a predicted joint of
    either kind and the tiles beside it, on the mask's scale of 0 to 1; ``tiles``: how many were looked at."""

    ok: bool
    reason: str
    beds: float
    heads: float
    tiles: int


def judge_fit(tiling: Tiling, joint: NDArray[np.float32]) -> Verdict:
    """Judge a tiling in the pixels of a map of joints (H, W)."""
    beds, heads, tiles = measure_joints(tiling, joint)
    bed, head = (float(np.nanmedian(each)) if np.isfinite(each).any() else 0.0 for each in (beds, heads))
    _, split = find_wrong_sizes(tiling, joint)
    reason = _find_fault(bed, head, tiles, split)
    return Verdict(not reason, reason, bed, head, tiles)


def _find_fault(beds: float, heads: float, tiles: int, split: float) -> str:
    if tiles < _FEWEST_TILES:
        return f"only {tiles} whole tiles would lie in the picture: too few to tell a tiling from chance"
    if beds < _BEDS_SEEN:
        return f"joints between courses are not where they should be (contrast {beds:.2f}, {_BEDS_SEEN} needed)"
    if heads < _HEADS_SEEN:
        return f"joints between tiles of a course are not there (contrast {heads:.2f}, {_HEADS_SEEN} needed)"
    if split > _MOST_SPLIT:
        return f"{split:.0%} of the tiles would have a joint in their middle"
    return ""


def measure_joints(tiling: Tiling, joint: NDArray[np.float32]) -> tuple[Array, Array, int]:
    """Contrast of every predicted bed and head joint of the tiles inside the map (H, W) against the tiles beside."""
    read, tiles = _reader(tiling, joint)
    along, band = np.linspace(0.2, 0.8, 9), np.linspace(-0.35, 0.35, 5)
    tile = read(np.linspace(0.3, 0.7, 5), np.linspace(0.3, 0.7, 5), 0.0, 0.0)
    bed = read(along, np.zeros(1), 0.0, band * float(tiling.mortar_y))
    head = read(np.zeros(1), along, band * float(tiling.mortar_x), 0.0)
    return bed - tile, head - tile, tiles


def find_wrong_sizes(tiling: Tiling, joint: NDArray[np.float32]) -> tuple[float, float]:
    """Share of the predicted joints, bed or head, that are missing; and of the longest tiles that are split in the
    middle, along or across."""
    lengths = list_tiles(tiling, joint.shape[1], joint.shape[0])[:, 1]
    longest = lengths > 0.99 * lengths.max(initial=0.0)
    read, _ = _reader(tiling, joint)
    some, band = np.linspace(0.2, 0.8, 9), np.linspace(-0.35, 0.35, 5)
    # Joints laid by hand stray from where they should be, whatever their thickness.
    shortest = float(tiling.tile_width * np.min(tiling.course_lengths)), float(tiling.tile_height)
    band_x = band * max(float(tiling.mortar_x), _ASTRAY * shortest[0])
    band_y = band * max(float(tiling.mortar_y), _ASTRAY * shortest[1])
    beside = read(np.array([0.25, 0.75]), some, 0.0, 0.0)
    head = read(np.zeros(1), some, band_x, 0.0) - beside
    bed = read(some, np.zeros(1), 0.0, band_y) - beside
    half = np.array([0.5])
    along = (read(half, some, band_x, 0.0) - beside)[longest]
    across = (read(np.array([0.35, 0.65]), half, 0.0, band_y) - beside)[longest]
    head, bed, along, across = (each[np.isfinite(each)] for each in (head, bed, along, across))
    if not (len(head) and len(bed) and len(along) and len(across)):
        return 1.0, 0.0
    # Faint joints count as seen: on one wall some may be wide and others hairlines.
    seen_head, seen_bed = (0.3 * max(float(np.quantile(each, 0.85)), 0.1) for each in (head, bed))
    missing = max(float(np.mean(head < seen_head)), float(np.mean(bed < seen_bed)))
    return missing, max(float(np.mean(along > seen_head)), float(np.mean(across > seen_bed)))


def _reader(tiling: Tiling, joint: NDArray[np.float32]) -> tuple[Callable[..., Array], int]:
    """A function that averages the map over the same places in every tile, and the number of tiles.

    Places are all pairs of shares of a tile's length and of its height, shifted by all of the given pixels.
    """
    height, width = joint.shape
    pitch = float(min(tiling.tile_width * np.min(tiling.course_lengths), tiling.tile_height))
    # Not so much that thin joints fade.
    thinnest = float(min(tiling.mortar_x, tiling.mortar_y))
    smooth = ndimage.gaussian_filter(joint, min(0.03 * pitch, max(0.3 * thinnest, 0.5)))
    start, length, top = list_tiles(tiling, width, height).T[:, :, None, None]

    def read(along: Array, down: Array, shift_x: Array | float, shift_y: Array | float) -> Array:
        qx = start + along[:, None] * length + np.atleast_1d(shift_x)
        qy = top + down[:, None] * float(tiling.tile_height) + np.atleast_1d(shift_y)
        qx = qx.reshape(len(start), along.size * np.size(shift_x))
        qy = qy.reshape(len(start), down.size * np.size(shift_y))
        qx, qy = np.repeat(qx, qy.shape[1], axis=1), np.tile(qy, (1, qx.shape[1]))
        x, y = from_lattice(tiling, qx, qy)
        values = ndimage.map_coordinates(smooth, [y - 0.5, x - 0.5], order=1, mode="constant", cval=np.nan)
        # Places outside the picture tell nothing; a tile with none inside is left out by its NaN.
        seen = np.isfinite(values)
        total = np.where(seen, values, 0.0).sum(1)
        return np.where(seen.any(1), total / np.maximum(seen.sum(1), 1), np.nan)

    return read, len(start)


def list_tiles(tiling: Tiling, width: int, height: int) -> Array:
    """(N, 3): start q_x, length and top q_y of each tile whose middle lies in the picture, large enough to be seen.

    None where the view is so oblique, or the tiles so small, that nobody could count them.
    """
    q = _visible_border(tiling, width, height)
    w, h = float(tiling.tile_width), float(tiling.tile_height)
    if np.ptp(q[:, 0]) * np.ptp(q[:, 1]) > _MOST_TILES * w * h * float(np.min(tiling.course_lengths)):
        return np.zeros((0, 3))
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
    middle = tiles[:, 0] + tiles[:, 1] / 2, tiles[:, 2] + h / 2
    x, y = from_lattice(tiling, *middle)
    ends = [from_lattice(tiling, middle[0] + dx, middle[1] + dy) for dx, dy in ((tiles[:, 1], 0.0), (0.0, h))]
    sizes = [np.hypot(end_x - x, end_y - y) for end_x, end_y in ends]
    inside = (x > 0) & (y > 0) & (x < width) & (y < height)
    return tiles[inside & (np.minimum(*sizes) > _SEEN)]


def _visible_border(tiling: Tiling, width: int, height: int) -> Array:
    """Lattice coordinates (N, 2) of the picture's border, as far as it lies well before the horizon."""
    along = np.linspace(0.0, 1.0, 65)
    x = np.concatenate([along, along, np.zeros(65), np.ones(65)]) * width
    y = np.concatenate([np.zeros(65), np.ones(65), along, along]) * height
    row = np.asarray(tiling.homography, float)[2]
    depth = (row[0] * x + row[1] * y + row[2]) / (row[0] * width / 2 + row[1] * height / 2 + row[2])
    return np.stack(to_lattice(tiling, x[depth > _HORIZON], y[depth > _HORIZON]), 1)


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
