"""Controls as a file: one `[[control]]` table of controls.toml for each.

    [[control]]
    classes = [0]                   # all of them where there is no such line
    where = { map = "mask.png" }    # a picture beside the file; everywhere where there is no such line
    size = { inside = 0.5, outside = 1, centre = [0.5, 0.5], radius = 0.4 }
    orientation = { from = 0, to = 90, start = [0, 0], end = [1, 0] }
    colour = [1, 0.5, 0.5]          # or one number

    [[control]]
    probability = 0.5
    weights = { 3 = 0, 7 = 2.5 }    # by the particle's number

Places are parts of the plane's width and height, radii parts of its shorter side, so that a file goes with any size.
`least_distance` is in pixels, angles are in degrees.
"""

from collections.abc import Callable, Mapping
from math import radians
from pathlib import Path
from typing import Any, NamedTuple

from jaxtex.core.errors import InputError
from jaxtex.io.masks import read_mask
from jaxtex.io.toml_files import check_names, is_number, read_toml, tables_of
from jaxtex.particles.controls import LIMITS, Control, range_of
from jaxtex.particles.fields import Amount, linear_field, map_field, radial_field

_FARTHEST = 10  # of the plane's sides: who gives more means pixels
_DEGREES = ("orientation", "orientation_variation")
_FORMS = {
    "map": ({"map"}, {"low", "high"}),
    "radius": ({"inside", "outside", "centre", "radius"}, {"softness"}),
    "start": ({"from", "to", "start", "end"}, set()),
}
"""Inline tables by a key that only they have: the keys that they need, and those that they may have."""


class _Key(NamedTuple):
    """Where a value stands in a file, and what it is a value of."""

    path: Path
    table: int
    name: str
    size: tuple[int, int]

    def fault(self, told: str) -> InputError:
        return InputError(f"{self.path}: control {self.table}: {self.name}: {told}")


def read_controls(path: Path | str, size: tuple[int, int]) -> tuple[Control, ...]:
    """Read what a user asks of particles from a TOML file.

    It holds a table `[[control]]` for each `Control`, with its entries as keys. A number that may differ from place to
    place is one number, or an inline table: `{from, to, start, end}`, `{inside, outside, centre, radius, softness}` or
    `{map, low, high}`, a grey picture beside the file. Places are parts of the plane's sides, from the upper left
    corner; the radius is a part of the shorter side. Angles are in degrees, `least_distance` is in pixels.

    Args:
        path: the file.
        size: width and height of the plane in pixels.

    Raises:
        InputError: there is no such file, it is no TOML, or one of its entries is unknown, missing or wrong; the
            message names the file, the number of the control (from 1) and the entry.

    Examples:
        >>> text = "[[control]]\\nsize = {from = 1, to = 2, start = [0, 0], end = [1, 0]}\\n"
        >>> _ = Path("controls.toml").write_text(text)
        >>> (growing,) = read_controls("controls.toml", (200, 100))
        >>> import numpy as np
        >>> growing.size(np.array([0.0, 100.0]), np.array([0.0, 50.0]))
        array([1. , 1.5])
    """
    path = Path(path)
    document = read_toml(path, "a file of controls (controls.toml)")
    check_names(f"{path}", document, {"control"})
    tables = tables_of(document, "control", path, "control")
    return tuple(_read_control(path, number, table, size) for number, table in enumerate(tables, 1))


def _read_control(path: Path, number: int, table: Mapping[str, Any], size: tuple[int, int]) -> Control:
    check_names(f"{path}: control {number}", table, {*LIMITS, "classes", "weights"})
    values: dict[str, Any] = {}
    for name, value in table.items():
        key = _Key(path, number, name, size)
        if name == "classes":
            values[name] = _read_classes(key, value)
        elif name == "weights":
            values[name] = _read_weights(key, value)
        elif name == "colour" and isinstance(value, list):
            if len(value) != 3:
                raise key.fault(f"has {len(value)} numbers; give one, or one each for red, green and blue")
            values[name] = tuple(_read_amount(key, each) for each in value)
        else:
            values[name] = _read_amount(key, value)
    return Control(**values)


def _read_classes(key: _Key, value: Any) -> list[int]:
    if not isinstance(value, list) or not all(type(each) is int and each >= 0 for each in value):
        raise key.fault(f"is {value!r}; give a list of numbers of classes, from 0, as [0, 2]")
    return value


