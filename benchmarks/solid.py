"""How fast solid textures are relaxed and read. Nothing here passes or fails; ratios within one run are what counts.

python benchmarks/solid.py                # a minute or two; writes benchmarks/results/solid-cpu.md
"""

import argparse
import resource
import subprocess
import sys
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import numpy_solid
from heeger_bergen import granite
from timing import Result, Row, clock, clock_in_turn, show, write_report

from jaxtex.material.solid import evaluate_solid
from jaxtex.models.solid import make_solid
from jaxtex.synthesis.solid_optimisation import optimise_solid
from jaxtex.synthesis.solid_relaxation import process_axis, relax_solid
from jaxtex.synthesis.solid_views import AXES, align_views, analyse_views

KEY = jax.random.key(0)
METHODS = {"relaxation": relax_solid, "optimisation": optimise_solid}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--worker", type=int, metavar="SIDE", help=argparse.SUPPRESS)
    parser.add_argument("--method", choices=METHODS, default="relaxation", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        view = granite(5 * options.worker // 4)
        METHODS[options.method](dict.fromkeys(AXES, view), options.worker, key=KEY, iterations=2)
        print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
        return
    weight = weigh_blocks()  # first: a process begins with what the one that starts it holds
    results = [time_iteration(), time_methods(), weight, time_points()]
    show(results)
    write_report("solid", "Speed of solid textures", results)


@jax.jit
def transform(voxels: jax.Array) -> jax.Array:
    """There and back: all slices across all axes, what an iteration cannot do without."""
    for axis in range(3):
        slices = jnp.moveaxis(voxels, axis + 1, 1)
        voxels = jnp.moveaxis(jnp.fft.irfft2(jnp.fft.rfft2(slices), slices.shape[2:]), 1, axis + 1)
    return voxels


def time_iteration() -> Result:
    rows: list[Row] = []
    for side in (64, 128):
        views = align_views(dict.fromkeys(AXES, granite(2 * side)), side)
        learnt = analyse_views(views.pictures, side, key=KEY)
        noise = jax.random.normal(KEY, (3, side, side, side))
        plain = np.asarray(noise)

        def ours(noise: jax.Array = noise, learnt: Any = learnt) -> jax.Array:
            for name, statistics in learnt.items():
                noise = process_axis(noise, statistics, AXES[name])
            return jax.block_until_ready(noise)

        def theirs(block: np.ndarray = plain, learnt: Any = learnt) -> np.ndarray:
            for name, statistics in learnt.items():
                block = numpy_solid.process_axis(block, statistics, AXES[name])
            return block

        apart = float(np.abs(np.asarray(ours()) - theirs()).mean() / theirs().std())
        assert apart < 0.02, f"the two blocks differ by {apart}"
        took, bare, numpy = clock_in_turn(
            ours, lambda noise=noise: jax.block_until_ready(transform(noise)), theirs, turns=5
        )
        rows.append((f"{side}³", f"{took:.3f}", f"{took / bare:.1f}", f"{numpy / took:.1f}"))
    head = ("block, RGB", "jaxtex, s", "against the bare transforms", "NumPy against jaxtex")
    return "One iteration, three axes, warm", head, rows


def time_methods() -> Result:
    rows: list[Row] = []
    for side in (64, 128):
        views = dict.fromkeys(AXES, granite(2 * side))
        relaxed, optimised = clock_in_turn(
            lambda views=views, side=side: relax_solid(views, side, key=KEY),
            lambda views=views, side=side: optimise_solid(views, side, key=KEY),
            turns=2,
        )
        rows.append((f"{side}³", f"{relaxed:.1f}", f"{optimised:.1f}", f"{optimised / relaxed:.1f}"))
    head = ("block, RGB", "relaxation, s", "optimisation, s", "ratio")
    return "Whole blocks, analysis included, warm", head, rows


def weigh_blocks() -> Result:
    rows: list[Row] = []
    for method in METHODS:
        for side in (128, 256):
            command = [sys.executable, str(Path(__file__).resolve()), "--worker", str(side), "--method", method]
            said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
            rows.append((f"{side}³", method, f"{int(said.split()[-1]) / 2**20:.2f}"))
    return "Peak memory of a process, two iterations", ("block, RGB", "method", "GiB"), rows


def time_points() -> Result:
    points = np.random.default_rng(0).uniform(-500, 500, (1_000_000, 3)).astype(np.float32)
    rows: list[Row] = []
    for name, seed in (("as it is", None), ("at random offsets", 0)):
        solid = make_solid(np.random.default_rng(1).random((128, 128, 128, 3), np.float32), offsets_seed=seed)
        took = clock(lambda solid=solid: evaluate_solid(solid, points))
        rows.append((name, f"{1 / took:.1f}"))
    return "Colours of a million points of 128³, warm", ("repeated", "Mpoint/s"), rows


if __name__ == "__main__":
    main()
