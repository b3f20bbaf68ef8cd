"""Label images of discs and bricks in known arrangements, and how closely placed particles keep to one."""

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from jaxtex.particles.things import Decomposition, describe_particles

Vector = tuple[float, float]


def lattice(first: Vector, second: Vector, size: tuple[int, int]) -> np.ndarray:
    """All points of a lattice on a picture and up to 60 pixels outside of it, [point, (x, y)]."""
    count = int((60 + max(size)) / min(np.hypot(*first), np.hypot(*second))) * 2
    i, j = np.mgrid[-count : count + 1, -count : count + 1]
    points = i.reshape(-1, 1) * np.array(first)[None] + j.reshape(-1, 1) * np.array(second)[None] + 7.3
    return points[((points > -60) & (points < np.array(size)[None] + 60)).all(axis=1)]


def turn(vectors: Sequence[Vector], degrees: float) -> list[Vector]:
    """Vectors turned clockwise as seen."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return [(x * c - y * s, x * s + y * c) for x, y in vectors]


def poisson_disc(size: tuple[int, int], apart: float, rng: np.random.Generator) -> np.ndarray:
    """Points at random that keep a distance, as many as find room, [point, (x, y)]."""
    points = np.full((1, 2), -1000.0)
    for point in rng.uniform(-30, np.array(size) + 30, (8000, 2)):
        if (np.hypot(*(points - point[None]).T) >= apart).all():
            points = np.append(points, point[None], axis=0)
    return points[1:]


def draw_things(
    points: np.ndarray,
    size: tuple[int, int],
    *,
    width: float,
    height: float,
    angles: float | np.ndarray = 0.0,
    discs: bool = False,
) -> Decomposition:
    """The label image of bricks, or of discs, of one class; angles in degrees."""
    row, column = np.indices(size[::-1]) + 0.5
    labels = np.zeros(size[::-1], int)
    for number, ((x, y), angle) in enumerate(zip(points, np.broadcast_to(angles, len(points)), strict=True), 1):
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        along, across = (column - x) * c + (row - y) * s, (row - y) * c - (column - x) * s
        u, v = np.abs(along) / (0.5 * width), np.abs(across) / (0.5 * height)
        labels[(u**2 + v**2 < 1) if discs else (u < 1) & (v < 1)] = number
    return describe_particles(labels, np.zeros(len(np.unique(labels[labels > 0])), int))


def measure_lattice(points: np.ndarray, vectors: Sequence[Vector], size: tuple[int, int]) -> tuple[float, float, float]:
    """How well points keep to a lattice, away from the border.

    Returns:
        By how many degrees neighbours' mean direction is off, by what share their mean distance is, for the worst of
        the vectors; and how many neighbours are more than 0.3 of the spacing from where they should be, as a share.
    """
    tree, least = cKDTree(points), min(np.hypot(*vector) for vector in vectors)
    inner = points[((points > 60) & (points < np.array(size)[None] - 60)).all(axis=1)]
    turned, stretched, missing = [], [], []
    for vector in vectors:
        distance, index = tree.query(inner + np.array(vector)[None])
        near = distance < 0.3 * least
        way = (points[index] - inner)[near] @ np.array([1, 1j]) / complex(*vector)
        turned.append(abs(np.degrees(np.angle(way.mean()))))
        stretched.append(abs(np.abs(way).mean() - 1))
        missing.append(1 - near.mean())
    return max(turned), max(stretched), float(np.mean(missing))


def nearest_distances(points: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """From each point that is not at the border to its nearest one."""
    inner = points[((points > 30) & (points < np.array(size)[None] - 30)).all(axis=1)]
    return cKDTree(points).query(inner, 2)[0][:, 1]
