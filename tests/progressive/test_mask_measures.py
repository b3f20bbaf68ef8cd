"""What elements of masks are like."""

import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.progressive.mask_measures import count_holes, count_small_regions, measure_contrast, measure_element_area


def disks(radius: float, apart: int = 40) -> np.ndarray:
    return (np.hypot(*(np.indices((80, 120)) % apart - apart / 2)) < radius).astype(np.uint8)


def test_contrast_is_that_of_all_types_of_elements_against_what_is_none() -> None:
    labels = np.repeat([0, 1, 2, 0], 8).reshape(4, 8)
    light = np.where(labels == 0, 0.5, np.where(labels == 1, 0.1, 0.2))
    lightness = 116 * np.cbrt([0.1, 0.2]).mean() - 116 * np.cbrt(0.5)
    assert measure_contrast(light, labels) == pytest.approx(lightness, abs=0.5)
    assert measure_contrast(light, labels == 0) == pytest.approx(-lightness, abs=0.5)
    assert measure_contrast(light, np.zeros((4, 8))) == 0
    with pytest.raises(InputError):
        measure_contrast(light, labels[:2])


def test_areas_are_those_of_most_of_what_elements_cover() -> None:
    mask = disks(12)
    area = measure_element_area(mask)
    assert area == mask[:40, :40].sum()
    mask[::8, 0] = 1  # specks
    assert measure_element_area(2 * mask, 2) == area


def test_what_the_picture_cuts_is_left_out() -> None:
    mask = disks(12)
    assert measure_element_area(mask[8:, 20:]) == mask[:40, :40].sum()  # two whole ones, and two halves


def test_types_that_touch_are_measured_apart() -> None:
    rings = 2 * disks(12) - disks(5)
    assert measure_element_area(rings, 1) == disks(5)[:40, :40].sum()
    assert measure_element_area(rings, 2) == (rings[:40, :40] == 2).sum()


def test_small_regions() -> None:
    mask = disks(15)
    mask[20, 20], mask[60, 60], mask[1, 1] = 0, 2, 1
    assert count_small_regions(mask, 2) == 3
    assert count_small_regions(mask, 1) == 0


def test_what_reaches_through_the_picture_has_no_area() -> None:
    stripes = np.broadcast_to(np.arange(40) % 8 < 4, (30, 40))
    assert measure_element_area(stripes) == measure_element_area(stripes.T) == 0
    row, column = np.indices((80, 120))
    for degrees in (20, 45, 70):
        turned = (row * np.cos(np.radians(degrees)) + column * np.sin(np.radians(degrees))) % 30 < 15
        turned ^= (row % 20 == 10) & (column % 20 == 10)  # specks in the gaps are whole
        assert measure_element_area(turned) == 0
    assert measure_element_area(1 - disks(12)) == 0
    assert measure_element_area(np.zeros((4, 4))) == 0


def test_holes_and_pinholes() -> None:
    mask = disks(15)
    assert count_holes(mask) == (0, 0)
    mask[20, 20], mask[58:62, 58:62], mask[18:22, 58] = 0, 0, 0  # small beside the disk's 700 pixels; not so; small
    assert count_holes(mask) == (3, 2)
    assert count_holes(1 - disks(4)) == (6, 0)  # gaps around things
    mask[:, :3], mask[40, 0] = 1, 0  # no hole, but a pit from the border
    assert count_holes(mask) == (3, 2)
