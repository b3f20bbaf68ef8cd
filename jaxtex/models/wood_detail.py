"""What wood shows beyond its rings: fibres and pores, and by how much one plank's rings were seen displaced."""

import math

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.typing import ArrayLike

from jaxtex.core.hashing import random_of_cell
from jaxtex.models.waves import cosine

_LONG = 24.0  # times as long as broad: fibres, and pores
_COARSE = 2.5  # times as broad: the bundles that fibres lie in
_MIXED = 0.8, 0.6  # how strong fibres are, and bundles; squared, they add up to 1
_CELL = 2.5  # fibres' breadths: from pore to pore at most
_PORE = 0.36  # of that: a pore's radius
_DARK = 0.4, 0.5, 0.6  # by how much of red, green and blue light a pore is darker
_SPREAD = math.sqrt((1 - 2 * 9 / 70) ** 3 / 3)  # root mean square of smoothed noise between -1 and 1
_FADE = 0.12  # of its side: how fast a plank's displacement fades beyond its picture, and below its face


class Fibres(eqx.Module):
    """The fine grain of wood: streaks along the trunk, and pores, short dark lines among them.

    Attributes:
        contrast: root mean square of the streaks' lightness, relative to the wood's, >= 0.
        width: how broad they are, in pixels, > 0.
        pores: (2,), share of early and of late wood that is pores, 0 to 0.25.

    Examples:
        >>> fibres = Fibres(jnp.array(0.1), jnp.array(2.0), jnp.zeros(2))
        >>> fibres.tone(jnp.zeros(3), 1.0, blur=100.0).tolist()
        [1.0, 1.0, 1.0]
    """

    contrast: Array
    width: Array
    pores: Array

    def check(self) -> None:
        """Refuse what are no fibres.

        Raises:
            ValueError: a number that is out of range or not finite.
        """
        limits = (("contrast", (), 0.0, 1.0), ("width", (), 1e-6, math.inf), ("pores", (2,), 0.0, 0.25))
        for name, shape, low, high in limits:
            value = np.asarray(getattr(self, name))
            if value.shape != shape or not ((low <= value) & (value <= high) & np.isfinite(value)).all():
                told = "two numbers" if shape else "one number"
                raise ValueError(f"fibres.{name} is {value.tolist()}; it must be {told}, {low:g} to {high:g}")

    def tone(self, trunk: Array, early: ArrayLike, *, blur: ArrayLike) -> Array:
        """What the wood's colour at a trunk point (3,), so much of which is `early` wood, is multiplied by (3,), seen
        through a spot of `blur` pixels."""
        fine, coarse = (self._streaks(trunk, scale, blur, salt) for salt, scale in enumerate((1.0, _COARSE)))
        streaks = jnp.maximum(1.0 + self.contrast * (_MIXED[0] * fine + _MIXED[1] * coarse), 0.1)
        share = self.pores[1] + early * (self.pores[0] - self.pores[1])
        return streaks * (1.0 - jnp.array(_DARK, trunk.dtype) * self._pore(trunk, share, blur))

    def _streaks(self, trunk: Array, scale: float, blur: ArrayLike, salt: int) -> Array:
        """Noise of unit strength; a spot as broad as its streaks sees it fade."""
        stretch = jnp.array([1.0, 1.0, 1 / _LONG], trunk.dtype) / (self.width * scale)
        return _noise(trunk * stretch, salt) / _SPREAD * _seen(blur, self.width * scale)

    def _pore(self, trunk: Array, share: Array, blur: ArrayLike) -> Array:
        """How much of a pore there is, 0 to 1, where pores take up such a share."""
        size = self.width * _CELL
        cell = jnp.floor(trunk[:2] / size)
        # Each column of cells begins elsewhere along the trunk, or pores would stand in rows.
        along = trunk[2] / (size * _LONG / _CELL) + _random(cell, jnp.zeros(()), 2)
        layer = jnp.floor(along)
        there = _random(cell, layer, 3) < share / (math.pi * _PORE**2 * 0.7)
        place = 0.5 + (0.5 - _PORE) * (2 * jnp.stack([_random(cell, layer, 4), _random(cell, layer, 5)]) - 1)
        aside = jnp.sum((trunk[:2] / size - cell - place) ** 2) / _PORE**2
        ends = (2 * (along - layer) - 1) ** 4
        return there * jnp.clip(2.0 * (1.0 - aside - ends), 0.0, 1.0) * _seen(blur, self.width)


