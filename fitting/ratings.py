"""What particles.rating knows, learnt from pictures that are drawn, and how well things are found in others.

    python fitting/ratings.py

prints the weights, and then a table for pictures that had no part in them (--test alone: with the weights there are).
"""

import argparse
from collections.abc import Sequence

import numpy as np
from stones import draw_scenes
from tables import make_table

import jaxtex as jt
import jaxtex.particles.rating
from jaxtex.particles.edges import part_at_edges
from jaxtex.particles.joints import Level, make_levels
from jaxtex.particles.rating import compare_looks, fit_logistic, multiply_out, spread_likelihood
from jaxtex.particles.regions import Tree, choose_regions, measure_regions, merge_patches
from jaxtex.photo.pictures import to_lab

SCENES = 8  # of each sort to learn from; the seeds of those to test are others
PAR = 0.4
PENALTY = 1e-5


def find_overlaps(tree: Tree, patches: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """The best overlap of each region with a thing, intersection over union."""
    both = np.zeros((tree.patches + 1, labels.max() + 1))
    np.add.at(both, (patches, labels), 1)
    common = tree.sum_up(both)
    union = common.sum(axis=1, keepdims=True) + both.sum(axis=0) - common
    return (common / np.maximum(union, 1))[:, 1:].max(axis=1)


def measure_level(level: Level, labels: np.ndarray) -> tuple:
    row, column = (np.arange(n) * m // n for n, m in zip(level.edges.shape, labels.shape, strict=True))
    patches = part_at_edges(level.edges)
    tree = merge_patches(patches, level.edges)
    areas, measures = measure_regions(tree, patches, level.edges)
    overlaps = find_overlaps(tree, patches, labels[row[:, None], column])
    return level, patches, tree, areas, measures, overlaps


def learn_first(cases: list[tuple]) -> np.ndarray:
    values, overlaps, areas = gather([(m[:, :2], o, a / lvl.edges.size) for lvl, _, _, a, m, o in cases])
    return fit_logistic(np.concatenate([np.ones((len(values), 1)), values], axis=1), overlaps, areas, PENALTY, 30)


def learn_second(cases: list[tuple]) -> np.ndarray:
    rows = []
    for level, patches, tree, areas, measures, overlaps in cases:
        likely = choose_regions(tree, areas * (jt.particles.rating.rate_by_shape(measures) - PAR))
        looks = compare_looks(level.lab, patches, tree, spread_likelihood(tree, measures, likely))
        rows.append((np.concatenate([measures, looks], axis=1), overlaps, areas / level.edges.size))
    values, overlaps, areas = gather(rows)
    products = multiply_out(values)
    weights = fit_logistic(products, overlaps, areas, PENALTY, 40)
    told = 1 / (1 + np.exp(-products @ weights))
    mean = np.average(overlaps, weights=areas)
    left = np.average(np.square(overlaps - told), weights=areas) / np.average(np.square(overlaps - mean), weights=areas)
    print(f"explained: {1 - left:.3f} of the variance of overlaps")
    return weights


def gather(rows: list[tuple]) -> tuple[np.ndarray, ...]:
    """All regions that can be things, one after the other."""
    fit = [np.isfinite(row[0]).all(axis=1) & (np.arange(len(row[0])) > 0) for row in rows]
    return tuple(np.concatenate([row[i][good] for row, good in zip(rows, fit, strict=True)]) for i in range(3))


def compare(found: np.ndarray, labels: np.ndarray) -> list[str]:
    """Things, found, the median overlap of things, the share of things found, and of what is found that is a thing."""
    both = np.zeros((labels.max() + 1, found.max() + 1))
    np.add.at(both, (labels, found), 1)
    union = both.sum(axis=1, keepdims=True) + both.sum(axis=0) - both
    there = both.sum(axis=1)[1:] > 0
    best = (both / np.maximum(union, 1))[1:, 1:][there].max(axis=1)
    hits = (best > 0.5).sum()
    return [
        f"{there.sum()}",
        f"{found.max()}",
        f"{np.median(best):.2f}",
        f"{hits / len(best):.2f}",
        f"{hits / found.max():.2f}",
    ]


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--test", action="store_true", help="learn nothing")
    options = parser.parse_args(words)
    if not options.test:
        scenes = [scene for _, scene in draw_scenes(0, SCENES)]
        cases = [measure_level(lvl, labels) for pixels, labels in scenes for lvl in make_levels(to_lab(pixels))]
        first = learn_first(cases)
        print("first", np.round(first, 2).tolist())
        jt.particles.rating._FIRST_WEIGHTS = tuple(first)
        second = learn_second(cases)
        print("weights", np.round(second, 2).tolist())
        jt.particles.rating._WEIGHTS = tuple(second)
    lines = [[name, *compare(jt.find_particles(p).labels, labels)] for name, (p, labels) in draw_scenes(1, 3)]
    print(make_table(["picture", "there are", "found", "median overlap", "of these found", "of found right"], lines))


if __name__ == "__main__":
    main()
