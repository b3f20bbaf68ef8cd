"""`jaxtex particles`: a picture made of things, taken apart, shown, and arranged anew; and what cannot be."""

import json
from pathlib import Path

import numpy as np
import pytest
from skimage import data

from jaxtex.cli.particles import Analyse, Show
from jaxtex.cli.particles_synth import Synth
from jaxtex.cli.usage import parse
from jaxtex.core.errors import InputError
from jaxtex.io.images import read_image, write_image
from jaxtex.io.masks import read_mask
from jaxtex.particles.files import read_particles, write_particles
from jaxtex.particles.things import describe_particles

SHAPE = 96, 120
SPOT, SAND = np.array([0.35, 0.05, 0.04]), np.array([0.55, 0.5, 0.35])


def run(command: type, *words: object) -> int:
    options = parse(command, prog="jaxtex", arguments=list(map(str, words)))
    assert options is not None
    return options.run()


def draw_spots() -> np.ndarray:
    """Twenty spots in rows, on grainy sand, as linear colours."""
    row, column = np.indices(SHAPE) + 0.5
    inside = np.hypot(row % 24 - 12, column % 24 - 12) < 6
    return np.where(inside[..., None], SPOT, SAND) * np.random.default_rng(0).lognormal(0, 0.08, (*SHAPE, 1))


