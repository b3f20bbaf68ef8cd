"""Textures made from statistics: that they have them, whatever the size, the channels and the resolution."""

import io

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from jaxtex.core.histograms import quantile_table, table_variance
from jaxtex.core.pyramids import build_pyramid
from jaxtex.synthesis.heeger_bergen import (
    TextureStatistics,
    analyse_texture,
    estimate_memory,
    extrapolate_finer,
    synthesise_texture,
)

PROBABILITIES = np.linspace(0.02, 0.98, 49)
KEY = jax.random.key(0)
SMALL = (32, 48)  # compiling takes longer than all else here: pictures of few shapes share what is compiled


def granite(side: int = 96, seed: int = 0) -> np.ndarray:
    """Coloured, seamless grain [1, side, side, 3] of two sizes, coarser along x, with colours that go together."""
    random = np.random.default_rng(seed)
    fine, coarse = (
        gaussian_filter(random.normal(size=(side, side)), sigma, mode="wrap") for sigma in ((0.8, 1.6), (3, 5))
    )
    light = 0.5 + 0.08 * np.exp(fine / fine.std() / 2) + 0.08 * coarse / coarse.std()
    tint = 0.03 * random.normal(size=(side, side, 3)).cumsum(axis=2)
    return (light[..., None] * [1.0, 0.8, 0.6] + tint).astype(np.float32)[None]


@pytest.fixture(scope="module")
def statistics() -> TextureStatistics:
    return analyse_texture(granite(), scales=3, periodic=True)


@pytest.fixture(scope="module")
def texture(statistics: TextureStatistics) -> np.ndarray:
    return np.asarray(synthesise_texture(statistics, (96, 96), key=KEY))


def test_colours_are_those_of_the_exemplar(texture: np.ndarray) -> None:
    seen, made = granite().reshape(-1, 3), texture.reshape(-1, 3)
    np.testing.assert_allclose(made.mean(0), seen.mean(0), atol=1e-3)
    np.testing.assert_allclose(np.cov(made.T), np.cov(seen.T), atol=0.06 * np.cov(seen.T).max())


def test_sub_bands_become_those_of_the_exemplar(statistics: TextureStatistics) -> None:
    texture = np.asarray(synthesise_texture(statistics, (96, 96), key=KEY, iterations=20))
    decorrelated = (texture - np.asarray(statistics.mean)) @ np.asarray(statistics.axes).T
    for channel in range(3):
        pyramid = build_pyramid(decorrelated[..., channel], scales=3, orientations=4)
        for scale, bands in enumerate(pyramid.bands):
            wanted = np.sqrt(table_variance(statistics.bands[channel, scale]))
            np.testing.assert_allclose(np.std(np.asarray(bands), axis=(1, 2)), wanted, rtol=0.06)
            made = quantile_table(np.asarray(bands).reshape(4, -1))
            apart = np.abs(made - statistics.bands[channel, scale])[:, 50:-50].max(axis=1)
            assert (apart < 0.2 * wanted).all()


def test_directions_are_kept(texture: np.ndarray) -> None:
    def share(picture: np.ndarray) -> float:
        down, right = (np.mean(np.diff(picture.mean(-1), axis=axis) ** 2) for axis in (0, 1))
        return float(down / right)

    assert share(granite()[0]) > 1.2
    assert share(texture) == pytest.approx(share(granite()[0]), rel=0.05)


def test_it_repeats_without_a_seam(texture: np.ndarray) -> None:
    for axis in (0, 1):
        inside = np.abs(np.diff(texture, axis=axis)).mean()
        across = np.abs(np.take(texture, 0, axis) - np.take(texture, -1, axis)).mean()
        assert across == pytest.approx(inside, rel=0.25)


def test_analysis_by_hand() -> None:
    # The sub-bands of reflected regions, seen on the regions alone, pooled.
    regions = np.random.default_rng(0).random((2, 20, 27, 1)).astype(np.float32)
    found = analyse_texture(regions, scales=2, orientations=3)
    centred = (regions[..., 0] - regions.mean()) * float(found.axes[0, 0])
    seen: list[np.ndarray] = []
    for region in centred:
        extended = np.block([[region, region[:, ::-1]], [region[::-1], region[::-1, ::-1]]])
        seen.append(np.asarray(build_pyramid(extended, scales=2, orientations=3).bands[1])[:, :10, :14].reshape(3, -1))
    np.testing.assert_allclose(found.bands[0, 1], quantile_table(np.concatenate(seen, axis=1)), atol=1e-5)
    np.testing.assert_allclose(found.pixels[0], quantile_table(centred.ravel()), atol=1e-5)


