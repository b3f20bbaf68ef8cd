"""The scripts in fitting/: their own geometry against the library's, and their measures against known answers."""

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import jaxtex as jt
from jaxtex.io.meshes import Mesh, read_mesh, write_mesh
from jaxtex.material.solid import place_in_solid
from jaxtex.models.canonical import canonical


@pytest.mark.parametrize("script", ["recovery"], indirect=True)
@pytest.mark.parametrize("bond", ["stack", "running", "raking", "irregular"])
def test_the_masks_of_the_recovery_are_those_of_the_model(script: ModuleType, bond: str) -> None:
    wall = script.draw_wall(bond, np.random.default_rng(1))
    rendered = np.asarray(jt.coverage_grid(script.tiling_of(wall), script.SIZE, script.SIZE, blur=0.1)) > 0.5
    assert (rendered == script.draw_mask(wall)).mean() > 0.999
    errors = script.find_errors(wall, canonical(script.tiling_of(wall)))
    assert script.is_captured(errors)
    assert np.nanmax(list(errors.values())) < 1e-3


@pytest.mark.parametrize("script", ["recovery"], indirect=True)
def test_masks_are_spoilt_as_much_as_is_said(script: ModuleType) -> None:
    mask = np.ones((script.SIZE, script.SIZE), bool)
    spoilt = [script.spoil_mask(mask, np.random.default_rng(seed)) for seed in range(20)]
    # Half of the blotches change nothing here: 0.9 (0.05) + 0.1 (0.95)
    assert np.mean([1 - one.mean() for one in spoilt]) == pytest.approx(0.14, abs=0.02)


@pytest.mark.parametrize("script", ["particle_controls"], indirect=True)
def test_what_controls_do_is_measured(script: ModuleType) -> None:
    spots = script.draw_spots()
    whole = next(number for number, each in enumerate(spots.things.particles) if each.complete)
    assert script.own_axis(spots, whole) == pytest.approx(spots.things.particles[whole].box.angle, abs=0.15)
    neighbours, drawn = (float(each) for each in script.measure_turn(spots, 500))
    assert neighbours < 4
    assert drawn < 2
    inside, before = script.measure_forbidden(spots, 500).split(" of ")
    assert inside == "0"
    assert int(before) > 20
    assert float(script.measure_size(spots, 700)) == pytest.approx(1, abs=0.2)
    assert float(script.measure_probability(spots, 500)) == pytest.approx(0.3, abs=0.1)
    # The spots lie nearly as hexagons do, six ways.
    mean = []
    for controls in ((), (jt.Control(orientation=0.2),)):
        ways, there = script.nearest_ways(script.on_plane(spots.seed(500, *controls)))
        mean.append(np.mean((ways[there] / np.abs(ways[there])) ** 6))
    assert np.angle(mean[1] / mean[0]) / 6 == pytest.approx(0.2, abs=0.05)


@pytest.mark.parametrize("script", ["accuracy"], indirect=True)
def test_corners_are_measured_in_tile_heights(script: ModuleType) -> None:
    to_image = np.array([[0.55, 0.18, 59.0], [-0.19, 0.71, 53.0], [-2.5e-4, 1.6e-4, 1.0]])
    truth = {
        "H_base_px_to_image_px": to_image.tolist(),
        "column_pitch_base_px": 256.0,
        "course_pitch_base_px": 128.0,
        "offset": 0.5,
    }
    homography = np.linalg.inv(to_image)
    wall = {
        "tile_width": 256.0,
        "tile_height": 128.0,
        "homography": homography / homography[2, 2],
        "origin": (13.0, 7.0),
    }
    assert script.find_corner_error(jt.make_tiling(**wall, offset=0.5), truth, (900, 675)) < 0.01
    assert script.find_corner_error(jt.make_tiling(**wall, offset=-0.5), truth, (900, 675)) < 0.01
    # A course further on, tiles are a hundredth of a width, which is a fiftieth of a height, aside: more and more.
    assert 2 < script.find_corner_error(jt.make_tiling(**wall, offset=0.51), truth, (900, 675)) < 20
    wall["tile_height"] = 64.0
    assert script.find_corner_error(jt.make_tiling(**wall, offset=0.5), truth, (900, 675)) == np.inf


