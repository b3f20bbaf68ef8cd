"""Histogram matching: values are moved, in order, so that they come to be distributed as others are.

A distribution is a table of quantiles. Values are ranked by counting them at knots, which takes a fraction of the time
of sorting and is exact where they lie further apart than knots do; between knots, values are moved linearly.
"""

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

QUANTILES = 512
"""Quantiles in a table, where nothing else is said."""

_KNOTS = 2049


def quantile_table(values: npt.ArrayLike, *, count: int = QUANTILES) -> npt.NDArray[np.float32]:
    """The quantiles of values at the probabilities (1 - cos(pi k / (count - 1))) / 2, k = 0 to count - 1.

    These are dense where p is near 0 and 1: sub-bands of pictures have long tails, and with evenly spaced probabilities
    the last step would reach from the last but one quantile to the largest value of all.

    Args:
        values: [..., n], n >= 1; each row is a distribution of its own.
        count: quantiles to a table, at least 2.

    Returns:
        [..., count], ascending: from the smallest value to the largest.

    Raises:
        ValueError: no values, or `count` below 2.

    Examples:
        >>> quantile_table([3.0, 1.0, 2.0], count=3)
        array([1., 2., 3.], dtype=float32)
    """
    ascending = np.sort(np.asarray(values, np.float32), axis=-1)
    if count < 2 or ascending.shape[-1] < 1:
        raise ValueError(f"{count} quantiles of {ascending.shape[-1]} values: give at least 2 of at least 1")
    probability = 0.5 - 0.5 * np.cos(np.pi * np.arange(count) / (count - 1))
    place = probability * (ascending.shape[-1] - 1)
    below = np.minimum(place.astype(int), max(ascending.shape[-1] - 2, 0))
    above = np.minimum(below + 1, ascending.shape[-1] - 1)
    share = (place - below).astype(np.float32)
    # In this form, equal neighbours give themselves, bit for bit, and the table cannot descend.
    return ascending[..., below] + share * (ascending[..., above] - ascending[..., below])


@jax.jit
def match_histogram(values: Array, table: Array) -> Array:
    """Move values so that they are distributed as a table of quantiles says.

    The map is continuous and never descends; the smallest value becomes the first entry of the table and the largest
    the last.

    Args:
        values: float array of any shape; all of it is one distribution. Values that are all equal become the
            table's median.
        table: of `quantile_table`, [count].

    Examples:
        >>> table = jnp.asarray(quantile_table(np.linspace(0, 1, 1001) ** 2))
        >>> moved = match_histogram(jnp.linspace(-5, 5, 10_001), table)
        >>> moved[::2500].round(2)
        Array([0.  , 0.06, 0.25, 0.56, 1.  ], dtype=float32)
    """
    place = _place(values.ravel())
    below = jnp.minimum(place.astype(jnp.int32), _KNOTS - 2)
    share = place - below
    # Each value counts at the two knots around it, as linear interpolation would have it: where it lies between them
    # does not change its own rank, and its rank is continuous in all values.
    counts = jnp.zeros(_KNOTS, values.dtype).at[below].add(1 - share).at[below + 1].add(share)
    rank = jnp.cumsum(counts) - 0.5 * counts
    span = rank[-1] - rank[0]
    knots = look_up(table, (rank - rank[0]) / span)
    moved = knots[below] + share * (knots[below + 1] - knots[below])
    return moved.reshape(values.shape)


def look_up(table: Array, probability: Array) -> Array:
    """The quantiles at other probabilities, by linear interpolation in the table.

    Args:
        table: of `quantile_table`, [count].
        probability: 0 to 1, of any shape.
    """
    place = jnp.arccos(jnp.clip(1 - 2 * probability, -1.0, 1.0)) / jnp.pi * (table.size - 1)
    below = jnp.clip(place.astype(jnp.int32), 0, table.size - 2)
    return table[below] + jnp.clip(place - below, 0.0, 1.0) * (table[below + 1] - table[below])


def table_variance(table: Array) -> Array:
    """The variance of the distribution that a table stands for, between its entries linear.

    Args:
        table: of `quantile_table`, [..., count].

    Returns:
        [...].

    Examples:
        >>> float(table_variance(jnp.asarray(quantile_table(np.linspace(0, 1, 1001))))) # doctest: +ELLIPSIS
        0.0833...
    """
    count = table.shape[-1]
    share = jnp.asarray(np.diff(0.5 - 0.5 * np.cos(np.pi * np.arange(count) / (count - 1))), table.dtype)
    centred = table - jnp.tensordot(0.5 * (table[..., :-1] + table[..., 1:]), share, axes=1)[..., None]
    below, above = centred[..., :-1], centred[..., 1:]
    return jnp.tensordot((below * below + below * above + above * above) / 3, share, axes=1)


def _place(values: Array) -> Array:
    """Where among the knots values lie, from 0 for the smallest to the number of the last knot for the largest.

    Knots are even in a companded value: x / (|x| + d), with x the distance from the mean and d its mean size, keeps
    long tails from taking most of them; a square root then draws them together at both ends, where a distribution that
    ends abruptly is moved furthest.
    """
    centred = values - jnp.mean(values)
    size = jnp.abs(centred)
    companded = centred / jnp.maximum(size + jnp.mean(size), jnp.finfo(values.dtype).tiny)
    least, most = jnp.min(companded), jnp.max(companded)
    even = (companded - least) / jnp.where(most > least, most - least, 1.0)
    to_end = jnp.sqrt(0.5 * jnp.clip(jnp.minimum(even, 1 - even), 0.0, 0.5))
    place = (_KNOTS - 1) * jnp.where(even < 0.5, to_end, 1 - to_end)
    # Rounding must not move the ends, where the square root would magnify it.
    smallest, largest = jnp.min(values), jnp.max(values)
    place = jnp.where(values <= smallest, 0.0, jnp.where(values >= largest, _KNOTS - 1.0, place))
    return jnp.where(smallest < largest, place, 0.5 * (_KNOTS - 1))
