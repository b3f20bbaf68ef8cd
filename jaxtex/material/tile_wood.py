"""Wood inside a tiling's tiles: parquet, shingles, a wall of boards (Lefebvre & Poulin 2000, section 4.4).

Every tile is cut elsewhere from one trunk, its grain along its longer side; where tiles are square, grain turns from
tile to tile as on a chessboard.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.core.colour import linear_to_srgb
from jaxtex.material.appearance import Appearance
from jaxtex.material.draw import DrawnTiles, pad_table
from jaxtex.material.filling import Filling, pixels_of_tiles
from jaxtex.material.finish import BARE_WOOD
from jaxtex.material.sheet import Sheet, TileTable
from jaxtex.material.wood import RELIEF, ROUNDING, ROWS_AT_ONCE, SPOT, in_single, solid_to_trunk
from jaxtex.models.wood import Wood, early_share

ROWS = ROWS_AT_ONCE, ROWS_AT_ONCE + 1
"""Rows to evaluate at once of a band of maps, and of a band with one more on either side: both go into it evenly."""

_DEEP = 0.05  # of the photograph's longer side: how deep below the photographed face tiles are cut, either way
_TONES = 0.08  # standard deviation of the logarithm of how light one piece is against another, as pieces of a trunk are
_SQUARE = 0.1  # sides that differ by less make a square


class Timber(NamedTuple):
    """What tiles are cut of.

    Attributes:
        wood: the model.
        image: (width, height) of its photograph.
        scale: how many plane pixels of the tiling a pixel of that photograph is long.
        bare: whether early and late wood shine each as they do; else all of a tile is as the appearance has it.
    """

    wood: Wood
    image: tuple[int, int]
    scale: float = 1.0
    bare: bool = True


class TileWood(eqx.Module):
    """How each tile is cut. Tables by tile are padded.

    Attributes:
        wood: in single precision.
        blur: standard deviation of the spot that a map's pixel sees, in pixels of the wood's photograph.
        scale: as `Timber` has it.
        start: the map's pixel (x, y) in which each tile begins, [tile, 2].
        corner: the solid's point (u, v, depth) at which it does, [tile, 3].
        turn: from map's pixels (x, y) to (u, v), [tile, 2, 2].
        tone: how light each tile's wood is, against the model's, [tile].
        bare: as `Timber` has it.
    """

    wood: Wood
    blur: Array
    scale: Array
    start: Array
    corner: Array
    turn: Array
    tone: Array
    bare: Array

    def mean_colour(self) -> Array:
        """Of the wood, linear light (3,)."""
        wood = self.wood
        return wood.late_rgb + wood.early_fraction * (wood.early_rgb - wood.late_rgb)

    def surface(self, entry: Array, at: Array) -> tuple[Array, Array]:
        """Colour (3,), linear light, and roughness that a map's pixel (x, y) shows of a tile."""
        trunk = solid_to_trunk(self.wood, self._place(entry, at))
        early = _early_on_cut(self.wood, trunk, self.blur)
        colour = self.tone[entry] * self.wood.colour_of(early, trunk, blur=self.blur)
        rough_early, rough_late = (finish.roughness for finish in BARE_WOOD)
        return jnp.clip(colour, 0.0, 1.0), rough_late + early * (rough_early - rough_late)

    def height(self, entry: Array, at: Array) -> Array:
        """Of late wood above early wood that a map's pixel (x, y) shows of a tile, in plane pixels of the tiling."""
        spacing = self.wood.ring_spacing
        blur = jnp.sqrt(self.blur**2 + (ROUNDING * spacing) ** 2)
        early = _early_on_cut(self.wood, solid_to_trunk(self.wood, self._place(entry, at)), blur)
        return self.scale * RELIEF * spacing * (1.0 - early)

    def _place(self, entry: Array, at: Array) -> Array:
        """The solid's point (3,) that a map's pixel (x, y) shows, counted in whole pixels from the tile's beginning, so
        that both ends of a seamless sheet show the same."""
        inside = (at - self.start[entry]).astype(self.corner.dtype) + 0.5
        turn, corner = self.turn[entry], self.corner[entry]
        u = corner[0] + turn[0, 0] * inside[0] + turn[0, 1] * inside[1]
        v = corner[1] + turn[1, 0] * inside[0] + turn[1, 1] * inside[1]
        return jnp.stack([u, v, corner[2]])


def cut_tiles(sheet: Sheet, table: TileTable, timber: Timber, *, pixel: tuple[float, float], key: Array) -> TileWood:
    """Cut every tile of a sheet out of a trunk.

    Tiles are cut where the photograph shows the trunk, as far as it is large enough, or a little above or below its
    face, and are turned about or over by chance.

    Args:
        sheet, table: the sheet and its tiles.
        timber: what they are cut of.
        pixel: breadth and height of the maps' pixels in plane pixels.
        key: random key. Where a tile is cut depends on it and the tile alone.
    """
    t = sheet.tiling
    start, size = pixels_of_tiles(sheet, table, pixel)
    start, size = start[:, ::-1], size[:, ::-1]  # here as (x, y)
    faces = size[:, 0] - float(t.mortar_x), float(t.tile_height - t.mortar_y)
    tiles = [jnp.asarray(pad_table(part.ravel())) for part in (table.course, table.tile)]
    chance, tone = (np.asarray(each)[: len(size)] for each in _draw_cuts(key, *tiles))
    corner, turn = _lay_boards(timber, size / timber.scale, _grain_along_x(faces, table), chance)
    return TileWood(
        wood=in_single(timber.wood),
        blur=jnp.asarray(SPOT * max(pixel) / timber.scale, jnp.float32),
        scale=jnp.asarray(timber.scale, jnp.float32),
        start=jnp.asarray(pad_table(start.astype(np.int32))),
        corner=jnp.asarray(pad_table(corner.astype(np.float32))),
        turn=jnp.asarray(pad_table((turn * np.array(pixel) / timber.scale).astype(np.float32))),
        tone=jnp.asarray(pad_table(np.exp(_TONES * tone))),
        bare=jnp.asarray(timber.bare),
    )


