"""Perspective and shear of a picture, told apart from the lattice seen in it.

All views of a plane that leave lengths and angles at one point of the picture, its centre c, as they are seen there are

    x -> c + J (x - c) / (1 + tilt . (x - c)),    J = I + shear d n^T

with d the direction of the courses and n the direction across them. The two numbers of `tilt` are the perspective,
in 1/pixel; `shear` is what is left of an oblique view in the middle of the picture. Every homography is one of these,
followed by a change of the lattice's own scale, direction and place.
"""

import dataclasses

import jax
import jax.numpy as jnp
from jax import Array
from jax.typing import ArrayLike

from jaxtex.models.tiling import Tiling


def perspective_homography(centre: ArrayLike, tilt: ArrayLike, shear: ArrayLike, angle: ArrayLike) -> Array:
    """The homography that keeps `centre`, with H33 = 1; exactly the identity for no tilt and no shear.

    Args:
        centre: image point (x, y).
        tilt: (2,), in 1/pixel; the horizon is where 1 + tilt . (x - centre) = 0.
        shear: how far courses are moved along, per pixel across.
        angle: courses run along (cos angle, sin angle); radians.

    Examples:
        >>> perspective_homography([50.0, 40.0], [0.0, 0.0], 0.25, 0.0).tolist()
        [[1.0, 0.25, -10.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    """
    centre, tilt = jnp.asarray(centre), jnp.asarray(tilt)
    d, n = _directions(angle)
    jacobian = jnp.eye(2, dtype=d.dtype) + shear * jnp.outer(d, n)
    at_corner = 1.0 - jnp.sum(tilt * centre)
    linear = jacobian + jnp.outer(centre, tilt)
    constant = centre * at_corner - _times(jacobian, centre)
    upper = jnp.concatenate([linear, constant[:, None]], axis=1) / at_corner
    # The corner is written as 1: compiled, a number divided by itself need not be.
    lower = jnp.append(tilt / at_corner, jnp.ones_like(at_corner))
    return jnp.concatenate([upper, lower[None]])


def split_homography(homography: ArrayLike, centre: ArrayLike, angle: ArrayLike) -> tuple[Array, Array]:
    """The (tilt, shear) of a homography: the inverse of `perspective_homography`.

    For a homography that is not of that family, what `normalise_view` finds for courses that the picture shows
    at `angle`.
    """
    h, centre = jnp.asarray(homography), jnp.asarray(centre)
    d, n = _directions(angle)
    depth = jnp.sum(h[2, :2] * centre) + h[2, 2]
    plane = (_times(h[:2, :2], centre) + h[:2, 2]) / depth
    jacobian = (h[:2, :2] - jnp.outer(plane, h[2, :2])) / depth
    along, across = _times(jacobian, d), _times(jacobian, n)
    return h[2, :2] / depth, jnp.sum(along * across) / jnp.sum(along * along)


def normalise_view(tiling: Tiling, centre: ArrayLike) -> Tiling:
    """The same picture, with a homography that keeps `centre` and shows lengths and angles there as the image does.

    Scale, direction and place move from the homography into the tile sizes, joints, angle and origin. Differentiable,
    and the coverage is unchanged everywhere; but where the homography scales the two directions differently, rounded
    corners would become elliptic: they stay round, of the same area.

    Args:
        tiling: the model.
        centre: image point (x, y); for model files the middle of the picture (width / 2, height / 2).

    Examples:
        >>> from jaxtex.models.tiling import make_tiling
        >>> doubled = make_tiling(tile_width=80.0, tile_height=40.0, homography=[[2.0, 0, 0], [0, 2, 0], [0, 0, 1]])
        >>> float(normalise_view(doubled, [30.0, 20.0]).tile_width)
        40.0
    """
    centre = jnp.asarray(centre, dtype=jnp.result_type(tiling.homography))
    to_plane = jax.jacfwd(tiling.to_plane)(centre)
    c, s = jnp.cos(tiling.angle), jnp.sin(tiling.angle)
    along, across = c * to_plane[0] + s * to_plane[1], c * to_plane[1] - s * to_plane[0]
    scale_y = jnp.sqrt(jnp.sum(across * across))
    angle = jnp.arctan2(-across[0], across[1])
    d, n = _directions(angle)
    scale_x = jnp.sum(along * d)  # negative for a mirrored view: its courses run the other way
    q = tiling.to_lattice(centre) / jnp.stack([scale_x, scale_y])
    tilt, shear = split_homography(tiling.homography, centre, angle)
    forward, size_x = jnp.sign(scale_x), jnp.abs(scale_x)
    lengths = jnp.asarray(tiling.course_lengths)
    return dataclasses.replace(
        tiling,
        tile_width=tiling.tile_width / size_x,
        tile_height=tiling.tile_height / scale_y,
        angle=angle,
        mortar_x=tiling.mortar_x / size_x,
        mortar_y=tiling.mortar_y / scale_y,
        offset=tiling.offset * forward,
        origin=centre - q[0] * d - q[1] * n,
        homography=perspective_homography(centre, tilt, shear, angle),
        corner_radius=tiling.corner_radius / jnp.sqrt(size_x * scale_y),
        course_offsets=tiling.course_offsets * forward,
        course_lengths=jnp.where(forward < 0, lengths[:, ::-1], lengths),
    )


def _directions(angle: ArrayLike) -> tuple[Array, Array]:
    c, s = jnp.cos(angle), jnp.sin(angle)
    return jnp.stack([c, s]), jnp.stack([-s, c])


def _times(matrix: Array, vector: Array) -> Array:
    """Their product, in full precision also on accelerators that round the factors of matrix products."""
    return jnp.sum(matrix * vector[None, :], axis=1)
