"""What is inside of tiles: drawn on a wall, and learnt from it."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxtex.core.colour import srgb_to_linear
from jaxtex.core.errors import InputError
from jaxtex.material.interiors import measure_interiors
from jaxtex.material.measure import measure_appearance
from jaxtex.material.regions import Regions
from jaxtex.models.tiling import make_tiling

HEIGHT, WIDTH = 158, 258
WALL = make_tiling(tile_width=50.0, tile_height=30.0, mortar_x=6.0, mortar_y=6.0, origin=(4.0, 4.0))
PLACES = [(course, tile) for course in range(5) for tile in range(5)]


def draw_wall(*, shift=None, strength=0.03, stain=None):
    """A photograph of `WALL` (linear light) and its mask.

    Each tile has its own colour, and grain of its own strength; its edges are moved by `shift` [course, tile, side].
    """
    random = np.random.default_rng(0)
    shift = np.zeros((5, 5, 4)) if shift is None else shift
    strength = np.broadcast_to(strength, (5, 5))
    encoded = np.full((HEIGHT, WIDTH, 3), 0.75) + random.normal(0, 0.01, (HEIGHT, WIDTH, 1))
    mask = np.zeros((HEIGHT, WIDTH), np.float32)
    y, x = np.indices((HEIGHT, WIDTH)) + 0.5
    for course, tile in PLACES:
        left, right, top, bottom = shift[course, tile]
        across = (x > 7 + 50 * tile - left) & (x < 51 + 50 * tile + right)
        here = across & (y > 7 + 30 * course - top) & (y < 31 + 30 * course + bottom)
        colour = np.array([0.5, 0.35, 0.3]) + random.uniform(-0.05, 0.05)
        encoded[here] = colour + random.normal(0, strength[course, tile], (int(here.sum()), 1))
        mask[here] = 1
    if stain is not None:
        encoded[stain] = 0.95
    return srgb_to_linear(np.clip(encoded, 0, 1)).astype(np.float32), mask


def measure(photo, mask, **options):
    return measure_interiors(photo, WALL, measure_appearance(photo, WALL, mask=mask), mask=mask, **options)


def test_all_whole_tiles_are_measured_and_nothing_is_made_up():
    found = measure(*draw_wall())
    assert sorted(map(tuple, found.places.tolist())) == PLACES
    assert np.abs(found.shift).max() < 0.6
    assert found.wobble < 0.3
    assert not found.kind.any()
    np.testing.assert_allclose(found.contrast, 1, atol=0.15)
    (grain,) = found.tile_grain
    assert grain.std() == pytest.approx(0.03, rel=0.1)
    assert np.abs(grain.mean(axis=(0, 1, 2))).max() < 0.004
    assert np.abs(found.tile_profile).max() < 0.02
    assert np.abs(found.joint_profile).max() < 0.02


def test_edges_are_found_where_they_were_drawn():
    shift = np.random.default_rng(1).integers(-2, 3, (5, 5, 4)).astype(float)
    shift[:, 1:, 0] = -shift[:, :-1, 1]  # joints are as thick as the tiling has them
    found = measure(*draw_wall(shift=shift))
    own = np.array([shift[place] for place in map(tuple, found.places.tolist())])
    limited = np.stack([*own.T[:2], *np.minimum(own.T[2:], 0.375 * 6)], axis=-1)
    np.testing.assert_allclose(found.shift, limited - np.median(own), atol=0.8)


def test_tiles_are_on_the_average_as_large_as_the_tiling_has_them():
    shift = np.ones((5, 5, 4))
    shift[2, 2] = -1.0
    found = measure(*draw_wall(shift=shift))
    odd = np.all(found.places == 2, axis=1)
    np.testing.assert_allclose(found.shift[~odd], 0, atol=0.3)
    np.testing.assert_allclose(found.shift[odd], -2, atol=0.3)


def test_joints_are_never_closed():
    found = measure(*draw_wall(shift=np.tile([3.0, 3.0, 0.0, 0.0], (5, 5, 1))))
    number = {place: n for n, place in enumerate(map(tuple, found.places.tolist()))}
    for (course, tile), n in number.items():
        if (course, tile + 1) in number:
            assert found.shift[n, 1] + found.shift[number[course, tile + 1], 0] <= 0.75 * 6 + 1e-4


def test_contrast_is_that_of_each_tile():
    strength = np.linspace(0.02, 0.05, 25).reshape(5, 5)
    found = measure(*draw_wall(strength=strength))
    expected = np.array([strength[place] for place in map(tuple, found.places.tolist())])
    np.testing.assert_allclose(found.contrast, expected / np.median(expected), rtol=0.12)


def test_tiles_of_a_chessboard_have_two_sorts():
    photo, mask = draw_wall()
    y, x = np.indices((HEIGHT, WIDTH))
    dark = (((y - 4) // 30 + (x - 4) // 50) % 2 == 1) & (mask > 0)
    photo[dark] *= 0.2
    found = measure(photo, mask)
    parity = found.places.sum(axis=1) % 2
    assert not set(found.kind[parity == 0]) & set(found.kind[parity == 1])
    assert len(found.tile_grain) == len(np.unique(found.kind)) >= 2


def test_only_clean_tiles_are_learnt_from():
    stain = np.zeros((HEIGHT, WIDTH), bool)
    stain[74:84, 114:139] = True  # in tile (2, 2)
    assert max(grain.max() for grain in measure(*draw_wall(stain=stain)).tile_grain) < 0.2


def test_a_picture_without_a_whole_tile_has_no_interiors():
    photo, mask = draw_wall()
    appearance = measure_appearance(photo, WALL, mask=mask)
    assert measure_interiors(photo[:28, :48], WALL, appearance, mask=mask[:28, :48]) is None


def test_grey_photographs_have_grey_interiors():
    photo, mask = draw_wall()
    found = measure(photo.mean(axis=2, keepdims=True), mask)
    assert np.ptp(found.tile_grain[0], axis=-1).max() < 1e-5


def test_rectangles_take_the_place_of_clean_tiles():
    photo, mask = draw_wall(strength=0.02)
    motley = photo[70:82, 110:146]  # in tile (2, 2)
    motley *= np.random.default_rng(5).uniform(0.9, 1.1, motley.shape).astype(np.float32)
    told = measure(photo, mask, regions=Regions(tiles=((110.0, 70.0, 36.0, 12.0),)))
    usual = measure(photo, mask)
    assert len(told.tile_grain) == 1
    assert told.tile_grain[0].shape[0] == 1
    assert told.tile_grain[0].shape[1] <= 12
    alike = [
        np.corrcoef(each.tile_grain[0][..., 0].ravel(), each.tile_grain[0][..., 1].ravel()) for each in (told, usual)
    ]
    assert alike[0][0, 1] < 0.8 < 0.95 < alike[1][0, 1]
    assert not told.kind.any()
    joint = measure(photo, mask, regions=Regions(joints=((20.0, 32.0, 60.0, 4.0),))).joint_grain
    assert joint.shape == (1, 4, 60, 3)
    with pytest.raises(InputError, match="tile region 0,0,5x5: is in no tile"):
        measure(photo, mask, regions=Regions(tiles=((0.0, 0.0, 5.0, 5.0),)))


def test_painted_tiles_give_their_kind_to_those_like_them():
    photo, mask = draw_wall()
    left = np.arange(WIDTH) < 104
    photo[:, left] *= 0.3  # the first two columns of tiles
    painted = np.zeros((HEIGHT, WIDTH), np.int32)
    painted[4:34, 4:54] = 1  # a dark one
    painted[4:34, 154:204] = 2  # a light one
    found = measure(photo, mask, regions=Regions(painted=painted))
    assert [len(grain) for grain in found.tile_grain] == [1, 1]
    assert np.array_equal(found.kind == 1, found.places[:, 1] >= 2)
    # Numbers of kinds need not be without gaps.
    again = measure(photo, mask, regions=Regions(painted=painted * 3))
    assert np.array_equal(again.kind, found.kind)
    with pytest.raises(InputError, match="painted regions: cover no tile that the photograph shows as a whole"):
        measure(photo, mask, regions=Regions(painted=(painted == 1) * (np.arange(WIDTH) < 25).astype(np.int32)))


def test_a_turned_wall_has_the_interiors_of_an_upright_one():
    turned = make_tiling(tile_width=50.0, tile_height=30.0, mortar_x=6.0, mortar_y=6.0, angle=0.4, origin=(60.0, 20.0))
    y, x = np.indices((HEIGHT, WIDTH)) + 0.5
    q = jax.vmap(jax.vmap(turned.to_lattice))(jnp.asarray(np.stack([x, y], axis=-1), jnp.float32))
    right, down = np.mod(np.asarray(q[..., 0]), 50), np.mod(np.asarray(q[..., 1]), 30)
    mask = ((np.abs(right - 25) < 24) & (np.abs(down - 15) < 12)).astype(np.float32)  # two pixels wider on two sides
    noise = np.random.default_rng(0).normal(0, 0.03, (HEIGHT, WIDTH, 1))
    photo = srgb_to_linear(np.where(mask[..., None] > 0, 0.4 + noise, 0.75) * np.ones(3)).astype(np.float32)
    found = measure_interiors(photo, turned, measure_appearance(photo, turned, mask=mask), mask=mask)
    assert len(found.places) >= 5
    # A pixel out and a pixel in: half of it is believed, as a mask is not sure of less.
    apart = np.median(found.shift[:, :2], axis=0) - np.median(found.shift[:, 2:], axis=0)
    np.testing.assert_allclose(apart, 1, atol=0.4)
    # Between pixels splines smooth white noise a little.
    assert 0.02 < found.tile_grain[0].std() < 0.032
