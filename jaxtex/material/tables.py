"""All that a pixel of a sheet depends on but its place, as tables on the device."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
from jax import Array

from jaxtex.material.appearance import Appearance
from jaxtex.material.draw import draw_tiles, pad_table
from jaxtex.material.filling import Filling, make_filling
from jaxtex.material.interiors import Interiors
from jaxtex.material.sheet import Sheet
from jaxtex.material.tile_wood import TileWood, Timber, cut_tiles, plain_filling, straighten_edges
from jaxtex.models.tiling import Tiling

_PIECES, _CUTS = 1, 2  # purposes of the key: which piece of grain, or of wood, a tile is; colours take the key itself


class Material(eqx.Module):
    """Tables are padded, so that sheets of about as many tiles share compiled code.

    Attributes:
        tiling: in single precision; its bond's name, on which nothing depends here, is the same for all.
        first_course: course of the first row of tiles, the one above the sheet.
        shape: rows, and tiles to a row.
        first_tile: number of each row's first tile.
        colours: linear light, by row and place in the row as one index, [tile, 3].
        identity: ids in the maps, likewise, [tile].
        joint: colour of the joints, (3,).
        corner_radius: None where corners are square: most are, and need but half of the code.
        relief: joint depth, width of the tiles' edges.
        pixel: width and height of a pixel, in plane pixels.
        filling: None where tiles and joints are flat.
        wood: None where tiles are not of wood; there is a filling where they are.
    """

    tiling: Tiling
    first_course: Array
    shape: Array
    first_tile: Array
    colours: Array
    identity: Array
    joint: Array
    corner_radius: Array | None
    relief: Array
    pixel: Array
    filling: Filling | None
    wood: TileWood | None = None


def make_material(
    sheet: Sheet,
    appearance: Appearance,
    interiors: Interiors | None,
    *,
    size: tuple[int, int],
    key: Array,
    timber: Timber | None = None,
) -> Material:
    """Gather what maps of a sheet look up.

    Args:
        interiors: None leaves tiles and joints flat.
        size: (width, height) of the maps in pixels.
        key: random key of the colours of tiles that were not seen, and of interiors and wood.
        timber: what tiles are cut of, if they are of wood.
    """
    table, radius = sheet.table(), float(sheet.tiling.corner_radius)
    drawn = draw_tiles(appearance, table.course, table.tile, key=key)
    pixel = sheet.width / size[0], sheet.height / size[1]
    filling = None if timber is None else plain_filling(sheet, table, appearance, drawn)
    if interiors is not None:
        pieces = jax.random.fold_in(key, _PIECES)
        filling = make_filling(sheet, table, appearance, interiors, drawn, pixel=pixel, key=pieces)
    wood = None
    if timber is not None and filling is not None:
        filling = straighten_edges(filling)
        wood = cut_tiles(sheet, table, timber, pixel=pixel, key=jax.random.fold_in(key, _CUTS))
    unnamed = dataclasses.replace(sheet.tiling, bond="irregular")  # static: names would not share compiled code
    return Material(
        tiling=jax.tree.map(lambda leaf: jnp.asarray(leaf, jnp.float32), unnamed),
        first_course=jnp.asarray(sheet.first_course - 1, jnp.int32),
        shape=jnp.asarray(table.tile.shape, jnp.int32),
        first_tile=jnp.asarray(pad_table(table.first)),
        colours=jnp.asarray(pad_table(drawn.colour.reshape(-1, 3))),
        identity=jnp.asarray(pad_table(table.identity.ravel())),
        joint=jnp.asarray(appearance.joint, jnp.float32),
        corner_radius=jnp.asarray(radius, jnp.float32) if radius > 0 else None,
        relief=jnp.asarray([appearance.joint_depth, appearance.edge_width], jnp.float32),
        pixel=jnp.asarray(pixel, jnp.float32),
        filling=filling,
        wood=wood,
    )
