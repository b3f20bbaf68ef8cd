"""Solid textures as colours: of any points, carved meshes, cuts, and of the block itself with a corner cut away."""

import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array
from scipy import fft

from jaxtex.core.errors import InputError
from jaxtex.io.meshes import Mesh
from jaxtex.material.bands import check_sides, evaluate_chunks, evaluate_points, in_bands
from jaxtex.material.carving import mean_edge, place_mesh
from jaxtex.models.solid import Solid

_SPOT = 0.5  # voxels: standard deviation of what trilinear sampling sees anyway
_ROWS_AT_ONCE = 16  # of pixels evaluated at once

# How a block is looked at: from in front, turned to its right side, and from above.
_TURN, _RISE = math.radians(35), math.radians(28)
_LIGHT = 0.5, 1.0, 0.8  # on faces across x (the right one), y (the top) and z (the front)
_INSIDE = 0.85  # of that, within the corner that is cut away
_BACKGROUND = 0.75
_FARTHEST = 2.0**20  # voxels from the origin: beyond, single precision does not tell a sixteenth of one
_LARGEST_SCALE = 1e4
_MARGIN = 0.04  # of the picture, on each side
_SAMPLES = 4  # to a pixel, along and across


def evaluate_solid(solid: Solid, points: npt.NDArray[np.floating]) -> npt.NDArray[np.float32]:
    """Colours of points, 16 384 at a time: memory beside the block and the result is bounded.

    Args:
        solid: the texture.
        points: [point, 3], (x, y, z) as `Solid` has them.

    Returns:
        [point, channel], linear light.

    Raises:
        ValueError: points of another shape.

    Examples:
        >>> from jaxtex.models.solid import make_solid
        >>> ramp = make_solid(np.arange(24.0).reshape(2, 3, 4, 1))
        >>> evaluate_solid(ramp, np.array([[1.5, 0.5, 0.5], [5.5, 0.5, 0.5]])).tolist()
        [[1.0], [1.0]]
    """
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"points of shape {points.shape} are none of space; give [point, 3]")
    return evaluate_chunks(lambda chunk: _colours(solid, chunk), points)


def carve_solid(solid: Solid, mesh: Mesh, *, scale: float = 1.0) -> npt.NDArray[np.float32]:
    """Colours of a mesh's vertices, as if it were carved of the solid.

    The mesh's middle is the block's. A vertex sees a spot of half the mean edge length, so that what is finer than the
    mesh fades instead of flickering.

    Args:
        solid: the texture.
        mesh: of any size; axes as `place_mesh` has them.
        scale: how many times as long as the block's longest side the mesh's bounding box is, > 0.

    Returns:
        [vertex, 3], linear light; grey blocks give grey.

    Raises:
        InputError: as `place_mesh`; a scale that is none; a block of other than 1 or 3 channels.
    """
    placed = place_in_solid(solid, mesh, scale=scale)
    colours = evaluate_solid(blur_solid(solid, 0.5 * mean_edge(placed, mesh.faces)), placed)
    return np.ascontiguousarray(np.broadcast_to(colours, (len(colours), 3)))


def place_in_solid(solid: Solid, mesh: Mesh, *, scale: float) -> npt.NDArray[np.float64]:
    """Where the vertices [vertex, 3] of a mesh lie in a solid that it is carved of, as `carve_solid` has it.

    Raises:
        InputError: as `carve_solid`.
    """
    if not 0 < scale <= _LARGEST_SCALE:
        raise InputError(f"scale: {scale:g} is none; give a number above 0, at most {_LARGEST_SCALE:g}")
    _check_colours(solid)
    return place_mesh(mesh, longest=scale * max(solid.size)) + 0.5 * np.array(solid.size)


