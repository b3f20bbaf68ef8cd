"""Colours of tiles: their own where seen, drawn like the others where not, and the way to a model file and back."""

import json

import jax
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jaxtex.core.colour import linear_to_srgb
from jaxtex.core.errors import InputError
from jaxtex.material.appearance import Appearance, appearance_from_json, appearance_of, choose_relief, quantise
from jaxtex.models.files import SourceImage, TilingFile
from jaxtex.models.tiling import make_tiling

KEY = jax.random.key(7)
CHESS = ((0, 1), (1, 0))
REPORT = {"ok": True, "reason": "", "iou": None, "start": None, "standard_errors": {}}


def make_appearance(colours, pattern=((0,),), **changes):
    """Tiles of course 0 and on, four to a course."""
    tiles = {(n // 4, n % 4): quantise(colour) for n, colour in enumerate(colours)}
    return Appearance(tiles=tiles, joint=quantise((0.5, 0.5, 0.5)), pattern=pattern, **changes)


def random_colours(count, seed=0):
    return np.random.default_rng(seed).uniform(0.05, 0.6, (count, 3))


def test_tiles_that_were_seen_keep_their_colours():
    appearance = make_appearance(random_colours(12))
    course, tile = np.indices((3, 4))
    colours = appearance.colours(course, tile, key=KEY)
    assert np.array_equal(colours.reshape(-1, 3), np.array(list(appearance.tiles.values()), np.float32))


def test_a_drawn_colour_depends_on_key_and_tile_alone():
    appearance = make_appearance(random_colours(12))
    course, tile = np.meshgrid(np.arange(-9, 9), np.arange(-20, 20), indexing="ij")
    together = appearance.colours(course, tile, key=KEY)
    some = appearance.colours(course[3:5, 7:30:5], tile[3:5, 7:30:5], key=KEY)
    assert np.array_equal(together[3:5, 7:30:5], some)
    assert np.array_equal(appearance.colours(-9, -20, key=KEY), together[0, 0])
    others = appearance.colours(course, tile, key=jax.random.key(8))
    seen = (course >= 0) & (course < 3) & (tile >= 0) & (tile < 4)
    assert np.array_equal(np.all(others == together, axis=-1), seen)


def test_drawn_colours_have_mean_and_covariance_of_the_seen_ones():
    appearance = make_appearance(random_colours(40))
    drawn = appearance.colours(np.full(40_000, 1000), np.arange(40_000), key=KEY)
    seen = np.array(list(appearance.tiles.values()))

    def logits(colours):
        encoded = linear_to_srgb(colours.astype(np.float64))
        return np.log(encoded / (1 - encoded))

    np.testing.assert_allclose(logits(drawn).mean(axis=0), logits(seen).mean(axis=0), atol=0.03)
    covariance = np.cov(logits(seen).T, bias=True)
    np.testing.assert_allclose(np.cov(logits(drawn).T), covariance, atol=0.03 * covariance.max())


def test_drawn_colours_stay_near_seen_ones_however_odd_these_are():
    odd = [(0.9, 0.02, 0.02), (0.02, 0.9, 0.02), (0.02, 0.02, 0.9), (0.9, 0.9, 0.02)] * 3
    drawn = make_appearance(odd).colours(np.full(2000, -5), np.arange(2000), key=KEY)
    nearest = np.abs(linear_to_srgb(drawn)[:, None] - linear_to_srgb(np.array(odd))[None]).max(axis=-1).min(axis=1)
    assert np.quantile(nearest, 0.95) < 0.2


def test_drawn_colours_follow_the_pattern():
    course, tile = np.indices((3, 4)).reshape(2, -1)
    colours = np.where((course + tile) % 2, 0.8, 0.1)[:, None] * np.array([1.0, 0.9, 0.8])
    colours = colours * np.random.default_rng(0).uniform(0.95, 1.05, (12, 1))
    drawn = make_appearance(colours, CHESS).colours(*np.indices((30, 30)) - 40, key=KEY)
    course, tile = np.indices((30, 30))
    assert np.array_equal(drawn[..., 0] > 0.4, (course + tile) % 2 == 1)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 1000), st.sampled_from([0.0, 1e-4, 0.5, 1.0]))
