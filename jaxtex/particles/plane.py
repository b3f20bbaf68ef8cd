"""The plane that particles are placed on: places, how they differ, and which places are near one.

`seeding` asks for nothing else, so that a mesh can take the plane's place.
"""

from collections import defaultdict
from collections.abc import Iterator
from itertools import chain
from math import floor
from typing import Generic, NamedTuple, TypeVar

Item = TypeVar("Item")


class Plane(NamedTuple):
    """A rectangle of the plane, of which places just outside are known too, or one that repeats to all sides.

    Attributes:
        width, height: in pixels.
        periodic: whether it repeats: what leaves it at one side comes in at the other.
    """

    width: float
    height: float
    periodic: bool

    def wrap(self, x: float, y: float) -> tuple[float, float]:
        """The same place within the rectangle; where nothing repeats, the place itself.

        Examples:
            >>> Plane(100, 50, True).wrap(103.0, -1.0)
            (3.0, 49.0)
        """
        return (x % self.width, y % self.height) if self.periodic else (x, y)

    def difference(self, x: float, y: float, other_x: float, other_y: float) -> tuple[float, float]:
        """The way from one place to another, the shortest one.

        Examples:
            >>> Plane(100, 50, True).difference(98.0, 20.0, 3.0, 22.0)
            (5.0, 2.0)
        """
        dx, dy = other_x - x, other_y - y
        if self.periodic:
            dx -= self.width * floor(dx / self.width + 0.5)
            dy -= self.height * floor(dy / self.height + 0.5)
        return dx, dy

    def turns_back(self, dx: float, dy: float) -> bool:
        """Whether there is a shorter way than this one to where it leads.

        Examples:
            >>> Plane(100, 50, True).turns_back(10.0, 30.0), Plane(100, 50, False).turns_back(10.0, 30.0)
            (True, False)
        """
        return self.periodic and (2 * abs(dx) > self.width or 2 * abs(dy) > self.height)

    def contains(self, x: float, y: float, reach: float = 0.0) -> bool:
        """Whether anything within `reach` of a place may be on it.

        Examples:
            >>> Plane(100, 50, False).contains(103.0, 20.0), Plane(100, 50, False).contains(103.0, 20.0, reach=4.0)
            (False, True)
        """
        return self.periodic or (-reach <= x <= self.width + reach and -reach <= y <= self.height + reach)


class Grid(Generic[Item]):
    """Things at places of a plane, in cells, so that those near a place are found however many there are.

    Args:
        plane: the plane.
        reach: how near is near, in pixels.

    Examples:
        >>> grid = Grid(Plane(100, 50, True), 10.0)
        >>> grid.add(98.0, 20.0, "leaf")
        >>> list(grid.near(3.0, 22.0)), list(grid.near(50.0, 22.0))
        (['leaf'], [])
    """

    def __init__(self, plane: Plane, reach: float) -> None:
        self._plane = plane
        self._columns = max(1, floor(plane.width / reach))
        self._rows = max(1, floor(plane.height / reach))
        # Cells of a plane that repeats must fit in it a whole number of times.
        self._across = plane.width / self._columns if plane.periodic else reach
        self._down = plane.height / self._rows if plane.periodic else reach
        self._cells: defaultdict[tuple[int, int], list[Item]] = defaultdict(list)
        self._around: dict[tuple[int, int], tuple[list[Item], ...]] = {}

    def add(self, x: float, y: float, item: Item) -> None:
        """Put a thing at a place."""
        self._cells[self._cell(floor(x / self._across), floor(y / self._down))].append(item)

    def near(self, x: float, y: float) -> Iterator[Item]:
        """All things within reach of a place, and some a little further away; those of its own cell come first."""
        at = floor(x / self._across), floor(y / self._down)
        around = self._around.get(at)
        if around is None:
            cells = dict.fromkeys(self._cell(at[0] + i, at[1] + j) for i in (0, -1, 1) for j in (0, -1, 1))
            # The lists themselves, so that what is put into them later is found too.
            around = self._around[at] = tuple(self._cells[cell] for cell in cells)
        return chain.from_iterable(around)

    def _cell(self, column: int, row: int) -> tuple[int, int]:
        return (column % self._columns, row % self._rows) if self._plane.periodic else (column, row)
