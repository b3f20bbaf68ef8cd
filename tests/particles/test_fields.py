"""Fields against what they are drawn from."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import map_coordinates

from jaxtex.particles.fields import field_values, linear_field, map_field, radial_field

place = st.tuples(st.floats(-50, 150), st.floats(-50, 150))


@given(place, place, st.floats(-1, 2), st.floats(-20, 20))
def test_linear_fields_change_along_their_way_alone(
    start: tuple[float, float], end: tuple[float, float], part: float, aside: float
) -> None:
    way = np.subtract(end, start)
    if np.hypot(*way) < 1:
        return
    x, y = np.array(start) + part * way + aside * np.array([-way[1], way[0]])
    value = linear_field(start, end, 2.0, 5.0)(np.array([x]), np.array([y]))
    np.testing.assert_allclose(value, 2 + 3 * np.clip(part, 0, 1), atol=1e-9)


@pytest.mark.parametrize(("softness", "expected"), [(1.0, [1, 0.75, 0, 0]), (0.5, [1, 1, 0, 0]), (0.0, [1, 1, 0, 0])])
def test_radial_fields_have_a_rim(softness: float, expected: list[float]) -> None:
    field = radial_field((10, 20), 8, 1.0, 0.0, softness=softness)
    np.testing.assert_allclose(field(np.array([10.0, 12.0, 18.0, 30.0]), np.full(4, 20.0)), expected)


def test_maps_are_interpolated_between_pixels() -> None:
    painted = np.random.default_rng(0).uniform(size=(5, 7))
    x, y = np.random.default_rng(1).uniform(0, 1, (2, 50)) * np.array([[70.0], [100.0]])
    found = map_field(painted, (70, 100), low=-1.0, high=3.0)(x, y)
    known = map_coordinates(painted, [y * 5 / 100 - 0.5, x * 7 / 70 - 0.5], order=1, mode="nearest")
    np.testing.assert_allclose(found, -1 + 4 * known)


def test_masks_end_where_they_are_painted() -> None:
    mask = np.random.default_rng(0).uniform(size=(30, 40)) > 0.5
    row, column = np.indices(mask.shape)
    field = map_field(mask, (40, 30))
    for shift in (0.001, 0.5, 0.999):
        np.testing.assert_array_equal(field(column + shift, row + shift), mask)


@pytest.mark.parametrize(
    ("make", "complaint"),
    [
        (lambda: linear_field((3, 4), (3, 4), 0.0, 1.0), "give two places"),
        (lambda: radial_field((0, 0), 0.0, 0.0, 1.0), "radius is 0"),
        (lambda: radial_field((0, 0), 1.0, 0.0, 1.0, softness=2.0), "softness is 2"),
        (lambda: map_field(np.zeros((4, 4, 3)), (9, 9)), r"map of shape \(4, 4, 3\)"),
        (lambda: map_field([[np.nan]], (9, 9)), "give finite numbers"),
        (lambda: field_values("size", lambda x, y: x[:2], np.zeros(3), np.zeros(3)), r"size: the field gives shape"),
        (lambda: field_values("size", np.inf, np.zeros(3), np.zeros(3)), "size: holds a number that is not finite"),
    ],
)
def test_what_is_no_field_is_refused(make: Callable, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        make()
