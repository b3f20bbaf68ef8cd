"""Material maps of a sheet: base colour, height, normal, roughness and tile ids, from functions of one point.

What a pixel shows is the mean over the rectangle it covers, exactly so but for rounded corners: a map made at half the
resolution is the larger map with each four pixels averaged.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.core.errors import InputError
from jaxtex.material.appearance import Appearance, pad_table
from jaxtex.material.bands import LONGEST_SIDE as LONGEST_SIDE
from jaxtex.material.bands import check_sides, evaluate_points, in_bands, normals_of
from jaxtex.material.sheet import Sheet
from jaxtex.models.tiling import Tiling

MOST_TILES = 4_000_000
"""More are refused; the ids of up to 16 million would be exact."""

_FEWEST = 4  # pixels across the narrowest tile


class Maps(NamedTuple):
    """Some rows of the maps of a sheet.

    Attributes:
        base_colour: linear light, [row, col, 3], 0 to 1.
        height: in plane pixels above the joints' floor, [row, col].
        normal: unit vectors, [row, col, 3]: x right, y up, z out of the sheet (OpenGL's).
        roughness: 0 to 1, [row, col].
        tile_id: the id of the tile at the pixel's centre as a whole number from 0, -1 in joints, [row, col].
    """

    base_colour: npt.NDArray[np.float32]
    height: npt.NDArray[np.float32]
    normal: npt.NDArray[np.float32]
    roughness: npt.NDArray[np.float32]
    tile_id: npt.NDArray[np.float32]


def render_maps(sheet: Sheet, appearance: Appearance, *, size: tuple[int, int], key: Array) -> Iterator[Maps]:
    """Render the material maps of a sheet, some rows at a time from top to bottom.

    The maps cover the sheet exactly: where `size` has another ratio of sides, pixels are not square, and heights and
    slopes stay those of the sheet. Memory is that of a band of 128 rows, whatever the size. The maps of a seamless
    sheet go on, beyond their last row and column, with their first.

    Args:
        size: (width, height) in pixels.
        key: random key of the colours of tiles that were not seen; a tile's colour depends on nothing else.

    Raises:
        InputError: a size without pixels, beyond `LONGEST_SIDE`, or with too few pixels for the sheet's tiles.

    Examples:
        >>> grey = Appearance(tiles={(0, 0): (0.3, 0.3, 0.3)}, joint=(0.5, 0.5, 0.5), joint_depth=2.0, edge_width=2.0)
        >>> from jaxtex.material.sheet import lay_sheet
        >>> from jaxtex.models.tiling import make_tiling
        >>> sheet = lay_sheet(make_tiling(tile_width=60, tile_height=20, offset=0.5), tiles=(2, 4))
        >>> rows = list(render_maps(sheet, grey, size=(64, 200), key=jax.random.key(0)))
        >>> [part.height.shape for part in rows]
        [(128, 64), (72, 64)]
    """
    _check_size(sheet, size)
    return _render_bands(sheet, appearance, size, key)


def _check_size(sheet: Sheet, size: tuple[int, int]) -> None:
    check_sides(size)
    shortest = float(np.min(sheet.tiling.course_lengths))
    if sheet.along / shortest * sheet.rows > MOST_TILES:
        raise InputError(f"{sheet.columns:g} x {sheet.rows} tiles: are too many; at most {MOST_TILES:,} can be made")
    across = size[0] / sheet.along * shortest
    along = size[1] / sheet.rows
    if min(across, along) < _FEWEST:
        raise InputError(
            f"size {size[0]} x {size[1]}: is too small for {sheet.columns:g} x {sheet.rows} tiles, as it leaves "
            f"{min(across, along):.2g} pixels to a tile; give at least {_FEWEST}, or fewer tiles"
        )


def _render_bands(sheet: Sheet, appearance: Appearance, size: tuple[int, int], key: Array) -> Iterator[Maps]:
    material = _make_material(sheet, appearance, size, key)
    extent = sheet.width, sheet.height
    return in_bands(lambda x, y: _render_grid(material, x, y), corner=sheet.corner, extent=extent, size=size)


class _Material(eqx.Module):
    """All that a pixel of a sheet depends on but its place.

    Tables are padded, so that sheets of about as many tiles share compiled code.
    """

    tiling: Tiling
    first_course: Array  # course of the first row of tiles, the one above the sheet
    shape: Array  # rows and tiles to a row
    first_tile: Array  # by row
    colours: Array  # by row and place in the row, as one index
    identity: Array  # likewise
    joint: Array
    corner_radius: Array | None  # None where corners are square: most are, and need but half of the code
    relief: Array  # joint depth, width of the tiles' edges
    roughness: Array  # of tiles, of joints
    pixel: Array  # width and height of a pixel, in plane pixels


def _make_material(sheet: Sheet, appearance: Appearance, size: tuple[int, int], key: Array) -> _Material:
    table, radius = sheet.table(), float(sheet.tiling.corner_radius)
    colours = appearance.colours(table.course, table.tile, key=key)
    return _Material(
        tiling=jax.tree.map(lambda leaf: jnp.asarray(leaf, jnp.float32), sheet.tiling),
        first_course=jnp.asarray(sheet.first_course - 1, jnp.int32),
        shape=jnp.asarray(table.tile.shape, jnp.int32),
        first_tile=jnp.asarray(pad_table(table.first)),
        colours=jnp.asarray(pad_table(colours.reshape(-1, 3))),
        identity=jnp.asarray(pad_table(table.identity.ravel())),
        joint=jnp.asarray(appearance.joint, jnp.float32),
        corner_radius=jnp.asarray(radius, jnp.float32) if radius > 0 else None,
        relief=jnp.asarray([appearance.joint_depth, appearance.edge_width], jnp.float32),
        roughness=jnp.asarray([appearance.tile_roughness, appearance.joint_roughness], jnp.float32),
        pixel=jnp.asarray([sheet.width / size[0], sheet.height / size[1]], jnp.float32),
    )


def _render_grid(material: _Material, x: Array, y: Array) -> Maps:
    # One kernel for each: a map of one value per pixel is compiled into a single loop, all of them together are not,
    # and take five times as long.
    slope_x, slope_y = (evaluate_points(function, material, x, y) for function in (_slope_x, _slope_y))
    maps = (
        evaluate_points(_base_colour, material, x, y),
        evaluate_points(_height, material, x, y),
        normals_of(slope_x, slope_y),
        evaluate_points(_roughness, material, x, y),
        evaluate_points(_tile_id, material, x, y),
    )
    return Maps(*map(np.asarray, maps))


def _base_colour(material: _Material, q: Array) -> Array:
    tiles = _find_tiles(material, q)
    shares = [_share(tile, material) for tile in tiles]
    colour = _joint_share(shares) * material.joint
    for tile, share in zip(tiles, shares, strict=True):
        colour = colour + share * material.colours[tile.entry]
    return colour


def _roughness(material: _Material, q: Array) -> Array:
    joint = _joint_share([_share(tile, material) for tile in _find_tiles(material, q)])
    return material.roughness[0] + joint * (material.roughness[1] - material.roughness[0])


def _tile_id(material: _Material, q: Array) -> Array:
    own = _find_tiles(material, q)[0]
    x, y = _round_corner(own.inside_x, own.inside_y, material.corner_radius)
    return jnp.where(jnp.minimum(x, y) >= 0, material.identity[own.entry], -1).astype(jnp.float32)


def _height(material: _Material, q: Array) -> Array:
    return _height_beside(0.0, 0.0, _find_tiles(material, q), material)


def _slope_x(material: _Material, q: Array) -> Array:
    return jax.grad(_height_beside, argnums=0)(0.0, 0.0, _find_tiles(material, q), material)


def _slope_y(material: _Material, q: Array) -> Array:
    return jax.grad(_height_beside, argnums=1)(0.0, 0.0, _find_tiles(material, q), material)


def _height_beside(right: Array | float, down: Array | float, tiles: "list[_Near]", material: _Material) -> Array:
    """The height a little to the right of the pixel's centre and a little below it.

    Joints have a flat floor at 0; a tile's edge rises from there as a parabola, level where it meets the tile's face.
    """
    rises = [
        _mean_over_pixel(_rise, tile.inside_x + tile.inward_x * right, tile.inside_y + tile.inward_y * down, material)
        for tile in tiles
    ]
    return material.relief[0] * sum(rises)


def _share(tile: "_Near", material: _Material) -> Array:
    """How much of the pixel a tile covers."""
    return _mean_over_pixel(_step, tile.inside_x, tile.inside_y, material)


def _joint_share(shares: list[Array]) -> Array:
    return jnp.maximum(1.0 - sum(shares), 0.0)


class _Near(NamedTuple):
    """A tile that a pixel may show a part of: its entry in the tables, and how far inside the nearest of its edges the
    pixel's centre lies, along (x) and across (y) the course, negative outside. `inward` is 1 where that grows with x or
    y, -1 where it shrinks."""

    entry: Array
    inside_x: Array
    inside_y: Array
    inward_x: Array
    inward_y: Array


def _find_tiles(material: _Material, q: Array) -> list[_Near]:
    """The tile at a point, then its neighbours along, across, and both."""
    t = material.tiling
    own = t.locate(q)
    down = jnp.where(own.bottom < own.top, 1, -1)
    beside = t.locate(jnp.stack([q[0], (own.course + 0.5 + down) * t.tile_height]))
    to_bed = jnp.minimum(own.top, own.bottom)
    near = []
    for place, inside_y, inward_y in ((own, to_bed, -down), (beside, -to_bed, down)):
        right = jnp.where(place.right < place.left, 1, -1)
        to_head = jnp.minimum(place.left, place.right)
        row = jnp.clip(place.course.astype(jnp.int32) - material.first_course, 0, material.shape[0] - 1)
        for step, inside_x, inward_x in ((0, to_head, -right), (right, -to_head, right)):
            in_row = jnp.clip(place.tile.astype(jnp.int32) + step - material.first_tile[row], 0, material.shape[1] - 1)
            near.append(
                _Near(
                    entry=row * material.shape[1] + in_row,
                    inside_x=inside_x - 0.5 * t.mortar_x,
                    inside_y=inside_y - 0.5 * t.mortar_y,
                    inward_x=inward_x,
                    inward_y=inward_y,
                )
            )
    return near


def _round_corner(x: Array, y: Array, radius: Array | None) -> tuple[Array, Array]:
    """Where a corner is rounded, the lesser of the two distances from the edges becomes the distance from the arc."""
    if radius is None:
        return x, y
    beyond_x, beyond_y = radius - x, radius - y
    in_corner = (beyond_x > 0) & (beyond_y > 0)
    # sqrt has no finite gradient at 0: where there is no corner it is taken of something else.
    reach = jnp.sqrt(jnp.where(in_corner, beyond_x**2 + beyond_y**2, 1.0))
    rounded = jnp.where(in_corner, radius - reach, jnp.inf)
    return jnp.where(x <= y, jnp.minimum(x, rounded), x), jnp.where(x > y, jnp.minimum(y, rounded), y)


def _mean_over_pixel(profile: Callable[..., Array], x: Array, y: Array, material: _Material) -> Array:
    """The mean over a pixel of a profile of the distances from the edges, along times across."""
    x, y = _round_corner(x, y, material.corner_radius)
    edge = material.relief[1]
    return profile(x, material.pixel[0], edge) * profile(y, material.pixel[1], edge)


def _step(inside: Array, pixel: Array, edge: Array) -> Array:
    """Mean over a pixel of the step from 0 outside to 1 inside."""
    return jnp.clip(inside / pixel + 0.5, 0.0, 1.0)


def _rise(inside: Array, pixel: Array, edge: Array) -> Array:
    """Mean over a pixel of 0 outside, u (2 - u) at u edge widths inside, 1 from one edge width on."""

    def integral(d: Array) -> Array:
        u = jnp.clip(d / jnp.maximum(edge, 1e-6), 0.0, 1.0)
        return jnp.maximum(edge, 1e-6) * (u * u - u**3 / 3.0 - u) + jnp.clip(d, 0.0)

    centre = jnp.clip(inside, -pixel, edge + pixel)  # far from the edge nothing changes, and digits are not lost
    return (integral(centre + 0.5 * pixel) - integral(centre - 0.5 * pixel)) / pixel
