"""Exhaustive search in wavefronts: that it is the loop over pixels; trees that lead home."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_synthesis import synthesise_plain_wei_levoy

from jaxtex.synthesis.sources import copy_sources
from jaxtex.synthesis.wei_levoy import coarsening, halve, synthesise_wei_levoy, wei_levoy_steps
from jaxtex.synthesis.wei_levoy_tree import grow_tree

KEY = jax.random.key(3)

# (rows, columns), radius, levels, (rows, columns) of the exemplar, channels. The last is so large that colours are
# coarsened.
SIZES = [
    ((6, 9), 1, 1, (6, 5), 1),
    ((9, 1), 2, 1, (7, 8), 3),
    ((1, 7), 1, 2, (7, 6), 5),
    ((7, 6), 2, 3, (20, 19), 2),
    ((5, 6), 6, 1, (14, 15), 5),
]


def draw_exemplar(seed: int, shape: tuple[int, int], channels: int) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 4, (*shape, channels)) / 3


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 2**31 - 1), size=st.sampled_from(SIZES))
def test_is_the_loop_over_pixels(seed: int, size: tuple) -> None:
    shape, radius, levels, exemplar_shape, channels = size
    exemplar, key = draw_exemplar(seed, exemplar_shape, channels), jax.random.key(seed)
    made = synthesise_wei_levoy(exemplar, shape, key=key, radius=radius, levels=levels)
    expected = synthesise_plain_wei_levoy(exemplar, shape, key=key, radius=radius, levels=levels)
    np.testing.assert_array_equal(made, expected)


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 2**31 - 1), count=st.integers(1, 60), values=st.integers(1, 200))
def test_vectors_lead_to_themselves(seed: int, count: int, values: int) -> None:
    vectors = np.random.default_rng(seed).integers(0, values, (count, 3), dtype=np.int32)
    tree = grow_tree(vectors)
    padded = jnp.asarray(np.concatenate([vectors, np.zeros((60 - count, 3), np.int32)]))
    found = np.asarray(tree.descend(padded, jnp.ones((60, 3), bool)))[:count]
    np.testing.assert_array_equal(vectors[found], vectors)
    assert all(index == np.flatnonzero((vectors == vectors[index]).all(axis=1))[0] for index in found)


def test_trees_find_what_is_similar() -> None:
    random = np.random.default_rng(0)
    vectors = random.integers(-128, 128, (20, 12)).repeat(30, axis=0) + random.integers(-9, 9, (600, 12))
    queries = vectors[::7] + random.integers(-5, 5, vectors[::7].shape)
    found = np.asarray(grow_tree(vectors.astype(np.int32)).descend(jnp.asarray(queries), jnp.ones(queries.shape, bool)))
    distance = np.square(queries[:, None] - vectors[None]).sum(axis=2)
    chance = distance.mean()
    assert distance[np.arange(len(queries)), found].mean() < distance.min(axis=1).mean() + 0.02 * chance


def test_a_tree_goes_on_with_what_it_has_begun() -> None:
    stripes = np.repeat(np.arange(24) % 6 / 5, 24).reshape(24, 24, 1).swapaxes(0, 1)
    sources = np.asarray(synthesise_wei_levoy(stripes, (20, 25), key=KEY, radius=3, search="tree"))
    texture = stripes[sources[..., 0], sources[..., 1], 0]
    np.testing.assert_allclose(texture, np.broadcast_to(texture[:1], texture.shape))


def test_coarse_levels_are_shown_at_full_size() -> None:
    exemplar = draw_exemplar(0, (21, 24), 3)
    steps = list(wei_levoy_steps(exemplar, (11, 7), key=KEY, radius=2, levels=3))
    assert [each[:2] for each in steps] == [(1, 3), (2, 3), (3, 3)]
    for each in steps:
        assert copy_sources(exemplar, each.sources).shape == (11, 7, 3)
    coarse = steps[0].sources
    np.testing.assert_array_equal(coarse[:4, :4] - coarse[:1, :1], np.moveaxis(np.indices((4, 4)), 0, -1))


def test_halving_keeps_what_is_even_and_blurs_the_rest() -> None:
    np.testing.assert_allclose(halve(np.full((5, 8, 2), 0.3, np.float32)), np.full((3, 4, 2), 0.3), rtol=1e-6)
    dot = np.zeros((9, 9, 1), np.float32)
    dot[4, 4] = 1
    expected = np.outer([0, 1, 6, 1, 0], [0, 1, 6, 1, 0]) / 256
    np.testing.assert_allclose(halve(dot)[..., 0], expected, atol=1e-7)


@pytest.mark.parametrize("components", [1, 341, 342, 1000, 5000])
def test_sums_are_exact(components: int) -> None:
    levels = 128 >> coarsening(components)
    assert components * (2 * levels * levels + levels * levels) < 2**24


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"exemplar": np.zeros((8, 20, 3))}, "holds no neighbourhood of 9 x 9"),
        ({"levels": 2}, "holds no neighbourhood of 9 x 9"),
        ({"levels": 0}, "levels: 0"),
        ({"search": "quick"}, "give 'full' or 'tree'"),
        ({"shape": (3, 0)}, "each at least 1"),
        ({"exemplar": np.full((9, 9, 1), np.inf)}, "NaN or infinite"),
    ],
)
def test_complaints(options: dict, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        synthesise_wei_levoy(**{"exemplar": np.zeros((12, 12, 3)), "shape": (6, 8), "key": KEY, **options})
