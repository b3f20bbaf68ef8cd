"""Filled maps: each tile its own piece, its own colour, its own edges, and no seam in any of it."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from drawn_interiors import COURSES, TILES, draw_grain, make_appearance, make_interiors

from jaxtex.core.colour import linear_to_srgb
from jaxtex.material import bands as module
from jaxtex.material import filled
from jaxtex.material.bands import evaluate_points
from jaxtex.material.maps import Maps, render_maps
from jaxtex.material.sheet import lay_sheet
from jaxtex.material.tables import make_material
from jaxtex.models.tiling import make_tiling

KEY = jax.random.key(3)
WIDE, HIGH = 64.0, 32.0
# Sizes and numbers of everything are such that all of these maps share compiled code.
NOTHING = np.zeros((0, 1, 1, 3), np.float32)
GRAIN = {"tile_grain": (draw_grain(), NOTHING), "joint_grain": draw_grain(strength=0.03, height=12, seed=1)}


def make_wall(**changes):
    sizes = {"tile_width": WIDE, "tile_height": HIGH, "mortar_x": 6.0, "mortar_y": 6.0, "offset": 0.0}
    return make_tiling(**{**sizes, "course_lengths": ((1.0, 1.0),), "bond": "irregular", **changes})


def make_shifts(seed=0, most=1.5):
    return np.random.default_rng(seed).uniform(-most, most, (COURSES * TILES, 4)).astype(np.float32)


def make_full(**changes):
    """Interiors with everything that there is."""
    fall = np.exp(-np.arange(6) / 2.0, dtype=np.float32)
    profile = np.array([-0.1, -0.05, 0.08, -0.12], np.float32)[:, None, None] * fall[None, :, None] * np.ones(3)
    profile[:, -1] = 0
    joint = np.full((4, 2, 3), -0.05, np.float32)
    parts = {"shift": make_shifts(), "wobble": 0.4, "tile_profile": profile, "joint_profile": joint}
    return make_interiors(**{**GRAIN, **parts, **changes})


def render(sheet, size=None, *, interiors=None, appearance=None, key=KEY):
    bumpy = make_appearance(tile_bump=0.1, joint_bump=0.1)
    size = size or sheet.natural_size
    bands = render_maps(sheet, appearance or bumpy, size=size, key=key, interiors=interiors or make_full())
    return Maps(*(np.concatenate(part) for part in zip(*bands, strict=True)))


@pytest.fixture(scope="module", autouse=True)
def small_blocks():
    """Blocks of the size of these maps: most pixels of the usual ones would be for nothing."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "_BLOCK", (128, 320))
        yield


@pytest.fixture(scope="module")
def sheet():
    return lay_sheet(make_wall(), tiles=(5, 4))


@pytest.fixture(scope="module")
def maps(sheet):
    return render(sheet)


def faces(maps, margin=0):
    """The pixels of each tile of a sheet of (5, 4) tiles in stack bond, [course, tile, row, col, ...]."""
    pixels = maps.reshape(COURSES, 32, TILES, 64, *maps.shape[2:]).swapaxes(1, 2)
    return pixels[:, :, 3 + margin : 29 - margin, 3 + margin : 61 - margin]


@pytest.mark.parametrize("changes", [{"offset": 0.3}, {"course_lengths": ((1.0, 0.5),), "offset": 0.75}])
def test_with_nothing_inside_filled_maps_are_the_flat_ones(changes):
    sheet = lay_sheet(make_wall(**changes), tiles=(3, 3))
    size = (150, 90)
    plain = render(sheet, size, interiors=make_interiors())
    flat = Maps(*map(np.concatenate, zip(*render_maps(sheet, make_appearance(), size=size, key=KEY), strict=True)))
    for name in set(Maps._fields) - {"normal"}:
        np.testing.assert_allclose(getattr(plain, name), getattr(flat, name), atol=2e-4, err_msg=name)
    # Normals are those of differences between pixels.
    assert plain.normal.shape == flat.normal.shape
    assert np.median(np.abs(plain.normal - flat.normal).max(axis=-1)) < 1e-4


def test_the_mean_colour_of_each_tile_is_its_own(sheet):
    appearance = make_appearance()
    interiors = make_interiors(**GRAIN)
    colour = faces(linear_to_srgb(render(sheet, interiors=interiors, appearance=appearance).base_colour), 3)
    own = linear_to_srgb(np.array(list(appearance.tiles.values()))).reshape(COURSES, TILES, 3)
    np.testing.assert_allclose(colour.mean(axis=(2, 3)), own, atol=0.004)
    # That is not by chance: pieces of 20 x 52 pixels of this grain stray by more.
    assert colour.std(axis=(2, 3))[..., 0].mean() == pytest.approx(0.05, rel=0.15)


