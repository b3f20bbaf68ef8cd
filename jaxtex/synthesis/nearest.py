"""Which places of an exemplar look alike: the candidates of k-coherent search.

X. Tong, J. Zhang, L. Liu, X. Wang, B. Guo and H.-Y. Shum, "Synthesis of bidirectional texture functions on arbitrary
surfaces", SIGGRAPH 2002, section 4: the similarity set of a place. Places of a set are kept apart, since those right
beside a place look like it and lead nowhere new.

Neighbourhoods are compared by their principal components, in whole numbers, so that the matrix products that all
distances are taken from are exact.
"""

from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array, lax

from jaxtex.synthesis.neighbourhoods import FARTHEST, check_exemplar, square_offsets

# Of natural textures, so many components keep nearly all variance. 16 * 3 * 512² is below 2^24: sums in float32 are
# exact.
_COMPONENTS = 16
_LARGEST = 512

_AT_ONCE = 2**22  # distances
_NOWHERE = np.float32(2**24)


class _Cells(eqx.Module):
    """Places in square cells, of which one place each is found. Cells that reach beyond the last place are filled up.

    Attributes:
        table: -2b for each component, and the sum of b², [member, cell, component + 1].
        row, column: [member, cell].
    """

    table: Array
    row: Array
    column: Array


def find_similar(exemplar: npt.ArrayLike, *, radius: int, count: int, apart: int | None = None) -> Array:
    """For each place of an exemplar, the places whose full square neighbourhoods are like its.

    The exemplar is divided into square cells with sides of `apart` pixels, each of which offers its most similar place.
    Of these the most similar are taken in turn, if they are at least `apart` rows or columns from the place itself and
    from those taken before.

    Time grows with the square of the exemplar's pixels: some seconds for 192 x 192.

    Args:
        exemplar: float [row, col, channel], values in an encoding whose steps look even.
        radius: neighbourhoods are squares of 2 radius + 1 pixels.
        count: places for each place, itself included.
        apart: pixels; radius + 1 unless given.

    Returns:
        int32 [row, col, count, 2], (row, col) of places whose neighbourhood is whole, itself first, then by
        similarity. Places whose own is not have those of the nearest one whose is. Where no place is left that is far
        enough from the others, the place itself stands again.

    Raises:
        ValueError: an exemplar smaller than a neighbourhood, values that are not finite, a count or distance below 1.

    Examples:
        >>> stripes = np.tile(np.array([0.1, 0.5, 0.9, 0.3]), (9, 3))[..., None]
        >>> find_similar(stripes, radius=1, count=2)[4, 1].tolist()
        [[4, 1], [1, 1]]
    """
    pixels = check_exemplar(exemplar, radius)
    apart = radius + 1 if apart is None else apart
    if count < 1:
        raise ValueError(f"count: {count} is too few; give at least 1, the place itself")
    if apart < 1:
        raise ValueError(f"apart: {apart} would find a place itself again; give at least 1")
    components = principal_neighbourhoods(pixels, radius)
    similar = _find(jnp.asarray(components), _divide(components, apart), count, apart) + radius
    around = [np.clip(np.arange(side) - radius, 0, side - 1 - 2 * radius) for side in pixels.shape[:2]]
    return similar[jnp.asarray(around[0])[:, None], jnp.asarray(around[1])[None]]


def principal_neighbourhoods(pixels: npt.NDArray[np.float32], radius: int) -> npt.NDArray[np.float32]:
    """The principal components of all whole neighbourhoods, at most 16, [row, col, component], as whole numbers below
    512 in magnitude, in one scale."""
    rows, columns = (side - 2 * radius for side in pixels.shape[:2])
    offsets = square_offsets(radius) + radius
    seen = np.concatenate([pixels[y : y + rows, x : x + columns] for y, x in offsets], axis=-1).astype(np.float64)
    centred = (seen - seen.mean(axis=(0, 1))).reshape(rows * columns, -1)
    _, axes = np.linalg.eigh(centred.T @ centred)
    components = centred @ axes[:, ::-1][:, :_COMPONENTS]
    largest = np.abs(components).max()
    scaled = components * ((_LARGEST - 1) / largest if largest > 0 else 0.0)
    return np.round(scaled).astype(np.float32).reshape(rows, columns, -1)


