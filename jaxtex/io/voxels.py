"""Voxel blocks as `.npz` files: written part by part, and read."""

import math
import zipfile
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.io.arrays import read_arrays
from jaxtex.io.files import replacing


def write_voxels(
    path: Path | str, parts: Iterable[npt.NDArray[np.float32]], *, shape: tuple[int, int, int, int]
) -> None:
    """Write a block of voxels to a `.npz` file, key `voxels`, whole or not at all; it is never held in memory.

    Args:
        path: the file, *.npz; `numpy.load` reads it.
        parts: [voxel, channel], some voxels at a time: row by row, slice by slice.
        shape: of the whole block [z, y, x, channel].

    Raises:
        InputError: the file has another extension, or cannot be made.
        ValueError: the parts are not a block of that shape.

    Examples:
        >>> write_voxels("oak.npz", (np.full((6, 3), z) for z in range(4)), shape=(4, 2, 3, 3))
        >>> np.load("oak.npz")["voxels"][2, 0, 0].tolist()
        [2.0, 2.0, 2.0]
    """
    path = Path(path)
    if path.suffix.lower() != ".npz":
        raise InputError(f"{path}: cannot be written as '{path.suffix}'; name it .npz")
    # With a date of its own, the same voxels give the same bytes.
    entry = zipfile.ZipInfo("voxels.npy", date_time=(1980, 1, 1, 0, 0, 0))
    written = 0
    with replacing(path) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        with archive.open(entry, "w", force_zip64=True) as file:
            header = {"descr": "<f4", "fortran_order": False, "shape": shape}
            np.lib.format.write_array_header_1_0(file, header)
            for part in parts:
                if part.shape[1:] != shape[3:]:
                    raise ValueError(f"voxels of shape {part.shape} are no part of a block of shape {shape}")
                file.write(np.ascontiguousarray(part, "<f4").tobytes())
                written += len(part)
        if written != math.prod(shape[:3]):
            raise ValueError(f"there are {written} of the {math.prod(shape[:3])} voxels of a block of shape {shape}")


def read_voxels(path: Path | str) -> npt.NDArray[np.float32]:
    """Read a block of voxels, key `voxels`, from a `.npz` file, as `write_voxels` and `numpy.savez` write it.

    Returns:
        [z, y, x, channel], linear light.

    Raises:
        InputError: there is no such file, or it is damaged; it holds no such array of floating-point numbers, or an
            empty one; a number is not finite.

    Examples:
        >>> np.savez("oak.npz", voxels=np.full((2, 3, 4, 1), 0.5))
        >>> read_voxels("oak.npz").shape
        (2, 3, 4, 1)
    """
    arrays = read_arrays(path)
    if "voxels" not in arrays:
        raise InputError(f"{path}: holds no array 'voxels'; save the block under that name")
    voxels = arrays["voxels"]
    if voxels.ndim != 4 or voxels.size == 0:
        raise InputError(f"{path}: voxels of shape {voxels.shape} are no block; save [z, y, x, channel], none empty")
    if not np.issubdtype(voxels.dtype, np.floating):
        raise InputError(f"{path}: voxels are {voxels.dtype}; save linear light as floating-point numbers")
    with np.errstate(over="ignore"):
        single = voxels.astype(np.float32, copy=False)
    if not np.isfinite(single).all():
        z, y, x, _ = np.argwhere(~np.isfinite(single))[0]
        raise InputError(
            f"{path}: holds NaN or infinite numbers, the first at z {z}, y {y}, x {x}; save the block again"
        )
    return single
