"""Texture synthesis by coherent search: M. Ashikhmin, "Synthesizing natural textures", I3D 2001.

Pixels are made in scanline order. Each is copied from that place of the exemplar, among the few that its neighbours'
sources suggest, whose neighbourhood is most like what is there already. Textures grow in irregular patches; that does
well for leaves, pebbles, grass, whose edges hide where patches meet, and less well for smooth textures.

With more candidates for each neighbour it becomes k-coherent search: X. Tong, J. Zhang, L. Liu, X. Wang, B. Guo and
H.-Y. Shum, "Synthesis of bidirectional texture functions on arbitrary surfaces", SIGGRAPH 2002, section 4.

Departures from the paper: neighbours that are not made yet have no candidates, where the paper has random ones. Later
passes compare neighbours that no target is painted on with what the pass before has left there, which the paper leaves
out. Outputs that repeat are made by a causal pass that ends at the borders, and passes over strips along them; the
paper lets the first pass look around the border, which no wavefront can follow exactly.
"""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

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
    check_exemplar,
    check_picture,
    check_shape,
    choose_place,
    draw_bits,
    draw_place,
    measure_places,
    mix_bits,
    pack_colours,
    pass_seed,
    pixel_bits,
    quantise,
    square_offsets,
)
from jaxtex.synthesis.wavefront import Canvas, Wavefronts


class _Exemplar(eqx.Module):
    """Attributes:
    colours: one word after another, each [place].
    similar: the places that each place brings as candidates, itself first, [candidate, place].
    kept: draws above this make a candidate of the row give way to a random one, uint32 [row]; absent, none do.
    """

    colours: tuple[Array, ...]
    similar: Array | None
    kept: Array | None
    shape: Shape = eqx.field(static=True)
    radius: int = eqx.field(static=True)


class _Target(eqx.Module):
    """Attributes:
    colours: one word after another, each [row, col].
    painted: boolean [row, col].
    """

    colours: tuple[Array, ...]
    painted: Array


class _Plan(NamedTuple):
    """What all passes of one synthesis share."""

    exemplar: _Exemplar
    target: _Target | None
    shape: Shape
    tileable: bool
    key: Array


def synthesise_ashikhmin(
    exemplar: npt.ArrayLike,
    shape: Shape,
    *,
    key: Array,
    radius: int = 2,
    similar: npt.ArrayLike | None = None,
    tileable: bool = False,
    target: npt.ArrayLike | None = None,
    painted: npt.ArrayLike | None = None,
    passes: int = 1,
    start: npt.ArrayLike | None = None,
    even_rows: bool = False,
) -> Array:
    """Make a texture like an exemplar, pixel by pixel in scanline order, of pieces of the exemplar.

    The result is that of a loop over rows and columns, bit for bit. All draws of a pass follow from two words drawn
    with `fold_in(key, pass)`; those of a pixel are hashes of these and its number.

    Args:
        exemplar: float [row, col, channel], values 0..1 in an encoding whose steps look even; compared in 8 bits.
        shape: (rows, columns) of the output.
        key: random key.
        radius: neighbourhoods are squares of 2 radius + 1 pixels; only places of the exemplar whose square is whole
            are copied. The paper recommends 2; smooth textures take more.
        similar: for k-coherence, the places that each place of the exemplar brings as candidates, (row, col), itself
            first: int32 [row, col, k, 2] of `find_similar`, made with the same radius. Without, candidates come alone.
        tileable: whether the output repeats seamlessly.
        target: what the output should look like from afar, float [row, col, channel], as large as the output.
        painted: where the target counts, boolean [row, col]; everywhere unless given.
        passes: after the first pass, which knows only what is above and to the left, others go over the output
            again with all neighbours known. Each comes nearer to the target.
        start: a former result, [row, col, 2], that stands in for the first pass; `passes` further ones are made.
        even_rows: replace candidates by random places the likelier, the nearer they are to the exemplar's bottom,
            which is copied more often than the rest otherwise; patches become smaller (section 3, `rand^d > d`).

    Returns:
        The source map: the (row, col) of the exemplar that each pixel is copied from, int32 [row, col, 2].

    Raises:
        ValueError: an exemplar smaller than a neighbourhood, values that are not finite, arrays whose sizes do not go
            together, sources or similar places beyond the exemplar, no pass.

    Examples:
        >>> exemplar = np.random.default_rng(0).random((32, 32, 3))
        >>> synthesise_ashikhmin(exemplar, (20, 30), key=jax.random.key(0)).shape
        (20, 30, 2)
    """
    *_, last = ashikhmin_passes(
        exemplar, shape, key=key, radius=radius, similar=similar, tileable=tileable, target=target, painted=painted,
        passes=passes, start=start, even_rows=even_rows,
    )  # fmt: skip
    return last


