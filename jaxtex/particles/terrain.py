"""What controls ask for where particles are sown, sampled over the plane once, so that it costs little to look up."""

from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import accumulate
from math import prod
from random import Random
from typing import NamedTuple

import numpy as np

from jaxtex.core.errors import InputError
from jaxtex.particles.controls import Control, combine_controls, region_of
from jaxtex.particles.plane import Plane

_FINEST = 512  # samples along each side at most
_REMEMBERED = 4096  # chances of different places, so that regions with soft edges take no room without end


class Local(NamedTuple):
    """What controls ask for at a place.

    Attributes:
        size: factor on particles.
        spacing: factor on distances.
        orientation: radians.
        least_distance: pixels.
        size_variation, orientation_variation: as a control has them.
        regions: how much of each control with weights acts, 0 to 1.
    """

    size: float
    spacing: float
    orientation: float
    least_distance: float
    size_variation: float
    orientation_variation: float
    regions: tuple[float, ...]


EVEN = Local(1.0, 1.0, 0.0, 0.0, 0.0, 0.0, ())
"""Where nothing is asked for."""


class Terrain:
    """What the controls of one class ask for, all over a plane.

    Args:
        plane: the plane.
        controls: those of the class, at least one.
        members: numbers of the particles that are chosen from.
        usual: how far the nearest neighbour is as a rule, in the picture's pixels. Where a greater distance is asked
            for, all distances grow, so that lattices stay lattices.

    Attributes:
        largest: factor on footprints.
        furthest: pixels that centres keep.
        abundance: particles per area, as a factor: the mean over the plane.
        chances: how likely each member is chosen where `regions` of a `Local` are, those before it added.

    Raises:
        InputError: weights leave no particle.
        ValueError: a field gives what it must not.

    Examples:
        >>> terrain = Terrain(Plane(100, 50, False), [Control(size=2.0, weights={3: 0.0})], (3, 7), 20.0)
        >>> terrain.at(20.0, 10.0).size, terrain.chances(terrain.at(20.0, 10.0).regions)
        (2.0, (0.0, 1.0))
    """

    def __init__(self, plane: Plane, controls: Sequence[Control], members: Sequence[int], usual: float) -> None:
        self._plane = plane
        self._columns, self._rows = (int(min(_FINEST, np.ceil(side))) for side in (plane.width, plane.height))
        row, column = np.indices((self._rows, self._columns)).reshape(2, -1)
        x = (column + 0.5) * (plane.width / self._columns)
        y = (row + 0.5) * (plane.height / self._rows)
        effects = combine_controls(controls, x, y)
        if usual > 0:
            effects = effects._replace(spacing=np.maximum(effects.spacing, effects.least_distance / usual))
        weighing = [control for control in controls if control.weights]
        self._weights = [[control.weights.get(number, 1.0) for control in weighing] for number in members]
        regions = [region_of(control, x, y) for control in weighing]
        # Double precision, so that where nothing is asked for all is as without controls.
        samples = np.stack([*(getattr(effects, name) for name in Local._fields[:-1]), *regions], axis=-1)
        self._samples = samples.reshape(self._rows, self._columns, -1)
        self.largest = float((effects.spacing * (1 + effects.size_variation)).max())
        self.furthest = float(effects.least_distance.max())
        self.abundance = float(np.mean(effects.spacing**-2))
        self.chances = lru_cache(_REMEMBERED)(self._add_up)

    def at(self, x: float, y: float) -> Local:
        """What is asked for at a place; of places outside of the plane, at its border."""
        column, row = int(x * self._columns // self._plane.width), int(y * self._rows // self._plane.height)
        if self._plane.periodic:
            column, row = column % self._columns, row % self._rows
        else:
            column, row = min(max(column, 0), self._columns - 1), min(max(row, 0), self._rows - 1)
        values = self._samples[row, column].tolist()
        return Local._make((*values[:6], tuple(values[6:])))

    def throws(self, margin: float, rng: Random) -> Callable[[], tuple[float, float]]:
        """What gives places at random, as often as particles are asked for there, up to a margin around the plane."""
        across = np.linspace(0.0, self._plane.width, self._columns + 1)
        down = np.linspace(0.0, self._plane.height, self._rows + 1)
        for edges in (across, down):
            edges[0] -= margin
            edges[-1] += margin
        spacing = self._samples[..., Local._fields.index("spacing")]
        shares = np.cumsum(np.diff(down)[:, None] * np.diff(across)[None] / np.square(spacing))

        def throw() -> tuple[float, float]:
            cell = min(int(np.searchsorted(shares, rng.random() * shares[-1])), shares.size - 1)
            row, column = divmod(cell, self._columns)
            return rng.uniform(across[column], across[column + 1]), rng.uniform(down[row], down[row + 1])

        return throw

    def _add_up(self, regions: tuple[float, ...]) -> tuple[float, ...]:
        """How likely each particle is chosen, those before it added."""
        sums = tuple(
            accumulate(
                prod(1 + share * (weight - 1) for share, weight in zip(regions, own, strict=True))
                for own in self._weights
            )
        )
        if sums[-1] == 0:
            raise InputError(
                "weights: leave no complete particle of a class; give one more than 0, or a probability of 0"
            )
        return sums
