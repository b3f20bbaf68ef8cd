"""`jaxtex solid`: views in, a block of voxels out."""

from pathlib import Path

import numpy as np
import pytest

from jaxtex.cli.main import main
from jaxtex.io.images import read_image, write_image


def solid(*words: object) -> int:
    return main(["solid", *map(str, words)])


@pytest.fixture
def view(tmp_path: Path) -> Path:
    write_image(tmp_path / "view.png", np.random.default_rng(0).uniform(0.1, 0.6, (24, 30, 3)))
    return tmp_path / "view.png"


def test_one_picture_stands_for_all_views(view: Path, capsys: pytest.CaptureFixture[str]) -> None:
    block, preview = view.with_name("block.npz"), view.with_name("preview.png")
    assert solid("--xy", view, "-n", 16, "-o", block, "--iterations", 2, "--preview", preview) == 0
    voxels = np.load(block)["voxels"]
    assert voxels.shape == (16, 16, 16, 3)
    assert voxels.dtype == np.float32
    pixels = read_image(view).pixels
    np.testing.assert_allclose(voxels.mean(axis=(0, 1, 2)), pixels.mean(axis=(0, 1)), atol=0.03)
    assert voxels.min() >= pixels.min() - 1e-3
    shown = read_image(preview).pixels
    assert shown.shape == (16, 48, 3)
    np.testing.assert_allclose(shown[:, :16], voxels[8], atol=0.02)
    np.testing.assert_allclose(shown[:, 16:32], voxels[:, 8], atol=0.02)
    np.testing.assert_allclose(shown[:, 32:], voxels[:, :, 8], atol=0.02)
    told = capsys.readouterr().out
    assert f"{block}: a block of 16 x 16 x 16 voxels, tileable\n" in told
    assert "histograms" not in told


