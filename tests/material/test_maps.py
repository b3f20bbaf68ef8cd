"""Maps: against a plain reference, at any resolution, in any pieces, and repeating."""

import jax
import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.material import bands as module
from jaxtex.material.appearance import Appearance
from jaxtex.material.bands import count_bands
from jaxtex.material.maps import Maps, render_maps
from jaxtex.material.sheet import lay_sheet
from jaxtex.material.tables import make_material
from jaxtex.models.tiling import make_tiling

KEY = jax.random.key(3)
BONDS = {
    "stack": {},
    "running": {"offset": 0.5},
    "raking": {"offset": 0.3},
    "flemish": {"course_lengths": ((1.0, 0.5),), "offset": 0.75, "bond": "flemish"},
    "irregular": {
        "course_offsets": (0.0, 0.41, 0.13),
        "course_lengths": ((0.75, 1.0), (1.0, 0.5)),
        "bond": "irregular",
    },
}


def make_wall(bond="running", **changes):
    sizes = {"tile_width": 64.0, "tile_height": 32.0, "mortar_x": 6.0, "mortar_y": 4.0}
    return make_tiling(**{**sizes, **BONDS[bond], **changes})


def make_appearance(**changes):
    seen = np.random.default_rng(0).uniform(0.1, 0.7, (8, 3))
    tiles = {(0, n): tuple(colour) for n, colour in enumerate(seen.tolist())}
    relief = {"joint_depth": 3.0, "edge_width": 2.5, "tile_roughness": 0.4, "joint_roughness": 0.9}
    return Appearance(tiles=tiles, joint=(0.9, 0.85, 0.8), **{**relief, **changes})


