"""`jaxtex render`: from a model file to maps, and everything that can be wrong with what it is given."""

import json

import numpy as np
import pytest

from jaxtex.cli.main import main
from jaxtex.io.images import read_image
from jaxtex.material.export import MAP_NAMES
from jaxtex.material.measure import measure_appearance
from jaxtex.models.files import SourceImage, TilingFile, save_model
from jaxtex.models.tiling import make_tiling

REPORT = {"ok": True, "reason": "made by hand", "iou": None, "start": None, "standard_errors": {}}


@pytest.fixture(autouse=True)
def cache(monkeypatch, tmp_path_factory):
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", str(tmp_path_factory.getbasetemp() / "xla"))


@pytest.fixture
def model(tmp_path):
    wall = make_tiling(tile_width=40.0, tile_height=20.0, mortar_x=4.0, mortar_y=3.0, offset=0.498)
    photo = np.random.default_rng(0).uniform(0.2, 0.6, (100, 120, 3)).astype(np.float32)
    appearance = measure_appearance(photo, wall).to_json()
    path = tmp_path / "model.json"
    save_model(path, TilingFile(wall, SourceImage(120, 100, "0" * 64), 5, 3, REPORT, appearance=appearance))
    return path


def render(model, *options):
    folder = model.parent / "maps"
    assert main(["render", str(model), "-o", str(folder), *options]) == 0
    return {name: read_image(folder / name, colour_space="data").pixels for name in MAP_NAMES}


def test_maps_are_as_large_as_the_tiles_in_the_photograph_unless_told(model, capsys):
    maps = render(model)
    assert {pixels.shape[:2] for pixels in maps.values()} == {(100, 120)}
    assert capsys.readouterr().out == f"{model.parent / 'maps'}: maps of 120 x 100 pixels, 3 x 5 tiles\n"


def test_size_and_tiles_are_as_told(model):
    maps = render(model, "--size", "96x60", "--tiles", "2x4")
    assert {pixels.shape[:2] for pixels in maps.values()} == {(60, 96)}
    ids = maps["tile_id.exr"][..., 0]
    assert len(np.unique(ids[ids >= 0])) == 2 + 3 + 2 + 3


def test_seamless_maps_say_what_gave_way(model, capsys):
    ids = render(model, "--seamless", "--size", "240x240")["tile_id.exr"][..., 0]
    assert len(np.unique(ids[ids >= 0])) == 3 * 6
    out = capsys.readouterr().out.splitlines()
    assert out[0].endswith("240 x 240 pixels, 3 x 6 tiles")
    assert [line.partition(", ")[2] for line in out[1:]] == ["5 courses became 6", "the offset 0.498 became 0.5"]


def test_the_seed_gives_the_colours_of_tiles_beyond_the_photograph(model):
    sheets = [render(model, "--tiles", "6x10", "--seed", seed)["basecolor.png"] for seed in ("1", "1", "2")]
    assert np.array_equal(sheets[0], sheets[1])
    assert not np.array_equal(sheets[0], sheets[2])
    assert np.array_equal(sheets[0][6:14, 6:34], sheets[2][6:14, 6:34])  # a tile of the photograph


def test_a_model_without_appearance_renders_grey(model):
    document = json.loads(model.read_text())
    del document["appearance"]
    model.write_text(json.dumps(document))
    colour = render(model)["basecolor.png"]
    assert np.ptp(colour, axis=-1).max() == 0
    assert np.ptp(colour) > 0.05


def complain(capsys, *words):
    assert main(["render", *words]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("jaxtex: error: ")
    assert captured.err.count("\n") == 1
    return captured.err


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["--size", "big"], "--size: 'big' is no size"),
        (["--size", "0x100"], "--size: '0x100' is no size"),
        (["--size", "100"], "--size: '100' is no size"),
        (["--size", "-5x5"], "is no size"),
        (["--size", "90000x10"], "is too large"),
        (["--size", "8x8"], "is too small for 3 x 5 tiles"),
        (["--tiles", "3by5"], "--tiles: '3by5' is no number of tiles"),
        (["--tiles", "0x5"], "--tiles: '0x5' is no number of tiles"),
        (["--tiles", "5000x5000", "--size", "20000x20000"], "are too many"),
        (["--seed", "-1"], "--seed: -1 is out of range"),
        (["--seed", "99999999999"], "is out of range"),
    ],
)
def test_options_that_cannot_be_used_write_nothing(model, capsys, options, complaint):
    folder = model.parent / "maps"
    assert complaint in complain(capsys, str(model), "-o", str(folder), *options)
    assert not folder.exists()


def test_files_and_folders_that_cannot_be_used_are_named(model, capsys, tmp_path):
    folder = str(tmp_path / "maps")
    assert "there is no such file" in complain(capsys, str(tmp_path / "none.json"), "-o", folder)
    assert "is a folder" in complain(capsys, str(tmp_path), "-o", folder)
    (tmp_path / "file").write_text("x")
    assert "is (or stands below) a file" in complain(capsys, str(model), "-o", str(tmp_path / "file" / "maps"))
    (tmp_path / "text.json").write_text("{")
    assert "is damaged" in complain(capsys, str(tmp_path / "text.json"), "-o", folder)
    document = json.loads(model.read_text())
    document["appearance"]["joint"] = "white"
    model.write_text(json.dumps(document))
    assert f"{model}: appearance: 'white' is no colour" in complain(capsys, str(model), "-o", folder)
    assert not (tmp_path / "maps").exists()
