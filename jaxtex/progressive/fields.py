"""Fields over a picture from a few keys: how large things are there, how far a transition is, which way things lie.

J. Zhang et al., "Synthesis of Progressively-Variant Textures on Arbitrary Surfaces" (SIGGRAPH 2003), sections 3 and
4.1: three control channels, interpolated between keys by radial basis functions.

Departures: the functions are multiquadrics rather than Gaussians, whose width has to suit the distances between keys
and which fall back to a mean away from all of them. Multiquadrics go nearly evenly from one key to the next, are smooth
at the keys, and level off beyond. Nothing is smaller than the least value of a key, or larger than the largest. Keys
may be strokes too.
"""

from collections.abc import Callable, Sequence
from math import inf

import numpy as np
import numpy.typing as npt
from scipy import ndimage
from scipy.interpolate import RBFInterpolator
from scipy.spatial import cKDTree
from skimage.restoration import unwrap_phase

from jaxtex.core.errors import InputError
from jaxtex.progressive.keys import SPACING, FieldKey, Samples, fold_vectors, sample_directions, sample_scalars

Floats = npt.NDArray[np.floating]

_LEAST_LENGTH = 1e-6  # of an interpolated vector that has a direction

Given = Sequence[FieldKey] | Floats
"""What says a field: keys, or its values painted as a map of any size that is stretched over the picture."""


def scale_field(given: Given, size: tuple[int, int]) -> npt.NDArray[np.float32]:
    """How many times as large as in the exemplar things are, at each pixel.

    Args:
        given: keys with values above 0, or such values [row, col]. Their logarithms are interpolated.
        size: width and height of the picture in pixels.

    Returns:
        float32 [row, col].

    Raises:
        InputError: no key, a key outside of the picture, a value that is not above 0, or two values for one place.

    Examples:
        >>> left, right = FieldKey(((0.0, 0.5),), 0.5), FieldKey(((1.0, 0.5),), 2.0)
        >>> scale_field([left, right], (101, 3))[1, [0, 50, 100]].round(1).tolist()
        [0.5, 1.0, 2.0]
    """
    logarithms = _scalar_field("scale", given, size, np.log, least=0.0, most=inf)
    with np.errstate(over="ignore"):  # beyond float32 they are infinite, which is told as out of range
        return np.exp(logarithms).astype(np.float32)


def transition_field(given: Given, size: tuple[int, int]) -> npt.NDArray[np.float32]:
    """How far a transition is at each pixel.

    Args:
        given: keys with values from 0 to 1, or such values [row, col].
        size: width and height of the picture in pixels.

    Returns:
        float32 [row, col], 0 to 1.

    Raises:
        InputError: no key, a key outside of the picture, a value out of range, or two values for one place.

    Examples:
        >>> transition_field(np.array([[0.0, 1.0]]), (4, 1)).tolist()
        [[0.0, 0.25, 0.75, 1.0]]
    """
    return _scalar_field("transition", given, size, np.asarray, least=0.0, most=1.0).astype(np.float32)


def orientation_field(given: Given, size: tuple[int, int], *, symmetric: bool = False) -> npt.NDArray[np.float32]:
    """Which way things lie at each pixel: the direction in which the exemplar's x axis is turned.

    Args:
        given: keys with angles or strokes with none, which give their own direction; or vectors [row, col, 2] of any
            length but 0, (x, y).
        size: width and height of the picture in pixels.
        symmetric: whether the texture looks the same turned by half. Directions 10 and 170 degrees then have 0 between
            them, not 90; vectors do not jump to the opposite one where that can be helped.

    Returns:
        (x, y) of unit vectors, float32 [row, col, 2]. Where opposite directions meet (across each other, where
        symmetric), theirs jumps: a key between them tells which way it is to turn.

    Raises:
        InputError: no key, a key outside of the picture, a point without value, or two values for one place.

    Examples:
        >>> falling, rising = FieldKey(((0.0, 0.5),), np.radians(10)), FieldKey(((1.0, 0.5),), np.radians(170))
        >>> np.abs(orientation_field([falling, rising], (41, 3), symmetric=True)[1, 20]).round(3).tolist()
        [1.0, 0.0]
        >>> np.abs(orientation_field([falling, rising], (41, 3))[1, 20]).round(3).tolist()
        [0.0, 1.0]
    """
    fold = 2 if symmetric else 1
    if isinstance(given, np.ndarray):
        painted = _check_map("orientation", given, form="[row, col, 2]")
        if not np.hypot(painted[..., 0], painted[..., 1]).min() > 0:
            raise InputError("orientation: the map has a vector of length 0; paint a direction everywhere")
        vectors = _stretch(fold_vectors(painted, fold), size)
        first = painted[0, 0]
    else:
        samples = sample_directions(given, size, fold)
        vectors = _interpolate(samples, size)
        unclear = np.hypot(vectors[..., 0], vectors[..., 1]) < _LEAST_LENGTH
        nearest = cKDTree(samples.points).query(_centres(size)[unclear])[1]
        vectors[unclear] = samples.values[nearest]
        first = sample_directions(given[:1], size, 1).values[0]
    angles = np.arctan2(vectors[..., 1], vectors[..., 0])
    if symmetric:
        angles = _unwrap(angles) / 2
    vectors = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    if symmetric and (vectors @ first).mean() < 0:
        vectors = -vectors  # there are two such fields: the one that goes the first key's way
    return vectors.astype(np.float32)


