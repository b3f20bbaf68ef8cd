"""Numbers that look random, one for each cell of a lattice: the same wherever, whenever and in what order asked."""

import jax.numpy as jnp
from jax import Array
from jax.typing import ArrayLike

# Large odd numbers. Products with them are added up, as exclusive or would take a cell for its mirror image: -a ^ -b is
# often a ^ b.
_FACTORS = 0x9E3779B1, 0x85EBCA77, 0xC2B2AE3D
_SALT_FACTOR = 0x27D4EB2F


def hash_cell(cell: Array, *, salt: ArrayLike) -> Array:
    """A number of 32 bits that looks random.

    The mixing by shifts and products is C. Wellons' `lowbias32` (Prospecting for Hash Functions, 2018).

    Args:
        cell: whole numbers (3,), of any type, of less than 31 bits.
        salt: a whole number of 32 bits at most; another one, other numbers.

    Returns:
        uint32, a scalar.

    Examples:
        >>> [hash_cell(jnp.array([x, 0, 0]), salt=5).item() for x in range(2)]
        [2825255213, 1090628979]
    """
    products = cell.astype(jnp.int32).astype(jnp.uint32) * jnp.array(_FACTORS, jnp.uint32)
    mixed = jnp.sum(products, dtype=jnp.uint32) ^ jnp.asarray(salt, jnp.uint32) * jnp.uint32(_SALT_FACTOR)
    for shift, factor in ((16, 0x7FEB352D), (15, 0x846CA68B)):
        mixed = (mixed ^ mixed >> shift) * jnp.uint32(factor)
    return mixed ^ mixed >> 16


def random_of_cell(cell: Array, *, salt: ArrayLike) -> Array:
    """A float32 that looks drawn evenly from 0 to 1.

    Args:
        cell, salt: as `hash_cell` takes them.

    Examples:
        >>> 0 <= random_of_cell(jnp.array([3.0, -1.0, 7.0]), salt=0).item() <= 1
        True
    """
    return hash_cell(cell, salt=salt).astype(jnp.float32) * 2.0**-32
