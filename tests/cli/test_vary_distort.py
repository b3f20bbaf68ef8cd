"""`jaxtex vary distort` from the words typed to the files written."""

from pathlib import Path

import numpy as np
import pytest

from jaxtex.cli.main import main
from jaxtex.io.images import read_image, write_image
from jaxtex.io.masks import write_mask
from jaxtex.io.raster import read_raster
from jaxtex.progressive.varying import read_varying


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
    assert told == f"{saved}: texture, scale and orientation\n{output}: 70 x 60 pixels\n"
    varying = read_varying(saved)
    assert varying.texture.shape == (60, 70, 3)
    np.testing.assert_allclose(varying.scale, 1.5)
    np.testing.assert_allclose(varying.orientation, np.broadcast_to([0.0, 1.0], (60, 70, 2)), atol=1e-6)


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


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--scale", "0"], "--scale: 0 is out of range"),
        (["--scale", "-1"], "--scale: -1 is out of range"),
        (["--scale", "nan"], "--scale: nan is out of range"),
        (["--scale", "100"], "give values from 0.125 to 16"),
        (["--scale", "large"], "neither a number nor a picture"),
        (["--scale", "none.exr"], "none.exr"),
        (["--orientation", "inf"], "--orientation: inf is no direction"),
        (["--neighborhood", "4"], "--neighborhood: 4 is none"),
        (["--neighborhood", "0"], "--neighborhood: 0 is none"),
        (["--size", "12"], "--size: '12' is no size"),
        (["--keys", "keys.toml", "--scale", "2"], "--keys: tells scale and orientation already"),
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
    assert "is read" in complain(capsys, exemplar, "-o", exemplar)
    assert "one channel" in complain(capsys, exemplar, "-o", output, "--orientation", other)
    keys.write_text("[[transition]]\nat = [0.5, 0.5]\nvalue = 0.75\n")
    assert "no keys of scale or orientation" in complain(capsys, exemplar, "-o", output, "--keys", keys)
    write_image(other, np.random.default_rng(0).random((5, 40, 3)))
    assert "smaller --neighborhood" in complain(capsys, other, "-o", output)
