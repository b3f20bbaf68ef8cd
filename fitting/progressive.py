"""Progressively-variant textures: figures of J. Zhang et al. (SIGGRAPH 2003) made again.

    python fitting/progressive.py FOLDER -o OUT [--only figure_5 figure_7]

FOLDER holds photographs; coats of a leopard and a tiger are grown by `reaction_diffusion.py`.

figure_2   a texture that varies, another made of it without its directions being known, and with; fields above both
figure_3   things made smaller to the right, each beside its exemplar
figure_5   a tiger's stripes made thinner to the right, along rows alone: exemplar, mask, mask warped, texture
figure_6   a leopard's rosettes become spots: light areas shrink together, and then those between rosettes widen
warping    elements scaled, turned and moved about their centres, and a mask bent by a mesh
figure_7   blending: Wei's mixture, ours, with masks averaged alike everywhere, cross-faded; below, three textures
figure_8   masks of figure 7: M0 and M1; the paper's M, that blurred, that thresholded; ours; averaged likewise
figure_10  exemplar and mask; more of either alone; more of both together
figure_11  exemplars, their masks, and what is made with these; the last mask is painted, with two kinds of elements
figure_13  two masks of each exemplar, and what is made with either
OUT/blending.md (`--only blending`) tells what blends of figure 7 measure.
"""

import argparse
import os
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

import jax
import numpy as np
from progressive_blending import blend_labels, going_beyond, kept_edges, measure_blend, mix_textures, turning_back
from progressive_exemplars import KEY, Floats, Labels, draw_mask, read_exemplar
from progressive_fields import draw_figure_2, draw_figure_3
from progressive_masks import draw_figure_10, draw_figure_11, draw_figure_13
from tables import make_table

import jaxtex as jt
from jaxtex.core.colour import srgb_to_linear
from jaxtex.io.files import atomic_write_text, prepare_folder
from jaxtex.progressive.blending import lay_out_mask
from jaxtex.synthesis.anisometric import sample_sources

BLEND_SIZE, BLEND_BORDER = (160, 448), 64  # rows and columns of a blend; columns at either end of one texture alone
PAIRS = ("tiger", "leopard"), ("pebbles_coloured.jpg", "coffee_beans.jpg"), ("reptile_skin.png", "cheese_holes.png")


def filtered(exemplar: Floats, mask: Labels, wanted: Labels) -> Floats:
    return sample_sources(exemplar, jt.filter_mask(exemplar, mask, wanted, key=KEY))


def ramp(mask: Labels) -> Floats:
    return np.broadcast_to(np.linspace(0, 1, mask.shape[1]), mask.shape)


def draw_figure_5(folder: Path) -> Floats:
    exemplar, mask = read_exemplar(folder, "tiger")
    wide = np.tile(mask, (1, 2))
    thinner = jt.grow_mask(wide, -6 * ramp(wide), types=(1,), direction="horizontal")
    return np.concatenate(
        [
            np.concatenate([exemplar, draw_mask(mask)], axis=1),
            draw_mask(thinner),
            filtered(exemplar, mask, thinner),
        ]
    )


def draw_figure_6(folder: Path) -> Floats:
    exemplar, mask = read_exemplar(folder, "leopard")
    wide = np.tile(mask, (1, 2))
    closed = jt.grow_mask(wide, -3 * ramp(wide), types=(0, 1))
    closed = jt.grow_mask(closed, -7 * ramp(wide), types=(1,))  # rosettes are wider than what is between them
    spots = jt.grow_mask(closed, 5 * ramp(wide), types=(0,))
    rows = [np.concatenate([exemplar, draw_mask(mask)], axis=1)]
    for each in (closed, spots):
        rows += [draw_mask(each), filtered(exemplar, mask, each)]
    return np.concatenate(rows)


def draw_warping(folder: Path) -> Floats:
    exemplar, mask = read_exemplar(folder, "cheese_holes.png")
    larger = jt.displace_elements(mask, scale=0.6 + 1.0 * ramp(mask))
    leopard, rosettes = read_exemplar(folder, "leopard")
    down, right = np.indices((5, 5)) / 4 * 2 - 1
    mesh = 30 * np.stack([np.sin(np.pi * right / 2) * (1 - down**2), 0 * right], axis=2) * (1 - right[..., None] ** 2)
    scales = read_exemplar(folder, "reptile_skin.png")
    turned = jt.displace_elements(scales[1], scale=0.7, turn=0.22 * np.pi * ramp(scales[1]))
    rows = []
    for picture, labels, moves in ((exemplar, mask, larger), (leopard, rosettes, mesh), (*scales, turned)):
        warped = jt.warp_mask(labels, moves)
        shown = picture, draw_mask(labels), draw_mask(warped), filtered(picture, labels, warped)
        rows.append(np.concatenate([each[: mask.shape[0], : mask.shape[1]] for each in shown], axis=1))
    return np.concatenate(rows)


@cache
def lay_out(folder: Path, names: tuple[str, ...]) -> tuple[list[Floats], list[Labels], list[Labels], Floats]:
    """Exemplars, their masks, masks of elements of all at the blend's size, and weights."""
    read = [read_exemplar(folder, name) for name in names]
    masks = [(mask == mask.max()).astype(np.uint8) for _, mask in read]
    laid = [
        lay_out_mask(exemplar, mask, BLEND_SIZE, key=key)
        for (exemplar, _), mask, key in zip(read, masks, jax.random.split(KEY, len(read)), strict=True)
    ]
    columns = np.arange(BLEND_SIZE[1])
    far = np.clip((columns - BLEND_BORDER) / (BLEND_SIZE[1] - 2 * BLEND_BORDER), 0, 1)
    weights = jt.transition_weights(np.broadcast_to(far, BLEND_SIZE), len(names))
    return [each for each, _ in read], masks, laid, weights


