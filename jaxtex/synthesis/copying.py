"""How much of a texture is copied, and in pieces of what size: to be shown beside every distance.

A texture made of an exemplar's pixels falls into coherent pieces, within which neighbours were neighbours in the
exemplar too. A source map tells them exactly. Where there is none, as of other programs' results, windows of the
texture are looked up in the exemplar: `find_windows` makes a source map of it, and `verbatim_share` counts what is
there.
"""

import math
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array
from scipy import ndimage

from jaxtex.synthesis.distances import check_pictures
from jaxtex.synthesis.sources import Sources

_BLOCK = 2048  # windows that are compared with as many others at a time

_MOST_NUMBERS = 1024  # in a window: sums of products of -128 to 127 are exact in float32 up to this


class Pieces(NamedTuple):
    """What coherent pieces a texture consists of.

    Attributes:
        number: how many there are.
        mean_size: pixels of a piece, in the mean over pieces.
        typical_size: pixels of the piece that a pixel belongs to, in the mean over pixels.
        large_share: share of the area, 0 to 1, in pieces of more than a number of pixels.
    """

    number: int
    mean_size: float
    typical_size: float
    large_share: float


def coherent_pieces(sources: npt.ArrayLike) -> npt.NDArray[np.int32]:
    """Number the coherent pieces of a texture.

    Two pixels side by side, or one above the other, continue one another if their sources lie so too. A piece is what
    hangs together by such steps.

    Args:
        sources: source map, integers [row, col, 2]: the exemplar's (row, col) of each pixel.

    Returns:
        Labels [row, col], from 0 in the order of rows.

    Raises:
        ValueError: a map of another form, or empty.

    Examples:
        >>> rows, columns = np.indices((3, 4))
        >>> coherent_pieces(np.stack([rows, columns % 2], axis=-1))
        array([[0, 0, 1, 1],
               [0, 0, 1, 1],
               [0, 0, 1, 1]], dtype=int32)
    """
    down, right = _continues(_check_sources(sources))
    # On a lattice twice as fine, pixels stand at even places and what joins two of them between.
    rows, columns = right.shape[0], down.shape[1]
    joined = np.zeros((2 * rows - 1, 2 * columns - 1), bool)
    joined[::2, ::2] = True
    joined[1::2, ::2] = down
    joined[::2, 1::2] = right
    labels: npt.NDArray[np.int32] = ndimage.label(joined, output=np.int32)[0][::2, ::2] - 1
    return labels


