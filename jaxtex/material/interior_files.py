"""Interiors as a file beside their model's: the arrays that JSON is no place for."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.io.arrays import read_arrays, write_arrays
from jaxtex.material.appearance import appearance_of
from jaxtex.material.grain import from_steps, to_steps
from jaxtex.material.interiors import Interiors
from jaxtex.material.planks import PlankGrain, PlankInteriors
from jaxtex.models.files import TilingFile
from jaxtex.models.floor_files import FloorFile

InteriorsT = TypeVar("InteriorsT")

_SCHEMA = 1


def write_interiors(path: Path | str, interiors: Interiors | PlankInteriors) -> None:
    """Write interiors to a `.npz` file, whole or not at all.

    Grain is kept in the steps in which it was measured, so that what is read is what was written.

    Raises:
        InputError: the file cannot be made.
    """
    of_tiles = isinstance(interiors, Interiors)
    arrays = _tile_arrays(interiors) if isinstance(interiors, Interiors) else _plank_arrays(interiors)
    write_arrays(path, {"schema": _SCHEMA, "kind_of_interiors": "tiles" if of_tiles else "planks", **arrays})


def interiors_of_tiles(source: Path | str, file: TilingFile) -> Interiors | None:
    """The interiors that a model file names, read from beside it; None where it names none.

    Args:
        source: the model file.
        file: its content.

    Raises:
        InputError: they are not there, damaged, or another model's.
    """
    interiors = _read_beside(source, (file.appearance or {}).get("interiors"), "tiles", _tiles_from_arrays)
    if interiors is not None and not set(map(tuple, interiors.places.tolist())) & set(appearance_of(file).tiles):
        raise InputError(f"{source}: its interiors are those of other tiles; fit the photograph again")
    return interiors


def interiors_of_planks(source: Path | str, file: FloorFile) -> PlankInteriors | None:
    """The same of a floor's model file."""
    interiors = _read_beside(source, file.report.get("interiors"), "planks", _planks_from_arrays)
    if interiors is not None and len(interiors.tone) != len(file.planks):
        raise InputError(f"{source}: its interiors are those of {len(interiors.tone)} planks; fit the photograph again")
    return interiors


def _read_beside(
    source: Path | str, name: object, kind: str, make: Callable[[Mapping[str, npt.NDArray]], InteriorsT]
) -> InteriorsT | None:
    if name is None:
        return None
    path = Path(source).parent / str(name)
    if path.name != name or not path.is_file():
        told = f"names the interiors {name!r}, which are not beside it"
        raise InputError(f"{source}: {told}; put them there, or give --no-fill")
    arrays = read_arrays(path)
    if arrays.get("schema") != _SCHEMA or arrays.get("kind_of_interiors") != kind:
        raise InputError(f"{path}: holds no interiors of {kind} that this version knows; fit the photograph again")
    try:
        interiors = make(arrays)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise InputError(f"{path}: is damaged ({type(error).__name__}: {error}); fit the photograph again") from None
    return interiors


def _tile_arrays(interiors: Interiors) -> dict[str, npt.ArrayLike]:
    names = (
        "places",
        "learnt",
        "kind",
        "contrast",
        "offset",
        "shift",
        "wobble",
        "wobble_length",
        "tile_profile",
        "joint_profile",
    )
    grain = {f"tile_grain_{number}": to_steps(each) for number, each in enumerate(interiors.tile_grain)}
    joint = {"kinds": len(interiors.tile_grain), "joint_grain": to_steps(interiors.joint_grain)}
    return {name: getattr(interiors, name) for name in names} | grain | joint


def _tiles_from_arrays(arrays: Mapping[str, npt.NDArray]) -> Interiors:
    tiles, kinds = len(arrays["places"]), int(arrays["kinds"])
    kind = _shaped(arrays, "kind", (tiles,))
    if not tiles or not kinds or kind.min() < 0 or kind.max() >= kinds:
        raise ValueError("kind")
    return Interiors(
        places=_shaped(arrays, "places", (tiles, 2)),
        learnt=_shaped(arrays, "learnt", (tiles,)).astype(bool),
        kind=kind,
        contrast=_shaped(arrays, "contrast", (tiles,)),
        offset=_shaped(arrays, "offset", (tiles, 3)),
        shift=_shaped(arrays, "shift", (tiles, 4)),
        wobble=float(_shaped(arrays, "wobble", ())),
        wobble_length=float(_shaped(arrays, "wobble_length", ())),
        tile_grain=tuple(_grain(arrays, f"tile_grain_{number}") for number in range(kinds)),
        joint_grain=_grain(arrays, "joint_grain"),
        tile_profile=_shaped(arrays, "tile_profile", (4, None, 3)),
        joint_profile=_shaped(arrays, "joint_profile", (4, None, 3)),
    )


def _plank_arrays(interiors: PlankInteriors) -> dict[str, npt.ArrayLike]:
    arrays = {name: getattr(interiors, name) for name in ("tone", "own", "turned", "contrast", "profile", "joint")}
    for number, grain in enumerate(interiors.grain):
        arrays |= {f"grain_{number}": to_steps(grain.examples), f"squeezed_{number}": grain.squeezed}
        arrays[f"fine_{number}"] = to_steps(grain.fine)
    return arrays


def _planks_from_arrays(arrays: Mapping[str, npt.NDArray]) -> PlankInteriors:
    planks = len(arrays["tone"])
    plain, ringed = (
        PlankGrain(
            _grain(arrays, f"grain_{number}"), int(arrays[f"squeezed_{number}"]), _grain(arrays, f"fine_{number}")
        )
        for number in range(2)
    )
    return PlankInteriors(
        tone=_shaped(arrays, "tone", (planks, 3)),
        own=_shaped(arrays, "own", (planks,)).astype(bool),
        turned=_shaped(arrays, "turned", (planks,)).astype(bool),
        contrast=_shaped(arrays, "contrast", (planks,)),
        grain=(plain, ringed),
        profile=_shaped(arrays, "profile", (None, 3)),
        joint=_shaped(arrays, "joint", (3,)),
    )


def _shaped(arrays: Mapping[str, npt.NDArray], name: str, shape: tuple[int | None, ...]) -> npt.NDArray:
    array = arrays[name]
    fits = array.ndim == len(shape) and all(n is None or n == m for n, m in zip(shape, array.shape, strict=True))
    if not fits or 0 in array.shape or not np.isfinite(array).all():
        raise ValueError(name)
    return array


def _grain(arrays: Mapping[str, npt.NDArray], name: str) -> npt.NDArray[np.float32]:
    steps = arrays[name]
    if steps.ndim != 4 or steps.shape[3] != 3 or steps.dtype != np.int8:
        raise ValueError(name)
    return from_steps(steps)
