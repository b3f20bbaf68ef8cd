"""One pass of coherent search: pixels copied from the places that their neighbours' sources suggest.

What `jaxtex.synthesis.ashikhmin` is made of; the algorithm is described there.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array, lax

from jaxtex.synthesis.neighbourhoods import (
    FARTHEST,
    Shape,
    causal_taps,
    choose_place,
    draw_bits,
    draw_place,
    measure_places,
    mix_bits,
    pixel_bits,
    square_offsets,
)
from jaxtex.synthesis.wavefront import Canvas, Wavefronts

_LEAP = 4  # times as far does a place count that continues no neighbour


class Exemplar(eqx.Module):
    """Attributes:
    colours: one word after another, each [place].
    afar: the same of the exemplar as seen from afar, which is what targets ask for; empty without one.
    similar: the places that each place brings as candidates, itself first, [candidate, place].
    kept: draws above this make a candidate of the row give way to a random one, uint32 [row]; absent, none do.
    """

    colours: tuple[Array, ...]
    afar: tuple[Array, ...]
    similar: Array | None
    kept: Array | None
    shape: Shape = eqx.field(static=True)
    radius: int = eqx.field(static=True)


class Target(eqx.Module):
    """Attributes:
    colours: one word after another, each [row, col].
    painted: boolean [row, col].
    """

    colours: tuple[Array, ...]
    painted: Array


@partial(jax.jit, static_argnames="shape")
def first_pass(exemplar: Exemplar, target: Target | None, seed: Array, shape: Shape) -> Array:
    """Places [row, col] of a pass over nothing."""
    around = jax.tree.map(lambda picture: jnp.pad(picture, exemplar.radius), target)
    return _scan(exemplar, None, around, shape, lambda row, column: pixel_bits(seed, row * shape[1] + column))


@partial(jax.jit, static_argnames=("size", "tileable"))
def later_pass(
    exemplar: Exemplar,
    target: Target | None,
    seed: Array,
    former: Array,
    corner: Array,
    size: Shape,
    tileable: bool,
) -> Array:
    """Places [row, col] of a pass over a part of a former result; what surrounds the part stays as it was."""
    radius, (rows, columns) = exemplar.radius, former.shape
    rolled = jnp.roll(former, -corner, axis=(0, 1))

    def surround(picture: Array, **mode: Any) -> Array:
        whole = jnp.pad(picture, radius, **({"mode": "wrap"} if tileable else mode))
        return whole[: size[0] + 2 * radius, : size[1] + 2 * radius]

    def bits(row: Array, column: Array) -> Array:
        return pixel_bits(seed, (row + corner[0]) % rows * columns + (column + corner[1]) % columns)

    aim = jax.tree.map(lambda picture: surround(jnp.roll(picture, -corner, axis=(0, 1))), target)
    made = _scan(exemplar, surround(rolled, constant_values=-1), aim, size, bits)
    return jnp.roll(rolled.at[: size[0], : size[1]].set(made), corner, axis=(0, 1))


def _scan(
    exemplar: Exemplar,
    former: Array | None,
    target: Target | None,
    shape: Shape,
    bits: Callable[[Array, Array], Array],
) -> Array:
    """One pass over a picture of this shape.

    A target weighs as much as all pixels of the causal neighbourhood together. Where it is painted, a random place is a
    candidate, too: neighbours may all lead to colours that are not asked for. It must be much nearer than they, so that
    pieces stay whole.

    Args:
        former: places [row, col] with surroundings of the radius's width, -1 where there is nothing. Without, this is
            the first pass: only the causal neighbourhood brings candidates.
        target: with surroundings.
        bits: the word of a pixel at (row, column).

    Returns:
        Places [row, col], without surroundings.
    """
    radius, causal = exemplar.radius, causal_taps(exemplar.radius)
    fronts = Wavefronts((shape[0] + 2 * radius, shape[1] + 2 * radius), radius)
    first = former is None
    offsets = square_offsets(radius)[: causal + 1 if first else None]
    aim = jax.tree.map(partial(fronts.skew, empty=0), target)
    taken = slice(causal) if first else slice(None)

    def compute(starts: Array, row: Array, column: Array, state: Canvas) -> Canvas:
        near = fronts.read(state.places, starts)
        word = bits(row, column)
        known = near[taken]
        places = _suggest(exemplar, known, offsets[taken], word, first)
        each_lane = places.reshape(-1, fronts.lanes)
        usable = jnp.broadcast_to((known >= 0)[None], places.shape).reshape(each_lane.shape)
        if aim is not None:
            painted = fronts.read(aim.painted, starts[causal : causal + 1])
            leap = draw_place(draw_bits(word, len(square_offsets(radius)) + 1), exemplar.shape, radius)[None]
            each_lane, usable = jnp.concatenate([each_lane, leap]), jnp.concatenate([usable, painted])
        distance = measure_places(
            exemplar.colours,
            each_lane,
            offsets[taken] @ np.array([exemplar.shape[1], 1], np.int32),
            [fronts.read(each, starts[taken]) for each in state.colours],
            (known >= 0) & (np.arange(len(known)) != causal)[:, None],
        )
        if aim is not None:
            here = partial(fronts.read, starts=starts[causal : causal + 1])
            distance += causal * _miss_target(exemplar, aim, each_lane, here)
            distance = distance.at[-1].set(_LEAP * jnp.minimum(distance[-1], FARTHEST // _LEAP))
        best = choose_place(each_lane, jnp.where(usable, distance, FARTHEST))
        best = jnp.where(jnp.any(known >= 0, axis=0), best, draw_place(draw_bits(word, 0), exemplar.shape, radius))
        return state.write(starts[causal], jnp.where(row >= 0, best, near[causal]), exemplar.colours)

    return fronts.unskew(fronts.run(compute, Canvas.begin(fronts, former, exemplar.colours), offsets).places)


def _miss_target(exemplar: Exemplar, aim: Target, places: Array, read: Callable[..., Array]) -> Array:
    """How far places [candidate, lane] are, seen from afar, from what is painted there; 0 where nothing is."""
    wanted = [read(each) for each in aim.colours]
    return measure_places(exemplar.afar, places, np.zeros(1, np.int32), wanted, read(aim.painted))


def _suggest(exemplar: Exemplar, known: Array, offsets: npt.NDArray[np.int32], word: Array, first: bool) -> Array:
    """The candidates that neighbours bring, [candidate, tap, lane].

    Args:
        known: places of the neighbours [tap, lane]; where there is none, any candidates will do.
        offsets: of the neighbours.
        word: of each lane.
    """
    radius, (rows, columns) = exemplar.radius, exemplar.shape
    bits = draw_bits(word[None], jnp.arange(1, len(offsets) + 1)[:, None])
    row = lax.div(known, np.int32(columns)) - offsets[:, :1]
    column = lax.rem(known, np.int32(columns)) - offsets[:, 1:]
    stays = (row >= radius) & (row < rows - radius) & (column >= radius) & (column < columns - radius)
    if first and exemplar.kept is not None:
        stays &= mix_bits(~bits) <= exemplar.kept.at[row].get(mode="clip")
    places = jnp.where(stays, row * columns + column, draw_place(bits, exemplar.shape, radius))
    if exemplar.similar is None:
        return places[None]
    return jax.vmap(lambda table: table.at[places].get(mode="promise_in_bounds"))(exemplar.similar)
