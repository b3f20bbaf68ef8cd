"""`jaxtex solid-slice` and `jaxtex carve`: pictures and carvings of blocks of voxels, and what cannot be made."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from glb import read_attribute, read_chunks
from scipy import ndimage

from jaxtex.cli.carve import Carve
from jaxtex.cli.solid_slice import SolidSlice
from jaxtex.cli.usage import parse
from jaxtex.core.colour import srgb_to_linear
from jaxtex.core.errors import InputError
from jaxtex.io.images import read_image
from jaxtex.io.meshes import Mesh, read_mesh
from jaxtex.material.baking import bake_solid
from jaxtex.material.solid import carve_solid, cut_solid, draw_block, evaluate_solid, place_in_solid
from jaxtex.models.solid import make_solid

VOXELS = np.random.default_rng(0).random((5, 6, 7, 3)).astype(np.float32)


@pytest.fixture
def block(tmp_path: Path) -> Path:
    np.savez(tmp_path / "block.npz", voxels=VOXELS)
    return tmp_path / "block.npz"


@pytest.fixture
def ball(tmp_path: Path) -> Path:
    trimesh.creation.icosphere(subdivisions=3).export(tmp_path / "ball.obj")
    return tmp_path / "ball.obj"


def run(command: type, *words: object) -> int:
    options = parse(command, prog="jaxtex", arguments=list(map(str, words)))
    assert options is not None
    return options.run()


def cut(block: Path, *words: object) -> np.ndarray:
    picture = block.parent / "cut.exr"
    assert run(SolidSlice, block, "-o", picture, *words) == 0
    return read_image(picture).pixels


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ([], VOXELS[2]),
        (["--axis", "z", "--at", "0"], VOXELS[0]),
        (["--axis", "y"], VOXELS[:, 3]),
        (["--axis", "x", "--at", "6"], VOXELS[:, :, 6]),
        (["--size", "14x6"], np.tile(VOXELS[2], (1, 2, 1))),
        (["--origin", "0,0,1.5", "--across", "1,0,0", "--down", "0,1,0", "--size", "7x6"], VOXELS[1]),
    ],
)
def test_slices_are_those_of_the_block(block: Path, words: list[str], expected: np.ndarray) -> None:
    np.testing.assert_allclose(cut(block, *words), expected, atol=1e-3)


def test_cuts_are_oblique_and_as_large_as_told(block: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plane = {"origin": (0, 0, 0), "across": (0.7, 0, -0.7), "down": (0.1, 1, 0)}
    words = ["--across", "0.7,0,-0.7", "--down", "0.1,1,0"]
    for seed in (None, 3):
        solid = make_solid(VOXELS, offsets_seed=seed)
        varied = [] if seed is None else ["--vary", seed]
        # Random offsets may lead beyond 0 to 1, which EXR keeps.
        np.testing.assert_allclose(cut(block, *words, *varied), cut_solid(solid, **plane, size=(7, 7)), atol=1e-3)
    assert cut(block, *words, "--size", "30x20").shape == (20, 30, 3)
    assert capsys.readouterr().out.splitlines()[-1] == f"{block.parent / 'cut.exr'}: 30 x 20 pixels"


def test_the_block_is_drawn(block: Path) -> None:
    expected = draw_block(make_solid(VOXELS), size=(60, 50))
    np.testing.assert_allclose(cut(block, "--block", "--size", "60x50"), expected, atol=1e-3)
    assert cut(block, "--block").shape == (512, 512, 3)


@pytest.mark.parametrize("kind", ["ply", "glb"])
def test_a_mesh_is_carved(block: Path, ball: Path, kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    path = block.parent / f"carved.{kind}"
    assert run(Carve, block, "--mesh", ball, "-o", path, "--scale", "1.5", "--vary", "2") == 0
    mesh = read_mesh(ball)
    assert capsys.readouterr().out == f"{path}: a mesh of {len(mesh.vertices)} coloured vertices\n"
    expected = np.clip(carve_solid(make_solid(VOXELS, offsets_seed=2), mesh, scale=1.5), 0, 1)
    carved = trimesh.load_mesh(path, process=False)
    np.testing.assert_allclose(carved.vertices, mesh.vertices, atol=1e-6)
    if kind == "ply":
        colours = srgb_to_linear(carved.visual.vertex_colors[:, :3] / 255)
        np.testing.assert_allclose(colours, expected, atol=6e-3)
    else:
        np.testing.assert_allclose(read_attribute(*read_chunks(path), "COLOR_0"), expected, atol=1e-6)


def test_a_mesh_is_carved_with_a_texture(block: Path, ball: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one, other = block.with_name("one.glb"), block.with_name("other.glb")
    words = ["--scale", "0.8", "--vary", "2", "--texture", "128"]
    for path in (one, other):
        assert run(Carve, block, "--mesh", ball, "-o", path, *words) == 0
    assert one.read_bytes() == other.read_bytes()
    told = f"{other}: a mesh of 1280 triangles, its texture 128 x 128 pixels\n  a pixel is 0.2 voxels long\n"
    assert told in capsys.readouterr().out
    solid, mesh = make_solid(VOXELS, offsets_seed=2), read_mesh(ball)
    baked = bake_solid(solid, mesh, side=128, scale=0.8)
    (read,) = trimesh.load_scene(one, process=False).geometry.values()
    picture = srgb_to_linear(np.asarray(read.visual.material.baseColorTexture) / 255)
    np.testing.assert_allclose(picture, np.clip(baked.picture, 0, 1), atol=6e-3)
    np.testing.assert_allclose(read.visual.uv, baked.mesh.uv, atol=1e-6)
    # At the vertices it has the solid's own colours.
    column, row = read.visual.uv[:, 0] * 128 - 0.5, (1 - read.visual.uv[:, 1]) * 128 - 0.5
    seen = [ndimage.map_coordinates(picture[..., n], [row, column], order=1, mode="grid-wrap") for n in range(3)]
    colours = np.clip(evaluate_solid(solid, place_in_solid(solid, Mesh(read.vertices, read.faces), scale=0.8)), 0, 1)
    assert np.sqrt(np.square(np.stack(seen, axis=-1) - colours).mean()) < 0.02


def complain(command: type, folder: Path, *words: object) -> str:
    before = sorted(folder.iterdir())
    with pytest.raises(InputError) as refusal:
        run(command, *words)
    assert sorted(folder.iterdir()) == before
    assert "\n" not in str(refusal.value)
    return str(refusal.value)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--axis", "y", "--at", "6"], "--at: there is no slice 6 across y; give 0 to 5"),
        (["--at", "-1"], "--at: there is no slice -1 across z; give 0 to 4"),
        (["--axis", "y", "--block"], "--block and --axis: ask for different pictures"),
        (["--at", "2", "--across", "1,0,0", "--down", "0,1,0"], "--at and --across: ask for different pictures"),
        (["--across", "1,0,0"], "--across and --down: an oblique cut takes both"),
        (["--origin", "1,0,0"], "--across and --down: an oblique cut takes both"),
        (["--across", "1,0", "--down", "0,1,0"], "--across: '1,0' is no vector; write x,y,z"),
        (["--across", "1,0,0", "--down", "2,0,0"], "block.npz: across and down span no plane"),
        (["--size", "3"], "--size: '3' is no size"),
        (["--size", "70000x3"], "is too large"),
        (["--vary", "-1"], "--vary: -1 is out of range"),
    ],
)
def test_pictures_that_cannot_be_made_are_one_line(block: Path, words: list[str], told: str) -> None:
    assert told in complain(SolidSlice, block.parent, block, "-o", block.parent / "cut.png", *words)


def test_files_that_cannot_be_read_or_written_are_named(block: Path, ball: Path) -> None:
    folder = block.parent
    assert "nowhere.npz: there is no such file" in complain(
        SolidSlice, folder, folder / "nowhere.npz", "-o", folder / "cut.png"
    )
    assert "is no archive" in complain(SolidSlice, folder, ball, "-o", folder / "cut.png")
    assert "there is no folder" in complain(SolidSlice, folder, block, "-o", folder / "none" / "cut.png")
    np.savez(folder / "flow.npz", voxels=VOXELS[..., :2])
    flow = folder / "flow.npz"
    assert "flow.npz: the block has 2 channels" in complain(SolidSlice, folder, flow, "-o", folder / "a.png", "--block")


@pytest.mark.parametrize(
    ("mesh", "output", "words", "told"),
    [
        ("ball.obj", "ball.stl", [], "ball.stl: cannot be written as '.stl'; name it .ply or .glb"),
        ("ball.ply", "ball.ply", [], "ball.ply: is the mesh to carve; give the carved one another name"),
        ("ball.obj", "none/ball.ply", [], "there is no folder"),
        ("nowhere.ply", "ball.ply", [], "nowhere.ply: there is no such file"),
        ("dot.obj", "ball.ply", [], "block.npz: all vertices of the mesh lie at one point"),
        ("ball.obj", "ball.ply", ["--texture", "64"], "ball.ply would hold no picture; name it .glb"),
        ("ball.obj", "ball.glb", ["--texture", "8"], "--texture: 8 is out of range; give 16 to 8192"),
        ("line.obj", "line.glb", ["--texture", "64"], "all triangles of the mesh are without an area"),
        ("ball.obj", "ball.ply", ["--scale", "0"], "scale: 0 is none"),
        ("ball.obj", "ball.ply", ["--vary", "4294967296"], "--vary: 4294967296 is out of range"),
    ],
)
def test_carvings_that_cannot_be_made_are_one_line(
    block: Path, ball: Path, mesh: str, output: str, words: list[str], told: str
) -> None:
    (block.parent / "dot.obj").write_text("v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n")
    (block.parent / "line.obj").write_text("v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n")
    folder = block.parent
    assert told in complain(Carve, folder, block, "--mesh", folder / mesh, "-o", folder / output, *words)
