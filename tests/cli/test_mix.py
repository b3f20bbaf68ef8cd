"""`jaxtex mix`: mixtures that render, export and info open, and everything that can be wrong with them."""

import json
import shutil

import numpy as np
import pytest

from jaxtex.cli.main import main
from jaxtex.io.images import read_image, write_image
from jaxtex.io.masks import write_mask
from jaxtex.material.export import MAP_NAMES
from jaxtex.material.measure import measure_appearance
from jaxtex.models.files import SourceImage, TilingFile, save_model
from jaxtex.models.floor_files import FloorFile, PlacedWood
from jaxtex.models.tiling import make_tiling
from jaxtex.models.wood import make_wood
from jaxtex.models.wood_files import WoodFile

REPORT = {"ok": True, "reason": "made by hand", "iou": None, "start": None, "standard_errors": {}}
IMAGE = SourceImage(120, 100, "0" * 64)
WALL = {"tile_width": 40.0, "tile_height": 20.0, "mortar_x": 4.0, "mortar_y": 3.0, "offset": 0.5}


@pytest.fixture(autouse=True)
def cache(monkeypatch, tmp_path_factory):
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", str(tmp_path_factory.getbasetemp() / "xla"))


@pytest.fixture(scope="module")
def parts(tmp_path_factory):
    """A folder of models, masks and photographs."""
    folder = tmp_path_factory.mktemp("parts")
    random = np.random.default_rng(0)
    photo = random.uniform(0.2, 0.6, (100, 120, 3)).astype(np.float32)
    write_image(folder / "wall.png", photo)
    write_image(folder / "small.png", photo[:50])

    def save(name, wall, image=IMAGE, report=REPORT, **options):
        appearance = measure_appearance(photo, wall).to_json()
        save_model(folder / name, TilingFile(wall, image, 5, 3, report, appearance=appearance, **options))

    save("wall.json", make_tiling(**WALL), mm_per_px=2.0)
    save("tiles.json", make_tiling(tile_width=25.0, tile_height=25.0, mortar_x=2.0, mortar_y=2.0))
    save("measured.json", make_tiling(**WALL), mm_per_px=4.0)
    save("doubtful.json", make_tiling(**WALL), report={**REPORT, "ok": False, "reason": "too dark"})
    oak = make_wood(ring_spacing=9.0, center=(20.0, 3.0), tilt=0.3)
    save_model(folder / "oak.json", WoodFile(oak, IMAGE, {}, REPORT))
    corners = np.array([[0.0, 0], [60, 0], [60, 100], [0, 100]])
    planks = (PlacedWood(corners, oak, True), PlacedWood(corners + np.array([60, 0]), oak, False))
    save_model(folder / "planks.json", FloorFile(planks, IMAGE, REPORT))
    low = np.zeros((100, 120))
    low[60:] = 1
    masks = {"low": low, "white": np.ones((100, 120)), "black": np.zeros((100, 120)), "wide": np.ones((3, 7))}
    for name, mask in masks.items():
        write_mask(folder / f"{name}-mask.png", mask)
    (folder / "text.json").write_text("bricks, mortar, a level")
    return folder


@pytest.fixture
def here(parts, tmp_path, monkeypatch):
    shutil.copytree(parts, tmp_path / "parts")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def mix(*words, output="mix.json"):
    assert main(["mix", *words, "-o", output]) == 0


def render(model, *options, folder="maps"):
    assert main(["render", model, "-o", folder, *options]) == 0
    return {name: read_image(f"{folder}/{name}", colour_space="data").pixels for name in MAP_NAMES}


