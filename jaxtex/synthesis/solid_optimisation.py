"""Solid textures from orthogonal views by optimisation: for textures with edges, and with things in them.

J. Kopf, C.-W. Fu, D. Cohen-Or, O. Deussen, D. Lischinski and T.-T. Wong, "Solid texture synthesis from 2D exemplars"
(SIGGRAPH 2007): around each voxel, the neighbourhoods in the slices of all axes are to look like some place of their
view. From coarse to fine, by turns, the place most like each neighbourhood is looked for, and voxels become the mean of
what the places that overlap there say, those counting most that fit best.

Places are the less preferred the more often they are taken already: the position histogram of J. Chen and B. Wang
("High quality solid texture synthesis using position and index histogram matching", The Visual Computer 2010), without
which some few smooth places would make up the block. Where views are large, candidates are the continuations of what
the neighbours of a voxel are taken from, in its slice and the two beside it, and places that look like these.

Departure: means are blurred, and blurred neighbourhoods find blurred places. So after each turn the slices are given
the amplitudes and the histogram of their views, as by relaxation (`jaxtex.synthesis.solid_relaxation`), which leaves
the phases: what is where.
"""

from collections.abc import Iterator, Mapping
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array, lax
from scipy.ndimage import zoom

from jaxtex.core.compiling import SAME_EVERY_TIME
from jaxtex.synthesis.exemplars import ExemplarLevel, analyse_levels, neighbourhood_weights
from jaxtex.synthesis.slices import SliceStatistics
from jaxtex.synthesis.solid_relaxation import SolidStep, change_of, process_block
from jaxtex.synthesis.solid_views import AXES, ColourModel, align_views, analyse_views, apply_once

ITERATIONS = 8
"""Turns at each resolution, unless told."""

_COARSEST = 16  # voxels along an edge, at least
_RADIUS = 3  # of neighbourhoods
_SPACING = 2  # voxels, along rows and columns, between neighbourhoods that are compared
_SIMILAR = 4  # places of each neighbour, its own continuation among them
_SEARCHED = 1 << 28  # pairs of neighbourhood and place that are all compared, at most
_CELL = 4  # pixels along the sides of the squares whose use is counted
_ROBUST = 0.8  # the power of differences that is least in sum
_LEAST = 0.01  # of the variance of neighbourhoods: smaller differences count alike
_TIE = 1e-6  # of that variance: what differs less is the same
_LARGEST = 4  # times as large as the block is what is used of a view at most
_FAINT = 0.01  # of a view's variance: levels with less show nothing of it

Floats = npt.NDArray[np.floating]
Places = npt.NDArray[np.int32]


class _Exemplar(NamedTuple):
    """A view at one resolution; see `ExemplarLevel`."""

    pixels: Array
    valid: Array
    basis: Array
    features: Array
    similar: Array


def optimise_solid(
    views: Mapping[str, npt.ArrayLike],
    side: int,
    *,
    key: Array,
    shared: bool | None = None,
    colours: ColourModel = "decorrelated",
    iterations: int = ITERATIONS,
) -> npt.NDArray[np.float32]:
    """Make a solid texture whose slices look like the views, edges and things included.

    It takes several times as long as `relax_solid`.

    Args:
        views: as `align_views` takes them: two or three of "xy", "xz" and "yz". Of pictures more than four times as
            large as the block, the middle is used.
        side: voxels along each edge.
        key: random key; another key, another piece of the texture.
        shared, colours: as in `align_views`.
        iterations: turns at each resolution.

    Returns:
        Voxels [z, y, x, channel], encoded as the views are, within their range of values. The block repeats
        seamlessly along all three axes.

    Raises:
        ValueError: as `align_views` and `analyse_views`; less than 8 voxels along an edge; no iteration.

    Examples:
        >>> grain = np.random.default_rng(0).random((24, 24, 3))
        >>> optimise_solid({"xy": grain, "xz": grain}, 16, key=jax.random.key(0), iterations=2).shape
        (16, 16, 16, 3)
    """
    aligned = align_views(views, side, shared=shared, colours=colours)
    *_, last = optimise_steps(aligned.pictures, side, key=key, iterations=iterations)
    return aligned.to_voxels(last.voxels)


