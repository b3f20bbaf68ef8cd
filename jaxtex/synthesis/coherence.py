"""Textures by multi-resolution k-coherence search: from coarse to fine, each pixel takes, of the
few places of the exemplar that its neighbours lead to, the one whose neighbourhood is most like its own.

The candidates are those of M. Ashikhmin ("Synthesizing natural textures", I3D 2001), the continuations of what the
neighbours are copied from, and places that look like these (X. Tong et al., "Synthesis of bidirectional texture
functions on arbitrary surfaces", SIGGRAPH 2002). As in S. Lefebvre and H. Hoppe ("Parallel controllable texture
synthesis", SIGGRAPH 2005), whole squares are compared, at every level, and pixels that lie apart are decided together.

Departures: the coarsest level does not begin with noise but with blocks of the exemplar, evenly spread over it, so that
things are whole from the beginning and all of the exemplar is used. What remains to be done is to make blocks meet;
only where no candidate fits, all of the exemplar is searched, as textures are the smoother, the more often what looks
most alike is chosen. The texture repeats without a seam.
"""

import math
from collections.abc import Iterator
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array, lax

from jaxtex.core.compiling import SAME_EVERY_TIME
from jaxtex.synthesis.coarse_start import grow_inwards, lay_blocks
from jaxtex.synthesis.exemplars import (
    ExemplarLevel,
    analyse_levels,
    halve,
    halve_mask,
    neighbourhood_weights,
)
from jaxtex.synthesis.guides import GUIDE_WEIGHT, weigh_guides
from jaxtex.synthesis.neighbourhoods import check_exemplar, check_shape
from jaxtex.synthesis.sources import Sources, Step, last_of, magnify_places

_COARSEST = 32  # pixels along the shorter side of an exemplar
_PASSES, _COARSE_PASSES = 2, 6
_SIMILAR = 4  # places of each neighbour, its own continuation among them
_LEAP = 2.0  # times as far does a place found by looking everywhere count
_JUMP = 1.5  # times as far does a place count that continues no neighbour: pieces stay whole
_SEARCHED = 1 << 28  # pairs of pixel and place that are all compared, at most
_APART = 2  # pixels, along either axis, between those that are decided together
_AT_A_TIME = 2048  # pixels


def synthesise_coherence(
    exemplar: npt.ArrayLike,
    shape: tuple[int, int],
    *,
    key: Array,
    radius: int = 3,
    guides: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    guide_weight: float = GUIDE_WEIGHT,
) -> Sources:
    """Make a texture from an exemplar. It repeats seamlessly.

    Args:
        exemplar: floats [row, col, channel], in an encoding whose steps look even, as sRGB's.
        shape: (rows, columns) of the texture, any.
        key: random key; another key, another piece of the texture.
        radius: of the neighbourhoods that are compared, in pixels of each level.
        guides: of the exemplar, [row, col, channel], and of the texture, [*shape, channel]: places are copied to where
            their guide is like the texture's. Their values may be of any scale.
        guide_weight: how much the guide counts, of what colours count; above 0. Where it asks for what the exemplar
            hardly has, the more it counts, the more often the same place is copied.

    Returns:
        The source map, int32 [*shape, 2]; see `jaxtex.synthesis.sources`.

    Raises:
        ValueError: arrays of another form, NaN or infinite values, an exemplar smaller than a neighbourhood.

    Examples:
        >>> grain = np.random.default_rng(0).random((40, 40, 3))
        >>> synthesise_coherence(grain, (50, 75), key=jax.random.key(0)).shape
        (50, 75, 2)
    """
    return last_of(coherence_steps(exemplar, shape, key=key, radius=radius, guides=guides, guide_weight=guide_weight))


def coherence_steps(
    exemplar: npt.ArrayLike,
    shape: tuple[int, int],
    *,
    key: Array,
    radius: int = 3,
    guides: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    guide_weight: float = GUIDE_WEIGHT,
) -> Iterator[Step]:
    """The same step by step, with the source map so far, from coarse to fine."""
    pixels = check_exemplar(exemplar, radius)
    shape = check_shape(shape)
    pixels, guide = weigh_guides(pixels, guides, shape, guide_weight)
    levels = analyse_levels(pixels, np.ones(pixels.shape[:2], bool), radius=radius, coarsest=_COARSEST)
    return _refine(levels, guide, np.zeros(shape, bool), key=key, radius=radius, wrap=True)