def straighten_edges(filling: Filling) -> Filling:
    """A filling whose tiles end where the tiling has it, as boards do that a saw has cut."""
    straight = (jnp.zeros_like(filling.shift), filling.tile_stock.at[..., 4].set(0.0))
    return eqx.tree_at(lambda each: (each.shift, each.tile_stock), filling, straight)


def plain_filling(sheet: Sheet, table: TileTable, appearance: Appearance, drawn: DrawnTiles) -> Filling:
    """A filling without grain, of tiles with straight edges: where a tiling has no interiors, its tiles may be of wood
    all the same."""
    tiles = table.tile.size
    tables = {
        "kind": np.zeros(tiles, np.int32),
        "piece": np.zeros((tiles, 2), np.int32),
        "joint_piece": np.zeros((tiles, 2), np.int32),
        "contrast": np.zeros(tiles, np.float32),
        "colour": linear_to_srgb(np.clip(drawn.colour.reshape(-1, 3), 0, 1)).astype(np.float32),
        "shift": np.zeros((tiles, 4), np.float32),
    }
    return Filling(
        tile_stock=jnp.zeros((1, 1, 1, 5)),
        joint_stock=jnp.zeros((1, 1, 4)),
        joint=jnp.asarray(linear_to_srgb(np.array(appearance.joint)), jnp.float32),
        tile_profile=jnp.zeros((4, 1, 3)),
        joint_profile=jnp.zeros((4, 1, 3)),
        corner=jnp.asarray(sheet.corner, jnp.float32),
        **{name: jnp.asarray(pad_table(values)) for name, values in tables.items()},
    )


def _early_on_cut(wood: Wood, trunk: Array, blur: Array) -> Array:
    """Share of early wood that a spot sees on a face cut parallel to the plank's, around a trunk point (3,)."""
    aside = trunk[:2] - wood.center
    square = jnp.sum(aside**2) + 1e-6 * wood.ring_spacing**2
    seen = jnp.sqrt((aside[0] ** 2 + (aside[1] * jnp.sin(wood.tilt)) ** 2) / square + 1e-3)
    return early_share(wood.ring_count(trunk), wood.early_fraction, blur * seen / wood.ring_spacing, wood.gradation)


def _grain_along_x(faces: tuple[npt.NDArray[np.float64], float], table: TileTable) -> npt.NDArray[np.bool_]:
    """Whether each tile's grain runs along its course, [tile]."""
    breadth, height = faces
    square = np.abs(breadth - height) < _SQUARE * np.maximum(breadth, height)
    chessboard = (table.course + table.tile).ravel() % 2 == 0
    return np.where(square, chessboard, breadth > height)


def _lay_boards(
    timber: Timber, size: npt.NDArray[np.float64], along_x: npt.NDArray[np.bool_], chance: npt.NDArray[np.float32]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Where each tile's upper left corner lies in the solid, [tile, 3], and how its x and y run there, [tile, 2, 2].

    Args:
        timber: what tiles are cut of.
        size: (width, height) of the tiles in pixels of its photograph, [tile, 2].
        along_x: whether their grain runs along their courses, [tile].
        chance: five numbers from 0 to 1 for each, [tile, 5].
    """
    c, s = np.cos(float(timber.wood.rotation)), np.sin(float(timber.wood.rotation))
    across, along = np.array([c, s]), np.array([-s, c])
    half = 0.5 * np.array([np.abs(side) @ np.array(timber.image) for side in (across, along)])
    extent = np.where(along_x[:, None], size[:, ::-1], size)  # of each tile, across its grain and along
    room = half - (extent - half)
    first = np.minimum(-half, half - extent) + chance[:, :2] * np.abs(room)
    mirrored = chance[:, 2:4] < 0.5
    begin = np.where(mirrored, first + extent, first)
    way = np.where(mirrored, -1.0, 1.0)
    depth = _DEEP * max(timber.image) * (2 * chance[:, 4] - 1)
    corner = np.column_stack([begin @ np.stack([across, along]), depth])
    grain, other = way[:, 1:] * along, way[:, :1] * across
    x, y = np.where(along_x[:, None], grain, other), np.where(along_x[:, None], other, grain)
    return corner, np.stack([x, y], axis=-1)


@jax.jit
def _draw_cuts(key: Array, course: Array, tile: Array) -> tuple[Array, Array]:
    """For each tile five numbers from 0 to 1, and one about 0 whose standard deviation is about 1."""

    def draw(course: Array, tile: Array) -> tuple[Array, Array]:
        own = jax.random.split(jax.random.fold_in(jax.random.fold_in(key, course), tile))
        return jax.random.uniform(own[0], (5,)), jax.random.truncated_normal(own[1], -2.0, 2.0)

    return jax.vmap(draw)(course, tile)
