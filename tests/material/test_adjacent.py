"""One tiling over adjacent polygons: towers, storeys, roofs, meshes, and that a mistake in them is measured."""

import dataclasses

import jax
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jaxtex.core.errors import InputError
from jaxtex.material.adjacent import lay_adjacent, lay_tiling, polygon_mesh
from jaxtex.material.appearance import Appearance
from jaxtex.material.maps import render_maps
from jaxtex.material.mismatch import measure_mismatch
from jaxtex.material.sheet import lay_sheet
from jaxtex.models.bonds import bond_pattern
from jaxtex.models.tiling import make_tiling

BONDS = {
    "stack": ({}, "joint"),
    "running": ({"offset": 0.5}, "quoin"),
    "running, as fitted": ({"offset": 0.4983}, "quoin"),
    "a third, back and forth": ({"course_offsets": (0.0, 1 / 3)}, "quoin"),
    "two thirds, back and forth": ({"course_offsets": (0.1, 0.1 + 2 / 3)}, "quoin"),
    "raking": ({"offset": 1 / 3}, "wrap"),
    "english": (bond_pattern("english"), "wrap"),
    "flemish": (bond_pattern("flemish"), "wrap"),
    "irregular": ({"course_offsets": (0.0, 0.41, 0.13, 0.77)}, "wrap"),
}
LENGTH, HEIGHT, GAP = 48.0, 16.0, 4.0


def make_sheet(bond, columns=4, **changes):
    sizes = {"tile_width": LENGTH, "tile_height": HEIGHT, "mortar_x": GAP, "mortar_y": 3.0}
    tiling = make_tiling(**{**sizes, **bond, **changes})
    return lay_sheet(tiling, tiles=(columns, 6), seamless=True, near=(-100.0, 70.0))


def raise_walls(plan, low=0.0, high=4.0, top=1.0):
    """Walls over a closed plan of points (x, z), counter-clockwise from above; `top` scales the upper edges."""
    plan = np.asarray(plan, float)
    foot = np.insert(plan, 1, low, axis=1)
    head = np.insert(top * plan, 1, high, axis=1)
    return [np.array([foot[k - 1], foot[k], head[k], head[k - 1]]) for k in range(len(plan))]


def circle(sides, radius=2.4, jitter=0.0, seed=0):
    """Counter-clockwise as seen from above (from +y, with z towards the viewer)."""
    angle = 2 * np.pi * (np.arange(sides) + np.random.default_rng(seed).uniform(-jitter, jitter, sides)) / sides
    return radius * np.stack([np.sin(angle), np.cos(angle)], axis=-1)


def jacobian(layout, polygon):
    """Plane pixels along and down for each unit of length, [2, 3], of what a client interpolates."""
    points, lattice = layout.polygons[polygon], layout.lattice[polygon]
    return np.linalg.lstsq(points - points.mean(0), lattice - lattice.mean(0), rcond=1e-9)[0].T


@pytest.mark.parametrize(("bond", "style"), BONDS.values(), ids=BONDS)
@pytest.mark.parametrize("columns", [4, 5])
@pytest.mark.parametrize("jitter", [0.0, 0.3])
def test_bricks_turn_the_corners_of_a_tower(bond, style, columns, jitter):
    layout = lay_adjacent(raise_walls(circle(8, jitter=jitter)), make_sheet(bond, columns), tiles=6)
    measured = measure_mismatch(layout)
    assert layout.turn.style == style
    assert [meeting.kind for meeting in layout.meetings] == ["corner"] * 8
    assert max(measured.bed.max(), measured.head.max()) < 1e-5
    assert measured.worst == max(measured.bed.max(), measured.head.max())
    np.testing.assert_allclose(layout.stretch[:, 1], 1)
    assert abs(np.log(layout.stretch[:, 0])).max() < 0.25
    if columns == 4 and not jitter:  # 48 tiles around, or as many and headers
        np.testing.assert_allclose(layout.stretch, 1)


