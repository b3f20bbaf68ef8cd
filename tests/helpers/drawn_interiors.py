"""Interiors of tiles whose every part is known, and a wall of which they are."""

import numpy as np
from scipy.ndimage import gaussian_filter

from jaxtex.core.colour import srgb_to_linear
from jaxtex.material.appearance import Appearance, quantise
from jaxtex.material.interiors import Interiors

COURSES, TILES = 4, 5


def draw_grain(*, strength=0.05, height=48, width=48, smooth=1.0, seed=0) -> np.ndarray:
    """Examples of grain, [region, row, col, 3]."""
    noise = gaussian_filter(np.random.default_rng(seed).normal(size=(4, height, width)), (0, smooth, smooth))
    return (strength * (noise - noise.mean()) / noise.std())[..., None].astype(np.float32) * np.float32([1, 0.9, 0.8])


def make_interiors(**changes) -> Interiors:
    """Of `make_appearance`'s tiles; of no grain, shift, wobble or shade unless `changes` say so."""
    places = np.stack(np.indices((COURSES, TILES)), axis=-1).reshape(-1, 2).astype(np.int32)
    count = len(places)
    none = np.zeros((0, 1, 1, 3), np.float32)
    plain = {
        "places": places,
        "kind": np.zeros(count, np.int32),
        "learnt": np.ones(count, bool),
        "contrast": np.ones(count, np.float32),
        "offset": np.zeros((count, 3), np.float32),
        "shift": np.zeros((count, 4), np.float32),
        "wobble": 0.0,
        "wobble_length": 4.0,
        "tile_grain": (none, none),
        "joint_grain": none,
        "tile_profile": np.zeros((4, 6, 3), np.float32),
        "joint_profile": np.zeros((4, 2, 3), np.float32),
    }
    return Interiors(**{**plain, **changes})


def make_appearance(**changes) -> Appearance:
    """Tiles of well-spread colours, lighter joints."""
    colours = srgb_to_linear(np.random.default_rng(1).uniform(0.35, 0.65, (COURSES, TILES, 3)))
    tiles = {place: quantise(colours[place]) for place in np.ndindex(COURSES, TILES)}
    relief = {"joint_depth": 3.0, "edge_width": 2.5, "tile_roughness": 0.4, "joint_roughness": 0.9}
    return Appearance(tiles=tiles, joint=quantise((0.6, 0.58, 0.5)), **{**relief, **changes})