def test_reflection_makes_no_edges() -> None:
    # A slope has no detail; taken to repeat, it has an edge.
    slope = np.broadcast_to(np.linspace(0, 1, 64)[None, :, None, None], (1, 64, 64, 1))
    reflected, repeated = (analyse_texture(slope, scales=2, periodic=periodic) for periodic in (False, True))
    assert float(np.abs(reflected.highpass).max()) < 0.1 * float(np.abs(repeated.highpass).max())


@pytest.mark.parametrize("channels", [1, 4])
def test_any_number_of_channels(channels: int) -> None:
    exemplar = np.repeat(granite(48)[..., :1], channels, axis=3)
    made = np.asarray(synthesise_texture(analyse_texture(exemplar, scales=1), (40, 53), key=KEY))
    assert made.shape == (40, 53, channels)
    assert np.isfinite(made).all()
    # Channels that are all the same stay so: there is nothing in the others.
    np.testing.assert_allclose(made, np.repeat(made[..., :1], channels, axis=2), atol=1e-5)
    assert made.std() == pytest.approx(exemplar.std(), rel=0.02)


def test_a_picture_of_one_colour() -> None:
    flat = np.broadcast_to(np.float32([0.2, 0.4, 0.6]), (1, 32, 32, 3))
    for finer in (0, 1):
        made = synthesise_texture(analyse_texture(flat, scales=3 - finer), SMALL, key=KEY, finer=finer)
        np.testing.assert_allclose(made, np.broadcast_to(flat[0, 0, 0], (*SMALL, 3)), atol=1e-5)


@pytest.mark.parametrize("scales", [0, 1])
def test_finer_keeps_the_mean_where_there_are_hardly_scales_to_go_by(scales: int) -> None:
    found = analyse_texture(granite(), scales=scales, periodic=True)
    finer = np.asarray(synthesise_texture(found, (192, 192), key=KEY, finer=1))
    np.testing.assert_allclose(finer.mean((0, 1)), granite().mean((0, 1, 2)), atol=2e-3)
    assert finer.std() > 0.5 * granite().std()


def test_finer_adds_detail_and_changes_nothing_seen_from_afar(
    statistics: TextureStatistics, texture: np.ndarray
) -> None:
    plain = texture.mean(-1)
    finer = np.asarray(synthesise_texture(statistics, (384, 384), key=KEY, finer=2)).mean(-1)
    assert np.isfinite(finer).all()
    afar = finer.reshape(96, 4, 96, 4).mean((1, 3))
    assert finer.mean() == pytest.approx(plain.mean(), abs=2e-3)

    def coarse(picture: np.ndarray) -> np.ndarray:
        bands = build_pyramid(picture, scales=3, orientations=4).bands[1:]
        return np.array([np.asarray(each).std(axis=(1, 2)) for each in bands])

    np.testing.assert_allclose(coarse(afar), coarse(plain), rtol=0.1)
    enlarged = np.asarray(jax.image.resize(jnp.asarray(plain), (384, 384), "lanczos3"))
    detail = [
        float(np.asarray(build_pyramid(each, scales=1, orientations=1).bands[0]).std()) for each in (finer, enlarged)
    ]
    assert detail[0] > 3 * detail[1]


def test_what_is_extrapolated_falls_off_as_the_exemplar_does() -> None:
    # Sub-bands of one shape whose contrast halves with every octave, but for one that is astray.
    shape = jnp.asarray(quantile_table(np.random.default_rng(0).laplace(size=9999)))
    contrast = jnp.array([1.0, 2.0, 4.0, 5.0])
    bands = jnp.broadcast_to(contrast[None, :, None, None] * shape[None, None, None], (1, 4, 3, shape.size))
    no_views = jnp.zeros((0, 1, shape.size))
    found = TextureStatistics(jnp.zeros(1), jnp.eye(1), 9 * shape[None], no_views, 2 * shape[None], bands, shape[None])
    finer = jax.jit(extrapolate_finer, static_argnums=1)(found, 2)
    assert finer.bands.shape == (1, 6, 3, shape.size)
    np.testing.assert_allclose(finer.bands[0, 2:], bands[0], rtol=1e-6)
    for scale, factor in ((1, 0.5), (0, 0.25)):
        np.testing.assert_allclose(
            finer.bands[0, scale], np.broadcast_to(factor * shape, (3, shape.size)), rtol=1e-3, atol=1e-4
        )
    added = 3 * (0.25 + 0.0625) + float(table_variance(finer.highpass)[0] / table_variance(shape))
    assert float(table_variance(finer.pixels)[0] / table_variance(shape)) == pytest.approx(81 - 4 + added, rel=1e-3)


