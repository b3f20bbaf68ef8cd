"""Ashikhmin's synthesis in wavefronts: that it is the loop over pixels, that targets act where they are painted, and
that what should repeat does."""

import jax
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_synthesis import PlainAshikhmin

from jaxtex.synthesis.ashikhmin import ashikhmin_steps, synthesise_ashikhmin
from jaxtex.synthesis.sources import copy_sources

KEY = jax.random.key(3)

# Every size is compiled anew, so there are few. (rows, columns), radius, (rows, columns) of the exemplar, channels.
SIZES = [
    ((7, 9), 1, (6, 5), 1),
    ((9, 7), 2, (9, 8), 3),
    ((12, 1), 1, (5, 7), 5),
    ((1, 6), 2, (7, 5), 4),
    ((5, 14), 3, (9, 10), 2),
]


def draw_exemplar(seed: int, shape: tuple[int, int], channels: int) -> np.ndarray:
    """Few levels, so that distances are often equal."""
    return np.random.default_rng(seed).integers(0, 4, (*shape, channels)) / 3


def draw_similar(seed: int, shape: tuple[int, int], radius: int, count: int) -> np.ndarray:
    random = np.random.default_rng(seed)
    rows, columns = (random.integers(radius, side - radius, (*shape, count)) for side in shape)
    similar = np.stack([rows, columns], axis=-1).astype(np.int32)
    valid = np.stack(np.meshgrid(*(np.clip(np.arange(s), radius, s - 1 - radius) for s in shape), indexing="ij"), -1)
    similar[:, :, 0] = valid
    return similar


seeds = st.integers(0, 2**31 - 1)
sizes = st.sampled_from(SIZES)


def check(options: dict, seed: int, size: tuple, passes: int = 1) -> None:
    shape, radius, exemplar_shape, channels = size
    exemplar = draw_exemplar(seed, exemplar_shape, channels)
    options = {"key": jax.random.key(seed), "radius": radius, **options}
    plain = PlainAshikhmin(exemplar, shape, **options).passes(passes)
    made = ashikhmin_steps(exemplar, shape, passes=passes, **options)
    for expected, seen in zip(plain, made, strict=True):
        np.testing.assert_array_equal(seen.sources, expected)


@settings(max_examples=10, deadline=None)
@given(seed=seeds, size=sizes, even_rows=st.booleans())
def test_is_the_loop_over_pixels(seed: int, size: tuple, even_rows: bool) -> None:
    check({"even_rows": even_rows}, seed, size)


@settings(max_examples=10, deadline=None)
@given(seed=seeds, size=st.sampled_from(SIZES[:3]))
def test_is_the_loop_with_eight_candidates_each(seed: int, size: tuple) -> None:
    check({"similar": draw_similar(seed, size[2], size[1], 8)}, seed, size)


@settings(max_examples=5, deadline=None)
@given(seed=seeds, size=st.sampled_from([SIZES[2], ((23, 21), 1, (8, 9), 3)]))
def test_is_the_loop_where_it_repeats(seed: int, size: tuple) -> None:
    check({"tileable": True}, seed, size, passes=2)


@settings(max_examples=10, deadline=None)
@given(seed=seeds, size=st.sampled_from(SIZES[:3]))
def test_is_the_loop_with_a_target(seed: int, size: tuple) -> None:
    random = np.random.default_rng(seed)
    target, painted = random.random((*size[0], size[3])), random.random(size[0]) < 0.4
    check({"target": target, "painted": painted}, seed, size, passes=2)


def test_an_empty_target_changes_nothing() -> None:
    exemplar = draw_exemplar(0, (9, 8), 3)
    target, nowhere = np.random.default_rng(1).random((9, 7, 3)), np.zeros((9, 7), bool)
    plain = ashikhmin_steps(exemplar, (9, 7), key=KEY, passes=2)
    aimed = ashikhmin_steps(exemplar, (9, 7), key=KEY, passes=2, target=target, painted=nowhere)
    for expected, seen in zip(plain, aimed, strict=True):
        np.testing.assert_array_equal(seen.sources, expected.sources)


