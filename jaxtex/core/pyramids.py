"""The steerable pyramid: a picture as a highpass residual, oriented sub-bands scale by scale, and a lowpass residual.

It is a tight frame: analysis and synthesis use the same filters, whose squares sum to one at every frequency. Filters
are applied in the Fourier domain, so pictures go on periodically beyond their border, and coarser sub-bands are
subsampled by cropping their spectra, which are zero beyond what is kept: nothing aliases, and reconstruction is exact
for pictures of any size, odd ones included, in one to three dimensions.

E. P. Simoncelli and W. T. Freeman, "The steerable pyramid: a flexible architecture for multi-scale derivative
computation", ICIP 1995; filters as in J. Portilla and E. P. Simoncelli, "A parametric texture model based on joint
statistics of complex wavelet coefficients", IJCV 2000, section 2.1. Departure: sub-bands are in the picture's units (a
sub-band is the filtered picture, seen at fewer points); in the authors' code, those of scale s are 4^s times as large.
"""

import math
from functools import partial
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.typing import ArrayLike

Shape = tuple[int, ...]


class SteerablePyramid(NamedTuple):
    """What a picture is made of.

    Attributes:
        highpass: the finest detail, beyond all orientations, [*shape].
        bands: for each scale, from fine to coarse, [orientation, *shape_of_the_scale]; each scale is half as large as
            the one before, rounded up, and the first is as large as the picture.
        lowpass: what is left, half as large as the last scale.
    """

    highpass: Array
    bands: tuple[Array, ...]
    lowpass: Array


def most_scales(shape: Shape) -> int:
    """How many scales fit a picture: those whose lowpass residual keeps four pixels along each side.

    Examples:
        >>> most_scales((256, 300)), most_scales((3, 3))
        (6, 0)
    """
    return max(int(math.log2(min(shape))) - 2, 0)


def build_pyramid(image: ArrayLike, *, scales: int, orientations: int) -> SteerablePyramid:
    """Split a picture into sub-bands.

    Sub-band k of K has its filter's axis at k·180/K degrees from x towards y: the first answers to vertical edges.

    Args:
        image: float array of any size; two dimensions, or one to three where `orientations` is 1.
        scales: number of octaves that are split into orientations; at most `most_scales`.
        orientations: number K of sub-bands per scale. With 1, they are isotropic.

    Raises:
        ValueError: there are more scales than fit, less than one orientation, or more than one orientation of a picture
            that is not two-dimensional.

    Examples:
        >>> pyramid = build_pyramid(jnp.ones((30, 45)), scales=2, orientations=4)
        >>> [band.shape for band in pyramid.bands], pyramid.lowpass.shape
        ([(4, 30, 45), (4, 15, 23)], (8, 12))
    """
    image = jnp.asarray(image)
    check_structure(image.shape, scales=scales, orientations=orientations)
    return _build(image, scales, orientations)


def collapse_pyramid(pyramid: SteerablePyramid) -> Array:
    """The picture that a pyramid was built from.

    Raises:
        ValueError: more than one orientation, and not two dimensions.

    Examples:
        >>> image = jax.random.uniform(jax.random.key(0), (30, 45))
        >>> bool(jnp.allclose(collapse_pyramid(build_pyramid(image, scales=2, orientations=4)), image, atol=1e-5))
        True
    """
    return _collapse(pyramid)


@partial(jax.jit, static_argnums=(1, 2))
def _build(image: Array, scales: int, orientations: int) -> SteerablePyramid:
    directions = even_directions(orientations, image.ndim)
    return design_filters(image.shape, scales=scales, directions=directions).build(image)


@jax.jit
def _collapse(pyramid: SteerablePyramid) -> Array:
    shape = pyramid.highpass.shape
    directions = even_directions(pyramid.bands[0].shape[0] if pyramid.bands else 1, len(shape))
    return design_filters(shape, scales=len(pyramid.bands), directions=directions).collapse(pyramid)