def ashikhmin_passes(
    exemplar: npt.ArrayLike,
    shape: Shape,
    *,
    key: Array,
    radius: int = 2,
    similar: npt.ArrayLike | None = None,
    tileable: bool = False,
    target: npt.ArrayLike | None = None,
    painted: npt.ArrayLike | None = None,
    passes: int = 1,
    start: npt.ArrayLike | None = None,
    even_rows: bool = False,
) -> Iterator[Array]:
    """The source maps of `synthesise_ashikhmin` after each pass, as they are made; arguments and errors are its."""
    pixels, shape = check_exemplar(exemplar, radius), check_shape(shape)
    if passes < 1:
        raise ValueError(f"passes: {passes} are too few; give at least 1")
    prepared = _Exemplar(
        colours=tuple(each.reshape(-1) for each in _pack(pixels)),
        similar=_check_similar(similar, pixels.shape[:2], radius),
        kept=_kept_rows(pixels.shape[0], radius) if even_rows else None,
        shape=pixels.shape[:2],
        radius=radius,
    )
    aim = _check_target(target, painted, (*shape, pixels.shape[2]))
    former = None if start is None else jnp.asarray(_check_start(start, shape, pixels.shape[:2], radius))
    return _passes(_Plan(prepared, aim, shape, tileable, key), former, passes)


def _passes(plan: _Plan, former: Array | None, passes: int) -> Iterator[Array]:
    strips = _strips(plan.shape, plan.exemplar.radius) if plan.tileable else []
    for number in range(passes) if former is None else range(1, passes + 1):
        scans = [((0, 0), plan.shape), *strips]
        for index, (corner, size) in enumerate(scans):
            seed = pass_seed(plan.key, number * len(scans) + index)
            if former is None:
                former = _first_pass(plan.exemplar, plan.target, seed, plan.shape)
            else:
                exemplar, aim = plan.exemplar, plan.target
                former = _later_pass(exemplar, aim, seed, former, jnp.asarray(corner), size, plan.tileable)
        yield _pairs(former, plan.exemplar.shape[1])


@partial(jax.jit, static_argnums=1)
def _pairs(places: Array, columns: int) -> Array:
    return jnp.stack(jnp.divmod(places, columns), axis=-1)


@partial(jax.jit, static_argnames="shape")
def _first_pass(exemplar: _Exemplar, target: _Target | None, seed: Array, shape: Shape) -> Array:
    """Places [row, col] of a pass over nothing."""
    around = jax.tree.map(lambda picture: jnp.pad(picture, exemplar.radius), target)
    return _scan(exemplar, None, around, shape, lambda row, column: pixel_bits(seed, row * shape[1] + column))


