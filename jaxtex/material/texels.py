"""The texels of a picture that triangles lie in: which triangle each shows, where it lies on it, and what stands beside
charts."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from jaxtex.material.carving import areas_of

Floats = npt.NDArray[np.float64]

REACH = 1.5
"""Texels: how far from its triangles a chart goes on. Bilinear filters read up to sqrt 2 beyond."""

_AT_ONCE = 1 << 18  # pairs of a texel and a triangle
_FLAT = 1e-9  # texels: triangles of less than this area have no inside


class Places(NamedTuple):
    """Where texels lie on triangles, as weights [texel, 3] of their corners.

    Attributes:
        nearest: the nearest point of the triangle: the texel's own centre where that is inside.
        own: the centre itself, beyond the triangle where the weights are not in 0 to 1.
        beyond: [texel], how far the centre is from the nearest point, in texels.
    """

    nearest: Floats
    own: Floats
    beyond: Floats


class Found(NamedTuple):
    """Which triangle each texel shows, as far as is known.

    Attributes:
        faces: [row, col], numbers of triangles, -1 where none is; filled in from one to the next.
        done: the share of the work, 0 to 1.
    """

    faces: npt.NDArray[np.int32]
    done: float


def find_faces(corners: Floats, side: int) -> Iterator[Found]:
    """Which triangle each texel of a square picture shows: the one its centre lies in, or else the nearest one, if that
    is within `REACH`.

    Args:
        corners: [face, 3, 2], (x, y) in texels.
        side: of the picture.

    Yields:
        What is known, again and again; the last, with `done` 1, is the result.

    Examples:
        >>> *_, (faces, _) = find_faces(np.array([[[3.0, 3], [9, 3], [3, 9]]]), 12)
        >>> faces[5, 5].item(), faces[3, 2].item(), faces[11, 11].item()
        (0, 0, -1)
    """
    best = np.full(side * side, np.inf, np.float32)
    owner = np.full(side * side, -1, np.int32)
    whole = np.flatnonzero(areas_of(corners) > _FLAT)
    low = np.clip(np.floor(corners[whole].min(axis=1) - REACH), 0, side - 1).astype(np.int64)
    high = np.clip(np.ceil(corners[whole].max(axis=1) + REACH), 1, side).astype(np.int64)
    extent = high - low
    ends = np.cumsum(extent.prod(axis=1))
    total = int(ends[-1]) if len(ends) else 0
    for first in range(0, total, _AT_ONCE):
        end = min(first + _AT_ONCE, total)
        pair = np.arange(first, end)
        which = np.searchsorted(ends, pair, side="right")
        row, column = np.divmod(pair - (ends[which] - extent[which].prod(axis=1)), extent[which, 0])
        column, row = column + low[which, 0], row + low[which, 1]
        centres = np.stack([column, row], axis=1) + 0.5
        near = _may_be_near(centres, corners[whole[which]])
        face, texel = whole[which[near]], (row * side + column)[near]
        beyond = locate(centres[near], corners[face]).beyond.astype(np.float32)
        close = beyond <= REACH
        face, texel, beyond = face[close], texel[close], beyond[close]
        np.minimum.at(best, texel, beyond)
        wins = beyond == best[texel]
        owner[texel[wins]] = face[wins]
        yield Found(owner.reshape(side, side), end / total)
    if not total:
        yield Found(owner.reshape(side, side), 1.0)


def locate(points: Floats, corners: Floats) -> Places:
    """Where points [point, 2] lie on triangles [point, 3, 2] that have an area."""
    edges = np.roll(corners, -1, axis=1) - corners
    offsets = points[:, None] - corners
    # Twice the areas that the point makes with each edge, by the triangle's: weights of the corners opposite.
    shares = (edges[..., 0] * offsets[..., 1] - edges[..., 1] * offsets[..., 0]) / _signed_area(corners)[:, None]
    own = np.roll(shares, -1, axis=1)
    lengths = np.maximum(np.square(edges).sum(axis=-1), 1e-300)
    along = np.clip((offsets * edges).sum(axis=-1) / lengths, 0, 1)
    squares = np.square(offsets - along[..., None] * edges).sum(axis=-1)
    edge = squares.argmin(axis=1)[:, None]
    part = np.take_along_axis(along, edge, axis=1)
    nearest = np.zeros_like(own)
    np.put_along_axis(nearest, edge, 1 - part, axis=1)
    np.put_along_axis(nearest, (edge + 1) % 3, part, axis=1)
    inside = own.min(axis=1) >= 0
    beyond = np.where(inside, 0.0, np.sqrt(squares.min(axis=1)))
    return Places(np.where(inside[:, None], own, nearest), own, beyond)


def spread_colours(picture: npt.NDArray[np.float32], covered: npt.NDArray[np.bool_]) -> npt.NDArray[np.float32]:
    """Fill the texels that show nothing, so that mipmaps have no seams: each has the mean of what is covered in the
    smallest square of 2, 4, 8 ... texels around it that shows something (push and pull: S. Gortler and others, "The
    Lumigraph", 1996, section 3.4, without their smoothing).

    A texel of a mipmap is then the mean of the covered ones below it, whatever the chart's border does there.

    Args:
        picture: [row, col, channel], square.
        covered: [row, col].

    Returns:
        [row, col, channel]; covered texels as they are.

    Examples:
        >>> spread_colours(np.array([[[1.0], [0]], [[0], [0]]], np.float32), np.array([[1, 0], [0, 0]], bool))[1, 1]
        array([1.], dtype=float32)
    """
    if covered.all() or len(picture) == 1:
        return picture
    odd = len(picture) % 2
    even = np.pad(picture * covered[..., None], ((0, odd), (0, odd), (0, 0)))
    counted = np.pad(covered, ((0, odd), (0, odd)))
    half = len(even) // 2
    sums = even.reshape(half, 2, half, 2, -1).sum(axis=(1, 3))
    counts = counted.reshape(half, 2, half, 2).sum(axis=(1, 3))
    above = spread_colours(sums / np.maximum(counts, 1)[..., None].astype(np.float32), counts > 0)
    around = above.repeat(2, axis=0).repeat(2, axis=1)[: len(picture), : len(picture)]
    return np.where(covered[..., None], picture, around)


def _may_be_near(points: Floats, corners: Floats) -> npt.NDArray[np.bool_]:
    """False where a point is further than `REACH` beyond the line of an edge, which is cheaper to tell."""
    edges = np.roll(corners, -1, axis=1) - corners
    offsets = points[:, None] - corners
    inwards = np.sign(_signed_area(corners))[:, None] * (
        edges[..., 0] * offsets[..., 1] - edges[..., 1] * offsets[..., 0]
    )
    return (inwards >= -REACH * np.sqrt(np.square(edges).sum(axis=-1))).all(axis=1)


def _signed_area(corners: Floats) -> Floats:
    """Twice the area of triangles, positive where they turn from x towards y."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
