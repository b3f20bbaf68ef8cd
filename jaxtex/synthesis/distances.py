"""How far a texture is from its exemplar, as distributions of small patches: the sliced Wasserstein distance.

Patches of the exemplar and of the texture are two clouds of points. Along a line, the Wasserstein distance of two
clouds is known exactly, as their points are matched in order; the sliced distance takes many lines at random (J. Rabin,
G. Peyré, J. Delon and M. Bernot, "Wasserstein barycenter and its application to texture mixing", SSVM 2011). Patches
are taken scale by scale from a Laplacian pyramid (T. Karras, T. Aila, S. Laine and J. Lehtinen, "Progressive growing of
GANs", ICLR 2018, section 5), as the coarse contrast of whole patches would hide whether detail is right.

Departures: each scale is counted in units of the exemplar's contrast there, rather than both pictures being brought to
the same contrast; the distance along a line is exact for pictures of different size; and patches are never stored, as
their projections are correlations of the picture with a patch of random weights.

Like every such distance it is flattered by copying: a picture that repeats the exemplar is nearest of all. Show the
copied share (`jaxtex.synthesis.copying`) beside it.
"""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.core.compiling import SAME_EVERY_TIME
from jaxtex.synthesis.neighbourhoods import check_picture

_BINOMIAL = np.array([1, 4, 6, 4, 1], np.float32) / 16

_LEAST_CONTRAST = 1 / 255

_MOST_VALUES = 2**25  # that are held and sorted at a time


class PatchDistance(NamedTuple):
    """Distances in units of the exemplar's contrast: 0 where patches are distributed alike, 1 where the texture is all
    of one colour, the exemplar's mean.

    Attributes:
        total: the mean over scales.
        scales: from the finest detail to the coarsest; the last is of what remains, colours included, [scale].
    """

    total: float
    scales: npt.NDArray[np.float32]


def sliced_wasserstein(
    exemplar: npt.ArrayLike,
    texture: npt.ArrayLike,
    *,
    key: Array,
    patch: int = 7,
    scales: int = 4,
    projections: int = 128,
) -> PatchDistance:
    """The sliced Wasserstein distance of multi-scale patches.

    At each scale it is the root of the mean over projections of the squared 2-Wasserstein distance, divided by the root
    of the mean over projections of the exemplar's variance (at least that of a step of 8 bits).

    Args:
        exemplar, texture: floats [row, col, channel] with as many channels, of any sizes, in an encoding whose steps
            look even.
        key: random key of the projections. Distances that are to be compared take the same.
        patch: side of the patches in pixels of each scale.
        scales: number of octaves; the last holds all that is coarser too.
        projections: at each scale.

    Raises:
        ValueError: arrays of another form or of different numbers of channels, NaN or infinite values, pictures smaller
            than a patch at the coarsest scale, a number below 1.

    Examples:
        >>> grain = np.random.default_rng(0).random((64, 64, 3))
        >>> distance = sliced_wasserstein(grain, 0.5 + 0.7 * (grain - 0.5), key=jax.random.key(0), scales=3)
        >>> distance.scales.round(1)
        array([0.3, 0.3, 0.3], dtype=float32)
    """
    pictures = check_pictures(exemplar, texture)
    if min(patch, scales, projections) < 1:
        raise ValueError(f"patch {patch}, scales {scales}, projections {projections}: give at least 1 of each")
    for name, picture in zip(("exemplar", "texture"), pictures, strict=True):
        least = (patch - 1) * 2 ** (scales - 1) + 1
        if min(picture.shape[:2]) < least:
            rows, columns = picture.shape[:2]
            raise ValueError(
                f"{name} of {columns} x {rows} pixels: {scales} scales of patches of {patch} pixels need {least}; "
                "give a larger picture, or fewer scales"
            )
    levels = zip(*(_laplacian(jnp.asarray(each), scales) for each in pictures), strict=True)
    distances = []
    for scale, (seen, made) in enumerate(levels):
        directions = _draw_directions(jax.random.fold_in(key, scale), projections, patch, seen.shape[2])
        distances.append(_relative_distance(seen, made, directions))
    return PatchDistance(float(np.mean(distances)), np.array(distances, np.float32))


