"""What the tiles and joints of a tiling look like, apart from where they are."""

import dataclasses
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
from jaxtex.core.errors import InputError
from jaxtex.material.patterns import ONE_CLASS, Pattern, class_of
from jaxtex.models.files import ModelFile, need_tiling
from jaxtex.models.tiling import Tiling

Place = tuple[int, int]

_DEPTH = 0.4  # of the mortar's thickness: joints of brickwork are struck back by 3 to 5 mm of 10
_JITTER = 0.2  # how far drawn colours stray from the seen ones, in standard deviations of all seen ones
_EDGE = 1 / 512  # black and white as drawn colours see them: half a step of 8 bits inside


@dataclasses.dataclass(frozen=True)
class Appearance:
    """Colours, roughness and relief of a tiling's tiles and joints.

    Attributes:
        tiles: colour of each tile that was seen, by (course, tile): linear light, quantised to 8 bits of sRGB.
        joint: colour of the joints, likewise.
        pattern: which tiles share a class of colours, as `choose_pattern` has it.
        joint_depth: how far the joints lie below the tiles' faces, in plane pixels, >= 0.
        edge_width: how far the rounding of a tile's edge reaches into its face, in plane pixels, >= 0.
        tile_roughness, joint_roughness: 0 (mirror) to 1 (dull), the square root of GGX's alpha. A photograph does not
            show depth, edges and roughness: they are chosen, and can be edited in the model file.
    """

    tiles: Mapping[Place, tuple[float, float, float]]
    joint: tuple[float, float, float]
    pattern: Pattern = ONE_CLASS
    joint_depth: float = 0.0
    edge_width: float = 0.0
    tile_roughness: float = 0.6
    joint_roughness: float = 0.9

    def colours(self, course: npt.ArrayLike, tile: npt.ArrayLike, *, key: Array) -> npt.NDArray[np.float32]:
        """The colour of each tile, linear light, [..., 3]: its own where it was seen, drawn where not.

        A drawn colour depends on the key and the tile alone, whatever else is asked for. It is one of the colours seen
        on tiles of its class, strayed from by a fifth of their standard deviation and shrunk so that mean and
        covariance stay those of the class (the smoothed bootstrap; B. Silverman, Density Estimation, 1986, section
        6.4.1). This happens in the logit of sRGB values, so that no colour leaves the range; a set of few odd colours
        stays such a set.

        Args:
            course, tile: integer numbers of the tiles, of one shape.
            key: random key.

        Examples:
            >>> plain = Appearance(tiles={(0, 0): (0.5, 0.2, 0.1)}, joint=(0.6, 0.6, 0.6))
            >>> plain.colours([0, 1], [0, 0], key=jax.random.key(0)).round(2)
            array([[0.5, 0.2, 0.1],
                   [0.5, 0.2, 0.1]], dtype=float32)
        """
        course, tile = np.broadcast_arrays(np.asarray(course, dtype=np.int64), np.asarray(tile, dtype=np.int64))
        flat = [pad_table(part.ravel()) for part in (class_of(self.pattern, course, tile), course, tile)]
        drawn = np.asarray(_draw_all(*self._palettes(), *flat, key))[: course.size]
        own = np.array(list(self.tiles))
        numbers, order = np.unique(_one_number(own[:, 0], own[:, 1]), return_index=True)
        asked = _one_number(course.ravel(), tile.ravel())
        found = np.minimum(np.searchsorted(numbers, asked), len(numbers) - 1)
        seen = np.array(list(self.tiles.values()), dtype=np.float32)[order[found]]
        return np.where((numbers[found] == asked)[:, None], seen, drawn).reshape(*course.shape, 3)

    def _palettes(self) -> tuple[npt.NDArray[np.float32], ...]:
        """For each class: logits of the colours seen (padded), how many they are, a root of their covariance."""
        places = np.array(list(self.tiles))
        seen = _to_logit(np.array(list(self.tiles.values())))
        label = class_of(self.pattern, *places.T)
        groups = [seen[label == k] if (label == k).any() else seen for k in range(1 + max(map(max, self.pattern)))]
        longest = max(map(len, groups))
        padded = np.stack([pad_table(np.pad(group, [(0, longest - len(group)), (0, 0)])) for group in groups])
        roots = np.stack([_covariance_root(group) for group in groups])
        return padded.astype(np.float32), np.array([len(group) for group in groups], np.int32), roots.astype(np.float32)

    def to_json(self) -> dict[str, Any]:
        """As plain JSON values; colours as sRGB hexadecimal, tiles not seen as null."""
        return {
            "joint": _to_hex(self.joint),
            "pattern": [list(row) for row in self.pattern],
            "joint_depth": self.joint_depth,
            "edge_width": self.edge_width,
            "tile_roughness": self.tile_roughness,
            "joint_roughness": self.joint_roughness,
            "tiles": list(_courses_to_json(self.tiles)),
        }


