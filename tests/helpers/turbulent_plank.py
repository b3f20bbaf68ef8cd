"""A plank whose rings turbulence displaces, drawn without the code that fits it."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from jaxtex.fitting.rings import lay_plank
from jaxtex.models.wood import make_wood

Floats = NDArray[np.float64]

TRUTH = np.array([35.0, -22.0, np.radians(8.0), np.radians(40.0), np.log(14.0)])
SHAPE = 120, 240
RMS, FREQUENCY = 2.0, 1 / 90


def distance(free: Floats, u: Floats, v: Floats) -> Floats:
    """Of points of the plank from the axis, as :mod:`jaxtex.models.wood` describes it."""
    c, s = np.cos(free[3]), np.sin(free[3])
    aside, depth = c * u + s * v - free[0], (c * v - s * u) * np.sin(free[2]) - free[1]
    return np.sqrt(aside**2 + depth**2)


def draw_turbulence(seed: int) -> Floats:
    """The displacement (H, W) of a model's turbulence across the trunk, where it is alike all around."""
    wood = make_wood(
        ring_spacing=np.exp(TRUTH[4]), center=TRUTH[:2], tilt=TRUTH[2], rotation=TRUTH[3],
        turbulence_rms=RMS, turbulence_frequency=FREQUENCY, seed=seed,
    )  # fmt: skip
    points = np.stack(lay_plank(*SHAPE), axis=-1).reshape(-1, 2)
    return np.asarray(turbulence_at(wood, jnp.asarray(points, jnp.float32)), float).reshape(SHAPE)


@eqx.filter_jit
def turbulence_at(wood, points):
    return jax.vmap(lambda point: wood.turbulence(jnp.append(point, 0.0)))(points)
