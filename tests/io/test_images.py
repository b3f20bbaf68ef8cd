"""Images in and out: every kind of file gives the right numbers, and every bad one a single clear line."""

import hashlib
import zlib
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import PIL.Image
import PIL.PngImagePlugin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import jaxtex as jt
from jaxtex.core.colour import srgb_to_linear
from jaxtex.io import raster

RNG = np.random.default_rng(3)
BYTES = RNG.integers(0, 256, (5, 7, 3), dtype=np.uint8)
LINEAR = srgb_to_linear(BYTES / np.float64(255))


def write_with_oiio(path: Path, numbers: np.ndarray, kind: str, **attributes: object) -> Path:
    spec = oiio.ImageSpec(numbers.shape[1], numbers.shape[0], numbers.shape[2], kind)
    for name, value in attributes.items():
        spec.attribute(name.replace("__", ":"), value)
    target = oiio.ImageOutput.create(str(path))
    assert target.open(str(path), spec)
    assert target.write_image(numbers)
    assert target.close()
    return path


def complaint(path: Path) -> str:
    """The one line that reading `path` ends in."""
    with pytest.raises(jt.InputError) as caught:
        jt.read_image(path)
    told = str(caught.value)
    assert told.startswith(f"{path}: ")
    assert "\n" not in told
    return told.removeprefix(f"{path}: ")


# --- what comes out of good files ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["rgb.png", "rgb.tif", "rgb.bmp", "rgb.webp"])
def test_eight_bits_are_decoded_from_srgb(tmp_path: Path, name: str) -> None:
    PIL.Image.fromarray(BYTES).save(tmp_path / name, **({"lossless": True} if name.endswith("webp") else {}))
    image = jt.read_image(tmp_path / name)
    assert (image.pixels.dtype, image.colour_space, image.alpha) == (np.float32, "srgb", None)
    assert (image.height, image.width) == (5, 7)
    np.testing.assert_allclose(image.pixels, LINEAR, atol=1e-7)


def test_jpeg_is_read_within_its_loss(tmp_path: Path) -> None:
    flat = np.full((16, 16, 3), (200, 100, 50), np.uint8)
    PIL.Image.fromarray(flat).save(tmp_path / "flat.jpg", quality=95)
    np.testing.assert_allclose(jt.read_image(tmp_path / "flat.jpg").pixels, srgb_to_linear(flat / 255), atol=0.01)


@pytest.mark.parametrize("name", ["deep.png", "deep.tif"])
def test_sixteen_bits_are_decoded_in_full(tmp_path: Path, name: str) -> None:
    numbers = RNG.integers(0, 65536, (4, 3, 3), dtype=np.uint16)
    image = jt.read_image(write_with_oiio(tmp_path / name, numbers, "uint16"))
    np.testing.assert_allclose(image.pixels, srgb_to_linear(numbers / 65535), rtol=1e-6)


@pytest.mark.parametrize(("kind", "error"), [("half", 2**-11), ("float", 1e-7)])
def test_exr_is_linear_and_keeps_what_is_brighter_than_white(tmp_path: Path, kind: str, error: float) -> None:
    numbers = RNG.uniform(-1, 50, (4, 6, 3)).astype(np.float32)
    image = jt.read_image(write_with_oiio(tmp_path / "scene.exr", numbers, kind))
    assert image.colour_space == "linear"
    np.testing.assert_allclose(image.pixels, numbers, rtol=error)


def test_float_tiff_is_linear(tmp_path: Path) -> None:
    path = write_with_oiio(tmp_path / "a.tif", LINEAR.astype(np.float32), "float")
    np.testing.assert_array_equal(jt.read_image(path).pixels, LINEAR.astype(np.float32))


@pytest.mark.parametrize("name", ["grey.png", "grey.jpg", "grey.tif"])
def test_grey_stays_one_channel(tmp_path: Path, name: str) -> None:
    PIL.Image.fromarray(np.full((8, 9), 188, np.uint8)).save(tmp_path / name)
    image = jt.read_image(tmp_path / name)
    assert image.pixels.shape == (8, 9, 1)
    np.testing.assert_allclose(image.pixels, srgb_to_linear(np.array(188 / 255)), atol=1e-6)