@partial(jax.jit, static_argnames=("size", "tileable"))
def _later_pass(
    exemplar: _Exemplar,
    target: _Target | None,
    seed: Array,
    former: Array,
    corner: Array,
    size: Shape,
    tileable: bool,
) -> Array:
    """Places [row, col] of a pass over a part of a former result; what surrounds the part stays as it was.

    Args:
        corner: (row, col) where the part begins. It may go on beyond the border, at the opposite one.
        size: (rows, columns) of the part.
    """
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
    exemplar: _Exemplar,
    former: Array | None,
    target: _Target | None,
    shape: Shape,
    bits: Callable[[Array, Array], Array],
) -> Array:
    """One pass over a picture of this shape.

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
    first, plain = former is None, former is None and target is None
    offsets = square_offsets(radius)[: causal + 1 if plain else None]
    aim = jax.tree.map(partial(fronts.skew, empty=0), target)
    suggesting = slice(causal) if first else slice(None)
    compared = slice(causal) if plain else slice(None)

    def compute(starts: Array, row: Array, column: Array, state: Canvas) -> Canvas:
        near = fronts.read(state.places, starts)
        colours = [fronts.read(each, starts) for each in state.colours]
        weight, seen = (near >= 0) & (np.arange(len(offsets)) != causal)[:, None], colours
        if aim is not None:
            drawn = fronts.read(aim.painted, starts) & (np.arange(len(offsets)) >= causal)[:, None]
            seen = [jnp.where(drawn, fronts.read(t, starts), c) for t, c in zip(aim.colours, colours, strict=True)]
            weight = weight | drawn
        word = bits(row, column)
        known = near[suggesting]
        places = _suggest(exemplar, known, offsets[suggesting], word, first)
        distance = measure_places(
            exemplar.colours,
            places.reshape(-1, fronts.lanes),
            offsets[compared] @ np.array([exemplar.shape[1], 1], np.int32),
            [each[compared] for each in seen],
            weight[compared],
        ).reshape(places.shape)
        distance = jnp.where((known >= 0)[None], distance, FARTHEST)
        best = choose_place(places.reshape(-1, fronts.lanes), distance.reshape(-1, fronts.lanes))
        best = jnp.where(jnp.any(known >= 0, axis=0), best, draw_place(draw_bits(word, 0), exemplar.shape, radius))
        return state.write(starts[causal], jnp.where(row >= 0, best, near[causal]), exemplar.colours)

    return fronts.unskew(fronts.run(compute, Canvas.begin(fronts, former, exemplar.colours), offsets).places)


def _suggest(exemplar: _Exemplar, known: Array, offsets: npt.NDArray[np.int32], word: Array, first: bool) -> Array:
    """The candidates that neighbours bring, [candidate, tap, lane].

    Args:
        known: places of the neighbours [tap, lane]; where there is none, any candidates will do.
        offsets: of the neighbours.
        word: of each lane.
    """
    radius, (rows, columns) = exemplar.radius, exemplar.shape
    bits = draw_bits(word[None], np.arange(1, len(offsets) + 1, dtype=np.uint32)[:, None])
    row = lax.div(known, np.int32(columns)) - offsets[:, :1]
    column = lax.rem(known, np.int32(columns)) - offsets[:, 1:]
    stays = (row >= radius) & (row < rows - radius) & (column >= radius) & (column < columns - radius)
    if first and exemplar.kept is not None:
        stays &= mix_bits(~bits) <= exemplar.kept.at[row].get(mode="clip")
    places = jnp.where(stays, row * columns + column, draw_place(bits, exemplar.shape, radius))
    if exemplar.similar is None:
        return places[None]
    return jax.vmap(lambda table: table.at[places].get(mode="promise_in_bounds"))(exemplar.similar)


def _strips(shape: Shape, radius: int) -> list[tuple[Shape, Shape]]:
    """Corners and sizes of the strips along the borders that join opposite ones."""
    height, width = (min(2 * radius, side) for side in shape)
    return [((0, shape[1] - width // 2), (shape[0], width)), ((shape[0] - height // 2, 0), (height, shape[1]))]


def _pack(pixels: npt.NDArray[np.float32]) -> tuple[Array, ...]:
    return tuple(map(jnp.asarray, pack_colours(quantise(pixels))))


def _kept_rows(rows: int, radius: int) -> Array:
    """With d from 0 at the lowest valid row to 1 at the highest, the rule rand^d > d asks for draws above d^(1/d)."""
    distance = np.clip((rows - 1 - radius - np.arange(rows)) / max(rows - 1 - 2 * radius, 1), 0.0, 1.0)
    kept = np.where(distance > 0, distance ** (1 / np.where(distance > 0, distance, 1.0)), 0.0)
    return jnp.asarray(np.floor(kept * (2**32 - 1)).astype(np.uint32))


def _check_target(
    target: npt.ArrayLike | None, painted: npt.ArrayLike | None, wanted: tuple[int, int, int]
) -> _Target | None:
    if target is None:
        if painted is not None:
            raise ValueError("painted: there is no target that it could be the mask of; give both")
        return None
    pixels = check_picture(target, "target")
    if pixels.shape != wanted:
        raise ValueError(
            f"target of shape {pixels.shape}: give {wanted}, the output's size and the exemplar's number of channels"
        )
    mask = np.ones(wanted[:2], bool) if painted is None else np.asarray(painted)
    if mask.shape != wanted[:2] or mask.dtype != bool:
        raise ValueError(f"painted of shape {mask.shape} and type {mask.dtype}: give booleans of shape {wanted[:2]}")
    return _Target(_pack(pixels), jnp.asarray(mask))


def _check_places(places: npt.ArrayLike, name: str, shape: Shape, radius: int) -> npt.NDArray[np.int32]:
    """(row, col) [..., 2] as numbers."""
    pairs = np.asarray(places)
    if not np.issubdtype(pairs.dtype, np.integer) or pairs.shape[-1:] != (2,):
        raise ValueError(f"{name} of shape {pairs.shape} and type {pairs.dtype}: give integers (row, col), [..., 2]")
    if pairs.size and (pairs.min() < radius or (pairs >= np.array(shape) - radius).any()):
        raise ValueError(f"{name}: some neighbourhoods reach beyond the exemplar; make it with radius {radius}")
    return (pairs @ np.array([shape[1], 1])).astype(np.int32)


def _check_start(start: npt.ArrayLike, shape: Shape, exemplar: Shape, radius: int) -> npt.NDArray[np.int32]:
    places = _check_places(start, "start", exemplar, radius)
    if places.shape != shape:
        raise ValueError(f"start of shape {np.shape(start)}: give {(*shape, 2)}, a result of the output's size")
    return places


def _check_similar(similar: npt.ArrayLike | None, exemplar: Shape, radius: int) -> Array | None:
    if similar is None:
        return None
    places = _check_places(similar, "similar", exemplar, radius)
    if places.ndim != 3 or places.shape[:2] != exemplar or places.shape[2] < 1:
        raise ValueError(f"similar of shape {np.shape(similar)}: give {exemplar} and (k, 2), places for each place")
    return jnp.asarray(np.moveaxis(places, -1, 0).reshape(places.shape[2], -1))
