"""What anisometric synthesis begins with, at the coarsest level: pieces of the exemplar, scaled and turned."""

import itertools

import jax
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.synthesis.anisometric_pass import Floats, Given
from jaxtex.synthesis.exemplars import ExemplarLevel

_BLOCK = 11  # pixels at the coarsest level: the larger, the more is copied as it stands
_GUIDED_BLOCK = 5  # likewise, where guides change within larger ones
_DRAWS = 48  # places that are tried for each piece
_SHIFT = 3  # pixels, at most, by which the best of these is moved to where it fits even better

Places = npt.NDArray[np.intp]


def lay_pieces(level: ExemplarLevel, given: Given, tolerance: float, key: Array, radius: int, tileable: bool) -> Floats:
    """Pieces of the exemplar, each scaled and turned about its middle; as sources [row, col, 2].

    Each is, of some that are drawn among the places that may be used, the one that is most like what lies around it
    already, so that regular textures stay in step, and like the guide.
    """
    rng = np.random.default_rng(np.asarray(jax.random.bits(key, (4,), np.uint32)))
    shape = given.frames.shape[:2]
    block = _GUIDED_BLOCK if given.guide.shape[2] else _BLOCK
    sources, laid = np.zeros((*shape, 2), np.float32), np.zeros(shape, bool)
    borders = [np.arange(count + 1) * side // count for side in shape for count in [max(1, round(side / block))]]
    shifts = _pixels(-_SHIFT, _SHIFT + 1, -_SHIFT, _SHIFT + 1)
    for (top, bottom), (left, after) in itertools.product(*map(itertools.pairwise, borders)):
        middle = (top + bottom - 1) // 2, (left + after - 1) // 2
        inside = _pixels(top, bottom, left, after)
        around = _pixels(top - radius, bottom + radius, left - radius, after + radius)
        there = around % shape if tileable else np.clip(around, 0, np.array(shape) - 1)
        lying = laid[tuple(there.T)]
        around, there = around[lying], there[lying]

        def choose(places: Places) -> Places:
            options = _keep_valid(level, places)
            missed = _miss_guide(level, given, options, middle, inside)  # noqa: B023
            missed += _miss_surroundings(level, given, options, middle, around, sources[tuple(there.T)])  # noqa: B023
            return options[np.argmin(missed)][None]

        place = choose(choose(_draw_places(level, given, middle, tolerance, rng)) + shifts)
        piece = _lead(level, given, place, middle, inside)
        sources[top:bottom, left:after] = piece.reshape(bottom - top, after - left, 2)
        laid[top:bottom, left:after] = True
    return np.clip(sources, radius, np.array(level.valid.shape) - 1 - radius)


def _pixels(top: int, bottom: int, left: int, after: int) -> Places:
    return np.moveaxis(np.indices((bottom - top, after - left)), 0, -1).reshape(-1, 2) + np.array([top, left])


def _draw_places(
    level: ExemplarLevel, given: Given, middle: tuple[int, int], tolerance: float, rng: np.random.Generator
) -> Places:
    """Some of the places [place, 2] whose transition value is like the one in the middle of a piece."""
    apart = np.abs(given.transition[0] - given.transition[1][middle])
    usable = np.argwhere(level.valid & (apart < max(tolerance, apart[level.valid].min() + 1e-6)))
    return usable[rng.integers(len(usable), size=_DRAWS)]


def _keep_valid(level: ExemplarLevel, places: Places) -> Places:
    places = np.clip(places, 0, np.array(level.valid.shape) - 1)
    nearest = level.nearest_valid[places[:, 0] * level.valid.shape[1] + places[:, 1]]
    return np.stack(np.divmod(nearest, level.valid.shape[1]), axis=1)


def _lead(
    level: ExemplarLevel,
    given: Given,
    places: Places,
    middle: tuple[int, int],
    pixels: Places,
) -> Floats:
    """Where pixels of the texture come from if the middle comes from each of some places, [place, pixel, 2]."""
    steps = np.linalg.inv(given.frames[middle])[None]
    if level.frames is not None:
        steps = level.frames[places[:, 0], places[:, 1]] @ steps
    away = (pixels - np.array(middle)).astype(np.float32)
    return (places[:, None] + away[None] @ np.swapaxes(steps, 1, 2)).astype(np.float32)


def _show(picture: Floats, sources: Floats) -> Floats:
    row, column = (
        np.clip(np.rint(each), 0, side - 1).astype(int)
        for each, side in zip(np.moveaxis(sources, -1, 0), picture.shape[:2], strict=True)
    )
    return picture[row, column]


def _miss_guide(
    level: ExemplarLevel,
    given: Given,
    places: Places,
    middle: tuple[int, int],
    pixels: Places,
) -> Floats:
    channels = given.guide.shape[2]
    if not channels:
        return np.zeros(len(places), np.float32)
    shown = _show(level.pixels[..., -channels:], _lead(level, given, places, middle, pixels))
    return np.square(shown - given.guide[tuple(pixels.T)][None]).sum(axis=2).mean(axis=1)


def _miss_surroundings(
    level: ExemplarLevel,
    given: Given,
    places: Places,
    middle: tuple[int, int],
    pixels: Places,
    lying: Floats,
) -> Floats:
    """How much a piece would differ from what lies around it, whose sources are `lying`, [pixel, 2]."""
    if not len(pixels):
        return np.zeros(len(places), np.float32)
    shown = _show(level.pixels, _lead(level, given, places, middle, pixels))
    return np.square(shown - _show(level.pixels, lying)[None]).sum(axis=2).mean(axis=1)
