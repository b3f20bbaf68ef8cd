"""Rectangular tilings: the forward model, evaluated at one point of the picture.

The way of a point (Lefebvre & Poulin 2000, section 2 and figure 2, with the extensions they propose):

    image point --homography--> plane point p --> q = R(-angle) (p - origin)
    course j = floor(q_y / tile_height),  tile i = floor(q_x / tile_width - offset * j)

Joints are centred on the lattice lines. Everything is a pure function of one point; callers `vmap`.
"""

from collections.abc import Sequence
from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array, lax
from jax.typing import ArrayLike

from jaxtex.models.soft import corner_defect, soft_step

BONDS = ("stack", "running", "raking", "english", "flemish", "irregular")


class TilePlace(NamedTuple):
    """Where a point lies in a tiling: which tile, and how far from that tile's four lattice lines (plane pixels)."""

    course: Array
    tile: Array
    left: Array
    right: Array
    top: Array
    bottom: Array


class Spot(NamedTuple):
    """How far inside the tiles of one course a Gaussian spot lies, in its own standard deviations.

    `this` and `next` are the two tiles at the nearest head joint, `top` and `bottom` the course's two edges.
    """

    this: Array
    next: Array
    top: Array
    bottom: Array

    def covered(self) -> Array:
        """How much of the spot is tile of this course, the tiles' corners being square."""
        return (soft_step(self.this) + soft_step(self.next)) * (soft_step(self.top) + soft_step(self.bottom) - 1.0)