def check_structure(shape: Shape, *, scales: int, orientations: int) -> None:
    """Refuse pyramids that cannot be built.

    Raises:
        ValueError: as `build_pyramid`.
    """
    told = " x ".join(map(str, shape[::-1]))
    if 0 in shape or not shape:
        raise ValueError(f"a picture of {told or 'no'} pixels has no scales; give one that has pixels")
    if not 0 <= scales <= most_scales(shape):
        raise ValueError(f"{scales} scales do not fit {told} pixels; give 0 to {most_scales(shape)}")
    if orientations < 1:
        raise ValueError(f"{orientations} orientations are too few; give at least 1")
    if orientations > 1 and len(shape) != 2:
        raise ValueError(f"{orientations} orientations are even in two dimensions only, not {len(shape)}; give 1")


def even_directions(orientations: int, dimensions: int) -> np.ndarray:
    """Unit vectors [orientation, dimension] evenly spread over half a turn from x towards y, in the order [row, col].

    Raises:
        ValueError: more than one orientation, and not two dimensions.
    """
    if orientations == 1:
        return np.eye(dimensions)[-1:]
    if dimensions != 2:
        raise ValueError(f"{orientations} orientations are even in two dimensions only, not {dimensions}; give 1")
    angle = np.pi * np.arange(orientations) / orientations
    return np.stack([np.sin(angle), np.cos(angle)], axis=-1)


class SteerableFilters(eqx.Module):
    """The filters of a pyramid, real and on the half spectrum; make them with `design_filters`.

    To take many pictures of one size apart and put them together again, this saves making the filters each time.

    Attributes:
        highpass: [*half].
        lowpass: for the picture, then for each scale's crop, [*half_of_the_crop].
        bands: for each scale [orientation, *half_of_the_scale].
        shapes: of the picture, of each further scale, and of the lowpass residual.
    """

    highpass: Array
    lowpass: tuple[Array, ...]
    bands: tuple[Array, ...]
    shapes: tuple[Shape, ...] = eqx.field(static=True)

    def build(self, image: Array) -> SteerablePyramid:
        """The pyramid of an image [*shape]."""
        spectrum = jnp.fft.rfftn(image, norm="forward")
        highpass = _inverse(spectrum * self.highpass, self.shapes[0])
        spectrum = spectrum * self.lowpass[0]
        bands = []
        for filters, low, shape, coarser in zip(
            self.bands, self.lowpass[1:], self.shapes[:-1], self.shapes[1:], strict=True
        ):
            turned = (-1j) ** (len(filters) - 1) * spectrum
            bands.append(jax.vmap(lambda band, shape=shape: _inverse(band, shape))(turned[None] * filters))
            spectrum = _crop(spectrum, shape, coarser) * low
        return SteerablePyramid(highpass, tuple(bands), _inverse(spectrum, self.shapes[-1]))

    def collapse(self, pyramid: SteerablePyramid) -> Array:
        """The image [*shape] of a pyramid."""
        spectrum = jnp.fft.rfftn(pyramid.lowpass, norm="forward")
        for scale in reversed(range(len(self.bands))):
            filters = self.bands[scale]
            spectrum = _pad(spectrum * self.lowpass[scale + 1], self.shapes[scale + 1], self.shapes[scale])
            seen = jax.vmap(partial(jnp.fft.rfftn, norm="forward"))(pyramid.bands[scale])
            spectrum = spectrum + 1j ** (len(filters) - 1) * jnp.sum(seen * filters, axis=0)
        highpass = jnp.fft.rfftn(pyramid.highpass, norm="forward")
        return _inverse(spectrum * self.lowpass[0] + highpass * self.highpass, self.shapes[0])


