"""Model files: what a photograph made of a model, as versioned JSON that says what it means.

This module reads and writes them all, and holds what is the tilings' own; their format is described, key by key, by the
JSON Schema `tiling-1.json` beside it.
"""

import dataclasses
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import jax
import numpy as np

from jaxtex.core.errors import InputError
from jaxtex.models.canonical import canonical
from jaxtex.models.envelope import SourceImage as SourceImage
from jaxtex.models.envelope import plain, read_envelope, schema_of, write_envelope
from jaxtex.models.floor_files import FloorFile, floor_content, floor_from_document
from jaxtex.models.mixture_files import MixtureFile, mixture_content, mixture_from_document
from jaxtex.models.tiling import Tiling, make_tiling
from jaxtex.models.wood_files import WoodFile, wood_content, wood_from_document

# Parameters that stand in a file only where they are not the plain tiling's.
_OPTIONAL: dict[str, Any] = {"course_lengths": [[1.0]], "course_offsets": [0.0], "corner_radius": 0.0}


@dataclasses.dataclass(frozen=True, eq=False)
class TilingFile:
    """What a model file of a tiling holds.

    Attributes:
        tiling: the model; read from a file, its leaves are NumPy arrays in double precision.
        image: the photograph.
        rows, columns: courses, and tiles along a course, in the photograph.
        report: how the fit went: `ok`, `reason`, `iou`, `start` (see `tiling_parameters`), `standard_errors`, and
            whatever else the fit reports, as plain values.
        appearance: what the tiles look like, as the material layer writes it. Its numbers of tiles are those of
            `tiling`.
        seed: of all random choices, where there were any.
        mm_per_px: millimetres of the wall in one plane pixel, where known.
        versions: of the software that wrote the file; by default of the software that runs.
    """

    tiling: Tiling
    image: SourceImage
    rows: int
    columns: int
    report: Mapping[str, Any]
    appearance: Mapping[str, Any] | None = None
    seed: int | None = None
    mm_per_px: float | None = None
    versions: Mapping[str, str] | None = None


ModelFile = TilingFile | WoodFile | FloorFile
"""What a photograph made of a model."""


def save_model(path: Path | str, file: ModelFile | MixtureFile) -> None:
    """Write a model file, whole or not at all. The same model gives the same bytes.

    The model is written in its canonical form (see `jaxtex.models.canonical` and `canonical_wood`). Numbers in the
    report that are not finite become null.

    Raises:
        InputError: the folder does not exist.
        ValueError: the model cannot be written: numbers that are not finite or out of range, a report without its
            entries, an appearance whose tiles would be numbered otherwise in the canonical form, or a turbulence that
            is not that of the file's seed.

    Examples:
        >>> report = {"ok": True, "reason": "made by hand", "iou": None, "start": None, "standard_errors": {}}
        >>> wall = make_tiling(tile_width=60.0, tile_height=20.0, mortar_x=4.0, mortar_y=4.0, offset=0.5)
        >>> save_model("wall.json", TilingFile(wall, SourceImage(640, 480, "0" * 64), 24, 11, report))
        >>> float(load_model("wall.json").tiling.tile_width)
        60.0
    """
    kind, content = _content(file)
    image, seed = (None, None) if isinstance(file, MixtureFile) else (file.image, file.seed)
    write_envelope(path, kind, image=image, content=content, versions=file.versions, seed=seed)


def load_model(path: Path | str) -> ModelFile:
    """Read a model file.

    Returns:
        A `TilingFile`, a `WoodFile` or a `FloorFile`, as the file's `type` says.

    Raises:
        InputError: there is no such file, it is damaged, of an unknown kind or version, or one of its entries is
            missing or wrong; the message names the file and the entry. Or it is a mixture.
    """
    file = load_any(path)
    if isinstance(file, MixtureFile):
        raise InputError(f"{path}: is a mixture, and no model of its own; name one of the models that it mixes")
    return file


def load_any(path: Path | str) -> ModelFile | MixtureFile:
    """Read a model file, or a file of a mixture; the files that it names are not read.

    Raises:
        InputError: as `load_model`.

    Examples:
        >>> save_model("mix.json", MixtureFile("wall.json"))
        >>> load_any("mix.json").base
        'wall.json'
    """
    readers: dict[str, Callable[[Mapping[str, Any]], ModelFile | MixtureFile]] = {
        "tiling": _tiling_from_document,
        "wood": wood_from_document,
        "floor": floor_from_document,
        "mixture": mixture_from_document,
    }
    document = read_envelope(path, tuple(readers))
    try:
        return readers[document["type"]](document)
    except ValueError as error:
        raise InputError(f"{path}: parameters: {error}") from None


