"""Triangle meshes, read by trimesh, with or without texture coordinates; written with a colour to each vertex."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

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


class TexturedMesh(NamedTuple):
    """A mesh of triangles that a picture is laid on. Where a picture's parts differ along a seam, vertices stand twice.

    Attributes:
        vertices: [vertex, 3]: x right, y up, z towards the viewer.
        faces: [face, 3], numbers of vertices, counterclockwise as seen from outside.
        uv: [vertex, 2], with v upwards: (0, 0) is the lower left corner of the picture, (1, 1) the upper right one, and
            ((col + 0.5) / width, 1 - (row + 0.5) / height) the centre of a pixel. Beyond 0 to 1 the picture repeats.
        normals: [vertex, 3], unit vectors.
        tangent: unit vector (3,) of growing u, where the mesh is flat and it is the same everywhere.
    """

    vertices: npt.NDArray[np.float64]
    faces: npt.NDArray[np.int64]
    uv: npt.NDArray[np.float64]
    normals: npt.NDArray[np.float64]
    tangent: npt.NDArray[np.float64] | None = None


def wall_mesh(width: float, height: float) -> TexturedMesh:
    """A wall on the ground: it faces the viewer (+z), and a picture stands upright on it.

    Args:
        width, height: in metres. x is 0 in its middle, y at its foot.

    Examples:
        >>> wall_mesh(4.0, 3.0).vertices.tolist()
        [[-2.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 3.0, 0.0], [-2.0, 3.0, 0.0]]
    """
    x, y = width / 2, height
    return _rectangle([[-x, 0, 0], [x, 0, 0], [x, y, 0], [-x, y, 0]], normal=[0, 0, 1])


def floor_mesh(width: float, depth: float) -> TexturedMesh:
    """A floor: it faces upwards (+y), and a picture's upper side lies away from the viewer (-z).

    Args:
        width, depth: in metres, along x and z. Its middle is the origin.

    Examples:
        >>> floor_mesh(4.0, 3.0).vertices.tolist()
        [[-2.0, 0.0, 1.5], [2.0, 0.0, 1.5], [2.0, 0.0, -1.5], [-2.0, 0.0, -1.5]]
    """
    x, z = width / 2, depth / 2
    return _rectangle([[-x, 0, z], [x, 0, z], [x, 0, -z], [-x, 0, -z]], normal=[0, 1, 0])


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
    with _reading(path):
        loaded = trimesh.load_mesh(str(path), process=False)
        vertices, faces = np.asarray(loaded.vertices, np.float64), np.asarray(loaded.faces, np.int64)
    _check_triangles(path, vertices, faces)
    return Mesh(vertices, faces)


def read_textured_mesh(path: Path | str) -> TexturedMesh:
    """Read a mesh file with texture coordinates: OBJ, GLB, PLY and what else trimesh reads; of several parts, all.

    Lengths and axes stay the file's. Normals are the file's own; a part without them is smooth, also across the seams
    of its texture.

    Raises:
        InputError: as `read_mesh`, or a part has no texture coordinates, or some that are not finite.

    Examples:
        >>> _ = Path("sail.obj").write_text("v 0 0 0\\nv 2 0 0\\nv 0 2 0\\nvt 0 0\\nvt 1 0\\nvt 0 1\\nf 1/1 2/2 3/3\\n")
        >>> read_textured_mesh("sail.obj").uv.tolist()
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
    """
    path = existing_file(path)
    with _reading(path):
        scene = trimesh.load_scene(str(path), process=False)
        placed = [scene.graph[node] for node in scene.graph.nodes_geometry]
        parts = [_Part(scene.geometry[name], matrix) for matrix, name in placed]
    parts = [part for part in parts if isinstance(part.mesh, trimesh.Trimesh) and len(part.mesh.faces)]
    if not parts:
        raise InputError(f"{path}: holds no triangles; save the mesh's faces too")
    for mesh, _ in parts:
        uv = getattr(mesh.visual, "uv", None)
        if uv is None or len(uv) != len(mesh.vertices):
            raise InputError(f"{path}: has no texture coordinates; unwrap it in your modeller first")
        _check_triangles(path, mesh.vertices, mesh.faces)
        if not np.isfinite(uv).all():
            raise InputError(f"{path}: has texture coordinates that are not finite; unwrap it in your modeller anew")
    with _reading(path):
        return _join([_place(part) for part in parts])


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


class _Part(NamedTuple):
    mesh: Any  # trimesh's; what else files hold is left out
    matrix: npt.NDArray[np.float64]  # [4, 4], to where it stands


def _place(part: _Part) -> TexturedMesh:
    mesh, matrix = part
    vertices, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
    # trimesh would make up normals for each vertex by itself, and the seams of the texture would show.
    own = "vertex_normals" in mesh._cache
    normals = np.asarray(mesh.vertex_normals, np.float64) if own else smooth_normals(vertices, faces)
    return TexturedMesh(
        vertices=vertices @ matrix[:3, :3].T + matrix[:3, 3],
        faces=faces if np.linalg.det(matrix[:3, :3]) > 0 else faces[:, ::-1],
        uv=np.asarray(mesh.visual.uv, np.float64)[:, :2],
        normals=_unit(normals @ np.linalg.inv(matrix[:3, :3])),
    )


def smooth_normals(vertices: npt.NDArray[np.float64], faces: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
    """Unit normals [vertex, 3]: the mean of those of all triangles that meet at a vertex's place, by their areas."""
    _, place = np.unique(vertices, axis=0, return_inverse=True)
    place = place.ravel()
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    areas = np.cross(b - a, c - a)
    sums = np.zeros((len(vertices), 3))
    np.add.at(sums, place[faces].ravel(), np.repeat(areas, 3, axis=0))
    return _unit(sums[place])


