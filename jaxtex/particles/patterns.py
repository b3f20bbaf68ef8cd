"""Particles as points of several classes in a window, and where each has its nearest ones of a class.

What is nearest is only known of points that are further from the window's border than from what is nearest. Points far
from others are left out more often for that, which weights make up for: K.-H. Hanisch, "Some remarks on estimators of
the distribution function of nearest neighbour distance in stationary spatial point processes" (Statistics, 1984).
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from jaxtex.particles.composition import Composition
from jaxtex.particles.things import Decomposition

Floats = npt.NDArray[np.floating]
Numbers = npt.NDArray[np.intp]


class Pattern(NamedTuple):
    """Points of several classes in a window.

    Attributes:
        points: centres of boxes, pixels, [point, (x, y)].
        kinds: the class of each, [point].
        known: whether a point is where its particle is, rather than in the middle of what is left of it, [point].
        low, high: corners (x, y) of the window in which all points are known; what is outside may be missing.
        period: width and height of a plane that repeats to all sides, which has no border; none otherwise.
    """

    points: Floats
    kinds: Numbers
    known: npt.NDArray[np.bool_]
    low: tuple[float, float]
    high: tuple[float, float]
    period: tuple[float, float] | None


class Neighbours(NamedTuple):
    """The nearest points of a class to those of a class.

    Attributes:
        around: points that have been asked, those in the window that are known, [asked].
        which: their nearest points, nearest first, [asked, rank]; where there is none, the point itself.
        ways: from a point to them, pixels, [asked, rank, (x, y)]; 0 where there is none.
        weights: how many points of an endless plane each stands for, in relation; 0 where the border is nearer than
            the neighbour or there is none, [asked, rank].
    """

    around: Numbers
    which: Numbers
    ways: Floats
    weights: Floats


def pattern_of_picture(decomposition: Decomposition) -> Pattern:
    """The particles of a picture as points.

    The window is the picture without a margin of half of what complete particles are wide as a rule: nearer to the
    border, most are cut off, and the middle of what is left of them is not theirs.

    Args:
        decomposition: the picture taken apart.

    Examples:
        >>> from jaxtex.particles.things import describe_particles
        >>> labels = np.zeros((40, 60), int)
        >>> labels[10:14, 10:16] = 1
        >>> pattern_of_picture(describe_particles(labels, [0])).low
        (3.0, 3.0)
    """
    particles = decomposition.particles
    height, width = decomposition.labels.shape
    widths = [each.box.width for each in particles if each.complete]
    margin = min(0.5 * float(np.median(widths)) if widths else 0.0, 0.25 * min(height, width))
    return Pattern(
        np.array([(each.box.x, each.box.y) for each in particles], float).reshape(-1, 2),
        np.array([each.kind for each in particles], np.intp),
        np.array([each.complete for each in particles], bool),
        (margin, margin),
        (width - margin, height - margin),
        None,
    )


def pattern_of_composition(composition: Composition) -> Pattern:
    """The particles of a composition as points.

    Args:
        composition: of any particles; those that lie outside of an open plane are neighbours too.
    """
    points, size = np.stack([composition.x, composition.y], axis=1), (composition.width, composition.height)
    if composition.periodic:
        points = points % np.array(size)[None]
        points[points == np.array(size)[None]] = 0.0  # what rounding makes of places just below 0
    return Pattern(
        points,
        composition.kinds,
        np.ones(len(composition), bool),
        (0.0, 0.0),
        (float(size[0]), float(size[1])),
        (float(size[0]), float(size[1])) if composition.periodic else None,
    )


def find_nearest(pattern: Pattern, kind: int, other: int, count: int) -> Neighbours:
    """The nearest points of one class to each known point of another one, or of the same.

    Args:
        pattern: points.
        kind: class of the points that are asked.
        other: class of their neighbours.
        count: how many neighbours each is asked for.

    Examples:
        >>> three = np.array([[10.0, 10.0], [14.0, 10.0], [97.0, 10.0]])
        >>> here = np.ones(3, bool)
        >>> leaves = Pattern(three, np.zeros(3, int), here, (0.0, 0.0), (100.0, 50.0), (100.0, 50.0))
        >>> find_nearest(leaves, 0, 0, 1).ways[:, 0].tolist()
        [[4.0, 0.0], [-4.0, 0.0], [13.0, 0.0]]
    """
    points, low, high = pattern.points, np.array(pattern.low), np.array(pattern.high)
    inside = ((points >= low[None]) & (points <= high[None])).all(axis=1)
    around = np.flatnonzero(pattern.known & inside & (pattern.kinds == kind))
    members = np.flatnonzero(pattern.kinds == other)
    which = np.repeat(around[:, None], count, axis=1)
    if len(around) == 0 or len(members) == 0:
        return Neighbours(around, which, np.zeros((len(around), count, 2)), np.zeros((len(around), count)))
    tree = cKDTree(points[members], boxsize=pattern.period)
    # A point is its own nearest one.
    index = tree.query(points[around], np.arange(1, count + 2))[1]
    found = np.where(index < len(members), members[np.minimum(index, len(members) - 1)], -1)
    itself = found == around[:, None]
    order = np.argsort(itself | (found < 0), axis=1, kind="stable")[:, :count]
    found = np.take_along_axis(np.where(itself, -1, found), order, axis=1)
    which = np.where(found >= 0, found, which)
    ways = points[which] - points[around][:, None]
    if pattern.period is not None:
        ways -= np.round(ways / np.array(pattern.period)) * np.array(pattern.period)
    return Neighbours(around, which, ways, _weigh(pattern, points[around], ways) * (found >= 0))


def _weigh(pattern: Pattern, points: Floats, ways: Floats) -> Floats:
    """Hanisch's: one over the area in which points with such a neighbour would have been taken."""
    if pattern.period is not None:
        return np.ones(ways.shape[:2])
    low, high = np.array(pattern.low), np.array(pattern.high)
    border = np.minimum(points - low[None], high[None] - points).min(axis=1)
    distances = np.hypot(ways[..., 0], ways[..., 1])
    width, height = (high - low).tolist()
    area = (width - 2 * distances) * (height - 2 * distances)
    taken = (distances <= border[:, None]) & (area > 0)
    return np.where(taken, width * height / np.where(taken, area, 1.0), 0.0)
