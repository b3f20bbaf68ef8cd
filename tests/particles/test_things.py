"""Particles of label images: their boxes, and whether they are whole."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxtex.particles.things import describe_particles, fit_box


def draw_rectangle(x: float, y: float, width: float, height: float, angle: float) -> np.ndarray:
    row, column = np.indices((120, 140)) + 0.5
    along = (column - x) * np.cos(angle) + (row - y) * np.sin(angle)
    across = (row - y) * np.cos(angle) - (column - x) * np.sin(angle)
    return (np.abs(along) < width / 2) & (np.abs(across) < height / 2)


@given(st.floats(-1.5, 1.5), st.floats(55, 80), st.floats(50, 70))
def test_boxes_are_the_rectangles_that_were_drawn(angle: float, x: float, y: float) -> None:
    box = fit_box(*np.nonzero(draw_rectangle(x, y, 60, 24, angle)))
    assert (box.x, box.y) == (pytest.approx(x, abs=1), pytest.approx(y, abs=1))
    # A box holds whole pixels, and so is larger; nearly upright ones are taken for upright.
    if box.angle not in (0, np.pi / 2):
        assert abs(np.sin(box.angle - angle)) < 0.05
        assert (box.width, box.height) == (pytest.approx(60, abs=3), pytest.approx(24, abs=3))
    assert box.width >= box.height


@given(st.integers(0, 2**32 - 1))
def test_boxes_hold_all_pixels(seed: int) -> None:
    rng = np.random.default_rng(seed)
    row, column = rng.integers(0, 30, (2, rng.integers(1, 20)))
    box = fit_box(row, column)
    away_x, away_y = column + 0.5 - box.x, row + 0.5 - box.y
    along = away_x * np.cos(box.angle) + away_y * np.sin(box.angle)
    across = away_y * np.cos(box.angle) - away_x * np.sin(box.angle)
    assert (np.abs(along) <= box.width / 2 + 1e-9).all()
    assert (np.abs(across) <= box.height / 2 + 1e-9).all()
    assert -np.pi / 2 < box.angle <= np.pi / 2


def test_particles_cut_off_by_the_border_are_incomplete() -> None:
    row, column = np.indices((60, 80)) + 0.5
    labels = np.zeros((60, 80), int)
    for number, (x, y) in enumerate([(20, 20), (80, 30), (40, 10), (60, 57)], 1):
        labels[np.hypot(column - x, row - y) < 10] = number
    found = describe_particles(labels, [0, 1, 0, 1])
    assert [each.complete for each in found.particles] == [True, False, True, False]
    assert [each.kind for each in found.particles] == [0, 1, 0, 1]
    assert found.kinds == 2
    assert found.particles[0].area == np.sum(labels == 1)


def test_numbers_with_gaps_are_closed_up() -> None:
    labels = np.array([[0, 5, 5, 0, 9], [0, 5, 0, 0, 9]])
    found = describe_particles(labels, [0, 0])
    assert found.labels.tolist() == [[0, 1, 1, 0, 2], [0, 1, 0, 0, 2]]
    assert [each.area for each in found.particles] == [3, 2]


def test_nothing_is_no_particle() -> None:
    assert describe_particles(np.zeros((4, 5), int), []).particles == ()


@pytest.mark.parametrize(
    ("labels", "kinds", "complaint"),
    [
        (np.zeros((4, 5)), [], "labels: float64 of shape"),
        (np.zeros(4, int), [], "labels: int64 of shape"),
        (np.full((2, 2), -1), [], "labels: -1 is below 0"),
        (np.ones((2, 2), int), [], "kinds of shape .* each of the 1 particles"),
        (np.ones((2, 2), int), [-1], "kinds of shape"),
    ],
)
def test_what_is_no_picture_of_labels_is_told(labels: np.ndarray, kinds: list[int], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        describe_particles(labels, kinds)
