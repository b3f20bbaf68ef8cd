"""One pass of k-coherent search in scaled and turned neighbourhoods, over continuous sources.

What `jaxtex.synthesis.anisometric` is made of; the algorithm is described there.
"""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array, lax

from jaxtex.core.compiling import SAME_EVERY_TIME
from jaxtex.synthesis.exemplars import neighbourhood_taps, neighbourhood_weights

_LEAP = 2.0  # times as far does a place found by looking everywhere count
_JUMP = 1.5  # times as far does a place count that continues no neighbour: pieces stay whole
_APART = 2  # pixels, along either axis, between those that are decided together
_TURNS = (0, 0), (1, 1), (0, 1), (1, 0)
_AT_A_TIME = 2048  # pixels

Floats = npt.NDArray[np.float32]


class Given(NamedTuple):
    """What is wanted of a texture at one resolution.

    Attributes:
        frames: from steps of the exemplar, (row, col), to the texture's, [row, col, 2, 2].
        guide: [row, col, channel].
        transition: of the exemplar and of the texture, [row, col] each.
    """

    frames: Floats
    guide: Floats
    transition: tuple[Floats, Floats]


class Known(NamedTuple):
    """An `ExemplarLevel`'s arrays."""

    pixels: Floats
    valid: npt.NDArray[np.bool_]
    basis: Array
    features: Array
    similar: Array
    frames: Floats | None


def sample_places(picture: Array | Floats, places: Array | Floats, wrap: bool = False) -> Array:
    """A picture [row, col, channel] at places [..., 2], bilinear; beyond its border is what is at it, or on the other
    side."""
    rows, columns = picture.shape[:2]
    corner = jnp.floor(jnp.asarray(places))
    share = jnp.asarray(places) - corner
    corner = corner.astype(jnp.int32)
    flat = jnp.asarray(picture).reshape(rows * columns, picture.shape[2])

    def at(down: int, right: int) -> Array:
        row, column = corner[..., 0] + down, corner[..., 1] + right
        if wrap:
            row, column = row % rows, column % columns
        else:
            row, column = jnp.clip(row, 0, rows - 1), jnp.clip(column, 0, columns - 1)
        return flat[row * columns + column]

    down, right = share[..., :1], share[..., 1:]
    upper = (1 - right) * at(0, 0) + right * at(0, 1)
    lower = (1 - right) * at(1, 0) + right * at(1, 1)
    return (1 - down) * upper + down * lower


