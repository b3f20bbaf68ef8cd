"""The joint statistics of complex wavelet coefficients, and how far apart those of two textures are: J. Portilla and
E. P. Simoncelli, "A parametric texture model based on joint statistics of complex wavelet coefficients", IJCV 2000.

A picture is taken apart by the steerable pyramid, and each sub-band made complex by adding its quadrature. Kept are the
moments of the pixels and of the picture seen at each scale, its autocorrelation there, the contrast of sub-bands, how
their magnitudes go together with themselves shifted, with other orientations and with the next coarser scale, and how
phases follow from scale to scale, which tells edges from lines and lit sides from shaded ones.

Departures: colours are decorrelated along the exemplar's principal axes and each channel is measured by itself;
pictures that do not repeat are extended by reflection beyond their borders and measured within them; the least and the
largest pixel, which are no statistics of a texture, are left out; sub-bands are in the picture's units.

These distances alone mislead: pictures of random phases have most of these statistics too, and copying flatters them.
"""

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.core.compiling import SAME_EVERY_TIME
from jaxtex.core.pyramids import (
    Shape,
    SteerableFilters,
    SteerablePyramid,
    check_structure,
    design_filters,
    even_directions,
)
from jaxtex.synthesis.distances import check_pictures

_REACH = 3  # autocorrelations are kept for shifts of up to so many pixels of their scale

_LEAST_VARIANCE = 1e-8  # a fortieth of a step of 8 bits: what varies less does not vary


class JointStatistics(NamedTuple):
    """What is kept of a picture, per channel of decorrelated colour.

    Attributes:
        mean: of the colours along the axes, [channel].
        covariance: likewise, [channel, channel].
        moments: skewness and kurtosis of the pixels, then of the views: the picture without what is finer than each
            scale, and without all scales, [channel, 1 + scales + 1, 2].
        deviation: standard deviation of the highpass residual, then of the views, [channel, 1 + scales + 1].
        autocorrelation: of the views, for shifts of up to three pixels, [channel, scales + 1, 7, 7].
        magnitude: standard deviation of the magnitudes of sub-bands, [channel, scale, orientation].
        magnitude_autocorrelation: of magnitudes, [channel, scale, orientation, 7, 7].
        orientations: correlations of magnitudes at one scale, [channel, scale, orientation, orientation].
        parents: correlations of magnitudes with those of the next coarser scale, [channel, scales - 1, orientation,
            coarser orientation].
        phases: correlations of sub-bands with the real and the imaginary parts of the next coarser ones, their phases
            doubled, [channel, scales - 1, orientation, 2 coarser orientations].
    """

    mean: Array
    covariance: Array
    moments: Array
    deviation: Array
    autocorrelation: Array
    magnitude: Array
    magnitude_autocorrelation: Array
    orientations: Array
    parents: Array
    phases: Array


class JointDistance(NamedTuple):
    """Distances by groups of statistics: 0 where they agree, about 1 for another texture altogether.

    Attributes:
        total: the mean over groups.
        groups: by name: `colours`, `moments`, `contrast`, `autocorrelation`, `magnitudes`, `orientations`, `scales` and
            `phases`.
    """

    total: float
    groups: dict[str, float]


# What groups of statistics differ by, in the median, from one photographed natural texture to another (552 pairs of
# leaves, gravel, bark, water and the like): the units of distances. Two halves of one photograph of 256 x 256 pixels
# differ by a tenth (colours) to a half (phases) of this.
_TYPICAL = {
    "colours": 1.8,
    "moments": 0.63,
    "contrast": 1.1,
    "autocorrelation": 0.29,
    "magnitudes": 0.17,
    "orientations": 0.16,
    "scales": 0.21,
    "phases": 0.10,
}


