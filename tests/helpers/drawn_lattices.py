"""Label images of discs and bricks in known arrangements, and how regular placed particles are."""

import numpy as np
from scipy.spatial import cKDTree

from jaxtex.particles.things import Decomposition, describe_particles


def lattice(first: tuple[float, float], second: tuple[float, float], size: tuple[int, int]) -> np.ndarray:
    """All points of a lattice that are less than 60 pixels outside of a picture, [point, (x, y)]."""
    most = 60 + max(size)
    count = int(most / min(np.hypot(*first), np.hypot(*second))) * 2
    i, j = np.mgrid[-count : count + 1, -count : count + 1]
    points = i.reshape(-1, 1) * np.array(first)[None] + j.reshape(-1, 1) * np.array(second)[None] + 7.3
    return points[((points > -60) & (points < np.array(size)[None] + 60)).all(axis=1)]


def poisson_disc(size: tuple[int, int], apart: float, rng: np.random.Generator) -> np.ndarray:
    """Points that keep a distance, as many as find room, [point, (x, y)]."""
    points: list[np.ndarray] = []
    for point in rng.uniform(-30, np.array(size) + 30, (20000, 2)):
        if all(np.hypot(*(point - other)) >= apart for other in points):
            points.append(point)
    return np.array(points)


def draw_things(points: np.ndarray, size: tuple[int, int], width: float, height: float, angle: float = 0.0, round_: bool = True) -> Decomposition:
    """The label image of discs or bricks of one class."""
    row, column = np.indices(size[::-1]) + 0.5
    labels = np.zeros(size[::-1], int)
    for number, (x, y) in enumerate(points, 1):
        along = 2 / width * ((column - x) * np.cos(angle) + (row - y) * np.sin(angle))
        across = 2 / height * ((row - y) * np.cos(angle) - (column - x) * np.sin(angle))
        inside = along**2 + across**2 < 1 if round_ else (np.abs(along) < 1) & (np.abs(across) < 1)
        labels[inside] = number
    return describe_particles(labels, np.zeros(len(np.unique(labels[labels > 0])), int))
