"""How fast wood is fitted and rendered. Nothing here passes or fails; ratios within one run are what counts.

python benchmarks/wood.py            # all of it, some minutes; writes benchmarks/results/wood-cpu.md
python benchmarks/wood.py --help
"""

import argparse
import json
import os
import sys
import tempfile
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from timing import Result, Row, rate, run, seconds, show, write_report


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photo", type=Path, help="a photograph in place of the generated board of 512 x 512")
    parser.add_argument("--planks", type=int, default=32, help="planks in the batch (default 32)")
    parser.add_argument("--block", type=int, default=256, help="voxels along a side of the block (default 256)")
    parser.add_argument("--only", choices=["photo", "batch", "block"], help="only this part")
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        print(json.dumps(fit_photo(options.photo)))
        return
    with tempfile.TemporaryDirectory() as folder:
        parts = {
            "photo": lambda: time_photo(options.photo, Path(folder)),
            "batch": lambda: time_batch(options.planks),
            "block": lambda: time_block(options.block),
        }
        results = [part() for name, part in parts.items() if options.only in (None, name)]
    show(results)
    if options.only is None:
        write_report("wood", "Speed of wood", results)


def fit_photo(path: Path | None) -> dict[str, float]:
    """Two fits in this process: seconds of the first, cold or with kernels from the cache, and of the second."""
    from jaxtex.fitting.wood import fit_wood
    from jaxtex.io.images import read_image

    assert path is not None
    pixels = read_image(path).pixels
    first, second = (fit_wood(pixels).seconds for _ in range(2))
    return {
        f"{name} {step}": spent
        for name, each in (("first", first), ("second", second))
        for step, spent in {**each, "all": sum(each.values())}.items()
    }


def time_photo(path: Path | None, folder: Path) -> Result:
    """A photograph, and the whole command: a new process with an empty cache of kernels, with a full one, and warm."""
    from pictures import wooden_board

    from jaxtex.io.images import read_image, write_image

    if path is None:
        path = folder / "board.png"
        write_image(path, wooden_board(512))
    own = [sys.executable, str(Path(__file__).resolve()), "--worker", "--photo", str(path)]
    cold, cached = (json.loads(run(own, folder / "fit")[1].splitlines()[-1]) for _ in range(2))
    command = [sys.executable, "-m", "jaxtex", "fit", "wood", str(path), "-o"]
    whole = [run([*command, str(folder / f"out{turn}")], folder / "command")[0] for turn in range(2)]

    def row(label: str, step: str) -> Row:
        times = cold[f"first {step}"], cached[f"first {step}"], cached[f"second {step}"]
        return label, *(seconds(each) for each in times)

    rows = [
        row("rings", "rings"),
        row("description", "description"),
        row("fit", "all"),
        ("jaxtex fit wood PHOTO -o DIR", *(seconds(each) for each in whole), "-"),
    ]
    height, width = read_image(path).pixels.shape[:2]
    return f"A photograph of {width} x {height}", ("seconds", "cold", "kernels from the cache", "warm"), rows


def time_batch(count: int) -> Result:
    """Planks fitted by as many threads as there are cores, against a loop of single fits, both warm.

    The library has no call for a batch of wood; threads over `fit_wood` are what its users would write.
    """
    from pictures import drawn_planks

    from jaxtex.fitting.wood import fit_wood

    planks = drawn_planks(count, 128)
    threads = os.cpu_count() or 1

    def loop(planks: Iterable[Any]) -> list[Any]:
        return [fit_wood(plank) for plank in planks]

    def pool(planks: Iterable[Any]) -> list[Any]:
        with ThreadPoolExecutor(threads) as workers:
            return list(workers.map(fit_wood, planks))

    # Which starts a plank needs decides what is compiled, so all of them are warmed up.
    loop(planks)
    ways = {f"{threads} threads over fit_wood": pool, "loop of single jitted fits": loop}
    rates = {name: rate(lambda way=way: way(planks), count) for name, way in ways.items()}
    single = rates["loop of single jitted fits"]
    rows: list[Row] = [(name, f"{each:.2f}", f"{each / single:.2f}") for name, each in rates.items()]
    return f"{count} planks of 128 x 128", ("way", "fits/s", "against the loop"), rows


def time_block(side: int) -> Result:
    """A block of voxels with turbulence, against the same geometry written in NumPy."""
    from numpy_wood import render_block_numpy

    from jaxtex.material.wood import render_block
    from jaxtex.models.wood import make_wood

    wood = make_wood(
        ring_spacing=14.0, center=(30.0, -20.0), tilt=0.2, rotation=0.5, turbulence_rms=2.0, turbulence_frequency=0.01
    )
    few = (4, 64, 64)
    ours = np.concatenate(list(render_block(wood, shape=few))).reshape(*few, 3)
    apart = float(np.abs(ours - np.array(list(render_block_numpy(wood, shape=few)))).max())
    assert apart < 1e-3, f"the two models differ by {apart}"
    # The whole block for ours; of NumPy's slices, which all take as long, enough to tell.
    slices = min(side, 16)
    million = side**2 / 1e6
    fast = max(rate(lambda: exhaust(render_block(wood, shape=(side,) * 3)), million * side) for _ in range(3))
    plain = rate(lambda: exhaust(render_block_numpy(wood, shape=(slices, side, side))), million * slices)
    rows: list[Row] = [
        ("jaxtex", f"{fast:.1f}", f"{fast / plain:.1f}"),
        (f"NumPy, {slices} slices", f"{plain:.2f}", "1.0"),
    ]
    return f"A block of {side} x {side} x {side} voxels", ("model", "Mvoxel/s", "against NumPy"), rows


def exhaust(parts: Iterable[Any]) -> None:
    for _ in parts:
        pass


if __name__ == "__main__":
    main()