def design_filters(shape: Shape, *, scales: int, directions: ArrayLike) -> SteerableFilters:
    """The filters of a pyramid of pictures of one size.

    With radius r in units of the Nyquist frequency, high(r) rises from 0 at 1/2 to 1 at 1 as cos(pi/2 log2 r), and
    low² + high² = 1. The angular filter of direction d is (d·w/|w|)^(K-1), normalised so that the squares of all K sum
    to one; for `even_directions` that is the constant of Portilla and Simoncelli.

    Args:
        shape: of the pictures.
        scales: as in `build_pyramid`.
        directions: unit vectors [K, dimension], in the order of the axes, which must span the space unless K is 1.
    """
    directions = jnp.asarray(directions, jnp.float32)
    shapes = [shape]
    for _ in range(scales):
        shapes.append(tuple(-(-side // 2) for side in shapes[-1]))
    radius, _ = _polar(_frequencies(shape, shape))
    low, bands = [_low(radius)], []
    for scale in range(scales):
        radius, unit = _polar(_frequencies(shape, shapes[scale]))
        angular = jnp.tensordot(directions, unit, axes=1) ** (len(directions) - 1)
        size = jnp.sqrt(jnp.sum(angular**2, axis=0))
        bands.append(angular * (_high(2 ** (scale + 1) * radius) / jnp.maximum(size, 1e-12))[None])
        coarser, _ = _polar(_frequencies(shape, shapes[scale + 1]))
        low.append(_low(2 ** (scale + 1) * coarser))
    highpass = _high(_polar(_frequencies(shape, shape))[0])
    return SteerableFilters(highpass=highpass, lowpass=tuple(low), bands=tuple(bands), shapes=tuple(shapes))


def _high(radius: Array) -> Array:
    return jnp.cos(0.5 * jnp.pi * jnp.clip(jnp.log2(radius), -1.0, 0.0))


def _low(radius: Array) -> Array:
    return jnp.sin(-0.5 * jnp.pi * jnp.clip(jnp.log2(radius), -1.0, 0.0))


def _frequencies(shape: Shape, cropped: Shape) -> Array:
    """Frequencies [dimension, *half] of a cropped spectrum, in units of the whole picture's Nyquist frequency."""
    axes = [np.fft.fftfreq(kept, 0.5 * side / kept) for side, kept in zip(shape[:-1], cropped[:-1], strict=True)]
    axes.append(np.fft.rfftfreq(cropped[-1], 0.5 * shape[-1] / cropped[-1]))
    grids = jnp.meshgrid(*(jnp.asarray(axis, jnp.float32) for axis in axes), indexing="ij")
    return jnp.stack(grids)


def _polar(frequencies: Array) -> tuple[Array, Array]:
    """Radius and unit vectors; at zero frequency a tiny radius, and no direction."""
    radius = jnp.maximum(jnp.sqrt(jnp.sum(frequencies**2, axis=0)), 1e-9)
    return radius, frequencies / radius[None]


def _inverse(spectrum: Array, shape: Shape) -> Array:
    return jnp.fft.irfftn(spectrum, s=shape, norm="forward")


def _crop(spectrum: Array, shape: Shape, smaller: Shape) -> Array:
    """The low frequencies of a half spectrum. Filters remove what is at the smaller shape's Nyquist frequency."""
    for axis, (side, kept) in enumerate(zip(shape[:-1], smaller[:-1], strict=True)):
        positive = jax.lax.slice_in_dim(spectrum, 0, (kept + 1) // 2, axis=axis)
        negative = jax.lax.slice_in_dim(spectrum, side - kept // 2, side, axis=axis)
        spectrum = jnp.concatenate([positive, negative], axis=axis)
    return spectrum[..., : smaller[-1] // 2 + 1]


def _pad(spectrum: Array, smaller: Shape, shape: Shape) -> Array:
    """The inverse of `_crop`, with zeros around."""
    for axis, (kept, side) in enumerate(zip(smaller[:-1], shape[:-1], strict=True)):
        positive = jax.lax.slice_in_dim(spectrum, 0, (kept + 1) // 2, axis=axis)
        negative = jax.lax.slice_in_dim(spectrum, (kept + 1) // 2, kept, axis=axis)
        between = jnp.zeros((*spectrum.shape[:axis], side - kept, *spectrum.shape[axis + 1 :]), spectrum.dtype)
        spectrum = jnp.concatenate([positive, between, negative], axis=axis)
    beyond = shape[-1] // 2 - smaller[-1] // 2
    return jnp.pad(spectrum, [(0, 0)] * (spectrum.ndim - 1) + [(0, beyond)])
