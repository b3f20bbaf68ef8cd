"""`jaxtex synth` from the words typed to the files written."""

from pathlib import Path

import jax
import numpy as np
import pytest

from jaxtex.cli.main import main
from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
from jaxtex.io.images import read_image, write_image
from jaxtex.io.masks import read_mask, write_mask
from jaxtex.io.raster import read_raster

NOISE = ["--method", "heeger-bergen"]
COPYING = ["coherence", "ashikhmin", "wei-levoy", "efros-leung", "quilting"]


@pytest.fixture
def exemplar(tmp_path: Path) -> Path:
    path = tmp_path / "exemplar.png"
    write_image(path, np.random.default_rng(0).random((64, 70, 3)) * np.array([0.8, 0.4, 0.2]))
    return path


def synth(*words: object) -> int:
    return main(["synth", *map(str, words)])


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def numbered(path: Path, rows: int = 32, columns: int = 40, alpha: bool = False) -> np.ndarray:
    """A picture of 16 bits in which each pixel's number tells its place."""
    places = np.arange(rows * columns).reshape(rows, columns, 1) / (rows * columns)
    write_image(path, np.concatenate([places, places], axis=2) if alpha else places, colour_space="data", bits=16)
    return read_raster(path).numbers


class TestNoise:
    def test_a_texture_is_written(self, exemplar: Path, capsys: pytest.CaptureFixture[str]) -> None:
        from jaxtex.synthesis.heeger_bergen import analyse_texture, synthesise_texture

        output = exemplar.with_name("texture.exr")
        words = ["--size", "50x40", "--scales", "2", "--orientations", "3", "--iterations", "2", "--seed", "7"]
        assert synth(exemplar, "-o", output, *NOISE, *words) == 0
        encoded = linear_to_srgb(read_image(exemplar).pixels)[None]
        made = synthesise_texture(
            analyse_texture(encoded, scales=2, orientations=3), (40, 50), key=jax.random.key(7), iterations=2
        )
        expected = srgb_to_linear(np.asarray(made))
        np.testing.assert_allclose(read_image(output).pixels, expected, atol=2e-3)
        assert capsys.readouterr().out == f"{output}: 50 x 40 pixels, tileable\n"

    def test_it_is_as_large_as_the_exemplar(self, exemplar: Path) -> None:
        outputs = [exemplar.with_name(f"{k}.png") for k in range(3)]
        for output, seed in zip(outputs, "001", strict=True):
            assert synth(exemplar, "-o", output, *NOISE, "--seed", seed) == 0
        first, second, other = (output.read_bytes() for output in outputs)
        assert read_image(outputs[0]).pixels.shape == (64, 70, 3)
        assert first == second != other

    def test_regions_are_learnt_from(self, exemplar: Path) -> None:
        pixels = np.zeros((64, 64))
        pixels[:16, :16] = np.random.default_rng(1).uniform(0.4, 0.5, (16, 16))
        pixels[40:56, 8:24] = np.random.default_rng(2).uniform(0.6, 0.7, (16, 16))
        write_image(exemplar, pixels)
        output = exemplar.with_name("texture.exr")
        words = ["--region", "0,0,16x16", "--region", "8,40,16x16", "--scales", "1", "--finer", "1"]
        assert synth(exemplar, "-o", output, *NOISE, *words) == 0
        made = read_image(output).pixels
        assert made.shape == (32, 32, 1)
        assert made.min() > 0.2
        assert made.mean() == pytest.approx(0.55, abs=0.02)

    def test_transparent_parts_are_not_learnt_from(self, exemplar: Path, capsys: pytest.CaptureFixture[str]) -> None:
        pixels = np.random.default_rng(0).random((64, 64, 4))
        pixels[..., 3] = 1.0
        pixels[50:, 50:, 3] = 0.0
        write_image(exemplar, pixels)
        output = exemplar.with_name("texture.png")
        assert synth(exemplar, "-o", output, *NOISE) == 2
        assert "is transparent in places" in capsys.readouterr().err
        assert not output.exists()
        assert synth(exemplar, "-o", output, *NOISE, "--region", "0,0,48x48", "--scales", "3") == 0
        assert read_image(output).pixels.shape == (48, 48, 3)