def blur_solid(solid: Solid, spot: float) -> Solid:
    """A solid seen through a Gaussian spot.

    Args:
        solid: the texture.
        spot: standard deviation in voxels; up to half a voxel, which sampling sees anyway, the solid stays as it is.

    Examples:
        >>> from jaxtex.models.solid import make_solid
        >>> checks = make_solid(np.indices((4, 4, 4)).sum(axis=0)[..., None] % 2.0)
        >>> blur_solid(checks, 4.0).voxels.std().round(3).item()
        0.0
    """
    if spot <= _SPOT:
        return solid
    spectrum = fft.rfftn(np.asarray(solid.voxels, np.float32), axes=(0, 1, 2))
    for axis, side in enumerate(solid.voxels.shape[:3]):
        frequency = fft.rfftfreq(side) if axis == 2 else fft.fftfreq(side)
        seen = np.exp(-2 * np.square(np.pi * spot * frequency)).astype(np.float32)
        spectrum *= np.expand_dims(seen, [other for other in range(4) if other != axis])
    return Solid(jnp.asarray(fft.irfftn(spectrum, solid.voxels.shape[:3], axes=(0, 1, 2))), solid.offsets)


def cut_solid(
    solid: Solid, *, origin: npt.ArrayLike, across: npt.ArrayLike, down: npt.ArrayLike, size: tuple[int, int]
) -> npt.NDArray[np.float32]:
    """The picture that a plane cut shows; the centre of its pixel (row, col) is the point
    `origin + (col + 0.5) across + (row + 0.5) down`.

    Args:
        solid: the texture.
        origin: (3,), the picture's upper left corner, in voxels.
        across, down: (3,), one pixel's step to the right and downwards, in voxels.
        size: (width, height) of the picture in pixels.

    Returns:
        [row, col, channel], linear light.

    Raises:
        InputError: vectors of other than three finite numbers, or that span no plane; sizes as `check_sides`.

    Examples:
        >>> from jaxtex.models.solid import make_solid
        >>> ramp = make_solid(np.arange(24.0).reshape(2, 3, 4, 1))
        >>> cut_solid(ramp, origin=(0, 0, 1.5), across=(1, 0, 0), down=(0, 1, 0), size=(4, 3))[..., 0].tolist()
        [[12.0, 13.0, 14.0, 15.0], [16.0, 17.0, 18.0, 19.0], [20.0, 21.0, 22.0, 23.0]]
    """
    check_sides(size)
    vectors = {"origin": origin, "across": across, "down": down}
    plane = {name: np.asarray(vector, np.float64) for name, vector in vectors.items()}
    for name, vector in plane.items():
        if vector.shape != (3,) or not np.isfinite(vector).all():
            raise InputError(f"{name}: {vector.tolist()} is no vector; give three finite numbers, x, y and z")
    ends = [plane["origin"] + x * plane["across"] + y * plane["down"] for x in (0, size[0]) for y in (0, size[1])]
    if np.abs(ends).max() > _FARTHEST:
        raise InputError(f"the cut reaches {np.abs(ends).max():.3g} voxels far; stay within {_FARTHEST:g}")
    if not np.linalg.norm(np.cross(plane["across"], plane["down"])) > 0:
        raise InputError("across and down span no plane; give two directions that are not parallel")
    cut = _Cut(solid, **{name: jnp.asarray(vector, jnp.float32) for name, vector in plane.items()})
    bands = in_bands(
        lambda x, y: (np.asarray(evaluate_points(_colour_on_cut, cut, x, y, rows=_ROWS_AT_ONCE)),),
        corner=(0, 0),
        extent=size,
        size=size,
    )
    return np.concatenate([band for (band,) in bands])


