"""Voxel blocks as `.npz` files, written part by part."""

import math
import zipfile
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
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
