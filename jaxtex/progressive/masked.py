"""Textures whose elements stay whole, by the help of a mask that marks them.

J. Zhang et al., "Synthesis of Progressively-Variant Textures on Arbitrary Surfaces" (SIGGRAPH 2003), sections 5.1 and
5.3: the difference of colours tells little of whether an element breaks, that of masks much; so the mask is synthesised
along with the texture, and places are compared by both.

Departures: at each place of the mask stands how far it is to the nearest border of an element rather than its label.
So the least difference is between borders that are in almost the same place, coarse levels see elements that labels
alone would average away, and it tells how large an element is from its middle. Mask and colours of a pixel come
from one place of the exemplar, which is chosen by both at once. The search is that of `jaxtex.synthesis.anisometric`
with all scales 1: it begins with pieces that fit what lies beside them, rather than with all parts of the exemplar.
"""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
from jax import Array
from scipy.ndimage import distance_transform_edt

from jaxtex.synthesis.anisometric import anisometric_steps
from jaxtex.synthesis.guides import weigh_guides
from jaxtex.synthesis.neighbourhoods import check_picture, check_shape
from jaxtex.synthesis.sources import Sources, Step, last_of

MASK_WEIGHT = 1.0
"""How much masks vary beside colours, unless told."""

_MOST_LABELS = 4
_DEEP = 0.9  # of an element's pixels are nearer to its border than what is told apart

Floats = npt.NDArray[np.float32]


def synthesise_masked(
    exemplar: npt.ArrayLike,
    mask: npt.ArrayLike,
    shape: tuple[int, int],
    *,
    key: Array,
    radius: int = 3,
    mask_weight: float = MASK_WEIGHT,
) -> Sources:
    """Make a texture from an exemplar whose elements are marked. It repeats seamlessly.

    Args:
        exemplar: floats [row, col, channel], in an encoding whose steps look even, as sRGB's.
        mask: which type of element each of its pixels belongs to, [row, col], of two to four values.
        shape: (rows, columns) of the texture, any.
        key: random key; another key, another piece of the texture.
        radius: of the neighbourhoods that are compared, in pixels of each level.
        mask_weight: how much the mask counts, of what colours count; above 0.

    Returns:
        The source map, int32 [*shape, 2], of the colours, the mask and any other map; see `jaxtex.synthesis.sources`.

    Raises:
        ValueError: as `synthesise_anisometric`; a mask of another size than the exemplar's, with one value or more than
            four.

    Examples:
        >>> import jax
        >>> grain = np.random.default_rng(0).random((40, 40, 3))
        >>> synthesise_masked(grain, grain[..., 0] > 0.5, (50, 75), key=jax.random.key(0)).shape
        (50, 75, 2)
    """
    return last_of(masked_steps(exemplar, mask, shape, key=key, radius=radius, mask_weight=mask_weight))


def masked_steps(
    exemplar: npt.ArrayLike,
    mask: npt.ArrayLike,
    shape: tuple[int, int],
    *,
    key: Array,
    radius: int = 3,
    mask_weight: float = MASK_WEIGHT,
) -> Iterator[Step]:
    """The same step by step, with the source map so far, from coarse to fine."""
    alike = np.ones(check_shape(shape))
    marked = mark_elements(exemplar, mask, mask_weight)
    steps = anisometric_steps(marked, alike, 0 * alike, key=key, radius=radius, tileable=True)
    # Where nothing is scaled or turned, sources are whole pixels.
    return (Step(each.done, each.total, np.rint(each.sources).astype(np.int32)) for each in steps)


def mark_elements(exemplar: npt.ArrayLike, mask: npt.ArrayLike, mask_weight: float = MASK_WEIGHT) -> Floats:
    """An exemplar with its mask as further channels, as `synthesise_anisometric` takes it, too.

    Args:
        exemplar, mask, mask_weight: as in `synthesise_masked`.

    Returns:
        float32 [row, col, channel].

    Raises:
        ValueError: as `synthesise_masked`.

    Examples:
        >>> grain = np.random.default_rng(0).random((40, 40, 3))
        >>> mark_elements(grain, grain[..., 0] > 0.5).shape
        (40, 40, 4)
    """
    pixels, depths = check_picture(exemplar, "exemplar"), measure_depths(mask)
    if depths.shape[:2] != pixels.shape[:2]:
        raise ValueError(f"mask of shape {depths.shape[:2]}: give the exemplar's, {pixels.shape[:2]}")
    return weigh_guides(pixels, (depths, depths), depths.shape[:2], mask_weight)[0]


def measure_depths(mask: npt.ArrayLike) -> Floats:
    """How deep pixels are in what each label marks, and, below 0, how far from it.

    Args:
        mask: [row, col] of two to four values.

    Returns:
        -1 to 1, float32 [row, col, label]; of two labels, of the larger one alone. Deeper than nearly all pixels of a
        label and as far away is 1 and -1.

    Raises:
        ValueError: a mask of another form, with one value or more than four.

    Examples:
        >>> measure_depths([[0, 0, 0, 0, 1, 1, 1, 1]])[0, 3:6, 0].tolist()
        [-0.15625, 0.15625, 0.46875]
    """
    labels = np.asarray(mask)
    if labels.ndim != 2:
        raise ValueError(f"mask of shape {labels.shape}: give [row, col]")
    values = np.unique(labels)
    if not 2 <= len(values) <= _MOST_LABELS:
        raise ValueError(f"mask has {len(values)} values: give two to {_MOST_LABELS}")
    return np.stack([_measure_depth(labels == value) for value in (values[1:] if len(values) == 2 else values)], axis=2)


def _measure_depth(marked: npt.NDArray[np.bool_]) -> Floats:
    inside = distance_transform_edt(marked)
    depth = np.where(marked, inside - 0.5, 0.5 - distance_transform_edt(~marked))
    return np.clip(depth / np.quantile(depth[marked], _DEEP), -1, 1).astype(np.float32)
