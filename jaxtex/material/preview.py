"""A material under a lamp: what its maps look like together."""

import math

import numpy as np
import numpy.typing as npt

from jaxtex.material.maps import Maps

_LAMP = (-0.3, -0.45, 0.7)  # left of the sheet, above it and in front of it, in units of its longer side
_EYE = (0.5, 0.5, 2.2)
_SKY = 0.18  # light from all around, as a share of the lamp's
_REFLECTANCE = 0.04  # of stone, brick and glazing seen straight on
_PENUMBRA = 0.25  # of the relief


def shade_maps(maps: Maps, *, pixel: float) -> npt.NDArray[np.float32]:
    """Light the maps of a sheet with one lamp from the upper left, with shadows of its relief.

    Lambert's law and the GGX reflection model (B. Walter et al., Microfacet models for refraction, 2007; Smith's
    shadowing in C. Schlick's form) under a lamp near the sheet, and even light from all around that reaches less
    into joints.

    Args:
        maps: all rows of the maps.
        pixel: breadth of a pixel in plane pixels, the unit of the height; pixels are taken to be square.

    Returns:
        float32 [row, col, 3], linear light, in [0, 1].
    """
    rows, columns = maps.height.shape
    side = max(rows, columns)
    y, x = (np.indices((rows, columns), dtype=np.float32) + 0.5) / side
    here = np.stack([x, y, np.zeros_like(x)], axis=-1)
    normal = maps.normal * np.array([1, -1, 1], np.float32)  # as here: x right, y down
    away = np.asarray(_LAMP, np.float32) - here
    to_lamp, to_eye = _unit(away), _unit(np.asarray(_EYE, np.float32) - here)
    middle = away[rows // 2, columns // 2]
    lamp = np.sqrt(middle @ middle / np.square(away).sum(axis=-1))  # gentler than the square: the far side shows too
    lit = np.clip((normal * to_lamp).sum(axis=-1), 0, None) * lamp * _light_through(maps.height, pixel)
    relief = max(float(np.ptp(maps.height)), 1e-6)
    sky = _SKY * (0.55 + 0.45 * (maps.height - maps.height.min()) / relief)
    diffuse = maps.base_colour * (lit + sky)[..., None]
    shine = _ggx(normal, to_lamp, to_eye, maps.roughness) * lit
    light = diffuse + shine[..., None]
    # The middle looks as bright as its base colour, unless the side near the lamp would burn out.
    exposure = 1 / (to_lamp[rows // 2, columns // 2, 2] + _SKY)
    brightest = float(np.quantile(light.max(axis=-1), 0.98))
    return np.clip(min(exposure, 0.9 / max(brightest, 1e-6)) * light, 0, 1).astype(np.float32)


def _light_through(height: npt.NDArray[np.float32], pixel: float) -> npt.NDArray[np.float32]:
    """The share of the lamp that the relief lets through to each pixel; the lamp stands as over the sheet's middle."""
    rows, columns = height.shape
    side = max(rows, columns)
    across, down, up = _LAMP[0] - 0.5 * columns / side, _LAMP[1] - 0.5 * rows / side, _LAMP[2]
    reach = math.hypot(across, down)
    rise = up / reach * pixel  # of the ray, in units of height, for a pixel of way
    relief = float(np.ptp(height))
    blocked = np.zeros_like(height)
    for step in range(1, math.ceil(relief / rise) + 1 if relief > 0 else 1):
        shift = (-round(step * down / reach), -round(step * across / reach))
        over = np.roll(height, shift, axis=(0, 1)) - height - step * rise
        np.maximum(blocked, over, out=blocked)
    return 1 - np.clip(blocked / max(_PENUMBRA * relief, 1e-6), 0, 1)


def _ggx(
    normal: npt.NDArray[np.float32],
    to_lamp: npt.NDArray[np.float32],
    to_eye: npt.NDArray[np.float32],
    roughness: npt.NDArray[np.float32],
) -> npt.NDArray[np.float32]:
    """Light reflected at the surface, for lamp light of pi."""
    half = _unit(to_lamp + to_eye)
    n_half, n_lamp, n_eye = (np.clip((normal * to).sum(axis=-1), 1e-3, 1) for to in (half, to_lamp, to_eye))
    alpha = np.maximum(roughness, 0.05) ** 2
    spread = alpha**2 / (n_half**2 * (alpha**2 - 1) + 1) ** 2
    k = alpha / 2
    hidden = 1 / ((n_lamp * (1 - k) + k) * (n_eye * (1 - k) + k))
    fresnel = _REFLECTANCE + (1 - _REFLECTANCE) * (1 - np.clip((half * to_eye).sum(axis=-1), 0, 1)) ** 5
    return spread * hidden * fresnel / 4


def _unit(vectors: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    return vectors / np.sqrt(np.square(vectors).sum(axis=-1, keepdims=True))
