"""Pictures of things, drawn, so that each pixel's thing is known: stones in mortar, heaps, spots on a ground.

All are square, linear light [row, col, channel] from 0 to 1, with labels [row, col], 0 being the ground.
"""

from collections.abc import Iterator

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

SIDE = 256
Scene = tuple[np.ndarray, np.ndarray]


def draw_scenes(seed: int, count: int) -> Iterator[tuple[str, Scene]]:
    """So many pictures of each sort, named, of things of various sizes; another seed gives others."""
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        yield f"mortar {number}", draw_mortar(rng, spacing=rng.uniform(22, 62), alike=rng.uniform(0, 1))
        yield f"heap {number}", draw_heap(rng, radius=rng.uniform(8, 28), corners=0)
        yield f"gravel {number}", draw_heap(rng, radius=rng.uniform(9, 24), corners=int(rng.integers(5, 8)))
        yield f"spots {number}", draw_spots(rng, radius=rng.uniform(5, 14))


def draw_mortar(rng: np.random.Generator, spacing: float, alike: float) -> Scene:
    """Stones, rough and smooth ones, in mortar that is of their mean colour, the more alike the harder to tell."""
    gap = spacing * rng.uniform(0.1, 0.28)
    middles = _scatter(rng, SIDE + 2 * spacing, 0.8 * spacing) - spacing
    places = np.moveaxis(np.indices((SIDE, SIDE)) + 0.5, 0, 2)
    places = places + 0.04 * spacing * np.stack([_noise(rng, spacing / 4) for _ in range(2)], axis=2)
    _, nearest = cKDTree(middles).query(places, 3)
    first, *others = (middles[nearest[..., i]] for i in range(3))
    reach = [_reach(places, first, other) for other in others]
    inside = -gap * np.log(sum(np.exp(-each / gap) for each in reach)) > 0.3 * gap
    stone = nearest[..., 0]
    ground = np.array([0.30, 0.27, 0.23]) * rng.uniform(0.4, 1.4)
    tint = rng.normal(0, 0.12 + 0.35 * (1 - alike), (len(middles), 1)) + rng.normal(0, 0.1, (len(middles), 3))
    rough, fine = rng.uniform(0.03, 0.35, len(middles))[stone], _noise(rng, rng.uniform(0.7, 1.5))
    depth = ndimage.distance_transform_edt(inside)
    bulge = np.gradient(ndimage.gaussian_filter(np.minimum(depth, spacing / 4), 2))
    shade = (1 - 0.35 * np.exp(-depth / 3)) * (1 - 0.25 * bulge[0] - 0.1 * bulge[1])
    stones = (ground * np.exp(tint))[stone] * (np.exp(rough * fine + 0.1 * _noise(rng, spacing / 5)) * shade)[..., None]
    deep = np.exp(-ndimage.distance_transform_edt(~inside) / 2)
    mortar = ground * np.exp(0.05 * fine + 0.05 * _noise(rng, 4) + 0.1 * _noise(rng, spacing) - 0.3 * deep)[..., None]
    return _finish(rng, np.where(inside[..., None], stones, mortar), np.where(inside, stone + 1, 0))


def draw_heap(rng: np.random.Generator, radius: float, corners: int) -> Scene:
    """Ellipses, or things of so many corners, one upon the other, light and dark, shaded, veined, with shadows."""
    grey, dark = rng.random() < 0.4, rng.uniform(0.1, 0.6)
    pixels = 0.01 * np.exp(0.2 * _noise(rng, 2))[..., None] * np.ones(3)
    labels = np.zeros((SIDE, SIDE), int)
    for number in range(1, int(1.1 * SIDE**2 / radius**2)):
        x, y, size = *rng.uniform(-radius, SIDE + radius, 2), radius * np.exp(rng.normal(0, 0.3))
        along, across, turn = _own_frame(rng, x, y, size, 0.55 if corners == 0 else 0.7)
        edge, shade = _shape(rng, along, across, turn, corners)
        inside = edge < 1
        pixels *= 1 - 0.75 * (np.exp(-np.maximum(edge - 1, 0) * size / 4) * ~inside)[..., None]
        light = 0.25 * np.exp(rng.normal(0, 0.5)) * (0.25 if rng.random() < dark else 1)
        colour = light * (1 if grey else np.exp(rng.normal(0, 0.25, 3)) * (1.2, 1, 0.75)) * np.ones(3)
        pattern = rng.uniform(0.02, 0.2) * _noise(rng, 1) + rng.uniform(0, 0.35) * _noise(rng, size / 4)
        if rng.random() < 0.3:  # a vein or a slit
            pattern += rng.choice([-0.7, 0.4]) * (np.abs(across - rng.uniform(-0.3, 0.3)) < rng.uniform(0.04, 0.12))
        pixels[inside] = (colour * (shade * np.exp(pattern))[..., None])[inside]
        labels[inside] = number
    return _finish(rng, pixels, _keep_visible(labels, 0.08 * np.pi * radius**2))


