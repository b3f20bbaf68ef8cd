"""The tiling's soft mask written plainly in NumPy: what the JAX model is compared with.

Square corners and the identity view, as a person would write it for whole arrays.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from jaxtex.models.tiling import Tiling

Array = NDArray[np.float32]


def coverage_numpy(tiling: Tiling, height: int, width: int, blur: float) -> Array:
    """[height, width]: what `jaxtex.models.grids.coverage_grid` gives for square corners seen straight on."""
    values = {name: np.float32(getattr(tiling, name)) for name in ("tile_width", "tile_height", "offset")}
    angle = float(tiling.angle)
    c, s = np.float32(np.cos(angle)), np.float32(np.sin(angle))
    x = np.arange(width, dtype=np.float32)[None, :] + np.float32(0.5) - np.float32(tiling.origin[0])
    y = np.arange(height, dtype=np.float32)[:, None] + np.float32(0.5) - np.float32(tiling.origin[1])
    q_x, q_y = c * x + s * y, c * y - s * x
    own = np.floor(q_y / values["tile_height"])
    beside = own + np.where(q_y - own * values["tile_height"] < 0.5 * values["tile_height"], -1, 1).astype(np.float32)
    return sum(_covered(q_x, q_y, course, tiling, blur, **values) for course in (own, beside))


def _covered(
    q_x: Array,
    q_y: Array,
    course: Array,
    tiling: Tiling,
    blur: float,
    *,
    tile_width: float,
    tile_height: float,
    offset: float,
) -> Array:
    half_x, half_y = np.float32(tiling.mortar_x) / 2, np.float32(tiling.mortar_y) / 2
    along = q_x / tile_width - offset * course
    along = along - np.floor(along)
    head = np.minimum(along, 1 - along) * tile_width
    top = q_y - course * tile_height
    across = _step((top - half_y) / blur) + _step((tile_height - top - half_y) / blur) - 1
    return (_step((head - half_x) / blur) + _step((-head - half_x) / blur)) * across


def _step(x: Array) -> Array:
    return 0.5 * (1 + erf(x * np.float32(0.70710678)))
