"""Model files: what is written, what comes back, and what is refused with one line."""

import copy
import dataclasses
import json
import math
from importlib import resources
from typing import Any

import jax
import jsonschema
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import jaxtex
from jaxtex.core.errors import InputError
from jaxtex.models.bonds import bond_pattern
from jaxtex.models.canonical import canonical
from jaxtex.models.documents import find_fault
from jaxtex.models.files import (
    SourceImage,
    TilingFile,
    load_model,
    save_model,
    tiling_from_parameters,
    tiling_parameters,
    tiling_schema,
)
from jaxtex.models.tiling import Tiling, make_tiling

IMAGE = SourceImage(640, 480, "0123456789abcdef" * 4)


def make_wall(**changes) -> Tiling:
    with jax.enable_x64():
        return jax.tree.map(
            np.asarray,
            make_tiling(
                **{
                    "tile_width": 60.1,
                    "tile_height": 1 / 3,
                    "mortar_x": 0.1,
                    "mortar_y": 0.1,
                    "angle": 0.3,
                    "offset": 0.5,
                    **changes,
                }
            ),
        )


def make_file(tiling: Tiling | None = None, **changes) -> TilingFile:
    tiling = make_wall() if tiling is None else tiling
    start = tiling_parameters(make_wall(angle=0.29), rows=24, columns=11)
    report = {
        "ok": True,
        "reason": "the joints lie where the model has them",
        "iou": 0.8125,
        "start": start,
        "standard_errors": {"tile_width": 0.01, "origin": [0.1, 0.2], "angle_deg": math.nan},
        "criterion": 3,
    }
    return TilingFile(**{"tiling": tiling, "image": IMAGE, "rows": 24, "columns": 11, "report": report, **changes})


@pytest.fixture
def document(tmp_path) -> dict[str, Any]:
    path = tmp_path / "good.json"
    save_model(path, make_file(appearance={"tile_colours": [[0.5, 0.2, 0.1]]}, seed=0, mm_per_px=2.5))
    return json.loads(path.read_text())


