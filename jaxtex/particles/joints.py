"""Things found by the joints between them, where no ground tells them apart: packed stones, heaps.

Edges cut a picture into patches, patches make a tree of regions (`particles.regions`), each region is rated by how
likely it is a thing (`particles.rating`), and those that do not overlap and have the best ratings are the things; what
is left is ground. This is done at several sizes of the picture: of things found at the one that gains the most, those
are replaced that gain more otherwise.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from skimage.segmentation import watershed
from skimage.transform import resize

from jaxtex.particles.edges import find_edges, part_at_edges
from jaxtex.particles.rating import compare_looks, rate_by_shape, rate_regions, spread_likelihood
from jaxtex.particles.regions import Tree, choose_regions, draw_regions, measure_regions, merge_patches

Map = npt.NDArray[np.float32]
Labels = npt.NDArray[np.int32]
Values = npt.NDArray[np.float64]

_LONGEST = 640  # pixels along the longer side of the largest size that is looked at
_SIZES = 3  # each half of the one before
_ENLARGED = 2.0  # times, at most: small things have few pixels
_PAR = 0.4  # of overlap with a thing: what is rated lower is rather ground; 0.35 takes bits of even grounds for things
_OVERLAP = 0.15  # of the smaller of two things: less is but a border drawn otherwise
_OVERGROWTH = 0.3  # of a thing that replaces others: how much of it was ground at most
_LEAST_AREA = 9  # pixels
_LEAST_SHARE = 1 / 16  # of the area that half of what is covered is in things above: a splinter of a thing has less


class Level(NamedTuple):
    """A picture at one size, in CIE Lab, [row, col, channel], and how strong edges are there, [row, col]."""

    lab: Map
    edges: Map


def make_levels(lab: Map) -> list[Level]:
    """The sizes at which things are looked for, the largest first."""
    longest = max(lab.shape[:2])
    scale = min(_ENLARGED, 2.0 ** np.floor(np.log2(_LONGEST / longest)))
    levels = []
    for _ in range(_SIZES):
        shape = tuple(max(1, round(side * scale)) for side in lab.shape[:2])
        if min(shape) < 16:
            break
        sized = lab if scale == 1 else resize(lab, shape, order=3 if scale > 1 else 1, anti_aliasing=scale < 1)
        levels.append(Level(sized.astype(np.float32), find_edges(sized)))
        scale /= 2
    return levels


def find_by_joints(lab: Map, levels: list[Level]) -> tuple[Labels, float]:
    """Number what is parted by joints, [row, col], in a picture in CIE Lab; 0 is ground.

    Returns:
        Labels, and what they gain: the mean over the picture's pixels of by how much things are rated above par.
    """
    found = []
    for level in levels:
        patches = part_at_edges(level.edges)
        if patches.max() < 2:
            continue
        tree = merge_patches(patches, level.edges)
        chosen, gained = _choose_things(level, patches, tree)
        found.append((_fit_to(draw_regions(tree, chosen, patches), lab), np.concatenate([[0.0], gained])))
    labels, gains = np.zeros(lab.shape[:2], np.int32), np.zeros(1)
    for others, more in sorted(found, key=lambda each: -each[1].sum()):
        labels, gains = _combine(labels, gains, others, more) if labels.any() else (others, more)
    return _drop_splinters(labels), float(gains.sum())


def rate_things(labels: Labels, levels: list[Level]) -> float:
    """What things gain that were found in some other way: the most at any size, as of `find_by_joints`."""
    most = 0.0
    for level in levels:
        sized = _resample(labels, level.edges.shape)
        patches = part_at_edges(level.edges)
        # Borders are rated where the edges next to them are: a patch goes to the label that it has most of.
        counts = np.zeros((int(patches.max()) + 1, int(sized.max()) + 1))
        np.add.at(counts, (patches, sized), 1)
        owners = counts.argmax(axis=1)
        if owners.max() == 0:
            continue
        tree = merge_patches(patches, level.edges, owners[patches])
        roots = np.setdiff1d(np.arange(1, len(tree.parts)), tree.parts)
        owner = np.concatenate([owners, np.zeros(len(tree.parts) - len(owners), np.intp)])
        for node in range(tree.patches + 1, len(tree.parts)):
            owner[node] = owner[tree.parts[node, 0]]
        things = roots[owner[roots] > 0]
        most = max(most, _gain(level, patches, tree, things)[things].sum() / patches.size)
    return float(most)


def _choose_things(level: Level, patches: Labels, tree: Tree) -> tuple[npt.NDArray[np.intp], Values]:
    """The regions that are things, and what each gains, in parts of the picture."""
    areas, measures = measure_regions(tree, patches, level.edges)
    first = choose_regions(tree, areas * (rate_by_shape(measures) - _PAR))
    gains = _gain(level, patches, tree, first)
    chosen = choose_regions(tree, gains)
    return chosen, gains[chosen] / patches.size


def _gain(level: Level, patches: Labels, tree: Tree, likely: npt.NDArray[np.intp]) -> Values:
    """What each region would gain as a thing, [node], where some are likely things already."""
    areas, measures = measure_regions(tree, patches, level.edges)
    looks = compare_looks(level.lab, patches, tree, spread_likelihood(tree, measures, likely))
    return areas * (rate_regions(measures, looks) - _PAR)


def _resample(labels: Labels, shape: tuple[int, ...]) -> Labels:
    rows, columns = ((np.arange(new) + 0.5) * old / new for new, old in zip(shape, labels.shape, strict=True))
    return labels[rows.astype(int)[:, None], columns.astype(int)[None]]


def _fit_to(labels: Labels, lab: Map) -> Labels:
    """Labels found at another size, at the picture's own: borders move to the edges near them."""
    whole = _fill_holes(_resample(labels, lab.shape[:2]))
    reach = lab.shape[0] / labels.shape[0]
    if reach > 1:
        near = ndimage.maximum_filter(whole, int(2 * reach) + 1) != ndimage.minimum_filter(whole, int(2 * reach) + 1)
        cores = np.where(near, 0, whole + 1)
        kept = np.bincount(cores.ravel(), minlength=whole.max() + 2) > 0
        cores = np.where(kept[whole + 1], cores, whole + 1)  # thin things are left as they are
        steps = [ndimage.gaussian_gradient_magnitude(lab[..., i], 1.0) for i in range(3)]
        whole = watershed(np.linalg.norm(steps, axis=0), cores) - 1
    return whole.astype(np.int32)


