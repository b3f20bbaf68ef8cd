"""Meshes put into a solid that they are carved of."""

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.io.meshes import Mesh


def place_mesh(mesh: Mesh, *, longest: float) -> npt.NDArray[np.float64]:
    """Where the vertices of a mesh lie in a solid, [vertex, 3], from its middle: x right, y down, z into it.

    The middle of the mesh's bounding box is put to that of the solid. The mesh's axes are as most programs have them: x
    right, y up, z towards the viewer.

    Args:
        mesh: of any size.
        longest: how long the longest side of its bounding box is in the solid.

    Raises:
        InputError: all vertices lie at one point.

    Examples:
        >>> place_mesh(Mesh(np.array([[0.0, 0, 0], [2, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]])), longest=100)
        array([[-50.,  25.,   0.],
               [ 50.,  25.,   0.],
               [-50., -25.,   0.]])
    """
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    length = float((high - low).max())
    if not length > 0:
        raise InputError("all vertices of the mesh lie at one point; give a mesh with an extent")
    turned = (mesh.vertices - (low + high) / 2) * np.array([1.0, -1.0, -1.0])
    return turned * (longest / length) + 0.0


def mean_edge(points: npt.NDArray[np.floating], faces: npt.NDArray[np.integer]) -> float:
    """Mean length of the edges of triangles, each as often as it has triangles.

    Args:
        points: [vertex, 3].
        faces: [face, 3], numbers of vertices.

    Examples:
        >>> mean_edge(np.array([[0.0, 0, 0], [3, 0, 0], [0, 4, 0]]), np.array([[0, 1, 2]]))
        4.0
    """
    corners = points[faces]
    return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).mean())


def areas_of(corners: npt.NDArray[np.floating]) -> npt.NDArray[np.float64]:
    """Areas [face] of triangles [face, 3, axis] of the plane or of space.

    Examples:
        >>> areas_of(np.array([[[0.0, 0], [2, 0], [0, 3]]])).tolist()
        [3.0]
    """
    a, b = (corners[:, corner].astype(np.float64) - corners[:, 0] for corner in (1, 2))
    if corners.shape[2] == 2:
        return np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
    return np.linalg.norm(np.cross(a, b), axis=1) / 2