def test_wood_in_tiles_repeats_without_a_seam(here, capsys):
    mix("parts/wall.json", "--wood", "parts/oak.json", "--wood-scale", "0.5")
    document = json.loads((here / "mix.json").read_text())
    assert document["wood"] == {"model": "parts/oak.json", "scale": 0.5}
    maps = render("mix.json", "--seamless")
    out = capsys.readouterr().out.splitlines()
    assert out[0] == "mix.json: parts/wall.json with wood in its tiles"
    assert out[1].endswith("maps of 120 x 120 pixels, 3 x 6 tiles of wood")
    plain = render("parts/wall.json", "--seamless", folder="plain")
    np.testing.assert_array_equal(maps["tile_id.exr"], plain["tile_id.exr"])
    on_tiles = plain["height.exr"][..., 0] > 0.999 * plain["height.exr"].max()
    assert np.std(maps["basecolor.png"][on_tiles], axis=0).min() > 0.03
    assert maps["roughness.png"][on_tiles].min() == pytest.approx(0.5, abs=0.01)


def test_layers_and_kept_parts_lie_where_masks_are_white(here):
    layers = ["parts/low-mask.png=parts/tiles.json", "parts/wide-mask.png=parts/planks.json"]
    mix("parts/wall.json", "--layer", *layers[:1], "--keep", "parts/low-mask.png=parts/wall.png")
    maps, wall = render("mix.json"), render("parts/wall.json", folder="wall")
    photo = read_image("parts/wall.png", colour_space="data").pixels
    # The wall's origin is the photograph's corner, and its maps are as large as the photograph.
    for name in MAP_NAMES:
        np.testing.assert_array_equal(maps[name][:60], wall[name][:60], err_msg=name)
    np.testing.assert_allclose(maps["basecolor.png"][61:], photo[61:], atol=2 / 255)
    assert (maps["tile_id.exr"][61:] == -1).all()
    assert maps["height.exr"][61:].min() == maps["height.exr"][61:].max() == wall["height.exr"].max()
    mix("parts/wall.json", "--layer", *layers, output="two.json")
    two, planks = render("two.json"), render_planks()
    np.testing.assert_allclose(two["basecolor.png"], planks, atol=1 / 255)
    ids = np.unique(two["tile_id.exr"])
    assert len(ids) == 2
    assert ids.min() > wall["tile_id.exr"].max()


def render_planks():
    assert main(["render", "parts/planks.json", "-o", "planks"]) == 0
    return read_image("planks/basecolor.png", colour_space="data").pixels


def test_a_layer_behind_a_white_mask_is_the_layer_itself_and_goes_on(here):
    mix("parts/wall.json", "--layer", "parts/white-mask.png=parts/tiles.json")
    mixed = render("mix.json")
    alone = render("parts/tiles.json", "--tiles", "5x4", folder="alone")
    for name in set(MAP_NAMES) - {"height.exr", "tile_id.exr"}:
        np.testing.assert_array_equal(mixed[name], alone[name][:100, :120], err_msg=name)
    lift = mixed["height.exr"] - alone["height.exr"][:100, :120]
    assert np.ptp(lift) < 1e-5  # so that faces lie level
    wall = render("parts/wall.json", folder="wall")
    assert mixed["height.exr"].max() == pytest.approx(wall["height.exr"].max(), abs=1e-5)
    mix("parts/wall.json", "--layer", "parts/white-mask.png=parts/oak.json@2", output="oak.json")
    assert main(["render", "parts/oak.json", "-o", "oak", "--size", "240x200"]) == 0
    oak = read_image("oak/basecolor.png", colour_space="data").pixels
    np.testing.assert_allclose(render("oak.json")["basecolor.png"], oak[50:150, 60:180], atol=0.02)


def test_scales_in_millimetres_and_those_told_are_kept(here):
    mix("parts/wall.json", "--layer", "parts/wide-mask.png=parts/measured.json", output="twice.json")
    mix("parts/wall.json", "--layer", "parts/wide-mask.png=parts/measured.json@0.5", output="once.json")
    wall = render("parts/wall.json", folder="wall")
    np.testing.assert_array_equal(render("once.json")["basecolor.png"], wall["basecolor.png"])
    large = render("parts/wall.json", "--tiles", "2x3", "--size", "160x120", folder="large")
    np.testing.assert_array_equal(render("twice.json")["normal.png"], large["normal.png"][:100, :120])


