"""Solid textures baked: a mesh with a picture that shows the solid it is carved of."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.io.meshes import Mesh, TexturedMesh
from jaxtex.material.carving import areas_of
from jaxtex.material.solid import blur_solid, evaluate_solid, place_in_solid
from jaxtex.material.texels import find_faces, locate, spread_colours
from jaxtex.material.unwrapping import lay_picture, unwrap_mesh
from jaxtex.models.solid import Solid

SMALLEST_SIDE, LARGEST_SIDE = 16, 8192
"""Of pictures, in texels."""

_AT_ONCE = 1 << 18  # texels
_FARTHEST = 2.0  # how much longer than a mean one a texel may be where charts go on beyond their triangles
_FINDING = 0.3  # of the time, to find out which triangle each texel shows

Report = Callable[[float, float | None], None]


class Baked(NamedTuple):
    """A mesh and the picture on it.

    Attributes:
        mesh: the mesh unwrapped; triangles are those of the mesh it was made of, in their order.
        picture: [row, col, 3], square, linear light. What no triangle shows is filled with colours near by.
        texel: mean length of a texel's sides on the mesh, in voxels.
    """

    mesh: TexturedMesh
    picture: npt.NDArray[np.float32]
    texel: float


def bake_solid(
    solid: Solid, mesh: Mesh, *, side: int = 2048, scale: float = 1.0, report: Report | None = None
) -> Baked:
    """Bake what a mesh shows that is carved of a solid into a picture laid on it.

    The mesh is placed as `carve_solid` does. Where that lets a vertex see a spot of half the mean edge length, here a
    texel sees one of half its own length.

    Args:
        solid: the texture.
        mesh: of any size; axes as `place_mesh` has them.
        side: of the picture in texels, `SMALLEST_SIDE` to `LARGEST_SIDE`.
        scale: as `carve_solid` has it.
        report: told how far it is; the mesh is unwrapped before.

    Raises:
        InputError: as `carve_solid` and `unwrap_mesh`; a side out of range.

    Examples:
        >>> from jaxtex.models.solid import make_solid
        >>> square = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]]))
        >>> baked = bake_solid(make_solid(np.full((4, 4, 4, 1), 0.5)), square, side=32)
        >>> baked.picture.shape, np.ptp(baked.picture).item()
        ((32, 32, 3), 0.0)
    """
    if not SMALLEST_SIDE <= side <= LARGEST_SIDE:
        raise InputError(f"side: {side} is out of range; give a number from {SMALLEST_SIDE} to {LARGEST_SIDE}")
    report = report or (lambda done, total: None)
    placed = place_in_solid(solid, mesh, scale=scale)
    report(0, 1)
    unwrapped = unwrap_mesh(mesh, side=side)
    corners, flat = placed[mesh.faces], unwrapped.texels[unwrapped.faces]
    texel = math.sqrt(areas_of(corners).sum() / areas_of(flat).sum())
    seen = blur_solid(solid, 0.5 * texel)
    for found in find_faces(flat, side):
        faces = found.faces
        report(_FINDING * found.done, 1)
    shown = np.flatnonzero(faces >= 0)
    picture = np.zeros((side * side, 3), np.float32)
    for first in range(0, len(shown), _AT_ONCE):
        at = shown[first : first + _AT_ONCE]
        face = faces.ravel()[at]
        points = _points_of(at, flat[face], corners[face], side=side, texel=texel)
        picture[at] = evaluate_solid(seen, points)
        report(_FINDING + (1 - _FINDING) * (first + len(at)) / len(shown), 1)
    filled = spread_colours(picture.reshape(side, side, 3), faces >= 0)
    return Baked(lay_picture(mesh, unwrapped), filled, texel)


def _points_of(
    at: npt.NDArray[np.int64],
    flat: npt.NDArray[np.float64],
    corners: npt.NDArray[np.float64],
    *,
    side: int,
    texel: float,
) -> npt.NDArray[np.float64]:
    """Points [texel, 3] of the solid that texels of these numbers show. Beyond its triangles a chart goes on in their
    planes, so that filters find on either side of its border what is there."""
    row, column = np.divmod(at, side)
    places = locate(np.stack([column, row], axis=1) + 0.5, flat)
    nearest, own = (np.einsum("tc,tcx->tx", weights, corners) for weights in (places.nearest, places.own))
    onwards = own - nearest
    # In slivers, the plane's steps may be as long as one likes.
    most, length = _FARTHEST * texel * places.beyond, np.linalg.norm(onwards, axis=1)
    return nearest + onwards * (most / np.maximum(length, np.maximum(most, 1e-300)))[:, None]