@pytest.mark.parametrize("bond", ["running", "a third, back and forth", "stack"])
def test_what_is_drawn_on_both_sides_of_a_corner(bond):
    """Read off rendered maps, with nothing of the library's but these and the texture coordinates."""
    sheet = make_sheet(BONDS[bond][0], tile_width=60.0, tile_height=20.0, mortar_x=6.0, mortar_y=4.0)
    layout = lay_adjacent(raise_walls(circle(8)), sheet, tiles=5)
    grey = Appearance(tiles={(0, 0): (0.3, 0.3, 0.3)}, joint=(0.5, 0.5, 0.5))
    size = round(sheet.width), round(sheet.height)
    bands = render_maps(sheet, grey, size=size, key=jax.random.key(0))
    ids = np.concatenate([maps.tile_id for maps in bands]).astype(int)
    mesh = polygon_mesh(layout)
    uv = mesh.uv.astype(np.float32).reshape(8, 4, 2)

    def look(wall, across, up):
        u, v = (1 - across) * ((1 - up) * uv[wall, 0] + up * uv[wall, 3]) + across * (
            (1 - up) * uv[wall, 1] + up * uv[wall, 2]
        )
        return ids[int((1 - v) * size[1] // 1) % size[1], int(u * size[0] // 1) % size[0]]

    pixel = 1 / (jacobian(layout, 0)[0] @ (layout.polygons[0][1] - layout.polygons[0][0]))
    courses = jacobian(layout, 0)[1] @ [0, -4.0, 0] / 20.0
    seen = set()
    for wall in range(8):
        for course in range(int(courses) - 1):
            up = (course + 0.5) / courses
            left = [look(wall, 1 - (k + 0.5) * pixel, up) for k in range(70)]
            right = [look((wall + 1) % 8, (k + 0.5) * pixel, up) for k in range(70)]
            if bond == "stack":
                assert left[:3] == right[:3] == [-1] * 3
                assert min(left[3], right[3]) >= 0
                continue
            assert left[0] == right[0] >= 0
            lengths = [next(k for k in range(70) if side[k] != side[0]) for side in (left, right)]
            seen.add(tuple(lengths))
    if bond != "stack":
        header = 24 if bond == "running" else 14
        assert seen == {(54, header), (header, 54)}


@pytest.mark.parametrize("name", ["stack", "running", "raking"])
def test_a_wall_that_is_laid_wrong_is_measured(name):
    layout = lay_adjacent(raise_walls(circle(8)), make_sheet(BONDS[name][0]), tiles=6)
    edges = np.array([[meeting.edge.first, meeting.edge.second] for meeting in layout.meetings])

    def spoil(change):
        lattice = tuple(change(points) if number == 3 else points for number, points in enumerate(layout.lattice))
        return measure_mismatch(dataclasses.replace(layout, lattice=lattice))

    touched = (edges == 3).any(axis=1)
    aside = spoil(lambda points: np.add(points, [0.02 * LENGTH, 0.0]))
    np.testing.assert_allclose(aside.head, np.where(touched, 0.02, 0.0), atol=1e-5)
    assert aside.bed.max() < 1e-5
    raised = spoil(lambda points: np.add(points, [0.0, 0.02 * HEIGHT]))
    np.testing.assert_allclose(raised.bed, np.where(touched, 0.02, 0.0), atol=1e-5)
    leaning = spoil(lambda points: np.add(points, [[0, 0], [0, 0], [0, 0.3 * HEIGHT], [0, 0.3 * HEIGHT]]))
    np.testing.assert_allclose(leaning.bed, np.where(touched, 0.3, 0.0), atol=1e-5)
    wide = spoil(lambda points: points[0] + (points - points[0]) * [1.01, 1.0])
    assert 0.05 < wide.head.max() < 0.07
    assert wide.worst == wide.head.max()
    if name != "stack":
        other = spoil(lambda points: np.add(points, [LENGTH, 0.0]))  # every joint in its place, but no brick goes round
        np.testing.assert_allclose(other.head, np.where(touched, 1.0, 0.0), atol=1e-5)


def test_courses_run_around_and_tiles_keep_their_proportions():
    layout = lay_adjacent(raise_walls(circle(8)), make_sheet(BONDS["running"][0]), tiles=6)
    width = np.linalg.norm(layout.polygons[0][1] - layout.polygons[0][0])
    assert width / layout.tile_length == pytest.approx(6 + (0.5 * LENGTH - GAP) / LENGTH)
    for wall in range(8):
        along, down = jacobian(layout, wall)
        right = layout.polygons[wall][1] - layout.polygons[wall][0]
        assert along @ right == pytest.approx(LENGTH / layout.tile_length * width)  # grows to the right
        assert along @ [0, 1, 0] == pytest.approx(0, abs=1e-9)
        np.testing.assert_allclose(down, [0, -LENGTH / layout.tile_length, 0], atol=1e-9)
    uv = polygon_mesh(layout).uv.reshape(8, 4, 2)
    np.testing.assert_allclose(uv[:, :2, 1], 0, atol=1e-9)  # a bed joint at the foot


def test_walls_of_a_row_are_stretched_as_is_told():
    plan = [(0, 0), (0, -2.9), (4.1, -2.9), (4.1, 0)][::-1]
    layout = lay_adjacent(raise_walls(plan), make_sheet(BONDS["running"][0], 2), tile_length=0.25)
    assert measure_mismatch(layout).worst < 1e-5
    for wall in range(4):
        along, down = jacobian(layout, wall)
        pitch = [LENGTH / np.linalg.norm(along), HEIGHT / np.linalg.norm(down)]
        proportion = [layout.tile_length, layout.tile_length * HEIGHT / LENGTH]
        np.testing.assert_allclose(np.array(pitch) / proportion, layout.stretch[wall])
        span = np.ptp(layout.lattice[wall][:, 0]) / LENGTH - (0.5 * LENGTH - GAP) / LENGTH
        assert span == pytest.approx(round(span))
    assert layout.tile_length == pytest.approx(0.25, rel=0.05)
    mean = np.average(np.log(layout.stretch[:, 0]), weights=[4.1, 2.9, 4.1, 2.9])
    assert np.ptp(layout.stretch[:, 0]) > 0
    assert abs(mean) < 0.01


def test_an_open_row_has_its_ends_free():
    walls = raise_walls(circle(8))[:5]
    layout = lay_adjacent(walls, make_sheet(BONDS["running"][0], 5), tiles=6, along=2)
    assert measure_mismatch(layout).worst < 1e-5
    assert len(layout.meetings) == 4
    np.testing.assert_allclose(layout.stretch, 1)
    (alone,) = lay_adjacent(walls[:1], make_sheet(BONDS["stack"][0]), tiles=7).lattice
    assert np.ptp(alone[:, 0]) == pytest.approx(7 * LENGTH)


def test_storeys_and_halves_of_walls_go_on_as_one():
    plan = circle(8)
    lower, upper = raise_walls(plan, 0, 2.3), raise_walls(plan, 2.3, 4.1)
    # One lower wall is two, side by side: its neighbour above has corners of others inside its edge.
    foot = lower.pop(3)
    middle = 0.3 * foot[[0, 3]] + 0.7 * foot[[1, 2]]
    halves = [np.array([foot[0], *middle, foot[3]]), np.array([middle[0], *foot[1:3], middle[1]])]
    layout = lay_adjacent([*lower, *upper, *halves], make_sheet(BONDS["running"][0]), tiles=6)
    kinds = [meeting.kind for meeting in layout.meetings]
    assert (kinds.count("corner"), kinds.count("flush")) == (16, 10)
    assert measure_mismatch(layout).worst < 1e-5
    np.testing.assert_allclose(layout.stretch, 1)


@pytest.mark.parametrize("name", ["stack", "running", "raking"])
def test_inner_corners_are_corners_too(name):
    plan = [(0, 0), (3, 0), (3, -2), (4.5, -2), (4.5, -5), (-1.5, -5), (-1.5, -2), (0, -2)]  # a T
    layout = lay_adjacent(raise_walls(plan), make_sheet(BONDS[name][0]), tile_length=0.2)
    assert measure_mismatch(layout).worst < 1e-5
    assert abs(layout.stretch - 1).max() < 0.2


@pytest.mark.parametrize("name", ["stack", "running", "raking"])
def test_triangles_of_a_mesh_are_laid_as_the_walls_they_make_up(name):
    walls, sheet = raise_walls(circle(8)), make_sheet(BONDS[name][0])
    whole = lay_adjacent(walls, sheet, tiles=6)
    mesh = polygon_mesh(whole)
    split = lay_adjacent(list(mesh.vertices[mesh.faces].astype(np.float32)), sheet, tiles=6)
    assert measure_mismatch(split).worst < 1e-4
    assert {meeting.kind for meeting in split.meetings} == {"flush", "corner"}
    difference = np.concatenate(split.lattice) - np.concatenate(whole.lattice)[mesh.faces].reshape(-1, 2)
    size = np.array([sheet.width, sheet.height])
    np.testing.assert_allclose((difference + 0.5 * size) % size - 0.5 * size, 0, atol=2e-3)


def test_courses_meet_on_walls_that_lean():
    layout = lay_adjacent(raise_walls(circle(8), top=0.8), make_sheet(BONDS["running"][0]), tiles=6)
    measured = measure_mismatch(layout)
    assert {meeting.kind for meeting in layout.meetings} == {"cut"}
    assert measured.bed.max() < 1e-5
    assert np.isnan(measured.head).all()
    np.testing.assert_allclose(layout.stretch, 1)  # along the slope, all slopes being equal
    for wall in range(8):
        np.testing.assert_allclose(jacobian(layout, wall)[0] @ [0, 1, 0], 0, atol=1e-9)


def test_walls_of_two_slopes_share_their_courses_heights():
    plan = np.array([(-2, 2), (2, 2), (2, -2), (-2, -2)], float)
    foot, head = np.insert(plan, 1, 0, axis=1), np.insert(plan * [0.9, 0.5], 1, 3.0, axis=1)
    walls = [np.array([foot[k - 1], foot[k], head[k], head[k - 1]]) for k in range(4)]
    layout = lay_adjacent(walls, make_sheet(BONDS["running"][0]), tiles=6)
    assert measure_mismatch(layout).bed.max() < 1e-5
    slopes = np.array([3 / np.hypot(3, d) for d in (0.2, 1.0, 0.2, 1.0)])
    np.testing.assert_allclose(layout.stretch[:, 1] * slopes, np.full(4, (layout.stretch[:, 1] * slopes)[0]))
    assert layout.stretch[:, 1].min() < 1 < layout.stretch[:, 1].max()


def test_a_spire_goes_on_from_the_walls_with_its_own_slope():
    plan = circle(8)
    eaves = np.insert(plan, 1, 4.0, axis=1)
    spire = [np.array([eaves[k - 1], eaves[k], [0, 9.0, 0]]) for k in range(8)]
    layout = lay_adjacent([*raise_walls(plan), *spire], make_sheet(BONDS["running"][0]), tiles=6)
    kinds = [meeting.kind for meeting in layout.meetings]
    assert (kinds.count("corner"), kinds.count("level"), kinds.count("cut")) == (8, 8, 8)
    assert measure_mismatch(layout).worst < 1e-5
    np.testing.assert_allclose(layout.stretch, 1)


def test_a_flat_roof_goes_on_from_its_longest_edge():
    plan = [(0, 0), (5, 0), (5, -3), (0, -3)]
    roof = np.insert(np.array(plan, float), 1, 4.0, axis=1)
    layout = lay_adjacent([*raise_walls(plan), roof], make_sheet(BONDS["running"][0]), tile_length=0.25)
    measured = measure_mismatch(layout)
    kinds = np.array([meeting.kind for meeting in layout.meetings])
    assert sorted(kinds) == ["corner"] * 4 + ["level"] + ["loose"] * 3
    assert measured.worst < 1e-5
    assert np.isnan(measured.bed[kinds == "loose"]).all()
    (anchor,) = (meeting.edge for meeting in layout.meetings if meeting.kind == "level")
    assert anchor.length == pytest.approx(5)
    along, down = jacobian(layout, 4)
    assert along @ down == pytest.approx(0, abs=1e-9)
    np.testing.assert_allclose(LENGTH / layout.tile_length, np.linalg.norm(down))


def test_the_two_sides_of_a_roof_are_laid_upright():
    ridge = np.array([[0, 3, -1], [4, 3, -1]], float)
    front = np.array([[0, 2, 0], [4, 2, 0], *ridge[::-1]])
    back = np.array([[4, 2, -2], [0, 2, -2], *ridge])
    layout = lay_adjacent([front, back], make_sheet(BONDS["running"][0]), tiles=8)
    assert [meeting.kind for meeting in layout.meetings] == ["loose"]
    for side, sign in ((0, 1), (1, -1)):
        along, down = jacobian(layout, side)
        assert sign * along[0] > 0
        assert down[1] < 0
    assert measure_mismatch(layout).worst == 0


def test_which_way_is_up_is_free():
    walls = raise_walls(circle(8))
    sheet = make_sheet(BONDS["running"][0])
    turned = lay_adjacent([wall[:, [2, 0, 1]] for wall in walls], sheet, tiles=6, up=(0, 0, 2))
    for one, other in zip(lay_adjacent(walls, sheet, tiles=6).lattice, turned.lattice, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9)


def test_whole_courses_fill_the_height():
    layout = lay_adjacent(raise_walls(circle(8)), make_sheet(BONDS["running"][0]), tiles=6, whole_courses=True)
    courses = np.ptp(layout.lattice[0][:, 1]) / HEIGHT
    assert courses == pytest.approx(round(courses))
    np.testing.assert_allclose(layout.stretch[:, 0], 1)
    assert abs(layout.stretch[0, 1] - 1) < 0.5 / courses + 1e-9


@settings(max_examples=40, deadline=None)
@given(
    sides=st.integers(3, 10),
    seed=st.integers(0, 1000),
    offset=st.sampled_from([0.0, 0.5, 0.3, 0.72]),
    gap=st.sampled_from([0.0, 1.0, 4.0]),
    columns=st.integers(1, 6),
    tiles=st.floats(6, 12),
    style=st.sampled_from([None, "wrap"]),
)
def test_any_tower_is_tiled_without_a_mismatch(sides, seed, offset, gap, columns, tiles, style):
    sheet = make_sheet({"course_offsets": (0.2, 0.2 + offset)}, columns, mortar_x=gap)
    walls = raise_walls(circle(sides, jitter=0.3, seed=seed))
    layout = lay_adjacent(walls, sheet, tiles=tiles, along=seed % sides, corners=style)
    assert measure_mismatch(layout).worst < 1e-4


@pytest.mark.parametrize("name", ["stack", "running", "raking", "flemish"])
@pytest.mark.parametrize("tiles", [5, 6, 7, 9])
def test_a_sheet_is_found_that_goes_around(name, tiles):
    wall = make_tiling(tile_width=LENGTH, tile_height=HEIGHT, mortar_x=GAP, mortar_y=3.0, **BONDS[name][0])
    layout = lay_tiling(raise_walls(circle(8)), wall, tiles=tiles)
    np.testing.assert_allclose(layout.stretch, 1)
    assert layout.tile_length == pytest.approx(layout.asked_length)
    assert measure_mismatch(layout).worst < 1e-5
    with pytest.raises(InputError, match="does not go with"):
        lay_tiling(raise_walls(circle(8)), wall, tiles=tiles, corners="quoin" if name != "running" else "joint")


def test_texture_coordinates_stay_small():
    layout = lay_adjacent(raise_walls(circle(8)), make_sheet(BONDS["running"][0]), tiles=60)
    uv = polygon_mesh(layout).uv.reshape(8, 4, 2)
    assert uv.min() >= -1e-8
    assert uv.min(axis=1).max() < 1
    assert measure_mismatch(layout).worst < 1e-4


def test_a_mesh_of_polygons_keeps_them():
    gable = np.array([[0, 0, 0], [4, 0, 0], [4, 2, 0], [2, 3.5, 0], [0, 2, 0]])
    side = np.array([[4, 0, 0], [4, 0, -3], [4, 2, -3], [4, 2, 0]])
    mesh = polygon_mesh(lay_adjacent([gable, side], make_sheet(BONDS["running"][0]), tiles=8))
    assert mesh.vertices.shape == (9, 3)
    a, b, c = mesh.vertices[mesh.faces].swapaxes(0, 1)
    area = 0.5 * np.cross(b - a, c - a)
    np.testing.assert_allclose(np.linalg.norm(area, axis=1).sum(), 11 + 6)
    np.testing.assert_allclose(area / np.linalg.norm(area, axis=1)[:, None], mesh.normals[mesh.faces[:, 0]], atol=1e-12)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"tiles": None}, "one of them"),
        ({"tile_length": 0.2}, "one of them"),
        ({"tiles": -1.0}, "more than 0"),
        ({"along": 8}, "polygon 8: does not exist"),
        ({"up": (0, 0, 0)}, "not all 0"),
        ({"corners": "joint"}, "does not go with this running bond"),
        ({"corners": "mitre"}, "not one of quoin, joint, wrap"),
        ({"tiles": 0.1}, "too short|too few tiles"),
    ],
)
def test_what_cannot_be_laid_is_refused(change, told):
    with pytest.raises(InputError, match=told):
        lay_adjacent(raise_walls(circle(8)), make_sheet(BONDS["running"][0]), **{"tiles": 6, **change})


