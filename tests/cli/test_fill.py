"""Filling on the command line: learnt from where it is told, drawn or left out, and refused in one line."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from jaxtex.cli.main import main
from jaxtex.core.colour import linear_to_srgb
from jaxtex.io.arrays import read_arrays
from jaxtex.io.images import read_image, write_image
from jaxtex.material.export import MAP_NAMES
from jaxtex.models.files import SourceImage, save_model
from jaxtex.models.floor_files import FloorFile, PlacedWood
from jaxtex.models.wood import make_wood
from jaxtex.models.wood_files import WoodFile

# In the second course, and below the first.
BRICK, JOINT = "41,29,36x10", "15,23.5,30x3"


@pytest.fixture(scope="module")
def fitted(wall_photo: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("filled") / "wall"
    assert main(["fit", "tiling", str(wall_photo), "-o", str(folder)]) == 0
    return folder


@pytest.fixture
def model(fitted: Path, tmp_path: Path) -> Path:
    for name in ("model.json", "interiors.npz"):
        shutil.copy(fitted / name, tmp_path / name)
    return tmp_path / "model.json"


def unevenness(folder: Path) -> float:
    """Of tiles' insides."""
    ids = read_image(folder / "tile_id.exr").pixels[..., 0]
    colour = linear_to_srgb(read_image(folder / "basecolor.png").pixels[..., 0])
    return float(np.median([colour[ids == each].std() for each in np.unique(ids[ids >= 0])]))


def render(model: Path, *options: str) -> Path:
    folder = model.parent / "maps"
    assert main(["render", str(model), "-o", str(folder), *options]) == 0
    assert {path.name for path in folder.iterdir()} == set(MAP_NAMES)
    return folder


def test_rendering_fills_tiles_as_fitting_did_unless_told_not_to(fitted: Path, model: Path) -> None:
    folder = render(model)
    for name in ("basecolor.png", "height.exr", "normal.png", "occlusion.png", "tile_id.exr"):
        one, other = (read_image(each / name, colour_space="data").pixels for each in (folder, fitted))
        # Files keep grain in steps of 1/255.
        assert np.mean(np.abs(one - other) > 0.02) < 0.02, name
    even = unevenness(folder)
    assert unevenness(render(model, "--no-fill")) < 0.5 * even
    (model.parent / "interiors.npz").unlink()
    render(model, "--no-fill")


def test_finishes_are_those_of_their_structures(model: Path) -> None:
    folder = render(model, "--finish", "tile=mirror", "joint=dull")
    rough, metal = (
        read_image(folder / f"{name}.png", colour_space="data").pixels[..., 0] for name in ("roughness", "metallic")
    )
    ids = read_image(folder / "tile_id.exr").pixels[..., 0]
    assert np.median(metal[ids >= 0]) == 1
    assert np.median(metal[ids < 0]) == 0
    assert np.median(rough[ids >= 0]) == pytest.approx(0.02, abs=0.005)
    assert np.median(rough[ids < 0]) == pytest.approx(0.95, abs=0.005)


def test_fitting_without_filling_names_no_interiors(wall_photo: Path, tmp_path: Path) -> None:
    assert main(["fit", "tiling", str(wall_photo), "-o", str(tmp_path / "wall"), "--no-fill"]) == 0
    assert not (tmp_path / "wall" / "interiors.npz").exists()
    document = json.loads((tmp_path / "wall" / "model.json").read_text(encoding="utf-8"))
    assert "interiors" not in document["appearance"]
    assert "--no-fill" in (tmp_path / "wall" / "report.html").read_text(encoding="utf-8")


@pytest.mark.usefixtures("no_maps")
def test_interiors_are_learnt_from_where_they_are_told(wall_photo: Path, tmp_path: Path) -> None:
    options = ["--tile-region", BRICK, "--joint-region", JOINT]
    assert main(["fit", "tiling", str(wall_photo), "-o", str(tmp_path / "wall"), *options]) == 0
    found = read_arrays(tmp_path / "wall" / "interiors.npz")
    assert found["kinds"] == 1
    regions, height, width, _ = found["tile_grain_0"].shape
    assert regions == 1
    assert height <= 10
    assert width <= 36
    assert found["joint_grain"].shape[:3] == (1, 3, 30)
    assert " ".join(options) in (tmp_path / "wall" / "report.html").read_text(encoding="utf-8")


@pytest.mark.usefixtures("no_maps")
def test_painted_tiles_are_learnt_from(wall_photo: Path, tmp_path: Path) -> None:
    painted = np.zeros((200, 200), np.float32)
    painted[25:43, 35:83] = 0.5
    painted[61:79, 35:83] = 1.0
    write_image(tmp_path / "painted.png", painted, colour_space="data")
    out = tmp_path / "wall"
    assert main(["fit", "tiling", str(wall_photo), "-o", str(out), "--regions", str(tmp_path / "painted.png")]) == 0
    found = read_arrays(out / "interiors.npz")
    assert found["kinds"] == 2
    assert [len(found[f"tile_grain_{kind}"]) for kind in (0, 1)] == [1, 1]
    assert set(found["kind"].tolist()) == {0, 1}


