"""`jaxtex info` prints what a model file says."""

from pathlib import Path

import pytest

from jaxtex.cli.main import main


@pytest.fixture
def model(tmp_path: Path) -> Path:
    from jaxtex.models.bonds import bond_pattern
    from jaxtex.models.files import SourceImage, TilingFile, save_model, tiling_parameters
    from jaxtex.models.tiling import make_tiling

    size = {"tile_width": 61.25, "tile_height": 20.5}
    start = tiling_parameters(make_tiling(**size, offset=0.25), rows=24, columns=11)
    errors = {"tile_width": 0.0123, "tile_height": None, "origin": [0.4, None]}
    reason = "found [all] courses"
    report = {"ok": True, "reason": reason, "iou": 0.8125, "start": start, "standard_errors": errors}
    wall = make_tiling(**size, mortar_x=3.0, mortar_y=2.0, angle=0.5, **bond_pattern("flemish"))
    file = TilingFile(wall, SourceImage(640, 480, "ab" * 32), 23, 10, report, seed=5, mm_per_px=1.5)
    save_model(tmp_path / "model.json", file)
    return tmp_path / "model.json"


@pytest.fixture(autouse=True)
def _wide_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")


def test_parameters_stand_with_errors_start_and_meaning(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(model)]) == 0
    shown = capsys.readouterr().out
    rows = {line.split()[0]: line.split() for line in shown.splitlines() if line.strip()}
    assert rows["tile_width"][1:4] == ["61.25", "0.012", "61.25"]
    assert rows["tile_height"][1:3] == ["20.5", "20.5"]
    assert rows["angle_deg"][1:3] == ["28.6479", "0"]
    assert rows["origin"][1:7] == ["0", "0", "0.4", "-", "0", "0"]
    assert rows["bond"][1:3] == ["flemish", "raking"]
    assert rows["rows"][1:3] == ["23", "24"]
    assert rows["course_lengths"][1:3] == ["1", "0.5"]
    assert rows["mm_per_px"][1:3] == ["1.5", "Millimetres"]
    assert "Pitch along the courses, joint included" in shown


def test_the_report_stands_above(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["info", str(model)])
    lines = capsys.readouterr().out.splitlines()
    assert lines[:5] == [
        f"{model}: a tiling in flemish bond",
        "photograph: 640 x 480 pixels, sha256 abababababababab...",
        "fit: ok: found [all] courses",
        "overlap of its joints with those seen: 81.2 %",
        "seed: 5",
    ]


def test_a_model_that_was_not_fitted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from jaxtex.models.files import SourceImage, TilingFile, save_model
    from jaxtex.models.tiling import make_tiling

    report = {"ok": False, "reason": "no courses", "iou": None, "start": None, "standard_errors": {}}
    wall = make_tiling(tile_width=60.0, tile_height=20.0)
    save_model(tmp_path / "model.json", TilingFile(wall, SourceImage(640, 480, "ab" * 32), 24, 11, report))
    assert main(["info", str(tmp_path / "model.json")]) == 0
    shown = capsys.readouterr().out
    assert "fit: not ok: no courses" in shown
    assert "overlap" not in shown


def test_wood_stands_with_what_the_photograph_tells(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from jaxtex.models.files import SourceImage, save_model
    from jaxtex.models.wood import make_wood
    from jaxtex.models.wood_files import WoodFile, wood_parameters

    oak = make_wood(ring_spacing=20.5, center=(31.0, -4.0), tilt=0.5)
    start = wood_parameters(make_wood(ring_spacing=21.0))
    errors = {"ring_spacing": 0.0123, "center": [0.25, None], "tilt_deg": 9.0}
    report = {"ok": True, "reason": "rings", "iou": 0.75, "start": start, "standard_errors": errors}
    determined = {"ring_spacing": True, "tilt_deg": False}
    save_model(tmp_path / "oak.json", WoodFile(oak, SourceImage(640, 480, "ab" * 32), determined, report, seed=2))
    assert main(["info", str(tmp_path / "oak.json")]) == 0
    shown = capsys.readouterr().out
    lines = shown.splitlines()
    assert lines[:5] == [
        f"{tmp_path / 'oak.json'}: wood",
        "photograph: 640 x 480 pixels, sha256 abababababababab...",
        "fit: ok: rings",
        "overlap of its early wood with that seen: 75.0 %",
        "seed: 2",
    ]
    rows = {line.split()[0]: line.split() for line in lines if line.strip()}
    assert rows["ring_spacing"][1:4] == ["20.5", "0.012", "21"]
    assert rows["center"][1:7] == ["31", "-4", "0.25", "-", "0", "0"]
    assert rows["tilt_deg"][1:5] == ["28.6479", "not", "seen", "0"]
    assert "From ring to ring" in shown


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (None, "there is no such file"),
        ("{", "is damaged, or is no JSON file"),
        ('{"schema": 1, "type": "tiling"}', "image is missing"),
    ],
)
def test_a_bad_file_is_one_line_and_status_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str | None, told: str
) -> None:
    path = tmp_path / "model.json"
    if text is not None:
        path.write_text(text)
    assert main(["info", str(path)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith(f"jaxtex: error: {path}: ")
    assert told in err
    assert err.count("\n") == 1
