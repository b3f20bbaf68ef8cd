"""What a solve sees of a map of joints."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxtex.fitting.refine import observe


@given(height=st.integers(1, 700), width=st.integers(1, 700))
def test_no_shape_of_picture_has_more_points_than_there_is_room_for(height, width):
    seen = observe(np.zeros((height, width), np.float32), (width, height), blur=1.0, tolerance=0.5, budget=4096)
    assert seen.points.shape == (4096, 2)
    inside = seen.points[seen.weight > 0]
    assert np.all((inside > 0) & (inside < [width, height]))


def test_points_are_pixel_centres_of_the_photograph_and_see_its_joints():
    joint = np.zeros((40, 60), np.float32)
    joint[:, 30:] = 1.0
    seen = observe(joint, (120.0, 80.0), blur=1.0, tolerance=0.5, budget=4096)
    known = seen.weight > 0
    x, y = seen.points[known].T
    assert x[0] == pytest.approx(3.0)  # the first pixel centre further from the border than the blur reaches
    assert np.all(seen.joint[known][x < 50] < 0.01)
    assert np.all(seen.joint[known][x > 70] > 0.99)
    assert y.min() > 0
    assert y.max() < 80
