"""How near the arrangements of new particles come to those of their pictures.

    python fitting/particle_statistics.py FOLDER -o OUT
    python fitting/particle_statistics.py FOLDER -o OUT --only coins_sk.png --seeds 3

FOLDER holds pictures made of things. For each, and each class of 10 or more complete particles, OUT/statistics.md has
a row for seeding alone, for seeding relaxed, and for as many particles placed uniformly at random: means over seeds of
Wasserstein distances between the picture and 512 x 512 pixels, tileable (`compare_statistics`): of distances to the
nearest particle, as shares of the mean; of directions to it, modulo 180 degrees; of sizes, and of the shares of area
covered. The row "alike" says how far apart samples are, on average, of which one has as many values as the picture's
and the other is drawn from it, as large as the composition's: differences below cannot be told from chance. The last
table has lattices: by how many degrees directions to neighbours are off, by how many percent spacings are, and how many
neighbours are missing, for the worst of a lattice's vectors; of points thrown like darts, by how much their mean
distance is off. The rows "picture" say how far off the few points already are that all is learnt from.
"""

import argparse
import dataclasses
import os
from collections.abc import Iterator, Sequence
from pathlib import Path

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

import jax
import numpy as np
from scipy.spatial import cKDTree
from tables import make_table

import jaxtex as jt
from jaxtex.io.files import atomic_write_text, prepare_folder
from jaxtex.particles.statistics import ClassDistances, ClassStatistics, Sample

MARKED = (
    *("pebbles_coloured.jpg", "coffee_beans.jpg", "pebbles_sh3.jpg", "coins_sk.png", "field_cobbles.jpg"),
    *("reptile_skin.png", "cheese_holes.png", "terrazzo018.png", "terrazzo009.png", "gravel_gray_sk.png"),
)
SIDE = 512
FEWEST = 10  # complete particles of a class that statistics are made of
EXEMPLAR, LARGE = (220, 200), (1000, 1000)  # of lattices
LATTICES = {
    "square": [(24.7, 0.0), (0.0, 24.7)],
    "hexagonal": [(26.3, 0.0), (13.15, 22.78), (-13.15, 22.78)],
    "bricks": [(40.4, 0.0), (20.2, 17.6), (-20.2, 17.6)],
}
APART = 24.0  # pixels that points thrown like darts keep
DRAWN = ("distances", "directions", "sizes")  # of which samples are drawn
JITTERS = (0.0, 0.04, 0.08)  # standard deviations, of the least spacing


def arrange(found: jt.Decomposition, learnt, seed: int) -> Iterator[tuple[str, jt.Composition]]:
    """The three ways to place as many particles."""
    seeded = jt.seed_composition(found, learnt, (SIDE, SIDE), key=jax.random.key(seed), tileable=True)
    x, y = np.random.default_rng(seed).uniform(0, SIDE, (2, len(seeded)))
    yield "random", dataclasses.replace(seeded, x=x, y=y)
    yield "seeded", seeded
    yield "relaxed", jt.relax_composition(seeded, found)


def resample(picture: ClassStatistics, count: int, rng: np.random.Generator) -> ClassDistances:
    """What distances chance makes between the picture's own sample and one drawn from it."""

    def draw(sample: Sample) -> Sample:
        def pick(size: int) -> np.ndarray:
            return rng.choice(sample.values, size, p=sample.weights / sample.weights.sum())

        return Sample(pick(count), np.ones(count))

    return jt.compare_statistics(picture, picture._replace(**{name: draw(getattr(picture, name)) for name in DRAWN}))


def judge_picture(path: Path, seeds: int) -> list[list[str]]:
    """Rows of the table."""
    found = jt.find_particles(jt.read_image(path).pixels)
    learnt, pictures = jt.learn_arrangement(found), jt.measure_picture(found)
    complete = np.bincount([each.kind for each in found.particles if each.complete], minlength=found.kinds)
    rows = []
    results: dict[tuple[int, str], list[ClassDistances]] = {}
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        for way, made in arrange(found, learnt, seed):
            for kind, statistics in enumerate(jt.measure_composition(made, found)):
                results.setdefault((kind, way), []).append(jt.compare_statistics(pictures[kind], statistics))
        for kind in np.flatnonzero(complete >= FEWEST):
            count = int(np.sum(made.kinds == kind))
            results.setdefault((int(kind), "alike"), []).append(resample(pictures[kind], count, rng))
    for kind in np.flatnonzero(complete >= FEWEST):
        for way in ("random", "seeded", "relaxed", "alike"):
            distance, direction, size, area = np.mean(results[int(kind), way], axis=0)
            known = int((pictures[kind].distances.weights > 0).sum())
            shown = [f"{distance:.3f}", f"{direction:.1f}", f"{size:.3f}", f"{area:.3f}"]
            rows.append([path.name, f"{kind}", f"{complete[kind]}", f"{known}", way, *shown])
    return rows


