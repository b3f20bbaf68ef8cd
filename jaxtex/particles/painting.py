"""Drawing a composition: the ground, what surrounds each particle, and particles over it one after the other.

J.-M. Dischler, K. Maritaud, B. Lévy and D. Ghazanfarpour, "Texture particles" (Eurographics 2002), sections 2.1 and
2.2. Addition: particles bring their halos (`jaxtex.particles.sprites`), which lie under all particles; where several
meet, the nearest particle's rules.
"""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
from jaxtex.particles.composition import Composition
from jaxtex.particles.grounds import check_against, even_ground
from jaxtex.particles.sprites import Cut, SpriteSheet, find_places, transform_cut, transform_sprite
from jaxtex.particles.things import Decomposition
from jaxtex.synthesis.neighbourhoods import check_picture

_HALF = 0.4999  # of a pixel: a particle covers one that it fills so far, rounding aside

Floats = npt.NDArray[np.float32]


def paint_composition(
    composition: Composition,
    pixels: npt.ArrayLike,
    decomposition: Decomposition,
    ground: npt.ArrayLike,
    *,
    halos: bool = True,
) -> Floats:
    """Draw a composition.

    Args:
        composition: of the particles of `decomposition`.
        pixels: the picture, floats [row, col, channel], encoded as sRGB if particles' colours change.
        decomposition: the picture taken apart.
        ground: what is seen where neither particles nor what surrounds them are, [row, col, channel], of the
            composition's size.
        halos: whether what surrounds particles in the picture is drawn with them; not, if the ground is no part of that
            picture, as when leaves are laid on a wall.

    Returns:
        Colours as `pixels` has them, [row, col, channel].

    Raises:
        ValueError: pictures of another size than the decomposition's and the composition's.
    """
    picture, beneath = check_against(pixels, decomposition), check_picture(ground, "ground")
    size = composition.width, composition.height
    if beneath.shape != (*size[::-1], picture.shape[2]):
        raise ValueError(f"ground of shape {beneath.shape}: give the composition's, {(*size[::-1], picture.shape[2])}")
    sheet = SpriteSheet(picture, even_ground(picture, decomposition), decomposition)
    channels = picture.shape[2]
    # The last plane is how much is covered by particles, and the weight of all halos.
    things, around = (np.zeros((*size[::-1], channels + 1), np.float32) for _ in range(2))
    bare = np.ones(size[::-1], np.float32)
    for (number, x, y, angle, scale), gain in zip(_placed(composition), composition.gains, strict=True):
        sprite = transform_sprite(sheet[number], angle, scale)
        part, places = find_places(sprite, x, y, size, composition.periodic)
        cover, halo, away = (each[part] for each in (sprite.cover, sprite.halo, sprite.away))
        colours = np.concatenate([sprite.pixels[part], np.ones((*cover.shape, 1), np.float32)], axis=2)
        if halos:
            # The eighth power: at 8 pixels, what is a pixel further away, or a tenth weaker, counts 0.4 times.
            weight = np.square(np.square(np.square(halo / (1 + away))))
            around[places] += weight[..., None] * colours
            bare[places] *= 1 - halo
        colours[..., :-1] = _tint(colours[..., :-1], gain)  # of the thing, and not of what surrounds it
        things[places] += cover[..., None] * (colours - things[places])
    weights = around[..., channels:]
    around = np.where(weights > 0, around[..., :channels] / np.where(weights > 0, weights, 1), beneath)
    beneath = around + bare[..., None] * (beneath - around)
    return things[..., :channels] + (1 - things[..., channels:]) * beneath


def _tint(pixels: Floats, gain: npt.NDArray[np.float64]) -> Floats:
    """Encoded colours, their light multiplied; in pictures that are not of three channels by the mean factor."""
    if (gain == 1).all():
        return pixels
    factors = gain if pixels.shape[2] == 3 else gain.mean(keepdims=True)
    return linear_to_srgb(srgb_to_linear(pixels) * factors.astype(np.float32))


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
    size = composition.width, composition.height
    labels = np.zeros(size[::-1], np.int32)
    around = ndimage.find_objects(decomposition.labels)
    cut: dict[int, Cut] = {}
    for index, (number, x, y, angle, scale) in enumerate(_placed(composition), 1):
        if number not in cut:
            rows, columns = around[number]
            mask, box = decomposition.labels[rows, columns] == number + 1, decomposition.particles[number].box
            cut[number] = Cut(mask[..., None].astype(np.float32), box.x - columns.start, box.y - rows.start)
        turned = transform_cut(cut[number], angle, scale)
        part, places = find_places(turned, x, y, size, composition.periodic)
        seen = turned.planes[part][..., 0] > _HALF
        labels[places] = np.where(seen, index, labels[places])
    return labels


def _placed(composition: Composition) -> Iterator[tuple[int, float, float, float, float]]:
    """Number, x, y, angle and scale of each particle."""
    return zip(composition.particles, composition.x, composition.y, composition.angles, composition.scales, strict=True)