@pytest.mark.parametrize(
    ("kind", "files", "told"),
    [
        ("exr", [f"block.{z:04}.exr" for z in range(12)], "slices across z: block.0000.exr to block.0011.exr\n"),
        ("raw", ["block.nhdr", "block.raw"], "[z, y, x, channel] = [12, 12, 12, 3] in C order\n  block.nhdr says so"),
        ("vol", ["block.vol"], ""),
    ],
)
def test_other_programs_get_the_same_block(
    view: Path, kind: str, files: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    for suffix in ("npz", kind):
        assert solid("--xy", view, "-n", 12, "-o", view.with_name(f"block.{suffix}"), "--iterations", 1) == 0
    assert told in capsys.readouterr().out
    voxels = np.load(view.with_name("block.npz"))["voxels"]
    assert sorted(path.name for path in view.parent.glob("block.*")) == sorted([*files, "block.npz"])
    if kind == "exr":
        read = np.stack([read_image(view.with_name(name)).pixels for name in files])
    else:
        data = view.with_name(files[-1]).read_bytes()
        read = np.frombuffer(data[-4 * voxels.size :], "<f4").reshape(voxels.shape)
    np.testing.assert_allclose(read, voxels, atol=5e-4 if kind == "exr" else 0)


def test_smaller_pictures_show_more(view: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What is finer than the pixels of the smaller picture is gone; a block that shows little of a picture says so."""
    write_image(view, np.random.default_rng(0).uniform(0.1, 0.6, (48, 60, 3)))
    blocks = [view.with_name(name) for name in ("one.npz", "other.npz")]
    words = ["-n", 12, "--method", "relaxation", "--iterations", 1]
    for block, factor in zip(blocks, (1, 2), strict=True):
        assert solid("--xy", view, "-o", block, "--shrink", factor, *words) == 0
    spread, smaller = (np.load(block)["voxels"].std() for block in blocks)
    assert smaller < 0.6 * spread
    first, second = capsys.readouterr().out.split(f"{blocks[1]}:")
    assert "shows 12 x 12 pixels of 60 x 48; with --shrink 2 it shows more" in first
    assert "shows 12 x 12 pixels of 30 x 24" in second


def test_pictures_that_differ_are_told(view: Path, capsys: pytest.CaptureFixture[str]) -> None:
    dark, block = view.with_name("dark.png"), view.with_name("block.npz")
    write_image(dark, 0.3 * read_image(view).pixels.mean(axis=2, keepdims=True))
    for words, told in (([], "moved to one between them"), (["--histogram", "own"], "left as they are")):
        assert solid("--xy", view, "--yz", dark, "-n", 12, "-o", block, *words, "--iterations", 1) == 0
        assert told in capsys.readouterr().out


def test_one_hue_is_told_by_one_channel(view: Path) -> None:
    light = np.random.default_rng(0).uniform(0.1, 0.6, (24, 30, 1))
    write_image(view, np.concatenate([light, light**2, np.zeros_like(light)], axis=2))
    block, preview = view.with_name("block.npz"), view.with_name("preview.png")
    words = ["--colours", "single-hue", "--iterations", 1, "--preview", preview]
    assert solid("--xy", view, "-n", 16, "-o", block, *words) == 0
    red, green, blue = np.moveaxis(np.load(block)["voxels"], -1, 0)
    np.testing.assert_allclose(green, red**2, atol=0.01)
    np.testing.assert_allclose(blue, 0, atol=1e-6)
    assert read_image(preview).pixels.shape == (16, 48, 3)


def test_the_same_seed_makes_the_same_file(view: Path) -> None:
    files = [view.with_name(f"{number}.npz") for number in range(3)]
    for file, seed in zip(files, (0, 0, 1), strict=True):
        assert solid("--xz", view, "-n", 13, "-o", file, "--iterations", 1, "--seed", seed) == 0
    first, second, other = (file.read_bytes() for file in files)
    assert first == second != other


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ([], "--xy: give a picture"),
        (["--xy", "no.png"], "no.png: there is no such file"),
        (["--xy", "view.png", "-n", "25"], "view xy of 30 x 24 pixels: its crops of 25 x 25"),
        (["--xy", "view.png", "-n", "7"], "--side: 7 is out of range"),
        (["--xy", "view.png", "-n", "16", "--iterations", "0"], "--iterations: 0 is out of range"),
        (["--xy", "view.png", "-n", "16", "-o", "block.png"], "block.png: cannot be written as '.png'; name it .npz"),
        (["--xy", "view.png", "-n", "16", "-o", "block.vdb"], "'.vdb'; name it .npz, .exr, .raw, .vol"),
        (["--xy", "view.png", "-n", "16", "-o", "none/block.npz"], "there is no folder none"),
        (["--xy", "view.png", "-n", "16", "--preview", "view.png"], "--preview: view.png would be written over"),
        (["--xy", "view.png", "--xz", "flat.png", "-n", "16"], "view xz: is all of one colour"),
        (["--xy", "large.png", "-n", "16"], "--xy: large.png has 3000 x 1500 pixels"),
        (["--xy", "clear.png", "-n", "16"], "--xy: clear.png is transparent in places"),
    ],
)
def test_what_cannot_be_done_is_told_in_one_line(
    view: Path, words: list[str], told: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(view.parent)
    write_image(Path("flat.png"), np.full((24, 24, 3), 0.4))
    write_image(Path("clear.png"), np.random.default_rng(0).random((24, 24, 4)))
    write_image(Path("large.png"), np.zeros((1500, 3000)))
    before = sorted(path.name for path in Path().iterdir())
    output = [] if "-o" in words else ["-o", "block.npz"]
    assert solid(*words, *output) == 2
    error = capsys.readouterr().err
    assert told in error
    assert error.count("\n") == 1
    assert sorted(path.name for path in Path().iterdir()) == before


@pytest.mark.parametrize(
    ("view_name", "output", "preview", "taken"),
    [
        ("oak.0003.exr", "oak.exr", None, "oak.0003.exr"),
        ("oak.0003.exr", "below/../oak.exr", None, "oak.0003.exr"),
        ("view.png", "elm.exr", "elm.0040.exr", "elm.0040.exr"),
        ("view.png", "ash.exr", "below/../ash.0004.exr", "below/../ash.0004.exr"),
        ("view.png", "ash.exr", "below/ash.0004.exr", None),
        ("view.png", "ash.npz", "ash.0004.exr", None),
        ("oak.exr", "oak.exr", None, None),  # of slices, none has that name
    ],
)
def test_pictures_are_no_files_of_the_block(
    view: Path,
    view_name: str,
    output: str,
    preview: str | None,
    taken: str | None,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(view.parent)
    Path("below").mkdir()
    if view_name != view.name:
        write_image(Path(view_name), read_image(view).pixels)
    before = Path(view_name).read_bytes()
    words = ["--xy", view_name, "-o", output, *(["--preview", preview] if preview else [])]
    assert solid(*words, "-n", 16, "--iterations", 1, "--method", "relaxation") == (2 if taken else 0)
    assert Path(view_name).read_bytes() == before
    if taken:
        error = f"--output: {taken} would be one of the files of {output}; give another name\n"
        assert capsys.readouterr().err.endswith(error)
        assert not [path for path in Path().iterdir() if path.name not in (view.name, view_name, "below")]


@pytest.mark.parametrize(
    ("words", "needed"),
    [([], "10.4"), (["--colours", "single-hue"], "7.4"), (["--method", "relaxation"], "6.9")],
)
def test_blocks_beyond_the_memory_are_refused(
    view: Path, words: list[str], needed: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("jaxtex.cli.values._physical_memory", lambda: 2 << 30)
    assert solid("--xy", view, "-n", 512, "-o", view.with_name("block.npz"), *words) == 2
    assert f"--side: 512 takes {needed} GiB of memory, and this machine has 2.0" in capsys.readouterr().err
