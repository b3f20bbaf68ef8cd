"""Things by their colours: a person says what colours they have, and perhaps the ground's.

J.-M. Dischler, K. Maritaud, B. Lévy and D. Ghazanfarpour, "Texture particles" (Eurographics 2002), section 2.1.
"""

from collections.abc import Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy import ndimage
from skimage.morphology import remove_small_holes, remove_small_objects

from jaxtex.core.colour import linear_to_srgb
from jaxtex.core.errors import InputError
from jaxtex.particles.ground import split_touching
from jaxtex.particles.kinds import nearest_centre
from jaxtex.particles.things import Decomposition, describe_particles
from jaxtex.photo.pictures import check_picture, to_lab

ColourDistance = Literal["lab", "rgb"]

_LEAST_AREA = 8  # pixels, times the square of the smoothing: less is no thing, and no hole in one
_TURNS = 20  # of looking for the ground's colour

Map = npt.NDArray[np.float32]


def pick_particles(
    pixels: npt.ArrayLike,
    things: Sequence[npt.ArrayLike],
    ground: npt.ArrayLike | None = None,
    *,
    distance: ColourDistance = "lab",
    smoothing: float = 1.0,
) -> Decomposition:
    """Take a picture apart into things of given colours, each pixel going with the colour that is nearest.

    Args:
        pixels: linear light, [row, col] or [row, col, channel] of 1 or 3 channels.
        things: for each class of things its colours, linear light, [colour, channel]. `photo.segment.pick_colours`
            takes them from places in the picture.
        ground: likewise, of what is no thing. Unless told, the ground is of the one colour that fits best all that is
            far from the colours of things.
        distance: how colours are compared: where steps look even (CIE Lab), or by sRGB's numbers as in the paper.
        smoothing: standard deviation in pixels of the Gaussian filter that takes grain away first; 0 is none.

    Returns:
        The picture taken apart; things that touch others of their class are parted where they are narrow.

    Raises:
        InputError: no picture, colours of another number of channels, or no thing of these colours.
        ValueError: no colours of things, or a negative smoothing.

    Examples:
        >>> row, column = np.indices((48, 48)) % 24 - 12
        >>> spots = np.where(np.hypot(row, column) < 7, 0.1, 0.6)
        >>> len(pick_particles(spots, [[[0.1]]]).particles)
        4
    """
    picture = check_picture(pixels)
    if not len(things) or any(not np.size(each) for each in things):
        raise ValueError("things: hold no colour; give one to each class at least")
    if not (np.isfinite(smoothing) and smoothing >= 0):
        raise ValueError(f"smoothing is {smoothing}; give pixels, 0 or more")
    values = ndimage.gaussian_filter(_convert(picture, distance), (smoothing, smoothing, 0))
    picked = [_convert_colours(each, picture, distance) for each in things]
    owners = np.repeat(np.arange(len(picked)), [len(each) for each in picked])
    centres = np.concatenate(picked)
    beyond = _find_ground(values, centres) if ground is None else _convert_colours(ground, picture, distance)
    nearest = np.append(owners, np.full(len(beyond), -1))[nearest_centre(values, np.concatenate([centres, beyond]))]
    labels, kinds = _number_things(nearest, len(picked), smoothing)
    if not kinds:
        raise InputError("picture: nothing has these colours; pick others")
    return describe_particles(labels, np.unique(kinds, return_inverse=True)[1])


def _convert(picture: Map, distance: ColourDistance) -> Map:
    return to_lab(picture) if distance == "lab" else np.asarray(linear_to_srgb(picture), np.float32)


def _convert_colours(colours: npt.ArrayLike, picture: Map, distance: ColourDistance) -> Map:
    given = np.atleast_2d(np.asarray(colours, np.float32))
    if given.ndim != 2 or given.shape[1] != picture.shape[2]:
        raise InputError(f"colours of shape {given.shape}: give [colour, channel], of the picture's {picture.shape[2]}")
    return _convert(given[:, None], distance)[:, 0]


def _find_ground(values: Map, centres: Map) -> Map:
    """One more colour [1, feature] beside those that are given: k-means in which only that one moves."""
    away = np.min([np.square(values - each).sum(axis=-1) for each in centres], axis=0)
    ground = values[away >= np.quantile(away, 0.9)].mean(axis=0)
    for _ in range(_TURNS):
        belongs = np.square(values - ground).sum(axis=-1) < away
        if not belongs.any():
            break
        ground = values[belongs].mean(axis=0)
    return ground[None].astype(np.float32)


def _number_things(
    nearest: npt.NDArray[np.intp], classes: int, smoothing: float
) -> tuple[npt.NDArray[np.int32], list[int]]:
    small = int(_LEAST_AREA * (1 + smoothing**2))
    labels, kinds = np.zeros(nearest.shape, np.int32), list[int]()
    for kind in range(classes):
        things = remove_small_objects(remove_small_holes(nearest == kind, max_size=small), max_size=small)
        numbered = split_touching(things & (labels == 0), smoothing=smoothing)
        numbers = np.unique(numbered[numbered > 0])
        labels = np.where(numbered > 0, np.searchsorted(numbers, numbered) + 1 + len(kinds), labels).astype(np.int32)
        kinds += [kind] * len(numbers)
    return labels, kinds
