"""A fitted tiling and the photograph's own colours -> how thick the joints are, and a mask that shows them so.

The mask that a lattice was fitted to also holds the shaded and rounded edges of tiles, which make joints easy to find
and look thick. Once the lattice is known, colour alone can say where the mortar ends.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import NDArray

from jaxtex.fitting.verdict import mean_iou
from jaxtex.models.grids import on_grid
from jaxtex.models.tiling import Tiling
from jaxtex.photo.automask import learn_joints, part, probability
from jaxtex.photo.evidence import COLOURS, Evidence

Map = NDArray[np.float32]

# Colours of joint and tile less apart than this, in standard deviations, say that there is no mortar.
_DISTINCT = 0.7
_CORE = 0.15  # of the fitted thickness, on either side of a joint's centre line, is mortar for sure
_INTERIOR = 0.22  # of the pitch away from a joint is tile for sure
_BIN = 0.5  # pixels


class Distances(NamedTuple):
    """Of every pixel (H, W) from the centre line of the nearest head joint and of the nearest bed joint, in pixels."""

    head: NDArray[np.float64]
    bed: NDArray[np.float64]


def measure_distances(tiling: Tiling, shape: tuple[int, ...]) -> Distances:
    """Distances in a picture of ``shape`` (H, W) whose pixels the tiling is in."""
    height, width = shape
    with jax.enable_x64():
        return Distances(*(np.asarray(each) for each in on_grid(eqx.Partial(_distances, tiling), height, width)))


def measure_thickness(tiling: Tiling, distances: Distances, evidence: Evidence) -> tuple[float, float]:
    """Thickness of head and bed joints in pixels: where the colour of the joints is half that of the tiles.

    0 for both where tiles meet without mortar.
    """
    colours = evidence.features[..., :COLOURS]
    length = float(tiling.tile_width * np.min(tiling.course_lengths))
    height = float(tiling.tile_height)
    heads = _measure(colours, distances.head, distances.bed > 0.25 * height, float(tiling.mortar_x), length)
    beds = _measure(colours, distances.bed, distances.head > 0.2 * length, float(tiling.mortar_y), height)
    if max(heads[1], beds[1]) < _DISTINCT:
        return 0.0, 0.0
    return heads[0], beds[0]


def see_joints(distances: Distances, thickness: tuple[float, float], evidence: Evidence) -> Map:
    """Probability (H, W) that a pixel is joint, learnt again from joints of this thickness."""
    near = np.minimum(distances.head / thickness[0], distances.bed / thickness[1])
    return probability(learn_joints(evidence.features, near))


def mask_iou(tiling: Tiling, joint: Map) -> float:
    """Intersection over union of a tiling and of a map of joints (H, W) in its pixels, mean of tiles and joints."""
    distances = measure_distances(tiling, joint.shape)
    tile = (distances.head > tiling.mortar_x / 2) & (distances.bed > tiling.mortar_y / 2)
    return mean_iou(joint < 0.5, np.asarray(tile))


def _distances(tiling: Tiling, point: Array) -> tuple[Array, Array]:
    place = tiling.locate(tiling.to_lattice(point))
    return jnp.minimum(place.left, place.right), jnp.minimum(place.top, place.bottom)


def _measure(
    colours: Map, distance: NDArray[np.float64], clear: NDArray[np.bool_], fitted: float, pitch: float
) -> tuple[float, float]:
    """(thickness, how distinct the joint's colour is) from the pixels that are ``clear`` of the other joints."""
    distance, colours = distance[clear], colours[clear].astype(float)
    core, interior = distance < max(_CORE * fitted, 0.7), distance > _INTERIOR * pitch
    if min(core.sum(), interior.sum()) < 30:
        return fitted, np.inf
    direction, distinct = part(colours[core], colours[interior])
    likeness = colours @ direction
    halfway = (np.median(likeness[core]) + np.median(likeness[interior])) / 2
    edges = np.arange(0.0, 0.25 * pitch, _BIN)
    bins = np.digitize(distance, edges)
    before = float(np.median(likeness[core]))
    for number, edge in enumerate(edges, start=1):
        here = likeness[bins == number]
        if len(here) == 0:
            continue
        level = float(np.median(here))
        if level < halfway:
            # Between the middles of this bin and the one before.
            share = (before - halfway) / max(before - level, 1e-9)
            return 2 * max(edge - 0.5 * _BIN + share * _BIN, 0.0), distinct
        before = level
    return fitted, distinct
