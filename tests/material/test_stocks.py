"""Stocks of grain, wobble and relief: what was asked of them is in them."""

import jax
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from jaxtex.core.pyramids import most_scales
from jaxtex.material import stocks as module
from jaxtex.material.stocks import (
    SIDES_OF_STOCKS,
    choose_side,
    choose_slope,
    make_grain,
    make_wobble,
    relief_of,
)

KEY = jax.random.key(5)
SMOOTH = 1.2  # pixels: of the examples' grain
ONE = (1.0, 1.0)


def draw_examples(regions=6, height=48, width=48, *, seed=0):
    """Grain with a skewed distribution, reddish, around 0, that is smooth over a pixel or so."""
    noise = np.random.default_rng(seed).normal(size=(regions, height, width))
    smooth = gaussian_filter(noise, (0, SMOOTH, SMOOTH), mode="wrap")
    grain = np.exp(smooth / smooth.std() * 0.6)
    grain = 0.05 * (grain - grain.mean()) / grain.std()
    return (grain[..., None] * [1.0, 0.8, 0.5]).astype(np.float32)


@pytest.fixture(scope="module")
def stock():
    return make_grain(draw_examples(), ONE, 256, key=KEY)


def test_sides_hold_the_tiles_and_are_few():
    for height, width in [(1, 1), (20, 60), (100, 100), (50, 700), (1000, 1000), (9000, 9000)]:
        side = choose_side(height, width)
        assert side in SIDES_OF_STOCKS
        if side < SIDES_OF_STOCKS[-1]:
            assert side >= 1.25 * max(height, width)
            assert side**2 >= 8 * height * width
            smaller = [each for each in SIDES_OF_STOCKS if each < side]
            assert all(each < 1.25 * max(height, width) or each**2 < 8 * height * width for each in smaller)
    assert choose_side(20, 60) == choose_side(60, 20)
    assert choose_side(9000, 9000) == 2048


def skew(values):
    return np.mean((values - values.mean()) ** 3) / values.std() ** 3


def assert_like(stock, examples, *, rel=0.1):
    own, made = examples.reshape(-1, 3), stock.reshape(-1, 3)
    np.testing.assert_allclose(made.mean(axis=0), own.mean(axis=0), atol=0.004)
    np.testing.assert_allclose(np.cov(made.T), np.cov(own.T), rtol=2 * rel, atol=1e-5)
    assert skew(made[:, 0]) == pytest.approx(skew(own[:, 0]), rel=0.2)
    for axis in (0, 1):
        expected = np.diff(examples[..., 0], axis=axis + 1).std()
        assert np.diff(stock[..., 0], axis=axis).std() == pytest.approx(expected, rel=rel + 0.05)


def test_stocks_have_the_statistics_of_their_examples(stock):
    assert stock.shape == (256, 256, 3)
    assert_like(stock, draw_examples())


def test_stocks_repeat_without_a_seam(stock):
    for axis in (0, 1):
        within = np.diff(stock, axis=axis).std()
        across = (np.take(stock, 0, axis) - np.take(stock, -1, axis)).std()
        assert across == pytest.approx(within, rel=0.25)


def test_another_key_gives_another_stock_and_the_same_the_same(stock):
    assert np.array_equal(make_grain(draw_examples(), ONE, 256, key=KEY), stock)
    other = make_grain(draw_examples(), ONE, 256, key=jax.random.key(6))
    assert abs(np.corrcoef(other[..., 0].ravel(), stock[..., 0].ravel())[0, 1]) < 0.05


def test_at_half_the_size_stocks_are_like_the_examples_averaged():
    examples = draw_examples(height=96, width=96)
    halved = examples.reshape(6, 48, 2, 48, 2, 3).mean(axis=(2, 4))
    assert_like(make_grain(examples, (2.0, 2.0), 256, key=KEY), halved, rel=0.15)


def test_pixels_that_are_not_square_stretch_the_grain():
    stock = make_grain(draw_examples(height=48, width=96), (2.0, 1.0), 256, key=KEY)
    along, across = (np.diff(stock[..., 0], axis=axis).std() for axis in (1, 0))
    own = draw_examples(height=48, width=96)[..., 0]
    assert across == pytest.approx(np.diff(own, axis=1).std(), rel=0.15)
    assert along == pytest.approx(np.diff(own[:, :, ::2], axis=2).std(), rel=0.2)


