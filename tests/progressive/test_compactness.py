import numpy as np
import pytest
from scipy import ndimage

from jaxtex.progressive.compactness import SPECK, keep_compact, measure_raggedness


def ellipse(length: float, width: float, turn: float, side: int = 96) -> np.ndarray:
    row, column = np.indices((side, side)) - 0.5 * (side - 1)
    along, across = np.cos(turn) * column + np.sin(turn) * row, np.cos(turn) * row - np.sin(turn) * column
    return np.hypot(along / length, across / width) < 1


@pytest.mark.parametrize("turn", [0.0, 0.3, 0.8])
@pytest.mark.parametrize("axes", [(20.0, 20.0), (36.0, 18.0), (40.0, 10.0)])
def test_raggedness_is_that_of_ellipses(axes: tuple[float, float], turn: float) -> None:
    angles = np.linspace(0, 2 * np.pi, 10_000)
    perimeter = np.hypot(*np.diff([axes[0] * np.cos(angles), axes[1] * np.sin(angles)])).sum()
    true = perimeter**2 / (4 * np.pi**2 * axes[0] * axes[1])
    assert measure_raggedness(ellipse(*axes, turn).astype(int))[1] == pytest.approx(true, rel=0.12)


def test_elements_that_touch_are_measured_each() -> None:
    alone = ellipse(20, 20, 0).astype(int)
    both = np.concatenate([alone[:, 28:68], 2 * alone[:, 28:68]], axis=1)
    assert measure_raggedness(both)[1:] == pytest.approx(measure_raggedness(alone)[1], rel=0.01)


def test_specks_have_no_shape() -> None:
    specks = np.zeros((9, 9), int)
    specks[1, 1 : SPECK - 1], specks[5, 1 : SPECK + 1] = 1, 2
    assert measure_raggedness(specks)[1] == 0
    assert measure_raggedness(specks)[2] > 0


def blobs(seed: int) -> np.ndarray:
    noise = ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=(96, 96)), 3)
    return noise > 0.3 * noise.std()


@pytest.mark.parametrize("seed", range(3))
def test_what_is_compact_enough_stays(seed: int) -> None:
    mask = blobs(seed)
    ragged = measure_raggedness(ndimage.label(mask)[0]).max()
    np.testing.assert_array_equal(keep_compact(mask, np.full(mask.shape, 1.001 * ragged)), mask)
    np.testing.assert_array_equal(keep_compact(mask, np.full(mask.shape, np.inf)), mask)


@pytest.mark.parametrize("seed", range(3))
def test_elements_become_compact_and_cover_as_much(seed: int) -> None:
    mask = blobs(seed)
    made = keep_compact(mask, np.full(mask.shape, 2.0))
    assert measure_raggedness(ndimage.label(mask)[0]).max() > 4
    assert measure_raggedness(ndimage.label(made)[0]).max() < 2.2
    assert made.mean() == pytest.approx(mask.mean(), rel=0.1)


def test_only_where_it_is_wanted() -> None:
    """Two pairs of disks, each with a bridge: one may stay, the other may not."""
    row, column = np.indices((40, 80))
    pair = (np.hypot(row - 20, np.abs(column - 40) - 20) < 12) | ((np.abs(row - 20) < 2) & (np.abs(column - 40) < 20))
    most = np.concatenate([np.full(pair.shape, 9.0), np.full(pair.shape, 1.3)])
    made = keep_compact(np.concatenate([pair, pair]), most)
    np.testing.assert_array_equal(made[:40], pair)
    assert ndimage.label(made[40:])[1] == 2


def test_shapes_must_be_alike() -> None:
    with pytest.raises(ValueError, match="give both"):
        keep_compact(np.ones((4, 5), bool), np.ones((5, 4)))
