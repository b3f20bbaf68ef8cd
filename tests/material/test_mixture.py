"""Layers over maps: all of one where the mask is white, nothing where it is black, in between a mean."""

import dataclasses

import jax
import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.material.appearance import Appearance
from jaxtex.material.maps import Maps, render_maps
from jaxtex.material.mixture import keep_photograph, layer_maps, mix_maps
from jaxtex.material.placement import over_photograph, over_picture
from jaxtex.material.sheet import lay_sheet
from jaxtex.material.wood import WoodMaps
from jaxtex.models.tiling import make_tiling

SIZE = (90, 300)  # of more than two bands
GREY = Appearance(tiles={(0, 0): (0.3, 0.3, 0.3)}, joint=(0.05, 0.06, 0.07), joint_depth=2.0, edge_width=1.0)
RED = dataclasses.replace(GREY, tiles={(0, 0): (0.6, 0.1, 0.1)}, tile_metallic=1.0, tile_specular=0.2)


def bands_of(appearance=GREY, size=SIZE, **tiling):
    wall = make_tiling(**{"tile_width": 30.0, "tile_height": 20.0, "mortar_x": 4.0, "mortar_y": 3.0, **tiling})
    sheet = lay_sheet(wall, tiles=(3, 15))
    return render_maps(sheet, appearance, size=size, key=jax.random.key(0))


def whole(bands) -> Maps:
    return Maps(*(np.concatenate(part) for part in zip(*bands, strict=True)))


def lay(mask, bands=None, **options):
    placement = over_picture((mask.shape[1], mask.shape[0]), size=SIZE)
    layer = layer_maps(bands or bands_of(RED, offset=0.5), mask, placement, size=SIZE, **options)
    return whole(mix_maps(bands_of(), [layer]))


def assert_same(one: Maps, other: Maps):
    for name, first, second in zip(Maps._fields, one, other, strict=True):
        np.testing.assert_array_equal(first, second, err_msg=name)


def test_a_white_mask_shows_the_layer_alone_and_a_black_one_the_base():
    assert_same(lay(np.ones((7, 5), np.float32)), whole(bands_of(RED, offset=0.5)))
    assert_same(lay(np.zeros((7, 5), np.float32)), whole(bands_of()))


def test_in_between_all_is_mixed():
    below, above = whole(bands_of()), whole(bands_of(RED, offset=0.5))
    mixed = lay(np.full((1, 1), 0.75, np.float32))
    for name in set(Maps._fields) - {"normal", "tile_id"}:
        expected = 0.25 * getattr(below, name) + 0.75 * getattr(above, name)
        np.testing.assert_allclose(getattr(mixed, name), expected, atol=1e-6, err_msg=name)
    normal = 0.25 * below.normal + 0.75 * above.normal
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    np.testing.assert_allclose(mixed.normal, normal, atol=1e-6)
    np.testing.assert_array_equal(mixed.tile_id, above.tile_id)
    np.testing.assert_array_equal(lay(np.full((1, 1), 0.5, np.float32)).tile_id, below.tile_id)


def test_ids_of_a_layer_follow_and_joints_have_none():
    mask = np.zeros((300, 90), np.float32)
    mask[:, 45:] = 1
    base, layer = whole(bands_of()).tile_id, whole(bands_of(RED, offset=0.5)).tile_id
    ids = lay(mask, first_id=500).tile_id
    np.testing.assert_array_equal(ids[:, :45], base[:, :45])
    np.testing.assert_array_equal(ids[:, 45:], np.where(layer >= 0, layer + 500, -1)[:, 45:])


def test_heights_of_a_layer_are_scaled_and_lifted():
    white = np.ones((1, 1), np.float32)
    plain = whole(bands_of(RED, offset=0.5)).height
    np.testing.assert_allclose(lay(white, scale=1.5, lift=-0.25).height, 1.5 * plain - 0.25, atol=1e-6)


def test_larger_layers_are_cut_off_and_maps_they_have_not_are_plain():
    rng = np.random.default_rng(0)
    rows = (128, 128, 90)
    wood = [
        WoodMaps(*(rng.random((count, 111, *more), np.float32) for more in ((3,), (), (3,), (), (), ())))
        for count in rows
    ]
    mixed = lay(np.ones((1, 1), np.float32), iter(wood))
    np.testing.assert_array_equal(mixed.base_colour, np.concatenate([w.base_colour for w in wood])[:300, :90])
    np.testing.assert_array_equal(mixed.specular, np.concatenate([w.specular for w in wood])[:300, :90])
    assert (mixed.occlusion == 1).all()
    assert (mixed.tile_id == -1).all()