def test_pixels_before_any_paint_stay() -> None:
    exemplar, painted = np.random.default_rng(0).random((20, 21, 3)), np.zeros((20, 21), bool)
    painted[6:, 3:] = True
    plain = np.asarray(synthesise_ashikhmin(exemplar, (20, 21), key=KEY)).reshape(-1, 2)
    target = np.zeros((20, 21, 3))
    aimed = np.asarray(synthesise_ashikhmin(exemplar, (20, 21), key=KEY, target=target, painted=painted)).reshape(-1, 2)
    first = 6 * 21 + 3
    np.testing.assert_array_equal(aimed[:first], plain[:first])
    assert (aimed[first:] != plain[first:]).any()


def test_passes_bring_the_texture_nearer_to_the_target() -> None:
    random = np.random.default_rng(0)
    exemplar = np.concatenate([random.uniform(0, 0.4, (20, 20, 1)), random.uniform(0.6, 1, (20, 20, 1))], axis=1)
    target = np.repeat(np.linspace(0, 1, 9) > 0.5, 7)[:9, None, None] * np.ones((9, 7, 1))
    distances = [
        np.square(copy_sources(exemplar, step.sources) - target).mean()
        for step in ashikhmin_steps(exemplar, (9, 7), key=KEY, target=target, passes=3)
    ]
    assert distances[0] > distances[-1]


def test_a_former_result_stands_for_the_first_pass() -> None:
    exemplar = draw_exemplar(0, (9, 8), 3)
    first, second = ashikhmin_steps(exemplar, (9, 7), key=KEY, passes=2)
    assert [first[:2], second[:2]] == [(1, 2), (2, 2)]
    again = synthesise_ashikhmin(exemplar, (9, 7), key=KEY, start=first.sources)
    np.testing.assert_array_equal(again, second.sources)


def test_tiles_meet() -> None:
    from scipy.ndimage import gaussian_filter

    noise = np.random.default_rng(0).normal(size=(64, 64, 1))
    exemplar = 0.5 + 0.1 * gaussian_filter(noise, (1.5, 1.5, 0), mode="wrap") / 0.2
    sources = np.asarray(synthesise_ashikhmin(exemplar, (60, 50), key=KEY, tileable=True))
    texture = exemplar[sources[..., 0], sources[..., 1], 0]
    for axis in (0, 1):
        energy = np.square(texture - np.roll(texture, -1, axis)).mean(1 - axis)
        assert energy[-1] < energy[:-1].max()


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"exemplar": np.zeros((4, 9, 3))}, "holds no neighbourhood of 5 x 5; give .* radius of at most 1"),
        ({"exemplar": np.zeros((9, 9))}, "give .row, col, channel."),
        ({"exemplar": np.full((9, 9, 1), np.nan)}, "NaN or infinite"),
        ({"shape": (0, 5)}, "give .rows, columns., each at least 1"),
        ({"radius": 0}, "radius: 0"),
        ({"passes": 0}, "passes: 0"),
        ({"target": np.zeros((6, 7, 3))}, "target of shape .6, 7, 3.: give .6, 8, 3."),
        ({"target": np.zeros((6, 8, 1))}, "give .6, 8, 3."),
        ({"painted": np.ones((6, 8), bool)}, "no target"),
        ({"target": np.zeros((6, 8, 3)), "painted": np.ones((6, 8))}, "give booleans"),
        ({"similar": np.zeros((9, 9, 2, 2), int)}, "reach beyond the exemplar"),
        ({"similar": np.full((9, 8, 2, 2), 4)}, "similar of shape"),
        ({"start": np.full((6, 7, 2), 4)}, "start of shape"),
    ],
)
def test_complaints(options: dict, complaint: str) -> None:
    arguments = {"exemplar": np.zeros((9, 9, 3)), "shape": (6, 8), "key": KEY, **options}
    with pytest.raises(ValueError, match=complaint):
        synthesise_ashikhmin(**arguments)
