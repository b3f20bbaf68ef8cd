"""Detail that was drawn is read again: gradual late wood, fibres, a smooth displacement."""

import jax.numpy as jnp
import numpy as np
import pytest

from jaxtex.fitting.wood_detail import read_fibres, read_gradation, smooth_displacement, sum_cosines
from jaxtex.material.wood import render_wood
from jaxtex.models.wood import early_share, make_wood
from jaxtex.models.wood_detail import Fibres


@pytest.mark.parametrize("gradation", [0.0, 0.1, 0.2])
def test_gradation_is_read_through_blur_and_noise(gradation):
    rings = np.broadcast_to(np.linspace(0, 9, 300), (200, 300))
    light = np.asarray(early_share(rings, 0.55, 0.04, gradation)) * 20
    light = light + np.random.default_rng(0).normal(0, 3, light.shape)
    assert read_gradation(light, rings, np.ones(rings.shape, bool), 0.55) == pytest.approx(gradation, abs=0.03)


def test_what_ends_gradually_has_no_gradation():
    rings = np.broadcast_to(np.linspace(0, 9, 300), (200, 300))
    light = np.asarray(early_share(0.5 - rings, 0.5, 0.04, 0.2)) * 20
    assert read_gradation(light, rings, np.ones(rings.shape, bool), 0.5) == 0.0


def read_off(contrast: float, width: float, pores: float = 0.0) -> Fibres:
    fibres = Fibres(*(jnp.asarray(each) for each in (contrast, width, pores)))
    wood = make_wood(ring_spacing=40.0, rotation=0.7, fibres=fibres)
    return read_fibres(np.concatenate([band.base_colour for band in render_wood(wood, across=256, size=(256, 256))]))


def test_fibres_are_read_off_a_plank():
    """Long streaks are left to the rings, and pixels blur fine ones: what is read is less, in a fixed proportion."""
    weak, strong = (float(read_off(contrast, 1.5).contrast) for contrast in (0.06, 0.12))
    assert 0.25 * 0.12 < strong < 0.12
    assert strong / weak == pytest.approx(2.0, rel=0.1)
    assert 1.0 <= float(read_off(0.1, 1.5).width) < 2.5


def test_smooth_wood_has_no_fibres():
    assert float(read_fibres(np.full((64, 64, 3), 0.4, np.float32)).contrast) == 0.0


@pytest.mark.parametrize("rotation", [0.0, np.pi / 2, 0.6])
def test_a_smooth_displacement_is_kept_and_what_is_unclear_is_filled(rotation):
    wood = make_wood(ring_spacing=16.0, rotation=rotation)
    v, u = np.indices((200, 300)) / 100
    displacement = 4 * np.sin(u) + 3 * np.cos(1.3 * v)
    clear = np.ones(displacement.shape, bool)
    clear[90:110, 140:160] = False
    spoilt = np.where(clear, displacement, 50.0)
    field = smooth_displacement(spoilt, clear, wood, scale=2.0)
    assert field.extent.tolist() == [600.0, 400.0]
    inside = np.s_[8:-8, 8:-8]
    np.testing.assert_allclose(sum_cosines(field, displacement.shape)[inside], displacement[inside], atol=0.25)