@pytest.mark.parametrize("script", ["accuracy"], indirect=True)
@pytest.mark.parametrize(
    ("file", "kind", "other"),
    [
        ("natural/grass.png", "grass", True),
        ("natural/coins.png", "coins on dark ground", False),
        ("solids/rings.png", "growth-ring probability map", False),
        ("wood/board.png", "flat-sawn board", True),
        ("wood/floor.png", "planks, grain vertical", False),
        ("tilings/paving.png", "herringbone paving", True),
        ("tilings/brick.png", "running bond brick", False),
    ],
)
def test_what_is_no_tiling(script: ModuleType, file: str, kind: str, other: bool) -> None:
    assert script.is_other({"file": file, "class": kind}) is other


@pytest.mark.parametrize("script", ["gallery"], indirect=True)
def test_the_gallery_says_what_cannot_be_used(script: ModuleType, tmp_path: Path) -> None:
    (tmp_path / "broken.png").write_bytes(b"no picture")
    (tmp_path / "notes.txt").write_text("no picture either")
    jt.write_image(tmp_path / "tiny.jpg", np.eye(8))
    rows = list(script.fit_all(script.list_folder(tmp_path), tmp_path / "out"))
    assert [row[0] for row in rows] == ["broken", "tiny"]
    assert all(row[4].startswith("cannot be used: ") for row in rows)
    assert all(source.path.is_file() for source in script.list_shipped())


@pytest.mark.parametrize("script", ["tower"], indirect=True)
@pytest.mark.parametrize(("bond", "style"), [(None, "wrap"), ("running", "quoin"), ("stack", "joint")])
def test_bricks_go_around_the_tower(script: ModuleType, bond: str | None, style: str) -> None:
    layout, appearance = script.lay_bricks(jt.load_model(script.MODEL), bond, 6)
    assert (len(layout.polygons), layout.turn.style) == (8, style)
    told = script.describe(layout).splitlines()
    assert sum("corner" in line for line in told[2:-3]) == 8
    assert float(told[-1].removeprefix("largest mismatch: ").removesuffix(" tile")) < 1e-5
    picture = script.draw_tower(layout, appearance, script.VIEWS[0], size=(60, 90))
    assert picture.shape == (90, 60, 3)
    # Where the middle of the picture looks there is a wall: joints and bricks on it, the sky beside it.
    assert np.ptp(picture[30:60, 25:35]) > 0.1
    np.testing.assert_array_equal(picture[:, 0], 1)


@pytest.mark.parametrize("script", ["tables"], indirect=True)
def test_tables_are_aligned(script: ModuleType) -> None:
    table = script.make_table(("a", "long"), [("wide cell", "1"), ("", "22")])
    assert table.splitlines() == [
        "| a         | long |",
        "| --------- | ---- |",
        "| wide cell | 1    |",
        "|           | 22   |",
    ]


