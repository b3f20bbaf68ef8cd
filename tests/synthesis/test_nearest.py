"""Similar places: that they are those a loop finds, apart from each other, and copies before all others."""

import jax
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jaxtex.synthesis.ashikhmin import synthesise_ashikhmin
from jaxtex.synthesis.nearest import find_similar, principal_neighbourhoods


def find_plain(exemplar: np.ndarray, radius: int, count: int, apart: int) -> np.ndarray:
    components = principal_neighbourhoods(exemplar.astype(np.float32), radius).astype(int)
    rows, columns = components.shape[:2]
    similar = np.zeros((*exemplar.shape[:2], count, 2), int)
    for y in range(exemplar.shape[0]):
        for x in range(exemplar.shape[1]):
            own = (min(max(y - radius, 0), rows - 1), min(max(x - radius, 0), columns - 1))
            distance = np.square(components - components[own]).sum(axis=2)
            cells: dict[tuple[int, int], tuple] = {}
            for v, u in np.ndindex(rows, columns):
                cell = (v // apart, u // apart)
                cells[cell] = min(cells.get(cell, (np.inf,)), (distance[v, u], v, u))
            offers = sorted((each[0], cell, each[1:]) for cell, each in cells.items())
            found = [own]
            for _, _, place in offers:
                if all(max(abs(place[0] - v), abs(place[1] - u)) >= apart for v, u in found):
                    found.append(place)
            found = (found + [own] * count)[:count]
            similar[y, x] = np.array(found) + radius
    return similar


@settings(max_examples=6, deadline=None)
@given(
    seed=st.integers(0, 2**31 - 1),
    size=st.sampled_from([((9, 11), 1, 3, 2, 3), ((7, 12), 2, 4, 1, 1), ((5, 5), 2, 3, 3, 2), ((13, 6), 1, 8, 4, 5)]),
)
def test_is_what_a_loop_finds(seed: int, size: tuple) -> None:
    shape, radius, count, apart, channels = size
    exemplar = np.random.default_rng(seed).integers(0, 3, (*shape, channels)) / 2
    found = find_similar(exemplar, radius=radius, count=count, apart=apart)
    np.testing.assert_array_equal(found, find_plain(exemplar, radius, count, apart))


def test_copies_are_found() -> None:
    tile = np.random.default_rng(0).random((10, 10, 3))
    found = np.asarray(find_similar(np.tile(tile, (3, 3, 1)), radius=2, count=3))
    inside = found[2:-2, 2:-2]
    assert ((inside[:, :, 1:] - inside[:, :, :1]) % 10 == 0).all()
    assert np.isin(np.ptp(inside, axis=2).max(axis=-1), (10, 20)).all()


def test_an_even_exemplar_and_one_of_one_place() -> None:
    assert np.isfinite(find_similar(np.full((9, 9, 1), 0.5), radius=1, count=4)).all()
    np.testing.assert_array_equal(find_similar(np.zeros((5, 5, 1)), radius=2, count=3), np.full((5, 5, 3, 2), 2))


def test_goes_into_coherent_search() -> None:
    exemplar = np.random.default_rng(0).random((16, 17, 3))
    similar = find_similar(exemplar, radius=2, count=4)
    assert synthesise_ashikhmin(exemplar, (9, 7), key=jax.random.key(0), similar=similar).shape == (9, 7, 2)


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"radius": 3}, "holds no neighbourhood of 7 x 7"),
        ({"count": 0}, "count: 0"),
        ({"apart": 0}, "apart: 0"),
        ({"exemplar": np.full((6, 6, 1), np.nan)}, "NaN"),
    ],
)
def test_complaints(options: dict, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        find_similar(**{"exemplar": np.zeros((6, 6, 1)), "radius": 1, "count": 2, **options})
