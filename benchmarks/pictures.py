"""Pictures made for timing: brick walls with jittered colours, masks with flipped pixels, boards and planks."""

import numpy as np
from numpy.typing import NDArray


def brick_wall(size: int, seed: int = 0) -> NDArray[np.float32]:
    """A linear photograph-like picture [size, size, 3]: running bond, tiles of many colours, grain, slow light."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:size, 0:size] + 0.5
    clear, course, tile = _lay(x, y, width=size / 8.3, height=size / 22.7, offset=0.5, joint=size / 170, angle=0.01)
    tones = rng.normal(1.0, 0.15, (64, 64))[course % 64, tile % 64][..., None]
    brick = np.array([0.30, 0.11, 0.07]) * tones
    wall = np.where(clear[..., None], brick, np.array([0.42, 0.40, 0.37]))
    light = 0.8 + 0.3 * x / size
    grain = rng.normal(1.0, 0.08, (size, size))
    return np.clip(wall * (light * grain)[..., None], 0.0, 1.0).astype(np.float32)


def noisy_masks(count: int, size: int, seed: int = 0) -> NDArray[np.float32]:
    """Masks [count, size, size] of random tilings, with one pixel of twenty flipped."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:size, 0:size] + 0.5
    masks = []
    for _ in range(count):
        width = rng.uniform(24, 48)
        clear, _, _ = _lay(
            x, y, width=width, height=rng.uniform(0.4, 0.6) * width, offset=rng.choice([0.0, 0.5, 0.3]),
            joint=rng.uniform(2, 4), angle=rng.uniform(-0.3, 0.3),
        )  # fmt: skip
        masks.append(clear ^ (rng.random(clear.shape) < 0.05))
    return np.array(masks, np.float32)


def wooden_board(size: int, seed: int = 0) -> NDArray[np.float32]:
    """A linear photograph-like picture [size, size, 3]: uneven, wavy rings, fibres, slow light."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:size, 0:size] + 0.5
    edges = np.cumsum(rng.uniform(0.6, 1.4, 200) * size / 24)
    level = x + 0.1 * y + size / 60 * (np.cos(y * 7 / size) + np.cos((y * 11 + x * 5) / size))
    part = np.interp(level + size / 20, edges, np.arange(200.0)) % 1
    # Fibres run along the trunk: noise that a Gaussian draws out in that direction.
    fibres = rng.normal(size=(size, size))
    spectrum = np.fft.rfft2(fibres)
    along = np.fft.fftfreq(size)[:, None] - 0.1 * np.fft.rfftfreq(size)[None]
    fibres = np.fft.irfft2(spectrum * np.exp(-2 * (np.pi * 12 * along) ** 2), (size, size))
    tone = (1 - 0.45 * part**3) * (1 + 0.05 * fibres / fibres.std()) + rng.normal(0, 0.02, (size, size))
    light = 0.8 + 0.3 * x / size
    return np.clip((tone * light)[..., None] * np.array([0.55, 0.33, 0.17]), 0.0, 1.0).astype(np.float32)


def drawn_planks(count: int, size: int, seed: int = 0) -> NDArray[np.float32]:
    """Planks [count, size, size, 3] as clean as drawings: the model's two colours, no turbulence."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:size, 0:size] + 0.5 - size / 2
    planks = []
    for _ in range(count):
        turn, lean = rng.uniform(0, np.pi), np.sin(rng.uniform(0.03, 0.3))
        across, along = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
        radius = np.hypot(across - rng.uniform(-0.4, 0.4) * size, along * lean - rng.uniform(-0.2, 0.2) * size)
        early = np.sin(2 * np.pi * radius / rng.uniform(8, 14)) > np.cos(np.pi * rng.uniform(0.4, 0.7))
        planks.append(np.where(early[..., None], [0.55, 0.33, 0.17], [0.27, 0.13, 0.06]))
    return np.array(planks, np.float32)


def _lay(
    x: NDArray, y: NDArray, *, width: float, height: float, offset: float, joint: float, angle: float
) -> tuple[NDArray[np.bool_], NDArray[np.int64], NDArray[np.int64]]:
    along, across = np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x
    course = np.floor(across / height)
    at = along / width - offset * course
    tile = np.floor(at)
    head, bed = (at - tile) * width, across - course * height
    clear = (np.minimum(head, width - head) > joint / 2) & (np.minimum(bed, height - bed) > joint / 2)
    return clear, course.astype(int), tile.astype(int)