@pytest.fixture(scope="module", autouse=True)
def small_blocks():
    """Most of these maps are small: of the usual blocks most pixels would be for nothing."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "_BLOCK", (128, 128))
        yield


def render(sheet, size, *, appearance=None, key=KEY):
    bands = render_maps(sheet, appearance or make_appearance(), size=size, key=key)
    return Maps(*(np.concatenate(part) for part in zip(*bands, strict=True)))


def measure_plainly(sheet, appearance, x, y):
    """Colour, height, roughness and id at points of the sheet, by plain NumPy, tile after tile."""
    wall, table = sheet.tiling, sheet.table()
    colours = appearance.colours(table.course, table.tile, key=KEY)
    colour = np.broadcast_to(np.array(appearance.joint), (*x.shape, 3)).copy()
    height, identity = np.zeros(x.shape), np.full(x.shape, -1)
    lengths, offsets = np.asarray(wall.course_lengths), np.asarray(wall.course_offsets)
    for row, entry in np.ndindex(table.tile.shape):
        course, tile = sheet.first_course - 1 + row, int(table.first[row]) + entry
        pattern = lengths[course % len(lengths)]
        repeat, number = divmod(tile, len(pattern))
        start = float(wall.offset) * course + offsets[course % len(offsets)]
        start += repeat * pattern.sum() + pattern[:number].sum()
        left = start * float(wall.tile_width) + 0.5 * float(wall.mortar_x)
        right = (start + pattern[number]) * float(wall.tile_width) - 0.5 * float(wall.mortar_x)
        top = course * float(wall.tile_height) + 0.5 * float(wall.mortar_y)
        bottom = (course + 1) * float(wall.tile_height) - 0.5 * float(wall.mortar_y)
        inside_x, inside_y = np.minimum(x - left, right - x), np.minimum(y - top, bottom - y)
        shown = (inside_x >= 0) & (inside_y >= 0)
        rise = [1 - np.clip(1 - inside / appearance.edge_width, 0, 1) ** 2 for inside in (inside_x, inside_y)]
        colour[shown] = colours[row, entry]
        height[shown] = appearance.joint_depth * (rise[0] * rise[1])[shown]
        identity[shown] = table.identity[row, entry]
    roughness = np.where(identity >= 0, appearance.tile_roughness, appearance.joint_roughness)
    return colour, height, roughness, identity


@pytest.mark.parametrize("bond", BONDS)
@pytest.mark.parametrize("seamless", [False, True])
def test_maps_are_the_mean_over_each_pixel_of_what_is_there(bond, seamless):
    sheet = lay_sheet(make_wall(bond), tiles=(2, 3), seamless=seamless, near=(-70.0, -40.0))
    size, fine = (97, 41), 12
    maps = render(sheet, size)
    x = sheet.corner[0] + (np.arange(size[0] * fine) + 0.5) * sheet.width / (size[0] * fine)
    y = sheet.corner[1] + (np.arange(size[1] * fine) + 0.5) * sheet.height / (size[1] * fine)
    x, y = np.meshgrid(x, y)
    colour, height, roughness, identity = measure_plainly(sheet, make_appearance(), x, y)

    def mean(values):
        return values.reshape(size[1], fine, size[0], fine, -1).mean(axis=(1, 3)).squeeze()

    np.testing.assert_allclose(maps.base_colour, mean(colour), atol=0.07)
    np.testing.assert_allclose(maps.height, mean(height), atol=0.1)
    np.testing.assert_allclose(maps.roughness, mean(roughness), atol=0.05)
    np.testing.assert_allclose(maps.base_colour.mean(), colour.mean(), rtol=0.01)
    centre = fine // 2
    near_centre = identity.reshape(size[1], fine, size[0], fine)[:, centre - 1 : centre + 1, :, centre - 1 : centre + 1]
    sure = np.ptp(near_centre, axis=(1, 3)) == 0
    assert sure.mean() > 0.9
    assert np.array_equal(maps.tile_id[sure], near_centre[:, 0, :, 0][sure])


@pytest.mark.parametrize("bond", BONDS)
@pytest.mark.parametrize("mortar", [0.0, 1.0, 9.0])
def test_a_map_is_the_larger_map_with_four_pixels_averaged(bond, mortar):
    sheet = lay_sheet(make_wall(bond, mortar_x=mortar, mortar_y=mortar), tiles=(3, 4))
    small, large = render(sheet, (57, 43)), render(sheet, (114, 86))
    for name in ("base_colour", "height", "roughness"):
        halved = getattr(large, name).reshape(43, 2, 57, 2, -1).mean(axis=(1, 3)).squeeze()
        np.testing.assert_allclose(getattr(small, name), halved, atol=2e-4)


def test_rounded_corners_agree_across_resolutions_and_take_their_area():
    radius = 8.0
    sheet = lay_sheet(make_wall("stack", corner_radius=radius), tiles=(2, 2))
    small, large = render(sheet, (128, 64)), render(sheet, (512, 256))
    averaged = large.base_colour.reshape(64, 4, 128, 4, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(small.base_colour, averaged, atol=0.12)
    assert np.abs(small.base_colour - averaged).mean() < 4e-4
    covered = 1 - (large.roughness - 0.4).mean() / 0.5
    area = (58 * 28 - (4 - np.pi) * radius**2) / (64 * 32)
    assert covered == pytest.approx(area, abs=5e-4)
    assert (large.tile_id >= 0).mean() == pytest.approx(area, abs=2e-3)


@pytest.mark.parametrize("radius", [0.0, 7.0])
def test_normals_are_the_gradient_of_the_height(radius):
    sheet = lay_sheet(make_wall(corner_radius=radius), tiles=(1, 2))
    step = sheet.width / 1024
    maps = render(sheet, (1024, 1024))
    assert sheet.height / 1024 == step
    down, right = np.gradient(maps.height.astype(np.float64), step)
    slope = np.stack([-right, down], axis=-1)  # y up
    expected = np.concatenate([slope, np.ones((1024, 1024, 1))], axis=-1)
    expected /= np.linalg.norm(expected, axis=-1, keepdims=True)
    off = np.abs(maps.normal - expected).max(axis=-1)
    # The height has a crease where it meets the joint's floor: differences across it are between both sides.
    assert np.quantile(off, 0.9) < 2e-3
    assert (off > 0.1).mean() < 0.015
    np.testing.assert_allclose(np.linalg.norm(maps.normal, axis=-1), 1, atol=1e-5)


def test_normals_lean_outwards_at_edges_with_y_up():
    sheet = lay_sheet(make_wall("stack"), tiles=(1, 1))
    normal = render(sheet, (256, 128)).normal
    middle_row, middle_column = normal[64], normal[:, 128]
    left, right = middle_row[:30, 0], middle_row[-30:, 0]
    assert left.min() < -0.5 < left.max() == 0
    assert right.max() > 0.5 > right.min() == 0
    top, bottom = middle_column[:30, 1], middle_column[-30:, 1]
    assert top.max() > 0.5 > top.min() == 0
    assert bottom.min() < -0.5 < bottom.max() == 0
    assert np.array_equal(normal[64, 128], [0, 0, 1])


def test_maps_in_blocks_are_the_maps_in_one_go(monkeypatch):
    sheet = lay_sheet(make_wall(corner_radius=3.0), tiles=(3, 4))
    whole = render(sheet, (90, 64))
    monkeypatch.setattr(module, "_BLOCK", (7, 31))
    for one, other in zip(whole, render(sheet, (90, 64)), strict=True):
        assert np.array_equal(one, other)


@pytest.mark.parametrize("size", [(90, 64), (60, 128), (30, 300), (1100, 129)])
def test_bands_are_counted(size):
    bands = list(render_maps(lay_sheet(make_wall(), tiles=(2, 3)), make_appearance(), size=size, key=KEY))
    assert len(bands) == count_bands(size)
    assert sum(len(band.height) for band in bands) == size[1]
    assert {band.normal.shape[1:] for band in bands} == {(size[0], 3)}


@pytest.mark.parametrize("bond", ["stack", "running", "irregular"])
def test_a_seamless_sheet_repeats_bit_for_bit(bond):
    # Sizes of which all places are exact numbers, so that nothing is rounded anywhere.
    changes = (
        {"course_lengths": ((0.75, 1.0), (1.0, 0.75)), "course_offsets": (0.0, 0.375, 0.125)}
        if bond == "irregular"
        else {}
    )
    wall = make_wall(bond, **changes)
    one = lay_sheet(wall, tiles=(2, 2), seamless=True)
    tall = lay_sheet(wall, tiles=(round(2 * one.columns), 2 * one.rows), seamless=True)
    assert (tall.columns, tall.rows) == (2 * one.columns, 2 * one.rows)
    width, height = round(2 * one.width), round(2 * one.height)
    single, double = render(one, (width, height)), render(tall, (2 * width, 2 * height))
    for name in ("height", "normal", "roughness"):
        value = getattr(single, name)
        assert np.array_equal(getattr(double, name), np.tile(value, (2, 2) + (1,) * (value.ndim - 2)))
    assert np.array_equal(double.tile_id >= 0, np.tile(single.tile_id >= 0, (2, 2)))


@pytest.mark.parametrize("bond", ["running", "raking", "irregular"])
def test_tiles_go_on_across_the_seam(bond):
    sheet = lay_sheet(make_wall(bond), tiles=(3, 4), seamless=True)
    maps = render(sheet, (round(4 * sheet.width), round(4 * sheet.height)))
    first, last = maps.tile_id[:, 0], maps.tile_id[:, -1]
    cut = (first >= 0) & (last >= 0)
    assert cut.any()
    assert np.array_equal(first[cut], last[cut])
    assert np.array_equal(maps.base_colour[cut, 0], maps.base_colour[cut, -1])
    for tile in np.unique(maps.tile_id[maps.tile_id >= 0]):
        assert len(np.unique(maps.base_colour[ndimage_erode(maps.tile_id == tile)], axis=0)) == 1


def ndimage_erode(mask):
    """Pixels whose neighbours (round the edges) are in the mask too."""
    return mask & np.roll(mask, 1, 0) & np.roll(mask, -1, 0) & np.roll(mask, 1, 1) & np.roll(mask, -1, 1)


def test_ids_are_whole_numbers_each_of_one_tile_also_in_wide_maps():
    sheet = lay_sheet(make_wall(), tiles=(500, 6))
    ids = render(sheet, (4096, 48)).tile_id
    assert ids.dtype == np.float32
    assert ids.min() == -1
    assert np.array_equal(ids, np.round(ids))
    # From joint to joint there is one id, and each stands in one run of pixels only.
    for row in ids[4::8]:
        starts = np.flatnonzero(np.diff(row, prepend=-2))
        runs = row[starts]
        runs = runs[runs >= 0]
        assert len(runs) == len(set(runs.tolist())) in (500, 501)
    assert len(np.unique(ids)) == 1 + 3 * 500 + 3 * 501


def test_a_mosaic_of_ids_has_each_tile_once():
    sheet = lay_sheet(make_wall("stack", mortar_x=0.0, mortar_y=0.0), tiles=(4, 3))
    ids = render(sheet, (64, 48)).tile_id
    assert np.array_equal(np.unique(ids, return_counts=True)[1], [256] * 12)
    assert ids.min() >= 0


def test_colours_are_the_tiles_own_where_the_photograph_shows_them():
    appearance = make_appearance()
    sheet = lay_sheet(make_wall("stack"), tiles=(8, 1))
    centres = render(sheet, (8 * 16, 16), appearance=appearance).base_colour[8, 8::16]
    np.testing.assert_allclose(centres, list(appearance.tiles.values()), rtol=1e-6)


def test_the_same_key_gives_the_same_maps_and_another_other_colours():
    sheet = lay_sheet(make_wall(), tiles=(3, 3), near=(900.0, 900.0))
    one, again, other = (render(sheet, (60, 40), key=jax.random.key(seed)) for seed in (1, 1, 2))
    for a, b in zip(one, again, strict=True):
        assert np.array_equal(a, b)
    assert not np.array_equal(one.base_colour, other.base_colour)
    assert np.array_equal(one.tile_id, other.tile_id)


def test_a_tile_has_its_colour_at_every_resolution_and_in_every_sheet():
    wall = make_wall("stack")
    low, high = (render(lay_sheet(wall, tiles=(3, 4)), size) for size in ((36, 24), (108, 72)))
    assert np.array_equal(low.base_colour[3::6, 6::12], high.base_colour[9::18, 18::36])
    more = render(lay_sheet(wall, tiles=(5, 6)), (60, 36))
    assert np.array_equal(low.base_colour[3::6, 6::12], more.base_colour[3::6, 6::12][:4, :3])


def test_sheets_of_few_tiles_share_compiled_code():
    """Code is compiled anew for another structure, or for leaves of other shapes or precision."""
    of_two, of_many = (
        make_material(lay_sheet(make_wall(bond), tiles=tiles), make_appearance(), None, size=(90, 64), key=KEY)
        for bond, tiles in (("stack", (1, 2)), ("raking", (9, 12)))
    )
    assert jax.tree.structure(of_two) == jax.tree.structure(of_many)
    assert [leaf.aval for leaf in jax.tree.leaves(of_two)] == [leaf.aval for leaf in jax.tree.leaves(of_many)]


@pytest.mark.parametrize(
    ("size", "tiles", "complaint"),
    [
        ((0, 100), (2, 2), "holds no pixels"),
        ((100, -4), (2, 2), "holds no pixels"),
        ((70_000, 8), (2, 2), "is too large; at most 65536"),
        ((100, 100), (30, 2), r"is too small for 30 x 2 tiles, as it leaves 3\.3 pixels to a tile"),
        ((100, 100), (2, 30), "is too small"),
        ((65_536, 65_536), (4000, 4000), "are too many"),
    ],
)
def test_sizes_that_cannot_be_rendered_are_refused_at_once(size, tiles, complaint):
    with pytest.raises(InputError, match=complaint):
        render_maps(lay_sheet(make_wall("stack"), tiles=tiles), make_appearance(), size=size, key=KEY)
