"""An exemplar as multi-resolution synthesis looks at it: level by level, each place by its neighbourhood in few
numbers, and which other places look like it.

Neighbourhoods are projected to their principal components, as S. Lefebvre and H. Hoppe ("Parallel controllable texture
synthesis", SIGGRAPH 2005) do; which places look alike is what k-coherence search goes by (X. Tong et al., "Synthesis of
bidirectional texture functions on arbitrary surfaces", SIGGRAPH 2002).
"""

import dataclasses
from collections.abc import Iterator
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array, lax
from scipy.ndimage import distance_transform_edt, map_coordinates

from jaxtex.core.compiling import SAME_EVERY_TIME

_DIMENSIONS = 24  # of 147 at radius 3: hardly anything is lost
_SPREAD = 0.5  # of the radius: standard deviation of the weight of a neighbourhood's pixels
_SIMILAR = 6  # places kept for each
_BATCH = 1 << 22  # floats at a time
_LARGE_BATCH = 1 << 25
_CANDIDATES = 1 << 12  # places that all others are compared with, at most

Floats = npt.NDArray[np.float32]
Bools = npt.NDArray[np.bool_]


@dataclasses.dataclass(frozen=True)
class ExemplarLevel:
    """An exemplar at one resolution.

    Attributes:
        pixels: [row, col, channel].
        valid: places that may be copied from, as their neighbourhoods are whole, [row, col].
        nearest_valid: of each place, as row * columns + column, [row * col].
        basis: of neighbourhoods, [tap * channel, component]; pixels are weighted before by `neighbourhood_weights`.
        features: of all places, [row * col, component].
        similar: for each place itself and those that look most like it, as row * columns + column,
            [row * col, 1 + similar].
        frames: what neighbourhoods are seen in, [row, col, 2, 2]: by how many pixels a step along a neighbourhood's
            rows and one along its columns lead down and to the right; None where both are the picture's.
    """

    pixels: Floats
    valid: Bools
    nearest_valid: npt.NDArray[np.int32]
    basis: Array
    features: Array
    similar: Array
    frames: Floats | None = None


def analyse_levels(
    pixels: Floats,
    usable: Bools,
    *,
    radius: int,
    coarsest: int,
    similar: int = _SIMILAR,
    frames: Floats | None = None,
) -> list[ExemplarLevel]:
    """Look at an exemplar from fine to coarse.

    Args:
        pixels: [row, col, channel].
        usable: where the exemplar is known, [row, col].
        radius: of neighbourhoods.
        coarsest: levels are added as long as the shorter side of the next has so many pixels, and some of them are
            valid.
        similar: how many places that look alike are kept for each.
        frames: what neighbourhoods are seen in (see `ExemplarLevel`); the picture's by default.

    Raises:
        ValueError: no neighbourhood is whole.
    """
    if usable.any():  # what is not known is as what is near, so that it does not tell which places look alike
        pixels = pixels[tuple(distance_transform_edt(~usable, return_distances=False, return_indices=True))]
    pictures, masks, turns = [pixels], [usable], [frames]
    while min(pictures[-1].shape[:2]) >= 2 * coarsest and _valid_places(halve_mask(masks[-1]), radius).any():
        pictures.append(halve(pictures[-1], masks[-1]))
        masks.append(halve_mask(masks[-1]))
        turns.append(halve_frames(turns[-1]))
    levels: list[ExemplarLevel] = []
    for picture, mask, turn in zip(reversed(pictures), reversed(masks), reversed(turns), strict=True):
        valid = _valid_places(mask, radius) & _reach_within(turn, radius, mask.shape)
        if not valid.any():
            raise ValueError(f"no neighbourhood of {2 * radius + 1} x {2 * radius + 1} pixels may be copied from")
        basis, features = _project(picture, valid, radius, turn)
        alike = _find_similar(features, valid, levels[-1] if levels else None, similar)
        nearest = distance_transform_edt(~valid, return_distances=False, return_indices=True)
        nearest_valid = np.ravel_multi_index(tuple(nearest), valid.shape).ravel().astype(np.int32)
        levels.append(ExemplarLevel(picture, valid, nearest_valid, basis, features, alike, turn))
    return levels[::-1]


