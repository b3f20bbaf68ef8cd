"""Which tiles are learnt from: those without an artefact, however dark or light they are."""

import numpy as np
import pytest
from drawn_cells import draw_cell, draw_mask

from jaxtex.material.clean import choose_clean

COUNT, ODD = 20, 7


def draw_wall(spoil=lambda cell, mask: None, which=(ODD,)):
    """Tiles of slightly different lightness; `spoil` changes the cell's values or its mask in place."""
    cells = [draw_cell(colour=0.4 + 0.01 * (n % 5), grain=0.02, seed=n) for n in range(COUNT)]
    masks = [draw_mask(cell) for cell in cells]
    for n in which:
        spoil(cells[n].values, masks[n])
    return cells, masks


def highlight(values, mask):
    values[12:18, 20:30] += 0.3


def hole(values, mask):
    values[12:18, 20:30] = 0.1


def shadow_border(values, mask):
    values[:, 28:] *= 0.7


def lamp(values, mask):
    values += np.linspace(0.2, -0.2, len(values), dtype=np.float32)[:, None, None]


def dirt(values, mask):
    mask[10:20, 10:30] = 0


def clipped_light(values, mask):
    values[8:24, 8:40] = 1.0


def clipped_dark(values, mask):
    values[8:24, 8:40] = 0.0


@pytest.mark.parametrize("spoil", [highlight, hole, shadow_border, lamp, dirt, clipped_light, clipped_dark])
def test_a_tile_with_an_artefact_is_left_out(spoil):
    chosen = choose_clean(*draw_wall(spoil))
    assert chosen.tolist() == [n for n in range(COUNT) if n != ODD]


@pytest.mark.parametrize("axis", [0, 1])
def test_it_is_the_change_from_side_to_side_that_counts(axis):
    # The same pixels as they were, in order of their lightness: neither lights nor darks are others.
    cells, masks = draw_wall()
    for n, cell in enumerate(cells):
        cell.values[4:-4, 4:-4] += 0.1 * np.random.default_rng(n).normal(size=(24, 48, 1))
    face = cells[ODD].values[4:-4, 4:-4]
    ordered = np.sort(face.swapaxes(0, axis).reshape(-1, 3), axis=0)
    face[:] = ordered.reshape(face.swapaxes(0, axis).shape).swapaxes(0, axis)
    assert choose_clean(cells, masks).tolist() == [n for n in range(COUNT) if n != ODD]


def test_dark_and_light_tiles_stay():
    def darken(values, mask):
        values *= 0.4

    def lighten(values, mask):
        values += 0.3

    assert choose_clean(*draw_wall(darken)).tolist() == list(range(COUNT))
    assert choose_clean(*draw_wall(lighten, which=(2, 3))).tolist() == list(range(COUNT))


def test_what_all_tiles_have_is_no_artefact():
    assert choose_clean(*draw_wall(lamp, which=range(COUNT))).tolist() == list(range(COUNT))


def test_differences_that_nobody_sees_do_not_count_however_even_the_wall():
    cells = [draw_cell() for _ in range(COUNT)]
    cells[ODD].values[12:18, 20:30] += 0.01
    assert len(choose_clean(cells, [draw_mask(cell) for cell in cells])) == COUNT


@pytest.mark.parametrize("count", [1, 2, 3, 9])
def test_a_quarter_stays_whatever_they_look_like(count):
    random = np.random.default_rng(count)
    cells = [draw_cell(grain=10 ** random.uniform(-3, 0), seed=n) for n in range(count)]
    chosen = choose_clean(cells, [draw_mask(cell) for cell in cells])
    assert len(chosen) >= count / 4
