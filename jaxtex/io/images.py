"""Images, read to linear light and written from it, through OpenImageIO."""

import hashlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from jaxtex.core.colour import linear_to_srgb
from jaxtex.core.errors import InputError
from jaxtex.io.encoding import colour_space_of, to_linear
from jaxtex.io.raster import Raster, read_raster, writing_raster

ColourSpace = Literal["srgb", "linear", "data"]
Bits = Literal[8, 16, "half", "float"]

# What each kind of file can hold; the first is taken where the caller does not say.
_BITS: dict[str, tuple[Bits, ...]] = {
    ".png": (8, 16),
    ".jpg": (8,),
    ".jpeg": (8,),
    ".tif": (8, 16, "float"),
    ".tiff": (8, 16, "float"),
    ".exr": ("half", "float"),
}
_KINDS: dict[Bits, str] = {8: "uint8", 16: "uint16", "half": "half", "float": "float"}
_TAGS: dict[ColourSpace, str] = {"srgb": "srgb_rec709_scene", "linear": "lin_rec709_scene", "data": "data"}

# Metadata of the file, not of the picture: how it is packed, and what reading it has already applied.
_OF_THE_FILE = ("oiio:", "tiff:", "png:", "jpeg:", "openexr:", "gif:", "bmp:", "webp:", "screenWindow", "ICCProfile")
_OF_THE_FILE_TOO = {"Orientation", "compression", "planarconfig", "colorInteropID", "Exif:ColorSpace"}


@dataclass(frozen=True, eq=False)
class Image:
    """A picture as it was read: upright, in linear light.

    Attributes:
        pixels: float32 [row, col, channel], linear light with sRGB primaries, 1 channel (grey) or 3 (RGB), not
            multiplied by alpha; 0 to 1 from integer files, any finite values from float files.
        alpha: float32 [row, col], 1 where opaque; None where the file has none.
        colour_space: of the file: "srgb", "linear", "data", "gamma 2.2", or OpenImageIO's name of another.
        metadata: what the file says about the picture (camera, date, resolution), by OpenImageIO's names.
        sha256: hash of the file's bytes, in hexadecimal.
        path: the file.
    """

    pixels: np.ndarray
    alpha: np.ndarray | None
    colour_space: str
    metadata: dict[str, str | int | float]
    sha256: str
    path: Path

    @property
    def height(self) -> int:
        """Number of rows."""
        return int(self.pixels.shape[0])

    @property
    def width(self) -> int:
        """Number of columns."""
        return int(self.pixels.shape[1])


def read_image(path: Path | str, *, colour_space: ColourSpace | None = None) -> Image:
    """Read an image file to linear light.

    PNG, JPEG, TIFF and EXR, and whatever else OpenImageIO reads; of several pictures in a file, the first. The EXIF
    orientation is applied, so that row 0 is the top as a person sees it. CMYK comes as (1 - C)(1 - K) and so on,
    without its profile.

    Args:
        path: the file.
        colour_space: what its numbers mean, where the file does not say so or is wrong; "data" leaves them as they are
            (masks, normals, heights).

    Returns:
        The picture, its alpha, metadata and hash.

    Raises:
        InputError: the file is missing, damaged or no image; has more than `raster.MAX_PIXELS` pixels, channels that
            are neither grey nor RGB, pixels that are NaN or infinite, or a colour space that is not known.

    Examples:
        >>> write_image("wall.png", np.full((2, 3, 3), 0.25))
        >>> image = read_image("wall.png")
        >>> image.width, image.height, image.colour_space, image.pixels[0, 0].round(2)
        (3, 2, 'srgb', array([0.25, 0.25, 0.25], dtype=float32))
    """
    path = Path(path)
    raster = read_raster(path)
    try:
        space = colour_space or colour_space_of(raster.attributes, integer=raster.integer)
        pixels, alpha = _decode(raster, space)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    with path.open("rb") as file:
        sha256 = hashlib.file_digest(file, "sha256").hexdigest()
    return Image(pixels, alpha, space, _metadata(raster), sha256, path)


