"""The page of a fit of wood: one file, whole, that says plainly what the photograph does not tell."""

import base64
import re

import numpy as np
import pytest

from jaxtex.io.images import read_image, write_image
from jaxtex.material.report_wood import WoodPictures, write_wood_report
from jaxtex.models.envelope import SourceImage
from jaxtex.models.wood import make_wood
from jaxtex.models.wood_files import WoodFile

OAK = {"ring_spacing": 12.5, "center": (30.0, 4.0), "tilt": 0.2, "rotation": 1.1, "turbulence_frequency": 0.0123}
ERRORS = {"center": [0.5, None], "tilt_deg": None, "rotation_deg": 0.25, "ring_spacing": 0.031}


def make_page(folder, *, ok=True, reason="", name="oak.png", determined=None, held=(), **oak):
    pixels = np.random.default_rng(0).uniform(0.1, 0.6, (90, 120, 3)).astype(np.float32)
    write_image(folder / name, pixels)
    photo = read_image(folder / name)
    report = {
        "ok": ok,
        "reason": reason,
        "iou": 0.876,
        "start": None,
        "standard_errors": {key: error for key, error in ERRORS.items() if key not in held},
        "held": list(held),
    }
    file = WoodFile(
        make_wood(**(OAK | oak)),
        SourceImage(photo.width, photo.height, photo.sha256),
        {"center": False, "tilt_deg": False, "rotation_deg": True} if determined is None else determined,
        report,
        seed=5,
        versions={"jaxtex": "1.2.3"},
    )
    pictures = WoodPictures(pixels.mean(axis=-1) > 0.3, pixels, pixels[::-1])
    write_wood_report(folder / "report.html", photo=photo, pictures=pictures, file=file, seconds={"rings": 1.25})
    return (folder / "report.html").read_text(encoding="utf-8")


def row_of(page, name):
    return re.search(rf"<tr><td><code>{name}</code>.*?</tr>", page)[0]


def test_the_page_stands_alone(tmp_path):
    page = make_page(tmp_path)
    pictures = re.findall(r'<img[^>]* src="(.*?)"', page)
    assert len(pictures) == 6
    assert all(picture.startswith("data:image/") for picture in pictures)
    without_pictures = re.sub(r"data:[^\"]+", "", page)
    assert "//" not in without_pictures
    assert "<script" not in without_pictures
    assert "$" not in without_pictures


def test_the_page_tells_the_numbers(tmp_path):
    page = make_page(tmp_path)
    assert "Wood, its rings 12.5 pixels apart" in page
    assert "12.500" in row_of(page, "ring_spacing")
    assert "0.031" in row_of(page, "ring_spacing")
    assert "63.03" in row_of(page, "rotation_deg")
    assert "30.00, 4" in row_of(page, "center")
    assert "0.5, –" in row_of(page, "center")
    assert "0.0123" in row_of(page, "turbulence_frequency")
    assert "#c49b73" in row_of(page, "early_rgb")
    for told in ("153.0°", "88 <small>%", "1.25", "seed 5", "jaxtex 1.2.3"):
        assert told in page
    for options in (
        f"fit wood {tmp_path / 'oak.png'} -o",
        "--size 4096x4096",
        "--block 256x256x256",
        "--mesh MESH.ply",
    ):
        assert options in page


def test_what_the_photograph_does_not_tell_is_said(tmp_path):
    page = make_page(tmp_path, held=("ring_spacing",))
    assert "The photograph does not tell <code>center</code>, <code>tilt_deg</code>:" in page
    assert "does not tell" in row_of(page, "tilt_deg")
    assert ">tells<" in row_of(page, "rotation_deg")
    assert "held by hand" in row_of(page, "ring_spacing")
    assert "tell" not in row_of(page, "early_fraction").split("meaning")[0]
    assert "The photograph tells all" in make_page(tmp_path, determined={"center": True})


def test_a_fit_that_did_not_succeed_is_told_and_shown(tmp_path):
    page = make_page(tmp_path, ok=False, reason="edges <run> across")
    assert "No one piece of wood: edges &lt;run&gt; across" in page
    assert "best guess" in page
    assert 'class="verdict bad"' in page


def test_end_grain_has_no_direction(tmp_path):
    assert "end grain</dd>" in make_page(tmp_path, tilt=np.pi / 2)


def test_the_plank_is_rendered_as_large_as_the_photograph(tmp_path):
    page = make_page(tmp_path)
    encoded = re.search(r'src="data:image/jpeg;base64,([^"]+)" alt="The rendered plank"', page)[1]
    (tmp_path / "plank.jpg").write_bytes(base64.b64decode(encoded))
    plank = read_image(tmp_path / "plank.jpg").pixels
    assert plank.shape == (90, 120, 3)
    assert plank.mean(axis=(0, 1)) == pytest.approx(np.array([0.44, 0.25, 0.13]), abs=0.03)


def test_pages_differ_in_nothing_but_times(tmp_path):
    assert make_page(tmp_path) == make_page(tmp_path)
