"""What a user asks of particles, by class and by place: how many, how large, which way, of what colour, how likely.

J.-M. Dischler, K. Maritaud, B. Lévy and D. Ghazanfarpour, "Texture particles" (Eurographics 2002), section 3 and
figures 7, 8, 10 and 11: probability, density, size and orientation of particles vary with the place as the user says,
and particles whose centre is in a region are left out.
"""

import dataclasses
from collections.abc import Mapping, Sequence
from math import inf, pi
from typing import NamedTuple

import numpy as np

from jaxtex.particles.fields import Amount, Values, field_values

LIMITS: Mapping[str, tuple[float, float]] = {
    "where": (0.0, 1.0),
    "density": (0.0, inf),
    "size": (1e-3, 1e3),
    "orientation": (-inf, inf),
    "colour": (0.0, inf),
    "probability": (0.0, 1.0),
    "least_distance": (0.0, inf),
    "size_variation": (0.0, 0.95),
    "orientation_variation": (0.0, pi),
}
"""From where to where the numbers of each kind go."""

_SPARSEST = 1 / 16
"""Density at which distances grow no more. What is sparser is made so by hiding particles at random, so that 0 is none
rather than infinitely far away."""


@dataclasses.dataclass(frozen=True)
class Control:
    """Something asked of the particles of some classes, everywhere or in a region.

    Numbers may be fields (`jaxtex.particles.fields`). Several controls act together: factors and probabilities are
    multiplied, angles added, and of distances and variations the largest holds. In part of a region (`where` between 0
    and 1) a control acts by that part, so that regions with soft edges blend.

    Attributes:
        classes: numbers of the classes that are meant; all by default.
        where: 1 where it acts and 0 where it does not.
        density: how many times as many particles there are per area. Distances change by the square root of that, so
            that lattices stay lattices, and things keep their size: solid ones that have no room for that overlap;
            give a `size` with it if they should not. Below 1/16 particles are left out at random; 0 leaves none.
        size: how many times as large particles and distances are. Half the size is therefore four times as many; with
            the `density` of the same number squared, things change and distances do not.
        orientation: radians by which a particle and its surroundings are turned, clockwise as seen.
        colour: factor on linear light, or one each for red, green and blue.
        probability: that a particle is seen. The arrangement goes on behind those that are not, and whoever is seen at
            one probability is seen at all higher ones.
        weights: of being chosen, by a particle's number in the decomposition; 1 where none is given, 0 is never. They
            hold to within the difference of particles' sizes at the border of a region.
        least_distance: pixels that centres of particles of a class keep from each other.
        size_variation: by which part of its size each particle is larger or smaller, at most, at random. Neighbours
            stay where they are; who has no room there is left out, so that large ones are fewer where things are close.
        orientation_variation: radians by which each particle is turned to either side, at most, at random, likewise.

    Raises:
        ValueError: a colour of neither one number nor three, a weight below 0.

    Examples:
        >>> from jaxtex.particles.fields import radial_field
        >>> sparse_within_a_disc = Control(density=0.5, where=radial_field((100, 100), 50, 1.0, 0.0, softness=0.2))
    """

    classes: Sequence[int] | None = None
    where: Amount = 1.0
    density: Amount = 1.0
    size: Amount = 1.0
    orientation: Amount = 0.0
    colour: Amount | tuple[Amount, Amount, Amount] = 1.0
    probability: Amount = 1.0
    weights: Mapping[int, float] = dataclasses.field(default_factory=dict)
    least_distance: Amount = 0.0
    size_variation: Amount = 0.0
    orientation_variation: Amount = 0.0

    def __post_init__(self) -> None:
        if isinstance(self.colour, tuple) and len(self.colour) != 3:
            raise ValueError(f"colour: has {len(self.colour)} numbers; give one, or one each for red, green and blue")
        for number, weight in self.weights.items():
            if not 0 <= weight < inf:
                raise ValueError(f"weights: that of particle {number} is {weight}; give a number from 0")


class Effects(NamedTuple):
    """What controls come to at places, each [place] but `gains`.

    Attributes:
        size: factor on particles.
        spacing: factor on distances.
        orientation: radians.
        least_distance: pixels.
        size_variation, orientation_variation: as a control has them.
        probability: that a particle is seen.
        gains: factors on linear red, green and blue, [place, 3].
    """

    size: Values
    spacing: Values
    orientation: Values
    least_distance: Values
    size_variation: Values
    orientation_variation: Values
    probability: Values
    gains: Values


def controls_of(controls: Sequence[Control], kind: int) -> tuple[Control, ...]:
    """Those of some controls that are meant for a class."""
    return tuple(each for each in controls if each.classes is None or kind in each.classes)


def combine_controls(controls: Sequence[Control], x: Values, y: Values) -> Effects:
    """What several controls of a class come to.

    Args:
        controls: of the class.
        x, y: places in pixels, [place].

    Raises:
        ValueError: a field with a number that is out of range or not finite, or of a wrong shape.

    Examples:
        >>> twice, half = Control(size=2.0), Control(size=0.5, orientation=1.0, where=lambda x, y: x > 10)
        >>> found = combine_controls([twice, half], np.array([0.0, 20.0]), np.zeros(2))
        >>> found.size, found.orientation
        (array([2., 1.]), array([0., 1.]))
    """
    factors = {name: np.ones(x.shape) for name in ("density", "size", "probability")}
    largest = {name: np.zeros(x.shape) for name in ("least_distance", "size_variation", "orientation_variation")}
    orientation, gains = np.zeros(x.shape), np.ones((*x.shape, 3))
    for control in controls:
        where = region_of(control, x, y)
        # What asks for nothing is passed over, as there may be many places.
        for name in factors:
            if (amount := getattr(control, name)) != 1.0:
                factors[name] *= 1 + where * (_read(name, amount, x, y) - 1)
        for name in largest:
            if (amount := getattr(control, name)) != 0.0:
                largest[name] = np.maximum(largest[name], where * _read(name, amount, x, y))
        if control.orientation != 0.0:
            orientation += where * _read("orientation", control.orientation, x, y)
        if control.colour != 1.0:
            colour = control.colour if isinstance(control.colour, tuple) else (control.colour,) * 3
            tint = np.stack([_read("colour", each, x, y) for each in colour], axis=-1)
            gains *= 1 + where[:, None] * (tint - 1)
    density = factors["density"]
    return Effects(
        size=factors["size"],
        spacing=factors["size"] * np.maximum(density, _SPARSEST) ** -0.5,
        orientation=orientation,
        probability=factors["probability"] * np.minimum(density / _SPARSEST, 1.0),
        gains=gains,
        **largest,
    )


def region_of(control: Control, x: Values, y: Values) -> Values:
    """How much of a control acts at places, 0 to 1, [place]."""
    return _read("where", control.where, x, y)


def _read(name: str, amount: Amount, x: Values, y: Values) -> Values:
    values = field_values(name, amount, x, y)
    low, high = LIMITS[name]
    wrong = (values < low) | (values > high)
    if wrong.any():
        first = int(np.argmax(wrong))
        place = f" at ({x[first]:.0f}, {y[first]:.0f})" if callable(amount) else ""
        raise ValueError(f"{name} is {values[first]:g}{place}; {range_of(name)}")
    return values


def range_of(name: str) -> str:
    """What to give for a kind of number, in words.

    Examples:
        >>> range_of("probability"), range_of("density")
        ('give 0 to 1', 'give 0 or more')
    """
    low, high = LIMITS[name]
    return f"give {low:g} or more" if high == inf else f"give {low:g} to {high:.4g}"
