"""Numbers of lattice cells: all different, with even bits, and the same for whole numbers of any type."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxtex.core.hashing import hash_cell, random_of_cell

CELLS = jnp.stack(jnp.meshgrid(*[jnp.arange(-16, 16)] * 3), axis=-1).reshape(-1, 3)


def hash_all(cells: jax.Array, salt: int) -> np.ndarray:
    return np.asarray(jax.vmap(lambda cell: hash_cell(cell, salt=salt))(cells))


def hash_plainly(x: int, y: int, z: int, salt: int) -> int:
    """In whole numbers of any length."""
    mixed = (x * 0x9E3779B1 + y * 0x85EBCA77 + z * 0xC2B2AE3D) % 2**32 ^ salt * 0x27D4EB2F % 2**32
    mixed = (mixed ^ mixed >> 16) * 0x7FEB352D % 2**32
    mixed = (mixed ^ mixed >> 15) * 0x846CA68B % 2**32
    return mixed ^ mixed >> 16


@pytest.mark.parametrize("salt", [0, 7, 2**32 - 1])
def test_it_is_the_plain_arithmetic(salt):
    cells = np.random.default_rng(0).integers(-(2**30), 2**30, (50, 3))
    expected = [hash_plainly(*map(int, cell), salt) for cell in cells]
    np.testing.assert_array_equal(hash_all(jnp.asarray(cells), salt), expected)


def test_all_cells_differ_and_mirror_images_too():
    assert len(np.unique(hash_all(CELLS, 7))) == len(CELLS)


@pytest.mark.parametrize("salt", [0, 7])
def test_bits_are_even_and_independent_of_neighbours(salt):
    bits = hash_all(CELLS, salt)[:, None] >> np.arange(32, dtype=np.uint32) & 1
    assert np.abs(bits.mean(0) - 0.5).max() < 0.015
    for step in np.eye(3, dtype=int):
        beside = hash_all(CELLS + jnp.asarray(step)[None], salt)[:, None] >> np.arange(32, dtype=np.uint32) & 1
        assert np.abs((bits ^ beside).mean(0) - 0.5).max() < 0.015
    other = hash_all(CELLS, salt + 1)[:, None] >> np.arange(32, dtype=np.uint32) & 1
    assert np.abs((bits ^ other).mean(0) - 0.5).max() < 0.015


def test_shares_are_the_numbers_from_0_to_1():
    shares = np.asarray(jax.vmap(lambda cell: random_of_cell(cell, salt=7))(CELLS.astype(jnp.float32)))
    np.testing.assert_array_equal(shares, hash_all(CELLS, 7).astype(np.float32) / np.float32(2**32))
