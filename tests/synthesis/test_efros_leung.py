"""Tests of `jaxtex.synthesis.efros_leung`: against a plain loop, and on textures whose continuation is known."""

from typing import Any

import jax
import numpy as np
import pytest

from jaxtex.synthesis.efros_leung import efros_leung_steps, schedule_pixels, synthesise_efros_leung

KEY = jax.random.key(5)


def noise(*shape: int) -> np.ndarray:
    return np.random.default_rng(0).random(shape)


def weights_by_hand(radius: int) -> np.ndarray:
    """Gaussian integers, 16 in the middle, which is left out; at least 1 next to it."""
    steps = np.arange(-radius, radius + 1)
    squared = steps[:, None] ** 2 + steps[None] ** 2
    weights = np.rint(16 * np.exp(-squared / (2 * ((2 * radius + 1) / 6.4) ** 2))).astype(int)
    weights[squared <= 2] = np.maximum(weights[squared <= 2], 1)
    weights[squared == 0] = 0
    return weights


def layers_by_hand(known: np.ndarray) -> np.ndarray:
    """After how many times that known pixels made their eight neighbours known each is."""
    layers, reached = np.zeros(known.shape, int), known.copy()
    while not reached.all():
        around = np.pad(reached, 1)
        near = [around[r : r + known.shape[0], c : c + known.shape[1]] for r, c in np.ndindex(3, 3)]
        reached = np.any(near, axis=0)
        layers += ~reached
    return layers + ~known


