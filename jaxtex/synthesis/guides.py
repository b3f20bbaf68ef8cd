"""Guides: what a texture should be like where, in other terms than its colours.

As in A. Hertzmann et al., "Image analogies" (SIGGRAPH 2001), where the exemplar's guide relates to its colours as the
texture's guide does to what is sought.
"""

import math

import numpy as np
import numpy.typing as npt

from jaxtex.synthesis.neighbourhoods import check_picture

GUIDE_WEIGHT = 0.5
"""How much guides count beside colours, unless told."""

Floats = npt.NDArray[np.float32]


def weigh_guides(
    pixels: Floats,
    guides: tuple[npt.ArrayLike, npt.ArrayLike] | None,
    shape: tuple[int, int],
    weight: float,
) -> tuple[Floats, Floats]:
    """An exemplar with its guide as further channels, and the texture's guide, both as much as they are to count.

    Args:
        pixels: the exemplar, [row, col, channel].
        guides: of the exemplar, [row, col, guide channel], and of the texture, [*shape, guide channel]; None for none.
        shape: the texture's rows and columns.
        weight: how much guides vary beside colours; above 0.

    Raises:
        ValueError: guides of other sizes, or not as many channels; a weight that is not above 0.

    Examples:
        >>> ours, theirs = weigh_guides(np.eye(3, dtype=np.float32)[..., None], None, (4, 5), 0.5)
        >>> ours.shape, theirs.shape
        ((3, 3, 1), (4, 5, 0))
    """
    if not (math.isfinite(weight) and weight > 0):
        raise ValueError(f"guide_weight: {weight} is none; give a number above 0")
    if guides is None:
        return pixels, np.zeros((*shape, 0), np.float32)
    ours, guide = (check_picture(each, "guide") for each in guides)
    if ours.shape[:2] != pixels.shape[:2] or guide.shape[:2] != shape or ours.shape[2] != guide.shape[2]:
        raise ValueError(
            f"guides of shapes {ours.shape} and {guide.shape}: give one of the exemplar's size and one of the "
            f"texture's, {pixels.shape[:2]} and {shape}, with as many channels"
        )
    spread, own = (np.sqrt(each.var(axis=(0, 1)).sum()) for each in (pixels, ours))
    scale = np.float32(weight * (spread or 1) / (own or 1))
    return np.concatenate([pixels, scale * ours], axis=2), scale * guide
