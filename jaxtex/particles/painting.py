"""Drawing a composition: the ground, and particles laid over it one after the other, with soft edges.

J.-M. Dischler, K. Maritaud, B. Lévy and D. Ghazanfarpour, "Texture particles" (Eurographics 2002), sections 2.1 and
2.2: particles are cut out a little larger than they are, so that their edges blend.

Departure: the ground is not laid of overlapping patches, as in lapped textures. The picture without its things is
filled in by k-coherent search, and more of that is synthesised likewise (`jaxtex.synthesis.coherence`).
"""

from typing import NamedTuple

import jax
import numpy as np
import numpy.typing as npt
from jax import Array
from scipy import ndimage

from jaxtex.particles.composition import Composition
from jaxtex.particles.sprites import Cut, find_places, transform_cut
from jaxtex.particles.things import Box, Decomposition
from jaxtex.synthesis.coherence import inpaint_coherence, synthesise_coherence
from jaxtex.synthesis.neighbourhoods import check_picture
from jaxtex.synthesis.sources import copy_sources

_SOFT = 2  # pixels beyond a particle's edge until nothing of it is left
_HALF = 0.4999  # of a pixel: a particle covers one that it fills so far, rounding aside
_CLEAR = 2  # pixels around things that are not taken for ground, as they have shadows and blurred edges

Pixels = npt.NDArray[np.float32]


class _Sprite(NamedTuple):
    """A particle cut out: colours, how much they cover, and where in the cut the centre of its box is."""

    pixels: Pixels
    cover: Pixels
    x: float
    y: float


def make_ground(pixels: npt.ArrayLike, decomposition: Decomposition, size: tuple[int, int], *, key: Array) -> Pixels:
    """The ground that things lie on, of any size; it repeats without a seam.

    Where the ground is seen only in gaps that are narrower than what is compared, it gets the colours of what is
    nearest.

    Args:
        pixels: the picture, floats [row, col, channel] in an encoding whose steps look even, as sRGB's.
        decomposition: the picture taken apart.
        size: width and height.
        key: random key; another key, another piece of the ground.

    Raises:
        ValueError: a picture of another size than the decomposition's, or all of whose pixels are things'.

    Examples:
        >>> from jaxtex.particles.things import describe_particles
        >>> labels = np.zeros((40, 40), int)
        >>> labels[10:14, 20:26] = 1
        >>> grain = np.where(labels[..., None] > 0, 0.9, 0.3)
        >>> ground = make_ground(grain, describe_particles(labels, [0]), (50, 30), key=jax.random.key(0))
        >>> ground.shape, round(float(ground.max()), 3)
        ((30, 50, 1), 0.3)
    """
    picture = _check(pixels, decomposition)
    things = decomposition.labels > 0
    if things.all():
        raise ValueError("labels: no pixel is ground; leave some 0")
    hole = ndimage.binary_dilation(things, iterations=_CLEAR)
    hole = things if hole.all() else hole
    filled = picture[tuple(ndimage.distance_transform_edt(hole, return_distances=False, return_indices=True))]
    try:
        filled = copy_sources(filled, inpaint_coherence(filled, hole, key=jax.random.fold_in(key, 0)))
    except ValueError:  # nowhere is there so much ground that a neighbourhood is whole
        filled = ndimage.gaussian_filter(filled, (_SOFT, _SOFT, 0))
    sources = synthesise_coherence(filled, (size[1], size[0]), key=jax.random.fold_in(key, 1))
    return np.asarray(copy_sources(filled, sources), np.float32)


def paint_composition(
    composition: Composition, pixels: npt.ArrayLike, decomposition: Decomposition, ground: npt.ArrayLike
) -> Pixels:
    """Draw a composition.

    Args:
        composition: of the particles of `decomposition`.
        pixels: the picture, floats [row, col, channel].
        decomposition: the picture taken apart.
        ground: what particles are laid on, [row, col, channel], of the composition's size.

    Returns:
        Colours as `pixels` has them, [row, col, channel].

    Raises:
        ValueError: pictures of another size than the decomposition's and the composition's.
    """
    picture, drawn = _check(pixels, decomposition), check_picture(ground, "ground").copy()
    if drawn.shape != (composition.height, composition.width, picture.shape[2]):
        raise ValueError(
            f"ground of shape {drawn.shape}: give the composition's, "
            f"{(composition.height, composition.width, picture.shape[2])}"
        )
    around = ndimage.find_objects(decomposition.labels)
    cut: dict[int, _Sprite] = {}
    for number, x, y, angle, scale in zip(
        composition.particles, composition.x, composition.y, composition.angles, composition.scales, strict=True
    ):
        sprite = cut.get(number)
        if sprite is None:
            mask = decomposition.labels == number + 1
            sprite = cut[number] = _cut_out(picture, mask, around[number], decomposition.particles[number].box)
        _lay(drawn, _transform(sprite, angle, scale), x, y, composition.periodic)
    return drawn


