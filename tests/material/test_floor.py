"""Maps of floors: every plank shows its own wood, about its own middle."""

import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.material.floor import draw_planks, render_floor
from jaxtex.material.wood import look_at_plank
from jaxtex.models.floor_files import PlacedWood
from jaxtex.models.wood import make_wood

PLANKS = [
    PlacedWood(np.array([[0.0, 0], [60, 0], [60, 200], [0, 200]]), make_wood(ring_spacing=12.0), True),
    PlacedWood(np.array([[60.0, 0], [100, 0], [100, 200], [60, 200]]), make_wood(ring_spacing=7.0, rotation=1.0), True),
]


def render(size=(100, 200)):
    bands = list(render_floor(PLANKS, image=(100, 200), size=size))
    return [np.concatenate([getattr(band, name) for band in bands]) for name in bands[0]._fields]


def test_each_plank_shows_its_own_wood():
    colour, height, normal, roughness, number, *_ = render()
    assert colour.shape == (200, 100, 3)
    np.testing.assert_array_equal(number[100], np.repeat([0, 1], [60, 40]))
    for plank, column in ((PLANKS[0], 30), (PLANKS[1], 85)):
        middle = plank.corners.mean(0)
        seen = look_at_plank(plank.wood, np.array([[column + 0.5, 77.5]]) - middle, spot=0.5)
        np.testing.assert_allclose(colour[77, column], seen.base_colour[0], atol=1e-5)
        around = np.array([[1.0, 0.0], [-1, 0], [0, 1], [0, -1]]) + np.array([column + 0.5, 77.5]) - middle
        right, left, below, above = look_at_plank(plank.wood, around, spot=0.5).height
        leaning = np.array([left - right, below - above, 2.0])  # of the height as it stands in the map
        np.testing.assert_allclose(normal[77, column], leaning / np.linalg.norm(leaning), atol=1e-4)
        np.testing.assert_allclose(roughness[77, column], seen.roughness[0], atol=1e-5)
        np.testing.assert_allclose(height[77, column], seen.height[0], atol=1e-5)


def test_joints_are_dark_and_lie_deep():
    colour, height, *_ = render()
    assert colour[100, 59].sum() < 0.6 * colour[100, 55].sum() or colour[100, 60].sum() < 0.6 * colour[100, 64].sum()
    assert height[100, [59, 60]].max() < height[100, [30, 85]].min()


def test_maps_of_any_size_show_the_whole_floor():
    number = render(size=(50, 300))[4]
    assert number.shape == (300, 50)
    np.testing.assert_array_equal(number[0], np.repeat([0, 1], [30, 20]))
    with pytest.raises(InputError, match="no pixels"):
        render(size=(0, 10))


def test_outlines_are_drawn_on_the_joints():
    shown = draw_planks(np.full((200, 100, 1), 0.5, np.float32), PLANKS)
    changed = np.abs(shown - 0.5).max(-1) > 0.1
    assert changed[100, [59, 60]].all()
    assert not changed[100, [20, 40, 80]].any()
