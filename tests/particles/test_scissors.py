"""Things cut out by hand: outlines, paint, and both beside what is found."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image, ImageDraw

from jaxtex.core.errors import InputError
from jaxtex.particles.scissors import Polygon, cut_polygons, join_things, label_painted, read_polygons
from jaxtex.particles.things import describe_particles


@given(st.integers(0, 2**32 - 1))
def test_a_pixel_is_in_a_polygon_if_its_centre_is(seed: int) -> None:
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(0, 2 * np.pi, 7))
    corners = np.stack([20 + 15 * np.cos(angles), 16 + 12 * np.sin(angles)], axis=1)  # convex
    y, x = np.indices((32, 40)) + 0.5
    edges = np.roll(corners, -1, axis=0) - corners
    side = [dx * (y - cy) - dy * (x - cx) for (cx, cy), (dx, dy) in zip(corners, edges, strict=True)]
    inside, beside = np.min(side, axis=0) > 1e-9, np.min(side, axis=0) < -1e-9
    if not inside.any():
        return
    labels = cut_polygons([Polygon(corners)], (32, 40))
    assert np.all(labels[inside] == 1)
    assert not np.any(labels[beside])


def test_the_later_polygon_has_what_overlaps() -> None:
    square = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 6.0], [0.0, 6.0]])
    labels = cut_polygons([Polygon(square), Polygon(square + 3)], (12, 12))
    assert labels[4, 4] == 2
    assert labels[1, 1] == 1


@pytest.mark.parametrize(
    ("points", "told"),
    [
        ([[0, 0], [1, 1]], "three corners"),
        ([[90, 90], [99, 90], [99, 99]], "no pixel"),
        ([[0, 0], [1, np.nan], [2, 2]], "corners"),
    ],
)
def test_polygons_that_cut_nothing(points: list, told: str) -> None:
    with pytest.raises(InputError, match=told):
        cut_polygons([Polygon(np.array(points, float))], (20, 20))


def test_painted_areas_are_things_and_soft_edges_belong_to_what_is_next() -> None:
    image = Image.new("RGB", (400, 300))
    pen = ImageDraw.Draw(image)
    boxes = [(40, 40, 140, 130), (150, 40, 250, 130), (40, 160, 140, 260), (260, 150, 370, 260)]
    for box, colour in zip(boxes, ["red", "red", "blue", "lime"], strict=True):
        pen.ellipse(box, fill=colour)
    soft = np.asarray(image.resize((100, 75), Image.Resampling.BICUBIC))
    labels = label_painted(soft)
    assert labels.max() == 4
    hard = np.asarray(image.resize((100, 75), Image.Resampling.NEAREST)).any(axis=-1)
    assert np.mean((labels > 0) == hard) > 0.98


def test_things_that_touch_in_two_colours_are_two() -> None:
    painted = np.zeros((9, 20), int)
    painted[2:7, 3:9], painted[2:7, 9:15] = 40, 41
    assert label_painted(painted).max() == 2
    assert label_painted(np.where(painted > 0, 40, 0)).max() == 1
    assert label_painted(np.full((6, 6), 5)).min() == 1


def test_paint_that_shows_nothing() -> None:
    with pytest.raises(InputError, match="all is black"):
        label_painted(np.zeros((8, 8, 3)))
    with pytest.raises(InputError, match="three pixels wide"):
        label_painted(np.random.default_rng(0).random((8, 8)))
    with pytest.raises(InputError, match="shape"):
        label_painted(np.zeros((0, 3)))


def squares(places: list[tuple[int, int]], side: int = 6) -> np.ndarray:
    labels = np.zeros((40, 60), int)
    for number, (x, y) in enumerate(places, 1):
        labels[y : y + side, x : x + side] = number
    return labels


def test_what_is_cut_out_replaces_what_was_found_there() -> None:
    found = describe_particles(squares([(2, 2), (20, 2), (40, 2)]), [0, 1, 0])
    cut = describe_particles(squares([(3, 3), (20, 20)], 8), [0, 0])
    picture = np.full((40, 60, 3), 0.02)
    picture[found.labels == 2] = 0.8
    picture[:12, :12] = 0.1
    picture[20:28, 20:28] = 0.75
    joined = join_things(picture, cut, found, named=False)
    assert len(joined.particles) == 4
    assert [each.kind for each in joined.particles] == [0, 1, 1, 0]
    named = join_things(picture, cut, found, named=True)
    assert [each.kind for each in named.particles] == [0, 0, 2, 1]
    with pytest.raises(ValueError, match="labels"):
        join_things(picture[:20], cut, found, named=False)


def test_outlines_are_read_as_labelme_saves_them(tmp_path: Path) -> None:
    path = tmp_path / "cut.json"
    shape = {"label": "leaf", "points": [[1, 2], [3.5, 4], [1, 6]], "shape_type": "polygon", "flags": {}}
    path.write_text(json.dumps({"version": "5.5.0", "shapes": [shape, {**shape, "label": "stone"}], "imageData": None}))
    assert [each.name for each in read_polygons(path)] == ["leaf", "stone"]
    assert read_polygons(path)[0].points.tolist() == shape["points"]


def test_rectangles_are_polygons_and_sizes_of_pictures_are_compared(tmp_path: Path) -> None:
    path = tmp_path / "cut.json"
    shape = {"label": "a", "points": [[1, 2], [5, 8]], "shape_type": "rectangle"}
    path.write_text(json.dumps({"shapes": [shape], "imageWidth": 20, "imageHeight": 10}))
    labels = cut_polygons(read_polygons(path, (20, 10)), (10, 20))
    np.testing.assert_array_equal(np.argwhere(labels), [(row, column) for row in range(2, 8) for column in range(1, 5)])
    with pytest.raises(InputError, match="20 x 10; this one is 40 x 20"):
        read_polygons(path, (40, 20))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("{", "no JSON"),
        ('{"shapes": ' + 5000 * "9" + "}", "no JSON"),
        (100_000 * "[", "brackets too deep"),
        ("[]", "shapes"),
        ('{"shapes": []}', "shapes"),
        ('{"shapes": [{"label": "a"}]}', "shape 1"),
        ('{"shapes": [5]}', "shape 1"),
        ('{"shapes": [{"points": [[1, 2], [3]]}]}', "shape 1"),
        ('{"shapes": [{"points": [[1, 2], [3, 4]], "shape_type": "line"}]}', "no polygon"),
    ],
)
def test_files_without_outlines(tmp_path: Path, text: str, told: str) -> None:
    path = tmp_path / "cut.json"
    path.write_text(text)
    with pytest.raises(InputError, match=told) as error:
        read_polygons(path)
    assert "cut.json" in str(error.value)
