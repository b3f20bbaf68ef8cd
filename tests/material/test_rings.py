"""Rings drawn over a photograph: lines where the count says, as broad as told, faint where it is not to be trusted."""

import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.material.rings import draw_early_wood, draw_rings

GREY = np.full((60, 200, 3), 0.4, np.float32)


def straight(spacing: float, shape: tuple[int, int] = (60, 200)) -> np.ndarray:
    """Rings whose count is 0 at the left border."""
    return np.broadcast_to((np.arange(shape[1]) + 0.5) / spacing, shape)


def painted(drawn: np.ndarray) -> np.ndarray:
    return np.abs(drawn - 0.4).max(axis=-1) > 0.33


def runs(row: np.ndarray) -> list[float]:
    """Middles of the runs of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], row, [False]]).astype(int)))
    return [0.5 * (start + end) for start, end in edges.reshape(-1, 2)]


def test_one_line_lies_in_the_late_wood_of_each_ring():
    drawn = draw_rings(GREY, straight(20.0))
    lines = runs(painted(drawn)[30])
    np.testing.assert_allclose(lines, 20.0 * (np.arange(10) + 0.75), atol=0.6)


def test_every_fifth_is_heavier_and_of_another_colour():
    row = draw_rings(GREY, straight(20.0))[30]
    amber = (row[:, 0] > 0.9) & (row[:, 2] < 0.2)
    np.testing.assert_allclose(runs(amber), 20.0 * (np.array([4, 9]) + 0.75), atol=0.6)
    near = [np.abs(row[int(at) - 6 : int(at) + 7] - 0.4).sum() for at in (75.0 + 20.0, 75.0 - 20.0)]
    assert near[0] > near[1]


def test_lines_are_anti_aliased():
    one, other = (draw_rings(GREY, straight(20.0) + shift)[30, :, 1] for shift in (0.0, 0.02))
    # A line moved by 0.4 pixels changes what is at its borders, and its weight stays.
    assert np.abs(one - other).max() > 0.05
    assert np.abs((one - 0.4)[20:40].sum() - (other - 0.4)[20:40].sum()) < 0.15


def test_lines_are_equally_broad_however_the_rings_run():
    v, u = np.indices((200, 200)) + 0.5
    steep, flat = (
        painted(draw_rings(np.full((200, 200), 0.4), (u * a + v * b) / 25)).mean() for a, b in ((1, 0), (0.6, 0.8))
    )
    assert steep == pytest.approx(flat, rel=0.25)


def test_dense_rings_leave_room_between_their_lines():
    lines = painted(draw_rings(GREY, straight(5.0)))
    assert 0.1 < lines.mean() < 0.7


def test_lines_are_faint_where_the_count_cannot_be_trusted():
    clear = np.zeros((60, 200), bool)
    clear[:30] = True
    drawn = draw_rings(GREY, straight(20.0), clear=clear)
    strong, faint = (np.abs(drawn[row] - 0.4).max() for row in (10, 50))
    assert 0.05 < faint < 0.5 * strong


def test_outlines_lie_on_both_sides_of_early_wood():
    drawn = draw_early_wood(GREY, straight(40.0), 0.6)
    edges = 40.0 * (np.arange(6)[:, None] + np.array([0.25 - 0.3, 0.25 + 0.3])).ravel()
    lines = runs(np.abs(drawn[30] - 0.4).max(axis=-1) > 0.3)
    np.testing.assert_allclose(lines, [edge for edge in edges if 0 < edge < 200], atol=0.7)


@pytest.mark.parametrize("draw", [draw_rings, lambda *given: draw_early_wood(*given, 0.5)])
def test_where_there_are_no_rings_nothing_is_drawn(draw):
    assert np.array_equal(draw(GREY, np.zeros((60, 200))), GREY)


def test_the_pith_and_a_grey_picture_are_drawn_without_harm():
    v, u = np.indices((101, 101)) - 50
    drawn = draw_rings(np.full((101, 101), 0.4), np.hypot(u, v) / 12)
    assert drawn.shape == (101, 101, 3)
    assert np.isfinite(drawn).all()
    assert painted(drawn)[50, 50 + 9]
    assert not painted(drawn)[50, 50 + 3]


def test_the_photograph_is_left_alone():
    before = GREY.copy()
    draw_rings(GREY, straight(20.0))
    draw_early_wood(GREY, straight(20.0), 0.5)
    assert np.array_equal(GREY, before)


def test_a_count_of_another_size_is_refused():
    with pytest.raises(InputError, match="rings: has the shape"):
        draw_rings(GREY, np.zeros((60, 20)))
    with pytest.raises(InputError, match="clear: has the shape"):
        draw_rings(GREY, np.zeros((60, 200)), clear=np.zeros((2, 2)))
