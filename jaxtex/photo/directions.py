"""Which way the grain runs, place by place, and the map whose levels follow it.

The structure tensor tells the direction in which a picture changes most; in wood that is across the grain. Directions
have no sense, so they are kept as complex numbers of twice their angle. At the scale of fibres they show the axis of
the trunk, at the scale of rings which way these bend.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, sparse
from scipy.sparse.linalg import spsolve

Array = NDArray[np.float64]

_NODES = 96  # along the picture's longer side, of the map that follows the grain
_FOUR_CORNERS = 4
_STIFF = 0.03  # how much the map resists bending, where the picture's own directions weigh 1
_GLARE = 1.5  # times the typical gradient nearby: stronger edges weigh no more
_DENSE = 8.0  # pixels of reach, up to which every pixel along the grain is looked at; over more, as many
_ASTRAY = np.radians(50)  # from the grain: what runs so is no grain, but a knot, a crack, a joint
_ACROSS = np.radians(65)


class Directions(NamedTuple):
    """``across`` (H, W), complex: the direction of steepest change at twice its angle, as long as it is clear;
    ``energy`` (H, W): how steep, squared."""

    across: NDArray[np.complex128]
    energy: Array


def measure_directions(light: Array, scale: float, *, reach: float | None = None) -> Directions:
    """Directions in a picture (H, W), seen through a spot of standard deviation ``scale`` pixels, and averaged over
    one of ``reach``, by default three times as wide."""
    across = ndimage.gaussian_filter(light, scale, order=(0, 1)) + 1j * ndimage.gaussian_filter(
        light, scale, order=(1, 0)
    )
    square, reach = across**2, 3 * scale if reach is None else reach
    mean = ndimage.gaussian_filter(square.real, reach) + 1j * ndimage.gaussian_filter(square.imag, reach)
    return Directions(mean, ndimage.gaussian_filter(np.abs(square), reach) + 1e-12)


def main_direction(directions: Directions) -> tuple[float, float]:
    """Across the grain of the whole picture, radians in [0, pi), and how clearly all of it runs so, 0 to 1."""
    whole = directions.across.sum()
    turn = float(np.angle(whole) / 2 % np.pi)
    # A hair below zero is, rounded, a half turn.
    return turn if turn < np.pi else 0.0, float(np.abs(whole) / directions.energy.sum())


def directions_of(rings: Array) -> Directions:
    """The directions that a map of rings (H, W) would have everywhere."""
    down, right = np.gradient(rings)
    return Directions(np.exp(2j * np.arctan2(down, right)), np.ones(rings.shape))


def smooth_along(light: Array, directions: Directions, reach: float, *, at: Array | None = None) -> Array:
    """A picture (H, W) averaged along its grain: each pixel over a Gaussian of ``reach`` pixels on either side of it.

    Line integral convolution (Cabral & Leedom 1993) along the measured directions; of the whole picture, or ``at`` some
    places of it (2, ...), rows and columns.
    """
    angle = np.angle(directions.across) / 2 + np.pi / 2
    along = np.stack([np.sin(angle), np.cos(angle)])
    start = np.indices(light.shape).astype(float) if at is None else at
    total = ndimage.map_coordinates(light, start, order=1, mode="nearest")
    weights = np.ones_like(total)
    pace = max(1, int(reach / _DENSE))
    for sense in (1.0, -1.0):
        place, heading = start.copy(), sense * _nearest(along, start)
        for step in range(pace, int(2 * reach) + 1, pace):
            place += pace * heading
            ahead = _nearest(along, place)
            heading = np.where((ahead * heading).sum(0) < 0, -ahead, ahead)
            inside = ((place >= 0) & (place <= _last(light, place))).all(0)
            weight = inside * np.exp(-0.5 * (step / reach) ** 2)
            total += weight * ndimage.map_coordinates(light, place, order=1, mode="nearest")
            weights += weight
    return total / weights


def _last(light: Array, place: Array) -> Array:
    return np.array(light.shape, float).reshape(2, *[1] * (place.ndim - 1)) - 1


def _nearest(along: Array, place: Array) -> Array:
    """Headings (2, ...) at the pixels nearest to places (2, ...)."""
    row, column = (np.clip(np.rint(p).astype(int), 0, n - 1) for p, n in zip(place, along.shape[1:], strict=True))
    return along[:, row, column]


def follow_grain(directions: Directions, rings: Array, *, clear: NDArray[np.bool_] | None = None) -> Array:
    """The map (H, W) nearest to a guess at the rings whose levels run along the grain where that is ``clear``.

    The guess, in pixels across the grain, is displaced by a smooth map that makes its slope along the measured grain
    vanish: linear least squares, with a stiffness where the picture tells nothing.
    """
    height, width = rings.shape
    spacing = max(4, max(height, width) // _NODES)
    shape = height // spacing + 1, width // spacing + 1
    rows, columns = ((np.arange(n - 1) * spacing + spacing // 2) for n in shape)
    at = np.ix_(rows, columns)
    angle = np.angle(directions.across) / 2 + np.pi / 2
    x, y = np.cos(angle)[at].ravel(), np.sin(angle)[at].ravel()
    weight = weigh_directions(directions) if clear is None else weigh_directions(directions) * clear
    weight = weight[at].ravel()
    down, right = (np.asarray(slope)[at].ravel() for slope in np.gradient(rings))
    d_right, d_down = difference_matrices(shape, spacing)
    slopes = sparse.diags_array(weight * x) @ d_right + sparse.diags_array(weight * y) @ d_down
    stiff = _STIFF * (d_right.T @ d_right + d_down.T @ d_down) + 1e-8 * sparse.eye_array(shape[0] * shape[1])
    off = spsolve((slopes.T @ slopes + stiff).tocsc(), -slopes.T @ (weight * (x * right + y * down))).reshape(shape)
    place = (np.indices(rings.shape) + 0.5) / spacing
    return rings + ndimage.map_coordinates(off - off.mean(), place, order=1, mode="nearest")


def compare_directions(directions: Directions, rings: Array) -> tuple[float, float, NDArray[np.bool_]]:
    """How well a map of rings (H, W) runs along the grain: 1 where all edges follow it, 0 where there is no grain; how
    much of what is seen runs across instead, 0 to 1; and where it does not run astray (H, W)."""
    turned = directions.across * np.conj(directions_of(rings).across)
    aside, length = np.abs(np.angle(turned)) / 2, np.abs(turned)
    # One strong edge, such as a crack, counts as no more than its neighbours do.
    fair = np.minimum(directions.energy, 8 * np.median(directions.energy)) / directions.energy
    agreement = float((turned.real * fair).sum() / (directions.energy * fair).sum())
    crossing = float((length * fair)[aside > _ACROSS].sum() / max(float((length * fair).sum()), 1e-12))
    strong = length > np.median(length)
    return agreement, crossing, ~(strong & (aside > _ASTRAY))


def weigh_directions(directions: Directions) -> Array:
    """How much each place (H, W) tells: by how clear its direction is, and how strong for its neighbourhood."""
    near = ndimage.gaussian_filter(directions.energy, max(directions.energy.shape) / 10, truncate=2.0)
    strength = np.minimum(np.sqrt(directions.energy / near), _GLARE)
    return np.abs(directions.across) / directions.energy * strength


def difference_matrices(shape: tuple[int, int], spacing: int) -> tuple[sparse.csr_array, sparse.csr_array]:
    """Slopes to the right and down in the middle of each cell of a grid of nodes, as matrices (cells, nodes)."""
    node = np.arange(shape[0] * shape[1]).reshape(shape)
    corners = np.stack([node[:-1, :-1], node[:-1, 1:], node[1:, :-1], node[1:, 1:]], axis=-1).reshape(-1, _FOUR_CORNERS)
    cell = np.repeat(np.arange(len(corners)), _FOUR_CORNERS)
    return tuple(
        sparse.csr_array((np.tile(np.array(signs) / (2 * spacing), len(corners)), (cell, corners.ravel())))
        for signs in ([-1, 1, -1, 1], [-1, -1, 1, 1])
    )