def label_composition(composition: Composition, decomposition: Decomposition) -> npt.NDArray[np.int32]:
    """Which placed particle is seen where, with hard edges: those of its label, turned and scaled.

    Args:
        composition: of the particles of `decomposition`.
        decomposition: the picture taken apart.

    Returns:
        Of the particle that covers a pixel, the index in the composition, from 1; 0 is the ground. Int32 [row, col].

    Examples:
        >>> from jaxtex.particles.composition import Composition, identify_exemplar
        >>> from jaxtex.particles.things import describe_particles
        >>> labels = np.zeros((8, 12), int)
        >>> labels[2:5, 2:10] = 1
        >>> things = describe_particles(labels, [0])
        >>> exemplar = identify_exemplar(things)
        >>> one = Composition(6, 5, True, exemplar, [0], [0], [0.0], [2.0], [np.pi / 2], [0.5])
        >>> label_composition(one, things)
        array([[1, 0, 0, 0, 0, 1],
               [1, 0, 0, 0, 0, 1],
               [1, 0, 0, 0, 0, 1],
               [1, 0, 0, 0, 0, 1],
               [0, 0, 0, 0, 0, 0]], dtype=int32)
    """
    labels = np.zeros((composition.height, composition.width), np.int32)
    around = ndimage.find_objects(decomposition.labels)
    cut: dict[int, Cut] = {}
    for index, (number, x, y, angle, scale) in enumerate(
        zip(composition.particles, composition.x, composition.y, composition.angles, composition.scales, strict=True), 1
    ):
        if number not in cut:
            rows, columns = around[number]
            mask, box = decomposition.labels[rows, columns] == number + 1, decomposition.particles[number].box
            cut[number] = Cut(mask[..., None].astype(np.float32), box.x - columns.start, box.y - rows.start)
        turned = transform_cut(cut[number], angle, scale)
        part, places = find_places(turned, x, y, (composition.width, composition.height), composition.periodic)
        seen = turned.planes[part][..., 0] > _HALF
        labels[places] = np.where(seen, index, labels[places])
    return labels


def _check(pixels: npt.ArrayLike, decomposition: Decomposition) -> Pixels:
    picture = check_picture(pixels, "picture")
    if picture.shape[:2] != decomposition.labels.shape:
        raise ValueError(f"picture of shape {picture.shape}: give that of the labels, {decomposition.labels.shape}")
    return picture


def _cut_out(picture: Pixels, mask: npt.NDArray[np.bool_], around: tuple[slice, slice], box: Box) -> _Sprite:
    rows, columns = (
        slice(max(0, each.start - _SOFT), min(side, each.stop + _SOFT))
        for each, side in zip(around, mask.shape, strict=True)
    )
    away = ndimage.distance_transform_edt(~mask[rows, columns])
    cover = np.clip(1 - away / (_SOFT + 1), 0, 1).astype(np.float32)
    return _Sprite(picture[rows, columns], cover, box.x - columns.start, box.y - rows.start)


def _transform(sprite: _Sprite, angle: float, scale: float) -> _Sprite:
    """The sprite turned about the centre of its box, clockwise as seen, and made larger."""
    if angle == 0 and scale == 1:
        return sprite
    height, width = sprite.cover.shape
    forward = scale * np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])  # of (row, col)
    corners = np.array([[y - sprite.y, x - sprite.x] for y in (0, height) for x in (0, width)]) @ forward.T
    low, high = np.floor(corners.min(axis=0)), np.ceil(corners.max(axis=0))
    backward = np.linalg.inv(forward)
    offset = backward @ (low + 0.5) + np.array([sprite.y, sprite.x]) - 0.5
    shape = tuple((high - low).astype(int))
    # Larger steps than a pixel would leave out what lies between.
    blur = max(0.0, 0.5 * (1 / scale - 1))

    def sample(plane: Pixels, mode: str) -> Pixels:
        smooth = ndimage.gaussian_filter(plane, blur, mode=mode) if blur else plane
        return ndimage.affine_transform(smooth, backward, offset, shape, order=1, mode=mode)

    colours = np.stack([sample(plane, "nearest") for plane in np.moveaxis(sprite.pixels, -1, 0)], axis=-1)
    return _Sprite(colours, sample(sprite.cover, "constant"), -low[1], -low[0])


def _lay(drawn: Pixels, sprite: _Sprite, x: float, y: float, periodic: bool) -> None:
    """Blend a sprite into a picture, its centre at (x, y) to the nearest pixel."""
    height, width = sprite.cover.shape
    row = round(y - sprite.y) + np.arange(height)
    column = round(x - sprite.x) + np.arange(width)
    if periodic:
        inside = np.ones(height, bool), np.ones(width, bool)
    else:
        inside = (row >= 0) & (row < drawn.shape[0]), (column >= 0) & (column < drawn.shape[1])
    rows, columns = row[inside[0]] % drawn.shape[0], column[inside[1]] % drawn.shape[1]
    cover = sprite.cover[np.ix_(*inside)][..., None]
    place = np.ix_(rows, columns)
    drawn[place] += cover * (sprite.pixels[np.ix_(*inside)] - drawn[place])
