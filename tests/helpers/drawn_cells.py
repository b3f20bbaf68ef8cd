"""Tiles as `cut_cells` lays them out, drawn so that everything about them is known."""

import numpy as np

from jaxtex.material.cells import Cell


def draw_cell(
    height: int = 24, width: int = 48, *, joint: int = 4, place=(0, 0), colour=0.5, grain=0.0, seed=0
) -> Cell:
    """A face of a size with all of the joints around it, of one colour, and white noise on that.

    Colours of the joint are 0.8; faces end at pixels' borders.
    """
    x, y = (np.arange(-joint, side + joint) + 0.5 for side in (width, height))
    sides = {"left": x, "right": width - x, "top": y, "bottom": height - y}
    noise = grain * np.random.default_rng(seed).normal(size=(len(y), len(x), 1))
    values = np.where(inside_of(sides)[..., None], colour + noise, 0.8) * np.ones(3)
    return Cell(place, values.astype(np.float32), **{name: side.astype(np.float32) for name, side in sides.items()})


def draw_mask(cell: Cell, shift=(0.0, 0.0, 0.0, 0.0)) -> np.ndarray:
    """A cell's mask, [row, col]; `shift`: how far outside of its place each edge is, numbers or arrays along it."""
    (left, right), (top, bottom) = ([np.asarray(each) for each in pair] for pair in (shift[:2], shift[2:]))
    columns = (cell.left + left[..., None] > 0) & (cell.right + right[..., None] > 0)
    rows = (cell.top[:, None] + top > 0) & (cell.bottom[:, None] + bottom > 0)
    return (columns & rows).astype(np.float32)


def inside_of(sides) -> np.ndarray:
    """Which pixels of a cell are in the face, [row, col]."""
    columns, rows = (np.minimum(sides[a], sides[b]) > 0 for a, b in (("left", "right"), ("top", "bottom")))
    return rows[:, None] & columns
