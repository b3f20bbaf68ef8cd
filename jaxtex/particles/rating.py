"""How likely a region is a thing: the overlap with one that is to be expected of it.

A region is told by six measures from 0 to about 1: how much of its convex hull it fills, how strong the edge around it
is, the strongest edge that parts it and the mean one in it, how much it looks like what was taken for things rather
than ground, and how much more so than what is around it. The logarithm of the odds is a quadratic form of them, whose
weights were learnt from pictures of stones in mortar, heaps, and spots that a script draws and so knows the truth of
(fitting/ratings.py): no photograph had a part in them.
"""

import numpy as np
import numpy.typing as npt
from scipy import ndimage
from scipy.special import expit

from jaxtex.particles.regions import Tree

Map = npt.NDArray[np.float32]
Labels = npt.NDArray[np.int32]
Values = npt.NDArray[np.float64]

# Of 1, and a region's hull and edge; for where nothing is known yet of how things look.
_FIRST_WEIGHTS = -10.99, 5.57, 11.02
# Of products of 1 and the six measures, the upper triangle row by row.
_WEIGHTS = (
    *(-5.57, -4.51, 4.7, 3.87, 4.3, 7.59, 7.1),
    *(2.58, 7.14, 3.67, -1.21, -2.95, 4.79),
    *(-2.02, -4.58, 1.7, 2.58, 1.82),
    *(-10.35, -3.16, 5.58, -4.45),
    *(-1.15, -7.07, -7.64),
    *(-6.1, -5.31),
    *(-2.05,),
)
_LOOKS_PENALTY = 0.02  # on squared weights of what is learnt of looks, in standard deviations
_ROUNDS = 15  # of Newton's method; it has settled after ten


def rate_by_shape(measures: Values) -> Values:
    """The overlap with a thing (intersection over union) to be expected of regions [..., measure], 0 if unknown."""
    constant, hull, edge = _FIRST_WEIGHTS
    return np.nan_to_num(expit(constant + hull * measures[..., 0] + edge * measures[..., 1]))


def spread_likelihood(tree: Tree, measures: Values, likely: npt.NDArray[np.intp]) -> Values:
    """How likely each patch is part of a thing, by the shape of the likely one it lies in, [patch], from number 0."""
    likelihood = np.zeros(len(tree.parts))
    likelihood[likely] = rate_by_shape(measures)[likely]
    for node in range(len(tree.parts) - 1, tree.patches, -1):
        if likelihood[node]:
            likelihood[tree.parts[node]] = likelihood[node]
    return likelihood[: tree.patches + 1]


def rate_regions(measures: Values, looks: Values) -> Values:
    """The overlap with a thing to be expected of regions, by their measures and looks; 0 if unknown."""
    return np.nan_to_num(expit(multiply_out(np.concatenate([measures, looks], axis=-1)) @ np.array(_WEIGHTS)))


def multiply_out(values: Values) -> Values:
    """All products of two of 1 and the values [..., value], the upper triangle row by row, [..., product]."""
    extended = np.concatenate([np.ones_like(values[..., :1]), values], axis=-1)
    one, other = np.triu_indices(extended.shape[-1])
    return extended[..., one] * extended[..., other]


def compare_looks(lab: Map, patches: Labels, tree: Tree, thing: Values) -> Values:
    """How much regions look like things.

    Colours and roughness of patches are what things are told from ground by, learnt by logistic regression from this
    very picture: from what is likely a thing already, and from all that is not.

    Args:
        lab: picture in CIE Lab, [row, col, channel].
        patches: labels [row, col] of the tree's patches, from 1.
        thing: how likely each patch belongs to a thing, by what is known so far, from 0 to 1, [patch], from number 0.

    Returns:
        The likelihood to be part of a thing, by looks, and how much it is above that across the border, [node, 2].
    """
    areas = np.bincount(patches.ravel(), minlength=tree.patches + 1).astype(float)
    channels = _describe_looks(lab)
    means = [np.bincount(patches.ravel(), each.ravel(), len(areas))[1:] / areas[1:] for each in channels]
    values = np.stack(means, axis=1)
    mean = np.average(values, axis=0, weights=areas[1:])
    spread = np.sqrt(np.average(np.square(values - mean), axis=0, weights=areas[1:])) + 1e-6
    products = multiply_out((values - mean) / spread)
    weights = fit_logistic(products, thing[1:], areas[1:], _LOOKS_PENALTY, _ROUNDS)
    alike = np.concatenate([[0.0], expit(products @ weights)])
    above = np.zeros(len(areas))
    (one, other), long = tree.sides[0].T, tree.sides[1]
    np.add.at(above, one, long * (alike[one] - alike[other]))
    np.add.at(above, other, long * (alike[other] - alike[one]))
    whole = np.maximum(tree.sum_up(areas), 1)
    return np.stack([tree.sum_up(alike * areas) / whole, tree.sum_up(above) / np.maximum(tree.border[:, 1], 1)], axis=1)


def fit_logistic(products: Values, shares: Values, counts: Values, penalty: float, rounds: int) -> Values:
    """Weights of logistic regression, by Newton's method.

    Args:
        products: what is known, [case, product].
        shares: what is to be told, from 0 to 1, [case].
        counts: how much a case counts, [case].
        penalty: on half the squared weights, beside the mean of the cases.
    """
    weights, ridge = np.zeros(products.shape[1]), penalty * np.eye(products.shape[1])
    counts = counts / counts.sum()
    for _ in range(rounds):
        told = expit(products @ weights)
        slope = products.T @ (counts * (told - shares)) + penalty * weights
        bend = (products * (counts * told * (1 - told))[:, None]).T @ products + ridge
        weights -= np.linalg.solve(bend, slope)
    return weights


def _describe_looks(lab: Map) -> list[Map]:
    light = lab[..., 0]
    fine = [np.square(light - ndimage.gaussian_filter(light, width)) for width in (1.0, 2.0)]
    rough = [np.log1p(np.sqrt(ndimage.gaussian_filter(each, 2 * w))) for each, w in zip(fine, (1.0, 2.0), strict=True)]
    return [*np.moveaxis(ndimage.gaussian_filter(lab, (1.0, 1.0, 0)), 2, 0), *rough]