def test_the_keys_are_those_of_the_format(document):
    assert list(document) == ["schema", "type", "image", "parameters", "report", "appearance", "versions", "seed"]
    assert document["schema"] == 1
    assert document["type"] == "tiling"
    assert document["image"] == {"width": 640, "height": 480, "sha256": IMAGE.sha256}
    assert list(document["parameters"]) == [
        *("tile_width", "tile_height", "angle_deg", "mortar_x", "mortar_y", "offset", "origin", "homography"),
        *("bond", "rows", "columns", "mm_per_px"),
    ]
    assert document["parameters"]["homography"] == [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    assert document["parameters"]["angle_deg"] == pytest.approx(math.degrees(0.3), abs=1e-12)
    assert list(document["report"]) == ["ok", "reason", "iou", "start", "standard_errors", "criterion"]
    assert document["report"]["standard_errors"]["angle_deg"] is None
    assert document["versions"]["jaxtex"] == jaxtex.__version__


def test_numbers_come_back_exactly(tmp_path):
    given_file = make_file(appearance={"tiles": [1, 0.1]}, seed=7, mm_per_px=0.1 + 0.2)
    save_model(tmp_path / "wall.json", given_file)
    read = load_model(tmp_path / "wall.json")
    expected = canonical(given_file.tiling)
    for name in ("tile_width", "tile_height", "mortar_x", "offset", "origin", "homography", "course_lengths"):
        np.testing.assert_array_equal(getattr(read.tiling, name), getattr(expected, name))
        assert getattr(read.tiling, name).dtype == np.float64
    assert abs(read.tiling.angle - expected.angle) < 1e-13
    assert (read.image, read.rows, read.columns, read.seed, read.mm_per_px) == (IMAGE, 24, 11, 7, 0.1 + 0.2)
    assert read.appearance == {"tiles": [1, 0.1]}
    assert read.report["start"] == given_file.report["start"]
    start = tiling_from_parameters(read.report["start"])
    jax.tree.map(lambda one, other: np.testing.assert_allclose(one, other, atol=1e-13), start, make_wall(angle=0.29))


@settings(max_examples=60)
@given(
    bond=st.sampled_from(["stack", "running", "english", "flemish"]),
    angle=st.floats(-7, 7),
    tile_width=st.floats(1, 1e4),
    origin=st.tuples(st.floats(-1e5, 1e5), st.floats(-1e5, 1e5)),
    single=st.booleans(),
)
def test_what_was_read_is_written_as_the_same_bytes(tmp_path_factory, bond, angle, tile_width, origin, single):
    folder = tmp_path_factory.mktemp("files")
    arguments = {"offset": 0.0, **bond_pattern(bond, header=0.487), "angle": angle, "origin": origin}
    wall = make_wall(tile_width=tile_width, **arguments)
    if single:
        wall = jax.tree.map(lambda leaf: leaf.astype(np.float32), wall)
    save_model(folder / "first.json", make_file(wall))
    read = load_model(folder / "first.json")
    save_model(folder / "second.json", read)
    assert (folder / "first.json").read_bytes() == (folder / "second.json").read_bytes()
    # It is canonical, so tiles can be named by their numbers.
    save_model(folder / "second.json", dataclasses.replace(read, appearance={"tiles": []}))
    jsonschema.Draft202012Validator(tiling_schema()).validate(json.loads((folder / "first.json").read_text()))


def test_optional_parameters_are_written_where_they_matter(tmp_path):
    save_model(tmp_path / "wall.json", make_file(make_wall(offset=0.0, **bond_pattern("flemish"), corner_radius=0.05)))
    written = json.loads((tmp_path / "wall.json").read_text())
    assert written["parameters"]["course_lengths"] == [[1.0, 0.5]]
    assert written["parameters"]["course_offsets"] == [0.0, 0.75]
    assert written["parameters"]["corner_radius"] == 0.05
    assert "seed" not in written
    assert "appearance" not in written
    assert "mm_per_px" not in written["parameters"]


def test_lists_of_numbers_stand_on_one_line(tmp_path):
    save_model(tmp_path / "wall.json", make_file())
    lines = (tmp_path / "wall.json").read_text().splitlines()
    assert "      [1.0, 0.0, 0.0]," in lines
    assert '    "origin": [0.0, 0.0],' in lines
    assert len(lines) < 75


def test_a_model_made_by_hand_needs_no_fit(tmp_path):
    report = {"ok": True, "reason": "made by hand", "iou": None, "start": None, "standard_errors": {}}
    save_model(tmp_path / "wall.json", make_file(report=report))
    assert load_model(tmp_path / "wall.json").report == report


def test_the_file_that_stood_there_stays_when_writing_fails(tmp_path):
    path = tmp_path / "wall.json"
    save_model(path, make_file())
    before = path.read_bytes()
    with pytest.raises(ValueError, match="cannot be written"):
        save_model(path, make_file(rows=0))
    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["wall.json"]


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"rows": 0}, "this model cannot be written: parameters.rows is 0; it must be at least 1"),
        ({"report": {}}, "report.ok is missing"),
        ({"image": SourceImage(640, 480, "?")}, r"image.sha256 is \"\?\"; it must be of the form"),
        ({"mm_per_px": -1.0}, "parameters.mm_per_px is -1.0; it must be more than 0"),
        ({"seed": -1}, "seed is -1; it must be at least 0"),
        ({"appearance": {"tiles": math.nan}}, "not JSON compliant"),
        ({"appearance": {}, "tiling": make_wall(angle=3.0)}, "the tiling is not in canonical form"),
        ({"tiling": jax.tree.map(lambda leaf: leaf * np.nan, make_wall())}, "numbers that are not finite"),
    ],
)
def test_what_cannot_be_written_is_refused(tmp_path, changes, told):
    with pytest.raises(ValueError, match=told):
        save_model(tmp_path / "wall.json", make_file(**changes))
    assert not list(tmp_path.iterdir())


def test_there_must_be_a_folder(tmp_path):
    with pytest.raises(InputError, match="there is no folder"):
        save_model(tmp_path / "no" / "wall.json", make_file())


BAD_TEXTS = {
    "empty": ("", "is empty (0 bytes)"),
    "blank": ("  \n", "is damaged, or is no JSON file (Expecting value, line 2, column 1)"),
    "cut off": ('{"schema": 1, "type": "tiling", "ima', "is damaged, or is no JSON file (Unterminated string"),
    "no JSON": ("tile_width: 60", "is damaged, or is no JSON file (Expecting value, line 1, column 1)"),
    "a list": ("[1, 2]", "holds [1, 2], not a model"),
    "a number": ("3", "holds 3, not a model"),
    "nested": ("[" * 100_000, "its brackets are nested too deep"),
    "other JSON": ('{"name": "jaxtex"}', "has no schema and type, so it is no model file"),
    "later schema": ('{"schema": 2, "type": "tiling"}', "schema is 2; this version of jaxtex reads 1"),
    "other type": ('{"schema": 1, "type": "clay"}', "type is 'clay'; this version of jaxtex reads tiling and wood"),
    "type of no kind": ('{"schema": 1, "type": ["wood"]}', "type is ['wood']; this version of jaxtex reads"),
    "key twice": ('{"schema": 1, "schema": 1}', "holds the key 'schema' twice"),
    "NaN": ('{"schema": 1, "type": NaN}', "holds NaN, which is no number"),
    "infinity": ('{"schema": 1, "type": -Infinity}', "holds -Infinity, which is no number"),
    "huge": ('{"schema": 1, "type": 1e999}', "holds 1e999, which is too large a number"),
}


