"""Meshes with texture coordinates: read from files, with what the file has, and made up where it has none."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from jaxtex.core.errors import InputError
from jaxtex.io.meshes import read_textured_mesh

SAIL = "v 0 0 0\nv 2 0 0\nv 0 2 0\nvt 0 0\nvt 1 0\nvt 0 1\n"


def write(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def make_tent() -> trimesh.Trimesh:
    """Two sides that meet at a ridge, where vertices stand twice."""
    vertices = [[-1, 0, 0], [0, 1, 0], [0, 1, 2], [0, 1, 0], [0, 1, 2], [1, 0, 0]]
    uv = np.random.default_rng(0).random((6, 2))
    return trimesh.Trimesh(vertices, [[0, 2, 1], [3, 4, 5]], visual=trimesh.visual.TextureVisuals(uv=uv), process=False)


def sorted_corners(vertices: np.ndarray, faces: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """What each triangle's corners are, whatever the numbers of vertices."""
    corners = np.concatenate([vertices[faces], uv[faces]], axis=-1).reshape(len(faces), -1)
    return corners[np.lexsort(corners.T)]


@pytest.mark.parametrize("suffix", ["obj", "glb", "ply"])
def test_corners_are_those_of_the_file(tmp_path: Path, suffix: str) -> None:
    tent = make_tent()
    tent.export(tmp_path / f"tent.{suffix}")
    mesh = read_textured_mesh(tmp_path / f"tent.{suffix}")
    expected = sorted_corners(tent.vertices, tent.faces, tent.visual.uv)
    np.testing.assert_allclose(sorted_corners(mesh.vertices, mesh.faces, mesh.uv), expected, atol=1e-6)


def test_the_seam_of_a_texture_is_smooth(tmp_path: Path) -> None:
    tent = make_tent()
    lines = [f"v {x} {y} {z}" for x, y, z in tent.vertices] + [f"vt {u} {v}" for u, v in tent.visual.uv]
    lines += [f"f {' '.join(f'{k + 1}/{k + 1}' for k in face)}" for face in tent.faces]
    mesh = read_textured_mesh(write(tmp_path / "tent.obj", "\n".join(lines)))
    # Both sides have one area: on the ridge, the normal is the mean of theirs.
    sides = np.array([np.cross(b - a, c - a) for a, b, c in mesh.vertices[mesh.faces]])
    ridge = mesh.vertices[:, 1] == 1
    mean = sides.sum(axis=0) / np.linalg.norm(sides.sum(axis=0))
    np.testing.assert_allclose(mesh.normals[ridge], np.tile(mean, (ridge.sum(), 1)), atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-6)


def test_normals_of_the_file_are_kept(tmp_path: Path) -> None:
    sail = SAIL + "vn 0 1 0\nvn 1 0 0\nvn 0 0 2\nf 1/1/1 2/2/2 3/3/3\n"
    mesh = read_textured_mesh(write(tmp_path / "sail.obj", sail))
    by_place = {tuple(vertex): normal.tolist() for vertex, normal in zip(mesh.vertices, mesh.normals, strict=True)}
    assert by_place == {(0, 0, 0): [0, 1, 0], (2, 0, 0): [1, 0, 0], (0, 2, 0): [0, 0, 1]}


def test_parts_are_joined_where_they_stand(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    moved, mirrored = np.diag([2.0, 2.0, 2.0, 1.0]), np.diag([-1.0, 1.0, 1.0, 1.0])
    moved[:3, 3] = 1, 2, 3
    for matrix in (moved, mirrored):
        scene.add_geometry(make_tent(), transform=matrix)
    scene.export(tmp_path / "tents.glb")
    mesh = read_textured_mesh(tmp_path / "tents.glb")
    tent = make_tent()
    places = [tent.vertices * 2 + [1, 2, 3], tent.vertices * [-1, 1, 1]]
    faces = [tent.faces, tent.faces[:, ::-1]]  # a mirror turns triangles inside out
    expected = sorted_corners(
        np.concatenate(places), np.concatenate([faces[0], faces[1] + 6]), np.concatenate([tent.visual.uv] * 2)
    )
    np.testing.assert_allclose(sorted_corners(mesh.vertices, mesh.faces, mesh.uv), expected, atol=1e-5)
    flat = np.array([np.cross(b - a, c - a) for a, b, c in mesh.vertices[mesh.faces]])
    assert (np.einsum("fi,fki->fk", flat, mesh.normals[mesh.faces]) > 0).all()


def test_normals_of_a_stretched_part_stay_upright(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(subdivisions=1)
    uv = trimesh.visual.TextureVisuals(uv=ball.vertices[:, :2])
    ball = trimesh.Trimesh(ball.vertices, ball.faces, vertex_normals=ball.vertices, visual=uv, process=False)
    stretch, turn = np.diag([1.0, 2.0, 4.0, 1.0]), trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])
    scene = trimesh.Scene()
    scene.add_geometry(ball, transform=turn @ stretch)
    (tmp_path / "egg.glb").write_bytes(scene.export(file_type="glb", include_normals=True))
    mesh = read_textured_mesh(tmp_path / "egg.glb")
    # An ellipsoid's normal is the gradient of x² + (y / 2)² + (z / 4)².
    upright = mesh.vertices @ turn[:3, :3] / np.array([1.0, 4.0, 16.0])
    expected = upright / np.linalg.norm(upright, axis=1, keepdims=True) @ turn[:3, :3].T
    np.testing.assert_allclose(mesh.normals, expected, atol=1e-5)


def test_a_triangle_without_area_has_unit_normals(tmp_path: Path) -> None:
    mesh = read_textured_mesh(write(tmp_path / "needle.obj", SAIL + "f 1/1 2/2 2/3\n"))
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1)


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("bare.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "has no texture coordinates; unwrap it in your modeller"),
        ("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "holds no triangles|no mesh that can be read"),
        ("nan.obj", SAIL.replace("vt 0 1", "vt 0 nan") + "f 1/1 2/2 3/3\n", "texture coordinates that are not finite"),
        ("far.obj", SAIL.replace("v 2 0 0", "v nan 0 0") + "f 1/1 2/2 3/3\n", "vertices that are not finite"),
        ("words.glb", "a shopping list: bricks, mortar", "is no mesh that can be read"),
        ("words.xyz9", "a shopping list: bricks, mortar", "is no mesh that can be read"),
        ("empty.obj", "", "is empty"),
    ],
)
def test_what_cannot_be_read_is_one_line(tmp_path: Path, name: str, text: str, told: str) -> None:
    with pytest.raises(InputError, match=told) as caught:
        read_textured_mesh(write(tmp_path / name, text))
    assert name in str(caught.value)
    assert "\n" not in str(caught.value)


def test_one_bare_part_among_others_is_refused(tmp_path: Path) -> None:
    scene = trimesh.Scene([make_tent(), trimesh.creation.box()])
    scene.export(tmp_path / "two.glb")
    with pytest.raises(InputError, match="has no texture coordinates"):
        read_textured_mesh(tmp_path / "two.glb")