class TestCopies:
    def test_the_default_is_coherence(self, exemplar: Path, capsys: pytest.CaptureFixture[str]) -> None:
        from jaxtex.synthesis.coherence import synthesise_coherence
        from jaxtex.synthesis.sources import copy_sources

        output = exemplar.with_name("texture.png")
        assert synth(exemplar, "-o", output, "--seed", "3", "--size", "40x32") == 0
        encoded = linear_to_srgb(read_image(exemplar).pixels)
        sources = synthesise_coherence(encoded, (32, 40), key=jax.random.key(3))
        expected = copy_sources(read_raster(exemplar).numbers, sources)
        np.testing.assert_array_equal(read_raster(output).numbers, expected)
        assert capsys.readouterr().out == f"{output}: 40 x 32 pixels, tileable\n"
        assert names(exemplar.parent) == ["exemplar.png", "texture.png"]

    @pytest.mark.parametrize("method", COPYING)
    def test_the_same_seed_makes_the_same_bytes(self, tmp_path: Path, method: str) -> None:
        numbers = numbered(tmp_path / "exemplar.png")
        outputs = [tmp_path / f"{k}.png" for k in range(3)]
        for output, seed in zip(outputs, "001", strict=True):
            assert synth(tmp_path / "exemplar.png", "-o", output, "--method", method, "--seed", seed) == 0
        first, second, other = (output.read_bytes() for output in outputs)
        assert first == second != other
        made = read_raster(outputs[0]).numbers
        assert made.dtype == np.uint16
        assert made.shape == numbers.shape
        assert np.isin(made, numbers).all()

    @pytest.mark.parametrize("method", ["ashikhmin", "quilting"])
    def test_tileable_is_told(self, exemplar: Path, method: str, capsys: pytest.CaptureFixture[str]) -> None:
        output = exemplar.with_name("texture.png")
        words = ["--method", method, "--size", "24x20"]
        for tileable, told in (([], ""), (["--tileable"], ", tileable")):
            assert synth(exemplar, "-o", output, *words, *tileable) == 0
            assert capsys.readouterr().out == f"{output}: 24 x 20 pixels{told}\n"

    @pytest.mark.parametrize(
        "words", [["--method", "wei-levoy"], ["--method", "efros-leung"], ["--method", "ashikhmin", "--similar", "2"]]
    )
    def test_all_places_of_large_exemplars_are_not_compared(
        self, exemplar: Path, words: list[str], capsys: pytest.CaptureFixture[str]
    ) -> None:
        write_image(exemplar, np.zeros((1000, 1100)))
        assert synth(exemplar, "-o", exemplar.with_name("texture.png"), *words) == 2
        assert f"{words[-2] if '--similar' in words else ' '.join(words)}: compares with" in capsys.readouterr().err
        assert names(exemplar.parent) == ["exemplar.png"]
        assert synth(exemplar, "-o", exemplar.with_name("texture.png"), *words, "--region", "0,0,32x32") == 0

    @pytest.mark.parametrize(
        "words",
        [
            ["--method", "ashikhmin", "--similar", "3"],
            ["--method", "ashikhmin", "--passes", "2"],
            ["--method", "wei-levoy", "--levels", "2"],
            ["--method", "wei-levoy", "--search", "tree"],
            ["--method", "quilting", "--block", "10"],
            ["--neighborhood", "5"],
        ],
    )
    def test_options_make_a_difference(self, tmp_path: Path, words: list[str]) -> None:
        numbers = numbered(tmp_path / "exemplar.png")
        assert synth(tmp_path / "exemplar.png", "-o", tmp_path / "with.png", *words) == 0
        method = words[:2] if words[0] == "--method" else []
        assert synth(tmp_path / "exemplar.png", "-o", tmp_path / "without.png", *method) == 0
        made, plain = (read_raster(tmp_path / name).numbers for name in ("with.png", "without.png"))
        assert np.isin(made, numbers).all()
        assert (made != plain).any()

    @pytest.mark.parametrize("method", COPYING)
    def test_only_the_region_is_copied(self, tmp_path: Path, method: str) -> None:
        numbers = numbered(tmp_path / "exemplar.png")
        words = ["--method", method, "--region", "12,5,20x25"]
        assert synth(tmp_path / "exemplar.png", "-o", tmp_path / "texture.png", *words) == 0
        made = read_raster(tmp_path / "texture.png").numbers
        assert made.shape == (25, 20, 1)
        assert np.isin(made, numbers[5:30, 12:32]).all()

    @pytest.mark.parametrize("suffix", [".png", ".exr"])
    def test_alpha_is_copied_along(self, tmp_path: Path, suffix: str) -> None:
        source, output = tmp_path / f"exemplar{suffix}", tmp_path / f"texture{suffix}"
        pixels = np.random.default_rng(0).random((32, 32, 4))
        pixels[..., 3] = (pixels[..., 3] > 0.5) * 0.75
        write_image(source, pixels)
        assert synth(source, "-o", output) == 0
        made, there = (read_raster(path).numbers.reshape(-1, 4) for path in (output, source))
        assert {tuple(pixel) for pixel in made} <= {tuple(pixel) for pixel in there}
        assert 0.2 < (made[:, 3] > 0).mean() < 0.8

    def test_what_alpha_hides_does_not_matter(self, tmp_path: Path) -> None:
        """Transparent pixels of all colours look alike: the same pixels are copied."""
        random = np.random.default_rng(0)
        alpha = (random.random((32, 32, 1)) > 0.5).astype(np.float64)
        colours = random.random((32, 32, 3))
        for name, hidden in (("a", colours), ("b", colours * alpha)):
            write_image(tmp_path / f"{name}.png", np.concatenate([hidden, alpha], axis=2))
            assert synth(tmp_path / f"{name}.png", "-o", tmp_path / f"{name}_made.png") == 0
        made = [read_image(tmp_path / f"{name}_made.png") for name in "ab"]
        cover = made[0].alpha
        assert cover is not None
        np.testing.assert_array_equal(cover, made[1].alpha)
        np.testing.assert_array_equal(made[0].pixels[cover > 0], made[1].pixels[cover > 0])

    def test_a_picture_of_one_pixel_is_too_small(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        write_image(tmp_path / "dot.png", np.full((1, 1, 3), 0.5))
        for method in [*COPYING, "heeger-bergen"]:
            assert synth(tmp_path / "dot.png", "-o", tmp_path / "o.png", "--method", method) == 2
            captured = capsys.readouterr()
            assert captured.err.count("\n") == 1
            assert "1 x 1" in captured.err
        assert names(tmp_path) == ["dot.png"]

    @pytest.mark.parametrize("method", ["coherence", "ashikhmin", "quilting"])
    def test_one_pixel_is_made(self, exemplar: Path, method: str) -> None:
        output = exemplar.with_name("dot.png")
        assert synth(exemplar, "-o", output, "--size", "1x1", "--method", method) == 0
        assert read_raster(output).numbers.shape == (1, 1, 3)


class TestOtherMaps:
    def test_the_same_pixels_are_copied(self, exemplar: Path, capsys: pytest.CaptureFixture[str]) -> None:
        folder = exemplar.parent
        numbers = numbered(folder / "height.png", 64, 70)
        normal = np.random.default_rng(1).normal(size=(64, 70, 3))
        write_image(folder / "normal.exr", normal, colour_space="data")
        words = ["--also", folder / "height.png", folder / "normal.exr"]
        assert synth(exemplar, "-o", folder / "tile.png", "--size", "32x24", *words) == 0
        height = read_raster(folder / "tile_height.png").numbers
        assert height.dtype == np.uint16
        rank = np.searchsorted(numbers.ravel(), height[..., 0].ravel())
        rows, columns = (each.reshape(24, 32) for each in np.unravel_index(rank, (64, 70)))
        np.testing.assert_array_equal(
            read_raster(folder / "tile.png").numbers, read_raster(exemplar).numbers[rows, columns]
        )
        np.testing.assert_array_equal(
            read_raster(folder / "tile_normal.exr").numbers, np.float32(normal)[rows, columns]
        )
        assert capsys.readouterr().out.splitlines() == [
            f"{folder / name}: 32 x 24 pixels, tileable" for name in ("tile.png", "tile_height.png", "tile_normal.exr")
        ]

    def test_they_are_copied_from_the_region(self, exemplar: Path) -> None:
        folder = exemplar.parent
        numbers = numbered(folder / "height.png", 64, 70)
        words = ["--also", folder / "height.png", "--region", "30,20,24x30"]
        assert synth(exemplar, "-o", folder / "tile.png", *words) == 0
        assert np.isin(read_raster(folder / "tile_height.png").numbers, numbers[20:50, 30:54]).all()

    @pytest.mark.parametrize(
        ("maps", "told"),
        [
            (["a/normal.png", "b/normal.png"], "--also: two maps would be written to tile_normal.png"),
            (["a/small.png"], "--also: a/small.png is 69 x 64 pixels, and the exemplar is 70 x 64"),
            (["a/no.png"], "a/no.png: there is no such file"),
            (["a/normal.bmp"], "--also: a/normal.bmp: the result is of its format; convert it to .png, .tif,"),
            (["a/normal.png", "tile_normal.png"], "would be written over"),
            (["tile.png"], "would be written over"),
        ],
    )
    def test_maps_that_do_not_go_along_are_told(
        self,
        exemplar: Path,
        maps: list[str],
        told: str,
        capsys: pytest.CaptureFixture[str],
        monkeypatch: pytest.MonkeyPatch,
    ) -> None:
        from PIL import Image

        monkeypatch.chdir(exemplar.parent)
        for name in ("a", "b"):
            Path(name).mkdir()
            write_image(f"{name}/normal.png", np.zeros((64, 70, 3)))
        write_image("a/small.png", np.zeros((64, 69, 3)))
        Image.fromarray(np.zeros((64, 70, 3), np.uint8)).save("a/normal.bmp")
        for name in ("tile.png", "tile_normal.png"):
            write_image(name, np.full((64, 70, 3), 0.5))
        before = Path("tile.png").read_bytes()
        there = names(exemplar.parent)
        assert synth("exemplar.png", "-o", "tile.png", "--also", *maps) == 2
        captured = capsys.readouterr()
        assert told in captured.err
        assert captured.err.count("\n") == 1
        assert names(exemplar.parent) == there
        assert Path("tile.png").read_bytes() == before


class TestTargets:
    """What is asked for from afar: dark on the left, bright on the right."""

    words = ("--method", "ashikhmin", "--passes", "2")

    def paint(self, path: Path, *channels: float, colours: int = 1) -> None:
        target = np.full((64, 80, colours), 0.02)
        target[:, 40:] = 0.6
        cover = np.broadcast_to(np.float64(channels), (64, 80, len(channels)))
        write_image(path, np.concatenate([target, cover], axis=2))

    @pytest.fixture
    def grey(self, tmp_path: Path) -> Path:
        halves = np.where(np.arange(48) < 24, 0.02, 0.6)
        write_image(tmp_path / "grey.png", halves + np.random.default_rng(0).random((48, 48)) * 0.1)
        return tmp_path / "grey.png"

    @pytest.mark.parametrize("coloured", [False, True])
    def test_grey_targets_are_followed(self, grey: Path, coloured: bool) -> None:
        if coloured:
            write_image(grey, np.repeat(read_image(grey).pixels, 3, axis=2) * [1.0, 0.9, 0.8])
        target, output = grey.with_name("target.png"), grey.with_name("made.png")
        self.paint(target)
        assert synth(grey, "-o", output, *self.words, "--target", target) == 0
        made = read_image(output).pixels
        assert made.shape == (64, 80, 3 if coloured else 1)
        assert made[:, :38].mean() < 0.15
        assert made[:, 42:].mean() > 0.45

    def test_targets_of_bright_exemplars_are_no_brighter_than_they_look(self, grey: Path) -> None:
        bright = grey.with_name("bright.exr")
        write_image(bright, 4 * read_image(grey).pixels)
        target, output = grey.with_name("target.exr"), grey.with_name("made.exr")
        write_image(target, np.full((32, 40), 0.28))
        assert synth(bright, "-o", output, *self.words, "--target", target) == 0
        assert np.median(read_image(output).pixels) == pytest.approx(0.28, rel=0.3)

    def test_what_is_transparent_is_not_painted(self, grey: Path) -> None:
        target, empty, plain = (grey.with_name(name) for name in ("target.png", "empty.png", "plain.png"))
        self.paint(target, 0.0)
        assert synth(grey, "-o", empty, *self.words, "--target", target) == 0
        assert synth(grey, "-o", plain, *self.words, "--size", "80x64") == 0
        assert empty.read_bytes() == plain.read_bytes()

    @pytest.mark.parametrize(
        ("colours", "words", "told"),
        [
            (3, [], "is coloured, and the exemplar is grey"),
            (1, ["--size", "64x64"], "target.png is 80 x 64 pixels, and --size is 64x64"),
        ],
    )
    def test_targets_of_another_kind_are_told(
        self, grey: Path, colours: int, words: list[str], told: str, capsys: pytest.CaptureFixture[str]
    ) -> None:
        target = grey.with_name("target.png")
        self.paint(target, colours=colours)
        assert synth(grey, "-o", grey.with_name("made.png"), *self.words, "--target", target, *words) == 2
        captured = capsys.readouterr()
        assert told in captured.err
        assert captured.err.count("\n") == 1
        assert names(grey.parent) == ["grey.png", "target.png"]

    def test_a_transparent_exemplar_is_told(self, grey: Path, capsys: pytest.CaptureFixture[str]) -> None:
        write_image(grey, np.random.default_rng(0).random((64, 64, 2)))
        target = grey.with_name("target.png")
        self.paint(target)
        assert synth(grey, "-o", grey.with_name("made.png"), *self.words, "--target", target) == 2
        assert "--target: goes with an opaque exemplar" in capsys.readouterr().err


class TestGuides:
    @pytest.fixture
    def halves(self, tmp_path: Path) -> Path:
        """Dark on the left and bright on the right; the guide is grey, as is the one of the result, bright above."""
        pixels = np.random.default_rng(0).random((64, 64)) * 0.2
        pixels[:, 32:] += 0.6
        write_image(tmp_path / "exemplar.png", pixels)
        write_image(tmp_path / "from.png", np.repeat([0.0, 1.0], 32)[None].repeat(64, axis=0))
        write_image(tmp_path / "to.png", np.repeat([1.0, 0.0], 24)[:, None].repeat(40, axis=1))
        return tmp_path / "exemplar.png"

    def test_a_guide_that_weighs_more_makes_another_picture(self, halves: Path) -> None:
        guides = ["--guide", *(halves.with_name(name) for name in ("from.png", "to.png"))]
        for name, words in (
            ("made.png", []),
            ("same.png", ["--guide-weight", "0.5"]),
            ("more.png", ["--guide-weight", "2"]),
        ):
            assert synth(halves, "-o", halves.with_name(name), *guides, *words) == 0
        made, same, more = (halves.with_name(name).read_bytes() for name in ("made.png", "same.png", "more.png"))
        assert made == same != more

    def test_the_guide_tells_where(self, halves: Path) -> None:
        guides = [halves.with_name(name) for name in ("from.png", "to.png")]
        assert synth(halves, "-o", halves.with_name("made.png"), "--guide", *guides) == 0
        made = read_image(halves.with_name("made.png")).pixels[..., 0]
        assert made.shape == (48, 40)
        assert (made[3:21] > 0.4).mean() > 0.99
        assert (made[27:45] < 0.4).mean() > 0.99

    @pytest.mark.parametrize(
        ("words", "told"),
        [
            (["--guide", "from.png"], "guide"),
            (["--guide", "to.png", "to.png"], "--guide: to.png is 40 x 48 pixels, and the exemplar is 64 x 64"),
            (["--guide", "from.png", "coloured.png"], "is grey or transparent; make both alike"),
            (
                ["--guide", "from.png", "to.png", "--size", "9x9"],
                "--guide: to.png is 40 x 48 pixels, and --size is 9x9",
            ),
            (["--guide", "from.png", "to.png", "--region", "0,0,32x32"], "--region: does not go with --guide"),
            (["--guide", "from.png", "no.png"], "no.png: there is no such file"),
        ],
    )
    def test_guides_that_do_not_go_along_are_told(
        self,
        halves: Path,
        words: list[str],
        told: str,
        capsys: pytest.CaptureFixture[str],
        monkeypatch: pytest.MonkeyPatch,
    ) -> None:
        monkeypatch.chdir(halves.parent)
        write_image("coloured.png", np.zeros((48, 40, 3)))
        there = names(halves.parent)
        assert synth("exemplar.png", "-o", "made.png", *words) == 2
        captured = capsys.readouterr()
        assert told in captured.err
        assert "Traceback" not in captured.err
        assert names(halves.parent) == there


class TestTextonMasks:
    @pytest.fixture
    def mask(self, exemplar: Path) -> Path:
        path = exemplar.with_name("mask.png")
        row, column = np.indices((64, 70))
        write_mask(path, np.hypot(row % 16 - 8, column % 16 - 8) < 5)
        return path

    def test_elements_are_those_of_the_mask(self, exemplar: Path, mask: Path) -> None:
        from jaxtex.progressive.masked import synthesise_masked

        output = exemplar.with_name("made.png")
        words = ["--texton-mask", mask, "--also", mask, "--size", "50x40", "--seed", "3"]
        assert synth(exemplar, "-o", output, *words) == 0
        pixels, marked = read_image(exemplar).pixels, read_mask(mask) > 0.5
        sources = synthesise_masked(linear_to_srgb(pixels), marked, (40, 50), key=jax.random.key(3))
        np.testing.assert_array_equal(read_image(output).pixels, pixels[sources[..., 0], sources[..., 1]])
        made = read_mask(exemplar.with_name("made_mask.png")) > 0.5
        np.testing.assert_array_equal(made, marked[sources[..., 0], sources[..., 1]])

    @pytest.mark.parametrize(
        ("words", "told"),
        [
            (["--texton-mask", "none.png"], "none.png"),
            (["--texton-mask", "small.png"], "20 x 20"),
            (["--texton-mask", "black.png"], "one value alone"),
            (["--texton-mask", "mask.png", "--method", "ashikhmin"], "--texton-mask: goes with --method coherence"),
            (["--texton-mask", "mask.png", "--region", "0,0,40x40"], "--region: does not go with --texton-mask"),
            (
                ["--texton-mask", "mask.png", "--guide", "mask.png", "mask.png"],
                "--guide: does not go with --texton-mask",
            ),
            (["--texton-mask", "mask.png", "--inpaint", "mask.png"], "--texton-mask: does not go with --inpaint"),
        ],
    )
    def test_masks_that_do_not_go_along_are_told(
        self,
        exemplar: Path,
        mask: Path,
        words: list[str],
        told: str,
        capsys: pytest.CaptureFixture[str],
        monkeypatch: pytest.MonkeyPatch,
    ) -> None:
        monkeypatch.chdir(exemplar.parent)
        write_mask("small.png", np.eye(20))
        write_mask("black.png", np.zeros((64, 70)))
        there = names(exemplar.parent)
        assert synth("exemplar.png", "-o", "made.png", *words) == 2
        error = capsys.readouterr().err
        assert told in error
        assert error.count("\n") == 1
        assert names(exemplar.parent) == there


class TestInpainting:
    @pytest.fixture
    def checks(self, tmp_path: Path) -> np.ndarray:
        """A regular picture, the same with a smear, and the mask of the smear."""
        picture = np.tile(np.random.default_rng(5).random((8, 8, 3)), (8, 8, 1))
        hole = np.zeros((64, 64), bool)
        hole[20:33, 24:36] = True
        write_image(tmp_path / "whole.png", picture, bits=16)
        write_image(tmp_path / "wall.png", np.where(hole[..., None], 0.9, picture), bits=16)
        write_image(tmp_path / "hole.png", hole.astype(float), colour_space="data")
        return hole

    @pytest.mark.parametrize("method", ["coherence", "efros-leung"])
    def test_holes_are_filled_and_the_rest_stays(self, tmp_path: Path, checks: np.ndarray, method: str) -> None:
        numbered(tmp_path / "height.png", 64, 64)
        words = ["--method", method, "--inpaint", tmp_path / "hole.png", "--also", tmp_path / "height.png"]
        assert synth(tmp_path / "wall.png", "-o", tmp_path / "made.png", *words) == 0
        made, whole = (read_raster(tmp_path / name).numbers for name in ("made.png", "whole.png"))
        np.testing.assert_array_equal(made, whole)
        made, there = (read_raster(tmp_path / name).numbers for name in ("made_height.png", "height.png"))
        np.testing.assert_array_equal(made[~checks], there[~checks])
        assert not np.isin(made, there[checks]).any()

    def test_it_is_not_said_to_be_tileable(
        self, tmp_path: Path, checks: np.ndarray, capsys: pytest.CaptureFixture[str]
    ) -> None:
        words = ["-o", tmp_path / "made.png", "--inpaint", tmp_path / "hole.png"]
        assert synth(tmp_path / "wall.png", *words) == 0
        assert capsys.readouterr().out == f"{tmp_path / 'made.png'}: 64 x 64 pixels\n"

    @pytest.mark.parametrize(
        ("mask", "words", "told"),
        [
            (np.ones((64, 64)), [], "mask.png is all white; paint what is to be filled white"),
            (np.zeros((64, 64)), [], "mask.png is all black"),
            (np.eye(64, 60), [], "--inpaint: mask.png is 60 x 64 pixels, and the picture is 64 x 64"),
            (np.eye(64), ["--size", "64x64"], "--size: does not go with --inpaint"),
            (np.eye(64), ["--region", "0,0,32x32"], "--region: does not go with --inpaint"),
            (np.eye(64), ["--tileable"], "--tileable: does not go with --inpaint"),
            (np.eye(64), ["--guide", "wall.png", "wall.png"], "--guide: does not go with --inpaint"),
            (np.eye(64), ["--method", "quilting"], "--inpaint: goes with --method coherence or efros-leung"),
            (np.indices((64, 64)).sum(axis=0) % 5 / 4.0 == 0, [], "--inpaint: mask.png: no neighbourhood of 7 x 7"),
            (
                np.indices((64, 64)).sum(axis=0) % 5 / 4.0 == 0,
                ["--method", "efros-leung"],
                "--inpaint: mask.png: ",
            ),
        ],
    )
    def test_masks_that_tell_nothing_are_told(
        self,
        tmp_path: Path,
        checks: np.ndarray,
        mask: np.ndarray,
        words: list[str],
        told: str,
        capsys: pytest.CaptureFixture[str],
        monkeypatch: pytest.MonkeyPatch,
    ) -> None:
        monkeypatch.chdir(tmp_path)
        write_image("mask.png", mask.astype(float), colour_space="data")
        there = names(tmp_path)
        assert synth("wall.png", "-o", "made.png", "--inpaint", "mask.png", *words) == 2
        captured = capsys.readouterr()
        assert told in captured.err
        assert captured.err.count("\n") == 1
        assert names(tmp_path) == there


class TestPreviews:
    @pytest.mark.parametrize("method", ["coherence", "ashikhmin", "quilting"])
    def test_the_last_preview_is_the_result(self, exemplar: Path, method: str) -> None:
        output, preview = exemplar.with_name("made.png"), exemplar.with_name("preview.png")
        words = ["--method", method, "--size", "40x32", "--preview", preview]
        assert synth(exemplar, "-o", output, *words) == 0
        np.testing.assert_array_equal(read_raster(preview).numbers, read_raster(output).numbers)
        assert names(exemplar.parent) == ["exemplar.png", "made.png", "preview.png"]

    def test_what_is_known_is_seen_while_holes_are_filled(self, exemplar: Path) -> None:
        hole = np.zeros((64, 70))
        hole[20:30, 20:30] = 1
        write_image(exemplar.with_name("hole.png"), hole, colour_space="data")
        output, preview = exemplar.with_name("made.png"), exemplar.with_name("preview.png")
        words = ["--inpaint", exemplar.with_name("hole.png"), "--method", "efros-leung", "--preview", preview]
        assert synth(exemplar, "-o", output, *words) == 0
        np.testing.assert_array_equal(read_raster(preview).numbers, read_raster(output).numbers)


class TestBlending:
    def test_seams_are_softened_and_the_rest_stays(self, exemplar: Path) -> None:
        write_image(exemplar, np.random.default_rng(0).random((64, 64, 3)), bits=16)
        sharp, soft = exemplar.with_name("sharp.png"), exemplar.with_name("soft.png")
        words = ["--method", "quilting", "--size", "48x40", "--block", "24"]
        assert synth(exemplar, "-o", sharp, *words) == 0
        assert synth(exemplar, "-o", soft, *words, "--blend", "0.6") == 0
        first, second = (read_raster(path).numbers.astype(int) for path in (sharp, soft))
        assert read_raster(soft).numbers.dtype == np.uint16
        same = (np.abs(first - second) <= 1).all(axis=2)
        assert 0.3 < same.mean() < 0.95
        assert same[0].mean() > 0.8  # the border of a picture that does not repeat is no seam
        assert np.abs(np.diff(second, axis=1)).mean() < np.abs(np.diff(first, axis=1)).mean()

    def test_bright_pictures_stay_bright(self, exemplar: Path) -> None:
        source, output = exemplar.with_name("sun.exr"), exemplar.with_name("made.exr")
        write_image(source, 20 * np.random.default_rng(0).random((32, 32, 3)))
        words = ["--method", "quilting", "--blend", "0.4", "--size", "32x32"]
        assert synth(source, "-o", output, *words, "--preview", exemplar.with_name("seen.exr")) == 0
        for name in ("made.exr", "seen.exr"):
            assert read_image(exemplar.with_name(name)).pixels.mean() == pytest.approx(10, rel=0.1)

    def test_floats_stay_floats(self, exemplar: Path) -> None:
        source, output = exemplar.with_name("sun.tif"), exemplar.with_name("made.tif")
        write_image(source, 20 * np.random.default_rng(0).random((32, 32, 3)), colour_space="linear", bits="float")
        words = ["--method", "quilting", "--blend", "0.4", "--size", "32x32"]
        assert synth(source, "-o", output, *words) == 0
        assert read_raster(output).numbers.dtype == np.float32
        assert read_image(output).pixels.mean() == pytest.approx(10, rel=0.1)

    def test_alpha_is_blended_too(self, exemplar: Path) -> None:
        pixels = np.full((32, 32, 4), 0.5)
        pixels[..., 3] = np.random.default_rng(0).random((32, 32)) > 0.5
        write_image(exemplar, pixels)
        output = exemplar.with_name("made.exr")
        assert synth(exemplar, "-o", output, "--blend", "1") == 0
        made = read_image(output)
        assert made.alpha is not None
        assert 0.3 < made.alpha.mean() < 0.7
        assert ((made.alpha > 0.05) & (made.alpha < 0.95)).any()
        np.testing.assert_allclose(made.pixels[made.alpha > 0.05], 0.5, atol=0.01)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--size", "0x64"], "--size: '0x64' is no size"),
        (["--size", "64"], "--size: '64' is no size"),
        ([*NOISE, "--size", "900000x900000"], "--size: 900000x900000 takes"),
        (["--size", "900000x900000"], "--size: 900000x900000 takes"),
        (["--preview", "exemplar.png"], "exemplar.png: would be written over"),
        ([*NOISE, "--size", "60x64"], "--size: 60x64 holds 3 scales, not 4; give 64 pixels"),
        ([*NOISE, "--size", "64x64", "--finer", "1"], "holds 4 scales, not 4 and 1 finer; give 128 pixels"),
        (
            [*NOISE, "--scales", "5"],
            "--scales: 5 do not fit what is learnt from, which is 70 x 64 pixels; give at most 4",
        ),
        ([*NOISE, "--scales", "0"], "--scales: 0 is out of range"),
        ([*NOISE, "--orientations", "0"], "--orientations: 0 is out of range"),
        ([*NOISE, "--orientations", "17"], "--orientations: 17 is out of range"),
        ([*NOISE, "--iterations", "0"], "--iterations: 0 is out of range"),
        ([*NOISE, "--finer", "-1"], "--finer: -1 is out of range"),
        ([*NOISE, "--finer", "99"], "--finer: 99 is out of range"),
        (["--seed", "-1"], "--seed: -1 is out of range"),
        (["--method", "photoshop"], "'photoshop'"),
        (["--region", "0,0,64"], "--region: '0,0,64' is no rectangle"),
        (["--region", "30,0,64x64"], "--region: 30,0,64x64 lies outside"),
        (["--region", "-1,0,64x64"], "--region: -1,0,64x64 lies outside"),
        ([*NOISE, "--region", "30,0,64x64"], "--region: 30,0,64x64 lies outside"),
        (
            [*NOISE, "--region", "0,0,16x16"],
            "--scales: 4 do not fit what is learnt from, which is 16 x 16 pixels; give at most 2",
        ),
        ([*NOISE, "--region", "0,0,64x64", "--region", "0,0,64x63"], "--region: sizes are 64x63, 64x64"),
        (["--region", "0,0,32x32", "--region", "32,0,32x32"], "--region: coherence learns from one"),
        (["-o", "texture.xyz"], "texture.xyz: cannot be written"),
        (["-o", "nowhere/texture.png"], "no folder nowhere"),
        ([*NOISE, "-o", "texture.xyz"], "texture.xyz: cannot be written"),
        (["--preview", "seen.xyz"], "seen.xyz: cannot be written"),
        (["--preview", "nowhere/seen.png"], "no folder nowhere"),
        # Options that other methods take.
        (["--passes", "5"], "--passes: goes with --method ashikhmin, not with coherence"),
        (["--similar", "2"], "--similar: goes with --method ashikhmin, not with coherence"),
        (["--target", "exemplar.png"], "--target: goes with --method ashikhmin, not with coherence"),
        (["--block", "16"], "--block: goes with --method quilting, not with coherence"),
        (["--levels", "2"], "--levels: goes with --method wei-levoy, not with coherence"),
        (["--search", "tree"], "--search: goes with --method wei-levoy, not with coherence"),
        (["--scales", "4"], "--scales: goes with --method heeger-bergen, not with coherence"),
        (["--scales", "0"], "--scales: goes with --method heeger-bergen, not with coherence"),
        (["--finer", "0"], "--finer: goes with --method heeger-bergen, not with coherence"),
        (["--method", "quilting", "--neighborhood", "5"], "--neighborhood: goes with --method coherence or"),
        (["--method", "wei-levoy", "--tileable"], "--tileable: goes with --method coherence or"),
        (["--method", "ashikhmin", "--guide", "exemplar.png", "exemplar.png"], "--guide: goes with --method coherence"),
        (["--method", "wei-levoy", "--preview", "seen.png"], "--preview: goes with --method"),
        ([*NOISE, "--also", "exemplar.png"], "--also: goes with --method coherence or"),
        ([*NOISE, "--blend", "1"], "--blend: goes with --method coherence or"),
        # Numbers that are none.
        (["--neighborhood", "6"], "--neighborhood: 6 has no middle; give an odd number"),
        (["--neighborhood", "1"], "--neighborhood: 1 is out of range; give a number from 3 to 41"),
        (["--neighborhood", "43"], "--neighborhood: 43 is out of range"),
        (
            ["--neighborhood", "33", "--region", "0,0,32x40"],
            "what is learnt from is 32 x 40 pixels, and neighborhoods are 33 x 33; give a larger picture, or a smaller",
        ),
        (["--guide-weight", "2"], "--guide-weight: there is no --guide that it could be of"),
        (["-o", "exemplar.png"], "exemplar.png is the exemplar, which would be written over"),
        (["-o", "exemplar.png", "--method", "heeger-bergen"], "which would be written over"),
        (["-o", "from.png", "--guide", "from.png", "to.png"], "from.png is the first of the guides, which"),
        (["-o", "to.png", "--guide", "from.png", "to.png"], "to.png is the second of the guides, which"),
        (["-o", "t.png", "--method", "ashikhmin", "--target", "t.png"], "t.png is the target, which"),
        (["-o", "m.png", "--inpaint", "m.png"], "m.png is the mask, which"),
        (["--preview", "texture.png"], "texture.png: would be written over"),
        (["--preview", "m.png", "--inpaint", "m.png"], "m.png: would be written over"),
        (
            ["--preview", "texture_exemplar.png", "--also", "exemplar.png"],
            "texture_exemplar.png: would be written over",
        ),
        (["--blend", "0"], "--blend: 0.0 is out of range"),
        (["--blend", "nan"], "--blend: nan is out of range"),
        (["--method", "ashikhmin", "--passes", "0"], "--passes: 0 is out of range"),
        (["--method", "ashikhmin", "--similar", "0"], "--similar: 0 is out of range"),
        (["--method", "wei-levoy", "--levels", "0"], "--levels: 0 is out of range"),
        (["--method", "wei-levoy", "--levels", "5"], "--levels: "),
        (["--method", "quilting", "--block", "1"], "--block: 1 is out of range; give 2 or more"),
        (["--method", "quilting", "--block", "65"], "--block: block of 65 pixels: give 2 to 64"),
        (["--method", "quilting", "--tileable", "--size", "1x9"], "error: shape: (9, 1) cannot be tileable"),
    ],
)
def test_what_cannot_be_done_is_told_in_one_line(
    exemplar: Path, options: list[str], told: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(exemplar.parent)
    output = [] if "-o" in options else ["-o", "texture.png"]
    assert synth(exemplar.name, *options, *output) == 2
    captured = capsys.readouterr()
    assert told in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""
    assert names(exemplar.parent) == [exemplar.name]


def test_the_exemplar_is_not_written_over_by_another_map(exemplar: Path, capsys: pytest.CaptureFixture[str]) -> None:
    colours = exemplar.rename(exemplar.with_name("tile_normal.png"))
    write_image(exemplar.with_name("normal.png"), np.zeros((64, 70)))
    before = colours.read_bytes()
    words = ["-o", exemplar.with_name("tile.png"), "--also", exemplar.with_name("normal.png")]
    assert synth(colours, *words) == 2
    assert "would be written over" in capsys.readouterr().err
    assert colours.read_bytes() == before


def test_an_opaque_format_is_told_before_the_work(exemplar: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_image(exemplar, np.random.default_rng(0).random((64, 64, 4)))
    assert synth(exemplar, "-o", exemplar.with_name("o.jpg")) == 2
    assert "a JPEG file has no alpha" in capsys.readouterr().err
    assert names(exemplar.parent) == ["exemplar.png"]


@pytest.mark.parametrize("method", ["coherence", "heeger-bergen"])
def test_a_missing_exemplar_is_told(tmp_path: Path, method: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert synth(tmp_path / "no.png", "-o", tmp_path / "o.png", "--method", method) == 2
    assert "no.png: there is no such file" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
