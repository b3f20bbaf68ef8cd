"""A fitted vector -> the tiling in the photograph's own pixels, with its name and its errors."""

import dataclasses
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from jaxtex.fitting.parameters import build_tiling, place, read_free
from jaxtex.fitting.start import Fitted, Start
from jaxtex.fitting.verdict import to_lattice
from jaxtex.models.canonical import canonical, nearest_node
from jaxtex.models.perspective import normalise_view
from jaxtex.models.tiling import Tiling
from jaxtex.photo.lattice import SAME_BOND

Array = NDArray[np.float64]

_MOST_MORTAR = 0.95  # of a tile; a fit that ends with more has found no tiling


def tiling_of(free: Array, start: Start, size: tuple[int, int]) -> Tiling:
    """The tiling of a vector found in the working picture, in a photograph of ``size`` (width, height) pixels."""
    tiling = dataclasses.replace(tiling_seen(free, start, size), bond=name_bond(free, start.kind))
    if start.kind == "irregular":
        tiling = _visible_courses(tiling, size)
    centre = np.asarray(size) / 2
    tiling = canonical(tiling)
    if not np.array_equal(tiling.homography, np.eye(3)):
        with jax.enable_x64():
            tiling = jax.tree.map(lambda leaf: np.asarray(leaf, float), normalise_view(tiling, centre))
    return nearest_node(tiling, centre)


def tiling_seen(free: Array, start: Start, size: tuple[int, int]) -> Tiling:
    """The same, written as the solver found it: not yet in the form that model files hold."""
    scale = max(size) / max(start.size)
    with jax.enable_x64():
        centre = np.asarray(start.size) / 2
        tiling = jax.device_get(
            _build(jnp.asarray(free, float), jnp.asarray(start.course_lengths, float), jnp.asarray(centre))
        )
    grow = np.diag([scale, scale, 1.0])
    width, height = tiling.tile_width * scale, tiling.tile_height * scale
    return dataclasses.replace(
        tiling,
        tile_width=width,
        tile_height=height,
        mortar_x=np.minimum(tiling.mortar_x * scale, _MOST_MORTAR * width * tiling.course_lengths.min()),
        mortar_y=np.minimum(tiling.mortar_y * scale, _MOST_MORTAR * height),
        origin=tiling.origin * scale,
        homography=_exact(grow @ tiling.homography @ np.linalg.inv(grow)),
        corner_radius=np.zeros(()),
    )


_build = eqx.filter_jit(build_tiling)


def name_bond(free: Array, kind: str) -> str:
    """What masons call it."""
    if kind != "regular":
        return kind
    fraction = free[place("offset")] % 1.0
    if min(fraction, 1.0 - fraction) < SAME_BOND:
        return "stack"
    return "running" if abs(fraction - 0.5) < SAME_BOND else "raking"


def standard_errors(fitted: Fitted, tiling: Tiling, size: tuple[int, int]) -> dict[str, float]:
    """One standard deviation of each parameter that moved, in the units of the model file.

    ``tiling`` is what the fit became: a stack bond may have been written with its columns as courses.
    """
    scale = max(size) / max(fitted.start.size)
    values = read_free(fitted.free)[0]
    # By how much a free number stands for a change of what the file holds.
    units = {
        "tile_width": values["tile_width"] * scale,
        "tile_height": values["tile_height"] * scale,
        "angle": float(np.degrees(1.0)),
        "mortar_x": scale * -np.expm1(-values["mortar_x"]),
        "mortar_y": scale * -np.expm1(-values["mortar_y"]),
        "offset": 1.0,
        "origin_x": scale,
        "origin_y": scale,
        "tilt_x": 1 / scale,
        "tilt_y": 1 / scale,
        "shear": 1.0,
    }
    variance = fitted.variance[[place(name) for name in units]]
    errors = {
        name: float(np.sqrt(one)) * unit for (name, unit), one in zip(units.items(), variance, strict=True) if one > 0
    }
    if np.abs(np.cos(float(tiling.angle) - values["angle"])) < 0.5:
        turned = {"tile_width": "tile_height", "mortar_x": "mortar_y"}
        turned |= {other: name for name, other in turned.items()}
        errors = {turned.get(name, name): error for name, error in errors.items()}
    return {"angle_deg" if name == "angle" else name: error for name, error in errors.items()}


def count_tiles(tiling: Tiling, size: tuple[int, int]) -> tuple[int, int]:
    """Courses, and tiles along a course, that a picture of ``size`` (width, height) shows, to the nearest whole."""
    width, height = size
    middle = np.array([[0.0, height / 2], [width, height / 2], [width / 2, 0.0], [width / 2, height]])
    qx, qy = to_lattice(tiling, middle[:, 0], middle[:, 1])
    along, across = float(np.ptp(qx)), float(np.ptp(qy))
    mean_length = float(tiling.tile_width) * float(np.mean(tiling.course_lengths))
    return max(round(across / float(tiling.tile_height)), 1), max(round(along / mean_length), 1)


def _visible_courses(tiling: Tiling, size: tuple[int, int]) -> Tiling:
    """Keep the offsets of the courses that the picture shows; beyond it they repeat."""
    corners = np.array([[0.0, 0.0], [size[0], 0], [size[0], size[1]], [0, size[1]]])
    across = to_lattice(tiling, corners[:, 0], corners[:, 1])[1] / float(tiling.tile_height)
    courses = np.arange(int(np.floor(across.min())), int(np.ceil(across.max())))
    offsets = np.zeros(len(courses))
    offsets[courses % len(courses)] = np.asarray(tiling.course_offsets)[courses % len(tiling.course_offsets)]
    changed: dict[str, Any] = {"course_offsets": offsets}
    return dataclasses.replace(tiling, **changed)


def _exact(homography: Array) -> Array:
    homography = homography / homography[2, 2]
    return np.eye(3) if np.allclose(homography, np.eye(3), rtol=0, atol=1e-13) else homography
