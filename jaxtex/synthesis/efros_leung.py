"""Textures pixel by pixel: A. A. Efros and T. K. Leung, "Texture synthesis by non-parametric sampling", ICCV 1999.

Each pixel is drawn from among those of the exemplar whose surroundings are most like what is known of its own. That
makes a texture from a seed, and fills the holes of a picture from their borders inwards. Structures up to about the
neighbourhood's size are continued well; larger ones fall apart, or one place is copied over and over.

Departures from the paper: there is no threshold on how unlike the best may be, so every pixel finds one; pixels of one
layer come in the order of a fixed pattern, in which those drawn one after another do not see each other and are
computed together; weights are small integers, so that sums are exact.
"""

import math
from collections.abc import Iterator
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array
from scipy.ndimage import distance_transform_cdt

from jaxtex.synthesis.neighbourhoods import check_picture, check_shape
from jaxtex.synthesis.sources import Sources, Step, last_of

Mask = npt.NDArray[np.bool_]

_EXACT = 2**24  # integers up to here are floats of single precision, and so are their sums
_HEAVIEST = 16  # weight of a neighbour at no distance
_LANES = 16  # pixels computed together
_STEPS = 64  # times that, between two reports
_RUN = 128  # places that are counted together in a draw
_NOWHERE = 2**24  # row and column of no pixel


class _Search(eqx.Module):
    """What neighbourhoods are compared with.

    Attributes:
        places: centres of the exemplar's neighbourhoods, (row, col), [place, 2].
        centres: their colours as integers, [place, channel].
        colours: those of the taps around, [place, tap * channel].
        squares: their squares, summed over channels, [place, tap].
        taps: what is looked at, (row, col) from the neighbourhood's first corner, [tap, 2].
        weights: how much it counts, [tap].
    """

    places: Array
    centres: Array
    colours: Array
    squares: Array
    taps: Array
    weights: Array


class _Growth(eqx.Module):
    """The texture so far.

    Attributes:
        canvas: colours as integers and, as one more channel, whether they are known, with a border as wide as the
            neighbourhood's radius in which nothing is, [row, col, channel + 1].
        sources: the source map, [row, col, 2].
    """

    canvas: Array
    sources: Array


def synthesise_efros_leung(
    exemplar: npt.ArrayLike,
    shape: tuple[int, int],
    *,
    key: Array,
    radius: int = 5,
    tolerance: float = 0.1,
    picture: npt.ArrayLike | None = None,
    known: npt.ArrayLike | None = None,
    usable: npt.ArrayLike | None = None,
) -> Sources:
    """Grow a texture from a seed, or into the holes of a picture.

    The search is exhaustive: about 3 (channels + 1) radius^2 multiplications for each pixel and each place of the
    exemplar, done as matrix products. From 128^2 to 256^2 pixels with 11 x 11 neighbourhoods, those are 3 * 10^11, and
    ten seconds or so on one core. The exemplar's neighbourhoods are kept in memory, 10 (channels + 1) radius^2 bytes
    for each place.

    Args:
        exemplar: floats [row, col, channel], 0 to 1 (what lies beyond is clipped), in an encoding whose steps look
            even. Any number of channels.
        shape: (rows, columns) of the texture, any.
        key: random key; another key, another piece of the same texture.
        radius: of the neighbourhood, (2 radius + 1)^2 pixels with Gaussian weights; so large that it holds the largest
            regular feature.
        tolerance: pixels are drawn from among those whose neighbourhood's squared difference is at most 1 + tolerance
            times the least.
        picture, known: floats [row, col, channel] in the exemplar's encoding and a mask [row, col], both of this shape:
            pixels known stay, and the others are grown inwards from them. Without them, or where nothing is known, 3 x
            3 pixels of the exemplar in the middle are what it grows from.
        usable: mask [row, col] of the exemplar; what it leaves out is not looked at and not copied. To fill holes of a
            picture from the picture itself, it is what is known.

    Returns:
        The source map, [row, col, 2]: which (row, col) of the exemplar each pixel is copied from; -1 where it is known.

    Raises:
        ValueError: an exemplar of another form, with NaN or infinite values, smaller than the neighbourhood, or without
            one that is all usable; an empty shape; a radius below 1, a negative tolerance; a picture without known
            pixels' mask, or the other way round; pictures and masks of other sizes or channels.

    Examples:
        >>> stripes = np.tile([[[0.0], [0.0], [1.0]]], (12, 4, 1))
        >>> sources = synthesise_efros_leung(stripes, (5, 7), key=jax.random.key(0), radius=2)
        >>> np.unique(sources[:, :3, 1] % 3, axis=0).shape
        (1, 3)
    """
    return last_of(
        efros_leung_steps(
            exemplar,
            shape,
            key=key,
            radius=radius,
            tolerance=tolerance,
            picture=picture,
            known=known,
            usable=usable,
        )
    )