def test_what_a_photographs_tiles_have_on_top_of_their_colours_comes_back(sheet):
    offset = np.random.default_rng(0).uniform(-0.05, 0.05, (COURSES * TILES, 3)).astype(np.float32)
    appearance = make_appearance()
    plain, moved = (
        faces(linear_to_srgb(render(sheet, interiors=make_interiors(**parts), appearance=appearance).base_colour), 3)
        for parts in ({}, {"offset": offset})
    )
    np.testing.assert_allclose((moved - plain).mean(axis=(2, 3)).reshape(-1, 3), offset, atol=1e-3)


def test_tiles_of_one_colour_differ_inside(sheet):
    colours = dataclasses.replace(make_appearance(), tiles=dict.fromkeys(make_appearance().tiles, (0.2, 0.2, 0.2)))
    pixels = faces(render(sheet, appearance=colours, interiors=make_interiors(**GRAIN)).base_colour, 3)[..., 0]
    pieces = pixels.reshape(COURSES * TILES, -1)
    alike = np.corrcoef(pieces) - np.eye(len(pieces))
    assert np.quantile(np.abs(alike), 0.9) < 0.2
    assert alike.max() < 0.9


def test_grain_is_as_strong_as_each_tiles_contrast(sheet):
    contrast = np.linspace(0.4, 2.0, COURSES * TILES, dtype=np.float32)
    pixels = faces(linear_to_srgb(render(sheet, interiors=make_interiors(**GRAIN, contrast=contrast)).base_colour), 3)
    spread = pixels.std(axis=(2, 3))[..., 0].ravel()
    assert np.corrcoef(spread, contrast)[0, 1] > 0.98
    np.testing.assert_allclose(spread / contrast, np.median(spread / contrast), rtol=0.2)


def test_kinds_of_grain_go_to_the_tiles_of_their_kind(sheet):
    kind = (np.arange(COURSES * TILES) % 2).astype(np.int32)
    two = (draw_grain(strength=0.01), draw_grain(strength=0.08))
    pixels = faces(render(sheet, interiors=make_interiors(kind=kind, tile_grain=two)).base_colour, 3)
    strong = (linear_to_srgb(pixels).std(axis=(2, 3))[..., 0] > 0.03).ravel()
    assert np.array_equal(strong, kind == 1)


def test_the_same_key_gives_the_same_maps_and_another_others(sheet, maps):
    for one, again in zip(maps, render(sheet), strict=True):
        assert np.array_equal(one, again)
    other = render(sheet, key=jax.random.key(4))
    assert np.abs(other.base_colour - maps.base_colour).mean() > 0.01
    assert np.array_equal(faces(other.tile_id, 6), faces(maps.tile_id, 6))


def test_bands_do_not_show(maps):
    # Of this sheet, which begins two courses higher, the first band ends where the other has its middle.
    taller = render(lay_sheet(make_wall(), tiles=(3, 8), near=(0.0, -2 * HIGH)))
    for name in set(Maps._fields) - {"tile_id"}:
        one, other = getattr(maps, name)[:, : 3 * 64 - 4], getattr(taller, name)[64:192, : 3 * 64 - 4]
        np.testing.assert_allclose(one, other, atol=1e-5, err_msg=name)


@pytest.mark.parametrize("bond", [{"offset": 0.5}, {"course_lengths": ((1.0, 0.5),), "offset": 0.75}])
def test_a_seamless_sheet_goes_on_with_its_other_side(bond):
    sheet = lay_sheet(make_wall(**bond), tiles=(4, 3), seamless=True)
    (width, height), (x, y) = sheet.natural_size, sheet.corner
    material = make_material(sheet, make_appearance(tile_bump=0.1), make_full(), size=(width, height), key=KEY)
    # From some pixels before the sheet's beginning to some after it, and the same at its end.
    across, down = np.arange(-40, 120) + 0.5, np.arange(-32, 32) + 0.5
    across, down = np.concatenate([x + across, x + width + across]), np.concatenate([y + down, y + height + down])
    across, down = jnp.asarray(across, jnp.float32), jnp.asarray(down, jnp.float32)
    seen = evaluate_points(filled.look, material, across, down)._asdict()
    around = (jnp.concatenate([at[:1], at, at[-1:]]) for at in (across, down))
    seen["height"] = evaluate_points(filled.height, material, *around)[1:-1, 1:-1]
    for name in ("base_colour", "joint", "occlusion", "tile_id", "height"):
        values = np.asarray(seen[name])
        assert values.std() > 0
        # Of what lies beyond the sheet, some pixels count: these are what normals see of it, and more.
        along = values[26:64, 34:46] - values[26:64, 194:206]
        over = values[26:38, 34:160] - values[90:102, 34:160]
        for off in (along, over):
            # Pixels whose centres lie on an edge: rounding tells which side they are of.
            assert (np.abs(off).reshape(*off.shape[:2], -1).max(axis=-1) > 1e-3).mean() < 4e-3, name


