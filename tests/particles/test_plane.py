"""The plane, and which places are near one, against plain loops."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxtex.particles.plane import Grid, Plane

coordinates = st.floats(-300, 300)
planes = st.builds(Plane, st.integers(5, 200), st.integers(5, 200), st.booleans())


@given(planes, coordinates, coordinates)
def test_wrapped_places_are_on_the_plane_and_the_same(plane: Plane, x: float, y: float) -> None:
    there = plane.wrap(x, y)
    assert plane.difference(x, y, *there) == pytest.approx((0, 0), abs=1e-9)
    if plane.periodic:
        assert 0 <= there[0] <= plane.width
        assert 0 <= there[1] <= plane.height


@given(planes, coordinates, coordinates, coordinates, coordinates)
def test_differences_are_the_shortest(plane: Plane, x: float, y: float, other_x: float, other_y: float) -> None:
    dx, dy = plane.difference(x, y, other_x, other_y)
    copies = range(-130, 131) if plane.periodic else [0]
    assert abs(dx) == pytest.approx(min(abs(other_x - x + plane.width * i) for i in copies), abs=1e-9)
    assert abs(dy) == pytest.approx(min(abs(other_y - y + plane.height * i) for i in copies), abs=1e-9)


@given(planes, st.floats(3, 80), st.integers(0, 2**32 - 1))
def test_everything_within_reach_is_found_once(plane: Plane, reach: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    margin = 0 if plane.periodic else 20
    places = [plane.wrap(*rng.uniform(-margin, [plane.width + margin, plane.height + margin])) for _ in range(40)]
    grid: Grid[int] = Grid(plane, reach)
    for number, place in enumerate(places):
        grid.add(*place, number)
    for place in places:
        found = list(grid.near(*place))
        within = {number for number, other in enumerate(places) if np.hypot(*plane.difference(*place, *other)) <= reach}
        if not plane.periodic or min(plane.width, plane.height) >= reach:
            assert within <= set(found)
        assert len(found) == len(set(found))


def test_places_outside_are_on_a_plane_that_repeats() -> None:
    assert Plane(10, 10, True).contains(-5.0, 3.0)
    assert not Plane(10, 10, False).contains(-5.0, 3.0, reach=4.0)