def test_keys_batches_and_iterations(statistics: TextureStatistics) -> None:
    keys = jax.random.split(KEY, 2)
    other = analyse_texture(granite(seed=1), scales=3, periodic=True)
    both = jax.tree.map(lambda *leaves: jnp.stack(leaves), other, statistics)
    batch = jax.vmap(lambda each, key: synthesise_texture(each, SMALL, key=key, iterations=2))(both, keys)
    alone = synthesise_texture(statistics, SMALL, key=keys[1], iterations=2)
    # Rounded otherwise in a batch, values change places with their neighbours.
    np.testing.assert_allclose(batch[1], alone, atol=1e-2)
    np.testing.assert_allclose(batch[0], synthesise_texture(other, SMALL, key=keys[0], iterations=2), atol=1e-2)
    assert np.array_equal(alone, synthesise_texture(statistics, SMALL, key=keys[1], iterations=2))
    assert float(jnp.abs(synthesise_texture(statistics, SMALL, key=keys[0], iterations=2) - alone).mean()) > 0.05
    assert float(jnp.abs(synthesise_texture(statistics, SMALL, key=keys[1], iterations=1) - alone).max()) > 0.02


def test_statistics_live_in_a_file(statistics: TextureStatistics) -> None:
    file = io.BytesIO()
    np.savez(file, **{name: np.asarray(value) for name, value in vars(statistics).items()})
    file.seek(0)
    with np.load(file) as arrays:
        again = TextureStatistics(**{name: jnp.asarray(arrays[name]) for name in arrays.files})
    assert (again.scales, again.orientations) == (3, 4)
    first, second = (synthesise_texture(each, SMALL, key=KEY) for each in (statistics, again))
    assert np.array_equal(first, second)


@pytest.mark.parametrize(
    ("shape", "options", "told"),
    [
        ((32, 32, 3), {}, "exemplars of shape"),
        ((1, 0, 32, 3), {}, "exemplars of shape"),
        ((1, 32, 40, 3), {"scales": 4}, "4 scales do not fit 40 x 32 pixels; give 0 to 3"),
        ((1, 32, 32, 3), {"scales": 2, "orientations": 0}, "0 orientations are too few"),
    ],
)
def test_what_cannot_be_analysed(shape: tuple[int, ...], options: dict[str, int], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        analyse_texture(np.zeros(shape), **options)


def test_no_numbers_no_statistics() -> None:
    with pytest.raises(ValueError, match="NaN or infinite"):
        analyse_texture(np.full((1, 32, 32, 1), np.nan), scales=1)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"iterations": 0}, "0 iterations are too few"),
        ({"finer": -1}, "finer: -1 is negative"),
        ({"finer": 1}, "4 scales do not fit 40 x 32 pixels; give 0 to 3"),
    ],
)
def test_what_cannot_be_made(statistics: TextureStatistics, options: dict[str, int], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        synthesise_texture(statistics, (32, 40), key=KEY, **options)


def test_memory_grows_with_all_that_takes_it() -> None:
    least = estimate_memory((100, 100), orientations=1, channels=1)
    assert estimate_memory((200, 100), orientations=1, channels=1) == 2 * least
    assert estimate_memory((100, 100), orientations=2, channels=3) > least


def test_colours_that_go_together_stay_together() -> None:
    # Red, and white lime on it: nothing in between, and neither along one principal axis alone.
    rng = np.random.default_rng(2)
    level = rng.normal(size=(96, 96, 1))
    lime = gaussian_filter(rng.normal(size=(96, 96)), 3, mode="wrap")[..., None]
    red = np.array([0.5, 0.15, 0.1]) + 0.05 * level * np.array([1.0, 0.5, 0.2])
    picture = np.where(lime > 0.12, np.array([0.9, 0.85, 0.8]) + 0.02 * level, red)
    found = analyse_texture(picture[None], scales=3, periodic=True)
    made = np.asarray(synthesise_texture(found, (96, 96), key=KEY)).reshape(-1, 3)
    seen = picture.reshape(-1, 3)
    for axis in np.random.default_rng(3).normal(size=(8, 3)):
        along = axis / np.linalg.norm(axis)
        apart = np.abs(np.quantile(made @ along, PROBABILITIES) - np.quantile(seen @ along, PROBABILITIES)).mean()
        assert apart < 0.1 * float(np.std(seen @ along))


def test_within_a_users_jit_it_is_the_same_texture(statistics: TextureStatistics) -> None:
    made = jax.jit(lambda key: synthesise_texture(statistics, SMALL, key=key, iterations=2))(jax.random.key(3))
    alone = synthesise_texture(statistics, SMALL, key=jax.random.key(3), iterations=2)
    np.testing.assert_allclose(made, alone, atol=1e-4)


def test_an_exemplar_is_measured_the_same_every_time():
    # Of this size, Fourier transforms shared out among threads differ in their last bits from time to time.
    exemplars = np.random.default_rng(0).random((3, 192, 192, 3))
    first, *others = (jax.tree.leaves(analyse_texture(exemplars, scales=5)) for _ in range(8))
    for other in others:
        assert all(np.array_equal(a, b) for a, b in zip(first, other, strict=True))
