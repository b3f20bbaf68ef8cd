"""What anisometric synthesis begins with, at the coarsest level: pieces of the exemplar, scaled and turned."""

import itertools
from collections.abc import Iterator
from typing import Any

import jax
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.synthesis.anisometric_pass import Floats, Given
from jaxtex.synthesis.exemplars import ExemplarLevel

_BLOCK = 11  # pixels at the coarsest level: the larger, the more is copied as it stands
_GUIDED_BLOCK = 5  # likewise, where guides change within larger ones
_FIT = 1.5  # times as large as it should be may a piece be before it is parted in four
_DRAWS = 96  # places that are tried for each piece
_SPARE = 4  # times as many are drawn, of which those are tried that have been used least
_SHIFT = 3  # pixels, at most, by which the best of these is moved to where it fits even better
_NOT_WHOLE = 1e6  # how much worse than all others is a place beside which the exemplar ends within the piece

Places = npt.NDArray[np.intp]


def lay_pieces(level: ExemplarLevel, given: Given, tolerance: float, key: Array, radius: int, tileable: bool) -> Floats:
    """Pieces of the exemplar, each scaled and turned about its middle; as sources [row, col, 2].

    Each is, of some that are drawn among the places that may be used, the one that is most like what lies around it
    already, so that regular textures stay in step, and like the guide. Without a guide, all parts of the exemplar come
    into use about equally often, so that the texture has as much of each thing as it has.
    """
    rng = np.random.default_rng(np.asarray(jax.random.bits(key, (4,), np.uint32)))
    shape = given.frames.shape[:2]
    block = _GUIDED_BLOCK if given.guide.shape[2] else _BLOCK
    sources, laid = np.zeros((*shape, 2), np.float32), np.zeros(shape, bool)
    used = np.zeros(level.valid.shape, np.intp)
    shifts = _pixels(-_SHIFT, _SHIFT + 1, -_SHIFT, _SHIFT + 1)
    for top, bottom, left, after in _part(np.sqrt(np.linalg.det(given.frames)), block):
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
            missed = missed + _NOT_WHOLE * ~_lie_within(level, given, options, middle, inside, radius)  # noqa: B023
            return options[np.argmin(missed)][None]

        drawn = _draw_places(level, given, middle, tolerance, inside, radius, used, rng)
        place = choose(choose(drawn) + shifts)
        piece = _lead(level, given, place, middle, inside)[0]
        np.add.at(used, _nearest(used.shape, piece), 1)
        sources[top:bottom, left:after] = piece.reshape(bottom - top, after - left, 2)
        laid[top:bottom, left:after] = True
    return np.clip(sources, radius, np.array(level.valid.shape) - 1 - radius)


def _part(scale: Floats, block: int) -> Iterator[tuple[int, int, int, int]]:
    """(top, bottom, left, after) of squares about as large as a block is where they lie, where scale is [row, col]."""

    def split(limits: tuple[int, int, int, int], side: float) -> Iterator[tuple[int, int, int, int]]:
        top, bottom, left, after = limits
        if side * block < 2 or side < _FIT * scale[(top + bottom - 1) // 2, (left + after - 1) // 2]:
            yield limits
            return
        middle, centre = (top + bottom) // 2, (left + after) // 2
        for one, other in itertools.product(((top, middle), (middle, bottom)), ((left, centre), (centre, after))):
            if one[0] < one[1] and other[0] < other[1]:
                yield from split((*one, *other), side / 2)

    largest = float(scale.max())
    counts = [min(max(1, round(length / (block * largest))), length) for length in scale.shape]
    borders = [np.arange(count + 1) * length // count for count, length in zip(counts, scale.shape, strict=True)]
    for one, other in itertools.product(*map(itertools.pairwise, borders)):
        yield from split((int(one[0]), int(one[1]), int(other[0]), int(other[1])), largest)


def _pixels(top: int, bottom: int, left: int, after: int) -> Places:
    return np.moveaxis(np.indices((bottom - top, after - left)), 0, -1).reshape(-1, 2) + np.array([top, left])


def _draw_places(
    level: ExemplarLevel,
    given: Given,
    middle: tuple[int, int],
    tolerance: float,
    pixels: Places,
    radius: int,
    used: Places,
    rng: np.random.Generator,
) -> Places:
    """Some of the places [place, 2] whose transition value is like the one in the middle of a piece of some pixels,
    and around which the exemplar holds all of it, if there are such. Without a guide, those that are used least, where
    `used` tells how often each pixel is already."""
    apart = np.abs(given.transition[0] - given.transition[1][middle])
    usable = np.argwhere(level.valid & (apart < max(tolerance, apart[level.valid].min() + 1e-6)))
    whole = _lie_within(level, given, usable, middle, pixels, radius)
    usable = usable[whole] if whole.any() else usable
    spare = 1 if given.guide.shape[2] else _SPARE
    drawn = usable[rng.choice(len(usable), min(spare * _DRAWS, len(usable)), replace=False)]
    often = _show(used, _lead(level, given, drawn, middle, pixels)).mean(axis=1)
    return drawn[np.argsort(often, kind="stable")[: -(-len(drawn) // spare)]]


def _lie_within(
    level: ExemplarLevel, given: Given, places: Places, middle: tuple[int, int], pixels: Places, radius: int
) -> npt.NDArray[np.bool_]:
    """Whether what a piece shows, with its middle at each of some places, is all in the exemplar."""
    corners = np.array(list(itertools.product(*zip(pixels.min(axis=0), pixels.max(axis=0), strict=True))))
    shown = _lead(level, given, places, middle, corners)
    return np.all((shown >= radius) & (shown <= np.array(level.valid.shape) - 1 - radius), axis=(1, 2))


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


def _show(picture: npt.NDArray[Any], sources: Floats) -> npt.NDArray[Any]:
    return picture[_nearest(picture.shape, sources)]


def _nearest(shape: tuple[int, ...], sources: Floats) -> tuple[Places, ...]:
    """(rows, columns) of the pixels of a picture of some shape that are nearest to sources."""
    return tuple(
        np.clip(np.rint(each), 0, side - 1).astype(int)
        for each, side in zip(np.moveaxis(sources, -1, 0), shape[:2], strict=True)
    )


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
