"""The ground that things lie on, made of what is seen of it between them.

J.-M. Dischler, K. Maritaud, B. Lévy and D. Ghazanfarpour, "Texture particles" (Eurographics 2002), section 2.2, lay it
of overlapping patches, as in lapped textures (`fill="patches"`). Departures: where most of the ground is clear of
things it is synthesised by k-coherent search, and of sand, plaster or fog, noise can be made. Where things leave only
dark gaps between them there is no ground: what is seen there is more of them, further down. Light that falls on the
ground is evened first.
"""

from typing import Literal, get_args

import jax
import numpy as np
import numpy.typing as npt
from jax import Array
from scipy import ndimage

from jaxtex.core.pyramids import most_scales
from jaxtex.particles.things import Decomposition
from jaxtex.synthesis.coherence import synthesise_coherence
from jaxtex.synthesis.heeger_bergen import analyse_texture, synthesise_texture
from jaxtex.synthesis.lapped import lap_patches
from jaxtex.synthesis.neighbourhoods import check_picture
from jaxtex.synthesis.sources import copy_sources

Fill = Literal["coherence", "patches", "noise", "heap"]

_RADIUS = 3  # pixels: of what k-coherent search compares
_SLOW = 0.25  # of the picture's longer side: what light is averaged over, thrice
_CLEAR = 2  # pixels around things that are not taken for ground, as they have blurred edges
_BLEND = 4.0  # pixels over which what is seen of the ground goes over into what is laid on things
_OPEN = 0.5  # of the ground's pixels have surroundings that are clear of things, where most of it can be searched
_TIGHT = 0.3  # of them: where fewer have, there are only gaps
_KEPT = 0.5  # of those places: how many must be left by a wider margin
_MOST_CLEAR = 32  # pixels: the widest margin
_SETTLED = 1.15  # times as much as far from things may colours differ from the ground's

Floats = npt.NDArray[np.float32]
Mask = npt.NDArray[np.bool_]


def make_ground(
    pixels: npt.ArrayLike,
    decomposition: Decomposition,
    size: tuple[int, int],
    *,
    key: Array,
    fill: Fill | None = None,
    scale: float = 1.0,
) -> Floats:
    """The ground that things lie on, of any size; it repeats without a seam.

    All but a heap are learnt from pixels that keep clear of things: 2 pixels, or more, up to where colours no longer
    differ from what they are far from things, as long as half of the places remain that k-coherent search could copy.

    Args:
        pixels: the picture, floats [row, col, channel] in an encoding whose steps look even, as sRGB's.
        decomposition: the picture taken apart.
        size: width and height.
        key: random key; another key, another piece of the ground.
        fill: "coherence", k-coherent search, which keeps what the ground has in it; "patches", lapped ones; "noise",
            for grounds of fine grain; "heap", more things further down: the picture anew, in the ground's mean colour.
            Unless said, it is as of how many of the ground's pixels the surroundings (7 x 7) are clear of things:
            coherence from a half, a heap below 3 in 10 if the ground is darker than things, otherwise patches. Where
            things leave no ground at all, it is always a heap.
        scale: how many times as large as in the picture its grain is, for compositions that are drawn larger.

    Raises:
        ValueError: a picture of another size than the decomposition's, or one of fewer than 7 x 7 pixels for all fills
            but patches; no such fill, a scale that is not above 0.

    Examples:
        >>> from jaxtex.particles.things import describe_particles
        >>> labels = np.zeros((40, 40), int)
        >>> labels[10:14, 20:26] = 1
        >>> grain = np.where(labels[..., None] > 0, 0.9, 0.3)
        >>> ground = make_ground(grain, describe_particles(labels, [0]), (50, 30), key=jax.random.key(0))
        >>> ground.shape, round(float(ground.max()), 3)
        ((30, 50, 1), 0.3)
    """
    picture = check_against(pixels, decomposition)
    if fill is not None and fill not in get_args(Fill):
        raise ValueError(f"fill: {fill!r} is none; give one of {', '.join(get_args(Fill))}")
    if not (np.isfinite(scale) and scale > 0):
        raise ValueError(f"scale is {scale}; give a number above 0")
    rows, columns = (max(1, round(side / scale)) for side in (size[1], size[0]))
    return _magnify(_lay(picture, decomposition, fill, (rows, columns), key), (size[1], size[0]))


def _lay(
    picture: Floats, decomposition: Decomposition, fill: Fill | None, shape: tuple[int, int], key: Array
) -> Floats:
    ground = decomposition.labels == 0
    if not ground.any():
        return _heap_up(picture, ~ground, shape, key)
    away = ndimage.distance_transform_edt(ground).astype(np.float32)
    fill = choose_fill(picture, decomposition) if fill is None else fill
    if fill == "heap":
        return _heap_up(picture, ground, shape, key)
    picture = even_ground(picture, decomposition)
    usable = _keep_clear(picture, away)
    if fill == "patches":
        return lap_patches(picture, shape, key=key, usable=usable)
    if fill == "noise":
        exemplar = _search(picture, usable, picture.shape[:2], jax.random.fold_in(key, 1))
        scales = max(0, min(4, most_scales(exemplar.shape[:2]), most_scales(shape)))
        statistics = analyse_texture(exemplar[None], scales=scales, periodic=True)
        return np.asarray(synthesise_texture(statistics, shape, key=key), np.float32)
    return _search(picture, usable, shape, key)


