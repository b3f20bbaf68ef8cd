"""`jaxtex render` of wood: maps, blocks, carved meshes, and what cannot be asked for."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from jaxtex.cli.main import main
from jaxtex.io.images import read_image
from jaxtex.material.wood import render_points
from jaxtex.models.files import SourceImage, TilingFile, save_model
from jaxtex.models.tiling import make_tiling
from jaxtex.models.wood import make_wood
from jaxtex.models.wood_files import WoodFile

REPORT = {"ok": True, "reason": "made by hand", "iou": None, "start": None, "standard_errors": {}}
IMAGE = SourceImage(60, 40, "0" * 64)
OAK = make_wood(ring_spacing=9.0, center=(20.0, 3.0), tilt=0.3, turbulence_rms=1.0, turbulence_frequency=0.02, seed=5)


@pytest.fixture
def model(tmp_path: Path) -> Path:
    save_model(tmp_path / "oak.json", WoodFile(OAK, IMAGE, {}, REPORT, seed=5))
    return tmp_path / "oak.json"


def render(model: Path, *options: str) -> Path:
    folder = model.parent / "out"
    assert main(["render", str(model), "-o", str(folder), *options]) == 0
    return folder


def test_maps_are_as_large_as_the_photograph_unless_told(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = render(model)
    assert capsys.readouterr().out == f"{folder}: maps of 60 x 40 pixels, 1 to one of the photograph\n"
    names = {"basecolor.png", "height.exr", "normal.png", "roughness.png", "specular.png", "metallic.png"}
    assert {path.name for path in folder.iterdir()} == names
    assert {read_image(folder / name).pixels.shape[:2] for name in names} == {(40, 60)}
    # The file's turbulence is that of its seed.
    early = np.asarray(OAK.early_on_plank(np.array([10.5, -4.5], np.float32), blur=0.5))
    expected = OAK.late_rgb + early * (OAK.early_rgb - OAK.late_rgb)
    np.testing.assert_allclose(read_image(folder / "basecolor.png").pixels[15, 40], expected, atol=0.01)


def test_the_size_is_as_told(model: Path) -> None:
    folder = render(model, "--size", "90x200")
    assert read_image(folder / "basecolor.png").pixels.shape == (200, 90, 3)


def test_a_block_is_written(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = render(model, "--block", "3x4x5")
    assert capsys.readouterr().out == f"{folder / 'voxels.npz'}: a block of 3 x 4 x 5 voxels\n"
    assert [path.name for path in folder.iterdir()] == ["voxels.npz"]
    voxels = np.load(folder / "voxels.npz")["voxels"]
    assert (voxels.shape, voxels.dtype) == ((3, 4, 5, 3), np.float32)
    np.testing.assert_allclose(voxels[2, 1, 4], render_points(OAK, np.array([[2.0, -0.5, 2.0]]))[0], atol=1e-4)


def test_a_mesh_is_carved(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ball = trimesh.creation.icosphere(subdivisions=4, radius=3.0)
    ball.export(model.parent / "ball.obj")
    folder = render(model, "--mesh", str(model.parent / "ball.obj"))
    assert capsys.readouterr().out == f"{folder / 'mesh.ply'}: a mesh of {len(ball.vertices)} coloured vertices\n"
    carved = trimesh.load_mesh(folder / "mesh.ply", process=False)
    assert len(carved.vertices) == len(ball.vertices)
    assert np.unique(carved.visual.vertex_colors[:, :3], axis=0).shape[0] > 20


def test_a_best_guess_says_so(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report = {**REPORT, "ok": False, "reason": "no rings"}
    save_model(model, WoodFile(OAK, IMAGE, {}, report, seed=5))
    render(model, "--block", "1x1x1")
    assert "its fit did not succeed: no rings" in capsys.readouterr().out


def complain(capsys: pytest.CaptureFixture[str], model: Path, *options: str) -> str:
    folder = model.parent / "out"
    assert main(["render", str(model), "-o", str(folder), *options]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("jaxtex: error: ")
    assert err.count("\n") == 1
    assert not folder.exists()
    return err


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--tiles", "2x3"], "oak.json is a model of wood, which has no tiles"),
        (["--seamless"], "--seamless: "),
        (["--size", "90000x10"], "is too large"),
        (["--block", "3x4"], "--block: '3x4' is no block"),
        (["--block", "9999x9999x9999"], "block 9999 x 9999 x 9999: is too large"),
        (["--mesh", "nowhere.ply"], "nowhere.ply: there is no such file"),
        (["--block", "3x4x5", "--size", "9x9"], "--size and --block: ask for different things; give one of them"),
        (["--block", "3x4x5", "--mesh", "ball.ply"], "--block and --mesh: ask for different things"),
    ],
)
def test_what_cannot_be_made_of_wood_is_one_line(
    model: Path, capsys: pytest.CaptureFixture[str], options: list[str], told: str
) -> None:
    assert told in complain(capsys, model, *options)


def test_a_mesh_without_extent_is_named(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (model.parent / "dot.obj").write_text("v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n")
    assert "dot.obj: all vertices of the mesh lie" in complain(capsys, model, "--mesh", str(model.parent / "dot.obj"))


@pytest.mark.parametrize("options", [["--block", "3x4x5"], ["--mesh", "ball.ply"]])
def test_what_is_for_wood_cannot_be_made_of_tiles(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str]
) -> None:
    wall = make_tiling(tile_width=30.0, tile_height=20.0)
    save_model(tmp_path / "wall.json", TilingFile(wall, IMAGE, 2, 2, REPORT))
    told = complain(capsys, tmp_path / "wall.json", *options)
    assert f"{options[0]}: " in told
    assert "wall.json is a model of a tiling; it is for wood" in told
