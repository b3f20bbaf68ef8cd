"""Solid textures by relaxation: slices that look like their views, blocks that go on at their faces."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from jaxtex.synthesis.solid_relaxation import measure_axis, relax_solid, relax_steps
from jaxtex.synthesis.solid_views import AXES, CROPS, align_views, analyse_views

KEY = jax.random.key(5)
SIDE = 32


def draw(seed: int, sigma: tuple[float, float], side: int = 64) -> np.ndarray:
    """Coloured grain, drawn out by so many pixels along rows and columns."""
    noise = np.random.default_rng(seed).normal(size=(side, side, 3))
    smooth = gaussian_filter(noise, (*sigma, 0), mode="wrap")
    smooth = smooth / smooth.std(axis=(0, 1)) + 0.1 * noise  # as photographs, of no frequency nothing
    mixed = smooth @ np.array([[0.1, 0.08, 0.05], [0.02, 0.0, 0.03], [0.0, 0.01, 0.0]])
    return np.clip(mixed + np.array([0.5, 0.4, 0.3]), 0, 1)


def spread(block: np.ndarray) -> np.ndarray:
    """How much neighbours differ along z, y and x, as a share of the spread of all values."""
    steps = [np.square(block - np.roll(block, 1, axis)).mean() for axis in range(3)]
    return np.sqrt(np.array(steps) / block.var())


@pytest.fixture(scope="module")
def grain() -> np.ndarray:
    """Long along x: view xy and view xz show lines, view yz dots."""
    lines, dots = draw(0, (0.7, 6)), draw(1, (0.7, 0.7))
    return relax_solid({"xy": lines, "xz": draw(2, (0.7, 6)), "yz": dots}, SIDE, key=KEY)


def test_grain_runs_where_the_views_say(grain: np.ndarray) -> None:
    along_z, along_y, along_x = spread(grain)
    assert along_x < 0.5 * min(along_y, along_z)
    assert along_y == pytest.approx(along_z, rel=0.15)


def test_turned_views_make_the_turned_block() -> None:
    """Figure 5: lines along y rather than x, and with two views the third axis as these make it."""
    block = relax_solid({"xy": draw(0, (6, 0.7)), "yz": draw(2, (0.7, 6))}, SIDE, key=KEY)
    along_z, along_y, along_x = spread(block)
    assert along_y < 0.5 * min(along_z, along_x)


def test_statistics_are_the_views() -> None:
    pictures = {"xy": draw(0, (1, 3)), "xz": draw(1, (1, 3)), "yz": draw(2, (1, 1))}
    views = align_views(pictures, SIDE, shared=True)
    *_, last = relax_steps(views.pictures, SIDE, key=KEY)
    for name, statistics in analyse_views(views.pictures, SIDE, key=jax.random.fold_in(KEY, 0)).items():
        inside, apart = measure_axis(last.voxels, statistics, AXES[name])
        # Of a crop that is held out, all but two frequencies in CROPS are in the range of the others.
        assert float(inside.min()) > 1 - 2 / CROPS - 0.05
        assert float(apart.max()) < 0.01


def test_blocks_go_on_at_their_faces(grain: np.ndarray) -> None:
    for axis in range(3):
        steps = np.square(np.diff(grain, axis=axis)).mean(axis=tuple(set(range(4)) - {axis}))
        across = np.square(np.take(grain, 0, axis) - np.take(grain, -1, axis)).mean()
        assert across < 1.3 * steps.max()


def test_colours_stay_those_of_the_views(grain: np.ndarray) -> None:
    pixels = draw(0, (0.7, 6)).reshape(-1, 3)
    np.testing.assert_allclose(grain.reshape(-1, 3).mean(axis=0), pixels.mean(axis=0), atol=0.03)
    np.testing.assert_allclose(np.cov(grain.reshape(-1, 3).T), np.cov(pixels.T), atol=0.003)


def test_the_same_key_makes_the_same_block(grain: np.ndarray) -> None:
    pictures = {"xy": draw(0, (2, 1)), "xz": draw(2, (1, 1))}
    first, second, other = (relax_solid(pictures, 12, key=jax.random.key(seed), iterations=2) for seed in (0, 0, 1))
    np.testing.assert_array_equal(first, second)
    assert np.abs(first - other).max() > 0.05


@pytest.mark.parametrize(("side", "channels"), [(15, 1), (16, 4)])
def test_any_side_and_number_of_channels(side: int, channels: int) -> None:
    picture = np.random.default_rng(0).random((20, 31, channels))
    block = relax_solid({"xz": picture}, side, key=KEY, iterations=1)
    assert block.shape == (side, side, side, channels)
    assert np.isfinite(block).all()


def test_views_with_different_histograms_meet_half_way() -> None:
    dark, light = draw(0, (1, 1)) * 0.5, draw(1, (1, 1))
    views = align_views({"xy": dark, "xz": light}, SIDE)
    assert views.shared
    assert views.apart > 0.1
    statistics = analyse_views(views.pictures, SIDE, key=KEY)
    cumulative = [np.asarray(each.cumulative) for each in statistics.values()]
    np.testing.assert_allclose(cumulative[0], cumulative[1], atol=0.03)
    assert not align_views({"xy": dark, "xz": dark}, SIDE).shared


def test_blocks_stop_when_they_change_no_more() -> None:
    views = align_views({"xy": draw(0, (1, 1))}, 16)
    steps = list(relax_steps(views.pictures, 16, key=KEY, iterations=50))
    assert 3 <= len(steps) < 50
    assert [step.done for step in steps] == list(range(1, len(steps) + 1))


def test_independent_channels_become_colours() -> None:
    pictures = {"xy": draw(0, (1, 1)), "yz": draw(1, (1, 1))}
    views = align_views(pictures, 16)
    colours = np.random.default_rng(3).uniform(0.3, 0.5, (4, 4, 4, 3))
    channels = jnp.asarray(np.moveaxis((colours - views.mean) @ views.basis, -1, 0))
    np.testing.assert_allclose(views.to_voxels(channels), colours, atol=1e-5)


def draw_hue(seed: int) -> np.ndarray:
    """Grain of one hue: how light it is tells the colour, along a curve."""
    light = draw(seed, (1, 3))[..., :1]
    light = (light - light.min()) / np.ptp(light)
    return 0.1 + 0.8 * np.concatenate([light**0.7, light, light**1.6], axis=2)


def test_one_hue_is_met_by_one_channel() -> None:
    """The colours are on the views' curve, as far from their neighbours as with three channels, and as often there."""
    pictures = {"xy": draw_hue(0), "yz": draw_hue(1)}
    views = align_views(pictures, SIDE, colours="single-hue")
    assert [each.shape[2] for each in views.pictures.values()] == [1, 1]
    one, three = (relax_solid(pictures, SIDE, key=KEY, colours=each) for each in ("single-hue", "decorrelated"))
    light = (one[..., 1] - 0.1) / 0.8
    np.testing.assert_allclose((one[..., 0] - 0.1) / 0.8, light**0.7, atol=0.02)
    np.testing.assert_allclose((one[..., 2] - 0.1) / 0.8, light**1.6, atol=0.02)
    np.testing.assert_allclose(spread(one), spread(three), rtol=0.1)
    shares = np.linspace(0.02, 0.98, 9)
    for channel in range(3):
        wanted = np.quantile(np.stack(list(pictures.values()))[..., channel], shares)
        np.testing.assert_allclose(np.quantile(one[..., channel], shares), wanted, atol=0.03)


