"""`jaxtex fit floor`: the files it leaves, and what it says."""

from pathlib import Path

import numpy as np
import pytest

from jaxtex.cli.main import main
from jaxtex.io.images import write_image
from jaxtex.models.files import load_model
from jaxtex.models.floor_files import FloorFile

MAPS = {"basecolor.png", "height.exr", "normal.png", "roughness.png", "specular.png", "metallic.png", "tile_id.exr"}
FILES = {"model.json", "interiors.npz", "overlay.png", *MAPS}


@pytest.fixture(scope="module")
def photo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    v, u = np.indices((192, 192)) + 0.5
    number = u // 64
    early = np.sin(2 * np.pi * (u + np.sin(v / 25 + number)) / (8 + 2 * number)) > 0
    light = np.where(early, 0.4, 0.25) * (1 + np.random.default_rng(0).normal(0, 0.05, u.shape))
    light[(np.abs(u - 64) < 1.5) | (np.abs(u - 128) < 1.5)] = 0.02
    path = tmp_path_factory.mktemp("floor") / "floor.png"
    write_image(path, (light[..., None] * [1.0, 0.7, 0.4]).astype(np.float32))
    return path


def test_everything_is_written_and_opens_again(photo: Path, tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    folder = tmp_path / "floor"
    assert main(["fit", "floor", str(photo), "-o", str(folder)]) == 0
    assert {path.name for path in folder.iterdir()} == FILES
    assert "3 planks" in capsys.readouterr().out
    file = load_model(folder / "model.json")
    assert isinstance(file, FloorFile)
    assert len(file.planks) == 3
    assert main(["info", str(folder / "model.json")]) == 0
    assert "a floor of 3 planks" in capsys.readouterr().out
    assert main(["render", str(folder / "model.json"), "-o", str(tmp_path / "maps")]) == 0
    assert {path.name for path in (tmp_path / "maps").iterdir()} == MAPS
    assert main(["render", str(folder / "model.json"), "-o", str(tmp_path / "no"), "--block", "4x4x4"]) == 2
    assert "is a model of a floor" in capsys.readouterr().err


def test_a_flat_card_is_no_floor(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    write_image(tmp_path / "card.png", np.full((64, 64, 3), 0.4, np.float32))
    assert main(["fit", "floor", str(tmp_path / "card.png"), "-o", str(tmp_path / "out")]) == 1
    assert "no floor of wood" in capsys.readouterr().out
    assert not load_model(tmp_path / "out" / "model.json").report["ok"]


@pytest.mark.parametrize(
    "options", [["--size", "0x5"], ["--seed", "-1"], ["--wood", "missing.png"], ["--wood", "CARD"], ["--tiles", "2x2"]]
)
def test_bad_input_is_one_line(photo: Path, tmp_path: Path, capsys: pytest.CaptureFixture, options: list[str]) -> None:
    card = tmp_path / "card.png"
    write_image(card, np.full((64, 64, 3), 0.4, np.float32))
    told = [str(card) if option == "CARD" else option for option in options]
    assert main(["fit", "floor", str(photo), "-o", str(tmp_path / "out"), *told]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not (tmp_path / "out").exists()
