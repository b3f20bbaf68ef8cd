"""How fast tilings are fitted and rendered. Nothing here passes or fails; ratios within one run are what counts.

python benchmarks/tiling.py            # all of it, a few minutes; writes benchmarks/results/tiling-cpu.md
python benchmarks/tiling.py --help
"""

import argparse
import json
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from timing import Result, Row, rate, run, seconds, show, write_report


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photo", type=Path, help="a photograph in place of the generated brick wall of 1024 x 1024")
    parser.add_argument("--masks", type=int, default=256, help="masks in the batch (default 256)")
    parser.add_argument("--only", choices=["photo", "batch", "render"], help="only this part")
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        print(json.dumps(fit_photo(options.photo)))
        return
    with tempfile.TemporaryDirectory() as folder:
        parts = {
            "photo": lambda: time_photo(options.photo, Path(folder)),
            "batch": lambda: time_batch(options.masks),
            "render": lambda: time_render(4096),
        }
        results = [part() for name, part in parts.items() if options.only in (None, name)]
    show(results)
    if options.only is None:
        write_report("tiling", "Speed of tilings", results)


def fit_photo(path: Path | None) -> dict[str, float]:
    """Two fits in this process: seconds of the first, cold or with kernels from the cache, and of the second."""
    from jaxtex.fitting.tiling import fit_tiling
    from jaxtex.io.images import read_image

    assert path is not None
    pixels = read_image(path).pixels
    first, second = (fit_tiling(pixels).seconds for _ in range(2))
    return {f"{name} {key}": value[key] for name, value in (("first", first), ("second", second)) for key in value}


def time_photo(path: Path | None, folder: Path) -> Result:
    """A photograph, and the whole command: a new process with an empty cache of kernels, with a full one, and warm."""
    from pictures import brick_wall

    from jaxtex.io.images import write_image

    if path is None:
        path = folder / "wall.png"
        write_image(path, brick_wall(1024))
    own = [sys.executable, str(Path(__file__).resolve()), "--worker", "--photo", str(path)]
    cold, cached = (json.loads(run(own, folder / "fit")[1].splitlines()[-1]) for _ in range(2))
    command = [sys.executable, "-m", "jaxtex", "fit", "tiling", str(path), "-o"]
    whole = [run([*command, str(folder / f"out{turn}")], folder / "command")[0] for turn in range(2)]
    rows: list[Row] = [
        ("start", *(seconds(each) for each in (cold["first start"], cached["first start"], cached["second start"]))),
        (
            "refine",
            *(seconds(each) for each in (cold["first refine"], cached["first refine"], cached["second refine"])),
        ),
        ("fit", *(seconds(each) for each in (cold["first all"], cached["first all"], cached["second all"]))),
        ("jaxtex fit tiling PHOTO -o DIR", *(seconds(each) for each in whole), "-"),
    ]
    return "A photograph of 1024 x 1024", ("seconds", "cold", "kernels from the cache", "warm"), rows


def time_batch(count: int) -> Result:
    """A batch by one call, against a loop of single fits and against its solves batched by vmap, all warm."""
    from pictures import noisy_masks

    from jaxtex.fitting.batch import fit_tiling_masks, gathered_solves
    from jaxtex.fitting.tiling import fit_tiling

    masks = noisy_masks(count, 128)
    few = masks[: max(count // 8, 1)]

    def loop(masks: Any) -> None:
        for mask in masks:
            fit_tiling(mask, mask=mask, perspective=False)

    def vmapped(masks: Any) -> None:
        with gathered_solves():
            fit_tiling_masks(masks)

    ways: dict[str, tuple[Callable[[Any], Any], Any]] = {
        "one call, fit_tiling_masks": (fit_tiling_masks, masks),
        "loop of single jitted fits": (loop, masks),
        "one call, solves under vmap": (vmapped, few),
    }
    for way, _ in ways.values():
        way(few)
    rates = {name: rate(lambda way=way, these=these: way(these), len(these)) for name, (way, these) in ways.items()}
    single = rates["loop of single jitted fits"]
    rows: list[Row] = [(name, f"{each:.1f}", f"{each / single:.2f}") for name, each in rates.items()]
    return f"{count} masks of 128 x 128", ("way", "fits/s", "against the loop"), rows


def time_render(size: int) -> Result:
    """The soft mask of a large picture, against the same model written in NumPy."""
    import jax
    from numpy_tiling import coverage_numpy

    from jaxtex.models.grids import coverage_grid
    from jaxtex.models.tiling import make_tiling

    tiling = make_tiling(
        tile_width=170.0, tile_height=60.0, mortar_x=9.0, mortar_y=8.0, offset=0.5, angle=0.02, origin=(20.0, 9.0)
    )
    jax.block_until_ready(coverage_grid(tiling, size, size))
    apart = float(np.abs(np.asarray(coverage_grid(tiling, 512, 512)) - coverage_numpy(tiling, 512, 512, 0.5)).max())
    assert apart < 1e-2, f"the two models differ by {apart}"
    million = size * size / 1e6
    ours = max(rate(lambda: jax.block_until_ready(coverage_grid(tiling, size, size)), million) for _ in range(3))
    plain = rate(lambda: coverage_numpy(tiling, size, size, 0.5), million)
    rows: list[Row] = [
        ("jaxtex", f"{ours:.0f}", f"{ours / plain:.1f}"),
        ("NumPy", f"{plain:.1f}", "1.0"),
    ]
    return f"Soft mask of {size} x {size}", ("model", "Mpixel/s", "against NumPy"), rows


if __name__ == "__main__":
    main()
