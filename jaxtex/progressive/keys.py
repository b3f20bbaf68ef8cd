"""Keys of fields: values at points or along strokes, as points that can be interpolated between."""

from collections.abc import Callable, Sequence
from math import cos, isfinite, sin
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from jaxtex.core.errors import InputError

Floats = npt.NDArray[np.floating]
Place = tuple[float, float]

SPACING = 1 / 32
"""Distance of the samples of a stroke, in shorter sides of the picture."""

_NEAR = 1 / 500  # of the shorter side: keys no farther apart are at one place
_ALIKE = 1e-6  # values no farther apart are the same


class FieldKey(NamedTuple):
    """A value that a field is to have somewhere.

    Attributes:
        places: (x, y) in parts of the picture's width and height, (0, 0) its upper left corner and (1, 1) its lower
            right one: one is a point, more are a stroke.
        value: scale, transition, or direction in radians from x towards y (clockwise as seen). None is a stroke's own
            direction.
    """

    places: tuple[Place, ...]
    value: float | None = None


class Samples(NamedTuple):
    """Keys as points that lie apart.

    Attributes:
        points: (x, y) in shorter sides of the picture, [point, 2].
        values: [point, channel].
    """

    points: Floats
    values: Floats


def sample_scalars(name: str, keys: Sequence[FieldKey], size: tuple[int, int]) -> Samples:
    """Keys with values as points, with one channel.

    Args:
        name: of the field, for complaints.
        keys: all with values.
        size: width and height of the picture in pixels.

    Raises:
        InputError: no key, one outside of the picture or with no length, or two values for one place.

    Examples:
        >>> sample_scalars("scale", [FieldKey(((0.5, 0.5),), 2.0)], (200, 100))
        Samples(points=array([[1. , 0.5]]), values=array([[2.]]))
    """
    return _sample(name, keys, size, lambda key, ways: np.full((len(ways), 1), key.value))


def sample_directions(keys: Sequence[FieldKey], size: tuple[int, int], fold: int) -> Samples:
    """Keys of orientation as points, with unit vectors (x, y) at `fold` times the angle.

    Args:
        keys: points with values, strokes with or without.
        size: width and height of the picture in pixels.
        fold: 2 where opposite directions are the same, or 1.

    Raises:
        InputError: no key, one outside of the picture or with no length, a point without value, or two directions for
            one place.

    Examples:
        >>> stroke = FieldKey(((0.5, 0.2), (0.5, 0.8)))
        >>> sample_directions([stroke], (100, 100), 1).values[0].round(6).tolist()
        [0.0, 1.0]
    """

    for number, key in enumerate(keys, 1):
        if key.value is None and len(key.places) == 1:
            raise InputError(f"orientation: key {number} is a point without value; give one, or draw a stroke")
        if key.value is not None and not isfinite(key.value):
            raise InputError(f"orientation: key {number} is {key.value}; give an angle")

    def vectors(key: FieldKey, ways: Floats) -> Floats:
        own = ways if key.value is None else np.tile([cos(key.value), sin(key.value)], (len(ways), 1))
        return fold_vectors(own, fold)

    return _sample("orientation", keys, size, vectors)


def fold_vectors(vectors: Floats, fold: int) -> Floats:
    """Unit vectors [..., 2] at `fold` times the angle.

    Examples:
        >>> fold_vectors(np.array([[0.0, 1.0], [0.0, -1.0]]), 2).round(6).tolist()
        [[-1.0, 0.0], [-1.0, -0.0]]
    """
    angle = fold * np.arctan2(vectors[..., 1], vectors[..., 0])
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _sample(
    name: str, keys: Sequence[FieldKey], size: tuple[int, int], values_of: Callable[[FieldKey, Floats], Floats]
) -> Samples:
    """Keys as points. `values_of` gives a key's values at points with these directions, [point, channel]."""
    if not keys:
        raise InputError(f"{name}: has no keys; give one at least")
    for number, key in enumerate(keys, 1):
        _check_places(f"{name}: key {number}", key)
    sides = np.array(size) / min(size)

    def sample(spacing: float) -> tuple[npt.NDArray[np.intp], Samples]:
        strokes = [_sample_stroke(np.array(key.places, float) * sides, spacing) for key in keys]
        owners = np.repeat(np.arange(len(keys)), [len(points) for points, _ in strokes])
        values = [values_of(key, ways) for key, (_, ways) in zip(keys, strokes, strict=True)]
        return owners, Samples(np.concatenate([points for points, _ in strokes]), np.concatenate(values))

    _check_contradictions(name, *sample(_NEAR), sides)
    _, samples = sample(SPACING)
    # Where strokes meet, one place would be there twice.
    spare = cKDTree(samples.points).query_pairs(_NEAR, output_type="ndarray").max(axis=1, initial=-1)
    kept = np.setdiff1d(np.arange(len(samples.points)), spare)
    return Samples(samples.points[kept], samples.values[kept])


def _check_places(where: str, key: FieldKey) -> None:
    if not key.places:
        raise InputError(f"{where}: has no place; give (x, y) in parts of the picture")
    for x, y in key.places:
        if not (0 <= x <= 1 and 0 <= y <= 1):
            raise InputError(
                f"{where}: ({x:g}, {y:g}) is outside of the picture; give parts of its width and height, 0 to 1"
            )
    if len(key.places) > 1 and len(set(key.places)) == 1:
        raise InputError(f"{where}: is a stroke of no length; give two places at least")


def _check_contradictions(name: str, owners: npt.NDArray[np.intp], samples: Samples, sides: Floats) -> None:
    """Whether keys that meet have one value there."""
    pairs = cKDTree(samples.points).query_pairs(_NEAR, output_type="ndarray")
    one, other = pairs[owners[pairs[:, 0]] != owners[pairs[:, 1]]].T
    apart = np.abs(samples.values[one] - samples.values[other]).max(axis=1, initial=0.0) > _ALIKE
    if apart.any():
        place = int(one[apart][0])
        first, second = sorted((owners[place], owners[other[apart][0]]))
        x, y = samples.points[place] / sides
        raise InputError(
            f"{name}: keys {first + 1} and {second + 1} say different values for one place, ({x:.3g}, {y:.3g});"
            " leave one out, or move it"
        )


def _sample_stroke(places: Floats, spacing: float) -> tuple[Floats, Floats]:
    """Points along a polyline no farther apart than that, and its direction at each, both (x, y) [point, 2]."""
    if len(places) == 1:
        return places, np.zeros((1, 2))
    steps = np.diff(places, axis=0)
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    starts, steps, lengths = (each[lengths > 0] for each in (places[:-1], steps, lengths))
    total = lengths.sum()
    ends = np.cumsum(lengths)
    along = np.linspace(0.0, total, max(2, int(np.ceil(total / spacing)) + 1))
    piece = np.minimum(np.searchsorted(ends, along), len(lengths) - 1)
    part = (along - (ends - lengths)[piece]) / lengths[piece]
    return starts[piece] + part[:, None] * steps[piece], (steps / lengths[:, None])[piece]
