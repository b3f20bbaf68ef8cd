"""Texton mask filtering: a texture that goes with a mask as an exemplar does with its own.

J. Zhang et al., "Synthesis of Progressively-Variant Textures on Arbitrary Surfaces" (SIGGRAPH 2003), section 4.3, as in
A. Hertzmann et al., "Image analogies" (SIGGRAPH 2001), and section 5.2: multi-resolution, k-coherence, a refinement
pass with a small neighbourhood.

Departures: the search is that of `jaxtex.synthesis.anisometric` at scale 1. Masks are compared by signed distances to
the borders of each label, up to a few pixels, rather than by labels: near borders it is known how near they are, and
borders that lie a pixel apart differ little, so pieces of the exemplar stay larger and elements have its outlines.
"""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.core.errors import InputError
from jaxtex.progressive.texton_masks import Labels, check_texton_mask
from jaxtex.progressive.warping import signed_distance
from jaxtex.synthesis.anisometric import SIMILAR, AnisometricStep, anisometric_steps
from jaxtex.synthesis.anisometric_refinement import refine_anisometric
from jaxtex.synthesis.neighbourhoods import check_exemplar

MASK_WEIGHT = 2.0
"""How much masks vary beside colours, unless told."""

_REACH = 3.0  # pixels from a border beyond which distances are not told apart
_REFINEMENT = 2  # radius of the neighbourhoods of the last pass

Floats = npt.NDArray[np.float32]


def filter_mask(
    exemplar: npt.ArrayLike,
    mask: npt.ArrayLike,
    wanted: npt.ArrayLike,
    *,
    key: Array,
    radius: int = 3,
    similar: int = SIMILAR,
    mask_weight: float = MASK_WEIGHT,
) -> Floats:
    """Make a texture whose elements lie, and have the shapes, that a mask tells.

    Args:
        exemplar: floats [row, col, channel], in an encoding whose steps look even, as sRGB's.
        mask: which type of element each of its pixels belongs to, 0 to 3, [row, col].
        wanted: likewise of the texture, of any size; all of its types are in `mask`.
        key: random key; another key, another texture.
        radius: of the neighbourhoods that are compared, in pixels of each level.
        similar: places beside its own continuation that each neighbour brings as candidates (k - 1 of section 5.2).
        mask_weight: how much masks count beside colours, above 0: with more, borders lie as told more exactly, and
            smaller pieces of the exemplar are put together.

    Returns:
        Where each pixel comes from: (row, col) of the exemplar, float32 [row, col, 2];
        `jaxtex.synthesis.anisometric.sample_sources` shows it.

    Raises:
        InputError: masks of another size or form, types in `wanted` that are not in `mask`, a mask of one type alone.
        ValueError: as `synthesise_anisometric`.

    Examples:
        >>> import jax
        >>> there = np.hypot(*(np.indices((48, 48)) % 16 - 8)) < 5
        >>> larger = np.hypot(*(np.indices((40, 60)) % 20 - 10)) < 6
        >>> sources = filter_mask(there[..., None] * 1.0, there, larger, key=jax.random.key(0))
        >>> sources.shape
        (40, 60, 2)
    """
    *_, last = filter_mask_steps(
        exemplar, mask, wanted, key=key, radius=radius, similar=similar, mask_weight=mask_weight
    )
    return last.sources


def filter_mask_steps(
    exemplar: npt.ArrayLike,
    mask: npt.ArrayLike,
    wanted: npt.ArrayLike,
    *,
    key: Array,
    radius: int = 3,
    similar: int = SIMILAR,
    mask_weight: float = MASK_WEIGHT,
) -> Iterator[AnisometricStep]:
    """The same step by step, with the sources so far, from coarse to fine."""
    pixels = check_exemplar(exemplar, radius)
    ours = check_texton_mask(mask, (pixels.shape[1], pixels.shape[0]))
    theirs = check_texton_mask(wanted)
    guides = _make_guides(ours, theirs)
    frames = np.ones(theirs.shape, np.float32), np.zeros(theirs.shape, np.float32)
    for step in anisometric_steps(
        pixels, *frames, key=key, radius=radius, similar=similar, guides=guides, guide_weight=mask_weight
    ):
        yield step._replace(total=step.total + 1)
    refined = refine_anisometric(
        pixels,
        step.sources,
        *frames,
        radius=min(_REFINEMENT, radius),
        similar=similar,
        guides=guides,
        guide_weight=mask_weight,
    )
    yield AnisometricStep(step.total + 1, step.total + 1, refined)


def _make_guides(ours: Labels, theirs: Labels) -> tuple[Floats, Floats]:
    """Signed distances to the borders of each label, [row, col, label]; of two labels, of the larger one alone."""
    labels = np.unique(ours)
    missing = [str(each) for each in np.setdiff1d(theirs, labels)]
    if missing:
        raise InputError(f"the wanted mask has type {', '.join(missing)}, which the exemplar's mask has not")
    if len(labels) == 1:
        raise InputError("the exemplar's texton mask has one value alone; mark its elements")
    labels = labels[1:] if len(labels) == 2 else labels

    def measure(mask: Labels) -> Floats:
        depths = [np.clip(signed_distance(mask == each) / _REACH, -1, 1) for each in labels]
        return np.stack(depths, axis=2).astype(np.float32)

    return measure(ours), measure(theirs)