def test_colours_stay_in_range_and_greys_stay_grey(seed, level):
    greys = np.clip(level + np.random.default_rng(seed).uniform(-0.3, 0.3, (5, 1)), 0, 1) * np.ones(3)
    drawn = make_appearance(greys).colours(np.full(50, 9), np.arange(50), key=jax.random.key(seed))
    assert drawn.min() >= 0
    assert drawn.max() <= 1
    assert np.ptp(linear_to_srgb(drawn), axis=-1).max() < 1e-3


def test_a_class_that_was_not_seen_takes_the_colours_of_all():
    drawn = make_appearance([(0.2, 0.1, 0.05)], CHESS).colours([0, 0, 1], [0, 1, 0], key=KEY)
    np.testing.assert_allclose(drawn, np.tile(quantise((0.2, 0.1, 0.05)), (3, 1)), rtol=1e-3)


def test_the_way_through_json_loses_nothing():
    appearance = make_appearance(
        random_colours(7), CHESS, joint_depth=3.25, edge_width=1.5, tile_roughness=0.2, joint_roughness=1.0
    )
    del appearance.tiles[0, 2]
    assert appearance_from_json(json.loads(json.dumps(appearance.to_json()))) == appearance


def damaged(**changes):
    return {**make_appearance(random_colours(2)).to_json(), **changes}


@pytest.mark.parametrize(
    ("data", "complaint"),
    [
        (damaged(joint="grey"), "'grey' is no colour; write it as #rrggbb"),
        (damaged(joint=[1, 2, 3]), "is no colour"),
        (damaged(tile_roughness=1.5), "tile_roughness must be a number from 0 to 1, not 1.5"),
        (damaged(joint_depth=-1), "joint_depth must be a number from 0"),
        (damaged(edge_width="2"), "edge_width must be a number"),
        (damaged(edge_width=True), "edge_width must be a number"),
        (damaged(pattern=[]), "pattern must be a table"),
        (damaged(pattern=[[0, 1], [1]]), "pattern must be a table"),
        (damaged(pattern=[[0, -1]]), "pattern must be a table"),
        (damaged(pattern=3), "not laid out"),
        (damaged(tiles=[]), "tiles holds no colour"),
        (damaged(tiles=[{"course": 0, "first": 0, "colours": [None]}]), "tiles holds no colour"),
        (damaged(tiles=[{"course": 0, "colours": ["#ffffff"]}]), "lacks 'first'"),
        (damaged(tiles=[{"course": "up", "first": 0, "colours": ["#ffffff"]}]), "whole number"),
        (damaged(tiles=[{"course": 0.5, "first": 0, "colours": ["#ffffff"]}]), "whole number"),
        (damaged(tiles=[{"course": 10**12, "first": 0, "colours": ["#ffffff"]}]), "whole number"),
        (damaged(tiles=3), "not laid out"),
        ({}, "lacks"),
    ],
)
def test_what_is_wrong_in_a_file_is_named(data, complaint):
    with pytest.raises(InputError, match=r"^appearance: ") as error:
        appearance_from_json(data)
    assert complaint in str(error.value)


def test_a_model_file_without_appearance_is_grey_with_joints_by_its_mortar():
    tiling = make_tiling(tile_width=60.0, tile_height=20.0, mortar_x=6.0, mortar_y=4.0)
    appearance = appearance_of(TilingFile(tiling, SourceImage(64, 48, "0" * 64), 2, 1, REPORT))
    assert (appearance.joint_depth, appearance.edge_width) == choose_relief(tiling) == (2.0, 2.0)
    assert appearance.joint > next(iter(appearance.tiles.values()))


@pytest.mark.parametrize(("mortar", "depth", "edge"), [(0.0, 0.0, 0.0), (10.0, 4.0, 2.5)])
def test_edges_reach_into_a_tile_by_a_quarter_at_most(mortar, depth, edge):
    assert choose_relief(make_tiling(tile_width=60.0, tile_height=20.0, mortar_x=mortar, mortar_y=mortar)) == (
        depth,
        edge,
    )