def test_at_twice_the_size_grain_is_as_strong_and_finer(stock):
    finer = make_grain(draw_examples(), (0.5, 0.5), 256, key=KEY)
    assert finer.std() == pytest.approx(stock.std(), rel=0.25)
    coarse = finer.reshape(128, 2, 128, 2, 3).mean(axis=(1, 3))
    expected = np.diff(stock[..., 0], axis=0).std()
    assert np.diff(coarse[..., 0], axis=0).std() == pytest.approx(expected, rel=0.3)


@pytest.mark.parametrize("shape", [(0, 1, 1, 3), (3, 4, 4, 3), (2, 1, 200, 3)])
def test_without_examples_to_speak_of_there_is_no_grain(shape):
    stock = make_grain(np.ones(shape, np.float32), ONE, 256, key=KEY)
    assert stock.shape == (256, 256, 3)
    assert not stock.any()
    assert not make_grain(draw_examples(2, 16, 16), (8.0, 8.0), 256, key=KEY).any()


@pytest.mark.parametrize(
    ("deviation", "length", "pixel"), [(1.5, 6.0, ONE), (0.4, 8.0, (0.5, 0.5)), (2.0, 10.0, (1.0, 0.5))]
)
def test_wobble_strays_and_hangs_together_as_asked(deviation, length, pixel):
    field = make_wobble(deviation, length, pixel, 512, key=KEY)
    assert field.shape == (512, 512)
    assert field.std() == pytest.approx(deviation, rel=0.05)
    assert np.abs(field).max() <= 2.5 * deviation * 1.0001
    for axis, step in ((1, pixel[0]), (0, pixel[1])):
        far = round(length / step)
        correlation = np.mean(field * np.roll(field, far, axis)) / np.mean(field**2)
        assert correlation == pytest.approx(np.exp(-far * step / length), abs=0.12)


def test_no_wobble_is_none():
    assert not make_wobble(0.0, 5.0, ONE, 256, key=KEY).any()


def test_relief_is_as_steep_as_asked_and_dark_is_deep(stock):
    relief = relief_of(stock, [draw_examples()], 0.2)
    slopes = [np.roll(relief, -1, axis) - relief for axis in (0, 1)]
    assert np.sqrt(np.mean(np.square(slopes).sum(axis=0))) == pytest.approx(0.2, rel=0.15)
    assert np.corrcoef(relief.ravel(), stock.mean(axis=2).ravel())[0, 1] > 0.9
    np.testing.assert_allclose(relief_of(stock, [draw_examples()], 0.4), 2 * relief, rtol=1e-4, atol=1e-6)


def test_no_slope_and_no_examples_are_flat(stock):
    assert not relief_of(stock, [draw_examples()], 0.0).any()
    assert not relief_of(stock, [np.zeros((0, 1, 1, 3), np.float32)], 0.2).any()
    assert not relief_of(np.zeros_like(stock), [np.zeros((1, 9, 9, 3), np.float32)], 0.2).any()


def test_slopes_follow_the_contrast_up_to_a_limit():
    grain = draw_examples()
    slope = choose_slope([grain])
    assert 0 < slope < choose_slope([2 * grain]) <= choose_slope([100 * grain]) == 0.25
    assert choose_slope([np.zeros((0, 1, 1, 3))]) == choose_slope([np.zeros((1, 9, 9, 3))]) == 0
    assert slope == round(slope, 3)


@pytest.mark.parametrize("octaves", [1, 5, 6, 9, 12])
def test_a_tile_may_be_seen_at_any_size(octaves, monkeypatch):
    asked = []

    def synthesise(statistics, shape, *, key, finer):
        asked.append((statistics.scales, finer))
        return np.zeros((*shape, 3), np.float32)

    monkeypatch.setattr(module, "synthesise_texture", synthesise)
    make_grain(draw_examples(1, 16, 16), (2.0**-octaves, 2.0**-octaves), 256, key=KEY)
    ((scales, finer),) = asked
    assert scales >= 0
    assert scales + finer <= most_scales((256, 256))
    assert finer == min(octaves, most_scales((256, 256)))