def _combine(labels: Labels, gains: Values, others: Labels, more: Values) -> tuple[Labels, Values]:
    """Things, some replaced by others that gain more.

    Things of either set that overlap, and what these overlap in turn, are one case, which one of the sets wins. What is
    ground to the first set stays ground.

    Args:
        labels, others: [row, col], of the same shape.
        gains, more: what each of their things gains, by number, [thing], from number 0, which is none.
    """
    common = np.zeros((len(gains), len(more)))
    np.add.at(common, (labels, others), 1)
    least = np.minimum(common.sum(axis=1)[:, None], common.sum(axis=0))
    fit = common[0] <= _OVERGROWTH * common.sum(axis=0)
    one, other = np.nonzero((common[1:, 1:] > _OVERLAP * least[1:, 1:]) & fit[1:])
    nodes = len(gains) + len(more)
    links = coo_matrix((np.ones(len(one)), (one + 1, other + 1 + len(gains))), shape=(nodes, nodes))
    count, case = connected_components(links, directed=False)
    own, theirs = case[: len(gains)], case[len(gains) :]
    wins = np.bincount(own, gains, count) >= np.bincount(theirs, more, count)
    stay, come = wins[own], ~wins[theirs] & np.isin(theirs, own)
    stay[0] = come[0] = False
    numbers = np.cumsum(np.concatenate([stay, come])) * np.concatenate([stay, come])
    kept, new = numbers[: len(gains)][labels], numbers[len(gains) :][others]
    return np.where(kept > 0, kept, new).astype(np.int32), np.concatenate([[0.0], gains[stay], more[come]])


def _drop_splinters(labels: Labels) -> Labels:
    areas = np.bincount(labels.ravel())
    areas[0] = 0
    order = np.sort(areas)
    usual = order[np.searchsorted(np.cumsum(order), areas.sum() / 2)]
    kept = areas >= max(_LEAST_AREA, _LEAST_SHARE * usual)
    return (np.cumsum(kept) * kept)[labels].astype(np.int32)


def _fill_holes(labels: Labels) -> Labels:
    """Ground that is surrounded by one thing alone is part of it."""
    holes, count = ndimage.label(labels == 0)
    padded = np.pad(labels, 1, constant_values=-1)
    highest = ndimage.maximum_filter(padded, footprint=ndimage.generate_binary_structure(2, 1))[1:-1, 1:-1]
    nothing = np.iinfo(np.int32).max
    lowest = ndimage.minimum_filter(np.where(padded == 0, nothing, padded), 3)[1:-1, 1:-1]
    numbers = np.arange(1, count + 1)
    high, low = ndimage.maximum(highest, holes, numbers), ndimage.minimum(lowest, holes, numbers)
    owners = np.concatenate([[0], np.where(high == low, high, 0)]).astype(np.int32)
    return np.where(labels == 0, owners[holes], labels)