def test_later_layers_lie_over_earlier_ones():
    white, half = np.ones((1, 1), np.float32), np.zeros((300, 90), np.float32)
    half[:150] = 1
    place = over_picture((90, 300), size=SIZE)
    one = layer_maps(bands_of(RED), white, over_picture((1, 1), size=SIZE), size=SIZE)
    kept = keep_photograph(np.full((300, 90, 3), 0.9), half, place, size=SIZE, height=2.0)
    colour = whole(mix_maps(bands_of(), [one, kept])).base_colour
    assert (colour[:150] == np.float32(0.9)).all()
    np.testing.assert_array_equal(colour[150:], whole(bands_of(RED)).base_colour[150:])


def test_what_is_kept_of_a_photograph_lies_where_the_tiling_has_it():
    oblique = {"angle": 0.2, "origin": (21.0, 7.0), "homography": [[1, 0.05, 0], [0.02, 1.1, 0], [3e-4, 5e-4, 1.0]]}
    wall = make_tiling(tile_width=30.0, tile_height=20.0, **oblique)
    image = (120, 160)
    middle = np.asarray(wall.to_lattice(np.array([60.0, 80.0], np.float32)))
    sheet = lay_sheet(wall, tiles=(3, 5), near=tuple(middle - np.array([45.0, 50.0])))
    size = (180, 200)
    y, x = np.indices((160, 120)) + 0.5
    photo = np.stack([x / 120, y / 160, np.full_like(x, 0.25)], axis=-1)
    mask = (np.hypot(x - 60, y - 80) < 25).astype(float)
    kept = keep_photograph(photo, mask, over_photograph(sheet, wall, image=image, size=size), size=size, height=1.5)
    base = render_maps(sheet, GREY, size=size, key=jax.random.key(0))
    mixed = whole(mix_maps(base, [kept]))
    seen = 0
    for row, col in np.ndindex(size[1] // 5, size[0] // 5):
        row, col = 5 * row, 5 * col
        q = np.array([(col + 0.5) * sheet.width / size[0], (row + 0.5) * sheet.height / size[1]]) + sheet.corner
        u, v = np.asarray(wall.from_lattice(q.astype(np.float32)))
        if np.hypot(u - 60, v - 80) < 23:
            seen += 1
            np.testing.assert_allclose(mixed.base_colour[row, col], [u / 120, v / 160, 0.25], atol=1e-3)
            assert mixed.height[row, col] == 1.5
            assert mixed.roughness[row, col] == np.float32(0.7)
            assert mixed.normal[row, col].tolist() == [0, 0, 1]
            assert mixed.tile_id[row, col] == -1
        elif np.hypot(u - 60, v - 80) > 27:
            assert mixed.roughness[row, col] != np.float32(0.7)
    assert seen > 50


def test_colours_beside_what_is_kept_do_not_bleed_into_it():
    photo = np.zeros((32, 32, 3))
    photo[:, 16:] = 1.0
    mask = np.zeros((32, 32))
    mask[:, 16:] = 1.0
    for size in ((5, 32), (97, 32)):  # smaller, larger
        layer = keep_photograph(photo, mask, over_picture((32, 32), size=size), size=size, height=0.0)
        seen = next(layer)
        assert ((seen.share > 0) & (seen.share < 1)).any()
        np.testing.assert_allclose(seen.maps.base_colour[seen.share > 0.01], 1.0, atol=1e-5)


def test_a_photograph_in_grey_is_kept_too_and_its_mask_must_fit():
    seen = next(keep_photograph(np.full((4, 4, 1), 0.3), np.ones((4, 4)), np.eye(3), size=(4, 4), height=0.0))
    np.testing.assert_allclose(seen.maps.base_colour, 0.3, atol=1e-6)
    with pytest.raises(InputError, match="mask is 3 x 4 pixels"):
        keep_photograph(np.zeros((4, 4, 3)), np.ones((4, 3)), np.eye(3), size=(4, 4), height=0.0)
