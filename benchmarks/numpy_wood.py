"""Wood as a solid written plainly in NumPy: what the JAX model's block of voxels is compared with.

A person would write it for whole arrays; here some slices at a time, so that they fit the memory.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from jaxtex.models.wood import Wood

Array = NDArray[np.float32]

_SPOT = 0.5  # pixels: what a voxel sees, as in jaxtex.material.wood
_NEIGHBOURS = 3  # rings on either side that a spot may see


def render_block_numpy(wood: Wood, *, shape: tuple[int, int, int]) -> Iterator[Array]:
    """Slices [height, width, 3]: what `jaxtex.material.wood.render_block` gives, from the photographed face down."""
    plain = {
        name: np.asarray(getattr(wood, name), np.float32)
        for name in ("center", "early_rgb", "late_rgb", "waves", "phases")
    }
    depth, height, width = shape
    u = (np.arange(width, dtype=np.float32) + np.float32(0.5 - width / 2))[None, :]
    v = (np.arange(height, dtype=np.float32) + np.float32(0.5 - height / 2))[:, None]
    turn, tilt = float(wood.rotation), float(wood.tilt)
    c, s = np.float32(np.cos(turn)), np.float32(np.sin(turn))
    sine, cosine = np.float32(np.sin(tilt)), np.float32(np.cos(tilt))
    along = c * v - s * u
    for z in np.arange(depth, dtype=np.float32):
        trunk = c * u + s * v, along * sine + z * cosine, along * cosine - z * sine
        radius = np.hypot(trunk[0] - plain["center"][0], trunk[1] - plain["center"][1])
        count = (radius + _turbulence(wood, trunk, plain["waves"], plain["phases"])) / np.float32(wood.ring_spacing)
        early = _early_share(count, np.float32(wood.early_fraction), np.float32(_SPOT / float(wood.ring_spacing)))
        yield plain["late_rgb"] + early[..., None] * (plain["early_rgb"] - plain["late_rgb"])


def _turbulence(wood: Wood, trunk: tuple[Array, Array, Array], waves: Array, phases: Array) -> Array:
    """One wave after the other: all at once they would take 48 times the memory of a slice."""
    total = np.zeros(trunk[0].shape, np.float32)
    for wave, phase in zip(np.float32(2 * np.pi * float(wood.turbulence_frequency)) * waves, phases, strict=True):
        total += np.cos(wave[0] * trunk[0] + wave[1] * trunk[1] + wave[2] * trunk[2] + phase)
    return np.float32(float(wood.turbulence_rms) * np.sqrt(2 / len(phases))) * total


def _early_share(count: Array, fraction: np.float32, width: np.float32) -> Array:
    """Share of early wood in a Gaussian spot, at most half a ring wide."""
    turn = count - np.float32(0.25)
    aside = turn - np.round(turn)
    share = np.zeros_like(aside)
    for n in range(-_NEIGHBOURS, _NEIGHBOURS + 1):
        share += _step((aside - n + fraction / 2) / width) - _step((aside - n - fraction / 2) / width)
    return share


def _step(x: Array) -> Array:
    return np.float32(0.5) * (1 + erf(x * np.float32(0.70710678)))
