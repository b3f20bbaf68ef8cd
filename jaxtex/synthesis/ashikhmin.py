"""Texture synthesis by coherent search: M. Ashikhmin, "Synthesizing natural textures", I3D 2001.

Pixels are made in scanline order. Each is copied from that place of the exemplar, among the few that its neighbours'
sources suggest, whose neighbourhood is most like what is there already. Textures grow in irregular patches; that does
well for leaves, pebbles, grass, whose edges hide where patches meet, and less well for smooth textures.

With more candidates for each neighbour it becomes k-coherent search: X. Tong, J. Zhang, L. Liu, X. Wang, B. Guo and
H.-Y. Shum, "Synthesis of bidirectional texture functions on arbitrary surfaces", SIGGRAPH 2002, section 4.

Departures from the paper: neighbours that are not made yet have no candidates, where the paper has random ones. Later
passes compare the lower half of squares with what the pass before has left there. A target is compared with the
exemplar as it looks from afar, blurred by twice the radius, pixel with pixel, which counts as much as all pixels of the
causal neighbourhood; the paper compares it with the exemplar itself, in the lower half of the square, so that textures
flatten with each pass. Where it is painted, a random place is one more candidate, if it is four times nearer than all
others. Outputs that repeat are made by a
causal pass that ends at the borders, and passes over strips along them; the paper lets the first pass look around the
border, which no wavefront can follow exactly.
"""

from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array
from scipy.ndimage import gaussian_filter

from jaxtex.synthesis.coherent_pass import Exemplar, Target, first_pass, later_pass
from jaxtex.synthesis.neighbourhoods import (
    Shape,
    check_exemplar,
    check_picture,
    check_shape,
    pack_colours,
    pass_seed,
    quantise,
)
from jaxtex.synthesis.sources import Sources, Step, last_of


class _Part(NamedTuple):
    """A part of the output: (row, col) where it begins, and (rows, columns). Beyond the border, it goes on at the
    opposite one."""

    corner: Shape
    size: Shape


class _Plan(NamedTuple):
    """What all passes of one synthesis share."""

    exemplar: Exemplar
    target: Target | None
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
) -> Sources:
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
        target: what the output should look like from afar, float [row, col, channel], as large as the output. Colours
            that the exemplar, blurred, has somewhere are followed best.
        painted: where the target counts, boolean [row, col]; everywhere unless given.
        passes: after the first pass, which knows only what is above and to the left, others go over the output
            again with all neighbours known. Most come nearer to the target.
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
    return last_of(
        ashikhmin_steps(
            exemplar, shape, key=key, radius=radius, similar=similar, tileable=tileable, target=target,
            painted=painted, passes=passes, start=start, even_rows=even_rows,
        )
    )  # fmt: skip


def ashikhmin_steps(
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
) -> Iterator[Step]:
    """`synthesise_ashikhmin`, pass by pass.

    Raises:
        ValueError: as `synthesise_ashikhmin` does, at once.
    """
    pixels, shape = check_exemplar(exemplar, radius), check_shape(shape)
    if passes < 1:
        raise ValueError(f"passes: {passes} are too few; give at least 1")
    aim = _check_target(target, painted, (*shape, pixels.shape[2]))
    prepared = Exemplar(
        colours=_pack_places(pixels),
        afar=() if aim is None else _pack_places(gaussian_filter(pixels, (2 * radius, 2 * radius, 0))),
        similar=_check_similar(similar, pixels.shape[:2], radius),
        kept=_kept_rows(pixels.shape[0], radius) if even_rows else None,
        shape=pixels.shape[:2],
        radius=radius,
    )
    former = None if start is None else jnp.asarray(_check_start(start, shape, pixels.shape[:2], radius))
    return _passes(_Plan(prepared, aim, shape, tileable, key), former, passes)


