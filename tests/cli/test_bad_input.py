"""What cannot be used: one line that says what, where and what to do; status 2; nothing written."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import OpenImageIO as oiio
import pytest

from jaxtex.cli.main import main


class Bad(NamedTuple):
    """One command line that cannot be used, and words that the complaint must hold.

    ``{photo}`` and the like stand for the files that `files` makes; without ``-o`` in the words, `-o out` is added.
    """

    name: str
    words: str
    told: tuple[str, ...]


PHOTO = "fit tiling {photo}"
PLANK = "fit wood {photo}"
BAD = [
    # the photograph
    Bad("missing photograph", "fit tiling nowhere.png", ("nowhere.png", "no such file")),
    Bad("empty photograph", "fit tiling {empty}", ("empty.png", "empty (0 bytes)")),
    Bad("photograph without pixels", "fit tiling {zero}", ("zero.png",)),
    Bad("damaged photograph", "fit tiling {damaged}", ("damaged.png",)),
    Bad("truncated photograph", "fit tiling {truncated}", ("truncated.jpg",)),
    Bad("text for a photograph", "fit tiling {text}", ("text.png",)),
    Bad("folder for a photograph", "fit tiling {folder}", ("folder", "is a folder; name a file")),
    Bad("NaN in the photograph", "fit tiling {nan}", ("nan.exr", "NaN or infinite")),
    Bad("channels that are no colours", "fit tiling {channels}", ("channels.exr", "channels")),
    Bad("photograph too small", "fit tiling {small}", ("20 x 20 pixels", "32 x 32 at least")),
    # the mask
    Bad("missing mask", f"{PHOTO} --mask nowhere.png", ("nowhere.png", "no such file")),
    Bad("mask of another size", f"{PHOTO} --mask {{small}}", ("mask", "(20, 20)", "(48, 64)")),
    Bad("constant mask", f"{PHOTO} --mask {{white}}", ("mask", "the same everywhere", "1 on tiles and 0 on joints")),
    Bad("coloured mask", f"{PHOTO} --mask {{coloured}}", ("coloured.png", "coloured")),
    # parameters
    Bad("unknown parameter", f"{PHOTO} --fix wdith=5", ("wdith", "tile_width")),
    Bad("no number", f"{PHOTO} --fix angle_deg=flat", ("--fix", "angle_deg=flat", "name=number")),
    Bad("no assignment", f"{PHOTO} --init tile_width", ("--init", "tile_width", "name=number")),
    Bad("infinite value", f"{PHOTO} --init tile_width=1e999", ("tile_width", "not a finite number")),
    Bad("value out of range", f"{PHOTO} --fix tile_height=-3", ("tile_height=-3", "at least 4")),
    Bad("negative joint", f"{PHOTO} --fix mortar_x=-1", ("mortar_x=-1", "0 pixels")),
    Bad("fixed twice", f"{PHOTO} --fix offset=0 offset=0.5", ("--fix", "offset", "twice")),
    Bad("fixed and started", f"{PHOTO} --fix offset=0 --init offset=0.5", ("offset", "both")),
    # wood
    Bad("missing photograph of wood", "fit wood nowhere.png", ("nowhere.png", "no such file")),
    Bad("photograph of wood too small", "fit wood {small}", ("20 x 20 pixels", "32 x 32 at least")),
    Bad("wood's mask of another size", f"{PLANK} --mask {{small}}", ("mask", "(20, 20)", "(48, 64)")),
    Bad("unknown parameter of wood", f"{PLANK} --fix tilt=5", ("tilt", "tilt_deg")),
    Bad("tilt out of range", f"{PLANK} --fix tilt_deg=-5", ("tilt_deg", "-5")),
    Bad("pith outside", f"{PLANK} --ellipse-center 99,9", ("(99, 9)", "64 x 48")),
    # other options
    Bad("bad size", f"{PHOTO} --size 100", ("--size", "'100'", "WIDTHxHEIGHT")),
    Bad("size of nothing", f"{PHOTO} --size 0x100", ("--size", "'0x100'")),
    Bad("negative seed", f"{PHOTO} --seed -1", ("--seed", "-1")),
    Bad("seed that is no number", f"{PHOTO} --seed red", ("--seed", "red")),
    Bad("unknown option", f"{PHOTO} --perspectve", ("--perspectve",)),
    Bad("no photograph named", "fit tiling", ("PHOTO", "--help")),
    Bad("unknown kind of model", "fit tyling {photo}", ("tyling", "fit tiling")),
    # where results go
    Bad("output is a file", f"{PHOTO} -o {{text}}", ("text.png", "file; name a folder")),
    Bad("output below a file", f"{PHOTO} -o {{text}}/out", ("text.png", "file; name a folder")),
    Bad("output cannot be made", f"{PHOTO} -o /proc/out", ("/proc/out", "cannot be made")),
    Bad("demo into a file", "demo -o {text}", ("text.png", "file; name a folder")),
    # model files
    Bad("missing model", "render nowhere.json", ("nowhere.json", "no such file")),
    Bad("model that is no JSON", "render {text}", ("text.png", "damaged, or is no JSON")),
    Bad("photograph for a model", "info {photo}", ("photo.png",)),
    Bad("model of another schema", "render {schema}", ("schema.json", "schema is 2", "reads 1")),
    Bad("model of another kind", "info {clay}", ("clay.json", "type is 'clay'", "reads tiling and wood")),
    Bad("model without width", "render {lacking}", ("lacking.json", "tile_width", "missing")),
    Bad("model with a negative joint", "info {negative}", ("negative.json", "mortar_x")),
    Bad("maps too small", "render {model} --size 3x3", ("3 x 3", "too small")),
    Bad("maps too large", "render {model} --size 99999999x2", ("too large", "65536")),
    Bad("bad number of tiles", "render {model} --tiles 3", ("--tiles", "'3'", "COLUMNSxROWS")),
    Bad("maps into a file", "render {model} -o {text}", ("text.png", "file; name a folder")),
    # corners and masks
    Bad("three corners", "rectify {photo} --corners 0,0 9,0 9,9 -o out.png", ("--corners",)),
    Bad("corners in line", "rectify {photo} --corners 0,0 5,0 9,0 5,9 -o out.png", ("in line",)),
    Bad("corner outside", "rectify {photo} --corners 0,0 99,0 9,9 0,9 -o out.png", ("(99, 0)", "outside", "64 x 48")),
    Bad("unknown kind of picture", "mask threshold {photo} -o out.xyz", ("out.xyz", "cannot be written")),
    Bad("click outside", "mask colour {photo} --at 99,9 -o out.png", ("--at: points: (99, 9)", "outside")),
    Bad("nothing clicked", "mask colour {photo} -o out.png", ("nothing is picked", "--at")),
    Bad("negative radius", "mask open {white} --radius -2 -o out.png", ("error: --radius: -2",)),
    Bad("level out of range", "mask threshold {photo} --level 500 -o out.png", ("error: --level: 500",)),
    Bad("nothing but white", "mask sobel {white} -o out.png", ("white.png: picture:", "one single colour")),
]


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Good and bad files by name."""
    folder = tmp_path_factory.mktemp("files")
    random = np.random.default_rng(0)
    paths = _pictures(folder, random)
    (folder / "folder").mkdir()
    paths |= {"folder": folder / "folder"} | _models(folder)
    return paths