@pytest.mark.parametrize(("base", "size"), [("oak", (60, 80)), ("planks", (60, 50))])
def test_planks_and_floors_may_lie_below(here, base, size):
    mix(f"parts/{base}.json", "--layer", "parts/low-mask.png=parts/tiles.json")
    shape = f"{size[0]}x{size[1]}"
    mixed = render("mix.json", "--size", shape)
    assert main(["render", f"parts/{base}.json", "-o", "below", "--size", shape]) == 0
    below = read_image("below/basecolor.png", colour_space="data").pixels
    # The mask begins 10 pixels of the photograph below its middle: of the maps, half as many.
    edge = size[1] // 2 + 5
    np.testing.assert_array_equal(mixed["basecolor.png"][: edge - 1], below[: edge - 1])
    assert not np.array_equal(mixed["basecolor.png"][edge:], below[edge:])


def test_a_mixture_moves_with_its_folder_and_is_opened_from_anywhere(here, monkeypatch):
    (here / "mixed").mkdir()
    mix("parts/wall.json", "--layer", "parts/low-mask.png=parts/tiles.json", output="mixed/mix.json")
    document = json.loads((here / "mixed" / "mix.json").read_text())
    assert document["base"] == "../parts/wall.json"
    before = render("mixed/mix.json")
    (here / "elsewhere").mkdir()
    for name in ("parts", "mixed"):
        shutil.move(here / name, here / "elsewhere" / name)
    monkeypatch.chdir(here / "elsewhere" / "parts")
    after = render("../mixed/mix.json", folder="maps")
    np.testing.assert_array_equal(before["basecolor.png"], after["basecolor.png"])