def grow_by_hand(
    exemplar: np.ndarray,
    shape: tuple[int, int],
    radius: int,
    tolerance: float,
    start: tuple[np.ndarray, np.ndarray] | None = None,
    usable: np.ndarray | None = None,
) -> np.ndarray:
    """The same one pixel after another, with sums of integers."""
    weights = weights_by_hand(radius)
    steps = min(255, 2 * int(np.sqrt(2**24 // (weights.sum() * exemplar.shape[2]))) - 1)
    levels = np.rint(exemplar * steps).astype(int)
    usable = np.ones(exemplar.shape[:2], bool) if usable is None else usable
    within = [
        (r, c)
        for r, c in np.ndindex(*usable.shape)
        if min(r, c, usable.shape[0] - 1 - r, usable.shape[1] - 1 - c) >= radius
        and usable[r - radius : r + radius + 1, c - radius : c + radius + 1].all()
    ]
    canvas = np.zeros((*shape, exemplar.shape[2]), int)
    known = np.zeros(shape, bool)
    sources = np.full((*shape, 2), -1)
    if start is not None:
        canvas, known = np.rint(start[0] * steps).astype(int), start[1].copy()
    if not known.any():
        seed = within[int(jax.random.randint(jax.random.fold_in(KEY, known.size), (), 0, len(within)))]
        for r, c in np.ndindex(3, 3):
            to = shape[0] // 2 + r - 1, shape[1] // 2 + c - 1
            if 0 <= to[0] < shape[0] and 0 <= to[1] < shape[1]:
                sources[to], known[to] = (seed[0] + r - 1, seed[1] + c - 1), True
                canvas[to] = levels[tuple(sources[to])]
    turn = np.random.default_rng(0).permutation((radius + 1) ** 2).reshape(radius + 1, radius + 1)
    layers = layers_by_hand(known)
    order = sorted(
        zip(*np.nonzero(~known), strict=True), key=lambda at: (layers[at], turn[at[0] % len(turn), at[1] % len(turn)])
    )
    around = np.pad(canvas, [(radius, radius), (radius, radius), (0, 0)])
    seen = np.pad(known, radius)
    for r, c in order:
        box = np.s_[r : r + 2 * radius + 1, c : c + 2 * radius + 1]
        weight = (weights * seen[box])[..., None]
        errors = np.array(
            [
                (weight * (levels[y - radius : y + radius + 1, x - radius : x + radius + 1] - around[box]) ** 2).sum()
                for y, x in within
            ]
        )
        near = np.flatnonzero(errors.astype(np.float32) <= np.float32(1 + np.float32(tolerance)) * errors.min())
        key = jax.random.fold_in(KEY, int(r * shape[1] + c))
        sources[r, c] = within[near[int(jax.random.randint(key, (), 0, len(near)))]]
        around[r + radius, c + radius], seen[r + radius, c + radius] = levels[tuple(sources[r, c])], True
    return sources


@pytest.mark.parametrize(
    ("exemplar", "shape", "radius", "tolerance"),
    [((14, 12, 3), (17, 20), 3, 0.1), ((9, 15, 1), (13, 4), 1, 0.5), ((16, 17, 4), (2, 9), 5, 0.0)],
)
def test_it_is_the_plain_loop_bit_for_bit(
    exemplar: tuple[int, ...], shape: tuple[int, int], radius: int, tolerance: float
) -> None:
    pixels = np.round(noise(*exemplar) * 3) / 3  # of few colours, so that there is a choice
    made = synthesise_efros_leung(pixels, shape, key=KEY, radius=radius, tolerance=tolerance)
    assert made.dtype == np.int32
    np.testing.assert_array_equal(made, grow_by_hand(pixels, shape, radius, tolerance))


def test_holes_are_the_plain_loop_bit_for_bit() -> None:
    pixels, picture = noise(14, 13, 3), noise(12, 15, 3)
    known, usable = noise(12, 15) > 0.6, np.ones((14, 13), bool)
    usable[10:, 4:7] = False
    made = synthesise_efros_leung(pixels, (12, 15), key=KEY, radius=2, picture=picture, known=known, usable=usable)
    np.testing.assert_array_equal(made, grow_by_hand(pixels, (12, 15), 2, 0.1, (picture, known), usable))
    assert (made[known] == -1).all()
    assert not ((made[~known][:, 0] >= 8) & (np.abs(made[~known][:, 1] - 5) <= 3)).any()


@pytest.mark.parametrize("radius", [1, 4])
def test_pixels_of_a_turn_do_not_see_each_other_and_come_in_layers(radius: int) -> None:
    known = noise(30, 41) > 0.97
    turns = schedule_pixels(known, radius)
    layers, before = layers_by_hand(known), 0
    grown = known.astype(int)
    for turn in turns:
        at = turn[turn[:, 0] < 1000]
        apart = np.abs(at[:, None] - at[None]).max(axis=-1)
        assert (apart[~np.eye(len(at), dtype=bool)] > radius).all()
        assert before <= layers[tuple(at.T)].min() == layers[tuple(at.T)].max()
        before = layers[tuple(at[0])]
        grown[tuple(at.T)] += 1
    assert (grown == 1).all()


def weave(rows: int, columns: int) -> np.ndarray:
    """A pattern that repeats after 6 rows and 5 columns, and not before."""
    return np.tile(np.random.default_rng(7).random((6, 5, 3)), (-(-rows // 6), -(-columns // 5), 1))[:rows, :columns]


def test_a_weave_goes_on() -> None:
    made = synthesise_efros_leung(weave(20, 22), (33, 40), key=KEY, radius=3)
    drawn = weave(20, 22)[made[..., 0], made[..., 1]]
    shift = made[0, 0] % (6, 5)
    np.testing.assert_array_equal(drawn, weave(60, 60)[shift[0] : shift[0] + 33, shift[1] : shift[1] + 40])


def test_a_hole_in_a_weave_is_mended_from_the_weave_itself() -> None:
    whole, known = weave(40, 36), np.ones((40, 36), bool)
    known[12:25, 20:31] = known[30:33, 3:6] = False
    torn = np.where(known[..., None], whole, np.nan)
    made = synthesise_efros_leung(torn, (40, 36), key=KEY, radius=3, picture=torn, known=known, usable=known)
    assert (made[known] == -1).all()
    np.testing.assert_array_equal(torn[made[~known][:, 0], made[~known][:, 1]], whole[~known])


def test_nothing_and_everything_known() -> None:
    pixels = noise(9, 9, 1)
    all_known = synthesise_efros_leung(
        pixels, (6, 7), key=KEY, radius=2, picture=noise(6, 7, 1), known=np.ones((6, 7), bool)
    )
    assert (all_known == -1).all()
    nothing = synthesise_efros_leung(
        pixels, (6, 7), key=KEY, radius=2, picture=noise(6, 7, 1), known=np.zeros((6, 7), bool)
    )
    np.testing.assert_array_equal(nothing, synthesise_efros_leung(pixels, (6, 7), key=KEY, radius=2))


@pytest.mark.parametrize("shape", [(1, 1), (1, 5), (2, 2)])
def test_any_size(shape: tuple[int, int]) -> None:
    made = synthesise_efros_leung(noise(5, 5, 2), shape, key=KEY, radius=1)
    assert made.shape == (*shape, 2)
    assert (made >= 0).all()
    assert (made < 5).all()


def test_pixels_come_a_few_at_a_time() -> None:
    steps = list(efros_leung_steps(noise(12, 12, 1), (30, 25), key=KEY, radius=2))
    assert steps[0][:2] == (0, 741)
    assert steps[-1][:2] == (741, 741)
    assert len(steps) > 2
    for done, of, sources in steps:
        assert np.all(sources >= 0, axis=-1).sum() == done + 750 - of
    np.testing.assert_array_equal(steps[-1][2], synthesise_efros_leung(noise(12, 12, 1), (30, 25), key=KEY, radius=2))
    other = synthesise_efros_leung(noise(12, 12, 1), (30, 25), key=jax.random.key(6), radius=2)
    assert (other != steps[-1][2]).mean() > 0.5


PIXELS, MASK = noise(9, 9, 3), np.ones((9, 9), bool)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"exemplar": noise(9, 9)}, "exemplar of shape"),
        ({"exemplar": np.full((9, 9, 1), np.inf)}, "exemplar: some values are NaN or infinite"),
        ({"exemplar": noise(9, 4, 3)}, "exemplar of 4 x 9 pixels: give at least 5 x 5"),
        ({"shape": (5, 0)}, "each at least 1"),
        ({"radius": 0}, "radius 0: give 1 or more"),
        ({"tolerance": float("nan")}, "tolerance nan: give 0 or more"),
        ({"usable": np.ones((9, 8), bool)}, "usable of shape"),
        ({"usable": np.ones((9, 9))}, "usable of shape .* give bool"),
        ({"usable": ~MASK}, "no 5 x 5 pixels of the exemplar are"),
        ({"picture": PIXELS}, "picture and known go together"),
        ({"known": MASK}, "picture and known go together"),
        ({"picture": PIXELS[..., :1], "known": MASK}, "picture of shape"),
        ({"picture": PIXELS[:8], "known": MASK[:8]}, "picture of shape"),
        ({"picture": PIXELS, "known": MASK[:8]}, "known of shape"),
        ({"picture": np.full_like(PIXELS, np.nan), "known": MASK}, "picture: some values are NaN"),
    ],
)
def test_what_cannot_be_grown(options: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        efros_leung_steps(**{"exemplar": PIXELS, "shape": (9, 9), "key": KEY, "radius": 2, **options})