def measure_joint_statistics(
    picture: npt.ArrayLike, *, axes: npt.ArrayLike, scales: int = 4, orientations: int = 4, periodic: bool = False
) -> JointStatistics:
    """Measure the joint statistics of a picture.

    Args:
        picture: floats [row, col, channel], in an encoding whose steps look even.
        axes: along which colours are measured, as rows, orthonormal: those of `decorrelating_axes`.
        scales, orientations: of the steerable pyramid.
        periodic: whether the picture goes on seamlessly beyond its borders.

    Raises:
        ValueError: a picture of another form, more scales than fit, fewer than one scale or orientation.

    Examples:
        >>> grain = np.random.default_rng(0).random((64, 48, 3))
        >>> statistics = measure_joint_statistics(grain, axes=decorrelating_axes(grain), scales=2)
        >>> statistics.orientations.shape, statistics.phases.shape
        ((3, 2, 4, 4), (3, 1, 4, 8))
    """
    pixels, _ = check_pictures(picture, picture)
    _check_structure(pixels.shape[:2], scales, orientations)
    channels = jnp.moveaxis(jnp.asarray(pixels @ np.asarray(axes, np.float32).T), -1, 0)
    return _measure(channels, scales, orientations, periodic)


def decorrelating_axes(picture: npt.ArrayLike) -> npt.NDArray[np.float32]:
    """The principal axes of a picture's colours as rows, the one of the most contrast first, [axis, channel].

    Examples:
        >>> grey = np.repeat(np.random.default_rng(0).random((8, 8, 1)), 3, axis=2)
        >>> np.abs(decorrelating_axes(grey)[0]).round(3)
        array([0.577, 0.577, 0.577], dtype=float32)
    """
    pixels = np.asarray(picture, np.float64)
    colours = pixels.reshape(-1, pixels.shape[-1])
    centred = colours - colours.mean(axis=0)
    return np.linalg.eigh(centred.T @ centred)[1].T[::-1].astype(np.float32)


def portilla_simoncelli_distance(
    exemplar: npt.ArrayLike, texture: npt.ArrayLike, *, scales: int = 4, orientations: int = 4
) -> JointDistance:
    """How far apart the joint statistics of two pictures are.

    Correlations differ by what they differ; deviations by their ratio; moments by their skewness and the logarithm of
    their kurtosis; colours in units of the exemplar's contrast. Of each group it is the root mean square, channels
    weighted by the exemplar's contrast in them, in units of what it is between two natural textures, in the median.

    Args:
        exemplar, texture: floats [row, col, channel] with as many channels, of any sizes, in an encoding whose steps
            look even.
        scales, orientations: of the steerable pyramid.

    Raises:
        ValueError: arrays of another form or of different numbers of channels, NaN or infinite values, more scales than
            fit either picture, fewer than one scale or orientation.

    Examples:
        >>> grain = np.random.default_rng(0).random((64, 64, 1))
        >>> distance = portilla_simoncelli_distance(grain, 0.9 * grain, scales=2)
        >>> [name for name, value in distance.groups.items() if value > 0.01]
        ['colours', 'contrast']
    """
    pictures = check_pictures(exemplar, texture)
    for each in pictures:
        _check_structure(each.shape[:2], scales, orientations)
    axes = decorrelating_axes(pictures[0])
    seen, made = (
        jax.tree.map(
            partial(np.asarray, dtype=np.float64),
            measure_joint_statistics(each, axes=axes, scales=scales, orientations=orientations),
        )
        for each in pictures
    )
    groups = {name: value / _TYPICAL[name] for name, value in _differences(seen, made).items()}
    return JointDistance(sum(groups.values()) / len(groups), groups)


def _check_structure(shape: Shape, scales: int, orientations: int) -> None:
    if scales < 1:
        raise ValueError(f"{scales} scales are too few; give at least 1")
    check_structure(shape, scales=scales, orientations=orientations)


def _differences(seen: JointStatistics, made: JointStatistics) -> dict[str, float]:
    """Root mean square differences by groups."""
    variance = np.maximum(np.diag(seen.covariance), _LEAST_VARIANCE)
    weights = np.sqrt(variance) / np.sqrt(variance).sum()

    def rms(*differences: npt.ArrayLike) -> float:
        """Of arrays [channel, ...], each element counting once."""
        flat = np.concatenate([np.reshape(each, (len(weights), -1)) for each in differences], axis=1)
        return math.sqrt(weights @ (flat**2).mean(axis=1)) if flat.size else 0.0

    def ratio(here: npt.ArrayLike, there: npt.ArrayLike) -> npt.NDArray[np.float64]:
        return np.subtract(there, here) / np.maximum(here, math.sqrt(_LEAST_VARIANCE))

    total = variance.sum()
    moved, stretched = (made.mean - seen.mean) / math.sqrt(total), (made.covariance - seen.covariance) / total
    return {
        "colours": math.sqrt((moved**2).sum() + (stretched**2).sum()),
        "moments": rms(
            made.moments[..., 0] - seen.moments[..., 0], np.log(made.moments[..., 1] / seen.moments[..., 1])
        ),
        "contrast": rms(ratio(seen.deviation, made.deviation), ratio(seen.magnitude, made.magnitude)),
        "autocorrelation": rms(made.autocorrelation - seen.autocorrelation),
        "magnitudes": rms(made.magnitude_autocorrelation - seen.magnitude_autocorrelation),
        "orientations": rms(made.orientations - seen.orientations),
        "scales": rms(made.parents - seen.parents),
        "phases": rms(made.phases - seen.phases),
    }


