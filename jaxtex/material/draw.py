"""Tiles that no photograph shows, drawn so that they go with those it shows."""

import math
from typing import TYPE_CHECKING, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
from jaxtex.material.patterns import class_of

if TYPE_CHECKING:
    from jaxtex.material.appearance import Appearance

STRONGEST = 0.7
"""The strongest correlation between neighbours that can be drawn, either way."""

_JITTER = 0.2  # how far drawn colours stray from the seen ones, in standard deviations of all seen ones
_EDGE = 1 / 512  # black and white as drawn colours see them: half a step of 8 bits inside
_SHORT = 256  # entries that every table has room for


class DrawnTiles(NamedTuple):
    """Attributes:
    colour: linear light, [..., 3].
    like: which of the tiles seen each is like, itself where it was seen: a number in the order of `Appearance.tiles`.
    """

    colour: npt.NDArray[np.float32]
    like: npt.NDArray[np.int32]


def draw_tiles(appearance: "Appearance", course: npt.ArrayLike, tile: npt.ArrayLike, *, key: Array) -> DrawnTiles:
    """The colours of tiles: their own where they were seen, drawn where not.

    A drawn colour depends on the key and the tile alone, whatever else is asked for. It is one of the colours seen on
    tiles of its class, strayed from by a fifth of their standard deviation and shrunk so that mean and covariance stay
    those of the class (the smoothed bootstrap; B. Silverman, Density Estimation, 1986, section 6.4.1). This happens in
    the logit of sRGB values, so that no colour leaves the range; a set of few odd colours stays such a set.

    Which of the colours it is follows a Gaussian field over the tiles, correlated between neighbours as the
    appearance has it, by the colours' rank along their first principal axis (a Gaussian copula; R. Nelsen, An
    Introduction to Copulas, 2006). Where courses change steadily over the photograph, courses above and below it have
    the colours of its first and last.

    Args:
        course, tile: integer numbers of the tiles, of one shape.
        key: random key.
    """
    course, tile = np.broadcast_arrays(np.asarray(course, dtype=np.int64), np.asarray(tile, dtype=np.int64))
    label, row, place = (pad_table(part.ravel()) for part in (class_of(appearance.pattern, course, tile), course, tile))
    weights = np.array([_weights(correlation) for correlation in appearance.neighbours], np.float32)
    own = np.array(list(appearance.tiles))
    palettes = _palettes(appearance)
    change = pad_table(np.clip(course.ravel(), own[:, 0].min(), own[:, 0].max()))
    trend = np.array(appearance.trend, np.float32)
    colour, like = _draw_all(palettes, weights, trend, label, row, place, change, key)
    colour, like = np.asarray(colour)[: course.size], np.asarray(like)[: course.size]
    numbers, order = np.unique(_one_number(own[:, 0], own[:, 1]), return_index=True)
    asked = _one_number(course.ravel(), tile.ravel())
    found = np.minimum(np.searchsorted(numbers, asked), len(numbers) - 1)
    was_seen = numbers[found] == asked
    seen = np.array(list(appearance.tiles.values()), dtype=np.float32)[order[found]]
    return DrawnTiles(
        np.where(was_seen[:, None], seen, colour).reshape(*course.shape, 3),
        np.where(was_seen, order[found], like).astype(np.int32).reshape(course.shape),
    )


def pad_table(table: npt.NDArray) -> npt.NDArray:
    """A table with zeros after it, up to a power of four: tables of about one length share compiled code, short ones
    all of it."""
    length = max(_SHORT, 4 ** math.ceil(math.log(len(table), 4)))
    return np.pad(table, [(0, length - len(table))] + [(0, 0)] * (table.ndim - 1))


def to_logit(linear: npt.NDArray[np.floating]) -> npt.NDArray[np.floating]:
    """The logit of colours' sRGB values, in which drawn colours are mixed."""
    encoded = np.clip(linear_to_srgb(np.clip(linear, 0, 1)), _EDGE, 1 - _EDGE)
    return np.log(encoded / (1 - encoded))


