"""Wood as a material: maps of a plank, blocks of voxels, and anything carved of it.

The solid's points are (x, y, z) in pixels of the photograph, from its middle: x right, y down, z into the plank.
"""

import dataclasses
import math
from collections.abc import Iterator
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.core.errors import InputError
from jaxtex.io.meshes import Mesh
from jaxtex.material.bands import CHUNK, check_sides, evaluate_chunks, evaluate_points, in_bands, normals_of
from jaxtex.material.carving import mean_edge, place_mesh
from jaxtex.material.finish import BARE_WOOD, WoodFinish
from jaxtex.models.wood import Wood

MOST_VOXELS = 1 << 30
"""Larger blocks are refused: this many are a file of 12 GiB."""

_COSINES = 32  # in a row or column, or a multiple of it
ROWS_AT_ONCE = 4  # evaluated at once: each point takes 48 waves
SPOT = 0.5  # standard deviation of what a pixel sees, in pixels
RELIEF = 0.02  # of the ring spacing: how high late wood stands
ROUNDING = 0.06  # likewise: how soft its edges are


class WoodMaps(NamedTuple):
    """Some rows of the maps of a plank.

    Attributes:
        base_colour: linear light, [row, col, 3].
        height: in pixels of the photograph above early wood, [row, col].
        normal: unit vectors, [row, col, 3]: x right, y up, z out of the plank (OpenGL's).
        roughness: 0 to 1, [row, col].
        specular, metallic: as `jaxtex.material.maps.Maps` has them.
    """

    base_colour: npt.NDArray[np.float32]
    height: npt.NDArray[np.float32]
    normal: npt.NDArray[np.float32]
    roughness: npt.NDArray[np.float32]
    specular: npt.NDArray[np.float32]
    metallic: npt.NDArray[np.float32]


def render_wood(
    wood: Wood, *, across: float, size: tuple[int, int], finish: WoodFinish = BARE_WOOD
) -> Iterator[WoodMaps]:
    """Render the maps of a plank, some rows at a time from top to bottom.

    Pixels are square. The middle of the maps is that of the photograph; maps that are longer than it show more wood.
    Late wood, the harder, stands higher by 2 % of the ring spacing, which cannot be seen on a photograph and is chosen,
    as is the finish. Memory is that of a band of 128 rows, whatever the size.

    Args:
        wood: the model.
        across: pixels of the photograph that the maps' width covers; the photograph's width as a rule.
        size: (width, height) of the maps in pixels.
        finish: of early and of late wood.

    Raises:
        InputError: a size without pixels, or too large.

    Examples:
        >>> from jaxtex.models.wood import make_wood
        >>> bands = list(render_wood(make_wood(ring_spacing=20.0), across=100.0, size=(200, 150)))
        >>> [band.base_colour.shape for band in bands]
        [(128, 200, 3), (22, 200, 3)]
    """
    check_sides(size)
    scale = across / size[0]
    plank = _Plank(in_single(wood), jnp.asarray(SPOT * scale, jnp.float32), _finish_table(finish))
    extent = across, size[1] * scale
    corner = -0.5 * extent[0], -0.5 * extent[1]
    return in_bands(lambda x, y: _render_grid(plank, x, y), corner=corner, extent=extent, size=size)


def render_points(wood: Wood, points: npt.NDArray[np.floating], *, spot: float = SPOT) -> npt.NDArray[np.float32]:
    """Colours of points of the solid.

    Args:
        wood: the model.
        points: [point, 3].
        spot: standard deviation of the Gaussian that the colour is averaged over, in pixels of the photograph.

    Returns:
        [point, 3], linear light.

    Examples:
        >>> from jaxtex.models.wood import make_wood
        >>> pale = make_wood(ring_spacing=20.0, early_rgb=(0.6, 0.4, 0.2))
        >>> render_points(pale, np.array([[45.0, 0.0, 0.0]])).round(2).tolist()[0][0]
        0.6000000238418579
    """
    single, blur = in_single(wood), jnp.asarray(spot, jnp.float32)
    return evaluate_chunks(lambda chunk: _colours(single, chunk, blur), points)


def look_at_plank(
    wood: Wood, points: npt.NDArray[np.floating], *, spot: float, finish: WoodFinish = BARE_WOOD
) -> WoodMaps:
    """The maps at points of a plank's face.

    Args:
        wood: the model.
        points: [point, 2], (u, v) from the plank's middle.
        spot: as `render_points` has it.
        finish: of early and of late wood.

    Returns:
        Maps whose one axis, before that of channels, is [point].
    """
    plank = _Plank(in_single(wood), jnp.asarray(spot, jnp.float32), _finish_table(finish))
    return WoodMaps(*evaluate_chunks(lambda chunk: _look(plank, chunk), points))