@pytest.mark.parametrize("name", BAD_TEXTS)
def test_what_is_no_model_file_is_refused_in_one_line(tmp_path, name):
    text, told = BAD_TEXTS[name]
    path = tmp_path / "bad.json"
    path.write_text(text)
    assert_refused(path, told)


def assert_refused(path, told: str) -> None:
    with pytest.raises(InputError) as refusal:
        load_model(path)
    message = str(refusal.value)
    assert message.startswith(f"{path}: ")
    assert told in message
    assert "\n" not in message
    assert len(message) < 250 + len(str(path))


def test_files_that_are_no_text_are_refused(tmp_path):
    (tmp_path / "picture.png").write_bytes(b"\x89PNG\r\n\x1a\n\xff\xfe")
    assert_refused(tmp_path / "picture.png", "is not a text file, so it is no model file")
    assert_refused(tmp_path / "missing.json", "there is no such file")
    assert_refused(tmp_path, "is a folder")


MISSING = object()
BAD_ENTRIES = [
    ("parameters.tile_width", MISSING, "parameters.tile_width is missing"),
    ("parameters.tile_width", 0, "parameters.tile_width is 0; it must be more than 0"),
    ("parameters.tile_height", -3.5, "parameters.tile_height is -3.5; it must be more than 0"),
    ("parameters.tile_width", "60", 'parameters.tile_width is "60"; it must be a number'),
    ("parameters.tile_width", None, "parameters.tile_width is null; it must be a number"),
    ("parameters.tile_width", True, "parameters.tile_width is true; it must be a number"),
    ("parameters.mortar_x", 60.1, "parameters: mortar_x = 60.1 leaves nothing of a shortest tile of 60.1"),
    ("parameters.mortar_y", -1, "parameters.mortar_y is -1; it must be at least 0"),
    ("parameters.offset", 1.0, "parameters.offset is 1.0; it must be less than 1"),
    ("parameters.angle_deg", -90, "parameters.angle_deg is -90; it must be more than -90"),
    ("parameters.angle_deg", 90.5, "parameters.angle_deg is 90.5; it must be at most 90"),
    ("parameters.origin", [1.0], "parameters.origin is [1.0]; it must be a list of 2"),
    ("parameters.origin", {"x": 1}, 'parameters.origin is {"x": 1}; it must be a list [...]'),
    ("parameters.homography", [[1, 0, 0], [0, 1, 0]], "it must be a list of 3"),
    ("parameters.homography", [[1, 0, 0], [0, 1], [0, 0, 1]], "parameters.homography[1] is [0, 1]; it must be a list"),
    ("parameters.homography", [[1, 0, 0], [1, 0, 0], [0, 0, 1]], "parameters: homography is singular"),
    ("parameters.homography", [[2, 0, 0], [0, 2, 0], [0, 0, 2]], "parameters: homography has H33 = 2; divide it"),
    ("parameters.bond", "herringbone", 'parameters.bond is "herringbone"; it must be one of stack, running, raking'),
    ("parameters.rows", 2.5, "parameters.rows is 2.5; it must be a whole number"),
    ("parameters.columns", 0, "parameters.columns is 0; it must be at least 1"),
    ("parameters.corner_radius", 50, "parameters: corner_radius = 50 is more than half a tile's shorter side"),
    ("parameters.corner_raduis", 1, "parameters.corner_raduis is not known; it must be one of tile_width"),
    ("parameters.course_lengths", [[1, 2], [1]], "parameters: course_lengths has rows of different lengths"),
    ("parameters.course_lengths", [[]], "parameters.course_lengths[0] is []; it must be a list of at least 1"),
    ("parameters.course_lengths", [[1, -1]], "parameters.course_lengths[0][1] is -1; it must be more than 0"),
    ("parameters.course_offsets", ["0"], 'parameters.course_offsets[0] is "0"; it must be a number'),
    ("parameters", [], "parameters is []; it must be an object {...}"),
    ("image.sha256", "abc", 'image.sha256 is "abc"; it must be of the form ^[0-9a-f]{64}$'),
    ("image.width", MISSING, "image.width is missing"),
    ("image", MISSING, "image is missing"),
    ("report.ok", "yes", 'report.ok is "yes"; it must be true or false'),
    ("report.iou", 1.5, "report.iou is 1.5; it must be at most 1"),
    ("report.iou", "good", 'report.iou is "good"; it must be a number or null'),
    ("report.start", 3, "report.start is 3; it must be an object {...}"),
    ("report.start.offset", -0.1, "report.start.offset is -0.1; it must be at least 0"),
    ("report.start.bond", MISSING, "report.start.bond is missing"),
    ("report.standard_errors.offset", "big", 'report.standard_errors.offset is "big"; it must be a number or'),
    ("versions.jaxtex", 0.1, "versions.jaxtex is 0.1; it must be a text"),
    ("appearance", "red", 'appearance is "red"; it must be an object {...}'),
    ("seed", 1.5, "seed is 1.5; it must be a whole number"),
    ("schema", True, "schema is true; it must be 1"),
    ("colour", "red", "colour is not known; it must be one of schema, type, image"),
]


