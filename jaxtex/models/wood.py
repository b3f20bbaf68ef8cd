"""Wood as a solid: rings around the axis of a trunk, cut by a plank.

Lefebvre & Poulin 2000, section 3. A plank's points (u, v) are pixels from the picture's centre, x right and y down; the
trunk's are (X, Y, Z), its axis along Z. The plank is turned in the picture by `rotation`, and leans by `tilt` against
the axis: at tilt 0 its grain runs along the trunk, at 90 degrees it is end grain.
"""

import math

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array
from jax.typing import ArrayLike
from numpy.typing import NDArray

from jaxtex.models.soft import soft_step
from jaxtex.models.waves import cosine
from jaxtex.models.wood_detail import Displacement, Fibres

_WAVES = 48
_ALONG = 0.3  # of the turbulence's frequency: that along the trunk
_RIGHT_ANGLE = math.pi / 2 + 1e-6  # in single precision a right angle is a little more than one
_PITH = 1e-3  # of the ring spacing: how far the pith is rounded, so that it has a gradient
_PERIODS = 3  # neighbouring rings that a spot may still see
_WIDEST = 0.5  # rings: beyond this width a spot sees but the fundamental of the rings, to nine digits
_ELSEWHERE = 300.0  # pixels by which fibres are moved for each radian of the turbulence's phases
_SHAPES = {"center": (2,), "early_rgb": (3,), "late_rgb": (3,)}  # the others are one number each
_LIMITS = {
    "ring_spacing": (1e-6, np.inf),
    "early_fraction": (0.0, 1.0),
    "turbulence_rms": (0.0, np.inf),
    "turbulence_frequency": (0.0, np.inf),
    "gradation": (0.0, 0.25),
}


class Wood(eqx.Module):
    """The wood of a trunk, and where a plank was cut from it (Lefebvre & Poulin 2000, section 3).

    Lengths are pixels of the plank's picture. Departures from the paper: turbulence is given by the displacement that
    it causes, its root mean square in pixels, whatever noise makes it; rings have soft edges as wide as the spot that
    looks at them.

    Attributes:
        center: (2,), the axis (xc, yc) in trunk coordinates.
        tilt: of the plank against the axis, radians, 0 to pi/2.
        rotation: of the plank in the picture, radians, 0 to pi; across the grain is (cos, sin), along it (-sin, cos).
        ring_spacing: from ring to ring, > 0.
        early_fraction: share of early wood, the lighter, in a period, 0 to 1.
        early_rgb, late_rgb: (3,), linear light.
        turbulence_rms: root mean square of the rings' displacement, >= 0.
        turbulence_frequency: of that displacement across the trunk, cycles per pixel, >= 0; along it, it is less.
        waves: (K, 3), the directions of the plane waves that the turbulence is made of, in units of its frequency.
        phases: (K,), theirs, radians.
        gradation: how gradually early wood darkens into late wood, which then ends sharply: standard deviation of that
            edge in rings, 0 to 0.25. The paper's rings have 0.
        fibres: fine grain, if any.
        displacement: by how much the rings of a photographed plank are displaced, if that is known. There it stands in
            place of turbulence.

    Examples:
        >>> plank = make_wood(center=(10.0, 0.0), ring_spacing=20.0)
        >>> plank.ring_count(plank.to_trunk(jnp.array([50.0, 7.0]))).round(3).item()
        2.0
    """

    center: Array
    tilt: Array
    rotation: Array
    ring_spacing: Array
    early_fraction: Array
    early_rgb: Array
    late_rgb: Array
    turbulence_rms: Array
    turbulence_frequency: Array
    waves: Array
    phases: Array
    gradation: Array | float = 0.0
    fibres: Fibres | None = None
    displacement: Displacement | None = None

    def to_trunk(self, point: Array) -> Array:
        """Plank point (u, v) to the trunk's (X, Y, Z)."""
        return jnp.stack(trunk_coordinates(point[0], point[1], tilt=self.tilt, rotation=self.rotation))

    def radius(self, trunk: Array) -> Array:
        """Distance of a trunk point (3,) from the axis, as turbulence has it; smooth at the pith."""
        displaced = self.turbulence(trunk)
        if self.displacement is not None:
            seen, weight = self.displacement(*self._below_plank(trunk))
            displaced = displaced + weight * (seen - displaced)
        return self._distance(trunk)[0] + displaced

    def ring_count(self, trunk: Array) -> Array:
        """How many rings lie between the axis and a trunk point (3,)."""
        return self.radius(trunk) / self.ring_spacing

    def turbulence(self, trunk: Array) -> Array:
        """By how much rings are displaced outwards at a trunk point (3,)."""
        # A product of matrices would be written to memory before its cosines are taken.
        turns = jnp.sum(self.waves * trunk[None, :], axis=1) * self.turbulence_frequency + self.phases / (2 * jnp.pi)
        return self.turbulence_rms * jnp.sqrt(2.0 / len(self.phases)) * jnp.sum(cosine(turns))

    def early_wood(self, trunk: Array, *, blur: ArrayLike) -> Array:
        """How much of a Gaussian spot of standard deviation `blur` pixels around a trunk point (3,) is early wood."""
        return self._early_share(trunk, blur / self.ring_spacing)

    def early_on_plank(self, point: Array, *, blur: ArrayLike) -> Array:
        """The same for a spot on the plank, around its point (u, v): along the grain it sees rings stretched."""
        trunk = self.to_trunk(point)
        _, outwards = self._distance(trunk)
        seen = jnp.sqrt(outwards[0] ** 2 + (outwards[1] * jnp.sin(self.tilt)) ** 2 + _PITH)
        return self._early_share(trunk, blur * seen / self.ring_spacing)

    def colour(self, trunk: Array, *, blur: ArrayLike) -> Array:
        """Linear colour (3,) at a trunk point (3,)."""
        return self.colour_of(self.early_wood(trunk, blur=blur), trunk, blur=blur)

    def colour_of(self, early: Array, trunk: Array, *, blur: ArrayLike) -> Array:
        """Linear colour (3,) at a trunk point (3,) of which so much is `early` wood."""
        rings = self.late_rgb + early * (self.early_rgb - self.late_rgb)
        if self.fibres is None:
            return rings
        # Wood of another seed has its fibres elsewhere.
        return rings * self.fibres.tone(trunk + _ELSEWHERE * self.phases[:3], early, blur=blur)

    def _early_share(self, trunk: Array, width: ArrayLike) -> Array:
        return early_share(self.ring_count(trunk), self.early_fraction, width, self.gradation)

    def _below_plank(self, trunk: Array) -> tuple[Array, Array, Array]:
        """The plank's u and v of a trunk point (3,), and how deep that lies below its face."""
        c, s, upright, lean = jnp.cos(self.rotation), jnp.sin(self.rotation), jnp.cos(self.tilt), jnp.sin(self.tilt)
        along = trunk[1] * lean + trunk[2] * upright
        return c * trunk[0] - s * along, s * trunk[0] + c * along, trunk[1] * upright - trunk[2] * lean

    def _distance(self, trunk: Array) -> tuple[Array, Array]:
        """From the axis, and the unit vector (2,) away from it."""
        aside = trunk[:2] - self.center
        distance = jnp.sqrt(jnp.sum(aside**2) + (_PITH * self.ring_spacing) ** 2)
        return distance, aside / distance


