"""The regions of a picture, small ones within larger ones, and the best of them.

P. Arbelaez, M. Maire, C. Fowlkes and J. Malik, "Contour detection and hierarchical image segmentation" (IEEE PAMI 33,
2011), section 4: patches are merged two by two, always those with the weakest edge between them, which gives a tree.
"""

import heapq
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage
from scipy.spatial import ConvexHull

Map = npt.NDArray[np.float32]
Labels = npt.NDArray[np.int32]
Values = npt.NDArray[np.float64]
Around = dict[int, tuple[float, float]]  # of regions that one touches: the sum of the edge between, and its length

_LARGEST = 0.15  # of the picture: what covers more is not taken for a thing


class Tree(NamedTuple):
    """Regions that contain each other; the first `patches` nodes from number 1 are patches, others join two earlier.

    Attributes:
        patches: how many patches there are; node 0 is none.
        parts: the two nodes that a node joins, [node, 2]; 0 of a patch.
        strongest: the strongest edge that was taken away within a region, [node].
        border: what its edges to others sum up to, and their length in pixels, [node, 2].
        sides: of patches that touch: their numbers [pair, 2], and how long their border is [pair].
    """

    patches: int
    parts: npt.NDArray[np.intp]
    strongest: Values
    border: Values
    sides: tuple[npt.NDArray[np.intp], Values]

    def sum_up(self, of_patches: Values) -> Values:
        """What patches have [patch, ...], from number 0, added up over each region, [node, ...]."""
        sums = np.zeros((len(self.parts), *of_patches.shape[1:]))
        sums[: self.patches + 1] = of_patches
        for node in range(self.patches + 1, len(self.parts)):
            sums[node] = sums[self.parts[node, 0]] + sums[self.parts[node, 1]]
        return sums


def merge_patches(patches: Labels, edges: Map, within: Labels | None = None) -> Tree:
    """Merge patches, numbered from 1, until one is left, or one in each of the labels that patches lie `within`."""
    count = int(patches.max())
    sides, strength, length = _find_sides(patches, edges)
    around: list[Around] = [{} for _ in range(count + 1)]
    border = np.zeros((2 * count, 2))
    for (one, other), strong, long in zip(sides.tolist(), strength.tolist(), length.tolist(), strict=True):
        around[one][other] = around[other][one] = (strong, long)
        border[[one, other]] += (strong, long)
    owner = np.zeros(2 * count, int)
    if within is not None:
        owner[patches.ravel()] = within.ravel()
    heap = [(s / n, a, b) for (a, b), s, n in zip(sides.tolist(), strength.tolist(), length.tolist(), strict=True)]
    heap = [each for each in heap if owner[each[1]] == owner[each[2]]]
    heapq.heapify(heap)
    parts, strongest, node = np.zeros((2 * count, 2), np.intp), np.zeros(2 * count), count
    merged = np.zeros(2 * count, bool)
    while heap:
        edge, one, other = heapq.heappop(heap)
        if merged[one] or merged[other]:
            continue
        node += 1
        parts[node], owner[node] = (one, other), owner[one]
        merged[one] = merged[other] = True
        strongest[node] = max(edge, strongest[one], strongest[other])
        border[node] = border[one] + border[other] - 2 * np.array(around[one][other])
        around.append(_join(around, one, other, node))
        for beyond, (strong, long) in around[node].items():
            if owner[beyond] == owner[node]:
                heapq.heappush(heap, (strong / long, beyond, node))
    node += 1
    return Tree(count, parts[:node], strongest[:node], border[:node], (sides, length))


def measure_regions(tree: Tree, patches: Labels, edges: Map) -> tuple[Values, Values]:
    """The area of each region, and what tells whether it is a thing, both [node, ...].

    Returns:
        Areas in pixels; and how much of its convex hull a region fills, how strong the edge around it is, the strongest
        edge that parts it and the mean one in it; not a number where it is too large for a thing.
    """
    areas = tree.sum_up(np.bincount(patches.ravel(), minlength=tree.patches + 1).astype(float))
    inside = tree.sum_up(np.bincount(patches.ravel(), edges.ravel(), tree.patches + 1).astype(float))
    hulls = _fill_hulls(tree, patches, areas)
    around = tree.border[:, 0] / np.maximum(tree.border[:, 1], 1)
    return areas, np.stack([areas / hulls, around, tree.strongest, inside / np.maximum(areas, 1)], axis=1)