def _pictures(folder: Path, random: np.random.Generator) -> dict[str, Path]:
    from jaxtex.io.images import write_image

    def picture(name: str, pixels: np.ndarray) -> Path:
        write_image(folder / name, pixels)
        return folder / name

    def raw(name: str, data: bytes) -> Path:
        (folder / name).write_bytes(data)
        return folder / name

    photo = picture("photo.png", random.random((48, 64, 3)))
    whole = photo.read_bytes()
    jpeg = picture("whole.jpg", random.random((48, 64, 3))).read_bytes()
    return {
        "photo": photo,
        "small": picture("small.png", np.eye(20)),
        "white": picture("white.png", np.ones((48, 64))),
        "coloured": picture("coloured.png", random.random((48, 64, 3))),
        "empty": raw("empty.png", b""),
        # the width in the header is 0
        "zero": raw("zero.png", whole[:16] + bytes(4) + whole[20:]),
        "damaged": raw("damaged.png", whole[:60] + bytes(255 - byte for byte in whole[60:400]) + whole[400:]),
        "truncated": raw("truncated.jpg", jpeg[: len(jpeg) // 3]),
        "text": raw("text.png", b"a shopping list: bricks, mortar, a level\n"),
        "nan": _oiio(folder / "nan.exr", np.full((48, 64, 3), np.nan, np.float32)),
        "channels": _oiio(folder / "channels.exr", np.zeros((48, 64, 2), np.float32), names=("motion.u", "motion.v")),
    }


def _oiio(path: Path, pixels: np.ndarray, names: tuple[str, ...] = ("R", "G", "B")) -> Path:
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], "float")
    spec.channelnames = names
    output = oiio.ImageOutput.create(str(path))
    output.open(str(path), spec)
    assert output.write_image(pixels)
    output.close()
    return path


