"""Meshes unwrapped: cut into charts that lie flat beside each other in one square picture."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.io.meshes import Mesh, TexturedMesh, smooth_normals
from jaxtex.material.carving import areas_of

_LENGTH = 1000.0  # of the mesh as xatlas gets it: shorter edges than 1e-4 are none to it
_LARGEST_CHART = 0.01  # of the mesh's area: larger charts take xatlas ten times as long
_PADDING = 4  # texels between charts, before they are scaled to fill the picture
_LEAST_PADDING = 1.5  # texels after that: nearer, filters would mix charts
_USED = 0.8  # of the side that xatlas is asked for: its charts need more room than it thinks


class Unwrapped(NamedTuple):
    """Where the triangles of a mesh lie in a picture. Along the borders of charts, vertices stand twice.

    Attributes:
        side: of the square picture, in texels.
        source: [vertex], which of the mesh's own vertices each is.
        faces: [face, 3], numbers of these vertices; the mesh's own faces in their order.
        texels: [vertex, 2], x to the right and y down, from 0 to `side`; centres of texels are at halves.
    """

    side: int
    source: npt.NDArray[np.int64]
    faces: npt.NDArray[np.int64]
    texels: npt.NDArray[np.float64]


def unwrap_mesh(mesh: Mesh, *, side: int) -> Unwrapped:
    """Unwrap a mesh by xatlas (J. Young's library, after that of I. Castaño's thekla_atlas).

    Charts have at most a hundredth of the mesh's area. Lengths are alike in all charts, within a third where the mesh
    is smooth. 10 000 triangles take about a second. Triangles without an area lie at one point.

    Args:
        mesh: of any size; it may be open, in pieces, or not a manifold.
        side: of the square picture in texels.

    Raises:
        InputError: xatlas is not installed; no triangle has an area, or none in single precision; more charts than can
            lie in the picture, or several that are long and thin.

    Examples:
        >>> square = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]]))
        >>> unwrapped = unwrap_mesh(square, side=64)
        >>> unwrapped.source[unwrapped.faces].tolist()
        [[0, 1, 2], [0, 2, 3]]
    """
    try:
        import xatlas
    except ImportError:
        raise InputError("textures of meshes take the package xatlas; pip install 'jaxtex[bake]'") from None
    low = mesh.vertices.min(axis=0)
    points = (mesh.vertices - low) * (_LENGTH / max(float((mesh.vertices - low).max()), 1e-300))
    area = areas_of(points[mesh.faces]).sum()
    if not area > 0:
        raise InputError("all triangles of the mesh are without an area; give a mesh with a surface")
    atlas, charts, packing = xatlas.Atlas(), xatlas.ChartOptions(), xatlas.PackOptions()
    charts.max_chart_area = _LARGEST_CHART * area
    packing.resolution, packing.padding = max(round(_USED * side), 1), _PADDING
    atlas.add_mesh(points.astype(np.float32), mesh.faces.astype(np.uint32))
    atlas.generate(charts, packing)
    source, faces, uv = atlas[0]
    extent = np.array([atlas.width, atlas.height], np.float64)
    # Strips much thinner than long have an area, but none in xatlas's single precision.
    if not extent.min() > 0 or not areas_of(uv[faces]).sum() > 0:
        raise InputError("the mesh is too thin to be unwrapped, as its charts have no area; give a wider one")
    # Pictures repeat: what lies at opposite borders is as far apart as charts are.
    scale = (side - _PADDING) / extent.max()
    # One chart alone has none to be held apart from; of a strip it has any scale, as xatlas goes by areas.
    if atlas.chart_count > 1 and scale * _PADDING < _LEAST_PADDING:
        told = f"a picture of {side} x {side} cannot hold the mesh's charts apart, {atlas.chart_count} in number"
        raise InputError(f"{told}; give a larger one, or a mesh without long thin strips")
    texels = _PADDING / 2 + uv.astype(np.float64) * extent * scale
    return Unwrapped(side, source.astype(np.int64), faces.astype(np.int64), texels)


def lay_picture(mesh: Mesh, unwrapped: Unwrapped) -> TexturedMesh:
    """The mesh with texture coordinates for a picture laid on it; its normals are smooth, also where charts meet."""
    across, down = unwrapped.texels.T / unwrapped.side
    return TexturedMesh(
        vertices=mesh.vertices[unwrapped.source],
        faces=unwrapped.faces,
        uv=np.stack([across, 1 - down], axis=1),
        normals=smooth_normals(mesh.vertices, mesh.faces)[unwrapped.source],
    )
