"""Pictures whose pixels are copied from those of another, number by number: nothing is decoded, rounded or lost."""

from pathlib import Path
from typing import Any

import numpy as np

from jaxtex.core.errors import InputError
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


def write_copies(picture: Path | str, output: Path | str, rows: np.ndarray, columns: np.ndarray) -> None:
    """Write a picture made of another one's pixels, whole or not at all.

    It has the other's colour space, depth and alpha; where its format cannot hold these, it has what `write_image`
    makes of them.

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
    picture, output = Path(picture), Path(output)
    raster = read_raster(picture)
    height, width = raster.numbers.shape[:2]
    if rows.min() < 0 or columns.min() < 0 or rows.max() >= height or columns.max() >= width:
        raise InputError(f"{picture}: is {width} x {height} pixels, and pixels beyond are to be copied")
    if raster.numbers.dtype.name not in _HOLDS.get(output.suffix.lower(), ()):
        image = read_image(picture)
        pixels = image.pixels if image.alpha is None else np.concatenate([image.pixels, image.alpha[..., None]], axis=2)
        write_image(output, pixels[rows, columns])
        return
    kind = {"float32": "float"}.get(raster.numbers.dtype.name, raster.numbers.dtype.name)
    with writing_raster(
        output,
        size=(rows.shape[1], rows.shape[0]),
        channels=raster.numbers.shape[2],
        kind=kind,
        attributes=_attributes(raster, output.suffix.lower()),
    ) as write_rows:
        write_rows(raster.numbers[rows, columns])


def _attributes(raster: Raster, suffix: str) -> dict[str, Any]:
    """What the numbers mean, and how to pack them."""
    kept = ("oiio:ColorSpace", "oiio:Gamma", "ICCProfile", "chromaticities")
    return {
        "DateTime": "",  # or OpenImageIO puts in the time of writing
        **{name: raster.attributes[name] for name in kept if name in raster.attributes},
        "oiio:UnassociatedAlpha": int(not raster.premultiplied),
        "compression": "jpeg:95" if suffix in (".jpg", ".jpeg") else "zip",
    }
