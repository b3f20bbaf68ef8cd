"""What a sheet's tiles and joints are filled with, as tables that its maps look up."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array
from scipy.spatial import cKDTree

from jaxtex.core.colour import linear_to_srgb
from jaxtex.material.appearance import Appearance
from jaxtex.material.cells import tile_bounds
from jaxtex.material.draw import DrawnTiles, pad_table
from jaxtex.material.grain import MARGIN
from jaxtex.material.interiors import Interiors
from jaxtex.material.sheet import Sheet, TileTable
from jaxtex.material.stocks import choose_side, make_grain, make_wobble, relief_of

_JOINTS = 1024  # pixels: the side of a stock of joints, at most


class Filling(eqx.Module):
    """Stocks of grain, and which piece of them each tile takes. Tables by tile are padded.

    Attributes:
        tile_stock: [kind, row, col, 5]: changes of sRGB-encoded colour; relief; wobble of the outline, both in plane
            pixels.
        joint_stock: [row, col, 4]: likewise, without wobble.
        kind: which stock, [tile].
        piece: what to add to a map's row and column to be at the stock's, [tile, 2].
        joint_piece: likewise, for the joints above and to the left of the tile.
        contrast: of the grain, [tile].
        colour: sRGB-encoded, with what makes up for the piece's mean, [tile, 3].
        joint: the joints' colour, sRGB-encoded, (3,).
        shift: how far outside of the tiling's edges the tile ends, [tile, 4]: left, right, top, bottom.
        tile_profile, joint_profile: as `Interiors` has them.
        corner: of the sheet, (2,), in plane pixels.
    """

    tile_stock: Array
    joint_stock: Array
    kind: Array
    piece: Array
    joint_piece: Array
    contrast: Array
    colour: Array
    joint: Array
    shift: Array
    tile_profile: Array
    joint_profile: Array
    corner: Array


def make_filling(
    sheet: Sheet,
    table: TileTable,
    appearance: Appearance,
    interiors: Interiors,
    drawn: DrawnTiles,
    *,
    pixel: tuple[float, float],
    key: Array,
) -> Filling:
    """Make the stocks for a sheet's maps, and give every tile its piece.

    Args:
        sheet, table: the sheet and its tiles.
        appearance, interiors: of tiles and joints.
        drawn: colours of the table's tiles, and which of the tiles seen each is like.
        pixel: breadth and height of the maps' pixels in plane pixels.
        key: random key. A tile's piece depends on it, the tile and the resolution alone.
    """
    stocks, joints, pieces = (jax.random.fold_in(key, purpose) for purpose in range(3))
    start, size = pixels_of_tiles(sheet, table, pixel)
    extent = np.ceil(size / np.array(pixel[::-1])).astype(np.int64)
    tile_stock = _make_tile_stock(interiors, appearance, pixel, choose_side(*extent.max(axis=0)), stocks)
    side, joint_side = tile_stock.shape[1], min(tile_stock.shape[1], _JOINTS)
    joint_grain = make_grain(interiors.joint_grain, pixel, joint_side, key=joints)
    joint_relief = relief_of(joint_grain, [interiors.joint_grain], appearance.joint_bump)
    like = _measured_like(appearance, interiors)[drawn.like.ravel()]
    places = (jnp.asarray(pad_table(part.ravel())) for part in (table.course, table.tile))
    chance = np.asarray(_draw_pieces(pieces, *places))[: table.course.size]
    first = np.floor(chance[:, :2] * np.maximum(side - extent + 1, 1)).astype(np.int64)
    joint_first = np.floor(chance[:, 2:] * joint_side).astype(np.int64)
    kind, contrast = interiors.kind[like], interiors.contrast[like]
    shift = _shifts(interiors, like, table)
    before, after = _margins(sheet, pixel, shift)
    inside = np.maximum(first + before, 0), np.maximum(extent - before - after, 1)
    excess = contrast[:, None] * _mean_of_pieces(tile_stock[..., :3], kind, *inside) - interiors.offset[like]
    tables = {
        "kind": kind.astype(np.int32),
        "piece": (first - start).astype(np.int32),
        "joint_piece": (joint_first - start).astype(np.int32),
        "contrast": contrast,
        "colour": (linear_to_srgb(np.clip(drawn.colour.reshape(-1, 3), 0, 1)) - excess).astype(np.float32),
        "shift": shift,
    }
    return Filling(
        tile_stock=jnp.asarray(tile_stock),
        joint_stock=jnp.asarray(np.concatenate([joint_grain, joint_relief[..., None]], axis=-1), jnp.float32),
        joint=jnp.asarray(linear_to_srgb(np.array(appearance.joint)), jnp.float32),
        tile_profile=jnp.asarray(interiors.tile_profile),
        joint_profile=jnp.asarray(interiors.joint_profile),
        corner=jnp.asarray(sheet.corner, jnp.float32),
        **{name: jnp.asarray(pad_table(values)) for name, values in tables.items()},
    )


def _make_tile_stock(
    interiors: Interiors, appearance: Appearance, pixel: tuple[float, float], side: int, key: Array
) -> npt.NDArray[np.float32]:
    """As `Filling.tile_stock`. All kinds have the same wobble."""
    kinds = len(interiors.tile_grain)
    wobble_key = jax.random.fold_in(key, kinds)
    stock = np.empty((kinds, side, side, 5), np.float32)
    stock[..., 4] = make_wobble(interiors.wobble, interiors.wobble_length, pixel, side, key=wobble_key)
    for number, examples in enumerate(interiors.tile_grain):
        stock[number, ..., :3] = make_grain(examples, pixel, side, key=jax.random.fold_in(key, number))
        stock[number, ..., 3] = relief_of(stock[number, ..., :3], interiors.tile_grain, appearance.tile_bump)
    return stock


def _measured_like(appearance: Appearance, interiors: Interiors) -> npt.NDArray[np.int_]:
    """For each tile that was seen: which of those measured it is like: itself, or one of about its colour."""
    number = {place: n for n, place in enumerate(map(tuple, interiors.places.tolist()))}
    colours = linear_to_srgb(np.array(list(appearance.tiles.values())))
    places = list(appearance.tiles)
    measured = [n for n, place in enumerate(places) if place in number]
    nearest = cKDTree(colours[measured]).query(colours)[1]
    return np.array([number.get(place, number[places[measured[k]]]) for place, k in zip(places, nearest, strict=True)])


def pixels_of_tiles(
    sheet: Sheet, table: TileTable, pixel: tuple[float, float]
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    """The map's pixel (row, col) in which each tile of the table begins, and its height and width in plane pixels,
    joints included: [tile, 2] each."""
    numbers = table.first[:, None] + np.arange(table.tile.shape[1])
    course = np.broadcast_to(np.arange(len(table.first))[:, None] + sheet.first_course - 1, numbers.shape)
    left, right = (edge.ravel() for edge in tile_bounds(sheet.tiling, course, numbers))
    height = float(sheet.tiling.tile_height)
    begin = np.stack([course.ravel() * height, left], axis=-1)
    # What rounding puts a hair before a pixel's border is meant to be on it, at either end of a seamless sheet.
    start = np.floor((begin - np.array(sheet.corner[::-1])) / np.array(pixel[::-1]) + 1e-3)
    return start.astype(np.int64), np.stack([np.full_like(left, height), right - left], axis=-1)


def _margins(
    sheet: Sheet, pixel: tuple[float, float], shift: npt.NDArray[np.float32]
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Pixels (rows, columns) from where tiles begin to where their grain is as it was measured, and from there to their
    ends, [tile, 2] each."""
    t = sheet.tiling
    faces = float(t.tile_height - t.mortar_y), float(t.tile_width * np.min(t.course_lengths) - t.mortar_x)
    inset = max(MARGIN[0], MARGIN[1] * min(faces))
    joints = 0.5 * np.array([float(t.mortar_y), float(t.mortar_x)])
    left, right, top, bottom = shift.T
    before, after = (joints + inset - np.stack(sides, axis=-1) for sides in ((top, left), (bottom, right)))
    step = np.array(pixel[::-1])
    return np.rint(before / step).astype(np.int64), np.rint(after / step).astype(np.int64)


