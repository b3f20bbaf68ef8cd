"""Detail that was drawn is read again: gradual late wood, fibres, a smooth displacement."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxtex.fitting.wood import fit_wood
from jaxtex.fitting.wood_detail import read_fibres, read_gradation, smooth_displacement, sum_cosines
from jaxtex.fitting.wood_outcome import find_inner_wood
from jaxtex.material.wood import render_wood
from jaxtex.models.envelope import SourceImage
from jaxtex.models.files import load_model, save_model
from jaxtex.models.wood import early_share, make_wood
from jaxtex.models.wood_detail import Fibres
from jaxtex.models.wood_files import WoodFile, wood_from_parameters, wood_parameters


@pytest.mark.parametrize("gradation", [0.0, 0.1, 0.2])
def test_gradation_is_read_through_blur_and_noise(gradation):
    rings = np.broadcast_to(np.linspace(0, 9, 300), (200, 300))
    light = np.asarray(early_share(rings, 0.55, 0.04, gradation)) * 20
    light = light + np.random.default_rng(0).normal(0, 3, light.shape)
    read, explained = read_gradation(light, rings, np.ones(rings.shape, bool), 0.55)
    assert read == pytest.approx(gradation, abs=0.03)
    inwards = read_gradation(light, 0.5 - rings, np.ones(rings.shape, bool), 0.55)[1]
    assert gradation == 0 or explained > inwards


def test_what_ends_gradually_has_no_gradation():
    rings = np.broadcast_to(np.linspace(0, 9, 300), (200, 300))
    light = np.asarray(early_share(0.5 - rings, 0.5, 0.04, 0.2)) * 20
    assert read_gradation(light, rings, np.ones(rings.shape, bool), 0.5)[0] == 0.0


def test_rings_that_are_not_numbers_are_passed_over():
    rings = np.broadcast_to(np.linspace(-1e-17, 9, 300), (200, 300)).copy()
    rings[:, 0], rings[5, 5] = -1e-17, np.nan
    assert np.isfinite(read_gradation(np.ones(rings.shape), rings, np.ones(rings.shape, bool), 0.5)).all()


def read_off(contrast: float, width: float, pores: float = 0.0) -> Fibres:
    fibres = Fibres(jnp.asarray(contrast), jnp.asarray(width), jnp.array([pores, pores]))
    wood = make_wood(ring_spacing=40.0, rotation=0.7, fibres=fibres)
    plank = np.concatenate([band.base_colour for band in render_wood(wood, across=256, size=(256, 256))])
    v, u = np.indices((256, 256)) + 0.5 - 128
    inner = find_inner_wood(np.abs(u * np.cos(0.7) + v * np.sin(0.7)) / 40.0, 0.405)
    read = read_fibres(plank, inner)
    assert read is not None
    return read


def test_fibres_are_read_off_a_plank():
    """Long streaks are left to the rings, and pixels blur fine ones: what is read is less, in a fixed proportion."""
    weak, strong = (float(read_off(contrast, 1.5).contrast) for contrast in (0.06, 0.12))
    assert 0.25 * 0.12 < strong < 0.12
    assert strong / weak == pytest.approx(2.0, rel=0.1)
    assert 1.0 <= float(read_off(0.1, 1.5).width) < 2.5


def test_smooth_wood_has_no_fibres():
    flat = np.full((64, 64, 3), 0.4, np.float32)
    assert read_fibres(flat, (np.ones((64, 64), bool), np.zeros((64, 64), bool))) is None


def test_stairs_at_the_borders_of_drawn_rings_are_no_pores():
    v, u = np.indices((160, 160)) - 79.5
    plank = 0.2 + 0.3 * (np.sin(2 * np.pi * np.hypot(u - 20, 0.3 * v + 30) / 9.7) > 0)
    assert fit_wood(plank).wood.fibres is None


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


def test_wide_regions_that_are_unclear_are_filled():
    wood = make_wood(ring_spacing=10.0)
    clear = np.ones((300, 200), bool)
    clear[20:280, 60:140] = False
    field = smooth_displacement(np.where(clear, 12.0, 0.0), clear, wood, scale=1.0)
    np.testing.assert_allclose(sum_cosines(field, clear.shape), 12.0, atol=0.01)


@pytest.mark.parametrize("turned", [0, 2])
def test_the_axis_lies_where_late_wood_comes_on_gradually(turned):
    """Which way up a photograph of straight grain lies changes nothing but the side of the axis."""
    random = np.random.default_rng(0)
    u = np.arange(256) + 0.5 + 3 * np.sin(np.arange(256) / 40)[:, None]
    light = 0.2 + 0.2 * np.asarray(early_share(u / 17, 0.5, 0.03, 0.15)) * random.normal(1, 0.05, (256, 256))
    light = np.rot90(light + 0.02 * random.normal(size=(256, 1)), turned)
    fit = fit_wood(np.repeat(light[..., None], 3, axis=2).copy())
    assert fit.ok
    assert fit.wood.gradation > 0.05
    outwards = np.cos(float(fit.wood.rotation)) * -np.sign(float(fit.wood.center[0]))
    assert np.sign(outwards) == (1 if turned == 0 else -1)


def test_a_fitted_plank_has_the_rings_that_were_seen_and_its_file_opens(tmp_path):
    wood = make_wood(
        ring_spacing=12.0, center=(-150.0, 20.0), rotation=0.2, turbulence_rms=3.0, turbulence_frequency=0.01,
        fibres=Fibres(jnp.asarray(0.2), jnp.asarray(1.5), jnp.asarray([0.2, 0.2])),
    )  # fmt: skip
    plank = np.concatenate([band.base_colour for band in render_wood(wood, across=160, size=(160, 160))])
    fit = fit_wood(plank)
    v, u = np.indices((160, 160)) + 0.5 - 80
    points = jnp.asarray(np.stack([u, v], -1).reshape(-1, 2), jnp.float32)
    count = jax.vmap(lambda at: fit.wood.ring_count(fit.wood.to_trunk(at)))(points)
    inside = np.s_[15:-15, 15:-15]
    off = np.asarray(count).reshape(160, 160)[inside] - fit.rings[inside]
    assert np.median(np.abs(off)) < 0.05
    report = {"ok": True, "reason": "", "iou": None, "start": None, "standard_errors": {}}
    drawn = wood_from_parameters(wood_parameters(fit.wood), seed=0)
    save_model(tmp_path / "oak.json", WoodFile(drawn, SourceImage(160, 160, "0" * 64), {}, report))
    assert isinstance(load_model(tmp_path / "oak.json"), WoodFile)