def draw_spots(rng: np.random.Generator, radius: float) -> Scene:
    """Discs apart from each other on a mottled ground."""
    ground = np.array([0.5, 0.45, 0.35]) * rng.uniform(0.1, 1.2)
    pixels = ground * np.exp(rng.uniform(0.02, 0.15) * _noise(rng, 1.5) + 0.1 * _noise(rng, 10))[..., None]
    labels = np.zeros((SIDE, SIDE), int)
    y, x = np.indices((SIDE, SIDE)) + 0.5
    for number, middle in enumerate(_scatter(rng, SIDE, radius * rng.uniform(2.5, 4)), 1):
        inside = np.hypot(y - middle[0], x - middle[1]) < radius * rng.uniform(0.7, 1.2)
        colour = ground * rng.choice([0.2, 0.5, 2.0]) * np.exp(rng.normal(0, 0.3, 3))
        pixels[inside] = (colour * np.exp(0.1 * _noise(rng, 1.5))[..., None])[inside]
        labels[inside] = number
    return _finish(rng, pixels, labels)


def _noise(rng: np.random.Generator, width: float) -> np.ndarray:
    noise = ndimage.gaussian_filter(rng.standard_normal((SIDE, SIDE)), width, mode="wrap")
    return noise / noise.std()


def _scatter(rng: np.random.Generator, side: float, apart: float) -> np.ndarray:
    places: list[np.ndarray] = []
    for place in rng.random((4000, 2)) * side:
        if all(np.hypot(*(place - other)) > apart for other in places):
            places.append(place)
    return np.array(places)


def _reach(places: np.ndarray, own: np.ndarray, other: np.ndarray) -> np.ndarray:
    """How far it is to the line midway to another middle."""
    apart = np.linalg.norm(own - other, axis=-1)
    return ((places - 0.5 * (own + other)) * (own - other)).sum(axis=-1) / apart


def _own_frame(rng: np.random.Generator, x: float, y: float, size: float, least: float) -> tuple:
    row, column = np.indices((SIDE, SIDE)) + 0.5
    turn, flat = rng.uniform(0, np.pi), rng.uniform(least, 0.95)
    along = ((column - x) * np.cos(turn) + (row - y) * np.sin(turn)) / size
    across = ((row - y) * np.cos(turn) - (column - x) * np.sin(turn)) / (size * flat)
    return along, across, turn


def _shape(
    rng: np.random.Generator, along: np.ndarray, across: np.ndarray, turn: float, corners: int
) -> tuple[np.ndarray, np.ndarray]:
    """How far out a place is, 1 at the edge, and how light: round things towards their middle, others by facets."""
    if corners == 0:
        edge = np.hypot(along, across)
        return edge, np.clip(1 - 0.45 * edge**3 - 0.25 * (across * np.cos(turn) + along * np.sin(turn)), 0.1, 2)
    angles = np.linspace(0, 2 * np.pi, corners, endpoint=False) + rng.uniform(-0.3, 0.3, corners)
    edge = np.max([np.cos(angle) * along + np.sin(angle) * across for angle in angles], axis=0) / 0.85
    facets = rng.uniform(0, 2 * np.pi, rng.integers(2, 4))
    which = np.argmax([np.cos(angle) * along + np.sin(angle) * across for angle in facets], axis=0)
    return edge, rng.uniform(0.65, 1.2, len(facets))[which]


def _keep_visible(labels: np.ndarray, least: float) -> np.ndarray:
    """Each visible part of a thing is one, if it is not too small."""
    kept, count = np.zeros_like(labels), 0
    for number in np.unique(labels[labels > 0]):
        parts, many = ndimage.label(labels == number)
        for part in range(1, many + 1):
            if (parts == part).sum() >= least:
                count += 1
                kept[parts == part] = count
    return kept


def _finish(rng: np.random.Generator, pixels: np.ndarray, labels: np.ndarray) -> Scene:
    """As a camera sees it."""
    blurred = ndimage.gaussian_filter(pixels, (*[rng.uniform(0.3, 1.5)] * 2, 0))
    return np.clip(blurred, 0, 1).astype(np.float32), labels