def change(document: dict[str, Any], where: str, value: Any) -> dict[str, Any]:
    changed = copy.deepcopy(document)
    *inside, key = where.split(".")
    place = changed
    for name in inside:
        place = place[name]
    if value is MISSING:
        del place[key]
    else:
        place[key] = value
    return changed


@pytest.mark.parametrize(("where", "value", "told"), BAD_ENTRIES)
def test_a_wrong_entry_is_named_in_one_line(document, tmp_path, where, value, told):
    path = tmp_path / "bad.json"
    bad = change(document, where, value)
    path.write_text(json.dumps(bad))
    assert_refused(path, told)
    # What the schema can say, it says; the rest is what only numbers together can be.
    judged = jsonschema.Draft202012Validator(tiling_schema()).is_valid(bad)
    assert judged == told.startswith("parameters: ")


def test_the_schema_is_one_and_says_what_things_are():
    schema = tiling_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    assert resources.files("jaxtex.models").joinpath("schema/tiling-1.json").is_file()
    described = [schema, *schema["properties"].values(), *schema["$defs"]["parameters"]["properties"].values()]
    assert all("title" in part or "$ref" in part for part in described)


def keywords(schema: Any) -> set[str]:
    """All keywords of a schema, the names of properties and definitions aside."""
    found = set(schema)
    inner = [*schema.get("properties", {}).values(), *schema.get("$defs", {}).values(), *schema.get("anyOf", [])]
    inner += [schema[key] for key in ("items", "additionalProperties") if isinstance(schema.get(key), dict)]
    return found.union(*map(keywords, inner))


def test_the_check_knows_every_keyword_of_the_schema():
    checked = {"type", "const", "enum", "required", "properties", "additionalProperties", "items", "minItems"}
    checked |= {"maxItems", "minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum", "pattern", "$ref", "anyOf"}
    assert keywords(tiling_schema()) <= checked | {"$schema", "$id", "$defs", "title", "description"}


WORDS = ["parameters", "report", "image", "start", "tile_width", "origin", "homography", "bond", "rows", "iou", "seed"]
values = st.recursive(
    st.none() | st.booleans() | st.sampled_from([0, 1, -1, 0.5, 2.0, 90, 1e300, "stack", "", "0" * 64]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(WORDS), inner, max_size=3),
    max_leaves=6,
)


@settings(max_examples=300)
@given(data=st.data(), value=values)
def test_the_check_agrees_with_a_full_validator(data, value):
    document = json.loads(json.dumps(GOOD))
    place: Any = document
    while True:
        key = data.draw(st.sampled_from(sorted(place)) if isinstance(place, dict) else st.integers(0, len(place) - 1))
        if not isinstance(place[key], dict | list) or not place[key] or data.draw(st.booleans()):
            break
        place = place[key]
    if isinstance(place, dict) and data.draw(st.booleans()):
        del place[key]
    else:
        place[key] = value
    validator = jsonschema.Draft202012Validator(tiling_schema())
    assert (find_fault(document, tiling_schema()) is None) == validator.is_valid(document)


GOOD = {
    "schema": 1,
    "type": "tiling",
    "image": {"width": 4, "height": 3, "sha256": "0" * 64},
    "parameters": tiling_parameters(make_wall(**bond_pattern("flemish")), rows=3, columns=4),
    "report": {
        "ok": False,
        "reason": "no courses",
        "iou": None,
        "start": tiling_parameters(make_wall(), rows=3, columns=4, mm_per_px=2.0),
        "standard_errors": {"tile_width": 0.1, "origin": [0.1, None]},
    },
    "appearance": {"tiles": []},
    "versions": {"jaxtex": "0.1.0"},
    "seed": 0,
}
