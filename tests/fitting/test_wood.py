"""Planks drawn by plain arithmetic -> the fit finds the numbers they were drawn with."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxtex.core.errors import InputError
from jaxtex.fitting.rings import canonical_rings
from jaxtex.fitting.wood import fit_wood
from jaxtex.fitting.wood_phase import compare_rings
from jaxtex.photo.grain import find_early_wood, find_period, measure_waves


def draw_plank(size=256, center=(30.0, -20.0), tilt=10.0, rotation=35.0, spacing=18.0, fraction=0.6, displacement=0.0):
    """True on early wood, at pixel centres; angles in degrees. Geometry as the model file's description has it."""
    v, u = np.mgrid[0:size, 0:size] + 0.5 - size / 2
    turn, lean = np.radians(rotation), np.radians(tilt)
    across, along = u * np.cos(turn) + v * np.sin(turn), v * np.cos(turn) - u * np.sin(turn)
    radius = np.hypot(across - center[0], along * np.sin(lean) - center[1]) + displacement
    return np.sin(2 * np.pi * radius / spacing) > np.cos(np.pi * fraction)


def paint(early):
    return np.where(early[..., None], [0.55, 0.33, 0.17], [0.27, 0.13, 0.06]).astype(np.float32)


def turn_apart(a, b):
    return abs((a - b + 90) % 180 - 90)


@pytest.mark.parametrize(
    "truth",
    [
        {"tilt": 10.0, "rotation": 35.0},
        {"tilt": 1.0, "rotation": 91.0, "center": (60.0, 45.0)},
        {"tilt": 45.0, "rotation": 120.0, "center": (-80.0, 10.0), "fraction": 0.4},
        {"tilt": 75.0, "rotation": 10.0, "center": (10.0, 25.0), "spacing": 14.0},
        # The pith lies in the picture, and rings run straight on both of its sides.
        {"tilt": 15.0, "rotation": 87.0, "center": (44.0, 2.5), "spacing": 21.0},
    ],
)
def test_a_plank_is_found(truth):
    drawn = {"center": (30.0, -20.0), "tilt": 10.0, "rotation": 35.0, "spacing": 18.0, "fraction": 0.6} | truth
    fit = fit_wood(paint(draw_plank(**drawn)))
    wood = fit.wood
    assert fit.ok, fit.reason
    # The plank of tilt t and axis (xc, yc) is also that of -t and (xc, -yc): the fit writes the one with t >= 0.
    assert float(wood.tilt) == pytest.approx(np.radians(drawn["tilt"]), rel=0.01)
    assert turn_apart(np.degrees(float(wood.rotation)), drawn["rotation"]) < 0.1
    assert float(wood.ring_spacing) == pytest.approx(drawn["spacing"], rel=0.002)
    assert float(wood.early_fraction) == pytest.approx(drawn["fraction"], abs=0.005)
    np.testing.assert_allclose(np.asarray(wood.center), drawn["center"], atol=0.5)
    np.testing.assert_allclose(np.asarray(wood.early_rgb), [0.55, 0.33, 0.17], atol=1e-3)
    np.testing.assert_allclose(np.asarray(wood.late_rgb), [0.27, 0.13, 0.06], atol=1e-3)
    assert fit.iou[0] > 0.99
    assert float(wood.turbulence_rms) < 0.3
    assert 0 < fit.standard_errors["tilt_deg"] < 0.1


def test_lengths_are_those_of_a_picture_larger_than_the_working_size():
    fit = fit_wood(paint(draw_plank(size=768, spacing=40.0, center=(90.0, -60.0))))
    assert float(fit.wood.ring_spacing) == pytest.approx(40.0, rel=0.003)
    np.testing.assert_allclose(np.asarray(fit.wood.center), (90.0, -60.0), atol=1.5)


def test_displacement_is_measured():
    v, u = np.mgrid[0:256, 0:256]
    wave = 2.0 * np.sin(2 * np.pi * (u + 0.4 * v) / 140)
    early = draw_plank(displacement=wave)
    off, strength, _ = compare_rings(
        early - early.mean(), np.array([30.0, -20.0, np.radians(10), np.radians(35), np.log(18.0)]), blur=9.0
    )
    clear = (strength > 0.5 * strength.max())[30:-30, 30:-30]
    error = (18.0 * off - wave)[30:-30, 30:-30][clear]
    assert np.abs(np.median(error)) < 0.2
    assert error.std() < 0.35