def test_grey_pictures_are_of_one_hue() -> None:
    picture = draw(0, (1, 3))[..., :1]
    for pixels in (picture, np.repeat(picture, 3, axis=2)):
        views = align_views({"xy": pixels}, SIDE, colours="single-hue")
        channels = (picture - picture.mean()).reshape(1, *picture.shape[:2], 1) * np.sqrt(pixels.shape[2])
        as_given = views.to_voxels(jnp.asarray(channels))
        np.testing.assert_allclose(as_given[:, :, 0], pixels, atol=1e-6)
        made = relax_solid({"xy": pixels}, SIDE, key=KEY, colours="single-hue", iterations=2)
        np.testing.assert_allclose(made, np.broadcast_to(made[..., :1], made.shape), atol=1e-6)
        np.testing.assert_allclose([made.mean(), made.std()], [picture.mean(), picture.std()], rtol=0.03)


def test_of_two_hues_one_channel_loses_one() -> None:
    """Red and green spots, as light as each other, on black and white grain."""
    light = draw(0, (1, 1)).mean(axis=2, keepdims=True)
    hue = np.where(draw(3, (2, 2))[..., :1] > 0.5, 0.05, -0.05)
    picture = np.concatenate([light + hue, light - hue, light], axis=2)
    one, three = (relax_solid({"xy": picture}, SIDE, key=KEY, colours=each) for each in ("single-hue", "decorrelated"))
    assert (three[..., 0] - three[..., 1]).std() == pytest.approx((2 * hue).std(), rel=0.1)
    assert (one[..., 0] - one[..., 1]).std() < 0.4 * (2 * hue).std()


def test_values_that_no_pixel_has_are_coloured_between_those_that_have() -> None:
    light = (
        np.where(np.indices((24, 24)).sum(axis=0) % 2, 0.1, 0.9)[..., None] + np.linspace(0, 0.01, 24)[:, None, None]
    )
    picture = np.concatenate([light, light**2], axis=2)
    palette = align_views({"xy": picture}, 16, colours="single-hue").palette
    assert palette is not None
    red, green = palette.colours.T
    assert (np.diff(palette.colours, axis=0) > 0).all()
    middle = np.interp(0.5, red, green)
    assert middle == pytest.approx(0.41, abs=0.02)  # half-way between 0.01 and 0.81, not 0.25
    assert abs(np.diff(green, 2)).max() < 1e-3


GRAIN = np.random.default_rng(0).random((20, 20, 3))
SPECK = np.where(np.indices((400, 400)).min(axis=0)[..., None] > 398, GRAIN[0, 0], 1.0)


@pytest.mark.parametrize(
    ("views", "options", "complaint"),
    [
        ({}, {}, "at least one of xy, xz and yz"),
        ({"zx": GRAIN}, {}, "at least one of xy, xz and yz"),
        ({"xy": GRAIN, "xz": GRAIN[..., :1]}, {}, "give as many in each"),
        ({"xy": GRAIN, "xz": GRAIN[:12]}, {}, "view xz of 20 x 12 pixels: .* block of at most 9"),
        ({"xy": GRAIN, "xz": np.full((20, 20, 3), 0.4)}, {}, "view xz: is all of one colour"),
        ({"xy": np.where(GRAIN > 0.9, np.nan, GRAIN)}, {}, "view xy: some values are NaN"),
        ({"xy": SPECK}, {}, "view xy: its crops of 16 x 16 pixels are all of one colour"),
        ({"xy": GRAIN}, {"crops": 1}, "crops: 1"),
        ({"xy": GRAIN}, {"iterations": 0}, "iterations: 0"),
        ({"xy": GRAIN}, {"side": 3}, "side: 3"),
        ({"xy": GRAIN}, {"colours": "rgb"}, "colours: 'rgb' is none of decorrelated, single-hue"),
    ],
)
def test_what_cannot_be_made_is_told(views: dict, options: dict, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        relax_solid(views, **{"side": 16, "key": KEY, **options})