def need_tiling(file: ModelFile) -> TilingFile:
    """`file` itself, once it is known to be that of a tiling.

    Raises:
        InputError: it is that of another model.
    """
    if not isinstance(file, TilingFile):
        kind = "a floor" if isinstance(file, FloorFile) else "wood"
        raise InputError(f"this is a model of {kind}, which has no tiles; give a model of a tiling")
    return file


def tiling_parameters(tiling: Tiling, *, rows: int, columns: int, mm_per_px: float | None = None) -> dict[str, Any]:
    """The named parameters of a tiling as they stand in a model file: canonical, the angle in degrees, plain numbers.

    Examples:
        >>> wall = make_tiling(tile_width=60.0, tile_height=20.0, offset=-0.25)
        >>> tiling_parameters(wall, rows=24, columns=11)["offset"]
        0.75
    """
    written = canonical(tiling)
    values: dict[str, Any] = {
        "tile_width": written.tile_width,
        "tile_height": written.tile_height,
        # Twelve digits behind the point, so that radians and back give the same number; at most 90, since in single
        # precision a right angle is a little more.
        "angle_deg": min(round(math.degrees(written.angle), 12), 90.0),
        "mortar_x": written.mortar_x,
        "mortar_y": written.mortar_y,
        "offset": written.offset,
        "origin": written.origin,
        "homography": written.homography,
        "bond": written.bond,
        "rows": rows,
        "columns": columns,
        "course_lengths": written.course_lengths,
        "course_offsets": written.course_offsets,
        "corner_radius": written.corner_radius,
        "mm_per_px": mm_per_px,
    }
    return {key: value for key, value in plain(values).items() if value is not None and value != _OPTIONAL.get(key)}


def tiling_from_parameters(parameters: Mapping[str, Any]) -> Tiling:
    """The tiling of named parameters as they stand in a model file: the inverse of `tiling_parameters`.

    Raises:
        ValueError: they are no tiling.
    """
    arrays = {"tile_width", "tile_height", "mortar_x", "mortar_y", "offset", "origin", "homography", *_OPTIONAL}
    arguments = {name: parameters[name] for name in arrays & parameters.keys()}
    if len({len(row) for row in arguments.get("course_lengths", [])}) > 1:
        raise ValueError("course_lengths has rows of different lengths; repeat the shorter ones to the same length")
    if parameters["homography"][2][2] != 1:
        raise ValueError(f"homography has H33 = {parameters['homography'][2][2]:g}; divide it by that, so that it is 1")
    with jax.enable_x64():
        tiling = make_tiling(**arguments, angle=math.radians(parameters["angle_deg"]), bond=parameters["bond"])
        return jax.tree.map(np.asarray, tiling)


def tiling_schema() -> dict[str, Any]:
    """The JSON Schema of model files of tilings."""
    return schema_of("tiling")


def _content(file: ModelFile | MixtureFile) -> tuple[str, dict[str, Any]]:
    """The kind of a model file, and what is its own."""
    if isinstance(file, MixtureFile):
        return "mixture", mixture_content(file)
    if isinstance(file, WoodFile):
        return "wood", wood_content(file)
    if isinstance(file, FloorFile):
        return "floor", floor_content(file)
    return "tiling", _tiling_content(file)


def _tiling_content(file: TilingFile) -> dict[str, Any]:
    _check_numbering(file)
    parameters = tiling_parameters(file.tiling, rows=file.rows, columns=file.columns, mm_per_px=file.mm_per_px)
    return {"parameters": parameters, "report": file.report, "appearance": file.appearance}


def _tiling_from_document(document: Mapping[str, Any]) -> TilingFile:
    parameters = document["parameters"]
    return TilingFile(
        tiling=tiling_from_parameters(parameters),
        image=SourceImage(**document["image"]),
        rows=int(parameters["rows"]),
        columns=int(parameters["columns"]),
        report=document["report"],
        appearance=document.get("appearance"),
        seed=document.get("seed"),
        mm_per_px=parameters.get("mm_per_px"),
        versions=document.get("versions"),
    )


def _check_numbering(file: TilingFile) -> None:
    if file.appearance is None:
        return
    given, written = jax.tree.leaves(file.tiling), jax.tree.leaves(canonical(file.tiling))
    if not all(np.array_equal(one, other) for one, other in zip(given, written, strict=True)):
        raise ValueError("the tiling is not in canonical form; bring it there before you measure its appearance")
