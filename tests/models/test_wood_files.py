"""Model files of wood: the canonical form, what is written, what comes back, and what is refused."""

import copy
import dataclasses
import json
import math
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import jsonschema
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import jaxtex
from jaxtex.core.errors import InputError
from jaxtex.material.appearance import appearance_of
from jaxtex.material.sheet import lay_photographed_sheet
from jaxtex.models.files import SourceImage, TilingFile, load_model, need_tiling, save_model
from jaxtex.models.grids import on_grid
from jaxtex.models.tiling import make_tiling
from jaxtex.models.wood import Wood, make_wood
from jaxtex.models.wood_detail import Displacement, Fibres
from jaxtex.models.wood_files import (
    WoodFile,
    canonical_wood,
    list_parameters,
    wood_from_parameters,
    wood_parameters,
    wood_schema,
)

IMAGE = SourceImage(640, 480, "0123456789abcdef" * 4)
NAMES = [field.name for field in dataclasses.fields(Wood) if field.name not in ("fibres", "displacement")]


def make_plank(**changes) -> Wood:
    oak = {"ring_spacing": 23.1, "center": (31.0, -1 / 3), "tilt": 0.4, "rotation": 0.9, "early_fraction": 0.37}
    with jax.enable_x64():
        wood = make_wood(**{**oak, "turbulence_rms": 2.5, "turbulence_frequency": 0.01, "seed": 3, **changes})
        return jax.tree.map(np.asarray, wood)


def make_file(wood: Wood | None = None, **changes) -> WoodFile:
    report = {
        "ok": True,
        "reason": "the rings lie where the model has them",
        "iou": 0.8125,
        "start": wood_parameters(make_plank(tilt=0.3)),
        "standard_errors": {"center": [0.5, math.nan], "tilt_deg": 0.1},
        "covariance": [[1.0, 0.5], [0.5, 1.0]],
    }
    determined = {"center": False, "tilt_deg": True}
    values = {"wood": wood or make_plank(), "image": IMAGE, "determined": determined, "report": report, "seed": 3}
    return WoodFile(**{**values, **changes})


def draw(wood: Wood) -> np.ndarray:
    with jax.enable_x64():
        middle = jnp.array([30.0, 20.0])
        return np.asarray(
            on_grid(eqx.Partial(lambda wood, at: wood.early_on_plank(at - middle, blur=1.0), wood), 40, 60)
        )


@settings(max_examples=40)
@given(tilt=st.floats(-8, 8), rotation=st.floats(-8, 8))
def test_the_canonical_form_draws_the_same_picture(tilt, rotation):
    wood = make_plank(tilt=tilt, rotation=rotation)
    written = canonical_wood(wood)
    assert 0 <= written.tilt <= math.pi / 2
    assert 0 <= written.rotation < math.pi
    np.testing.assert_allclose(draw(written), draw(wood), atol=1e-7)
    again = canonical_wood(written)
    for name in NAMES:
        np.testing.assert_allclose(getattr(again, name), getattr(written, name), atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"tilt": -0.4}, {"center": (31.0, 1 / 3), "tilt": 0.4}),
        ({"tilt": math.pi - 0.4}, {}),
        ({"tilt": 2 * math.pi + 0.4}, {}),
        ({"rotation": 0.9 + math.pi}, {"center": (-31.0, 1 / 3)}),
        ({"rotation": 0.9 - 2 * math.pi}, {}),
        ({"rotation": -1e-20}, {"rotation": 0.0}),
        ({"rotation": math.pi}, {"rotation": 0.0, "center": (-31.0, 1 / 3)}),
    ],
)
def test_the_equivalent_descriptions(changes, expected):
    written, told = canonical_wood(make_plank(**changes)), make_plank(**expected)
    for name in ("center", "tilt", "rotation", "ring_spacing", "early_rgb", "turbulence_rms"):
        np.testing.assert_allclose(getattr(written, name), getattr(told, name), atol=1e-12)


def test_single_precision_stays_and_a_right_angle_stays():
    upright = make_wood(ring_spacing=20.0, tilt=math.pi / 2, rotation=3.0)
    written = canonical_wood(upright)
    assert {leaf.dtype for leaf in jax.tree.leaves(written)} == {np.dtype(np.float32)}
    np.testing.assert_array_equal(written.waves, upright.waves)
    assert wood_parameters(upright)["tilt_deg"] <= 90
    assert wood_parameters(make_wood(ring_spacing=20.0, rotation=-1e-14))["rotation_deg"] < 180


