"""`jaxtex rectify` from the words typed to the file written."""

from pathlib import Path

import numpy as np
import pytest

from jaxtex.cli.main import main
from jaxtex.io.images import read_image, write_image

CORNERS = ["10,5", "50,8", "48,38", "12,35"]


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    path = tmp_path / "photo.png"
    write_image(path, np.random.default_rng(0).random((45, 60, 3)))
    return path


def test_the_picture_between_the_corners_is_written(photo: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from jaxtex.photo.rectify import rectify

    output = photo.with_name("upright.exr")
    assert main(["rectify", str(photo), "--corners", *CORNERS, "-o", str(output), "--size", "32x24"]) == 0
    expected, _ = rectify(read_image(photo).pixels, [(10, 5), (50, 8), (48, 38), (12, 35)], size=(32, 24))
    assert np.allclose(read_image(output).pixels, expected, atol=1e-3)
    assert capsys.readouterr().out == f"{output}: 32 x 24 pixels\n"


def test_the_order_of_corners_and_options_does_not_matter(photo: Path) -> None:
    outputs = [photo.with_name(f"{k}.png") for k in range(2)]
    assert main(["rectify", str(photo), "--corners", *CORNERS, "-o", str(outputs[0])]) == 0
    assert main(["rectify", "--corners", *CORNERS[::-1], "--output", str(outputs[1]), "--", str(photo)]) == 0
    assert outputs[0].read_bytes() == outputs[1].read_bytes()


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--corners", "0,0", "9,0", "9,9"], "--corners"),
        (["--corners", "0,0", "9,0", "9,9", "0;9"], "--corners: '0;9' is no point"),
        (["--corners", "0,0", "9,0", "9,9", "9,9"], "same point"),
        (["--corners", "0,0", "5,0", "9,0", "5,9"], "in line"),
        (["--corners", "0,0", "90,0", "9,9", "0,9"], "(90, 0) lies outside the photograph, which is 60 x 45"),
        (["--corners", *CORNERS, "--size", "32"], "--size: '32' is no size"),
        (["--corners", *CORNERS, "--size", "99999x3"], "size: 99999 x 3 is out of range"),
        (["--corners", *CORNERS, "-o", "upright.xyz"], "upright.xyz: cannot be written"),
        (["--corners", *CORNERS, "-o", "nowhere/upright.png"], "no folder nowhere"),
        ([], "--corners"),
    ],
)
def test_what_cannot_be_done_is_told_in_one_line(
    photo: Path, options: list[str], told: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(photo.parent)
    output = [] if "-o" in options else ["-o", "upright.png"]
    assert main(["rectify", photo.name, *options, *output]) == 2
    captured = capsys.readouterr()
    assert told in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""
    assert [path.name for path in photo.parent.iterdir()] == [photo.name]


def test_a_missing_photograph_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["rectify", str(tmp_path / "no.png"), "--corners", *CORNERS, "-o", str(tmp_path / "o.png")]) == 2
    assert "no.png: there is no such file" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
