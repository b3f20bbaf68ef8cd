"""A floor as maps: the wood of every plank, and the joints between them."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.core.colour import srgb_to_linear
from jaxtex.material.bands import BAND, check_sides, normals_of
from jaxtex.material.finish import BARE_WOOD, Finish, WoodFinish
from jaxtex.material.overlay import paint_lines
from jaxtex.material.plank_filling import PlankFilling, fill_planks
from jaxtex.material.planks import PlankInteriors, without_fibres
from jaxtex.material.wood import WoodMaps, look_at_plank
from jaxtex.models.floor_files import PlacedWood

_JOINT = 1.5  # pixels of the photograph: how broad the joint is that each plank has on its sides
_DARK = 0.15  # of late wood's colour: the joint's
_DEEP = 2.0  # pixels of the photograph: how deep it lies
_BETWEEN = Finish(0.9, 0.5)
_SPOT = 0.5  # standard deviation of what a pixel sees, in pixels


class FloorMaps(NamedTuple):
    """Some rows of the maps of a floor, as `WoodMaps` has them; `tile_id` [row, col]: the planks' numbers, and -1
    beyond all of them."""

    base_colour: npt.NDArray[np.float32]
    height: npt.NDArray[np.float32]
    normal: npt.NDArray[np.float32]
    roughness: npt.NDArray[np.float32]
    tile_id: npt.NDArray[np.float32]
    specular: npt.NDArray[np.float32]
    metallic: npt.NDArray[np.float32]


def render_floor(
    planks: Sequence[PlacedWood],
    *,
    image: tuple[int, int],
    size: tuple[int, int],
    interiors: PlankInteriors | None = None,
    key: Array | None = None,
    finish: WoodFinish = BARE_WOOD,
) -> Iterator[FloorMaps]:
    """Render the maps of a floor as far as the photograph shows it, some rows at a time from top to bottom.

    Args:
        planks: as a model file of a floor has them.
        image: (width, height) of the photograph.
        size: (width, height) of the maps in pixels.
        interiors: what planks look like beyond their rings. Without them each plank has rings, its own or such as the
            others have, and two tones.
        key: random key of the grain; needed where there are interiors.
        finish: of early and of late wood.

    Raises:
        InputError: a size without pixels, or too large.
    """
    check_sides(size)
    if interiors is not None and key is None:
        raise ValueError("a floor with interiors needs a random key")
    return _render_bands(planks, image, size, interiors, key, finish)


def _render_bands(
    planks: Sequence[PlacedWood],
    image: tuple[int, int],
    size: tuple[int, int],
    interiors: PlankInteriors | None,
    key: Array | None,
    finish: WoodFinish,
) -> Iterator[FloorMaps]:
    scale = image[0] / size[0], image[1] / size[1]
    filling = None
    if interiors is not None and key is not None:
        filling = fill_planks(planks, interiors, pixel=scale, key=key)
    look = _Look(planks, filling, finish, scale)
    for first in range(0, size[1], BAND):
        yield _render_rows(look, (first, min(BAND, size[1] - first), size[0]))


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


class _Look(NamedTuple):
    """All that a point of a floor depends on but its place."""

    planks: Sequence[PlacedWood]
    filling: PlankFilling | None
    finish: WoodFinish
    scale: tuple[float, float]  # breadth and height of a map's pixel, in pixels of the photograph


def _render_rows(look: _Look, band: tuple[int, int, int]) -> FloorMaps:
    """Maps of a band: its first row, its rows and columns."""
    first, rows, columns = band
    # One pixel more on all sides, from which slopes are taken.
    row, column = np.indices((rows + 2, columns + 2)) - 0.5
    seen = _see_floor(look, column * look.scale[0], (row + first) * look.scale[1])
    slope_x = (seen.height[1:-1, 2:] - seen.height[1:-1, :-2]) / (2 * look.scale[0])
    slope_y = (seen.height[2:, 1:-1] - seen.height[:-2, 1:-1]) / (2 * look.scale[1])
    inside = FloorMaps(*(each[1:-1, 1:-1] for each in seen))
    return inside._replace(normal=np.asarray(normals_of(jnp.asarray(slope_x), jnp.asarray(slope_y))))


def _see_floor(look: _Look, x: npt.NDArray[np.float64], y: npt.NDArray[np.float64]) -> FloorMaps:
    """What points of the floor [row, col] show, but for normals."""
    seen = FloorMaps(
        base_colour=np.zeros((*x.shape, 3), np.float32),
        height=np.full(x.shape, -_DEEP, np.float32),
        normal=np.zeros((*x.shape, 3), np.float32),
        roughness=np.full(x.shape, _BETWEEN.roughness, np.float32),
        tile_id=np.full(x.shape, -1, np.float32),
        specular=np.full(x.shape, _BETWEEN.specular, np.float32),
        metallic=np.full(x.shape, _BETWEEN.metallic, np.float32),
    )
    for number, plank in enumerate(look.planks):
        inside = _depth_inside(plank.corners, x, y)
        here = inside > 0
        if not here.any():
            continue
        middle = plank.corners.mean(0)
        points = np.stack([x[here] - middle[0], y[here] - middle[1]], axis=1)
        joint = np.clip((_JOINT - inside[here]) / _JOINT, 0, 1)[:, None].astype(np.float32)
        wood = _see_plank(look, number, points)
        dark = _DARK * np.asarray(plank.wood.late_rgb, np.float32)
        if look.filling is not None:
            dark = srgb_to_linear(look.filling.joint)
        seen.base_colour[here] = wood.base_colour + joint * (dark - wood.base_colour)
        seen.height[here] = wood.height - joint[:, 0] * (_DEEP + wood.height)
        for name, between in _BETWEEN._asdict().items():
            own = getattr(wood, name)
            getattr(seen, name)[here] = own + joint[:, 0] * (between - own)
        seen.tile_id[here] = number
    return seen


def _see_plank(look: _Look, number: int, points: npt.NDArray[np.float64]) -> WoodMaps:
    """What points [point, 2] of a plank, from its middle, show."""
    plank, filling, spot = look.planks[number], look.filling, _SPOT * max(look.scale)
    if filling is None:
        return look_at_plank(plank.wood, points, spot=spot, finish=look.finish)
    # Where rings were not read, none are drawn, and the finish is that of early wood all over.
    finish = look.finish if plank.own else WoodFinish(look.finish.early, look.finish.early)
    wood = look_at_plank(without_fibres(plank.wood), points, spot=spot, finish=finish)
    colour, height = filling.finish(number, points, wood.base_colour, wood.height)
    return wood._replace(base_colour=colour, height=height)


def _depth_inside(corners: npt.NDArray[np.float64], x: npt.NDArray, y: npt.NDArray) -> npt.NDArray[np.float64]:
    """How far points lie inside a convex outline; negative outside of it."""
    sides = np.roll(corners, -1, axis=0) - corners
    turning = np.sign(sides[0, 0] * sides[1, 1] - sides[0, 1] * sides[1, 0])
    depths = [
        turning * (side[0] * (y - corner[1]) - side[1] * (x - corner[0])) / max(float(np.hypot(*side)), 1e-9)
        for corner, side in zip(corners, sides, strict=True)
    ]
    return np.minimum.reduce(depths)