@pytest.fixture
def document(tmp_path) -> dict[str, Any]:
    save_model(tmp_path / "good.json", make_file())
    return json.loads((tmp_path / "good.json").read_text())


def test_the_keys_are_those_of_the_format(document):
    assert list(document) == ["schema", "type", "image", "parameters", "determined", "report", "versions", "seed"]
    assert (document["schema"], document["type"], document["seed"]) == (1, "wood", 3)
    assert list(document["parameters"]) == [
        *("center", "tilt_deg", "rotation_deg", "ring_spacing", "early_fraction", "early_rgb", "late_rgb"),
        *("turbulence_rms", "turbulence_frequency"),
    ]
    assert document["parameters"]["tilt_deg"] == pytest.approx(math.degrees(0.4), abs=1e-12)
    assert document["determined"] == {"center": False, "tilt_deg": True}
    assert list(document["report"]) == ["ok", "reason", "iou", "start", "standard_errors", "covariance"]
    assert document["report"]["standard_errors"]["center"] == [0.5, None]
    assert document["versions"]["jaxtex"] == jaxtex.__version__
    jsonschema.Draft202012Validator(wood_schema()).validate(document)


def test_the_schema_is_one_and_says_what_things_are():
    schema = wood_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    described = [schema, *schema["properties"].values(), *schema["$defs"]["parameters"]["properties"].values()]
    assert all("title" in part or "$ref" in part for part in described)


def test_numbers_come_back_exactly(tmp_path):
    written = make_file()
    save_model(tmp_path / "oak.json", written)
    read = load_model(tmp_path / "oak.json")
    assert isinstance(read, WoodFile)
    for name in NAMES:
        np.testing.assert_allclose(getattr(read.wood, name), getattr(written.wood, name), rtol=1e-14)
        assert getattr(read.wood, name).dtype == np.float64
    assert (read.image, read.seed, read.determined) == (IMAGE, 3, written.determined)
    np.testing.assert_allclose(draw(read.wood), draw(written.wood), atol=1e-9)


def make_detailed(**changes) -> Wood:
    with jax.enable_x64():
        fibres = Fibres(jnp.asarray(0.1), jnp.asarray(1.5), jnp.asarray([0.02, 0.1]))
        cosines, extent = jnp.asarray([[0.25, 1.0], [-2.0, 0.5]]), jnp.asarray([640.0, 480.0])
        field = Displacement(cosines, extent, jnp.asarray([3.0, -4.0]), jnp.asarray(0.3))
        return make_plank(gradation=0.11, fibres=fibres, displacement=field, **changes)


def test_detail_comes_back_exactly(tmp_path):
    written = make_detailed()
    save_model(tmp_path / "oak.json", make_file(written))
    read = load_model(tmp_path / "oak.json")
    assert isinstance(read, WoodFile)
    assert jax.tree.structure(read.wood) == jax.tree.structure(written)
    for one, other in zip(jax.tree.leaves(read.wood), jax.tree.leaves(written), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12)
    assert [name for name in list_parameters(written) if name not in list_parameters(make_plank())] == [
        *("gradation", "fibres.contrast", "fibres.width", "fibres.pores"),
    ]


@pytest.mark.parametrize("changes", [{"tilt": -0.4}, {"rotation": 4.0}, {"tilt": 2.0}])
def test_a_mirrored_trunk_has_the_same_displacement(changes):
    wood = make_detailed(**changes)
    np.testing.assert_allclose(draw(canonical_wood(wood)), draw(wood), atol=1e-7)


@settings(max_examples=25)
@given(tilt=st.floats(-7, 7), rotation=st.floats(-7, 7), spacing=st.floats(1, 1e3), single=st.booleans())
def test_what_was_read_is_written_as_the_same_bytes(tmp_path_factory, tilt, rotation, spacing, single):
    folder = tmp_path_factory.mktemp("files")
    wood = make_plank(tilt=tilt, rotation=rotation, ring_spacing=spacing, turbulence_rms=0.0)
    if single:
        wood = jax.tree.map(lambda leaf: leaf.astype(np.float32), wood)
    save_model(folder / "first.json", make_file(wood))
    save_model(folder / "second.json", load_model(folder / "first.json"))
    assert (folder / "first.json").read_bytes() == (folder / "second.json").read_bytes()


