"""What `jaxtex render` makes of wood: maps of the plank, a block of voxels, a carved mesh."""

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from jaxtex.core.errors import InputError
from jaxtex.material.finish import BARE_WOOD, WoodFinish, finish_wood

if TYPE_CHECKING:
    from jaxtex.models.wood_files import WoodFile


class WoodTask(NamedTuple):
    """What was asked for.

    Attributes:
        size: (width, height) of the maps in pixels.
        block: (depth, height, width) in voxels.
        mesh: the file of the mesh to carve.
        finishes: names of finishes by structure.
    """

    size: tuple[int, int] | None = None
    block: tuple[int, int, int] | None = None
    mesh: Path | None = None
    finishes: Mapping[str, str] = MappingProxyType({})


def render_wood_file(file: "WoodFile", output: Path, task: WoodTask) -> None:
    """Write the maps of a plank, or the block or carved mesh that was asked for, into a folder.

    Raises:
        InputError: it cannot be made; nothing is written then.
    """
    given = [f"--{option}" for option in ("size", "block", "mesh") if getattr(task, option) is not None]
    if len(given) > 1:
        raise InputError(f"{' and '.join(given)}: ask for different things; give one of them")
    if task.finishes and given and given != ["--size"]:
        raise InputError(f"{given[0]}: holds colours alone, which --finish does not change; leave one of them out")
    finish = finish_wood(task.finishes)
    if task.block is not None:
        _write_block(file, output, task.block)
    elif task.mesh is not None:
        _write_carving(file, output, task.mesh)
    else:
        size = task.size or (file.image.width, file.image.height)
        write_plank(output, file, size=size, finish=finish)
        scale = size[0] / file.image.width
        print(f"{output}: maps of {size[0]} x {size[1]} pixels, {scale:g} to one of the photograph")


def write_plank(folder: Path, file: "WoodFile", *, size: tuple[int, int], finish: WoodFinish = BARE_WOOD) -> None:
    """Write the maps of the photographed plank into a folder, with a bar for a person who waits.

    Args:
        folder: where to; it is made if there is none.
        file: the model.
        size: (width, height) of the maps in pixels.
        finish: of early and of late wood.

    Raises:
        InputError: as `render_wood`, `prepare_folder` and `write_maps`.
    """
    from jaxtex.cli.progress import progress
    from jaxtex.io.files import prepare_folder
    from jaxtex.material.bands import count_bands
    from jaxtex.material.export import write_maps
    from jaxtex.material.wood import WoodMaps, render_wood

    bands = render_wood(file.wood, across=file.image.width, size=size, finish=finish)
    shown = progress(bands, "rendering maps", total=count_bands(size))
    write_maps(prepare_folder(folder), shown, size=size, fields=WoodMaps._fields)


def _write_block(file: "WoodFile", output: Path, shape: tuple[int, int, int]) -> None:
    from jaxtex.cli.progress import progress
    from jaxtex.io.files import prepare_folder
    from jaxtex.io.voxels import write_voxels
    from jaxtex.material.wood import count_parts, render_block

    parts = render_block(file.wood, shape=shape)
    path = prepare_folder(output) / "voxels.npz"
    write_voxels(path, progress(parts, "rendering voxels", total=count_parts(shape)), shape=(*shape, 3))
    print(f"{path}: a block of {' x '.join(map(str, shape))} voxels")


def _write_carving(file: "WoodFile", output: Path, source: Path) -> None:
    from jaxtex.cli.values import naming
    from jaxtex.io.files import prepare_folder
    from jaxtex.io.meshes import read_mesh, write_mesh
    from jaxtex.material.wood import carve_mesh

    mesh = read_mesh(source)
    with naming(source):
        colours = carve_mesh(file.wood, mesh, image=(file.image.width, file.image.height))
    path = prepare_folder(output) / "mesh.ply"
    write_mesh(path, mesh, colours)
    print(f"{path}: a mesh of {len(mesh.vertices)} coloured vertices")
