"""Painted targets (Ashikhmin 2001, section 4): how near each pass comes to them, and what that costs the texture.

    python fitting/targets.py FOLDER -o OUT

Five exemplars of the folder, each with a target painted in its own colours: a disc, stripes, a
slope, a chequerboard, a ring; a part of each is left unpainted. OUT/targets.md has the table, and OUT/NAME.png shows
exemplar, target, the result without it, and those after the first and the last pass.
"""

import argparse
from itertools import pairwise
from pathlib import Path

import jax
import numpy as np
from scipy.ndimage import gaussian_filter
from tables import make_table

import jaxtex as jt
from jaxtex.core.colour import linear_to_srgb, srgb_to_linear

SIDE = 256
CROP = 192
PASSES = 5
AFAR = 4.0  # pixels: a target says what is seen when blurred so much


def paint_targets() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """How light targets are, 0 to 1, and where they are painted, both [row, col]."""
    y, x = (np.indices((SIDE, SIDE)) + 0.5) / SIDE
    radius = np.hypot(x - 0.5, y - 0.5)
    return {
        "disc": ((radius < 0.3).astype(float), radius < 0.4),
        "stripes": ((np.floor(4 * x) % 2), y > 0.3),
        "slope": (y, np.ones_like(y, bool)),
        "chequers": ((np.floor(3 * x) + np.floor(3 * y)) % 2, x < 0.7),
        "ring": ((np.abs(radius - 0.3) < 0.08).astype(float), np.ones_like(y, bool)),
    }


def colour_target(exemplar: np.ndarray, light: np.ndarray, painted: np.ndarray) -> np.ndarray:
    """A target in the colours of an exemplar as it looks from afar, from dark to light, in the exemplar's proportions.

    Other proportions could not be had without another texture.
    """
    blurred = gaussian_filter(exemplar, (AFAR, AFAR, 0)).reshape(-1, exemplar.shape[2])
    ordered = blurred[np.argsort(blurred.mean(axis=1), kind="stable")]
    levels, counts = np.unique(light[painted], return_counts=True)
    ends = np.rint(np.cumsum(counts) / counts.sum() * len(ordered)).astype(int)
    parts = np.split(ordered, ends[:-1])
    colours = np.stack([part.mean(axis=0) for part in parts])
    return colours[np.searchsorted(levels, light).clip(0, len(levels) - 1)].astype(np.float32)


def distance_to_target(texture: np.ndarray, target: np.ndarray, painted: np.ndarray) -> float:
    """Root mean square difference of both as seen from afar, where painted."""
    difference = gaussian_filter(texture, (AFAR, AFAR, 0)) - gaussian_filter(target, (AFAR, AFAR, 0))
    return float(np.sqrt(np.mean(np.square(difference[painted]))))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=3, help="results that figures are the means of (3)")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    names = ["pebbles_sh3", "clover_leaves", "maple_leaves", "gravel3", "pebbles_coloured"]
    passes = [f"pass {number + 1}" for number in range(PASSES)]
    header = ["exemplar", "target", "untargeted", *passes, "falls", "texture, untargeted", *passes, "change"]
    lines = []
    for name, (kind, (light, painted)) in zip(names, paint_targets().items(), strict=True):
        exemplar = read_exemplar(options.folder, name)
        target = colour_target(exemplar, light, painted)
        textures = [synthesise(exemplar, target, painted, seed) for seed in range(options.seeds)]
        near = np.mean([[distance_to_target(each, target, painted) for each in made] for made in textures], axis=0)
        texture = np.mean([[distance_to_exemplar(each, exemplar) for each in made] for made in textures], axis=0)
        falls = all(after < before for before, after in pairwise(near))
        line = [name, kind, *(f"{each:.4f}" for each in near), "yes" if falls else "no"]
        lines.append([*line, *(f"{each:.3f}" for each in texture), f"{100 * (texture[-1] / texture[0] - 1):+.0f} %"])
        print(*lines[-1], flush=True)
        shown = np.ones((SIDE, CROP, 3), np.float32)
        shown[:CROP] = exemplar
        seen = np.where(painted[..., None], target, 1)
        plain, first, *_, last = textures[0]
        sheet = np.concatenate([shown, seen, plain, first, last], axis=1)
        jt.write_image(options.output / f"{name}.png", srgb_to_linear(sheet))
    (options.output / "targets.md").write_text(make_table(header, lines) + "\n")


def read_exemplar(folder: Path, name: str) -> np.ndarray:
    return linear_to_srgb(jt.read_image(next(folder.glob(f"{name}.*"))).pixels[:CROP, :CROP])


def synthesise(exemplar: np.ndarray, target: np.ndarray, painted: np.ndarray, seed: int) -> list[np.ndarray]:
    """Textures without the target and with it, after each pass."""
    key, shape = jax.random.key(seed), (SIDE, SIDE)
    steps = jt.ashikhmin_steps(exemplar, shape, key=key, target=target, painted=painted, passes=PASSES)
    sources = [jt.synthesise_ashikhmin(exemplar, shape, key=key), *(step.sources for step in steps)]
    return [jt.copy_sources(exemplar, each) for each in sources]


def distance_to_exemplar(texture: np.ndarray, exemplar: np.ndarray) -> float:
    return float(jt.sliced_wasserstein(exemplar, texture, key=jax.random.key(1)).total)


if __name__ == "__main__":
    main()
