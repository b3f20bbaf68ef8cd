"""Solid textures from orthogonal views by relaxation: slices of a block of noise are made to look like the views.

J.-M. Dischler, D. Ghazanfarpour and R. Freydier, "Anisotropic solid texture synthesis using orthogonal 2D views"
(Eurographics 1998), section 5: all slices across one axis, then those across the next, and again. As Fourier
transforms have it, a block goes on at its opposite faces. Which slices the views are, see
`jaxtex.synthesis.solid_views`.
"""

from collections.abc import Iterator, Mapping
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array, lax

from jaxtex.core.compiling import SAME_EVERY_TIME
from jaxtex.synthesis.slices import SliceStatistics, measure_slice, process_slice
from jaxtex.synthesis.solid_views import AXES, CROPS, ColourModel, align_views, analyse_views

ITERATIONS = 10
"""How often all slices are processed at most, unless told. The paper: 2 or 3 times for wood, 10 for the worst."""

_STALLED = 0.95  # of the last change: further iterations only wander


class SolidStep(NamedTuple):
    """How far a block has come.

    Attributes:
        done, total: iterations; there may be fewer in the end.
        voxels: float32 [channel, z, y, x], in the views' independent channels; see `Views.to_voxels`.
        change: root mean square change of values since the iteration before, as a share of their standard deviation.
    """

    done: int
    total: int
    voxels: Array
    change: float


def relax_solid(
    views: Mapping[str, npt.ArrayLike],
    side: int,
    *,
    key: Array,
    crops: int = CROPS,
    shared: bool | None = None,
    colours: ColourModel = "decorrelated",
    iterations: int = ITERATIONS,
) -> npt.NDArray[np.float32]:
    """Make a solid texture whose slices look like the views.

    Args:
        views: as `align_views` takes them: two or three of "xy", "xz" and "yz". Slices across an axis without a view
            are left as the others make them.
        side: voxels along each edge.
        key: random key; another key, another piece of the texture.
        crops: as in `analyse_views`.
        shared, colours: as in `align_views`.
        iterations: how often all slices are processed, at most.

    Returns:
        Voxels [z, y, x, channel], encoded as the views are, within their range of values. The block repeats
        seamlessly along all three axes.

    Raises:
        ValueError: as `align_views` and `analyse_views`; no iteration.

    Examples:
        >>> grain = np.random.default_rng(0).random((24, 24, 3))
        >>> relax_solid({"xy": grain, "xz": grain}, 16, key=jax.random.key(0)).shape
        (16, 16, 16, 3)
    """
    aligned = align_views(views, side, shared=shared, colours=colours)
    *_, last = relax_steps(aligned.pictures, side, key=key, crops=crops, iterations=iterations)
    return aligned.to_voxels(last.voxels)


def relax_steps(
    pictures: Mapping[str, npt.NDArray[np.floating]],
    side: int,
    *,
    key: Array,
    crops: int = CROPS,
    iterations: int = ITERATIONS,
) -> Iterator[SolidStep]:
    """Blocks after each iteration. It ends early when blocks hardly change less from one iteration to the next.

    Args:
        pictures: of `Views`.
        side, key, crops, iterations: as in `relax_solid`.

    Raises:
        ValueError: as `analyse_views`; no iteration.
    """
    if iterations < 1:
        raise ValueError(f"iterations: {iterations} are too few; give at least 1")
    statistics = analyse_views(pictures, side, key=jax.random.fold_in(key, 0), crops=crops)
    channels = next(iter(pictures.values())).shape[2]
    noise = jax.random.normal(jax.random.fold_in(key, 1), (channels, side, side, side), jnp.float32)
    return _relax(statistics, noise, iterations)


def _relax(statistics: Mapping[str, SliceStatistics], voxels: Array, iterations: int) -> Iterator[SolidStep]:
    last = float("inf")
    for number in range(iterations):
        before, voxels = voxels, process_block(voxels, statistics)
        change = change_of(before, voxels)
        yield SolidStep(number + 1, iterations, voxels, change)
        if number > 1 and change > _STALLED * last:
            return
        last = change


def process_block(voxels: Array, statistics: Mapping[str, SliceStatistics]) -> Array:
    """Make all slices of voxels [channel, z, y, x] look like the views, across one axis after the other."""
    for name, each in statistics.items():
        voxels = process_axis(voxels, each, AXES[name])
    return voxels


@partial(jax.jit, static_argnames="axis", compiler_options=SAME_EVERY_TIME)
def process_axis(voxels: Array, statistics: SliceStatistics, axis: int) -> Array:
    """Make all slices across one axis of voxels [channel, z, y, x] look like the view."""
    slices = jnp.moveaxis(voxels, axis + 1, 0)
    # One by one, each stays in the caches.
    made = lax.map(lambda each: process_slice(each, statistics), slices)
    return jnp.moveaxis(made, 0, axis + 1)


@partial(jax.jit, static_argnames="axis")
def measure_axis(voxels: Array, statistics: SliceStatistics, axis: int) -> tuple[Array, Array]:
    """What `measure_slice` says of the slices across one axis of voxels [channel, z, y, x], on average; [channel]."""
    slices = jnp.moveaxis(voxels, axis + 1, 0)
    inside, apart = lax.map(lambda each: measure_slice(each, statistics), slices)
    return jnp.mean(inside, axis=0), jnp.mean(apart, axis=0)


def change_of(before: Array, after: Array) -> float:
    """How much values changed: the root mean square, as a share of their standard deviation."""
    return float(_change(before, after))


@jax.jit
def _change(before: Array, after: Array) -> Array:
    return jnp.sqrt(jnp.mean(jnp.square(after - before)) / jnp.var(after))
