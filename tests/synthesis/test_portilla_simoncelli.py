"""Joint statistics where they are known in closed form, against plain loops, and against plenoptic's of one picture."""

import jax
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from scipy.stats import kurtosis, skew

from jaxtex.core.pyramids import build_pyramid
from jaxtex.synthesis.portilla_simoncelli import (
    JointStatistics,
    decorrelating_axes,
    measure_joint_statistics,
    portilla_simoncelli_distance,
)


def measure(picture: np.ndarray, **options: int | bool) -> JointStatistics:
    statistics = measure_joint_statistics(picture, axes=np.eye(picture.shape[2]), **options)
    return jax.tree.map(np.asarray, statistics)


def grain(shape: tuple[int, int] = (64, 64), channels: int = 3, seed: int = 0) -> np.ndarray:
    """Seamless grain, coarser along x, of skewed colours that go together."""
    random = np.random.default_rng(seed)
    noise = gaussian_filter(random.normal(size=shape), (0.8, 2.5), mode="wrap")
    tint = gaussian_filter(random.normal(size=(*shape, channels)), (2.0, 2.0, 0.0), mode="wrap")
    return 0.2 + 0.1 * np.exp(noise / noise.std() / 2)[..., None] + 0.05 * tint / tint.std()


def bricks(side: int = 64, course: int = 16) -> np.ndarray:
    rows, columns = np.indices((side, side))
    joint = (rows % course < 2) | ((columns + course * (rows // course)) % (2 * course) < 2)
    return np.where(joint, 0.7, 0.4)[..., None] + 0.03 * np.random.default_rng(0).normal(size=(side, side, 1))


def test_statistics_are_those_of_plenoptic() -> None:
    """plenoptic 2.1.1, `PortillaSimoncelli` with two scales; its sub-bands of scale s are 4^s times ours."""
    rows, columns = np.indices((64, 64)) * 2 * np.pi / 64
    picture = 0.5 + 0.2 * np.sin(3 * rows + 2 * np.sin(2 * columns)) + 0.15 * np.cos(7 * columns + np.cos(rows)) ** 3
    picture += 0.1 * np.sin(12 * rows + 9 * columns + 3 * np.sin(rows))
    ours = measure(picture[..., None], scales=2, periodic=True)
    np.testing.assert_allclose(ours.mean, [0.5], atol=1e-5)
    np.testing.assert_allclose(ours.covariance[0, 0] * 4096 / 4095, 0.032039, atol=1e-6)
    np.testing.assert_allclose(ours.moments[0, :, 0], [6.8e-5, 6.6e-5, 4.7e-5, -0.000366], atol=2e-5)
    # Its variance of the pixels, which their kurtosis is told by, is that of a sample.
    np.testing.assert_allclose(ours.moments[0, 0, 1] * (4095 / 4096) ** 2, 2.345608, atol=2e-5)
    np.testing.assert_allclose(ours.moments[0, 1:, 1], [2.319138, 2.053537, 1.672487], atol=2e-5)
    np.testing.assert_allclose(ours.deviation[0, 0] ** 2, 0.000281, atol=1e-6)
    np.testing.assert_allclose(ours.deviation[0, 1:] * [1, 4, 16], [0.177636, 0.649870, 2.103426], rtol=1e-5)
    magnitude = [[0.013266, 0.007629, 0.009987, 0.002924], [0.090981, 0.098656, 0.024687, 0.086043]]
    np.testing.assert_allclose(ours.magnitude[0] * [[1], [4]], magnitude, atol=2e-6)
    np.testing.assert_allclose(
        ours.autocorrelation[0, 1, :, :3].T,
        [
            [-0.13728, -0.10198, -0.06841, -0.05747, -0.07268, -0.10004, -0.13437],
            [-0.27845, -0.06805, 0.09389, 0.15091, 0.09193, -0.06716, -0.27711],
            [-0.08183, 0.29406, 0.58162, 0.69292, 0.58666, 0.29178, -0.08527],
        ],
        atol=2e-5,
    )
    assert ours.magnitude_autocorrelation[0, 1, 2, 4:, 0] == pytest.approx([0.51982, 0.5287, 0.08387], abs=2e-5)
    np.testing.assert_allclose(ours.orientations[0, 1, 1:, 0], [0.53567, 0.02872, 0.54833], atol=2e-5)
    np.testing.assert_allclose(ours.orientations[0, 1, 3], [0.54833, -0.17267, 0.00079, 1], atol=2e-5)
    parents = [
        [0.00447, 0.03725, 0.09449, -0.00147],
        [-0.01134, -0.0333, -0.09538, 0.00422],
        [-0.01399, -0.21, -0.51848, 0.00442],
        [-0.00122, -0.24643, 0.00473, 0.30505],
    ]
    np.testing.assert_allclose(ours.parents[0, 0], parents, atol=5e-5)
    phases = [0.00031, 0.00222, 0.00459, -1e-05, -0.00096, -0.00199, -0.00068, 0.00012]
    np.testing.assert_allclose(ours.phases[0, 0, 0], phases, atol=2e-5)


def test_a_wave_correlates_with_itself_as_its_cosine() -> None:
    rows, columns = np.indices((64, 64))
    wave = 0.2 * np.cos(2 * np.pi * (3 * rows + 5 * columns) / 64)[..., None]
    statistics = measure(wave, scales=2, periodic=True)
    shifts = np.arange(-3, 4)
    expected = np.cos(2 * np.pi * (3 * shifts[:, None] + 5 * shifts[None, :]) / 64)
    np.testing.assert_allclose(statistics.autocorrelation[0, 0], expected, atol=1e-4)
    # Its magnitudes are everywhere the same, and do not vary with anything.
    np.testing.assert_allclose(statistics.magnitude, 0, atol=1e-6)
    assert not statistics.orientations.any()
    assert not statistics.parents.any()


@pytest.mark.parametrize(("slow", "fast"), [(0.0, 0.0), (0.0, 0.7), (0.5, 0.0), (0.3, 2.0)])
def test_phases_tell_how_a_wave_and_its_octave_meet(slow: float, fast: float) -> None:
    angle = np.broadcast_to(2 * np.pi * np.arange(64) / 64, (64, 64))
    picture = 0.2 * (np.cos(6 * angle + slow) + np.cos(12 * angle + fast))
    real, imaginary = measure(picture[..., None], scales=4, periodic=True).phases[0, 1, 0, [0, 4]]
    assert real**2 + imaginary**2 > 0.3
    between = np.arctan2(real, imaginary) - (fast - 2 * slow)
    assert np.cos(between) == pytest.approx(1, abs=1e-3)


def test_autocorrelation_within_the_picture_is_that_of_a_plain_loop() -> None:
    picture = grain((40, 52), channels=1)
    statistics = measure(picture, scales=2)
    # The finest view and the highpass residual, filtered twice, are the picture.
    view = lowpassed(picture[..., 0])
    view = view - view.mean()
    for down in range(-3, 4):
        for right in range(-3, 4):
            first = view[max(0, down) : 40 + min(0, down), max(0, right) : 52 + min(0, right)]
            second = view[max(0, -down) : 40 + min(0, -down), max(0, -right) : 52 + min(0, -right)]
            expected = (first * second).mean() / view.var()
            assert statistics.autocorrelation[0, 0, down + 3, right + 3] == pytest.approx(expected, abs=1e-4)
    assert statistics.moments[0, :2, 0] == pytest.approx([skew(picture, None), skew(view, None)], abs=1e-3)
    expected = [kurtosis(picture, None, fisher=False), kurtosis(view, None, fisher=False)]
    assert statistics.moments[0, :2, 1] == pytest.approx(expected, rel=1e-3)


def lowpassed(image: np.ndarray) -> np.ndarray:
    """An image, extended by reflection, without its highpass residual."""
    extended = np.pad(image, 32, mode="symmetric")
    highpass = build_pyramid(extended, scales=0, orientations=1).highpass
    twice = build_pyramid(highpass, scales=0, orientations=1).highpass
    return (extended - np.asarray(twice))[32:-32, 32:-32]


def test_correlations_of_magnitudes_are_those_of_plain_coefficients() -> None:
    """With two orientations, a sub-band's quadrature follows from its Hilbert transform along its axis."""
    picture = grain(channels=1)
    statistics = measure(picture, scales=1, orientations=2, periodic=True)
    bands = np.asarray(build_pyramid(picture[..., 0], scales=1, orientations=2).bands[0], np.float64)
    frequencies = np.fft.fftfreq(64)
    magnitudes = []
    for band, sign in zip(bands, (np.sign(frequencies)[None, :], np.sign(frequencies)[:, None]), strict=True):
        quadrature = np.fft.ifft2(np.fft.fft2(band) * -1j * sign).real
        magnitudes.append(np.hypot(band, quadrature))
    expected = np.corrcoef([each.ravel() for each in magnitudes])
    np.testing.assert_allclose(statistics.orientations[0, 0], expected, atol=1e-4)
    np.testing.assert_allclose(statistics.magnitude[0, 0], [each.std() for each in magnitudes], rtol=1e-4)
    assert statistics.parents.shape == (1, 0, 2, 2)


@pytest.mark.parametrize(("shape", "channels"), [((64, 64), 1), ((37, 50), 4)])
def test_a_picture_is_at_no_distance_from_itself(shape: tuple[int, int], channels: int) -> None:
    picture = grain(shape, channels)
    assert portilla_simoncelli_distance(picture, picture, scales=3).total == 0


def test_a_shift_of_a_seamless_picture_changes_nothing() -> None:
    picture = grain()
    here, there = (measure(each, scales=3, periodic=True) for each in (picture, np.roll(picture, (8, 24), (0, 1))))
    for name, first, second in zip(JointStatistics._fields, here, there, strict=True):
        np.testing.assert_allclose(first, second, atol=3e-4, err_msg=name)


def test_another_piece_is_nearer_than_another_texture() -> None:
    exemplar, same = grain((128, 128)), grain((128, 128), seed=1)
    other = np.swapaxes(same, 0, 1)
    near, far = (portilla_simoncelli_distance(exemplar, each, scales=3) for each in (same, other))
    assert far.total > 1.5 * near.total
    assert all(far.groups[name] > 0.98 * value for name, value in near.groups.items())
    for group in ("autocorrelation", "contrast"):
        assert far.groups[group] > 2 * near.groups[group]


def test_the_more_blurred_the_further() -> None:
    picture = grain()
    blurred = [gaussian_filter(picture, (s, s, 0), mode="wrap") for s in (0.4, 0.7, 1.2, 2.0)]
    totals = [portilla_simoncelli_distance(picture, each, scales=3).total for each in blurred]
    assert totals == sorted(totals)


def test_random_phases_keep_autocorrelation_only() -> None:
    picture = bricks()
    noise = np.fft.rfft2(np.random.default_rng(1).normal(size=picture.shape[:2]))
    spectrum = np.fft.rfft2(picture[..., 0]) * noise / np.abs(noise)
    spectrum[0, 0] = picture.sum()
    groups = portilla_simoncelli_distance(picture, np.fft.irfft2(spectrum)[..., None], scales=3).groups
    assert groups["autocorrelation"] < 0.6
    assert min(groups["moments"], groups["phases"], groups["magnitudes"]) > 1


def test_grey_in_three_channels_is_grey() -> None:
    first, second = grain(channels=1), grain(channels=1, seed=1) ** 1.2
    alone = portilla_simoncelli_distance(first, second, scales=3)
    three = portilla_simoncelli_distance(np.repeat(first, 3, axis=2), np.repeat(second, 3, axis=2), scales=3)
    for name, value in alone.groups.items():
        assert three.groups[name] == pytest.approx(value, rel=0.01), name


def test_the_order_of_channels_does_not_matter() -> None:
    first, second = grain(), grain(seed=1)
    once = portilla_simoncelli_distance(first, second, scales=3)
    again = portilla_simoncelli_distance(first[..., [2, 0, 1]], second[..., [2, 0, 1]], scales=3)
    assert again.groups == pytest.approx(once.groups, rel=1e-3)


def test_a_change_of_colour_is_told_in_units_of_contrast() -> None:
    picture = grain()
    contrast = np.sqrt(np.trace(np.cov(picture.reshape(-1, 3).T)))
    colour = contrast * np.array([0.3, 0.0, 0.4])
    moved, further = (portilla_simoncelli_distance(picture, picture + n * colour, scales=3) for n in (1, 2))
    assert further.groups["colours"] == pytest.approx(2 * moved.groups["colours"], rel=1e-3)
    assert max(value for name, value in moved.groups.items() if name != "colours") < 0.01


def test_axes_decorrelate() -> None:
    picture = grain()
    axes = decorrelating_axes(picture)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-6)
    covariance = np.asarray(measure_joint_statistics(picture, axes=axes, scales=3).covariance)
    np.testing.assert_allclose(covariance - np.diag(np.diag(covariance)), 0, atol=1e-7)
    assert (np.diff(np.diag(covariance)) <= 0).all()


def test_flat_pictures_have_finite_distances() -> None:
    flat = np.full((64, 64, 3), 0.5)
    assert portilla_simoncelli_distance(flat, flat, scales=3).total == 0
    for pair in ((flat, grain()), (grain(), flat)):
        assert all(np.isfinite(value) for value in portilla_simoncelli_distance(*pair, scales=3).groups.values())


@pytest.mark.parametrize(
    ("pictures", "options", "words"),
    [
        ((np.zeros((32, 32)), np.zeros((32, 32, 1))), {}, "exemplar of shape"),
        ((np.zeros((32, 32, 1)), np.zeros((32, 32, 3))), {}, "1 and 3 channels"),
        ((np.zeros((64, 64, 1)), np.zeros((64, 20, 1))), {"scales": 3}, "3 scales do not fit 20 x 64"),
        ((np.zeros((32, 32, 1)), np.zeros((32, 32, 1))), {"scales": 0}, "0 scales are too few"),
        ((np.zeros((32, 32, 1)), np.zeros((32, 32, 1))), {"scales": 1, "orientations": 0}, "0 orientations"),
    ],
)
def test_what_cannot_be_compared_is_refused(pictures: tuple, options: dict, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        portilla_simoncelli_distance(*pictures, **options)
