"""What every model file holds, whatever its model: kind and version, photograph, report, software, seed. Mixtures of
models have no photograph and no report of their own.

The formats are described, key by key, by the JSON Schemas beside this module, one for each kind.
"""

import json
import math
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np

import jaxtex
from jaxtex.core.errors import InputError
from jaxtex.io.files import atomic_write_text
from jaxtex.models.documents import find_fault, read_document, write_document

SCHEMA = 1
_REPORT = ("ok", "reason", "iou", "start", "standard_errors")


class SourceImage(NamedTuple):
    """The photograph a model was fitted to: its size in pixels, upright, and the SHA-256 of its file in hexadecimal."""

    width: int
    height: int
    sha256: str


def write_envelope(
    path: Path | str,
    kind: str,
    *,
    image: SourceImage | None,
    content: Mapping[str, Any],
    versions: Mapping[str, str] | None,
    seed: int | None,
) -> None:
    """Write a model file, whole or not at all.

    Args:
        path: the file.
        kind: the document's `type`.
        image: the photograph, if it is a model that one was fitted to.
        content: what is the kind's own, in order; its `report` among it, if it has one. Entries that are None are left
            out.
        versions: of the software that made the model; None stands for the software that runs.
        seed: of all random choices, where there were any.

    Raises:
        InputError: the folder does not exist.
        ValueError: the document is not as the schema of its kind has it.
    """
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "type": kind,
        "image": None if image is None else image._asdict(),
        **content,
        "report": _ordered_report(content["report"]) if "report" in content else None,
        "versions": _running_versions() if versions is None else dict(sorted(versions.items())),
        "seed": seed,
    }
    document = plain({key: value for key, value in document.items() if value is not None})
    fault = find_fault(document, schema_of(kind))
    if fault:
        raise ValueError(f"this model cannot be written: {fault}")
    atomic_write_text(path, write_document(document))


def read_envelope(path: Path | str, kinds: Sequence[str]) -> dict[str, Any]:
    """Read a model file's document, once it is known to be as the schema of its kind has it.

    Args:
        path: the file.
        kinds: those that the caller knows.

    Raises:
        InputError: there is no such file, it is damaged, of an unknown kind or version, or one of its entries is
            missing or wrong; the message names the file and the entry.
    """
    document = read_document(path)
    if "schema" not in document or "type" not in document:
        raise InputError(f"{path}: has no schema and type, so it is no model file (model.json)")
    if document["schema"] != SCHEMA:
        raise InputError(f"{path}: schema is {document['schema']!r}; this version of jaxtex reads {SCHEMA}")
    if document["type"] not in tuple(kinds):
        raise InputError(f"{path}: type is {document['type']!r}; this version of jaxtex reads {' and '.join(kinds)}")
    fault = find_fault(document, schema_of(document["type"]))
    if fault:
        raise InputError(f"{path}: {fault}")
    return document


@cache
def schema_of(kind: str) -> dict[str, Any]:
    """The JSON Schema of model files of a kind.

    Examples:
        >>> schema_of("tiling")["title"]
        'Fitted tiling'
    """
    text = resources.files("jaxtex.models").joinpath("schema", f"{kind}-{SCHEMA}.json").read_text(encoding="utf-8")
    schema: dict[str, Any] = json.loads(text)
    return schema


def plain(value: Any) -> Any:
    """As JSON has it: arrays become lists, and minus zero, which draws the same picture, zero.

    Examples:
        >>> plain({"origin": np.array([0.5, -0.0])})
        {'origin': [0.5, 0.0]}
    """
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic | jax.Array):
        return plain(np.asarray(value).tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return value + 0.0
    return value


def _ordered_report(report: Mapping[str, Any]) -> Any:
    """Every fit's entries first, then the others by name; numbers that are not finite become null."""
    ordered = {key: report[key] for key in _REPORT if key in report}
    return _finite_or_null(ordered | {key: report[key] for key in sorted(set(report) - set(_REPORT))})


def _finite_or_null(value: Any) -> Any:
    value = plain(value)
    if isinstance(value, dict):
        return {key: _finite_or_null(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite_or_null(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _running_versions() -> dict[str, str]:
    return {"jax": jax.__version__, "jaxtex": jaxtex.__version__, "numpy": np.__version__}
