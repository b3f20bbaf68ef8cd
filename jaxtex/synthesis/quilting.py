"""Image quilting: A. A. Efros and W. T. Freeman, "Image quilting for texture synthesis and transfer", SIGGRAPH 2001.

Square blocks of the exemplar are laid in raster order so that they overlap. Each is drawn from among those places of
the exemplar that fit well to what lies there already, and is cut along the path through the overlap on which the two
differ least. Things smaller than a block stay whole, and large areas are copied as they stand.

Departures from the paper: where two or more cuts meet, a pixel is the new block's if each of them says so; textures can
repeat seamlessly, by having the last blocks of each row and column fit to the first ones too.
"""

import math
from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.synthesis.neighbourhoods import check_picture, check_shape, quantise
from jaxtex.synthesis.sources import Sources, Step, last_of

# Numbers of a block, at most: sums of their squared differences are below 2^31, and rounding errors of correlations,
# which were at most 0.4 for noise of black and white, below a half.
_LARGEST = 2**15


class _Exemplar(eqx.Module):
    """An exemplar, ready to be searched.

    Attributes:
        levels: its colours as integers of 8 bits, -128 to 127, [row, col, channel].
        squares: sums of their squares over all rows and columns before one, modulo 2^32, [row, col].
        spectra: Fourier transforms of overlapping windows of it, [window row, window col, channel, row, col].
    """

    levels: Array
    squares: Array
    spectra: Array


class _Layout(NamedTuple):
    """Where blocks lie: their (rows, columns), the overlap of each with the next, the first row and column of each, and
    the (rows, columns) of what they cover together."""

    block: tuple[int, int]
    overlap: int
    tops: npt.NDArray[np.int_]
    lefts: npt.NDArray[np.int_]
    covered: tuple[int, int]


def synthesise_quilting(
    exemplar: npt.ArrayLike,
    shape: tuple[int, int],
    *,
    key: Array,
    block: int | None = None,
    overlap: int | None = None,
    tolerance: float = 0.1,
    tileable: bool = False,
) -> Sources:
    """Make a texture of blocks of an exemplar.

    Args:
        exemplar: floats [row, col, channel], 0 to 1 (what lies beyond is clipped), in an encoding whose steps look
            even. Any number of channels.
        shape: (rows, columns) of the texture, any.
        key: random key; another key, another piece of the same texture.
        block: side of a block in pixels: larger than the texture's largest features, and at most 104 of 3 channels,
            (2^15 / channels)^1/2 in general. As it is not said, a quarter of the exemplar's smaller side, or the
            largest there can be.
        overlap: of neighbouring blocks, in pixels, at most half a block. As it is not said, a sixth of a block.
        tolerance: blocks are drawn from among those whose squared difference from what they overlap is at most
            1 + tolerance times the least.
        tileable: whether the texture is to repeat seamlessly. Blocks are then made somewhat smaller where that is
            needed for a whole number of them.

    Returns:
        The source map, [row, col, 2]: which (row, col) of the exemplar each pixel is copied from.

    Raises:
        ValueError: an exemplar of another form, of fewer than 2 x 2 pixels, or with NaN or infinite values; an empty
            shape, or a tileable one of one row or column; a block larger than the exemplar or than said; an overlap
            of no pixel or of more than half a block; a negative tolerance.

    Examples:
        >>> exemplar = np.random.default_rng(0).random((32, 32, 3))
        >>> sources = synthesise_quilting(exemplar, (40, 60), key=jax.random.key(0), block=12)
        >>> sources.shape
        (40, 60, 2)
    """
    return last_of(
        quilting_steps(exemplar, shape, key=key, block=block, overlap=overlap, tolerance=tolerance, tileable=tileable)
    )


