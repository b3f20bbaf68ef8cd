"""Rings that close or turn back are followed around their tips, and rings that run through are left alone."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from jaxtex.photo.figure import follow_figure

Array = NDArray[np.float64]

SHAPE = 200, 260


def lay(turn: float) -> tuple[Array, Array]:
    v, u = np.indices(SHAPE) + 0.5 - np.array(SHAPE).reshape(2, 1, 1) / 2
    return u * np.cos(turn) + v * np.sin(turn), v * np.cos(turn) - u * np.sin(turn)


def draw(level: Array, turn: float, seed: int) -> Array:
    """Rings 12 pixels wide among fibres that run along the grain wherever rings go."""
    noise = np.random.default_rng(seed).normal(size=SHAPE)
    steps = range(-12, 13)
    fibres = np.sum([ndimage.shift(noise, (s * np.cos(turn), -s * np.sin(turn)), order=1) for s in steps], axis=0)
    return np.sin(2 * np.pi * level / 12) + 0.5 * fibres / fibres.std()


def correlate(ours: Array, drawn: Array) -> float:
    """How well one map tells the other, whichever way it climbs."""
    inner = np.s_[20:-20, 20:-20]
    return abs(float(np.corrcoef(ours[inner].ravel(), drawn[inner].ravel())[0, 1]))


@pytest.mark.parametrize("turn", [0.0, np.pi / 2, 0.5])
@pytest.mark.parametrize("seed", [0, 1])
def test_rings_close_around_their_middle(turn: float, seed: int) -> None:
    across, along = lay(turn)
    level = np.hypot(across - 10, 0.25 * (along + 15))
    ours = follow_figure(draw(level, turn, seed), turn)
    assert correlate(ours, level) > 0.93
    # The middle is the lowest or the highest of all.
    middle = np.hypot(across - 10, 0.25 * (along + 15)) < 4
    ring = np.abs(level - 30) < 2
    apart = ours[ring] - ours[middle].mean()
    assert (np.sign(apart) == np.sign(apart.mean())).all()


@pytest.mark.parametrize("turn", [0.0, 1.1])
def test_rings_turn_back_at_a_tip(turn: float) -> None:
    """The cathedral of a board: V's that stand in one another and are open to one side."""
    across, along = lay(turn)
    level = np.hypot(across, 25) - 0.3 * along
    ours = follow_figure(draw(level, turn, 0), turn)
    assert correlate(ours, level) > 0.9


@pytest.mark.parametrize("turn", [0.0, 0.7, 2.5])
def test_straight_grain_climbs_one_way(turn: float) -> None:
    across, along = lay(turn)
    level = across + 4 * np.cos(along / 40)
    ours = follow_figure(draw(level, turn, 0), turn)
    assert correlate(ours, level) > 0.99
    down, right = np.gradient(ours)
    outwards = (right * np.cos(turn) + down * np.sin(turn) > 0).mean()
    assert min(outwards, 1 - outwards) < 0.02
    # By a pixel a pixel.
    assert abs(np.median(np.abs(right * np.cos(turn) + down * np.sin(turn))) - 1) < 0.2
