"""Voxel blocks as files of several formats, written part by part; and read from `.npz`."""

import math
import zipfile
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.io.arrays import read_arrays
from jaxtex.io.files import place_for_file, replacing
from jaxtex.io.volumes import (
    Parts,
    Shape,
    check_grid,
    check_stack,
    is_slice,
    name_header,
    name_slices,
    write_raw,
    write_stack,
    write_vol,
)


def write_voxels(
    path: Path | str, parts: Iterable[npt.NDArray[np.float32]], *, shape: tuple[int, int, int, int]
) -> None:
    """Write a block of voxels, whole or not at all; it is never held in memory. The extension tells the format:

    - `.npz`: float32, key `voxels`; `read_voxels` and `numpy.load` read it;
    - `.exr`: slices across z as numbered files, oak.exr as oak.0000.exr and so on, of halves;
    - `.raw`: bare float32, little-endian, channels fastest, then x, y, z; a NRRD header of the same name, `.nhdr`, says
      so to ParaView, 3D Slicer and others, and takes the place of one that stands there;
    - `.vol`: a grid volume of the renderer Mitsuba, version 3, float32, of 1, 3 or 6 channels.

    Args:
        path: the file.
        parts: [voxel, channel], linear light, some voxels at a time: row by row, slice by slice.
        shape: of the whole block [z, y, x, channel].

    Raises:
        InputError: as `check_block`, or a file cannot be made.
        ValueError: the parts are not a block of that shape.

    Examples:
        >>> write_voxels("oak.npz", (np.full((6, 3), z) for z in range(4)), shape=(4, 2, 3, 3))
        >>> np.load("oak.npz")["voxels"][2, 0, 0].tolist()
        [2.0, 2.0, 2.0]
    """
    path = check_block(path, shape)
    _WRITERS[path.suffix.lower()](path, _checked(parts, shape), shape)


def check_block(path: Path | str, shape: tuple[int, int, int, int]) -> Path:
    """`path` as a `Path`, once it is known that a block of that shape can be written there; for work that takes long.

    Raises:
        InputError: the extension is none of `write_voxels`; there is no such folder; of a grid volume: there
            are other than 1, 3 or 6 channels; of a stack of slices: there are other than 1 or 3, or slices of a deeper
            stack of that name lie there.

    Examples:
        >>> check_block("oak.vol", (4, 4, 4, 3)).name
        'oak.vol'
    """
    path = Path(path)
    if path.suffix.lower() not in _WRITERS:
        raise InputError(f"{path}: cannot be written as '{path.suffix}'; name it {', '.join(_WRITERS)}")
    for each in block_files(path, shape[0]):
        place_for_file(each)
    if check := {".exr": check_stack, ".vol": check_grid}.get(path.suffix.lower()):
        check(path, shape)
    return path


def block_files(path: Path, depth: int) -> list[Path]:
    """The files that `write_voxels` makes of a block of so many slices."""
    kind = path.suffix.lower()
    if kind == ".exr":
        return name_slices(path, depth)
    return [path, name_header(path)] if kind == ".raw" else [path]


def find_taken(path: Path, depth: int, others: Iterable[Path]) -> Path | None:
    """The first of other files that `write_voxels` would write over, or that would be taken for a slice of its stack.

    Examples:
        >>> others = [Path("view.png"), Path("oak.0040.exr")]
        >>> find_taken(Path("oak.npz"), 16, others), find_taken(Path("oak.exr"), 16, others).name
        (None, 'oak.0040.exr')
    """
    files = {each.resolve() for each in block_files(path, depth)}
    folder = path.parent.resolve() if path.suffix.lower() == ".exr" else None
    for each in others:
        if each.resolve() in files or (each.parent.resolve() == folder and is_slice(each, path)):
            return each
    return None


def _write_npz(path: Path, parts: Parts, shape: Shape) -> None:
    # With a date of its own, the same voxels give the same bytes.
    entry = zipfile.ZipInfo("voxels.npy", date_time=(1980, 1, 1, 0, 0, 0))
    with (
        replacing(path) as temporary,
        zipfile.ZipFile(temporary, "w") as archive,
        archive.open(entry, "w", force_zip64=True) as file,
    ):
        np.lib.format.write_array_header_1_0(file, {"descr": "<f4", "fortran_order": False, "shape": shape})
        for part in parts:
            file.write(part.tobytes())


_WRITERS: dict[str, Callable[[Path, Parts, Shape], None]] = {
    ".npz": _write_npz,
    ".exr": write_stack,
    ".raw": write_raw,
    ".vol": write_vol,
}


def _checked(parts: Iterable[npt.NDArray], shape: Shape) -> Parts:
    """The parts as little-endian float32, once each is known to belong to a block of that shape, and all to fill it."""
    written, total = 0, math.prod(shape[:3])
    for part in parts:
        written += len(part)
        if part.shape[1:] != shape[3:] or written > total:
            raise ValueError(f"voxels of shape {part.shape} are no part of a block of shape {shape}")
        yield np.ascontiguousarray(part, "<f4")
    if written != total:
        raise ValueError(f"there are {written} of the {total} voxels of a block of shape {shape}")


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
