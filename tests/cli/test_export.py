"""`jaxtex export`: from a model file to one file that clients open, and everything that can be wrong with it."""

import json
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh
from gltf_validator import complaints, find_validator, validate

from jaxtex.cli.main import main
from jaxtex.io.raster import read_raster
from jaxtex.material import sheet
from jaxtex.material.measure import measure_appearance
from jaxtex.models.files import SourceImage, TilingFile, save_model
from jaxtex.models.floor_files import FloorFile, PlacedWood
from jaxtex.models.tiling import make_tiling
from jaxtex.models.wood import make_wood
from jaxtex.models.wood_files import WoodFile

REPORT = {"ok": True, "reason": "made by hand", "iou": None, "start": None, "standard_errors": {}}
PHOTO = SourceImage(120, 100, "0" * 64)
OAK = make_wood(ring_spacing=9.0, center=(20.0, 3.0), tilt=0.3)
KITE = "v 0 0 0\nv 2 0 0\nv 0 2 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"


def make_wall_file(**options) -> TilingFile:
    wall = make_tiling(tile_width=40.0, tile_height=20.0, mortar_x=4.0, mortar_y=3.0, offset=0.498)
    photo = np.random.default_rng(0).uniform(0.2, 0.6, (100, 120, 3)).astype(np.float32)
    appearance = measure_appearance(photo, wall).to_json()
    return TilingFile(wall, PHOTO, 5, 3, REPORT, appearance=appearance, **options)


@pytest.fixture
def wall(tmp_path: Path) -> Path:
    save_model(tmp_path / "wall.json", make_wall_file())
    return tmp_path / "wall.json"


@pytest.fixture
def oak(tmp_path: Path) -> Path:
    save_model(tmp_path / "oak.json", WoodFile(OAK, PHOTO, {}, REPORT))
    return tmp_path / "oak.json"


@pytest.fixture
def planks(tmp_path: Path) -> Path:
    corners = np.array([[0.0, 0], [60, 0], [60, 100], [0, 100]])
    woods = (PlacedWood(corners, OAK, True), PlacedWood(corners + np.array([60, 0]), OAK, False))
    save_model(tmp_path / "planks.json", FloorFile(woods, PHOTO, REPORT))
    return tmp_path / "planks.json"


@pytest.fixture
def kite(tmp_path: Path) -> Path:
    (tmp_path / "kite.obj").write_text(KITE)
    return tmp_path / "kite.obj"


def export(model: Path, *options: str) -> trimesh.Trimesh:
    path = model.parent / "out.glb"
    assert main(["export", str(model), "-o", str(path), *options]) == 0
    return trimesh.load_scene(path, process=False).geometry["out"]


def read_tree(path: Path) -> dict:
    data = path.read_bytes()
    return json.loads(data[20 : 20 + struct.unpack_from("<I", data, 12)[0]])


def colour_of(mesh: trimesh.Trimesh) -> np.ndarray:
    return np.asarray(mesh.visual.material.baseColorTexture)


