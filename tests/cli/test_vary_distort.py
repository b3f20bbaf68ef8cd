"""`jaxtex vary distort` from the words typed to the files written."""

from pathlib import Path

import numpy as np
import pytest

from jaxtex.cli.field_options import read_fields
from jaxtex.cli.main import main
from jaxtex.io.images import read_image, write_image
from jaxtex.io.masks import write_mask
from jaxtex.io.raster import read_raster, writing_raster
from jaxtex.progressive.varying import read_varying
from jaxtex.synthesis.anisometric import sample_sources


@pytest.fixture
def exemplar(tmp_path: Path) -> Path:
    """Vertical stripes of 8 pixels, with some grain."""
    path = tmp_path / "exemplar.png"
    wave = 0.3 + 0.25 * np.sin(2 * np.pi * np.arange(64) / 8)
    write_image(path, wave[None, :, None] + np.random.default_rng(0).normal(0, 0.01, (56, 64, 3)))
    return path


def distort(*words: object) -> int:
    return main(["vary", "distort", *map(str, words)])


def complain(capsys: pytest.CaptureFixture[str], *words: object) -> str:
    assert distort(*words) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    return error


def wave_of(pixels: np.ndarray) -> tuple[float, float]:
    """(cycles per pixel down, to the right) of the strongest wave."""
    window = np.hanning(pixels.shape[0])[:, None] * np.hanning(pixels.shape[1])[None]
    power = np.abs(np.fft.fft2((pixels[..., 0] - pixels[..., 0].mean()) * window, (256, 256)))[:128]
    row, column = np.unravel_index(power.argmax(), power.shape)
    return float(np.fft.fftfreq(256)[row]), float(np.abs(np.fft.fftfreq(256)[column]))