def draw_block(solid: Solid, *, size: tuple[int, int] = (512, 512)) -> npt.NDArray[np.float32]:
    """A picture of the block, with the corner nearest to the viewer cut away: its three visible faces, and three inside
    it (as in figure 1 of J.-M. Dischler, D. Ghazanfarpour and R. Freydier 1998, but with a corner cut).

    It is seen without perspective, from in front (the face z = 0, x to the right and y down), turned to its right side,
    and from above. Each of the faces has a light of its own.

    Args:
        solid: the texture; faces show its outermost voxels, not those half-way to where it repeats.
        size: (width, height) of the picture in pixels. The block fills it, but for a margin.

    Returns:
        [row, col, 3], linear light, on light grey.

    Raises:
        InputError: a block of other than 1 or 3 channels; sizes as `check_sides`.

    Examples:
        >>> from jaxtex.models.solid import make_solid
        >>> draw_block(make_solid(np.full((4, 4, 4, 3), 0.5)), size=(40, 40))[20, 10].round(3).tolist()
        [0.4..., 0.4..., 0.4...]
    """
    check_sides(size)
    _check_colours(solid)
    right, down, _ = (np.abs(axis) for axis in _view_axes())
    sides = np.array(solid.size, float)
    voxels = max(float(side) / pixels for side, pixels in zip((right @ sides, down @ sides), size, strict=True))
    extent = tuple(pixels * voxels / (1 - 2 * _MARGIN) for pixels in size)
    bands = in_bands(
        lambda x, y: (np.asarray(evaluate_points(_colour_of_block, solid, x, y, rows=_ROWS_AT_ONCE)),),
        corner=(-extent[0] / 2, -extent[1] / 2),
        extent=(extent[0], extent[1]),
        size=(_SAMPLES * size[0], _SAMPLES * size[1]),
    )
    return np.concatenate([_average_samples(band) for (band,) in bands])


class _Cut(eqx.Module):
    solid: Solid
    origin: Array
    across: Array
    down: Array


def _colour_on_cut(cut: _Cut, at: Array) -> Array:
    return cut.solid.colour(cut.origin + at[0] * cut.across + at[1] * cut.down)


@jax.jit
def _colours(solid: Solid, points: Array) -> Array:
    return jax.vmap(solid.colour)(points)


def _check_colours(solid: Solid) -> None:
    channels = solid.voxels.shape[-1]
    if channels not in (1, 3):
        raise InputError(f"the block has {channels} channels, which are no colours; give one of 1 (grey) or 3")


def _view_axes() -> tuple[npt.NDArray[np.float64], ...]:
    """Unit vectors (3,) of the solid that point to the picture's right, down, and away from the viewer."""
    right = np.array([math.cos(_TURN), 0.0, math.sin(_TURN)])
    away = np.array([-math.cos(_RISE) * right[2], math.sin(_RISE), math.cos(_RISE) * right[0]])
    return right, np.cross(away, right), away


def _colour_of_block(solid: Solid, at: Array) -> Array:
    """What a ray (2,), in voxels from the picture's middle, meets first: a face, one within the cut, or nothing."""
    right, down, away = (jnp.asarray(axis, jnp.float32) for axis in _view_axes())
    sides = jnp.array(solid.size, jnp.float32)
    start = sides / 2 + at[0] * right + at[1] * down
    front, back = jnp.where(away > 0, 0.0, sides), jnp.where(away > 0, sides, 0.0)
    # Along the ray, how far planes across each axis are: the block's in front, those behind, those of the cut, which
    # goes to the middle of a voxel.
    enters, leaves, cuts = ((plane - start) / away for plane in (front, back, jnp.floor(sides / 2) + 0.5))
    entry, end = jnp.max(enters), jnp.min(cuts)
    is_inside = end > entry
    axis = jnp.where(is_inside, jnp.argmin(cuts), jnp.argmax(enters))
    place = jnp.clip(start + jnp.where(is_inside, end, entry) * away, 0.5, sides - 0.5)
    light = jnp.array(_LIGHT, jnp.float32)[axis] * jnp.where(is_inside, _INSIDE, 1.0)
    colour = jnp.broadcast_to(light * solid.colour(place), (3,))
    return jnp.where(entry < jnp.min(leaves), colour, _BACKGROUND)


def _average_samples(band: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    rows, columns, channels = band.shape
    samples = band.reshape(rows // _SAMPLES, _SAMPLES, columns // _SAMPLES, _SAMPLES, channels)
    return samples.mean(axis=(1, 3), dtype=np.float32)
