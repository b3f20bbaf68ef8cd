"""Copied pieces, of source maps made by hand and against a plain flood fill; windows found, against a plain loop."""

from collections import deque

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxtex.synthesis import copying
from jaxtex.synthesis.copying import coherent_pieces, find_windows, measure_pieces, seam_map, verbatim_share


def identity(rows: int, columns: int) -> np.ndarray:
    return np.stack(np.indices((rows, columns)), axis=-1).astype(np.int32)


def flood_fill(sources: np.ndarray) -> np.ndarray:
    rows, columns = sources.shape[:2]
    labels = np.full((rows, columns), -1)
    count = 0
    for start in np.ndindex(rows, columns):
        if labels[start] >= 0:
            continue
        labels[start], queue = count, deque([start])
        while queue:
            r, c = queue.popleft()
            for dr, dc in ((0, 1), (1, 0), (0, -1), (-1, 0)):
                y, x = r + dr, c + dc
                if not (0 <= y < rows and 0 <= x < columns) or labels[y, x] >= 0:
                    continue
                if (sources[y, x] - sources[r, c] == (dr, dc)).all():
                    labels[y, x] = count
                    queue.append((y, x))
        count += 1
    return labels


@given(st.integers(1, 9), st.integers(1, 9), st.integers(1, 3), st.integers(0, 999))
def test_pieces_are_those_of_a_flood_fill(rows: int, columns: int, offsets: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    moved = rng.integers(0, 2, size=(offsets, 2)) * 5
    sources = identity(rows, columns) + moved[rng.integers(0, offsets, size=(rows, columns))]
    np.testing.assert_array_equal(coherent_pieces(sources), flood_fill(sources))


def test_a_piece_may_be_joined_by_one_pixel_only_and_not_by_its_offset() -> None:
    sources = identity(3, 5)
    sources[:, 2] += 7  # a stripe between two parts of the same offset
    assert coherent_pieces(sources)[0].tolist() == [0, 0, 1, 2, 2]
    sources[1, 2] -= 7  # a bridge of one pixel
    labels = coherent_pieces(sources)
    assert labels[0, 0] == labels[1, 2] == labels[2, 4]
    assert labels[0, 2] != labels[2, 2]


def test_sizes_of_a_map_made_by_hand() -> None:
    sources = identity(10, 10)
    sources[:, 7:] += [20, 0]
    sources[9, 9] = 55
    pieces = measure_pieces(sources, large=29)
    assert pieces.number == 3
    assert pieces.mean_size == pytest.approx(100 / 3)
    assert pieces.typical_size == pytest.approx((70**2 + 29**2 + 1) / 100)
    assert pieces.large_share == pytest.approx(0.7)
    assert measure_pieces(sources, large=28).large_share == pytest.approx(0.99)


def test_the_exemplar_itself_is_one_piece_and_mirrored_it_is_all_seams() -> None:
    assert measure_pieces(identity(8, 6)) == (1, 48.0, 48.0, 0.0)
    assert not seam_map(identity(8, 6)).any()
    mirrored = identity(8, 6)[::-1, ::-1]
    assert measure_pieces(mirrored).mean_size == 1
    assert seam_map(mirrored).sum() == 47


def test_seams_are_where_labels_change() -> None:
    sources = identity(6, 8)
    sources[2:5, 3:6] += 30
    seams = seam_map(sources)
    labels = coherent_pieces(sources)
    expected = np.zeros_like(seams)
    expected[1:] |= labels[1:] != labels[:-1]
    expected[:, 1:] |= labels[:, 1:] != labels[:, :-1]
    np.testing.assert_array_equal(seams, expected)
    # Three pixels along each of four sides; the piece's first corner begins two of them.
    assert seams.sum() == 11


@given(
    st.integers(1, 4), st.integers(1, 3), st.tuples(*[st.integers(4, 11)] * 4), st.integers(1, 3), st.integers(0, 999)
)
def test_windows_are_those_of_a_plain_search(
    window: int, channels: int, sides: tuple[int, ...], stride: int, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    # Few levels, so that many windows are equally near.
    exemplar, texture = (rng.integers(0, 3, size=(*shape, channels)) / 255 for shape in (sides[:2], sides[2:]))
    sources, differences = find_windows(exemplar, texture, window=window, stride=stride)
    for r, row in enumerate(range(0, sides[2] - window + 1, stride)):
        for c, column in enumerate(range(0, sides[3] - window + 1, stride)):
            wanted = texture[row : row + window, column : column + window]
            errors = [
                (np.mean((exemplar[y : y + window, x : x + window] - wanted) ** 2).round(12), y, x)
                for y in range(sides[0] - window + 1)
                for x in range(sides[1] - window + 1)
            ]
            error, *place = min(errors)
            assert sources[r, c].tolist() == place
            assert differences[r, c] == pytest.approx(np.sqrt(error), abs=1e-6)


def test_blocks_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(0)
    exemplar, texture = rng.random((23, 17, 3)), rng.random((14, 19, 3))
    whole = find_windows(exemplar, texture, window=3)
    monkeypatch.setattr(copying, "_BLOCK", 32)
    for before, after in zip(whole, find_windows(exemplar, texture, window=3), strict=True):
        np.testing.assert_array_equal(before, after)


def test_a_texture_of_copied_pieces_gives_its_source_map_back() -> None:
    exemplar = np.random.default_rng(1).random((30, 30, 3))
    sources = identity(20, 24)
    sources[:, 12:] += [7, -9]
    texture = exemplar[sources[..., 0], sources[..., 1]]
    found, differences = find_windows(exemplar, texture, window=5)
    whole = differences == 0
    # Windows of five columns lie across the cut at four places.
    assert whole[:, [*range(8), *range(12, 20)]].all()
    assert not whole[:, 8:12].any()
    np.testing.assert_array_equal(found[whole], sources[:16, :20][whole])
    assert verbatim_share(exemplar, texture, window=5, stride=1) == 16 / 20


def test_tolerance_is_the_root_mean_square_difference() -> None:
    exemplar = np.full((16, 16, 3), 100 / 255)
    texture = exemplar + np.array([3, 0, 4]) / 255
    apart = np.sqrt((9 + 16) / 3) / 255
    assert verbatim_share(exemplar, texture) == 0
    assert verbatim_share(exemplar, texture, tolerance=0.999 * apart) == 0
    assert verbatim_share(exemplar, texture, tolerance=1.001 * apart) == 1
    assert verbatim_share(exemplar, exemplar + 0.4 / 255) == 1


def test_the_largest_windows_of_the_largest_values_are_exact() -> None:
    """One step of one number in 1024, where all others are extreme."""
    exemplar = np.random.default_rng(2).integers(0, 2, size=(40, 40, 1)).astype(float)
    texture = exemplar[3:37, 4:38].copy()
    texture[16, 16] += (1 if texture[16, 16] == 0 else -1) / 255
    sources, differences = find_windows(exemplar, texture, window=32)
    np.testing.assert_array_equal(sources, identity(3, 3) + np.array([3, 4]))
    np.testing.assert_allclose(differences, 1 / 32 / 255, rtol=1e-5)


@pytest.mark.parametrize(
    "sources", [np.zeros((4, 4), int), np.zeros((4, 4, 3), int), np.zeros((0, 4, 2), int), np.zeros((4, 4, 2))]
)
def test_what_is_no_source_map_is_refused(sources: np.ndarray) -> None:
    for function in (coherent_pieces, seam_map, measure_pieces):
        with pytest.raises(ValueError, match="give integers"):
            function(sources)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"window": 0}, "window of 0 pixels: give 1 to 12"),
        ({"window": 13}, "window of 13 pixels: give 1 to 12"),
        ({"stride": 0}, "stride 0"),
        ({"tolerance": -1.0}, "tolerance -1"),
        ({"tolerance": float("nan")}, "tolerance nan"),
    ],
)
def test_what_cannot_be_searched_is_refused(options: dict, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        verbatim_share(np.zeros((20, 20, 3)), np.zeros((12, 15, 3)), **options)


def test_windows_too_large_to_be_exact_are_refused() -> None:
    with pytest.raises(ValueError, match="at most 1024"):
        verbatim_share(np.zeros((40, 40, 3)), np.zeros((40, 40, 3)), window=21)
