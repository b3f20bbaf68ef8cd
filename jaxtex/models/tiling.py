"""Rectangular tilings: the forward model, evaluated at one point of the picture.

The way of a point (Lefebvre & Poulin 2000, section 2 and figure 2, with the extensions they propose):

    image point --homography--> plane point p --> q = R(-angle) (p - origin)
    course j = floor(q_y / tile_height),  tile i = floor(q_x / tile_width - offset * j)

Joints are centred on the lattice lines. Everything is a pure function of one point; callers ``vmap``.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jax import Array
from jax.typing import ArrayLike

BONDS = ("stack", "running", "raking", "english", "flemish", "irregular")


class TilePlace(NamedTuple):
    """Where a point lies in a tiling: which tile, and how far from that tile's four lattice lines (plane pixels)."""

    course: Array
    tile: Array
    left: Array
    right: Array
    top: Array
    bottom: Array


class Tiling(eqx.Module):
    """A rectangular tiling seen in a photograph (Lefebvre & Poulin 2000, section 2).

    All lengths are plane pixels, which are image pixels where ``homography`` is the identity; tile sizes are pitches,
    joint included. Departures from the paper's six parameters: two joint thicknesses instead of one, a homography so
    that an oblique photograph needs no rectifying, rounded corners, and courses that may differ in their tile
    lengths and be shifted freely.

    Parameters
    ----------
    tile_width, tile_height : ()
        Pitch along and across the courses, > 0.
    angle : ()
        Direction of the courses in radians, from x (right) towards y (down).
    mortar_x, mortar_y : ()
        Gap between tiles of one course, and between courses, >= 0.
    offset : ()
        Shift of each course against the one before it, as a fraction of ``tile_width``.
    origin : (2,)
        A lattice node (x, y): the start of tile 0 of course 0.
    homography : (3, 3)
        Image point to plane point.
    corner_radius : ()
        Radius of the tiles' rounded corners, >= 0.
    course_offsets : (C,)
        Further shift of course j, entry ``j mod C``, as a fraction of ``tile_width``.
    course_lengths : (D, L)
        Lengths of consecutive tiles in course j, row ``j mod D``, in units of ``tile_width``; the row repeats.
    bond : str
        One of :data:`BONDS`. A name for people and files; the geometry is in the arrays.

    Examples
    --------
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
        h = self.homography
        return (h[:2, :2] @ point + h[:2, 2]) / (h[2, :2] @ point + h[2, 2])

    def to_lattice(self, point: Array) -> Array:
        """Image point (2,) to lattice coordinates q (2,), in plane pixels along and across the courses."""
        p = self.to_plane(point) - self.origin
        c, s = jnp.cos(self.angle), jnp.sin(self.angle)
        return jnp.stack([c * p[0] + s * p[1], c * p[1] - s * p[0]])

    def from_lattice(self, q: Array) -> Array:
        """Lattice coordinates (2,) back to the image point (2,): the inverse of :meth:`to_lattice`."""
        c, s = jnp.cos(self.angle), jnp.sin(self.angle)
        p = self.origin + jnp.stack([c * q[0] - s * q[1], s * q[0] + c * q[1]])
        h = jnp.linalg.inv(self.homography)
        return (h[:2, :2] @ p + h[:2, 2]) / (h[2, :2] @ p + h[2, 2])

    def locate(self, q: Array) -> TilePlace:
        """The tile that holds the lattice point ``q`` (2,)."""
        course = jnp.floor(q[1] / self.tile_height)
        return self._place_in_course(q, course)

    def coverage(self, point: Array, *, blur: ArrayLike) -> Array:
        """How much of a Gaussian spot of standard deviation ``blur`` image pixels around ``point`` (2,) is tile.

        1 inside tiles, 0 inside joints wider than the spot; smooth and differentiable in every parameter. Away from
        rounded corners it is the exact convolution of the binary mask with the Gaussian, so a mask blurred by the same
        amount can be compared with it at every scale without bias. ``blur`` must be > 0 and well below a tile's size.
        """
        q = self.to_lattice(point)
        blur_x, blur_y = self._blur_in_lattice(point, blur)
        course = jnp.floor(q[1] / self.tile_height)
        # The nearest other course shares the bed joint with this one: a spot on the joint sees both.
        beside = course + jnp.where(q[1] - course * self.tile_height < 0.5 * self.tile_height, -1.0, 1.0)
        return self._course_coverage(q, course, blur_x, blur_y) + self._course_coverage(q, beside, blur_x, blur_y)

    def _place_in_course(self, q: Array, course: Array) -> TilePlace:
        index = course.astype(int)
        shift = self.offset * course + self.course_offsets[index % self.course_offsets.shape[0]]
        lengths = self.course_lengths[index % self.course_lengths.shape[0]]
        ends = jnp.cumsum(lengths)
        along = q[0] / self.tile_width - shift
        repeat = jnp.floor(along / ends[-1])
        along = along - repeat * ends[-1]
        number = jnp.sum(along >= ends[:-1])
        right = ends[number] - along
        return TilePlace(
            course=course,
            tile=repeat * lengths.shape[0] + number,
            left=(lengths[number] - right) * self.tile_width,
            right=right * self.tile_width,
            top=q[1] - course * self.tile_height,
            bottom=(course + 1) * self.tile_height - q[1],
        )

    def _course_coverage(self, q: Array, course: Array, blur_x: Array, blur_y: Array) -> Array:
        place = self._place_in_course(q, course)
        to_head = jnp.minimum(place.left, place.right)
        head = _step((to_head + 0.5 * self.mortar_x) / blur_x) - _step((to_head - 0.5 * self.mortar_x) / blur_x)
        inside_top = place.top - 0.5 * self.mortar_y
        inside_bottom = place.bottom - 0.5 * self.mortar_y
        across = _step(inside_top / blur_y) + _step(inside_bottom / blur_y) - 1.0
        inside_x = jnp.maximum(to_head - 0.5 * self.mortar_x, 0.0)
        inside_y = jnp.maximum(jnp.minimum(inside_top, inside_bottom), 0.0)
        return across * (1.0 - head) * self._corner_factor(inside_x, inside_y, jnp.sqrt(blur_x * blur_y))

    def _corner_factor(self, inside_x: Array, inside_y: Array, blur: Array) -> Array:
        """What rounding leaves of the square corner; 1 outside corners, and everywhere for radius 0."""
        x = jnp.maximum(self.corner_radius - inside_x, 0.0)
        y = jnp.maximum(self.corner_radius - inside_y, 0.0)
        square = x * x + y * y
        # sqrt has no finite gradient at 0: the inner where keeps the unused branch away from it.
        distance = jnp.where(square > 0, jnp.sqrt(jnp.where(square > 0, square, 1.0)), 0.0)
        straight = _step((self.corner_radius - jnp.maximum(x, y)) / blur)
        return _step((self.corner_radius - distance) / blur) / straight

    def _blur_in_lattice(self, point: Array, blur: ArrayLike) -> tuple[Array, Array]:
        """Standard deviations of an image-space Gaussian along q_x and q_y (the homography stretches it)."""
        h = self.homography
        depth = h[2, :2] @ point + h[2, 2]
        jacobian = (h[:2, :2] - jnp.outer(self.to_plane(point), h[2, :2])) / depth
        c, s = jnp.cos(self.angle), jnp.sin(self.angle)
        along, across = jnp.stack([c, s]) @ jacobian, jnp.stack([-s, c]) @ jacobian
        return blur * jnp.sqrt(along @ along), blur * jnp.sqrt(across @ across)


def _step(x: Array) -> Array:
    """The unit step blurred by a unit Gaussian."""
    return 0.5 * (1.0 + jax.scipy.special.erf(x * 0.7071067811865476))


def make_tiling(
    *,
    tile_width: ArrayLike,
    tile_height: ArrayLike,
    angle: ArrayLike = 0.0,
    mortar_x: ArrayLike = 0.0,
    mortar_y: ArrayLike = 0.0,
    offset: ArrayLike = 0.0,
    origin: ArrayLike = (0.0, 0.0),
    homography: ArrayLike | None = None,
    corner_radius: ArrayLike = 0.0,
    course_offsets: ArrayLike = (0.0,),
    course_lengths: ArrayLike = ((1.0,),),
    bond: str | None = None,
) -> Tiling:
    """Make a :class:`Tiling` from plain numbers, checking them. ``angle`` in radians.

    Without ``bond`` its name follows from the arrays where that is certain: stack, running or raking.

    Raises
    ------
    ValueError
        For sizes that are not positive, negative joints, joints that leave no tile, wrong shapes, an unknown bond.

    Examples
    --------
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
    if bond is None:
        bond = _name_bond(leaves)
    if bond not in BONDS:
        raise ValueError(f"bond {bond!r} is not one of {', '.join(BONDS)}")
    return Tiling(**leaves, bond=bond)


def _as_leaf(name: str, value: ArrayLike, shape: tuple[int | None, ...]) -> Array:
    array = jnp.asarray(value)
    if not jnp.issubdtype(array.dtype, jnp.floating):
        array = array.astype(jnp.result_type(float))
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
    for mortar, pitch, of in (("mortar_x", shortest, "shortest tile"), ("mortar_y", float(leaves["tile_height"]), "course")):
        if float(leaves[mortar]) >= pitch:
            raise ValueError(f"{mortar} = {float(leaves[mortar]):g} leaves nothing of a {of} of {pitch:g}; make it smaller")


def _name_bond(leaves: dict[str, Array]) -> str:
    if leaves["course_offsets"].shape[0] > 1 or leaves["course_lengths"].shape[0] > 1:
        return "irregular"
    fraction = float(leaves["offset"] % 1.0)
    if min(fraction, 1.0 - fraction) < 0.02:
        return "stack"
    return "running" if abs(fraction - 0.5) < 0.02 else "raking"
