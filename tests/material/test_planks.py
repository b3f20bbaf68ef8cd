"""Planks beyond their rings: drawn on a floor, learnt from it, and drawn anew."""

import dataclasses

import jax
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
from jaxtex.material import floor as module
from jaxtex.material.floor import render_floor
from jaxtex.material.planks import cut_plank, frame_of, measure_planks
from jaxtex.models.floor_files import PlacedWood
from jaxtex.models.wood import make_wood

KEY = jax.random.key(2)
HEIGHT, WIDTH = 160, 180
TONES = np.array([[0.5, 0.4, 0.3], [0.6, 0.5, 0.35], [0.45, 0.33, 0.25]])
WOOD = make_wood(ring_spacing=12.0)


def plank_at(left, top, width, height, *, own=False):
    corners = np.array([[left, top], [left + width, top], [left + width, top + height], [left, top + height]], float)
    return PlacedWood(corners, WOOD, own)


PLANKS = [plank_at(60 * n, 0, 60, 160) for n in range(3)]


def draw_floor(*, shade=0.0, strength=0.03):
    """Three planks whose fibres run downwards, and dark joints between them; linear light."""
    x = np.broadcast_to(np.arange(WIDTH) + 0.5, (HEIGHT, WIDTH))
    inside = np.minimum(x % 60, 60 - x % 60)
    grain = gaussian_filter(np.random.default_rng(0).normal(size=(HEIGHT, WIDTH)), (8, 0.5))
    encoded = TONES[(x // 60).astype(int)] + (strength * grain / grain.std() + shade * np.exp(-inside / 2))[..., None]
    encoded[inside < 1.5] = 0.1
    return srgb_to_linear(np.clip(encoded, 0, 1)).astype(np.float32)


def render(planks=PLANKS, *, interiors, size=(WIDTH, HEIGHT), key=KEY):
    bands = list(render_floor(planks, image=(WIDTH, HEIGHT), size=size, interiors=interiors, key=key))
    return bands[0]._make(np.concatenate(part) for part in zip(*bands, strict=True))


@pytest.fixture(scope="module")
def found():
    return measure_planks(draw_floor(), PLANKS)


def test_tones_joints_and_grain_are_measured(found):
    np.testing.assert_allclose(found.tone, TONES, atol=0.012)
    np.testing.assert_allclose(found.joint, 0.1, atol=0.01)
    np.testing.assert_allclose(found.contrast, 1, atol=0.2)
    assert not found.own.any()
    assert not found.turned.any()
    plain, ringed = found.grain
    assert plain.squeezed > 1  # fibres are long
    assert plain.examples.std() == pytest.approx(0.03, rel=0.25)
    assert len(ringed.examples) == 0


def test_shades_towards_the_long_sides_are_measured():
    found = measure_planks(draw_floor(shade=-0.3), PLANKS)
    at = np.arange(len(found.profile)) + 0.5
    np.testing.assert_allclose(found.profile[3:6], np.repeat(-0.3 * np.exp(-at[3:6, None] / 2), 3, axis=1), atol=0.02)
    np.testing.assert_allclose(found.profile[-1], 0, atol=1e-6)
    assert np.abs(measure_planks(draw_floor(), PLANKS).profile).max() < 0.02


def test_grain_of_one_plank_may_be_stronger():
    photo = draw_floor()
    encoded = linear_to_srgb(photo.astype(np.float64))
    encoded[:, 60:120] = TONES[1] + 2 * (encoded[:, 60:120] - TONES[1])
    contrast = measure_planks(srgb_to_linear(np.clip(encoded, 0, 1)), PLANKS).contrast
    assert contrast[1] / contrast[[0, 2]].mean() == pytest.approx(2, rel=0.2)


@pytest.mark.parametrize("across", [False, True])
def test_fibres_of_a_square_plank_run_where_light_changes_less(across):
    grain = gaussian_filter(np.random.default_rng(0).normal(size=(80, 80)), (0.5, 6) if across else (6, 0.5))
    photo = srgb_to_linear(np.clip(0.5 + 0.05 * grain / grain.std(), 0, 1))[..., None].astype(np.float32)
    plank = plank_at(0, 0, 80, 80)
    found = measure_planks(photo, [plank])
    along = frame_of(plank, turned=bool(found.turned[0])).along
    np.testing.assert_allclose(np.abs(along), [1, 0] if across else [0, 1], atol=1e-9)
    assert found.grain[0].squeezed > 1


def test_a_frame_lies_along_the_longer_side():
    turn = np.array([[np.cos(0.5), np.sin(0.5)], [-np.sin(0.5), np.cos(0.5)]])
    plank = dataclasses.replace(plank_at(0, 0, 20, 90), corners=plank_at(0, 0, 20, 90).corners @ turn + 100)
    frame = frame_of(plank, turned=False)
    assert frame.half == pytest.approx((10, 45))
    np.testing.assert_allclose(frame.middle, plank.corners.mean(axis=0))
    np.testing.assert_allclose(frame.along, np.array([0.0, 1.0]) @ turn, atol=1e-9)
    assert frame.along @ frame.across == pytest.approx(0, abs=1e-9)
    turned = frame_of(plank, turned=True)
    np.testing.assert_allclose(np.abs(turned.along @ frame.across), 1)
    assert turned.half == pytest.approx((45, 10))


def test_a_turned_plank_is_cut_upright():
    y, x = np.indices((200, 200)) + 0.5
    turn = np.array([[np.cos(0.5), np.sin(0.5)], [-np.sin(0.5), np.cos(0.5)]])
    plank = dataclasses.replace(plank_at(0, 0, 30, 90), corners=(plank_at(-15, -45, 30, 90).corners) @ turn + 100)
    across, along = turn[0], turn[1]
    picture = np.stack([(x - 100) * v[0] + (y - 100) * v[1] for v in (across, along)], axis=-1).astype(np.float32)
    piece = cut_plank(picture, plank, turned=False)
    sign = np.sign(frame_of(plank, turned=False).along @ along), np.sign(frame_of(plank, turned=False).across @ across)
    rows, columns = piece.values.shape[:2]
    assert 80 <= rows <= 90
    assert 20 <= columns <= 30
    np.testing.assert_allclose(piece.values[:, columns // 2, 1] * sign[0], np.arange(rows) - 0.5 * (rows - 1), atol=0.6)
    np.testing.assert_allclose(15 - np.abs(piece.values[rows // 2, :, 0]), piece.inside, atol=0.02)


def test_nails_are_evened_out():
    photo = draw_floor()
    photo[40:46, 28:34] = 0.0
    photo[100:106, 88:94] = 1.0
    grain = measure_planks(photo, PLANKS).grain[0].examples
    assert np.abs(grain).max() < 0.2


def test_planks_that_cannot_be_seen_have_the_usual_tone(found):
    hidden = [*PLANKS, plank_at(900, 0, 60, 160)]
    more = measure_planks(draw_floor(), hidden)
    np.testing.assert_allclose(more.tone[:3], found.tone, atol=1e-5)
    np.testing.assert_allclose(more.tone[3], np.median(found.tone, axis=0), atol=0.02)
    assert more.contrast[3] == 1
    assert measure_planks(draw_floor(), [plank_at(900, 0, 60, 160)]) is None
    assert measure_planks(draw_floor(), [plank_at(3, 3, 8, 8)]) is None


def test_filled_planks_have_their_tone_their_grain_and_shaded_joints(found):
    maps = render(interiors=found)
    encoded = linear_to_srgb(maps.base_colour)
    for number in range(3):
        face = encoded[8:-8, 60 * number + 8 : 60 * number + 52]
        np.testing.assert_allclose(np.median(face, axis=(0, 1)), TONES[number], atol=0.03)
        assert face[..., 0].std() == pytest.approx(0.03, rel=0.5)
        along, across = (np.diff(face[..., 0], axis=axis).std() for axis in (0, 1))
        assert across > 3 * along  # fibres run downwards
    joint = [59, 60, 119, 120]
    assert encoded[:, joint].mean() < 0.7 * encoded.mean()
    # Joints lie deep: walls of the planks beside them lean towards them.
    assert maps.height[:, joint].max() < np.median(maps.height) - 0.5
    assert maps.normal[:, 58, 0].mean() > 0.3
    assert maps.normal[:, 61, 0].mean() < -0.3
    np.testing.assert_allclose(np.linalg.norm(maps.normal, axis=-1), 1, atol=1e-5)


def test_normals_are_the_gradient_of_the_height(found):
    maps = render(interiors=found)
    down, right = np.gradient(maps.height.astype(np.float64))
    expected = np.stack([-right, down, np.ones_like(down)], axis=-1)
    expected /= np.linalg.norm(expected, axis=-1, keepdims=True)
    np.testing.assert_allclose(maps.normal[1:-1, 1:-1], expected[1:-1, 1:-1], atol=1e-4)


def test_the_same_key_gives_the_same_floor_and_another_another(found):
    one, again, other = (render(interiors=found, key=jax.random.key(seed)) for seed in (1, 1, 2))
    for a, b in zip(one, again, strict=True):
        assert np.array_equal(a, b)
    assert np.abs(one.base_colour - other.base_colour).mean() > 0.003
    with pytest.raises(ValueError, match="key"):
        next(render_floor(PLANKS, image=(WIDTH, HEIGHT), size=(90, 80), interiors=found))


def test_bands_do_not_show(found, monkeypatch):
    whole = render(interiors=found)
    monkeypatch.setattr(module, "BAND", 37)
    for name, one, other in zip(whole._fields, whole, render(interiors=found), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-5, err_msg=name)


def test_two_planks_of_one_tone_differ_inside(found):
    maps = render(interiors=dataclasses.replace(found, tone=np.full((3, 3), 0.5, np.float32)))
    one, other = (maps.base_colour[8:-8, 60 * n + 8 : 60 * n + 52, 0].ravel() for n in (0, 1))
    assert abs(np.corrcoef(one, other)[0, 1]) < 0.3


def test_planks_with_their_own_rings_keep_them(found):
    own = [dataclasses.replace(plank, own=True) for plank in PLANKS]
    bare = render(own, interiors=None)
    nothing = np.zeros((0, 1, 1, 3), np.float32)
    none = dataclasses.replace(found.grain[0], examples=nothing, fine=nothing)
    plain = dataclasses.replace(
        found, own=np.ones(3, bool), tone=0 * found.tone, profile=0 * found.profile, grain=(none, none)
    )
    filled = render(own, interiors=plain)
    inner = np.abs((np.arange(WIDTH) + 0.5) % 60 - 30) < 26
    np.testing.assert_allclose(filled.base_colour[4:-4, inner], bare.base_colour[4:-4, inner], atol=2e-3)
    np.testing.assert_allclose(filled.height[4:-4, inner], bare.height[4:-4, inner], atol=1e-4)
