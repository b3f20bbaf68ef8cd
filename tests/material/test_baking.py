"""Solid textures baked into pictures on meshes."""

import sys

import numpy as np
import pytest
import trimesh
from scipy import ndimage

from jaxtex.core.errors import InputError
from jaxtex.io.meshes import Mesh
from jaxtex.material.baking import bake_solid
from jaxtex.material.carving import areas_of, mean_edge, place_mesh
from jaxtex.material.solid import carve_solid, evaluate_solid, place_in_solid
from jaxtex.material.unwrapping import lay_picture, unwrap_mesh
from jaxtex.models.solid import make_solid

SMOOTH = ndimage.gaussian_filter(np.random.default_rng(0).random((12, 14, 16, 3)), (2, 2, 2, 0), mode="wrap")
SOLID = make_solid(((SMOOTH - SMOOTH.min()) / np.ptp(SMOOTH)).astype(np.float32))


def as_mesh(made: trimesh.Trimesh) -> Mesh:
    return Mesh(np.asarray(made.vertices, np.float64), np.asarray(made.faces, np.int64))


def join(*meshes: Mesh) -> Mesh:
    firsts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + first for mesh, first in zip(meshes, firsts, strict=False)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces))


BALL = as_mesh(trimesh.creation.icosphere(subdivisions=4))
BOX = as_mesh(trimesh.creation.box(extents=(3, 2, 1)))
SOUP = Mesh(BALL.vertices[BALL.faces].reshape(-1, 3), np.arange(3 * len(BALL.faces)).reshape(-1, 3))
FANS = join(BOX, Mesh(BOX.vertices, BOX.faces[:4]), Mesh(BOX.vertices * 1e-3, BOX.faces[:, ::-1]))  # no manifold
POLES = Mesh(BALL.vertices, np.concatenate([BALL.faces, [[0, 0, 1], [2, 2, 2], [3, 4, 3]]]))  # some without an area


