"""Tiles cut out of pictures: against the picture's own formula, and the model's own places."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxtex.material.cells import cut_box, cut_cells, tile_bounds
from jaxtex.models.grids import coverage_grid
from jaxtex.models.tiling import make_tiling

HEIGHT, WIDTH = 140, 190
WALL = {
    "tile_width": 46.0,
    "tile_height": 22.0,
    "mortar_x": 5.0,
    "mortar_y": 3.0,
    "offset": 0.5,
    "origin": (80.3, 61.7),
}
VIEW = ((1.02, 0.05, -3.0), (-0.03, 0.98, 2.0), (4e-4, -2e-4, 1.0))
COURSES = {"course_offsets": (0.0, 0.41, 0.13), "course_lengths": ((0.75, 1.0), (1.0, 0.5)), "bond": "irregular"}
WALLS = [{}, {"angle": 0.3}, {"homography": VIEW, "angle": -0.2}, COURSES, {**COURSES, "angle": 1.4}]
PLACES = [(course, tile) for course in range(-4, 5) for tile in range(-5, 6)]


def shade(x, y):
    """A picture that is smooth enough for cubic splines to be right about it between pixels, and not for lines."""
    return np.stack([0.5 + 0.3 * np.sin(x / 3 + y / 5), 0.5 + 0.3 * np.cos(y / 3 - x / 20), x / 200], axis=-1)


def make_picture():
    y, x = np.indices((HEIGHT, WIDTH)) + 0.5
    return shade(x, y).astype(np.float32)


def corner_of(wall, place):
    """Where the lattice of a tile begins, by counting tiles along its course."""
    course, tile = place
    offsets, lengths = np.asarray(wall.course_offsets), np.asarray(wall.course_lengths)
    row = lengths[course % len(lengths)]
    before = sum(row[n % len(row)] for n in range(tile)) - sum(row[n % len(row)] for n in range(tile, 0))
    along = float(wall.offset) * course + offsets[course % len(offsets)] + before
    return along * float(wall.tile_width), course * float(wall.tile_height)


@pytest.mark.parametrize("changes", WALLS)
def test_a_cell_holds_what_the_picture_shows_there(changes):
    wall = make_tiling(**{**WALL, **changes})
    cells = cut_cells(make_picture(), wall, PLACES)
    assert len(cells) >= 5
    for cell in cells:
        left, top = corner_of(wall, cell.place)
        x = left + 2.5 + cell.left
        y = top + 1.5 + cell.top
        q = jnp.asarray(np.stack(np.meshgrid(x, y), axis=-1), jnp.float32)
        at = np.asarray(jax.vmap(jax.vmap(wall.from_lattice))(q))
        # At the picture's border splines have but one side to go by.
        sure = np.all((at > 5) & (at < [WIDTH - 5, HEIGHT - 5]), axis=-1)
        np.testing.assert_allclose(cell.values[sure], shade(at[..., 0], at[..., 1])[sure], atol=2e-3)


@pytest.mark.parametrize("changes", WALLS)
def test_sides_say_how_far_inside_of_the_face_pixels_lie(changes):
    wall = make_tiling(**{**WALL, **changes})
    cover = np.asarray(coverage_grid(wall, HEIGHT, WIDTH, blur=0.3))[..., None]
    for cell in cut_cells(cover.astype(np.float32), wall, PLACES):
        depth = np.minimum(np.minimum(cell.left, cell.right)[None, :], np.minimum(cell.top, cell.bottom)[:, None])
        assert (cell.values[depth > 1.2] > 0.9).all()
        # The joints reach to where the next tile begins.
        assert (cell.values[(depth < -1.0) & (depth > -1.6)] < 0.35).all()
        (start,), (end,) = tile_bounds(wall, *np.array(cell.place)[:, None])
        np.testing.assert_allclose(cell.left + cell.right, end - start - 5, atol=1e-3)
        np.testing.assert_allclose(cell.top + cell.bottom, 22 - 3, atol=1e-3)
        for side, joint in zip(cell[2:], (5, 5, 3, 3), strict=True):
            assert -joint - 0.5 <= side.min() < -0.5 * joint + 1


@pytest.mark.parametrize("changes", WALLS)
def test_tiles_of_which_a_part_is_outside_are_passed_over(changes):
    wall = make_tiling(**{**WALL, **changes})
    kept = {cell.place for cell in cut_cells(make_picture(), wall, PLACES)}
    for place in PLACES:
        left, top = corner_of(wall, place)
        (start,), (end,) = tile_bounds(wall, np.array([place[0]]), np.array([place[1]]))
        around = [(x, y) for x in (left - 1, left + end - start + 1) for y in (top - 0.5, top + 22.5)]
        at = np.array([wall.from_lattice(jnp.asarray(corner, jnp.float32)) for corner in around])
        out = max((-at).max(), (at - [WIDTH, HEIGHT]).max())
        if out > 3:
            assert place not in kept
        if out < -3:
            assert place in kept


def test_a_wall_that_is_not_turned_keeps_the_pictures_own_pixels():
    picture = np.random.default_rng(0).random((HEIGHT, WIDTH, 3)).astype(np.float32)
    wall = make_tiling(**WALL)
    (cell,) = cut_cells(picture, wall, [(0, 0)])
    column, row = 80.3 + 2.5 + cell.left - 0.5, 61.7 + 1.5 + cell.top - 0.5
    assert np.abs(column - np.round(column)).max() < 1e-4
    assert np.abs(row - np.round(row)).max() < 1e-4
    own = picture[np.round(row).astype(int)][:, np.round(column).astype(int)]
    np.testing.assert_allclose(cell.values, own, atol=2e-3)


@pytest.mark.parametrize("changes", WALLS)
def test_bounds_are_where_the_model_has_them(changes):
    wall = make_tiling(**{**WALL, **changes})
    course, tile = np.array(PLACES).T
    start, end = tile_bounds(wall, course, tile)
    np.testing.assert_allclose(start, [corner_of(wall, place)[0] for place in PLACES], atol=1e-4)
    q = np.stack([0.7 * start + 0.3 * end, (course + 0.4) * 22.0], axis=-1)
    place = jax.vmap(wall.locate)(jnp.asarray(q, jnp.float32))
    np.testing.assert_array_equal(np.asarray(place.course), course)
    np.testing.assert_array_equal(np.asarray(place.tile), tile)
    np.testing.assert_allclose(place.left, 0.3 * (end - start), atol=1e-3)
    np.testing.assert_allclose(place.right, 0.7 * (end - start), atol=1e-3)
    table = tile_bounds(wall, course.reshape(9, 11), tile.reshape(9, 11))
    np.testing.assert_array_equal(table, (start.reshape(9, 11), end.reshape(9, 11)))


def test_a_box_is_cut_as_it_lies_in_the_lattice():
    wall = make_tiling(**WALL, angle=0.3)
    low, high = np.array([-12.0, 3.0]), np.array([18.0, 21.0])
    box = cut_box(make_picture(), wall, low, high)
    assert box.shape == (18, 30, 3)
    y, x = np.indices((18, 30)) + 0.5
    turned = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    at = np.stack([x - 12, y + 3], axis=-1) @ turned.T + [80.3, 61.7]
    np.testing.assert_allclose(box, shade(at[..., 0], at[..., 1]), atol=2e-3)


def test_no_tiles_are_no_cells():
    assert cut_cells(make_picture(), make_tiling(**WALL), []) == []
    assert cut_cells(make_picture(), make_tiling(**WALL), [(500, 0)]) == []
