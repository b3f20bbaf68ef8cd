"""Outlines: drawn displaced and wobbling, and found again."""

import numpy as np
import pytest
from drawn_cells import draw_cell, draw_mask

from jaxtex.material.edges import SIDES, measure_outlines


def measure(shifts, *, reach=4.0, **size):
    cells = [draw_cell(**size) for _ in shifts]
    return measure_outlines(cells, [draw_mask(*pair) for pair in zip(cells, shifts, strict=True)], reach=reach)


def test_edges_are_found_where_they_are():
    shifts = np.random.default_rng(0).integers(-3, 4, (12, 4))
    outline = measure(shifts)
    np.testing.assert_allclose(outline.shift, shifts, atol=1e-5)
    assert outline.wobble == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("side", range(4), ids=SIDES)
def test_each_side_is_told_from_the_others(side):
    shifts = np.eye(4)[[side]] * 2
    np.testing.assert_allclose(measure(shifts).shift, shifts, atol=1e-5)
    np.testing.assert_allclose(measure(-shifts).shift, -shifts, atol=1e-5)


def stray(random, count, deviation, length):
    """A path whose correlation falls as exp(-distance / length)."""
    keep = np.exp(-1 / length)
    path = [deviation * random.normal()]
    for step in random.normal(0, deviation * np.sqrt(1 - keep**2), count - 1):
        path.append(keep * path[-1] + step)
    return np.array(path)


@pytest.mark.parametrize(("deviation", "length"), [(1.0, 6.0), (1.8, 12.0)])
def test_wobble_is_recovered(deviation, length):
    random = np.random.default_rng(1)
    size = {"height": 200, "width": 200, "joint": 8}
    sides = [[stray(random, 216, deviation, length) for _ in SIDES] for _ in range(12)]
    outline = measure(sides, reach=8.0, **size)
    assert outline.wobble == pytest.approx(deviation, rel=0.25)
    assert outline.length == pytest.approx(length, rel=0.35)
    expected = [[np.median(side[40:-40]) for side in each] for each in sides]
    np.testing.assert_allclose(outline.shift, expected, atol=0.75)


def test_an_edge_that_is_not_there_has_no_shift():
    cells = [draw_cell()]
    outline = measure_outlines(cells, [np.ones_like(cells[0].values[..., 0])], reach=4.0)
    assert (outline.shift == 0).all()
    assert (outline.wobble, outline.length) == (0.0, 1.0)
    assert measure([(0, 0, 0, 12)]).shift[0, 3] == 0  # beyond the cell
    assert (measure([(-20, 0, 0, 0)]).shift[0] == 0).all()  # farther in than edges are looked for


def test_rounded_corners_and_a_stain_do_not_move_edges():
    cell = draw_cell(height=40, width=80)
    mask = draw_mask(cell, (1, 1, 1, 1))
    x, y = np.minimum(cell.left, cell.right) + 1, np.minimum(cell.top, cell.bottom) + 1
    mask[np.hypot(np.clip(6 - x, 0, None)[None, :], np.clip(6 - y, 0, None)[:, None]) > 6] = 0
    mask[20:28, 40:52] = 0
    np.testing.assert_allclose(measure_outlines([cell], [mask], reach=4.0).shift, [[1, 1, 1, 1]], atol=1e-5)