def average_masks(laid: list[Labels], weights: Floats) -> Labels:
    """Both masks count alike wherever neither is alone."""
    return blend_labels(laid, np.where((weights == 0) | (weights == 1), weights, 1 / len(laid)))[2]


def lay_layers(exemplars: list[Floats], masks: list[Labels], wanted: list[Labels]) -> Floats:
    """Each texture, [texture, row, col, 3], filtered from its wanted mask."""
    return np.stack([filtered(*each) for each in zip(exemplars, masks, wanted, strict=True)])


def blend_colours(layers: Floats, weights: Floats) -> Floats:
    return np.einsum("nrc,nrck->rck", weights, layers)


WAYS: dict[str, Callable[[list[Labels], Floats], Labels]] = {
    "ours": lambda masks, weights: jt.blend_masks(masks, weights),
    "labels blended": lambda masks, weights: blend_labels(masks, weights)[2],
    "masks averaged": average_masks,
}


@cache
def blend_pair(folder: Path, names: tuple[str, str]) -> dict[str, Floats]:
    """The layers that each way of blending masks makes of two textures, and those that are cross-faded."""
    exemplars, masks, laid, weights = lay_out(folder, names)
    made = {way: lay_layers(exemplars, masks, [blend(laid, weights)] * 2) for way, blend in WAYS.items()}
    return made | {"cross-fade": lay_layers(exemplars, masks, laid)}


def draw_figure_7(folder: Path) -> Floats:
    rows = []
    for pair in PAIRS:
        exemplars, _, _, weights = lay_out(folder, pair)
        made = blend_pair(folder, pair)
        rows.append(mix_textures(exemplars, weights))
        rows += [blend_colours(made[way], weights) for way in ("ours", "masks averaged", "cross-fade")]
    exemplars, masks, laid, weights = lay_out(folder, ("reptile_skin.png", "leopard", "tiger"))
    layers = lay_layers(exemplars, masks, [jt.blend_masks(laid, weights)] * 3)
    return np.concatenate([*rows, blend_colours(layers, weights)])


def draw_figure_8(folder: Path) -> Floats:
    rows = []
    for pair in PAIRS:
        _, _, laid, weights = lay_out(folder, pair)
        sheets = [*laid, *blend_labels(laid, weights), jt.blend_masks(laid, weights)]
        sheets += [*blend_labels(laid, np.full_like(weights, 0.5))[1:]]
        rows.append(np.concatenate([draw_mask(each) for each in sheets]))
    return np.concatenate(rows, axis=1)


def tell_blending(folder: Path) -> str:
    """Tables of what masks of blends are like from strip to strip, and of what edges are left in their middle."""
    strips, edges = [], []
    middle = slice(*(BLEND_SIZE[1] * np.array([2, 3]) // 5))
    for pair in PAIRS:
        _, _, laid, weights = lay_out(folder, pair)
        for way, blend in WAYS.items():
            found = measure_blend(laid, weights, blend)
            cells = [
                f"{' '.join(f'{each:.3g}' for each in row)} ({turning_back(row):.0%}, {going_beyond(row):.0%})"
                for row in found
            ]
            strips.append([" to ".join(pair), way, *cells])
        made = blend_pair(folder, pair)
        edges.append([" to ".join(pair), *(f"{kept_edges(each, weights, middle):.2f}" for each in made.values())])
    heads = ["blend", "masks", "share covered", "elements in 100 x 100 pixels", "perimeter²/(4 pi area)"]
    return (
        "What elements are like in strips from left to right; in brackets, how much of the way is gone back, and how\n"
        "far they go beyond both ends.\n\n"
        f"{make_table(heads, strips)}\n\n"
        "How much of the strength of edges is left in the middle of the blend.\n\n"
        f"{make_table(['blend', *WAYS, 'cross-fade'], edges)}\n"
    )


FIGURES: dict[str, Callable[[Path], Floats]] = {
    "figure_2": draw_figure_2,
    "figure_3": draw_figure_3,
    "figure_5": draw_figure_5,
    "figure_6": draw_figure_6,
    "warping": draw_warping,
    "figure_7": draw_figure_7,
    "figure_8": draw_figure_8,
    "figure_10": draw_figure_10,
    "figure_11": draw_figure_11,
    "figure_13": draw_figure_13,
}


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="photographs, by the names that the script tells")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT", help="folder for what is made")
    parser.add_argument("--only", nargs="+", choices=[*FIGURES, "blending"], metavar="NAME", help="all by default")
    options = parser.parse_args(words)
    prepare_folder(options.output)
    chosen = options.only or [*FIGURES, "blending"]
    for name, draw in FIGURES.items():
        if name in chosen:
            drawn = draw(options.folder)
            jt.write_image(options.output / f"{name}.png", srgb_to_linear(np.clip(drawn, 0, 1)))
    if "blending" in chosen:
        atomic_write_text(options.output / "blending.md", tell_blending(options.folder))


if __name__ == "__main__":
    main()
