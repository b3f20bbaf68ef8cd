"""Files of controls: what they say is done, and what is wrong with them is told in a line."""

from pathlib import Path

import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.io.masks import write_mask
from jaxtex.particles.control_files import read_controls
from jaxtex.particles.controls import Control, combine_controls

SIZE = (400, 200)
X, Y = np.array([0.0, 100.0, 399.0]), np.array([0.0, 100.0, 199.0])


def read(folder: Path, text: str) -> tuple[Control, ...]:
    path = folder / "controls.toml"
    path.write_text(text)
    return read_controls(path, SIZE)


def test_each_entry_is_read(tmp_path: Path) -> None:
    write_mask(tmp_path / "soft.png", np.array([[0.0, 0.2, 1.0]]))
    write_mask(tmp_path / "sharp.png", np.array([[True, False]]))
    one, two = read(
        tmp_path,
        """
        [[control]]
        classes = [1, 2]
        where = {map = "sharp.png"}
        density = {map = "soft.png", low = 1, high = 2}
        size = {inside = 0.5, outside = 1, centre = [0.25, 0.5], radius = 0.5, softness = 0.1}
        orientation = {from = 0, to = 90, start = [0, 0], end = [0, 1]}
        colour = [1, 0.5, {from = 0, to = 1, start = [0, 0], end = [1, 0]}]
        probability = 0.5
        weights = {3 = 0, 11 = 2.5}
        least_distance = 12
        size_variation = 0.3
        orientation_variation = 180
        [[control]]
        colour = 2
        """,
    )
    assert one.classes == [1, 2]
    assert one.weights == {3: 0.0, 11: 2.5}
    found = combine_controls([one], X, Y)
    np.testing.assert_allclose(found.size, [1, 0.5, 1])
    np.testing.assert_allclose(found.orientation, np.radians([0, 45, 0]), atol=1e-9)
    np.testing.assert_allclose(found.least_distance, [12, 12, 0])
    np.testing.assert_allclose(found.probability, [0.5, 0.5, 1])
    np.testing.assert_allclose(found.orientation_variation, [np.pi, np.pi, 0])
    np.testing.assert_allclose(found.size_variation, [0.3, 0.3, 0])
    np.testing.assert_allclose(found.gains, [[1, 0.5, 0], [1, 0.5, 0.25], [1, 1, 1]])
    # A quarter along three pixels is a quarter of the way from the middle of the first to that of the second.
    assert (one.density(X, Y)[1] - 1) == pytest.approx(0.25 * 0.2, abs=1e-3)
    np.testing.assert_allclose(combine_controls([two], X, Y).gains, 2)


def test_an_empty_file_asks_for_nothing(tmp_path: Path) -> None:
    assert read(tmp_path, "# none yet") == ()
    assert read(tmp_path, "[[control]]") == (Control(),)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("[[contro]]", "contro is not known; did you mean control?"),
        ("[control]", r"control: write \[\[control\]\] above each control"),
        ("[[control]]\n[[control]]\ndensty = 2", "control 2: densty is not known; did you mean density?"),
        ("[[control]]\nxyz = 2", "control 1: xyz is not known; known are classes, colour"),
        ("[[control]]\ndensity = 'much'", "control 1: density: is 'much'; give a number"),
        ("[[control]]\ndensity = true", "control 1: density: is True; give a number"),
        ("[[control]]\nsize = inf", "control 1: size: is inf; give a number"),
        ("[[control]]\nsize = 0", "control 1: size: is 0; give 0.001 to 1000"),
        ("[[control]]\nprobability = 1.5", "control 1: probability: is 1.5; give 0 to 1"),
        ("[[control]]\norientation_variation = 200", "control 1: orientation_variation: is 200; give 0 to 180"),
        ("[[control]]\ncolour = [1, 2]", "control 1: colour: has 2 numbers"),
        ("[[control]]\nclasses = 1", r"control 1: classes: is 1; give a list of numbers of classes"),
        ("[[control]]\nclasses = [true]", r"control 1: classes: is \[True\]; give a list"),
        ("[[control]]\nweights = [1]", r"control 1: weights: is \[1\]; give weights by particles' numbers"),
        ("[[control]]\nweights = {a = 1}", "control 1: weights: a is no number of a particle"),
        ("[[control]]\nweights = {1 = -1}", "control 1: weights: that of particle 1 is -1; give 0 or more"),
        (
            "[[control]]\nsize = {a = 1}",
            r"control 1: size: is a table of no known kind; give one number, or one of \{map",
        ),
        ("[[control]]\nsize = {start = [0, 0], end = [0, 1], from = 1}", "control 1: size: has no to; give one"),
        (
            "[[control]]\nsize = {start = [0, 0], end = [0, 1], from = 1, too = 2}",
            "control 1: size: too is not known; did you mean to",
        ),
        (
            "[[control]]\nsize = {start = [0, 0], end = [0, 1], from = 1, to = -2}",
            "control 1: size: to is -2; give 0.001 to 1000",
        ),
        ("[[control]]\nsize = {start = 0, end = [0, 1], from = 1, to = 2}", r"start is 0; give \[x, y\] in parts"),
        ("[[control]]\nsize = {start = [0, 1], end = [0, 1], from = 1, to = 2}", "start and end are the same place"),
        ("[[control]]\nsize = {centre = [0, 0], radius = 0, inside = 1, outside = 2}", "radius is 0; give more than 0"),
        (
            "[[control]]\nsize = {centre = [0, 0], radius = 1, inside = 1, outside = 2, softness = 3}",
            "softness is 3; give 0 to 1",
        ),
        ("[[control]]\nwhere = {map = 3}", "control 1: where: map is 3; give the name of a picture beside this file"),
        ("[[control]", "is no TOML"),
    ],
)
def test_faults_are_told_in_one_line(tmp_path: Path, text: str, complaint: str) -> None:
    with pytest.raises(InputError, match=complaint) as caught:
        read(tmp_path, text)
    assert str(caught.value).startswith(str(tmp_path / "controls.toml"))
    assert "\n" not in str(caught.value)


def test_files_that_are_not_there_are_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.toml"):
        read_controls(tmp_path / "none.toml", SIZE)
    with pytest.raises(InputError, match=r"control 1: where: .*none\.png"):
        read(tmp_path, '[[control]]\nwhere = {map = "none.png"}')
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="is not a text file"):
        read_controls(tmp_path / "bytes.toml", SIZE)
