"""All methods of synthesis in one form."""

from typing import get_args

import jax
import numpy as np
import pytest

from jaxtex.cli import synth
from jaxtex.synthesis.heeger_bergen import analyse_texture, synthesise_texture
from jaxtex.synthesis.methods import METHODS
from jaxtex.synthesis.quilting import synthesise_quilting

KEY = jax.random.key(3)
SHAPE = (20, 27)


def draw_exemplar(shape: tuple[int, ...]) -> np.ndarray:
    return np.random.default_rng(0).random(shape).astype(np.float32)


def test_they_are_those_of_the_command_line() -> None:
    assert tuple(METHODS) == get_args(synth.Method)


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("name", METHODS)
def test_each_makes_a_texture_of_the_shape(name: str, channels: int) -> None:
    exemplar = draw_exemplar((24, 25, channels))
    pixels, sources = METHODS[name](exemplar, SHAPE, key=KEY)
    assert pixels.shape == (*SHAPE, channels)
    assert pixels.dtype == np.float32
    assert 0 <= pixels.min() < pixels.max() <= 1
    if sources is None:
        assert name == "heeger-bergen"
    else:
        np.testing.assert_array_equal(pixels, exemplar[sources[..., 0], sources[..., 1]])
    again, other = (METHODS[name](exemplar, SHAPE, key=key).pixels for key in (KEY, jax.random.key(4)))
    np.testing.assert_array_equal(again, pixels)
    assert (other != pixels).any()


def test_settings_are_the_methods_own() -> None:
    exemplar = draw_exemplar((24, 25, 3))
    np.testing.assert_array_equal(
        METHODS["quilting"](exemplar, SHAPE, key=KEY).sources, synthesise_quilting(exemplar, SHAPE, key=KEY)
    )
    exemplar = draw_exemplar((64, 70, 3))
    made = synthesise_texture(analyse_texture(exemplar[None]), (64, 64), key=KEY)
    np.testing.assert_allclose(
        METHODS["heeger-bergen"](exemplar, (64, 64), key=KEY).pixels, np.clip(made, 0, 1), atol=1e-6
    )


@pytest.mark.parametrize("name", [name for name in METHODS if name != "heeger-bergen"])
def test_one_pixel_is_too_few_to_copy(name: str) -> None:
    with pytest.raises(ValueError, match=r"1 x 1|\(1, 1"):
        METHODS[name](np.zeros((1, 1, 3)), SHAPE, key=KEY)


def test_of_one_pixel_noise_takes_the_colour() -> None:
    colour = np.array([0.2, 0.5, 0.7], np.float32)
    made = METHODS["heeger-bergen"](colour.reshape(1, 1, 3), SHAPE, key=KEY)
    np.testing.assert_allclose(made.pixels, np.broadcast_to(colour, (*SHAPE, 3)), atol=1e-3)