def _divide(components: npt.NDArray[np.float32], apart: int) -> _Cells:
    rows, columns = components.shape[:2]
    table = np.concatenate([-2 * components, np.square(components).sum(axis=2, keepdims=True)], axis=2)
    down, right = -(-rows // apart), -(-columns // apart)
    filled = np.pad(table, [(0, down * apart - rows), (0, right * apart - columns), (0, 0)])
    filled[rows:, :, -1] = filled[:, columns:, -1] = _NOWHERE
    numbers = np.meshgrid(np.arange(down * apart), np.arange(right * apart), indexing="ij")

    def by_cells(picture: npt.NDArray) -> Array:
        cells = picture.reshape(down, apart, right, apart, -1).transpose(1, 3, 0, 2, 4)
        return jnp.asarray(cells.reshape(apart * apart, down * right, -1))

    row, column = (by_cells(each.astype(np.int32))[..., 0] for each in numbers)
    return _Cells(by_cells(filled), row, column)


@partial(jax.jit, static_argnames=("count", "apart"))
def _find(components: Array, cells: _Cells, count: int, apart: int) -> Array:
    """Similar places [row, col, count, 2] of all places [row, col]."""
    rows, columns, _ = components.shape
    members, number, _ = cells.table.shape
    block = max(_AT_ONCE // (members * number), 1)

    def one_block(places: Array) -> Array:
        row, column = jnp.divmod(places, columns)
        query = components.reshape(rows * columns, -1)[places]
        query = jnp.concatenate([query, jnp.ones((len(places), 1))], axis=1)
        score = jnp.matmul(query, cells.table.reshape(members * number, -1).T, precision=lax.Precision.HIGHEST)
        score = score.reshape(len(places), members, number)
        least = jnp.min(score, axis=1)
        member = jnp.min(jnp.where(score == least[:, None], jnp.arange(members)[None, :, None], members), axis=1)
        return _take_in_turn(cells, row, column, least, member, count, apart)

    blocks = -(-rows * columns // block)
    numbers = jnp.minimum(jnp.arange(blocks * block), rows * columns - 1).reshape(blocks, block)
    return (
        lax.map(one_block, numbers).reshape(blocks * block, count, 2)[: rows * columns].reshape(rows, columns, count, 2)
    )


def _take_in_turn(
    cells: _Cells, row: Array, column: Array, least: Array, member: Array, count: int, apart: int
) -> Array:
    """The places that one block of queries at (row, column) finds, [query, count, 2].

    Args:
        least: distances of what the cells offer, [query, cell].
        member: which of their members that is, [query, cell].
    """
    cell = jnp.arange(least.shape[1])
    offered = cells.row[member, cell[None]], cells.column[member, cell[None]]

    def take(left: Array, _: None) -> tuple[Array, Array]:
        best = jnp.min(left, axis=1)
        chosen = jnp.min(jnp.where(left == best[:, None], cell[None], FARTHEST), axis=1)[:, None]
        there = [jnp.take_along_axis(each, chosen, axis=1)[:, 0] for each in offered]
        to_row, to_column = (
            jnp.where(best < _NOWHERE, each, own) for each, own in zip(there, (row, column), strict=True)
        )
        return _keep_apart(left, offered, to_row, to_column, apart), jnp.stack([to_row, to_column], axis=1)

    left = _keep_apart(least, offered, row, column, apart)
    _, others = lax.scan(take, left, None, length=count - 1)
    return jnp.concatenate([jnp.stack([row, column], axis=1)[:, None], jnp.moveaxis(others, 0, 1)], axis=1)


def _keep_apart(left: Array, offered: tuple[Array, Array], row: Array, column: Array, apart: int) -> Array:
    near = (jnp.abs(offered[0] - row[:, None]) < apart) & (jnp.abs(offered[1] - column[:, None]) < apart)
    return jnp.where(near, _NOWHERE, left)