@pytest.mark.parametrize("name", ["a.png", "a.tif"])
def test_alpha_stands_apart_and_leaves_the_colours_alone(tmp_path: Path, name: str) -> None:
    alpha = RNG.integers(0, 256, (5, 7), dtype=np.uint8)
    alpha[0, 0] = 0
    PIL.Image.fromarray(np.dstack([BYTES, alpha])).save(tmp_path / name)
    image = jt.read_image(tmp_path / name)
    np.testing.assert_allclose(image.pixels, LINEAR, atol=1e-7)
    np.testing.assert_allclose(image.alpha, alpha / 255, atol=1e-7)


@pytest.mark.parametrize("name", ["ga.png", "ga.tif"])
def test_two_channels_are_grey_and_alpha(tmp_path: Path, name: str) -> None:
    PIL.Image.fromarray(BYTES[..., :2].copy(), "LA").save(tmp_path / name)
    image = jt.read_image(tmp_path / name)
    assert image.pixels.shape == (5, 7, 1)
    np.testing.assert_allclose(image.pixels[..., 0], LINEAR[..., 0], atol=1e-7)
    np.testing.assert_allclose(image.alpha, BYTES[..., 1] / 255, atol=1e-7)


def test_premultiplied_alpha_of_exr_is_divided_out(tmp_path: Path) -> None:
    numbers = np.array([[[0.2, 0.1, 0.05, 0.5], [0.7, 0.0, 0.0, 0.0], [0.3, 0.6, 0.9, 1.0]]], np.float32)
    image = jt.read_image(write_with_oiio(tmp_path / "a.exr", numbers, "float"))
    np.testing.assert_allclose(image.pixels[0], [[0.4, 0.2, 0.1], [0.7, 0, 0], [0.3, 0.6, 0.9]], rtol=1e-6)
    np.testing.assert_allclose(image.alpha[0], [0.5, 0, 1])


@pytest.mark.parametrize("name", ["cmyk.jpg", "cmyk.tif"])
def test_cmyk_is_converted(tmp_path: Path, name: str) -> None:
    PIL.Image.fromarray(np.full((16, 16, 3), (200, 100, 50), np.uint8)).convert("CMYK").save(tmp_path / name)
    image = jt.read_image(tmp_path / name)
    np.testing.assert_allclose(image.pixels[8, 8], srgb_to_linear(np.array([200, 100, 50]) / 255), atol=0.01)


@pytest.mark.parametrize("name", ["o.jpg", "o.png", "o.tif"])
@pytest.mark.parametrize("orientation", range(1, 9))
def test_exif_orientation_is_applied_and_dropped(tmp_path: Path, name: str, orientation: int) -> None:
    upright = np.zeros((24, 40), np.uint8)
    upright[:8, :16] = 255  # a corner that tells all eight apart
    stored = {
        1: upright,
        2: np.fliplr(upright),
        3: np.rot90(upright, 2),
        4: np.flipud(upright),
        5: upright.T,
        6: np.rot90(upright, 1),  # to be turned clockwise for viewing
        7: np.rot90(upright, 2).T,
        8: np.rot90(upright, -1),
    }[orientation]
    exif = PIL.Image.Exif()
    exif[0x0112] = orientation
    PIL.Image.fromarray(np.ascontiguousarray(stored)).save(tmp_path / name, exif=exif)
    image = jt.read_image(tmp_path / name)
    np.testing.assert_allclose(image.pixels[..., 0], upright / 255, atol=0.02)
    assert "Orientation" not in image.metadata


@pytest.mark.parametrize(
    ("chunk", "space", "value"),
    [(45455, "gamma 2.2", 0.25 ** (1 / 0.45455)), (100000, "linear", 0.25), (55556, "gamma 1.8", 0.25**1.8)],
)
def test_png_gamma_is_obeyed(tmp_path: Path, chunk: int, space: str, value: float) -> None:
    chunks = PIL.PngImagePlugin.PngInfo()
    chunks.add(b"gAMA", chunk.to_bytes(4, "big"))
    PIL.Image.fromarray(np.full((2, 2), 64, np.uint8)).save(tmp_path / "g.png", pnginfo=chunks)
    image = jt.read_image(tmp_path / "g.png")
    assert image.colour_space == space
    np.testing.assert_allclose(image.pixels, value, rtol=0.02)


