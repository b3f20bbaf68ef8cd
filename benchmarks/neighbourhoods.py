"""How fast textures are made pixel by pixel. Nothing here passes or fails; ratios within one run are what counts.

python benchmarks/neighbourhoods.py            # minutes; writes benchmarks/results/neighbourhoods-cpu.md
python benchmarks/neighbourhoods.py --only ashikhmin
"""

import argparse
from typing import Any

import jax
import numba_ashikhmin as plain
import numpy as np
from pictures import brick_wall
from timing import Result, Row, clock, clock_in_turn, show, write_report

from jaxtex.synthesis.ashikhmin import synthesise_ashikhmin
from jaxtex.synthesis.nearest import find_similar
from jaxtex.synthesis.neighbourhoods import draw_bits, draw_place, pass_seed, pixel_bits, quantise, square_offsets
from jaxtex.synthesis.wei_levoy import synthesise_wei_levoy

KEY = jax.random.key(0)
SEED = np.asarray(pass_seed(KEY, 0))
PASS_SEED = np.asarray(pass_seed(jax.random.fold_in(KEY, 0), 0))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parts = {"ashikhmin": time_ashikhmin, "modes": time_modes, "wei-levoy": time_wei_levoy, "similar": time_similar}
    parser.add_argument("--only", choices=parts, help="only this part")
    options = parser.parse_args()
    results = [part() for name, part in parts.items() if options.only in (None, name)]
    show(results)
    if options.only is None:
        write_report("neighbourhoods", "Speed of synthesis by neighbourhoods", results)


def bricks(size: int) -> np.ndarray:
    return np.sqrt(brick_wall(2 * size)[:size, :size])


def make(exemplar: np.ndarray, size: int, **options: Any) -> np.ndarray:
    return np.asarray(synthesise_ashikhmin(exemplar, (size, size), key=KEY, **options))


def flat(sources: np.ndarray, exemplar: np.ndarray) -> np.ndarray:
    return sources @ np.array([exemplar.shape[1], 1])


def time_ashikhmin() -> Result:
    """Against the loop, which gives the same result; exemplars of several sizes."""
    rows: list[Row] = []
    for side, size in ((192, 200), (192, 500), (192, 2048), (64, 500), (512, 500)):
        exemplar = bricks(side)
        levels = quantise(exemplar)
        expected = plain.synthesise_ashikhmin(levels, (size, size), PASS_SEED, 2)
        assert (flat(make(exemplar, size), exemplar) == expected).all()
        ours, theirs = clock_in_turn(
            lambda exemplar=exemplar, size=size: make(exemplar, size),
            lambda levels=levels, size=size: plain.synthesise_ashikhmin(levels, (size, size), PASS_SEED, 2),
            turns=20 if size < 2048 else 6,
        )
        speed = f"{size * size / ours / 1e6:.1f}"
        rows.append((f"{side}² to {size}²", f"{ours:.4f}", f"{theirs:.4f}", f"{ours / theirs:.2f}", speed))
    head = ("exemplar to output", "jaxtex, s", "Numba loop, s", "jaxtex / Numba", "jaxtex, Mpixel/s")
    return "Ashikhmin, RGB, 5 x 5, warm, against one thread of Numba without duplicate candidates", head, rows


def time_modes() -> Result:
    """What targets, passes, repetition and k-coherence cost."""
    exemplar, size = bricks(192), 500
    similar = np.asarray(find_similar(exemplar, radius=2, count=4))
    modes: dict[str, dict[str, Any]] = {
        "plain": {},
        "tileable": {"tileable": True},
        "target, one pass": {"target": np.zeros((size, size, 3))},
        "two passes": {"passes": 2},
        "k = 4": {"similar": similar},
        "9 x 9": {"radius": 4},
    }
    rows: list[Row] = [
        (name, f"{clock(lambda options=options: make(exemplar, size, **options), 3):.3f}")
        for name, options in modes.items()
    ]
    return "Ashikhmin's other modes, 192² to 500², warm", ("mode", "seconds"), rows


def time_wei_levoy() -> Result:
    """Exhaustive search, the loop's time taken from its first rows; the tree with the quality of what it finds."""
    exemplar, size, radius = bricks(128), 256, 4
    levels, some = quantise(exemplar), 16
    first = int(draw_place(draw_bits(pixel_bits(SEED, np.zeros(1, np.uint32)), 0), levels.shape[:2], radius)[0])

    def search(kind: Any, rows: int = size) -> np.ndarray:
        return np.asarray(synthesise_wei_levoy(exemplar, (rows, size), key=KEY, radius=radius, search=kind))

    found = search("full", some)
    assert (flat(found, exemplar) == plain.synthesise_wei_levoy(levels, (some, size), first, radius, True)).all()
    full, tree, patient, hasty = clock_in_turn(
        lambda: search("full"),
        lambda: search("tree"),
        lambda: plain.synthesise_wei_levoy(levels, (some, size), first, radius, False),
        lambda: plain.synthesise_wei_levoy(levels, (some, size), first, radius, True),
        turns=3,
    )
    rows: list[Row] = []
    for name, taken in (("Numba loop, all distances in full", patient), ("Numba loop that gives up early", hasty)):
        rows.append((name, f"{taken * size / some:.1f}", f"{taken * size / some / full:.1f}", ""))
    rows.append(("jaxtex, full", f"{full:.2f}", "1", f"{misfit(levels, search('full'), radius):.1f}"))
    rows.append(("jaxtex, tree", f"{tree:.2f}", f"{tree / full:.2f}", f"{misfit(levels, search('tree'), radius):.1f}"))
    head = ("search", "seconds", "of jaxtex, full", "misfit, 8-bit levels")
    return "Wei and Levoy, RGB, 9 x 9, 128² to 256², warm", head, rows


def misfit(levels: np.ndarray, sources: np.ndarray, radius: int) -> float:
    """Root mean square difference between causal neighbourhoods in the texture and where they are copied from."""
    made = levels[sources[..., 0], sources[..., 1]].astype(int)
    inner = sources[radius:, radius:-radius]
    squares = []
    for dy, dx in square_offsets(radius)[: 2 * radius * (radius + 1)]:
        there = levels[inner[..., 0] + dy, inner[..., 1] + dx].astype(int)
        here = np.roll(made, (-dy, -dx), axis=(0, 1))[radius:, radius:-radius]
        squares.append(np.square(there - here).mean())
    return float(np.sqrt(np.mean(squares)))


def time_similar() -> Result:
    rows: list[Row] = []
    for side in (128, 192, 256):
        exemplar = bricks(side)
        taken = clock(lambda exemplar=exemplar: np.asarray(find_similar(exemplar, radius=2, count=8)), 2)
        rows.append((f"{side}²", f"{taken:.2f}"))
    return "Similar places, RGB, 5 x 5, 8 for each place, warm", ("exemplar", "seconds"), rows


if __name__ == "__main__":
    main()
