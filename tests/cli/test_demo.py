"""`jaxtex demo`: the whole way, on the photograph that comes along."""

import contextlib
import io
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from skimage import data

from jaxtex.cli.main import main
from jaxtex.core.colour import linear_to_srgb
from jaxtex.io.images import read_image
from jaxtex.material.export import MAP_NAMES
from jaxtex.models.files import load_model

pytestmark = pytest.mark.slow


class Demo(NamedTuple):
    folder: Path
    told: list[str]


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Demo:
    folder = tmp_path_factory.mktemp("whole") / "demo"
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        assert main(["demo", "-o", str(folder)]) == 0
    assert err.getvalue() == ""
    return Demo(folder, out.getvalue().splitlines())


def test_the_demo_shows_its_commands_and_ends_with_what_to_open(demo: Demo) -> None:
    folder, told = demo
    for name in ("photo.png", "model.json", "mask.png", "overlay.png", "report.html", *MAP_NAMES):
        assert (folder / name).stat().st_size > 0
    assert {path.name for path in (folder / "seamless").iterdir()} == set(MAP_NAMES)
    assert told[0] == f"jaxtex fit tiling {folder / 'photo.png'} -o {folder}"
    assert any(line.startswith("jaxtex render ") and line.endswith("--seamless") for line in told)
    assert told[-1] == f"Open {folder / 'report.html'}"
    encoded = linear_to_srgb(read_image(folder / "photo.png").pixels[..., 0])
    assert np.array_equal(np.round(255 * encoded).astype(np.uint8), data.brick())


def test_every_course_of_the_shipped_photograph_is_found(demo: Demo) -> None:
    file = load_model(demo.folder / "model.json")
    # Head to head, 17 joints cross the top edge of this photograph, 15 its middle and 12 its bottom edge.
    assert file.report["ok"] is True
    assert file.rows in (14, 15)
    tiling = file.tiling
    across = [float(tiling.to_lattice(np.array([x, 256.0]))[1] / tiling.tile_height) for x in (0, 512)]
    assert abs(across[1] - across[0]) == pytest.approx(14.3, abs=0.5)
    assert float(tiling.homography[2, 1]) > 1e-4  # the courses converge upwards
    assert not np.array_equal(tiling.homography, np.eye(3))
