"""Keys as a file: tables [[scale]], [[transition]] and [[orientation]] of keys.toml.

    symmetric = true                # the texture looks the same turned by half; false where there is no such line

    [[scale]]
    at = [0, 0.5]                   # a point
    value = 0.5

    [[scale]]
    stroke = [[1, 0], [1, 1]]       # a polyline
    value = 2

    [[transition]]
    map = "half.png"                # or all of a field, painted: a grey picture beside the file
    low = 0                         # what black stands for, and white; 0 and 1 by default
    high = 1

    [[orientation]]
    stroke = [[0.2, 0.9], [0.5, 0.1], [0.9, 0.1]]    # its own direction, where no value is given

Places are parts of the picture's width and height, from the upper left corner, so that a file goes with any size.
Orientations are in degrees from the x axis towards y, clockwise as seen. As maps they are x and y in red and green, as
they stand in .exr files, from -1 (0) to 1 (1) in others; or grey, from 0 (black) by half a turn, where the texture is
symmetric, or a whole one (white).
"""

from collections.abc import Mapping
from math import pi, radians
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.io.images import read_image
from jaxtex.io.masks import read_mask
from jaxtex.io.toml_files import check_names, is_number, read_toml, tables_of
from jaxtex.progressive.fields import Given, orientation_field, scale_field, transition_field
from jaxtex.progressive.keys import FieldKey, Place

FieldKind = Literal["scale", "transition", "orientation"]

KINDS: tuple[FieldKind, ...] = ("scale", "transition", "orientation")
"""All of them."""

_KEY = {"at", "stroke", "value"}
_MAP = {"map", "low", "high"}


class FieldKeys(NamedTuple):
    """What a file says about fields.

    Attributes:
        scale, transition: keys or a map; no keys where it says nothing.
        orientation: likewise; angles in radians.
        symmetric: whether opposite orientations are the same.
    """

    scale: Given = ()
    transition: Given = ()
    orientation: Given = ()
    symmetric: bool = False


class _Entry(NamedTuple):
    """Where something stands in a file."""

    path: Path
    kind: FieldKind
    number: int
    symmetric: bool

    def fault(self, told: str) -> InputError:
        return InputError(f"{self.path}: {self.kind} {self.number}: {told}")


def read_keys(path: Path | str) -> FieldKeys:
    """Read keys of fields, or maps, from a TOML file.

    It holds tables `[[scale]]`, `[[transition]]` and `[[orientation]]`. Each has a place, `at = [x, y]` or
    `stroke = [[x, y], ...]` in parts of the picture's width and height, and a `value` (orientations: degrees, and a
    stroke without one has its own direction); or one table has a `map`, a picture beside the file, and for scale and
    transition what black and white stand for in it, `low` and `high`. `symmetric = true` above them says that the
    texture looks the same turned by half.

    Args:
        path: the file.

    Raises:
        InputError: there is no such file, it is no TOML, or one of its entries is unknown, missing or wrong; the
            message names the file, the number of the table (from 1, of its kind) and the entry.

    Examples:
        >>> _ = Path("keys.toml").write_text("[[orientation]]\\nat = [0.5, 0.5]\\nvalue = 180\\n")
        >>> read_keys("keys.toml").orientation
        (FieldKey(places=((0.5, 0.5),), value=3.141592653589793),)
    """
    path = Path(path)
    document = read_toml(path, "a file of keys (keys.toml)")
    check_names(f"{path}", document, {*KINDS, "symmetric"})
    symmetric = document.get("symmetric", False)
    if not isinstance(symmetric, bool):
        raise InputError(f"{path}: symmetric is {symmetric!r}; give true or false")
    given = {kind: _read_tables(path, kind, tables_of(document, kind, path, "key"), symmetric) for kind in KINDS}
    return FieldKeys(**given, symmetric=symmetric)


def list_maps(path: Path | str) -> list[Path]:
    """The pictures that a file of keys names, so that nothing is written over them.

    Args:
        path: the file; what is wrong with its entries, `read_keys` tells.

    Raises:
        InputError: there is no such file, or it is no TOML.

    Examples:
        >>> _ = Path("keys.toml").write_text("[[scale]]\\nmap = 'half.png'\\n")
        >>> [each.name for each in list_maps("keys.toml")]
        ['half.png']
    """
    path = Path(path)
    document = read_toml(path, "a file of keys (keys.toml)")
    tables = [table for kind in KINDS for table in tables_of(document, kind, path, "key")]
    return [path.parent / table["map"] for table in tables if isinstance(table.get("map"), str)]


