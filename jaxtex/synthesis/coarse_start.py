"""What multi-resolution k-coherence search begins with, at the coarsest level: blocks of the exemplar, or a hole filled
from its border inwards. See `jaxtex.synthesis.coherence`."""

import itertools
import math

import jax
import numpy as np
import numpy.typing as npt
from jax import Array
from scipy.ndimage import distance_transform_cdt

from jaxtex.synthesis.exemplars import ExemplarLevel, choose_candidates, look_around, neighbourhood_weights

_BLOCK = 11  # pixels at the coarsest level: the larger, the more is copied as it stands
_GUIDED_BLOCK = 5  # likewise, where guides change within larger ones
_SHIFT = 3  # pixels at the coarsest level, at most, to where a block fits best
_GUIDE_SLACK = 0.05  # of a guide's variance: how much less like the texture's it may be than the best
_AT_A_TIME = 2048  # pixels


def lay_blocks(level: ExemplarLevel, guide: npt.NDArray[np.float32], key: Array, radius: int) -> npt.NDArray[np.int32]:
    """Blocks of the exemplar, from places that are about evenly spread over it; as places [row, col].

    Each is shifted to where its surroundings are most like what lies there already, across the borders too: so regular
    textures stay in step. With a guide [row, col, channel], they are of places where the exemplar's is like it.
    """
    shape = (guide.shape[0], guide.shape[1])
    rows, columns = level.valid.shape
    side = min(_GUIDED_BLOCK if guide.shape[2] else _BLOCK, rows, columns)
    down, right = (max(1, round(each / side)) for each in shape)
    tops, lefts = (np.arange(count + 1) * each // count for count, each in zip((down, right), shape, strict=True))
    limits = np.maximum(level.valid.shape - np.array([np.diff(tops).max(), np.diff(lefts).max()]), 0)
    strata = math.ceil(math.sqrt(down * right))
    cells = jax.random.permutation(jax.random.fold_in(key, 0), strata**2)[: down * right]
    jitter = np.asarray(jax.random.uniform(jax.random.fold_in(key, 1), (down * right, 2)))
    starts = ((np.stack([cells // strata, cells % strata], axis=1) + jitter) / strata * (limits + 1)).astype(int)
    starts = np.clip(starts - _SHIFT, 0, np.maximum(limits - 2 * _SHIFT, 0))
    shifts = np.moveaxis(np.indices((2 * _SHIFT + 1, 2 * _SHIFT + 1)), 0, -1).reshape(-1, 2)
    # Blocks meet along lines, of which none should always be the texture's border.
    turn = np.asarray(jax.random.randint(jax.random.fold_in(key, 3), (2,), 0, side))
    if guide.shape[2]:
        starts = _follow_guide(level, np.roll(guide, -turn, (0, 1)), (tops, lefts), key)
    places = np.full(shape, -1)
    for number, start in enumerate(starts):
        top, bottom = tops[number // right : number // right + 2]
        left, after = lefts[number % right : number % right + 2]
        row, column = np.indices((bottom - top + 2 * radius, after - left + 2 * radius)).reshape(2, -1) - radius
        around = places[(top + row) % shape[0], (left + column) % shape[1]]
        corners = np.minimum(start + shifts, limits)
        corner = corners[np.argmin(_mismatch(level, corners, np.stack([row, column])[:, around >= 0], around))]
        row, column = np.indices((bottom - top, after - left))
        place_row, place_column = (
            np.minimum(first + step, last - 1)
            for first, step, last in zip(corner, (row, column), (rows, columns), strict=True)
        )
        places[top:bottom, left:after] = place_row * columns + place_column
    return np.roll(level.nearest_valid[places], turn, (0, 1))


def _follow_guide(
    level: ExemplarLevel,
    guide: npt.NDArray[np.float32],
    borders: tuple[npt.NDArray[np.int_], npt.NDArray[np.int_]],
    key: Array,
) -> npt.NDArray[np.int_]:
    """For each block between these borders, a start [block, 2] where the exemplar's guide is like the texture's: any of
    those where it is nearly as like as can be, so that all that a guide leaves open is used."""
    channels = guide.shape[2]
    ours = level.pixels[..., -channels:]
    blocks = list(itertools.product(itertools.pairwise(borders[0]), itertools.pairwise(borders[1])))
    draws = np.asarray(jax.random.uniform(jax.random.fold_in(key, 2), (len(blocks),)))
    slack = _GUIDE_SLACK * ours.var(axis=(0, 1)).sum()
    chosen = []
    for ((top, bottom), (left, after)), draw in zip(blocks, draws, strict=True):
        down, right = min(bottom - top, len(ours)), min(after - left, ours.shape[1])
        wanted = guide[top : top + down, left : left + right]
        windows = np.lib.stride_tricks.sliding_window_view(ours, (down, right), axis=(0, 1))[::2, ::2]
        apart = np.square(windows - np.moveaxis(wanted, -1, 0)).mean(axis=(3, 4)).sum(axis=2)
        like = np.argwhere(apart <= apart.min() + slack)
        chosen.append(2 * like[int(draw * len(like))])
    return np.array(chosen)


def _mismatch(
    level: ExemplarLevel, corners: npt.NDArray[np.int_], steps: npt.NDArray[np.int_], places: npt.NDArray[np.int_]
) -> npt.NDArray[np.float32]:
    """How much pixels at some steps from each corner, [corner, 2], differ from what lies there; 0 if nothing does."""
    limits = np.array(level.valid.shape)[:, None, None] - 1
    row, column = np.clip(corners.T[:, :, None] + steps[:, None, :], 0, limits)
    lying = level.pixels.reshape(-1, level.pixels.shape[2])[places[places >= 0]]
    return np.square(level.pixels[row, column] - lying).sum(axis=(1, 2))


def grow_inwards(level: ExemplarLevel, kept: npt.NDArray[np.bool_], radius: int) -> npt.NDArray[np.int32]:
    """A hole filled ring by ring, each pixel from where the exemplar is most like what is known around it."""
    places = np.arange(kept.size, dtype=np.int32).reshape(kept.shape)
    picture, known = level.pixels * kept[..., None], kept.astype(np.float32)[..., None]
    choices = choose_candidates(level.valid)
    weights = np.square(neighbourhood_weights(radius))[:, None]
    seen = look_around(level.pixels, radius, choices)
    values, squares = seen.reshape(len(choices), -1), np.square(seen).sum(axis=2)
    ring = distance_transform_cdt(~kept, metric="chessboard")
    for number in range(1, int(ring.max()) + 1):
        pixels = np.flatnonzero(ring == number)
        found = []
        for part in np.array_split(pixels, -(-len(pixels) // _AT_A_TIME)):
            mask = look_around(known, radius, part) * weights
            given = (look_around(picture, radius, part) * mask).reshape(len(part), -1)
            found.append(choices[np.argmin(mask[..., 0] @ squares.T - 2 * given @ values.T, axis=1)])
        places.ravel()[pixels] = np.concatenate(found)
        picture.reshape(-1, picture.shape[2])[pixels] = level.pixels.reshape(-1, picture.shape[2])[
            places.ravel()[pixels]
        ]
        known.ravel()[pixels] = 1
    return places