def write_image(
    path: Path | str,
    pixels: np.ndarray,
    *,
    colour_space: ColourSpace | None = None,
    bits: Bits | None = None,
    metadata: Mapping[str, str | int | float] | None = None,
) -> None:
    """Write pixels to a PNG, JPEG, TIFF or EXR file, whole or not at all.

    Args:
        path: the file; its extension tells the format.
        pixels: [row, col] or [row, col, channel], 1 channel (grey), 2 (grey and alpha), 3 (RGB) or 4 (RGB and alpha),
            not multiplied by alpha. Colours are linear light; what lies outside 0 to 1 is clipped in integer files.
        colour_space: "srgb" encodes; "linear" writes linear values and says so in the file; "data" writes numbers that
            are no colours as they stand. Default: "linear" for EXR, "srgb" for the others.
        bits: 8, 16, "half" or "float" per channel. Default: 8; for EXR "half", or "float" if it is data.
        metadata: to keep in the file, as `Image.metadata` has it. No date is written unless it is among these, so the
            same pixels give the same file.

    Raises:
        InputError: pixels of a shape or dtype that is no image, or not finite; data outside 0 to 1 for an integer file;
            a format, or a combination of it with `bits`, `colour_space` or alpha, that cannot be written; a file that
            cannot be made.

    Examples:
        >>> write_image("height.exr", np.zeros((4, 4)), colour_space="data")
        >>> write_image("wall.jpg", np.full((4, 4, 3), 0.5))
    """
    try:
        values = _checked_pixels(np.asarray(pixels))
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    rows, columns, channels = values.shape
    with writing_image(
        path, size=(columns, rows), channels=channels, colour_space=colour_space, bits=bits, metadata=metadata
    ) as write_rows:
        write_rows(values)


@contextmanager
def writing_image(
    path: Path | str,
    *,
    size: tuple[int, int],
    channels: int,
    colour_space: ColourSpace | None = None,
    bits: Bits | None = None,
    metadata: Mapping[str, str | int | float] | None = None,
) -> Iterator[Callable[[np.ndarray], None]]:
    """A function to hand an image file's rows to, some at a time from the top, for pictures too large to hold.

    The file is there, whole, when the block ends, and only if it ends without error.

    Args:
        path: the file; its extension tells the format.
        size: (width, height) in pixels.
        channels: 1 (grey) to 4 (RGB and alpha), as in `write_image`.
        colour_space, bits, metadata: as in `write_image`.

    Yields:
        A function that takes the next rows as `write_image` takes pixels.

    Raises:
        InputError: as `write_image`.

    Examples:
        >>> with writing_image("slope.png", size=(4, 6), channels=1, colour_space="data") as write_rows:
        ...     for row in range(6):
        ...         write_rows(np.full((1, 4), row / 6))
    """
    path = Path(path)
    try:
        suffix = path.suffix.lower()
        if suffix not in _BITS:
            raise InputError(f"cannot be written as '{path.suffix}'; name it {', '.join(_BITS)}")
        space: ColourSpace = colour_space or ("linear" if suffix == ".exr" else "srgb")
        depth = _checked_bits(suffix, bits, space, has_alpha=channels in (2, 4))
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    attributes = {
        "DateTime": "",  # or OpenImageIO puts in the time of writing
        **(metadata or {}),
        "oiio:ColorSpace": _TAGS[space],
        "oiio:UnassociatedAlpha": int(suffix != ".exr"),
        "compression": "jpeg:95" if suffix in (".jpg", ".jpeg") else "zip",
    }
    with writing_raster(path, size=size, channels=channels, kind=_KINDS[depth], attributes=attributes) as write_numbers:

        def write_rows(pixels: np.ndarray) -> None:
            try:
                numbers = _encode(_checked_pixels(pixels), space, depth, premultiply=suffix == ".exr")
            except InputError as error:
                raise InputError(f"{path}: {error}") from None
            write_numbers(numbers)

        yield write_rows


def check_image_name(path: Path | str) -> None:
    """That a picture can be written under a name, before the work that goes into it.

    Raises:
        InputError: the extension is of no kind that can be written.

    Examples:
        >>> check_image_name("wall.png")
    """
    if Path(path).suffix.lower() not in _BITS:
        raise InputError(f"{path}: cannot be written as '{Path(path).suffix}'; name it {', '.join(_BITS)}")


def to_bytes(pixels: np.ndarray, *, colour_space: ColourSpace) -> np.ndarray:
    """The numbers that an 8-bit file of `write_image` holds, for files that hold images among other things.

    Args:
        pixels: as `write_image` takes them.
        colour_space: likewise.

    Returns:
        uint8 [row, col, channel].

    Raises:
        InputError: pixels that `write_image` would refuse.

    Examples:
        >>> to_bytes(np.array([[0.0, 0.214, 1.0]]), colour_space="srgb")[0, :, 0]
        array([  0, 127, 255], dtype=uint8)
    """
    return _encode(_checked_pixels(np.asarray(pixels)), colour_space, 8, premultiply=False)


def _decode(raster: Raster, space: str) -> tuple[np.ndarray, np.ndarray | None]:
    """Linear pixels and alpha of a raster."""
    colours, alpha_at = _find_channels(raster)
    numbers = raster.numbers[..., colours]
    alpha = None if alpha_at is None else _to_unit(raster.numbers[..., alpha_at])
    if alpha is not None and raster.premultiplied:
        cover = alpha[..., None]
        pixels = to_linear(np.divide(_to_unit(numbers), cover, out=_to_unit(numbers), where=cover > 0), space)
    elif numbers.dtype == np.float32:
        pixels = to_linear(numbers, space)
    elif len(colours) == 1 or space in ("srgb", "linear", "data") or space.startswith("gamma "):
        # Every number on its own: decode the 256 or 65536 there can be, and look them up.
        table = to_linear(_to_unit(np.arange(np.iinfo(numbers.dtype).max + 1, dtype=numbers.dtype))[:, None], space)
        pixels = table[:, 0][numbers]
    else:
        pixels = to_linear(_to_unit(numbers), space)
    _check_finite(pixels)
    if alpha is not None:
        _check_finite(alpha)
    return pixels, alpha