def draw_discs(points: np.ndarray, width: float, height: float) -> jt.Decomposition:
    """The label image of ellipses."""
    row, column = np.indices(EXEMPLAR[::-1]) + 0.5
    labels = np.zeros(EXEMPLAR[::-1], int)
    for number, (x, y) in enumerate(points, 1):
        labels[np.hypot((column - x) / width, (row - y) / height) < 0.5] = number
    return jt.describe_particles(labels, np.zeros(len(np.unique(labels[labels > 0])), int))


def measure_lattice(points: np.ndarray, size: tuple[int, int], vectors: Sequence[tuple[float, float]]) -> list[str]:
    """Of the worst vector: degrees and percent that neighbours' mean is off; missing ones of all, percent."""
    tree, least = cKDTree(points), min(np.hypot(*vector) for vector in vectors)
    inner = points[((points > 45) & (points < np.array(size) - 45)).all(axis=1)]
    turned, stretched, missing = [], [], []
    for vector in vectors:
        distance, index = tree.query(inner + np.array(vector))
        near = distance < 0.3 * least
        way = (points[index] - inner)[near] @ np.array([1, 1j]) / complex(*vector)
        turned.append(abs(np.degrees(np.angle(way.mean()))))
        stretched.append(100 * abs(np.abs(way).mean() - 1))
        missing.append(100 * (1 - near.mean()))
    return [f"{max(turned):.2f}", f"{max(stretched):.2f}", f"{np.mean(missing):.1f}"]


def judge_lattices() -> list[list[str]]:
    rows = []
    for name, vectors in LATTICES.items():
        i, j = np.mgrid[-20:21, -20:21].reshape(2, -1, 1)
        exact = i * np.array(vectors[0]) + j * np.array(vectors[1]) + 7.3
        exact = exact[((exact > -60) & (exact < np.array(EXEMPLAR) + 60)).all(axis=1)]
        for jitter in JITTERS:
            noise = np.random.default_rng(0).normal(0, jitter * min(np.hypot(*each) for each in vectors), exact.shape)
            found = draw_discs(exact + noise, 0.65 * np.hypot(*vectors[0]), 0.65 * vectors[1][1])
            seeded = jt.seed_composition(found, jt.learn_arrangement(found), LARGE, key=jax.random.key(0))
            rows.append([name, f"{100 * jitter:.0f} %", "picture", *measure_lattice(exact + noise, EXEMPLAR, vectors)])
            for way, made in (("seeded", seeded), ("relaxed", jt.relax_composition(seeded, found))):
                measured = measure_lattice(np.stack([made.x, made.y], axis=1), LARGE, vectors)
                rows.append([name, f"{100 * jitter:.0f} %", way, *measured])
    return rows + judge_scattered()


def throw_darts(size: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
    """Points at random that keep a distance, [point, 2]."""
    points = np.empty((0, 2))
    for place in rng.uniform(0, size, (20 * size[0] * size[1] // int(APART**2), 2)):
        if not len(points) or np.hypot(*(points - place).T).min() >= APART:
            points = np.append(points, place[None], axis=0)
    return points


def judge_scattered() -> list[list[str]]:
    """How far the mean distance to the nearest is from that of very many points thrown likewise."""

    def spacing(points: np.ndarray, size: tuple[int, int]) -> float:
        inner = points[((points > 60) & (points < np.array(size) - 60)).all(axis=1)]
        return float(cKDTree(points).query(inner, 2)[0][:, 1].mean())

    truth = np.mean([spacing(throw_darts(LARGE, np.random.default_rng(seed)), LARGE) for seed in range(3)])
    darts = throw_darts(EXEMPLAR, np.random.default_rng(9))
    found = draw_discs(darts, 0.6 * APART, 0.6 * APART)
    seeded = jt.seed_composition(found, jt.learn_arrangement(found), LARGE, key=jax.random.key(0))
    made = {"seeded": seeded, "relaxed": jt.relax_composition(seeded, found)}
    means = {"picture": jt.measure_picture(found)[0].distances.mean}
    means |= {way: spacing(np.stack([each.x, each.y], axis=1), LARGE) for way, each in made.items()}
    off = {way: 100 * abs(mean / truth - 1) for way, mean in means.items()}
    return [["Poisson-disc", "-", way, "-", f"{value:.2f}", "-"] for way, value in off.items()]


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="pictures made of things")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT", help="folder for what is made")
    parser.add_argument("--seeds", type=int, default=20, help="of which means are taken")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="of these pictures alone")
    options = parser.parse_args(words)
    prepare_folder(options.output)
    rows = []
    for name in options.only or [name for name in MARKED if (options.folder / name).exists()]:
        new = judge_picture(options.folder / name, options.seeds)
        rows += new
        print(*new, sep="\n", flush=True)
    head = ["picture", "class", "complete", "inner", "placed", "distance", "direction, degrees", "size", "area"]
    lattices = ["lattice", "jitter", "placed", "turned, degrees", "spacing, %", "missing, %"]
    page = "\n".join([make_table(head, rows), "", make_table(lattices, judge_lattices()), ""])
    atomic_write_text(options.output / "statistics.md", page)
    print(page)


if __name__ == "__main__":
    main()