class Tiling(eqx.Module):
    """A rectangular tiling seen in a photograph (Lefebvre & Poulin 2000, section 2).

    All lengths are plane pixels, which are image pixels where `homography` is the identity; tile sizes are pitches,
    joint included. Departures from the paper's six parameters: two joint thicknesses instead of one, a homography so
    that an oblique photograph needs no rectifying, rounded corners, and courses that may differ in their tile
    lengths and be shifted freely.

    Attributes:
        tile_width, tile_height: pitch along and across the courses, > 0.
        angle: direction of the courses in radians, from x (right) towards y (down).
        mortar_x, mortar_y: gap between tiles of one course, and between courses, >= 0.
        offset: shift of each course against the one before it, as a fraction of `tile_width`.
        origin: (2,), a lattice node (x, y): the start of tile 0 of course 0.
        homography: (3, 3), image point to plane point.
        corner_radius: radius of the tiles' rounded corners, >= 0.
        course_offsets: (C,), further shift of course j, entry `j mod C`, as a fraction of `tile_width`.
        course_lengths: (D, L), lengths of consecutive tiles in course j, row `j mod D`, in units of `tile_width`; the
            row repeats.
        bond: one of `BONDS`. A name for people and files; the geometry is in the arrays.

    Examples:
        >>> from jaxtex.models.tiling import make_tiling
        >>> wall = make_tiling(tile_width=40.0, tile_height=20.0, mortar_x=4.0, mortar_y=4.0, offset=0.5)
        >>> round(float(wall.coverage(jnp.array([20.0, 10.0]), blur=0.5)), 3)
        1.0
    """

    tile_width: Array
    tile_height: Array
    angle: Array
    mortar_x: Array
    mortar_y: Array
    offset: Array
    origin: Array
    homography: Array
    corner_radius: Array
    course_offsets: Array
    course_lengths: Array
    bond: str = eqx.field(static=True)

    def to_plane(self, point: Array) -> Array:
        """Image point (2,) to plane point (2,) by the homography."""
        return _project(self.homography, point)

    def to_lattice(self, point: Array) -> Array:
        """Image point (2,) to lattice coordinates q (2,), in plane pixels along and across the courses."""
        p = self.to_plane(point) - self.origin
        c, s = jnp.cos(self.angle), jnp.sin(self.angle)
        return jnp.stack([c * p[0] + s * p[1], c * p[1] - s * p[0]])

    def from_lattice(self, q: Array) -> Array:
        """Lattice coordinates (2,) back to the image point (2,): the inverse of `to_lattice`."""
        c, s = jnp.cos(self.angle), jnp.sin(self.angle)
        p = self.origin + jnp.stack([c * q[0] - s * q[1], s * q[0] + c * q[1]])
        return _project(jnp.linalg.inv(self.homography), p)

    def locate(self, q: Array) -> TilePlace:
        """The tile that holds the lattice point `q` (2,)."""
        course = jnp.floor(q[1] / self.tile_height)
        return self._place_in_course(q, course)

    def coverage(self, point: Array, *, blur: ArrayLike) -> Array:
        """How much of a Gaussian spot of standard deviation `blur` image pixels around `point` (2,) is tile.

        1 inside tiles, 0 inside joints wider than the spot; smooth and differentiable in every parameter. For square
        corners and one scale all over the spot it is the exact convolution of the binary mask with the Gaussian, so a
        mask blurred by the same amount can be compared with it at every scale without bias. At rounded corners it is
        within 0.01 for radii up to 0.4 of a tile's shorter side, and within 0.03 where the homography stretches one
        direction by a quarter more than the other. `blur` must be > 0; the spot is taken to reach only the nearest bed
        joint and head joints, so keep it below a quarter of a tile's shorter side.
        """
        square = self.square_coverage(point, blur=blur)
        # A radius of a hundredth of the spot takes away 1e-5 at most. The answer is one for all points, so that under
        # vmap this stays a branch, and square corners cost nothing.
        return square - lax.cond(
            self.corner_radius > 0.01 * jnp.asarray(blur),
            lambda: self._lost_at_corners(point, blur),
            lambda: jnp.zeros_like(square),
        )

    def square_coverage(self, point: Array, *, blur: ArrayLike) -> Array:
        """`coverage` as if the corners were square: what a fit needs, several times cheaper to compile."""
        own, beside = self._spots(point, blur)
        return own.covered() + beside.covered()

    def near_courses(self, q: Array) -> Array:
        """The course that holds the lattice point `q` (2,), and the course beyond the nearest bed joint: (2,)."""
        own = jnp.floor(q[1] / self.tile_height)
        return jnp.stack([own, own + jnp.where(q[1] - own * self.tile_height < 0.5 * self.tile_height, -1.0, 1.0)])

    def spot_in_course(self, q: Sequence[Array] | Array, blur: Sequence[Array] | Array, course: Array) -> Spot:
        """A Gaussian spot at the lattice point `q` (2,), of standard deviations `blur` (2,), seen from a course."""
        place = self._place_in_course(q, course)
        to_head = jnp.minimum(place.left, place.right)
        return Spot(
            this=(to_head - 0.5 * self.mortar_x) / blur[0],
            next=(-to_head - 0.5 * self.mortar_x) / blur[0],
            top=(place.top - 0.5 * self.mortar_y) / blur[1],
            bottom=(place.bottom - 0.5 * self.mortar_y) / blur[1],
        )

    def _lost_at_corners(self, point: Array, blur: ArrayLike) -> Array:
        own, beside = self._spots(point, blur)
        # The four tiles at the nearest crossing of joints.
        inside_x = jnp.stack([own.this, own.next, beside.this, beside.next])
        own_y, beside_y = jnp.minimum(own.top, own.bottom), jnp.minimum(beside.top, beside.bottom)
        inside_y = jnp.stack([own_y, own_y, beside_y, beside_y])
        along, across = self._blur_in_lattice(point, blur)
        return jnp.sum(corner_defect(inside_x, inside_y, self.corner_radius / jnp.sqrt(along * across)))

    def _spots(self, point: Array, blur: ArrayLike) -> tuple[Spot, Spot]:
        """A Gaussian spot as seen from the course it is in, and from the course beyond the nearest bed joint."""
        q, stretched = self.to_lattice(point), self._blur_in_lattice(point, blur)
        own, beside = self.near_courses(q)
        return self.spot_in_course(q, stretched, own), self.spot_in_course(q, stretched, beside)

    def _place_in_course(self, q: Sequence[Array] | Array, course: Array) -> TilePlace:
        rows = jnp.asarray(self.course_lengths)
        shift = self.offset * course + _take(jnp.asarray(self.course_offsets), course)
        lengths, ends = _take(rows, course), _take(jnp.cumsum(rows, axis=1), course)
        along = q[0] / self.tile_width - shift
        repeat = jnp.floor(along / ends[-1])
        along = along - repeat * ends[-1]
        number = jnp.sum(along >= ends[:-1])
        length, right = _take(lengths, number), _take(ends, number) - along
        return TilePlace(
            course=course,
            tile=repeat * lengths.shape[0] + number,
            left=(length - right) * self.tile_width,
            right=right * self.tile_width,
            top=q[1] - course * self.tile_height,
            bottom=(course + 1) * self.tile_height - q[1],
        )

    def _blur_in_lattice(self, point: Array, blur: ArrayLike) -> Array:
        """Standard deviations (2,) of an image-space Gaussian along q_x and q_y (the homography stretches it)."""
        h, p = self.homography, self.to_plane(point)
        c, s = jnp.cos(self.angle), jnp.sin(self.angle)
        depth = h[2, 0] * point[0] + h[2, 1] * point[1] + h[2, 2]
        # The image gradients of p_x and p_y, times the depth.
        x_dx, x_dy = h[0, 0] - p[0] * h[2, 0], h[0, 1] - p[0] * h[2, 1]
        y_dx, y_dy = h[1, 0] - p[1] * h[2, 0], h[1, 1] - p[1] * h[2, 1]
        along = jnp.sqrt((c * x_dx + s * y_dx) ** 2 + (c * x_dy + s * y_dy) ** 2)
        across = jnp.sqrt((c * y_dx - s * x_dx) ** 2 + (c * y_dy - s * x_dy) ** 2)
        return jnp.stack([along, across]) * (jnp.asarray(blur) / jnp.abs(depth))