def look_up(picture: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Bilinear, as graphics cards do; the picture repeats."""
    side = len(picture)
    at = np.stack([(1 - uv[:, 1]) * side - 0.5, uv[:, 0] * side - 0.5])
    return np.stack(
        [ndimage.map_coordinates(picture[..., n], at, order=1, mode="grid-wrap") for n in range(3)], axis=-1
    )


def points_on_edges(faces: np.ndarray, *, borders: bool) -> tuple[np.ndarray, np.ndarray]:
    """Corners [point, 2] of faces' edges, as numbers of faces and of corners: those where charts end, or the others."""
    edges = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    _, number, count = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    found = np.flatnonzero((count[number.ravel()] == 1) == borders)
    return np.divmod(found, 3)


@pytest.mark.parametrize("mesh", [BALL, BOX, SOUP, FANS, POLES], ids=["ball", "box", "soup", "fans", "poles"])
def test_charts_do_not_overlap_and_keep_lengths(mesh: Mesh) -> None:
    unwrapped = unwrap_mesh(mesh, side=256)
    assert np.array_equal(unwrapped.source[unwrapped.faces], mesh.faces)
    assert 2 <= unwrapped.texels.min() <= unwrapped.texels.max() <= 254
    flat, solid = areas_of(unwrapped.texels[unwrapped.faces]), areas_of(mesh.vertices[mesh.faces])
    assert np.array_equal(flat > 1e-9, solid > 0)
    lengths = np.sqrt(flat[solid > 1e-4] / solid[solid > 1e-4])
    assert lengths.max() / lengths.min() < 1.5
    shown = np.zeros((256, 256), int)
    for triangle in unwrapped.texels[unwrapped.faces][solid > 0]:
        inside = texels_inside(triangle)
        shown[inside[:, 1], inside[:, 0]] += 1
    assert shown.max() <= 1
    assert shown.mean() > 0.2


def texels_inside(triangle: np.ndarray) -> np.ndarray:
    low, high = np.floor(triangle.min(axis=0)).astype(int), np.ceil(triangle.max(axis=0)).astype(int)
    grid = np.stack(np.meshgrid(*map(np.arange, low, high)), axis=-1).reshape(-1, 2)
    ways = np.roll(triangle, -1, axis=0) - triangle
    offsets = grid[:, None] + 0.5 - triangle[None]
    turns = ways[None, :, 0] * offsets[..., 1] - ways[None, :, 1] * offsets[..., 0]
    return grid[(turns > 1e-6).all(axis=1) | (turns < -1e-6).all(axis=1)]


def errors_on_edges(mesh: Mesh, *, borders: bool) -> np.ndarray:
    """By how much a mesh with a picture differs from the solid, at random points of edges."""
    baked = bake_solid(SOLID, mesh, side=256)
    assert baked.texel < 1  # so that no spot blurs
    face, corner = points_on_edges(baked.mesh.faces, borders=borders)
    share = np.random.default_rng(0).random((len(face), 1))
    ends = [(face, corner), (face, (corner + 1) % 3)]
    uv, points = (
        (1 - share) * values[faces[ends[0]]] + share * values[faces[ends[1]]]
        for values, faces in ((baked.mesh.uv, baked.mesh.faces), (place_in_solid(SOLID, mesh, scale=1.0), mesh.faces))
    )
    there = areas_of(mesh.vertices[mesh.faces])[face] > 0
    return np.abs(look_up(baked.picture, uv) - evaluate_solid(SOLID, points))[there]


@pytest.mark.parametrize("mesh", [BALL, BOX, SOUP, FANS, POLES], ids=["ball", "box", "soup", "fans", "poles"])
def test_the_surface_shows_the_solid_also_where_charts_end(mesh: Mesh) -> None:
    errors = errors_on_edges(mesh, borders=True)
    assert errors.max() < 0.05
    assert np.sqrt(np.square(errors).mean()) < 0.006


def test_charts_end_as_well_as_they_go_on() -> None:
    borders, within = (np.sqrt(np.square(errors_on_edges(BALL, borders=each)).mean()) for each in (True, False))
    assert borders < 1.5 * within


def test_at_vertices_the_picture_agrees_with_carved_colours() -> None:
    fine = as_mesh(trimesh.creation.icosphere(subdivisions=5))
    assert mean_edge(place_mesh(fine, longest=16.0), fine.faces) < 1
    unwrapped = unwrap_mesh(fine, side=512)
    baked = bake_solid(SOLID, fine, side=512)
    colours = carve_solid(SOLID, fine)[unwrapped.source]
    np.testing.assert_allclose(look_up(baked.picture, baked.mesh.uv), colours, atol=0.02)


def test_what_is_finer_than_texels_fades() -> None:
    noise = make_solid(np.random.default_rng(0).random((16, 16, 16, 1)))
    spreads = [bake_solid(noise, BOX, side=128, scale=scale).picture.std() for scale in (1.0, 30.0, 300.0)]
    assert spreads[0] > 0.1 > 0.02 > spreads[1] > spreads[2]


def test_the_mesh_is_the_same_and_its_normals_have_no_seams() -> None:
    unwrapped = unwrap_mesh(BALL, side=128)
    laid = lay_picture(BALL, unwrapped)
    assert np.array_equal(laid.vertices[laid.faces], BALL.vertices[BALL.faces])
    np.testing.assert_allclose(laid.normals, laid.vertices, atol=0.02)
    for place in np.unique(unwrapped.source):
        assert len(np.unique(laid.normals[unwrapped.source == place], axis=0)) == 1


def test_the_same_mesh_gives_the_same_picture_and_progress_grows() -> None:
    told: list[float] = []
    one = bake_solid(SOLID, BALL, side=100, report=lambda done, _: told.append(done))
    other = bake_solid(SOLID, BALL, side=100)
    assert np.array_equal(one.picture, other.picture)
    assert np.array_equal(one.mesh.uv, other.mesh.uv)
    assert told == sorted(told)
    assert (told[0], told[-1]) == (0, 1)


def strip(width: float) -> Mesh:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, width, 0], [0, width, 0]])
    return Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]]))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("width", [0.1, 1e-3, 1e-6, 1e-9])
def test_a_strip_alone_fills_the_picture_along_its_length(width: float) -> None:
    mesh = strip(width)
    baked = bake_solid(SOLID, mesh, side=64)
    assert np.ptp(baked.mesh.uv, axis=0).max() > 0.9
    # What lies within the strip, from corner to corner.
    share = np.linspace(0, 1, 50)[:, None]
    placed = place_in_solid(SOLID, mesh, scale=1.0)[baked.mesh.faces[0]]
    uv = baked.mesh.uv[baked.mesh.faces[0]]
    ends = [(1 - share) * each[0] + share * each[2] for each in (uv, placed)]
    np.testing.assert_allclose(look_up(baked.picture, ends[0]), evaluate_solid(SOLID, ends[1]), atol=0.05)


LINE = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), np.array([[0, 1, 2]]))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("mesh", "options", "told"),
    [
        (LINE, {}, "all triangles of the mesh are without an area"),
        *((strip(width), {}, "the mesh is too thin to be unwrapped") for width in (1e-12, 1e-20)),
        (BALL, {"side": 32}, "a picture of 32 x 32 cannot hold the mesh's charts apart, .* give a larger one"),
        (BALL, {"side": 15}, "side: 15 is out of range"),
        (BALL, {"side": 8193}, "side: 8193 is out of range"),
        (BALL, {"scale": 0.0}, "scale: 0 is none"),
    ],
)
def test_what_cannot_be_baked_is_refused(mesh: Mesh, options: dict, told: str) -> None:
    with pytest.raises(InputError, match=told):
        bake_solid(SOLID, mesh, **options)


def test_a_package_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xatlas", None)
    with pytest.raises(InputError, match=r"xatlas; pip install 'jaxtex\[bake\]'"):
        bake_solid(SOLID, BALL, side=64)