def optimise_steps(
    pictures: Mapping[str, Floats], side: int, *, key: Array, iterations: int = ITERATIONS
) -> Iterator[SolidStep]:
    """Blocks after each turn, coarse ones at first.

    Args:
        pictures: of `Views`.
        side, key, iterations: as in `optimise_solid`.

    Raises:
        ValueError: as `analyse_views`; no iteration.
    """
    if iterations < 1:
        raise ValueError(f"iterations: {iterations} are too few; give at least 1")
    if side < 2 * _RADIUS + 2:
        raise ValueError(f"side: {side} voxels are too few for neighbourhoods; give at least {2 * _RADIUS + 2}")
    pyramids = _analyse_levels(pictures, side)
    count = len(next(iter(pyramids.values())))
    sides = [-(-side // 2**number) for number in range(count)]
    statistics = [
        # The same key takes crops at the same places of all levels.
        analyse_views(
            {name: pyramid[number].pixels for name, pyramid in pyramids.items()}, sides[number], key=_fold(key, 0)
        )
        for number in range(count)
    ]
    return _optimise(pyramids, statistics, sides, _fold(key, 1), iterations)


def _fold(key: Array, *numbers: int) -> Array:
    for number in numbers:
        key = jax.random.fold_in(key, number)
    return key


def _analyse_levels(pictures: Mapping[str, Floats], side: int) -> dict[str, list[ExemplarLevel]]:
    """From fine to coarse, as many of each view: until the block is small, or nothing is left of what a view shows."""
    wanted = max(1, int(np.log2(side / _COARSEST)) + 1)

    def analyse(picture: Floats) -> list[ExemplarLevel]:
        start = [max(0, (each - _LARGEST * side) // 2) for each in picture.shape[:2]]
        middle = picture[tuple(slice(each, each + _LARGEST * side) for each in start)].astype(np.float32)
        coarsest = min(middle.shape[:2]) >> (wanted - 1)
        levels = analyse_levels(middle, np.ones(middle.shape[:2], bool), radius=_RADIUS, coarsest=coarsest)
        contrast = [level.pixels.var(axis=(0, 1)).sum() for level in levels]
        return levels[: sum(each > _FAINT * contrast[0] for each in contrast)]

    pyramids = apply_once(analyse, pictures)
    count = min(map(len, pyramids.values()))
    return {name: levels[:count] for name, levels in pyramids.items()}


def _optimise(
    pyramids: dict[str, list[ExemplarLevel]],
    statistics: list[dict[str, SliceStatistics]],
    sides: list[int],
    key: Array,
    iterations: int,
) -> Iterator[SolidStep]:
    done, total = 0, iterations * len(sides)
    for number in reversed(range(len(sides))):
        levels = {name: pyramid[number] for name, pyramid in pyramids.items()}
        if number == len(sides) - 1:
            voxels, places = _start(levels, sides[number], key)
        else:
            coarse = {name: pyramid[number + 1] for name, pyramid in pyramids.items()}
            voxels = _enlarge(voxels, sides[number])
            places = {name: _descend(places[name], coarse[name], levels[name], sides[number]) for name in levels}
        exemplars = apply_once(_gather, levels)
        for _ in range(iterations):
            before = voxels
            voxels, places = _improve(voxels, places, exemplars)
            voxels = process_block(voxels, statistics[number])
            done += 1
            yield SolidStep(done, total, voxels, change_of(before, voxels))


def _gather(level: ExemplarLevel) -> _Exemplar:
    arrays = (level.pixels, level.valid, level.basis, level.features, level.similar[:, :_SIMILAR])
    return _Exemplar(*(jnp.asarray(each) for each in arrays))


def _start(levels: dict[str, ExemplarLevel], side: int, key: Array) -> tuple[Array, dict[str, Array]]:
    """Voxels of random colours, and places at random."""
    pixels = next(iter(levels.values())).pixels
    drawn = jax.random.choice(_fold(key, 0), jnp.asarray(pixels.reshape(-1, pixels.shape[2])), (side,) * 3)
    lattice = -(-side // _SPACING)
    places = {
        name: jax.random.choice(_fold(key, 1, AXES[name]), np.flatnonzero(level.valid), (side, lattice, lattice))
        for name, level in levels.items()
    }
    return jnp.moveaxis(drawn, -1, 0), {name: each.astype(jnp.int32) for name, each in places.items()}


def _enlarge(voxels: Array, side: int) -> Array:
    factors = (1.0, *(side / each for each in voxels.shape[1:]))
    return jnp.asarray(zoom(np.asarray(voxels), factors, order=1, mode="grid-wrap", grid_mode=True))


def _descend(places: Array, coarse: ExemplarLevel, fine: ExemplarLevel, side: int) -> Array:
    """Places of the next finer level: below those of the coarser one that are nearest to their voxels in the enlarged
    block, and as far from what is below these."""
    above = np.asarray(places)
    factor = side / len(above)
    at = np.arange(0, side, _SPACING)
    nearest = np.rint(((at + 0.5) / factor - 0.5) / _SPACING).astype(int)
    away = at - ((_SPACING * nearest + 0.5) * factor - 0.5)
    nearest = nearest % above.shape[1]
    slices = ((np.arange(side) + 0.5) / factor).astype(int)
    above = above[slices[:, None, None], nearest[:, None], nearest]
    rows, columns = fine.valid.shape
    down = np.floor(2 * (above // coarse.valid.shape[1]) + 1 + away[:, None]).astype(int)
    right = np.floor(2 * (above % coarse.valid.shape[1]) + 1 + away).astype(int)
    return jnp.asarray(fine.nearest_valid[np.clip(down, 0, rows - 1) * columns + np.clip(right, 0, columns - 1)])


def _improve(
    voxels: Array, places: dict[str, Array], exemplars: dict[str, _Exemplar]
) -> tuple[Array, dict[str, Array]]:
    """Look for the places once, and take the mean of what they say."""
    total, found = jnp.zeros((len(voxels) + 1, *voxels.shape[1:]), voxels.dtype), {}
    for name, exemplar in exemplars.items():
        everywhere = places[name].size * exemplar.valid.size <= _SEARCHED
        found[name], distance = _find_places(voxels, places[name], exemplar, AXES[name], everywhere)
        total = _add_places(total, found[name], distance, exemplar, AXES[name])
    return total[:-1] / total[-1:], found


@partial(jax.jit, static_argnums=(3, 4), compiler_options=SAME_EVERY_TIME)
def _find_places(voxels: Array, places: Array, exemplar: _Exemplar, axis: int, everywhere: bool) -> tuple[Array, Array]:
    """For each neighbourhood of the slices across an axis, the place of the view that is most like it.

    Args:
        voxels: [channel, z, y, x].
        places: row * columns + column, as they were, [slice, row, col] of the lattice of neighbourhoods.
        exemplar: the view.
        axis: across which.
        everywhere: whether to look at all of the view.

    Returns:
        New places, and squared distances.
    """
    slices = jnp.moveaxis(voxels, (axis + 1, 0), (0, -1))
    _, valid, basis, features, similar = exemplar
    columns = valid.shape[1]
    cell = _number_cells(valid.shape)
    cells = -(-valid.shape[0] // _CELL) * -(-columns // _CELL)
    usual = jnp.zeros(cells, features.dtype).at[cell].add(valid.ravel().astype(features.dtype))
    usual = usual * (places.size / jnp.sum(usual))
    length = jnp.sum(features**2, axis=1)
    tie = _TIE * jnp.sum(jnp.var(features, axis=0))

    def visit(used: Array, number: Array) -> tuple[Array, tuple[Array, Array]]:
        old = places[number]
        used = used.at[cell[old]].add(-1.0)
        # Of a place taken twice as often as others, differences count twice.
        burden = jnp.where(valid.ravel(), jnp.maximum(used / jnp.maximum(usual, 1.0), 1.0)[cell], jnp.inf)
        seen = _look_around(slices[number]) @ basis
        if everywhere:
            distance = length[None] - 2 * (seen @ features.T) + jnp.sum(seen**2, axis=1)[:, None]
            options = jnp.argmin(jnp.maximum(distance, tie) * burden[None], axis=1)[:, None]
        else:
            beside = jnp.stack([places[number - 1], old, places[(number + 1) % len(places)]])
            options = _list_options(beside, similar, valid.shape, slices.shape[1:3])
        distance = jnp.sum((features[options] - seen[:, None]) ** 2, axis=-1)
        best = jnp.argmin(jnp.maximum(distance, tie) * burden[options], axis=1)[:, None]
        place, distance = (jnp.take_along_axis(each, best, axis=1)[:, 0] for each in (options, distance))
        used = used.at[cell[place]].add(1.0)
        return used, (place.reshape(old.shape).astype(jnp.int32), distance.reshape(old.shape))

    used = jnp.zeros(cells, features.dtype).at[cell[places]].add(1.0)
    return lax.scan(visit, used, jnp.arange(len(places)))[1]


def _number_cells(shape: tuple[int, ...]) -> Array:
    """In which square of `_CELL` pixels along its sides each place of a picture lies."""
    row, column = jnp.divmod(jnp.arange(shape[0] * shape[1]), shape[1])
    return row // _CELL * -(-shape[1] // _CELL) + column // _CELL


def _look_around(pixels: Array) -> Array:
    """The weighted neighbourhoods of a slice [row, col, channel], on the lattice, [place, tap * channel]."""
    taps = jnp.arange(-_RADIUS, _RADIUS + 1)
    row, column = (jnp.arange(0, side, _SPACING)[:, None] + taps[None] for side in pixels.shape[:2])
    rows, columns, channels = pixels.shape
    seen = pixels[row[:, None, :, None] % rows, column[None, :, None, :] % columns]
    weighted = seen.reshape(-1, len(taps) ** 2, channels) * jnp.asarray(neighbourhood_weights(_RADIUS))[None, :, None]
    return weighted.reshape(len(weighted), -1)


def _list_options(beside: Array, similar: Array, shape: tuple[int, ...], sides: tuple[int, ...]) -> Array:
    """Places that may fit, for each of a lattice of neighbourhoods, [place, option].

    Args:
        beside: places of the slice before, of the same slice, and of that after it, [3, row, col].
        similar: [place, similar].
        shape: of the view.
        sides: of the slice, in voxels.
    """
    _, rows, columns = beside.shape
    (row, above), (column, left) = (_step_aside(*each) for each in zip((rows, columns), sides, strict=True))
    around = similar[beside[1][row[:, None, :, None], column[None, :, None, :]]]  # [row, col, step, step, similar]
    down = around // shape[1] + above[:, None, :, None, None]
    right = around % shape[1] + left[None, :, None, :, None]
    inside = (down >= 0) & (down < shape[0]) & (right >= 0) & (right < shape[1])
    continued = jnp.where(inside, down * shape[1] + right, beside[1][:, :, None, None, None])
    across = jnp.moveaxis(similar[beside[::2]], 0, 2)
    return jnp.concatenate([continued.reshape(rows * columns, -1), across.reshape(rows * columns, -1)], axis=1)


def _step_aside(count: int, side: int) -> tuple[Array, Array]:
    """Along one axis of the lattice: who comes before each, itself, and who after, and how many voxels it is from each
    of these, [count, 3]. Where an odd side ends, the next is nearer."""
    beside = (jnp.arange(count)[:, None] + jnp.arange(-1, 2)[None]) % count
    away = _SPACING * (jnp.arange(count)[:, None] - beside)
    return beside, (away + side // 2) % side - side // 2


@partial(jax.jit, static_argnums=4, donate_argnums=0, compiler_options=SAME_EVERY_TIME)
def _add_places(total: Array, places: Array, distance: Array, exemplar: _Exemplar, axis: int) -> Array:
    """Add what places say of the voxels around them, and how much it counts, to [channel + 1, z, y, x]."""
    pixels, valid, _, features, _ = exemplar
    slices = jnp.moveaxis(total, (axis + 1, 0), (0, -1))
    taps = jnp.arange(-_RADIUS, _RADIUS + 1)
    rows, columns = valid.shape
    shape = slices.shape[1:3]
    row, column = ((jnp.arange(0, side, _SPACING)[:, None] + taps[None]) % side for side in shape)
    near = (jnp.asarray(neighbourhood_weights(_RADIUS)) ** 2).reshape(len(taps), -1)
    spread = jnp.maximum(jnp.sum(jnp.var(features, axis=0)), jnp.finfo(features.dtype).tiny)
    # The weights that make the sum of the power least: iteratively reweighted least squares.
    counts = (distance / spread + _LEAST) ** (_ROBUST / 2 - 1)

    def add(each: tuple[Array, Array, Array]) -> Array:
        before, place, count = each
        down = jnp.clip((place // columns)[..., None] + taps[None, None], 0, rows - 1)
        right = jnp.clip((place % columns)[..., None] + taps[None, None], 0, columns - 1)
        said = pixels[down[..., :, None], right[..., None, :]]  # [row, col, tap, tap, channel]
        weight = (count[..., None, None] * near[None, None])[..., None]
        parts = jnp.concatenate([said * weight, weight], axis=-1)
        return before.at[row[:, None, :, None], column[None, :, None, :]].add(parts)

    return jnp.moveaxis(lax.map(add, (slices, places, counts)), (0, -1), (axis + 1, 0))
