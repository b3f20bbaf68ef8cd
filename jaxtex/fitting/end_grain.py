"""Rings in numbers that suit end grain.

Where the axis meets the plank at nearly a right angle, its tilt and rotation hardly matter, as latitude and longitude
do near a pole: a step along either leads nowhere. Rings are ellipses there; where these have their middle, and by how
much and which way they are stretched, in two numbers as of a vector, changes the picture evenly in all directions.
"""

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_POLE = 1e-5  # stretch at least, so that it has a direction
_MOST = 0.98  # and at most: that of a tilt of some ten degrees


def to_ellipses(free: Floats) -> Floats:
    """Of a vector (6,): the ellipses' middle (u, v), their stretch along u and along the diagonal, the logarithm of
    their mean spacing, and the logit as it is."""
    xc, yc, tilt, rotation, log_spacing, logit = free
    c, s, along = np.cos(rotation), np.sin(rotation), yc / np.sin(tilt)
    half = np.cos(tilt) ** 2 / 2
    stretch = max(half / (1 - half), _POLE)
    turn = [stretch * np.cos(2 * rotation), stretch * np.sin(2 * rotation)]
    return np.array([xc * c - along * s, xc * s + along * c, *turn, log_spacing - 0.5 * np.log(1 - half), logit])


def from_ellipses(ellipses: Floats) -> tuple[Floats, Floats]:
    """The vector (6,) of ellipses (6,), and how it changes with them (6, 6)."""
    with jax.enable_x64():
        free, slopes = _from_ellipses(jnp.asarray(ellipses))
        return np.asarray(free), np.asarray(slopes)


@jax.jit
def _from_ellipses(ellipses: Array) -> tuple[Array, Array]:
    def convert(ellipses: Array) -> Array:
        u, v, x, y, log_mean, logit = ellipses
        stretch = jnp.minimum(jnp.hypot(x, y), _MOST)
        half = stretch / (1 + stretch)
        rotation = 0.5 * jnp.arctan2(y, x)
        c, s, lean = jnp.cos(rotation), jnp.sin(rotation), jnp.sqrt(1 - 2 * half)
        log_spacing = log_mean + 0.5 * jnp.log(1 - half)
        return jnp.stack([u * c + v * s, lean * (v * c - u * s), jnp.arcsin(lean), rotation, log_spacing, logit])

    return convert(ellipses), jax.jacfwd(convert)(ellipses)