def test_a_sheet_that_does_not_repeat_is_refused():
    sheet = lay_sheet(make_tiling(tile_width=60, tile_height=20), tiles=(3, 3))
    with pytest.raises(InputError, match="seamless=True"):
        lay_adjacent(raise_walls(circle(4)), sheet, tiles=6)


def test_corners_that_contradict_each_other_are_named():
    # A narrower storey, flush with the front alone: its corners are not where the bricks below have theirs.
    lower = raise_walls([(0, 0), (4.03, 0), (4.03, -4), (0, -4)], 0, 2)
    upper = raise_walls([(1.2, 0), (3.4, 0), (3.4, -2), (1.2, -2)], 2, 4)
    sheet = make_sheet(BONDS["running"][0])
    with pytest.raises(InputError, match=r"polygons \d and \d: tiles cannot turn their corner"):
        lay_adjacent([*lower, *upper], sheet, tile_length=0.25)
    layout = lay_adjacent([*lower, *upper], sheet, tile_length=0.25, corners="wrap")
    assert measure_mismatch(layout).worst < 1e-4


def test_heights_that_contradict_each_other_are_named():
    # A wall, and beside it another with a roof on it that leads up to a third; that one joins the first round a corner.
    tall = [[2, 0, 0], [4, 0, 0], [4, 4, 0], [2, 4, 0]]
    low = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]]
    roof = [[0, 2, 0], [2, 2, 0], [2, 3, -1], [0, 3, -1]]
    third = [[0, 3, -1], [2, 3, -1], [2, 4, -1], [0, 4, -1]]
    side = [[2, 3, -1], [2, 3, 0], [2, 4, 0], [2, 4, -1]]
    sheet = make_sheet(BONDS["raking"][0])
    with pytest.raises(InputError, match=r"polygons \d and \d: cannot meet at the edge they share"):
        lay_adjacent([tall, low, roof, third, side], sheet, tile_length=0.25)
    assert measure_mismatch(lay_adjacent([tall, low, roof, third], sheet, tile_length=0.25)).worst < 1e-5
