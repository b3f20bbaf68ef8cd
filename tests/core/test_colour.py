"""The sRGB curve: against the standard's table of values, its own inverse, and for both kinds of arrays."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxtex.core.colour import linear_to_srgb, srgb_to_linear


def curve(encoded: float) -> float:
    return encoded / 12.92 if encoded <= 0.04045 else ((encoded + 0.055) / 1.055) ** 2.4


def test_every_byte_value_decodes_as_the_standard_says() -> None:
    encoded = np.arange(256) / 255
    np.testing.assert_allclose(srgb_to_linear(encoded), [curve(value) for value in encoded], rtol=1e-14)


def test_encoding_undoes_decoding_outside_the_displayable_range_too() -> None:
    encoded = np.linspace(-0.5, 4, 2001)
    np.testing.assert_allclose(linear_to_srgb(srgb_to_linear(encoded)), encoded, atol=2e-7)


@pytest.mark.parametrize("function", [srgb_to_linear, linear_to_srgb])
def test_both_kinds_of_arrays_agree_and_keep_their_dtype(function) -> None:
    values = np.linspace(-0.2, 1.5, 101, dtype=np.float32)
    assert function(values).dtype == np.float32
    traced = jax.jit(function)(jnp.asarray(values))
    assert traced.dtype == jnp.float32
    np.testing.assert_allclose(traced, function(values), rtol=3e-6, atol=1e-7)


@pytest.mark.parametrize("function", [srgb_to_linear, linear_to_srgb])
def test_gradients_are_finite_and_positive_everywhere(function) -> None:
    at = jnp.array([-2.0, -0.055, 0.0, 0.0031308, 0.04045, 0.5, 1.0, 3.0])
    slopes = jax.vmap(jax.grad(function))(at)
    assert jnp.all(jnp.isfinite(slopes) & (slopes > 0))
