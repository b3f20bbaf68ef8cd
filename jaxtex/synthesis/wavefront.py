"""Scanline order, many pixels at a time: wavefronts.

A pixel of a causal, L-shaped neighbourhood of radius r depends on pixels up to r to its right in the rows above. So all
pixels with one value of x + (r + 1) y can be computed together, and steps of growing values compute exactly what a loop
over rows and columns would, also when the neighbourhood's later half holds what an earlier pass has left there.

The picture is stored skewed: row t holds the pixels of step t, one below the other, from the picture's first row that
has one. A neighbour (dx, dy) of all of them is then a run of row t + dx + (r + 1) dy, so nothing is gathered pixel by
pixel.
"""

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array, lax

from jaxtex.synthesis.neighbourhoods import Shape

StateT = TypeVar("StateT")


class Wavefronts(NamedTuple):
    """The skewed layout of pictures of one size.

    Attributes:
        shape: (rows, columns) of the picture, surroundings included.
        radius: of the neighbourhoods. The outermost `radius` pixels of the picture are surroundings: they are read and
            never computed.
    """

    shape: Shape
    radius: int

    @property
    def steps(self) -> int:
        """Rows of the layout."""
        return self.shape[1] + (self.radius + 1) * (self.shape[0] - 1)

    @property
    def lanes(self) -> int:
        """Pixels in a step, at most."""
        return min(self.shape[0], -(-self.shape[1] // (self.radius + 1)) + 1)

    @property
    def stride(self) -> int:
        """Cells in a row of the layout: lanes, and what runs of neighbours may reach beyond them on either side."""
        return self.lanes + 2 * (self.radius + 1)

    def skew(self, picture: Array, empty: int) -> Array:
        """A picture [row, col] as a flat array of cells; those that are no pixel hold `empty`."""
        step = jnp.arange(self.steps)[:, None]
        lane = jnp.arange(self.stride)[None] - (self.radius + 1)
        row = self._first_row(step) + lane
        column = step - (self.radius + 1) * row
        inside = (row >= 0) & (row < self.shape[0]) & (column >= 0) & (column < self.shape[1])
        cell = jnp.where(inside, row * self.shape[1] + column, 0)
        return jnp.where(inside, picture.reshape(-1).at[cell].get(mode="promise_in_bounds"), empty).reshape(-1)

    def unskew(self, cells: Array) -> Array:
        """The inner part of the picture, without surroundings, from its cells."""
        row, column = (jnp.arange(self.radius, side - self.radius) for side in self.shape)
        step = column[None] + (self.radius + 1) * row[:, None]
        cell = step * self.stride + row[:, None] - self._first_row(step) + self.radius + 1
        return cells.at[cell].get(mode="promise_in_bounds")

    def run(
        self, compute: Callable[[Array, Array, Array, StateT], StateT], state: StateT, offsets: npt.NDArray[np.int32]
    ) -> StateT:
        """Let `compute(starts, row, column, state)` compute the pixels of one step after another.

        `starts` is where in the cells the runs of the neighbours at these (row, col) offsets begin, [tap]. `row` and
        `column` of the pixels, [lane], count from the inner part's corner; lanes without an inner pixel have row -1.
        """
        radius, (rows, columns) = self.radius, self.shape
        first = radius + (radius + 1) * radius
        last = columns - 1 - radius + (radius + 1) * (rows - 1 - radius)
        step = jnp.arange(first, last + 1)[:, None]
        there = step + jnp.asarray(offsets[:, 1] + (radius + 1) * offsets[:, 0])[None]
        down = jnp.asarray(offsets[:, 0])[None] + self._first_row(step) - self._first_row(there)
        table = there * self.stride + down + radius + 1
        lane = jnp.arange(self.lanes)

        def body(number: Array, state: StateT) -> StateT:
            row = self._first_row(first + number) + lane - radius
            column = first + number - (radius + 1) * (row + radius) - radius
            inner = (row >= 0) & (row < rows - 2 * radius) & (column >= 0) & (column < columns - 2 * radius)
            return compute(table[number], jnp.where(inner, row, -1), column, state)

        return lax.fori_loop(0, last + 1 - first, body, state)

    def read(self, cells: Array, starts: Array) -> Array:
        """The runs of cells that begin there, [tap, lane]."""
        return jax.vmap(lambda start: lax.dynamic_slice(cells, (start,), (self.lanes,)))(starts)

    def _first_row(self, step: Array) -> Array:
        """The first row that has a pixel in a step."""
        return jnp.maximum(0, -((self.shape[1] - 1 - step) // (self.radius + 1)))


class Canvas(eqx.Module):
    """What is made so far, as cells.

    Attributes:
        places: of the exemplar, -1 where there is nothing.
        colours: one word after another.
    """

    places: Array
    colours: tuple[Array, ...]

    @classmethod
    def begin(cls, fronts: Wavefronts, former: Array | None, colours: tuple[Array, ...]) -> "Canvas":
        """A canvas with what a former pass left, places [row, col], or with nothing.

        Args:
            colours: of the exemplar's places.
        """
        cells = fronts.steps * fronts.stride
        if former is None:
            return cls(jnp.full(cells, -1), tuple(jnp.zeros(cells, each.dtype) for each in colours))
        places = fronts.skew(former, -1)
        return cls(places, _look_up(colours, places))

    def write(self, start: Array, places: Array, colours: tuple[Array, ...]) -> "Canvas":
        """The canvas with a step's pixels copied from these places."""
        pixels = zip(self.colours, _look_up(colours, places), strict=True)
        return Canvas(
            lax.dynamic_update_slice(self.places, places, (start,)),
            tuple(lax.dynamic_update_slice(cells, new, (start,)) for cells, new in pixels),
        )


def _look_up(colours: tuple[Array, ...], places: Array) -> tuple[Array, ...]:
    return tuple(each.at[jnp.maximum(places, 0)].get(mode="promise_in_bounds") for each in colours)
