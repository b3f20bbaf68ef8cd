"""Model files of floors: what is written is what is read, and damage is named."""

import json

import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.models.envelope import SourceImage
from jaxtex.models.files import load_model, need_tiling, save_model
from jaxtex.models.floor_files import FloorFile, PlacedWood, wood_of_plank
from jaxtex.models.wood import make_wood
from jaxtex.models.wood_files import wood_parameters

REPORT = {"ok": True, "reason": "", "iou": None, "start": None, "standard_errors": {}}


def make_floor():
    corners = np.array([[0.0, 0], [50, 0], [50, 90], [0, 90]])
    wood = [make_wood(ring_spacing=12.0, turbulence_rms=2.0), make_wood(ring_spacing=9.0, rotation=1.0)]
    drawn = [wood_of_plank(wood_parameters(each), seed=5, number=number) for number, each in enumerate(wood)]
    planks = (PlacedWood(corners, drawn[0], True), PlacedWood(corners + np.array([50, 0]), drawn[1], False))
    return FloorFile(planks, SourceImage(100, 90, "0" * 64), REPORT, seed=5)


def test_a_floor_is_read_as_it_was_written(tmp_path):
    floor = make_floor()
    save_model(tmp_path / "floor.json", floor)
    read = load_model(tmp_path / "floor.json")
    assert isinstance(read, FloorFile)
    for one, other in zip(floor.planks, read.planks, strict=True):
        np.testing.assert_array_equal(one.corners, other.corners)
        assert one.own == other.own
        assert wood_parameters(one.wood) == wood_parameters(other.wood)
        np.testing.assert_allclose(one.wood.phases, other.wood.phases)
    save_model(tmp_path / "again.json", read)
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "floor.json").read_bytes()


@pytest.mark.parametrize(
    ("entry", "value", "told"),
    [
        (("planks", 0, "corners"), [[0, 0], [1, 0]], "planks"),
        (("planks", 1, "wood", "ring_spacing"), -1, "ring_spacing"),
        (("planks", 0, "own"), "yes", "own"),
    ],
)
def test_damage_is_named(tmp_path, entry, value, told):
    path = tmp_path / "floor.json"
    save_model(path, make_floor())
    document = json.loads(path.read_text())
    place = document
    for key in entry[:-1]:
        place = place[key]
    place[entry[-1]] = value
    path.write_text(json.dumps(document))
    with pytest.raises(InputError, match=told):
        load_model(path)


def test_a_floor_has_no_tiles():
    with pytest.raises(InputError, match="a model of a floor"):
        need_tiling(make_floor())
