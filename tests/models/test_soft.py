"""Soft edges and corners against sums over fine samples of the spot."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxtex.models.soft import corner_defect, soft_step

STEP = 0.02
SAMPLES = np.arange(-6, 6, STEP) + STEP / 2
DENSITY = np.exp(-(SAMPLES**2) / 2) / np.sqrt(2 * np.pi) * STEP
PLACES = [(0.0, 0.0), (0.5, 0.5), (1.0, -0.5), (-1.0, -1.0), (2.0, 0.3), (0.2, 4.0), (3.0, 3.0), (-3.0, 2.0)]


def lost_in_the_gap(x: float, y: float, radius: float) -> float:
    """Weight of the samples between the corner and its arc."""
    u, v = np.meshgrid(x + SAMPLES, y + SAMPLES)
    gap = (u > 0) & (v > 0) & (u < radius) & (v < radius) & (np.hypot(radius - u, radius - v) > radius)
    return float((gap * DENSITY[:, None] * DENSITY[None, :]).sum())


def test_a_soft_step_is_the_weight_beyond_the_edge():
    for x in (-2.0, -0.3, 0.0, 0.7, 3.0):
        assert abs(float(soft_step(x)) - DENSITY[x + SAMPLES > 0].sum()) < 0.005


@pytest.mark.parametrize("radius", [0.5, 1.0, 2.0, 2.6, 3.0, 5.0, 12.0])
def test_a_corner_loses_the_weight_of_the_gap(radius):
    for x, y in [*PLACES, (0.3 * radius, 0.3 * radius), (0.1 * radius, 0.6 * radius)]:
        lost = corner_defect(jnp.float32(x), jnp.float32(y), jnp.float32(radius))
        assert abs(float(lost) - lost_in_the_gap(x, y, radius)) < 0.0085


def test_corners_have_finite_gradients_everywhere():
    with jax.enable_x64():
        at = jnp.array([-40.0, -3.0, -0.1, 0.0, 1e-9, 0.7, 2.6, 5.0, 40.0])
        grid = jnp.stack([leaf.ravel() for leaf in jnp.meshgrid(at, at, jnp.abs(at))], axis=1)
        gradient = jax.jit(jax.vmap(jax.grad(lambda p: corner_defect(p[0], p[1], p[2]))))(grid)
        assert bool(jnp.isfinite(gradient).all())
        value = jax.jit(jax.vmap(lambda p: corner_defect(p[0], p[1], p[2])))
        for axis in range(2):
            step = jnp.zeros((1, 3)).at[0, axis].set(1e-6)
            numeric = (value(grid + step) - value(grid - step)) / 2e-6
            np.testing.assert_allclose(gradient[:, axis], numeric, atol=1e-7)
        assert bool((jnp.abs(gradient[grid[:, 2] == 0]) < 1e-15).all())
