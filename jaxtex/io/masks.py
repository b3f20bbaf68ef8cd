"""Masks: 1 (white) where a tile is, 0 (black) where a joint is. Their values are coverage, never encoded as colours."""

from pathlib import Path

import numpy as np

from jaxtex.core.errors import InputError
from jaxtex.io.images import read_image, write_image


def read_mask(path: Path | str) -> np.ndarray:
    """Read a mask from an image file, upright by its EXIF orientation.

    Args:
        path: the file; grey, or RGB with equal channels.

    Returns:
        float32 [row, col], 0 (joint) to 1 (tile).

    Raises:
        InputError: as `read_image`; or the picture is coloured, partly transparent, or has values outside 0 to 1.

    Examples:
        >>> write_mask("mask.png", np.array([[True, False]]))
        >>> read_mask("mask.png")
        array([[1., 0.]], dtype=float32)
    """
    image = read_image(path, colour_space="data")
    values = image.pixels
    if image.alpha is not None and image.alpha.min() < 1:
        raise InputError(f"{path}: is partly transparent and so no mask; fill its ground with white or black")
    # Lossy files of grey pictures differ between channels by a level or two.
    if np.ptp(values, axis=-1).max() > 4 / 255:
        raise InputError(f"{path}: is coloured and so no mask; a mask is white, grey and black alone")
    mask = values.mean(axis=-1)
    if mask.min() < 0 or mask.max() > 1:
        raise InputError(
            f"{path}: is no mask, since its values go from {mask.min():.4g} to {mask.max():.4g}; 0 to 1 do"
        )
    return mask


def write_mask(path: Path | str, mask: np.ndarray) -> None:
    """Write a mask to an image file: white on tiles, black on joints, 8 bits (EXR: float), whole or not at all.

    Args:
        path: the file; its extension tells the format.
        mask: [row, col], bool or float 0 (joint) to 1 (tile).

    Raises:
        InputError: as `write_image`, of data.
    """
    mask = np.asarray(mask)
    if mask.ndim != 2:
        raise InputError(f"{path}: a mask has the shape [row, col], not {mask.shape}")
    write_image(path, mask.astype(np.float32), colour_space="data")
