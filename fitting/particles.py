"""Texture particles: what is found in pictures made of things, and new arrangements of it.

    python fitting/particles.py FOLDER -o OUT

FOLDER holds pictures: those that `particle_statistics.py` names as made of things, or else any. OUT/particles.png has
a row for each, and for scikit-image's coins and gravel and a checkerboard (figure 13): the picture, its things
outlined, 512 x 512 pixels of a new arrangement, tileable, the same relaxed, and lapped textures for comparison.
OUT/particles.md says how many things were found, of how many classes with how many
lists of neighbours, and beside those of pictures that were counted by hand (fitting/particle_counts.csv, upper left
part of each), how many there are.
"""

import argparse
import csv
import os
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

import jax
import numpy as np
from particle_statistics import MARKED
from skimage import data
from skimage.segmentation import find_boundaries
from tables import make_table

import jaxtex as jt
from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
from jaxtex.io.files import atomic_write_text, prepare_folder

COUNTS = Path(__file__).with_name("particle_counts.csv")
KEY = jax.random.key(0)
SIDE = 512


def count_things(folder: Path) -> list[list[str]]:
    """Found, and counted by hand."""
    lines = []
    for row in csv.DictReader(COUNTS.read_text().splitlines()):
        if (folder / row["picture"]).exists():
            pixels = jt.read_image(folder / row["picture"]).pixels[: int(row["rows"]), : int(row["columns"])]
            found, there = len(jt.find_particles(pixels).particles), int(row["things"])
            lines.append([row["picture"], str(there), str(found), f"{100 * (found - there) / there:+.0f} %"])
    return lines


def outline(picture: np.ndarray, found: jt.Decomposition) -> np.ndarray:
    """The ground darkened, edges of complete things green, of others red."""
    drawn = picture * np.where(found.labels > 0, 1, 0.35)[..., None]
    complete = np.array([False, *(each.complete for each in found.particles)])[found.labels]
    edges = find_boundaries(found.labels, mode="inner")
    drawn[edges & complete], drawn[edges & ~complete] = (0, 1, 0), (1, 0, 0)
    return drawn


def fit_in(picture: np.ndarray) -> np.ndarray:
    cell = np.ones((SIDE, SIDE, 3), np.float32)
    rows, columns = (min(SIDE, each) for each in picture.shape[:2])
    cell[:rows, :columns] = picture[:rows, :columns]
    return cell


def draw_checkerboard() -> np.ndarray:
    """Figure 13: black and white squares of 32 pixels that touch at their corners, linear."""
    row, column = np.indices((224, 288)) // 32
    return np.where((row + column) % 2 > 0, 0.7, 0.03)[..., None] * np.ones(3)


def list_pictures(folder: Path, only: Sequence[str] | None) -> dict[str, np.ndarray]:
    """Linear pictures by their names: those of the folder, two that scikit-image brings, and a checkerboard."""
    there = sorted(path.name for path in folder.iterdir() if path.suffix in (".png", ".jpg"))
    names = only or [name for name in there if name in MARKED] or there
    pictures = {name: jt.read_image(folder / name).pixels for name in names}
    if only is None:
        brought = {"coins": data.coins(), "gravel": data.gravel()}
        pictures |= {
            f"scikit-image's {name}": srgb_to_linear(each[..., None] / 255.0) for name, each in brought.items()
        }
        pictures["checkerboard"] = draw_checkerboard()
    return pictures


def arrange_anew(pixels: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """A row of the sheet, encoded, and what was found."""
    picture = np.broadcast_to(linear_to_srgb(pixels), (*pixels.shape[:2], 3)).astype(np.float32)
    found = jt.find_particles(pixels)
    learnt = jt.learn_arrangement(found)
    composed = jt.seed_composition(found, learnt, (SIDE, SIDE), key=KEY, tileable=True)
    ground = jt.make_ground(picture, found, (SIDE, SIDE), key=KEY)
    seeded = jt.paint_composition(composed, picture, found, ground)
    relaxed = jt.paint_composition(jt.relax_composition(composed, found), picture, found, ground)
    lapped = jt.lap_patches(picture, (SIDE, SIDE), key=KEY)
    cells = (picture, outline(picture, found), seeded, relaxed, lapped)
    complete = sum(each.complete for each in found.particles)
    lists = [str(len(rule.lists)) if hasattr(rule, "lists") else "-" for rule in learnt.classes]
    area = np.mean(found.labels > 0)
    density = len(composed) / SIDE**2 / (len(found.particles) / found.labels.size)
    said = [str(complete), str(len(found.particles) - complete), str(found.kinds), ", ".join(lists)]
    return np.concatenate([fit_in(each) for each in cells], axis=1), [*said, f"{100 * area:.0f} %", f"{density:.2f}"]


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="pictures made of things")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT", help="folder for what is made")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="of these pictures alone")
    options = parser.parse_args(words)
    prepare_folder(options.output)
    rows, lines = [], []
    for name, pixels in list_pictures(options.folder, options.only).items():
        row, said = arrange_anew(pixels)
        rows.append(row)
        lines.append([name, *said])
        print(*lines[-1], flush=True)
    jt.write_image(options.output / "particles.png", srgb_to_linear(np.concatenate(rows)))
    head = ["picture", "complete", "incomplete", "classes", "lists", "area", "density of the new, times"]
    page = [
        make_table(head, lines),
        "\nCounted by hand:\n",
        make_table(["picture", "there are", "found", "off"], count_things(options.folder)),
        "",
    ]
    atomic_write_text(options.output / "particles.md", "\n".join(page))
    print("\n".join(page))


if __name__ == "__main__":
    main()