def quilting_steps(
    exemplar: npt.ArrayLike,
    shape: tuple[int, int],
    *,
    key: Array,
    block: int | None = None,
    overlap: int | None = None,
    tolerance: float = 0.1,
    tileable: bool = False,
) -> Iterator[Step]:
    """`synthesise_quilting`, row of blocks by row of blocks. The source maps are -1 where nothing lies yet.

    Raises:
        ValueError: as `synthesise_quilting` does, at once.
    """
    pixels, shape = check_picture(exemplar, "exemplar"), check_shape(shape)
    if min(pixels.shape[:2]) < 2:
        raise ValueError(f"exemplar of {pixels.shape[1]} x {pixels.shape[0]} pixels: give at least 2 x 2")
    if tileable and min(shape) < 2:
        raise ValueError(f"shape: {shape} cannot be tileable; give at least 2 rows and columns")
    if not tolerance >= 0:
        raise ValueError(f"tolerance {tolerance}: give 0 or more")
    side = min(*pixels.shape[:2], math.isqrt(_LARGEST // pixels.shape[2]))
    block = min(side, max(2, min(pixels.shape[:2]) // 4)) if block is None else block
    overlap = max(1, block // 6) if overlap is None else overlap
    if not 2 <= block <= side:
        raise ValueError(f"block of {block} pixels: give 2 to {side}, of this exemplar")
    if not 1 <= overlap <= block // 2:
        raise ValueError(f"overlap of {overlap} pixels: give 1 to {block // 2}, half a block")
    layout = _lay_out(shape, block, overlap, tileable)
    return _quilt(pixels, shape, layout, key, tolerance, tileable)


def _lay_out(shape: tuple[int, int], block: int, overlap: int, tileable: bool) -> _Layout:
    if not tileable:
        counts = [max(1, -(-(side - overlap) // (block - overlap))) for side in shape]
        tops, lefts = (np.arange(count) * (block - overlap) for count in counts)
        rows, columns = (count * (block - overlap) + overlap for count in counts)
        return _Layout((block, block), overlap, tops, lefts, (rows, columns))
    counts = [max(2, -(-side // (block - overlap))) for side in shape]
    # Steps differ by one pixel where blocks do not come out even; the last is one of the longest.
    tops, lefts = (np.arange(count) * side // count for count, side in zip(counts, shape, strict=True))
    steps = [-(-side // count) for count, side in zip(counts, shape, strict=True)]
    overlap = min(overlap, *(side - step for side, step in zip(shape, steps, strict=True)))
    return _Layout((steps[0] + overlap, steps[1] + overlap), overlap, tops, lefts, shape)


def _quilt(
    pixels: npt.NDArray[np.float32],
    shape: tuple[int, int],
    layout: _Layout,
    key: Array,
    tolerance: float,
    tileable: bool,
) -> Iterator[Step]:
    exemplar = _prepare(jnp.asarray(quantise(pixels).astype(np.int32) - 128), layout.block)
    sources = jnp.full((*layout.covered, 2), -1, jnp.int32)
    columns = np.arange(len(layout.lefts))
    last = len(layout.tops) - 1
    for row, top in enumerate(layout.tops):
        corners = np.stack([np.full_like(columns, top), layout.lefts], axis=1)
        # Which sides lie on something: above, below, left, right.
        above, below = np.full_like(columns, row > 0), np.full_like(columns, tileable and row == last)
        sides = np.stack([above, below, columns > 0, tileable & (columns == columns[-1])], axis=1).astype(bool)
        keys = jax.vmap(partial(jax.random.fold_in, key))(row * len(columns) + columns)
        sources = _lay_row(
            exemplar, sources, corners, sides, keys, np.float32(tolerance), block=layout.block, overlap=layout.overlap
        )
        yield Step(row + 1, last + 1, np.asarray(sources)[: shape[0], : shape[1]])


@partial(jax.jit, static_argnames="block")
def _prepare(levels: Array, block: tuple[int, int]) -> _Exemplar:
    squares = jnp.sum(levels * levels, axis=-1)
    squares = jnp.pad(jnp.cumsum(jnp.cumsum(squares, axis=0), axis=1), [(1, 0), (1, 0)])
    rows, columns = levels.shape[:2]
    side = _window_side(levels.shape, block)
    row, column = (np.arange(0, n - b + 1, side - b + 1) for n, b in zip((rows, columns), block, strict=True))
    padded = jnp.pad(levels, [(0, side), (0, side), (0, 0)])
    within = np.arange(side)
    windows = padded[
        (row[:, None] + within)[:, None, :, None], (column[:, None] + within)[None, :, None, :]
    ]  # [window row, window col, row, col, channel]
    high, low = _split(jnp.moveaxis(windows, -1, 2))
    return _Exemplar(levels, squares, jnp.fft.fft2(jax.lax.complex(high, low)))


def _window_side(shape: tuple[int, ...], block: tuple[int, int]) -> int:
    """Side of the windows that Fourier transforms are taken of: a power of two of about four blocks, so that their
    rounding errors do not grow with the exemplar."""
    return 1 << (min(4 * max(block), max(shape[:2])) - 1).bit_length()


def _split(levels: Array) -> tuple[Array, Array]:
    """Integers -128 to 127 as 16 high + low, both within -8 to 8."""
    high = (levels + 8) >> 4
    return high.astype(jnp.float32), (levels - 16 * high).astype(jnp.float32)


@partial(jax.jit, static_argnames=("block", "overlap"))
def _lay_row(
    exemplar: _Exemplar,
    sources: Array,
    corners: Array,
    sides: Array,
    keys: Array,
    tolerance: Array,
    block: tuple[int, int],
    overlap: int,
) -> Array:
    """The source map with some more blocks on it, laid one after another."""
    rows, columns = jnp.indices(block)
    covered = jnp.array(sources.shape[:2])

    def lay(sources: Array, each: tuple[Array, Array, Array]) -> tuple[Array, None]:
        corner, on, key = each
        row, column = (rows + corner[0]) % covered[0], (columns + corner[1]) % covered[1]
        under = sources[row, column]
        seen = exemplar.levels[under[..., 0], under[..., 1]]
        place = _draw_place(_differences(exemplar, seen, on, overlap), tolerance, key)
        source = jnp.stack([rows, columns], axis=-1) + place[None, None]
        new = exemplar.levels[source[..., 0], source[..., 1]]
        cut = _cut_block(jnp.sum((new - seen) ** 2, axis=-1), on, overlap)
        return sources.at[row, column].set(jnp.where(cut[..., None], source, under)), None

    return jax.lax.scan(lay, sources, (corners, sides, keys))[0]


def _differences(exemplar: _Exemplar, seen: Array, on: Array, overlap: int) -> Array:
    """Squared differences, summed over the overlaps, between what lies there and a block from each place of the
    exemplar: exact integers, [row, col]."""
    rows, columns = seen.shape[:2]
    top, left = jnp.where(on[0], overlap, 0), jnp.where(on[2], overlap, 0)
    bottom, right = rows - jnp.where(on[1], overlap, 0), columns - jnp.where(on[3], overlap, 0)
    row, column = jnp.indices((rows, columns))
    inside = (row >= top) & (row < bottom) & (column >= left) & (column < right)
    seen = jnp.where(inside[..., None], 0, seen)
    places = exemplar.levels.shape[0] - rows + 1, exemplar.levels.shape[1] - columns + 1

    def box(top: Array | int, bottom: Array | int, left: Array | int, right: Array | int) -> Array:
        """Sums of squares over a part of each block."""
        corner = partial(jax.lax.dynamic_slice, exemplar.squares, slice_sizes=places)
        return corner((bottom, right)) - corner((top, right)) - corner((bottom, left)) + corner((top, left))

    squares = box(0, rows, 0, columns) - box(top, bottom, left, right)
    return squares - 2 * _correlate(exemplar, seen, places) + jnp.sum(seen * seen)


def _correlate(exemplar: _Exemplar, block: Array, places: tuple[int, int]) -> Array:
    """Sums of products of a block with the exemplar at each place, [row, col].

    Fourier transforms in single precision are too coarse for sums of products of 8 bits; of those of 4 bits their
    errors are below a half, and rounding makes them exact.
    """
    side = exemplar.spectra.shape[-1]
    digits = jnp.stack(_split(jnp.moveaxis(block, -1, 0)))
    spectra = jnp.conj(jnp.fft.fft2(digits, s=(side, side)))
    products = jnp.fft.ifft2(jnp.einsum("ijcuv,dcuv->dijuv", exemplar.spectra, spectra))
    high, low = jnp.rint(products.real).astype(jnp.int32), jnp.rint(products.imag).astype(jnp.int32)
    sums = 256 * high[0] + 16 * (high[1] + low[0]) + low[1]
    steps = (side - block.shape[0] + 1, side - block.shape[1] + 1)
    sums = jnp.swapaxes(sums[..., : steps[0], : steps[1]], 1, 2)
    joined = sums.reshape(sums.shape[0] * steps[0], sums.shape[2] * steps[1])
    return joined[: places[0], : places[1]]


def _draw_place(differences: Array, tolerance: Array, key: Array) -> Array:
    """(row, col) of a place drawn evenly from among those that differ little more than the best."""
    limit = (1 + tolerance) * jnp.min(differences).astype(jnp.float32)
    near = jnp.cumsum((differences.astype(jnp.float32) <= limit).ravel())
    drawn = jax.random.randint(key, (), 0, near[-1])
    return jnp.stack(jnp.divmod(jnp.searchsorted(near, drawn, side="right"), differences.shape[1])).astype(jnp.int32)


def _cut_block(errors: Array, on: Array, overlap: int) -> Array:
    """Which pixels of a block to lay, of squared differences [row, col] from what it lies on."""

    def beyond(errors: Array) -> Array:
        """Those from the cut through the leftmost columns on."""
        cut = minimum_cut(errors[:, :overlap])
        return jnp.arange(errors.shape[1])[None] >= cut[:, None]

    above = beyond(errors.T).T
    below = jnp.flipud(beyond(jnp.flipud(errors).T).T)
    left = beyond(errors)
    right = jnp.fliplr(beyond(jnp.fliplr(errors)))
    cuts = jnp.stack([above, below, left, right])
    return jnp.all(cuts | ~on[:, None, None], axis=0)


def minimum_cut(errors: Array) -> Array:
    """The path from the first row to the last on which errors [row, col] sum to the least, moving by at most one column
    from row to row: the column in each row, found by dynamic programming.

    Examples:
        >>> minimum_cut(jnp.array([[5, 1, 4], [1, 4, 4], [3, 2, 3]])).tolist()
        [1, 0, 1]
    """
    beyond = jnp.full(1, jnp.iinfo(errors.dtype).max)

    def down(sums: Array, row: Array) -> tuple[Array, Array]:
        before = jnp.stack([jnp.concatenate([beyond, sums[:-1]]), sums, jnp.concatenate([sums[1:], beyond])])
        return row + jnp.min(before, axis=0), jnp.argmin(before, axis=0) - 1

    def up(column: Array, moves: Array) -> tuple[Array, Array]:
        return column + moves[column], column

    sums, moves = jax.lax.scan(down, errors[0], errors[1:])
    first, others = jax.lax.scan(up, jnp.argmin(sums), moves, reverse=True)
    return jnp.concatenate([first[None], others])
