"""The numbers that a tiling fit is free to choose, as one unconstrained vector, and back.

Layout of the vector: the scalars of :data:`SCALARS` in their order, then the course offsets. Perspective and shear
stand in it instead of a homography's nine entries: that family has no redundant directions (see
:mod:`jaxtex.models.perspective`). Pitches pass through a logarithm and thicknesses through an inverse softplus, so that
every real vector is a valid tiling.
"""

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import NDArray

from jaxtex.models.perspective import perspective_homography
from jaxtex.models.tiling import Tiling

SCALARS = (
    "level",  # what the observed map reads on tiles
    "contrast",  # how much more it reads on joints
    "tile_width",
    "tile_height",
    "angle",
    "mortar_x",
    "mortar_y",
    "offset",
    "origin_x",
    "origin_y",
    "tilt_x",
    "tilt_y",
    "shear",
    "corner_radius",
)
PITCHES = ("tile_width", "tile_height")
THICKNESSES = ("mortar_x", "mortar_y", "corner_radius")
VIEW = ("tilt_x", "tilt_y", "shear")


def place(name: str) -> int:
    """Index of a scalar in the vector."""
    return SCALARS.index(name)


def to_free(values: dict[str, float], course_offsets: NDArray[np.float64]) -> NDArray[np.float64]:
    """Natural values, one for each of :data:`SCALARS`, and course offsets (C,) as an unconstrained vector."""
    free = [_scalar_to_free(name, values[name]) for name in SCALARS]
    return np.concatenate([free, np.asarray(course_offsets, float)])


def from_free(free: Array) -> tuple[dict[str, Array], Array]:
    """The inverse of :func:`to_free`, differentiable: natural values by name and course offsets (C,)."""
    values = {}
    for index, name in enumerate(SCALARS):
        value = free[index]
        if name in PITCHES:
            value = jnp.exp(value)
        elif name in THICKNESSES:
            value = jax.nn.softplus(value)
        values[name] = value
    return values, free[len(SCALARS) :]


def read_free(free: NDArray[np.float64]) -> tuple[dict[str, float], NDArray[np.float64]]:
    """:func:`from_free` on the host, in plain numbers."""
    values = {name: float(free[index]) for index, name in enumerate(SCALARS)}
    values |= {name: float(np.exp(values[name])) for name in PITCHES}
    values |= {name: float(np.logaddexp(values[name], 0.0)) for name in THICKNESSES}
    return values, np.asarray(free[len(SCALARS) :], float)


def build_tiling(free: Array, course_lengths: Array, centre: Array) -> Tiling:
    """The tiling that a vector stands for; ``centre`` (2,) is where perspective leaves lengths as they are."""
    values, course_offsets = from_free(free)
    tilt = jnp.stack([values["tilt_x"], values["tilt_y"]])
    return Tiling(
        tile_width=values["tile_width"],
        tile_height=values["tile_height"],
        angle=values["angle"],
        mortar_x=values["mortar_x"],
        mortar_y=values["mortar_y"],
        offset=values["offset"],
        origin=centre + jnp.stack([values["origin_x"], values["origin_y"]]),
        homography=perspective_homography(centre, tilt, values["shear"], values["angle"]),
        corner_radius=values["corner_radius"],
        course_offsets=course_offsets,
        course_lengths=course_lengths,
        bond="irregular",
    )


def free_scales(values: dict[str, float], courses: int, size: float) -> NDArray[np.float64]:
    """For each entry, the change that moves some joint of a picture ``size`` across by about one pixel.

    Divided by these, all directions matter alike to a solver, whatever the units.
    """
    width = values["tile_width"]
    scale = {
        "level": 0.05,
        "contrast": 0.05,
        "tile_width": 2 / size,
        "tile_height": 2 / size,
        "angle": 2 / size,
        "offset": 1 / width,
        "tilt_x": 4 / size**2,
        "tilt_y": 4 / size**2,
        "shear": 2 / size,
    }
    return np.array([scale.get(name, 1.0) for name in SCALARS] + [1 / width] * courses)


def _scalar_to_free(name: str, value: float) -> float:
    if name in PITCHES:
        return float(np.log(value))
    if name in THICKNESSES:
        # Softplus reaches 0 only at minus infinity; a thousandth of a pixel is as good.
        value = max(value, 1e-3)
        return float(value + np.log(-np.expm1(-value)))
    return float(value)
