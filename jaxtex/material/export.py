"""Material maps as a folder of image files."""

from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

import numpy as np

from jaxtex.io.images import ColourSpace, writing_image
from jaxtex.material.maps import Maps


def encode_normals(normals: np.ndarray) -> np.ndarray:
    """Unit vectors as files have them: 0.5 n + 0.5, from 0 to 1.

    Examples:
        >>> encode_normals(np.array([0.0, 0.0, 1.0]))
        array([0.5, 0.5, 1. ])
    """
    return np.clip(0.5 * normals + 0.5, 0, 1)


class _MapFile(NamedTuple):
    name: str
    field: str  # of the maps
    channels: int
    colour_space: ColourSpace
    encode: Callable[[np.ndarray], np.ndarray] = np.asarray


_FILES = (
    _MapFile("basecolor.png", "base_colour", 3, "srgb"),
    _MapFile("height.exr", "height", 1, "data"),
    _MapFile("normal.png", "normal", 3, "data", encode_normals),
    _MapFile("roughness.png", "roughness", 1, "data"),
    _MapFile("specular.png", "specular", 1, "data"),
    _MapFile("metallic.png", "metallic", 1, "data"),
    _MapFile("occlusion.png", "occlusion", 1, "data"),
    _MapFile("tile_id.exr", "tile_id", 1, "data"),
)

MAP_NAMES = tuple(file.name for file in _FILES)
"""The files that `write_maps` makes of `Maps`."""


def write_maps(
    folder: Path | str, bands: Iterable[NamedTuple], *, size: tuple[int, int], fields: Sequence[str] = Maps._fields
) -> list[Path]:
    """Write maps as they are rendered: base colour as sRGB, everything else as data.

    Height and ids are floats (EXR); the others are 8-bit PNG, normals as 0.5 n + 0.5. The files
    appear when all rows are there; until then, and if something fails, older ones stay.

    Args:
        folder: an existing folder.
        bands: rows from the top, as `render_maps` and `render_wood` give them.
        size: (width, height) of the maps in pixels.
        fields: names of those to write, of `Maps` or `WoodMaps`.

    Returns:
        The files.

    Raises:
        InputError: a file cannot be written.
    """
    files = [file for file in _FILES if file.field in fields]
    paths = [Path(folder) / file.name for file in files]
    with ExitStack() as open_files:
        writers = [
            open_files.enter_context(
                writing_image(path, size=size, channels=file.channels, colour_space=file.colour_space)
            )
            for path, file in zip(paths, files, strict=True)
        ]
        for maps in bands:
            for write_rows, file in zip(writers, files, strict=True):
                write_rows(file.encode(getattr(maps, file.field)))
    return paths
