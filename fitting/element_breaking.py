"""Whether elements break: textures made with the mask of their exemplar's elements, and without.

    python fitting/element_breaking.py FOLDER -o OUT

FOLDER holds pictures made of things; masks are what `propose_texton_mask` makes of them. OUT/breaking.png has a row for
each: the picture, what is told as its elements, and what is made of it: by what `jaxtex synth` does by itself; by the
search that masks are used with, without mask ("plain": "the same synthesis procedure", as the caption of figure 10 has
it) and with; and by these two larger from left to right, from 0.6 to 1.7 times.

OUT/breaking.md says how far the elements' areas (over the square of the scale where they are), and their perimeter²
over area, are from the exemplar's: Wasserstein distances in octaves. Elements of all seeds are taken together: one
picture holds few, and then even the exemplar's own halves lie as far apart as `halves` says, by chance. Each picture is
as large as its exemplar, so that as many large elements are cut off by the border and left out in all.
`whole` is the share of elements, by mask, that are copied as they are in one piece, where nothing is scaled.
What follows ± is by how much ratios vary with what seeds there are (jackknife).
"""

import argparse
import itertools
import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

import jax
import numpy as np
import numpy.typing as npt
from element_shapes import Elements, find_elements, join_elements, learn_classes, measure_apart, share_whole
from jax import Array
from tables import make_table

import jaxtex as jt
from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
from jaxtex.io.files import atomic_write_text, prepare_folder
from jaxtex.progressive.masked import mark_elements, synthesise_masked
from jaxtex.synthesis.anisometric import make_frames, sample_sources, synthesise_anisometric
from jaxtex.synthesis.coherence import synthesise_coherence

PICTURES = (
    "pebbles_coloured.jpg",
    "coffee_beans.jpg",
    "pebbles_sh3.jpg",
    "coins_sk.png",
    "field_cobbles.jpg",
    "reptile_skin.png",
    "cheese_holes.png",
    "terrazzo018.png",
    "terrazzo009.png",
    "gravel_gray_sk.png",
)
LARGEST = 320  # pixels along either side of what is learnt from
SPAN = 0.53  # natural logarithm of how much larger than the exemplar's things become
WAYS = "default", "plain", "mask", "scaled plain", "scaled mask"
SCALED = WAYS[3:]
PAIRS = ("mask", "plain"), ("mask", "default"), ("scaled mask", "scaled plain")
CLEARLY = 0.9  # of the distances without mask

Bools = npt.NDArray[np.bool_]


class Compared(NamedTuple):
    """Attributes:
    cells: of the sheet.
    apart: of areas and of compactness, by way, [way, 2].
    halves: likewise, of one half of the exemplar against the other.
    count: of whole elements that the exemplar has.
    whole: the share of elements that are one of the exemplar's as it is, by way that is not scaled.
    ratios: of the distances with mask to those without, the mean of both: by pair of ways, and their errors, [pair, 2].
    """

    cells: list[np.ndarray]
    apart: np.ndarray
    halves: np.ndarray
    count: int
    whole: list[float]
    ratios: np.ndarray


def compare(picture: np.ndarray, mask: Bools, seeds: int) -> Compared:
    classes = learn_classes(picture, mask)
    own = find_elements(picture, classes)
    cells = [linear_to_srgb(picture), own.mask[..., None].astype(np.float32)]
    found: dict[str, list[Elements]] = {way: [] for way in WAYS}
    whole: dict[str, list[float]] = {way: [] for way in WAYS if way not in SCALED}
    scales = np.exp(np.linspace(-SPAN, SPAN, mask.shape[1]))[None].repeat(mask.shape[0], axis=0)
    for way, each in itertools.product(WAYS, range(seeds)):
        scale = scales if way in SCALED else None
        sources, made = synthesise(way, picture, mask, scale, jax.random.key(each))
        if scale is None:
            whole[way].append(share_whole(mask, np.rint(sources).astype(int)))
        found[way].append(find_elements(made, classes, scale))
        if each == 0:
            cells.append(linear_to_srgb(np.maximum(made, 0)))

    def apart_without(left_out: int | None) -> np.ndarray:
        kept = [[each for n, each in enumerate(found[way]) if n != left_out] for way in WAYS]
        return np.array([measure_apart(join_elements(each), own) for each in kept])

    def compare_ways(apart: np.ndarray) -> np.ndarray:
        told = dict(zip(WAYS, np.log(apart).mean(axis=1), strict=True))
        return np.exp([told[with_mask] - told[without] for with_mask, without in PAIRS])

    apart = apart_without(None)
    others = np.array([compare_ways(apart_without(each)) for each in range(seeds)])
    errors = np.sqrt(seeds - 1) * others.std(axis=0)
    half = picture.shape[1] // 2
    halves = measure_apart(find_elements(picture[:, :half], classes), find_elements(picture[:, half:], classes))
    ratios = np.stack([compare_ways(apart), errors], axis=1)
    shares = [float(np.mean(each)) for each in whole.values()]
    return Compared(cells, apart, np.array(halves), len(own.areas), shares, ratios)


