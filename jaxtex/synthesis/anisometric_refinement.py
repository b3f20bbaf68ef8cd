"""A last pass of anisometric synthesis with small neighbourhoods.

J. Zhang et al., "Synthesis of Progressively-Variant Textures on Arbitrary Surfaces" (SIGGRAPH 2003), section 5.2: "a
refinement pass with a small neighborhood size". What is near counts more then: borders come to lie where guides have
them.
"""

import math

import numpy as np
import numpy.typing as npt

from jaxtex.synthesis.anisometric import SIMILAR, make_frames
from jaxtex.synthesis.anisometric_pass import Floats, Given, Known, decide_all, order_pixels
from jaxtex.synthesis.exemplars import analyse_levels
from jaxtex.synthesis.guides import GUIDE_WEIGHT, weigh_guides
from jaxtex.synthesis.neighbourhoods import check_exemplar

_ALL_AT_ONCE = 1 << 12  # places that are compared each with each


def refine_anisometric(
    exemplar: npt.ArrayLike,
    sources: npt.ArrayLike,
    scale: npt.ArrayLike,
    orientation: npt.ArrayLike,
    *,
    radius: int = 2,
    similar: int = SIMILAR,
    tileable: bool = False,
    guides: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    guide_weight: float = GUIDE_WEIGHT,
) -> Floats:
    """Decide all pixels of a texture once more, at full resolution.

    Args:
        exemplar, scale, orientation, similar, tileable, guides, guide_weight: as in `synthesise_anisometric`.
        sources: what that returned, [row, col, 2].
        radius: of the neighbourhoods that are compared, smaller than before.

    Returns:
        New sources, float32 [row, col, 2].

    Raises:
        ValueError: arrays of another form, an exemplar smaller than a neighbourhood.

    Examples:
        >>> grain = np.random.default_rng(0).random((40, 40, 3))
        >>> same = np.moveaxis(np.indices((40, 40), np.float32), 0, -1)
        >>> again = refine_anisometric(grain, same, np.ones((40, 40)), np.zeros((40, 40)))
        >>> bool((again == same)[2:-2, 2:-2].all())
        True
    """
    pixels, frames = check_exemplar(exemplar, radius), make_frames(scale, orientation)
    start = np.asarray(sources, np.float32)
    if start.shape != (*frames.shape[:2], 2):
        raise ValueError(f"sources of shape {start.shape}: give {(*frames.shape[:2], 2)}, as scale has it")
    if similar < 0:
        raise ValueError(f"similar: {similar} is below 0")
    size, everywhere = pixels.shape[:2], np.ones(pixels.shape[:2], bool)
    pixels, guide = weigh_guides(pixels, guides, frames.shape[:2], guide_weight)
    coarsest = _coarsest_side(size, radius)
    level = analyse_levels(pixels, everywhere, radius=radius, coarsest=coarsest, similar=max(similar, 1))[0]
    alike = level.similar[:, : 1 + similar]
    known = Known(level.pixels, level.valid, level.basis, level.features, alike, level.frames)
    given = Given(frames, guide, (np.zeros(size, np.float32), np.zeros(frames.shape[:2], np.float32)))
    order = order_pixels(np.ones(frames.shape[:2], bool))
    return np.asarray(decide_all(known, given, start, np.float32(np.inf), *order, radius, False, tileable))


def _coarsest_side(size: tuple[int, ...], radius: int) -> int:
    """The shorter side at the finest resolution of an exemplar at which all of its places are compared.

    Among all places at once those that look alike are found best. That takes too long of large exemplars, so they are
    sought from that resolution to finer ones: less alike, but at 256 x 256 in a fourteenth of the time.
    """
    halved = 0
    while math.prod(-(-side >> halved) - 2 * radius for side in size) > _ALL_AT_ONCE:
        halved += 1
    return min(size) >> halved
