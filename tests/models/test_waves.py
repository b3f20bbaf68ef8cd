"""The polynomial is the cosine, in value and slope, for any number of turns."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxtex.models.waves import cosine


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float32, 2e-6), (np.float64, 1e-11)])
def test_it_is_the_cosine(dtype, tolerance):
    turns = np.random.default_rng(0).uniform(-300, 300, 20_000).astype(dtype)
    with jax.enable_x64():
        value, slope = jax.jit(jax.vmap(jax.value_and_grad(cosine)))(jnp.asarray(turns))
    assert value.dtype == dtype
    exact = 2 * np.pi * (turns.astype(np.float64) % 1)
    np.testing.assert_allclose(value, np.cos(exact), atol=tolerance)
    np.testing.assert_allclose(slope, -2 * np.pi * np.sin(exact), atol=200 * tolerance)


def test_half_turns_have_no_jump():
    with jax.enable_x64():
        below, at, above = np.asarray(cosine(jnp.array([2.5 - 1e-9, 2.5, 2.5 + 1e-9])))
    assert max(abs(below - at), abs(above - at)) < 1e-12