def test_numbers(exemplar: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output, saved = exemplar.with_name("made.png"), exemplar.with_name("made.npz")
    words = ["--size", "70x60", "--scale", "1.5", "--orientation", "90", "--save", saved]
    assert distort(exemplar, "-o", output, *words) == 0
    down, right = wave_of(read_image(output).pixels)
    assert down == pytest.approx(1 / 12, rel=0.1)
    assert right == pytest.approx(0, abs=0.01)
    told = capsys.readouterr().out
    assert told == f"{output}: 70 x 60 pixels\n{saved}: texture, scale and orientation\n"
    varying = read_varying(saved)
    assert varying.texture.shape == (60, 70, 3)
    np.testing.assert_allclose(varying.scale, 1.5)
    np.testing.assert_allclose(varying.orientation, np.broadcast_to([0.0, 1.0], (60, 70, 2)), atol=1e-6)


@pytest.mark.parametrize("option", ["--scale", "--orientation"])
def test_what_repeats_has_fields_that_do(exemplar: Path, capsys: pytest.CaptureFixture[str], option: str) -> None:
    across = np.linspace(0.5, 2, 40)
    channels = [across] if option == "--scale" else [np.cos(across), np.sin(across), 0 * across]
    path = exemplar.with_name("field.exr")
    with writing_raster(path, size=(40, 30), channels=len(channels), kind="float", attributes={}) as write_rows:
        write_rows(np.stack(channels, axis=1)[None].repeat(30, axis=0).astype(np.float32))
    error = complain(capsys, exemplar, "-o", path.with_name("made.png"), "--size", "40x30", option, path, "--tileable")
    assert "left and right borders" in error
    assert "leave --tileable out" in error


def test_maps_and_keys_say_the_same(exemplar: Path) -> None:
    size, way, keys = (exemplar.with_name(name) for name in ("size.exr", "way.exr", "keys.toml"))
    write_image(size, np.full((5, 6), 0.75), colour_space="data")
    write_image(way, np.broadcast_to([1.0, 1.0, 0.0], (4, 4, 3)), colour_space="data")
    keys.write_text("[[scale]]\nat = [0.5, 0.5]\nvalue = 0.75\n[[orientation]]\nat = [0.2, 0.1]\nvalue = 45\n")
    outputs = [exemplar.with_name(f"{number}.png") for number in range(3)]
    given = (["--scale", size, "--orientation", way], ["--keys", keys], ["--scale", "0.75", "--orientation", "45"])
    for output, words in zip(outputs, given, strict=True):
        assert distort(exemplar, "-o", output, "--size", "48x40", *words) == 0
    first, second, third = (read_image(output).pixels for output in outputs)
    np.testing.assert_allclose(first, second, atol=2 / 255)
    np.testing.assert_allclose(first, third, atol=2 / 255)


def test_depth_and_mask_are_kept(exemplar: Path) -> None:
    deep, mask, output, saved = (exemplar.with_name(name) for name in ("deep.png", "mask.png", "made.png", "v.npz"))
    pixels = read_image(exemplar).pixels
    write_image(deep, pixels, bits=16)
    write_mask(mask, pixels[..., 0] > 0.3)
    assert distort(deep, "-o", output, "--texton-mask", mask, "--save", saved, "--tileable") == 0
    assert read_raster(output).numbers.dtype == np.uint16
    varying = read_varying(saved)
    light = varying.texture[..., 0]
    assert light[varying.mask == 1].mean() > light[varying.mask == 0].mean() + 0.2


def test_other_maps_go_along(exemplar: Path, capsys: pytest.CaptureFixture[str]) -> None:
    row, column, output = (exemplar.with_name(name) for name in ("row.png", "column.exr", "made.png"))
    places = np.moveaxis(np.indices((56, 64), np.float32), 0, -1)
    write_image(row, places[..., 0] / 100, colour_space="data", bits=16)
    write_image(column, places[..., 1], colour_space="data")
    assert distort(exemplar, "-o", output, "--size", "48x40", "--scale", "2.5", "--also", row, column) == 0
    made = [exemplar.with_name(name) for name in ("made_row.png", "made_column.exr")]
    assert read_raster(made[0]).numbers.dtype == np.uint16
    from_row, from_column = (read_image(each, colour_space="data").pixels[..., 0] for each in made)
    expected = sample_sources(read_image(exemplar).pixels, np.stack([100 * from_row, from_column], axis=-1))
    np.testing.assert_allclose(read_image(output).pixels, expected, atol=0.01)
    told = [f"{each}: 48 x 40 pixels" for each in (output, *made)]
    assert capsys.readouterr().out.splitlines() == told


@pytest.mark.parametrize("name", ["normal.png", "normal.exr"])
def test_normals_turn_with_things(exemplar: Path, name: str) -> None:
    normals, output = exemplar.with_name(name), exemplar.with_name("made.png")
    towards_right = np.broadcast_to(np.float32([0.8, 0.0, 0.6]), (56, 64, 3))
    signed = normals.suffix == ".exr"
    write_image(normals, towards_right if signed else 0.5 + 0.5 * towards_right, colour_space="data")
    words = ["--size", "24x20", "--orientation", "30", "--normals", normals]
    assert distort(exemplar, "-o", output, *words) == 0
    made = read_image(exemplar.with_name(f"made_{name}"), colour_space="data").pixels
    turned = np.median(made if signed else 2 * made - 1, axis=(0, 1))
    down = np.radians(30)  # clockwise: what looked right looks a little down
    np.testing.assert_allclose(turned, [0.8 * np.cos(down), -0.8 * np.sin(down), 0.6], atol=0.01)


def test_what_is_not_seen_of_other_maps_is_not_mixed_in(exemplar: Path) -> None:
    cover, output = exemplar.with_name("cover.png"), exemplar.with_name("made.png")
    pixels = np.zeros((56, 64, 4), np.float32)
    pixels[:, np.arange(64) % 8 < 4] = 0.5, 0.25, 0.5, 1
    write_image(cover, pixels, colour_space="data")
    assert distort(exemplar, "-o", output, "--size", "24x20", "--scale", "2.5", "--also", cover) == 0
    made = read_raster(exemplar.with_name("made_cover.png")).numbers
    some = (made[..., 3] > 20) & (made[..., 3] < 235)
    assert some.any()
    np.testing.assert_allclose(made[some][:, :3], np.broadcast_to([128, 64, 128], (some.sum(), 3)), atol=2)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--also", "small.png"], "--also: small.png is 9 x 8 pixels, and the exemplar is 64 x 56"),
        (["--normals", "grey.png"], "--normals: grey.png has fewer than three channels"),
        (["--also", "holes.exr"], "--also: holes.exr holds numbers that are NaN or infinite"),
        (["--normals", "grey.png", "--also", "grey.png"], "two maps would be written to made_grey.png"),
        (["--also", "grey.png", "--save", "made_grey.png"], "made_grey.png: would be written over"),
        (["--also", "grey.png", "--texton-mask", "made_grey.png"], "made_grey.png: would be written over"),
    ],
)
def test_maps_that_do_not_go_along(
    exemplar: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, words: list[str], told: str
) -> None:
    monkeypatch.chdir(exemplar.parent)
    write_image("small.png", np.zeros((8, 9)))
    write_image("grey.png", np.zeros((56, 64)))
    with writing_raster("holes.exr", size=(64, 56), channels=1, kind="float", attributes={}) as write_rows:
        write_rows(np.where(np.eye(56, 64) > 0, np.nan, 0).astype(np.float32)[..., None])
    assert told in complain(capsys, "exemplar.png", "-o", "made.png", *words)
    assert not Path("made.png").exists()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--scale", "0"], "--scale: 0 is out of range; give 0.125 to 16"),
        (["--scale", "-1"], "--scale: -1 is out of range"),
        (["--scale", "nan"], "--scale: nan is out of range"),
        (["--scale", "1e400"], "--scale: inf is out of range"),
        (["--scale", "100"], "--scale: 100 is out of range; give 0.125 to 16"),
        (["--scale", "1e300"], "--scale: 1e+300 is out of range; give 0.125 to 16"),
        (["--scale", "large"], "neither a number nor a picture"),
        (["--scale", "none.exr"], "none.exr"),
        (["--orientation", "inf"], "--orientation: inf is no direction"),
        (["--neighborhood", "4"], "--neighborhood: 4 is none"),
        (["--neighborhood", "0"], "--neighborhood: 0 is none"),
        (["--size", "12"], "--size: '12' is no size"),
        (["--seed", "-1"], "--seed: -1 is out of range"),
        (["--texton-mask", "mask.png"], "mask.png"),
    ],
)
def test_bad_words(exemplar: Path, capsys: pytest.CaptureFixture[str], words: list[str], told: str) -> None:
    assert told in complain(capsys, exemplar, "-o", exemplar.with_name("made.png"), *words)
    assert not exemplar.with_name("made.png").exists()


