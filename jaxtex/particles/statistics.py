"""How particles are arranged, in distributions, and how far apart those of a picture and of a composition are."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.stats import wasserstein_distance

from jaxtex.particles.boxes import form_of, reach_along
from jaxtex.particles.composition import Composition, check_exemplar
from jaxtex.particles.painting import label_composition
from jaxtex.particles.patterns import Pattern, find_nearest, pattern_of_composition, pattern_of_picture
from jaxtex.particles.things import Decomposition

Floats = npt.NDArray[np.floating]


class Sample(NamedTuple):
    """Values, and how much each counts.

    Attributes:
        values: [value].
        weights: 0 or more, [value].
    """

    values: Floats
    weights: Floats

    @property
    def mean(self) -> float:
        """Weighted mean; nan of nothing."""
        return float(np.average(self.values, weights=self.weights)) if self.weights.sum() > 0 else float("nan")


class ClassStatistics(NamedTuple):
    """How the particles of one class are arranged.

    Attributes:
        distances: from each to its nearest one, centre to centre, pixels.
        directions: to it, radians modulo pi, clockwise as seen from the picture's rows: of two particles that are
            nearest to each other, neither is the first.
        sizes: square roots of areas, pixels.
        area: the share of the picture that they cover.
    """

    distances: Sample
    directions: Sample
    sizes: Sample
    area: float


class ClassDistances(NamedTuple):
    """How far apart the statistics of two classes are; 0 where they agree, nan where there is nothing to compare.

    Attributes:
        distance: Wasserstein's, between distances to nearest ones, as a share of the picture's mean distance.
        direction: the same on the circle, between directions, degrees; 22.5 from a single one to all alike.
        size: between sizes, as a share of the picture's mean size.
        area: difference between shares of area, as a share of the picture's.
    """

    distance: float
    direction: float
    size: float
    area: float


def measure_picture(decomposition: Decomposition) -> tuple[ClassStatistics, ...]:
    """Statistics of a picture's particles, class by class.

    Only complete particles are measured. What lies near the border is made up for: distances by Hanisch's weights (see
    `jaxtex.particles.patterns`), sizes by one over the area in which the box could lie without being cut off (R. E.
    Miles, 1974; C. Lantuéjoul, 1978).

    Args:
        decomposition: the picture taken apart.

    Examples:
        >>> from jaxtex.particles.things import describe_particles
        >>> row, column = np.indices((60, 80))
        >>> labels = np.where((row % 12 < 8) & (column % 20 < 15), 1 + row // 12 * 4 + column // 20, 0)
        >>> (bricks,) = measure_picture(describe_particles(labels, [0] * 20))
        >>> bricks.distances.mean, bricks.directions.mean / np.pi, bricks.area
        (12.0, 0.5, 0.5)
    """
    pattern, shape = pattern_of_picture(decomposition), decomposition.labels.shape
    kinds = np.array([-1, *(each.kind for each in decomposition.particles)])[decomposition.labels]
    sizes, weights = np.zeros(len(pattern.kinds)), np.zeros(len(pattern.kinds))
    for index, particle in enumerate(decomposition.particles):
        sizes[index] = particle.area**0.5
        if particle.complete:
            across, down = reach_along(form_of(particle.box), 1.0, 0.0)
            room = max(1.0, shape[1] - 2 * across) * max(1.0, shape[0] - 2 * down)
            weights[index] = shape[0] * shape[1] / room
    return tuple(_measure_class(pattern, kind, sizes, weights, kinds) for kind in range(decomposition.kinds))


def measure_composition(composition: Composition, decomposition: Decomposition) -> tuple[ClassStatistics, ...]:
    """Statistics of a composition's particles, class by class of its picture.

    Args:
        composition: of the particles of `decomposition`.
        decomposition: the picture taken apart.

    Raises:
        InputError: the composition is made of another picture's particles.
    """
    check_exemplar(composition, decomposition)
    pattern = pattern_of_composition(composition)
    kinds = np.append(-1, composition.kinds)[label_composition(composition, decomposition)]
    areas = np.array([particle.area for particle in decomposition.particles], float)
    sizes = np.sqrt(areas[composition.particles]) * composition.scales
    inside = ((pattern.points >= 0) & (pattern.points <= np.array(pattern.high)[None])).all(axis=1)
    return tuple(
        _measure_class(pattern, kind, sizes, inside.astype(float), kinds) for kind in range(decomposition.kinds)
    )


def compare_statistics(picture: ClassStatistics, made: ClassStatistics) -> ClassDistances:
    """How far apart the statistics of a picture's class and of the same class in a composition are.

    Args:
        picture: of a picture, by `measure_picture`.
        made: of a composition, by `measure_composition`.
    """
    return ClassDistances(
        _wasserstein(picture.distances, made.distances) / (picture.distances.mean or float("nan")),
        float(np.degrees(circular_wasserstein(picture.directions, made.directions, np.pi))),
        _wasserstein(picture.sizes, made.sizes) / (picture.sizes.mean or float("nan")),
        abs(made.area - picture.area) / picture.area if picture.area else float("nan"),
    )


def circular_wasserstein(one: Sample, other: Sample, period: float) -> float:
    """Wasserstein's distance of order 1 between distributions on a circle.

    On a circle it does not matter where distribution functions begin, so that a constant may be taken off their
    difference; the median leaves least of it (J. Rabin, J. Delon and Y. Gousseau, "Transportation distances on the
    circle", 2011).

    Args:
        one, other: values modulo `period`, any numbers.
        period: length of the circle.

    Returns:
        How far the one has to be moved to become the other one on average; nan if either is empty.

    Examples:
        >>> here, there = (Sample(np.array([each]), np.ones(1)) for each in (0.1, 6.2))
        >>> round(circular_wasserstein(here, there, 6.3), 9)
        0.2
    """
    if not (one.weights.sum() > 0 and other.weights.sum() > 0):
        return float("nan")
    places = np.concatenate([one.values, other.values]) % period
    steps = np.concatenate([one.weights / one.weights.sum(), -other.weights / other.weights.sum()])
    order = np.argsort(places)
    difference, lengths = np.cumsum(steps[order]), np.diff(places[order], append=places[order[0]] + period)
    ranked = np.argsort(difference)
    middle = int(np.searchsorted(np.cumsum(lengths[ranked]), 0.5 * period))
    median = difference[ranked[min(middle, len(ranked) - 1)]]
    return float((np.abs(difference - median) * lengths).sum())


def _measure_class(
    pattern: Pattern, kind: int, sizes: Floats, weights: Floats, kinds: npt.NDArray[np.integer]
) -> ClassStatistics:
    found, members = find_nearest(pattern, kind, kind, 1), pattern.kinds == kind
    x, y, counted = found.ways[:, 0, 0], found.ways[:, 0, 1], found.weights[:, 0]
    return ClassStatistics(
        Sample(np.hypot(x, y), counted),
        Sample(np.arctan2(y, x) % np.pi, counted),
        Sample(sizes[members], weights[members]),
        float(np.mean(kinds == kind)),
    )


def _wasserstein(one: Sample, other: Sample) -> float:
    if not (one.weights.sum() > 0 and other.weights.sum() > 0):
        return float("nan")
    return float(wasserstein_distance(one.values, other.values, one.weights, other.weights))
