"""`jaxtex fit wood` from the words typed to the files written."""

import json
import re
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from jaxtex.cli.main import main
from jaxtex.io.images import read_image, write_image
from jaxtex.io.masks import read_mask, write_mask
from jaxtex.models.files import load_model
from jaxtex.models.wood_files import wood_schema

MAPS = {"basecolor.png", "height.exr", "normal.png", "roughness.png", "specular.png", "metallic.png"}
FILES = {"model.json", "mask.png", "overlay.png", "rings.png", "report.html", *MAPS}
TRUTH = {"center": (30.0, -20.0), "tilt": 10.0, "rotation": 35.0, "spacing": 14.0, "fraction": 0.6}


def draw_early(size: int = 160, **changes: Any) -> np.ndarray:
    """True on early wood. Geometry as the model file's description has it; angles in degrees."""
    plank = TRUTH | changes
    v, u = np.indices((size, size)) + 0.5 - size / 2
    turn, lean = np.radians(plank["rotation"]), np.radians(plank["tilt"])
    across, along = u * np.cos(turn) + v * np.sin(turn), v * np.cos(turn) - u * np.sin(turn)
    radius = np.hypot(across - plank["center"][0], along * np.sin(lean) - plank["center"][1])
    return np.sin(2 * np.pi * radius / plank["spacing"]) > np.cos(np.pi * plank["fraction"])


def paint(path: Path, early: np.ndarray) -> Path:
    write_image(path, np.where(early[..., None], [0.55, 0.33, 0.17], [0.27, 0.13, 0.06]))
    return path


def fit(photo: Path, folder: Path, *options: str) -> int:
    return main(["fit", "wood", str(photo), "-o", str(folder), *options])


