"""Maps of normals: what their numbers mean."""

import numpy as np
import pytest

from jaxtex.progressive.normal_maps import is_signed

_RNG = np.random.default_rng(0)


def _bumps() -> np.ndarray:
    slopes = _RNG.normal(0, 0.4, (20, 24, 2))
    normals = np.concatenate([slopes, np.ones((20, 24, 1))], axis=2)
    return normals / np.linalg.norm(normals, axis=2, keepdims=True)


FLAT = np.broadcast_to([0.0, 0.0, 1.0], (20, 24, 3))
SLOPE = np.broadcast_to([0.6, 0.0, 0.8], (20, 24, 3))


@pytest.mark.parametrize("normals", [FLAT, SLOPE, np.abs(_bumps()), _bumps()])
def test_how_they_are_written_shows_by_their_lengths(normals: np.ndarray) -> None:
    assert is_signed(normals)
    encoded = 0.5 + 0.5 * normals
    encoded[0, 0] = -0.01  # as filters with negative lobes leave it
    assert not is_signed(encoded)
