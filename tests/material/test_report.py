"""The page of a fit: one file, whole, that shows what is so."""

import base64
import re
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest

from jaxtex.io.images import read_image, write_image
from jaxtex.material.diagram import draw_diagram
from jaxtex.material.measure import measure_appearance
from jaxtex.material.report import write_report
from jaxtex.models.files import SourceImage, TilingFile, tiling_parameters
from jaxtex.models.tiling import make_tiling

VIEW = ((1.02, 0.05, -3.0), (-0.03, 0.98, 2.0), (4e-4, -2e-4, 1.0))
WALL = {"tile_width": 40.0, "tile_height": 20.0, "mortar_x": 4.0, "mortar_y": 3.0, "offset": 0.5}
VOID = {"meta", "img", "br", "line", "rect"}


class Page(HTMLParser):
    """Elements that open and close properly, the text, and what is referred to."""

    def __init__(self, text):
        super().__init__()
        self.open, self.text, self.sources = [], [], []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.sources += [value for name, value in attributes if name in ("src", "href")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        pass

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def make_page(folder, *, ok=True, reason="joints lie on joints", name="wall.png", start=True, errors=True, **wall):
    tiling = make_tiling(**{**WALL, **wall})
    pixels = np.random.default_rng(0).uniform(0.1, 0.6, (90, 120, 3)).astype(np.float32)
    write_image(folder / name, pixels)
    photo = read_image(folder / name)
    rows, columns = 4, 3
    report = {
        "ok": ok,
        "reason": reason,
        "iou": 0.876 if ok else None,
        "start": tiling_parameters(make_tiling(**{**WALL, "tile_width": 41.25}), rows=4, columns=3) if start else None,
        "standard_errors": {"tile_width": 0.0123, "origin": [0.05, None]} if errors else {},
    }
    file = TilingFile(
        tiling,
        SourceImage(photo.width, photo.height, photo.sha256),
        rows,
        columns,
        report,
        appearance=measure_appearance(photo.pixels, tiling).to_json(),
        seed=5,
        versions={"jaxtex": "1.2.3"},
    )
    path = folder / "report.html"
    mask = np.random.default_rng(1).random(pixels.shape[:2]) > 0.2
    write_report(path, photo=photo, mask=mask, file=file, seconds={"start": 0.5, "refine": 1.25})
    return path.read_text(encoding="utf-8")


def test_the_page_stands_alone(tmp_path):
    text = make_page(tmp_path)
    page = Page(text)
    assert len(page.sources) == 6
    for source in page.sources:
        kind, encoded = re.fullmatch(r"data:image/(png|jpeg);base64,([A-Za-z0-9+/=]+)", source).groups()
        picture = tmp_path / f"embedded.{kind}"
        picture.write_bytes(base64.b64decode(encoded))
        assert min(read_image(picture).pixels.shape[:2]) >= 80
    without_pictures = re.sub(r"data:[^\"]+", "", text)
    assert "//" not in without_pictures  # no address of anything elsewhere
    assert "<script" not in without_pictures
    assert "$" not in without_pictures


def test_the_page_tells_the_numbers(tmp_path):
    text = " ".join(Page(make_page(tmp_path)).text)
    assert "A tiling in running bond" in text
    assert "wall.png" in text
    for number in ("40.000", "0.012", "41.250", "-1.250", "0.05, –", "88", "0.50", "1.25", "seed 5", "jaxtex 1.2.3"):
        assert number in text
    assert f"jaxtex fit tiling {tmp_path / 'wall.png'} -o {tmp_path}" in text
    assert f"jaxtex render {tmp_path / 'model.json'} -o maps" in text


def test_a_fit_that_did_not_succeed_is_told_and_shown(tmp_path):
    text = make_page(tmp_path, ok=False, reason="nothing repeats <here>", start=False, errors=False)
    told = " ".join(Page(text).text)
    assert "No rectangular tiling: nothing repeats <here>" in told
    assert "nothing repeats <here>" not in text
    assert "best guess" in told
    assert 'class="verdict bad"' in text


def test_a_name_with_special_characters_is_shown_as_it_is(tmp_path):
    text = make_page(tmp_path, name="a <b> & 'c' $d.png")
    assert "a <b> & 'c' $d.png" in "".join(Page(text).text)


def test_long_lists_and_matrices_have_their_place(tmp_path):
    offsets = tuple(np.linspace(0, 0.9, 9))
    text = " ".join(Page(make_page(tmp_path, course_offsets=offsets, homography=VIEW)).text)
    assert "0, 0.1125, 0.225" in text
    assert "1.02, 0.05, -3" in text


def test_pages_differ_in_nothing_but_times(tmp_path):
    assert make_page(tmp_path) == make_page(tmp_path)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"offset": 0.0, "mortar_x": 0.0, "mortar_y": 0.0},
        {"tile_width": 12.0, "tile_height": 90.0},
        {"tile_width": 900.0, "tile_height": 9.0},
        {"course_lengths": ((0.5, 1.0),), "course_offsets": (0.2, 0.7)},
        {"corner_radius": 4.0, "offset": 0.99},
    ],
)
def test_diagrams_are_drawings_with_the_tiles_to_scale(changes):
    tiling = make_tiling(**{**WALL, **changes})
    drawing = ElementTree.fromstring(draw_diagram(tiling))
    tiles = [rect for rect in drawing.iter("rect") if rect.get("class")]
    assert len(tiles) >= 6
    marked = [rect for rect in tiles if rect.get("class") == "tile first"]
    assert len(marked) == 1
    width, height = (float(marked[0].get(side)) for side in ("width", "height"))
    face = float(tiling.tile_width - tiling.mortar_x), float(tiling.tile_height - tiling.mortar_y)
    assert width / height == pytest.approx(face[0] / face[1], rel=0.02)
    numbers = [
        float(value)
        for element in drawing.iter()
        for value in element.attrib.values()
        if re.fullmatch(r"-?[\d.]+", value)
    ]
    assert np.isfinite(numbers).all()
    labels = {text.text for text in drawing.iter("text")}
    assert {"tile width", "tile height"} <= labels
    assert ("head joint" in labels) == (float(tiling.mortar_x) > 0)