def neighbourhood_weights(radius: int) -> Floats:
    """The square root of the weight of each pixel of a neighbourhood, [tap]: Gaussian, and 1 in sum before that."""
    steps = np.arange(-radius, radius + 1) / (_SPREAD * radius)
    weights = np.exp(-0.5 * (steps[:, None] ** 2 + steps[None, :] ** 2))
    return np.sqrt(weights / weights.sum()).ravel().astype(np.float32)


def look_around(picture: Floats, radius: int, places: npt.NDArray[np.integer] | None = None) -> Floats:
    """The neighbourhoods of all pixels, or of those at some places (row * columns + column): [place, tap, channel].
    Beyond a border is what is at it."""
    padded = np.pad(picture, [(radius, radius), (radius, radius), (0, 0)], mode="edge")
    side = 2 * radius + 1
    windows = np.lib.stride_tricks.sliding_window_view(padded, (side, side), axis=(0, 1))
    rows, columns, channels = picture.shape
    row, column = np.divmod(np.arange(rows * columns) if places is None else places, columns)
    return np.moveaxis(windows[row, column], 1, -1).reshape(len(row), side * side, channels)


def neighbourhood_taps(radius: int) -> Floats:
    """The (row, col) steps from a neighbourhood's middle to its pixels, [tap, 2], in scanline order."""
    return np.moveaxis(np.indices((2 * radius + 1, 2 * radius + 1)), 0, -1).reshape(-1, 2).astype(np.float32) - radius


def _look_along(picture: Floats, radius: int, places: npt.NDArray[np.integer], frames: Floats) -> Floats:
    """As `look_around`, but neighbourhoods are seen in frames: bilinear between pixels."""
    place = np.stack(np.divmod(places, picture.shape[1]), axis=1)
    at = place[:, None] + np.einsum("pij,tj->pti", frames.reshape(-1, 2, 2)[places], neighbourhood_taps(radius))
    planes = [
        map_coordinates(plane, np.moveaxis(at, -1, 0), order=1, mode="nearest") for plane in np.moveaxis(picture, -1, 0)
    ]
    return np.stack(planes, axis=-1)


