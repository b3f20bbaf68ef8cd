"""`jaxtex field` and `jaxtex texton-mask` from the words typed to the files written."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from jaxtex.cli.main import main
from jaxtex.io.images import read_image, write_image
from jaxtex.progressive import texton_masks
from jaxtex.progressive.key_files import make_field, read_keys

KEYS = """
[[scale]]
at = [0.1, 0.5]
value = 0.5

[[scale]]
at = [0.9, 0.5]
value = 2

[[orientation]]
stroke = [[0.1, 0.9], [0.9, 0.2]]
"""


def spots() -> np.ndarray:
    row, column = np.indices((96, 128)) % 32 - 16
    return np.where(np.hypot(row, column) < 10, 1, 0).astype(np.uint8)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("keys.toml").write_text(KEYS)
    write_image("hide.png", np.array([[0.5, 0.4, 0.2], [0.05, 0.03, 0.02]])[spots()])
    return tmp_path


@pytest.mark.parametrize("kind", ["scale", "orientation"])
def test_the_field_is_the_library_s(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["field", "keys.toml", "-o", "field.exr", "--kind", kind, "--over", "hide.png", "--preview", "look.png"]
    assert main(words) == 0
    expected = make_field(read_keys("keys.toml"), kind, (128, 96))  # type: ignore[arg-type]
    written = read_image("field.exr").pixels
    assert np.array_equal(written[..., 0] if kind == "scale" else written[..., :2], expected)
    assert written.shape[2] == (1 if kind == "scale" else 3)
    assert read_image("look.png").pixels.shape == (384, 512, 3)
    assert capsys.readouterr().out.startswith(f"field.exr: {kind}, 128 x 96")


@pytest.mark.parametrize(("value", "told"), [(16, False), (17, True), (0.125, False), (0.11, True)])
def test_scales_at_which_nothing_is_made_are_told(value: float, told: bool, capsys: pytest.CaptureFixture[str]) -> None:
    Path("keys.toml").write_text(f"[[scale]]\nat = [0, 0]\nvalue = 1\n[[scale]]\nat = [1, 1]\nvalue = {value}\n")
    assert main(["field", "keys.toml", "-o", "f.exr", "--size", "64x64"]) == 0
    hint = capsys.readouterr().err
    assert ("takes scales from 0.125 to 16 alone; change the values in keys.toml\n" in hint) == told
    assert hint.count("\n") == told


def test_written_orientations_are_read_as_a_map() -> None:
    assert main(["field", "keys.toml", "-o", "flow.exr", "--kind", "orientation", "--size", "40x30"]) == 0
    Path("map.toml").write_text('[[orientation]]\nmap = "flow.exr"\n')
    assert main(["field", "map.toml", "-o", "again.exr", "--size", "40x30"]) == 0
    assert np.allclose(read_image("flow.exr").pixels, read_image("again.exr").pixels, atol=1e-6)


FIELDS = [
    (["keys.toml", "-o", "f.exr", "--size", "8x8"], "keys.toml: has keys of scale and orientation; name the field"),
    (["keys.toml", "-o", "f.exr", "--size", "8x8", "--kind", "transition"], "keys.toml: transition: has no keys"),
    (["keys.toml", "-o", "f.exr", "--kind", "scale"], "--size: not given"),
    (["keys.toml", "-o", "f.png", "--kind", "scale", "--size", "8x8"], "f.png: a field is written as .exr"),
    (["no.toml", "-o", "f.exr", "--size", "8x8"], "no.toml: there is no such file"),
    (["keys.toml", "-o", "f.exr", "--kind", "scale", "--size", "8"], "--size: '8' is no size"),
    (["keys.toml", "-o", "f.exr", "--kind", "scale", "--size", "8x8", "--over", "hide.png"], "hide.png is 128 x 96"),
    (
        ["keys.toml", "-o", "f.exr", "--kind", "scale", "--size", "8x8", "--preview", "f.exr"],
        "f.exr: would be written over",
    ),
    (["keys.toml", "-o", "f.exr", "--kind", "scale", "--size", "8x8", "--preview", "no/l.png"], "no/l.png: cannot be"),
    (["keys.toml", "-o", "f.exr", "--kind", "scael", "--size", "8x8"], "--kind"),
    (["keys.toml", "-o", "f.exr", "--kind", "scale", "--size", "900000x900000"], "error: --size: 900000x900000 takes"),
    (["keys.toml", "-o", "f.exr", "--kind", "scale", "--size", "8x8", "--preview", "l.gif"], "l.gif: cannot be"),
]


@pytest.mark.parametrize(("words", "told"), FIELDS)
def test_fields_that_cannot_be_made_leave_nothing(
    words: list[str], told: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["field", *words]) == 2
    complaint = capsys.readouterr().err
    assert told in complaint
    assert complaint.count("\n") == 1
    assert sorted(path.name for path in folder.iterdir()) == ["hide.png", "keys.toml"]


def test_elements_are_picked_proposed_or_painted(capsys: pytest.CaptureFixture[str]) -> None:
    texton_masks.write_texton_mask("painted.png", spots())
    for words in (["--pick", "16.5,16.5:20", "--smoothing", "0"], [], ["--painted", "painted.png"]):
        assert main(["texton-mask", "hide.png", "-o", "mask.png", "--overlay", "look.png", *words]) == 0
        assert capsys.readouterr().err == ""
        mask = texton_masks.read_texton_mask("mask.png", (128, 96))
        assert (mask == spots()).mean() > 0.96
        assert read_image("look.png").pixels.shape == (96, 128, 3)
    assert main(["texton-mask", "hide.png", "-o", "mask.png", "--painted", "painted.png"]) == 0
    assert capsys.readouterr().out.endswith(f"{spots().mean():.0%} of type 1, {1 - spots().mean():.0%} none\n")


def test_help_tells_how_pebbles_are_marked(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["texton-mask", "--help"]) == 0
    shown = " ".join(re.sub(r"[^\w:.,-]+", " ", capsys.readouterr().out).split())
    recipe = "--pick X,Y:30 --smoothing 0.7 --invert --open 1.5"
    assert recipe in shown
    words = recipe.replace("X,Y", "100.5,90.5").split()
    assert main(["texton-mask", "hide.png", "-o", "mask.png", *words]) == 0
    assert texton_masks.read_texton_mask("mask.png")[90, 100] == 0


@pytest.mark.parametrize(
    ("pixels", "told"),
    [
        (np.eye(5), "small.png: picture of 5 x 5 pixels: is too small"),
        (np.ones((32, 32)), "small.png: picture: is all"),
    ],
)
def test_pictures_without_elements_are_named(pixels: np.ndarray, told: str, capsys: pytest.CaptureFixture[str]) -> None:
    write_image("small.png", pixels)
    assert main(["texton-mask", "small.png", "-o", "mask.png"]) == 2
    assert told in capsys.readouterr().err


@pytest.mark.parametrize("nearly_all", [False, True])
def test_a_mask_that_marks_nearly_all_is_told(nearly_all: bool, capsys: pytest.CaptureFixture[str]) -> None:
    mask = spots()
    mask[1:] |= nearly_all
    texton_masks.write_texton_mask("painted.png", mask)
    assert main(["texton-mask", "hide.png", "--painted", "painted.png", "-o", "mask.png"]) == 0
    assert capsys.readouterr().err.count("nearly all of it is of one type") == nearly_all


def test_picks_have_types() -> None:
    words = ["--pick", "16,16:20:2", "--pick", "0,0:20:1", "--smoothing", "0"]
    assert main(["texton-mask", "hide.png", "-o", "mask.png", *words]) == 0
    # Nothing is left over: what the file holds are the types' places among those it has.
    assert np.array_equal(texton_masks.read_texton_mask("mask.png") > 1, spots() == 1)


@pytest.mark.parametrize(
    ("option", "value", "refine"),
    [
        ("open", 4.5, lambda mask: texton_masks.refine_texton_mask(mask, "open", 4.5)),
        ("close", 4.0, lambda mask: texton_masks.refine_texton_mask(mask, "close", 4.0)),
        ("dilate", 2.0, lambda mask: texton_masks.refine_texton_mask(mask, "dilate", 2.0)),
        ("erode", 3.0, lambda mask: texton_masks.refine_texton_mask(mask, "erode", 3.0)),
        ("despeckle", 200, lambda mask: texton_masks.despeckle_texton_mask(mask, 200)),
    ],
)
def test_masks_are_refined_as_by_the_library(
    option: str, value: float, refine: Callable[[np.ndarray], np.ndarray]
) -> None:
    texton_masks.write_texton_mask("painted.png", spots())
    words = ["texton-mask", "hide.png", "--painted", "painted.png", "-o", "mask.png"]
    assert main([*words, f"--{option}", f"{value:g}"]) == 0
    assert np.array_equal(texton_masks.read_texton_mask("mask.png"), refine(spots()))
    assert main([*words, "--invert"]) == 0
    assert np.array_equal(texton_masks.read_texton_mask("mask.png"), 1 - spots())


MASKS = [
    (["--pick", "16"], "--pick: '16' is no point"),
    (["--pick", "16,16:x"], "--pick: '16,16:x' is no pick; write x,y:tolerance:type"),
    (["--pick", "16,16:5:4"], "is no pick"),
    (["--pick", "500,16:5"], "--pick: '500,16:5': points: (500, 16) lies outside the picture"),
    (["--pick", "16,16:0"], "--pick: pick 1: tolerance 0"),
    (["--despeckle", "-2"], "--despeckle: area: -2 is out of range"),
    (["--open", "nan"], "--open: radius: nan is out of range"),
    (["--overlay", "look.gif"], "look.gif: cannot be written as '.gif'"),
    (["--pick", "16,16:-5"], "tolerance -5 is out of range"),
    (["--pick", "16,16:5", "--painted", "hide.png"], "--painted does not go with --pick"),
    (["--painted", "hide.png"], "hide.png: is coloured"),
    (["--smoothing", "-1", "--pick", "16,16"], "--smoothing: -1 is out of range; give 0 to 100 pixels"),
    (["--erode", "-1"], "--erode: radius: -1 is out of range"),
    (["--overlay", "mask.png"], "mask.png: would be written over"),
    (["--overlay", "hide.png"], "hide.png: would be written over"),
    (["--erode", "99"], "all of it would be of one type"),
]


@pytest.mark.parametrize(("words", "told"), MASKS)
def test_masks_that_cannot_be_made_leave_nothing(
    words: list[str], told: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["texton-mask", "hide.png", "-o", "mask.png", *words]) == 2
    complaint = capsys.readouterr().err
    assert told in complaint
    assert complaint.count("\n") == 1
    assert sorted(path.name for path in folder.iterdir()) == ["hide.png", "keys.toml"]