def test_a_tile_does_not_depend_on_how_many_others_there_are(sheet, maps):
    less = render(lay_sheet(make_wall(), tiles=(3, 3)))
    part = slice(0, 3 * 32 - 4), slice(0, 3 * 64 - 4)  # the last joints are also others'
    for name in ("base_colour", "height", "occlusion"):
        np.testing.assert_allclose(getattr(less, name)[part], getattr(maps, name)[part], atol=1e-5, err_msg=name)


def test_normals_are_the_gradient_of_the_height(sheet, maps):
    down, right = np.gradient(maps.height.astype(np.float64))
    expected = np.stack([-right, down, np.ones_like(down)], axis=-1)
    expected /= np.linalg.norm(expected, axis=-1, keepdims=True)
    np.testing.assert_allclose(maps.normal[1:-1, 1:-1], expected[1:-1, 1:-1], atol=1e-4)
    np.testing.assert_allclose(np.linalg.norm(maps.normal, axis=-1), 1, atol=1e-5)
    half = render(sheet, (160, 64), interiors=make_full(tile_grain=(NOTHING,) * 2, joint_grain=NOTHING))  # pixels of 2
    down, right = np.gradient(half.height.astype(np.float64), 2.0)
    steep = np.hypot(half.normal[..., 0], half.normal[..., 1]) / half.normal[..., 2]
    np.testing.assert_allclose(steep[1:-1, 1:-1], np.hypot(down, right)[1:-1, 1:-1], atol=1e-3)


def test_grain_is_uneven_as_asked(sheet):
    slopes = []
    for bump in (0.0, 0.1, 0.2):
        grain = render(sheet, interiors=make_interiors(**GRAIN), appearance=make_appearance(tile_bump=bump))
        normal = faces(grain.normal, 6)
        slopes.append(np.sqrt(np.mean(np.square(normal[..., :2] / normal[..., 2:]).sum(axis=-1))))
    assert slopes[0] == 0
    # Slopes between neighbours' neighbours are a little less than those from pixel to pixel.
    np.testing.assert_allclose(slopes[1:], [0.1, 0.2], rtol=0.3)


def test_joints_lie_below_tiles_and_in_the_shade(maps):
    tile = maps.tile_id >= 0
    assert np.median(maps.height[tile]) > 2.5 > 0.5 > np.median(maps.height[~tile])
    assert maps.occlusion.min() > 0
    assert maps.occlusion.max() <= 1
    assert np.median(maps.occlusion[tile]) > 0.97
    assert np.median(maps.occlusion[~tile]) < 0.85


def test_ids_are_those_of_flat_maps(sheet, maps):
    flat = Maps(
        *map(np.concatenate, zip(*render_maps(sheet, make_appearance(), size=(320, 128), key=KEY), strict=True))
    )
    assert np.array_equal(faces(maps.tile_id, 5), faces(flat.tile_id, 5))
    assert np.array_equal(np.unique(maps.tile_id), np.unique(flat.tile_id))


@pytest.mark.parametrize("side", range(4))
def test_edges_are_where_they_were_measured(sheet, side):
    shift = np.zeros((COURSES * TILES, 4), np.float32)
    shift[:, side] = 2.0
    ids = render(sheet, interiors=make_interiors(shift=shift)).tile_id.reshape(COURSES, 32, TILES, 64).swapaxes(1, 2)
    size = np.array([(ids >= 0).any(axis=axis).sum(axis=-1).max() for axis in (2, 3)])  # width, height
    expected = {0: (60, 26), 1: (60, 26), 2: (58, 28), 3: (58, 28)}[side]
    assert tuple(size) == expected
    first = np.argmax((ids[2, 2] >= 0).any(axis=0)), np.argmax((ids[2, 2] >= 0).any(axis=1))
    assert first == {0: (1, 3), 1: (3, 3), 2: (3, 1), 3: (3, 3)}[side]


