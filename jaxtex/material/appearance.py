"""What the tiles and joints of a tiling look like, apart from where they are."""

import dataclasses
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
from jaxtex.core.errors import InputError
from jaxtex.material.draw import STRONGEST, draw_tiles
from jaxtex.material.patterns import ONE_CLASS, Pattern
from jaxtex.models.files import ModelFile, need_tiling
from jaxtex.models.tiling import Tiling

Place = tuple[int, int]

_DEPTH = 0.4  # of the mortar's thickness: joints of brickwork are struck back by 3 to 5 mm of 10


@dataclasses.dataclass(frozen=True)
class Appearance:
    """Colours, roughness and relief of a tiling's tiles and joints.

    Attributes:
        tiles: colour of each tile that was seen, by (course, tile): linear light, quantised to 8 bits of sRGB.
        joint: colour of the joints, likewise.
        pattern: which tiles share a class of colours, as `choose_pattern` has it.
        neighbours: how alike tiles are that lie side by side in a course, and that have one number in courses one
            above the other: rank correlations, -0.7 to 0.7.
        trend: what colours change by from course to course, in the logits of sRGB values.
        joint_depth: how far the joints lie below the tiles' faces, in plane pixels, >= 0.
        edge_width: how far the rounding of a tile's edge reaches into its face, in plane pixels, >= 0.
        tile_bump, joint_bump: how uneven faces and joints are: the root mean square of their slopes, >= 0.
        tile_roughness, joint_roughness: 0 (mirror) to 1 (dull), the square root of GGX's alpha.
        tile_specular, joint_specular: how strongly a surface that is no metal reflects, 0 to 1; 0.5 stands for 4 % seen
            straight on, 1 for 8 %.
        tile_metallic, joint_metallic: 0 (stone, glazing, wood) or 1 (a metal, a mirror).

    A photograph does not show depth, edges, roughness and what follows: they are chosen, and can be edited in the model
    file.
    """

    tiles: Mapping[Place, tuple[float, float, float]]
    joint: tuple[float, float, float]
    pattern: Pattern = ONE_CLASS
    neighbours: tuple[float, float] = (0.0, 0.0)
    trend: tuple[float, float, float] = (0.0, 0.0, 0.0)
    joint_depth: float = 0.0
    edge_width: float = 0.0
    tile_bump: float = 0.0
    joint_bump: float = 0.0
    tile_roughness: float = 0.6
    joint_roughness: float = 0.9
    tile_specular: float = 0.5
    joint_specular: float = 0.5
    tile_metallic: float = 0.0
    joint_metallic: float = 0.0

    def colours(self, course: npt.ArrayLike, tile: npt.ArrayLike, *, key: Array) -> npt.NDArray[np.float32]:
        """The colour of each tile, linear light, [..., 3]: its own where it was seen, drawn where not, as `draw_tiles`
        has it.

        Args:
            course, tile: integer numbers of the tiles, of one shape.
            key: random key.

        Examples:
            >>> import jax
            >>> plain = Appearance(tiles={(0, 0): (0.5, 0.2, 0.1)}, joint=(0.6, 0.6, 0.6))
            >>> plain.colours([0, 1], [0, 0], key=jax.random.key(0)).round(2)
            array([[0.5, 0.2, 0.1],
                   [0.5, 0.2, 0.1]], dtype=float32)
        """
        return draw_tiles(self, course, tile, key=key).colour

    def to_json(self) -> dict[str, Any]:
        """As plain JSON values; colours as sRGB hexadecimal, tiles not seen as null."""
        return {
            "joint": _to_hex(self.joint),
            "pattern": [list(row) for row in self.pattern],
            "neighbours": list(self.neighbours),
            "trend": list(self.trend),
            **{name: getattr(self, name) for name in _NUMBERS},
            "tiles": list(_courses_to_json(self.tiles)),
        }


def choose_relief(tiling: Tiling) -> tuple[float, float]:
    """How deep a tiling's joints lie and how far its tiles' edges are rounded, by the thickness of its mortar.

    Returns:
        (joint_depth, edge_width) of an `Appearance`.
    """
    mortar = 0.5 * float(tiling.mortar_x + tiling.mortar_y)
    shortest = float(tiling.tile_width * np.min(tiling.course_lengths) - tiling.mortar_x)
    face = min(shortest, float(tiling.tile_height - tiling.mortar_y))
    return round(_DEPTH * mortar, 3), round(min(_DEPTH * mortar, 0.25 * face), 3)


def appearance_of(file: ModelFile) -> Appearance:
    """The appearance in a model file; grey tiles and lighter joints where it has none.

    Raises:
        InputError: as `appearance_from_json`, or the model is no tiling.
    """
    file = need_tiling(file)
    if file.appearance is not None:
        return appearance_from_json(file.appearance)
    depth, edge = choose_relief(file.tiling)
    tile, joint = quantise((0.3,) * 3), quantise((0.5,) * 3)
    return Appearance(tiles={(0, 0): tile}, joint=joint, joint_depth=depth, edge_width=edge)


