"""Tests of `jaxtex.synthesis.quilting`: against a plain loop, and on textures whose quilts are known."""

import itertools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxtex.synthesis.quilting import minimum_cut, quilting_steps, synthesise_quilting

KEY = jax.random.key(3)


def noise(*shape: int) -> np.ndarray:
    return np.random.default_rng(0).random(shape)


def quilt_by_hand(
    exemplar: np.ndarray, shape: tuple[int, int], block: int, overlap: int, tolerance: float, tileable: bool
) -> np.ndarray:
    """The same in loops: canvas, all places measured one by one, cuts from a table of sums."""
    levels = np.rint(exemplar * 255).astype(int)
    counts = [max(2, -(-n // (block - overlap))) if tileable else -(-(n - overlap) // (block - overlap)) for n in shape]
    sizes = [block, block]
    canvas = [n * (block - overlap) + overlap for n in counts]
    if tileable:
        steps = [-(-n // count) for n, count in zip(shape, counts, strict=True)]
        overlap = min(overlap, shape[0] - steps[0], shape[1] - steps[1])
        sizes, canvas = [step + overlap for step in steps], list(shape)
    sources = np.full((*canvas, 2), -1)
    for i, j in np.ndindex(*counts):
        start = np.array([i, j]) * (block - overlap)
        if tileable:
            start = np.array([i, j]) * shape // counts
        rows, columns = ((s + np.arange(n)) % m for s, n, m in zip(start, sizes, canvas, strict=True))
        under = sources[np.ix_(rows, columns)]
        seen = levels[under[..., 0], under[..., 1]]
        compared = np.zeros(sizes, bool)
        sides = [i > 0, tileable and i == counts[0] - 1, j > 0, tileable and j == counts[1] - 1]
        edges = [np.s_[:overlap], np.s_[-overlap:], np.s_[:, :overlap], np.s_[:, -overlap:]]
        for on, edge in zip(sides, edges, strict=True):
            compared[edge] |= on
        assert (under[compared] >= 0).all()
        measured = {
            (r, c): int(((levels[r : r + sizes[0], c : c + sizes[1]] - seen)[compared] ** 2).sum())
            for r, c in np.ndindex(levels.shape[0] - sizes[0] + 1, levels.shape[1] - sizes[1] + 1)
        }
        near = [place for place, error in measured.items() if error <= (1 + tolerance) * min(measured.values())]
        key = jax.random.fold_in(KEY, i * counts[1] + j)
        place = near[int(jax.random.randint(key, (), 0, len(near)))]
        source = np.stack(np.indices(sizes), axis=-1) + place
        error = ((levels[source[..., 0], source[..., 1]] - seen) ** 2).sum(-1)
        laid = np.ones(sizes, bool)
        views = [lambda a: a.T, lambda a: a[::-1].T, lambda a: a, lambda a: a[:, ::-1]]
        for on, view in zip(sides, views, strict=True):
            if on:
                for row, cut in enumerate(cut_by_hand(view(error)[:, :overlap])):
                    view(laid)[row, :cut] = False
        sources[np.ix_(rows, columns)] = np.where(laid[..., None], source, under)
    return sources[: shape[0], : shape[1]]


def cut_by_hand(errors: np.ndarray) -> list[int]:
    sums = [list(errors[0])]
    for row in errors[1:]:
        sums.append([e + min(sums[-1][max(c - 1, 0) : c + 2]) for c, e in enumerate(row)])
    path = [int(np.argmin(sums[-1]))]
    for above in sums[-2::-1]:
        around = range(max(path[0] - 1, 0), min(path[0] + 2, len(above)))
        path.insert(0, min(around, key=lambda c: above[c]))
    return path


@pytest.mark.parametrize(
    ("exemplar", "shape", "block", "overlap", "tolerance", "tileable"),
    [
        ((21, 18, 3), (30, 22), 8, 2, 0.1, False),
        ((16, 33, 1), (17, 40), 9, 4, 0.5, True),
        ((40, 38, 4), (19, 20), 6, 1, 0.0, True),
    ],
)
def test_it_is_the_plain_loop_bit_for_bit(
    exemplar: tuple[int, ...], shape: tuple[int, int], block: int, overlap: int, tolerance: float, tileable: bool
) -> None:
    pixels = noise(*exemplar)
    made = synthesise_quilting(
        pixels, shape, key=KEY, block=block, overlap=overlap, tolerance=tolerance, tileable=tileable
    )
    assert made.dtype == np.int32
    np.testing.assert_array_equal(made, quilt_by_hand(pixels, shape, block, overlap, tolerance, tileable))


def test_the_largest_blocks_are_measured_exactly() -> None:
    # Noise of black and white, with as much white as black in places only: the largest sums there are.
    pixels = np.rint(noise(106, 300, 3) * np.linspace(0.5, 1.5, 300)[None, :, None])
    made = synthesise_quilting(pixels, (150, 156), key=KEY, block=104, overlap=52)
    np.testing.assert_array_equal(made, quilt_by_hand(pixels, (150, 156), 104, 52, 0.1, False))


@pytest.mark.parametrize("shape", [(1, 4), (6, 3), (5, 1), (7, 4)])
def test_the_cut_is_the_cheapest_of_all_paths(shape: tuple[int, int]) -> None:
    errors = np.random.default_rng(1).integers(0, 1000, shape)
    paths = itertools.product(range(shape[1]), repeat=shape[0])
    sums = {path: errors[np.arange(shape[0]), path].sum() for path in paths if np.abs(np.diff(path)).max(initial=0) < 2}
    found = tuple(np.asarray(minimum_cut(jnp.asarray(errors, jnp.int32))).tolist())
    assert sums[found] == min(sums.values())


def test_inside_blocks_the_exemplar_is_copied_as_it_stands() -> None:
    made = synthesise_quilting(noise(40, 40, 3), (50, 70), key=KEY, block=14, overlap=3)
    for row, column in itertools.product(range(3, 37, 11), range(3, 57, 11)):
        inside = made[row : row + 8, column : column + 8]
        np.testing.assert_array_equal(inside - inside[:1, :1], np.moveaxis(np.indices(inside.shape[:2]), 0, -1))


@pytest.mark.parametrize("tileable", [False, True])
def test_a_chessboard_goes_on(tileable: bool) -> None:
    def board(rows: int, columns: int, start: np.ndarray) -> np.ndarray:
        row, column = np.indices((rows, columns))
        return ((row + start[0]) // 4 + (column + start[1]) // 4) % 2

    made = synthesise_quilting(
        board(32, 37, np.zeros(2))[..., None], (48, 64), key=KEY, block=18, overlap=6, tileable=tileable
    )
    drawn = board(32, 37, np.zeros(2))[made[..., 0], made[..., 1]]
    np.testing.assert_array_equal(drawn, board(48, 64, made[0, 0]))


def test_a_tileable_texture_has_no_seam() -> None:
    # Slow waves that do not repeat within the exemplar: neighbours are alike, also around the borders.
    row, column = np.indices((80, 80))
    waves = 0.5 + 0.25 * (np.sin(row / 5.3 + np.sin(column / 11)) + np.sin(column / 4.1 + row / 17))
    seams = []
    for tileable in (False, True):
        made = synthesise_quilting(waves[..., None], (75, 90), key=KEY, block=20, tileable=tileable)
        drawn = waves[made[..., 0], made[..., 1]]
        across = [np.abs(np.take(drawn, 0, axis) - np.take(drawn, -1, axis)).mean() for axis in (0, 1)]
        within = [np.abs(np.diff(drawn, axis=axis)).mean() for axis in (0, 1)]
        seams.append(max(np.divide(across, within)))
    assert seams[1] < 1.5 < seams[0]


def test_rows_come_one_after_another() -> None:
    steps = list(quilting_steps(noise(24, 24, 2), (30, 20), key=KEY, block=10, overlap=2))
    assert [(done, of) for done, of, _ in steps] == [(1, 4), (2, 4), (3, 4), (4, 4)]
    for (done, _, before), (_, _, after) in itertools.pairwise(steps):
        np.testing.assert_array_equal(before[: 8 * done], after[: 8 * done])  # what no later block overlaps
        assert (before[8 * done + 2 :] == -1).all()
    again = synthesise_quilting(noise(24, 24, 2), (30, 20), key=KEY, block=10, overlap=2)
    np.testing.assert_array_equal(steps[-1][2], again)
    other = synthesise_quilting(noise(24, 24, 2), (30, 20), key=jax.random.key(4), block=10, overlap=2)
    assert (other != again).mean() > 0.5


@pytest.mark.parametrize(
    ("exemplar", "shape", "tileable"),
    [((2, 2, 1), (5, 7), False), ((2, 9, 3), (1, 1), False), ((12, 12, 3), (2, 3), True), ((64, 64, 1), (3, 70), True)],
)
def test_any_size(exemplar: tuple[int, ...], shape: tuple[int, int], tileable: bool) -> None:
    made = synthesise_quilting(noise(*exemplar), shape, key=KEY, tileable=tileable)
    assert made.shape == (*shape, 2)
    assert (made >= 0).all()
    assert (made < exemplar[:2]).all()


@pytest.mark.parametrize(
    ("exemplar", "options", "told"),
    [
        ((8, 8), {}, "exemplar of shape"),
        ((1, 8, 3), {}, "exemplar of 8 x 1 pixels: give at least 2 x 2"),
        ((8, 8, 0), {}, "exemplar of shape"),
        ((8, 8, 3), {"shape": (0, 5)}, "each at least 1"),
        ((8, 8, 3), {"shape": (1, 5), "tileable": True}, "at least 2 rows and columns"),
        ((8, 9, 3), {"block": 9}, "block of 9 pixels: give 2 to 8"),
        ((130, 120, 3), {"block": 105}, "block of 105 pixels: give 2 to 104"),
        ((8, 9, 3), {"block": 6, "overlap": 4}, "overlap of 4 pixels: give 1 to 3"),
        ((8, 9, 3), {"overlap": 0}, "overlap of 0 pixels: give 1 to 1"),
        ((8, 9, 3), {"tolerance": -0.1}, "tolerance -0.1: give 0 or more"),
    ],
)
def test_what_cannot_be_quilted(exemplar: tuple[int, ...], options: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        quilting_steps(noise(*exemplar), **{"shape": (16, 16), "key": KEY, **options})


def test_no_numbers_no_quilt() -> None:
    with pytest.raises(ValueError, match="NaN or infinite"):
        synthesise_quilting(np.full((8, 8, 1), np.nan), (8, 8), key=KEY)
