"""Texture synthesis by matching histograms of sub-bands: D. J. Heeger and J. R. Bergen, "Pyramid-based texture
analysis/synthesis", SIGGRAPH 1995.

A texture is what is common to all noise whose pixels and whose sub-bands of a steerable pyramid are distributed as the
exemplar's are. That holds of stochastic textures (granite, plaster, sand, fur); things with outlines, such as pebbles,
fall apart into grain of their size and contrast.

Departures from the paper: colours are decorrelated by rotation to their principal axes, without whitening, so that a
channel without contrast (of a grey picture) does no harm; as decorrelated is not independent (the lime on red bricks is
white, with no pink in between), colours are matched along other axes too, as F. Pitié, A. Kokaram and R. Dahyot do
("Automated colour grading using colour distribution transfer", CVIU 2007); exemplars that do not repeat are extended
by reflection, as T. Briand, J. Vacher, B. Galerne and J. Rabin ("The Heeger & Bergen pyramid based texture synthesis
algorithm", IPOL 2014) found to matter; and textures finer than the exemplar can be made.
"""

import math
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.core.compiling import SAME_EVERY_TIME
from jaxtex.core.histograms import match_histogram, quantile_table, table_variance
from jaxtex.core.pyramids import (
    Shape,
    SteerableFilters,
    SteerablePyramid,
    check_structure,
    design_filters,
    even_directions,
)

# From octave to octave, a scale-free picture keeps its contrast, and one of sharp-edged flat grains loses a factor of
# 2^-1/2. Where an exemplar's contrast still grows towards finer scales, what lies beyond is taken to be between these.
_STEADIEST = 2**-0.25

# Of a texture as strong in every octave, the highpass residual holds 0.66 octaves, corners of the spectrum included.
_HIGHPASS = 0.81

_VIEWS = 3


class TextureStatistics(eqx.Module):
    """All that is kept of an exemplar: tables of quantiles (`jaxtex.core.histograms.quantile_table`), per channel of
    decorrelated colour. Make them with `analyse_texture`.

    Attributes:
        mean: of the colours, [channel].
        axes: principal axes of the colours as rows, [decorrelated channel, channel], orthonormal.
        pixels: of the decorrelated colours, [decorrelated channel, quantile].
        views: of the same along other axes, [view, axis, quantile], those of `colour_views`.
        highpass: of the pyramid's highpass residual, likewise.
        bands: [decorrelated channel, scale, orientation, quantile], from fine to coarse.
        lowpass: of the lowpass residual, [decorrelated channel, quantile].
    """

    mean: Array
    axes: Array
    pixels: Array
    views: Array
    highpass: Array
    bands: Array
    lowpass: Array

    @property
    def scales(self) -> int:
        """Number of scales."""
        return int(self.bands.shape[-3])

    @property
    def orientations(self) -> int:
        """Number of orientations per scale."""
        return int(self.bands.shape[-2])


def analyse_texture(
    exemplars: npt.ArrayLike, *, scales: int = 4, orientations: int = 4, periodic: bool = False
) -> TextureStatistics:
    """Measure a texture.

    Args:
        exemplars: floats [region, row, col, channel]; statistics are taken over all regions together. Any number of
            channels, in any encoding: distances between colours should be about as large as they look, as they are
            between sRGB-encoded values.
        scales, orientations: of the steerable pyramid. The coarsest detail that is kept as such spans about 2^(scales
            + 1) pixels; `most_scales` of `jaxtex.core.pyramids` tells how many scales fit.
        periodic: whether the exemplars go on seamlessly beyond their borders. Otherwise they are extended by
            reflection.

    Raises:
        ValueError: an array of another form, NaN or infinite values, more scales than fit, fewer than one orientation.

    Examples:
        >>> grain = np.random.default_rng(0).random((1, 64, 64, 3))
        >>> statistics = analyse_texture(grain, scales=3)
        >>> statistics.bands.shape
        (3, 3, 4, 512)
    """
    pixels = np.asarray(exemplars, np.float32)
    if pixels.ndim != 4 or 0 in pixels.shape:
        raise ValueError(f"exemplars of shape {pixels.shape}: give [region, row, col, channel], none of them empty")
    if not np.isfinite(pixels).all():
        raise ValueError("exemplars: some values are NaN or infinite")
    check_structure(pixels.shape[1:3], scales=scales, orientations=orientations)
    mean, axes = _principal_axes(pixels)
    # Channel first, then region: each channel is a texture of its own from here on.
    decorrelated = np.moveaxis((pixels - mean) @ axes.T, -1, 0)
    pyramids = _decompose(jnp.asarray(decorrelated), scales, orientations, periodic)
    bands = [_pool(np.moveaxis(np.asarray(band), 2, 1)) for band in pyramids.bands]
    no_bands = np.zeros((len(axes), 0, orientations, _pool(decorrelated).shape[-1]), np.float32)
    arrays = (
        mean,
        axes,
        _pool(decorrelated),
        _pool(np.tensordot(colour_views(len(axes)), decorrelated, axes=1)),
        _pool(pyramids.highpass),
        np.stack(bands, axis=1) if bands else no_bands,
        _pool(pyramids.lowpass),
    )
    return TextureStatistics(*map(jnp.asarray, arrays))


