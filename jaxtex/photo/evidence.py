"""Photograph -> maps of where joints may lie.

Nothing is known yet of a photograph's joints: they may be lighter or darker than the tiles, of another colour only, or
not there at all where tiles are told apart by colour. So several maps are made, each positive where it sees a joint of
its kind, and the search for courses (:mod:`jaxtex.photo.courses`) finds out which of them is periodic.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from skimage import transform

from jaxtex.photo.pictures import to_lab

Map = NDArray[np.float32]

# Line widths looked for, in pixels of a picture whose longer side is 512.
_RIDGE_SCALES = (1.2, 2.4, 4.8)
# Lab units of spread below which a picture is taken to be grey.
_COLOURED = 2.0
COLOURS = 3
_SMALL = 64  # pixels along the longer side, enough for what changes slowly


class Evidence(NamedTuple):
    """Maps made from one photograph, all of one shape (H, W).

    ``joints`` names each map of likely joints (zero mean, about unit spread, positive on joints); ``features`` (H, W,
    F) are the plain measurements from which a joint can be told from a tile once the lattice is known; the first
    ``COLOURS`` of them are a pixel's own colour, the others depend on its surroundings.
    """

    joints: dict[str, Map]
    features: Map


def shrink(pixels: NDArray[np.floating], longest: int) -> Map:
    """The picture [H, W] or [H, W, C] with its longer side at most ``longest`` pixels, anti-aliased; never enlarged."""
    height, width = pixels.shape[:2]
    scale = longest / max(height, width)
    if scale >= 1.0:
        return np.asarray(pixels, np.float32)
    shape = (max(1, round(height * scale)), max(1, round(width * scale)))
    return transform.resize(pixels, shape, anti_aliasing=True).astype(np.float32)


def find_evidence(pixels: NDArray[np.floating]) -> Evidence:
    """Maps of likely joints in a picture, linear [H, W, 1 or 3].

    Dark and light lines in lightness, lines of either sign in the picture's strongest colour contrast, and edges
    (which serve tiles without joints). Ridges are the larger eigenvalue of the Hessian over three scales, so that spots
    count less than lines; every map is divided by its local spread, so that uneven light and contrast do not matter.
    """
    lab = to_lab(np.clip(pixels, 0.0, 1.0))
    size = max(lab.shape[:2]) / 512
    scales = [max(scale * size, 0.8) for scale in _RIDGE_SCALES]
    channels = {"lightness": lab[..., 0]}
    contrast = _colour_contrast(lab)
    if contrast is not None:
        channels["colour"] = contrast
    joints: dict[str, Map] = {}
    features: list[Map] = [_flatten(lab[..., channel]) for channel in range(COLOURS)]
    for name, channel in channels.items():
        ridges = [find_ridges(channel, scale) for scale in scales]
        dark, light = (np.max([ridge[sign] for ridge in ridges], axis=0) for sign in (0, 1))
        joints[f"dark {name}"] = _equalise(dark)
        joints[f"light {name}"] = _equalise(light)
        features += [joints[f"dark {name}"], joints[f"light {name}"]]
    gradient = sum(ndimage.gaussian_gradient_magnitude(lab[..., c], scales[0] * 1.25) ** 2 for c in range(3))
    joints["edges"] = _equalise(np.sqrt(gradient))
    features.append(joints["edges"])
    return Evidence(joints, np.stack(features, axis=-1))


def find_ridges(channel: Map, scale: float) -> tuple[Map, Map]:
    """Strength of dark and of light lines about ``scale`` pixels wide in one channel (H, W)."""
    xx = ndimage.gaussian_filter(channel, scale, order=(0, 2))
    yy = ndimage.gaussian_filter(channel, scale, order=(2, 0))
    xy = ndimage.gaussian_filter(channel, scale, order=(1, 1))
    mean, radius = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    high, low = mean + radius, mean - radius
    # The exponent between 1 and 2 lets fine lines stand beside broad ones.
    dark = np.where(high > -low, high, 0.0) * scale**1.5
    light = np.where(-low > high, -low, 0.0) * scale**1.5
    return dark, light


def mask_evidence(mask: NDArray[np.floating]) -> Evidence:
    """Evidence from a mask the user made (H, W), 1 on tiles and 0 on joints."""
    joint = 1.0 - np.asarray(mask, np.float32)
    # Single wrong pixels tell nothing of the lattice.
    smooth = ndimage.gaussian_filter(joint, 1.0)
    return Evidence({"mask": smooth - smooth.mean()}, joint[..., None])


def _colour_contrast(lab: Map) -> Map | None:
    """The (a, b) plane projected on its strongest direction, or None for a grey picture."""
    ab = lab[..., 1:] - lab[..., 1:].mean((0, 1))
    spread, directions = np.linalg.eigh(np.cov(ab.reshape(-1, 2).T))
    if spread[1] < _COLOURED**2:
        return None
    return (ab @ directions[:, 1]).astype(np.float32)


def _flatten(channel: Map) -> Map:
    """The channel without what changes slower than about a quarter of the picture."""
    return channel - _slow_part(channel)


def _equalise(strength: Map) -> Map:
    centred = _flatten(strength)
    spread = np.sqrt(_slow_part(centred**2))
    # The floor keeps empty parts from being blown up; tanh keeps single strong spots from ruling the spectrum.
    return (2 * np.tanh(centred / (2 * (spread + 0.25 * strength.std() + 1e-6)))).astype(np.float32)


def _slow_part(channel: Map) -> Map:
    """The channel blurred by an eighth of the picture, worked out on a small copy."""
    small = shrink(channel, _SMALL)
    blurred = ndimage.gaussian_filter(small, max(small.shape) / 8, truncate=2.5)
    return transform.resize(blurred, channel.shape, order=1)