@pytest.fixture(scope="module")
def spots(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("pictures") / "spots.png"
    write_image(path, draw_spots())
    return path


@pytest.fixture(scope="module")
def folder(spots: Path) -> Path:
    assert run(Analyse, spots, "-o", spots.parent / "spots") == 0
    return spots.parent / "spots"


def test_things_are_found_and_shown(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = read_particles(folder).decomposition
    assert len(found.particles) == 20
    assert run(Show, folder, "-o", folder.parent / "sheet.png") == 0
    assert "20" in capsys.readouterr().out
    sheet = read_image(folder.parent / "sheet.png").pixels
    np.testing.assert_array_equal(sheet, read_image(folder / "sheet.png").pixels)
    assert sheet.std() > 0.1


def test_things_of_picked_colours(spots: Path, tmp_path: Path) -> None:
    assert run(Analyse, spots, "-o", tmp_path / "a", "--colours", "12,12") == 0
    assert run(Analyse, spots, "-o", tmp_path / "b", "--colours", "9f4038+12,12", "--ground", "0,0", "c4bb9f") == 0
    assert run(Analyse, spots, "-o", tmp_path / "c", "--colours", "12,12", "--distance", "rgb", "--smoothing", "0") == 0
    assert [len(read_particles(tmp_path / name).decomposition.particles) for name in "abc"] == [20, 20, 20]


def test_things_cut_out_by_hand(spots: Path, tmp_path: Path) -> None:
    square = [[4, 4], [20, 4], [20, 20], [4, 20]]
    shapes = [{"label": "big", "points": square}, {"label": "small", "points": [[60, 60], [70, 60], [66, 70]]}]
    (tmp_path / "cut.json").write_text(json.dumps({"shapes": shapes}))
    assert run(Analyse, spots, "-o", tmp_path / "cut", "--polygons", tmp_path / "cut.json") == 0
    alone = read_particles(tmp_path / "cut")
    assert (alone.names, alone.decomposition.kinds) == (("big", "small"), 2)
    assert run(Analyse, spots, "-o", tmp_path / "both", "--polygons", tmp_path / "cut.json", "--find") == 0
    both = read_particles(tmp_path / "both")
    assert both.names == ("big", "small", "found 0")
    assert len(both.decomposition.particles) == 21  # of the 20 one is all cut, another hardly


def test_things_that_are_painted(spots: Path, tmp_path: Path) -> None:
    painted = np.zeros((*SHAPE, 3))
    painted[4:20, 4:20], painted[4:20, 30:44], painted[60:80, 60:90] = (1, 0, 0), (0, 0, 1), (1, 0, 0)
    write_image(tmp_path / "paint.png", painted, colour_space="data")
    assert run(Analyse, spots, "-o", tmp_path / "out", "--labels", tmp_path / "paint.png", "--label-classes") == 0
    out = read_particles(tmp_path / "out")
    assert out.names == ("0000ff", "ff0000")
    assert [each.kind for each in out.decomposition.particles] == [1, 0, 1]
    assert run(Analyse, spots, "-o", tmp_path / "out", "--labels", tmp_path / "paint.png") == 0
    assert len(read_particles(tmp_path / "out").decomposition.particles) == 3


def test_labels_mended_by_hand_are_not_written_over(spots: Path, tmp_path: Path) -> None:
    words = (spots, "-o", tmp_path / "out", "--colours", "12,12")
    assert run(Analyse, *words) == 0
    assert run(Analyse, *words) == 0
    labels = tmp_path / "out" / "labels.png"
    write_image(
        labels, np.where(np.arange(120) < 60, 1 / 65535, 0)[None].repeat(96, axis=0), colour_space="data", bits=16
    )
    mended = labels.read_bytes()
    with pytest.raises(InputError, match=r"--output: .*labels\.png is not as .* left it, may have been mended"):
        run(Analyse, *words)
    assert labels.read_bytes() == mended


def test_things_are_arranged_anew(folder: Path, tmp_path: Path) -> None:
    words = (folder, "-o", tmp_path / "a.png", "--size", "192x144", "--tileable")
    assert run(Synth, *words, "--save", tmp_path / "a.json", "--mask", tmp_path / "mask.png") == 0
    first = read_image(tmp_path / "a.png").pixels
    assert first.shape == (144, 192, 3)
    placed = json.loads((tmp_path / "a.json").read_text())["placed"]
    assert len(placed) == pytest.approx(48, abs=6)
    red = first[..., 0] > 2.5 * first[..., 1]
    assert np.mean(red == (read_mask(tmp_path / "mask.png") > 0.5)) > 0.95
    assert run(Synth, *words) == 0
    np.testing.assert_array_equal(read_image(tmp_path / "a.png").pixels, first)
    assert run(Synth, folder, "-o", tmp_path / "b.png", "--composition", tmp_path / "a.json") == 0
    np.testing.assert_array_equal(read_image(tmp_path / "b.png").pixels, first)


def test_a_composition_is_edited_and_drawn_larger(folder: Path, tmp_path: Path) -> None:
    words = (folder, "-o", tmp_path / "a.png", "--size", "120x96", "--save", tmp_path / "a.json")
    assert run(Synth, *words, "--no-relax", "--seed", "3") == 0
    document = json.loads((tmp_path / "a.json").read_text())
    document["placed"] = [[*line[:2], 60, 48, *line[4:]] for line in document["placed"][:1]]
    (tmp_path / "b.json").write_text(json.dumps(document))
    assert run(Synth, folder, "-o", tmp_path / "b.png", "--composition", tmp_path / "b.json", "--scale", "2") == 0
    drawn = read_image(tmp_path / "b.png").pixels
    assert drawn.shape == (192, 240, 3)
    rows, columns = np.nonzero(drawn[..., 0] > 2.5 * drawn[..., 1])
    assert np.mean(rows) == pytest.approx(96, abs=3)
    assert np.mean(columns) == pytest.approx(120, abs=3)
    assert len(rows) == pytest.approx(4 * np.pi * 36, rel=0.2)


def test_controls_are_taken_from_a_file(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "wish.toml").write_text("[[control]]\nsize = 0.5\n")
    words = (folder, "-o", tmp_path / "a.png", "--size", "192x192", "--save", tmp_path / "a.json")
    assert run(Synth, *words, "--control", tmp_path / "wish.toml") == 0
    assert {line[5] for line in json.loads((tmp_path / "a.json").read_text())["placed"]} == {0.5}


@pytest.mark.parametrize("wish", ["density = 0", "probability = 0"])
def test_that_nothing_is_placed_is_told(
    folder: Path, spots: Path, tmp_path: Path, wish: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "none.toml").write_text(f"[[control]]\n{wish}\n")
    words = ("--under", spots, "--control", tmp_path / "none.toml")
    assert run(Synth, folder, "-o", tmp_path / "a.png", *words) == 0
    hint = capsys.readouterr().err
    assert f"nothing is placed; in {tmp_path / 'none.toml'} a density or probability may be 0" in hint
    assert hint.count("\n") == 1


def test_things_are_laid_over_another_picture_where_it_is_free(folder: Path, tmp_path: Path) -> None:
    write_image(tmp_path / "wall.png", np.full((160, 200, 3), 0.2))
    mask = np.zeros((160, 200, 1))
    mask[:, :100] = 1
    write_image(tmp_path / "bricks.png", mask, colour_space="data")
    words = (folder, "-o", tmp_path / "a.png", "--under", tmp_path / "wall.png", "--avoid", tmp_path / "bricks.png")
    assert run(Synth, *words, "--save", tmp_path / "a.json") == 0
    drawn = read_image(tmp_path / "a.png").pixels
    assert drawn.shape == (160, 200, 3)
    np.testing.assert_allclose(drawn[:, :88], 0.2, atol=0.01)
    places = [line[2] for line in json.loads((tmp_path / "a.json").read_text())["placed"]]
    assert places
    assert min(places) >= 99


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--classes", "0"), "--classes: 0 is out of range"),
        (("--classes", "2", "--colours", "ff0000"), "--classes: goes without"),
        (("--ground", "ff0000"), "--ground: goes with --colours"),
        (("--colours", "red"), "--colours: 'red'"),
        (("--colours", "500,5"), "--colours: '500,5': .*lies outside"),
        (("--classes", "99"), "^--classes: 99 are asked for"),
        (("--colours", "00ff00", "--ground", "a8413a", "c4bb9f"), r"spots\.png: .*nothing has these colours"),
        (("--smoothing", "-1", "--colours", "ff0000"), "--smoothing"),
        (("--label-classes",), "--label-classes: goes with --labels"),
        (("--find",), "--find: goes with"),
        (("--smallest", "9999"), "--smallest: nothing has 9999 pixels"),
        (("--smallest", "-1"), "--smallest: -1 is out of range"),
        (("--labels", "nowhere.png"), r"nowhere\.png: there is no such file"),
        (("--polygons", "nowhere.json"), r"nowhere\.json: there is no such file"),
    ],
)
def test_wishes_that_cannot_be_met_in_taking_apart(spots: Path, tmp_path: Path, words: tuple, told: str) -> None:
    with pytest.raises(InputError, match=told):
        run(Analyse, spots, "-o", tmp_path / "out", *words)
    assert not (tmp_path / "out").exists()


