"""A contact sheet: pictures side by side, each with its name above, and a small one and some lines of text below."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

_MARGIN = 16
_HEADING = 30  # pixels, of 20-pixel letters
_LINE = 19  # of 14-pixel letters
_GAP = 8
_LEAST_SIDE = 256  # of a cell, so that text fits; smaller pictures are magnified
_MOST_COLUMNS = 4
_INK, _PAPER = (32, 32, 32), (255, 255, 255)


class Cell(NamedTuple):
    """One picture of the sheet. Pictures are floats [row, col, channel], 0 to 1, sRGB-encoded, grey or RGB.

    Attributes:
        title: stands above it.
        picture: shown as it is, or magnified by a whole number.
        small: another picture of its size, shown below at half that size, if there is one.
        lines: text beside the small picture.
    """

    title: str
    picture: npt.NDArray[np.floating]
    small: npt.NDArray[np.floating] | None = None
    lines: tuple[str, ...] = ()


class Layout(NamedTuple):
    """Where things stand, in pixels. All cells are alike.

    Attributes:
        columns, rows: of cells.
        times: how many times pictures are magnified.
        cell: (width, height).
        small: where what stands below the pictures begins.
    """

    columns: int
    rows: int
    times: int
    cell: tuple[int, int]
    small: int

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) of the sheet."""
        width, height = self.cell
        return self.columns * (width + _MARGIN) + _MARGIN, self.rows * (height + _MARGIN) + _MARGIN


def lay_out(count: int, *, largest: tuple[int, int], lines: int, small: bool = True) -> Layout:
    """Lay out a sheet.

    Args:
        count: number of cells.
        largest: (width, height) that no picture exceeds.
        lines: that no cell has more of.
        small: whether cells have small pictures.

    Examples:
        >>> lay_out(7, largest=(256, 256), lines=5).size
        (1104, 892)
    """
    rows = math.ceil(count / _MOST_COLUMNS)
    times = max(1, _LEAST_SIDE // max(largest))
    width, height = (times * side for side in largest)
    below = max(height // 2 if small else 0, lines * _LINE)
    begin = _HEADING + height + _GAP
    return Layout(math.ceil(count / rows), rows, times, (max(width, _LEAST_SIDE), begin + below), begin)


def draw_contact_sheet(cells: Sequence[Cell], layout: Layout) -> npt.NDArray[np.float32]:
    """Draw a sheet.

    Args:
        cells: row by row; no more, and none larger, than the layout is made for.

    Returns:
        [row, col, 3] of the layout's size, 0 to 1, sRGB-encoded.
    """
    sheet = Image.new("RGB", layout.size, _PAPER)
    for number, cell in enumerate(cells):
        down, right = divmod(number, layout.columns)
        place = (_MARGIN + right * (layout.cell[0] + _MARGIN), _MARGIN + down * (layout.cell[1] + _MARGIN))
        sheet.paste(_draw_cell(cell, layout), place)
    return (np.asarray(sheet) / 255).astype(np.float32)


def _draw_cell(cell: Cell, layout: Layout) -> Image.Image:
    drawn = Image.new("RGB", layout.cell, _PAPER)
    pen = ImageDraw.Draw(drawn)
    pen.text((0, 0), cell.title, fill=_INK, font=ImageFont.load_default(20))
    width, height = (layout.times * side for side in cell.picture.shape[1::-1])
    drawn.paste(_to_image(cell.picture).resize((width, height), Image.Resampling.NEAREST), (0, _HEADING))
    left = 0
    if cell.small is not None:
        half = max(1, width // 2), max(1, height // 2)
        drawn.paste(_to_image(cell.small).resize(half, Image.Resampling.BOX), (0, layout.small))
        left = half[0] + _GAP
    font = ImageFont.load_default(14)
    for number, line in enumerate(cell.lines):
        pen.text((left, layout.small + number * _LINE), line, fill=_INK, font=font)
    return drawn


def _to_image(picture: npt.NDArray[np.floating]) -> Image.Image:
    levels = np.rint(255 * np.clip(picture, 0, 1)).astype(np.uint8)
    return Image.fromarray(np.broadcast_to(levels, (*levels.shape[:2], 3)))
