"""Tests of `jaxtex.io.copies`: copied files are read again and compared number by number, or as pictures."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.io.copies import check_copies, write_copies
from jaxtex.io.images import Bits, ColourSpace, read_image, write_image
from jaxtex.io.raster import read_raster, writing_raster

# Where the pixels of a 5 x 4 picture (5 wide) go: larger, mirrored, some twice, some not at all.
ROWS, COLUMNS = (np.random.default_rng(1).integers(0, side, (6, 7)) for side in (4, 5))


def noise(*shape: int, high: float = 1.0) -> np.ndarray:
    return np.random.default_rng(0).uniform(0, high, (4, 5, *shape))


def write_numbers(path: Path, numbers: np.ndarray, channels: tuple[str, ...] | int, **attributes: Any) -> None:
    kind = {"float32": "float"}.get(numbers.dtype.name, numbers.dtype.name)
    size = (numbers.shape[1], numbers.shape[0])
    with writing_raster(path, size=size, channels=channels, kind=kind, attributes=attributes) as write_rows:
        write_rows(numbers)


def check_same(source: Path, copy: Path) -> None:
    """The very numbers, and all that tells what they mean."""
    expected, found = read_raster(source), read_raster(copy)
    assert found.numbers.dtype == expected.numbers.dtype
    np.testing.assert_array_equal(found.numbers, expected.numbers[ROWS, COLUMNS])
    assert found.channels == expected.channels
    if "A" in expected.channels:
        assert found.premultiplied == expected.premultiplied
    if set(expected.channels) <= set("YRGBA"):
        assert read_image(copy).colour_space == read_image(source).colour_space


def check_alike(source: Path, copy: Path, atol: float) -> None:
    """The same picture, in linear light."""
    expected, found = read_image(source), read_image(copy)
    np.testing.assert_allclose(found.pixels, expected.pixels[ROWS, COLUMNS], atol=atol)
    if expected.alpha is not None:
        assert found.alpha is not None
        np.testing.assert_allclose(found.alpha, expected.alpha[ROWS, COLUMNS], atol=0.003)


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
@pytest.mark.parametrize(
    ("suffix", "bits", "space"),
    [
        (".png", 8, "srgb"),
        (".png", 16, "srgb"),
        (".png", 8, "linear"),
        (".png", 16, "data"),
        (".tif", 8, "srgb"),
        (".tif", 16, "srgb"),
        (".tif", "float", "linear"),
        (".exr", "half", "linear"),
        (".exr", "float", "linear"),
        (".exr", "float", "data"),
    ],
)
def test_the_numbers_are_copied(tmp_path: Path, channels: int, suffix: str, bits: Bits, space: ColourSpace) -> None:
    source, copy = tmp_path / f"source{suffix}", tmp_path / f"copy{suffix}"
    write_image(source, noise(channels), bits=bits, colour_space=space)
    write_copies(source, copy, ROWS, COLUMNS)
    check_same(source, copy)


@pytest.mark.parametrize(
    ("source", "copy", "bits"),
    [
        ("a.png", "b.tif", 8),
        ("a.png", "b.TIFF", 16),
        ("a.tif", "b.png", 16),
        ("a.exr", "b.tif", "float"),
        ("a.tif", "b.png", 8),
    ],
)
def test_they_are_copied_to_other_formats_that_hold_them(tmp_path: Path, source: str, copy: str, bits: Bits) -> None:
    write_image(tmp_path / source, noise(3), bits=bits)
    write_copies(tmp_path / source, tmp_path / copy, ROWS, COLUMNS)
    check_same(tmp_path / source, tmp_path / copy)


def test_values_beyond_0_to_1_are_kept(tmp_path: Path) -> None:
    height = np.random.default_rng(0).normal(0, 1e5, (4, 5))
    write_image(tmp_path / "height.exr", height, colour_space="data")
    write_copies(tmp_path / "height.exr", tmp_path / "copy.exr", ROWS, COLUMNS)
    np.testing.assert_array_equal(read_raster(tmp_path / "copy.exr").numbers[..., 0], np.float32(height)[ROWS, COLUMNS])
    assert read_image(tmp_path / "copy.exr").colour_space == "data"


def test_names_of_channels_are_kept(tmp_path: Path) -> None:
    """A slope's x and y are no grey and alpha."""
    write_numbers(tmp_path / "slope.exr", noise(2).astype(np.float32), ("X", "Y"))
    write_copies(tmp_path / "slope.exr", tmp_path / "copy.exr", ROWS, COLUMNS)
    check_same(tmp_path / "slope.exr", tmp_path / "copy.exr")


def test_any_number_of_channels_is_copied(tmp_path: Path) -> None:
    write_numbers(tmp_path / "many.exr", noise(6).astype(np.float32), 6)
    write_copies(tmp_path / "many.exr", tmp_path / "copy.exr", ROWS, COLUMNS)
    check_same(tmp_path / "many.exr", tmp_path / "copy.exr")