def complain(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(list(words)) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("jaxtex: error: ")
    assert err.count("\n") == 1
    return err


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--tile-region", "10,10"], "--tile-region: '10,10' is no rectangle; write X,Y,WxH"),
        (["--tile-region", "10,10,0x5"], "--tile-region: '10,10,0x5' is empty"),
        (["--joint-region", "a,b,cxd"], "--joint-region: 'a,b,cxd' is no rectangle"),
        (
            ["--joint-region", "190,0,20x4"],
            "joint region 190,0,20x4: leaves the photograph, which has 200 x 200 pixels",
        ),
        (["--tile-region", "-1,0,20x4"], "-1,0,20x4"),
        (["--tile-region", BRICK, "199,199,2x2"], "tile region 199,199,2x2: leaves the photograph"),
        (["--regions", "nowhere.png"], "nowhere.png: there is no such file"),
        (["--regions", "{small}"], "small.png: has 20 x 20 pixels, and the photograph 200 x 200"),
        (["--regions", "{black}"], "black.png: is all black"),
        (["--regions", "{soft}"], "greys, each a kind of tile; paint with 16 at most"),
        (["--regions", "{photo}"], "is coloured"),
        (["--regions", "{black}", "--tile-region", BRICK], "--regions: and --tile-region both say where to learn from"),
        (["--tile-region", "1,1,3x3"], "tile region 1,1,3x3: is in no tile that the photograph shows as a whole"),
        (["--joint-region", "15,23.5,30x1"], "joint region 15,23.5,30x1: is too thin"),
    ],
)
def test_regions_that_cannot_be_used_leave_nothing(
    wall_photo: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], told: str
) -> None:
    pictures = {
        "small": np.ones((20, 20)),
        "black": np.zeros((200, 200)),
        "soft": np.linspace(0, 1, 200)[:, None].repeat(200, 1),
    }
    for name, levels in pictures.items():
        write_image(tmp_path / f"{name}.png", levels.astype(np.float32), colour_space="data")
    names = {name: tmp_path / f"{name}.png" for name in pictures} | {"photo": wall_photo}
    words = [option.format(**names) for option in options]
    assert told in complain(capsys, "fit", "tiling", str(wall_photo), "-o", str(tmp_path / "out"), *words)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["tile"], "--finish: 'tile' gives no structure a finish; write structure=finish, as tile=varnish"),
        (["tile=wet", "tile=dull"], "--finish: tile is given twice"),
        (["grout=wet"], "'grout' is no structure of a tiling, which has tile and joint"),
        (["tile=shiny"], "'shiny' is no finish; give one of dull, satin, varnish, wet, mirror"),
    ],
)
def test_finishes_that_there_are_not_leave_nothing(
    model: Path, capsys: pytest.CaptureFixture[str], words: list[str], told: str
) -> None:
    assert told in complain(capsys, "render", str(model), "-o", str(model.parent / "out"), "--finish", *words)
    assert not (model.parent / "out").exists()


@pytest.mark.parametrize(
    ("damage", "told"),
    [
        (
            lambda path: path.unlink(),
            "names the interiors 'interiors.npz', which are not beside it; put them there, or",
        ),
        (lambda path: path.write_text("a list"), "interiors.npz: is no archive of arrays, or damaged"),
        (lambda path: path.write_bytes(path.read_bytes()[:500]), "interiors.npz: is no archive of arrays, or damaged"),
    ],
    ids=["missing", "text", "cut"],
)
def test_damaged_interiors_are_named(model: Path, capsys: pytest.CaptureFixture[str], damage, told: str) -> None:
    damage(model.parent / "interiors.npz")
    assert told in complain(capsys, "render", str(model), "-o", str(model.parent / "out"))
    assert not (model.parent / "out").exists()


@pytest.mark.parametrize(
    ("kind", "options", "words"),
    [
        ("floor", ["--finish", "tile=wet"], "'tile' is no structure of"),
        ("wood", ["--finish", "joint=wet"], "'joint' is no structure of"),
        ("wood", ["--no-fill"], "--no-fill: {model} is a model of wood"),
    ],
)
def test_what_a_model_has_no_use_for_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str, options: list[str], words: str
) -> None:
    wood, photo = make_wood(ring_spacing=9.0), SourceImage(40, 40, "0" * 64)
    report = {"ok": True, "reason": "", "iou": None, "start": None, "standard_errors": {}}
    corners = np.array([[0.0, 0], [40, 0], [40, 40], [0, 40]])
    planks = FloorFile((PlacedWood(corners, wood, True),), photo, report)
    save_model(tmp_path / "model.json", planks if kind == "floor" else WoodFile(wood, photo, {}, report))
    told = complain(capsys, "render", str(tmp_path / "model.json"), "-o", str(tmp_path / "out"), *options)
    assert words.format(model=tmp_path / "model.json") in told
    assert not (tmp_path / "out").exists()