def inpaint_coherence(picture: npt.ArrayLike, hole: npt.ArrayLike, *, key: Array, radius: int = 3) -> Sources:
    """Fill a hole of a picture with what is around it.

    Args:
        picture: floats [row, col, channel]; what it holds in the hole does not matter.
        hole: bool [row, col].
        key, radius: as in `synthesise_coherence`.

    Returns:
        The source map, int32 [row, col, 2]: outside of the hole each pixel is its own source.

    Raises:
        ValueError: as `synthesise_coherence`; no neighbourhood is free of the hole.

    Examples:
        >>> stripes = np.tile(np.float32([0, 0, 1, 1]), (40, 10))[..., None]
        >>> hole = np.zeros((40, 40), bool)
        >>> hole[15:25, 15:25] = True
        >>> sources = inpaint_coherence(np.where(hole[..., None], 0.5, stripes), hole, key=jax.random.key(0))
        >>> bool((stripes[sources[..., 0], sources[..., 1]] == stripes).all())
        True
    """
    return last_of(inpaint_steps(picture, hole, key=key, radius=radius))


def inpaint_steps(picture: npt.ArrayLike, hole: npt.ArrayLike, *, key: Array, radius: int = 3) -> Iterator[Step]:
    """The same step by step, with the source map so far."""
    pixels, known = np.asarray(picture, np.float32), ~np.asarray(hole, bool)
    if known.shape != pixels.shape[:2]:
        raise ValueError(f"hole of shape {known.shape}: give the picture's, {pixels.shape[:2]}")
    pixels = check_exemplar(np.where(known[..., None], pixels, 0) if pixels.ndim == 3 else pixels, radius)
    levels = analyse_levels(pixels, known, radius=radius, coarsest=_COARSEST)
    return _refine(levels, np.zeros((*known.shape, 0), np.float32), known, key=key, radius=radius, wrap=False)


def _refine(
    levels: list[ExemplarLevel],
    guide: npt.NDArray[np.float32],
    kept: npt.NDArray[np.bool_],
    *,
    key: Array,
    radius: int,
    wrap: bool,
) -> Iterator[Step]:
    """From coarse to fine; `kept` pixels [row, col] are their own sources."""
    givens = [(guide, kept)]
    for _ in levels[1:]:
        guide, kept = givens[-1]
        givens.append((halve(guide, np.ones_like(kept)), halve_mask(kept)))
    total, done = _COARSE_PASSES + _PASSES * (len(levels) - 1), 0
    guide, kept = givens[-1]
    places = grow_inwards(levels[-1], kept, radius) if kept.any() else lay_blocks(levels[-1], guide, key, radius)
    for number in reversed(range(len(levels))):
        level, (guide, kept) = levels[number], givens[number]
        first = number == len(levels) - 1
        if not first:
            places = _double(places, levels[number + 1], level, kept.shape)
        if kept.any():
            places = np.where(kept, np.arange(kept.size, dtype=np.int32).reshape(kept.shape), places)
        everywhere = first and places.size * level.valid.size <= _SEARCHED
        for _ in range(_COARSE_PASSES if first else _PASSES):
            places = _correct(level, places, guide, kept, radius, wrap, everywhere)
            done += 1
            sources = magnify_places(places, level.valid.shape[1], number, givens[0][1].shape, levels[0].valid.shape)
            yield Step(done, total, sources)


