"""Feature-based blending: one texture becomes another, its elements' shapes and colours together.

J. Zhang et al., "Synthesis of Progressively-Variant Textures on Arbitrary Surfaces" (SIGGRAPH 2003), section 4.3 and
figures 7 and 8: a mask between those of the textures; each texture filtered from it, so that elements of all lie in the
same places; colours blended by the transition function. Any smooth transition will do, and any number of textures
(section 7, future work).

Departures: labels 0 and 1 that are blended by weights and thresholded at a half change all at once where the weights
are equal; blurring hides that, and thin elements with it. Instead of labels, signed distances to borders are blended,
so that shapes change all the way. They are made normally distributed first (by rank) and blended with their variance
kept, as E. Heitz and F. Neyret do with colours ("High-Performance By-Example Noise using a Histogram-Preserving
Blending Operator", 2018), so a threshold is known at which elements cover, at each place, the weighted mean of what
they cover in the textures; nobody selects it. Between textures, elements that are more ragged than those of the masks
are parted where they are narrow, and smoothed.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import jax
import numpy as np
import numpy.typing as npt
from jax import Array
from scipy import ndimage
from scipy.stats import norm, rankdata

from jaxtex.core.errors import InputError
from jaxtex.progressive.compactness import keep_compact, measure_raggedness
from jaxtex.progressive.filtering import MASK_WEIGHT, filter_mask
from jaxtex.progressive.masked import masked_steps
from jaxtex.progressive.texton_masks import Labels, check_texton_mask
from jaxtex.progressive.warping import signed_distance
from jaxtex.synthesis.anisometric import sample_sources

_SUM = 1e-3  # by which weights may miss 1
_RAGGED = 0.98  # of a mask's elements are less ragged than those of a blend may be

Floats = npt.NDArray[np.float32]


class Blend(NamedTuple):
    """Textures that become each other.

    Attributes:
        mask: of all of them, uint8 [row, col].
        sources: for each texture, where each pixel comes from in its exemplar, float32 [row, col, 2].
        weights: float32 [texture, row, col].
    """

    mask: Labels
    sources: list[Floats]
    weights: Floats

    def show(self, pictures: Sequence[npt.ArrayLike]) -> Floats:
        """Blend the exemplars' colours, or other maps of the same materials.

        Args:
            pictures: one for each texture, [row, col, channel], all with as many channels, in the encoding in which
                they are to be blended.
        """
        shown = [sample_sources(each, where) for each, where in zip(pictures, self.sources, strict=True)]
        return np.sum(self.weights[..., None] * np.stack(shown), axis=0)


def transition_weights(transition: npt.ArrayLike, count: int = 2) -> Floats:
    """Weights of textures that follow each other along a transition function, at even distances.

    Args:
        transition: 0, where the first texture is alone, to 1, where the last is; [row, col].
        count: of textures, 2 or more.

    Returns:
        [texture, row, col], summing to 1.

    Raises:
        ValueError: another shape, values out of range, or fewer than 2 textures.

    Examples:
        >>> transition_weights([[0.0, 0.25, 0.5, 1.0]], 3)[:, 0].T.tolist()
        [[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    """
    values = np.asarray(transition, np.float32)
    if values.ndim != 2 or not (values.size and np.isfinite(values).all() and 0 <= values.min() <= values.max() <= 1):
        raise ValueError(f"transition of shape {values.shape}: give numbers from 0 to 1, [row, col]")
    if count < 2:
        raise ValueError(f"count: {count} textures; give 2 or more")
    steps = np.abs(values[None] * (count - 1) - np.arange(count, dtype=np.float32)[:, None, None])
    return np.clip(1 - steps, 0, 1)


def blend_masks(masks: Sequence[npt.ArrayLike], weights: npt.ArrayLike) -> Labels:
    """A mask that is like some others as far as weights say, and between them elsewhere.

    Args:
        masks: labels 0 to 3, [row, col], all of one size.
        weights: of each, [mask, row, col], 0 or more, summing to 1; smooth.

    Returns:
        uint8 [row, col]. Of two labels, elements, which the larger marks, cover about the weighted mean of what they
        cover in the masks, and are no more ragged than most of theirs; of more labels, they cover so nearly.

    Raises:
        InputError: no texton masks, or of several sizes.
        ValueError: weights of another shape, below 0, or that do not sum to 1.

    Examples:
        >>> few = np.hypot(*(np.indices((64, 64)) % 32 - 16)) < 6
        >>> many = np.hypot(*(np.indices((64, 64)) % 16 - 8)) < 6
        >>> between = blend_masks([few, many], np.full((2, 64, 64), 0.5))
        >>> bool(few.mean() < between.mean() < many.mean())
        True
    """
    first = check_texton_mask(masks[0])
    given = [check_texton_mask(each, (first.shape[1], first.shape[0])) for each in masks]
    shares = _check_weights(weights, (len(given), *first.shape))
    spread = np.sqrt(np.square(shares).sum(axis=0))
    labels = np.unique(np.stack(given))
    above = []
    for label in labels:
        scores = np.stack([_score(each == label) for each in given])
        covered = np.array([np.mean(each == label) for each in given])[:, None, None]
        # Scores of what no mask has, or what all have everywhere, are infinite as this threshold is.
        threshold = norm.ppf(1 - np.clip((shares * covered).sum(axis=0), 1e-9, 1 - 1e-9))
        above.append((shares * scores).sum(axis=0) / spread - threshold)
    if len(labels) != 2:
        return labels[np.argmax(above, axis=0)]
    most = np.sum(shares * [[[_allow_ragged(each == labels[1])]] for each in given], axis=0)
    alone, blended = shares.max(axis=0) > 1 - _SUM, above[1] > 0
    return labels[np.where(alone, blended, keep_compact(blended, most)).astype(int)]


def blend_textures(
    exemplars: Sequence[npt.ArrayLike],
    masks: Sequence[npt.ArrayLike],
    weights: npt.ArrayLike,
    *,
    key: Array,
    radius: int = 3,
    mask_weight: float = MASK_WEIGHT,
) -> Blend:
    """Make a texture that goes over from one exemplar to others.

    Args:
        exemplars: floats [row, col, channel], in an encoding whose steps look even, as sRGB's; of any sizes.
        masks: which type of element each of their pixels belongs to, 0 to 3, [row, col]; all of the same types.
        weights: of each, [texture, row, col], 0 or more, summing to 1; `transition_weights` makes them.
        key: random key; another key, another texture.
        radius, mask_weight: as in `filter_mask`.

    Returns:
        The blend; its `show` gives colours.

    Raises:
        InputError: masks of another size or form, or not of the same types.
        ValueError: as `blend_masks` and `filter_mask`.

    Examples:
        >>> few = np.hypot(*(np.indices((48, 48)) % 24 - 12)) < 6
        >>> many = np.hypot(*(np.indices((48, 48)) % 16 - 8)) < 5
        >>> pictures = [few[..., None] * 1.0, many[..., None] * 0.5]
        >>> weights = transition_weights(np.linspace(0, 1, 60)[None].repeat(40, axis=0))
        >>> blend = blend_textures(pictures, [few, many], weights, key=jax.random.key(0))
        >>> blend.show(pictures).shape
        (40, 60, 1)
    """
    shape = np.shape(weights)[1:]
    if np.ndim(weights) != 3 or not len(exemplars) == len(masks) == len(np.asarray(weights)):
        raise ValueError(
            f"{len(exemplars)} exemplars, {len(masks)} masks, weights of shape {np.shape(weights)}: give one for each"
        )
    types = [np.unique(check_texton_mask(each)).tolist() for each in masks]
    if any(each != types[0] for each in types):
        raise InputError(f"masks: have types {', '.join(map(str, types))}; give them the same types")
    keys = jax.random.split(key, (len(exemplars), 2))
    laid = [
        lay_out_mask(*each, (shape[0], shape[1]), key=own[0])
        for each, own in zip(zip(exemplars, masks, strict=True), keys, strict=True)
    ]
    between = blend_masks(laid, weights)
    sources = [
        filter_mask(exemplar, mask, between, key=own[1], radius=radius, mask_weight=mask_weight)
        for exemplar, mask, own in zip(exemplars, masks, keys, strict=True)
    ]
    return Blend(between, sources, np.asarray(weights, np.float32))


def lay_out_mask(
    exemplar: npt.ArrayLike,
    mask: npt.ArrayLike,
    shape: tuple[int, int],
    *,
    key: Array,
    report: Callable[[float, float | None], None] | None = None,
) -> Labels:
    """An exemplar's mask at another size: cut out of it, or, where it is too small, synthesised along with it.

    Args:
        exemplar: floats [row, col, channel], encoded as above.
        mask: labels [row, col].
        shape: (rows, columns).
        key: random key.
        report: told what part of the work is done, and how much there is.

    Raises:
        InputError: a mask of another form, or of another size than the exemplar's.

    Examples:
        >>> lay_out_mask(np.eye(8)[..., None], np.eye(8), (2, 3), key=jax.random.key(0))
        array([[1, 0, 0], [0, 1, 0]], dtype=uint8)
    """
    rows, columns = np.shape(exemplar)[:2]
    labels = check_texton_mask(mask, (columns, rows))
    if rows >= shape[0] and columns >= shape[1]:
        return labels[: shape[0], : shape[1]]
    for step in masked_steps(exemplar, labels, shape, key=key):
        if report is not None:
            report(step.done, step.total)
    return labels[step.sources[..., 0], step.sources[..., 1]]


def _score(inside: npt.NDArray[np.bool_]) -> npt.NDArray[np.float64]:
    """Signed distances by rank, normally distributed; infinite where there is no border."""
    if inside.all() or not inside.any():
        return np.full(inside.shape, 9.0 if inside.all() else -9.0)
    return norm.ppf(rankdata(signed_distance(inside)).reshape(inside.shape) / (inside.size + 1))


def _allow_ragged(inside: npt.NDArray[np.bool_]) -> float:
    ragged = measure_raggedness(ndimage.label(inside)[0])
    return float(np.quantile(ragged[ragged > 0], _RAGGED)) if ragged.any() else 1.0


def _check_weights(weights: npt.ArrayLike, shape: tuple[int, ...]) -> npt.NDArray[np.float64]:
    shares = np.asarray(weights, np.float64)
    if shares.shape != shape:
        raise ValueError(f"weights of shape {shares.shape}: give {shape}")
    if not (np.isfinite(shares).all() and shares.min() >= 0 and np.abs(shares.sum(axis=0) - 1).max() < _SUM):
        raise ValueError("weights: hold values below 0, or do not sum to 1")
    return shares
