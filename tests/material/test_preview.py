"""The material under a lamp from the upper left."""

import jax
import numpy as np
import pytest

from jaxtex.material.appearance import Appearance
from jaxtex.material.maps import Maps, render_maps
from jaxtex.material.preview import shade_maps
from jaxtex.material.sheet import lay_sheet
from jaxtex.models.tiling import make_tiling

SIZE = (192, 128)


def make_maps(*, depth=3.0, edge=3.0, roughness=0.6, mortar=8.0, tile=0.4):
    wall = make_tiling(tile_width=96.0, tile_height=64.0, mortar_x=mortar, mortar_y=mortar)
    appearance = Appearance(
        tiles={(0, 0): (tile, tile, tile)},
        joint=(tile, tile, tile),
        joint_depth=depth,
        edge_width=edge,
        tile_roughness=roughness,
        joint_roughness=roughness,
    )
    sheet = lay_sheet(wall, tiles=(2, 2))
    bands = render_maps(sheet, appearance, size=SIZE, key=jax.random.key(0))
    return Maps(*(np.concatenate(part) for part in zip(*bands, strict=True)))


def test_edges_towards_the_lamp_are_lit_and_those_away_from_it_are_not():
    lit = shade_maps(make_maps(), pixel=1.0).mean(axis=-1)
    face, left, right = lit[32, 48], lit[32, 4:8].max(), lit[32, 88:92].min()
    top, bottom = lit[4:8, 48].max(), lit[56:60, 48].min()
    assert min(left, top) > 1.1 * face
    assert max(right, bottom) < 0.8 * face


def test_tiles_throw_shadows_into_the_joints_on_their_far_side():
    lit = shade_maps(make_maps(depth=8.0, edge=1.0, mortar=20.0), pixel=1.0).mean(axis=-1)
    joint = lit[32, 86:106]  # between two tiles; the left one is between it and the lamp
    assert joint[2:5].mean() < 0.6 * joint[14:17].mean()


def test_the_lamp_is_nearer_to_the_upper_left():
    lit = shade_maps(make_maps(depth=0.0), pixel=1.0).mean(axis=-1)
    assert np.all(np.diff(lit, axis=1) <= 1e-6)
    assert np.all(np.diff(lit, axis=0) <= 1e-6)
    assert lit[0, 0] > 1.2 * lit[-1, -1] > 0


def test_smooth_tiles_shine_and_rough_ones_do_not():
    smooth, rough = (shade_maps(make_maps(depth=0.0, roughness=value, tile=0.02), pixel=1.0) for value in (0.2, 1.0))
    assert smooth.max() / smooth.min() > 1.5 * rough.max() / rough.min()


@pytest.mark.parametrize("tile", [0.0, 0.02, 0.4, 1.0])
def test_light_stays_in_range_for_every_material(tile):
    lit = shade_maps(make_maps(tile=tile), pixel=1.0)
    assert lit.shape == (128, 192, 3)
    assert lit.dtype == np.float32
    assert lit.min() >= 0
    assert lit.max() <= 1
    assert (lit == 1).mean() < 0.02