def test_a_gamma_of_its_own_is_kept_by_png_and_applied_elsewhere(tmp_path: Path) -> None:
    numbers = np.random.default_rng(0).integers(0, 256, (4, 5, 3), np.uint8)
    write_numbers(tmp_path / "a.png", numbers, 3, **{"oiio:Gamma": 1.8, "oiio:ColorSpace": "g18_rec709_scene"})
    assert read_image(tmp_path / "a.png").colour_space == "gamma 1.8"
    write_copies(tmp_path / "a.png", tmp_path / "b.png", ROWS, COLUMNS)
    check_same(tmp_path / "a.png", tmp_path / "b.png")
    write_copies(tmp_path / "a.png", tmp_path / "b.tif", ROWS, COLUMNS)
    check_alike(tmp_path / "a.png", tmp_path / "b.tif", atol=0.005)


@pytest.mark.parametrize("bits", [8, 16])
def test_linear_numbers_are_encoded_where_the_file_cannot_say_so(tmp_path: Path, bits: Bits) -> None:
    write_image(tmp_path / "a.png", noise(3), colour_space="linear", bits=bits)
    write_copies(tmp_path / "a.png", tmp_path / "b.tif", ROWS, COLUMNS)
    assert read_raster(tmp_path / "b.tif").numbers.dtype.name == f"uint{bits}"
    check_alike(tmp_path / "a.png", tmp_path / "b.tif", atol={8: 0.005, 16: 2e-5}[bits])


def test_primaries_are_kept(tmp_path: Path) -> None:
    primaries = (0.7, 0.3, 0.17, 0.8, 0.13, 0.05, 0.3127, 0.329)
    write_numbers(tmp_path / "a.exr", noise(3).astype(np.float32), 3, chromaticities=primaries)
    write_copies(tmp_path / "a.exr", tmp_path / "b.exr", ROWS, COLUMNS)
    assert read_raster(tmp_path / "b.exr").attributes["chromaticities"] == pytest.approx(primaries)


def test_profiles_are_kept(tmp_path: Path) -> None:
    from PIL import Image, ImageCms

    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    numbers = np.random.default_rng(0).integers(0, 256, (4, 5, 3), np.uint8)
    Image.fromarray(numbers).save(tmp_path / "a.png", icc_profile=profile)
    for name in ("b.png", "b.tif"):
        write_copies(tmp_path / "a.png", tmp_path / name, ROWS, COLUMNS)
        assert Image.open(tmp_path / name).info["icc_profile"] == profile


@pytest.mark.parametrize("channels", [2, 4])
def test_alpha_means_the_same_in_exr(tmp_path: Path, channels: int) -> None:
    """A TIFF file's colours are not multiplied by alpha, an EXR file's are."""
    write_image(tmp_path / "a.tif", noise(channels, high=3.0), bits="float", colour_space="linear")
    write_copies(tmp_path / "a.tif", tmp_path / "b.exr", ROWS, COLUMNS)
    expected, found = read_image(tmp_path / "a.tif"), read_image(tmp_path / "b.exr")
    assert found.alpha is not None
    assert expected.alpha is not None
    np.testing.assert_allclose(found.pixels, expected.pixels[ROWS, COLUMNS], rtol=2e-3)  # half floats
    np.testing.assert_allclose(found.alpha, expected.alpha[ROWS, COLUMNS], rtol=1e-3)
    assert read_raster(tmp_path / "b.exr").premultiplied


def test_colours_under_no_alpha_stay(tmp_path: Path) -> None:
    numbers = np.random.default_rng(0).integers(1, 256, (4, 5, 4), np.uint8)
    numbers[::2, :, 3] = 0
    write_numbers(tmp_path / "a.png", numbers, 4, **{"oiio:UnassociatedAlpha": 1})
    write_copies(tmp_path / "a.png", tmp_path / "b.png", ROWS, COLUMNS)
    np.testing.assert_array_equal(read_raster(tmp_path / "b.png").numbers, numbers[ROWS, COLUMNS])


def test_premultiplied_integers_stay_as_they_are(tmp_path: Path) -> None:
    numbers = np.random.default_rng(0).integers(128, 256, (4, 5, 4), np.uint8)
    numbers[..., :3] //= 2
    write_numbers(tmp_path / "a.tif", numbers, 4, **{"oiio:UnassociatedAlpha": 0})
    assert read_raster(tmp_path / "a.tif").premultiplied
    write_copies(tmp_path / "a.tif", tmp_path / "b.tif", ROWS, COLUMNS)
    check_same(tmp_path / "a.tif", tmp_path / "b.tif")
    write_copies(tmp_path / "a.tif", tmp_path / "b.png", ROWS, COLUMNS)
    check_alike(tmp_path / "a.tif", tmp_path / "b.png", atol=0.005)