# So many entries are chosen from by comparing, which unlike a gather is fused with what stands around it.
_FEW = 8


def _take(entries: Array, index: Array) -> Array:
    """Entry `index` of an array, counted round: 0 follows the last."""
    count = entries.shape[0]
    if count > _FEW:
        return entries[index.astype(int) % count]
    taken = entries[0]
    for number in range(1, count):
        taken = jnp.where(index % count == number, entries[number], taken)
    return taken


def _project(h: Array, point: Array) -> Array:
    # Written out: as matrix products these would run in reduced precision on some accelerators, and would keep the
    # compiler from fusing a grid of points into one loop.
    x, y = point[0], point[1]
    depth = h[2, 0] * x + h[2, 1] * y + h[2, 2]
    return jnp.stack([h[0, 0] * x + h[0, 1] * y + h[0, 2], h[1, 0] * x + h[1, 1] * y + h[1, 2]]) / depth


def make_tiling(
    *,
    tile_width: ArrayLike,
    tile_height: ArrayLike,
    angle: ArrayLike = 0.0,
    mortar_x: ArrayLike = 0.0,
    mortar_y: ArrayLike = 0.0,
    offset: ArrayLike = 0.0,
    origin: npt.ArrayLike = (0.0, 0.0),
    homography: npt.ArrayLike | None = None,
    corner_radius: ArrayLike = 0.0,
    course_offsets: npt.ArrayLike = (0.0,),
    course_lengths: npt.ArrayLike = ((1.0,),),
    bond: str | None = None,
) -> Tiling:
    """Make a `Tiling` from plain numbers, checking them. `angle` in radians.

    Without `bond` its name follows from the arrays where that is certain: stack, running or raking.

    Raises:
        ValueError: sizes that are not positive, negative joints, joints that leave no tile, corners rounder than the
            tiles, a singular homography, wrong shapes, numbers that are not finite, an unknown bond.

    Examples:
        >>> make_tiling(tile_width=60, tile_height=20, offset=0.5).bond
        'running'
    """
    arrays = {
        "tile_width": (tile_width, ()),
        "tile_height": (tile_height, ()),
        "angle": (angle, ()),
        "mortar_x": (mortar_x, ()),
        "mortar_y": (mortar_y, ()),
        "offset": (offset, ()),
        "origin": (origin, (2,)),
        "homography": (jnp.eye(3) if homography is None else homography, (3, 3)),
        "corner_radius": (corner_radius, ()),
        "course_offsets": (course_offsets, (None,)),
        "course_lengths": (course_lengths, (None, None)),
    }
    leaves = {name: _as_leaf(name, value, shape) for name, (value, shape) in arrays.items()}
    _check_sizes(leaves)
    _check_homography(leaves["homography"])
    if bond is None:
        bond = _name_bond(leaves)
    if bond not in BONDS:
        raise ValueError(f"bond {bond!r} is not one of {', '.join(BONDS)}")
    return Tiling(**leaves, bond=bond)