def _scalar_field(
    name: str,
    given: Given,
    size: tuple[int, int],
    convert: Callable[[npt.ArrayLike], npt.NDArray],
    *,
    least: float,
    most: float,
) -> Floats:
    """A field of converted values. A bound of 0 is out of range itself where there is none above."""
    told = "above 0" if most == inf else f"from {least:g} to {most:g}"

    def check(values: Floats, where: str) -> Floats:
        wrong = ~((values > least if most == inf else values >= least) & (values <= most) & np.isfinite(values))
        if wrong.any():
            raise InputError(f"{name}: {where} is {values[wrong][0]:g}; give a value {told}")
        return convert(values)

    if isinstance(given, np.ndarray):
        painted = check(_check_map(name, given, form="[row, col]"), "a value of the map")
        return _stretch(painted[..., None], size)[..., 0]
    for number, key in enumerate(given, 1):
        if key.value is None:
            raise InputError(f"{name}: key {number} has no value; give one {told}")
        check(np.array([key.value]), f"key {number}")
    points, values = sample_scalars(name, given, size)
    converted = convert(values)
    field = _interpolate(Samples(points, converted), size)[..., 0]
    return np.clip(field, converted.min(), converted.max())


def _check_map(name: str, given: Floats, *, form: str) -> Floats:
    values = given.astype(float)
    if values.ndim != form.count(",") + 1 or values.shape[2:] not in ((), (2,)) or 0 in values.shape:
        raise InputError(f"{name}: a map of shape {given.shape}; give {form}, not empty")
    if not np.isfinite(values).all():
        raise InputError(f"{name}: the map holds a number that is not finite")
    return values


def _stretch(values: Floats, size: tuple[int, int]) -> Floats:
    """A map [row, col, channel] interpolated at the centres of a picture's pixels."""
    rows, columns = values.shape[:2]
    down, across = np.indices(size[::-1]) + 0.5
    places = np.stack([down * (rows / size[1]) - 0.5, across * (columns / size[0]) - 0.5])
    channels = [ndimage.map_coordinates(each, places, order=1, mode="nearest") for each in np.moveaxis(values, -1, 0)]
    return np.stack(channels, axis=-1)


def _centres(size: tuple[int, int]) -> Floats:
    """(x, y) of a picture's pixels in its shorter sides, [row, col, 2]."""
    down, across = np.indices(size[::-1]) + 0.5
    return np.stack([across, down], axis=-1) / min(size)


def _interpolate(samples: Samples, size: tuple[int, int]) -> Floats:
    """Values [row, col, channel] at a picture's pixels."""
    if len(samples.points) == 1:
        return np.tile(samples.values[0], (*size[::-1], 1))
    interpolator = RBFInterpolator(samples.points, samples.values, kernel="multiquadric", epsilon=1 / SPACING, degree=0)
    return interpolator(_centres(size).reshape(-1, 2)).reshape(*size[::-1], -1)


def _unwrap(angles: Floats) -> Floats:
    """Angles [row, col] without jumps by whole turns."""
    if min(angles.shape) > 1:
        return unwrap_phase(angles, rng=0)
    return np.unwrap(angles.ravel()).reshape(angles.shape)