def _models(folder: Path) -> dict[str, Path]:
    from jaxtex.models.files import SourceImage, TilingFile, save_model
    from jaxtex.models.tiling import make_tiling

    wall = make_tiling(tile_width=24.0, tile_height=12.0, mortar_x=2.0, mortar_y=2.0, offset=0.5)
    report = {"ok": True, "reason": "", "iou": None, "start": None, "standard_errors": {}}
    save_model(folder / "model.json", TilingFile(wall, SourceImage(96, 48, "0" * 64), 4, 4, report))
    text = (folder / "model.json").read_text(encoding="utf-8")

    def changed(name: str, change: Callable[[dict], object]) -> Path:
        document = json.loads(text)
        change(document)
        (folder / f"{name}.json").write_text(json.dumps(document), encoding="utf-8")
        return folder / f"{name}.json"

    return {
        "model": folder / "model.json",
        "schema": changed("schema", lambda document: document.update(schema=2)),
        "clay": changed("clay", lambda document: document.update(type="clay")),
        "lacking": changed("lacking", lambda document: document["parameters"].pop("tile_width")),
        "negative": changed("negative", lambda document: document["parameters"].update(mortar_x=-1)),
    }


@pytest.mark.parametrize("bad", BAD, ids=[bad.name for bad in BAD])
def test_bad_input_is_one_line_and_leaves_nothing(
    bad: Bad,
    files: dict[str, Path],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    before = {path: path.stat().st_mtime_ns for path in files["photo"].parent.rglob("*")}
    words = [word.format(**files) for word in bad.words.split()]
    needs_output = "-o" not in words and words[0] in ("fit", "render", "demo")
    status = main([*words, "-o", "out"] if needs_output else words)
    out, err = capsys.readouterr()
    assert status == 2
    assert out == ""
    assert err.startswith("jaxtex: error: ")
    assert err.endswith("\n")
    assert err.count("\n") == 1
    assert len(err) < 400
    assert [word for word in bad.told if word not in err] == [], err
    assert list(tmp_path.iterdir()) == []
    assert {path: path.stat().st_mtime_ns for path in files["photo"].parent.rglob("*")} == before


def test_there_are_enough_of_them() -> None:
    assert len({bad.words for bad in BAD}) == len(BAD) >= 30


@pytest.mark.slow
def test_maps_too_small_for_what_was_found_leave_nothing(
    wall_photo: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["fit", "tiling", str(wall_photo), "-o", str(tmp_path / "new" / "out"), "--size", "20x20"]) == 2
    assert "size 20 x 20: is too small" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