@pytest.mark.parametrize("script", ["raster"], indirect=True)
def test_the_nearest_triangle_is_seen(script: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(3)
    vertices, faces = rng.normal(size=(60, 3)), rng.integers(60, size=(40, 3))  # some have no area
    view, (width, height) = script.View(np.array([0.4, 1.0, 6.0]), np.array([0.1, 0.0, 0.0]), 2.5), (31, 22)
    monkeypatch.setattr(script, "_AT_ONCE", 500)
    seen = script.rasterise(vertices, faces, view, (width, height))
    right, up, ahead = script.look_at(view)
    for row in range(height):
        for column in range(width):
            x, y = (column + 0.5 - width / 2), (height / 2 - row - 0.5)
            ray = ahead + (x * right + y * up) / (0.5 * view.lens * height)
            nearest, number = np.inf, -1
            for face, corners in enumerate(vertices[faces]):
                # eye + t ray = share @ corners, with shares that sum to 1
                matrix = np.vstack([np.column_stack([corners.T, -ray]), [1, 1, 1, 0]])
                if abs(np.linalg.det(matrix)) > 1e-9:
                    *share, distance = np.linalg.solve(matrix, [*view.eye, 1])
                    if min(share) >= 0 and distance < nearest:
                        nearest, number = distance, face
            assert seen.face[row, column] == number
            assert seen.away[row, column] == pytest.approx(nearest)
            if number >= 0:
                met = seen.share[row, column] @ vertices[faces[number]]
                np.testing.assert_allclose(met, view.eye + nearest * ray, atol=1e-9)


@pytest.mark.parametrize("script", ["solid_scene"], indirect=True)
def test_carved_things_stand_on_the_ground_in_their_own_solid(script: ModuleType, tmp_path: Path) -> None:
    corners = np.array([[1.0, 1, 1], [3, 1, 1], [1, 5, 1], [1, 1, 2]])
    box = Mesh(corners, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))
    write_mesh(tmp_path / "box.ply", box, np.zeros((4, 3)))
    things = [
        script.Thing("box.ply", "red", 2.0, (-1.5, 0.0), 90, 1.0),
        script.Thing("box.ply", "", 1.0, (1.5, 0), 0, 2),
    ]
    scene = script.place_things(tmp_path, things)
    assert scene.thing.tolist() == [0] * 4 + [1] * 4
    np.testing.assert_allclose(scene.vertices[:4].min(axis=0)[1], 0, atol=1e-12)
    np.testing.assert_allclose(np.ptp(scene.vertices[:4], axis=0), [0.5, 2, 1], atol=1e-6)
    solid = jt.make_solid(np.zeros((script.SIDE,) * 3 + (1,)))
    placed = [place_in_solid(solid, read_mesh(tmp_path / "box.ply"), scale=scale) for scale in (1, 2)]
    np.testing.assert_allclose(scene.points, np.concatenate(placed))
    solids = [jt.make_solid(np.full((2, 2, 2, 3), colour)) for colour in ([0.5, 0, 0], [0, 0, 0.5])]
    picture = script.draw_scene(scene, solids, (80, 40))
    red, blue = picture[..., 0] - picture[..., 2] > 0.1, picture[..., 2] - picture[..., 0] > 0.1
    assert 0 < np.flatnonzero(red.any(axis=0)).max() < 40 < np.flatnonzero(blue.any(axis=0)).min()


@pytest.mark.parametrize("script", ["solids"], indirect=True)
def test_the_wood_of_a_cube_is_cut_where_the_cube_was(script: ModuleType) -> None:
    """A trunk that stands upright in the cube, its axis at x = 40 and z = -300, seen from face C."""
    wood = jt.make_wood(center=(-300.0 - 128, 40.0), ring_spacing=60.0, early_rgb=(0.5,) * 3, late_rgb=(0.1,) * 3)
    shown = script.cut_model(wood)[..., 0]
    column = np.arange(256) + 0.5
    count = np.hypot(0.7 * 256 - 0.575 * column - 40, 256 - column + 300) / 60
    early = np.sin(2 * np.pi * count) > np.cos(np.pi * 0.6)
    assert ((shown > shown.mean()) == early[None, :]).mean() > 0.97


@pytest.mark.parametrize("script", ["solids"], indirect=True)
def test_rows_show_each_view_once(script: ModuleType) -> None:
    grain = np.random.default_rng(0).random((40, 40, 3))
    voxels = np.full((4, 4, 4, 3), 0.5)
    one = script.draw_blocks({"xy": grain, "xz": grain, "yz": grain}, [voxels])
    two = script.draw_blocks({"xy": grain, "yz": grain[::-1]}, [voxels, voxels])
    assert (one.shape, two.shape) == ((384, 4 * 384, 3), (384, 5 * 384, 3))
    assert (one[:, 384 : 3 * 384] == 1).all()
    np.testing.assert_allclose(two[:40, 384:424], script.srgb_to_linear(grain[::-1]), atol=1e-6)


@pytest.mark.parametrize("script", ["particles"], indirect=True)
def test_a_row_shows_things_outlined_and_arranged_anew(script: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(script, "SIDE", 96)
    row, column = np.indices((90, 90)) % 30 - 15
    things = np.hypot(row, column) < 8
    drawn, said = script.arrange_anew(np.where(things, 0.1, 0.6)[..., None])
    assert drawn.shape == (96, 5 * 96, 3)
    picture, outlined, seeded, relaxed, lapped = np.split(drawn, 5, axis=1)
    ground_alone = np.hypot(row, column) > 11
    np.testing.assert_allclose(outlined[:90, :90][ground_alone], 0.35 * picture[:90, :90][ground_alone], rtol=1e-5)
    for new in (seeded, relaxed, lapped):
        assert np.mean(new < 0.5) == pytest.approx(things.mean(), rel=0.3)
    assert said[:4] == ["9", "0", "1", "9"]
