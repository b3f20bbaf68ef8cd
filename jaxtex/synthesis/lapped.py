"""Lapped textures in the plane: irregular patches of an exemplar with soft edges, laid over each other until all is
covered.

E. Praun, A. Finkelstein and H. Hoppe, "Lapped textures", SIGGRAPH 2000. It is the baseline that J.-M. Dischler and
others ("Texture particles", Eurographics 2002) compare with, and how they lay what is behind things.

Departures: patches are splotches of random outline, which suit textures without large things; nobody draws outlines
around these. Of a few places that a patch could be cut out at, the one is taken that differs least from what the patch
is laid on, so that light that changes slowly over the exemplar makes no spots. The plane needs no warping, and no
directions.
"""

from typing import NamedTuple

import jax
import numpy as np
import numpy.typing as npt
from jax import Array
from scipy.ndimage import distance_transform_edt

from jaxtex.synthesis.neighbourhoods import check_picture, check_shape

_SHARE = 0.25  # of the exemplar's shorter side: a patch's radius, unless told
_DISCS = 3.0  # radii of the largest usable disc: likewise, at most
_FEATHER = 0.4  # of a patch's radius, at most: how far its edge fades
_WAVES = np.arange(2, 7)  # around a patch's outline
_ROUGH = 0.35  # how much the outline's radius varies at the longest wave, of the radius
_RANGE = 0.4, 1.6  # of the radius: the least and the most that an outline keeps from the middle
_COVERED = 0.5  # of a pixel: what is covered less gets a patch of its own
_DRAWN = 5  # places for each patch
_STRIDE = 2  # pixels between those that patches are compared at
_ROUND = 64  # patches between two looks at what is not covered yet

Floats = npt.NDArray[np.float32]


class _Exemplar(NamedTuple):
    """What patches are cut out of; `inside` is how far each pixel is from what is not usable, `middles` [middle, 2] are
    where a patch may have its middle, and edges fade over `feather` pixels."""

    pixels: Floats
    inside: Floats
    middles: npt.NDArray[np.intp]
    feather: float


def lap_patches(
    pixels: npt.ArrayLike,
    shape: tuple[int, int],
    *,
    key: Array,
    radius: float | None = None,
    usable: npt.ArrayLike | None = None,
) -> Floats:
    """Lay patches of an exemplar at random until all is covered. The texture repeats without a seam.

    Args:
        pixels: the exemplar, floats [row, col, channel], in the encoding in which edges are to fade.
        shape: (rows, columns) of the texture, any.
        key: random key; another key, other patches.
        radius: of a patch, in pixels, above 0. As it is not said, a quarter of the exemplar's shorter side, or three
            times that of the largest disc that is usable, if that is less.
        usable: where patches may be cut out, bool [row, col]; everywhere by default. They fade where that ends.

    Returns:
        Colours, [*shape, channel].

    Raises:
        ValueError: arrays of another form, NaN or infinite values, no usable pixel, a radius below 2.

    Examples:
        >>> grain = np.random.default_rng(0).random((40, 40, 3))
        >>> lap_patches(grain, (50, 70), key=jax.random.key(0)).shape
        (50, 70, 3)
    """
    exemplar = check_picture(pixels, "exemplar")
    rows, columns = check_shape(shape)
    if radius is not None and not (np.isfinite(radius) and radius >= 2):
        raise ValueError(f"radius: {radius} is too small; give 2 pixels or more")
    allowed = np.ones(exemplar.shape[:2], bool) if usable is None else np.asarray(usable, bool)
    if allowed.shape != exemplar.shape[:2] or not allowed.any():
        raise ValueError(f"usable of shape {allowed.shape}: give {exemplar.shape[:2]}, with some pixels that are")
    rng = np.random.default_rng(np.asarray(jax.random.key_data(key)).ravel())
    inside = distance_transform_edt(np.pad(allowed, 1))[1:-1, 1:-1].astype(np.float32)
    deepest = float(inside.max())
    radius = max(2.0, min(_SHARE * min(exemplar.shape[:2]), _DISCS * deepest)) if radius is None else radius
    feather = max(1.0, min(_FEATHER * radius, 0.5 * deepest))
    # A patch's middle must not fade, or it would leave uncovered what it is laid on.
    source = _Exemplar(exemplar, inside, np.argwhere(inside >= min(feather, deepest)), feather)
    drawn, covered = np.zeros((rows, columns, exemplar.shape[2]), np.float32), np.zeros((rows, columns), np.float32)
    while len(bare := np.flatnonzero(covered < _COVERED)):
        for place in rng.choice(bare, min(_ROUND, len(bare)), replace=False):
            row, column = divmod(int(place), columns)
            if covered[row, column] < _COVERED:
                _lay_patch(drawn, covered, (row, column), source, _draw_edge(radius, rng), rng)
    return drawn / covered[..., None]


