"""Finding the things that a picture is made of.

J.-M. Dischler, K. Maritaud, B. Lévy and D. Ghazanfarpour, "Texture particles" (Eurographics 2002), section 2.1: colours
are smoothed and quantised to a few classes, whose connected parts are the things; a person says which colours count.

Departure: nobody needs to say. Things are looked for in two ways, by the ground that they lie on (`particles.ground`)
and by the joints that part them (`particles.joints`). One criterion chooses: how much of the picture is covered by what
is likely a thing, by its shape, the edge around it and in it, and its looks beside those of the ground.
"""

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.particles.ground import find_by_ground
from jaxtex.particles.joints import find_by_joints, make_levels, rate_things
from jaxtex.particles.kinds import class_things
from jaxtex.particles.things import Decomposition, describe_particles
from jaxtex.photo.pictures import check_picture, to_lab


def find_particles(pixels: npt.ArrayLike, *, kinds: int | None = None) -> Decomposition:
    """Take a picture apart into things, with nothing said about them.

    Args:
        pixels: linear light, [row, col] or [row, col, channel] of 1 or 3 channels.
        kinds: how many classes of things there are. Unless told, as many, up to 4, as are clearly apart in colour.

    Raises:
        InputError: no picture, one that is too small or of one colour, or in which nothing is found; no kind.

    Examples:
        >>> row, column = np.indices((96, 96)) % 24 - 12
        >>> find_particles(np.where(np.hypot(row, column) < 7, 0.1, 0.6)).kinds
        1
    """
    picture = check_picture(pixels)
    if min(picture.shape[:2]) < 16:
        raise InputError(f"picture of {picture.shape[1]} x {picture.shape[0]} pixels: is too small; give at least 16")
    if kinds is not None and kinds < 1:
        raise InputError(f"kinds: {kinds} is out of range; give 1 or more")
    lab = to_lab(picture)
    if np.ptp(lab, axis=(0, 1)).max() < 1e-3:
        raise InputError("picture: is all of one colour, so nothing can be told from it")
    levels = make_levels(lab)
    labels, most = find_by_joints(lab, levels)
    on_ground = find_by_ground(lab)
    if not labels.any() or rate_things(on_ground, levels) > most:
        labels = on_ground
    if labels.max() == 0:
        raise InputError("picture: nothing stands out of a ground; paint the things as a label image")
    return describe_particles(labels, class_things(lab, labels, kinds))


def rate_particles(pixels: npt.ArrayLike, decomposition: Decomposition) -> float:
    """How much particles look like things by their shapes and edges: mean expected overlap, over what they cover.

    Of pebbles, coins or scales it is 0.16 to 0.55; of grass, bark or sky, in which there are none, 0 to 0.11.

    Args:
        pixels: the picture, as in `find_particles`.
        decomposition: what it was taken apart into; at least one particle.

    Examples:
        >>> row, column = np.indices((96, 96)) % 24 - 12
        >>> spots = np.where(np.hypot(row, column) < 7, 0.1, 0.6)
        >>> rate_particles(spots, find_particles(spots)) > 0.3
        True
    """
    levels = make_levels(to_lab(check_picture(pixels)))
    return rate_things(decomposition.labels, levels) / float(np.mean(decomposition.labels > 0))
