"""`jaxtex compare`: the sheet shows what was made, and the table says what was measured."""

import csv
from pathlib import Path

import jax
import numpy as np
import pytest

from jaxtex.cli.contact_sheet import Cell, draw_contact_sheet, lay_out
from jaxtex.cli.main import main
from jaxtex.cli.synth_methods import encode
from jaxtex.core.colour import linear_to_srgb
from jaxtex.io.images import read_image, write_image
from jaxtex.synthesis.copying import measure_pieces, verbatim_share
from jaxtex.synthesis.distances import sliced_wasserstein
from jaxtex.synthesis.methods import METHODS
from jaxtex.synthesis.portilla_simoncelli import portilla_simoncelli_distance

# Exemplars and textures of one size share what is compiled to measure them.
QUICK = ["--methods", "quilting", "heeger-bergen", "--size", "48x40"]


@pytest.fixture
def exemplar(tmp_path: Path) -> Path:
    path = tmp_path / "sand.png"
    write_image(path, np.random.default_rng(0).random((40, 48, 3)) * np.array([0.8, 0.4, 0.2]))
    return path


def read_table(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def read_levels(path: Path) -> np.ndarray:
    return np.rint(255 * linear_to_srgb(read_image(path).pixels)).astype(int)


def show(pixels: np.ndarray, times: int) -> np.ndarray:
    """As it should stand on a sheet."""
    levels = np.rint(255 * np.broadcast_to(pixels, (*pixels.shape[:2], 3))).astype(int)
    return levels.repeat(times, axis=0).repeat(times, axis=1)


def stands_at(sheet: np.ndarray, picture: np.ndarray) -> tuple[int, int] | None:
    """The only place of the sheet where the picture stands, exactly; (row, col)."""
    windows = np.lib.stride_tricks.sliding_window_view(sheet, (*picture.shape[:2], 1))[..., 0]
    corner = (windows[..., 0, 0] == picture[0, 0]).all(axis=-1)
    places = [
        (row, column)
        for row, column in np.argwhere(corner)
        if (sheet[row : row + picture.shape[0], column : column + picture.shape[1]] == picture).all()
    ]
    return (int(places[0][0]), int(places[0][1])) if len(places) == 1 else None


def test_the_sheet_shows_the_exemplar_and_what_was_made(exemplar: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = exemplar.with_name("sheet.png")
    assert main(["compare", str(exemplar), "-o", str(output), *QUICK, "--seed", "5"]) == 0
    image = read_image(exemplar)
    encoded = encode(image.pixels, image.alpha)
    sheet = read_levels(output)
    places = [stands_at(sheet, show(encoded, 5))]
    rows = read_table(output.with_suffix(".csv"))
    assert [row["method"] for row in rows] == ["quilting", "heeger-bergen"]
    for row in rows:
        texture = METHODS[row["method"]](encoded, (40, 48), key=jax.random.key(5))
        places.append(stands_at(sheet, show(texture.pixels, 5)))
        measured = {
            "patches": sliced_wasserstein(encoded, texture.pixels, key=jax.random.key(0), scales=3).total,
            "statistics": portilla_simoncelli_distance(encoded, texture.pixels, scales=3).total,
            "copied": verbatim_share(encoded, texture.pixels),
        }
        assert {name: float(row[name]) for name in measured} == pytest.approx(measured, rel=1e-4)
        assert float(row["seconds"]) > 0
        if texture.sources is None:
            assert row["pieces"] == ""
        else:
            assert float(row["pieces"]) == pytest.approx(measure_pieces(texture.sources).mean_size, rel=1e-4)
    assert None not in places
    assert len(places) == len(set(places)) == 3
    told = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in told[:3]] == ["method", "quilting", "heeger-bergen"]
    assert told[3:] == [
        f"{output}: {sheet.shape[1]} x {sheet.shape[0]} pixels",
        f"{output.with_suffix('.csv')}: these figures",
    ]


def test_only_seconds_differ_from_run_to_run(exemplar: Path) -> None:
    output = exemplar.with_name("sheet.exr")
    tables = []
    for seed in "001":
        assert main(["compare", str(exemplar), "-o", str(output), *QUICK, "--seed", seed]) == 0
        tables.append([{**row, "seconds": ""} for row in read_table(output.with_suffix(".csv"))])
    assert tables[0] == tables[1] != tables[2]


@pytest.mark.parametrize(
    ("options", "shape", "inside"),
    [
        (["--size", "192x192"], (220, 300), np.s_[14:206, 54:246]),
        (["--size", "48x40", "--region", "20,30,48x40"], (80, 90, 3), np.s_[30:70, 20:68]),
    ],
)
def test_it_learns_from_the_middle_or_a_region(
    tmp_path: Path, options: list[str], shape: tuple[int, ...], inside: tuple[slice, slice]
) -> None:
    path, output = tmp_path / "exemplar.png", tmp_path / "sheet.png"
    write_image(path, np.random.default_rng(0).random(shape))
    assert main(["compare", str(path), "-o", str(output), "--methods", "quilting", *options]) == 0
    encoded = linear_to_srgb(read_image(path).pixels)[inside]
    assert stands_at(read_levels(output), show(encoded, 256 // max(encoded.shape[:2]))) is not None


def test_small_and_flat_exemplars_will_do(tmp_path: Path) -> None:
    path, output = tmp_path / "flat.png", tmp_path / "sheet.png"
    write_image(path, np.full((16, 16, 3), 0.25))
    assert main(["compare", str(path), "-o", str(output), "--size", "16x16"]) == 0
    rows = read_table(output.with_suffix(".csv"))
    assert [row["method"] for row in rows] == list(METHODS)
    assert all(float(row["patches"]) < 0.1 for row in rows)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--size", "256"], "--size: '256' is no size"),
        (["--size", "15x64"], "--size: 15x64 is out of range; give 16 to 1024 pixels"),
        (["--size", "64x1025"], "--size: 64x1025 is out of range"),
        (["--seed", "-1"], "--seed: -1 is out of range"),
        (["--methods", "weaving"], "'weaving'"),
        (["--methods", "quilting", "quilting"], "--methods: name each once"),
        (["--region", "0,0,64"], "--region: '0,0,64' is no rectangle"),
        (["--region", "30,0,20x20"], "--region: 30,0,20x20 lies outside sand.png, which is 48 x 40"),
        (["--region", "0,0,40x15"], "--region: 40 x 15 pixels are too few"),
        (["-o", "sheet.xyz"], "sheet.xyz: cannot be written"),
        (["-o", "nowhere/sheet.png"], "no folder nowhere"),
    ],
)
def test_what_cannot_be_done_is_told_in_one_line(
    exemplar: Path, options: list[str], told: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(exemplar.parent)
    output = [] if "-o" in options else ["-o", "sheet.png"]
    assert main(["compare", exemplar.name, *options, *output]) == 2
    captured = capsys.readouterr()
    assert told in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""
    assert [path.name for path in exemplar.parent.iterdir()] == [exemplar.name]


def test_exemplars_that_cannot_be_learnt_from_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, output = tmp_path / "exemplar.png", tmp_path / "sheet.png"
    words = ["compare", str(path), "-o", str(output), "--methods", "quilting", "--size", "48x40"]
    assert main(words) == 2
    assert "there is no such file" in capsys.readouterr().err
    write_image(path, np.zeros((1, 1, 3)))
    assert main(words) == 2
    assert "exemplar.png: 1 x 1 pixels are too few to learn from; give 16 to a side" in capsys.readouterr().err
    pixels = np.random.default_rng(0).random((64, 64, 4))
    pixels[..., 3] = np.arange(64) < 50
    write_image(path, pixels)
    assert main(words) == 2
    assert "is transparent where it is learnt from" in capsys.readouterr().err
    assert not output.exists()
    assert main([*words, "--region", "0,10,48x40"]) == 0


@pytest.mark.parametrize("count", [1, 4, 5, 7, 9])
@pytest.mark.parametrize("shape", [(256, 256), (40, 300), (64, 20)])
def test_every_picture_stands_on_the_sheet_whole(count: int, shape: tuple[int, int]) -> None:
    pictures = np.random.default_rng(0).integers(0, 256, (count, *shape, 3))
    lines = ("one line", "another")
    cells = [Cell("name", each / 255, each / 255, lines) for each in pictures]
    layout = lay_out(count, largest=shape[::-1], lines=len(lines))
    sheet = np.rint(255 * draw_contact_sheet(cells, layout)).astype(int)
    assert sheet.shape == (*layout.size[::-1], 3)
    places = {stands_at(sheet, show(each / 255, layout.times)) for each in pictures}
    assert None not in places
    assert len(places) == count