def _draw_edge(radius: float, rng: np.random.Generator) -> Floats:
    """How far each pixel around a patch's middle is within its outline, [row, col]."""
    angles = np.radians(np.arange(-180, 180))
    phases = rng.uniform(0, 2 * np.pi, len(_WAVES))
    weights = rng.normal(size=len(_WAVES)) * _ROUGH * _WAVES[0] / _WAVES
    outline = 1 + weights @ np.cos(_WAVES[:, None] * angles[None] + phases[:, None])
    outline = radius * np.clip(outline, *_RANGE)
    reach = int(np.ceil(outline.max()))
    row, column = np.ogrid[-reach : reach + 1, -reach : reach + 1]
    direction = (np.degrees(np.arctan2(row, column)).astype(int) + 180) % 360
    return (outline[direction] - np.hypot(row, column)).astype(np.float32)


def _lay_patch(
    drawn: Floats,
    covered: Floats,
    place: tuple[int, int],
    source: _Exemplar,
    edge: Floats,
    rng: np.random.Generator,
) -> None:
    """Blend the patch that fits best into colours that are multiplied by how much is covered."""
    # What is wider than the texture would lie over itself.
    reaches = [min(len(edge) // 2, (side - 1) // 2) for side in covered.shape]
    steps = [np.arange(-reach, reach + 1) for reach in reaches]
    edge = edge[np.ix_(*(step + len(edge) // 2 for step in steps))]
    there = np.ix_(*((at + step) % side for at, step, side in zip(place, steps, covered.shape, strict=True)))
    beneath, known = drawn[there], covered[there]
    drawn_middles = source.middles[rng.integers(len(source.middles), size=_DRAWN if known.any() else 1)]
    thin = slice(None, None, _STRIDE)
    misfits = [
        _misfit(
            *_cut_patch(source, middle, [step[thin] for step in steps], edge[thin, thin]),
            beneath[thin, thin],
            known[thin, thin],
        )
        for middle in drawn_middles
    ]
    cover, colours = _cut_patch(source, drawn_middles[np.argmin(misfits)], steps, edge)
    drawn[there] += cover[..., None] * (colours - beneath)
    covered[there] += cover * (1 - known)


def _cut_patch(
    source: _Exemplar, middle: npt.NDArray[np.intp], steps: list[npt.NDArray[np.intp]], edge: Floats
) -> tuple[Floats, Floats]:
    """How much a patch covers, and its colours, at some steps from its middle."""
    sides = source.inside.shape
    row, column = (centre + step for centre, step in zip(middle, steps, strict=True))
    beyond = [(place < 0) | (place >= side) for place, side in zip((row, column), sides, strict=True)]
    at = np.ix_(row % sides[0], column % sides[1])
    inside = np.where(beyond[0][:, None] | beyond[1], np.float32(0), source.inside[at])
    fade = np.asarray(np.clip(np.minimum(edge, inside) / source.feather, 0, 1), np.float32)
    return fade * fade * (3 - 2 * fade), source.pixels[at]


def _misfit(cover: Floats, colours: Floats, beneath: Floats, known: Floats) -> float:
    """How much a patch differs from what it is laid on. Larger ones are preferred: they make fewer edges."""
    apart = np.square(known[..., None] * colours - beneath).sum(axis=2)
    weight = cover * known
    return float((weight * apart).sum() / max(float(weight.sum()), 1e-6) / max(float(cover.sum()), 1e-6))