def test_info_says_what_it_is_made_of(here, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    keep = "parts/white-mask.png=parts/wall.png"
    mix(
        "parts/wall.json",
        "--wood",
        "parts/oak.json",
        "--keep",
        keep,
        "--layer",
        "parts/low-mask.png=parts/tiles.json@2",
    )
    capsys.readouterr()
    assert main(["info", "mix.json"]) == 0
    assert capsys.readouterr().out.splitlines()[:-1] == [
        "mix.json: a mixture",
        "base: parts/wall.json",
        "wood in its tiles: parts/oak.json, 1 times as large as photographed",
        "layer where parts/low-mask.png is white: parts/tiles.json, 2 times as large as photographed",
        "kept where parts/white-mask.png is white: parts/wall.png",
    ]


def test_export_tells_of_seams(here, capsys):
    mix("parts/wall.json", "--keep", "parts/low-mask.png=parts/wall.png")
    capsys.readouterr()
    assert main(["export", "mix.json", "-o", "wall.glb", "--repeat", "2x1"]) == 0
    told = capsys.readouterr().out.splitlines()
    assert told[0].startswith("wall.glb: a wall of 0.48 x 0.2 m, textures of 120 x 100 pixels, 3 x 5 tiles and 1 layer")
    assert told[1:] == ["  note: they repeat with a seam, as masks do not repeat"]
    assert (here / "wall.glb").stat().st_size > 1000


def test_fits_that_did_not_succeed_are_told(here, capsys):
    mix("parts/wall.json", "--layer", "parts/low-mask.png=parts/doubtful.json")
    capsys.readouterr()
    render("mix.json")
    assert "note: parts/doubtful.json is a best guess; its fit did not succeed: too dark" in capsys.readouterr().out


BAD = [
    ("wall.json", ["nothing is mixed"]),
    ("nowhere.json --wood oak.json", ["nowhere.json", "no such file"]),
    ("wall.json --wood nowhere.json", ["nowhere.json", "no such file"]),
    ("wall.json --wood tiles.json", ["tiles.json", "no model of wood"]),
    ("oak.json --wood oak.json", ["oak.json", "no tiles"]),
    ("planks.json --wood oak.json", ["planks.json", "no tiles"]),
    ("wall.json --wood oak.json --wood-scale 0", ["--wood-scale", "above 0"]),
    ("wall.json --wood oak.json --wood-scale nan", ["--wood-scale", "above 0"]),
    ("wall.json --wood-scale 2 --keep low-mask.png=wall.png", ["--wood-scale", "no wood"]),
    ("wall.json --wood text.json", ["text.json", "no JSON"]),
    ("wall.json --layer low-mask.png", ["--layer", "MASK=MODEL"]),
    ("wall.json --layer low-mask.png=", ["--layer", "MASK=MODEL"]),
    ("wall.json --keep =wall.png", ["--keep", "MASK=PHOTO"]),
    ("wall.json --layer low-mask.png=tiles.json@-2", ["--layer", "-2", "above 0"]),
    ("wall.json --layer nowhere.png=tiles.json", ["nowhere.png", "no such file"]),
    ("wall.json --layer low-mask.png=nowhere.json", ["nowhere.json", "no such file"]),
    ("wall.json --layer wall.png=tiles.json", ["wall.png", "no mask"]),
    ("wall.json --layer black-mask.png=tiles.json", ["black-mask.png", "black everywhere"]),
    ("wall.json --layer low-mask.png=wall.png", ["wall.png", "no model file"]),
    ("wall.json --keep black-mask.png=wall.png", ["black-mask.png", "black everywhere"]),
    ("wall.json --keep low-mask.png=tiles.json", ["tiles.json"]),
    ("wall.json --keep low-mask.png=small.png", ["small.png", "120 x 50", "120 x 100"]),
    ("wall.json --keep wide-mask.png=wall.png", ["wall.png", "7 x 3", "120 x 100"]),
    ("mixed.json --wood oak.json", ["mixed.json", "is a mixture"]),
    ("wall.json --layer low-mask.png=mixed.json", ["mixed.json", "is a mixture"]),
    ("wall.json --wood oak.json -o wall.json", ["wall.json", "part of the mixture itself"]),
    ("wall.json --wood oak.json -o out.png", ["out.png", ".json"]),
    ("wall.json --wood oak.json -o no/out.json", ["no folder no"]),
]


@pytest.mark.parametrize(("words", "told"), BAD, ids=[words for words, _ in BAD])
def test_what_cannot_be_mixed_is_one_line_and_leaves_nothing(parts, tmp_path, monkeypatch, capsys, words, told):
    shutil.copytree(parts, tmp_path / "parts")
    monkeypatch.chdir(tmp_path / "parts")
    save_mixture_of_all(tmp_path / "parts" / "mixed.json")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*.*") if path.is_file()}
    options = [] if " -o " in words else ["-o", "out.json"]
    complain(capsys, told, "mix", *words.split(), *options)
    assert {path: path.read_bytes() for path in tmp_path.rglob("*.*") if path.is_file()} == before


def save_mixture_of_all(path):
    path.write_text(json.dumps({"schema": 1, "type": "mixture", "base": "mixed.json", "layers": []}))


def complain(capsys, told, *words):
    assert main([*words]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("jaxtex: error: ")
    assert captured.err.count("\n") == 1
    assert [word for word in told if word not in captured.err] == [], captured.err


def test_what_cannot_be_made_of_a_mixture_is_one_line(here, capsys):
    mix("parts/wall.json", "--layer", "parts/low-mask.png=parts/tiles.json")
    mix("parts/oak.json", "--layer", "parts/low-mask.png=parts/tiles.json", output="oak.json")
    save_mixture_of_all(here / "mixed.json")
    capsys.readouterr()
    for words, told in (
        (["mix.json", "--seamless"], ["--seamless", "masks do not repeat"]),
        (["mix.json", "--block", "2x2x2"], ["--block", "a mixture"]),
        (["mix.json", "--size", "9x9"], ["too small"]),
        (["oak.json", "--tiles", "2x2"], ["--tiles", "no tiles"]),
        (["oak.json", "--seamless"], ["--seamless", "no tiles"]),
        (["mixed.json"], ["mixed.json", "is a mixture"]),
    ):
        complain(capsys, told, "render", *words, "-o", "maps")
    (here / "parts" / "tiles.json").unlink()
    complain(capsys, ["parts/tiles.json", "no such file", "mix.json is made of it"], "render", "mix.json", "-o", "maps")
    assert not (here / "maps").exists()
