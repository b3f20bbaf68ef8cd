"""A guess at a whole tiling, and the joints it predicts: what the search hands to the fit."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# How many independent measurements a picture of a tiling is taken for when models of it are compared: joints, which are
# out of place one by one, not pixels.
MEASUREMENTS = 300
# Tiles: offsets this near to none or to a half are called stack or running.
SAME_BOND = 0.04


class Lattice(NamedTuple):
    """A guess at a whole tiling, in pixels of the map it was found in, relative to the map's centre.

    ``tilt`` (2,): plane point p = x / (1 + tilt . x) for image point x. ``angle``: direction of the courses in the
    plane, radians. ``shear``: head joints lean by this much along the courses per unit across, so that the lattice is
    straight in (q_x - shear q_y, q_y). ``height``, ``width``: pitches. ``start`` (2,): the start of tile 0 of course 0
    in those coordinates. ``offset``, ``course_offsets`` (C,), ``course_lengths`` (D, L) and ``bond`` as in the model.
    ``joints`` (2,): thickness of the joints along and across. ``score``: how much of the map it explains, higher is
    better (minus the Bayesian information criterion).
    """

    tilt: Array
    angle: float
    shear: float
    height: float
    width: float
    start: Array
    offset: float
    course_offsets: Array
    course_lengths: Array
    bond: str
    joints: tuple[float, float]
    score: float

    @property
    def freedoms(self) -> int:
        """How many numbers a fit of this kind of lattice is free to choose."""
        # Pitches, angle, place and thicknesses; then the bond's own, an English wall's being the shift of its headers.
        bond = len(self.course_offsets) - 1 if len(self.course_offsets) > 1 else 1
        return 7 + bond + 2 * bool(np.any(self.tilt)) + bool(self.shear)


def to_strips(lattice: Lattice, x: NDArray[np.floating], y: NDArray[np.floating]) -> tuple[Array, Array]:
    """Lattice coordinates (q_x, q_y), lean removed, of map points given from the map's centre."""
    depth = 1.0 + lattice.tilt[0] * x + lattice.tilt[1] * y
    depth = np.where(depth > 0.1, depth, np.nan)
    c, s = np.cos(lattice.angle), np.sin(lattice.angle)
    along, across = (c * x + s * y) / depth, (c * y - s * x) / depth
    return along - lattice.shear * across, across


def joint_distances(lattice: Lattice, along: Array, across: Array) -> tuple[Array, Array]:
    """Distance of lattice points to the nearest head joint's and the nearest bed joint's centre line."""
    row = (across - lattice.start[1]) / lattice.height
    course = np.floor(row)
    # Points beyond the horizon have no course; their NaN goes on into both distances.
    index = np.nan_to_num(course).astype(int)
    shift = lattice.offset * course + lattice.course_offsets[index % len(lattice.course_offsets)]
    place = (along - lattice.start[0]) / lattice.width - shift
    bed = np.abs(row - np.round(row)) * lattice.height
    if lattice.course_lengths.size == 1:
        return np.abs(place - np.round(place)) * lattice.width, bed
    head = np.empty_like(place)
    for number, lengths in enumerate(lattice.course_lengths):
        mine = index % len(lattice.course_lengths) == number
        ends = np.concatenate([[0.0], np.cumsum(lengths)])
        head[mine] = np.abs(np.mod(place[mine], ends[-1])[:, None] - ends).min(-1)
    return head * lattice.width, bed


def turn_upright(lattice: Lattice) -> Lattice:
    """A stack bond may be read with its columns as courses; this reads it as model files do, with courses within 45
    degrees of the picture's rows. Other lattices are given back as they are."""
    aside = abs(lattice.offset - round(lattice.offset))
    turned = np.pi / 4 < lattice.angle % np.pi <= 3 * np.pi / 4
    if lattice.bond not in ("stack", "running", "raking") or aside > SAME_BOND or lattice.shear or not turned:
        return lattice
    return lattice._replace(
        angle=lattice.angle + np.pi / 2,
        width=lattice.height,
        height=lattice.width,
        start=np.array([lattice.start[1], -lattice.start[0]]),
        offset=0.0,
        joints=lattice.joints[::-1],
    )


def list_rows(lattice: Lattice) -> list[tuple[float, float]]:
    """Other courses that the joints of a lattice may belong to, as (angle, height): every second bed joint; and, where
    nodes repeat, rows along each of their shortest steps."""
    doubled = [(lattice.angle, 2 * lattice.height)]
    if lattice.bond not in ("stack", "running", "raking"):
        return doubled
    along = np.array([lattice.width, 0.0])
    down = np.array([(lattice.offset * lattice.width + lattice.shear * lattice.height), lattice.height])
    down = down - np.round(down[0] / along[0]) * along
    steps = [down, *(down + n * along for n in (-1, 1)), *(2 * down + n * along for n in (-1, 1))]
    steps.sort(key=lambda step: float(np.hypot(*step)))
    area = lattice.width * lattice.height
    rows = [(lattice.angle + float(np.arctan2(*step[::-1])), area / float(np.hypot(*step))) for step in steps[:3]]
    return doubled + rows