def seam_map(sources: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    """Where pieces end: whether a pixel does not continue the one above or the one to its left, [row, col].

    Raises:
        ValueError: as `coherent_pieces`.

    Examples:
        >>> rows, columns = np.indices((2, 4))
        >>> seam_map(np.stack([rows, columns % 2], axis=-1)).astype(int)
        array([[0, 0, 1, 0],
               [0, 0, 1, 0]])
    """
    down, right = _continues(_check_sources(sources))
    seams = np.zeros((right.shape[0], down.shape[1]), bool)
    seams[1:] |= ~down
    seams[:, 1:] |= ~right
    return seams


def measure_pieces(sources: npt.ArrayLike, *, large: int = 64) -> Pieces:
    """Measure the coherent pieces of a texture.

    Args:
        sources: source map, integers [row, col, 2].
        large: pieces of more pixels than this count as large.

    Raises:
        ValueError: as `coherent_pieces`.

    Examples:
        >>> rows, columns = np.indices((3, 4))
        >>> measure_pieces(np.stack([rows, columns % 3], axis=-1), large=3)
        Pieces(number=2, mean_size=6.0, typical_size=7.5, large_share=0.75)
    """
    sizes = np.bincount(coherent_pieces(sources).ravel()).astype(np.float64)
    area = sizes.sum()
    return Pieces(
        number=len(sizes),
        mean_size=float(area / len(sizes)),
        typical_size=float((sizes**2).sum() / area),
        large_share=float(sizes[sizes > large].sum() / area),
    )


def find_windows(
    exemplar: npt.ArrayLike, texture: npt.ArrayLike, *, window: int = 9, stride: int = 1
) -> tuple[Sources, npt.NDArray[np.float32]]:
    """Find, for each window of a texture, the exemplar's window that is most like it, by exhaustive search.

    Colours are compared as 8-bit numbers; values beyond 0 to 1 are clipped. Differences are exact wherever windows are
    nearly alike, and of equal ones the first in the order of rows is taken, so that results are the same every time.
    Memory is bounded; the time goes as the product of both pictures' pixels.

    Args:
        exemplar, texture: floats [row, col, channel], 0 to 1, with as many channels, of any sizes.
        window: side of the windows in pixels.
        stride: rows and columns from one window of the texture to the next.

    Returns:
        The upper left corners of the exemplar's windows, [row of windows, column of windows, 2], at a stride of 1 a
        source map; and the root mean square differences, [row of windows, column of windows].

    Raises:
        ValueError: arrays of another form or of different numbers of channels, NaN or infinite values; a window that
            does not fit both pictures or holds more than 1024 numbers, a stride below 1.

    Examples:
        >>> exemplar = np.random.default_rng(0).random((20, 24, 3))
        >>> sources, differences = find_windows(exemplar, exemplar[4:16, 7:18], window=5)
        >>> sources[0, 0].tolist(), float(differences.max())
        ([4, 7], 0.0)
    """
    pictures = check_pictures(exemplar, texture)
    side = min(*pictures[0].shape[:2], *pictures[1].shape[:2])
    if not 1 <= window <= side:
        raise ValueError(f"window of {window} pixels: give 1 to {side}, the smallest side of both pictures")
    numbers = window**2 * pictures[0].shape[2]
    if numbers > _MOST_NUMBERS:
        raise ValueError(f"window of {numbers} numbers: is too large to be compared exactly; at most {_MOST_NUMBERS}")
    if stride < 1:
        raise ValueError(f"stride {stride}: give 1 or more")
    levels = [jnp.asarray(np.rint(np.clip(each, 0, 1) * 255) - 128, jnp.float32) for each in pictures]
    places = _corners(pictures[0].shape, window, 1)
    wanted = _corners(pictures[1].shape, window, stride)
    # Filled up with the last one, which changes nothing.
    blocks = _fill_up(places, min(_BLOCK, len(places)))
    asked = _fill_up(wanted, min(_BLOCK, len(wanted)))
    found = [_nearest(levels[0], levels[1], jnp.asarray(blocks), jnp.asarray(each), window) for each in asked]
    index, squares = (np.concatenate([np.asarray(each[k]) for each in found])[: len(wanted)] for k in (0, 1))
    shape = tuple((each - window) // stride + 1 for each in pictures[1].shape[:2])
    differences = np.sqrt(squares / numbers) / 255
    return places[index].reshape(*shape, 2), differences.reshape(shape).astype(np.float32)


def verbatim_share(
    exemplar: npt.ArrayLike, texture: npt.ArrayLike, *, window: int = 9, tolerance: float = 0.0, stride: int = 4
) -> float:
    """The share of a texture's windows, 0 to 1, that stand in the exemplar as they are.

    Args:
        exemplar, texture: floats [row, col, channel], 0 to 1, with as many channels, of any sizes.
        window: side of the windows in pixels.
        tolerance: root mean square difference up to which a window counts as the same; at 0, all its 8-bit numbers are.
        stride: rows and columns from one window that is looked up to the next.

    Raises:
        ValueError: as `find_windows`; a negative tolerance.

    Examples:
        >>> random = np.random.default_rng(0)
        >>> exemplar = random.random((30, 30, 3))
        >>> half = np.concatenate([exemplar[:, :20], random.random((30, 20, 3))], axis=1)
        >>> round(verbatim_share(exemplar, half, stride=1), 3) == round(12 / 32, 3)
        True
    """
    if not tolerance >= 0:
        raise ValueError(f"tolerance {tolerance}: give 0 or more")
    _, differences = find_windows(exemplar, texture, window=window, stride=stride)
    return float(np.mean(differences <= tolerance))


def _check_sources(sources: npt.ArrayLike) -> npt.NDArray[np.int_]:
    array = np.asarray(sources)
    if array.ndim != 3 or array.shape[-1] != 2 or 0 in array.shape or array.dtype.kind not in "iu":
        raise ValueError(f"sources of shape {array.shape} and type {array.dtype}: give integers [row, col, 2]")
    return array.astype(np.int32, copy=False)


def _continues(sources: npt.NDArray[np.int_]) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Whether each pixel but the first row continues the one above; each but the first column, the one to its left."""
    down = (np.diff(sources, axis=0) == [1, 0]).all(axis=-1)
    right = (np.diff(sources, axis=1) == [0, 1]).all(axis=-1)
    return down, right


def _corners(shape: tuple[int, ...], window: int, stride: int) -> npt.NDArray[np.int32]:
    """Upper left corners of the windows of a picture, [window, 2]."""
    axes = [np.arange(0, side - window + 1, stride) for side in shape[:2]]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2).astype(np.int32)


def _fill_up(corners: npt.NDArray[np.int32], size: int) -> npt.NDArray[np.int32]:
    """Blocks [block, size, 2] of corners, the last one repeated."""
    count = math.ceil(len(corners) / size) * size
    return corners[np.minimum(np.arange(count), len(corners) - 1)].reshape(-1, size, 2)


@partial(jax.jit, static_argnums=4)
def _nearest(exemplar: Array, texture: Array, blocks: Array, asked: Array, window: int) -> tuple[Array, Array]:
    """For each of the texture's windows, [window, 2], the index of the nearest of the exemplar's, [block, window, 2],
    and the sum of squared differences."""

    def cut(picture: Array, corners: Array) -> Array:
        size = (window, window, picture.shape[2])
        return jax.vmap(lambda corner: jax.lax.dynamic_slice(picture, (*corner, 0), size).ravel())(corners)

    here = cut(texture, asked)
    here_squares = jnp.sum(here**2, axis=1)
    size = blocks.shape[1]

    def look(best: tuple[Array, Array], block: tuple[Array, Array]) -> tuple[tuple[Array, Array], None]:
        number, corners = block
        there = cut(exemplar, corners)
        products = jnp.matmul(here, there.T, precision=jax.lax.Precision.HIGHEST)
        # In this order nothing is rounded where windows are nearly alike.
        squares = (here_squares[:, None] - products) + (jnp.sum(there**2, axis=1)[None] - products)
        least = jnp.min(squares, axis=1)
        first = jnp.min(jnp.where(squares == least[:, None], jnp.arange(size)[None], size), axis=1)
        nearer = least < best[1]
        return (jnp.where(nearer, number * size + first, best[0]), jnp.where(nearer, least, best[1])), None

    nothing = (jnp.zeros(len(asked), jnp.int32), jnp.full(len(asked), jnp.inf))
    return jax.lax.scan(look, nothing, (jnp.arange(len(blocks)), blocks))[0]
