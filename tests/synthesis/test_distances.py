"""The sliced Wasserstein distance where it is known in closed form, and against SciPy's along one line."""

import jax
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter
from scipy.stats import wasserstein_distance

from jaxtex.synthesis import distances
from jaxtex.synthesis.distances import sliced_wasserstein

KEY = jax.random.key(0)


def grain(shape: tuple[int, int] = (72, 64), channels: int = 3, seed: int = 0, blur: float = 1.0) -> np.ndarray:
    """Seamless coloured grain of standard deviation 0.1 around 0.5."""
    noise = np.random.default_rng(seed).normal(size=(*shape, channels))
    noise = gaussian_filter(noise, (blur, blur, 0), mode="wrap")
    return 0.5 + 0.1 * (noise - noise.mean(axis=(0, 1))) / noise.std()


@pytest.mark.parametrize("channels", [1, 3, 5])
def test_a_picture_is_at_no_distance_from_itself(channels: int) -> None:
    picture = grain(channels=channels)
    assert not sliced_wasserstein(picture, picture, key=KEY, scales=3, projections=16).scales.any()


@pytest.mark.parametrize("gain", [0.0, 0.4, 1.7])
def test_a_change_of_contrast_is_the_distance_at_every_scale(gain: float) -> None:
    picture = grain()
    distance = sliced_wasserstein(picture, 0.5 + gain * (picture - 0.5), key=KEY, scales=3)
    np.testing.assert_allclose(distance.scales[:2], abs(gain - 1), rtol=0.01)
    # The mean of the few patches of the coarsest scale is not quite the picture's.
    assert distance.scales[2] == pytest.approx(abs(gain - 1), rel=0.1)
    assert distance.total == pytest.approx(distance.scales.mean())


def test_a_change_of_colour_shows_at_the_coarsest_scale_only() -> None:
    picture = grain()
    offset = np.array([0.05, -0.02, 0.03])
    distance = sliced_wasserstein(picture, picture + offset, key=KEY, scales=3, projections=4000)
    np.testing.assert_allclose(distance.scales[:2], 0, atol=1e-5)
    # Of unit vectors evenly spread, the mean square of their projections on a vector is its length over the dimension.
    coarsest = np.asarray(distances._laplacian(picture.astype(np.float32), 3)[-1])
    patches = np.lib.stride_tricks.sliding_window_view(coarsest, (7, 7), axis=(0, 1)).reshape(-1, 3 * 49, order="A")
    expected = np.sqrt((offset**2).mean() / patches.var(axis=0).mean())
    assert distance.scales[2] == pytest.approx(expected, rel=0.05)


def test_noise_of_two_known_distributions() -> None:
    """Single values of normal and of uniform noise of one variance: the square is 2 - 2 sqrt(3 / pi)."""
    rng = np.random.default_rng(1)
    normal, uniform = rng.normal(size=(400, 500, 1)), rng.uniform(-np.sqrt(3), np.sqrt(3), size=(300, 600, 1))
    distance = sliced_wasserstein(normal, uniform, key=KEY, patch=1, scales=1, projections=2)
    assert distance.total == pytest.approx(np.sqrt(2 - 2 * np.sqrt(3 / np.pi)), rel=0.02)


@given(st.integers(1, 40), st.integers(1, 40), st.integers(0, 99))
def test_samples_of_different_size_are_matched_as_scipy_matches_them(first: int, second: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    one, other = np.sort(rng.normal(size=first)), np.sort(rng.normal(size=second))
    here, there, shares = map(np.asarray, distances._match_in_order(first, second))
    assert (shares * np.abs(one[here] - other[there])).sum() == pytest.approx(
        wasserstein_distance(one, other), rel=1e-4
    )
    assert shares.sum() == pytest.approx(1, rel=1e-5)


def test_projections_are_those_of_patches() -> None:
    """At one scale the distance is that of patches written out and projected by a product."""
    first, second = grain((15, 12), 2), grain((11, 14), 2, seed=1)
    directions = np.asarray(distances._draw_directions(jax.random.fold_in(KEY, 0), 20, 5, 2))
    np.testing.assert_allclose((directions**2).sum(axis=(1, 2, 3)), 1, rtol=1e-5)

    def project(picture: np.ndarray) -> np.ndarray:
        rows, columns = picture.shape[0] - 4, picture.shape[1] - 4
        patches = np.stack([picture[r : r + 5, c : c + 5].ravel() for r in range(rows) for c in range(columns)])
        return np.sort(patches @ directions.reshape(20, -1).T, axis=0)

    seen, made = project(first), project(second)
    copies = [np.repeat(seen, len(made), axis=0), np.repeat(made, len(seen), axis=0)]
    expected = np.sqrt(((copies[0] - copies[1]) ** 2).mean() / seen.var(axis=0).mean())
    distance = sliced_wasserstein(first, second, key=KEY, patch=5, scales=1, projections=20)
    assert distance.total == pytest.approx(expected, rel=1e-4)


def test_a_shift_of_a_seamless_picture_is_next_to_nothing() -> None:
    picture = grain((128, 128))
    shifted = sliced_wasserstein(picture, np.roll(picture, (37, 51), (0, 1)), key=KEY, scales=3)
    other = sliced_wasserstein(picture, grain((128, 128), blur=1.5), key=KEY, scales=3)
    assert shifted.total < 0.05
    assert other.total > 5 * shifted.total


def test_the_more_blurred_the_further() -> None:
    picture = grain((96, 96))
    blurred = [gaussian_filter(picture, (s, s, 0), mode="wrap") for s in (0.3, 0.5, 0.8, 1.2, 2.0)]
    totals = [sliced_wasserstein(picture, each, key=KEY, scales=3).total for each in blurred]
    assert totals == sorted(totals)
    assert totals[-1] > 10 * totals[0]


def test_it_is_the_same_every_time_and_its_key_counts() -> None:
    first, second = grain(), grain(seed=3)
    once = [sliced_wasserstein(first, second, key=KEY, scales=2) for _ in range(2)]
    np.testing.assert_array_equal(once[0].scales, once[1].scales)
    again = sliced_wasserstein(first, second, key=jax.random.key(1), scales=2)
    assert again.total != once[0].total
    assert again.total == pytest.approx(once[0].total, rel=0.3)


def test_a_flat_exemplar_has_finite_distances() -> None:
    flat = np.full((32, 32, 3), 0.5)
    distance = sliced_wasserstein(flat, grain((32, 32)), key=KEY, scales=2)
    assert np.isfinite(distance.total)
    assert distance.total > 1
    assert sliced_wasserstein(flat, flat, key=KEY, scales=2).total == 0


@pytest.mark.parametrize(
    ("pictures", "options", "words"),
    [
        ((np.zeros((9, 9)), np.zeros((9, 9, 1))), {}, "exemplar of shape"),
        ((np.zeros((9, 9, 1)), np.zeros((0, 9, 1))), {}, "texture of shape"),
        ((np.zeros((9, 9, 1)), np.full((9, 9, 1), np.nan)), {}, "texture: some values are NaN"),
        ((np.zeros((9, 9, 1)), np.zeros((9, 9, 3))), {}, "1 and 3 channels"),
        ((np.zeros((64, 64, 1)), np.zeros((64, 12, 1))), {"scales": 2}, "texture of 12 x 64 .* need 13"),
        ((np.zeros((9, 9, 1)), np.zeros((9, 9, 1))), {"projections": 0}, "projections 0"),
    ],
)
def test_what_cannot_be_compared_is_refused(pictures: tuple, options: dict, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        sliced_wasserstein(*pictures, key=KEY, **options)
