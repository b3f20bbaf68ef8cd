"""Compositions as files: what is written comes back, and faults of an edit are told in a line."""

import json
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxtex.core.errors import InputError
from jaxtex.models.envelope import schema_of
from jaxtex.particles.composition import (
    Composition,
    Exemplar,
    check_exemplar,
    identify_exemplar,
    read_composition,
    write_composition,
)
from jaxtex.particles.things import describe_particles

THINGS = Exemplar(64, 48, 3, "0" * 64)
ARRAYS = ("kinds", "particles", "x", "y", "angles", "scales", "gains")


def make(*rows: tuple, **changes: Any) -> Composition:
    """Rows of six numbers, or of seven with gains at the end."""
    columns = list(zip(*rows, strict=True)) if rows else [()] * 6
    values: dict[str, Any] = {"width": 60, "height": 40, "periodic": True, "exemplar": THINGS}
    return Composition(**(values | dict(zip(ARRAYS, columns, strict=False)) | changes))


rows = st.tuples(
    st.integers(0, 5),
    st.integers(0, 900),
    st.floats(-1e4, 1e4),
    st.floats(-1e4, 1e4),
    st.floats(-7, 7),
    st.floats(1e-3, 1e3),
    st.tuples(*[st.floats(0, 100)] * 3),
)


@given(st.lists(rows, max_size=5))
def test_what_is_written_comes_back(tmp_path_factory: pytest.TempPathFactory, placed: list[tuple]) -> None:
    path = tmp_path_factory.mktemp("composition") / "wall.json"
    made = make(*placed, versions={"jaxtex": "0"})
    write_composition(path, made)
    found = read_composition(path)
    for name in ("width", "height", "periodic", "exemplar", "versions"):
        assert getattr(found, name) == getattr(made, name)
    for name in ARRAYS:
        np.testing.assert_allclose(getattr(found, name), getattr(made, name), rtol=0, atol=1e-12)
        assert getattr(found, name).dtype == getattr(made, name).dtype
        assert getattr(found, name).shape == getattr(made, name).shape
    first = path.read_bytes()
    write_composition(path, found)
    assert path.read_bytes() == first
    jsonschema.validate(json.loads(first), schema_of("composition"))


