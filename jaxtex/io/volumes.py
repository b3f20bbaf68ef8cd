"""Voxel blocks in the formats of other programs: stacks of slices, bare numbers with a header, Mitsuba's grid volumes.

Each writer takes the block as parts [voxel, channel], little-endian float32, in the order of the array
[z, y, x, channel].
"""

import struct
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.io.files import replacing, replacing_together
from jaxtex.io.images import write_image

Shape = tuple[int, int, int, int]
Parts = Iterable[npt.NDArray[np.float32]]


def name_slices(path: Path, depth: int) -> list[Path]:
    """The files of a stack of slices, from z = 0 on.

    Examples:
        >>> [each.name for each in name_slices(Path("oak.exr"), 2)]
        ['oak.0000.exr', 'oak.0001.exr']
    """
    return [path.with_name(f"{path.stem}.{z:04}{path.suffix}") for z in range(depth)]


def is_slice(file: Path, path: Path) -> bool:
    """Whether a file's name is that of a slice of the stack `path`, however deep.

    Examples:
        >>> [is_slice(Path(name), Path("oak.exr")) for name in ("oak.0040.exr", "oak.final.exr", "elm.0000.exr")]
        [True, False, False]
    """
    head, tail = f"{path.stem}.", path.suffix
    name = file.name
    return name.startswith(head) and name.endswith(tail) and name[len(head) : -len(tail)].isdecimal()


def check_stack(path: Path, shape: Shape) -> None:
    """Refuse stacks of slices that cannot be written.

    Raises:
        InputError: the block has other than 1 or 3 channels; slices of a deeper stack of that name lie there, which
            would be taken for this one's.
    """
    if shape[3] not in (1, 3):
        raise InputError(f"{path}: the block has {shape[3]} channels, and slices hold 1 (grey) or 3; write .npz")
    beside = {each.name for each in path.parent.iterdir() if is_slice(each, path)}
    others = beside - {each.name for each in name_slices(path, shape[0])}
    if left := sorted(others):
        told = left[0] if len(left) == 1 else f"{left[0]} to {left[-1]}"
        raise InputError(f"{path}: {told} of another stack would be taken for this one's; remove or rename them")


def name_header(path: Path) -> Path:
    """The header of a file of bare numbers."""
    return path.with_suffix(".nhdr")


def write_stack(path: Path, parts: Parts, shape: Shape) -> None:
    """Slices across z as numbered EXR files of halves, linear light: oak.exr is oak.0000.exr and so on.

    Raises:
        InputError: as `check_stack` and `write_image`.
    """
    check_stack(path, shape)
    with replacing_together(name_slices(path, shape[0])) as names:
        for name, across in zip(names, _slices(parts, shape), strict=True):
            write_image(name, across)


def write_raw(path: Path, parts: Parts, shape: Shape) -> None:
    """Bare float32, little-endian, as the array lies in memory; a NRRD header beside it, `.nhdr`, says so.

    The header is of version 4 (http://teem.sourceforge.net/nrrd/format.html): channels are its first axis where there
    is more than one, then come x, y, z.
    """
    with replacing_together([path, name_header(path)]) as (numbers, told):
        with numbers.open("wb") as file:
            for part in parts:
                file.write(part.tobytes())
        told.write_text(_nrrd_header(path.name, shape), encoding="utf-8", newline="\n")


def check_grid(path: Path, shape: Shape) -> None:
    """Refuse blocks that are no grid volumes.

    Raises:
        InputError: the block has other than 1, 3 or 6 channels, which are all that Mitsuba reads.
    """
    if shape[3] not in (1, 3, 6):
        raise InputError(f"{path}: the block has {shape[3]} channels, and Mitsuba reads 1, 3 or 6; write .npz")


def write_vol(path: Path, parts: Parts, shape: Shape) -> None:
    """A grid volume of the renderer Mitsuba, version 3, float32. Its bounding box has the block's proportions, the
    longest side 1.

    Raises:
        InputError: as `check_grid`.
    """
    check_grid(path, shape)
    depth, height, width, channels = shape
    box = np.array([width, height, depth]) / max(width, height, depth)
    with replacing(path) as temporary, temporary.open("wb") as file:
        file.write(struct.pack("<3sB5i6f", b"VOL", 3, 1, width, height, depth, channels, 0, 0, 0, *box))
        for part in parts:
            file.write(part.tobytes())


def _nrrd_header(name: str, shape: Shape) -> str:
    depth, height, width, channels = shape
    channel_kind = [{3: "RGB-color", 4: "RGBA-color"}.get(channels, "list")] if channels > 1 else []
    sizes = [*[channels for _ in channel_kind], width, height, depth]
    lines = [
        "NRRD0004",
        "# float32 [z, y, x, channel] in C order, linear light",
        "type: float",
        f"dimension: {len(sizes)}",
        f"sizes: {_words(sizes)}",  # before the dimension of space, or VTK takes that for the array's
        f"kinds: {_words([*channel_kind, *['domain'] * 3])}",
        "space dimension: 3",
        f"space directions: {_words([*['none' for _ in channel_kind], '(1,0,0)', '(0,1,0)', '(0,0,1)'])}",
        "endian: little",
        "encoding: raw",
        f"data file: {name}",
    ]
    return "\n".join(lines) + "\n"


def _words(values: Iterable[object]) -> str:
    return " ".join(map(str, values))


def _slices(parts: Parts, shape: Shape) -> Iterator[npt.NDArray[np.float32]]:
    """[row, col, channel], however the voxels come."""
    across = np.empty((shape[1] * shape[2], shape[3]), np.float32)
    filled = 0
    for part in parts:
        taken = 0
        while taken < len(part):
            count = min(len(part) - taken, len(across) - filled)
            across[filled : filled + count] = part[taken : taken + count]
            taken, filled = taken + count, filled + count
            if filled == len(across):
                yield across.reshape(shape[1:])
                filled = 0
