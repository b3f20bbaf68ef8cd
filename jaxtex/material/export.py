"""Material maps as a folder of image files."""

from collections.abc import Callable, Iterable
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

import numpy as np

from jaxtex.io.images import ColourSpace, writing_image
from jaxtex.material.maps import Maps


class _MapFile(NamedTuple):
    name: str
    channels: int
    colour_space: ColourSpace
    pixels: Callable[[Maps], np.ndarray]


_FILES = (
    _MapFile("basecolor.png", 3, "srgb", lambda maps: maps.base_colour),
    _MapFile("height.exr", 1, "data", lambda maps: maps.height),
    _MapFile("normal.png", 3, "data", lambda maps: np.clip(0.5 * maps.normal + 0.5, 0, 1)),
    _MapFile("roughness.png", 1, "data", lambda maps: maps.roughness),
    _MapFile("tile_id.exr", 1, "data", lambda maps: maps.tile_id),
)

MAP_NAMES = tuple(file.name for file in _FILES)
"""The files that `write_maps` makes."""


def write_maps(folder: Path | str, bands: Iterable[Maps], *, size: tuple[int, int]) -> list[Path]:
    """Write maps as they are rendered: base colour as sRGB, everything else as data.

    Height and ids are floats (EXR); colour, normals and roughness are 8-bit PNG, normals as 0.5 n + 0.5. The files
    appear when all rows are there; until then, and if something fails, older ones stay.

    Args:
        folder: an existing folder.
        bands: rows from the top, as `render_maps` gives them.
        size: (width, height) of the maps in pixels.

    Returns:
        The files.

    Raises:
        InputError: a file cannot be written.
    """
    paths = [Path(folder) / file.name for file in _FILES]
    with ExitStack() as open_files:
        writers = [
            open_files.enter_context(
                writing_image(path, size=size, channels=file.channels, colour_space=file.colour_space)
            )
            for path, file in zip(paths, _FILES, strict=True)
        ]
        for maps in bands:
            for write_rows, file in zip(writers, _FILES, strict=True):
                write_rows(file.pixels(maps))
    return paths
