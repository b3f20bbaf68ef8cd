"""Figures 10, 11 and 13 of Zhang et al.: textures made with masks of their elements; `progressive.py` draws them."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
from progressive_exemplars import KEY, SIDE, Floats, Labels, draw_mask, read_exemplar, read_picture

import jaxtex as jt
from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
from jaxtex.progressive import texton_masks
from jaxtex.progressive.masked import measure_depths
from jaxtex.synthesis.anisometric import sample_sources, synthesise_anisometric
from jaxtex.synthesis.sources import copy_sources

SHAPE = 256, 384  # rows and columns of what is made
GAP = 10  # pixels between pictures

# What a person might paint over the cobbles, whose stones are of the mortar's colours: ellipses, each with x and y of
# its centre and half its width and height.
GREY_STONES = (
    (32, 21, 14, 22), (68, 24, 20, 18), (113, 29, 18, 19), (137, 9, 12, 7), (165, 39, 22, 24),
    (188, 18, 12, 15), (215, 20, 7, 11), (202, 52, 12, 20), (238, 44, 17, 26), (50, 59, 19, 18),
    (93, 74, 17, 32), (179, 90, 19, 22), (222, 87, 18, 23), (16, 106, 15, 23), (95, 124, 14, 17),
    (130, 130, 20, 34), (74, 140, 17, 24), (39, 153, 20, 27), (105, 165, 18, 18), (243, 126, 20, 14),
    (143, 185, 24, 15), (12, 192, 12, 21), (49, 213, 23, 22), (96, 220, 20, 26), (155, 223, 16, 19),
    (225, 230, 16, 22), (189, 238, 12, 14), (212, 205, 8, 12), (243, 197, 14, 16), (15, 235, 15, 22),
    (249, 161, 9, 12),
)  # fmt: skip
RED_STONES = (
    (12, 57, 14, 24), (50, 100, 17, 23), (133, 73, 20, 24), (162, 129, 13, 20), (200, 131, 15, 15),
    (180, 161, 14, 19), (217, 168, 14, 24), (188, 195, 20, 17), (72, 184, 13, 16), (126, 238, 12, 18),
    (6, 23, 5, 6), (55, 247, 18, 10), (129, 220, 8, 11), (252, 72, 5, 8),
)  # fmt: skip


def read_cobbles(folder: Path) -> tuple[Floats, Labels]:
    """The photograph at half its size, encoded, and a painted mask of stones of two kinds."""
    pixels = jt.read_image(folder / "field_cobbles.jpg").pixels[: 2 * SIDE, : 2 * SIDE]
    return linear_to_srgb(pixels.reshape(SIDE, 2, SIDE, 2, 3).mean(axis=(1, 3))), paint((GREY_STONES, RED_STONES))


def paint(kinds: Sequence[Sequence[tuple[int, int, int, int]]]) -> Labels:
    """Ellipses of kinds 1, 2, ... on what is 0, the later above the earlier."""
    row, column = np.indices((SIDE, SIDE)) + 0.5
    mask = np.zeros((SIDE, SIDE), np.uint8)
    for kind, ellipses in enumerate(kinds, 1):
        for x, y, width, height in ellipses:
            mask[np.hypot((column - x) / width, (row - y) / height) < 1] = kind
    return mask


def mask_lit(picture: Floats, tolerance: float, opened: float) -> Labels:
    """All but dark gaps: what is farther than a tolerance (CIE Lab) from black, without bridges, specks and holes."""
    linear = srgb_to_linear(picture)
    gaps = jt.pick_texton_mask(linear, [jt.ColourPick(np.zeros(linear.shape[2]), tolerance)])
    lit = texton_masks.refine_texton_mask(texton_masks.invert_texton_mask(gaps), "open", opened)
    return texton_masks.fill_texton_mask(texton_masks.despeckle_texton_mask(lit, 60))


def read_coffee(folder: Path) -> tuple[Floats, Labels]:
    picture = read_picture(folder, "coffee_beans.jpg")
    return picture, mask_lit(picture, 42, 3)


def read_pebbles(folder: Path) -> tuple[Floats, Labels]:
    picture = read_picture(folder, "pebbles_coloured.jpg")
    return picture, mask_lit(picture, 42, 2)


def make_alone(pixels: Floats) -> Floats:
    """Sources of more of a picture, or of anything, by what `synthesise_masked` does with picture and mask together."""
    alike = np.ones(SHAPE)
    return synthesise_anisometric(pixels, alike, 0 * alike, key=KEY, tileable=True)


_made: dict[tuple[bytes, bytes], tuple[Floats, Labels]] = {}


def make_with(exemplar: tuple[Floats, Labels]) -> tuple[Floats, Labels]:
    """More of an exemplar, and the mask that results; made once, as figures share exemplars."""
    picture, mask = exemplar
    known = picture.tobytes(), mask.tobytes()
    if known not in _made:
        sources = jt.synthesise_masked(picture, mask, SHAPE, key=KEY)
        _made[known] = copy_sources(picture, sources), copy_sources(mask, sources)
    return _made[known]


def lay_rows(rows: Sequence[Sequence[npt.NDArray]]) -> Floats:
    """Pictures and masks in rows, those of a column equally wide, with gaps between them."""
    drawn = [[each if each.ndim == 3 else draw_mask(each) for each in row] for row in rows]
    return np.concatenate([np.concatenate([_with_gap(each) for each in row], axis=1) for row in drawn])


def _with_gap(picture: Floats) -> Floats:
    return np.pad(picture, [(0, GAP), (0, GAP), (0, 0)], constant_values=1)


def draw_figure_10(folder: Path) -> Floats:
    rows = []
    for exemplar in (read_cobbles(folder), read_pebbles(folder)):
        picture, mask = exemplar
        plain = sample_sources(picture, make_alone(picture))
        mask_alone = copy_sources(mask, np.rint(make_alone(measure_depths(mask))).astype(int))
        made, resulting = make_with(exemplar)
        rows += [[picture, plain, made], [mask, mask_alone, resulting]]
    return lay_rows(rows)


def draw_figure_11(folder: Path) -> Floats:
    exemplars = [read_exemplar(folder, name) for name in ("leopard", "cheese_holes.png")]
    exemplars += [read_coffee(folder), read_cobbles(folder)]
    return lay_rows([[*exemplar, make_with(exemplar)[0]] for exemplar in exemplars])


def draw_figure_13(folder: Path) -> Floats:
    rows = []
    for picture, mask in (read_coffee(folder), read_pebbles(folder)):
        bright = mask_lit(picture, 60, 1)
        rows += [[picture, each, make_with((picture, each))[0]] for each in (mask, bright)]
    return lay_rows(rows)
