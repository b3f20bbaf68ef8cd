"""`jaxtex synth` from the words typed to the file written."""

from pathlib import Path

import jax
import numpy as np
import pytest

from jaxtex.cli.main import main
from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
from jaxtex.io.images import read_image, write_image


@pytest.fixture
def exemplar(tmp_path: Path) -> Path:
    path = tmp_path / "exemplar.png"
    write_image(path, np.random.default_rng(0).random((64, 70, 3)) * np.array([0.8, 0.4, 0.2]))
    return path


def test_a_texture_is_written(exemplar: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from jaxtex.synthesis.heeger_bergen import analyse_texture, synthesise_texture

    output = exemplar.with_name("texture.exr")
    words = ["--size", "50x40", "--scales", "2", "--orientations", "3", "--iterations", "2", "--seed", "7"]
    assert main(["synth", str(exemplar), "-o", str(output), *words]) == 0
    encoded = linear_to_srgb(read_image(exemplar).pixels)[None]
    made = synthesise_texture(
        analyse_texture(encoded, scales=2, orientations=3), (40, 50), key=jax.random.key(7), iterations=2
    )
    expected = srgb_to_linear(np.asarray(made))
    np.testing.assert_allclose(read_image(output).pixels, expected, atol=2e-3)
    assert capsys.readouterr().out == f"{output}: 50 x 40 pixels, tileable\n"


def test_it_is_as_large_as_the_exemplar(exemplar: Path) -> None:
    outputs = [exemplar.with_name(f"{k}.png") for k in range(3)]
    for output, seed in zip(outputs, "001", strict=True):
        assert main(["synth", str(exemplar), "-o", str(output), "--seed", seed]) == 0
    first, second, other = (output.read_bytes() for output in outputs)
    assert read_image(outputs[0]).pixels.shape == (64, 70, 3)
    assert first == second != other


def test_regions_are_learnt_from(exemplar: Path) -> None:
    pixels = np.zeros((64, 64))
    pixels[:16, :16] = np.random.default_rng(1).uniform(0.4, 0.5, (16, 16))
    pixels[40:56, 8:24] = np.random.default_rng(2).uniform(0.6, 0.7, (16, 16))
    write_image(exemplar, pixels)
    output = exemplar.with_name("texture.exr")
    words = ["--region", "0,0,16x16", "--region", "8,40,16x16", "--scales", "1", "--finer", "1"]
    assert main(["synth", str(exemplar), "-o", str(output), *words]) == 0
    made = read_image(output).pixels
    assert made.shape == (32, 32, 1)
    assert made.min() > 0.2
    assert made.mean() == pytest.approx(0.55, abs=0.02)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--size", "0x64"], "--size: '0x64' is no size"),
        (["--size", "64"], "--size: '64' is no size"),
        (["--size", "900000x900000"], "--size: 900000x900000 takes"),
        (["--size", "60x64"], "--size: 60x64 holds 3 scales, not 4; give 64 pixels"),
        (["--size", "64x64", "--finer", "1"], "holds 4 scales, not 4 and 1 finer; give 128 pixels"),
        (["--scales", "5"], "--scales: 5 do not fit what is learnt from, which is 70 x 64 pixels; give at most 4"),
        (["--scales", "0"], "--scales: 0 is out of range"),
        (["--orientations", "0"], "--orientations: 0 is out of range"),
        (["--orientations", "17"], "--orientations: 17 is out of range"),
        (["--iterations", "0"], "--iterations: 0 is out of range"),
        (["--finer", "-1"], "--finer: -1 is out of range"),
        (["--finer", "99"], "--finer: 99 is out of range"),
        (["--seed", "-1"], "--seed: -1 is out of range"),
        (["--method", "quilting"], "'quilting'"),
        (["--region", "0,0,64"], "--region: '0,0,64' is no rectangle"),
        (["--region", "30,0,64x64"], "--region: 30,0,64x64 lies outside"),
        (["--region", "-1,0,64x64"], "--region: -1,0,64x64 lies outside"),
        (
            ["--region", "0,0,16x16"],
            "--scales: 4 do not fit what is learnt from, which is 16 x 16 pixels; give at most 2",
        ),
        (["--region", "0,0,64x64", "--region", "0,0,64x63"], "--region: sizes are 64x63, 64x64"),
        (["-o", "texture.xyz"], "texture.xyz: cannot be written"),
        (["-o", "nowhere/texture.png"], "no folder nowhere"),
    ],
)
def test_what_cannot_be_done_is_told_in_one_line(
    exemplar: Path, options: list[str], told: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(exemplar.parent)
    output = [] if "-o" in options else ["-o", "texture.png"]
    assert main(["synth", exemplar.name, *options, *output]) == 2
    captured = capsys.readouterr()
    assert told in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""
    assert [path.name for path in exemplar.parent.iterdir()] == [exemplar.name]


def test_a_missing_exemplar_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["synth", str(tmp_path / "no.png"), "-o", str(tmp_path / "o.png")]) == 2
    assert "no.png: there is no such file" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_transparent_parts_are_not_learnt_from(exemplar: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pixels = np.random.default_rng(0).random((64, 64, 4))
    pixels[..., 3] = 1.0
    pixels[50:, 50:, 3] = 0.0
    write_image(exemplar, pixels)
    output = exemplar.with_name("texture.png")
    assert main(["synth", str(exemplar), "-o", str(output)]) == 2
    assert "is transparent in places" in capsys.readouterr().err
    assert not output.exists()
    assert main(["synth", str(exemplar), "-o", str(output), "--region", "0,0,48x48", "--scales", "3"]) == 0
    assert read_image(output).pixels.shape == (48, 48, 3)
