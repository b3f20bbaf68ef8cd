"""Whether tileable textures show where they wrap: the step across the border among the steps within.

    python fitting/wrap_lines.py FOLDER

The exemplars are the upper left corners of a folder's pictures. Of each texture and axis, the energy of the step across
the border (mean squared difference of the rows or columns on both sides) is ranked among those of all steps within. An
invisible seam has any rank: the median is then about 50 %, and 5 % are above the 95th percentile.
"""

import argparse
import os
from pathlib import Path

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

import jax
import numpy as np
from tables import make_table

import jaxtex as jt
from jaxtex.cli.progress import progress
from jaxtex.core.colour import linear_to_srgb
from jaxtex.synthesis.sources import Sources

CROP, SIDE = 192, 160
METHODS = ("coherence", "ashikhmin", "quilting")


def synthesise(method: str, exemplar: np.ndarray, seed: int) -> Sources:
    key, shape = jax.random.key(seed), (SIDE, SIDE)
    if method == "coherence":  # always repeats
        return jt.synthesise_coherence(exemplar, shape, key=key)
    tileable = jt.synthesise_ashikhmin if method == "ashikhmin" else jt.synthesise_quilting
    return np.asarray(tileable(exemplar, shape, key=key, tileable=True))


def measure_wrap(texture: np.ndarray, axis: int) -> tuple[float, float]:
    """The share of steps within that have less energy than the one across the border, and the latter's energy as a
    share of the largest within."""
    energy = np.square(texture - np.roll(texture, -1, axis)).sum(axis=2).mean(axis=1 - axis)
    return float((energy[:-1] < energy[-1]).mean()), float(energy[-1] / energy[:-1].max())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="pictures of textures")
    parser.add_argument("--seeds", type=int, default=3, help="textures of each exemplar (3)")
    options = parser.parse_args()
    found: dict[str, list[tuple[float, float]]] = {method: [] for method in METHODS}
    for path in progress(sorted(options.folder.iterdir()), "synthesising"):
        exemplar = linear_to_srgb(jt.read_image(path).pixels[:CROP, :CROP])
        for method, measured in found.items():
            for seed in range(options.seeds):
                texture = jt.copy_sources(exemplar, synthesise(method, exemplar, seed))
                measured += [measure_wrap(texture, axis) for axis in (0, 1)]
    lines = []
    for method, measured in found.items():
        ranks, shares = np.array(measured).T
        lines.append([method, f"{np.median(ranks):.0%}", f"{(ranks > 0.95).mean():.0%}", f"{shares.max():.2f}"])
    print(make_table(["method", "median rank", "above the 95th percentile", "largest, of the largest within"], lines))


if __name__ == "__main__":
    main()