def test_pictures_that_cannot_be_taken_apart(spots: Path, tmp_path: Path) -> None:
    write_image(tmp_path / "flat.png", np.full((40, 40, 3), 0.3))
    with pytest.raises(InputError, match=r"flat\.png: picture: is all of one colour"):
        run(Analyse, tmp_path / "flat.png", "-o", tmp_path / "out")
    write_image(tmp_path / "tiny.png", np.full((5, 5, 3), 0.3))
    with pytest.raises(InputError, match=r"tiny\.png: .*too small"):
        run(Analyse, tmp_path / "tiny.png", "-o", tmp_path / "out")
    write_image(tmp_path / "paint.png", np.ones((20, 20, 1)), colour_space="data")
    with pytest.raises(InputError, match="is 20 x 20, and the exemplar 120 x 96"):
        run(Analyse, spots, "-o", tmp_path / "out", "--labels", tmp_path / "paint.png")
    write_image(tmp_path / "paint.png", np.zeros((*SHAPE, 1)), colour_space="data")
    with pytest.raises(InputError, match=r"paint\.png: labels: all is black"):
        run(Analyse, spots, "-o", tmp_path / "out", "--labels", tmp_path / "paint.png")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--size", "12"), "--size: '12' is no size"),
        (("--size", "900000x900000"), "GiB"),
        (("--scale", "0"), "--scale"),
        (("--germ", "5"), "--germ"),
        (("--germ", "900,5", "--size", "60x60"), "^--germ 900,5: is not on the plane"),
        (("--order", "3"), "^--order .3.: name classes"),
        (("--size", "8x8", "--tileable"), "^--size 8 x 8: too small to repeat"),
        (("--under", "small.png", "--tileable"), r"^--under: small\.png of 9 x 8: too small to repeat"),
        (("--control", "large.toml", "--tileable"), "^--size, by default 1024 x 1024: too small to repeat"),
        (("--control", "dense.toml"), "^--size, by default 1024 x 1024: takes .* or a lower density"),
        (("--control", "kinds.toml"), r"^kinds\.toml: classes \[7\] of control 2: name classes from 0 to 0"),
        (("--control", "weights.toml"), r"^weights\.toml: weights of particles \[999\] in control 1: name particles"),
        (("--control", "nowhere.toml"), r"nowhere\.toml"),
        (("--composition", "nowhere.json"), r"nowhere\.json"),
        (("--composition", "nowhere.json", "--size", "60x60"), "--size: goes without --composition"),
        (("--under", "nowhere.png", "--size", "60x60"), "--size: goes without --under"),
        (("--avoid", "out.png"), r"out\.png: would be written over"),
        (("--mask", "mask.gif"), "cannot be written as '.gif'"),
        (("--ground", "noise", "--under", "nowhere.png"), "--ground: goes without --under"),
    ],
)
def test_wishes_that_cannot_be_met_in_arranging(
    folder: Path, tmp_path: Path, words: tuple, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("kinds.toml").write_text("[[control]]\nsize = 0.5\n[[control]]\nclasses = [7]\n")
    Path("weights.toml").write_text("[[control]]\nweights = {999 = 0}\n")
    Path("large.toml").write_text("[[control]]\nsize = 100\n")
    Path("dense.toml").write_text("[[control]]\ndensity = 1000\n")
    write_image("small.png", np.full((8, 9, 3), 0.5))
    with pytest.raises(InputError, match=told):
        run(Synth, folder, "-o", "out.png", *words)
    assert not (tmp_path / "out.png").exists()


def test_that_no_thing_is_whole_is_told_of_the_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_image("edge.png", np.where(np.arange(40) < 12, 0.1, 0.7)[None].repeat(30, axis=0)[..., None])
    things = describe_particles((np.arange(40) < 12)[None].repeat(30, axis=0).astype(int), [0])
    write_particles("edge", read_image("edge.png"), things)
    Path("ctl.toml").write_text("[[control]]\nsize = 0.5\n")
    with pytest.raises(InputError, match=r"^edge: no particle is complete"):
        run(Synth, "edge", "-o", "out.png", "--control", "ctl.toml")


def test_a_composition_of_other_particles_is_refused(folder: Path, tmp_path: Path) -> None:
    words = (folder, "-o", tmp_path / "a.png", "--size", "100x100", "--no-relax", "--save", tmp_path / "a.json")
    assert run(Synth, *words) == 0
    document = json.loads((tmp_path / "a.json").read_text())
    document["exemplar"]["sha256"] = "0" * 64
    (tmp_path / "a.json").write_text(json.dumps(document))
    with pytest.raises(InputError, match="made of 20 particles"):
        run(Synth, folder, "-o", tmp_path / "b.png", "--composition", tmp_path / "a.json")


def test_small_things_are_left_out(tmp_path: Path) -> None:
    picture = draw_spots()
    picture[2:5, 2:5] = (0.02, 0.02, 0.4)
    write_image(tmp_path / "a.png", picture)
    words = ("--colours", "12,12", "272797", "--ground", "24,12", "--smoothing", "0")
    counts = []
    for smallest in (0, 30):
        assert run(Analyse, tmp_path / "a.png", "-o", tmp_path / "a", *words, "--smallest", smallest) == 0
        counts.append(
            np.bincount([each.kind for each in read_particles(tmp_path / "a").decomposition.particles]).tolist()
        )
    assert counts == [[20, 1], [20]]


def test_one_thing_alone(tmp_path: Path) -> None:
    picture = np.full((60, 60, 3), 0.5)
    picture[20:32, 22:40] = SPOT
    write_image(tmp_path / "one.png", picture)
    assert run(Analyse, tmp_path / "one.png", "-o", tmp_path / "one") == 0
    assert len(read_particles(tmp_path / "one").decomposition.particles) == 1
    assert run(Synth, tmp_path / "one", "-o", tmp_path / "more.png", "--size", "200x200") == 0
    drawn = read_image(tmp_path / "more.png").pixels
    assert 0.02 < np.mean(drawn[..., 0] > 2.5 * drawn[..., 1]) < 0.2


def test_what_hardly_looks_like_things_is_told(tmp_path: Path, spots: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_image(tmp_path / "grass.png", data.grass()[:160, :160, None] / 255)
    assert run(Analyse, tmp_path / "grass.png", "-o", tmp_path / "grass") == 1
    assert "hardly look like things" in capsys.readouterr().out
    assert run(Analyse, spots, "-o", tmp_path / "spots") == 0
    assert "hardly look like things" not in capsys.readouterr().out
