"""Finishes: by structure, and by their names."""

import dataclasses

import pytest

from jaxtex.core.errors import InputError
from jaxtex.material.appearance import Appearance, appearance_from_json, quantise
from jaxtex.material.finish import FINISHES, check_structures, find_finish, finish_tiling

PLAIN = Appearance(tiles={(0, 0): quantise((0.3, 0.2, 0.1))}, joint=quantise((0.5, 0.5, 0.5)), joint_depth=2.0)


@pytest.mark.parametrize("name", FINISHES)
@pytest.mark.parametrize(("structure", "other"), [("tile", "joint"), ("joint", "tile")])
def test_a_finish_is_that_of_its_structure_alone(name, structure, other):
    finished = finish_tiling(PLAIN, {structure: name})
    for field, value in FINISHES[name]._asdict().items():
        assert getattr(finished, f"{structure}_{field}") == value
        assert getattr(finished, f"{other}_{field}") == getattr(PLAIN, f"{other}_{field}")
        plain = dataclasses.replace(
            finished,
            **{f"{structure}_{each}": getattr(PLAIN, f"{structure}_{each}") for each in FINISHES[name]._fields},
        )
    assert plain == PLAIN


def test_structures_are_finished_together_or_not_at_all():
    finished = finish_tiling(PLAIN, {"tile": "varnish", "joint": "dull"})
    assert finished.tile_roughness < 0.2 < 0.9 < finished.joint_roughness
    assert finish_tiling(PLAIN, {}) == PLAIN
    assert finish_tiling(finished, {"tile": "mirror"}).tile_metallic == 1


@pytest.mark.parametrize("name", FINISHES)
def test_a_finish_is_one_that_model_files_hold(name):
    finished = finish_tiling(PLAIN, {"tile": name, "joint": name})
    assert appearance_from_json(finished.to_json()) == finished


def test_what_is_unknown_is_named():
    with pytest.raises(InputError, match=r"^'grout' is no structure of a tiling, which has tile and joint$"):
        finish_tiling(PLAIN, {"tile": "dull", "grout": "wet"})
    with pytest.raises(InputError, match=r"^'shiny' is no finish; give one of dull, satin, varnish, wet, mirror$"):
        finish_tiling(PLAIN, {"joint": "shiny"})
    with pytest.raises(InputError, match="is no finish"):
        find_finish("")
    with pytest.raises(InputError, match="'tile' is no structure of a wood, which has early"):
        check_structures({"tile": "dull"}, ("early",), "a wood")
