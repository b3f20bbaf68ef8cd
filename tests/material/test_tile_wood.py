"""Wood in tiles: each tile is cut of the trunk somewhere else, and sheets still repeat."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxtex.material import bands, filled
from jaxtex.material.appearance import Appearance
from jaxtex.material.bands import evaluate_points
from jaxtex.material.maps import Maps, render_maps
from jaxtex.material.sheet import lay_sheet
from jaxtex.material.tables import make_material
from jaxtex.material.tile_wood import Timber
from jaxtex.models.tiling import make_tiling
from jaxtex.models.wood import make_wood
from jaxtex.models.wood_detail import Displacement, Fibres

KEY = jax.random.key(0)


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch):
    monkeypatch.setattr(bands, "_BLOCK", (28, 128))  # what lies beyond the maps is evaluated with them


FIBRES = Fibres(jnp.array(0.1), jnp.array(1.5), jnp.array([0.02, 0.01]))
OAK = make_wood(
    ring_spacing=7.0,
    center=(30.0, 200.0),
    tilt=0.05,
    rotation=0.4,
    turbulence_rms=2.0,
    turbulence_frequency=0.02,
    fibres=FIBRES,
)
GREY = Appearance(tiles={(0, 0): (0.3, 0.3, 0.3)}, joint=(0.05, 0.06, 0.07), joint_depth=2.0, edge_width=1.0)


def make_boards(**changes):
    return make_tiling(
        **{"tile_width": 60.0, "tile_height": 20.0, "mortar_x": 4.0, "mortar_y": 3.0, "offset": 0.5, **changes}
    )


def render(sheet, size, timber=None, appearance=GREY, **options):
    timber = timber or Timber(OAK, (256, 256))
    rendered = render_maps(sheet, appearance, size=size, key=KEY, timber=timber, **options)
    return Maps(*(np.concatenate(part) for part in zip(*rendered, strict=True)))


def faces(sheet, size):
    """Whether pixels lie well within a tile."""
    flat = Maps(*(np.concatenate(part) for part in zip(*render_maps(sheet, GREY, size=size, key=KEY), strict=True)))
    return flat.height >= 2.0 - 1e-4, flat


def test_joints_stay_and_tiles_are_of_the_woods_colours():
    sheet = lay_sheet(make_boards(), tiles=(3, 4))
    on_face, flat = faces(sheet, (360, 160))
    maps = render(sheet, (360, 160))
    in_joint = flat.height == 0
    np.testing.assert_allclose(maps.base_colour[in_joint], np.broadcast_to(GREY.joint, (in_joint.sum(), 3)), atol=1e-6)
    np.testing.assert_array_equal(maps.tile_id, flat.tile_id)
    np.testing.assert_allclose(maps.occlusion, flat.occlusion, atol=1e-6)
    mean = OAK.late_rgb + OAK.early_fraction * (OAK.early_rgb - OAK.late_rgb)
    np.testing.assert_allclose(maps.base_colour[on_face].mean(0), mean, rtol=0.12)
    relief = maps.height[on_face] - 2.0
    assert relief.min() >= -1e-5
    assert 0.05 < relief.max() <= 0.02 * 7.0 + 1e-5
    assert maps.roughness[on_face].min() == pytest.approx(0.5, abs=0.01)
    assert maps.roughness[on_face].max() == pytest.approx(0.65, abs=0.01)
    np.testing.assert_allclose(maps.roughness[in_joint], GREY.joint_roughness)


@pytest.mark.parametrize(("width", "height", "along_x"), [(60.0, 20.0, True), (20.0, 60.0, False)])
def test_grain_runs_along_the_longer_side(width, height, along_x):
    sheet = lay_sheet(make_boards(tile_width=width, tile_height=height, offset=0.0), tiles=(2, 2))
    size = tuple(2 * side for side in sheet.natural_size)
    on_face, _ = faces(sheet, size)
    light = render(sheet, size).base_colour.mean(axis=2)
    both = [on_face[:, 1:] & on_face[:, :-1], on_face[1:] & on_face[:-1]]
    change = [np.abs(np.diff(light, axis=1 - axis))[both[axis]].mean() for axis in (0, 1)]
    assert (change[0] < 0.6 * change[1]) == along_x
    assert (change[1] < 0.6 * change[0]) == (not along_x)


def test_grain_of_square_tiles_turns_as_on_a_chessboard():
    sheet = lay_sheet(make_boards(tile_width=40.0, tile_height=40.0, offset=0.0), tiles=(4, 4))
    light = render(sheet, (160, 160)).base_colour.mean(axis=2).reshape(4, 40, 4, 40).swapaxes(1, 2)[:, :, 4:36, 4:36]
    along = [np.abs(np.diff(light, axis=axis)).mean(axis=(2, 3)) for axis in (2, 3)]
    runs_down = along[0] < along[1]
    chessboard = np.indices((4, 4)).sum(0) % 2 == 1
    np.testing.assert_array_equal(runs_down, chessboard == runs_down[0, 1])


@pytest.mark.parametrize("size", [(360, 240), (250, 170)])
def test_both_ends_of_a_seamless_sheet_show_the_same_wood(size):
    sheet = lay_sheet(make_boards(offset=0.4998), tiles=(3, 6), seamless=True)
    material = make_material(sheet, GREY, None, size=size, key=KEY, timber=Timber(OAK, (256, 256)))
    pixel = np.asarray(material.pixel)
    starts = [[sheet.corner[k] + (first + np.arange(24) + 0.5) * pixel[k] for first in (0, size[k])] for k in (0, 1)]

    def see(x, y):
        x, y = (jnp.asarray(each, jnp.float32) for each in (x, y))
        seen = evaluate_points(filled.look, material, x, y, rows=4)
        return seen, evaluate_points(filled.height, material, x, y, rows=4)

    one = see(starts[0][0], starts[1][0])
    for other in (see(starts[0][1], starts[1][0]), see(starts[0][0], starts[1][1])):
        np.testing.assert_array_equal(one[0].roughness, other[0].roughness)  # of the wood alone, bit for bit
        np.testing.assert_array_equal(one[0].tile_id, other[0].tile_id)
        np.testing.assert_allclose(one[0].base_colour, other[0].base_colour, atol=1e-5)
        np.testing.assert_allclose(one[1], other[1], atol=1e-4)
        whole = np.asarray(one[0].joint) == 0
        whole &= np.asarray(other[0].joint) == 0
        np.testing.assert_array_equal(np.asarray(one[0].base_colour)[whole], np.asarray(other[0].base_colour)[whole])


def test_tiles_are_cut_elsewhere_each_and_the_same_at_any_resolution():
    sheet = lay_sheet(make_boards(offset=0.0), tiles=(3, 4))
    small, large = (render(sheet, (180 * times, 80 * times)).base_colour for times in (2, 4))
    halved = large.reshape(160, 2, 360, 2, 3).mean(axis=(1, 3))
    assert np.abs(halved - small).mean() < 0.01
    tiles = small.mean(axis=2).reshape(4, 40, 3, 120).swapaxes(1, 2).reshape(12, 40, 120)[:, 6:34, 8:112]
    tiles = tiles - tiles.mean(axis=(1, 2), keepdims=True)
    tiles /= np.sqrt((tiles**2).sum(axis=(1, 2), keepdims=True))
    alike = np.einsum("nyx,myx->nm", tiles, tiles) - np.eye(12)
    assert alike.max() < 0.9


def test_tiles_are_cut_where_the_photograph_shows_the_trunk():
    # A photograph on which rings were seen 20 pixels off: only there is the wood of two tones.
    field = Displacement(jnp.array([[20.0]]), jnp.array([256.0, 256.0]), jnp.zeros(2), jnp.array(0.0))
    wood = dataclasses.replace(OAK, displacement=field)
    sheet = lay_sheet(make_boards(), tiles=(6, 8))
    material = make_material(sheet, GREY, None, size=(360, 160), key=KEY, timber=Timber(wood, (256, 256)))
    tile_wood = material.wood
    count = sheet.table().tile.size
    for corner in ((0, 0), (59, 0), (0, 19), (59, 19)):
        at = np.asarray(tile_wood.start)[:count] + np.array(corner)
        points = np.stack([np.asarray(tile_wood._place(n, jnp.asarray(place))) for n, place in enumerate(at)])
        # The rectangle of the photograph, turned to the grain, is a little more than the photograph.
        c, s = np.cos(0.4), np.sin(0.4)
        aside = np.abs(points[:, :2] @ np.array([[c, -s], [s, c]]))
        assert (aside <= 128 * (c + s) + 1e-3).all()
        assert (np.abs(points[:, 2]) <= 0.05 * 256).all()


def test_the_scale_makes_rings_broader():
    sheet = lay_sheet(make_boards(tile_width=120.0, tile_height=100.0, mortar_x=0.0, mortar_y=0.0), tiles=(2, 2))
    plain = dataclasses.replace(
        OAK, ring_spacing=jnp.array(6.0), center=jnp.array([900.0, 0.0]), turbulence_rms=jnp.array(0.0)
    )

    def crossings(scale):
        early = render(sheet, (120, 100), Timber(plain, (512, 512), scale)).roughness
        return np.sum(np.diff(early[:48, 30] > 0.575))

    assert crossings(2.0) == pytest.approx(0.5 * crossings(1.0), abs=2)


def test_a_finish_takes_the_place_of_the_woods_own_shine():
    sheet = lay_sheet(make_boards(), tiles=(2, 2))
    glazed = dataclasses.replace(GREY, tile_roughness=0.12)
    maps = render(sheet, (240, 80), Timber(OAK, (256, 256), bare=False), glazed)
    on_face, _ = faces(sheet, (240, 80))
    np.testing.assert_allclose(maps.roughness[on_face], 0.12, atol=1e-6)
