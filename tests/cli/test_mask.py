"""`jaxtex mask ...` from the words typed to the files written."""

from pathlib import Path

import numpy as np
import pytest

from jaxtex.cli.main import COMMANDS, main
from jaxtex.io.images import read_image, write_image
from jaxtex.io.masks import read_mask, write_mask
from jaxtex.photo import edges, illumination, morphology, segment

TILE, JOINT = (0.45, 0.2, 0.15), (0.02, 0.025, 0.03)
MAKING = ["threshold", "colour", "sobel", "pyramid"]
CLEANING = ["open", "close", "erode", "dilate", "despeckle"]
NEEDED = {"colour": ["--at", "50.5,10.5"], "despeckle": ["--area", "9"]}


def truth() -> np.ndarray:
    """A running bond of 40 x 20 pixels with joints 4 pixels wide; the frame cuts tiles."""
    rows, columns = np.indices((120, 160)) + 12
    return (rows % 20 >= 4) & ((columns + 20 * (rows // 20)) % 40 >= 4)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a photograph and a mask full of specks, in which commands run."""
    monkeypatch.chdir(tmp_path)
    random = np.random.default_rng(0)
    mask = truth()
    picture = np.where(mask[..., None], TILE, JOINT) * random.uniform(0.9, 1.1, mask.shape)[..., None]
    write_image("wall.png", picture)
    write_mask("specks.png", mask ^ (random.random(mask.shape) < 0.03))
    return tmp_path


def options(tool: str) -> list[str]:
    return NEEDED.get(tool, ["--radius", "1.5"] if tool in CLEANING else [])


def source(tool: str) -> str:
    return "specks.png" if tool in CLEANING else "wall.png"


@pytest.mark.parametrize("tool", MAKING)
def test_every_tool_makes_the_librarys_mask(tool: str) -> None:
    pixels = read_image("wall.png").pixels
    expected = {
        "threshold": lambda: segment.threshold_mask(pixels),
        "colour": lambda: segment.colour_mask(pixels, segment.pick_colours(pixels, [(50.5, 10.5)])),
        "sobel": lambda: edges.sobel_edges(pixels),
        "pyramid": lambda: edges.pyramid_edges(pixels),
    }[tool]()
    assert main(["mask", tool, "wall.png", "-o", "mask.png", *options(tool)]) == 0
    assert np.array_equal(read_mask("mask.png") == 1, expected)


@pytest.mark.parametrize("tool", CLEANING)
def test_every_cleaner_does_what_the_library_does(tool: str) -> None:
    mask = read_mask("specks.png") == 1
    expected = {
        "open": lambda: morphology.open_mask(mask, 1.5),
        "close": lambda: morphology.close_mask(mask, 1.5),
        "erode": lambda: morphology.erode_mask(mask, 1.5),
        "dilate": lambda: morphology.dilate_mask(mask, 1.5),
        "despeckle": lambda: morphology.remove_small_regions(mask, 9),
    }[tool]()
    assert main(["mask", tool, "specks.png", "-o", "specks.png", *options(tool)]) == 0
    assert np.array_equal(read_mask("specks.png") == 1, expected)


def test_options_reach_the_tools() -> None:
    pixels = read_image("wall.png").pixels
    evened = illumination.even_out(pixels)[0]
    runs = [
        ("threshold", ["--level", "60", "--joints", "light"], segment.threshold_mask(pixels, level=60, joints="light")),
        ("threshold", ["--even-out"], segment.threshold_mask(evened)),
        (
            "colour",
            ["--at", "8,8", "20.5,30", "--tolerance", "3", "--picked", "tiles"],
            segment.colour_mask(
                pixels, segment.pick_colours(pixels, [(8, 8), (20.5, 30)]), tolerance=3, picked="tiles"
            ),
        ),
        ("sobel", ["--smooth", "2", "--strength", "3"], edges.sobel_edges(pixels, smooth=2, strength=3)),
        ("pyramid", ["--levels", "1", "--strength", "3"], edges.pyramid_edges(pixels, levels=1, strength=3)),
    ]
    for tool, words, expected in runs:
        assert main(["mask", tool, "wall.png", "-o", "mask.png", *words]) == 0
        assert np.array_equal(read_mask("mask.png") == 1, expected), words


@pytest.mark.parametrize("grey", [False, True])
def test_colours_are_named_as_the_eye_sees_them(grey: bool) -> None:
    mask = truth()
    picture = np.where(mask[..., None], 0.8, 0.2140411) * np.ones(1 if grey else 3)
    write_image("wall.png", picture)
    words = ["--colour", "#808080", "--tolerance", "2"]
    assert main(["mask", "colour", "wall.png", "-o", "mask.png", *words]) == 0
    assert np.array_equal(read_mask("mask.png") == 1, mask)


def test_auto_needs_nothing_said() -> None:
    assert main(["mask", "auto", "wall.png", "-o", "mask.png", "--overlay", "look.png"]) == 0
    assert np.mean((read_mask("mask.png") == 1) == truth()) > 0.9
    assert read_image("look.png").pixels.shape == (120, 160, 3)


@pytest.mark.parametrize("tool", [*MAKING, *CLEANING])
def test_the_overlay_is_laid_over_the_picture(tool: str, folder: Path) -> None:
    words = ["mask", tool, source(tool), "-o", "mask.png", *options(tool), "--overlay", "look.png"]
    assert main(words if tool in MAKING else [*words, "--photo", "wall.png"]) == 0
    inner = morphology.erode_mask(read_mask("mask.png") == 1, 2)
    shown, photo = read_image("look.png").pixels, read_image("wall.png").pixels
    assert np.allclose(shown[inner], photo[inner], atol=1e-3)
    assert not np.allclose(shown, photo, atol=0.1)
    assert sorted(path.name for path in folder.iterdir()) == ["look.png", "mask.png", "specks.png", "wall.png"]


def test_without_a_photograph_the_overlay_shows_what_changed() -> None:
    assert main(["mask", "despeckle", "specks.png", "-o", "mask.png", "--area", "9", "--overlay", "look.png"]) == 0
    before, after = read_mask("specks.png") == 1, read_mask("mask.png") == 1
    filled = ~before & after & morphology.erode_mask(after, 2)
    assert filled.any()
    assert (read_image("look.png").pixels[filled] == 0).all()


def test_the_paper_s_way_from_photograph_to_clean_mask(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["mask", "sobel", "wall.png", "-o", "mask.png"]) == 0
    assert main(["mask", "open", "mask.png", "-o", "mask.png", "--radius", "2.5"]) == 0
    assert main(["mask", "despeckle", "mask.png", "-o", "mask.png", "--area", "20"]) == 0
    mask = read_mask("mask.png") == 1
    inside = morphology.erode_mask(truth(), 2.5)
    assert mask[inside].mean() > 0.98
    assert mask[morphology.erode_mask(~truth(), 1)].mean() < 0.02
    assert capsys.readouterr().out.endswith(f"mask.png: {mask.mean():.0%} tile, {1 - mask.mean():.0%} joint\n")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["threshold", "no.png"], "no.png: there is no such file"),
        (["threshold", "wall.png", "--level", "200"], "level: 200 is out of range"),
        (["threshold", "wall.png", "--joints", "grey"], "--joints"),
        (["threshold", "wall.png", "--overlay", "mask.png"], "give them two names"),
        (["threshold", "wall.png", "--overlay", "look.xyz"], "look.xyz: cannot be written as '.xyz'"),
        (["threshold", "wall.png", "--overlay", "nowhere/look.png"], "nowhere/look.png: cannot be written"),
        (["threshold", "flat.png"], "one single lightness"),
        (["threshold", "black.png", "--even-out"], "more than half of it is black"),
        (["colour", "wall.png"], "error: --at, --colour: nothing is picked; give points x,y or colours rrggbb"),
        (["colour", "wall.png", "--at", "3"], "--at: '3' is no point"),
        (["colour", "wall.png", "--at", "160.5,3"], "(160.5, 3) lies outside the picture, which is 160 x 120"),
        (["colour", "wall.png", "--colour", "blue"], "--colour: 'blue' is no colour"),
        (["colour", "wall.png", "--at", "3,3", "--tolerance", "-1"], "tolerance: -1 is out of range"),
        (["sobel", "wall.png", "--smooth", "-1"], "smooth: -1 is out of range"),
        (["sobel", "flat.png"], "one single colour"),
        (["pyramid", "wall.png", "--levels", "9"], "levels: 9 is out of range; a picture of this size has 0 to 3"),
        (["pyramid", "wall.png", "--strength", "0"], "strength: 0 is out of range"),
        (["open", "specks.png", "--radius", "-2"], "radius: -2 is out of range"),
        (["open", "specks.png"], "--radius"),
        (["close", "wall.png", "--radius", "2"], "wall.png: is coloured and so no mask"),
        (["despeckle", "specks.png", "--area", "20000"], "area: 20000 is out of range; give 0 to 19200 pixels"),
        (["despeckle", "specks.png", "--area", "1.5"], "--area"),
        (
            ["erode", "specks.png", "--radius", "1", "--photo", "flat.png", "--overlay", "look.png"],
            "mask: is 160 x 120 pixels, but its picture 64 x 64",
        ),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_what_cannot_be_done_is_told_in_one_line(
    folder: Path, words: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    write_image("flat.png", np.full((64, 64), 0.3))
    write_image("black.png", np.zeros((64, 64)))
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert main(["mask", *words, "-o", "mask.png"]) == 2
    captured = capsys.readouterr()
    assert told in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_an_older_mask_stays_where_a_new_one_fails(folder: Path) -> None:
    older = (folder / "specks.png").read_bytes()
    assert main(["mask", "threshold", "wall.png", "-o", "specks.png", "--overlay", "look.xyz"]) == 2
    assert (folder / "specks.png").read_bytes() == older


@pytest.mark.parametrize("command", [c for c in COMMANDS if c.words.startswith("mask ")], ids=lambda c: c.words)
def test_help_gives_an_example_that_names_the_command(command, capsys: pytest.CaptureFixture[str]) -> None:  # type: ignore[no-untyped-def]
    assert main([*command.words.split(), "--help"]) == 0
    told = capsys.readouterr().out
    assert f"Example: jaxtex {command.words} " in told
    assert "(default: None)" not in told