def _unit(normals: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Of length 1. Corners of triangles without an area have none; any direction will do, but it must be one."""
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.divide(normals, lengths, out=np.tile([0.0, 0.0, 1.0], (len(normals), 1)), where=lengths > 1e-30)


def _join(meshes: list[TexturedMesh]) -> TexturedMesh:
    firsts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes[:-1]])
    return TexturedMesh(
        vertices=np.concatenate([mesh.vertices for mesh in meshes]),
        faces=np.concatenate([mesh.faces + first for mesh, first in zip(meshes, firsts, strict=True)]),
        uv=np.concatenate([mesh.uv for mesh in meshes]),
        normals=np.concatenate([mesh.normals for mesh in meshes]),
    )


def _rectangle(corners: list[list[float]], *, normal: list[float]) -> TexturedMesh:
    """Of two triangles; its corners are those of a picture, from the lower left one on counterclockwise."""
    return TexturedMesh(
        vertices=np.array(corners, np.float64),
        faces=np.array([[0, 1, 2], [0, 2, 3]], np.int64),
        uv=np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float64),
        normals=np.tile(np.array(normal, np.float64), (4, 1)),
        tangent=np.array([1, 0, 0], np.float64),
    )


@contextmanager
def _reading(path: Path) -> Iterator[None]:
    try:
        yield
    except Exception as error:  # readers of damaged files raise whatever comes to them
        told = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"{path}: is no mesh that can be read ({told[:100]})") from None


def _check_triangles(path: Path, vertices: npt.NDArray[np.floating], faces: npt.NDArray[np.integer]) -> None:
    if vertices.ndim != 2 or vertices.shape[1:] != (3,) or faces.ndim != 2 or not len(faces):
        raise InputError(f"{path}: holds no triangles; save the mesh's faces too")
    if not np.isfinite(vertices).all():
        raise InputError(f"{path}: has vertices that are not finite")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise InputError(f"{path}: is damaged, as its faces name vertices that are not there")


def turn_mesh(mesh: TexturedMesh, *, up: str) -> TexturedMesh:
    """A mesh whose axis `up` points up turned so that y does, as glTF has it.

    Args:
        up: x, y or z.

    Examples:
        >>> turned = turn_mesh(floor_mesh(1.0, 1.0), up="z")  # what lay on the ground stands
        >>> turned.normals[0].round(3).tolist()
        [0.0, 0.0, -1.0]
    """
    if up == "y":
        return mesh
    turn = {"z": [[1, 0, 0], [0, 0, 1], [0, -1, 0]], "x": [[0, -1, 0], [1, 0, 0], [0, 0, 1]]}[up]
    matrix = np.array(turn, float).T
    return mesh._replace(vertices=mesh.vertices @ matrix + 0.0, normals=mesh.normals @ matrix + 0.0)