def icc_profile(description: bytes) -> bytes:
    """The least of a display profile: a header, and one tag with its name."""
    text = b"desc" + bytes(4) + (len(description) + 1).to_bytes(4, "big") + description + bytes(1 + 4 + 4 + 2 + 1 + 67)
    size = 128 + 4 + 12 + len(text)
    start = size.to_bytes(4, "big") + b"lcms\x02\x10\0\0mntrRGB XYZ "
    header = start + bytes(36 - len(start)) + b"acsp" + bytes(128 - 40)
    return header + (1).to_bytes(4, "big") + b"desc" + (144).to_bytes(4, "big") + len(text).to_bytes(4, "big") + text


def test_display_p3_photographs_become_srgb_primaries(tmp_path: Path) -> None:
    flat = np.full((4, 4, 3), (200, 100, 50), np.uint8)
    PIL.Image.fromarray(flat).save(tmp_path / "phone.tif", icc_profile=icc_profile(b"Display P3"))
    image = jt.read_image(tmp_path / "phone.tif")
    assert image.colour_space == "srgb_p3d65_scene"
    # The matrix from P3's primaries to sRGB's, both with white D65 (SMPTE EG 432-1, IEC 61966-2-1).
    to_srgb = np.array([[1.2249, -0.2247, 0.0], [-0.0420, 1.0419, 0.0], [-0.0197, -0.0786, 1.0979]])
    np.testing.assert_allclose(image.pixels[0, 0], to_srgb @ srgb_to_linear(flat[0, 0] / 255), atol=5e-4)


def test_the_caller_may_say_what_the_numbers_mean(tmp_path: Path) -> None:
    PIL.Image.fromarray(BYTES).save(tmp_path / "normal.png")
    data = jt.read_image(tmp_path / "normal.png", colour_space="data")
    assert data.colour_space == "data"
    np.testing.assert_allclose(data.pixels, BYTES / 255, atol=1e-7)


def test_strips_thirty_thousand_pixels_wide(tmp_path: Path) -> None:
    strip = np.zeros((3, 30_000, 3), np.uint8)
    strip[1, 29_999] = 255
    PIL.Image.fromarray(strip).save(tmp_path / "strip.png")
    pixels = jt.read_image(tmp_path / "strip.png").pixels
    assert pixels.shape == (3, 30_000, 3)
    assert np.argwhere(pixels[..., 0]).tolist() == [[1, 29_999]]


def test_metadata_and_hash_are_kept(tmp_path: Path) -> None:
    exif = PIL.Image.Exif()
    exif[0x010F] = "Camera maker"
    PIL.Image.fromarray(BYTES).save(tmp_path / "p.jpg", exif=exif)
    image = jt.read_image(str(tmp_path / "p.jpg"))
    assert image.metadata["Make"] == "Camera maker"
    assert image.sha256 == hashlib.sha256((tmp_path / "p.jpg").read_bytes()).hexdigest()
    jt.write_image(tmp_path / "p.exr", image.pixels, metadata=image.metadata)
    assert jt.read_image(tmp_path / "p.exr").metadata["Make"] == "Camera maker"


@pytest.mark.parametrize("name", ["no extension", "été.png", "a#1 %04d?x=1.png", "jpeg in disguise.png"])
def test_names_do_not_matter(tmp_path: Path, name: str) -> None:
    PIL.Image.fromarray(BYTES).save(tmp_path / name, format="JPEG" if "disguise" in name else "PNG")
    assert jt.read_image(tmp_path / name).pixels.shape == (5, 7, 3)


# --- bad files -------------------------------------------------------------------------------------------------------