def make_field(keys: FieldKeys, kind: FieldKind, size: tuple[int, int]) -> npt.NDArray[np.float32]:
    """One of the fields over a picture.

    Args:
        keys: as read from a file.
        kind: which of them.
        size: width and height of the picture in pixels.

    Returns:
        float32 [row, col], or [row, col, 2] for orientation.

    Raises:
        InputError: no keys of that kind, or one that is wrong (`jaxtex.progressive.fields`).

    Examples:
        >>> make_field(FieldKeys(scale=[FieldKey(((0.5, 0.5),), 2.0)]), "scale", (2, 1)).round(5).tolist()
        [[2.0, 2.0]]
    """
    if kind == "orientation":
        return orientation_field(keys.orientation, size, symmetric=keys.symmetric)
    return scale_field(keys.scale, size) if kind == "scale" else transition_field(keys.transition, size)


def _read_tables(path: Path, kind: FieldKind, tables: list[dict[str, Any]], symmetric: bool) -> Given:
    entries = [(_Entry(path, kind, number, symmetric), table) for number, table in enumerate(tables, 1)]
    for entry, table in entries:
        check_names(f"{path}: {kind} {entry.number}", table, _KEY | _MAP)
        if "map" in table:
            if len(tables) > 1:
                raise entry.fault("is a map, which says all of the field; leave out the others")
            return _read_map(entry, table)
    return tuple(_read_key(entry, table) for entry, table in entries)


def _read_key(entry: _Entry, table: Mapping[str, Any]) -> FieldKey:
    for name in table:
        if name not in _KEY:
            raise entry.fault(f"{name} goes with a map alone; leave it out")
    if ("at" in table) == ("stroke" in table):
        raise entry.fault("give one of at = [x, y] and stroke = [[x, y], ...]")
    if "at" in table:
        places: tuple[Place, ...] = (_read_place(entry, "at", table["at"]),)
    else:
        stroke = table["stroke"]
        if not isinstance(stroke, list) or len(stroke) < 2:
            raise entry.fault(f"stroke is {stroke!r}; give two places or more, [[x, y], [x, y]]")
        places = tuple(_read_place(entry, "stroke", each) for each in stroke)
    if "value" not in table:
        if entry.kind == "orientation" and "stroke" in table:
            return FieldKey(places)
        raise entry.fault("has no value; give one")
    value = _read_number(entry, "value", table["value"])
    _check_value(entry, "value", value)
    return FieldKey(places, radians(value) if entry.kind == "orientation" else value)


def _read_place(entry: _Entry, name: str, value: Any) -> Place:
    if not isinstance(value, list) or len(value) != 2:
        raise entry.fault(f"{name} is {value!r}; give [x, y] in parts of the picture's sides, as [0.5, 0.5]")
    x, y = (_read_number(entry, name, each) for each in value)
    if not (0 <= x <= 1 and 0 <= y <= 1):
        raise entry.fault(f"{name}: [{x:g}, {y:g}] is outside of the picture; give parts of its sides, 0 to 1")
    return x, y


def _read_map(entry: _Entry, table: Mapping[str, Any]) -> Given:
    for name in table:
        if name not in _MAP or (entry.kind == "orientation" and name != "map"):
            raise entry.fault(f"{name} does not go with this map; leave it out")
    if not isinstance(table["map"], str):
        raise entry.fault(f"map is {table['map']!r}; give the name of a picture beside this file")
    picture = entry.path.parent / table["map"]
    try:
        return _read_directions(picture, entry.symmetric) if entry.kind == "orientation" else _read_grey(entry, table)
    except InputError as error:
        raise entry.fault(str(error)) from None


def _read_grey(entry: _Entry, table: Mapping[str, Any]) -> npt.NDArray[np.floating]:
    low, high = (_read_number(entry, name, table.get(name, number)) for name, number in (("low", 0), ("high", 1)))
    for name, level in (("low", low), ("high", high)):
        _check_value(entry, name, level)
    grey = read_mask(entry.path.parent / table["map"])
    return low * (high / low) ** grey if entry.kind == "scale" else low + (high - low) * grey


def _read_directions(picture: Path, symmetric: bool) -> npt.NDArray[np.floating]:
    values = read_image(picture, colour_space="data").pixels.astype(float)
    if values.shape[2] == 1:
        angle = (pi if symmetric else 2 * pi) * values[..., 0]
        return np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return values[..., :2] if picture.suffix.lower() == ".exr" else 2 * values[..., :2] - 1


def _read_number(entry: _Entry, name: str, value: Any) -> float:
    if not is_number(value):
        raise entry.fault(f"{name} is {value!r}; give a number")
    return float(value)


def _check_value(entry: _Entry, name: str, value: float) -> None:
    if entry.kind == "scale" and value <= 0:
        raise entry.fault(f"{name} is {value:g}; give more than 0")
    if entry.kind == "transition" and not 0 <= value <= 1:
        raise entry.fault(f"{name} is {value:g}; give 0 to 1")
