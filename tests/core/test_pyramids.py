"""The steerable pyramid against another implementation, and what a tight frame must do."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pyrtools.pyramids import SteerablePyramidFreq

from jaxtex.core.pyramids import (
    build_pyramid,
    collapse_pyramid,
    design_filters,
    even_directions,
    most_scales,
)

SIZES = [(64, 64), (37, 61), (16, 17), (101, 30), (128, 33)]


def noise(shape: tuple[int, ...], seed: int = 0) -> jax.Array:
    return jax.random.uniform(jax.random.key(seed), shape)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    ("shape", "scales", "orientations"),
    [((64, 128), 3, 4), ((64, 64), 2, 3), ((128, 64), 4, 1), ((128, 128), 3, 6), ((64, 64), 3, 2)],
)
def test_sub_bands_are_those_of_pyrtools(shape: tuple[int, int], scales: int, orientations: int) -> None:
    image = noise(shape)
    ours = build_pyramid(image, scales=scales, orientations=orientations)
    theirs = SteerablePyramidFreq(np.asarray(image, float), height=scales, order=orientations - 1).pyr_coeffs
    pairs = [(ours.highpass, theirs["residual_highpass"])]
    for scale, bands in enumerate(ours.bands):
        # Theirs are not divided by the number of pixels that a spectrum is cropped to.
        pairs += [(band, theirs[scale, k] / 4**scale) for k, band in enumerate(bands)]
    pairs.append((ours.lowpass, theirs["residual_lowpass"] / 4**scales))
    assert len(pairs) == len(theirs)
    for mine, reference in pairs:
        # Their filters are interpolated in tables, to five digits or so.
        assert np.abs(mine - reference).max() < 1.5e-5 * np.abs(reference).max()


@settings(max_examples=8, deadline=None)
@given(st.tuples(st.integers(4, 40), st.integers(4, 40)), st.integers(0, 3), st.integers(1, 5), st.integers(0, 99))
def test_any_picture_comes_back(shape: tuple[int, int], scales: int, orientations: int, seed: int) -> None:
    image = noise(shape, seed)
    pyramid = build_pyramid(image, scales=min(scales, most_scales(shape)), orientations=orientations)
    assert collapse_pyramid(pyramid).shape == shape
    np.testing.assert_allclose(collapse_pyramid(pyramid), image, atol=1e-5)


@pytest.mark.parametrize(("shape", "scales"), [((41,), 3), ((256,), 6), ((16, 17, 18), 2), ((20, 9, 33), 1)])
def test_other_dimensions_come_back(shape: tuple[int, ...], scales: int) -> None:
    image = noise(shape)
    np.testing.assert_allclose(collapse_pyramid(build_pyramid(image, scales=scales, orientations=1)), image, atol=1e-5)


def test_solids_are_split_by_directions_in_space() -> None:
    diagonals = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3)
    filters = design_filters((16, 17, 18), scales=2, directions=diagonals)
    solid = noise((16, 17, 18))
    pyramid = filters.build(solid)
    assert [band.shape for band in pyramid.bands] == [(4, 16, 17, 18), (4, 8, 9, 9)]
    np.testing.assert_allclose(filters.collapse(pyramid), solid, atol=1e-5)


@pytest.mark.parametrize("shape", SIZES)
def test_sub_bands_share_the_picture_s_energy(shape: tuple[int, int]) -> None:
    # In the picture's units, mean squares add up, at whatever number of points each sub-band is seen.
    image = noise(shape)
    pyramid = build_pyramid(image, scales=2, orientations=4)
    parts = [pyramid.highpass, *(band for bands in pyramid.bands for band in bands), pyramid.lowpass]
    assert sum(float(jnp.mean(part**2)) for part in parts) == pytest.approx(float(jnp.mean(image**2)), rel=1e-5)


@pytest.mark.parametrize("shift", [(4, 0), (8, -12), (-4, 20)])
def test_even_shifts_shift_sub_bands(shift: tuple[int, int]) -> None:
    image = noise((48, 64))
    here = build_pyramid(image, scales=3, orientations=3)
    there = build_pyramid(jnp.roll(image, shift, (0, 1)), scales=3, orientations=3)
    for scale in range(3):
        moved = jnp.roll(here.bands[scale], [each // 2**scale for each in shift], (1, 2))
        np.testing.assert_allclose(there.bands[scale], moved, atol=1e-5)
    np.testing.assert_allclose(there.highpass, jnp.roll(here.highpass, shift, (0, 1)), atol=1e-5)


def test_a_wave_is_found_at_its_scale_and_direction() -> None:
    x = np.arange(64) + 0.5
    wave = np.cos(2 * np.pi * x / 8)  # a quarter of the Nyquist frequency: the middle of scale 1
    for orientation, image in ((0, wave[None, :]), (2, wave[:, None])):
        pyramid = build_pyramid(np.broadcast_to(image, (64, 64)), scales=3, orientations=4)
        energy = np.array([[float(jnp.mean(band**2)) for band in bands] for bands in pyramid.bands])
        assert np.unravel_index(energy.argmax(), energy.shape) == (1, orientation)
        assert energy[0].sum() + energy[2].sum() + float(jnp.mean(pyramid.lowpass**2)) < 1e-6 * energy.sum()


def test_it_is_linear_and_maps_over_batches() -> None:
    images = noise((3, 24, 31))
    together = jax.vmap(lambda image: build_pyramid(image, scales=2, orientations=4))(images)
    alone = build_pyramid(images[0] - 2 * images[1], scales=2, orientations=4)
    for parts, part in zip(jax.tree.leaves(together), jax.tree.leaves(alone), strict=True):
        np.testing.assert_allclose(parts[0] - 2 * parts[1], part, atol=1e-5)


def test_the_derivative_of_taking_apart_is_putting_together() -> None:
    image, seen = noise((20, 27)), build_pyramid(noise((20, 27), 1), scales=1, orientations=2)
    _, pull_back = jax.vjp(lambda image: build_pyramid(image, scales=1, orientations=2).highpass, image)
    (pulled,) = pull_back(seen.highpass)
    alone = jax.tree.map(jnp.zeros_like, seen)._replace(highpass=seen.highpass)
    np.testing.assert_allclose(pulled, collapse_pyramid(alone), atol=1e-5)


@pytest.mark.parametrize(
    ("shape", "scales"), [((256, 256), 6), ((255, 999), 5), ((8, 8), 1), ((7, 99), 0), ((1, 1), 0)]
)
def test_so_many_scales_fit(shape: tuple[int, int], scales: int) -> None:
    assert most_scales(shape) == scales
    assert min(build_pyramid(noise(shape), scales=scales, orientations=2).lowpass.shape) >= min(4, *shape)
    with pytest.raises(ValueError, match=rf"{scales + 1} scales do not fit .*; give 0 to {scales}$"):
        build_pyramid(noise(shape), scales=scales + 1, orientations=2)


@pytest.mark.parametrize(
    ("shape", "scales", "orientations", "told"),
    [
        ((32, 32), -1, 4, "-1 scales do not fit 32 x 32 pixels"),
        ((32, 32), 1, 0, "0 orientations are too few"),
        ((16, 16, 16), 1, 2, "in two dimensions only"),
        ((0, 16), 0, 1, "no scales"),
        ((), 0, 1, "no scales"),
    ],
)
def test_what_cannot_be_built_is_told(shape: tuple[int, ...], scales: int, orientations: int, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        build_pyramid(jnp.zeros(shape), scales=scales, orientations=orientations)


def test_directions_need_a_plane() -> None:
    np.testing.assert_allclose(even_directions(2, 2), [[0, 1], [1, 0]], atol=1e-15)
    with pytest.raises(ValueError, match="two dimensions only"):
        even_directions(2, 3)
