"""Triangles seen by a camera: what is nearest in each pixel."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

_AT_ONCE = 1 << 20  # pixels that triangles may cover

Floats = NDArray[np.float64]


class View(NamedTuple):
    """From where to where one looks, and the focal length in units of half the picture's height. y is up."""

    eye: Floats
    target: Floats
    lens: float


class Seen(NamedTuple):
    """Of each pixel, [row, col].

    Attributes:
        face: number of the triangle that is nearest, -1 where there is none.
        share: of its three corners, [row, col, 3].
        away: distance along the view, infinite where there is nothing.
    """

    face: NDArray[np.int64]
    share: Floats
    away: Floats


def look_at(view: View) -> Floats:
    """Rows: the camera's right, up and forward."""
    ahead = (view.target - view.eye) / np.linalg.norm(view.target - view.eye)
    right = np.cross(ahead, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(right, ahead), ahead])


def project(points: Floats, view: View, size: tuple[int, int]) -> tuple[Floats, Floats]:
    """Where points [..., 3] lie on a picture of a width and a height, in pixels from its upper left corner [..., 2],
    and how far away along the view."""
    seen = (points - view.eye) @ look_at(view).T
    focal = 0.5 * view.lens * size[1]
    return 0.5 * np.array(size) + focal * seen[..., :2] / seen[..., 2:] * [1, -1], seen[..., 2]


def rasterise(vertices: Floats, faces: NDArray[np.int64], view: View, size: tuple[int, int]) -> Seen:
    """The nearest triangle in each pixel of a picture of a width and a height, whichever side it shows.

    Args:
        vertices: [vertex, 3].
        faces: [face, 3]; what is not wholly before the camera is left out.
    """
    columns, rows = size
    pixels, away = project(vertices, view, size)
    homogeneous = np.append(pixels, np.ones((len(pixels), 1)), axis=1)[faces]
    is_seen = (away[faces] > 0).all(axis=1) & (np.abs(np.linalg.det(homogeneous)) > 1e-12)
    numbers, homogeneous, distance = np.flatnonzero(is_seen), homogeneous[is_seen], away[faces[is_seen]]
    to_share = np.linalg.inv(homogeneous)
    low, high = (
        np.clip(limit, 0, size).astype(int)
        for limit in (np.floor(homogeneous.min(axis=1))[:, :2], np.ceil(homogeneous.max(axis=1))[:, :2])
    )
    covered = np.prod(high - low, axis=1)
    nearness, face, share = np.zeros(rows * columns), np.full(rows * columns, -1), np.zeros((rows * columns, 3))
    ends = np.searchsorted(np.cumsum(covered), np.arange(_AT_ONCE, covered.sum() + _AT_ONCE, _AT_ONCE))
    for part in np.split(np.arange(len(numbers)), np.unique(ends)):
        which = np.repeat(part, covered[part])
        within = np.arange(len(which)) - np.repeat(np.cumsum(covered[part]) - covered[part], covered[part])
        row, column = np.divmod(within, np.maximum(high - low, 1)[which, 0]) + low[which].T[::-1]
        at = np.stack([column + 0.5, row + 0.5, np.ones(len(which))], axis=1)
        here = np.einsum("pj,pjk->pk", at, to_share[which])
        # What is linear in space is linear on the picture once divided by the distance.
        here_near = (here / distance[which]).sum(axis=1)
        place = row * columns + column
        drawn = np.flatnonzero((here >= 0).all(axis=1) & (here_near > nearness[place]))
        drawn = drawn[np.argsort(here_near[drawn])]  # the nearest is written last
        place, which = place[drawn], which[drawn]
        nearness[place], face[place] = here_near[drawn], numbers[which]
        share[place] = here[drawn] / distance[which] / here_near[drawn, None]
    with np.errstate(divide="ignore"):
        return Seen(face.reshape(rows, columns), share.reshape(rows, columns, 3), (1 / nearness).reshape(rows, columns))


def average_samples(picture: Floats, samples: int) -> NDArray[np.float32]:
    """A picture [row, col, channel] that was drawn so many times as large, at its own size and within 0 to 1."""
    rows, columns, channels = picture.shape
    blocks = picture.reshape(rows // samples, samples, columns // samples, samples, channels)
    return np.clip(blocks.mean(axis=(1, 3)), 0, 1).astype(np.float32)
