"""What a file of a mixture holds: the names of models, masks and photographs, and how they go together.

The format is described, key by key, by the JSON Schema `mixture-1.json` beside this module. Files are named relative to
the mixture's own folder, so that a folder of them can be moved as a whole.
"""

import dataclasses
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from jaxtex.core.errors import InputError


@dataclasses.dataclass(frozen=True)
class MixedWood:
    """Wood in the base's tiles.

    Attributes:
        model: name of its model file.
        scale: how many plane pixels of the base a pixel of the wood's photograph is long.
    """

    model: str
    scale: float = 1.0


@dataclasses.dataclass(frozen=True)
class ModelLayer:
    """Another model, seen where a mask is white.

    Attributes:
        mask, model: names of files.
        scale: how many plane pixels of the base a pixel of the layer's photograph is long.
    """

    mask: str
    model: str
    scale: float = 1.0


@dataclasses.dataclass(frozen=True)
class PhotographLayer:
    """The base's photograph, kept where a mask is white.

    Attributes:
        mask, photograph: names of files.
    """

    mask: str
    photograph: str


@dataclasses.dataclass(frozen=True)
class MixtureFile:
    """What a file of a mixture holds.

    Attributes:
        base: name of the model file of what lies below.
        wood: in the tiles of the base.
        layers: over it, from below.
        versions: of the software that wrote the file; by default of the software that runs.
    """

    base: str
    wood: MixedWood | None = None
    layers: tuple[ModelLayer | PhotographLayer, ...] = ()
    versions: Mapping[str, str] | None = None

    def names(self) -> Iterator[str]:
        """Of all files that it is made of.

        Examples:
            >>> list(MixtureFile("wall.json", MixedWood("oak.json")).names())
            ['wall.json', 'oak.json']
        """
        yield self.base
        if self.wood is not None:
            yield self.wood.model
        for layer in self.layers:
            yield layer.mask
            yield layer.model if isinstance(layer, ModelLayer) else layer.photograph


def name_beside(path: Path | str, part: Path | str) -> str:
    """How a mixture's file names a part of it: relative to its own folder, or absolute where it is given so.

    Args:
        path: the mixture's file.
        part: the part's, relative to where the program runs.

    Raises:
        InputError: the part is the mixture's file itself.

    Examples:
        >>> name_beside("mixed/mix.json", "wall/model.json")
        '../wall/model.json'
    """
    folder, place = os.path.realpath(Path(path).parent), os.path.realpath(Path(part).parent)
    if os.path.join(folder, Path(path).name) == os.path.join(place, Path(part).name):
        raise InputError(f"{path}: is a part of the mixture itself; give it a file of its own")
    if Path(part).is_absolute():
        return Path(part).as_posix()
    try:
        return Path(os.path.relpath(os.path.join(place, Path(part).name), folder)).as_posix()
    except ValueError:  # on another drive
        return Path(place, Path(part).name).as_posix()


def find_part(path: Path | str, name: str) -> Path:
    """The file that a mixture's file calls by a name.

    Examples:
        >>> find_part("mixed/mix.json", "../wall/model.json").as_posix()
        'mixed/../wall/model.json'
    """
    return Path(path).parent / name


def mixture_content(file: MixtureFile) -> dict[str, Any]:
    """What is a mixture's own in its document."""
    layers = [
        {name: value for name, value in dataclasses.asdict(layer).items() if (name, value) != ("scale", 1.0)}
        for layer in file.layers
    ]
    return {"base": file.base, "wood": file.wood and dataclasses.asdict(file.wood), "layers": layers}


def mixture_from_document(document: Mapping[str, Any]) -> MixtureFile:
    """The file of a document that is as its schema has it."""
    wood = document.get("wood")
    return MixtureFile(
        base=document["base"],
        wood=None if wood is None else MixedWood(wood["model"], float(wood["scale"])),
        layers=tuple(
            ModelLayer(each["mask"], each["model"], float(each.get("scale", 1.0)))
            if "model" in each
            else PhotographLayer(each["mask"], each["photograph"])
            for each in document["layers"]
        ),
        versions=document.get("versions"),
    )
