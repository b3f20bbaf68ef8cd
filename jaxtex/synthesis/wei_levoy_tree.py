"""Tree-structured vector quantisation: a binary tree of codewords that leads to similar vectors in few comparisons.

L.-Y. Wei and M. Levoy, "Fast texture synthesis using tree-structured vector quantization", SIGGRAPH 2000, section 4;
A. Gersho and R. M. Gray, "Vector quantization and signal compression", 1992.
"""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array, lax

_DEEPEST = 64
_ROUNDS = 4  # of 2-means


class Tree(eqx.Module):
    """A tree over vectors of whole numbers.

    Attributes:
        codewords: [node, component].
        children: the two nodes below each, both 0 at leaves, [node, 2]. Nodes that none leads to fill up the arrays, so
            that their shapes, which functions are compiled for, do not depend on the vectors.
        members: the vector that each node stands for, [node].
        depth: the most steps from the root to a leaf, [].
    """

    codewords: Array
    children: Array
    members: Array
    depth: Array

    def descend(self, queries: Array, weight: Array) -> Array:
        """The member that each query leads to, [query].

        Args:
            queries: int32 [query, component].
            weight: which components count, boolean [query, component].
        """

        def step(_: Array, node: Array) -> Array:
            below = self.children[node]
            apart = jnp.where(weight[:, None], self.codewords[below] - queries[:, None], 0)
            left, right = jnp.sum(jnp.square(apart), axis=2).T
            return jnp.where(below[:, 0] == 0, node, jnp.where(left <= right, below[:, 0], below[:, 1]))

        return self.members[lax.fori_loop(0, self.depth, step, jnp.zeros(len(queries), jnp.int32))]


def grow_tree(vectors: npt.NDArray[np.int32]) -> Tree:
    """A tree whose leaves are single vectors, or several that are equal; each vector leads to its own leaf.

    Nodes are split by 2-means, all nodes of a level together, from the vector farthest from the node's mean and the one
    farthest from that. Codewords are rounded, so that distances are exact.

    Args:
        vectors: [vector, component].

    Examples:
        >>> tree = grow_tree(np.array([[0, 0], [9, 9], [0, 1]], np.int32))
        >>> tree.descend(jnp.array([[8, 9], [0, 0]]), jnp.ones((2, 2), bool)).tolist()
        [1, 0]
    """
    nodes, points, sizes = np.zeros(1, np.int64), np.arange(len(vectors)), np.array([len(vectors)])
    # A binary tree has fewer than twice as many nodes as leaves.
    codewords = np.zeros((2 * len(vectors), vectors.shape[1]), np.int32)
    children, members = np.zeros((len(codewords), 2), np.int32), np.zeros(len(codewords), np.int32)
    depth, count = 0, 1
    while len(nodes) and depth < _DEEPEST:
        pairs, right = _split(vectors[points], sizes)
        side = 2 * np.repeat(np.arange(len(nodes)), sizes) + right
        halves = np.bincount(side, minlength=2 * len(nodes)).reshape(-1, 2)
        divided = np.repeat((halves > 0).all(axis=1), 2)
        # Stable, so that the first of a node's points is the one with the lowest number.
        points = points[np.argsort(side, kind="stable")][np.repeat(divided, halves.reshape(-1))]
        sizes = halves.reshape(-1)[divided]
        below = np.arange(count, count + len(sizes))
        children[nodes[divided[::2]]] = below.reshape(-1, 2)
        codewords[below] = pairs.reshape(-1, vectors.shape[1])[divided]
        members[below] = points[np.cumsum(sizes) - sizes]
        several = sizes > 1
        points, nodes, sizes = points[np.repeat(several, sizes)], below[several], sizes[several]
        count, depth = count + len(below), depth + 1
    return Tree(jnp.asarray(codewords), jnp.asarray(children), jnp.asarray(members), jnp.asarray(depth, jnp.int32))


def _split(vectors: npt.NDArray[np.int32], sizes: npt.NDArray[np.int_]) -> tuple[npt.NDArray, npt.NDArray[np.bool_]]:
    """Two codewords for each run of vectors, [run, 2, component], and which vectors are nearer to the second."""
    starts, runs = np.cumsum(sizes) - sizes, np.repeat(np.arange(len(sizes)), sizes)

    def farthest(centres: npt.NDArray) -> npt.NDArray[np.int32]:
        distance = np.square(vectors - centres[runs]).sum(axis=1)
        return vectors[np.lexsort((-distance, runs))[starts]]

    def nearer(pairs: npt.NDArray[np.int32]) -> npt.NDArray[np.bool_]:
        left, right = (np.square(vectors - pairs[runs, side]).sum(axis=1) for side in (0, 1))
        return left > right

    means = np.round(np.add.reduceat(vectors, starts) / sizes[:, None]).astype(np.int32)
    first = farthest(means)
    pairs = np.stack([first, farthest(first)], axis=1)
    right = nearer(pairs)
    for _ in range(_ROUNDS):
        counts = np.stack([np.add.reduceat(each.astype(int), starts) for each in (~right, right)], axis=1)
        sums = [np.add.reduceat(vectors * each[:, None], starts) for each in (~right, right)]
        moved = np.round(np.stack(sums, axis=1) / np.maximum(counts, 1)[..., None]).astype(np.int32)
        nearer_moved = nearer(moved)
        share = np.add.reduceat(nearer_moved.astype(int), starts)
        kept = (share > 0) & (share < sizes)
        pairs = np.where(kept[:, None, None], moved, pairs)
        right = np.where(kept[runs], nearer_moved, right)
    return pairs, right
