"""Histogram matching: values are moved, in order, so that they come to be distributed as others are.

A distribution is a table of quantiles. Values are ranked by counting them in bins, which takes a fraction of the time
of sorting and is exact to a fraction of a bin: within one, values are moved linearly.
"""

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

QUANTILES = 512
"""Quantiles in a table, where nothing else is said."""

_BINS = 2048


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
        values: float array of any shape; all of it is one distribution. Values that are all equal go to the middle
            between the table's ends.
        table: of `quantile_table`, [count].

    Examples:
        >>> table = jnp.asarray(quantile_table(np.linspace(0, 1, 1001) ** 2))
        >>> moved = match_histogram(jnp.linspace(-5, 5, 10_001), table)
        >>> moved[::2500].round(2)
        Array([0.  , 0.06, 0.25, 0.56, 1.  ], dtype=float32)
    """
    place = _place(values.ravel())
    bin_ = jnp.minimum(place.astype(jnp.int32), _BINS - 1)
    counts = jnp.zeros(_BINS, jnp.int32).at[bin_].add(1)
    rank = jnp.concatenate([jnp.zeros(1, jnp.int32), jnp.cumsum(counts)])
    edges = look_up(table, rank / values.size)
    moved = edges[bin_] + (place - bin_) * (edges[bin_ + 1] - edges[bin_])
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
    """Where among the bins values lie, from 0 for the smallest to the number of bins for the largest.

    Bins are even in a companded value: x / (|x| + d), with x the distance from the mean and d its mean size, keeps long
    tails from taking most of the bins; a square root then narrows those at both ends, where a distribution that ends
    abruptly is moved furthest.
    """
    centred = values - jnp.mean(values)
    size = jnp.abs(centred)
    companded = centred / jnp.maximum(size + jnp.mean(size), jnp.finfo(values.dtype).tiny)
    least, most = jnp.min(companded), jnp.max(companded)
    unequal = most > least
    even = jnp.where(unequal, 2 * (companded - least) / jnp.where(unequal, most - least, 1.0) - 1, 0.0)
    ends = jnp.sign(even) * (1 - jnp.sqrt(jnp.maximum(1 - jnp.abs(even), 0.0)))
    # Half a bin on: values that are all equal lie in the middle of one.
    return jnp.clip((0.5 + 0.5 * ends) * _BINS + jnp.where(unequal, 0.0, 0.5), 0.0, _BINS)