def test_shades_towards_the_sides_are_drawn(sheet):
    profile = make_full().tile_profile
    flat, shaded = (
        linear_to_srgb(render(sheet, interiors=make_interiors(tile_profile=each)).base_colour)
        for each in (0 * profile, profile)
    )
    change = faces(shaded - flat)[..., 0]
    np.testing.assert_allclose(change[:, :, 13, :6], np.broadcast_to(profile[0, :, 0], (COURSES, TILES, 6)), atol=1e-3)
    np.testing.assert_allclose(
        change[:, :, 13, :-7:-1], np.broadcast_to(profile[1, :, 0], (COURSES, TILES, 6)), atol=1e-3
    )
    np.testing.assert_allclose(change[:, :, :6, 29], np.broadcast_to(profile[2, :, 0], (COURSES, TILES, 6)), atol=1e-3)
    np.testing.assert_allclose(
        change[:, :, :-7:-1, 29], np.broadcast_to(profile[3, :, 0], (COURSES, TILES, 6)), atol=1e-3
    )
    assert np.abs(change[:, :, 8:-8, 8:-8]).max() < 1e-3


def test_joints_have_their_grain_and_their_shade(sheet):
    interiors = make_interiors(joint_grain=GRAIN["joint_grain"], joint_profile=np.full((4, 2, 3), -0.1, np.float32))
    encoded = linear_to_srgb(render(sheet, interiors=interiors).base_colour)[..., 0]
    joint = encoded[30:34, 8:312]
    own = linear_to_srgb(np.array(make_appearance().joint))[0]
    assert joint.mean() == pytest.approx(own - 0.1, abs=0.02)
    assert joint.std() == pytest.approx(0.03, rel=0.4)


def test_wobble_bends_edges_by_as_much_as_asked():
    wall = make_wall(tile_width=200.0, tile_height=40.0, mortar_x=10.0, mortar_y=10.0)
    sheet = lay_sheet(wall, tiles=(1, 3))
    straight, bent = (render(sheet, interiors=make_interiors(wobble=each)) for each in (0.0, 1.2))
    assert np.ptp((straight.tile_id >= 0).sum(axis=0)[20:-20]) == 0
    ends = np.stack([np.argmax(bent.tile_id[row : row + 20, 20:-20] >= 0, axis=0) for row in (0, 40, 80)])
    assert ends.std() == pytest.approx(1.2, rel=0.4)
    assert ends.mean() == pytest.approx(5, abs=1)
    assert np.abs(np.diff(ends, axis=1)).mean() < 1


@pytest.mark.parametrize("shift", [2.25, 2.9])
def test_no_place_is_lighter_than_all_that_is_there_however_edges_bend(sheet, shift):
    # Two edges that leave a quarter of the joint between them, and bend towards each other.
    shifts = np.full((COURSES * TILES, 4), shift, np.float32)
    maps = render(sheet, interiors=make_interiors(shift=shifts, wobble=0.9))
    brightest = max(max(map(max, make_appearance().tiles.values())), max(make_appearance().joint))
    assert maps.base_colour.max() <= brightest + 1e-5
    assert maps.height.max() <= 3.0 + 1e-5


def test_occlusion_is_the_share_of_an_even_sky():
    """Against a sum over directions, in a long joint."""
    depth, gap = 5.0, 12.0
    sheet = lay_sheet(make_wall(tile_width=4000.0, tile_height=100.0, mortar_x=0.0, mortar_y=gap), tiles=(1, 3))
    appearance = make_appearance(joint_depth=depth, edge_width=0.0)
    seen = np.concatenate([band.occlusion for band in render_maps(sheet, appearance, size=(40, 1200), key=KEY)])[
        :400, 20
    ]
    y = (np.arange(400) + 0.5) / 4
    up, azimuth = np.meshgrid((np.arange(400) + 0.5) / 400, (np.arange(400) + 0.5) / 400 * 2 * np.pi)
    # Each of these directions counts the same by its projected area: sin^2 of the angle from the normal is even.
    across, rise = np.sqrt(up) * np.sin(azimuth), np.sqrt(1 - up)
    for row in (1, 8, 15, 22, 379, 398):
        distance = min(y[row], 100 - y[row])  # from the joint's middle
        walls = np.where(across > 0, gap / 2 - distance, gap / 2 + distance)
        open_sky = np.mean(np.abs(across) / rise * depth < walls)
        assert seen[row] == pytest.approx(open_sky, abs=0.02)
    assert seen[200] == pytest.approx(1, abs=0.01)
