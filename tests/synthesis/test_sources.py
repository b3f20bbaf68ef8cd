"""Tests of `jaxtex.synthesis.sources`: against plain loops."""

import numpy as np
import pytest

from jaxtex.synthesis.sources import Step, blend_seams, copy_sources, last_of


def picture(*shape: int) -> np.ndarray:
    return np.random.default_rng(0).random(shape)


def places(shape: tuple[int, int], rows: int, columns: int) -> np.ndarray:
    random = np.random.default_rng(1)
    return np.stack([random.integers(0, rows, shape), random.integers(0, columns, shape)], axis=-1).astype(np.int32)


def blend_by_hand(pixels: np.ndarray, sources: np.ndarray, width: float, repeats: bool) -> np.ndarray:
    """Each neighbour within twice the width, rounded up, votes for what continues its piece, if there is such."""
    rows, columns = sources.shape[:2]
    reach = int(np.ceil(2 * width))
    result = np.zeros((rows, columns, *pixels.shape[2:]))
    for row, column in np.ndindex(rows, columns):
        weights = 0.0
        for down in range(-reach, reach + 1):
            for right in range(-reach, reach + 1):
                if not repeats and not (0 <= row + down < rows and 0 <= column + right < columns):
                    continue
                source = sources[(row + down) % rows, (column + right) % columns] - [down, right]
                if (source >= 0).all() and (source < pixels.shape[:2]).all():
                    weight = np.exp(-(down**2 + right**2) / (2 * width**2))
                    result[row, column] += weight * pixels[tuple(source)]
                    weights += weight
        result[row, column] /= weights
    return result


def test_pixels_are_copied() -> None:
    pixels, sources = picture(5, 7, 3), places((4, 6), 5, 7)
    made = copy_sources(pixels, sources)
    assert made.shape == (4, 6, 3)
    for row, column in np.ndindex(4, 6):
        np.testing.assert_array_equal(made[row, column], pixels[sources[row, column, 0], sources[row, column, 1]])


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "int64", "float16", "float32", "float64", "bool"])
@pytest.mark.parametrize("shape", [(5, 7), (5, 7, 1), (5, 7, 4), (5, 7, 2, 3)])
def test_any_type_and_form_is_kept(dtype: str, shape: tuple[int, ...]) -> None:
    pixels = (200 * picture(*shape)).astype(dtype)
    made = copy_sources(pixels, places((3, 8), 5, 7).astype(np.uint16))
    assert made.dtype == pixels.dtype
    assert made.shape == (3, 8, *shape[2:])


def test_what_is_its_own_source_stays() -> None:
    pixels = picture(6, 5, 3)
    np.testing.assert_array_equal(copy_sources(pixels, np.moveaxis(np.indices((6, 5)), 0, -1)), pixels)


@pytest.mark.parametrize("place", [(-1, 0), (0, -1), (5, 0), (0, 7)])
def test_places_outside_are_told(place: tuple[int, int]) -> None:
    sources = places((3, 3), 5, 7)
    sources[1, 2] = place
    for function in (copy_sources, blend_seams):
        with pytest.raises(ValueError, match=r"sources lead outside of a picture of shape \(5, 7, 3\)"):
            function(picture(5, 7, 3), sources)


@pytest.mark.parametrize("sources", [np.zeros((3, 3, 2)), np.zeros((3, 3, 3), int), np.zeros((3, 3), int)])
def test_other_forms_are_told(sources: np.ndarray) -> None:
    for function in (copy_sources, blend_seams):
        with pytest.raises(ValueError, match=r"give whole numbers \[row, col, 2\]"):
            function(picture(5, 7, 3), sources)


def test_a_picture_needs_two_axes() -> None:
    with pytest.raises(ValueError, match="picture of shape"):
        copy_sources(np.zeros(5), places((3, 3), 5, 7))


@pytest.mark.parametrize("width", [0.4, 1.0, 1.7])
@pytest.mark.parametrize(("shape", "repeats"), [((7, 8, 3), True), ((7, 8), True), ((7, 8, 3), False)])
def test_blending_is_that_of_a_plain_loop(width: float, shape: tuple[int, ...], repeats: bool) -> None:
    pixels, sources = picture(*shape), places((5, 6), 7, 8)
    made = blend_seams(pixels, sources, width=width, repeats=repeats)
    np.testing.assert_allclose(made, blend_by_hand(pixels, sources, width, repeats))


def test_a_picture_that_does_not_repeat_is_no_seam() -> None:
    """The whole exemplar but for a border, copied as it stands."""
    pixels = picture(20, 20, 3)
    sources = np.moveaxis(np.indices((14, 14)), 0, -1) + 3
    np.testing.assert_allclose(blend_seams(pixels, sources, repeats=False), pixels[3:17, 3:17])
    assert np.abs(blend_seams(pixels, sources) - pixels[3:17, 3:17]).max() > 0.1


def test_inside_of_pieces_nothing_is_blended() -> None:
    """Two pieces side by side: within 2 pixels of where they meet, and of the border that the texture repeats across,
    is between them."""
    pixels = np.concatenate([np.zeros((20, 20, 1)), np.ones((20, 20, 1))], axis=1)
    pixels += 0.1 * picture(20, 40, 1)
    sources = np.moveaxis(np.indices((12, 20)), 0, -1) + 4
    sources[:, 10:, 1] += 12  # columns 4 to 13 of the dark half, and 26 to 35 of the bright one
    sharp, made = copy_sources(pixels, sources), blend_seams(pixels, sources, width=1.0)
    np.testing.assert_allclose(made[2:-2, 2:8], sharp[2:-2, 2:8], atol=1e-12)
    np.testing.assert_allclose(made[2:-2, 12:-2], sharp[2:-2, 12:-2], atol=1e-12)
    # At the seam dark goes over into bright, each of its four columns brighter than the one before.
    across = made[..., 0].mean(axis=0)[7:13]
    assert (np.diff(across) > 0.05).all()
    assert across[2] == pytest.approx(1.1 - across[3], abs=0.03)
    assert 0.3 < across[2] < 0.5


def test_blending_is_as_exact_as_the_picture() -> None:
    sources = places((5, 6), 7, 8)
    assert blend_seams(np.float32(picture(7, 8, 3)), sources).dtype == np.float32
    assert blend_seams(picture(7, 8, 3), sources).dtype == np.float64


def test_a_constant_stays() -> None:
    made = blend_seams(np.full((7, 8, 3), 0.7), places((5, 6), 7, 8), width=2.0)
    np.testing.assert_allclose(made, 0.7)


@pytest.mark.parametrize("width", [0.0, -1.0, float("nan")])
def test_widths_that_are_none_are_told(width: float) -> None:
    with pytest.raises(ValueError, match="is not above 0"):
        blend_seams(picture(5, 7, 3), places((3, 3), 5, 7), width=width)


def test_the_last_step_counts() -> None:
    maps = [places((2, 2), 5, 7) + step for step in range(3)]
    assert last_of(Step(step + 1, 3, each) for step, each in enumerate(maps)) is maps[2]