@given(
    xc=st.floats(-300, 300), yc=st.floats(-300, 300), tilt=st.floats(-6, 6), rotation=st.floats(-9, 9)
)  # fmt: skip
def test_the_canonical_description_draws_the_same_rings(xc, yc, tilt, rotation):
    free = np.array([xc, yc, tilt, rotation, 3.0, 0.2])
    written, signs = canonical_rings(free)
    # How the numbers answer to a small change, which is what a covariance needs.
    step = np.array([1e-3, 2e-3, 1e-6, 0.0, 0.0, 0.0])
    if 1e-5 < written[2] < np.pi / 2 - 1e-5:
        np.testing.assert_allclose(canonical_rings(free + step)[0] - written, signs * step, atol=1e-9)
    assert 0 <= written[2] <= np.pi / 2
    assert 0 <= written[3] <= np.pi
    u, v = np.random.default_rng(0).uniform(-200, 200, (2, 50))

    def radius(free):
        across, along = u * np.cos(free[3]) + v * np.sin(free[3]), v * np.cos(free[3]) - u * np.sin(free[3])
        return np.hypot(across - free[0], along * np.sin(free[2]) - free[1])

    np.testing.assert_allclose(radius(written), radius(free), atol=1e-6)


def test_local_waves_are_those_of_the_rings():
    early = draw_plank(tilt=0.5, center=(2000.0, 0.0), rotation=30.0, spacing=16.0)
    rings = early - early.mean()
    assert find_period(rings) == pytest.approx(16.0, rel=0.05)
    waves = measure_waves(rings, 16.0)
    sure = waves.weight > 0.5
    assert np.median(np.hypot(*waves.wave[sure].T)) == pytest.approx(1 / 16, rel=0.01)
    direction = np.degrees(np.arctan2(waves.wave[sure, 1], waves.wave[sure, 0]))
    assert np.median([turn_apart(each, 30.0) for each in direction]) < 1


def test_slow_light_does_not_enter_the_mask():
    early = draw_plank()
    light = np.linspace(0.4, 1.0, 256)[None, :, None]
    assert np.mean(find_early_wood(paint(early) * light) == early) > 0.95


def test_rings_near_the_border_are_in_the_mask_of_a_drawing():
    """Where early wood is wide, its neighbourhood is light: evened out it would be late wood."""
    early = draw_plank(tilt=2.0, center=(-90.0, -40.0), rotation=150.0, spacing=48.0, fraction=0.7)
    np.testing.assert_array_equal(find_early_wood(paint(early)), early)


@pytest.mark.parametrize("shade", [0.35, 0.5, 0.7])
def test_a_shadow_is_not_taken_for_late_wood(shade):
    random = np.random.default_rng(0)
    early = draw_plank()
    shadow = np.where(np.arange(256) < 150, 1.0, shade)[:, None, None]
    photo = paint(early) * shadow * random.normal(1, 0.05, (256, 256, 1))
    mask = find_early_wood(photo)
    for half in (np.s_[:130], np.s_[170:]):
        assert 0.3 < mask[half].mean() < 0.9
        assert np.mean(mask[half] == early[half]) > 0.7


@pytest.mark.slow
@pytest.mark.parametrize("yc", [-20.0, 25.0])
@pytest.mark.parametrize(("tilt", "rotation"), [(0.0, 145.0), (0.0, 15.0), (17.0, 112.0)])
def test_a_held_centre_keeps_its_sign(yc, tilt, rotation):
    v, u = np.mgrid[0:100, 0:120] + 0.5
    wave = 1.2 * np.sin(u / 12) + np.cos(v / 15)
    turn, lean = np.radians([rotation, tilt])
    across = (u - 60) * np.cos(turn) + (v - 50) * np.sin(turn)
    along = (v - 50) * np.cos(turn) - (u - 60) * np.sin(turn)
    for displacement in (0.0, wave):
        radius = np.hypot(across - 12, along * np.sin(lean) - yc) + displacement
        fit = fit_wood(paint(np.sin(2 * np.pi * radius / 12) > 0), fix={"yc": yc})
        assert fit.ok, fit.reason
        assert float(fit.wood.center[1]) == pytest.approx(yc)
        assert float(fit.wood.center[0]) == pytest.approx(12, abs=2)


@pytest.mark.parametrize("card", [0.2, 0.9])
def test_a_flat_card_is_no_wood(card):
    fit = fit_wood(np.full((64, 64), card))
    assert not fit.ok
    assert fit.reason


def test_a_mask_of_another_shape_is_refused():
    with pytest.raises(InputError, match="mask has shape"):
        fit_wood(np.zeros((64, 64)), mask=np.zeros((32, 32), bool))