def synthesise_texture(
    statistics: TextureStatistics, shape: tuple[int, int], *, key: Array, iterations: int = 5, finer: int = 0
) -> Array:
    """Make a texture that has the statistics of an exemplar, from noise. It repeats seamlessly.

    Args:
        statistics: of `analyse_texture`.
        shape: (rows, columns), any that holds the statistics' scales and `finer` more.
        key: random key; another key, another piece of the same texture.
        iterations: of matching sub-bands and pixels in turn. Five bring the contrast of sub-bands of stochastic
            textures to within a percent or so; smooth pictures such as skies take some more.
        finer: octaves of detail beyond the exemplar's resolution, as `extrapolate_finer` makes them: at `finer=1`, the
            texture is seen at twice the exemplar's resolution.

    Returns:
        [row, col, channel], in the exemplars' encoding. Values may lie somewhat outside the exemplar's range, as
        channels are matched one by one.

    Raises:
        ValueError: more scales than fit the shape, fewer than one iteration, `finer` below 0.

    Examples:
        >>> grain = np.random.default_rng(0).random((1, 64, 64, 3))
        >>> statistics = analyse_texture(grain, scales=2)
        >>> synthesise_texture(statistics, (50, 75), key=jax.random.key(0)).shape
        (50, 75, 3)
    """
    if iterations < 1:
        raise ValueError(f"{iterations} iterations are too few; give at least 1")
    if finer < 0:
        raise ValueError(f"finer: {finer} is negative; give 0 octaves or more")
    check_structure(shape, scales=statistics.scales + finer, orientations=statistics.orientations)
    # Within a user's own jit, compiling is the user's.
    nested = any(isinstance(each, jax.core.Tracer) for each in jax.tree.leaves((statistics, key)))
    compiled = _synthesise if nested else _synthesise_alone
    return compiled(statistics, key, jnp.asarray(iterations), tuple(shape), finer)


def estimate_memory(shape: tuple[int, int], *, orientations: int, channels: int) -> int:
    """About how many bytes `synthesise_texture` takes.

    Examples:
        >>> round(estimate_memory((4096, 4096), orientations=4, channels=3) / 2**30, 1)
        5.7
    """
    return shape[0] * shape[1] * (100 + 55 * orientations + 15 * channels)


@partial(jax.jit, static_argnums=(3, 4))
def _synthesise(statistics: TextureStatistics, key: Array, iterations: Array, shape: Shape, finer: int) -> Array:
    if finer:
        statistics = extrapolate_finer(statistics, finer)
    filters = design_filters(
        shape, scales=statistics.scales, directions=even_directions(statistics.orientations, len(shape))
    )
    noise = jax.random.normal(key, (len(statistics.pixels), *shape))
    sub_bands = SteerablePyramid(
        statistics.highpass,
        tuple(statistics.bands[:, scale] for scale in range(statistics.scales)),
        statistics.lowpass,
    )

    def step(_: Array, channels: Array) -> Array:
        # One after another: together they would need as many times the memory, and be no faster.
        matched = jax.lax.map(lambda each: _match_sub_bands(filters, *each), (channels, sub_bands))
        return _match_colours(matched, statistics)

    channels = jax.lax.fori_loop(0, iterations, step, _match_colours(noise, statistics))
    return jnp.moveaxis(jnp.tensordot(statistics.axes.T, channels, axes=1), 0, -1) + statistics.mean[None, None]


_synthesise_alone = jax.jit(_synthesise, static_argnums=(3, 4), compiler_options=SAME_EVERY_TIME)


def _match_sub_bands(filters: SteerableFilters, image: Array, tables: SteerablePyramid) -> Array:
    """An image of one channel whose sub-bands are distributed as these tables say."""
    pyramid = filters.build(image)
    matched = SteerablePyramid(
        match_histogram(pyramid.highpass, tables.highpass),
        tuple(jax.vmap(match_histogram)(band, table) for band, table in zip(pyramid.bands, tables.bands, strict=True)),
        match_histogram(pyramid.lowpass, tables.lowpass),
    )
    return filters.collapse(matched)


def _match_colours(channels: Array, statistics: TextureStatistics) -> Array:
    """Channels [decorrelated channel, row, col] whose colours are distributed as the exemplar's."""

    def match(channels: Array, tables: Array) -> Array:
        return jax.lax.map(lambda each: match_histogram(*each), (channels, tables))

    def look(channels: Array, view: tuple[Array, Array]) -> tuple[Array, None]:
        axes, tables = view
        return jnp.tensordot(axes.T, match(jnp.tensordot(axes, channels, axes=1), tables), axes=1), None

    views = jnp.asarray(colour_views(len(channels)))
    return match(jax.lax.scan(look, channels, (views, statistics.views))[0], statistics.pixels)


