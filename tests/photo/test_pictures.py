"""What counts as a picture, and where its colours lie for the eye."""

import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.photo.pictures import check_picture, lightness, luminance, to_lab


@pytest.mark.parametrize("shape", [(3, 5), (3, 5, 1), (3, 5, 3)])
def test_pictures_of_one_and_three_channels_become_three_dimensional(shape: tuple[int, ...]) -> None:
    checked = check_picture(np.ones(shape, np.uint8))
    assert checked.dtype == np.float32
    assert checked.shape == (3, 5, 3 if shape[-1] == 3 else 1)


@pytest.mark.parametrize(
    ("pixels", "told"),
    [
        (np.zeros(5), r"shape .*not \[5\]"),
        (np.zeros((4, 4, 2)), r"not \[4, 4, 2\]"),
        (np.zeros((4, 4, 4)), r"not \[4, 4, 4\]"),
        (np.zeros((0, 4)), "holds no pixels"),
        (np.zeros((4, 4), complex), "real numbers, not complex128"),
        (np.array([["a"]]), "real numbers"),
        (np.array([[0.0, 1.0], [np.nan, np.inf]]), "2 values are NaN or infinite, the first at row 1, column 0"),
    ],
)
def test_what_is_no_picture_is_refused(pixels: np.ndarray, told: str) -> None:
    with pytest.raises(InputError, match=told):
        check_picture(pixels)


@pytest.mark.parametrize(
    ("colour", "lab"),
    [  # published values of the sRGB primaries under D65
        ((1, 0, 0), (53.24, 80.09, 67.20)),
        ((0, 1, 0), (87.74, -86.18, 83.18)),
        ((0, 0, 1), (32.30, 79.19, -107.86)),
        ((1, 1, 1), (100, 0, 0)),
        ((0, 0, 0), (0, 0, 0)),
    ],
)
def test_primaries_have_their_published_place_in_lab(colour: tuple[int, ...], lab: tuple[float, ...]) -> None:
    pixels = np.array(colour, float).reshape(1, 1, 3)
    assert to_lab(pixels)[0, 0] == pytest.approx(lab, abs=0.05)
    assert lightness(pixels)[0, 0] == pytest.approx(lab[0], abs=0.05)


def test_grey_is_the_same_in_one_channel_and_in_three() -> None:
    grey = np.linspace(0, 1.5, 50).reshape(5, 10)
    three = np.repeat(grey[..., None], 3, axis=2)
    assert np.allclose(luminance(grey), luminance(three), atol=1e-6)
    assert np.allclose(to_lab(grey), to_lab(three), atol=0.02)


def test_lightness_grows_with_light_also_below_black() -> None:
    light = lightness(np.linspace(-0.01, 1, 1000)[None])
    assert (np.diff(light) > 0).all()
