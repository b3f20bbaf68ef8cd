"""Particles cut out of their picture with what surrounds them: turned, made larger, and where on a plane they lie.

J.-M. Dischler, K. Maritaud, B. Lévy and D. Ghazanfarpour, "Texture particles" (Eurographics 2002), section 2.1:
particles are cut out a little larger than they are, so that their edges blend.

Addition: each has a halo too, the ground around it as far as it is rather its own than another's: rims, shadows, joints
and the dark between things go where their things go.
"""

from math import ceil, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from jaxtex.core.errors import InputError
from jaxtex.particles.things import Decomposition

_SOFT = 2.0  # pixels from a particle: up to there its edge fades, with the colours that the picture has there
_SIZES = 1.0  # of a disc's radius as large as a particle: how far its halo reaches at most
_GAPS = 1.0  # of how wide gaps between things are as a rule: likewise
_LEAST_REACH = 4.0  # pixels
_BEYOND = 2.0  # times as far from its own thing as from another one: where a halo has faded
_BORDER = 3.0  # pixels along the picture's border in which halos fade

_MOST_PIXELS = 1 << 26  # of one particle that is drawn

Floats = npt.NDArray[np.float32]
Window = tuple[slice, slice]
Places = tuple[Any, ...]


class Cut(NamedTuple):
    """A piece of a picture, and where in it the centre of its particle's box is.

    Attributes:
        planes: [row, col, plane].
        x, y: pixels from its upper left corner.
    """

    planes: Floats
    x: float
    y: float


def transform_cut(cut: Cut, angle: float, scale: float) -> Cut:
    """A piece turned about its particle's centre, clockwise as seen, and made larger. Around it all planes are 0.

    Args:
        cut: the piece.
        angle: radians.
        scale: above 0.

    Examples:
        >>> bar = Cut(np.ones((2, 6, 1), np.float32), 3.0, 1.0)
        >>> transform_cut(bar, np.pi / 2, 1.0).planes[..., 0].sum(axis=1).round(3)
        array([0., 2., 2., 2., 2., 2., 2., 0.], dtype=float32)
    """
    if angle == 0 and scale == 1:
        return cut
    height, width = cut.planes.shape[:2]
    forward = scale * np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])  # of (row, col)
    corners = np.array([[y - cut.y, x - cut.x] for y in (0, height) for x in (0, width)]) @ forward.T
    low, high = np.floor(corners.min(axis=0) - 0.5), np.ceil(corners.max(axis=0) + 0.5)
    if np.prod(high - low) > _MOST_PIXELS:
        raise InputError(f"a particle of {width} x {height} pixels is too large to be drawn {scale:g} times as large")
    backward = np.linalg.inv(forward)
    offset = backward @ (low + 0.5) + np.array([cut.y, cut.x]) - 0.5
    planes = np.pad(cut.planes, [(1, 1), (1, 1), (0, 0)])
    if scale < 1:  # larger steps than a pixel would leave out what lies between
        blur = min(0.5 * (1 / scale - 1), max(height, width))
        planes = ndimage.gaussian_filter(planes, (blur, blur, 0), mode="constant")
    row, column = np.arange(high[0] - low[0]), np.arange(high[1] - low[1])
    down = offset[0] + 1 + backward[0, 0] * row[:, None] + backward[0, 1] * column
    right = offset[1] + 1 + backward[1, 0] * row[:, None] + backward[1, 1] * column
    return Cut(_sample(planes, down, right), -low[1], -low[0])


def _sample(planes: Floats, row: npt.NDArray[np.float64], column: npt.NDArray[np.float64]) -> Floats:
    """Planes [row, col, plane] between their pixels, linearly; beyond their borders, what is at these."""
    height, width, count = planes.shape
    row, column = np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)
    top, left = np.minimum(row.astype(int), height - 2), np.minimum(column.astype(int), width - 2)
    flat, first = planes.reshape(-1, count), top * width + left
    down, right = (row - top).astype(np.float32)[..., None], (column - left).astype(np.float32)[..., None]
    above = flat[first] + right * (flat[first + 1] - flat[first])
    below = flat[first + width] + right * (flat[first + width + 1] - flat[first + width])
    return above + down * (below - above)


class Sprite(NamedTuple):
    """A particle cut out.

    Attributes:
        pixels: colours, [row, col, channel].
        cover: how much of what is beneath the particle covers, 0 to 1, [row, col].
        halo: how much its surroundings count, 0 to 1, [row, col]; 1 on the particle itself.
        away: pixels from the particle, [row, col]; of no meaning where there is no halo.
        x, y: the centre of the particle's box, in pixels from the upper left corner.
    """

    pixels: Floats
    cover: Floats
    halo: Floats
    away: Floats
    x: float
    y: float


