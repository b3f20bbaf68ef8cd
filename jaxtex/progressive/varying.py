"""A progressively-variant texture: pixels, and what is known about each of them.

J. Zhang et al., "Synthesis of Progressively-Variant Textures on Arbitrary Surfaces" (SIGGRAPH 2003), section 3: the
tuple (T, M, F, V). Departure: how large things are, and how far a transition is, are two functions rather than one F.
"""

from pathlib import Path
from typing import NamedTuple, Self

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.io.arrays import read_arrays, write_arrays

_MOST_LABEL = 3
_UNIT = 1e-3  # by which lengths of unit vectors may differ from 1
_FORMS = {"texture": 3, "mask": 2, "transition": 2, "orientation": 3, "scale": 2}


class VaryingTexture(NamedTuple):
    """A texture whose elements vary, with its fields; all arrays are of one height and width.

    Attributes:
        texture: linear light, float32 [row, col, channel].
        mask: which type of element each pixel belongs to, uint8 [row, col], 0 (none) to 3.
        transition: float32 [row, col], 0 to 1.
        orientation: (x, y) of unit vectors, y down, float32 [row, col, 2].
        scale: float32 [row, col], above 0.
    """

    texture: npt.NDArray[np.float32]
    mask: npt.NDArray[np.uint8]
    transition: npt.NDArray[np.float32]
    orientation: npt.NDArray[np.float32]
    scale: npt.NDArray[np.float32]

    @classmethod
    def of(
        cls,
        texture: npt.ArrayLike,
        *,
        mask: npt.ArrayLike | None = None,
        transition: npt.ArrayLike | None = None,
        orientation: npt.ArrayLike | None = None,
        scale: npt.ArrayLike | None = None,
    ) -> Self:
        """Put a texture together with what varies in it; what is left out is the same everywhere.

        Args:
            texture: linear light, [row, col] or [row, col, channel] of 1 or 3 channels.
            mask: labels [row, col], 0 to 3; 0 by default.
            transition: [row, col], 0 to 1; 0 by default.
            orientation: (x, y) of unit vectors, [row, col, 2]; (1, 0) by default.
            scale: [row, col], above 0; 1 by default.

        Raises:
            ValueError: arrays of another form or size, or values out of range.

        Examples:
            >>> VaryingTexture.of(np.zeros((4, 6))).orientation[0, 0].tolist()
            [1.0, 0.0]
        """
        pixels = np.asarray(texture, np.float32)
        pixels = pixels[..., None] if pixels.ndim == 2 else pixels
        size = pixels.shape[:2]
        labels = np.zeros(size, np.uint8) if mask is None else np.asarray(mask)
        made = cls(
            pixels,
            labels,
            np.asarray(np.zeros(size) if transition is None else transition, np.float32),
            np.asarray(np.broadcast_to([1.0, 0.0], (*size, 2)) if orientation is None else orientation, np.float32),
            np.asarray(np.ones(size) if scale is None else scale, np.float32),
        )
        _check(made)
        return made._replace(mask=labels.astype(np.uint8))


def write_varying(path: Path | str, varying: VaryingTexture) -> None:
    """Write it to one `.npz` file, with the arrays `texture`, `mask`, `transition`, `orientation` and `scale`.

    Raises:
        InputError: the file cannot be made.
        ValueError: arrays of another form or size, or values out of range.

    Examples:
        >>> write_varying("coat.npz", VaryingTexture.of(np.zeros((4, 6, 3))))
        >>> read_varying("coat.npz").texture.shape
        (4, 6, 3)
    """
    write_arrays(path, VaryingTexture.of(**varying._asdict())._asdict())


def read_varying(path: Path | str) -> VaryingTexture:
    """Read what `write_varying` wrote.

    Raises:
        InputError: there is no such file, it is damaged, an array is missing, or holds what it may not.
    """
    arrays = read_arrays(path)
    for name in VaryingTexture._fields:
        if name not in arrays:
            raise InputError(f"{path}: holds no {name}; a varying texture holds {', '.join(VaryingTexture._fields)}")
    for name in arrays:
        if name not in VaryingTexture._fields:
            raise InputError(
                f"{path}: {name} is not known; a varying texture holds {', '.join(VaryingTexture._fields)}"
            )
    texture = arrays.pop("texture")
    try:
        return VaryingTexture.of(texture, **arrays)
    except (ValueError, TypeError) as error:
        raise InputError(f"{path}: {error}") from None


def _check(varying: VaryingTexture) -> None:
    arrays = varying._asdict()
    height, width = varying.texture.shape[:2]
    for name, dimensions in _FORMS.items():
        array = arrays[name]
        if array.ndim != dimensions or 0 in array.shape:
            raise ValueError(f"{name} of shape {array.shape}: give {dimensions} dimensions, none empty")
        if array.shape[:2] != (height, width):
            raise ValueError(f"{name} is {array.shape[1]} x {array.shape[0]}, its texture {width} x {height}")
        if array.dtype.kind not in "fiub" or not np.isfinite(array).all():
            raise ValueError(f"{name} holds what is no finite number")
    if varying.texture.shape[2] not in (1, 3):
        raise ValueError(f"texture has {varying.texture.shape[2]} channels; give 1 or 3")
    if varying.orientation.shape[2] != 2:
        raise ValueError(f"orientation has {varying.orientation.shape[2]} channels; give x and y")
    if not np.isin(varying.mask, range(_MOST_LABEL + 1)).all():
        raise ValueError(f"mask holds labels beside 0 to {_MOST_LABEL}")
    if varying.transition.min() < 0 or varying.transition.max() > 1:
        raise ValueError("transition holds values outside 0 to 1")
    if varying.scale.min() <= 0:
        raise ValueError("scale holds values that are not above 0")
    if np.abs(np.hypot(varying.orientation[..., 0], varying.orientation[..., 1]) - 1).max() > _UNIT:
        raise ValueError("orientation holds vectors whose length is not 1")