def trunk_coordinates(u: Array, v: Array, *, tilt: Array, rotation: Array) -> tuple[Array, Array, Array]:
    """Where points (u, v) of a plank, of any one shape, lie in the trunk: X, Y and Z, each of that shape."""
    c, s = jnp.cos(rotation), jnp.sin(rotation)
    along = c * v - s * u
    return c * u + s * v, along * jnp.sin(tilt), along * jnp.cos(tilt)


def canonical_pose(tilt: float, rotation: float) -> tuple[float, float, NDArray[np.float64]]:
    """Tilt in [0, pi/2] and rotation in [0, pi) that show the same plank, once the trunk's axes are mirrored (3,).

    Examples:
        >>> tilt, rotation, mirror = canonical_pose(-0.5, 4.0)
        >>> tilt, round(rotation, 4), mirror.tolist()
        (0.5, 0.8584, [-1.0, 1.0, -1.0])
    """
    tilt = math.remainder(tilt, 2 * math.pi)
    mirror = np.ones(3)
    if tilt < 0:
        tilt, mirror[1] = -tilt, -1.0
    if tilt > _RIGHT_ANGLE:
        tilt, mirror[2] = math.pi - tilt, -1.0
    turns = math.floor(rotation / math.pi)
    rotation -= turns * math.pi
    if rotation >= math.pi:  # by rounding: it was a hair below a half turn
        rotation, turns = 0.0, turns + 1
    return tilt, rotation, -mirror if turns % 2 else mirror


