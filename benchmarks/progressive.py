"""How fast textures are made that a mask guides (texton mask filtering). Nothing here passes or fails; ratios within
one run are what counts.

python benchmarks/progressive.py            # minutes; writes benchmarks/results/progressive-cpu.md
python benchmarks/progressive.py --only loop

Seconds are those of the quickest of some turns, which go round all that a table compares. The precomputation is what
is found out from the exemplar alone. Processor seconds are those of all threads, which other processes hardly lengthen.
"""

import argparse
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import Any, NamedTuple
from unittest import mock

import jax
import numba_anisometric as plain
import numpy as np
from pictures import brick_wall
from timing import Result, Row, show, write_report

import jaxtex as jt
from jaxtex.progressive import filtering
from jaxtex.progressive.warping import signed_distance
from jaxtex.synthesis import anisometric, anisometric_refinement
from jaxtex.synthesis.anisometric_pass import decide_all
from jaxtex.synthesis.exemplars import analyse_levels

KEY = jax.random.key(0)
SIMILAR = 19  # with its own continuation k = 20 for each neighbour
SHAPE = 128, 512  # rows, columns
NEIGHBOURS = 9  # pixels that bring candidates, with the pixel itself
TURNS = 4


class Parts(NamedTuple):
    """Seconds of the precomputation and of the rest, processor seconds of the rest, and places of the exemplar that
    pixels are compared with."""

    known: float
    rest: float
    processor: float
    compared: float


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parts = {"loop": time_loop, "pixels": time_pixels, "candidates": time_candidates, "exemplars": time_exemplars}
    parser.add_argument("--only", choices=parts, help="only this part")
    options = parser.parse_args()
    results = [part() for name, part in parts.items() if options.only in (None, name)]
    show(results)
    if options.only is None:
        write_report("progressive", "Speed of texton mask filtering", results)


def filter_bricks(side: int = 128, shape: tuple[int, int] = SHAPE, similar: int = SIMILAR) -> np.ndarray:
    """Sources of bricks that lie as those in a square picture do, side by side."""
    picture = np.sqrt(brick_wall(2 * side)[:side, :side])
    mask = (picture.mean(axis=2) > np.median(picture)).astype(np.uint8)
    wanted = np.tile(mask, [-(-length // side) for length in shape])[: shape[0], : shape[1]]
    return jt.filter_mask(picture, mask, wanted, key=KEY, similar=similar)


def take_apart(work: Callable[[], Any], decide: Callable[..., Any]) -> Parts:
    """One turn of some work, with this pass over pixels."""
    known, known_processor, compared, masks = 0.0, 0.0, 0, 0

    def learn(find: Callable[[], Any]) -> Any:
        nonlocal known, known_processor
        began, began_processor = time.perf_counter(), time.process_time()
        found = find()
        known += time.perf_counter() - began
        known_processor += time.process_time() - began_processor
        return found

    def analyse(*arguments: Any, **options: Any) -> Any:
        def find() -> Any:
            levels = analyse_levels(*arguments, **options)
            jax.block_until_ready([(level.features, level.similar) for level in levels])
            return levels

        return learn(find)

    def measure_depths(mask: np.ndarray) -> np.ndarray:
        nonlocal masks
        masks += 1  # the first is the exemplar's, the second the texture's
        return learn(lambda: signed_distance(mask)) if masks == 1 else signed_distance(mask)

    def decide_and_count(exemplar: Any, *arguments: Any) -> Any:
        nonlocal compared
        *_, counts, _, everywhere, _ = arguments
        places = NEIGHBOURS * exemplar.similar.shape[1] + (exemplar.valid.size if everywhere else 0)
        compared += int(counts.sum()) * places
        return decide(exemplar, *arguments)

    with ExitStack() as patches:
        patches.enter_context(mock.patch.object(filtering, "signed_distance", measure_depths))
        for module in (anisometric, anisometric_refinement):
            patches.enter_context(mock.patch.multiple(module, analyse_levels=analyse, decide_all=decide_and_count))
        began, began_processor = time.perf_counter(), time.process_time()
        work()
        rest, processor = time.perf_counter() - began - known, time.process_time() - began_processor - known_processor
    return Parts(known, rest, processor, compared)


def measure(works: Sequence[Callable[[], Any]], passes: Sequence[Callable[..., Any]] | None = None) -> list[Parts]:
    """Each one's quickest turn of some, after one that compiles."""
    pairs = list(zip(works, passes or [decide_all] * len(works), strict=True))
    turns = [[take_apart(*pair) for pair in pairs] for _ in range(TURNS + 1)]
    return [min(those, key=lambda each: each.known + each.rest) for those in zip(*turns[1:], strict=True)]


def time_loop() -> Result:
    made: list[np.ndarray] = []

    def work() -> None:
        made.append(filter_bricks())

    ours, loop = measure([work, work], [decide_all, plain.decide_all])
    same = np.mean(np.abs(made[-2] - made[-1]).max(axis=-1) < 0.5)
    rows: list[Row] = [("precomputation, s", f"{ours.known:.2f}", f"{loop.known:.2f}", "")]
    for name, one, other in (
        ("the rest, s", ours.rest, loop.rest),
        ("all, s", ours.known + ours.rest, loop.known + loop.rest),
        ("the rest, processor s", ours.processor, loop.processor),
    ):
        rows.append((name, f"{one:.2f}", f"{other:.2f}", f"{one / other:.2f}"))
    rows.append(("pixels of one source in both", f"{same:.1%}", "", ""))
    head = ("128² to 512 x 128, k = 20", "jaxtex", "Numba loop", "jaxtex / Numba")
    return "Texton mask filtering, RGB and mask, 7 x 7, warm, against one thread of Numba", head, rows


def tabulate(names: Sequence[str], works: Sequence[Callable[[], Any]], pixels: Sequence[int]) -> tuple[Row, list[Row]]:
    rows: list[Row] = []
    for name, parts, count in zip(names, measure(works), pixels, strict=True):
        per_pixel = f"{parts.processor / count * 1e6:.0f}"
        told = (f"{parts.known:.2f}", f"{parts.rest:.2f}", f"{parts.processor:.2f}", per_pixel)
        rows.append((name, *told, f"{parts.compared / count:.0f}"))
    head = ("precomputation, s", "the rest, s", "the rest, processor s", "processor µs to a pixel", "places to a pixel")
    return head, rows


def time_pixels() -> Result:
    shapes = (128, 256), (128, 512), (256, 512), (512, 512)
    works = [lambda shape=shape: filter_bricks(shape=shape) for shape in shapes]
    names = [f"{columns} x {rows}" for rows, columns in shapes]
    head, rows = tabulate(names, works, [rows * columns for rows, columns in shapes])
    return "Growth with pixels, 128² exemplar, k = 20", ("texture", *head), rows


def time_candidates() -> Result:
    counts = 1, 4, 10, 20, 40
    works = [lambda count=count: filter_bricks(similar=count - 1) for count in counts]
    head, rows = tabulate([str(count) for count in counts], works, [SHAPE[0] * SHAPE[1]] * len(counts))
    return "Growth with k, 128² to 512 x 128", ("k", *head), rows


def time_exemplars() -> Result:
    sides = 64, 128, 256, 512
    works = [lambda side=side: filter_bricks(side) for side in sides]
    head, rows = tabulate([f"{side}²" for side in sides], works, [SHAPE[0] * SHAPE[1]] * len(sides))
    return "Growth with the exemplar, to 512 x 128, k = 20", ("exemplar", *head), rows


if __name__ == "__main__":
    main()
