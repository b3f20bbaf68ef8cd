"""Files of mixtures: what is written, what comes back, and how parts are found."""

import json
import os
from pathlib import Path

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxtex.core.errors import InputError
from jaxtex.models.documents import find_fault
from jaxtex.models.envelope import schema_of
from jaxtex.models.files import load_any, load_model, save_model
from jaxtex.models.mixture_files import (
    MixedWood,
    MixtureFile,
    ModelLayer,
    PhotographLayer,
    find_part,
    name_beside,
)

LAYERS = (
    ModelLayer("low.png", "tiles.json", 0.5),
    ModelLayer("high.png", "oak.json"),
    PhotographLayer("a.png", "b.jpg"),
)
MIX = MixtureFile("wall.json", MixedWood("oak.json", 2.0), LAYERS)

texts = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]), min_size=1)
scales = st.floats(1e-6, 1e6)
layers = st.builds(ModelLayer, texts, texts, scales) | st.builds(PhotographLayer, texts, texts)
mixtures = st.builds(
    MixtureFile,
    base=texts,
    wood=st.none() | st.builds(MixedWood, texts, scales),
    layers=st.lists(layers, max_size=3).map(tuple),
    versions=st.just({"jaxtex": "0"}),
)


@given(mixtures)
def test_what_is_written_comes_back(tmp_path_factory, file):
    path = tmp_path_factory.mktemp("mixture") / "mix.json"
    save_model(path, file)
    assert load_any(path) == file
    first = path.read_bytes()
    save_model(path, load_any(path))
    assert path.read_bytes() == first
    jsonschema.validate(json.loads(first), schema_of("mixture"))


def test_the_keys_are_those_of_the_format(tmp_path):
    save_model(tmp_path / "mix.json", MIX)
    document = json.loads((tmp_path / "mix.json").read_text())
    assert list(document) == ["schema", "type", "base", "wood", "layers", "versions"]
    assert document["wood"] == {"model": "oak.json", "scale": 2.0}
    assert document["layers"] == [
        {"mask": "low.png", "model": "tiles.json", "scale": 0.5},
        {"mask": "high.png", "model": "oak.json"},
        {"mask": "a.png", "photograph": "b.jpg"},
    ]
    assert list(MIX.names()) == [
        "wall.json",
        "oak.json",
        "low.png",
        "tiles.json",
        "high.png",
        "oak.json",
        "a.png",
        "b.jpg",
    ]


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda d: d.pop("base"), "base is missing"),
        (lambda d: d.update(base=""), "base"),
        (lambda d: d["wood"].update(scale=0), "wood.scale"),
        (lambda d: d["wood"].pop("model"), "wood.model is missing"),
        (lambda d: d["layers"][0].pop("mask"), "layers[0].mask is missing"),
        (lambda d: d["layers"][0].update(scale=-1), "layers[0].scale"),
        (lambda d: d["layers"][2].update(model="c.json"), "layers[2]"),
        (lambda d: d["layers"][2].pop("photograph"), "layers[2].model is missing"),
        (lambda d: d.update(image={}), "image is not known"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, change, told):
    path = tmp_path / "mix.json"
    save_model(path, MIX)
    document = json.loads(path.read_text())
    change(document)
    path.write_text(json.dumps(document))
    with pytest.raises(InputError) as caught:
        load_any(path)
    assert str(path) in str(caught.value)
    assert told in str(caught.value)
    # The package's own check and that of the reference implementation refuse the same.
    assert find_fault(document, schema_of("mixture")) is not None
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(document, schema_of("mixture"))


def test_a_mixture_is_no_model(tmp_path):
    save_model(tmp_path / "mix.json", MIX)
    with pytest.raises(InputError, match=r"mix\.json: is a mixture"):
        load_model(tmp_path / "mix.json")


@pytest.mark.parametrize(
    ("path", "part", "name"),
    [
        ("mix.json", "wall.json", "wall.json"),
        ("mix.json", "wall/model.json", "wall/model.json"),
        ("mixed/mix.json", "wall/model.json", "../wall/model.json"),
        ("mixed/mix.json", "mixed/wall.json", "wall.json"),
        ("mixed/mix.json", "./wall/../mixed/wall.json", "wall.json"),
    ],
)
def test_parts_are_named_from_the_mixtures_folder_and_found_from_anywhere(tmp_path, monkeypatch, path, part, name):
    monkeypatch.chdir(tmp_path)
    for folder in ("wall", "mixed", "elsewhere"):
        (tmp_path / folder).mkdir()
    Path(part).write_text("{}")
    assert name_beside(path, part) == name
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert os.path.samefile(find_part(tmp_path / path, name), tmp_path / part)


def test_absolute_names_stay(tmp_path):
    assert name_beside("mix.json", tmp_path / "wall.json") == (tmp_path / "wall.json").as_posix()
    assert find_part("mixed/mix.json", str(tmp_path / "wall.json")) == tmp_path / "wall.json"


def test_names_lead_through_links(tmp_path, monkeypatch):
    (tmp_path / "deep" / "real").mkdir(parents=True)
    (tmp_path / "link").symlink_to(tmp_path / "deep" / "real")
    (tmp_path / "wall.json").write_text("{}")
    monkeypatch.chdir(tmp_path)
    name = name_beside("link/mix.json", "wall.json")
    assert find_part("link/mix.json", name).exists()


def test_a_mixture_is_no_part_of_itself(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="is a part of the mixture itself"):
        name_beside(tmp_path / "mix.json", "./mix.json")