def principal_axes(values: npt.NDArray[np.floating]) -> tuple[npt.NDArray[np.floating], npt.NDArray[np.floating]]:
    """Standard deviations along the principal axes of values [n, channel], ascending, and the axes as columns."""
    scale, axes = np.linalg.eigh(np.cov(values.T, bias=True))
    return np.sqrt(np.clip(scale, 0, None)), axes


class _Palettes(NamedTuple):
    """For each class: logits of the colours seen (padded), in the order of their first principal axis; which tiles they
    are; the courses they are in; how many members they have; a root A of their covariance A^T A."""

    logits: npt.NDArray[np.float32]
    place: npt.NDArray[np.int32]
    course: npt.NDArray[np.int32]
    members: npt.NDArray[np.int32]
    root: npt.NDArray[np.float32]


def _palettes(appearance: "Appearance") -> _Palettes:
    places = np.array(list(appearance.tiles))
    seen = to_logit(np.array(list(appearance.tiles.values())))
    label = class_of(appearance.pattern, *places.T)
    groups, roots = [], []
    for each in range(1 + max(map(max, appearance.pattern))):
        members = np.flatnonzero(label == each) if (label == each).any() else np.arange(len(seen))
        level = seen[members] - np.array(appearance.trend) * (places[members, 0] - places[members, 0].mean())[:, None]
        spread, axes = principal_axes(level)
        # Colours of fewer dimensions (greys) stay there.
        roots.append(spread[:, None] * axes.T)
        groups.append(members[np.argsort(level @ axes[:, -1], kind="stable")])
    longest = max(map(len, groups))
    padded = np.stack([pad_table(np.pad(group, (0, longest - len(group)))) for group in groups])
    counted = np.arange(padded.shape[1]) < np.array([[len(group)] for group in groups])
    return _Palettes(
        logits=np.where(counted[..., None], seen[padded], 0.0).astype(np.float32),
        place=padded.astype(np.int32),
        course=places[padded, 0].astype(np.int32),
        members=np.array([len(group) for group in groups], np.int32),
        root=np.stack(roots).astype(np.float32),
    )


def _weights(correlation: float) -> tuple[float, float, float]:
    """Of a moving average over three independent numbers: unit variance, neighbours correlated as told."""
    r = float(np.clip(correlation, -STRONGEST, STRONGEST))
    side = (1.0 - math.sqrt(1.0 - 2.0 * r * r)) / (2.0 * r) if abs(r) > 1e-6 else 0.0
    norm = math.sqrt(1.0 + 2.0 * side * side)
    return side / norm, 1.0 / norm, side / norm


def _one_number(course: npt.NDArray[np.int64], tile: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    return course * 2**32 + tile


@jax.jit
def _draw_all(
    palettes: _Palettes,
    weights: Array,
    trend: Array,
    label: Array,
    course: Array,
    tile: Array,
    shown: Array,
    key: Array,
) -> tuple[Array, Array]:
    """Colours of all tiles, linear light, [tile, 3], and which of those seen they are like [tile]."""
    means = palettes.logits.sum(axis=1) / palettes.members[:, None]
    steps = jnp.arange(-1, 2)

    def level(course: Array, tile: Array) -> Array:
        return jax.random.normal(jax.random.fold_in(jax.random.fold_in(key, course), tile))

    def draw(label: Array, course: Array, tile: Array, shown: Array) -> tuple[Array, Array]:
        around = jax.vmap(lambda down: jax.vmap(lambda along: level(course + down, tile + along))(steps))(steps)
        chance = jax.scipy.special.ndtr(weights[1] @ around @ weights[0])
        pick = jnp.clip((chance * palettes.members[label]).astype(int), 0, palettes.members[label] - 1)
        own_key = jax.random.fold_in(jax.random.fold_in(jax.random.fold_in(key, course), tile), 1)
        mean = means[label]
        strayed = (
            palettes.logits[label, pick] - mean + _JITTER * (jax.random.normal(own_key, (3,)) @ palettes.root[label])
        )
        moved = trend * (shown - palettes.course[label, pick]).astype(trend.dtype)
        logit = mean + strayed / jnp.sqrt(1 + _JITTER**2) + moved
        return srgb_to_linear(jax.nn.sigmoid(logit)), palettes.place[label, pick]

    return jax.vmap(draw)(label, course, tile, shown)