def test_files_that_do_not_go_together(exemplar: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output, other, keys = (exemplar.with_name(name) for name in ("made.png", "other.png", "keys.toml"))
    write_mask(other, np.eye(20))
    assert "20 x 20" in complain(capsys, exemplar, "-o", output, "--texton-mask", other)
    assert "would be written over" in complain(capsys, exemplar, "-o", exemplar)
    numbers = exemplar.with_name("numbers.exr")
    write_image(numbers, np.eye(20), colour_space="data")
    assert "one channel" in complain(capsys, exemplar, "-o", output, "--orientation", numbers)
    keys.write_text("[[transition]]\nat = [0.5, 0.5]\nvalue = 0.75\n")
    assert "no keys of scale or orientation" in complain(capsys, exemplar, "-o", output, "--keys", keys)
    keys.write_text("[[scale]]\nat = [0.5, 0.5]\nvalue = 2\n")
    assert "--scale: " in complain(capsys, exemplar, "-o", output, "--keys", keys, "--scale", "2")
    assert distort(exemplar, "-o", output, "--keys", keys, "--orientation", "20") == 0
    write_image(other, np.random.default_rng(0).random((5, 40, 3)))
    write_image(numbers, np.random.default_rng(0).random((5, 40, 3)), colour_space="data")
    assert "several channels" in complain(capsys, exemplar, "-o", output, "--scale", numbers)
    assert "smaller --neighborhood" in complain(capsys, other, "-o", output)


@pytest.mark.parametrize(
    ("option", "table"),
    [
        ("--scale", 'scale = [{map = "maps/it\\"s.png", low = 0.5, high = 2}]'),
        ("--orientation", 'orientation = [{map = "maps/it\\"s.png"}]'),
    ],
)
def test_levels_of_pictures_are_no_numbers(
    exemplar: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, option: str, table: str
) -> None:
    monkeypatch.chdir(exemplar.parent)
    Path("maps").mkdir()
    name = 'maps/it"s.png'
    write_image(name, np.full((9, 9, 3), 0.4), bits=16)
    error = complain(capsys, "exemplar.png", "-o", "made.png", option, name)
    assert f"{option}: {name} holds levels, from 0 (black) to 1 (white)" in error
    assert error.endswith(f"{table}\n")
    Path("keys.toml").write_text(error.partition("in the folder where you are: ")[2])
    scale, orientation = read_fields(None, None, Path("keys.toml"), (4, 3))
    assert scale.shape == orientation.shape[:2] == (3, 4)


def test_fields_out_of_range_are_told_with_their_file(
    exemplar: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(exemplar.parent)
    words = ["exemplar.png", "-o", "made.png"]
    write_image("size.exr", np.diag([0.0, 1, 2]), colour_space="data")
    assert "--scale: size.exr: scale: a value of the map is 0" in complain(capsys, *words, "--scale", "size.exr")
    write_image("size.exr", np.full((2, 2), 20.0), colour_space="data")
    assert "--scale: size.exr goes from 20 to 20; give" in complain(capsys, *words, "--scale", "size.exr")
    Path("keys.toml").write_text("[[scale]]\nat = [0.5, 0.5]\nvalue = 1e300\n")
    assert "keys.toml: scale goes from inf to inf; give values" in complain(capsys, *words, "--keys", "keys.toml")
    Path("keys.toml").write_text("[[scale]]\nat = [0.5, 0.5]\nvalue = 0.1\n")
    assert "keys.toml: scale goes from 0.1 to 0.1; give" in complain(capsys, *words, "--keys", "keys.toml")
    write_image("way.exr", np.zeros((2, 2, 3)), colour_space="data")
    assert "--orientation: way.exr: orientation: " in complain(capsys, *words, "--orientation", "way.exr")


def test_that_files_cannot_be_written_is_told_before_long_work(
    exemplar: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("jaxtex.synthesis.anisometric.anisometric_steps", lambda *_, **__: pytest.fail("has begun"))
    words = [exemplar, "-o", exemplar.with_name("made.png"), "--save", exemplar.parent / "absent" / "v.npz"]
    assert "there is no folder" in complain(capsys, *words)