class Displacement(eqx.Module):
    """By how much the rings of a plank were seen displaced: a cosine series over its picture.

    The picture's x runs along (cos turn, sin turn) of the plank's u and v. The displacement is the sum over i and j of
    `cosines[i, j] cos(pi i y) cos(pi j x)`, where x and y go from 0 to 1 over the picture. Away from it, it fades.

    Attributes:
        cosines: (I, J), pixels outwards.
        extent: (2,), width and height of the picture.
        middle: (2,), u and v of the picture's middle.
        turn: of the picture on the plank, radians.

    Examples:
        >>> there = Displacement(jnp.array([[3.0, 1.0]]), jnp.array([200.0, 100.0]), jnp.zeros(2), jnp.array(0.0))
        >>> [each.item() for each in there(jnp.array(-100.0), jnp.array(0.0), jnp.array(0.0))]
        [4.0, 1.0]
    """

    cosines: Array
    extent: Array
    middle: Array
    turn: Array

    def check(self) -> None:
        """Refuse what is no displacement.

        Raises:
            ValueError: numbers that are not finite, too few of them, or a picture without extent.
        """
        if not all(np.isfinite(leaf).all() for leaf in (self.cosines, self.extent, self.middle, self.turn)):
            raise ValueError("the displacement holds numbers that are not finite")
        if np.ndim(self.cosines) != 2 or np.size(self.cosines) == 0:
            raise ValueError(f"displacement.cosines has the shape {np.shape(self.cosines)}; it must be a matrix")
        if not (np.asarray(self.extent) > 0).all():
            raise ValueError(f"displacement.extent is {np.asarray(self.extent).tolist()}; it must be more than 0")

    def __call__(self, u: Array, v: Array, depth: Array) -> tuple[Array, Array]:
        """The displacement at a plank's point and below its face; and how much it counts there, 1 on the picture."""
        c, s = jnp.cos(self.turn), jnp.sin(self.turn)
        right, down = u - self.middle[0], v - self.middle[1]
        place = jnp.stack([c * right + s * down, c * down - s * right]) / self.extent + 0.5
        terms = zip(self.cosines.shape[::-1], place, strict=True)
        x, y = (cosine(0.5 * jnp.arange(count, dtype=p.dtype) * p) for count, p in terms)
        beyond = jnp.maximum(jnp.abs(place - 0.5) - 0.5, 0.0)
        beneath = depth / jnp.max(self.extent)
        return y @ self.cosines @ x, jnp.exp(-0.5 * (jnp.sum(beyond**2) + beneath**2) / _FADE**2)


def _seen(blur: ArrayLike, width: Array) -> Array:
    """How much of streaks of a breadth a Gaussian spot sees: of a wave that is four times as long."""
    return jnp.exp(-0.5 * (0.5 * jnp.pi * blur / width) ** 2)


def _noise(at: Array, salt: int) -> Array:
    """Random values between -1 and 1 on whole numbers (3,), smooth between them."""
    corner = jnp.floor(at)
    part = at - corner
    part = part * part * (3 - 2 * part)
    total = jnp.zeros_like(part[0])
    for n in range(8):
        offset = jnp.array([n & 1, n >> 1 & 1, n >> 2 & 1])
        weight = jnp.prod(jnp.where(offset == 1, part, 1 - part))
        total = total + weight * (2 * _random((corner + offset)[:2], (corner + offset)[2], salt) - 1)
    return total


def _random(cell: Array, layer: Array, salt: int) -> Array:
    """A number between 0 and 1 that looks random, of a cell (2,) and layer of whole numbers."""
    return random_of_cell(jnp.stack([cell[0], cell[1], layer]), salt=salt)
