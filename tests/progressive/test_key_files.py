"""keys.toml: what it says, and what is wrong with it."""

from pathlib import Path

import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.io.images import write_image
from jaxtex.io.masks import write_mask
from jaxtex.progressive.key_files import make_field, read_keys
from jaxtex.progressive.keys import FieldKey


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(text: str) -> Path:
    Path("keys.toml").write_text(text, encoding="utf-8")
    return Path("keys.toml")


def test_keys_are_read_as_they_are_written() -> None:
    keys = read_keys(
        write(
            """symmetric = true
            [[scale]]
            at = [0, 0.5]
            value = 0.5
            [[scale]]
            stroke = [[1, 0], [1, 1]]
            value = 2
            [[orientation]]
            stroke = [[0.2, 0.9], [0.5, 0.1]]
            [[orientation]]
            at = [0.9, 0.9]
            value = 90
            """
        )
    )
    assert keys.scale == (FieldKey(((0.0, 0.5),), 0.5), FieldKey(((1.0, 0.0), (1.0, 1.0)), 2.0))
    assert keys.transition == ()
    assert keys.orientation == (FieldKey(((0.2, 0.9), (0.5, 0.1))), FieldKey(((0.9, 0.9),), np.pi / 2))
    assert keys.symmetric
    scale = make_field(keys, "scale", (40, 20))
    assert scale.shape == (20, 40)
    assert scale[:, -1].min() > 1.9
    with pytest.raises(InputError, match="transition: has no keys"):
        make_field(keys, "transition", (40, 20))


def test_a_field_may_be_painted() -> None:
    grey = np.linspace(0, 1, 12) * np.ones((6, 1))
    write_mask("grey.png", grey)
    keys = read_keys(
        write(
            """[[scale]]
            map = "grey.png"
            low = 0.5
            high = 2
            [[transition]]
            map = "grey.png"
            high = 0.25
            """
        )
    )
    assert np.allclose(make_field(keys, "scale", (12, 6)), 0.5 * 4**grey, rtol=0.01)
    assert np.allclose(make_field(keys, "transition", (12, 6)), 0.25 * grey, atol=0.002)


@pytest.mark.parametrize("coding", ["vectors", "colours", "angles"])
@pytest.mark.parametrize("symmetric", [False, True])
def test_orientations_may_be_painted(coding: str, symmetric: bool) -> None:
    angles = np.linspace(0.1, 3.0, 16) * np.ones((8, 1))
    vectors = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=-1)
    if coding == "vectors":
        write_image("flow.exr", vectors, colour_space="data")
    elif coding == "colours":
        write_image("flow.png", (vectors + 1) / 2, colour_space="data")
    else:
        write_mask("flow.png", angles / (np.pi if symmetric else 2 * np.pi))
    name = "flow.exr" if coding == "vectors" else "flow.png"
    keys = read_keys(write(f'symmetric = {str(symmetric).lower()}\n[[orientation]]\nmap = "{name}"\n'))
    field = make_field(keys, "orientation", (16, 8))
    assert np.sum(field * vectors[..., :2], axis=-1).min() > np.cos(0.03)


WRONG = [
    ("[[scael]]\nat = [0, 0]\n", "keys.toml: scael is not known; did you mean scale?"),
    ("[[scale]]\nat = [0, 0]\nvalu = 2\n", "keys.toml: scale 1: valu is not known; did you mean value?"),
    ("[[scale]]\nat = [0, 0]\n", "scale 1: has no value; give one"),
    ("[[scale]]\nvalue = 2\n", r"scale 1: give one of at = \[x, y\] and stroke"),
    ("[[scale]]\nat = [0, 0]\nstroke = [[0, 0], [1, 1]]\nvalue = 2\n", "scale 1: give one of at"),
    ("[[scale]]\nat = [0.5, 0.5]\nvalue = 1\n[[scale]]\nat = [0, 0]\nvalue = 0\n", "scale 2: value is 0; give more"),
    ("[[transition]]\nat = [0, 0]\nvalue = 2\n", "transition 1: value is 2; give 0 to 1"),
    ("[[transition]]\nat = [120, 40]\nvalue = 1\n", r"transition 1: at: \[120, 40\] is outside of the picture"),
    ("[[transition]]\nat = 3\nvalue = 1\n", r"transition 1: at is 3; give \[x, y\]"),
    ("[[transition]]\nstroke = [[0, 0]]\nvalue = 1\n", "give two places or more"),
    ("[[transition]]\nat = [0, true]\nvalue = 1\n", "at is True; give a number"),
    ("[[transition]]\nat = [0, 0]\nvalue = 'x'\n", "value is 'x'; give a number"),
    ("[[orientation]]\nat = [0, 0]\n", "orientation 1: has no value"),
    ("[scale]\nat = [0, 0]\n", r"scale: write \[\[scale\]\] above each key"),
    ("symmetric = 1\n", "symmetric is 1; give true or false"),
    ("[[scale]\n", "is no TOML"),
    ("[[scale]]\nmap = 'none.png'\nlow = 1\n", "scale 1: none.png: there is no such file"),
    ("[[scale]]\nmap = 'none.png'\n", "scale 1: low is 0; give more than 0"),
    ("[[scale]]\nmap = 3\n", "scale 1: map is 3; give the name of a picture"),
    ("[[scale]]\nmap = 'a.png'\nat = [0, 0]\n", "at does not go with this map"),
    ("[[scale]]\nat = [0, 0]\nvalue = 1\nlow = 2\n", "low goes with a map alone"),
    ("[[scale]]\nmap = 'a.png'\n[[scale]]\nmap = 'b.png'\n", "leave out the others"),
    ("[[orientation]]\nmap = 'a.png'\nlow = 0\n", "low does not go with this map"),
]


@pytest.mark.parametrize(("text", "told"), WRONG)
def test_what_is_wrong_is_said_in_one_line(text: str, told: str) -> None:
    with pytest.raises(InputError, match=told) as complaint:
        read_keys(write(text))
    assert "\n" not in str(complaint.value)
    assert str(complaint.value).startswith("keys.toml: ")


def test_what_is_no_text_is_told() -> None:
    Path("keys.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="is not a text file"):
        read_keys("keys.toml")
