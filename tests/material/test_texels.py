"""Which triangle each texel shows, and what stands beside charts."""

import numpy as np
import pytest
from scipy import spatial

from jaxtex.material.texels import REACH, find_faces, locate, spread_colours

SIDE = 24


def draw_triangles(seed: int) -> np.ndarray:
    """Eight triangles, some of them beyond the picture, one a sliver and one without an area."""
    random = np.random.default_rng(seed)
    corners = random.uniform(-4, SIDE + 4, (8, 1, 2)) + random.uniform(-6, 6, (8, 3, 2))
    corners[6, 2] = corners[6, :2].mean(axis=0) + 0.01
    corners[7, 2] = corners[7, :2].mean(axis=0)
    return corners


def distances_to(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """From points [point, 2] to a triangle, from a fine grid of places on it."""
    a, b = np.meshgrid(np.linspace(0, 1, 120), np.linspace(0, 1, 120))
    a, b = np.where(a + b > 1, 1 - a, a), np.where(a + b > 1, 1 - b, b)
    places = (1 - a - b)[..., None] * corners[0] + a[..., None] * corners[1] + b[..., None] * corners[2]
    return spatial.KDTree(places.reshape(-1, 2)).query(points)[0]


@pytest.mark.parametrize("seed", range(3))
def test_texels_show_the_nearest_triangle(seed: int) -> None:
    corners = draw_triangles(seed)
    *_, found = find_faces(corners, SIDE)
    assert found.done == 1
    row, column = np.indices((SIDE, SIDE)).reshape(2, -1)
    points = np.stack([column, row], axis=1) + 0.5
    distances = np.stack([distances_to(points, triangle) for triangle in corners[:7]])
    for face, to_each in zip(found.faces.ravel(), distances.T, strict=True):
        if face < 0:
            assert to_each.min() > REACH - 0.1
        else:
            assert to_each[face] <= min(to_each.min() + 0.1, REACH + 0.1)


@pytest.mark.parametrize("seed", range(3))
def test_places_are_where_they_are_said_to_be(seed: int) -> None:
    corners = draw_triangles(seed)[:6].repeat(50, axis=0)
    points = np.random.default_rng(seed).uniform(-4, SIDE + 4, (300, 2))
    places = locate(points, corners)
    np.testing.assert_allclose(places.own.sum(axis=1), 1, atol=1e-9)
    np.testing.assert_allclose(np.einsum("pc,pcx->px", places.own, corners), points, atol=1e-6)
    assert places.nearest.min() >= 0
    nearest = np.einsum("pc,pcx->px", places.nearest, corners)
    np.testing.assert_allclose(np.linalg.norm(nearest - points, axis=1), places.beyond, atol=1e-6)
    for point, triangle, beyond in zip(points, corners, places.beyond, strict=True):
        assert beyond == pytest.approx(distances_to(point, triangle), abs=0.1)


def test_progress_is_that_of_what_was_gone_over(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("jaxtex.material.texels._AT_ONCE", 100)
    corner = np.array([[4.0, 4], [8, 4], [4, 8]])
    # Boxes of 8 x 8 texels, with the reach around them.
    assert [found.done for found in find_faces(np.stack([corner] * 4), SIDE)] == [100 / 256, 200 / 256, 1.0]


def test_nothing_is_found_of_triangles_without_an_area() -> None:
    *_, found = find_faces(np.zeros((3, 3, 2)), SIDE)
    assert (found.faces == -1).all()


@pytest.mark.parametrize("side", [1, 2, 8, 13, 32])
def test_texels_of_mipmaps_are_means_of_what_is_covered(side: int) -> None:
    random = np.random.default_rng(side)
    covered = random.random((side, side)) < 0.1
    covered[0, 0] = True
    picture = random.random((side, side, 3)).astype(np.float32)
    filled = spread_colours(picture, covered)
    assert np.array_equal(filled[covered], picture[covered])
    assert filled.min() >= picture[covered].min() - 1e-6
    assert filled.max() <= picture[covered].max() + 1e-6
    for row, column in np.ndindex(side // 2, side // 2):
        block = np.s_[2 * row : 2 * row + 2, 2 * column : 2 * column + 2]
        if covered[block].any():
            expected = picture[block][covered[block]].mean(axis=0)
            np.testing.assert_allclose(filled[block].mean(axis=(0, 1)), expected, atol=1e-5)
        else:
            assert np.ptp(filled[block], axis=(0, 1)).max() == 0
