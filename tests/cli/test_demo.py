"""`jaxtex demo`: the whole way, on the small wall of these tests and on the photograph that comes along."""

from pathlib import Path

import numpy as np
import pytest

from jaxtex.cli.main import main
from jaxtex.core.colour import linear_to_srgb
from jaxtex.io.images import read_image
from jaxtex.material.export import MAP_NAMES
from jaxtex.models.files import load_model


def run_demo(folder: Path, capsys: pytest.CaptureFixture[str]) -> list[str]:
    assert main(["demo", "-o", str(folder)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    for name in ("photo.png", "model.json", "mask.png", "overlay.png", "report.html", *MAP_NAMES):
        assert (folder / name).stat().st_size > 0
    assert {path.name for path in (folder / "seamless").iterdir()} == set(MAP_NAMES)
    return out.splitlines()


def test_the_demo_shows_its_commands_and_ends_with_what_to_open(
    wall_photo: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    photo = read_image(wall_photo).pixels
    grey = np.round(255 * linear_to_srgb(photo.mean(axis=-1))).astype(np.uint8)
    monkeypatch.setattr("skimage.data.brick", lambda: grey)
    told = run_demo(tmp_path / "demo", capsys)
    assert told[0] == f"jaxtex fit tiling {tmp_path / 'demo' / 'photo.png'} -o {tmp_path / 'demo'}"
    assert any(line.startswith("jaxtex render ") and line.endswith("--seamless") for line in told)
    assert told[-1] == f"Open {tmp_path / 'demo' / 'report.html'}"
    encoded = linear_to_srgb(read_image(tmp_path / "demo" / "photo.png").pixels[..., 0])
    assert np.array_equal(np.round(255 * encoded).astype(np.uint8), grey)


@pytest.mark.slow
def test_every_course_of_the_shipped_photograph_is_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run_demo(tmp_path, capsys)
    file = load_model(tmp_path / "model.json")
    # Head to head, 17 joints cross the top edge of this photograph, 15 its middle and 12 its bottom edge.
    assert file.report["ok"] is True
    assert file.rows in (14, 15)
    tiling = file.tiling
    across = [float(tiling.to_lattice(np.array([x, 256.0]))[1] / tiling.tile_height) for x in (0, 512)]
    assert abs(across[1] - across[0]) == pytest.approx(14.3, abs=0.5)
    assert float(tiling.homography[2, 1]) > 1e-4  # the courses converge upwards
    assert not np.array_equal(tiling.homography, np.eye(3))
