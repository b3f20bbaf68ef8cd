"""How the expected mask changes with each parameter, pixel by pixel: the rows of the least-squares problem.

The model is differentiated in two parts that meet in four numbers per pixel, where its blurred spot lies in the lattice
and how wide it is there: forward from the view to these, backward from the coverage to these and to the tiles' own
sizes. Both parts see plain numbers only, one array for each, which compiles quickly and runs in few passes; the model
differentiated as a whole takes several times as long for both. Error functions, most of the work, are evaluated in
single precision: that costs 1e-7 of a full contrast, while all places stay double.
"""

import dataclasses
from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from jaxtex.fitting.parameters import SCALARS, build_tiling, from_free
from jaxtex.models.tiling import Tiling

_VIEW = ("angle", "origin_x", "origin_y", "tilt_x", "tilt_y", "shear")
_SIZES = ("tile_width", "tile_height", "mortar_x", "mortar_y")


def coverage_rows(free: Array, course_lengths: Array, centre: Array, points: Array, blur: Array) -> tuple[Array, Array]:
    """Square coverage (N,) at ``points`` (N, 2) blurred by ``blur``, and its derivatives (P, N) by ``free`` (P,).

    The tiling is that of :func:`jaxtex.fitting.parameters.build_tiling`.
    """
    tiling = build_tiling(free, course_lengths, centre)
    values, rates = jax.jvp(lambda free: from_free(free)[0], (free,), (jnp.ones_like(free),))
    x, y = points[:, 0] - centre[0], points[:, 1] - centre[1]
    view = [values[name] for name in _VIEW]
    spot, push = jax.linearize(lambda *view: _spot_in_lattice(view, x, y, blur), *view)
    by_view = jax.vmap(push)(*jnp.eye(len(_VIEW), dtype=free.dtype))

    courses = jax.vmap(tiling.near_courses, out_axes=1)(jnp.stack(spot[:2], axis=1))
    cycle = tiling.course_offsets.shape[0]
    slots = courses % cycle
    shifts = tiling.offset * courses + tiling.course_offsets[slots.astype(int)]
    parts, (by_spot, by_size, by_shift) = _slopes(spot, [values[name] for name in _SIZES], shifts, courses, tiling)

    rows = {name: jnp.zeros_like(x) for name in SCALARS}
    rows |= {name: each * rates[name] for name, each in zip(_SIZES, by_size, strict=True)}
    along_view = sum(each[None] * moved for each, moved in zip(by_spot, by_view, strict=True))
    rows |= dict(zip(_VIEW, along_view, strict=True))
    rows["offset"] = jnp.sum(by_shift * courses, axis=0)
    by_offset = jnp.sum(jnp.where(slots[None] == jnp.arange(cycle)[:, None, None], by_shift[None], 0.0), axis=1)
    return parts, jnp.concatenate([jnp.stack([rows[name] for name in SCALARS]), by_offset])


def _spot_in_lattice(view: Sequence[Array], x: Array, y: Array, blur: Array) -> tuple[Array, Array, Array, Array]:
    """Lattice coordinates of points (x, y) counted from the centre, and a spot's standard deviations along them.

    The same as the model's own with the homography of :mod:`jaxtex.models.perspective`, multiplied out.
    """
    angle, origin_x, origin_y, tilt_x, tilt_y, shear = view
    c, s = jnp.cos(angle), jnp.sin(angle)
    depth = 1.0 + tilt_x * x + tilt_y * y
    across = (c * y - s * x) / depth
    along = (c * x + s * y) / depth + shear * across
    tilt_along, tilt_across = c * tilt_x + s * tilt_y, c * tilt_y - s * tilt_x
    size = blur / jnp.abs(depth)
    return (
        along - (c * origin_x + s * origin_y),
        across - (c * origin_y - s * origin_x),
        size * jnp.sqrt((1.0 - along * tilt_along) ** 2 + (shear - along * tilt_across) ** 2),
        size * jnp.sqrt((across * tilt_along) ** 2 + (1.0 - across * tilt_across) ** 2),
    )


def _slopes(
    spot: tuple[Array, ...], sizes: list[Array], shifts: Array, courses: Array, tiling: Tiling
) -> tuple[Array, tuple[tuple[Array, ...], list[Array], Array]]:
    """Coverage (N,) by the near courses (2, N), and its derivatives by spot, sizes and shifts (2, N)."""

    def in_course(spot: tuple[Array, ...], sizes: list[Array], shift: Array, course: Array) -> Array:
        own: dict[str, Any] = dict(zip(_SIZES, sizes, strict=True))
        shifted = dataclasses.replace(tiling, **own, offset=jnp.zeros_like(shift), course_offsets=shift[None])
        seen = shifted.spot_in_course(spot[:2], spot[2:], course)
        return jax.tree.map(lambda inside: inside.astype(jnp.float32), seen).covered().astype(shift.dtype)

    slope = jax.value_and_grad(in_course, argnums=(0, 1, 2))
    over_points = jax.vmap(slope, in_axes=(0, None, 0, 0))
    over_courses = jax.vmap(over_points, in_axes=(None, None, 0, 0))
    parts, (by_spot, by_size, by_shift) = over_courses(spot, sizes, shifts, courses)
    by_spot, by_size = jax.tree.map(lambda each: jnp.sum(each, axis=0), (by_spot, by_size))
    return jnp.sum(parts, axis=0), (by_spot, by_size, by_shift)