def _double(
    places: npt.NDArray[np.int32], coarse: ExemplarLevel, fine: ExemplarLevel, shape: tuple[int, int]
) -> npt.NDArray[np.int32]:
    """Places of the next finer level: below those of the coarser one."""
    row, column = np.indices(shape, np.int32)
    above = places[row // 2, column // 2]
    rows, columns = fine.valid.shape
    down = np.minimum(2 * (above // coarse.valid.shape[1]) + row % 2, rows - 1)
    right = np.minimum(2 * (above % coarse.valid.shape[1]) + column % 2, columns - 1)
    return fine.nearest_valid[down * columns + right]


def _correct(
    level: ExemplarLevel,
    places: npt.NDArray[np.int32],
    guide: npt.NDArray[np.float32],
    kept: npt.NDArray[np.bool_],
    radius: int,
    wrap: bool,
    everywhere: bool,
) -> npt.NDArray[np.int32]:
    """Decide all pixels anew, once."""
    arrays = (level.pixels, level.valid, level.basis, level.features, level.similar[:, :_SIMILAR])
    return np.asarray(_decide(*arrays, places, guide, kept, radius, wrap, everywhere))


@partial(jax.jit, static_argnums=(8, 9, 10), compiler_options=SAME_EVERY_TIME)
def _decide(
    pixels: Array,
    valid: Array,
    basis: Array,
    features: Array,
    similar: Array,
    places: Array,
    guide: Array,
    kept: Array,
    radius: int,
    wrap: bool,
    everywhere: bool,
) -> Array:
    rows, columns = valid.shape
    side, mode = 2 * radius + 1, "wrap" if wrap else "edge"
    weights = jnp.asarray(neighbourhood_weights(radius))[:, None]
    colours = pixels.shape[2] - guide.shape[2]
    jump = jnp.where(jnp.arange(similar.shape[1]) > 0, _JUMP, 1.0)
    length = jnp.where(valid.ravel(), jnp.sum(features**2, axis=1), jnp.inf)
    steps = jnp.arange(-1, 2)
    lattice = tuple(-(-each // _APART) for each in places.shape)

    def among_all(feature: Array) -> tuple[Array, Array]:
        distance = length - 2 * (features @ feature)
        best = jnp.argmin(distance)
        return best, jnp.maximum(distance[best] + jnp.sum(feature**2), 0)

    def among_few(feature: Array, around: Array) -> tuple[Array, Array]:
        options = similar[around]  # [row, col, similar]
        row = options // columns - steps[:, None, None]
        column = options % columns - steps[None, :, None]
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        options = jnp.where(inside, row * columns + column, 0)
        distance = jnp.sum((features[options] - feature[None, None, None]) ** 2, axis=-1) * jump[None, None]
        distance = jnp.where(inside & valid.ravel()[options], distance, jnp.inf)
        best = jnp.argmin(distance)
        return options.ravel()[best], distance.ravel()[best]

    def visit(places: Array, offset: Array) -> tuple[Array, None]:
        seen = jnp.concatenate([pixels.reshape(-1, pixels.shape[2])[places][..., :colours], guide], axis=2)
        seen = jnp.pad(seen, [(radius, radius), (radius, radius), (0, 0)], mode=mode)
        around = jnp.pad(places, 1, mode=mode)
        row = jnp.minimum(offset[0] + _APART * jnp.arange(lattice[0]), places.shape[0] - 1)
        column = jnp.minimum(offset[1] + _APART * jnp.arange(lattice[1]), places.shape[1] - 1)

        def decide(index: Array) -> Array:
            at = row[index // lattice[1]], column[index % lattice[1]]
            window = lax.dynamic_slice(seen, (*at, jnp.zeros_like(at[0])), (side, side, seen.shape[2]))
            feature = (window.reshape(side * side, -1) * weights).ravel() @ basis
            near, distance = among_few(feature, lax.dynamic_slice(around, at, (3, 3)))
            if not everywhere:
                return near
            far, least = among_all(feature)
            return jnp.where(_LEAP * least < distance, far, near)

        found = lax.map(decide, jnp.arange(math.prod(lattice)), batch_size=_AT_A_TIME).reshape(lattice)
        moved = places.at[row[:, None], column[None, :]].set(found.astype(places.dtype))
        return jnp.where(kept, places, moved), None

    offsets = jnp.array([(0, 0), (1, 1), (0, 1), (1, 0)])
    return lax.scan(visit, places, offsets)[0]