@pytest.mark.parametrize(
    ("source", "copy", "atol"),
    [("a.exr", "b.png", 0.005), ("a.png", "b.exr", 5e-4), ("a.exr", "b.tif", 0)],
)
def test_what_a_format_cannot_hold_is_converted(tmp_path: Path, source: str, copy: str, atol: float) -> None:
    write_image(tmp_path / source, noise(3))
    write_copies(tmp_path / source, tmp_path / copy, ROWS, COLUMNS)
    check_alike(tmp_path / source, tmp_path / copy, atol=atol)


def test_integers_of_32_bits_are_converted(tmp_path: Path) -> None:
    """They are read as fractions of the largest, and would mean something else as floats."""
    from PIL import Image

    Image.fromarray(np.random.default_rng(0).integers(0, 2**31, (4, 5), np.int32)).save(tmp_path / "a.tif")
    raster = read_raster(tmp_path / "a.tif")
    assert raster.integer
    assert raster.numbers.dtype == np.float32
    for name, atol in (("b.tif", 2e-5), ("b.exr", 5e-4)):
        write_copies(tmp_path / "a.tif", tmp_path / name, ROWS, COLUMNS)
        check_alike(tmp_path / "a.tif", tmp_path / name, atol=atol)


def test_photographs_are_upright(tmp_path: Path) -> None:
    from PIL import Image

    numbers = np.kron(np.array([[0, 80], [160, 250], [40, 120]], np.uint8), np.ones((8, 8), np.uint8))
    picture = Image.fromarray(numbers)
    exif = picture.getexif()
    exif[0x0112] = 6  # to be turned clockwise
    picture.save(tmp_path / "a.jpg", exif=exif, quality=100)
    upright = np.rot90(numbers, -1)
    rows, columns = np.indices(upright.shape)
    for name in ("b.png", "b.jpg"):
        write_copies(tmp_path / "a.jpg", tmp_path / name, rows, columns)
        raster = read_raster(tmp_path / name)
        assert raster.attributes.get("Orientation", 1) == 1
        np.testing.assert_allclose(raster.numbers[..., 0].astype(int), upright, atol=12)
    exact = read_raster(tmp_path / "a.jpg").numbers
    np.testing.assert_array_equal(read_raster(tmp_path / "b.png").numbers, exact)


def test_the_same_bytes_each_time(tmp_path: Path) -> None:
    for suffix in (".png", ".tif", ".exr", ".jpg"):
        write_image(tmp_path / f"a{suffix}", noise(3))
        for name in "bc":
            write_copies(tmp_path / f"a{suffix}", tmp_path / f"{name}{suffix}", ROWS, COLUMNS)
        assert (tmp_path / f"b{suffix}").read_bytes() == (tmp_path / f"c{suffix}").read_bytes()


@pytest.mark.parametrize(("row", "column"), [(-1, 0), (0, -1), (4, 0), (0, 5)])
def test_places_outside_are_told(tmp_path: Path, row: int, column: int) -> None:
    write_image(tmp_path / "a.png", noise(3))
    with pytest.raises(InputError, match=r"a.png: is 5 x 4 pixels, and pixels beyond"):
        write_copies(tmp_path / "a.png", tmp_path / "b.png", np.full((2, 2), row), np.full((2, 2), column))
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]


@pytest.mark.parametrize(
    ("channels", "name", "told"),
    [
        (3, "b.bmp", "b.bmp: cannot be written as '.bmp'; name it .png"),
        (3, "b", "cannot be written as ''"),
        (4, "b.jpg", "b.jpg: a JPEG file has no alpha"),
        (2, "b.jpeg", "b.jpeg: a JPEG file has no alpha"),
        (3, "nowhere/b.png", "there is no folder"),
    ],
)
def test_files_that_cannot_be_written_are_told_also_beforehand(
    tmp_path: Path, channels: int, name: str, told: str
) -> None:
    write_image(tmp_path / "a.png", noise(channels))
    with pytest.raises(InputError, match=told):
        check_copies(tmp_path / "a.png", tmp_path / name)
    with pytest.raises(InputError, match=told):
        write_copies(tmp_path / "a.png", tmp_path / name, ROWS, COLUMNS)
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]


def test_what_can_be_written_passes(tmp_path: Path) -> None:
    write_image(tmp_path / "a.png", noise(3))
    for name in ("b.png", "b.JPG", "b.tif", "b.exr", "a.png"):
        check_copies(tmp_path / "a.png", tmp_path / name)
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]


def test_a_missing_picture_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no.png: there is no such file"):
        write_copies(tmp_path / "no.png", tmp_path / "b.png", ROWS, COLUMNS)
    with pytest.raises(InputError, match=r"no.png: there is no such file"):
        check_copies(tmp_path / "no.png", tmp_path / "b.png")


def test_a_picture_may_be_replaced_by_its_copy(tmp_path: Path) -> None:
    write_image(tmp_path / "a.png", noise(3), bits=16)
    before = read_raster(tmp_path / "a.png").numbers
    write_copies(tmp_path / "a.png", tmp_path / "a.png", ROWS, COLUMNS)
    np.testing.assert_array_equal(read_raster(tmp_path / "a.png").numbers, before[ROWS, COLUMNS])
