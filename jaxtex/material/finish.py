"""Finishes by structure (Lefebvre & Poulin 2000, section 4.1): varnish on the tiles and not on the joints, say."""

import dataclasses
from collections.abc import Mapping
from typing import NamedTuple

from jaxtex.core.errors import InputError
from jaxtex.material.appearance import Appearance


class Finish(NamedTuple):
    """How a surface reflects, besides its colour; see `Appearance`."""

    roughness: float
    specular: float
    metallic: float = 0.0


FINISHES: Mapping[str, Finish] = {
    "dull": Finish(0.95, 0.25),
    "satin": Finish(0.45, 0.5),
    "varnish": Finish(0.12, 0.5),
    "wet": Finish(0.05, 0.25),  # of water, which reflects 2 %
    "mirror": Finish(0.02, 0.5, 1.0),
}


def find_finish(name: str) -> Finish:
    """The finish of a name.

    Raises:
        InputError: there is none of this name.
    """
    if name not in FINISHES:
        raise InputError(f"'{name}' is no finish; give one of {', '.join(FINISHES)}")
    return FINISHES[name]


def finish_tiling(appearance: Appearance, finishes: Mapping[str, str]) -> Appearance:
    """Give structures of a tiling a finish.

    Args:
        finishes: names of finishes by structure: tile, joint.

    Raises:
        InputError: there is no such structure or finish.

    Examples:
        >>> plain = Appearance(tiles={(0, 0): (0.3, 0.3, 0.3)}, joint=(0.5, 0.5, 0.5))
        >>> glazed = finish_tiling(plain, {"tile": "varnish"})
        >>> glazed.tile_roughness, glazed.joint_roughness
        (0.12, 0.9)
    """
    check_structures(finishes, ("tile", "joint"), "a tiling")
    changes = {
        f"{structure}_{name}": value
        for structure, finish in finishes.items()
        for name, value in find_finish(finish)._asdict().items()
    }
    return dataclasses.replace(appearance, **changes)


class WoodFinish(NamedTuple):
    """Of early and of late wood."""

    early: Finish
    late: Finish


BARE_WOOD = WoodFinish(Finish(0.65, 0.5), Finish(0.5, 0.5))
"""Late wood, the harder, shines a little more, as on a brushed plank."""


def finish_wood(finishes: Mapping[str, str]) -> WoodFinish:
    """Give structures of wood a finish; those without one stay bare.

    Args:
        finishes: names of finishes by structure: early, late.

    Raises:
        InputError: there is no such structure or finish.

    Examples:
        >>> finish_wood({"late": "varnish"}).late.roughness
        0.12
    """
    check_structures(finishes, WoodFinish._fields, "wood")
    return BARE_WOOD._replace(**{structure: find_finish(name) for structure, name in finishes.items()})


def check_structures(finishes: Mapping[str, str], structures: tuple[str, ...], model: str) -> None:
    """Refuse finishes of structures that a model does not have.

    Raises:
        InputError: there is such a one.
    """
    for structure in finishes:
        if structure not in structures:
            raise InputError(f"'{structure}' is no structure of {model}, which has {' and '.join(structures)}")