def document(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "model.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def plank(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return paint(tmp_path_factory.mktemp("photographs") / "plank.png", draw_early())


@pytest.fixture(scope="module")
def fitted(plank: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fit") / "new" / "plank"
    assert fit(plank, folder) == 0
    return folder


def test_everything_is_written_and_nothing_else(fitted: Path) -> None:
    assert {path.name for path in fitted.iterdir()} == FILES
    assert all(path.stat().st_size > 0 for path in fitted.iterdir())


def test_the_model_is_the_planks(fitted: Path, plank: Path) -> None:
    written = document(fitted)
    jsonschema.validate(written, wood_schema())
    found = written["parameters"]
    assert found["center"] == pytest.approx([30.0, -20.0], abs=0.7)
    assert found["tilt_deg"] == pytest.approx(10.0, abs=0.2)
    assert found["rotation_deg"] == pytest.approx(35.0, abs=0.2)
    assert found["ring_spacing"] == pytest.approx(14.0, rel=0.005)
    assert found["early_fraction"] == pytest.approx(0.6, abs=0.01)
    assert found["early_rgb"] == pytest.approx([0.55, 0.33, 0.17], abs=0.01)
    assert written["image"] == {"width": 160, "height": 160, "sha256": read_image(plank).sha256}
    assert written["determined"]["tilt_deg"] is True


def test_the_report_tells_how_sure_the_fit_is(fitted: Path) -> None:
    report = document(fitted)["report"]
    assert report["ok"] is True
    assert report["start"] is None
    assert report["held"] == []
    assert 0.9 < report["iou_rigid"] <= 1
    assert 0.9 < report["iou"] <= 1
    assert len(report["standard_errors"]["center"]) == 2
    assert len(report["covariance_of"]) == 6
    covariance = np.array(report["covariance"])
    np.testing.assert_allclose(covariance, covariance.T, rtol=1e-6, atol=1e-15)
    # The errors are those of the covariance, in the units of the file.
    place = report["covariance_of"].index("tilt")
    assert np.degrees(np.sqrt(covariance[place, place])) == pytest.approx(report["standard_errors"]["tilt_deg"])
    assert np.sqrt(covariance[0, 0]) == pytest.approx(report["standard_errors"]["center"][0])


def test_the_pictures_show_the_plank(fitted: Path, plank: Path) -> None:
    photo, early = read_image(plank).pixels, draw_early()
    assert ((read_mask(fitted / "mask.png") > 0.5) == early).mean() > 0.99
    for name, share in (("overlay.png", 0.6), ("rings.png", 0.5)):
        drawn = read_image(fitted / name).pixels
        assert drawn.shape == photo.shape
        changed = np.abs(drawn - photo).max(axis=-1) > 0.05
        assert 0.05 < changed.mean() < share
    # The lines of the rings lie on late wood.
    rings = read_image(fitted / "rings.png").pixels
    light_line, heavy_line = (rings[..., 2] > 0.6), (rings[..., 0] > 0.9)
    assert (light_line | heavy_line).sum() > 500
    assert early[light_line | heavy_line].mean() < 0.02


def test_maps_are_those_that_render_makes(fitted: Path, tmp_path: Path) -> None:
    assert main(["render", str(fitted / "model.json"), "-o", str(tmp_path / "maps")]) == 0
    for name in sorted(MAPS):
        assert (tmp_path / "maps" / name).read_bytes() == (fitted / name).read_bytes(), name
    colour = read_image(fitted / "basecolor.png").pixels
    assert ((colour[..., 0] > 0.41) == draw_early()).mean() > 0.97


def test_no_file_but_the_report_tells_the_time(fitted: Path, plank: Path, tmp_path: Path) -> None:
    assert fit(plank, tmp_path) == 0
    for name in sorted(FILES - {"report.html"}):
        assert (tmp_path / name).read_bytes() == (fitted / name).read_bytes(), name


def test_the_end_of_the_output_says_what_was_found(
    plank: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert fit(plank, tmp_path / "out", "--size", "80x100") == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert out.splitlines()[0] == f"{plank}: wood"
    numbers = [float(number) for number in re.findall(r" (\d+\.\d\d) ", out)]
    assert numbers == pytest.approx([14.0, 125.0, 35.0, 10.0], abs=0.15)  # rings apart, along, across, tilt
    assert "60 % early wood" in out
    assert out.splitlines()[-1] == f"Open {tmp_path / 'out' / 'report.html'}"
    assert read_image(tmp_path / "out" / "normal.png", colour_space="data").pixels.shape == (100, 80, 3)


def test_what_is_fixed_stays(plank: Path, tmp_path: Path) -> None:
    options = ["--fix", "tilt_deg=12", "early_fraction=0.55", "--seed", "7"]
    assert fit(plank, tmp_path, *options) in (0, 1)
    written = document(tmp_path)
    assert written["parameters"]["tilt_deg"] == pytest.approx(12.0, abs=1e-4)
    assert written["parameters"]["early_fraction"] == pytest.approx(0.55, abs=1e-4)
    assert sorted(written["report"]["held"]) == ["early_fraction", "tilt_deg"]
    assert written["seed"] == 7
    for entry in (written["determined"], written["report"]["standard_errors"]):
        assert "rotation_deg" in entry
        assert not {"tilt_deg", "early_fraction"} & entry.keys()
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert f"{plank} -o {tmp_path} {' '.join(options)}<" in page
    assert page.count("held by hand") == 2


def test_the_axis_is_held_once_both_of_its_numbers_are(plank: Path, tmp_path: Path) -> None:
    fit(plank, tmp_path, "--fix", "xc=30", "yc=-20")
    written = document(tmp_path)
    assert written["report"]["held"] == ["center"]
    assert written["parameters"]["center"] == pytest.approx([30.0, -20.0], abs=1e-3)


def test_the_middle_of_the_ellipses_is_where_it_is_told(tmp_path: Path) -> None:
    ends = paint(tmp_path / "ends.png", draw_early(tilt=75.0, rotation=10.0, center=(10.0, 25.0)))
    turn = np.radians(10.0)
    s, t = 10.0, 25.0 / np.sin(np.radians(75.0))
    pith = s * np.cos(turn) - t * np.sin(turn) + 80, s * np.sin(turn) + t * np.cos(turn) + 80
    assert fit(ends, tmp_path / "out", "--ellipse-center", f"{pith[0]:.1f},{pith[1]:.1f}") == 0
    found = document(tmp_path / "out")["parameters"]
    turn = np.radians(found["rotation_deg"])
    s, t = found["center"][0], found["center"][1] / np.sin(np.radians(found["tilt_deg"]))
    assert s * np.cos(turn) - t * np.sin(turn) + 80 == pytest.approx(pith[0], abs=2)
    assert s * np.sin(turn) + t * np.cos(turn) + 80 == pytest.approx(pith[1], abs=2)


def test_the_users_own_mask_is_used(plank: Path, tmp_path: Path) -> None:
    write_mask(tmp_path / "own.png", draw_early(spacing=20.0))
    assert fit(plank, tmp_path / "out", "--mask", str(tmp_path / "own.png")) == 0
    assert document(tmp_path / "out")["parameters"]["ring_spacing"] == pytest.approx(20.0, rel=0.01)


def test_turbulence_is_that_of_the_seed(tmp_path: Path) -> None:
    v, u = np.indices((160, 160)) + 0.5
    rings = u + 3.0 * np.sin(2 * np.pi * (u + 2 * v) / 150)
    board = paint(tmp_path / "board.png", np.sin(2 * np.pi * rings / 12) > 0)
    for seed in ("0", "3"):
        assert fit(board, tmp_path / seed, "--seed", seed) == 0
    one, other = (load_model(tmp_path / seed / "model.json") for seed in ("0", "3"))
    assert float(one.wood.turbulence_rms) > 0.5
    assert float(one.wood.turbulence_rms) == float(other.wood.turbulence_rms)
    assert not np.array_equal(one.wood.waves, other.wood.waves)


@pytest.mark.parametrize("kind", ["card", "tiles"])
def test_a_picture_of_no_wood_is_status_one_with_everything_written(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    photo, folder = tmp_path / "photo.png", tmp_path / "out"
    y, x = np.indices((160, 160)) + 0.5
    tiled = np.where((x % 40 > 6) & (y % 40 > 6), 0.2, 0.5) + np.random.default_rng(0).normal(0, 0.01, (160, 160))
    write_image(photo, tiled if kind == "tiles" else np.full((64, 64, 3), 0.5))
    assert fit(photo, folder) == 1
    assert {path.name for path in folder.iterdir()} == FILES
    report = load_model(folder / "model.json").report
    assert report["ok"] is False
    first = capsys.readouterr().out.splitlines()[0]
    assert first == f"{photo}: no one piece of wood: {report['reason']}; the best guess is"


def test_what_was_never_found_is_null(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_image(tmp_path / "card.png", np.full((64, 64, 3), 0.5))
    assert fit(tmp_path / "card.png", tmp_path / "out") == 1
    written = document(tmp_path / "out")
    jsonschema.validate(written, wood_schema())
    assert written["report"]["covariance"] == [[None] * 6] * 6
    assert written["report"]["standard_errors"]["center"] == [None, None]
    assert "the picture does not tell: center, tilt_deg" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--fix", "tilt=3"], ("tilt", "tilt_deg")),
        (["--fix", "tilt_deg=95"], ("tilt_deg is 95", "from 0 to 90")),
        (["--fix", "tilt_deg=flat"], ("--fix", "name=number")),
        (["--fix", "early_fraction=1e999"], ("early_fraction is inf",)),
        (["--fix", "xc=3", "--ellipse-center", "4,5"], ("xc, yc",)),
        (["--ellipse-center", "400,10"], ("(400, 10)", "160 x 160")),
        (["--ellipse-center", "400"], ("--ellipse-center", "'400'")),
        (["--mask", "nowhere.png"], ("nowhere.png", "no such file")),
        (["--mask", "{small}"], ("mask", "(20, 20)", "(160, 160)")),
        (["--size", "100"], ("--size", "'100'")),
        (["--size", "90000x10"], ("too large",)),
        (["--seed", "-1"], ("--seed", "-1")),
    ],
)
def test_what_cannot_be_used_is_one_line_and_leaves_nothing(
    options: list[str], told: tuple[str, ...], plank: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_mask(tmp_path / "small.png", np.eye(20) > 0)
    options = [option.format(small=tmp_path / "small.png") for option in options]
    assert fit(plank, tmp_path / "new" / "out", *options) == 2
    assert_refused(capsys, told)
    assert [path.name for path in tmp_path.iterdir()] == ["small.png"]


def test_a_missing_photograph_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert fit(tmp_path / "nowhere.png", tmp_path / "out") == 2
    assert_refused(capsys, ("nowhere.png", "no such file"))
    assert list(tmp_path.iterdir()) == []


def assert_refused(capsys: pytest.CaptureFixture[str], told: tuple[str, ...]) -> None:
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("jaxtex: error: ")
    assert err.count("\n") == 1
    assert [word for word in told if word not in err] == [], err
