"""Particles: the things that a picture is made of, one by one, each with the box it fits in.

J.-M. Dischler, K. Maritaud, B. Lévy and D. Ghazanfarpour, "Texture particles" (Eurographics 2002), section 2. Places
are (x, y) in pixels, x right and y down from the picture's upper left corner; its first pixel's centre is (0.5, 0.5).
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.ndimage import find_objects
from scipy.spatial import ConvexHull

_MOST_ON_BORDER = 0.1
"""Of a complete particle's outline, how much may lie on the picture's border at most. Section 2.2: few pixels there
have no consequence that one sees, while a particle that is cut off does."""

_CLEARLY = 0.9  # of the upright box's area: what a leaning one has at most

Labels = npt.NDArray[np.int32]


class Box(NamedTuple):
    """The rectangle that fits a particle best; particles that lean have leaning boxes (section 2.2).

    Attributes:
        x, y: its centre.
        width, height: its sides in pixels, width being the longer one.
        angle: radians by which the width is turned from the picture's rows, clockwise as seen, in (-pi/2, pi/2].
    """

    x: float
    y: float
    width: float
    height: float
    angle: float


class Particle(NamedTuple):
    """A thing of a picture.

    Attributes:
        kind: the number of its class, from 0.
        area: pixels.
        box: where it is.
        complete: whether it is whole, rather than cut off by the picture's border.
    """

    kind: int
    area: int
    box: Box
    complete: bool


class Decomposition(NamedTuple):
    """A picture taken apart.

    Attributes:
        labels: int32 [row, col]: the number of the particle that a pixel belongs to, from 1; 0 is the background.
        particles: the particle with number 1, 2 ...
        kinds: how many classes there are.
    """

    labels: Labels
    particles: tuple[Particle, ...]
    kinds: int


def describe_particles(labels: npt.ArrayLike, kinds: npt.ArrayLike) -> Decomposition:
    """Measure the particles of a label image.

    Args:
        labels: integers [row, col], 0 is the background; numbers may have gaps, and particles several parts.
        kinds: the class of each particle, in the order of their numbers, integers from 0, [particle].

    Raises:
        ValueError: labels that are no such picture, or as many kinds as there are no particles.

    Examples:
        >>> labels = np.zeros((8, 12), int)
        >>> labels[2:5, 3:9] = 7
        >>> found = describe_particles(labels, [0])
        >>> found.particles[0].box
        Box(x=6.0, y=3.5, width=6.0, height=3.0, angle=0.0)
    """
    dense, kinds = _check_labels(labels, kinds)
    particles = []
    for number, (kind, around) in enumerate(zip(kinds, find_objects(dense), strict=True), 1):
        row, column = np.nonzero(dense[around] == number)
        row, column = row + around[0].start, column + around[1].start
        particles.append(Particle(int(kind), len(row), fit_box(row, column), _is_complete(row, column, dense.shape)))
    return Decomposition(dense, tuple(particles), int(max(kinds, default=-1)) + 1)


def fit_box(row: npt.NDArray[np.integer], column: npt.NDArray[np.integer]) -> Box:
    """The smallest rectangle around pixels at (row, column): upright, unless a leaning one is clearly smaller."""
    corners = np.concatenate([np.stack([column + x, row + y], axis=1) for x in (0, 1) for y in (0, 1)])
    hull = corners[ConvexHull(corners).vertices]
    edges = np.diff(np.append(hull, hull[:1], axis=0), axis=0)
    angles = np.append(0.0, np.arctan2(edges[:, 1], edges[:, 0]))
    along = hull @ np.stack([np.cos(angles), np.sin(angles)])
    across = hull @ np.stack([-np.sin(angles), np.cos(angles)])
    areas = np.ptp(along, axis=0) * np.ptp(across, axis=0)
    best = int(np.argmin(areas))
    if areas[best] > _CLEARLY * areas[0]:
        best = 0
    angle, ends = angles[best], [(each[:, best].min(), each[:, best].max()) for each in (along, across)]
    u, v = (0.5 * (low + high) for low, high in ends)
    width, height = (high - low for low, high in ends)
    if width < height:
        width, height, angle = height, width, angle + 0.5 * np.pi
    x, y = (
        u * np.cos(angles[best]) - v * np.sin(angles[best]),
        u * np.sin(angles[best]) + v * np.cos(angles[best]),
    )
    turned = 0.5 * np.pi - (0.5 * np.pi - angle) % np.pi
    return Box(float(x), float(y), float(width), float(height), float(turned))


def _is_complete(row: npt.NDArray[np.integer], column: npt.NDArray[np.integer], shape: tuple[int, ...]) -> bool:
    """Section 2.2: not too many of its pixels are on the border, as a share of what its outline would be as a disc."""
    at_border = (row == 0) | (column == 0) | (row == shape[0] - 1) | (column == shape[1] - 1)
    return bool(at_border.sum() <= _MOST_ON_BORDER * 2 * np.sqrt(np.pi * len(row)))


def _check_labels(labels: npt.ArrayLike, kinds: npt.ArrayLike) -> tuple[Labels, npt.NDArray[np.intp]]:
    """Labels without gaps, and their kinds."""
    given, classes = np.asarray(labels), np.asarray(kinds)
    if given.ndim != 2 or 0 in given.shape or not np.issubdtype(given.dtype, np.integer):
        raise ValueError(f"labels: {given.dtype} of shape {given.shape}; give whole numbers [row, col], not empty")
    if given.min() < 0:
        raise ValueError(f"labels: {given.min()} is below 0; 0 is the background, and particles count from 1")
    numbers = np.unique(given[given > 0])
    if classes.shape != numbers.shape or (classes.size and classes.min() < 0):
        raise ValueError(f"kinds of shape {classes.shape}: give a class from 0 to each of the {len(numbers)} particles")
    dense = np.where(given > 0, np.searchsorted(numbers, given) + 1, 0).astype(np.int32)
    return dense, classes.astype(np.intp)
