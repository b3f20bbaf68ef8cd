"""What a model file of a floor holds: planks, and the wood of each; `jaxtex.models.files` reads and writes it.

The format is described, key by key, by the JSON Schema `floor-1.json` beside this module.
"""

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jaxtex.models.envelope import SourceImage
from jaxtex.models.wood import Wood
from jaxtex.models.wood_files import wood_from_parameters, wood_parameters


@dataclasses.dataclass(frozen=True, eq=False)
class PlacedWood:
    """A plank of a floor.

    Attributes:
        corners: (4, 2), (x, y) in pixels of the photograph, in order around the plank.
        wood: the plank's point (0, 0) is the middle of its corners, its u and v those of the photograph.
        own: whether the wood was read off this plank.
    """

    corners: NDArray[np.float64]
    wood: Wood
    own: bool


@dataclasses.dataclass(frozen=True, eq=False)
class FloorFile:
    """What a model file of a floor holds.

    Attributes:
        planks: none of them overlap.
        image: the photograph.
        report: as `WoodFile` has it; `iou` and `start` are None.
        seed: of all random choices. The turbulence of plank n is that of seed + n.
        versions: of the software that wrote the file; by default of the software that runs.
    """

    planks: tuple[PlacedWood, ...]
    image: SourceImage
    report: Mapping[str, Any]
    seed: int = 0
    versions: Mapping[str, str] | None = None


def wood_of_plank(parameters: Mapping[str, Any], *, seed: int, number: int) -> Wood:
    """The wood of a floor's plank of a number, of named parameters as they stand in a model file.

    Every plank has turbulence of its own: that of the floor's seed and its number together.
    """
    return wood_from_parameters(parameters, seed=seed + number)


def floor_content(file: FloorFile) -> dict[str, Any]:
    """What is a floor's own in a model file's document."""
    planks = [
        {"corners": plank.corners, "wood": wood_parameters(plank.wood), "own": plank.own} for plank in file.planks
    ]
    return {"planks": planks, "report": file.report}


def floor_from_document(document: Mapping[str, Any]) -> FloorFile:
    """The file of a document that is as its schema has it.

    Raises:
        ValueError: a plank's parameters are no wood.
    """
    seed = int(document["seed"])
    planks = tuple(
        PlacedWood(np.array(each["corners"], float), wood_of_plank(each["wood"], seed=seed, number=number), each["own"])
        for number, each in enumerate(document["planks"])
    )
    image = SourceImage(**document["image"])
    return FloorFile(planks, image, document["report"], seed, document.get("versions"))
