"""`jaxtex fit tiling` from the words typed to the files written."""

import json
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from jaxtex.cli.main import main
from jaxtex.io.images import read_image, write_image
from jaxtex.io.masks import read_mask, write_mask
from jaxtex.material.export import MAP_NAMES
from jaxtex.models.files import load_model, tiling_schema

FILES = {"model.json", "interiors.npz", "regions.png", "mask.png", "overlay.png", "report.html", *MAP_NAMES}


def fit(photo: Path, folder: Path, *options: str) -> int:
    return main(["fit", "tiling", str(photo), "-o", str(folder), *options])


def parameters(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "model.json").read_text(encoding="utf-8"))["parameters"]


@pytest.fixture(scope="module")
def fitted(wall_photo: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fit") / "new" / "wall"
    assert fit(wall_photo, folder) == 0
    return folder


def test_everything_is_written_and_nothing_else(fitted: Path) -> None:
    assert {path.name for path in fitted.iterdir()} == FILES
    assert all(path.stat().st_size > 0 for path in fitted.iterdir())


def test_the_model_is_the_walls(fitted: Path, wall_photo: Path) -> None:
    document = json.loads((fitted / "model.json").read_text(encoding="utf-8"))
    jsonschema.validate(document, tiling_schema())
    found = document["parameters"]
    assert found["tile_width"] == pytest.approx(48, rel=0.005)
    assert found["tile_height"] == pytest.approx(18, rel=0.005)
    assert found["angle_deg"] == pytest.approx(0, abs=0.1)
    assert found["offset"] == pytest.approx(0.5, abs=0.02)
    assert found["mortar_x"] == pytest.approx(4, abs=1)
    assert found["mortar_y"] == pytest.approx(4, abs=1)
    assert (found["bond"], found["rows"], found["columns"]) == ("running", 11, 4)
    image = read_image(wall_photo)
    assert document["image"] == {"width": 200, "height": 200, "sha256": image.sha256}
    assert document["report"]["ok"] is True
    assert document["report"]["start"]["bond"] == "running"
    assert 0 < document["report"]["standard_errors"]["tile_width"] < 0.5
    assert len(document["report"]["standard_errors"]["origin"]) == 2


def test_no_file_but_the_report_tells_the_time(fitted: Path, wall_photo: Path, tmp_path: Path) -> None:
    assert fit(wall_photo, tmp_path) == 0
    for name in sorted(FILES - {"report.html"}):
        assert (tmp_path / name).read_bytes() == (fitted / name).read_bytes(), name


def test_the_pictures_show_the_photograph(fitted: Path, wall_photo: Path) -> None:
    photo, overlay = read_image(wall_photo).pixels, read_image(fitted / "overlay.png").pixels
    assert overlay.shape == photo.shape
    assert 0.01 < (np.abs(overlay - photo).max(axis=-1) > 0.05).mean() < 0.6
    mask = read_mask(fitted / "mask.png") > 0.5
    light = photo.mean(axis=-1) > 0.35
    assert (mask == ~light).mean() > 0.9


def test_maps_have_the_colours_and_the_relief_of_the_wall(fitted: Path) -> None:
    file = load_model(fitted / "model.json")
    colour, ids = read_image(fitted / "basecolor.png").pixels, read_image(fitted / "tile_id.exr").pixels[..., 0]
    height = read_image(fitted / "height.exr").pixels[..., 0]
    assert colour.shape[:2] == (round(11 * float(file.tiling.tile_height)), round(4 * float(file.tiling.tile_width)))
    assert np.median(colour[ids < 0], axis=0) == pytest.approx([0.5, 0.5, 0.5], abs=0.08)
    assert np.median(colour[ids >= 0], axis=0) == pytest.approx([0.3, 0.12, 0.08], abs=0.08)
    assert np.median(height[ids >= 0]) > np.median(height[ids < 0]) == 0


def test_the_end_of_the_output_says_what_was_found(
    wall_photo: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert fit(wall_photo, tmp_path / "wall", "--size", "150x140") == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert out.splitlines()[0] == f"{wall_photo}: a tiling in running bond"
    assert "11 courses of 4 tiles" in out
    assert out.splitlines()[-1] == f"Open {tmp_path / 'wall' / 'report.html'}"
    assert read_image(tmp_path / "wall" / "normal.png", colour_space="data").pixels.shape == (140, 150, 3)


@pytest.mark.usefixtures("no_maps")
def test_what_is_fixed_stays_and_what_is_started_does_not(wall_photo: Path, tmp_path: Path) -> None:
    options = ["--fix", "tile_height=18.25", "angle_deg=0", "--init", "tile_width=48.5", "mortar_x=3"]
    assert fit(wall_photo, tmp_path, *options) == 0
    found = parameters(tmp_path)
    assert found["tile_height"] == pytest.approx(18.25, abs=1e-9)
    assert found["angle_deg"] == pytest.approx(0, abs=1e-9)
    assert found["tile_width"] == pytest.approx(48, rel=0.01)
    assert f"{wall_photo} -o {tmp_path} {' '.join(options)}<" in (tmp_path / "report.html").read_text(encoding="utf-8")
    errors = load_model(tmp_path / "model.json").report["standard_errors"]
    assert "tile_width" in errors
    assert "tile_height" not in errors


@pytest.mark.usefixtures("no_maps")
def test_the_users_own_mask_is_used(wall_photo: Path, tmp_path: Path) -> None:
    y, x = np.indices((200, 200)) + 0.5
    write_mask(tmp_path / "own.png", (y % 25 > 4) & (x % 40 > 4))
    assert fit(wall_photo, tmp_path / "wall", "--mask", str(tmp_path / "own.png"), "--no-perspective") == 0
    found = parameters(tmp_path / "wall")
    assert (found["bond"], found["rows"], found["columns"]) == ("stack", 8, 5)
    assert found["homography"] == np.eye(3).tolist()


@pytest.mark.parametrize("kind", ["noise", "nothing"])
def test_a_picture_of_no_tiling_is_status_one_with_everything_written(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    photo, folder = tmp_path / "photo.png", tmp_path / "out"
    values = np.random.default_rng(0).random((64, 64)) if kind == "noise" else np.full((64, 64), 0.5)
    write_image(photo, values)
    assert fit(photo, folder) == 1
    assert {path.name for path in folder.iterdir()} == FILES
    report = load_model(folder / "model.json").report
    assert report["ok"] is False
    assert capsys.readouterr().out.splitlines()[0] == f"{photo}: no tiling: {report['reason']}; the best guess is"
