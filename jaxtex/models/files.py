"""Model files: what a photograph made of a model, as versioned JSON that says what it means.

The format is described, key by key, by the JSON Schema `tiling-1.json` beside this module.
"""

import dataclasses
import json
import math
from collections.abc import Mapping
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np

import jaxtex
from jaxtex.core.errors import InputError
from jaxtex.io.files import atomic_write_text
from jaxtex.models.canonical import canonical
from jaxtex.models.documents import find_fault, read_document, write_document
from jaxtex.models.tiling import Tiling, make_tiling

SCHEMA = 1
_REPORT = ("ok", "reason", "iou", "start", "standard_errors")
# Parameters that stand in a file only where they are not the plain tiling's.
_OPTIONAL: dict[str, Any] = {"course_lengths": [[1.0]], "course_offsets": [0.0], "corner_radius": 0.0}


class SourceImage(NamedTuple):
    """The photograph a model was fitted to: its size in pixels, upright, and the SHA-256 of its file in hexadecimal."""

    width: int
    height: int
    sha256: str


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


def save_model(path: Path | str, file: TilingFile) -> None:
    """Write a model file, whole or not at all. The same model gives the same bytes.

    The tiling is written in its canonical form (see `jaxtex.models.canonical`). Numbers in the report that are not
    finite become null.

    Raises:
        InputError: the folder does not exist.
        ValueError: the model cannot be written: numbers that are not finite or out of range, a report without its
            entries, or an appearance whose tiles would be numbered otherwise in the canonical form.

    Examples:
        >>> report = {"ok": True, "reason": "made by hand", "iou": None, "start": None, "standard_errors": {}}
        >>> wall = make_tiling(tile_width=60.0, tile_height=20.0, mortar_x=4.0, mortar_y=4.0, offset=0.5)
        >>> save_model("wall.json", TilingFile(wall, SourceImage(640, 480, "0" * 64), 24, 11, report))
        >>> float(load_model("wall.json").tiling.tile_width)
        60.0
    """
    _check_numbering(file)
    parameters = tiling_parameters(file.tiling, rows=file.rows, columns=file.columns, mm_per_px=file.mm_per_px)
    report = {key: file.report[key] for key in _REPORT if key in file.report}
    report |= {key: file.report[key] for key in sorted(set(file.report) - set(_REPORT))}
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "type": "tiling",
        "image": file.image._asdict(),
        "parameters": parameters,
        "report": _finite_or_null(report),
        "appearance": file.appearance,
        "versions": _running_versions() if file.versions is None else dict(sorted(file.versions.items())),
        "seed": file.seed,
    }
    document = _plain({key: value for key, value in document.items() if value is not None})
    fault = find_fault(document, tiling_schema())
    if fault:
        raise ValueError(f"this model cannot be written: {fault}")
    atomic_write_text(path, write_document(document))


def load_model(path: Path | str) -> TilingFile:
    """Read a model file.

    Raises:
        InputError: there is no such file, it is damaged, of an unknown kind or version, or one of its entries is
            missing or wrong; the message names the file and the entry.
    """
    document = read_document(path)
    if "schema" not in document or "type" not in document:
        raise InputError(f"{path}: has no schema and type, so it is no model file (model.json)")
    if document["schema"] != SCHEMA:
        raise InputError(f"{path}: schema is {document['schema']!r}; this version of jaxtex reads {SCHEMA}")
    if document["type"] != "tiling":
        raise InputError(f"{path}: type is {document['type']!r}; this version of jaxtex reads tiling")
    fault = find_fault(document, tiling_schema())
    if fault:
        raise InputError(f"{path}: {fault}")
    parameters = document["parameters"]
    try:
        tiling = tiling_from_parameters(parameters)
    except ValueError as error:
        raise InputError(f"{path}: parameters: {error}") from None
    return TilingFile(
        tiling=tiling,
        image=SourceImage(**document["image"]),
        rows=int(parameters["rows"]),
        columns=int(parameters["columns"]),
        report=document["report"],
        appearance=document.get("appearance"),
        seed=document.get("seed"),
        mm_per_px=parameters.get("mm_per_px"),
        versions=document.get("versions"),
    )


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
    plain = _plain(values)
    return {key: value for key, value in plain.items() if value is not None and value != _OPTIONAL.get(key)}


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


@cache
def tiling_schema() -> dict[str, Any]:
    """The JSON Schema of model files of tilings."""
    text = resources.files("jaxtex.models").joinpath("schema", f"tiling-{SCHEMA}.json").read_text(encoding="utf-8")
    schema: dict[str, Any] = json.loads(text)
    return schema


def _check_numbering(file: TilingFile) -> None:
    if file.appearance is None:
        return
    given, written = jax.tree.leaves(file.tiling), jax.tree.leaves(canonical(file.tiling))
    if not all(np.array_equal(one, other) for one, other in zip(given, written, strict=True)):
        raise ValueError("the tiling is not in canonical form; bring it there before you measure its appearance")


def _running_versions() -> dict[str, str]:
    return {"jax": jax.__version__, "jaxtex": jaxtex.__version__, "numpy": np.__version__}


def _plain(value: Any) -> Any:
    """As JSON has it: arrays become lists, and minus zero, which draws the same picture, zero."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic | jax.Array):
        return _plain(np.asarray(value).tolist())
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value + 0.0
    return value


def _finite_or_null(value: Any) -> Any:
    value = _plain(value)
    if isinstance(value, dict):
        return {key: _finite_or_null(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite_or_null(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