def colour_views(channels: int) -> npt.NDArray[np.float32]:
    """Orthonormal axes, as rows, along which colours are matched besides the principal ones: [view, axis, channel].

    Colours of one channel have none. Those of more are seen from all over: these axes are random, and always the same.
    """
    views = _VIEWS if channels > 1 else 0
    noise = np.random.default_rng(0).normal(size=(views, channels, channels))
    return np.linalg.qr(noise)[0].astype(np.float32)


@partial(jax.jit, static_argnums=(1, 2, 3), compiler_options=SAME_EVERY_TIME)
def _decompose(images: Array, scales: int, orientations: int, periodic: bool) -> SteerablePyramid:
    """Pyramids of [channel, region, row, col], seen where the images are."""
    if not periodic:
        images = jnp.pad(images, [(0, 0), (0, 0), *((0, side) for side in images.shape[2:])], mode="symmetric")
    shape = images.shape[2:]
    filters = design_filters(shape, scales=scales, directions=even_directions(orientations, len(shape)))
    pyramids = jax.vmap(jax.vmap(filters.build))(images)
    return pyramids if periodic else jax.tree.map(_first_half, pyramids)


def _first_half(band: Array) -> Array:
    rows, columns = (-(-side // 2) for side in band.shape[-2:])
    return band[..., :rows, :columns]


def _pool(values: npt.ArrayLike) -> npt.NDArray[np.float32]:
    """Quantile tables of the last two axes and the region's, which is the one before them."""
    array = np.asarray(values)
    return quantile_table(array.reshape(*array.shape[:-3], math.prod(array.shape[-3:])))


def _principal_axes(pixels: npt.NDArray[np.float32]) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """Mean [channel] and principal axes [axis, channel] of colours, in double precision."""
    colours = pixels.reshape(-1, pixels.shape[-1]).astype(np.float64)
    mean = colours.mean(axis=0)
    _, axes = np.linalg.eigh((colours - mean).T @ (colours - mean) / len(colours))
    return mean.astype(np.float32), axes.T[::-1].astype(np.float32)


def extrapolate_finer(statistics: TextureStatistics, octaves: int) -> TextureStatistics:
    """The statistics of the same texture seen at 2^octaves times the resolution.

    What the exemplar shows keeps its place in the world: its finest scale becomes scale `octaves`. The new scales are
    that one again, orientation by orientation, weaker from each to the next by the factor by which the exemplar's own
    scales grow weaker, as the median tells, and by 2^-1/4 at least. The highpass residual, which in a photograph is
    mostly the camera's, is made likewise, and the pixels' contrast grows by what is added.

    Args:
        octaves: at least 1.
    """
    finest, factor = _finest(statistics), _falloff(statistics.bands)
    new = [finest * (factor**step)[..., None] for step in range(octaves, 0, -1)]
    bands = jnp.concatenate([jnp.stack(new, axis=1), statistics.bands], axis=1)
    whole = jnp.sqrt(statistics.orientations) * jnp.mean(finest * (factor ** (octaves + 1))[..., None], axis=1)
    highpass = _HIGHPASS * whole
    added = jnp.sum(table_variance(bands[:, :octaves]), axis=(1, 2)) + table_variance(highpass)
    seen = table_variance(statistics.pixels)
    kept = jnp.maximum(seen - table_variance(statistics.highpass), 0.0)
    wider = jnp.sqrt((kept + added) / jnp.where(seen > 0, seen, 1.0))
    # Along other axes variances add up by the squares of their components.
    squares = jnp.square(jnp.asarray(colour_views(len(seen))))
    before, after = jnp.tensordot(squares, seen, axes=1), jnp.tensordot(squares, kept + added, axes=1)
    wider_views = jnp.sqrt(after / jnp.where(before > 0, before, 1.0))
    return TextureStatistics(
        mean=statistics.mean,
        axes=statistics.axes,
        pixels=statistics.pixels * wider[:, None],
        views=statistics.views * wider_views[..., None],
        highpass=highpass,
        bands=bands,
        lowpass=statistics.lowpass,
    )


def _finest(statistics: TextureStatistics) -> Array:
    """Tables of the finest scale, [channel, orientation, quantile]; where there is none, of the highpass residual."""
    if statistics.scales:
        return statistics.bands[:, 0]
    even = statistics.highpass / (_HIGHPASS * np.sqrt(statistics.orientations))
    return jnp.repeat(even[:, None], statistics.orientations, axis=1)


def _falloff(bands: Array) -> Array:
    """The factor by which sub-bands weaken towards each finer scale, [channel, orientation]."""
    deviation = jnp.sqrt(table_variance(bands))
    if bands.shape[1] < 2:
        return jnp.full((bands.shape[0], bands.shape[2]), _STEADIEST)
    finer, coarser = deviation[:, :-1], deviation[:, 1:]
    steps = jnp.where(coarser > 0, finer / jnp.where(coarser > 0, coarser, 1.0), _STEADIEST)
    return jnp.median(jnp.minimum(steps, _STEADIEST), axis=1)