def whole(name: str) -> bytes:
    """The bytes of a good picture, of noise, so that cutting it anywhere cuts what is needed."""
    folder = Path(name).parent
    noise = np.random.default_rng(0).integers(0, 256, (64, 64, 3), dtype=np.uint8)
    path = folder / f"whole{Path(name).suffix}"
    write_with_oiio(path, noise, "half" if path.suffix == ".exr" else "uint8")
    return path.read_bytes()


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif", ".exr"])
@pytest.mark.parametrize("kept", [0.0, 0.002, 0.1, 0.5, 0.97])
def test_files_cut_short(tmp_path: Path, capfd: pytest.CaptureFixture[str], suffix: str, kept: float) -> None:
    data = whole(str(tmp_path / f"a{suffix}"))
    (tmp_path / f"cut{suffix}").write_bytes(data[: int(len(data) * kept)])
    told = complaint(tmp_path / f"cut{suffix}")
    assert told.startswith(("is empty", "cannot be read as an image", "is damaged or cut short"))
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("suffix", [".png", ".exr"])
def test_files_damaged_in_the_middle(tmp_path: Path, capfd: pytest.CaptureFixture[str], suffix: str) -> None:
    data = bytearray(whole(str(tmp_path / f"a{suffix}")))
    for at in range(len(data) // 2, len(data) // 2 + 40):
        data[at] ^= 0xA5
    (tmp_path / f"bad{suffix}").write_bytes(data)
    assert complaint(tmp_path / f"bad{suffix}").startswith("is damaged or cut short")
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif", ".exr", ".txt", ""])
def test_text_is_no_image(tmp_path: Path, suffix: str) -> None:
    (tmp_path / f"text{suffix}").write_text("a list of things to buy\n" * 50)
    assert complaint(tmp_path / f"text{suffix}").startswith("cannot be read as an image")


def test_folders_and_missing_files(tmp_path: Path) -> None:
    (tmp_path / "folder.png").mkdir()
    assert "is a folder" in complaint(tmp_path / "folder.png")
    assert "no such file" in complaint(tmp_path / "none.png")
    assert "no such file" in complaint(tmp_path / "none" / "none.png")


def test_pictures_without_pixels(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    PIL.Image.fromarray(BYTES).save(tmp_path / "zero.png")
    data = bytearray((tmp_path / "zero.png").read_bytes())
    data[16:20] = bytes(4)  # the width, in the header chunk
    data[29:33] = zlib.crc32(data[12:29]).to_bytes(4, "big")
    (tmp_path / "zero.png").write_bytes(data)
    (tmp_path / "zero.ppm").write_bytes(b"P6\n0 0\n255\n")
    for name in ("zero.png", "zero.ppm"):
        assert complaint(tmp_path / name)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_pixels_that_are_no_numbers(tmp_path: Path, value: float) -> None:
    numbers = np.zeros((6, 5, 3), np.float32)
    numbers[2, 3, 1] = numbers[4, 0] = value
    path = write_with_oiio(tmp_path / "nan.exr", numbers, "float")
    assert complaint(path) == "is NaN or infinite in 2 of 30 pixels, the first at row 2, column 3"


@pytest.mark.parametrize("channels", [("U", "V"), ("diffuse.R", "diffuse.G", "diffuse.B", "glossy.R")])
def test_channels_that_are_no_colours(tmp_path: Path, channels: tuple[str, ...]) -> None:
    spec = oiio.ImageSpec(2, 2, len(channels), "half")
    spec.channelnames = channels
    target = oiio.ImageOutput.create(str(tmp_path / "odd.exr"))
    assert target.open(str(tmp_path / "odd.exr"), spec)
    assert target.write_image(np.zeros((2, 2, len(channels)), np.float32))
    assert target.close()
    assert f"has {len(channels)} channels ({', '.join(channels)})" in complaint(tmp_path / "odd.exr")


def test_cielab_is_refused(tmp_path: Path) -> None:
    PIL.Image.fromarray(BYTES).convert("LAB").save(tmp_path / "lab.tif")
    assert "CIELAB" in complaint(tmp_path / "lab.tif")


def test_unknown_colour_space(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = write_with_oiio(tmp_path / "odd.exr", np.ones((2, 2, 3), np.float32), "half", colorInteropID="martian")
    assert "'martian' is not known" in complaint(path)
    assert capfd.readouterr().err == ""


def test_pictures_larger_than_the_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(raster, "MAX_PIXELS", 34)
    PIL.Image.fromarray(BYTES).save(tmp_path / "large.png")
    assert "has 7 x 5 pixels, and at most 34" in complaint(tmp_path / "large.png")


# --- writing ---------------------------------------------------------------------------------------------------------

UNIT = hnp.arrays(
    np.float32,
    st.tuples(st.integers(1, 5), st.integers(1, 5), st.integers(1, 4)),
    elements=st.floats(0, 1, width=32, allow_subnormal=False),
)


@given(pixels=UNIT, form=st.sampled_from([(".png", 8), (".png", 16), (".tif", 8), (".tif", 16)]))
def test_integer_files_give_back_what_they_were_given(tmp_path_factory, pixels: np.ndarray, form: tuple) -> None:
    suffix, bits = form
    path = tmp_path_factory.mktemp("w") / f"a{suffix}"
    jt.write_image(path, pixels, bits=bits)
    image = jt.read_image(path)
    count = 3 if pixels.shape[2] > 2 else 1
    # Half a step of the file, which is widest in linear light at white, where the curve's slope is 2.4 / 1.055.
    np.testing.assert_allclose(image.pixels, pixels[..., :count], atol=1.14 / (2**bits - 1) + 1e-6)
    if pixels.shape[2] in (2, 4):
        np.testing.assert_allclose(image.alpha, pixels[..., -1], atol=0.5 / (2**bits - 1) + 1e-6)
    else:
        assert image.alpha is None


@given(pixels=UNIT, form=st.sampled_from([(".exr", "half"), (".exr", "float"), (".tif", "float")]))
def test_float_files_give_back_what_they_were_given(tmp_path_factory, pixels: np.ndarray, form: tuple) -> None:
    suffix, bits = form
    path = tmp_path_factory.mktemp("w") / f"a{suffix}"
    if pixels.shape[2] in (2, 4):
        pixels[..., -1] = 0.25 + 0.75 * pixels[..., -1]
    jt.write_image(path, pixels, bits=bits, colour_space="linear")
    image = jt.read_image(path)
    tolerance = {"rtol": 3e-3, "atol": 1e-6} if bits == "half" else {"rtol": 1e-6}
    np.testing.assert_allclose(image.pixels, pixels[..., : 3 if pixels.shape[2] > 2 else 1], **tolerance)


@pytest.mark.parametrize("name", ["d.png", "d.tif", "d.exr"])
def test_data_are_written_as_they_stand(tmp_path: Path, name: str) -> None:
    values = np.linspace(0, 1, 256, dtype=np.float32).reshape(16, 16)
    jt.write_image(tmp_path / name, values, colour_space="data")
    data = jt.read_image(tmp_path / name, colour_space="data")
    np.testing.assert_allclose(data.pixels[..., 0], values, atol=1e-7)


def test_data_are_not_marked_as_srgb(tmp_path: Path) -> None:
    jt.write_image(tmp_path / "n.png", np.full((2, 2, 3), 0.5), colour_space="data")
    jt.write_image(tmp_path / "c.png", np.full((2, 2, 3), 0.5))
    assert b"sRGB" not in (tmp_path / "n.png").read_bytes()
    assert b"sRGB" in (tmp_path / "c.png").read_bytes()


def test_ids_of_tiles_are_exact_in_exr(tmp_path: Path) -> None:
    ids = np.array([[-1, 2049, 16_777_215]], np.float32)  # half floats could not hold the last two
    jt.write_image(tmp_path / "tile_id.exr", ids, colour_space="data")
    np.testing.assert_array_equal(jt.read_image(tmp_path / "tile_id.exr").pixels[..., 0], ids)


def test_linear_png_says_so(tmp_path: Path) -> None:
    jt.write_image(tmp_path / "l.png", LINEAR, colour_space="linear", bits=16)
    image = jt.read_image(tmp_path / "l.png")
    assert image.colour_space == "linear"
    np.testing.assert_allclose(image.pixels, LINEAR, atol=1e-5)


def test_colours_brighter_than_white_are_clipped_in_integer_files(tmp_path: Path) -> None:
    jt.write_image(tmp_path / "c.png", np.array([[-1.0, 0.0, 1.0, 7.0]]))
    np.testing.assert_array_equal(jt.read_image(tmp_path / "c.png").pixels[0, :, 0], [0, 0, 1, 1])


@pytest.mark.parametrize("name", ["a.png", "a.jpg", "a.tif", "a.exr"])
def test_the_same_pixels_give_the_same_file(tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    files = []
    for index in range(2):
        (tmp_path / str(index)).mkdir()
        jt.write_image(tmp_path / str(index) / name, LINEAR)
        files.append((tmp_path / str(index) / name).read_bytes())
    assert files[0] == files[1]
    assert b"20" + b"26:" not in files[0]  # nor would it differ tomorrow: no date stands in it


def bad_writes() -> list:
    good = np.zeros((2, 2, 3))
    return [
        pytest.param("a.png", good[0, 0], {}, "shape (3,)", id="one axis"),
        pytest.param("a.png", np.zeros((2, 2, 5)), {}, "shape (2, 2, 5)", id="five channels"),
        pytest.param("a.png", np.zeros((0, 2)), {}, "shape (0, 2)", id="no pixels"),
        pytest.param("a.png", np.zeros((2, 2), np.uint8), {}, "dtype uint8", id="integers"),
        pytest.param("a.png", np.full((2, 2), np.nan), {}, "NaN or infinite in 4 of 4", id="NaN"),
        pytest.param("a.exr", np.full((2, 2), np.inf), {}, "NaN or infinite", id="infinity"),
        pytest.param("a.xyz", good, {}, "'.xyz'", id="unknown extension"),
        pytest.param("a", good, {}, "cannot be written as ''", id="no extension"),
        pytest.param("a.jpg", good, {"bits": 16}, "bits=16", id="JPEG of 16 bits"),
        pytest.param("a.exr", good, {"bits": 8}, "bits=8", id="EXR of 8 bits"),
        pytest.param("a.jpg", np.zeros((2, 2, 4)), {}, "no alpha", id="JPEG with alpha"),
        pytest.param("a.jpg", good, {"colour_space": "linear"}, "linear", id="linear JPEG"),
        pytest.param("a.tif", good, {"colour_space": "linear"}, "linear", id="linear integer TIFF"),
        pytest.param("a.exr", good, {"colour_space": "srgb"}, "sRGB", id="encoded EXR"),
        pytest.param("a.png", good + 1.5, {"colour_space": "data"}, "data from 1.5 to 1.5", id="data out of range"),
        pytest.param("none/a.png", good, {}, "no folder", id="no folder"),
        pytest.param("folder.png", good, {}, "is a folder", id="a folder"),
    ]


@pytest.mark.parametrize(("name", "pixels", "options", "told"), bad_writes())
def test_what_cannot_be_written_leaves_nothing(tmp_path: Path, name: str, pixels, options: dict, told: str) -> None:
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(jt.InputError) as caught:
        jt.write_image(tmp_path / name, pixels, **options)
    assert told in str(caught.value)
    assert str(tmp_path / name) in str(caught.value)
    assert [path.name for path in tmp_path.iterdir()] == ["folder.png"]


def test_a_failed_write_keeps_what_stood_there(tmp_path: Path) -> None:
    """70,000 columns are more than a JPEG can have, which only its encoder finds out."""
    (tmp_path / "a.jpg").write_bytes(b"an older picture")
    with pytest.raises(jt.InputError, match="cannot be written"):
        jt.write_image(tmp_path / "a.jpg", np.zeros((1, 70_000, 3)))
    assert (tmp_path / "a.jpg").read_bytes() == b"an older picture"
    assert [path.name for path in tmp_path.iterdir()] == ["a.jpg"]