def choose_regions(tree: Tree, gains: Values) -> npt.NDArray[np.intp]:
    """Those regions, none within another, whose gains [node] sum up to the most; exactly, from patches to the whole."""
    best = np.maximum(np.nan_to_num(gains, nan=0.0), 0.0)
    taken = best > 0
    for node in range(tree.patches + 1, len(tree.parts)):
        of_parts = best[tree.parts[node]].sum()
        if of_parts >= best[node]:
            best[node], taken[node] = of_parts, False
    covered = np.zeros(len(best), bool)
    for node in range(len(best) - 1, tree.patches, -1):
        covered[tree.parts[node]] = covered[node] | taken[node]
    return np.flatnonzero(taken & ~covered)


def draw_regions(tree: Tree, chosen: npt.NDArray[np.intp], patches: Labels) -> Labels:
    """Number the chosen regions from 1, in their order; 0 elsewhere."""
    numbers = np.zeros(len(tree.parts), np.int32)
    numbers[chosen] = np.arange(1, len(chosen) + 1)
    for node in range(len(tree.parts) - 1, tree.patches, -1):
        if numbers[node]:
            numbers[tree.parts[node]] = numbers[node]
    return numbers[patches]


def _find_sides(patches: Labels, edges: Map) -> tuple[npt.NDArray[np.intp], Values, Values]:
    """Which patches touch, [pair, 2], what their edges sum up to, and how long they are."""
    keys, strengths, base = [], [], int(patches.max()) + 1
    for one, other, near, far in (
        (patches[1:], patches[:-1], edges[1:], edges[:-1]),
        (patches[:, 1:], patches[:, :-1], edges[:, 1:], edges[:, :-1]),
    ):
        border = one != other
        low, high = np.minimum(one, other)[border], np.maximum(one, other)[border]
        keys.append(low.astype(np.int64) * base + high)
        strengths.append(np.maximum(near, far)[border])
    pairs, which = np.unique(np.concatenate(keys), return_inverse=True)
    strength = np.bincount(which, np.concatenate(strengths), len(pairs)).astype(float)
    sides = np.stack([pairs // base, pairs % base], axis=1).astype(np.intp)
    return sides, strength, np.bincount(which, minlength=len(pairs)).astype(float)


def _join(around: list[Around], one: int, other: int, node: int) -> Around:
    """What is around two regions that become one."""
    joined: Around = {}
    for part in (one, other):
        for beyond, (strong, long) in around[part].items():
            if beyond not in (one, other):
                already = joined.get(beyond, (0.0, 0.0))
                joined[beyond] = (already[0] + strong, already[1] + long)
                del around[beyond][part]
        around[part] = {}
    for beyond, both in joined.items():
        around[beyond][node] = both
    return joined


def _fill_hulls(tree: Tree, patches: Labels, areas: Values) -> Values:
    """The areas of convex hulls, not a number where a region is too large, [node]."""
    filled = np.full(len(tree.parts), np.nan)
    corners: dict[int, npt.NDArray[np.integer]] = {}
    places = ndimage.find_objects(patches)
    for node in range(1, len(tree.parts)):
        if areas[node] > _LARGEST * patches.size:
            continue
        if node <= tree.patches:
            points = _ends_of_rows(patches[places[node - 1]] == node, places[node - 1])
        else:
            points = np.concatenate([corners[part] for part in tree.parts[node]])
        hull = ConvexHull(points)
        corners[node], filled[node] = points[hull.vertices], hull.volume
    return filled


def _ends_of_rows(mask: npt.NDArray[np.bool_], place: tuple[slice, slice]) -> npt.NDArray[np.integer]:
    """The corners of the first and last pixels of each row, (x, y) [point, 2]: the hull needs no others."""
    row = np.flatnonzero(mask.any(axis=1))
    first, last = mask[row].argmax(axis=1), mask.shape[1] - mask[row, ::-1].argmax(axis=1)
    x = np.concatenate([first, last, first, last]) + place[1].start
    y = np.concatenate([row, row, row + 1, row + 1]) + place[0].start
    return np.stack([x, y], axis=1)
