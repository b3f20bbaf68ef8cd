"""Texture synthesis by exhaustive search: L.-Y. Wei and M. Levoy, "Fast texture synthesis using tree-structured vector
quantization", SIGGRAPH 2000.

Pixels are made in scanline order. Each is copied from that place of the whole exemplar whose neighbourhood is most like
what is there already; with several levels, from coarse to fine, also most like the level before. That does well for
smooth textures, and blurs what has edges.

The search of a wavefront is one matrix product. All its terms are whole numbers, and every sum of them is below 2^24,
so that float32 holds them exactly, in whatever order they are summed.

Departures from the paper: neighbours beyond the border are left out, where the paper wraps around it; the output starts
from nothing but the first pixel's random place, where the paper's holds noise.
"""

from collections.abc import Iterator
from functools import partial
from typing import Literal

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.synthesis.neighbourhoods import (
    FARTHEST,
    Shape,
    causal_taps,
    check_exemplar,
    check_shape,
    draw_bits,
    draw_place,
    pack_colours,
    pass_seed,
    pixel_bits,
    quantise,
    square_offsets,
)
from jaxtex.synthesis.sources import Sources, Step, last_of, magnify_places
from jaxtex.synthesis.wavefront import Canvas, Wavefronts
from jaxtex.synthesis.wei_levoy_tree import Tree, grow_tree

_EXACT = 2**24  # float32 holds all whole numbers up to here

_BINOMIAL = np.array([1, 4, 6, 4, 1], np.float32) / 16

Search = Literal["full", "tree"]


class _Level(eqx.Module):
    """An exemplar at one resolution, ready to be searched.

    Attributes:
        colours: one word after another, each [place].
        places: those whose neighbourhood is whole, [candidate].
        table: of these, for each component of the neighbourhood -2b, then for each tap the sum of its b², [candidate,
            component and tap]; absent where there is a tree.
        tree: of the neighbourhoods' components b.
        shift: bits that colours are coarsened by, so that sums stay exact.
    """

    colours: tuple[Array, ...]
    places: Array
    table: Array | None
    tree: Tree | None
    shape: Shape = eqx.field(static=True)
    channels: int = eqx.field(static=True)
    radius: int = eqx.field(static=True)
    shift: int = eqx.field(static=True)


class _Parent(eqx.Module):
    """The output at half the resolution, one word after another, each [row, col]."""

    colours: tuple[Array, ...]


def synthesise_wei_levoy(
    exemplar: npt.ArrayLike,
    shape: Shape,
    *,
    key: Array,
    radius: int = 4,
    levels: int = 1,
    search: Search = "full",
) -> Sources:
    """Make a texture like an exemplar, pixel by pixel in scanline order, by the most similar neighbourhood.

    The result of the full search is that of a loop over rows and columns, bit for bit; of places that are equally
    similar, the first is taken.

    Args:
        exemplar: float [row, col, channel], values 0..1 in an encoding whose steps look even; compared in 8 bits, or in
            fewer where neighbourhoods have more than 341 components (causal pixels and channels, and the parent's).
        shape: (rows, columns) of the output.
        key: random key.
        radius: neighbourhoods are the causal halves of squares of 2 radius + 1 pixels.
        levels: of a Gaussian pyramid. Each level is compared with itself and with a full square of half the radius,
            rounded down, of the next coarser one.
        search: "full", or "tree" for the paper's tree-structured vector quantisation: many times faster for large
            exemplars, and not always the most similar neighbourhood.

    Returns:
        The source map: the (row, col) of the exemplar that each pixel is copied from, int32 [row, col, 2].

    Raises:
        ValueError: an exemplar smaller than a neighbourhood at its coarsest level, values that are not finite, an
            empty output, no level, an unknown search.

    Examples:
        >>> exemplar = np.random.default_rng(0).random((16, 16, 3))
        >>> synthesise_wei_levoy(exemplar, (8, 10), key=jax.random.key(0), radius=2).shape
        (8, 10, 2)
    """
    return last_of(wei_levoy_steps(exemplar, shape, key=key, radius=radius, levels=levels, search=search))


