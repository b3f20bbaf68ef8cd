"""How fast textures are made that a mask guides (texton mask filtering). Nothing here passes or fails; ratios within
one run are what counts.

python benchmarks/progressive.py            # minutes; writes benchmarks/results/progressive-cpu.md
python benchmarks/progressive.py --only loop
"""

import argparse
from unittest import mock

import jax
import numba_anisometric as plain
import numpy as np
from pictures import brick_wall
from timing import Result, Row, clock, show, write_report

from jaxtex.synthesis.anisometric import synthesise_anisometric
from jaxtex.synthesis.exemplars import analyse_levels

KEY = jax.random.key(0)
SIMILAR = 19  # with its own continuation k = 20 for each neighbour
SHAPE = 128, 512  # rows, columns


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parts = {"loop": time_loop, "pixels": time_pixels, "candidates": time_candidates, "exemplars": time_exemplars}
    parser.add_argument("--only", choices=parts, help="only this part")
    options = parser.parse_args()
    results = [part() for name, part in parts.items() if options.only in (None, name)]
    show(results)
    if options.only is None:
        write_report("progressive", "Speed of texton mask filtering", results)


def bricks(side: int) -> tuple[np.ndarray, np.ndarray]:
    """A picture of bricks [row, col, 3], and a mask of them [row, col, 1]."""
    picture = np.sqrt(brick_wall(2 * side)[:side, :side])
    return picture, (picture.mean(axis=2, keepdims=True) > np.median(picture)).astype(float)


def tiled(mask: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    return np.pad(mask, [(0, max(0, a - b)) for a, b in zip(shape, mask.shape, strict=False)] + [(0, 0)], mode="wrap")[
        : shape[0], : shape[1]
    ]


def filter_mask(side: int = 128, shape: tuple[int, int] = SHAPE, similar: int = SIMILAR) -> np.ndarray:
    exemplar, mask = bricks(side)
    alike = np.ones(shape)
    guides = mask, tiled(mask, shape)
    return synthesise_anisometric(exemplar, alike, 0 * alike, key=KEY, guides=guides, similar=similar)


def analyse(side: int, similar: int = SIMILAR) -> None:
    """The precomputation alone, as it is within the above."""
    pixels = np.concatenate(bricks(side), axis=2).astype(np.float32)
    levels = analyse_levels(pixels, np.ones((side, side), bool), radius=3, coarsest=32, similar=similar)
    jax.block_until_ready([level.similar for level in levels])


def time_loop() -> Result:
    with mock.patch("jaxtex.synthesis.anisometric.decide_all", plain.decide_all):
        expected = filter_mask()
        loop = clock(filter_mask)
    same = np.mean(np.abs(filter_mask() - expected).max(axis=-1) < 0.5)
    ours, known = clock(filter_mask), clock(lambda: analyse(128))
    rows: list[Row] = [
        ("all, seconds", f"{ours:.2f}", f"{loop:.2f}", f"{ours / loop:.2f}"),
        (
            "without precomputation",
            f"{ours - known:.2f}",
            f"{loop - known:.2f}",
            f"{(ours - known) / (loop - known):.2f}",
        ),
        ("pixels of one source in both", f"{same:.1%}", "", ""),
    ]
    head = ("128² to 512 x 128, k = 20", "jaxtex", "Numba loop", "jaxtex / Numba")
    return "Texton mask filtering, RGB and mask, 7 x 7, warm, against one thread of Numba", head, rows


def time_pixels() -> Result:
    rows: list[Row] = []
    for shape in ((128, 256), (128, 512), (256, 512), (512, 512)):
        taken = clock(lambda shape=shape: filter_mask(shape=shape), 1)
        rows.append((f"{shape[1]} x {shape[0]}", f"{taken:.2f}", f"{taken / (shape[0] * shape[1]) * 1e6:.1f}"))
    return "Growth with pixels, 128² exemplar, k = 20", ("texture", "seconds", "µs for each pixel"), rows


def time_candidates() -> Result:
    rows: list[Row] = []
    for count in (1, 4, 10, 20, 40):
        taken = clock(lambda count=count: filter_mask(similar=count - 1), 1)
        known = clock(lambda count=count: analyse(128, max(count - 1, 1)), 1)
        rows.append((str(count), f"{known:.2f}", f"{taken - known:.2f}"))
    return "Growth with k, 128² to 512 x 128", ("k", "precomputation, s", "the rest, s"), rows


def time_exemplars() -> Result:
    rows: list[Row] = []
    for side in (64, 128, 256, 512):
        known, taken = clock(lambda side=side: analyse(side), 1), clock(lambda side=side: filter_mask(side), 1)
        rows.append((f"{side}²", f"{known:.2f}", f"{taken - known:.2f}"))
    return "Growth with the exemplar, to 512 x 128, k = 20", ("exemplar", "precomputation, s", "the rest, s"), rows


if __name__ == "__main__":
    main()
