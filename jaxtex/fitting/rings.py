"""What a fit of wood is free to choose, and the rings that follow from it: the geometry in plain numbers.

A vector ``free`` (6,) holds the axis (xc, yc), tilt, rotation, the logarithm of the ring spacing and the logit of the
share of early wood. Only geometry: colours follow from the mask.
"""

from collections.abc import Mapping
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array
from numpy.typing import NDArray

from jaxtex.models.wood import canonical_pose, early_share, trunk_coordinates

Floats = NDArray[np.float64]

NAMES = ("xc", "yc", "tilt", "rotation", "log_spacing", "logit_fraction")
GEOMETRY = 5  # how many of them place the rings
_PITH = 1e-3  # pixels: how far the pith is rounded, so that it has a gradient


Held = Mapping[int, float]  # numbers of a vector that do not move, by their place in it


def hold(free: Floats, held: Held) -> Floats:
    """The vector with its held numbers where they are held."""
    return np.array([held.get(n, value) for n, value in enumerate(free)])


def loosen(scale: npt.ArrayLike, held: Held) -> Floats:
    """Steps of a vector's numbers (N,), none for those that are held."""
    return np.array([0.0 if n in held else step for n, step in enumerate(np.asarray(scale, float))])


class Plank(NamedTuple):
    """Points of a plank from its picture's middle: ``u`` (N,) to the right and ``v`` (N,) down, in pixels."""

    u: Array
    v: Array


def lay_plank(height: int, width: int, step: int = 1) -> tuple[Floats, Floats]:
    """u and v (H / step, W / step) of every ``step``-th pixel."""
    rows, columns = np.mgrid[step // 2 : height : step, step // 2 : width : step]
    return columns + 0.5 - width / 2, rows + 0.5 - height / 2


def ring_distance(free: Array, plank: Plank) -> tuple[Array, Array]:
    """Distance (N,) of points from the axis, in pixels, and by how much of that a pixel on the plank differs from the
    next (N,), 0 to 1."""
    aside, depth = _from_axis(free, plank)
    distance = jnp.sqrt(aside**2 + depth**2 + _PITH**2)
    slope = jnp.sqrt((aside / distance) ** 2 + (jnp.sin(free[2]) * depth / distance) ** 2 + _PITH)
    return distance, slope


def ring_count(free: Array, plank: Plank) -> Array:
    """Rings (N,) between the axis and each point."""
    return ring_distance(free, plank)[0] * jnp.exp(-free[4])


def model_count(free: Floats, shape: tuple[int, ...], every: int = 1) -> Floats:
    """The rings of a vector, without turbulence, at ``every`` so many pixels of a picture (H, W)."""
    u, v = lay_plank(shape[0], shape[1], every)
    with jax.enable_x64():
        plank = Plank(jnp.asarray(u.ravel()), jnp.asarray(v.ravel()))
        return np.asarray(_count(jnp.asarray(free[:GEOMETRY]), plank)).reshape(u.shape)


def early_wood(free: Array, plank: Plank, blur: Array) -> Array:
    """Share (N,) of early wood in a Gaussian spot of ``blur`` pixels."""
    distance, slope = ring_distance(free, plank)
    spacing = jnp.exp(free[4])
    return early_share(distance / spacing, jax.nn.sigmoid(free[5]), blur * slope / spacing)


def wave_squares(free: Array, plank: Plank) -> Array:
    """(N, 3): the local wave vector's outer product with itself, as difference, cross term and sum."""
    aside, depth = _from_axis(free, plank)
    c, s, lean = jnp.cos(free[3]), jnp.sin(free[3]), jnp.sin(free[2])
    # Near the pith no piece of the picture has one wave; the ring itself bounds how sharply it may turn.
    spacing = jnp.exp(free[4])
    reach = jnp.sqrt(aside**2 + depth**2 + 1e-2 * spacing**2) * spacing
    across, along = aside / reach, lean * depth / reach
    return square_waves(jnp.stack([across * c - along * s, across * s + along * c], axis=1))


def square_waves(wave: Array) -> Array:
    """Of wave vectors (N, 2): what stays the same when their sense is turned (N, 3)."""
    x, y = wave[:, 0], wave[:, 1]
    return jnp.stack([x * x - y * y, 2 * x * y, x * x + y * y], axis=1)


def canonical_rings(free: Floats) -> tuple[Floats, Floats]:
    """The one of the descriptions of the same picture whose tilt is in [0, pi/2] and rotation in [0, pi); and which of
    the numbers (5 or 6,) have turned their sign, -1, on the way there."""
    tilt, rotation, mirror = canonical_pose(float(free[2]), float(free[3]))
    signs = np.ones(len(free))
    signs[:3] = mirror[0], mirror[1], mirror[1] * mirror[2]
    return np.array([free[0] * signs[0], free[1] * signs[1], tilt, rotation, *free[4:]]), signs


@jax.jit
def _count(free: Array, plank: Plank) -> Array:
    return ring_count(free, plank)


def _from_axis(free: Array, plank: Plank) -> tuple[Array, Array]:
    """From the axis to points of the plank, in the trunk: X and Y (N,)."""
    x, y, _ = trunk_coordinates(plank.u, plank.v, tilt=free[2], rotation=free[3])
    return x - free[0], y - free[1]
