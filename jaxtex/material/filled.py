"""Maps of tiles and joints with something inside: point functions that look up stocks of grain."""

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from jaxtex.core.colour import srgb_to_linear
from jaxtex.material.filling import Filling
from jaxtex.material.flat import sky_over
from jaxtex.material.near import Near, entry_of, joint_share, rise_of, round_corner, share_of, total
from jaxtex.material.tables import Material

_FAR = 1e6  # plane pixels: an edge that is not near


class _Face(NamedTuple):
    """A tile near a pixel: its entry in the tables, and how far inside of each edge the pixel's centre lies, [side]."""

    entry: Array
    inside: Array

    def near(self) -> Near:
        x, y = jnp.minimum(self.inside[0], self.inside[1]), jnp.minimum(self.inside[2], self.inside[3])
        still = jnp.zeros_like(x)
        return Near(self.entry, x, y, still, still)


class FilledPixel(NamedTuple):
    """Attributes:
    base_colour: linear light, (3,).
    joint: how much of the pixel is joint.
    occlusion: how much of an even sky lights it.
    tile_id: of the tile at its centre; -1 in joints.
    roughness: of tiles of wood; None where tiles are not.
    """

    base_colour: Array
    joint: Array
    occlusion: Array
    tile_id: Array
    roughness: Array | None


def look(material: Material, q: Array) -> FilledPixel:
    """What a pixel shows."""
    filling = _filling(material)
    faces = _find_faces(material, q)
    tiles = [face.near() for face in faces]
    shares = _at_most_all([share_of(tile, material) for tile in tiles])
    entries = jnp.stack([face.entry for face in faces])
    gap = joint_share(shares)
    colour = gap * _joint_colour(material, filling, faces, q)
    roughness = None
    if material.wood is None:
        for face, share in zip(faces, shares, strict=True):
            colour = colour + share * _tile_colour(material, filling, face, q)
    else:
        most = jnp.argmax(jnp.stack(shares))
        wood, roughness = material.wood.surface(entries[most], _pixel_at(material, q))
        share = jnp.stack(shares)[most]
        colour = colour + share * wood + (total(shares) - share) * material.wood.mean_colour()
    deepest = jnp.stack([jnp.minimum(*round_corner(t.inside_x, t.inside_y, material.corner_radius)) for t in tiles])
    entry = entries[jnp.argmax(deepest)]
    identity = jnp.where(jnp.max(deepest) >= 0, material.identity[entry], -1)
    risen = total(_at_most_all([rise_of(tile, material) for tile in tiles]))
    return FilledPixel(colour, gap, sky_over(tiles, risen, material), identity.astype(jnp.float32), roughness)


def height(material: Material, q: Array) -> Array:
    """In plane pixels above the joints' floor."""
    filling = _filling(material)
    faces = _find_faces(material, q)
    risen = _at_most_all([rise_of(face.near(), material) for face in faces])
    floor = jnp.maximum(1.0 - sum(risen), 0.0) * _joint_grain(material, filling, q)[3]
    if material.wood is not None:
        # Of the tile that counts most; that others share the pixel with it is nothing that shows in heights.
        entry = jnp.stack([face.entry for face in faces])[jnp.argmax(jnp.stack(risen))]
        return floor + sum(risen) * (material.relief[0] + material.wood.height(entry, _pixel_at(material, q)))
    heights = [
        rise * (material.relief[0] + filling.contrast[face.entry] * _tile_grain(material, filling, face.entry, q)[3])
        for rise, face in zip(risen, faces, strict=True)
    ]
    return floor + sum(heights)


def _at_most_all(shares: list[Array]) -> list[Array]:
    """Shares of the tiles near a pixel, where outlines may wobble across the whole joint: together no more than 1."""
    most = jnp.maximum(total(shares), 1.0)
    return [share / most for share in shares]


def _filling(material: Material) -> Filling:
    assert material.filling is not None
    return material.filling


def _find_faces(material: Material, q: Array) -> list[_Face]:
    """The tile at a point, then its neighbours along, across, and both, with the edges that they really have."""
    t, filling = material.tiling, _filling(material)
    own = t.locate(q)
    lower = own.bottom < own.top
    beside = t.locate(jnp.stack([q[0], (own.course + 0.5 + jnp.where(lower, 1, -1)) * t.tile_height]))
    far = jnp.full_like(own.top, _FAR)
    beyond = (jnp.where(lower, -own.bottom, far), jnp.where(lower, far, -own.top))
    joint = 0.5 * jnp.stack([t.mortar_x, t.mortar_x, t.mortar_y, t.mortar_y])
    faces = []
    for place, across in ((own, (own.top, own.bottom)), (beside, beyond)):
        right = place.right < place.left
        next_to = (jnp.where(right, -place.right, far), jnp.where(right, far, -place.left))
        for step, along in ((0, (place.left, place.right)), (jnp.where(right, 1, -1), next_to)):
            entry = entry_of(material, place.course, place.tile + step)
            row, column = _stock_place(material, filling.piece[entry], q, filling.tile_stock.shape[1])
            wobble = filling.tile_stock[filling.kind[entry], row, column, 4]
            faces.append(_Face(entry, jnp.stack([*along, *across]) - joint + filling.shift[entry] + wobble))
    return faces