def choose_candidates(valid: Bools) -> npt.NDArray[np.intp]:
    """Valid places, row * columns + column: all of them, or of very many some that are evenly spread."""
    places = np.flatnonzero(valid)
    count = min(len(places), _CANDIDATES)
    return places[np.arange(count) * len(places) // max(count, 1)]


def halve(picture: Floats, known: Bools) -> Floats:
    """A picture at half the resolution: filtered by (1 3 3 1) / 8 along both axes, of known pixels alone.

    Sides are rounded up. Pixel i of the result is the mean around pixels 2i and 2i + 1.
    """
    weights = known.astype(np.float32)[..., None]
    total, weight = _filter(picture * weights), _filter(weights)
    return np.where(weight > 0, total / np.maximum(weight, 1e-6), 0).astype(np.float32)


def halve_mask(mask: Bools) -> Bools:
    """Where all pixels that a pixel of the half resolution stands for are in a mask."""
    whole = np.pad(mask, [(0, side % 2) for side in mask.shape], mode="edge")
    return whole[::2, ::2] & whole[1::2, ::2] & whole[::2, 1::2] & whole[1::2, 1::2]


def halve_frames(frames: Floats | None) -> Floats | None:
    """Frames at half the resolution: the same steps in pixels, each of them twice as large."""
    if frames is None:
        return None
    flat = frames.reshape(*frames.shape[:2], 4)
    return halve(flat, np.ones(flat.shape[:2], bool)).reshape(-1, -(-flat.shape[1] // 2), 2, 2)


def _reach_within(frames: Floats | None, radius: int, shape: tuple[int, ...]) -> Bools | np.bool_:
    """Where neighbourhoods seen in frames do not reach beyond the picture."""
    if frames is None:
        return np.True_
    reach = np.abs(frames).sum(axis=-1) * radius
    place = np.moveaxis(np.indices(shape), 0, -1)
    return np.all((place >= reach) & (place <= np.array(shape) - 1 - reach), axis=-1)


def _filter(picture: Floats) -> Floats:
    for axis in (0, 1):
        side = picture.shape[axis]
        padding = [(0, 0)] * picture.ndim
        padding[axis] = (1, 1 + side % 2)
        padded = np.moveaxis(np.pad(picture, padding, mode="symmetric"), axis, 0)
        half = -(-side // 2)
        first, second, third, fourth = (padded[start : start + 2 * half - 1 : 2] for start in range(4))
        picture = np.moveaxis(((first + fourth + 3 * (second + third)) / 8).astype(np.float32), 0, axis)
    return picture


def _valid_places(usable: Bools, radius: int) -> Bools:
    """Where the whole neighbourhood can be used."""
    valid = np.zeros_like(usable)
    side = 2 * radius + 1
    if min(usable.shape) >= side:
        windows = np.lib.stride_tricks.sliding_window_view(usable, (side, side))
        valid[radius:-radius, radius:-radius] = windows.all(axis=(2, 3))
    return valid


def _project(picture: Floats, valid: Bools, radius: int, frames: Floats | None) -> tuple[Array, Array]:
    """Principal components of the valid neighbourhoods, and those of all places."""
    weights = neighbourhood_weights(radius)[:, None]
    numbers = len(weights) * picture.shape[2]

    def parts(places: npt.NDArray[np.intp]) -> Iterator[Floats]:
        for part in np.array_split(places, -(-len(places) * numbers // _LARGE_BATCH)):
            seen = look_around(picture, radius, part) if frames is None else _look_along(picture, radius, part, frames)
            yield (seen * weights).reshape(len(part), numbers)

    whole = np.flatnonzero(valid)
    mean = (sum(part.sum(axis=0, dtype=np.float64) for part in parts(whole)) / len(whole)).astype(np.float32)
    covariance = sum((part - mean).T.astype(np.float64) @ (part - mean).astype(np.float64) for part in parts(whole))
    basis = np.linalg.eigh(covariance)[1][:, ::-1][:, :_DIMENSIONS].astype(np.float32)
    features = np.concatenate([part @ basis for part in parts(np.arange(valid.size))])
    return jnp.asarray(basis), jnp.asarray(features)


def _find_similar(features: Array, valid: Bools, coarser: ExemplarLevel | None, count: int) -> Array:
    """Among all places at the coarsest level, if they are not very many; then among those that are below the similar
    ones of the coarser level, and their neighbours."""
    rows, columns = valid.shape
    if coarser is None:
        candidates = choose_candidates(valid)[None]
    else:
        row, column = (each.ravel()[:, None] for each in np.indices(valid.shape, np.int32))
        above = np.asarray(coarser.similar)[(row // 2 * coarser.valid.shape[1] + column // 2)[:, 0]]
        down = 2 * (above // coarser.valid.shape[1]) + row % 2
        right = 2 * (above % coarser.valid.shape[1]) + column % 2
        steps = [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)]
        places = [np.clip(down + y, 0, rows - 1) * columns + np.clip(right + x, 0, columns - 1) for y, x in steps]
        candidates = np.concatenate(places, axis=1)
    return _keep_nearest(features, jnp.asarray(candidates, jnp.int32), jnp.asarray(valid), count)


@partial(jax.jit, static_argnums=3, compiler_options=SAME_EVERY_TIME)
def _keep_nearest(features: Array, candidates: Array, valid: Array, count: int) -> Array:
    """Each place, and those of its candidates that look most like it, from near to far; neither beside one another,
    where places look alike because they overlap, nor twice. Where there are too few, the place itself again."""
    columns = valid.shape[1]

    def beside(places: Array, place: Array) -> Array:
        down, right = places // columns - place // columns, places % columns - place % columns
        return (jnp.abs(down) <= 1) & (jnp.abs(right) <= 1)

    def find(place: Array) -> Array:
        options = candidates[place % len(candidates)]
        distance = jnp.sum((features[options] - features[place][None]) ** 2, axis=-1)

        def pick(state: tuple[Array, Array], _: None) -> tuple[tuple[Array, Array], Array]:
            left, last = state
            left = jnp.where(beside(options, last), jnp.inf, left)
            best = jnp.argmin(left)
            found = jnp.where(jnp.isfinite(left[best]), options[best], place)
            return (left, found), found

        start = jnp.where(valid.ravel()[options], distance, jnp.inf), place
        return jnp.concatenate([place[None], lax.scan(pick, start, length=count)[1]])

    batch = max(1, _BATCH // (candidates.shape[1] * features.shape[1]))
    return lax.map(find, jnp.arange(valid.size, dtype=jnp.int32), batch_size=batch)