def _read_weights(key: _Key, value: Any) -> dict[int, float]:
    if not isinstance(value, dict):
        raise key.fault(f"is {value!r}; give weights by particles' numbers, as {{ 3 = 0, 7 = 2.5 }}")
    for name in value:
        if not name.isdecimal():
            raise key.fault(f"{name} is no number of a particle; give whole numbers from 0")
    weights = {int(name): _read_number(key, name, weight) for name, weight in value.items()}
    for number, weight in weights.items():
        if weight < 0:
            raise key.fault(f"that of particle {number} is {weight:g}; give 0 or more")
    return weights


def _read_amount(key: _Key, value: Any) -> Amount:
    if not isinstance(value, dict):
        return _read_level(key, "", value)
    form = next((name for name in _FORMS if name in value), None)
    if form is None:
        forms = ", ".join("{" + ", ".join(sorted(needed)) + "}" for needed, _ in _FORMS.values())
        raise key.fault(f"is a table of no known kind; give one number, or one of {forms}")
    needed, optional = _FORMS[form]
    check_names(f"{key.path}: control {key.table}: {key.name}", value, needed | optional)
    for name in sorted(needed - set(value)):
        raise key.fault(f"has no {name}; give one")
    return _READERS[form](key, value)


def _read_linear(key: _Key, value: Mapping[str, Any]) -> Amount:
    start, end = (_read_place(key, name, value[name]) for name in ("start", "end"))
    if start == end:
        raise key.fault("start and end are the same place; give two")
    return linear_field(start, end, _read_level(key, "from", value["from"]), _read_level(key, "to", value["to"]))


def _read_radial(key: _Key, value: Mapping[str, Any]) -> Amount:
    radius = _read_number(key, "radius", value["radius"])
    if radius <= 0:
        raise key.fault(f"radius is {radius:g}; give more than 0")
    softness = _read_number(key, "softness", value.get("softness", 1))
    if not 0 <= softness <= 1:
        raise key.fault(f"softness is {softness:g}; give 0 to 1")
    inside, outside = (_read_level(key, name, value[name]) for name in ("inside", "outside"))
    centre = _read_place(key, "centre", value["centre"])
    return radial_field(centre, radius * min(key.size), inside, outside, softness=softness)


def _read_map(key: _Key, value: Mapping[str, Any]) -> Amount:
    if not isinstance(value["map"], str):
        raise key.fault(f"map is {value['map']!r}; give the name of a picture beside this file")
    low, high = (_read_level(key, name, value.get(name, number)) for name, number in (("low", 0), ("high", 1)))
    try:
        mask = read_mask(key.path.parent / value["map"])
    except InputError as error:
        raise key.fault(str(error)) from None
    # What is black and white alone ends where it is painted, and is not interpolated.
    painted = mask > 0.5 if ((mask == 0) | (mask == 1)).all() else mask
    return map_field(painted, key.size, low=low, high=high)


_READERS: Mapping[str, Callable[[_Key, Mapping[str, Any]], Amount]] = {
    "map": _read_map,
    "radius": _read_radial,
    "start": _read_linear,
}


def _read_place(key: _Key, name: str, value: Any) -> tuple[float, float]:
    """From parts of the plane's sides to pixels."""
    if not isinstance(value, list) or len(value) != 2:
        raise key.fault(f"{name} is {value!r}; give [x, y] in parts of the plane's sides, as [0.5, 0.5]")
    x, y = (_read_number(key, name, each) for each in value)
    if max(abs(x), abs(y)) > _FARTHEST:
        raise key.fault(f"{name} is [{x:g}, {y:g}]; give parts of the plane's sides, as [0.5, 0.5], and not pixels")
    return x * key.size[0], y * key.size[1]


def _read_level(key: _Key, name: str, value: Any) -> float:
    """A number of the kind that the entry is of, angles in radians."""
    number = _read_number(key, name, value)
    level = radians(number) if key.name in _DEGREES else number
    low, high = LIMITS[key.name]
    if not low <= level <= high:
        wanted = "give 0 to 180" if key.name in _DEGREES else range_of(key.name)
        raise key.fault(f"{name} is {number:g}; {wanted}".lstrip())
    return level


def _read_number(key: _Key, name: str, value: Any) -> float:
    if not is_number(value):
        raise key.fault(f"{name} is {value!r}; give a number".lstrip())
    return float(value)
