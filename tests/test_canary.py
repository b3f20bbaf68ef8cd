"""What jaxtex relies on in the libraries below it, where one of their versions is known to have got it wrong."""

import jax
import jax.numpy as jnp
import numpy as np


def test_batched_products_in_double_precision_are_right_in_every_row() -> None:
    """jax 0.10.2 miscompiled this on the CPU: 23,616 of the 40,000 rows were wrong."""
    rng = np.random.default_rng(0)
    matrix, points = rng.normal(size=(3, 3)), rng.normal(size=(40_000, 3))
    with jax.enable_x64(True):
        square = jax.jit(jax.vmap(lambda x: jnp.sum((jnp.asarray(matrix) @ x) ** 2)))
        computed = np.asarray(square(jnp.asarray(points)))
    assert computed.dtype == np.float64
    np.testing.assert_allclose(computed, ((points @ matrix.T) ** 2).sum(axis=1), rtol=1e-11)
