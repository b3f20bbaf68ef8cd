"""Sheets: where they start, what they show, and that seamless ones come round."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jaxtex.core.errors import InputError
from jaxtex.material.patterns import class_of
from jaxtex.material.sheet import lay_photographed_sheet, lay_sheet
from jaxtex.models.files import SourceImage, TilingFile
from jaxtex.models.tiling import make_tiling

CHESS = ((0, 1), (1, 0))
REPORT = {"ok": True, "reason": "", "iou": None, "start": None, "standard_errors": {}}
BONDS = {
    "stack": {},
    "running": {"offset": 0.5},
    "running, as fitted": {"offset": 0.4983},
    "raking": {"offset": 0.3352},
    "raking back": {"offset": 0.7493},
    "english": {"course_lengths": ((1.0,), (0.5,)), "course_offsets": (0.0, 0.25), "bond": "english"},
    "english, as fitted": {"course_lengths": ((1.0,), (0.497,)), "course_offsets": (0.0, 0.251), "bond": "english"},
    "flemish": {"course_lengths": ((1.0, 0.5),), "offset": 0.75, "bond": "flemish"},
    "irregular": {"course_offsets": (0.0, 0.41, 0.13, 0.77), "bond": "irregular"},
    "irregular and leaning": {"offset": 0.121, "course_offsets": (0.0, 0.4, 0.2), "bond": "irregular"},
    "two lengths": {"course_lengths": ((1.0, 0.6), (0.7, 0.9)), "offset": 0.3, "bond": "irregular"},
}


def make_wall(bond, **changes):
    return make_tiling(**{"tile_width": 48.0, "tile_height": 20.0, "mortar_x": 4.0, "mortar_y": 3.0, **bond, **changes})


@jax.jit
def _locate_all(tiling, points):
    return jax.vmap(tiling.locate)(points)


def locate_all(tiling, points):
    """The places of many lattice points, in double precision."""
    with jax.enable_x64():
        return _locate_all(tiling, jnp.asarray(points))


@pytest.mark.parametrize("bond", BONDS.values(), ids=BONDS)
@pytest.mark.parametrize("pattern", [((0,),), CHESS, ((0, 1, 2),)], ids=["plain", "chess", "threes"])
@pytest.mark.parametrize("near", [(0.0, 0.0), (-130.0, -75.0)])
def test_a_seamless_sheet_comes_round(bond, pattern, near):
    wall = make_wall(bond)
    sheet = lay_sheet(wall, tiles=(4, 5), seamless=True, pattern=pattern, near=near)
    assert sheet.columns >= 4 * 0.98
    assert sheet.rows >= 5
    table = sheet.table()
    size = np.array([sheet.width, sheet.height])
    reach = np.array([24.0, 10.0])  # half a tile: the table goes one tile beyond the sheet
    outside = np.random.default_rng(0).uniform(-reach, size + reach, (300, 2))
    inside = outside % size
    places = [locate_all(sheet.tiling, points + sheet.corner) for points in (inside, outside)]
    for side in ("left", "right", "top", "bottom"):
        np.testing.assert_allclose(*(getattr(place, side) for place in places), atol=1e-6)
    numbers = []
    for place in places:
        course, tile = np.asarray(place.course, int), np.asarray(place.tile, int)
        row = course - (sheet.first_course - 1)
        entry = row, tile - table.first[row]
        numbers.append((table.course[entry], table.tile[entry], table.identity[entry]))
        # Colours repeat where tiles do.
        assert np.array_equal(class_of(pattern, course, tile), class_of(pattern, *numbers[-1][:2]))
    assert np.array_equal(numbers[0], numbers[1])
    assert np.array_equal(numbers[0][0], np.asarray(places[0].course))
    assert numbers[0][2].min() >= 0


@pytest.mark.parametrize("bond", BONDS.values(), ids=BONDS)
def test_little_gives_way_for_a_seamless_sheet(bond):
    wall = make_wall(bond)
    closed = lay_sheet(wall, tiles=(7, 9), seamless=True).tiling
    assert abs(float(closed.offset) - float(wall.offset)) <= 0.01 + 1e-6
    np.testing.assert_allclose(closed.course_lengths, wall.course_lengths, rtol=0.0101)
    np.testing.assert_array_equal(closed.course_offsets, np.asarray(wall.course_offsets, float))


def test_changes_are_told_and_only_where_there_are_any():
    assert lay_sheet(make_wall(BONDS["running"]), tiles=(5, 14), seamless=True).changes == ()
    assert lay_sheet(make_wall(BONDS["running, as fitted"]), tiles=(5, 13)).changes == ()
    told = lay_sheet(make_wall(BONDS["running, as fitted"]), tiles=(5, 13), seamless=True).changes
    assert told == ("13 courses became 14", "the offset 0.4983 became 0.5")
    assert lay_sheet(make_wall(BONDS["flemish"]), tiles=(4, 4), seamless=True).changes == ()
    told = lay_sheet(make_wall(BONDS["flemish"]), tiles=(5, 4), seamless=True).changes
    assert told == ("5 columns became 6",)
    told = lay_sheet(make_wall(BONDS["stack"]), tiles=(3, 3), seamless=True, pattern=CHESS).changes
    assert told == ("3 columns became 4", "3 courses became 4")
    (told,) = lay_sheet(make_wall(BONDS["english, as fitted"]), tiles=(4, 6), seamless=True).changes
    assert told == "tile lengths changed by up to 0.6 %"


def test_lengths_that_never_come_round_are_refused():
    wall = make_wall({"course_lengths": ((1.0,), (0.61803,)), "bond": "irregular"}, mortar_x=0.0)
    with pytest.raises(InputError, match="do not come round"):
        lay_sheet(wall, tiles=(1, 2), seamless=True, pattern=(tuple(range(47)),))


@settings(max_examples=30, deadline=None)
@given(st.floats(-400, 400), st.floats(-200, 200), st.sampled_from(sorted(BONDS)))
def test_a_sheet_starts_at_the_nearest_start_of_a_course(x, y, name):
    wall = make_wall(BONDS[name])
    sheet = lay_sheet(wall, tiles=(3, 3), near=(x, y))
    repeat = float(np.sum(wall.course_lengths, axis=1).max() * wall.tile_width)
    assert abs(sheet.corner[0] - x) <= 0.5 * repeat + 1e-3
    assert abs(sheet.corner[1] - y) <= 10.0 + 1e-3
    place = locate_all(sheet.tiling, np.array([sheet.corner]) + 0.01)
    assert float(place.left[0]) == pytest.approx(0.01, abs=1e-5)
    assert float(place.top[0]) == pytest.approx(0.01, abs=1e-5)
    assert int(place.course[0]) == sheet.first_course


def test_the_sheet_of_a_photograph_shows_its_tiles():
    wall = make_wall(BONDS["running"], origin=(100.0, 50.0))
    file = TilingFile(wall, SourceImage(240, 120, "0" * 64), rows=6, columns=5, report=REPORT)
    sheet = lay_photographed_sheet(file)
    assert (sheet.columns, sheet.rows) == (5, 6)
    left, top = np.asarray(wall.origin) + sheet.corner
    assert abs(left) <= 24
    assert abs(top) <= 10
    larger = lay_photographed_sheet(file, tiles=(9, 9))
    assert larger.corner == sheet.corner
    assert larger.natural_size == (432, 180)


def test_turned_and_tilted_tilings_are_laid_upright():
    view = ((1.02, 0.05, -3.0), (-0.03, 0.98, 2.0), (4e-4, -2e-4, 1.0))
    tilted = make_wall(BONDS["running"], angle=0.4, homography=view, origin=(31.0, 12.0))
    sheet, plain = (lay_sheet(wall, tiles=(3, 4)) for wall in (tilted, make_wall(BONDS["running"])))
    assert (sheet.corner, sheet.width, sheet.height) == (plain.corner, plain.width, plain.height)
    assert np.array_equal(sheet.tiling.to_lattice(jnp.array([5.0, 7.0])), [5.0, 7.0])


@pytest.mark.parametrize("tiles", [(0, 3), (3, 0), (-1, 2)])
def test_a_sheet_without_tiles_is_refused(tiles):
    with pytest.raises(InputError, match="shows nothing"):
        lay_sheet(make_wall({}), tiles=tiles)
