"""Regions of a picture: the tree that they make, their measures, and the best ones of it."""

import itertools

import numpy as np
import pytest

from jaxtex.particles.edges import find_edges, part_at_edges
from jaxtex.particles.regions import Tree, choose_regions, draw_regions, measure_regions, merge_patches


def checker(side: int = 8, many: int = 4) -> np.ndarray:
    row, column = np.indices((side * many, side * many)) // side
    return (row * many + column + 1).astype(np.int32)


def members(tree: Tree, node: int) -> set[int]:
    if node <= tree.patches:
        return {node}
    return set().union(*(members(tree, part) for part in tree.parts[node]))


@pytest.fixture(scope="module")
def noisy() -> tuple[np.ndarray, np.ndarray, Tree]:
    patches = checker()
    edges = np.random.default_rng(0).random(patches.shape).astype(np.float32)
    return patches, edges, merge_patches(patches, edges)


def test_the_weakest_edges_go_first_and_all_is_one_in_the_end(noisy: tuple) -> None:
    _, _, tree = noisy
    assert len(tree.parts) == 2 * 16
    assert members(tree, 31) == set(range(1, 17))
    parents = tree.strongest[17:]
    assert (parents[:, None] >= tree.strongest[tree.parts[17:]]).all()


def test_regions_measure_what_their_pixels_do(noisy: tuple) -> None:
    patches, edges, tree = noisy
    areas, measures = measure_regions(tree, patches, edges)
    for node in range(1, len(tree.parts)):
        inside = np.isin(patches, list(members(tree, node)))
        assert areas[node] == inside.sum()
        assert measures[node, 3] == pytest.approx(edges[inside].mean(), rel=1e-5)
        border = [
            max(edges[here], edges[there]) for here, there in neighbours(patches.shape) if inside[here] != inside[there]
        ]
        assert tree.border[node] == pytest.approx([sum(border), len(border)], rel=1e-5)


def neighbours(shape: tuple[int, int]) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    rows, columns = shape
    across = [((y, x), (y, x + 1)) for y in range(rows) for x in range(columns - 1)]
    return across + [((y, x), (y + 1, x)) for y in range(rows - 1) for x in range(columns)]


def test_a_square_fills_its_hull_and_an_angle_three_quarters_of_less() -> None:
    patches = checker(8, 8)
    patches[np.isin(patches, [1, 2, 9])] = 1
    patches = np.unique(patches, return_inverse=True)[1].reshape(patches.shape).astype(np.int32) + 1
    edges = np.ones(patches.shape, np.float32)
    tree = merge_patches(patches, edges)
    _, measures = measure_regions(tree, patches, edges)
    assert measures[1, 0] == pytest.approx(3 / 3.5)
    assert measures[2:10, 0] == pytest.approx(1)
    assert np.isnan(measures[-1, 0])  # the whole picture is no thing


def test_what_is_chosen_is_the_best_of_all_choices() -> None:
    patches = checker(2, 3)
    rng = np.random.default_rng(1)
    for _ in range(20):
        tree = merge_patches(patches, rng.random(patches.shape).astype(np.float32))
        gains = rng.normal(size=len(tree.parts)).cumsum() * rng.choice([-1, 1])
        gains[0] = 0
        chosen = choose_regions(tree, gains)
        sets = [members(tree, node) if node else set() for node in range(len(tree.parts))]
        assert all(not sets[a] & sets[b] for a, b in itertools.combinations(chosen, 2))
        best = 0.0
        for keep in itertools.product([False, True], repeat=8):  # joined nodes, and then whatever patches are left
            nodes = [node for node, kept in zip(range(10, 18), keep, strict=True) if kept]
            if all(not sets[a] & sets[b] for a, b in itertools.combinations(nodes, 2)):
                left = set(range(1, 10)) - set().union(*(sets[node] for node in nodes))
                best = max(best, gains[nodes].sum() + sum(max(gains[each], 0) for each in left))
        assert gains[chosen].sum() == pytest.approx(best)
        drawn = draw_regions(tree, chosen, patches)
        for number, node in enumerate(chosen, 1):
            assert set(np.unique(patches[drawn == number])) == sets[node]


def test_patches_merge_only_within_labels() -> None:
    patches = checker(4, 4)
    within = (patches > 8).astype(np.int32)
    tree = merge_patches(patches, np.random.default_rng(2).random(patches.shape).astype(np.float32), within)
    roots = np.setdiff1d(np.arange(1, len(tree.parts)), tree.parts)
    assert sorted(map(frozenset, (members(tree, root) for root in roots)), key=min) == [
        frozenset(range(1, 9)),
        frozenset(range(9, 17)),
    ]


def test_edges_lie_on_the_step_whatever_its_height_and_way() -> None:
    row, column = np.indices((64, 64))
    for turn in (0, 0.4, 1.2):
        along = (column - 32) * np.cos(turn) + (row - 32) * np.sin(turn)
        for height in (20, 60):
            lab = np.zeros((64, 64, 3), np.float32)
            lab[..., 0] = 30 + height * (along > 0)
            edges = find_edges(lab)
            on, off = np.abs(along) < 1, np.abs(along) > 20
            assert edges[on].min() > 0.5
            assert edges[off].max() < 0.05


def test_texture_makes_weaker_edges_than_a_step_in_it() -> None:
    noise = np.random.default_rng(3).normal(size=(96, 96))
    lab = np.zeros((96, 96, 3), np.float32)
    lab[..., 0] = 40 + 8 * noise + 25 * (np.indices((96, 96))[1] >= 48)
    edges = find_edges(lab)
    assert edges[:, 47:49].mean() > 2 * edges[:, 60:].mean()


def test_patches_are_parted_by_a_dark_line_between_alike() -> None:
    lab = np.full((48, 96, 3), 50, np.float32)
    lab[:, 46:50, 0] = 25
    patches = part_at_edges(find_edges(lab))
    assert not set(np.unique(patches[:, :40])) & set(np.unique(patches[:, 56:]))
