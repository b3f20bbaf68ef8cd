"""Lapped patches: what they are made of, that they cover all, and that they repeat."""

import jax
import numpy as np
import pytest
from scipy import ndimage

from jaxtex.synthesis import lapped
from jaxtex.synthesis.lapped import lap_patches

KEY = jax.random.key(1)
GRAIN = np.random.default_rng(0).uniform(0.2, 0.8, (48, 60, 3)).astype(np.float32)


@pytest.mark.parametrize("shape", [(40, 70), (7, 90), (1, 1), (130, 20)])
def test_all_is_covered(shape: tuple[int, int]) -> None:
    texture = lap_patches(GRAIN, shape, key=KEY)
    assert texture.shape == (*shape, 3)
    assert texture.dtype == np.float32
    assert texture.min() >= 0.2 - 1e-5
    assert texture.max() <= 0.8 + 1e-5


def test_contrast_is_the_exemplars_but_where_patches_fade() -> None:
    texture = lap_patches(GRAIN, (96, 96), key=KEY)
    assert texture.mean() == pytest.approx(GRAIN.mean(), abs=0.01)
    assert 0.7 < texture.std() / GRAIN.std() < 1.01


def test_patches_are_copied_as_they_stand() -> None:
    """Where nothing fades, a pixel's neighbour is its neighbour in the exemplar too."""
    places = np.stack(np.indices((48, 60)), axis=-1).astype(np.float32)
    texture = lap_patches(places, (80, 80), key=KEY)
    steps = np.diff(texture, axis=1)
    assert np.mean(np.abs(steps - [0, 1]).max(axis=2) < 1e-3) > 0.25


def test_textures_repeat_without_a_seam() -> None:
    smooth = ndimage.gaussian_filter(GRAIN, (3, 3, 0))
    texture = lap_patches(smooth, (64, 80), key=KEY)
    for axis in (0, 1):
        turned = np.moveaxis(texture, axis, 0)
        steps = np.abs(np.diff(turned, axis=0)).max(axis=(1, 2))
        assert np.abs(turned[0] - turned[-1]).max() <= steps.max()


def test_only_usable_pixels_are_seen() -> None:
    usable = np.zeros((48, 60), bool)
    usable[5:20, 8:40], usable[30, 3:50] = True, True
    texture = lap_patches(np.where(usable[..., None], GRAIN, 50.0), (50, 50), key=KEY, usable=usable)
    assert texture.max() <= 0.8 + 1e-4


def test_a_single_usable_pixel_covers_all() -> None:
    usable = np.zeros((48, 60), bool)
    usable[20, 30] = True
    texture = lap_patches(GRAIN, (9, 9), key=KEY, usable=usable)
    np.testing.assert_allclose(texture, np.broadcast_to(GRAIN[20, 30], (9, 9, 3)), atol=1e-5)


def test_keys_tell_textures_apart() -> None:
    first, again, other = (lap_patches(GRAIN, (40, 40), key=jax.random.key(each)) for each in (3, 3, 4))
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - other).mean() > 0.05


def test_patches_that_fit_are_chosen(monkeypatch: pytest.MonkeyPatch) -> None:
    slope = np.broadcast_to(np.linspace(0, 1, 80, dtype=np.float32)[:, None, None], (80, 80, 1))
    chosen = lap_patches(slope, (120, 120), key=KEY)
    monkeypatch.setattr(lapped, "_DRAWN", 1)
    any_one = lap_patches(slope, (120, 120), key=KEY)
    assert np.abs(np.diff(chosen, axis=0)).mean() < 0.75 * np.abs(np.diff(any_one, axis=0)).mean()


def test_wrong_requests_are_told() -> None:
    with pytest.raises(ValueError, match="radius"):
        lap_patches(GRAIN, (9, 9), key=KEY, radius=0.0)
    with pytest.raises(ValueError, match="usable of shape"):
        lap_patches(GRAIN, (9, 9), key=KEY, usable=np.zeros((48, 60), bool))
    with pytest.raises(ValueError, match="usable of shape"):
        lap_patches(GRAIN, (9, 9), key=KEY, usable=np.ones((48, 61), bool))
    with pytest.raises(ValueError, match="exemplar of shape"):
        lap_patches(GRAIN[..., 0], (9, 9), key=KEY)
    with pytest.raises(ValueError, match="shape"):
        lap_patches(GRAIN, (0, 9), key=KEY)