def _shifts(interiors: Interiors, like: npt.NDArray[np.int_], table: TileTable) -> npt.NDArray[np.float32]:
    """Of all tiles of the table, [tile, 4]. The two sides of a joint between tiles are those of one joint measured, so
    that joints are as thick as they were."""
    number = {place: n for n, place in enumerate(map(tuple, interiors.places.tolist()))}
    beside = [number.get((course, tile - 1), n) for (course, tile), n in number.items()]
    shift = interiors.shift[like].reshape(*table.tile.shape, 4).copy()
    shift[:, :-1, 1] = interiors.shift[beside, 1][like].reshape(table.tile.shape)[:, 1:]
    return shift.reshape(-1, 4)


def _mean_of_pieces(
    stock: npt.NDArray[np.float32],
    kind: npt.NDArray[np.int32],
    first: npt.NDArray[np.int64],
    extent: npt.NDArray[np.int64],
) -> npt.NDArray[np.float64]:
    """Mean colour of each tile's piece, [tile, 3]; of what the stock has, where tiles are larger."""
    first = np.minimum(first, stock.shape[1] - 1)
    end = np.minimum(first + extent, stock.shape[1])
    means = np.zeros((len(kind), 3))
    for number, grain in enumerate(stock):
        sums = np.pad(grain.astype(np.float64).cumsum(axis=0).cumsum(axis=1), [(1, 0), (1, 0), (0, 0)])
        own = kind == number
        (top, left), (bottom, right) = first[own].T, end[own].T
        total = sums[bottom, right] - sums[top, right] - sums[bottom, left] + sums[top, left]
        means[own] = total / np.prod(end[own] - first[own], axis=1)[:, None]
    return means


@jax.jit
def _draw_pieces(key: Array, course: Array, tile: Array) -> Array:
    """Four numbers from 0 to 1 for each tile."""
    return jax.vmap(lambda c, t: jax.random.uniform(jax.random.fold_in(jax.random.fold_in(key, c), t), (4,)))(
        course, tile
    )