def pad_table(table: npt.NDArray) -> npt.NDArray:
    """A table with zeros after it, up to a power of four: tables of about one length share compiled code."""
    length = 4 ** math.ceil(math.log(len(table), 4))
    return np.pad(table, [(0, length - len(table))] + [(0, 0)] * (table.ndim - 1))


def _one_number(course: npt.NDArray[np.int64], tile: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    return course * 2**32 + tile


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
        values = {name: _number(data, name, top) for name, top in _NUMBERS.items()}
        return Appearance(
            tiles=_courses_from_json(data["tiles"]),
            joint=_from_hex(data["joint"]),
            pattern=_check_pattern(data),
            **values,
        )
    except KeyError as error:
        raise InputError(f"appearance: lacks {error}") from None
    except (TypeError, AttributeError):
        raise InputError("appearance: is not laid out as model files are; fit the photograph again") from None


_NUMBERS = {"joint_depth": 1e9, "edge_width": 1e9, "tile_roughness": 1.0, "joint_roughness": 1.0}


def _number(data: Mapping[str, Any], name: str, top: float) -> float:
    value = data[name]
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= top:
        raise InputError(f"appearance: {name} must be a number from 0 to {top:g}, not {value!r}")
    return float(value)


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


def _to_logit(linear: npt.NDArray[np.floating]) -> npt.NDArray[np.floating]:
    encoded = np.clip(linear_to_srgb(np.clip(linear, 0, 1)), _EDGE, 1 - _EDGE)
    return np.log(encoded / (1 - encoded))


def _covariance_root(values: npt.NDArray[np.floating]) -> npt.NDArray[np.floating]:
    """A such that A^T A is the covariance; colours of fewer dimensions (greys) stay there."""
    scale, axes = np.linalg.eigh(np.cov(values.T, bias=True))
    return np.sqrt(np.clip(scale, 0, None))[:, None] * axes.T


@jax.jit
def _draw_all(
    palettes: Array, counts: Array, roots: Array, label: Array, course: Array, tile: Array, key: Array
) -> Array:
    """Colours of all tiles, linear light, [tile, 3]."""
    means = palettes.sum(axis=1) / counts[:, None]

    def draw(label: Array, course: Array, tile: Array) -> Array:
        # All that chance decides in one draw, as random bits are what takes long to compile.
        own_key = jax.random.fold_in(jax.random.fold_in(key, course), tile)
        chance = jax.random.uniform(own_key, (4,), minval=1e-6)
        pick = jnp.minimum((chance[0] * counts[label]).astype(int), counts[label] - 1)
        normal = jax.scipy.special.ndtri(chance[1:])
        strayed = palettes[label, pick] - means[label] + _JITTER * (normal @ roots[label])
        logit = means[label] + strayed / jnp.sqrt(1 + _JITTER**2)
        return srgb_to_linear(jax.nn.sigmoid(logit))

    return jax.vmap(draw)(label, course, tile)
