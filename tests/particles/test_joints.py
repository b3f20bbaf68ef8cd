"""Things found by the joints between them, and rated."""

import numpy as np
import pytest
from scipy import ndimage

from jaxtex.particles.joints import find_by_joints, make_levels, rate_things
from jaxtex.particles.kinds import class_things
from jaxtex.particles.rating import fit_logistic, multiply_out
from jaxtex.particles.segmentation import find_particles
from jaxtex.photo.pictures import to_lab


def pack_stones(seed: int, side: int = 160, apart: float = 26) -> tuple[np.ndarray, np.ndarray]:
    """Stones as light as a deep joint's rim, of many colours, the joints dark: no one ground tells them all."""
    rng = np.random.default_rng(seed)
    grid = np.stack(np.meshgrid(*[np.arange(apart / 2, side, apart)] * 2, indexing="ij"), axis=-1).reshape(-1, 2)
    middles = grid + rng.uniform(-0.15, 0.15, grid.shape) * apart
    places = np.moveaxis(np.indices((side, side)) + 0.5, 0, 2)
    away = np.linalg.norm(places[:, :, None] - middles, axis=3)
    near = np.sort(away, axis=2)
    stone = away.argmin(axis=2)
    inside = near[..., 1] - near[..., 0] > 5
    colours = np.exp(rng.normal(-1.6, 0.6, (len(middles), 1)) + rng.normal(0, 0.2, (len(middles), 3)))
    rough = ndimage.gaussian_filter(rng.normal(size=(side, side)), 1) * 0.3
    pixels = np.where(inside[..., None], colours[stone], 0.03) * np.exp(rough)[..., None]
    return np.clip(pixels, 0, 1), np.where(inside, stone + 1, 0)


@pytest.mark.parametrize("seed", [0, 1])
def test_packed_stones_light_and_dark_are_found(seed: int) -> None:
    pixels, stones = pack_stones(seed)
    found = find_particles(pixels)
    assert abs(len(found.particles) - stones.max()) <= 0.1 * stones.max()
    overlaps = []
    for number in range(1, stones.max() + 1):
        own = stones == number
        most = np.bincount(found.labels[own]).argmax()
        other = found.labels == most
        overlaps.append((own & other).sum() / (own | other).sum() if most else 0)
    assert np.median(overlaps) > 0.75


def test_true_things_gain_more_than_halves_and_than_pairs_of_them() -> None:
    pixels, stones = pack_stones(2)
    lab = to_lab(pixels)
    levels = make_levels(lab)
    true = rate_things(stones.astype(np.int32), levels)
    halves = np.where(stones > 0, 2 * stones - (np.indices(stones.shape)[1] // 13 % 2), 0)
    pairs = (ndimage.grey_dilation(stones, 7) + 1) // 2  # over the joints between them
    assert true > 0
    assert true > rate_things(halves.astype(np.int32), levels)
    assert true > rate_things(pairs.astype(np.int32), levels)
    assert rate_things(np.zeros_like(stones, np.int32), levels) == 0
    assert find_by_joints(lab, levels)[1] > 0.5 * true


def test_kinds_are_as_many_as_are_asked_for_and_go_by_colour() -> None:
    labels = np.arange(12, dtype=np.int32).reshape(3, 4)
    lab = np.zeros((3, 4, 3), np.float32)
    lab[..., 0] = 20 + 60 * (labels % 2) + np.random.default_rng(0).normal(size=labels.shape)
    assert len(set(class_things(lab, labels)[::2])) == 1
    assert class_things(lab, labels).max() == 1
    assert class_things(lab, labels, 1).max() == 0


def test_logistic_regression_finds_the_weights() -> None:
    rng = np.random.default_rng(4)
    products = multiply_out(rng.normal(size=(4000, 2)))
    assert products.shape[1] == 6
    weights = rng.normal(size=6)
    shares = 1 / (1 + np.exp(-products @ weights))
    assert fit_logistic(products, shares, np.ones(4000), 1e-9, 30) == pytest.approx(weights, abs=1e-3)
