"""`jaxtex vary warp` and `vary blend` from the words typed to the files written."""

from pathlib import Path

import numpy as np
import pytest

from jaxtex.cli.main import main
from jaxtex.cli.vary_blend import VaryBlend
from jaxtex.cli.vary_warp import VaryWarp
from jaxtex.core.errors import InputError
from jaxtex.io.images import read_image, write_image
from jaxtex.io.masks import write_mask
from jaxtex.progressive.texton_masks import read_texton_mask, write_texton_mask
from jaxtex.progressive.varying import read_varying


def spots(apart: int, radius: float) -> np.ndarray:
    return (np.hypot(*(np.indices((48, 64)) % apart - apart / 2)) < radius).astype(np.uint8)


def stripes() -> np.ndarray:
    return np.broadcast_to(np.arange(64) % 16 < 8, (48, 64)).astype(np.uint8)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name, mask, colours in (
        ("stripes", stripes(), [[0.6, 0.3, 0.1], [0.02, 0.02, 0.02]]),
        ("spots", spots(16, 5), [[0.3, 0.6, 0.2], [0.05, 0.02, 0.3]]),
    ):
        grain = np.random.default_rng(0).normal(0, 0.01, (48, 64, 3))
        write_image(f"{name}.png", np.clip(np.array(colours)[mask] + grain, 0, 1))
        write_texton_mask(f"{name}_mask.png", mask)
    return tmp_path


