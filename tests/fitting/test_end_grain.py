"""Ellipses say the same as axis, tilt and rotation do, evenly in all directions."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from jaxtex.fitting.end_grain import from_ellipses, to_ellipses
from jaxtex.fitting.rings import model_count

SHAPE = (40, 50)
Floats = NDArray[np.float64]


@given(
    xc=st.floats(-80, 80), yc=st.floats(-80, 80), tilt=st.floats(0.5, 2.6), rotation=st.floats(-3, 3),
    log_spacing=st.floats(1.0, 3.5),
)  # fmt: skip
def test_there_and_back_the_rings_are_the_same(
    xc: float, yc: float, tilt: float, rotation: float, log_spacing: float
) -> None:
    free = np.array([xc, yc, tilt, rotation, log_spacing, 0.3])
    back, _ = from_ellipses(to_ellipses(free))
    assert back[5] == 0.3
    # Where they are stretched by less than a hundred-thousandth, they are taken to be by that much.
    np.testing.assert_allclose(model_count(back, SHAPE), model_count(free, SHAPE), rtol=1e-4, atol=1e-4)


@given(seed=st.integers(0, 999), stretch=st.floats(1e-3, 0.5))
def test_slopes_are_those_of_small_steps(seed: int, stretch: float) -> None:
    random = np.random.default_rng(seed)
    angle = random.uniform(-3, 3)
    middle = [*random.uniform(-30, 30, 2), stretch * np.cos(angle), stretch * np.sin(angle), 2.0, 0.1]
    _, slopes = from_ellipses(np.array(middle))
    small = 1e-6 * stretch * np.eye(6)
    numeric = [(from_ellipses(middle + each)[0] - from_ellipses(middle - each)[0]) / (2e-6 * stretch) for each in small]
    np.testing.assert_allclose(slopes, np.array(numeric).T, rtol=1e-4, atol=1e-3)


def test_the_pole_is_crossed_evenly() -> None:
    """Rings change by as much whichever way they are stretched, where tilt and rotation would lead nowhere."""
    about = np.array([5.0, -3.0, 0.0, 0.0, 2.0, 0.0])
    counts = [model_count(from_ellipses(about + each)[0], SHAPE) for each in 0.01 * np.eye(6)[2:4]]
    still = model_count(from_ellipses(about + 1e-5 * np.eye(6)[2])[0], SHAPE)
    change = [np.abs(each - still).mean() for each in counts]
    assert 0.5 < change[0] / change[1] < 2.0
    assert min(change) > 1e-3
