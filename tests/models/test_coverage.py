"""The soft coverage against a mask drawn tile by tile, many samples to a pixel, and blurred."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from jaxtex.models.bonds import bond_pattern
from jaxtex.models.grids import coverage_grid
from jaxtex.models.tiling import Tiling, make_tiling

SIZE = 32
PER_PIXEL = 9  # odd: one sample lies at the pixel's centre

WALLS = {
    "running": {"mortar_x": 5.0, "mortar_y": 3.0, "offset": 0.5, "angle": 0.3},
    "raking": {"mortar_x": 2.0, "mortar_y": 2.5, "offset": 0.23, "angle": -0.7},
    "upright": {"mortar_x": 3.0, "mortar_y": 3.0, "offset": 0.37, "angle": 0.0},
    "hairline": {"mortar_x": 0.3, "mortar_y": 0.2, "offset": 0.5, "angle": 1.1},
    "no joint at all": {"mortar_x": 0.0, "mortar_y": 0.0, "offset": 0.5, "angle": 0.2},
    "english": dict(mortar_x=2.0, mortar_y=2.0, angle=2.0, **bond_pattern("english", header=0.6)),
    "flemish": dict(mortar_x=2.0, mortar_y=2.0, angle=0.4, **bond_pattern("flemish", header=0.55)),
    "irregular": {
        "mortar_x": 3.0,
        "mortar_y": 2.0,
        "offset": 0.1,
        "angle": -0.1,
        "course_offsets": [0.0, 0.7, 0.2, -0.4, 0.5],
    },
}


def draw_tiles(wall: Tiling, blur: float) -> np.ndarray:
    """What ``coverage_grid`` should give: every tile painted as a rounded rectangle on fine samples, then blurred."""
    margin = math.ceil(6 * blur)
    n = (SIZE + 2 * margin) * PER_PIXEL
    at = (np.arange(n) + 0.5) / PER_PIXEL - margin
    x, y = np.meshgrid(at, at)
    h = np.asarray(wall.homography, float)
    depth = h[2, 0] * x + h[2, 1] * y + h[2, 2]
    plane_x = (h[0, 0] * x + h[0, 1] * y + h[0, 2]) / depth - float(wall.origin[0])
    plane_y = (h[1, 0] * x + h[1, 1] * y + h[1, 2]) / depth - float(wall.origin[1])
    c, s = math.cos(wall.angle), math.sin(wall.angle)
    along, across = c * plane_x + s * plane_y, -s * plane_x + c * plane_y
    width, height = float(wall.tile_width), float(wall.tile_height)
    painted = np.zeros((n, n))
    for j in range(math.floor(across.min() / height), math.floor(across.max() / height) + 1):
        rows = wall.course_lengths.tolist()
        lengths = rows[j % len(rows)]
        start = float(wall.offset) * j + wall.course_offsets.tolist()[j % len(wall.course_offsets)]
        start -= sum(lengths) * math.ceil((start - along.min() / width) / sum(lengths))
        number = 0
        while start * width < along.max():
            end = start + lengths[number % len(lengths)]
            x_from, x_to = start * width + wall.mortar_x / 2, end * width - wall.mortar_x / 2
            y_from, y_to = j * height + wall.mortar_y / 2, (j + 1) * height - wall.mortar_y / 2
            painted += paint_rectangle(along, across, x_from, x_to, y_from, y_to, float(wall.corner_radius))
            start, number = end, number + 1
    blurred = gaussian_filter(painted, blur * PER_PIXEL, truncate=6.0)
    inner = slice(margin * PER_PIXEL, (margin + SIZE) * PER_PIXEL)
    return blurred[inner, inner][PER_PIXEL // 2 :: PER_PIXEL, PER_PIXEL // 2 :: PER_PIXEL]


def paint_rectangle(x, y, x_from, x_to, y_from, y_to, radius):
    """The share of each sample's little square inside a rounded rectangle."""
    beyond_x = np.abs(x - (x_from + x_to) / 2) - (x_to - x_from) / 2 + radius
    beyond_y = np.abs(y - (y_from + y_to) / 2) - (y_to - y_from) / 2 + radius
    if radius == 0:
        return np.clip(0.5 - beyond_x * PER_PIXEL, 0, 1) * np.clip(0.5 - beyond_y * PER_PIXEL, 0, 1)
    outside = np.hypot(np.maximum(beyond_x, 0), np.maximum(beyond_y, 0))
    distance = outside + np.minimum(np.maximum(beyond_x, beyond_y), 0) - radius
    return np.clip(0.5 - distance * PER_PIXEL, 0, 1)


def error_of(wall: Tiling, blur: float) -> float:
    rendered = np.asarray(coverage_grid(wall, SIZE, SIZE, blur=blur), float)
    return float(np.abs(rendered - draw_tiles(wall, blur)).max())


@pytest.mark.parametrize("name", WALLS)
def test_coverage_is_the_mask_convolved_with_the_gaussian(name):
    with jax.enable_x64():
        wall = make_tiling(tile_width=21.0, tile_height=12.0, origin=(3.3, 7.1), **WALLS[name])
        assert error_of(wall, 1.0) < 1e-3


def test_single_precision_is_as_good():
    wall = make_tiling(tile_width=21.0, tile_height=12.0, origin=(3.3, 7.1), **WALLS["running"])
    assert wall.coverage(jnp.array([1.0, 2.0]), blur=1.0).dtype == jnp.float32
    assert error_of(wall, 1.0) < 1e-3


@pytest.mark.parametrize("radius", [0.3, 1.0, 2.0, 3.0, 4.0])
@pytest.mark.parametrize("name", ["running", "hairline"])
def test_rounded_corners_are_close_to_the_convolution(name, radius):
    with jax.enable_x64():
        wall = make_tiling(tile_width=21.0, tile_height=12.0, corner_radius=radius, **WALLS[name])
        assert error_of(wall, 1.0) < 0.015


def test_perspective_and_shear_stretch_the_spot():
    with jax.enable_x64():
        view = [[1.1, 0.2, -3.0], [-0.1, 0.9, 2.0], [2e-3, -1e-3, 1.0]]
        wall = make_tiling(tile_width=21.0, tile_height=12.0, homography=view, **WALLS["upright"])
        # One scale for the whole spot, and round corners of it where the view shears, are approximations.
        assert error_of(wall, 0.7) < 0.02


def test_corners_of_a_stretched_picture_are_close_too():
    with jax.enable_x64():
        walls = [
            make_tiling(
                tile_width=21.0, tile_height=12.0, homography=np.diag(view), corner_radius=4.0, **WALLS["upright"]
            )
            for view in ((1.15, 0.9, 1.0), (0.9, 1.15, 1.0))
        ]
        assert max(error_of(wall, 0.8) for wall in walls) < 0.05


def test_blur_may_reach_a_quarter_of_the_tile():
    with jax.enable_x64():
        wall = make_tiling(tile_width=20.0, tile_height=12.0, mortar_x=3.0, mortar_y=3.0, offset=0.5, angle=0.3)
        assert error_of(wall, 3.0) < 0.03
