"""Solid textures on the command line: blocks of voxels that options name."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from jaxtex.models.solid import Solid


def read_solid(path: Path, *, vary: int | None) -> "Solid":
    """The solid texture of a block's file, repeated at random offsets where `vary` is their seed.

    Raises:
        InputError: as `read_voxels`; a seed out of range.
    """
    from jaxtex.cli.values import check_seed
    from jaxtex.io.voxels import read_voxels

    seed = None if vary is None else check_seed(vary, option="--vary")
    voxels = read_voxels(path)

    from jaxtex.models.solid import make_solid

    return make_solid(voxels, offsets_seed=seed)


def tell_format(path: Path, shape: tuple[int, int, int, int]) -> None:
    """Print how a block [z, y, x, channel] lies in its files, where their format does not say so by itself."""
    from jaxtex.io.voxels import block_files

    depth, height, width, channels = shape
    files = block_files(path, depth)
    if path.suffix.lower() == ".exr":
        print(f"  slices across z: {files[0].name} to {files[-1].name}")
    elif path.suffix.lower() == ".raw":
        print(f"  float32, little-endian, [z, y, x, channel] = [{depth}, {height}, {width}, {channels}] in C order")
        print(f"  {files[-1].name} says so to other programs")
