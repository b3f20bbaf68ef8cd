"""Something with a material on it, as one file for viewers, engines and modellers.

`WRITERS` has a writer for each kind of file; another kind is another line.
"""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from jaxtex.core.errors import InputError
from jaxtex.io.gltf import MaterialImages, write_glb
from jaxtex.io.meshes import TexturedMesh


class Scene(NamedTuple):
    """What is handed over.

    Attributes:
        mesh: in metres, y upwards.
        images: its material.
        repeat: how often the material's picture stands on it, to the right and downwards, where u and v go from 0 to 1.
        name: what clients show.
    """

    mesh: TexturedMesh
    images: MaterialImages
    repeat: tuple[float, float] = (1.0, 1.0)
    name: str = "material"


def _write_glb(path: Path, scene: Scene) -> None:
    write_glb(path, scene.mesh, scene.images, repeat=scene.repeat, name=scene.name)


WRITERS: dict[str, Callable[[Path, Scene], None]] = {".glb": _write_glb}
"""From a file's suffix to what writes it: whole or not at all, with an `InputError` for what cannot be written."""


def find_writer(path: Path | str) -> Callable[[Path, Scene], None]:
    """The one of `WRITERS` for a file.

    Raises:
        InputError: there is none for its suffix.

    Examples:
        >>> find_writer("wall.glb").__name__
        '_write_glb'
    """
    suffix = Path(path).suffix.lower()
    if suffix not in WRITERS:
        raise InputError(f"{path}: cannot be written as '{suffix}'; name it {' or '.join(WRITERS)}")
    return WRITERS[suffix]