def _as_leaf(name: str, value: npt.ArrayLike, shape: tuple[int | None, ...]) -> Array:
    array = jnp.asarray(value)
    # With its type given an array is never "weakly" typed: numbers and arrays make the same, compiled once.
    floating = jnp.issubdtype(array.dtype, jnp.floating)
    array = jnp.asarray(array, dtype=array.dtype if floating else jnp.result_type(float))
    fits = array.ndim == len(shape) and all(n is None or n == m for n, m in zip(shape, array.shape, strict=True))
    if not fits or array.size == 0:
        wanted = "x".join("n" if n is None else str(n) for n in shape) or "a single number"
        raise ValueError(f"{name} has shape {array.shape}; it must be {wanted}")
    if not bool(jnp.all(jnp.isfinite(array))):
        raise ValueError(f"{name} must be finite, not {array}")
    return array


def _check_sizes(leaves: dict[str, Array]) -> None:
    for name in ("tile_width", "tile_height", "course_lengths"):
        if float(leaves[name].min()) <= 0:
            raise ValueError(f"{name} must be > 0, not {float(leaves[name].min()):g}")
    for name in ("mortar_x", "mortar_y", "corner_radius"):
        if float(leaves[name]) < 0:
            raise ValueError(f"{name} must be >= 0, not {float(leaves[name]):g}")
    shortest = float(leaves["tile_width"] * leaves["course_lengths"].min())
    height = float(leaves["tile_height"])
    sides = []
    for name, pitch, of in (("mortar_x", shortest, "shortest tile"), ("mortar_y", height, "course")):
        mortar = float(leaves[name])
        if mortar >= pitch:
            raise ValueError(f"{name} = {mortar:g} leaves nothing of a {of} of {pitch:g}; make it smaller")
        sides.append(pitch - mortar)
    radius = float(leaves["corner_radius"])
    if radius > 0.5 * min(sides) * (1.0 + 1e-6):
        raise ValueError(f"corner_radius = {radius:g} is more than half a tile's shorter side, {min(sides):g}")


def _check_homography(homography: Array) -> None:
    h = np.asarray(homography, dtype=np.float64)
    if abs(np.linalg.det(h)) <= 1e-12 * np.prod(np.linalg.norm(h, axis=1)):
        raise ValueError("homography is singular: it maps the picture onto a line, so no tiling can be seen in it")


def _name_bond(leaves: dict[str, Array]) -> str:
    if leaves["course_offsets"].shape[0] > 1 or leaves["course_lengths"].shape[0] > 1:
        return "irregular"
    fraction = float(leaves["offset"] % 1.0)
    if min(fraction, 1.0 - fraction) < 0.02:
        return "stack"
    return "running" if abs(fraction - 0.5) < 0.02 else "raking"