def efros_leung_steps(
    exemplar: npt.ArrayLike,
    shape: tuple[int, int],
    *,
    key: Array,
    radius: int = 5,
    tolerance: float = 0.1,
    picture: npt.ArrayLike | None = None,
    known: npt.ArrayLike | None = None,
    usable: npt.ArrayLike | None = None,
) -> Iterator[Step]:
    """`synthesise_efros_leung`, some pixels at a time: they are what steps count.

    The source maps are -1 where a pixel is known or not yet grown.

    Raises:
        ValueError: as `synthesise_efros_leung` does, at once.
    """
    if radius < 1:
        raise ValueError(f"radius {radius}: give 1 or more")
    if not tolerance >= 0:
        raise ValueError(f"tolerance {tolerance}: give 0 or more")
    shape = check_shape(shape)
    pixels, allowed = _check_pair("exemplar", exemplar, "usable", usable)
    if (picture is None) != (known is None):
        raise ValueError("picture and known go together: give both or neither")
    size = (*shape, pixels.shape[2])
    start, given = (
        (np.zeros(size, np.float32), np.zeros(shape, bool))
        if picture is None
        else _check_pair("picture", picture, "known", known)
    )
    if start.shape != size:
        raise ValueError(f"picture of shape {start.shape}: give {size}, this shape and the exemplar's channels")
    places = _whole_neighbourhoods(allowed, radius)
    taps, weights = _weigh(radius)
    steps = min(255, 2 * math.isqrt(_EXACT // (int(weights.sum()) * size[2])) - 1)
    levels = _quantise(pixels, steps)
    search = _make_search(levels, places, taps, weights, radius)
    return _grow(search, levels, _quantise(start, steps), given, key, radius, tolerance)


def _check_pair(
    name: str, picture: npt.ArrayLike, mask_name: str, mask: npt.ArrayLike | None
) -> tuple[npt.NDArray[np.float32], Mask]:
    """A picture, black where a mask leaves it out, and the mask."""
    pixels = np.asarray(picture, np.float32)
    within = np.ones(pixels.shape[:2], bool) if mask is None else np.asarray(mask)
    if within.shape != pixels.shape[:2] or within.dtype != np.bool_:
        raise ValueError(
            f"{mask_name} of shape {within.shape}, {within.dtype}: give bool {pixels.shape[:2]}, the {name}'s size"
        )
    if pixels.ndim == 3:
        pixels = np.where(within[..., None], pixels, 0)
    return check_picture(pixels, name), within


def _whole_neighbourhoods(usable: Mask, radius: int) -> npt.NDArray[np.int32]:
    """Centres of the neighbourhoods that are usable all over, [place, 2]."""
    side = 2 * radius + 1
    rows, columns = usable.shape
    if min(rows, columns) < side:
        raise ValueError(f"exemplar of {columns} x {rows} pixels: give at least {side} x {side}, the neighbourhood")
    whole = np.lib.stride_tricks.sliding_window_view(usable, (side, side)).all(axis=(-2, -1))
    if not whole.any():
        raise ValueError(f"usable: no {side} x {side} pixels of the exemplar are; give more, or a smaller radius")
    return (np.argwhere(whole) + radius).astype(np.int32)


def _weigh(radius: int) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """Which neighbours count, [tap, 2] from the neighbourhood's corner, and how much, as integers.

    As in the authors' own program, the Gaussian's deviation is the side by 6.4. It is next to nothing in the corners:
    they are left out. The pixels all around the middle always count.
    """
    row, column = np.indices((2 * radius + 1, 2 * radius + 1)) - radius
    deviation = (2 * radius + 1) / 6.4
    weights = np.rint(_HEAVIEST * np.exp(-(row**2 + column**2) / (2 * deviation**2))).astype(np.int32)
    weights = np.where(np.maximum(abs(row), abs(column)) == 1, np.maximum(weights, 1), weights)
    weights[radius, radius] = 0
    return np.argwhere(weights > 0).astype(np.int32), weights[weights > 0]


def _quantise(pixels: npt.NDArray[np.float32], steps: int) -> npt.NDArray[np.int32]:
    """Colours as integers around 0, so few that weighted sums of their squares are exact."""
    return np.rint(np.clip(pixels, 0, 1) * steps).astype(np.int32) - (steps + 1) // 2


def _make_search(
    levels: npt.NDArray[np.int32],
    places: npt.NDArray[np.int32],
    taps: npt.NDArray[np.int32],
    weights: npt.NDArray[np.int32],
    radius: int,
) -> _Search:
    around = places[:, None] - np.int32(radius) + taps
    colours = levels[around[..., 0], around[..., 1]].astype(np.float32)
    arrays = (
        places,
        levels[places[:, 0], places[:, 1]].astype(np.float32),
        colours.reshape(len(places), -1),
        np.sum(colours**2, axis=-1),
        taps,
        weights.astype(np.float32),
    )
    return _Search(*map(jnp.asarray, arrays))


def _grow(
    search: _Search,
    exemplar: npt.NDArray[np.int32],
    levels: npt.NDArray[np.int32],
    known: Mask,
    key: Array,
    radius: int,
    tolerance: float,
) -> Iterator[Step]:
    sources = np.full((*known.shape, 2), -1, np.int32)
    if not known.any():
        place = search.places[jax.random.randint(jax.random.fold_in(key, known.size), (), 0, len(search.places))]
        target, source = _plant(known.shape, np.asarray(place))
        levels, known = levels.copy(), known.copy()
        sources[*target.T], levels[*target.T], known[*target.T] = source, exemplar[*source.T], True
    canvas = np.concatenate([levels, known[..., None]], axis=-1).astype(np.float32)
    canvas = np.pad(canvas, [(radius, radius), (radius, radius), (0, 0)])
    growth = _Growth(jnp.asarray(canvas), jnp.asarray(sources))
    turns = schedule_pixels(known, radius)
    done, of = 0, known.size - int(known.sum())
    yield Step(done, of, sources)
    for first in range(0, len(turns), _STEPS):
        block = turns[first : first + _STEPS]
        steps = len(block)
        block = np.pad(block, [(0, _STEPS - steps), (0, 0), (0, 0)], constant_values=_NOWHERE)
        growth = _grow_block(search, growth, block, np.int32(steps), key, np.float32(tolerance))
        done += int(np.sum(block[..., 0] < _NOWHERE))
        yield Step(done, of, np.asarray(growth.sources))


def _plant(shape: tuple[int, ...], place: npt.NDArray[np.int32]) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """Where a seed comes to lie, and what of the exemplar it is: both [pixel, 2]."""
    steps = np.argwhere(np.ones((3, 3))).astype(np.int32) - 1
    target = steps + np.array(shape, np.int32) // 2
    inside = np.all((target >= 0) & (target < shape), axis=1)
    return target[inside], (steps + place)[inside]


def schedule_pixels(known: Mask, radius: int) -> npt.NDArray[np.int32]:
    """In which order pixels are grown: those of one turn together, none of which sees another.

    They come in layers around what is known. Within a layer, pixels whose row and column are the same modulo radius + 1
    do not see one another; of these classes, one comes after another in an order that is random, and always the same.

    Returns:
        (row, col), [turn, lane, 2], filled up with numbers beyond any picture.
    """
    side = radius + 1
    layer = distance_transform_cdt(~known, "chessboard")
    row, column = np.nonzero(~known)
    turn = np.random.default_rng(0).permutation(side**2)[row % side * side + column % side]
    rank = layer[row, column].astype(np.int64) * side**2 + turn
    order = np.argsort(rank, kind="stable")
    _, first, counts = np.unique(rank[order], return_index=True, return_counts=True)
    blocks = -(-counts // _LANES)
    within = np.arange(len(order)) - np.repeat(first, counts)
    before = np.repeat(np.cumsum(blocks) - blocks, counts)
    turns = np.full((int(blocks.sum()), _LANES, 2), _NOWHERE, np.int32)
    turns[before + within // _LANES, within % _LANES] = np.stack([row, column], axis=1)[order]
    return turns


@jax.jit
def _grow_block(search: _Search, growth: _Growth, turns: Array, count: Array, key: Array, tolerance: Array) -> _Growth:
    """The texture after some more turns."""
    rows, columns = growth.sources.shape[:2]
    border = [(whole - side) // 2 for whole, side in zip(growth.canvas.shape, (rows, columns), strict=False)]

    def grow(step: Array, growth: _Growth) -> _Growth:
        at = turns[step]
        seen = at[:, None] + search.taps[None]
        window = growth.canvas.at[seen[..., 0], seen[..., 1]].get(mode="clip")
        keys = jax.vmap(jax.random.fold_in, in_axes=(None, 0))(key, at[:, 0] * columns + at[:, 1])
        drawn = _draw_places(_differences(search, window), tolerance, keys)
        colours = jnp.pad(search.centres[drawn], [(0, 0), (0, 1)], constant_values=1)
        return _Growth(
            growth.canvas.at[at[:, 0] + border[0], at[:, 1] + border[1]].set(colours, mode="drop"),
            growth.sources.at[at[:, 0], at[:, 1]].set(search.places[drawn], mode="drop"),
        )

    return jax.lax.fori_loop(0, count, grow, growth)


def _differences(search: _Search, window: Array) -> Array:
    """Weighted squared differences, [lane, place], between what is known of windows [lane, tap, channel + 1] and the
    exemplar's neighbourhoods: integers, and exact, as every sum of floats stays below 2^24."""
    product = partial(jnp.matmul, precision=jax.lax.Precision.HIGHEST)
    colours = window[..., :-1]
    weights = search.weights[None] * window[..., -1]
    weighted = weights[..., None] * colours
    flat = weighted.reshape(len(window), -1)
    crossed = product(flat, search.colours.T).astype(jnp.int32)
    squares = product(weights, search.squares.T).astype(jnp.int32)
    own = jnp.sum((weighted * colours).astype(jnp.int32), axis=(1, 2))
    return squares - 2 * crossed + own[:, None]


def _draw_places(differences: Array, tolerance: Array, keys: Array) -> Array:
    """For each lane, a place drawn evenly from among those that differ little more than the best."""
    places = differences.shape[1]
    limit = (1 + tolerance) * jnp.min(differences, axis=1).astype(jnp.float32)
    near = differences.astype(jnp.float32) <= limit[:, None]
    runs = jnp.pad(near, [(0, 0), (0, -places % _RUN)]).reshape(len(near), -1, _RUN)
    until = jnp.cumsum(jnp.sum(runs, axis=2, dtype=jnp.int32), axis=1)

    def draw(runs: Array, until: Array, key: Array) -> Array:
        drawn = jax.random.randint(key, (), 0, until[-1])
        run = jnp.searchsorted(until, drawn, side="right")
        before = jnp.where(run > 0, until[run - 1], 0)
        return run * _RUN + jnp.argmax(jnp.cumsum(runs[run]) > drawn - before)

    return jax.vmap(draw)(runs, until, keys)
