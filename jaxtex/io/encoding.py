"""Between the numbers in an image file and linear light with sRGB primaries."""

from collections.abc import Mapping

import numpy as np
import OpenImageIO as oiio

from jaxtex.core.colour import srgb_to_linear
from jaxtex.core.errors import InputError

_NAMES = {
    "srgb": "srgb",
    "srgb_rec709_scene": "srgb",
    "srgb_rec709_display": "srgb",
    "linear": "linear",
    "scene_linear": "linear",
    "lin_rec709": "linear",
    "lin_rec709_scene": "linear",
    "raw": "data",
    "data": "data",
}

# Photographs with other primaries say so in an ICC profile, which OpenImageIO reads but does not apply.
_PROFILES = {
    "Display P3": "srgb_p3d65_scene",
    "Adobe RGB (1998)": "g22_adobergb_scene",
}


def colour_space_of(attributes: Mapping[str, object], *, integer: bool) -> str:
    """What an image file says of its colour space, or what files of its kind mean when they say nothing.

    Args:
        attributes: the file's metadata, by OpenImageIO's names.
        integer: whether the file holds integers (sRGB unless it says otherwise) or floats (linear).

    Returns:
        "srgb", "linear", "data" (numbers that are no colours), "gamma 2.2" (with the file's exponent), or OpenImageIO's
        name of another colour space.
    """
    profile = str(attributes.get("ICCProfile:profile_description"))
    if profile in _PROFILES:
        return _PROFILES[profile]
    gamma = attributes.get("oiio:Gamma")
    if isinstance(gamma, float) and gamma != 1.0:
        return f"gamma {gamma:.4g}"
    name = str(attributes.get("oiio:ColorSpace") or ("srgb" if integer else "linear"))
    return _NAMES.get(name.lower(), name)


def to_linear(values: np.ndarray, colour_space: str) -> np.ndarray:
    """Decode the numbers of a file to linear light with sRGB primaries.

    Args:
        values: floats [..., channel] with one channel (grey) or three (RGB), integers scaled to 0 to 1.
        colour_space: as `colour_space_of` returns it.

    Returns:
        float32 array of the same shape.

    Raises:
        InputError: the colour space is none that is known.

    Examples:
        >>> to_linear(np.array([[0.5]]), "gamma 2")
        array([[0.25]], dtype=float32)
    """
    if colour_space in ("linear", "data"):
        decoded = values
    elif colour_space == "srgb":
        decoded = srgb_to_linear(values)
    elif colour_space.startswith("gamma "):
        decoded = np.maximum(values, 0) ** float(colour_space.removeprefix("gamma "))
    else:
        decoded = _convert(values, colour_space)
    return decoded.astype(np.float32)


def _convert(values: np.ndarray, colour_space: str) -> np.ndarray:
    """Other primaries and curves, by OpenImageIO's built-in colour configuration."""
    rows = np.broadcast_to(values, (*values.shape[:-1], 3)).reshape(1, -1, 3)
    picture = oiio.ImageBuf(np.ascontiguousarray(rows, np.float32))
    converted = oiio.ImageBufAlgo.colorconvert(picture, colour_space, "lin_rec709_scene", colorconfig="ocio://default")
    pixels = None if converted.has_error else converted.get_pixels(oiio.FLOAT)
    if pixels is None:
        converted.geterror()  # an error that nobody asks for is printed when the buffer goes
        raise InputError(f"the colour space '{colour_space}' is not known; convert the picture to sRGB")
    return pixels.reshape(*values.shape[:-1], 3)[..., : values.shape[-1]]
