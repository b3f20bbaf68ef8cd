"""A lattice read off a photograph -> where the least squares begin."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from jaxtex.fitting.parameters import SCALARS, THICKNESSES, VIEW, free_scales, place, read_free, to_free
from jaxtex.photo.lattice import Lattice

Array = NDArray[np.float64]

# Course offsets come in few sizes, so that pictures with different numbers of courses share one compilation.
_COURSE_SLOTS = (2, 16, 64, 256)


class Start(NamedTuple):
    """Where a solve begins: ``free`` (P,), see :mod:`jaxtex.fitting.parameters`, in pixels of the working picture;
    ``first`` (P,), where the very first of a chain of solves began; ``moving`` (P,), 1 where it may move; ``scale``
    (P,); ``course_lengths`` (2, 2); ``kind``: regular, english, flemish or irregular; ``size``: of the working picture;
    ``perspective``: whether the view may become oblique."""

    free: Array
    first: Array
    moving: Array
    scale: Array
    course_lengths: Array
    kind: str
    size: tuple[float, float]
    perspective: bool


class Fitted(NamedTuple):
    """A start's end: the ``free`` vector (P,) and its ``variance`` (P,); the ``start`` it came from; ``criterion``, the
    Bayesian information criterion of the fit (lower is better); ``mean_square`` residual, and which share of
    the map's variance that is: ``unexplained``; ``doubt``, the share of joints out of place, 1 until somebody looks."""

    free: Array
    variance: Array
    start: Start
    criterion: float
    mean_square: float
    unexplained: float
    doubt: float = 1.0


def start_fit(lattice: Lattice, size: tuple[float, float], *, perspective: bool) -> Start:
    """The start that a lattice gives in a picture of ``size`` (width, height)."""
    direction = np.array([np.cos(lattice.angle), np.sin(lattice.angle)])
    across = np.array([-direction[1], direction[0]])
    kind = lattice.bond if lattice.bond in ("english", "flemish", "irregular") else "regular"
    along, row, offsets = _recentre(lattice)
    origin = along * direction + row * across
    values = dict.fromkeys(SCALARS, 0.0) | {
        "contrast": 1.0,
        "tile_width": lattice.width,
        "tile_height": lattice.height,
        "angle": lattice.angle,
        "mortar_x": lattice.joints[0],
        "mortar_y": lattice.joints[1],
        "offset": lattice.offset,
        "origin_x": origin[0],
        "origin_y": origin[1],
        "tilt_x": lattice.tilt[0],
        "tilt_y": lattice.tilt[1],
        "shear": -lattice.shear,
    }
    free = to_free(values, offsets)
    moving = np.ones(len(free))
    oblique = perspective and bool(lattice.shear or np.any(lattice.tilt))
    held = ["corner_radius", *(() if oblique else VIEW), *(("offset",) if kind in ("irregular", "english") else ())]
    moving[[place(name) for name in held]] = 0.0
    if kind != "irregular":
        moving[len(SCALARS) :] = 0.0
    else:
        # One course keeps its place: the origin moves them all.
        moving[len(SCALARS)] = 0.0
    lengths = np.asarray(np.broadcast_to(lattice.course_lengths, (2, 2)), float)
    scale = free_scales(values, len(offsets), max(size))
    return Start(free, free, moving, scale, lengths, kind, size, perspective)


def with_thickness(fitted: Fitted, thickness: tuple[float, float]) -> Fitted:
    """The same fit with joints of another thickness, except where that was held."""
    values, offsets = read_free(fitted.free)
    names = [name for name in THICKNESSES[:2] if fitted.start.moving[place(name)]]
    measured = dict(zip(THICKNESSES, thickness, strict=False))
    free = to_free(values | {name: measured[name] for name in names}, offsets)
    return fitted._replace(free=free)


def _recentre(lattice: Lattice) -> tuple[float, float, Array]:
    """The node (q_x, q_y) nearest the picture's centre, and the course offsets counted from its course.

    Far from the node, errors of pitch and angle would move it; near it they are told apart.
    """
    cycle = np.asarray(lattice.course_offsets, float)
    step = 2 if lattice.bond == "english" else 1
    course = step * round(-lattice.start[1] / lattice.height / step)
    row = lattice.start[1] + course * lattice.height
    along = lattice.start[0] + lattice.offset * course * lattice.width
    if lattice.bond == "irregular":
        slots = next(n for n in _COURSE_SLOTS if n >= max(len(cycle), 16))
        numbers = np.arange(slots)
        numbers[slots // 2 :] -= slots
        offsets = cycle[(numbers + course) % len(cycle)]
        along, offsets = along + offsets[0] * lattice.width, offsets - offsets[0]
        offsets = offsets - np.round(offsets)
    else:
        offsets = np.resize(cycle, 2)
    period = lattice.width * float(lattice.course_lengths[course % len(lattice.course_lengths)].sum())
    return along - period * round(along / period), row, offsets
