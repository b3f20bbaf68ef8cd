"""Maps of flat tiles: point functions, exact means over the pixel."""

import jax
import jax.numpy as jnp
from jax import Array

from jaxtex.material.near import Near, find_tiles, joint_share, rise_of, round_corner, share_of, total
from jaxtex.material.tables import Material


def base_colour(material: Material, q: Array) -> Array:
    """Linear light (3,)."""
    tiles = find_tiles(material, q)
    shares = [share_of(tile, material) for tile in tiles]
    colour = joint_share(shares) * material.joint
    for tile, share in zip(tiles, shares, strict=True):
        colour = colour + share * material.colours[tile.entry]
    return colour


def joint(material: Material, q: Array) -> Array:
    """How much of the pixel is joint."""
    return joint_share([share_of(tile, material) for tile in find_tiles(material, q)])


def tile_id(material: Material, q: Array) -> Array:
    """The id of the tile at the pixel's centre; -1 in joints."""
    own = find_tiles(material, q)[0]
    x, y = round_corner(own.inside_x, own.inside_y, material.corner_radius)
    return jnp.where(jnp.minimum(x, y) >= 0, material.identity[own.entry], -1).astype(jnp.float32)


def height(material: Material, q: Array) -> Array:
    """In plane pixels above the joints' floor, which is flat."""
    return _height_beside(0.0, 0.0, find_tiles(material, q), material)


def slope_x(material: Material, q: Array) -> Array:
    """Of the height, to the right."""
    return jax.grad(_height_beside, argnums=0)(0.0, 0.0, find_tiles(material, q), material)


def slope_y(material: Material, q: Array) -> Array:
    """Of the height, downwards."""
    return jax.grad(_height_beside, argnums=1)(0.0, 0.0, find_tiles(material, q), material)


def occlusion(material: Material, q: Array) -> Array:
    """How much of an even sky lights the point, 0 to 1."""
    tiles = find_tiles(material, q)
    return sky_over(tiles, total([rise_of(tile, material) for tile in tiles]), material)


def sky_over(tiles: list[Near], risen: Array, material: Material) -> Array:
    """The share of an even sky's light that reaches a point of a joint, or of a tile's rounded edge.

    Joints are seen as long trenches between the faces of tiles: the share is the mean of the sines of the angles,
    from the normal, under which the trench's two rims are seen. Where trenches cross, the more open one counts.

    Args:
        tiles: near the point.
        risen: how high the surface is there, from 0 in joints to 1 on faces.
    """
    depth = material.relief[0] * (1.0 - risen)
    inside_x = jnp.max(jnp.stack([tile.inside_x for tile in tiles]))
    inside_y = jnp.max(jnp.stack([tile.inside_y for tile in tiles]))
    # A joint is as thick as its two tiles leave it; the first three tiles are its own, one beside, one above or below.
    across = _open_sky(inside_x, -(tiles[0].inside_x + tiles[1].inside_x), depth)
    down = _open_sky(inside_y, -(tiles[0].inside_y + tiles[2].inside_y), depth)
    crossing = (inside_x < 0) & (inside_y < 0)
    return jnp.where(crossing, jnp.maximum(across, down), across * down)


def _open_sky(inside: Array, thickness: Array, depth: Array) -> Array:
    outside = jnp.maximum(-inside, 0.0)

    def sine(rim: Array) -> Array:
        return rim / jnp.sqrt(rim**2 + depth**2 + 1e-12)

    near = jnp.where(inside < 0, sine(outside), 1.0)
    far = sine(jnp.maximum(thickness + inside, 1e-3))
    return 0.5 * (near + far)


def _height_beside(right: Array | float, down: Array | float, tiles: list[Near], material: Material) -> Array:
    return material.relief[0] * sum(rise_of(tile, material, right, down) for tile in tiles)
