"""How near the textures of each method of synthesis come to their exemplars, and how much of them is copied.

    python fitting/quality.py FOLDER -o OUT
    python fitting/quality.py FOLDER -o OUT --methods quilting coherence --exemplar 128 --seeds 3

Of every picture of a folder, a square at the left is the exemplar, and one at the right is held out. OUT/quality.csv
has a row for each exemplar, method and seed; OUT/quality.md the means over seeds, and which methods come nearest how
often. Distances are 0 where textures agree:

- patches: sliced Wasserstein of patches, relative to the exemplar's contrast (`sliced_wasserstein`),
- statistics: Portilla and Simoncelli's, relative to those between different textures (`portilla_simoncelli_distance`),
- held-out patches, held-out statistics: the same of what is held out.

Copying flatters the first two: a method that returned the exemplar would win. What is held out no method has seen; the
row "photograph" is the exemplar itself, judged so. Beside them stand the shares of 9 x 9 windows that are of the
exemplar, exactly (verbatim) or nearly (near: they differ by at most 3 of 255, root mean square), and the typical size
of copied pieces in pixels, where a method tells what it copies.
"""

import argparse
import csv
import io
import os
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

import jax
import numpy as np
from numpy.typing import NDArray
from tables import make_table

import jaxtex as jt
from jaxtex.cli.progress import progress
from jaxtex.core.colour import linear_to_srgb
from jaxtex.io.files import atomic_write_text
from jaxtex.synthesis.copying import measure_pieces, verbatim_share
from jaxtex.synthesis.distances import sliced_wasserstein
from jaxtex.synthesis.methods import METHODS
from jaxtex.synthesis.portilla_simoncelli import portilla_simoncelli_distance
from jaxtex.synthesis.sources import Sources

Floats = NDArray[np.floating]
Row = dict[str, str | float]

ENDINGS = {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".exr"}
DISTANCES = ["patches", "statistics", "held-out patches", "held-out statistics"]
PHOTOGRAPH = "photograph"
COPYING = ["verbatim", "near", "piece"]
NEAR = 3 / 255
WITHIN = 1.05  # of the least distance: what counts as nearest, too


def read_squares(path: Path, side: int) -> tuple[Floats, Floats]:
    """Squares of a picture's left and right, apart and at most so many pixels wide, sRGB-encoded."""
    pixels = linear_to_srgb(jt.read_image(path).pixels)
    side = min(side, pixels.shape[0], pixels.shape[1] // 2)
    middle = slice((pixels.shape[0] - side) // 2, (pixels.shape[0] + side) // 2)
    return pixels[middle, :side], pixels[middle, -side:]


def measure(exemplar: Floats, held_out: Floats, texture: Floats, sources: Sources | None) -> dict[str, float]:
    """All distances, and all that is copied; NaN where it is not known."""
    texture = np.clip(texture, 0, 1)
    distances = {
        prefix + name: distance
        for prefix, truth in (("", exemplar), ("held-out ", held_out))
        for name, distance in (
            ("patches", sliced_wasserstein(truth, texture, key=jax.random.key(0)).total),
            ("statistics", portilla_simoncelli_distance(truth, texture).total),
        )
    }
    return distances | {
        "verbatim": verbatim_share(exemplar, texture),
        "near": verbatim_share(exemplar, texture, tolerance=NEAR),
        "piece": float("nan") if sources is None else measure_pieces(sources).typical_size,
    }


def mean_over_seeds(rows: Sequence[Row]) -> dict[tuple[str, str], dict[str, float]]:
    """By exemplar and method."""
    grouped: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        grouped.setdefault((str(row["exemplar"]), str(row["method"])), []).append(row)
    return {
        pair: {name: float(np.mean([each[name] for each in group])) for name in DISTANCES + COPYING}
        for pair, group in grouped.items()
    }


def count_nearest(
    means: dict[tuple[str, str], dict[str, float]], name: str, *, copied: float = 1.0
) -> dict[str, float]:
    """For each method, the share of exemplars to which it is nearest, or within 5 % of the nearest, of those methods
    that copy no more than such a share of windows, nearly."""
    exemplars = sorted({exemplar for exemplar, _ in means})
    methods = [method for method in dict.fromkeys(method for _, method in means) if method != PHOTOGRAPH]
    wins = dict.fromkeys(methods, 0)
    for exemplar in exemplars:
        here = {method: means[exemplar, method] for method in methods}
        here = {method: values for method, values in here.items() if values["near"] <= copied}
        least = min((values[name] for values in here.values()), default=0.0)
        for method, values in here.items():
            wins[method] += values[name] <= WITHIN * least
    return {method: count / len(exemplars) for method, count in wins.items()}


def report(rows: Sequence[Row]) -> str:
    """Both tables in Markdown."""
    means = mean_over_seeds(rows)
    names = DISTANCES + COPYING
    lines = [[*pair, *(show(values[name]) for name in names)] for pair, values in means.items()]
    nearest = {f"nearest by {name}": count_nearest(means, name) for name in DISTANCES}
    nearest["nearest by patches, of those that copy half at most"] = count_nearest(means, "patches", copied=0.5)
    summary = []
    for method in dict.fromkeys(method for _, method in means):
        values = [each for (_, other), each in means.items() if other == method]
        medians = [show(float(np.median([each[name] for each in values]))) for name in names]
        wins = [f"{each[method]:.0%}" if method in each else "" for each in nearest.values()]
        summary.append([method, *medians, *wins])
    return "\n".join(
        [
            "Medians over exemplars, and how often a method is nearest or within 5 % of that:\n",
            make_table(["method", *names, *nearest], summary),
            "\nEach exemplar:\n",
            make_table(["exemplar", "method", *names], lines),
            "",
        ]
    )


def show(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.0f}" if value >= 10 else f"{value:.3f}"


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="pictures of textures")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT", help="folder for the tables")
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=list(METHODS), metavar="METHOD")
    parser.add_argument("--exemplar", type=int, default=192, help="pixels of an exemplar's side, at most (192)")
    parser.add_argument("--size", type=int, default=256, help="pixels of a texture's side (256)")
    parser.add_argument("--seeds", type=int, default=1, help="textures of each kind (1)")
    options = parser.parse_args(words)
    paths = sorted(path for path in options.folder.iterdir() if path.suffix.lower() in ENDINGS)
    if not paths:
        parser.error(f"{options.folder}: holds no pictures")
    options.output.mkdir(parents=True, exist_ok=True)
    rows: list[Row] = []
    for path in progress(paths, "synthesising and measuring"):
        exemplar, held_out = read_squares(path, options.exemplar)
        rows.append(
            {"exemplar": path.stem, "method": PHOTOGRAPH, "seed": 0} | measure(exemplar, held_out, exemplar, None)
        )
        for method in options.methods:
            for seed in range(options.seeds):
                made = METHODS[method](exemplar, (options.size, options.size), key=jax.random.key(seed))
                rows.append(
                    {"exemplar": path.stem, "method": method, "seed": seed} | measure(exemplar, held_out, *made)
                )
        # After every exemplar, as all of them take long.
        table = io.StringIO()
        writer = csv.DictWriter(table, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        atomic_write_text(options.output / "quality.csv", table.getvalue())
        atomic_write_text(options.output / "quality.md", report(rows))
    print(report(rows))


if __name__ == "__main__":
    main()
