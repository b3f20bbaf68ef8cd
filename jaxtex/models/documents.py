"""JSON documents: read strictly, checked against a schema, written for people to read.

The check knows the part of JSON Schema (2020-12) that the schemas of this package use, and says in one line which key
is wrong and what it must be.
"""

import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from jaxtex.core.errors import InputError
from jaxtex.io.files import existing_file

_TYPES: dict[str, tuple[type | tuple[type, ...], str]] = {
    "object": (dict, "an object {...}"),
    "array": (list, "a list [...]"),
    "string": (str, "a text"),
    "number": ((int, float), "a number"),
    "integer": ((int, float), "a whole number"),
    "boolean": (bool, "true or false"),
    "null": (type(None), "null"),
}


def read_document(path: Path | str) -> dict[str, Any]:
    """Read a file that holds one JSON object.

    Raises:
        InputError: there is no such file, it cannot be read, it is not JSON, it holds anything else than an object, a
            key twice, or a number that is not finite.
    """
    path = existing_file(path)
    try:
        document = json.loads(
            path.read_bytes().decode("utf-8"),
            object_pairs_hook=_without_doubles,
            parse_constant=_refuse,
            parse_float=_finite,
        )
    except UnicodeDecodeError:
        raise InputError(f"{path}: is not a text file, so it is no model file (model.json)") from None
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise InputError(f"{path}: is damaged, or is no JSON file ({error.msg}, {where})") from None
    except RecursionError:
        raise InputError(f"{path}: is damaged: its brackets are nested too deep") from None
    except ValueError as error:
        raise InputError(f"{path}: {error}") from None
    if not isinstance(document, dict):
        raise InputError(f"{path}: holds {_show(document)}, not a model, which is an object {{...}}")
    return document


def find_fault(document: Any, schema: Mapping[str, Any]) -> str | None:
    """The first thing wrong with a document, as `"key.key[0] is 3; it must be ..."`, or None.

    Args:
        document: as JSON gives it: dicts, lists, texts, numbers, booleans, None.
        schema: a JSON Schema, itself such a document.

    Examples:
        >>> find_fault({"size": -3}, {"type": "object", "properties": {"size": {"type": "number", "minimum": 0}}})
        'size is -3; it must be at least 0'
    """
    return next(_faults(document, schema, "", schema), None)


def write_document(document: Mapping[str, Any]) -> str:
    """A document as text: keys in their order, two spaces a level, lists of plain values on one line.

    Numbers are written so that reading them gives the same double-precision number.

    Examples:
        >>> print(write_document({"size": [3.0, 0.1], "name": "wall"}), end="")
        {
          "size": [3.0, 0.1],
          "name": "wall"
        }
    """
    return _layout(document, "\n") + "\n"


def _without_doubles(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    keys = [key for key, _ in pairs]
    doubled = next((key for key in keys if keys.count(key) > 1), None)
    if doubled is not None:
        raise ValueError(f"holds the key {doubled!r} twice in one object")
    return dict(pairs)


def _refuse(constant: str) -> None:
    raise ValueError(f"holds {constant}, which is no number")


def _finite(digits: str) -> float:
    number = float(digits)
    if math.isinf(number):
        raise ValueError(f"holds {digits[:30]}, which is too large a number")
    return number


def _faults(value: Any, schema: Mapping[str, Any], path: str, root: Mapping[str, Any]) -> Iterator[str]:
    if "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        yield from _faults(value, root["$defs"][name], path, root)
    if "anyOf" in schema:
        # The first choice is what is meant, and its faults are what helps; the others stand for its absence.
        choices = [list(_faults(value, choice, path, root)) for choice in schema["anyOf"]]
        if all(choices):
            yield choices[0][0]
    fault = _fault_of_one(value, schema)
    if fault:
        yield f"{path or 'the document'} is {_show(value)}; it must be {fault}"
    elif isinstance(value, dict):
        yield from _faults_of_object(value, schema, path, root)
    elif isinstance(value, list) and "items" in schema:
        for index, item in enumerate(value):
            yield from _faults(item, schema["items"], f"{path}[{index}]", root)


def _faults_of_object(
    value: dict[str, Any], schema: Mapping[str, Any], path: str, root: Mapping[str, Any]
) -> Iterator[str]:
    inside = f"{path}." if path else ""
    for key in schema.get("required", ()):
        if key not in value:
            yield f"{inside}{key} is missing"
    known, others = schema.get("properties", {}), schema.get("additionalProperties", True)
    for key, item in value.items():
        if key in known:
            yield from _faults(item, known[key], f"{inside}{key}", root)
        elif others is False:
            yield f"{inside}{key} is not known; it must be one of {', '.join(known)}"
        elif others is not True:
            yield from _faults(item, others, f"{inside}{key}", root)


def _fault_of_one(value: Any, schema: Mapping[str, Any]) -> str | None:
    """What a value must be, where it is not; what is inside of it aside."""
    types = schema.get("type", [])
    types = [types] if isinstance(types, str) else types
    if types and not any(_is_of_type(value, name) for name in types):
        return " or ".join(_TYPES[name][1] for name in types)
    if "const" in schema and (value != schema["const"] or isinstance(value, bool)):  # to Python, true equals 1
        return _show(schema["const"])
    if "enum" in schema and value not in schema["enum"]:
        return f"one of {', '.join(schema['enum'])}"
    if isinstance(value, list):
        return _fault_of_count(len(value), schema)
    if isinstance(value, str) and "pattern" in schema and not re.search(schema["pattern"], value):
        return f"of the form {schema['pattern']}"
    if isinstance(value, int | float) and not isinstance(value, bool):
        return _fault_of_number(value, schema)
    return None


def _fault_of_number(value: float, schema: Mapping[str, Any]) -> str | None:
    bounds = (
        ("minimum", value.__ge__, "at least"),
        ("exclusiveMinimum", value.__gt__, "more than"),
        ("maximum", value.__le__, "at most"),
        ("exclusiveMaximum", value.__lt__, "less than"),
    )
    for keyword, holds, words in bounds:
        if keyword in schema and not holds(schema[keyword]):
            return f"{words} {schema[keyword]:g}"
    return None


def _fault_of_count(count: int, schema: Mapping[str, Any]) -> str | None:
    least, most = schema.get("minItems", 0), schema.get("maxItems", count)
    if least <= count <= most:
        return None
    return f"a list of {least}" if least == most else f"a list of at least {least}"


def _is_of_type(value: Any, name: str) -> bool:
    if isinstance(value, bool) and name != "boolean":
        return False
    if name == "integer" and isinstance(value, float):
        return value.is_integer()
    return isinstance(value, _TYPES[name][0])


def _show(value: Any) -> str:
    shown = json.dumps(value, ensure_ascii=False)
    return shown if len(shown) <= 60 else f"{shown[:57]}..."


def _layout(value: Any, line: str) -> str:
    inner = line + "  "
    if isinstance(value, Mapping) and value:
        entries = [f"{json.dumps(key, ensure_ascii=False)}: {_layout(item, inner)}" for key, item in value.items()]
        return "{" + inner + f",{inner}".join(entries) + line + "}"
    if _holds_more_than_values(value):
        return "[" + inner + f",{inner}".join(_layout(item, inner) for item in value) + line + "]"
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def _holds_more_than_values(value: Any) -> bool:
    return isinstance(value, Sequence) and any(isinstance(item, Mapping | list | tuple) for item in value)