def test_turbulence_is_that_of_the_seed_or_refused(tmp_path):
    mirrored = make_plank(tilt=-0.4)
    for file in (make_file(mirrored), make_file(seed=4), make_file(make_plank(seed=2))):
        with pytest.raises(ValueError, match="turbulence is not that of seed"):
            save_model(tmp_path / "oak.json", file)
    assert not list(tmp_path.iterdir())
    save_model(tmp_path / "oak.json", make_file(wood_from_parameters(wood_parameters(mirrored), seed=3)))
    single = jax.tree.map(lambda leaf: leaf.astype(np.float32), make_plank())
    save_model(tmp_path / "oak.json", make_file(single))


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"report": {}}, "report.ok is missing"),
        ({"seed": -1}, "seed is -1; it must be at least 0"),
        ({"determined": {"center": 0.5}}, "determined.center is 0.5; it must be true or false"),
        ({"wood": make_plank(early_rgb=(-0.1, 0, 0))}, r"parameters.early_rgb\[0\] is -0.1; it must be at least 0"),
        ({"wood": jax.tree.map(lambda leaf: leaf * np.nan, make_plank())}, "numbers that are not finite"),
    ],
)
def test_what_cannot_be_written_is_refused(tmp_path, changes, told):
    with pytest.raises(ValueError, match=told):
        save_model(tmp_path / "oak.json", make_file(**changes))
    assert not list(tmp_path.iterdir())


BAD_ENTRIES = [
    ("parameters.ring_spacing", None, "parameters.ring_spacing is null; it must be a number"),
    ("parameters.ring_spacing", 0, "parameters.ring_spacing is 0; it must be more than 0"),
    ("parameters.ring_spacing", 1e-9, "parameters: ring_spacing is 1e-09; it must be at least 1e-06"),
    ("parameters.tilt_deg", 91, "parameters.tilt_deg is 91; it must be at most 90"),
    ("parameters.rotation_deg", 180, "parameters.rotation_deg is 180; it must be less than 180"),
    ("parameters.center", [1], "parameters.center is [1]; it must be a list of 2"),
    ("parameters.early_rgb", [1, 1], "parameters.early_rgb is [1, 1]; it must be a list of 3"),
    ("parameters.tile_width", 3, "parameters.tile_width is not known; it must be one of center, tilt_deg"),
    ("parameters.gradation", 0.3, "parameters.gradation is 0.3; it must be at most 0.25"),
    (
        "parameters.fibres",
        {"contrast": 0.1, "width": 0, "pores": [0, 0]},
        "parameters.fibres.width is 0; it must be more",
    ),
    (
        "parameters.displacement",
        {"cosines": [[1, 2], [3]], "extent": [4, 5], "middle": [0, 0], "turn_deg": 0},
        "displacement.cosines has rows of several lengths",
    ),
    ("determined", ["center"], 'determined is ["center"]; it must be an object'),
    ("report.iou", 2, "report.iou is 2; it must be at most 1"),
    ("report.start.tilt_deg", -1, "report.start.tilt_deg is -1; it must be at least 0"),
    ("seed", 0.5, "seed is 0.5; it must be a whole number"),
    ("type", "tiling", "determined is not known"),
]


@pytest.mark.parametrize(("where", "value", "told"), BAD_ENTRIES)
def test_a_wrong_entry_is_named_in_one_line(document, tmp_path, where, value, told):
    changed = copy.deepcopy(document)
    *inside, key = where.split(".")
    place = changed
    for name in inside:
        place = place[name]
    place[key] = value
    path = tmp_path / "bad.json"
    path.write_text(json.dumps(changed))
    with pytest.raises(InputError) as refusal:
        load_model(path)
    assert str(refusal.value).startswith(f"{path}: ")
    assert told in str(refusal.value) or where == "type"
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("key", ["parameters", "determined", "report", "seed", "image"])
def test_a_missing_entry_is_named(document, tmp_path, key):
    del document[key]
    (tmp_path / "bad.json").write_text(json.dumps(document))
    with pytest.raises(InputError, match=f"{key} is missing"):
        load_model(tmp_path / "bad.json")


def test_who_needs_a_tiling_says_so():
    report = {"ok": True, "reason": "", "iou": None, "start": None, "standard_errors": {}}
    wall = TilingFile(make_tiling(tile_width=60.0, tile_height=20.0), IMAGE, 24, 11, report)
    assert need_tiling(wall) is wall
    for asks in (need_tiling, appearance_of, lay_photographed_sheet):
        with pytest.raises(InputError, match="this is a model of wood, which has no tiles; give a model of a tiling"):
            asks(make_file())
