"""Boxes that lean, against points laid over them."""

from math import cos, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxtex.particles.boxes import Form, form_of, gap_between, overlap_share, reach_along
from jaxtex.particles.things import Box

angles = st.floats(-1.57, 1.57)
boxes = st.builds(Box, st.floats(-9, 9), st.floats(-9, 9), st.floats(2, 12), st.floats(1, 9), angles)


def lay_points(box: Box) -> np.ndarray:
    """Points all over a box, its corners among them, [point, (x, y)]."""
    u, v = (each.ravel() for each in np.meshgrid(np.linspace(-0.5, 0.5, 41), np.linspace(-0.5, 0.5, 41)))
    along, across = u * box.width, v * box.height
    c, s = cos(box.angle), sin(box.angle)
    return np.stack([box.x + along * c - across * s, box.y + along * s + across * c], axis=1)


@given(boxes, angles)
def test_reach_is_that_of_the_corners(box: Box, angle: float) -> None:
    away = lay_points(box) - np.array([box.x, box.y])[None]
    along, across = away @ [cos(angle), sin(angle)], away @ [-sin(angle), cos(angle)]
    assert reach_along(form_of(box), cos(angle), sin(angle)) == pytest.approx((along.max(), across.max()))


@given(boxes, boxes)
def test_boxes_overlap_if_they_have_points_in_common(one: Box, other: Box) -> None:
    dx, dy = other.x - one.x, other.y - one.y
    share, gap = (measure(dx, dy, form_of(one), form_of(other)) for measure in (overlap_share, gap_between))
    away = lay_points(other) - np.array([one.x, one.y])[None]
    c, s = cos(one.angle), sin(one.angle)
    inside = (np.abs(away @ [c, s]) < 0.5 * one.width) & (np.abs(away @ [-s, c]) < 0.5 * one.height)
    if inside.any():
        assert share > 0
        assert gap < 0
    elif share > 0.1:
        # Only so little that it lies between the points.
        reverse = lay_points(one) - np.array([other.x, other.y])[None]
        c, s = cos(other.angle), sin(other.angle)
        there = (np.abs(reverse @ [c, s]) < 0.5 * other.width) & (np.abs(reverse @ [-s, c]) < 0.5 * other.height)
        assert there.any() or share < 0.3
    nearest = np.min(np.hypot(*(lay_points(one)[:, None] - lay_points(other)[None, ::40]).T))
    assert gap <= nearest + 1e-9
    assert (gap > 0) == (share < 0) or abs(gap) < 1e-9
    assert overlap_share(-dx, -dy, form_of(other), form_of(one)) == pytest.approx(share) or share < 0


def test_overlap_is_a_share_of_the_smaller_box() -> None:
    large, small = Form(10.0, 10.0, 1.0, 0.0), Form(2.0, 2.0, 1.0, 0.0)
    assert overlap_share(10.0, 0.0, large, small) == 0.5
    assert overlap_share(3.0, 3.0, large, small) >= 1