def _tile_colour(material: Material, filling: Filling, face: _Face, q: Array) -> Array:
    """Linear light (3,)."""
    encoded = (
        filling.colour[face.entry] + filling.contrast[face.entry] * _tile_grain(material, filling, face.entry, q)[:3]
    )
    for side in range(4):
        encoded = encoded + _at_distance(filling.tile_profile, side, face.inside[side], beyond=0.0)
    return srgb_to_linear(jnp.clip(encoded, 0.0, 1.0))


def _joint_colour(material: Material, filling: Filling, faces: list[_Face], q: Array) -> Array:
    """Linear light (3,)."""
    insides = jnp.stack([face.inside for face in faces])
    outside = -jnp.min(insides, axis=1)  # of each face
    nearest = jnp.argmin(outside)
    side = jnp.argmin(insides[nearest])
    shade = _at_distance(filling.joint_profile, side, outside[nearest], beyond=1.0)
    return srgb_to_linear(jnp.clip(filling.joint + shade + _joint_grain(material, filling, q)[:3], 0.0, 1.0))


def _tile_grain(material: Material, filling: Filling, entry: Array, q: Array) -> Array:
    row, column = _stock_place(material, filling.piece[entry], q, filling.tile_stock.shape[1])
    return filling.tile_stock[filling.kind[entry], row, column]


def _joint_grain(material: Material, filling: Filling, q: Array) -> Array:
    """Each piece belongs to the joints on two sides of one tile, above it and to its left; from piece to piece there is
    a soft passage as long as a joint is thick, where grain keeps its strength."""
    t = material.tiling
    own = t.locate(q)
    to_bed = jnp.minimum(own.top, own.bottom)
    reach_x, reach_y = jnp.maximum(t.mortar_x, 1.0), jnp.maximum(t.mortar_y, 1.0)

    def piece(course: Array, tile: Array) -> Array:
        place = filling.joint_piece[entry_of(material, course, tile)]
        row, column = _stock_place(material, place, q, filling.joint_stock.shape[0])
        return filling.joint_stock[row, column]

    below = own.course + jnp.where(own.bottom < own.top, 1, 0)
    lower = t.locate(jnp.stack([q[0], (below + 0.5) * t.tile_height]))
    beside = jnp.where(lower.right < lower.left, 1, -1)
    to_head = jnp.minimum(lower.left, lower.right)
    bed = _pass_over(
        piece(below, lower.tile), piece(below, lower.tile + beside), jnp.clip(0.5 - 0.5 * to_head / reach_x, 0.0, 0.5)
    )
    head = piece(own.course, own.tile + jnp.where(own.right < own.left, 1, 0))
    return _pass_over(bed, head, jnp.clip(2.0 * to_bed / reach_y - 1.0, 0.0, 1.0))


def _pass_over(one: Array, other: Array, share: Array) -> Array:
    """A mixture of grains as strong as each of them."""
    return ((1.0 - share) * one + share * other) / jnp.sqrt((1.0 - share) ** 2 + share**2)


def _stock_place(material: Material, piece: Array, q: Array, side: int) -> tuple[Array, Array]:
    """Row and column of a stock that a map's pixel shows."""
    at = _pixel_at(material, q)
    return (at[1] + piece[0]) % side, (at[0] + piece[1]) % side


def _pixel_at(material: Material, q: Array) -> Array:
    """The map's pixel (x, y) at a point, in whole numbers from the sheet's corner."""
    return jnp.floor((q - _filling(material).corner) / material.pixel).astype(jnp.int32)


def _at_distance(profile: Array, side: Array | int, distance: Array, *, beyond: float) -> Array:
    """A side's profile at a distance from the edge; its last value times `beyond` past its end."""
    last = profile.shape[1] - 1
    at = jnp.clip(distance - 0.5, 0.0, last)
    low = jnp.floor(at).astype(jnp.int32)
    share = at - low
    value = (1.0 - share) * profile[side, low] + share * profile[side, jnp.minimum(low + 1, last)]
    return jnp.where(distance > last + 0.5, beyond * profile[side, last], value)
