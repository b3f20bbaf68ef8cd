"""Triangle meshes, read by trimesh; written with a colour to each vertex."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import trimesh

from jaxtex.core.colour import linear_to_srgb
from jaxtex.core.errors import InputError
from jaxtex.io.files import atomic_write_bytes, existing_file


class Mesh(NamedTuple):
    """A mesh of triangles.

    Attributes:
        vertices: [vertex, 3], in the file's own unit and axes.
        faces: [face, 3], numbers of vertices.
    """

    vertices: npt.NDArray[np.float64]
    faces: npt.NDArray[np.int64]


def read_mesh(path: Path | str) -> Mesh:
    """Read a mesh file: PLY, OBJ, STL, OFF, GLB and what else trimesh reads; of several parts, all as one.

    Raises:
        InputError: the file is missing, damaged, or holds no triangles; a vertex is not finite.

    Examples:
        >>> tetrahedron = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
        >>> write_mesh("tetra.ply", Mesh(np.eye(4)[:, :3], tetrahedron), np.full((4, 3), 0.5))
        >>> read_mesh("tetra.ply").faces.shape
        (4, 3)
    """
    path = existing_file(path)
    try:
        loaded = trimesh.load_mesh(str(path), process=False)
        vertices, faces = np.asarray(loaded.vertices, np.float64), np.asarray(loaded.faces, np.int64)
    except Exception as error:  # readers of damaged files raise whatever comes to them
        told = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"{path}: is no mesh that can be read ({told[:100]})") from None
    if vertices.ndim != 2 or vertices.shape[1:] != (3,) or faces.ndim != 2 or not len(faces):
        raise InputError(f"{path}: holds no triangles; save the mesh's faces too")
    if not np.isfinite(vertices).all():
        raise InputError(f"{path}: has vertices that are not finite")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise InputError(f"{path}: is damaged, as its faces name vertices that are not there")
    return Mesh(vertices, faces)


def write_mesh(path: Path | str, mesh: Mesh, colours: npt.NDArray[np.floating]) -> None:
    """Write a mesh with vertex colours to a binary PLY file, whole or not at all.

    Args:
        path: the file.
        mesh: its vertices keep their order and place.
        colours: [vertex, 3], linear light; the file has them as 8-bit sRGB, as other programs expect.

    Raises:
        InputError: the file cannot be made.
    """
    encoded = np.rint(255 * linear_to_srgb(np.clip(colours, 0, 1))).astype(np.uint8)
    coloured = trimesh.Trimesh(mesh.vertices, mesh.faces, vertex_colors=encoded, process=False)
    data = coloured.export(file_type="ply")
    assert isinstance(data, bytes)
    atomic_write_bytes(path, data)