def _find_channels(raster: Raster) -> tuple[list[int], int | None]:
    """Where the colours stand among the channels, and where alpha does."""
    if "LAB" in str(raster.attributes.get("tiff:ColorSpace", "")):
        raise InputError("is in CIELAB; convert it to RGB")
    names = [name.upper() for name in raster.channels]
    alpha = names.index("A") if "A" in names else None
    if {"R", "G", "B"} <= set(names):
        return [names.index(name) for name in "RGB"], alpha
    colours = [index for index in range(len(names)) if index != alpha]
    if len(colours) not in (1, 3):
        told = ", ".join(raster.channels)
        raise InputError(f"has {len(names)} channels ({told}), neither grey nor RGB; convert it to one of these")
    return colours, alpha


def _to_unit(numbers: np.ndarray) -> np.ndarray:
    """Integers scaled to 0 to 1; a copy, float32."""
    scale = 1 if numbers.dtype == np.float32 else np.iinfo(numbers.dtype).max
    return numbers.astype(np.float32) / np.float32(scale)


def _metadata(raster: Raster) -> dict[str, str | int | float]:
    return {
        name: value
        for name, value in sorted(raster.attributes.items())
        if isinstance(value, str | int | float) and not name.startswith(_OF_THE_FILE) and name not in _OF_THE_FILE_TOO
    }


def _checked_pixels(pixels: np.ndarray) -> np.ndarray:
    """`pixels` as float32 [row, col, channel]."""
    if pixels.ndim not in (2, 3) or 0 in pixels.shape or (pixels.ndim == 3 and pixels.shape[2] > 4):
        raise InputError(f"pixels of shape {pixels.shape} are no image; give [row, col] or [row, col, 1 to 4 channels]")
    if not np.issubdtype(pixels.dtype, np.floating):
        raise InputError(f"pixels of dtype {pixels.dtype} cannot be written; give floats, 0 to 1")
    values = pixels.astype(np.float32).reshape(*pixels.shape[:2], -1)
    _check_finite(values)
    return values


def _check_finite(pixels: np.ndarray) -> None:
    bad = ~np.isfinite(pixels)
    if bad.any():
        at = np.argwhere(bad.reshape(*bad.shape[:2], -1).any(-1))
        first = f"the first at row {at[0, 0]}, column {at[0, 1]}"
        raise InputError(f"is NaN or infinite in {len(at)} of {bad.shape[0] * bad.shape[1]} pixels, {first}")


def _checked_bits(suffix: str, bits: Bits | None, space: ColourSpace, *, has_alpha: bool) -> Bits:
    """The depth to write, once the format is known to hold it and everything else it is asked to."""
    if bits is None:
        bits = "float" if suffix == ".exr" and space == "data" else _BITS[suffix][0]
    if bits not in _BITS[suffix]:
        raise InputError(f"cannot hold bits={bits!r}; a {suffix} file takes {', '.join(map(repr, _BITS[suffix]))}")
    if space == "linear" and bits in (8, 16) and suffix != ".png":
        raise InputError(f"an integer {suffix} file cannot say that it is linear; write 'srgb', or a .png or .exr file")
    if space == "srgb" and bits in ("half", "float"):
        raise InputError("a file of floats is not encoded as sRGB; write 'linear'")
    if has_alpha and suffix in (".jpg", ".jpeg"):
        raise InputError("a JPEG file has no alpha; write a .png file, or only the colours")
    return bits


def _encode(values: np.ndarray, space: ColourSpace, bits: Bits, *, premultiply: bool) -> np.ndarray:
    """The numbers that stand in the file."""
    count = 3 if values.shape[-1] >= 3 else 1
    colours, alpha = values[..., :count], values[..., count:]
    if bits in ("half", "float"):
        return np.concatenate([colours * alpha if premultiply and alpha.size else colours, alpha], axis=-1)
    if space == "data" and not (values.min() >= 0 and values.max() <= 1):
        raise InputError(
            f"data from {values.min():.6g} to {values.max():.6g} do not fit an integer file, which holds 0 to 1; "
            "scale them, or write an .exr file"
        )
    if space == "srgb":
        colours = linear_to_srgb(np.clip(colours, 0, 1))
    largest = 255 if bits == 8 else 65535
    numbers = np.rint(np.clip(np.concatenate([colours, alpha], axis=-1), 0, 1) * largest)
    return numbers.astype(np.uint8 if bits == 8 else np.uint16)
