"""Maps of a material packed into the few textures that engines look up."""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from jaxtex.io.gltf import MaterialImages, check_texture_size
from jaxtex.io.images import ColourSpace, to_bytes
from jaxtex.material.export import encode_normals

# What stands for a map that a material has not: nothing in the light's way, no metal, a reflectance of 4 %.
_PLAIN = {"occlusion": 1.0, "metallic": 0.0, "specular": 0.5}


def pack_maps(bands: Iterable[NamedTuple], *, size: tuple[int, int]) -> MaterialImages:
    """Pack maps as they are rendered; every number is that of the PNG files that `write_maps` makes.

    Memory is that of the textures and of one band.

    Args:
        bands: rows from the top, as `render_maps`, `render_wood` and `render_floor` give them: `base_colour` (linear),
            `normal` and `roughness`, and perhaps `occlusion` (1 where all light comes), `metallic` and `specular`
            (0 to 1; 0.5 is a reflectance of 4 %).
        size: (width, height) of the maps in pixels.

    Raises:
        InputError: a size that textures cannot have; maps that are not finite, or beyond 0 to 1 where they are no
            colours.

    Examples:
        >>> class Maps(NamedTuple):
        ...     base_colour: np.ndarray
        ...     normal: np.ndarray
        ...     roughness: np.ndarray
        >>> white = Maps(np.ones((2, 3, 3)), np.tile([0.0, 0.0, 1.0], (2, 3, 1)), np.full((2, 3), 0.6))
        >>> packed = pack_maps([white, white], size=(3, 4))
        >>> packed.surface.shape, packed.surface[0, 0].tolist(), packed.specular
        ((4, 3, 3), [255, 153, 0], None)
    """
    check_texture_size(size)
    width, height = size
    colour, normal, surface = (np.empty((height, width, 3), np.uint8) for _ in range(3))
    specular = np.empty((height, width), np.uint8)
    row = 0
    for band in bands:
        rows = slice(row, row := row + len(band.base_colour))  # type: ignore[attr-defined]
        colour[rows] = to_bytes(_map(band, "base_colour"), colour_space="srgb")
        normal[rows] = to_bytes(encode_normals(_map(band, "normal")), colour_space="data")
        for channel, field in enumerate(("occlusion", "roughness", "metallic")):
            surface[rows, :, channel] = _single(band, field, "data")
        specular[rows] = _single(band, "specular", "srgb")
    if row != height:
        raise ValueError(f"maps of {height} rows were to be packed, and {row} came")
    plain = to_bytes(np.full((1, 1), _PLAIN["specular"]), colour_space="srgb")
    return MaterialImages(colour, normal, surface, None if (specular == plain.ravel()).all() else specular)


def _single(band: NamedTuple, field: str, space: ColourSpace) -> npt.NDArray[np.uint8]:
    return to_bytes(_map(band, field), colour_space=space)[..., 0]


def _map(band: NamedTuple, field: str) -> npt.NDArray[np.float32]:
    found: Any = getattr(band, field, None)
    return np.full(band.roughness.shape, _PLAIN[field], np.float32) if found is None else found  # type: ignore[attr-defined]