def _passes(plan: _Plan, former: Array | None, passes: int) -> Iterator[Step]:
    whole = _Part((0, 0), plan.shape)
    begun = int(former is not None)
    for number in range(begun, begun + passes):
        key = jax.random.fold_in(plan.key, number)
        if former is None:
            former = first_pass(plan.exemplar, plan.target, pass_seed(key, 0), plan.shape)
            former = _join_borders(plan, former, key) if plan.tileable else former
        else:
            former = _go_over(plan, former, whole, pass_seed(key, 0))
        sources = np.stack(np.divmod(np.asarray(former), np.int32(plan.exemplar.shape[1])), axis=-1)
        yield Step(number - begun + 1, passes, sources)


def _join_borders(plan: _Plan, places: Array, key: Array) -> Array:
    """Make opposite borders meet: strips along them, and then the corner, are emptied, grown again from what surrounds
    them, and gone over once more."""
    for index, (emptied, visited) in enumerate(_strips(plan.shape, plan.exemplar.radius)):
        places = _empty(places, jnp.asarray(emptied.corner), emptied.size)
        for turn in range(2):
            places = _go_over(plan, places, visited, pass_seed(key, 1 + 2 * index + turn))
    return places


def _strips(shape: Shape, radius: int) -> list[tuple[_Part, _Part]]:
    """What is emptied and what is visited, of the strip across the left and right borders, of that across the lower and
    upper ones, and of where these two cross.

    The widths are measured: in strips as wide as a neighbourhood, seams stay as they are, for lack of candidates that
    lead from one side to the other.
    """
    grown = [min(8 * radius, side // 4) for side in shape]
    inside = [(reach, side - 2 * reach) for reach, side in zip(grown, shape, strict=True)]
    across = [(side - reach, 2 * reach) for reach, side in zip(grown, shape, strict=True)]
    around = [(side - min(10 * radius, side // 2), min(20 * radius, side)) for side in shape]
    pairs = [
        ((inside[0], across[1]), (inside[0], around[1])),
        ((across[0], inside[1]), (around[0], inside[1])),
        ((across[0], across[1]), (around[0], around[1])),
    ]
    rows = [[_Part((y[0], x[0]), (y[1], x[1])) for y, x in pair] for pair in pairs]
    return [(emptied, visited) for emptied, visited in rows]


@partial(jax.jit, static_argnames="size")
def _empty(places: Array, corner: Array, size: Shape) -> Array:
    rolled = jnp.roll(places, -corner, axis=(0, 1))
    return jnp.roll(rolled.at[: size[0], : size[1]].set(-1), corner, axis=(0, 1))


def _go_over(plan: _Plan, former: Array, part: _Part, seed: Array) -> Array:
    return later_pass(plan.exemplar, plan.target, seed, former, jnp.asarray(part.corner), part.size, plan.tileable)


def _pack(pixels: npt.NDArray[np.float32]) -> tuple[Array, ...]:
    return tuple(map(jnp.asarray, pack_colours(quantise(pixels))))


def _pack_places(pixels: npt.NDArray[np.float32]) -> tuple[Array, ...]:
    return tuple(each.reshape(-1) for each in _pack(pixels))


def _kept_rows(rows: int, radius: int) -> Array:
    """With d from 0 at the lowest valid row to 1 at the highest, the rule rand^d > d asks for draws above d^(1/d)."""
    distance = np.clip((rows - 1 - radius - np.arange(rows)) / max(rows - 1 - 2 * radius, 1), 0.0, 1.0)
    kept = np.where(distance > 0, distance ** (1 / np.where(distance > 0, distance, 1.0)), 0.0)
    return jnp.asarray(np.floor(kept * (2**32 - 1)).astype(np.uint32))


def _check_target(
    target: npt.ArrayLike | None, painted: npt.ArrayLike | None, wanted: tuple[int, int, int]
) -> Target | None:
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
    return Target(_pack(pixels), jnp.asarray(mask))


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