def quantise(colour: Sequence[float] | npt.NDArray[np.floating]) -> tuple[float, float, float]:
    """The nearest colour that a model file holds (8 bits of sRGB per channel)."""
    return _from_hex(_to_hex(colour))


def appearance_from_json(data: Mapping[str, Any]) -> Appearance:
    """Read what `Appearance.to_json` made, or a person changed.

    Raises:
        InputError: what is missing or wrong, by its name.

    Examples:
        >>> floor = Appearance(tiles={(0, 0): quantise((0.5, 0.2, 0.1))}, joint=quantise((0.6, 0.6, 0.6)))
        >>> appearance_from_json(floor.to_json()) == floor
        True
    """
    try:
        # What no older file has is as a plain appearance has it.
        values = {name: _number(data, name, top) for name, top in _NUMBERS.items() if name in data}
        return Appearance(
            tiles=_courses_from_json(data["tiles"]),
            joint=_from_hex(data["joint"]),
            pattern=_check_pattern(data),
            neighbours=_numbers(data, "neighbours", 2, STRONGEST),
            trend=_numbers(data, "trend", 3, 10.0),
            **values,
        )
    except KeyError as error:
        raise InputError(f"appearance: lacks {error}") from None
    except (TypeError, AttributeError):
        raise InputError("appearance: is not laid out as model files are; fit the photograph again") from None


# The greatest value of each number.
_NUMBERS = {
    "joint_depth": 1e9,
    "edge_width": 1e9,
    "tile_bump": 10.0,
    "joint_bump": 10.0,
    "tile_roughness": 1.0,
    "joint_roughness": 1.0,
    "tile_specular": 1.0,
    "joint_specular": 1.0,
    "tile_metallic": 1.0,
    "joint_metallic": 1.0,
}


def _number(data: Mapping[str, Any], name: str, top: float) -> float:
    value = data[name]
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= top:
        raise InputError(f"appearance: {name} must be a number from 0 to {top:g}, not {value!r}")
    return float(value)


def _numbers(data: Mapping[str, Any], name: str, count: int, top: float) -> tuple[Any, ...]:
    values = data.get(name, [0.0] * count)
    right = isinstance(values, list) and len(values) == count
    if not right or not all(isinstance(value, int | float) and abs(value) <= top for value in values):
        raise InputError(f"appearance: {name} must be {count} numbers from {-top:g} to {top:g}, not {values!r}")
    return tuple(map(float, values))


def _check_pattern(data: Mapping[str, Any]) -> Pattern:
    pattern = tuple(map(tuple, data["pattern"]))
    numbers = [number for row in pattern for number in row]
    whole = all(isinstance(number, int) and 0 <= number < 256 for number in numbers)
    if not numbers or not whole or len(set(map(len, pattern))) != 1:
        raise InputError(f"appearance: pattern must be a table of whole numbers from 0, not {data['pattern']!r}")
    return pattern


def _courses_to_json(tiles: Mapping[Place, tuple[float, float, float]]) -> list[dict[str, Any]]:
    courses: dict[int, dict[int, str]] = {}
    for (course, tile), colour in tiles.items():
        courses.setdefault(course, {})[tile] = _to_hex(colour)
    return [
        {"course": course, "first": min(row), "colours": [row.get(tile) for tile in range(min(row), max(row) + 1)]}
        for course, row in sorted(courses.items())
    ]


def _courses_from_json(courses: Sequence[Mapping[str, Any]]) -> dict[Place, tuple[float, float, float]]:
    tiles = {
        (_whole(row["course"]), _whole(row["first"]) + n): _from_hex(colour)
        for row in courses
        for n, colour in enumerate(row["colours"])
        if colour is not None
    }
    if not tiles:
        raise InputError("appearance: tiles holds no colour; give at least one")
    return tiles


def _whole(number: object) -> int:
    if isinstance(number, int | float) and number == int(number) and abs(number) < 2**30:
        return int(number)
    raise InputError(f"appearance: {number!r} is no whole number of a tile or course")


def _to_hex(colour: Sequence[float] | npt.NDArray[np.floating]) -> str:
    encoded = linear_to_srgb(np.clip(np.asarray(colour, dtype=np.float64), 0, 1))
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in encoded)


def _from_hex(text: str) -> tuple[float, float, float]:
    if not isinstance(text, str) or not re.fullmatch("#[0-9a-fA-F]{6}", text):
        raise InputError(f"appearance: {text!r} is no colour; write it as #rrggbb")
    encoded = np.array([int(text[at : at + 2], 16) for at in (1, 3, 5)]) / 255
    red, green, blue = srgb_to_linear(encoded).tolist()
    return red, green, blue