class SpriteSheet:
    """A picture's particles, each cut out when it is first asked for.

    Halos reach as far as the radius of a disc of the particle's area, or as gaps between things are wide as a rule
    (twice the distance to what is nearest, median of the lines midway between things), whichever is less, and at least
    4 pixels. They are whole up to half of that and no further from their own particle than from any other, and end
    where the other is half as far.

    Args:
        picture: floats [row, col, channel].
        surroundings: the same, as it is to look around particles.
        decomposition: the picture taken apart.
    """

    def __init__(self, picture: Floats, surroundings: Floats, decomposition: Decomposition) -> None:
        self._picture, self._surroundings, self._decomposition = picture, surroundings, decomposition
        self._around = ndimage.find_objects(decomposition.labels)
        self._cut: dict[int, Sprite] = {}
        labels = decomposition.labels
        away, nearest = ndimage.distance_transform_edt(labels == 0, return_indices=True)
        self._away, self._owner = away.astype(np.float32), labels[tuple(nearest)]
        self._gap = _measure_gap(self._away, self._owner)
        row, column = (np.minimum(np.arange(side) + 0.5, np.arange(side)[::-1] + 0.5) for side in labels.shape)
        self._inside = np.clip(np.minimum(row[:, None], column[None]) / _BORDER, 0, 1).astype(np.float32)

    def __getitem__(self, number: int) -> Sprite:
        """The particle with this number in the decomposition, from 0."""
        if number not in self._cut:
            self._cut[number] = self._cut_out(number)
        return self._cut[number]

    def _cut_out(self, number: int) -> Sprite:
        particle, label = self._decomposition.particles[number], number + 1
        reach = max(_LEAST_REACH, min(_SIZES * sqrt(particle.area / pi), _GAPS * self._gap))
        margin = ceil(reach)
        rows, columns = (
            slice(max(0, each.start - margin), min(side, each.stop + margin))
            for each, side in zip(self._around[number], self._away.shape, strict=True)
        )
        labels, owner = self._decomposition.labels[rows, columns], self._owner[rows, columns]
        away = ndimage.distance_transform_edt(labels != label).astype(np.float32)
        free = (labels == 0) | (labels == label)
        cover = free * np.clip(1 - away / _SOFT, 0, 1)
        if not free.all():  # what touches another has no room for an edge beyond itself
            cover[ndimage.binary_dilation(~free)] *= 0.5
        halo = _fade(2 * (1 - away / reach)) * self._inside[rows, columns]
        others = np.maximum(self._away[rows, columns], 1e-3)
        halo *= np.where(owner == label, np.float32(1), free * _fade((_BEYOND - away / others) / (_BEYOND - 1)))
        halo[labels == label] = 1
        pixels = self._surroundings[rows, columns]
        pixels = pixels + cover[..., None] * (self._picture[rows, columns] - pixels)
        box = particle.box
        return Sprite(pixels, cover, halo, away, box.x - columns.start, box.y - rows.start)


def _measure_gap(away: Floats, owner: npt.NDArray[np.int32]) -> float:
    """How wide gaps between things are, in pixels: twice the distance to the nearest, midway between two."""
    across, down = owner[:, 1:] != owner[:, :-1], owner[1:] != owner[:-1]
    midway = np.concatenate([away[:, 1:][across], away[1:][down]])
    return float(2 * np.median(midway)) if midway.size else np.inf


def _fade(ramp: Floats) -> Floats:
    """0 below 0, 1 above 1, smooth in between."""
    inside = np.clip(ramp, 0, 1)
    return inside * inside * (3 - 2 * inside)


def transform_sprite(sprite: Sprite, angle: float, scale: float) -> Sprite:
    """A sprite turned about its particle's centre, clockwise as seen, and made larger.

    Args:
        sprite: the sprite.
        angle: radians.
        scale: above 0.
    """
    if angle == 0 and scale == 1:
        return sprite
    # What counts nothing must not mix with what does.
    known = ((sprite.cover > 0) | (sprite.halo > 0)).astype(np.float32)
    planes = np.dstack([known[..., None] * sprite.pixels, known * sprite.away, known, sprite.cover, sprite.halo])
    planes, x, y = transform_cut(Cut(planes, sprite.x, sprite.y), angle, scale)
    colours, (away, known, cover, halo) = planes[..., :-4], np.moveaxis(planes[..., -4:], 2, 0)
    known = np.maximum(known, 1e-6)
    return Sprite(colours / known[..., None], cover, halo, np.float32(scale) * away / known, x, y)


def find_places(cut: Cut | Sprite, x: float, y: float, size: tuple[int, int], periodic: bool) -> tuple[Window, Places]:
    """Where a piece lies whose centre is at (x, y), to the nearest pixel.

    Args:
        cut: the piece.
        x, y: pixels.
        size: width and height of the plane.
        periodic: whether what leaves it at one side comes in at the other; otherwise it is cut off.

    Returns:
        The part of the piece that is on the plane, and what indexes the plane's pixels that are that part's. Of what is
        wider than a plane that repeats, that is as much as there is room for, around the centre.
    """
    rows, row = _find_span(y, cut.y, cut[0].shape[0], size[1], periodic)
    columns, column = _find_span(x, cut.x, cut[0].shape[1], size[0], periodic)
    if isinstance(row, slice) and isinstance(column, slice):
        return (rows, columns), (row, column)
    return (rows, columns), np.ix_(*(np.r_[each] for each in (row, column)))


def _find_span(
    at: float, centre: float, length: int, side: int, periodic: bool
) -> tuple[slice, slice | npt.NDArray[np.integer]]:
    """Along one axis; slices where they do, as these are quick."""
    start = round(at - centre)
    if not periodic:
        part = slice(min(length, max(0, -start)), max(0, min(length, side - start)))
        return part, slice(start + part.start, start + max(part.start, part.stop))
    first = min(max(0, round(centre - 0.5 * side)), max(0, length - side))
    length, start = min(length, side), (start + first) % side
    part = slice(first, first + length)
    if start + length <= side:
        return part, slice(start, start + length)
    return part, np.arange(start, start + length) % side