def test_a_wall_is_seamless_and_says_so(wall: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh = export(wall)
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"{wall.parent / 'out.glb'}: a wall of 2 x 2 m, textures of 120 x 120 pixels, 3 x 6 tiles"
    assert lines[1] == "  note: what the textures show is taken to be 2 m wide; --width says otherwise"
    assert [line.partition(", ")[2] for line in lines[2:]] == ["5 courses became 6", "the offset 0.498 became 0.5"]
    np.testing.assert_allclose(mesh.bounds, [[-1, 0, 0], [1, 2, 0]])


def test_textures_are_the_maps_of_render(wall: Path) -> None:
    options = ["--size", "160x96", "--tiles", "4x4", "--seed", "3"]
    material = export(wall, *options).visual.material
    folder = wall.parent / "maps"
    assert main(["render", str(wall), "-o", str(folder), "--seamless", *options]) == 0
    assert np.array_equal(np.asarray(material.baseColorTexture), read_raster(folder / "basecolor.png").numbers)
    assert np.array_equal(np.asarray(material.normalTexture), read_raster(folder / "normal.png").numbers)
    rough = np.asarray(material.metallicRoughnessTexture)[..., 1]
    assert np.array_equal(rough, read_raster(folder / "roughness.png").numbers[..., 0])


def test_sizes_in_the_world(wall: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh = export(wall, "--width", "3", "--repeat", "4x2", "--tiles", "6x6")
    np.testing.assert_allclose(mesh.extents, [12, 3, 0], atol=1e-6)  # 6 x 6 tiles of 40 x 20 are twice as wide as high
    (material,) = read_tree(wall.parent / "out.glb")["materials"]
    scale = material["normalTexture"]["extensions"]["KHR_texture_transform"]["scale"]
    assert scale == [4, 2]
    assert "taken to be" not in capsys.readouterr().out
    save_model(wall, make_wall_file(mm_per_px=5.0))
    np.testing.assert_allclose(export(wall).extents, [0.6, 0.6, 0], atol=1e-6)
    assert "taken to be" not in capsys.readouterr().out
    np.testing.assert_allclose(export(wall, "--on", "floor").extents, [0.6, 0, 0.6], atol=1e-6)


def test_a_bond_that_cannot_close_is_exported_with_a_seam(
    wall: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sheet, "_LONGEST", 1)  # or thousands of tiles could be found in the end
    never = make_tiling(tile_width=40.0, tile_height=20.0, course_lengths=((1.0,), (0.61803,)), bond="irregular")
    save_model(wall, TilingFile(never, PHOTO, 5, 3, REPORT))
    export(wall)
    out = capsys.readouterr().out
    assert "textures of 97 x 100 pixels, 3 x 5 tiles\n" in out
    assert "\n  note: they repeat with a seam, as the courses' tile lengths do not come round together" in out
    assert main(["render", str(wall), "-o", str(wall.parent / "maps"), "--seamless"]) == 2


def test_large_photographs_give_textures_of_at_most_2048_pixels(oak: Path) -> None:
    save_model(oak, WoodFile(OAK, SourceImage(4096, 64, "0" * 64), {}, REPORT))
    mesh = export(oak)
    assert colour_of(mesh).shape == (32, 2048, 3)
    np.testing.assert_allclose(mesh.extents, [2, 2 / 64, 0], atol=1e-6)


def test_wood_repeats_with_a_seam(oak: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert colour_of(export(oak, "--size", "60x30")).shape == (30, 60, 3)
    assert "with a seam" not in capsys.readouterr().out
    np.testing.assert_allclose(export(oak, "--size", "60x30", "--repeat", "2x1").extents, [4, 1, 0], atol=1e-6)
    assert "note: textures of wood repeat with a seam" in capsys.readouterr().out


def test_a_floor_of_planks(planks: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh = export(planks, "--on", "floor", "--width", "6")
    np.testing.assert_allclose(mesh.extents, [6, 0, 5], atol=1e-6)
    assert "2 planks" in capsys.readouterr().out


def test_a_mesh_keeps_its_place(wall: Path, kite: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh = export(wall, "--on", str(kite), "--repeat", "3x3")
    assert f"1 triangles of {kite}" in capsys.readouterr().out
    np.testing.assert_allclose(mesh.vertices, [[0, 0, 0], [2, 0, 0], [0, 2, 0]])
    np.testing.assert_allclose(mesh.visual.uv, [[0, 0], [1, 0], [0, 1]], atol=1e-6)


def test_a_best_guess_says_so(oak: Path, capsys: pytest.CaptureFixture[str]) -> None:
    save_model(oak, WoodFile(OAK, PHOTO, {}, {**REPORT, "ok": False, "reason": "no rings"}))
    export(oak, "--size", "16x16")
    assert "its fit did not succeed: no rings" in capsys.readouterr().out


@pytest.mark.skipif(
    find_validator() is None, reason="needs Node and gltf-validator (make test installs it where there is npm)"
)
@pytest.mark.parametrize("model", ["wall", "oak", "planks"])
@pytest.mark.parametrize("on", ["wall", "floor"])
def test_khronos_has_nothing_to_say(request: pytest.FixtureRequest, model: str, on: str) -> None:
    path = request.getfixturevalue(model)
    export(path, "--on", on, "--size", "64x64", "--repeat", "2x2")
    assert complaints(validate(path.parent / "out.glb")) == []


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["-o", "{folder}/a.usd"], "a.usd: cannot be written as '.usd'; name it .glb"),
        (["-o", "{folder}/none/a.glb"], "there is no folder"),
        (["-o", "{folder}"], "is a folder; name a file"),
        (["--size", "big"], "--size: 'big' is no size"),
        (["--size", "8x8"], "is too small for 3 x 6 tiles"),
        (["--size", "20000x90"], "textures of 20000 x 90 pixels cannot be made; give 1 to 16384 to a side"),
        (["--tiles", "3by5"], "--tiles: '3by5' is no number of tiles"),
        (["--repeat", "0x1"], "--repeat: '0x1' is no number of repeats"),
        (["--width", "0"], "--width: 0 is no width"),
        (["--width", "nan"], "--width: nan is no width"),
        (["--width", "3", "--on", "{kite}"], "--width: is for walls and floors"),
        (["--seed", "-1"], "--seed: -1 is out of range"),
        (["--on", "{folder}/none.obj"], "none.obj: there is no such file"),
        (["--on", "{bare}"], "bare.obj: has no texture coordinates; unwrap it in your modeller first"),
        (["--on", "ceiling"], "ceiling: there is no such file"),
        (["--tiles-in-row", "5"], "--tiles-in-row: is for meshes; for a wall, give --tiles and --repeat"),
        (["--tiles-in-row", "0", "--on", "{bare}"], "--tiles-in-row: 0 is no number of tiles; give 1 or more"),
        (["--tiles-in-row", "5", "--tiles", "2x2", "--on", "{bare}"], "leave out --tiles and --repeat"),
        (["--finish", "tile"], "--finish: 'tile' gives no structure a finish"),
        (["--finish", "roof=wet"], "'roof' is no structure of a tiling"),
        (["--finish", "tile=gold"], "'gold' is no finish; give one of dull, satin"),
    ],
)
def test_what_cannot_be_exported_is_one_line(
    wall: Path, kite: Path, capsys: pytest.CaptureFixture[str], options: list[str], told: str
) -> None:
    bare = wall.parent / "bare.obj"
    bare.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    before = sorted(wall.parent.iterdir())
    words = [option.format(folder=wall.parent, kite=kite, bare=bare) for option in options]
    output = [] if "-o" in words else ["-o", str(wall.parent / "out.glb")]
    assert main(["export", str(wall), *output, *words]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("jaxtex: error: ")
    assert err.count("\n") == 1
    assert told in err
    assert sorted(wall.parent.iterdir()) == before


@pytest.mark.parametrize("model", ["oak", "planks"])
def test_tiles_are_for_tilings(request: pytest.FixtureRequest, capsys: pytest.CaptureFixture[str], model: str) -> None:
    path = request.getfixturevalue(model)
    assert main(["export", str(path), "-o", str(path.parent / "out.glb"), "--tiles", "2x2"]) == 2
    assert f"--tiles: {path} is a model of" in capsys.readouterr().err
    assert main(["export", str(path.parent / "none.json"), "-o", str(path.parent / "out.glb")]) == 2
    assert "no such file" in capsys.readouterr().err


def test_one_tiling_goes_over_all_faces_of_a_mesh(wall: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tower = wall.parent / "tower.obj"
    corners = [(1, 1), (1, -1), (-1, -1), (-1, 1)]
    lines = [f"v {x} {y} {z}" for x, z in corners for y in (0, 3)]
    lines += [f"f {2 * k + 1} {n + 1} {n + 2} {2 * k + 2}" for k in range(4) for n in (2 * ((k + 1) % 4),)]
    tower.write_text("\n".join(lines))
    mesh = export(wall, "--on", str(tower), "--tiles-in-row", "5", "--size", "256x256")
    told = capsys.readouterr().out
    assert float(told.partition("to within ")[2].split()[0]) < 0.01
    assert len(mesh.faces) == 8
    # Five tiles of twice their height along a wall of 2 m: texture coordinates go by metres in both directions.
    (columns, rows) = map(float, told.partition("pixels, ")[2].split(" tiles")[0].split(" x "))
    across, up = np.ptp(mesh.visual.uv[mesh.faces[0]], axis=0) * [columns, rows]
    assert across == pytest.approx(5, abs=0.6)
    assert up == pytest.approx(3 / (2 / across) * 2, rel=0.1)
