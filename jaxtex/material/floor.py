"""A floor as maps: the wood of every plank, and the joints between them."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.core.colour import srgb_to_linear
from jaxtex.material.bands import BAND, check_sides, normals_of
from jaxtex.material.overlay import paint_lines
from jaxtex.material.plank_filling import PlankFilling, fill_planks
from jaxtex.material.planks import PlankInteriors, without_fibres
from jaxtex.material.wood import look_at_plank
from jaxtex.models.floor_files import PlacedWood

_JOINT = 1.5  # pixels of the photograph: how broad the joint is that each plank has on its sides
_DARK = 0.15  # of late wood's colour: the joint's
_DEEP = 2.0  # pixels of the photograph: how deep it lies
_ROUGH = 0.9
_SPOT = 0.5  # standard deviation of what a pixel sees, in pixels


class FloorMaps(NamedTuple):
    """Some rows of the maps of a floor, as `WoodMaps` has them; `tile_id` [row, col]: the planks' numbers, and -1
    beyond all of them."""

    base_colour: npt.NDArray[np.float32]
    height: npt.NDArray[np.float32]
    normal: npt.NDArray[np.float32]
    roughness: npt.NDArray[np.float32]
    tile_id: npt.NDArray[np.float32]


def render_floor(
    planks: Sequence[PlacedWood],
    *,
    image: tuple[int, int],
    size: tuple[int, int],
    interiors: PlankInteriors | None = None,
    key: Array | None = None,
) -> Iterator[FloorMaps]:
    """Render the maps of a floor as far as the photograph shows it, some rows at a time from top to bottom.

    Args:
        planks: as a model file of a floor has them.
        image: (width, height) of the photograph.
        size: (width, height) of the maps in pixels.
        interiors: what planks look like beyond their rings. Without them each plank has rings, its own or such as the
            others have, and two tones.
        key: random key of the grain; needed where there are interiors.

    Raises:
        InputError: a size without pixels, or too large.
    """
    check_sides(size)
    return _render_bands(planks, image, size, interiors, key)


def _render_bands(
    planks: Sequence[PlacedWood],
    image: tuple[int, int],
    size: tuple[int, int],
    interiors: PlankInteriors | None,
    key: Array | None,
) -> Iterator[FloorMaps]:
    scale = image[0] / size[0], image[1] / size[1]
    filling = None
    if interiors is not None:
        if key is None:
            raise ValueError("a floor with interiors needs a random key")
        filling = fill_planks(planks, interiors, pixel=scale, key=key)
    for first in range(0, size[1], BAND):
        yield _render_rows(planks, filling, scale, (first, min(BAND, size[1] - first), size[0]))


def draw_planks(pixels: npt.NDArray[np.float32], planks: Sequence[PlacedWood]) -> npt.NDArray[np.float32]:
    """The planks' outlines drawn over their photograph.

    Args:
        pixels: linear light, [row, col, 1 or 3].
        planks: as a model file of a floor has them.

    Returns:
        float32 [row, col, 3].
    """
    height, width = pixels.shape[:2]
    shown = np.repeat(pixels, 3, axis=2) if pixels.shape[2] == 1 else pixels.copy()
    y, x = np.indices((height, width)) + 0.5
    aside = np.full((height, width), np.inf)
    for plank in planks:
        # A plank's outline is near its own pixels only: those of its bounding box, and a few more.
        low, high = plank.corners.min(0) - 4, plank.corners.max(0) + 4
        columns, rows = (slice(max(int(a), 0), max(int(b) + 1, 0)) for a, b in zip(low, high, strict=True))
        depth = np.abs(_depth_inside(plank.corners, x[rows, columns], y[rows, columns]))
        aside[rows, columns] = np.minimum(aside[rows, columns], depth)
    paint_lines(shown, aside, max(0.8, max(height, width) / 1200))
    return shown


def _render_rows(
    planks: Sequence[PlacedWood],
    filling: PlankFilling | None,
    scale: tuple[float, float],
    band: tuple[int, int, int],
) -> FloorMaps:
    """Maps of a band: its first row, its rows and columns."""
    first, rows, columns = band
    # One pixel more on all sides, from which slopes are taken.
    row, column = np.indices((rows + 2, columns + 2)) - 0.5
    shown = _look(planks, filling, column * scale[0], (row + first) * scale[1], scale)
    height = shown.height
    slope_x = (height[1:-1, 2:] - height[1:-1, :-2]) / (2 * scale[0])
    slope_y = (height[2:, 1:-1] - height[:-2, 1:-1]) / (2 * scale[1])
    normal = np.asarray(normals_of(jnp.asarray(slope_x), jnp.asarray(slope_y)))
    base_colour, height, roughness, tile_id = (each[1:-1, 1:-1] for each in shown)
    return FloorMaps(base_colour, height, normal, roughness, tile_id)


class _Seen(NamedTuple):
    base_colour: npt.NDArray[np.float32]
    height: npt.NDArray[np.float32]
    roughness: npt.NDArray[np.float32]
    tile_id: npt.NDArray[np.float32]


def _look(
    planks: Sequence[PlacedWood],
    filling: PlankFilling | None,
    x: npt.NDArray[np.float64],
    y: npt.NDArray[np.float64],
    scale: tuple[float, float],
) -> _Seen:
    """What points of the floor [row, col] show."""
    seen = _Seen(
        base_colour=np.zeros((*x.shape, 3), np.float32),
        height=np.full(x.shape, -_DEEP, np.float32),
        roughness=np.full(x.shape, _ROUGH, np.float32),
        tile_id=np.full(x.shape, -1, np.float32),
    )
    for number, plank in enumerate(planks):
        inside = _depth_inside(plank.corners, x, y)
        here = inside > 0
        if not here.any():
            continue
        middle = plank.corners.mean(0)
        points = np.stack([x[here] - middle[0], y[here] - middle[1]], axis=1)
        joint = np.clip((_JOINT - inside[here]) / _JOINT, 0, 1)[:, None].astype(np.float32)
        rings = plank.wood if filling is None else without_fibres(plank.wood)
        wood = look_at_plank(rings, points, spot=_SPOT * max(scale))
        colour, height = wood.base_colour, wood.height
        dark = _DARK * np.asarray(plank.wood.late_rgb, np.float32)
        if filling is not None:
            colour, height = filling.finish(number, points, colour, height)
            dark = srgb_to_linear(filling.joint)
        seen.base_colour[here] = colour + joint * (dark - colour)
        seen.height[here] = height - joint[:, 0] * (_DEEP + height)
        seen.roughness[here] = wood.roughness + joint[:, 0] * (_ROUGH - wood.roughness)
        seen.tile_id[here] = number
    return seen


def _depth_inside(corners: npt.NDArray[np.float64], x: npt.NDArray, y: npt.NDArray) -> npt.NDArray[np.float64]:
    """How far points lie inside a convex outline; negative outside of it."""
    sides = np.roll(corners, -1, axis=0) - corners
    turning = np.sign(sides[0, 0] * sides[1, 1] - sides[0, 1] * sides[1, 0])
    depths = [
        turning * (side[0] * (y - corner[1]) - side[1] * (x - corner[0])) / max(float(np.hypot(*side)), 1e-9)
        for corner, side in zip(corners, sides, strict=True)
    ]
    return np.minimum.reduce(depths)