def test_each_placed_particle_has_a_line(tmp_path: Path) -> None:
    write_composition(tmp_path / "wall.json", make((0, 2, 30.5, 20.0, np.pi / 2, 1.0), (0, 1, 3.0, 2.0, 0.0, 1.5)))
    lines = [line.strip() for line in (tmp_path / "wall.json").read_text().splitlines()]
    assert "[0, 2, 30.5, 20.0, 90.0, 1.0, 1.0, 1.0, 1.0]," in lines
    assert '"columns": ["class", "particle", "x", "y", "angle", "scale", "red", "green", "blue"],' in lines


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (
            {"placed": [[0, 1.5, 3, 3, 0, 1, 1, 1, 1]]},
            r"placed\[0\]: particle is 1.5; it must be a whole number from 0",
        ),
        ({"placed": [[-1, 1, 3, 3, 0, 1, 1, 1, 1]]}, r"placed\[0\]: class is -1; it must be a whole number from 0"),
        ({"placed": [[0, 1, 3, 3, 0, 0, 1, 1, 1]]}, r"placed\[0\]: scale is 0; it must be from 0.001 to 1000"),
        ({"placed": [[0, 1, 3, 3, 0, 1]]}, r"placed\[0\] is .*; it must be a list of 9"),
        ({"placed": [[0, 1, "left", 3, 0, 1, 1, 1, 1]]}, r"placed\[0\]\[2\] is \"left\"; it must be a number"),
        ({"placed": [[0, 1, 3, 3, 0, 1, 1, -1, 1]]}, r"placed\[0\]: green is -1; it must be at least 0"),
        ({"size": [0, 4]}, r"size\[0\] is 0; it must be at least 1"),
        ({"columns": ["particle", "class", "x", "y", "angle", "scale"]}, "columns is"),
        ({"periodic": 1}, "periodic is 1; it must be true or false"),
        ({"colour": 1}, "colour is not known"),
        ({"schema": 2}, "schema is 2"),
        ({"type": "tiling"}, "type is 'tiling'"),
    ],
)
def test_faults_are_told_in_one_line(tmp_path: Path, change: dict, complaint: str) -> None:
    path = tmp_path / "wall.json"
    write_composition(path, make((0, 1, 3.0, 3.0, 0.0, 1.0)))
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(InputError, match=complaint) as caught:
        read_composition(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"width": 0}, "at least 1 x 1"),
        ({"x": [1.0, 2.0]}, "kinds of shape"),
        ({"y": [np.nan]}, "y: holds a number"),
        ({"particles": [-1]}, "particles: holds a number"),
        ({"scales": [0.0]}, "scales: holds 0"),
        ({"gains": np.ones((2, 3))}, r"gains of shape \(2, 3\)"),
        ({"gains": [[1.0, -1.0, 1.0]]}, "gains: holds a number"),
    ],
)
def test_what_is_no_composition_is_refused(changes: dict, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        make((0, 1, 3.0, 3.0, 0.0, 1.0), **changes)


def test_another_resolution_keeps_the_picture() -> None:
    made = make((0, 1, 3.0, 5.0, 0.3, 1.0), (0, 2, 59.0, 39.0, 0.0, 2.0))
    large = made.rescaled(2.51)
    assert (large.width, large.height) == (151, 100)
    np.testing.assert_allclose(large.x / 151, made.x / 60)
    np.testing.assert_allclose(large.y / 100, made.y / 40)
    np.testing.assert_allclose(large.scales, [2.51, 5.02])
    np.testing.assert_array_equal(large.angles, made.angles)
    for factor in (0.0, -1.0, np.nan):
        with pytest.raises(ValueError, match="factor is"):
            made.rescaled(factor)


def test_compositions_know_their_particles() -> None:
    labels = np.zeros((20, 30), int)
    labels[2:5, 3:9], labels[10:15, 3:9] = 1, 2
    things = describe_particles(labels, [0, 1])
    there = identify_exemplar(things)
    check_exemplar(make((0, 0, 1.0, 1.0, 0.0, 1.0), (1, 1, 1.0, 1.0, 0.0, 1.0), exemplar=there), things)
    with pytest.raises(InputError, match="made of 3 particles of a picture of 64 x 48"):
        check_exemplar(make(), things)
    with pytest.raises(InputError, match=r"placed\[0\]: class is 1; particle 0 is of class 0"):
        check_exemplar(make((1, 0, 1.0, 1.0, 0.0, 1.0), exemplar=there), things)
    with pytest.raises(InputError, match=r"placed\[0\]: particle is 2; it must be at most 1"):
        check_exemplar(make((0, 2, 1.0, 1.0, 0.0, 1.0), exemplar=there), things)


def test_particles_are_taken_away_and_the_rest_is_kept() -> None:
    gains = [[1.0, 1.0, 1.0], [0.5, 1.0, 1.0], [1.0, 1.0, 2.0]]
    made = make(*((0, number, 3.0 * number, 5.0, 0.1 * number, 1.0) for number in range(3)), gains=gains)
    rest = made.without([0])
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(rest, name), getattr(made, name)[1:])
    np.testing.assert_array_equal(made.without([]).x, made.x)
    np.testing.assert_array_equal(made.select(made.x < 4).particles, [0, 1])
    np.testing.assert_array_equal(made.select([2, 0]).gains, np.array(gains)[[2, 0]])
    assert len(made.select([])) == 0
    assert (rest.width, rest.periodic, rest.exemplar) == (made.width, made.periodic, made.exemplar)


def test_a_particle_is_added_over_the_others() -> None:
    made = make((0, 1, 3.0, 5.0, 0.3, 1.0)).with_particle(1, 2, 7.0, 8.0, angle=0.5, scale=2.0, gain=(1.0, 0.5, 0.0))
    added = [getattr(made, name)[-1].tolist() for name in ARRAYS]
    assert added == [1, 2, 7.0, 8.0, 0.5, 2.0, [1.0, 0.5, 0.0]]
    assert made.kinds.dtype == np.intp
    np.testing.assert_array_equal(made.without([1]).x, [3.0])


@pytest.mark.parametrize(
    ("edit", "complaint"),
    [
        (lambda made: made.without([1]), "give numbers from 0 to 0"),
        (lambda made: made.without([-1]), "give numbers from 0 to 0"),
        (lambda made: made.without([0.5]), "give whole numbers"),
        (lambda made: made.select([True, False]), "give yes or no to each of the 1 placed"),
        (lambda made: made.with_particle(0, 0, 1.0, 1.0, scale=0.0), "scales: holds 0"),
        (lambda made: made.with_particle(0, 0, 1.0, 1.0, gain=(1.0, 1.0)), "match exactly|dimension"),
    ],
)
def test_edits_of_what_is_not_there_are_refused(edit: Any, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        edit(make((0, 1, 3.0, 3.0, 0.0, 1.0)))