def wei_levoy_steps(
    exemplar: npt.ArrayLike,
    shape: Shape,
    *,
    key: Array,
    radius: int = 4,
    levels: int = 1,
    search: Search = "full",
) -> Iterator[Step]:
    """`synthesise_wei_levoy`, level by level, from coarse to fine.

    Raises:
        ValueError: as `synthesise_wei_levoy` does, at once.
    """
    if levels < 1:
        raise ValueError(f"levels: {levels} are too few; give at least 1")
    if search not in ("full", "tree"):
        raise ValueError(f"search: {search!r} is unknown; give 'full' or 'tree'")
    pyramid, sizes = [check_exemplar(exemplar, radius)], [check_shape(shape)]
    for _ in range(levels - 1):
        pyramid.append(check_exemplar(halve(pyramid[-1]), radius))
        sizes.append((-(-sizes[-1][0] // 2), -(-sizes[-1][1] // 2)))
    return _climb(pyramid, sizes, key, radius, search)


def _climb(
    pyramid: list[npt.NDArray[np.float32]], sizes: list[Shape], key: Array, radius: int, search: Search
) -> Iterator[Step]:
    parent, levels = None, len(pyramid)
    for level in reversed(range(levels)):
        above = pyramid[level + 1] if level + 1 < levels else None
        prepared = _prepare(pyramid[level], above, radius, search)
        places = _scan(prepared, parent, pass_seed(key, level), sizes[level])
        parent = _Parent(tuple(each[places] for each in prepared.colours))
        whole = pyramid[0].shape[:2]
        sources = magnify_places(np.asarray(places), prepared.shape[1], level, sizes[0], (whole[0], whole[1]))
        yield Step(levels - level, levels, sources)


def halve(picture: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """The next level of a Gaussian pyramid: every other pixel of the blurred picture (P. J. Burt and E. H. Adelson,
    1983, with their 5-tap binomial filter), which is reflected at its borders."""
    for axis in (0, 1):
        around = [(2, 2) if each == axis else (0, 0) for each in range(3)]
        padded = np.moveaxis(np.pad(picture, around, mode="symmetric"), axis, 0)
        count = picture.shape[axis]
        shifted = np.stack([padded[at : at + count : 2] for at in range(5)], axis=-1)
        picture = np.moveaxis(shifted @ _BINOMIAL, 0, axis).astype(np.float32)
    return picture


def coarsening(components: int) -> int:
    """By how many bits 8-bit colours are coarsened so that distances of so many components are exact.

    Sums are of terms m b² - 2 m a b with a and b from -128 to 127, coarsened; their magnitudes add up to less than 3 *
    128² for each component.

    Examples:
        >>> coarsening(341), coarsening(342)
        (0, 1)
    """
    shift = 0
    while components * 3 * (128 >> shift) ** 2 >= _EXACT:
        shift += 1
    return shift


def _prepare(
    pixels: npt.NDArray[np.float32], above: npt.NDArray[np.float32] | None, radius: int, search: Search
) -> _Level:
    (rows, columns), channels = pixels.shape[:2], pixels.shape[2]
    row, column = np.mgrid[radius : rows - radius, radius : columns - radius].reshape(2, -1)
    levels = quantise(pixels)
    seen = [_squares(levels, row, column, square_offsets(radius)[: causal_taps(radius)])]
    if above is not None:
        seen.append(_squares(quantise(above), row // 2, column // 2, square_offsets(radius // 2)))
    neighbourhoods = np.concatenate(seen, axis=1)
    shift = coarsening(neighbourhoods[0].size)
    centred = (neighbourhoods >> shift).astype(np.int32) - (128 >> shift)
    flat = centred.reshape(len(centred), -1)
    table = np.concatenate([-2 * flat, np.square(centred).sum(axis=2)], axis=1).astype(np.float32)
    return _Level(
        colours=tuple(jnp.asarray(each.reshape(-1)) for each in pack_colours(levels)),
        places=jnp.asarray(row * columns + column, jnp.int32),
        table=jnp.asarray(table) if search == "full" else None,
        tree=grow_tree(flat) if search == "tree" else None,
        shape=(rows, columns), channels=channels, radius=radius, shift=shift,
    )  # fmt: skip


def _squares(
    levels: npt.NDArray[np.uint8],
    row: npt.NDArray[np.int_],
    column: npt.NDArray[np.int_],
    offsets: npt.NDArray[np.int32],
) -> npt.NDArray[np.uint8]:
    """Neighbourhoods [place, tap, channel]."""
    return levels[row[:, None] + offsets[:, 0], column[:, None] + offsets[:, 1]]


@partial(jax.jit, static_argnames="shape")
def _scan(level: _Level, parent: _Parent | None, seed: Array, shape: Shape) -> Array:
    """Places [row, col] of one level."""
    radius, causal = level.radius, causal_taps(level.radius)
    fronts = Wavefronts((shape[0] + 2 * radius, shape[1] + 2 * radius), radius)
    offsets = square_offsets(radius)[: causal + 1]

    def compute(starts: Array, row: Array, column: Array, state: Canvas) -> Canvas:
        weight = fronts.read(state.places, starts)[:causal] >= 0
        seen = [fronts.read(each, starts)[:causal] for each in state.colours]
        if parent is not None:
            inside, above = _look_above(parent, row // 2, column // 2, radius // 2)
            weight = jnp.concatenate([weight, inside])
            seen = [jnp.concatenate(pair) for pair in zip(seen, above, strict=True)]
        best = level.places[_search(level, _unpack(level, seen), weight)]
        first = draw_place(draw_bits(pixel_bits(seed, row * shape[1] + column), 0), level.shape, radius)
        best = jnp.where(jnp.any(weight, axis=0), best, first)
        return state.write(starts[causal], jnp.where(row >= 0, best, -1), level.colours)

    return fronts.unskew(fronts.run(compute, Canvas.begin(fronts, None, level.colours), offsets).places)


def _look_above(parent: _Parent, row: Array, column: Array, radius: int) -> tuple[Array, list[Array]]:
    """Which pixels of the parent's neighbourhoods there are, and their colours, word by word, [tap, lane]."""
    rows, columns = parent.colours[0].shape
    offsets = square_offsets(radius)
    row, column = row[None] + offsets[:, :1], column[None] + offsets[:, 1:]
    inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
    return inside, [each[jnp.clip(row, 0, rows - 1), jnp.clip(column, 0, columns - 1)] for each in parent.colours]


def _unpack(level: _Level, words: list[Array]) -> Array:
    """Centred, coarsened colours [tap, channel, lane]."""
    channels = [((words[each // 4] >> (8 * (each % 4))) & 0xFF).astype(jnp.int32) for each in range(level.channels)]
    return (jnp.stack(channels, axis=1) >> level.shift) - (128 >> level.shift)


def _search(level: _Level, colours: Array, weight: Array) -> Array:
    """The candidate most like each lane's neighbourhood; of several, the first.

    Args:
        colours: [tap, channel, lane].
        weight: boolean [tap, lane].
    """
    taps, channels, lanes = colours.shape
    kept = jnp.where(weight[:, None], colours, 0).reshape(taps * channels, lanes)
    if level.tree is not None:
        return level.tree.descend(kept.T, jnp.repeat(weight, channels, axis=0).T)
    assert level.table is not None
    query = jnp.concatenate([kept, weight.astype(jnp.int32)]).astype(jnp.float32)
    score = jnp.matmul(query.T, level.table.T, precision=jax.lax.Precision.HIGHEST)
    # As two reductions, which are vectorised where argmin is not.
    nearest = score == jnp.min(score, axis=1)[:, None]
    return jnp.min(jnp.where(nearest, jnp.arange(len(level.table))[None], FARTHEST), axis=1)
