"""Polygons in space: frames, shared edges, triangles."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jaxtex.core.errors import InputError
from jaxtex.material.polygons import check_polygons, find_area, find_frame, find_shared_edges, triangulate

UP = np.array([0.0, 1.0, 0.0])


def turned(seed):
    """A rotation and a shift."""
    rng = np.random.default_rng(seed)
    q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return q * np.sign(np.linalg.det(q)), rng.normal(size=3)


@pytest.mark.parametrize("seed", range(5))
def test_frames_are_right_handed_and_right_is_level(seed):
    q, shift = turned(seed)
    polygon = np.array([[0, 0, 0], [2, 0, 0], [3, 1, 0], [0, 1, 0]]) @ q.T + shift
    frame = find_frame(polygon, UP)
    np.testing.assert_allclose(np.cross(frame.right, frame.up), frame.normal, atol=1e-12)
    np.testing.assert_allclose(frame.normal, q @ [0, 0, 1], atol=1e-12)
    assert abs(frame.right @ UP) < 1e-12
    assert frame.up @ UP > 0
    assert not frame.is_floor


@pytest.mark.parametrize(("outwards", "ahead"), [(1, [0, 0, -1]), (-1, [0, 0, 1])])
def test_floors_have_world_x_to_the_right(outwards, ahead):
    floor = np.array([[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0]])[::outwards]
    frame = find_frame(floor.astype(float), UP)
    assert frame.is_floor
    np.testing.assert_allclose(frame.normal, [0, outwards, 0])
    np.testing.assert_allclose(frame.right, [1, 0, 0])
    np.testing.assert_allclose(frame.rise, ahead)


@settings(max_examples=60, deadline=None)
@given(st.integers(3, 12), st.integers(0, 10_000))
def test_triangles_cover_a_star_once(corners, seed):
    rng = np.random.default_rng(seed)
    angle = 2 * np.pi * (np.arange(corners) + rng.uniform(0, 0.9, corners)) / corners
    radius = rng.uniform(0.2, 1.0, corners)
    star = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(corners)], axis=-1)
    q, shift = turned(seed)
    polygon = star @ q.T + shift
    triangles = triangulate(polygon)
    assert triangles.shape == (corners - 2, 3)
    areas = [find_area(polygon[triangle]) @ q[:, 2] for triangle in triangles]
    # None is turned over, so together they have the polygon's area only if they do not overlap.
    assert min(areas) > -1e-9
    assert sum(areas) == pytest.approx(find_area(polygon) @ q[:, 2])


def test_a_wall_with_a_window_is_triangulated_around_it():
    outer, inner = [(0, 0), (4, 0), (4, 3), (0, 3)], [(1, 1), (1, 2), (3, 2), (3, 1)]
    bridged = np.array([(x, y, 0) for x, y in [*outer, outer[0], *inner, inner[0]]], float)
    triangles = bridged[triangulate(bridged)]
    assert sum(find_area(one)[2] for one in triangles) == pytest.approx(10)
    middles = triangles.mean(axis=1)[np.array([find_area(one)[2] for one in triangles]) > 1e-9]
    assert not np.any((abs(middles[:, 0] - 2) < 1) & (abs(middles[:, 1] - 1.5) < 0.5))


def test_edges_are_shared_where_they_overlap():
    wide = np.array([[0, 0, 0], [4, 0, 0], [4, 1, 0], [0, 1, 0]], float)
    left, right = wide * [0.25, 1, 1] + [0, 1, 0], wide * [0.5, 1, 1] + [1.5, 1, 0]
    far = np.add(wide, [0, 5, 0])
    edges = find_shared_edges([wide, left, right, far], UP)
    found = {frozenset((edge.first, edge.second)): sorted(edge.ends[:, 0]) for edge in edges}
    assert found.keys() == {frozenset((0, 1)), frozenset((0, 2))}
    np.testing.assert_allclose(found[frozenset((0, 1))], [0, 1])
    np.testing.assert_allclose(found[frozenset((0, 2))], [1.5, 3.5])


@pytest.mark.parametrize("seed", range(3))
def test_all_edges_of_a_closed_mesh_are_shared_once(seed):
    trimesh = pytest.importorskip("trimesh")
    q, shift = turned(seed)
    ball = trimesh.creation.icosphere(subdivisions=2)
    vertices = ball.vertices.astype(np.float32) @ q.T.astype(np.float32) + shift.astype(np.float32)
    edges = find_shared_edges(list(vertices[ball.faces].astype(float)), UP)
    pairs = {frozenset((edge.first, edge.second)) for edge in edges}
    assert len(edges) == len(pairs)
    assert pairs == {frozenset(pair) for pair in ball.face_adjacency.tolist()}
    assert all((edge.ends[1] - edge.ends[0]) @ UP >= -1e-6 for edge in edges)


def test_an_upright_edge_has_the_left_wall_first():
    front = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    side = np.array([[1, 0, 0], [1, 0, -1], [1, 1, -1], [1, 1, 0]], float)
    for order in (1, -1):
        (edge,) = find_shared_edges([front, side][::order], UP)
        assert (edge.first, edge.second) == (0, 1)[::order]


@pytest.mark.parametrize(
    ("polygon", "told"),
    [
        ([[0, 0, 0], [1, 0, 0]], "shape"),
        ([[0, 0], [1, 0], [1, 1]], "shape"),
        ([[0, 0, 0], [1, 0, np.nan], [1, 1, 0]], "not finite"),
        ([[0, 0, 0], [1, 0, 0], [2, 0, 0]], "no area"),
        ([[0, 0, 0], [1, 0, 0], [1, 1, 0.2], [0, 1, 0]], "not planar"),
    ],
)
def test_polygons_that_are_none_are_refused(polygon, told):
    good = [[0, 0, 0], [1, 0, 0], [1, 1, 0]]
    with pytest.raises(InputError, match=f"polygon 1: .*{told}"):
        check_polygons([good, polygon])


def test_polygons_inside_out_are_named():
    front = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    side = np.array([[1, 0, 0], [1, 0, -1], [1, 1, -1], [1, 1, 0]], float)[::-1]
    with pytest.raises(InputError, match="polygons 0 and 1: run the same way"):
        find_shared_edges([front, side], UP)