def complain(capsys: pytest.CaptureFixture[str], *words: object) -> str:
    assert main(["vary", *map(str, words)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    return error


def test_stripes_become_thinner_to_the_right(capsys: pytest.CaptureFixture[str]) -> None:
    words = (
        "warp stripes.png stripes_mask.png -o thin.png --grow=-3:1:horizontal --mask-output thin_mask.png --save v.npz"
    )
    assert main(["vary", *words.split()]) == 0
    made, mask, varying = read_image("thin.png").pixels, read_texton_mask("thin_mask.png"), read_varying("v.npz")
    dark = made.mean(axis=2) < 0.15
    assert np.mean(dark == (mask > 0)) > 0.92
    assert mask[:, :16].mean() > 0.4 > 0.25 > mask[:, 48:].mean() > 0
    np.testing.assert_array_equal(varying.mask, mask)
    np.testing.assert_allclose(varying.transition[0], np.linspace(0, 1, 64), atol=1e-6)
    np.testing.assert_allclose(varying.texture, made, atol=0.01)
    assert capsys.readouterr().out.splitlines()[0] == "thin.png: 64 x 48 pixels"


def test_changes_follow_a_picture_one_after_the_other() -> None:
    write_mask("half.png", np.broadcast_to(np.arange(48)[:, None] >= 24, (48, 64)))
    words = ["warp", "spots.png", "spots_mask.png", "-o", "a.png", "--transition", "half.png", "--mask-output", "m.png"]
    assert main(["vary", *words, "--grow=-2", "--grow=0.5:1"]) == 0
    made, before = read_texton_mask("m.png"), spots(16, 5)
    np.testing.assert_array_equal(made[:22], before[:22])
    assert 0 < made[27:].mean() < 0.7 * before[27:].mean()
    assert main(["vary", *words, "--scale", "1.4", "--turn", "30"]) == 0
    assert read_texton_mask("m.png")[32:].mean() > 1.2 * before[32:].mean()


def test_a_mesh_bends_the_mask() -> None:
    mesh = np.zeros((2, 2, 3), np.float32)
    mesh[..., 0] = 8
    write_image("mesh.exr", mesh, colour_space="data")
    write_mask("all.png", np.ones((4, 4)))
    words = "warp stripes.png stripes_mask.png -o bent.png --displace mesh.exr --transition all.png --mask-output m.png"
    assert main(["vary", *words.split()]) == 0
    np.testing.assert_array_equal(read_texton_mask("m.png")[:, :56], stripes()[:, 8:])


def test_more_than_the_exemplar_is_made() -> None:
    words = "warp spots.png spots_mask.png -o more.png --size 100x60 --grow=-2 --mask-output m.png"
    assert main(["vary", *words.split()]) == 0
    mask = read_texton_mask("m.png")
    assert read_image("more.png").pixels.shape == (60, 100, 3)
    assert mask[:, :25].mean() > 1.4 * mask[:, 75:].mean() > 0


def test_one_texture_becomes_another(capsys: pytest.CaptureFixture[str]) -> None:
    words = "blend stripes.png spots.png -o ab.png --masks stripes_mask.png spots_mask.png --size 96x48 --save ab.npz"
    assert main(["vary", *words.split()]) == 0
    assert capsys.readouterr().err == ""  # elements of both are dark, so there is nothing to say
    made, varying = read_image("ab.png").pixels, read_varying("ab.npz")
    assert made.shape == (48, 96, 3)
    left, right = (made[:, part][varying.mask[:, part] == 0].mean(axis=0) for part in (np.s_[:8], np.s_[-8:]))
    np.testing.assert_allclose(left, [0.6, 0.3, 0.1], atol=0.08)
    np.testing.assert_allclose(right, [0.3, 0.6, 0.2], atol=0.08)
    np.testing.assert_allclose(varying.transition[5], np.linspace(0, 1, 96), atol=1e-6)


def test_elements_that_are_dark_in_one_and_light_in_the_other_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    write_image("spots.png", np.where(spots(16, 5), 0.6, 0.1))
    assert main(["vary", *BLEND, "--size", "24x16"]) == 0
    hint = capsys.readouterr().err
    assert hint.count("\n") == 1
    assert "darker than what is around them in stripes.png and lighter in spots.png" in hint
    command = "jaxtex texton-mask stripes.png --painted stripes_mask.png --invert -o stripes_mask_inverted.png"
    assert hint.rstrip().endswith(command)
    assert main(command.split()[1:]) == 0
    np.testing.assert_array_equal(
        read_texton_mask("stripes_mask_inverted.png"), 1 - read_texton_mask("stripes_mask.png")
    )


def test_masks_of_more_types_are_not_to_be_turned_round(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*_: object) -> None:
        raise InputError("stopped")

    monkeypatch.setattr(VaryBlend, "_blend", stop)
    write_image("spots.png", np.where(spots(16, 5), 0.6, 0.1))
    for name in ("stripes", "spots"):
        mask = read_texton_mask(f"{name}_mask.png")
        mask[:2, :2], mask[:2, 2:4] = 2, 0
        write_texton_mask(f"{name}_mask.png", mask)
    assert main(["vary", *BLEND, "--size", "24x16"]) == 2
    assert "so they fade halfway\n" in capsys.readouterr().err


def test_elements_of_very_unequal_size_are_told(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*_: object) -> None:
        raise InputError("stopped")

    monkeypatch.setattr(VaryBlend, "_blend", stop)
    row, column = np.indices((48, 64))
    for radius, told in ((12, False), (15, True)):  # beside 5: 5.8 and 9 times the area
        mask = np.hypot(row - 24, column - 32) < radius
        write_image("large.png", np.where(mask, 0.05, 0.6))
        write_texton_mask("large_mask.png", mask)
        words = [
            "vary",
            "blend",
            "large.png",
            "spots.png",
            "-o",
            "out.png",
            "--masks",
            "large_mask.png",
            "spots_mask.png",
        ]
        assert main(words) == 2
        hint = capsys.readouterr().err.removesuffix("jaxtex: error: stopped\n")
        assert bool(hint) == told
    assert "elements of large_mask.png have some 697 pixels and those of spots_mask.png 69, so" in hint
    assert hint.endswith("large.png to 31% or spots.png to 318%\n")


def test_sizes_are_compared_by_type(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(*_: object) -> None:
        raise InputError("stopped")

    monkeypatch.setattr(VaryBlend, "_blend", stop)
    row, column = np.indices((48, 64))
    disk = np.hypot(row - 24, column - 20) < 15
    speck = np.hypot(row - 24, column - 54) < 4
    write_texton_mask("stripes_mask.png", disk + 2 * speck)
    for mask, told in ((speck + 2 * disk, True), (disk[:, ::-1] + 2 * speck[:, ::-1], False)):
        write_texton_mask("spots_mask.png", mask)
        assert main(["vary", *BLEND]) == 2
        hint = capsys.readouterr().err
        assert ("elements of type 1 of stripes_mask.png have some 697 pixels" in hint) == told
        assert hint.count("pixels") == told


def test_pinholes_are_told(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(*_: object) -> None:
        raise InputError("stopped")

    monkeypatch.setattr(VaryWarp, "_make", stop)
    words = ["vary", "warp", "spots.png", "spots_mask.png", "-o", "out.png", "--grow=-1"]
    assert main(words) == 2
    assert "hint" not in capsys.readouterr().err
    mask = spots(16, 7)
    mask[8, 8] = mask[24, 40] = 0
    write_texton_mask("spots_mask.png", mask)
    assert main(words) == 2
    hint = capsys.readouterr().err.splitlines()[0]
    assert "spots_mask.png has 2 pinholes in its elements" in hint
    command = "jaxtex texton-mask spots.png --painted spots_mask.png --fill -o spots_mask_filled.png"
    assert hint.endswith(command)
    assert main(command.split()[1:]) == 0
    np.testing.assert_array_equal(read_texton_mask("spots_mask_filled.png"), spots(16, 7))


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--grow=-1"], True),
        (["--grow=2"], False),
        (["--grow=1:0"], True),
        (["--grow=-1:0"], False),
        (["--grow=1", "--grow=-1"], True),
        (["--scale", "2"], False),
        (["--grow=0"], False),
    ],
)
def test_pinholes_are_told_where_elements_shrink_alone(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, words: list[str], told: bool
) -> None:
    monkeypatch.setattr(VaryWarp, "_make", lambda *_: None)
    monkeypatch.setattr("jaxtex.cli.varying.write_results", lambda *_, **__: None)
    mask = spots(16, 7)
    mask[8, 8] = 0
    write_texton_mask("spots_mask.png", mask)
    assert main(["vary", "warp", "spots.png", "spots_mask.png", "-o", "out.png", *words]) == 0
    assert ("pinhole" in capsys.readouterr().err) == told


@pytest.mark.parametrize(("pixels", "told"), [("-2", False), ("-6", True)])
def test_elements_that_vanish_are_told(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, pixels: str, told: bool
) -> None:
    nowhere = np.zeros((*spots(16, 7).shape, 2), np.float32)
    monkeypatch.setattr("jaxtex.cli.varying.filter_exemplar", lambda *_: nowhere)
    write_texton_mask("spots_mask.png", spots(16, 5))
    assert main(["vary", "warp", "spots.png", "spots_mask.png", "-o", "out.png", f"--grow={pixels}"]) == 0
    assert ("elements are so narrow that they vanish" in capsys.readouterr().err) == told


@pytest.mark.parametrize("has_small_elements", [False, True])
def test_despeckling_is_recommended_where_it_drops_no_element(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, has_small_elements: bool
) -> None:
    monkeypatch.setattr(VaryWarp, "_make", lambda *_: None)
    monkeypatch.setattr("jaxtex.cli.varying.write_results", lambda *_, **__: None)
    row, column = np.indices((48, 64))
    away = np.hypot(row - 24, column - 24)
    mask = ((away < 22) & (away > 5)).astype(np.uint8)  # a hole that is meant
    mask[24, 36] = 0
    if has_small_elements:
        mask[2:5, 58:62] = 1
    write_texton_mask("spots_mask.png", mask)
    assert main(["vary", "warp", "spots.png", "spots_mask.png", "-o", "out.png", "--grow=-1"]) == 0
    hint = capsys.readouterr().err
    assert hint.count("\n") == 1
    assert ("--despeckle" in hint) == (not has_small_elements)
    if has_small_elements:
        assert hint.endswith("spots_mask.png has 1 pinhole in its elements, of which holes are made\n")
        return
    assert main(hint.partition("as by: jaxtex ")[2].split()) == 0
    mask[24, 36] = 1
    np.testing.assert_array_equal(read_texton_mask("spots_mask_filled.png"), mask)


def test_weights_place_three_textures() -> None:
    thirds = np.arange(64)[None].repeat(48, axis=0) * 3 // 64
    for number in range(3):
        write_mask(f"w{number}.png", thirds == number)
    names = ["spots", "stripes", "spots"]
    words = ["blend", *(f"{each}.png" for each in names), "-o", "abc.png", "--masks"]
    words += [f"{each}_mask.png" for each in names] + ["--weights", "w0.png", "w1.png", "w2.png", "--save", "abc.npz"]
    assert main(["vary", *words]) == 0
    varying = read_varying("abc.npz")
    np.testing.assert_allclose(varying.transition[0, [5, 32, 60]], [0, 0.5, 1], atol=1e-6)
    np.testing.assert_array_equal(varying.mask[:, 24:40], stripes()[:, 24:40])


WARP = ["warp", "stripes.png", "stripes_mask.png", "-o", "out.png"]
BLEND = ["blend", "stripes.png", "spots.png", "-o", "out.png", "--masks", "stripes_mask.png", "spots_mask.png"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (WARP, "--grow"),
        ([*WARP, "--grow=-6:7"], "--grow"),
        ([*WARP, "--grow=-6:3"], "stripes_mask.png has no type 3; it has 0, 1"),
        ([*WARP, "--grow=99"], "stripes_mask.png: only one type would be left"),
        ([*WARP, "--grow=-6:1:sideways"], "--grow"),
        ([*WARP, "--scale", "0"], "--scale"),
        ([*WARP, "--grow=1", "--neighborhood", "8"], "--neighborhood"),
        ([*WARP, "--grow=1", "--transition", "stripes.png"], "stripes.png: is no transition"),
        ([*WARP, "--grow=1", "--transition", "absent.png"], "absent.png"),
        ([*WARP, "--grow=1", "--mask-output", "stripes_mask.png"], "written over"),
        ([*WARP, "--grow=1", "--keys", "maps.toml", "--save", "black.png"], "black.png: would be written over"),
        ([*WARP, "--grow=1", "--size", "8x99"], "--size"),
        ([*WARP, "--grow=1", "--mask-output", "m.gif"], "m.gif: cannot be written"),
        ([*BLEND, "--mask-output", "m.gif"], "m.gif: cannot be written"),
        ([*WARP, "--displace", "stripes_mask.png"], "--displace: stripes_mask.png holds levels, from 0"),
        ([*WARP, "--displace", "one.exr"], "--displace: one.exr has one channel"),
        ([*WARP, "--displace", "long.exr"], "--displace: long.exr is 2 x 90 pixels; give 2 x 2 to the size"),
        (["warp", "stripes.png", "small_mask.png", "-o", "out.png", "--grow=1"], "small_mask.png: is 10 x 20"),
        (["warp", "tiny.png", "tiny_mask.png", "-o", "out.png", "--grow=1"], "tiny.png: is 5 x 5"),
        (["blend", "stripes.png", "-o", "out.png", "--masks", "stripes_mask.png"], "two or more"),
        (BLEND[:-1], "--masks: 1 for 2"),
        ([*BLEND[:-1], "small_mask.png"], "small_mask.png: is 10 x 20"),
        ([*BLEND[:-1], "three_mask.png"], "three_mask.png: has types [0, 1, 2]"),
        ([*BLEND, "--size", "8x8"], "--size"),
        ([*BLEND, "--weights", "stripes_mask.png"], "--weights: 1 for 2"),
        ([*BLEND, "--weights", "black.png", "black.png"], "all black"),
        ([*BLEND, "--weights", "black.png", "black.png", "--transition", "black.png"], "--weights"),
        ([*BLEND, "--transition", "black.png", "--keys", "keys.toml"], "--keys"),
        ([*BLEND, "--keys", "keys.toml"], "no keys of transition"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_line(
    words: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    write_mask("small_mask.png", np.eye(20)[:, :10])
    write_image("one.exr", np.zeros((2, 2)), colour_space="data")
    write_image("long.exr", np.zeros((90, 2, 3)), colour_space="data")
    write_image("tiny.png", np.full((5, 5, 3), 0.5))
    write_mask("tiny_mask.png", np.eye(5))
    write_mask("black.png", np.zeros((4, 4)))
    write_texton_mask("three_mask.png", stripes() + spots(16, 3))
    Path("keys.toml").write_text("[[scale]]\nat = [0.5, 0.5]\nvalue = 2\n")
    Path("maps.toml").write_text("[[transition]]\nmap = 'black.png'\n")
    assert told in complain(capsys, *words)
    assert not Path("out.png").exists()