def early_share(count: ArrayLike, fraction: ArrayLike, width: ArrayLike, gradation: ArrayLike = 0.0) -> Array:
    """Share of early wood that a Gaussian spot sees, `width` rings wide, at a ring count.

    Early wood is where sin(2 pi count) > cos(pi fraction), which is the fraction of each ring around a quarter turn.

    Args:
        count, fraction, width: of shapes that broadcast; `count` in rings, `fraction` 0 to 1, `width` the spot's
            standard deviation in rings, >= 0.
        gradation: standard deviation, in rings, of the edge at which late wood comes on.

    Examples:
        >>> early_share(jnp.array([0.25, 0.75]), 0.4, 0.01).tolist()
        [1.0, 0.0]
    """
    width = jnp.maximum(width, 1e-6)
    narrow = jnp.minimum(width, _WIDEST)
    gradual = jnp.sqrt(narrow**2 + jnp.asarray(gradation) ** 2)
    turn = jnp.asarray(count) - 0.25
    aside = turn - jnp.round(turn)
    mean = jnp.asarray(fraction)
    half = mean / 2
    share = jnp.zeros_like(aside)
    for n in range(-_PERIODS, _PERIODS + 1):
        share = share + soft_step((aside - n + half) / narrow) - soft_step((aside - n - half) / gradual)
    # A wider spot sees the fundamental fade as its Gaussian has it, and the mean of early and late wood stay.
    fading = jnp.exp(-2 * jnp.pi**2 * (width**2 - narrow**2))
    return mean + (share - mean) * fading


def make_wood(
    *,
    ring_spacing: ArrayLike,
    center: npt.ArrayLike = (0.0, 0.0),
    tilt: ArrayLike = 0.0,
    rotation: ArrayLike = 0.0,
    early_fraction: ArrayLike = 0.6,
    early_rgb: npt.ArrayLike = (0.55, 0.33, 0.17),
    late_rgb: npt.ArrayLike = (0.27, 0.13, 0.06),
    turbulence_rms: ArrayLike = 0.0,
    turbulence_frequency: ArrayLike = 0.005,
    gradation: ArrayLike = 0.0,
    fibres: Fibres | None = None,
    displacement: Displacement | None = None,
    seed: int = 0,
) -> Wood:
    """A `Wood` from plain numbers; the turbulence's shape is that of the `seed`.

    Args:
        ring_spacing, center, tilt, rotation, early_fraction, early_rgb, late_rgb, turbulence_rms, turbulence_frequency,
            gradation, fibres, displacement: as `Wood` has them.
        seed: whole number, >= 0.

    Raises:
        ValueError: a number that is out of range or not finite, or too many or too few of them.

    Examples:
        >>> make_wood(ring_spacing=20.0, tilt=0.3).early_on_plank(jnp.array([5.0, 0.0]), blur=0.5).round(2).item()
        1.0
    """
    given = {
        "center": center,
        "tilt": tilt,
        "rotation": rotation,
        "ring_spacing": ring_spacing,
        "early_fraction": early_fraction,
        "early_rgb": early_rgb,
        "late_rgb": late_rgb,
        "turbulence_rms": turbulence_rms,
        "turbulence_frequency": turbulence_frequency,
        "gradation": gradation,
    }
    numbers = {name: _checked(name, value) for name, value in given.items()}
    for part in (fibres, displacement):
        if part is not None:
            part.check()
    waves, phases = _draw_waves(seed)
    values = {name: jnp.asarray(value, float) for name, value in numbers.items()}
    return Wood(**values, waves=waves, phases=phases, fibres=fibres, displacement=displacement)


def _checked(name: str, value: npt.ArrayLike) -> NDArray[np.float64]:
    """The numbers of a parameter, once they are known to be as many as it has, finite and in its range."""
    numbers = np.asarray(value, float)
    shape = _SHAPES.get(name, ())
    if numbers.shape != shape:
        raise ValueError(f"{name} has the shape {numbers.shape}; it must be {shape or 'one number'}")
    if not np.isfinite(numbers).all():
        raise ValueError(f"{name} is {numbers.tolist()}; it must be finite")
    low, high = _LIMITS.get(name, (-np.inf, np.inf))
    if not np.all((low <= numbers) & (numbers <= high)):
        most = f" and at most {high:g}" if high < np.inf else ""
        raise ValueError(f"{name} is {numbers.tolist()}; it must be at least {low:g}{most}")
    return numbers


def _draw_waves(seed: int) -> tuple[Array, Array]:
    """Directions all around, each about one unit long: turbulence has its frequency, give or take a third.

    Along the trunk it is slower, as the fibres that grow there are long.
    """
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(_WAVES, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    waves = directions * np.exp(rng.normal(0.0, 0.3, (_WAVES, 1))) * np.array([1.0, 1.0, _ALONG])
    return jnp.asarray(waves, float), jnp.asarray(rng.uniform(0.0, 2 * np.pi, _WAVES), float)