@partial(jax.jit, static_argnums=(1, 2, 3), compiler_options=SAME_EVERY_TIME)
def _measure(channels: Array, scales: int, orientations: int, periodic: bool) -> JointStatistics:
    """Statistics of decorrelated channels [channel, row, col]."""
    shape = channels.shape[1:]
    # About what the coarsest filters reach. As a multiple of 2^scales, it is whole pixels of every scale.
    margin = 0 if periodic else 2 ** (scales + 2)
    beyond = [(0, 0) if periodic else (margin, margin + -side % 2**scales) for side in shape]
    mean = jnp.mean(channels, axis=(1, 2))
    centred = channels - mean[:, None, None]
    extended = jnp.pad(centred, [(0, 0), *beyond], mode="symmetric")
    filters = design_filters(extended.shape[1:], scales=scales, directions=even_directions(orientations, len(shape)))

    def within(band: Array, scale: int) -> Array:
        """What of [..., row, col] lies within the picture."""
        rows, columns = (slice(margin >> scale, (margin >> scale) + -(-side // 2**scale)) for side in shape)
        return band[..., rows, columns]

    def measure(each: tuple[Array, Array]) -> tuple[Array, ...]:
        channel, image = each
        pyramid = filters.build(image)
        views = [within(view, scale) for scale, view in enumerate(_views(pyramid, filters))]
        moments = jnp.stack([_moments(view) for view in (channel, *views)])
        deviation = jnp.stack([jnp.sqrt(_variance(view)) for view in (within(pyramid.highpass, 0), *views)])
        autocorrelation = jnp.stack([_autocorrelation(view[None], periodic)[0] for view in views])
        bands = [_quadrature(band) for band in pyramid.bands]
        return moments, deviation, autocorrelation, *_joint(bands, within, periodic)

    covariance = jnp.einsum("irc,jrc->ij", centred, centred) / math.prod(shape)
    # One after another: together they would need as many times the memory.
    return JointStatistics(mean, covariance, *jax.lax.map(measure, (centred, extended)))


def _views(pyramid: SteerablePyramid, filters: SteerableFilters) -> list[Array]:
    """The picture without what is finer than a scale, at that scale's resolution; last, what no scale holds."""
    scales = len(pyramid.bands)
    views: list[Array] = []
    for scale in reversed(range(scales + 1)):
        low = filters.lowpass[scale]
        # A coarser view has been filtered on the way already.
        lowpass = (low, jnp.ones_like(filters.lowpass[scale + 1])) if views else (low,)
        here = slice(scale, scale + 1)
        step = SteerableFilters(jnp.zeros_like(low), lowpass, filters.bands[here], filters.shapes[scale : scale + 2])
        nothing = jnp.zeros(filters.shapes[scale], pyramid.highpass.dtype)
        coarser = views[0] if views else pyramid.lowpass
        views.insert(0, step.collapse(SteerablePyramid(nothing, pyramid.bands[here], coarser)))
    return views


def _joint(
    bands: list[Array], within: Callable[[Array, int], Array], periodic: bool
) -> tuple[Array, Array, Array, Array, Array]:
    """From `magnitude` to `phases`, of complex sub-bands [orientation, row, col] of each scale."""
    sizes, shifted, orientations, parents, phases = [], [], [], [], []
    for scale, band in enumerate(bands):
        band_within = within(band, scale)
        magnitude = _centre(jnp.abs(band_within))
        sizes.append(jnp.sqrt(_variance(magnitude)))
        shifted.append(_autocorrelation(magnitude, periodic))
        orientations.append(_correlate(magnitude, magnitude))
        if scale + 1 < len(bands):
            coarser = within(_enlarge(bands[scale + 1], band.shape[1:]), scale)
            size = jnp.abs(coarser)
            parents.append(_correlate(magnitude, _centre(size)))
            doubled = coarser**2 / jnp.maximum(size, jnp.finfo(size.dtype).tiny)
            phases.append(_correlate(band_within.real, jnp.concatenate([doubled.real, doubled.imag])))
    count = len(bands[0])
    return (
        jnp.stack(sizes),
        jnp.stack(shifted),
        jnp.stack(orientations),
        jnp.stack(parents) if parents else jnp.zeros((0, count, count)),
        jnp.stack(phases) if phases else jnp.zeros((0, count, 2 * count)),
    )


def _quadrature(bands: Array) -> Array:
    """Real sub-bands [orientation, row, col], made complex: without the frequencies that point against their axes."""
    rows, columns = (jnp.fft.fftfreq(side) for side in bands.shape[1:])
    axes = jnp.asarray(even_directions(len(bands), 2), jnp.float32)
    along = axes[:, 0, None, None] * rows[None, :, None] + axes[:, 1, None, None] * columns[None, None, :]
    return jnp.fft.ifft2(jnp.fft.fft2(bands) * (1 + jnp.sign(along)))


def _enlarge(bands: Array, shape: Shape) -> Array:
    """Complex sub-bands [orientation, row, col] seen at more points."""
    spectrum = jnp.fft.fftshift(jnp.fft.fft2(bands, norm="forward"), axes=(1, 2))
    # Zero frequency stands at the middle, rounded down.
    before = [side // 2 - kept // 2 for side, kept in zip(shape, bands.shape[1:], strict=True)]
    after = [side - kept - less for side, kept, less in zip(shape, bands.shape[1:], before, strict=True)]
    padded = jnp.pad(spectrum, [(0, 0), *zip(before, after, strict=True)])
    return jnp.fft.ifft2(jnp.fft.ifftshift(padded, axes=(1, 2)), norm="forward")


def _centre(bands: Array) -> Array:
    return bands - jnp.mean(bands, axis=(-2, -1), keepdims=True)


def _variance(bands: Array) -> Array:
    return jnp.mean(_centre(bands) ** 2, axis=(-2, -1))


def _moments(image: Array) -> Array:
    """Skewness and kurtosis, 0 and 3 where nothing varies."""
    centred = _centre(image)
    variance = jnp.mean(centred**2)
    skewness, kurtosis = (jnp.mean(centred**n) / jnp.maximum(variance, _LEAST_VARIANCE) ** (n / 2) for n in (3, 4))
    return jnp.where(variance > _LEAST_VARIANCE, jnp.stack([skewness, kurtosis]), jnp.array([0.0, 3.0]))


def _autocorrelation(bands: Array, periodic: bool) -> Array:
    """Of [band, row, col] for shifts of up to `_REACH` pixels, [band, 7, 7], the mean over pairs within the picture."""
    shape = bands.shape[1:]
    padded = shape if periodic else tuple(side + _REACH for side in shape)
    power = jnp.abs(jnp.fft.rfft2(_centre(bands), s=padded)) ** 2
    sums = jnp.fft.irfft2(power, s=padded)
    shifts = np.arange(-_REACH, _REACH + 1)
    pairs = [np.full(len(shifts), side) if periodic else np.maximum(side - np.abs(shifts), 1) for side in shape]
    kept = sums[:, shifts[:, None] % padded[0], shifts[None, :] % padded[1]]
    covariance = kept / jnp.asarray(pairs[0][:, None] * pairs[1][None, :], jnp.float32)[None]
    variance = covariance[:, _REACH, _REACH, None, None]
    return jnp.where(variance > _LEAST_VARIANCE, covariance / jnp.maximum(variance, _LEAST_VARIANCE), 0.0)


def _correlate(first: Array, second: Array) -> Array:
    """Correlations of bands [band, row, col] with others, [band, other band]; their means are taken to be 0."""
    count = math.prod(first.shape[1:])
    products = jnp.einsum("irc,jrc->ij", first, second) / count
    variances = (jnp.sum(each**2, axis=(1, 2)) / count for each in (first, second))
    here, there = variances
    scale = here[:, None] * there[None, :]
    return jnp.where(scale > _LEAST_VARIANCE**2, products / jnp.sqrt(jnp.maximum(scale, _LEAST_VARIANCE**2)), 0.0)
