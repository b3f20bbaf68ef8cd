"""The tiles near a pixel of a sheet: which they are, how far inside of their edges it lies, what it sees of them."""

from collections.abc import Callable
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from jaxtex.material.tables import Material


class Near(NamedTuple):
    """A tile that a pixel may show a part of.

    Attributes:
        entry: its place in the tables.
        inside_x, inside_y: how far inside the nearest of its edges the pixel's centre lies, along and across the
            course, negative outside.
        inward_x, inward_y: 1 where that grows with x or y, -1 where it shrinks.
    """

    entry: Array
    inside_x: Array
    inside_y: Array
    inward_x: Array
    inward_y: Array


def find_tiles(material: Material, q: Array) -> list[Near]:
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
        for step, inside_x, inward_x in ((0, to_head, -right), (right, -to_head, right)):
            entry = entry_of(material, place.course, place.tile + step)
            tile = Near(entry, inside_x - 0.5 * t.mortar_x, inside_y - 0.5 * t.mortar_y, inward_x, inward_y)
            near.append(tile)
    return near


def entry_of(material: Material, course: Array, tile: Array) -> Array:
    """A tile's place in the tables; of those beyond them, the nearest one's."""
    row = jnp.clip(course.astype(jnp.int32) - material.first_course, 0, material.shape[0] - 1)
    in_row = jnp.clip(tile.astype(jnp.int32) - material.first_tile[row], 0, material.shape[1] - 1)
    return row * material.shape[1] + in_row


def share_of(tile: Near, material: Material) -> Array:
    """How much of the pixel a tile covers."""
    return mean_over_pixel(_step, tile.inside_x, tile.inside_y, material)


def rise_of(tile: Near, material: Material, right: Array | float = 0.0, down: Array | float = 0.0) -> Array:
    """How high a tile stands in the pixel, from 0 outside of it to 1 on its face, a little to the right of the pixel's
    centre and a little below it.

    A tile's edge rises as a parabola, level where it meets the tile's face.
    """
    x, y = tile.inside_x + tile.inward_x * right, tile.inside_y + tile.inward_y * down
    return mean_over_pixel(_rise, x, y, material)


def joint_share(shares: list[Array]) -> Array:
    """How much of the pixel is joint."""
    return jnp.maximum(1.0 - total(shares), 0.0)


def total(shares: list[Array]) -> Array:
    """Of the tiles near a pixel, together."""
    return jnp.sum(jnp.stack(shares), axis=0)


def round_corner(x: Array, y: Array, radius: Array | None) -> tuple[Array, Array]:
    """Where a corner is rounded, the lesser of the two distances from the edges becomes the distance from the arc."""
    if radius is None:
        return x, y
    beyond_x, beyond_y = radius - x, radius - y
    in_corner = (beyond_x > 0) & (beyond_y > 0)
    # sqrt has no finite gradient at 0: where there is no corner it is taken of something else.
    reach = jnp.sqrt(jnp.where(in_corner, beyond_x**2 + beyond_y**2, 1.0))
    rounded = jnp.where(in_corner, radius - reach, jnp.inf)
    return jnp.where(x <= y, jnp.minimum(x, rounded), x), jnp.where(x > y, jnp.minimum(y, rounded), y)


def mean_over_pixel(profile: Callable[..., Array], x: Array, y: Array, material: Material) -> Array:
    """The mean over a pixel of a profile of the distances from the edges, along times across."""
    x, y = round_corner(x, y, material.corner_radius)
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
