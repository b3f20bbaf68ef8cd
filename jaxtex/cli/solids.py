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
