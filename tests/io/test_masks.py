"""Masks: coverage as it stands, and pictures that are none."""

from pathlib import Path

import numpy as np
import PIL.Image
import pytest

import jaxtex as jt


@pytest.mark.parametrize("name", ["m.png", "m.tif", "m.exr"])
def test_coverage_comes_back_without_a_curve(tmp_path: Path, name: str) -> None:
    mask = np.linspace(0, 1, 256, dtype=np.float32).reshape(16, 16)
    jt.write_mask(tmp_path / name, mask)
    np.testing.assert_allclose(jt.read_mask(tmp_path / name), mask, atol=1e-7)


def test_truth_values_are_white_on_tiles(tmp_path: Path) -> None:
    mask = np.random.default_rng(0).random((6, 9)) > 0.5
    jt.write_mask(tmp_path / "m.png", mask)
    np.testing.assert_array_equal(np.asarray(PIL.Image.open(tmp_path / "m.png")), mask * np.uint8(255))
    np.testing.assert_array_equal(jt.read_mask(tmp_path / "m.png"), mask)


def test_a_grey_picture_saved_as_rgb_or_with_opaque_alpha_is_a_mask(tmp_path: Path) -> None:
    grey = np.full((4, 5), 128, np.uint8)
    PIL.Image.fromarray(np.dstack([grey] * 3 + [np.full_like(grey, 255)])).save(tmp_path / "m.png")
    np.testing.assert_allclose(jt.read_mask(tmp_path / "m.png"), 128 / 255, atol=1e-6)


def test_pictures_that_are_no_masks(tmp_path: Path) -> None:
    PIL.Image.fromarray(np.full((4, 5, 3), (200, 100, 50), np.uint8)).save(tmp_path / "coloured.png")
    PIL.Image.fromarray(np.full((4, 5, 4), 128, np.uint8)).save(tmp_path / "clear.png")
    jt.write_image(tmp_path / "bright.exr", np.full((4, 5), 2.0))
    for name, told in (("coloured.png", "coloured"), ("clear.png", "transparent"), ("bright.exr", "from 2 to 2")):
        with pytest.raises(jt.InputError, match=told):
            jt.read_mask(tmp_path / name)


def test_arrays_that_are_no_masks(tmp_path: Path) -> None:
    for mask in (np.ones((2, 2, 1)), np.full((2, 2), 1.5), np.full((2, 2), np.nan)):
        with pytest.raises(jt.InputError, match=r"m\.png"):
            jt.write_mask(tmp_path / "m.png", mask)
    assert not list(tmp_path.iterdir())
