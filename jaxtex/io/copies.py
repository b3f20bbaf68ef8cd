"""Pictures made of the numbers of another, as deep as it: those that are copied are not decoded, rounded or lost."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from jaxtex.core.errors import InputError
from jaxtex.io.encoding import colour_space_of
from jaxtex.io.files import place_for_file
from jaxtex.io.images import read_image, write_image
from jaxtex.io.raster import Raster, read_raster, writing_raster

# What each format holds as it stands.
_HOLDS = {
    ".png": ("uint8", "uint16"),
    ".tif": ("uint8", "uint16", "float32"),
    ".tiff": ("uint8", "uint16", "float32"),
    ".jpg": ("uint8",),
    ".jpeg": ("uint8",),
    ".exr": ("float32",),
}
FORMATS = tuple(_HOLDS)
"""Extensions of files that are written."""

_LOSSY = (".jpg", ".jpeg")


def check_copies(picture: Path | str, output: Path | str) -> None:
    """Find out whether `write_copies` can write, for work that takes long before it does.

    Raises:
        InputError: the picture cannot be read; there is no folder for the output, or it is of a format that is not
            written, or that has no alpha where the picture has.
    """
    output = place_for_file(output)
    suffix, channels = output.suffix.lower(), read_raster(picture).channels
    if suffix not in _HOLDS:
        raise InputError(f"{output}: cannot be written as '{output.suffix}'; name it {', '.join(FORMATS)}")
    if suffix in _LOSSY and "A" in channels:
        raise InputError(f"{output}: a JPEG file has no alpha, which {picture} has; write a .png file")


def write_as_deep(raster: Raster, output: Path | str, pixels: np.ndarray) -> None:
    """Write a picture as `write_image` does, with the depth of another one, as far as the format can hold it.

    Args:
        raster: the other one.
        output, pixels: as `write_image` takes them.

    Raises:
        InputError: as `write_image`.

    Examples:
        >>> write_image("deep.png", np.zeros((1, 1)), bits=16)
        >>> write_as_deep(read_raster("deep.png"), "made.tif", np.ones((2, 2)))
        >>> read_raster("made.tif").numbers.dtype
        dtype('uint16')
    """
    held = _HOLDS.get(Path(output).suffix.lower(), ())
    if not raster.integer and {"uint16", "float32"} <= set(held):
        write_image(output, pixels, colour_space="linear", bits="float")
    else:
        deep = raster.integer and raster.numbers.dtype != np.uint8 and "uint16" in held
        write_image(output, pixels, bits=16 if deep else None)


def write_copies(picture: Path | str, output: Path | str, rows: np.ndarray, columns: np.ndarray) -> None:
    """Write a picture made of another one's pixels, whole or not at all.

    It has the other's colour space, depth (half floats become floats), names of channels and alpha; where its format
    cannot hold these, it has what `write_image` makes of them. JPEG files are near to what is copied, as they always
    are.

    Args:
        picture: the file copied from: colours, normals, heights, any number of channels.
        output: the file to write; its extension tells the format.
        rows, columns: of the pixel to copy, integers [row, col], counted from the upper left of the upright picture.

    Raises:
        InputError: the picture cannot be read, or the file not written; a place is outside of the picture.

    Examples:
        >>> write_image("wall.png", np.array([[0.0, 1.0]]), bits=16)
        >>> write_copies("wall.png", "copies.png", np.zeros((2, 2), int), np.eye(2, dtype=int))
        >>> read_image("copies.png").pixels[..., 0]
        array([[1., 0.],
               [0., 1.]], dtype=float32)
    """

    def copy(numbers: np.ndarray) -> np.ndarray:
        height, width = numbers.shape[:2]
        if rows.min() < 0 or columns.min() < 0 or rows.max() >= height or columns.max() >= width:
            raise InputError(f"{picture}: is {width} x {height} pixels, and pixels beyond are to be copied")
        return numbers[rows, columns]

    write_like(picture, output, copy)


def write_like(picture: Path | str, output: Path | str, make: Callable[[np.ndarray], np.ndarray]) -> None:
    """Write a picture made of another one's numbers, with all that `write_copies` keeps, whole or not at all.

    Args:
        picture, output: as there.
        make: from the numbers [row, col, channel] as they stand in the file to those to be written, of any size, which
            are rounded where the file holds integers.

    Raises:
        InputError: the picture cannot be read, or the file not written.

    Examples:
        >>> write_image("height.png", np.array([[0.0, 0.5]]), bits=16, colour_space="data")
        >>> write_like("height.png", "mean.png", lambda numbers: numbers.mean(axis=1, keepdims=True))
        >>> read_raster("mean.png").numbers.ravel()
        array([16384], dtype=uint16)
    """
    picture, output = Path(picture), Path(output)
    raster = read_raster(picture)
    if not _holds(output.suffix.lower(), raster, picture.suffix.lower()):
        image = read_image(picture)
        pixels = image.pixels if image.alpha is None else np.concatenate([image.pixels, image.alpha[..., None]], axis=2)
        write_as_deep(raster, output, make(pixels))
        return
    made, kind = make(raster.numbers), raster.numbers.dtype
    if made.dtype != kind and kind != np.float32:
        made = np.clip(np.rint(made), 0, np.iinfo(kind).max)
    with writing_raster(
        output,
        size=(made.shape[1], made.shape[0]),
        channels=raster.channels,
        kind="float" if kind == np.float32 else kind.name,
        attributes=_attributes(raster, output.suffix.lower()),
    ) as write_rows:
        write_rows(made.astype(kind, copy=False))


def _holds(suffix: str, raster: Raster, read_from: str) -> bool:
    """Whether the numbers of a picture mean the same in a file of this format."""
    scaled = raster.integer and raster.numbers.dtype == np.float32
    if scaled or raster.numbers.dtype.name not in _HOLDS.get(suffix, ()):
        return False
    if "A" in raster.channels and (suffix in _LOSSY or (suffix == ".exr" and not raster.premultiplied)):
        return False
    if suffix in (".png", read_from):
        return True
    # Other files have no place for the name of a colour space: numbers are what such files usually hold, or data.
    if suffix != ".exr" and "ICCProfile" in raster.attributes:
        return True
    return colour_space_of(raster.attributes, integer=raster.integer) in (
        "srgb" if raster.integer else "linear",
        "data",
    )


def _attributes(raster: Raster, suffix: str) -> dict[str, Any]:
    """What the numbers mean, and how to pack them."""
    kept = ("oiio:ColorSpace", "oiio:Gamma", "ICCProfile", "chromaticities")
    return {
        "DateTime": "",  # or OpenImageIO puts in the time of writing
        **{name: raster.attributes[name] for name in kept if name in raster.attributes},
        "oiio:UnassociatedAlpha": int(not raster.premultiplied),
        "compression": "jpeg:95" if suffix in _LOSSY else "zip",
    }