def render_block(wood: Wood, *, shape: tuple[int, int, int]) -> Iterator[npt.NDArray[np.float32]]:
    """Render a block of voxels, some at a time; a voxel is as large as a pixel of the photograph.

    The first slice is the photographed face, about the photograph's middle; the others lie below it. Memory is that of
    16 384 voxels, whatever the block.

    Args:
        wood: the model.
        shape: (depth, height, width) in voxels.

    Returns:
        Parts [voxel, 3], linear light: row by row, slice by slice.

    Raises:
        InputError: a shape without voxels, or more than `MOST_VOXELS`.

    Examples:
        >>> from jaxtex.models.wood import make_wood
        >>> parts = render_block(make_wood(ring_spacing=8.0), shape=(2, 4, 6))
        >>> np.concatenate(list(parts)).reshape(2, 4, 6, 3).shape
        (2, 4, 6, 3)
    """
    depth, height, width = shape
    told = f"block {depth} x {height} x {width}"
    if min(shape) < 1:
        raise InputError(f"{told}: holds no voxels; give at least 1 x 1 x 1")
    if depth * height * width > MOST_VOXELS:
        raise InputError(f"{told}: is too large; at most {MOST_VOXELS:,} voxels can be made")
    single, count = in_single(wood), depth * height * width
    firsts = range(0, count, CHUNK)
    return (render_points(single, _voxel_centres(shape, first, min(first + CHUNK, count))) for first in firsts)


def count_parts(shape: tuple[int, int, int]) -> int:
    """How many parts `render_block` makes of a block."""
    return -(-math.prod(shape) // CHUNK)


def carve_mesh(wood: Wood, mesh: Mesh, *, image: tuple[int, int]) -> npt.NDArray[np.float32]:
    """Colours of a mesh's vertices, [vertex, 3], linear light, as if it were carved of the wood.

    The mesh's middle is the photograph's, and its bounding box as long as that. A vertex sees a spot of half the mean
    edge length, so that rings finer than the mesh fade instead of flickering.

    Args:
        wood: the model.
        mesh: of any size; axes as `place_mesh` has them.
        image: (width, height) of the photograph.

    Raises:
        InputError: as `place_mesh`.
    """
    points = place_mesh(mesh, longest=max(image))
    return render_points(wood, points, spot=max(SPOT, 0.5 * mean_edge(points, mesh.faces)))


class _Plank(eqx.Module):
    wood: Wood
    blur: Array  # of a map's pixel, in pixels of the photograph
    finish: Array  # [roughness, specular, metallic; early, late]


def _render_grid(plank: _Plank, x: Array, y: Array) -> WoodMaps:
    colour, finish = evaluate_points(_surface, plank, x, y, rows=ROWS_AT_ONCE)
    height, slope = evaluate_points(_height_and_slope, plank, x, y, rows=ROWS_AT_ONCE)
    maps = colour, height, normals_of(slope[..., 0], slope[..., 1]), *jnp.moveaxis(finish, -1, 0)
    return WoodMaps(*map(np.asarray, maps))


@eqx.filter_jit
def _look(plank: _Plank, points: Array) -> tuple[Array, ...]:
    colour, finish = jax.vmap(lambda point: _surface(plank, point))(points)
    height, slope = jax.vmap(lambda point: _height_and_slope(plank, point))(points)
    return colour, height, normals_of(slope[:, 0], slope[:, 1]), *finish.T


def _surface(plank: _Plank, point: Array) -> tuple[Array, Array]:
    """Colour (3,) and finish (3,) of a plank's point."""
    early = plank.wood.early_on_plank(point, blur=plank.blur)
    colour = plank.wood.colour_of(early, plank.wood.to_trunk(point), blur=plank.blur)
    return colour, plank.finish[:, 1] + early * (plank.finish[:, 0] - plank.finish[:, 1])


def _finish_table(finish: WoodFinish) -> Array:
    return jnp.asarray(finish, jnp.float32).T


def _height_and_slope(plank: _Plank, point: Array) -> tuple[Array, Array]:
    """Of the relief, at a point of the plank: late wood is raised, and its edges are round."""
    spacing = plank.wood.ring_spacing
    blur = jnp.sqrt(plank.blur**2 + (ROUNDING * spacing) ** 2)
    return jax.value_and_grad(lambda at: RELIEF * spacing * (1.0 - plank.wood.early_on_plank(at, blur=blur)))(point)


def _voxel_centres(shape: tuple[int, int, int], first: int, end: int) -> npt.NDArray[np.float32]:
    """Where the voxels of a block with numbers from `first` to `end` lie in the solid, [voxel, 3]."""
    z, y, x = np.unravel_index(np.arange(first, end), shape)
    return np.stack([x + 0.5 - shape[2] / 2, y + 0.5 - shape[1] / 2, z], axis=-1).astype(np.float32)


@eqx.filter_jit
def _colours(wood: Wood, points: Array, blur: Array) -> Array:
    return jax.vmap(lambda point: wood.colour(solid_to_trunk(wood, point), blur=blur))(points)


def solid_to_trunk(wood: Wood, point: Array) -> Array:
    """A point of the solid (3,) in the trunk: below the plank's face, at right angles to it."""
    inwards = jnp.stack([jnp.zeros_like(wood.tilt), jnp.cos(wood.tilt), -jnp.sin(wood.tilt)])
    return wood.to_trunk(point[:2]) + point[2] * inwards


def in_single(wood: Wood) -> Wood:
    """In single precision. A displacement's cosines get zeros for company: few numbers of them share few compilations,
    and a floor has a plank of every size."""
    field = wood.displacement
    if field is not None:
        padded = jnp.pad(jnp.asarray(field.cosines), [(0, -count % _COSINES) for count in field.cosines.shape])
        wood = dataclasses.replace(wood, displacement=dataclasses.replace(field, cosines=padded))
    return jax.tree.map(lambda leaf: jnp.asarray(leaf, jnp.float32), wood)