def synthesise(
    way: str, picture: np.ndarray, mask: Bools, scale: np.ndarray | None, key: Array
) -> tuple[np.ndarray, np.ndarray]:
    """More of a picture, as large as it, by one of some ways: where its pixels come from, and they."""
    exemplar = linear_to_srgb(picture)
    sizes, flat = np.ones(mask.shape) if scale is None else scale, np.zeros(mask.shape)
    if way == "default":
        sources = synthesise_coherence(exemplar, mask.shape, key=key)
    elif way == "mask":
        sources = synthesise_masked(exemplar, mask, mask.shape, key=key)
    else:
        looked_at = mark_elements(exemplar, mask) if way == "scaled mask" else exemplar
        sources = synthesise_anisometric(looked_at, sizes, flat, key=key, tileable=scale is None)
    return sources, sample_sources(picture, sources, make_frames(sizes, flat))


def fit_in(picture: np.ndarray) -> np.ndarray:
    cell = np.ones((LARGEST, LARGEST, 3), np.float32)
    cell[: picture.shape[0], : picture.shape[1]] = picture
    return cell


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="pictures made of things")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT", help="folder for what is made")
    parser.add_argument("--only", nargs="+", metavar="NAME", default=PICTURES, help="these pictures alone")
    parser.add_argument("--seeds", type=int, default=6, help="textures made of each picture; by default 6")
    options = parser.parse_args(words)
    if options.seeds < 2:
        parser.error(f"argument --seeds: {options.seeds} is too few to tell errors; give 2 or more")
    prepare_folder(options.output)
    rows, lines, closer = [], [], np.zeros(len(PAIRS), int)
    for name in options.only:
        pixels = jt.read_image(options.folder / name).pixels[:LARGEST, :LARGEST]
        found = compare(pixels, jt.propose_texton_mask(pixels) > 0, options.seeds)
        rows.append(np.concatenate([fit_in(each) for each in found.cells], axis=1))
        closer += found.ratios[:, 0] < CLEARLY
        told = [" ".join(f"{each:.3f}" for each in row) for row in (*found.apart, found.halves)]
        lines.append([name, str(found.count), *told, " ".join(f"{each:.0%}" for each in found.whole)])
        lines[-1] += [f"{ratio:.2f} ± {error:.2f}" for ratio, error in found.ratios]
        print(" | ".join(lines[-1]), flush=True)
    ratios = [f"{one} / {other}" for one, other in PAIRS]
    table = make_table(("picture", "elements", *WAYS, "halves", "whole: default, plain, mask", *ratios), lines)
    counts = ", ".join(f"{count} ({ratio})" for count, ratio in zip(closer, ratios, strict=True))
    told = (
        f"Of areas and of shapes, elements of {options.seeds} seeds together. Of {len(lines)}, clearly closer, below "
        f"{CLEARLY} in the mean of both: {counts}."
    )
    atomic_write_text(options.output / "breaking.md", f"# Elements, with mask and without\n\n{table}\n\n{told}\n")
    print(f"{table}\n{told}")
    jt.write_image(options.output / "breaking.png", srgb_to_linear(np.concatenate(rows)))


if __name__ == "__main__":
    main()