def check_pictures(
    exemplar: npt.ArrayLike, texture: npt.ArrayLike
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """Two pictures [row, col, channel] that can be compared.

    Raises:
        ValueError: an array of another form, NaN or infinite values, different numbers of channels.
    """
    first, second = check_picture(exemplar, "exemplar"), check_picture(texture, "texture")
    if first.shape[2] != second.shape[2]:
        raise ValueError(f"{first.shape[2]} and {second.shape[2]} channels cannot be compared; give as many of both")
    return first, second


@partial(jax.jit, static_argnums=1, compiler_options=SAME_EVERY_TIME)
def _laplacian(picture: Array, scales: int) -> list[Array]:
    """What each scale adds to the coarser ones, at its own resolution, and what remains: [row, col, channel] each."""
    levels = []
    for _ in range(scales - 1):
        smooth = _smooth(_smooth(picture, 0), 1)
        levels.append(picture - smooth)
        picture = smooth[::2, ::2]
    return [*levels, picture]


def _smooth(picture: Array, axis: int) -> Array:
    widths = [(2, 2) if each == axis else (0, 0) for each in range(3)]
    padded = jnp.pad(picture, widths, mode="symmetric")
    side = picture.shape[axis]
    return sum(
        (weight * jax.lax.slice_in_dim(padded, k, k + side, axis=axis) for k, weight in enumerate(_BINOMIAL)),
        start=jnp.zeros_like(picture),
    )


def _draw_directions(key: Array, projections: int, patch: int, channels: int) -> Array:
    """Unit vectors in the space of patches, [projection, row, col, channel], even over the sphere."""
    directions = jax.random.normal(key, (projections, patch, patch, channels))
    return directions / jnp.sqrt(jnp.sum(directions**2, axis=(1, 2, 3), keepdims=True))


def _relative_distance(seen: Array, made: Array, directions: Array) -> float:
    """The distance of the patches of two pictures, some projections at a time."""
    group = max(1, _MOST_VALUES // max(seen[..., 0].size, made[..., 0].size))
    squares, variances = [], []
    for first in range(0, len(directions), group):
        # Sorted by NumPy, which takes a small part of the time XLA does on a processor.
        one, other = (np.sort(_project(each, directions[first : first + group])) for each in (seen, made))
        here, there, shares = _match_in_order(one.shape[1], other.shape[1])
        squares += [shares @ (a[here] - b[there]) ** 2 for a, b in zip(one, other, strict=True)]
        variances += [each.var(dtype=np.float64) for each in one]
    return float(np.sqrt(np.mean(squares) / max(np.mean(variances), _LEAST_CONTRAST**2)))


@partial(jax.jit, compiler_options=SAME_EVERY_TIME)
def _project(picture: Array, directions: Array) -> Array:
    """Projections of all patches of [row, col, channel], [projection, patch]."""
    projected = jax.lax.conv_general_dilated(
        picture[None], jnp.moveaxis(directions, 0, -1), (1, 1), "VALID", dimension_numbers=("NHWC", "HWIO", "NHWC")
    )
    return projected.reshape(-1, len(directions)).T


def _match_in_order(
    first: int, second: int
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    """How two sorted samples are matched: parts of the one that go to parts of the other, and their shares.

    Each of n values has the share 1/n. The ends of the shares of both samples, together, bound the parts: their indices
    into either sample, and their sizes, which sum to 1.
    """
    ends = np.union1d(np.arange(1, first + 1) * second, np.arange(1, second + 1) * first)
    return (ends - 1) // second, (ends - 1) // first, np.diff(ends, prepend=0) / (first * second)