def order_pixels(some: npt.NDArray[np.bool_]) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """Some pixels [row, col] in the order in which they are decided: (row, col) of those that are decided together,
    [turn, pixel, 2], which lie apart, and how many they are, [turn]."""
    lattice = [-(-side // _APART) for side in some.shape]
    batch = min(_AT_A_TIME, lattice[0] * lattice[1])
    order = np.full((len(_TURNS), -(-lattice[0] * lattice[1] // batch) * batch, 2), max(some.shape), np.int32)
    counts = []
    for turn, first in enumerate(_TURNS):
        there = np.argwhere(some[first[0] :: _APART, first[1] :: _APART]) * _APART + first
        order[turn, : len(there)] = there
        counts.append(len(there))
    return order, np.array(counts, np.int32)


@partial(jax.jit, static_argnames=("radius", "everywhere", "tileable"), compiler_options=SAME_EVERY_TIME)
def decide_all(
    known: Known,
    wanted: Given,
    sources: Array,
    tolerance: Array,
    order: Array,
    counts: Array,
    radius: int,
    everywhere: bool,
    tileable: bool,
) -> Array:
    """Decide pixels anew, once, in an order of `order_pixels`: new sources [row, col, 2]."""
    weights = jnp.asarray(neighbourhood_weights(radius))[:, None]
    taps = jnp.asarray(neighbourhood_taps(radius))
    colours = known.pixels.shape[2] - wanted.guide.shape[2]
    backward = jnp.linalg.inv(wanted.frames)
    batch = min(_AT_A_TIME, order.shape[1])

    def visit(sources: Array, turn: tuple[Array, Array]) -> tuple[Array, None]:
        def decide(at: Array) -> Array:
            frame, back = wanted.frames[at[0], at[1]], backward[at[0], at[1]]
            places = at[None] + taps @ frame.T
            shown = sample_places(
                known.pixels[..., :colours], _continue_sources(known, sources, places, back, tileable)
            )
            window = jnp.concatenate([shown, sample_places(wanted.guide, places, tileable)], axis=1)
            feature = (window * weights).ravel() @ known.basis
            value = wanted.transition[1][at[0], at[1]]
            near, distance = _choose_among_few(known, wanted, feature, (value, tolerance), sources, at, back, tileable)
            near = jnp.where(jnp.isfinite(distance), near, sources[at[0], at[1]])
            if not everywhere:
                return near
            far, least = _choose_among_all(known, wanted, feature, (value, tolerance))
            return jnp.where(_LEAP * least < distance, far, near)

        def decide_some(number: Array, moved: Array) -> Array:
            some = lax.dynamic_slice_in_dim(turn[0], number * batch, batch)
            return moved.at[some[:, 0], some[:, 1]].set(jax.vmap(decide)(some), mode="drop")

        return lax.fori_loop(0, -(-turn[1] // batch), decide_some, sources), None

    return lax.scan(visit, sources, (order, counts))[0]


def _continue_sources(known: Known, sources: Array, places: Array, backward: Array, tileable: bool) -> Array:
    """Where places [tap, 2] come from, between pixels and beyond the border, if what the nearest pixel shows goes on.

    So a neighbourhood inside of a piece is as sharp as the exemplar, and none tells anything of what is not there.
    """
    limits = jnp.array(sources.shape[:2])
    pixels = jnp.rint(places).astype(jnp.int32)
    if not tileable:
        pixels = jnp.clip(pixels, 0, limits[None] - 1)
    beside = pixels % limits[None]
    return _lead(known, sources[beside[:, 0], beside[:, 1]], (places - pixels) @ backward.T)


def _lead(known: Known, sources: Array, steps: Array) -> Array:
    """Sources [place, 2] that lie some steps [place, 2] beside others, in the exemplar's own frames."""
    if known.frames is None:
        return sources + steps
    place = jnp.clip(jnp.rint(sources), 0, jnp.array(known.valid.shape)[None] - 1).astype(jnp.int32)
    return sources + jnp.einsum("nij,nj->ni", known.frames[place[:, 0], place[:, 1]], steps)


def _choose_among_few(
    known: Known,
    wanted: Given,
    feature: Array,
    pool: tuple[Array, Array],
    sources: Array,
    at: Array,
    backward: Array,
    tileable: bool,
) -> tuple[Array, Array]:
    """Of what continues the pixel's neighbours, and of places that look like it, the most alike, and how far it is."""
    rows, columns = known.valid.shape
    ends = jnp.array([rows - 1, columns - 1])
    steps = jnp.stack(jnp.meshgrid(jnp.arange(-1, 2), jnp.arange(-1, 2), indexing="ij"), axis=-1).reshape(-1, 2)
    limits = jnp.array(sources.shape[:2])
    beside = at[None] + steps
    beside = beside % limits[None] if tileable else jnp.clip(beside, 0, limits[None] - 1)
    goes_on = _lead(known, sources[beside[:, 0], beside[:, 1]], -steps.astype(sources.dtype) @ backward.T)
    whole = jnp.clip(jnp.rint(goes_on), 0, ends[None]).astype(jnp.int32)
    alike = known.similar[whole[:, 0] * columns + whole[:, 1]]
    options = jnp.stack([alike // columns, alike % columns], axis=-1) + (goes_on - whole)[:, None]
    nearest = jnp.clip(jnp.rint(options), 0, ends[None, None]).astype(jnp.int32)
    usable = (
        jnp.all((options >= 0) & (options <= ends[None, None]), axis=-1) & known.valid[nearest[..., 0], nearest[..., 1]]
    )
    usable &= jnp.abs(wanted.transition[0][nearest[..., 0], nearest[..., 1]] - pool[0]) < pool[1]
    # Features are linear in colours, so between pixels they are what features of resampled colours would be.
    theirs_look = sample_places(known.features.reshape(rows, columns, -1), options)
    jump = jnp.where(jnp.arange(known.similar.shape[1]) > 0, _JUMP, 1.0)
    distance = jnp.sum((theirs_look - feature[None, None]) ** 2, axis=-1) * jump[None]
    distance = jnp.where(usable, distance, jnp.inf).ravel()
    best = jnp.argmin(distance)
    return options.reshape(-1, 2)[best], distance[best]


def _choose_among_all(known: Known, wanted: Given, feature: Array, pool: tuple[Array, Array]) -> tuple[Array, Array]:
    """The place of the exemplar that is most alike, and how far it is."""
    usable = known.valid & (jnp.abs(wanted.transition[0] - pool[0]) < pool[1])
    distance = jnp.sum(known.features**2, axis=1) - 2 * (known.features @ feature)
    distance = jnp.where(usable.ravel(), distance, jnp.inf)
    best = jnp.argmin(distance)
    place = jnp.stack(jnp.divmod(best, known.valid.shape[1])).astype(jnp.float32)
    return place, jnp.maximum(distance[best] + jnp.sum(feature**2), 0)
