"""Evening out: slow light goes, whatever the material looks like, and the material stays."""

import numpy as np
import pytest
from skimage import data

from jaxtex.core.errors import InputError
from jaxtex.photo.illumination import even_out

HEIGHT, WIDTH = 150, 211


def light(height: int = HEIGHT, width: int = WIDTH) -> np.ndarray:
    """A lamp near the upper left: 1 there, about 0.4 far from it."""
    y, x = np.mgrid[:height, :width] / max(height, width)
    return 0.35 + 0.65 * np.exp(-((x - 0.2) ** 2 + (y - 0.15) ** 2) / 0.5)


def tiles(*, joint: float = 0.08, seed: int = 0) -> np.ndarray:
    """Grey-brown tiles of 20 x 12 pixels, each a little different, with joints 2 pixels wide."""
    shades = np.random.default_rng(seed).uniform(0.3, 0.35, (20, 20))
    wall = np.kron(shades, np.ones((12, 20)))[:HEIGHT, :WIDTH]
    wall[np.arange(HEIGHT) % 12 < 2] = joint
    wall[:, np.arange(WIDTH) % 20 < 2] = joint
    return wall[..., None] * (1.0, 0.8, 0.6)


def spread(first: np.ndarray, second: np.ndarray) -> float:
    """Standard deviation of the ratio of two pictures, but for a factor."""
    return float(np.std(np.log(first / second)))


@pytest.mark.parametrize("joint", [0.05, 0.9])
def test_light_changes_nearly_nothing(joint: float) -> None:
    wall, gain = tiles(joint=joint), light()[..., None]
    assert spread(wall * gain, wall) > 0.15
    assert spread(even_out(wall * gain)[0], even_out(wall)[0]) < 0.01


@pytest.mark.parametrize("name", ["brick", "gravel", "grass"])
def test_light_changes_nearly_nothing_on_photographs(name: str) -> None:
    photo = (getattr(data, name)()[::2, ::2] / 255.0) ** 2.2 + 0.01
    assert spread(even_out(photo * light(256, 256))[0], even_out(photo)[0]) < 0.01


def test_the_light_itself_is_found() -> None:
    _, field = even_out(tiles() * light()[..., None])
    assert spread(field, light()) < 0.03


def test_light_lies_where_it_falls_also_on_large_pictures() -> None:
    """Light is estimated on cells of several pixels; half a cell beside would show."""
    x = np.linspace(-1, 1, 500)
    gain = np.exp(-2 * x**2) * np.ones((40, 1))
    _, field = even_out(0.3 * gain)
    assert spread(field[:, 10:-10], gain[:, 10:-10]) < 1e-3


def test_joints_do_not_count_as_shade() -> None:
    """Joints twice as dense on the right half leave the light of the tiles as it is."""
    wall = np.full((HEIGHT, WIDTH), 0.3)
    wall[np.arange(HEIGHT) % 15 < 2] = 0.02
    wall[np.arange(HEIGHT) % 15 < 4, WIDTH // 2 :] = 0.02
    _, field = even_out(wall)
    assert np.ptp(np.log(field)) < 0.01


def test_picture_is_evened_times_light_and_keeps_mean_and_hue() -> None:
    photo = tiles() * light()[..., None]
    evened, field = even_out(photo)
    assert field.shape == (HEIGHT, WIDTH)
    assert evened.dtype == field.dtype == np.float32
    assert np.allclose(evened * field[..., None], photo, rtol=1e-5)
    assert evened.mean() == pytest.approx(photo.mean(), rel=1e-3)
    assert np.allclose(evened[..., 1] / evened[..., 0], 0.8, rtol=1e-5)


def test_a_smaller_scale_follows_faster_light() -> None:
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    photo = tiles() * np.exp(0.3 * np.sin(x / 12) * np.cos(y / 12))[..., None]
    slow, fast = (spread(even_out(photo, scale=scale)[0], tiles()) for scale in (0.25, 0.04))
    assert fast < 0.6 * slow


@pytest.mark.parametrize("shape", [(HEIGHT, WIDTH), (HEIGHT, WIDTH, 1), (1, 1), (1, 40), (3, 2, 3), (700, 15)])
def test_every_shape_comes_back_as_it_was(shape: tuple[int, ...]) -> None:
    photo = np.random.default_rng(0).uniform(0.2, 0.3, shape)
    evened, field = even_out(photo)
    assert evened.shape == shape
    assert field.shape == shape[:2]
    assert np.isfinite(evened).all()
    assert (field > 0).all()


def test_black_parts_say_nothing() -> None:
    photo = tiles() * light()[..., None]
    holed = photo.copy()
    holed[40:70, 60:110] = 0
    full, field = even_out(photo)[1], even_out(holed)[1]
    assert np.isfinite(field).all()
    assert spread(field, full) < 0.02


@pytest.mark.parametrize("scale", [0, 0.01, 11, float("nan")])
def test_scales_out_of_range_are_refused(scale: float) -> None:
    with pytest.raises(InputError, match=r"scale: .* out of range; give 0\.02 to 10"):
        even_out(tiles(), scale=scale)


def test_a_black_picture_is_refused() -> None:
    with pytest.raises(InputError, match="more than half of it is black"):
        even_out(np.zeros((20, 20)))