def _magnify(ground: Floats, shape: tuple[int, int]) -> Floats:
    """The ground at another resolution; it still repeats."""
    if ground.shape[:2] == shape:
        return ground
    ratio = [old / new for old, new in zip(ground.shape, shape, strict=False)]
    blurred = ndimage.gaussian_filter(ground, [max(0.0, 0.5 * (each - 1)) for each in (*ratio, 1.0)], mode="wrap")
    places = np.meshgrid(
        *((np.arange(new) + 0.5) * each - 0.5 for new, each in zip(shape, ratio, strict=True)), indexing="ij"
    )
    planes = [
        ndimage.map_coordinates(plane, places, order=1, mode="grid-wrap") for plane in np.moveaxis(blurred, -1, 0)
    ]
    return np.stack(planes, axis=-1)


def choose_fill(picture: Floats, decomposition: Decomposition) -> Fill:
    """How the ground is made unless told: see `make_ground`.

    Examples:
        >>> from jaxtex.particles.things import describe_particles
        >>> row, column = np.indices((40, 40))
        >>> tight = np.where((row % 8 > 1) & (column % 8 > 1), 1 + row // 8 * 5 + column // 8, 0)
        >>> things = describe_particles(tight, [0] * 25)
        >>> dark_gaps = np.where(tight[..., None] > 0, 0.8, 0.2)
        >>> choose_fill(dark_gaps, things), choose_fill(1 - dark_gaps, things)
        ('heap', 'patches')
    """
    ground = decomposition.labels == 0
    open_share = _whole(ndimage.distance_transform_edt(ground) > _CLEAR).sum() / ground.sum()
    if open_share < _TIGHT and picture[ground].mean() < picture[~ground].mean():
        return "heap"
    return "coherence" if open_share >= _OPEN else "patches"


def check_against(pixels: npt.ArrayLike, decomposition: Decomposition) -> Floats:
    """A picture that is the decomposition's, by its size, as floats.

    Raises:
        ValueError: it is not.
    """
    picture = check_picture(pixels, "picture")
    if picture.shape[:2] != decomposition.labels.shape:
        raise ValueError(f"picture of shape {picture.shape}: give that of the labels, {decomposition.labels.shape}")
    return picture


def even_ground(picture: Floats, decomposition: Decomposition) -> Floats:
    """The picture under the light that falls on its ground on average: what the ground's colours slowly change by is
    taken away, so that pieces from anywhere meet. Colours stay in the picture's range."""
    ground = (decomposition.labels == 0).astype(np.float32)[..., None]
    side = max(1, round(_SLOW * max(picture.shape[:2])))

    def blur(plane: Floats) -> Floats:
        for _ in range(3):
            plane = ndimage.uniform_filter(plane, (side, side, 0), mode="reflect")
        return plane

    share = blur(ground)
    slow = blur(ground * picture) / np.maximum(share, 1e-6)
    mean = (ground * picture).sum(axis=(0, 1)) / max(float(ground.sum()), 1.0)
    evened = picture + np.where(share > 1e-3, mean - slow, 0)
    return np.asarray(np.clip(evened, picture.min(), picture.max()), np.float32)


def _whole(usable: Mask) -> Mask:
    """Places all of whose neighbourhood is usable."""
    side = 2 * _RADIUS + 1
    return ndimage.binary_erosion(usable, np.ones((side, side), bool))


def _keep_clear(picture: Floats, away: Floats) -> Mask:
    """What may be learnt from: ground that is so far from things that its colours have settled, if there is enough."""
    clear = away > _CLEAR
    places = _whole(clear).sum()
    if not places:
        return clear if clear.any() else away > 0
    far = away >= np.median(away[clear])
    apart = np.square(picture - picture[far].mean(axis=0)).sum(axis=2)
    settled = _SETTLED * apart[far].mean()
    steps = np.minimum(away, _MOST_CLEAR).astype(int)[clear]
    count = np.bincount(steps)
    unsettled = np.flatnonzero(np.bincount(steps, apart[clear]) > settled * count)
    margin = unsettled.max() + 1 if len(unsettled) else _CLEAR
    while margin > _CLEAR and _whole(away > margin).sum() < _KEPT * places:
        margin -= 1
    return away > margin


def _search(picture: Floats, usable: Mask, shape: tuple[int, int], key: Array) -> Floats:
    """Of the picture, in which patches of the ground lie over things."""
    patches = lap_patches(picture, picture.shape[:2], key=jax.random.fold_in(key, 0), usable=usable)
    inside = ndimage.distance_transform_edt(usable)[..., None]
    filled = patches + np.clip(inside / _BLEND, 0, 1).astype(np.float32) * (picture - patches)
    sources = synthesise_coherence(filled, shape, key=jax.random.fold_in(key, 1))
    return np.asarray(copy_sources(filled, sources), np.float32)


def _heap_up(picture: Floats, ground: Mask, shape: tuple[int, int], key: Array) -> Floats:
    """The whole picture anew, with what the gaps' mean colour is in place of its own."""
    heap = copy_sources(picture, synthesise_coherence(picture, shape, key=key))
    darker = picture[ground].mean(axis=0) / np.maximum(picture.mean(axis=(0, 1)), 1e-3)
    return np.asarray(heap * darker, np.float32)
