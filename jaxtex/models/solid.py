"""A solid texture as a block of voxels: sampled at any point of space, periodically or without a visible period.

What a point reads is put in an order that depends on what is read, not on how the point was rounded (even voxels before
odd ones): XLA computes a point anew wherever it is used, with other last bits, and may find it on either side of a
voxel's centre. Either way it must get the same colour.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy.typing as npt
from jax import Array

from jaxtex.core.hashing import hash_cell

_CELL = 0.5  # of the block's shortest side: the edge of the lattice that random offsets are drawn on
_REACH = 0.5  # squared, in edges: how far a corner's weight reaches, the height of the tetrahedra
_SHARPNESS = 4  # of the weights: how soon one corner's reading gives way to the next

# Which of three numbers are odd where their sum is even, and where it is odd.
_ODD = ((0, 0, 0), (0, 1, 1), (1, 0, 1), (1, 1, 0)), ((1, 1, 1), (1, 0, 0), (0, 1, 0), (0, 0, 1))


class RandomOffsets(eqx.Module):
    """How a block is repeated without a visible period.

    Attributes:
        seed: uint32; another one, another solid.
        mean: [channel], of the block: what readings are blended about.
        least, greatest: [channel], of the block: what colours stay within.
    """

    seed: Array
    mean: Array
    least: Array
    greatest: Array


class Solid(eqx.Module):
    """A solid texture that fills space with a block of voxels.

    Points are (x, y, z) in voxels: x right, y down, z into the block. The centre of `voxels[k, j, i]` is the point
    (i + 0.5, j + 0.5, k + 0.5); between centres colours are trilinear, and beyond the block it repeats.

    With `offsets` the repetition has no visible period: space is divided into tetrahedra whose corners read the block
    each at its own random offset, a whole number of voxels, and their readings c are blended by smooth weights w as
    m + sum w (c - m) / sqrt(sum w^2), where m is the block's mean. Mean, variance and covariance are the block's (E.
    Heitz and F. Neyret, "High-Performance By-Example Noise using a Histogram-Preserving Blending Operator", 2018,
    section 3; here in three dimensions, with the weights of K. Perlin's simplex noise, which are smooth where theirs
    have creases). It is an approximation: the paper makes the histogram Gaussian before it blends, and undoes it after;
    here colours are blended as they are, and clipped to the block's range. Where readings mix, histograms draw near to
    a Gaussian's, and structures larger than the cells (half the block's shortest side) overlap.

    Attributes:
        voxels: [z, y, x, channel], linear light, of any floating type.
        offsets: of the repetition; None for the plain one.
    """

    voxels: Array
    offsets: RandomOffsets | None = None

    @property
    def size(self) -> tuple[int, int, int]:
        """Sides of the block along x, y and z, in voxels."""
        depth, height, width, _ = self.voxels.shape
        return width, height, depth

    def colour(self, point: Array) -> Array:
        """The colour [channel] at a point (3,). Without random offsets, it is that of the block, exact at centres."""
        if self.offsets is None:
            return self._read(point, jnp.zeros(3, jnp.int32))
        seed, mean = self.offsets.seed, self.offsets.mean
        corners, weights = _lattice_corners(point / (_CELL * min(self.size)))
        readings = jax.vmap(lambda corner: self._read(point, _draw_offset(corner, seed, self.size)))(corners)
        blended = mean + weights @ (readings - mean[None]) / jnp.sqrt(jnp.sum(weights**2))
        return jnp.clip(blended, self.offsets.least, self.offsets.greatest)

    def _read(self, point: Array, offset: Array) -> Array:
        """Trilinear between the eight voxels about a point that is moved by whole voxels."""
        place = point - 0.5
        first = jnp.floor(place).astype(jnp.int32)
        even, odd = first + 1 & ~1, first | 1
        past = place - even
        to_odd = jnp.where(past >= 0, past, -past)  # has a slope also where it is 0
        pairs = jnp.stack([even, odd]) + offset[None]
        x, y, z = (pairs[:, axis] % side for axis, side in enumerate(self.size))
        cube = self.voxels[z[:, None, None], y[None, :, None], x[None, None, :]]
        for share in to_odd[::-1]:
            cube = (1 - share) * cube[0] + share * cube[1]  # exact at either
        return cube


def make_solid(voxels: npt.ArrayLike, *, offsets_seed: int | None = None) -> Solid:
    """A `Solid` from a block of voxels.

    Args:
        voxels: [z, y, x, channel], linear light, of any floating type.
        offsets_seed: of the random offsets that hide the period, 0 to 2^32 - 1; None for plain repetition.

    Raises:
        ValueError: voxels that are no such array, NaN or infinite values, or a seed out of range.

    Examples:
        >>> ramp = make_solid(jnp.arange(24.0).reshape(2, 3, 4, 1))
        >>> ramp.colour(jnp.array([1.5, 0.5, 0.5])).tolist(), ramp.colour(jnp.array([2.0, 0.5, 2.5])).tolist()
        ([1.0], [1.5])
    """
    block = jnp.asarray(voxels)
    if block.ndim != 4 or 0 in block.shape:
        raise ValueError(f"voxels of shape {block.shape} are no block; give [z, y, x, channel], none empty")
    if not jnp.issubdtype(block.dtype, jnp.floating):
        raise ValueError(f"voxels are {block.dtype}; give linear light as floating-point numbers")
    if not bool(jnp.isfinite(block).all()):
        raise ValueError("voxels: some values are NaN or infinite; replace them")
    if offsets_seed is None:
        return Solid(block)
    if not 0 <= offsets_seed < 2**32:
        raise ValueError(f"offsets_seed: {offsets_seed} is out of range; give a whole number from 0 to {2**32 - 1}")
    mean = jnp.mean(block, axis=(0, 1, 2), dtype=jnp.promote_types(block.dtype, jnp.float32))
    ends = jnp.min(block, axis=(0, 1, 2)), jnp.max(block, axis=(0, 1, 2))
    return Solid(block, RandomOffsets(jnp.asarray(offsets_seed, jnp.uint32), mean, *ends))


def _draw_offset(corner: Array, seed: Array, size: tuple[int, int, int]) -> Array:
    """Random voxels (3,) by which a corner of the lattice is off when it reads a block of such sides."""
    drawn = jnp.stack([hash_cell(corner, salt=3 * seed + jnp.uint32(axis)) for axis in range(3)])
    return (drawn % jnp.array(size, jnp.uint32)).astype(jnp.int32)


def _lattice_corners(place: Array) -> tuple[Array, Array]:
    """The corners of the tetrahedron that a place (3,) lies in, in half edges, int32 [corner, 3], and their weights.

    The lattice is the body-centred cubic one: whole numbers, and those with a half added to each. Either half of it
    falls into points of an even and of an odd sum, and each tetrahedron has a corner of each of these four kinds: the
    nearest of its kind. A weight falls to 0, smoothly, where the corner's own tetrahedra end, and there is no other
    point of its kind within that reach.
    """
    points = place[None] - jnp.array([0.0, 0.5], place.dtype)[:, None]
    even, odd = 2 * jnp.round(points / 2), 2 * jnp.round((points - 1) / 2) + 1
    # Of each half [2], kind [2] and way [4] to be of that kind.
    ways = jnp.where(jnp.array(_ODD, bool)[None], odd[:, None, None], even[:, None, None])
    away = jnp.sum((points[:, None, None] - ways) ** 2, axis=-1)
    nearest = jnp.argmin(away, axis=-1)
    corners = jnp.take_along_axis(ways, nearest[..., None, None], axis=2)[:, :, 0].astype(jnp.int32)
    halves = 2 * corners + jnp.arange(2)[:, None, None]
    weights = jnp.maximum(_REACH - jnp.min(away, axis=-1), 0.0) ** _SHARPNESS
    return halves.reshape(4, 3), weights.reshape(4)
