"""Textures whose scale and direction vary from place to place, by multi-resolution k-coherence search.

J. Zhang et al., "Synthesis of Progressively-Variant Textures on Arbitrary Surfaces" (SIGGRAPH 2003), section 4.1:
neighbourhoods are scaled and turned as the texture is to be at each pixel, and resampled. Candidates are k-coherent
(X. Tong et al., SIGGRAPH 2002; section 5.2), and optionally only places of a like transition value (equation 1).

Departures: all pixels are decided again and again from coarse to fine, those that lie apart together, with whole square
neighbourhoods, rather than once each in an order that follows the field; so no order is better than another. As in
S. Lefebvre and H. Hoppe ("Appearance-space texture synthesis", SIGGRAPH 2006), what is kept of each pixel is where it
comes from, between pixels too: pieces of the exemplar are magnified, turned and bent smoothly as they are, and no
colours are resampled more than once. `jaxtex.synthesis.coherence` is the same for a texture like the exemplar.
"""

from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.synthesis.anisometric_pass import Floats, Given, Known, decide_all, sample_places
from jaxtex.synthesis.anisometric_start import lay_pieces
from jaxtex.synthesis.exemplars import ExemplarLevel, analyse_levels, halve, halve_frames
from jaxtex.synthesis.guides import GUIDE_WEIGHT, weigh_guides
from jaxtex.synthesis.neighbourhoods import check_exemplar

SIMILAR = 3
"""Places beside its own continuation that each neighbour brings as candidates, unless told: k - 1."""

_COARSEST = 32  # pixels along the shorter side of an exemplar
_PASSES, _COARSE_PASSES = 2, 6
_MOST_SAMPLES = 4  # along each axis, to a pixel in which more than one of the exemplar's are seen

Search = Literal["coherence", "exhaustive"]


class Transition(NamedTuple):
    """Which places of the exemplar may be used where (section 5.2, equation 1).

    Attributes:
        exemplar: a value at each of its pixels, 0 to 1, [row, col].
        texture: likewise of the texture, [row, col].
        tolerance: by how much they may differ.
    """

    exemplar: Floats
    texture: Floats
    tolerance: float = 0.1


class AnisometricStep(NamedTuple):
    """How far synthesis is.

    Attributes:
        done, total: steps.
        sources: (row, col) of the exemplar that each pixel shows, between pixels too, float32 [row, col, 2].
    """

    done: int
    total: int
    sources: Floats


def synthesise_anisometric(
    exemplar: npt.ArrayLike,
    scale: npt.ArrayLike,
    orientation: npt.ArrayLike,
    *,
    key: Array,
    radius: int = 3,
    similar: int = SIMILAR,
    search: Search = "coherence",
    tileable: bool = False,
    guides: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    guide_weight: float = GUIDE_WEIGHT,
    exemplar_frames: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    transition: Transition | None = None,
) -> Floats:
    """Make a texture whose things are as large, and turned as far, as two fields say.

    Args:
        exemplar: floats [row, col, channel], in an encoding whose steps look even, as sRGB's.
        scale: of the texture, how many times as large as in the exemplar things are, above 0, [row, col].
        orientation: radians by which they are turned, clockwise as seen, [row, col].
        key: random key; another key, another texture.
        radius: of the neighbourhoods that are compared, in pixels of each level, seen in the exemplar's frame.
        similar: places beside its own continuation that each neighbour brings as candidates (k - 1 of section 5.2).
        search: "exhaustive" compares all places of the exemplar at each pixel and level, as a reference.
        tileable: whether it repeats seamlessly; the fields must do so too.
        guides: as in `synthesise_coherence`: of the exemplar and of the texture, [row, col, channel].
        guide_weight: how much the guide counts beside colours.
        exemplar_frames: scale and orientation of the exemplar itself, where these vary in it (section 5.2).
        transition: which places of the exemplar may be used where; all by default.

    Returns:
        Where each pixel comes from: (row, col) of the exemplar, float32 [row, col, 2]; `sample_sources` shows it.

    Raises:
        ValueError: arrays of another form, values that are not finite or scales that are not above 0, an exemplar
            smaller than a neighbourhood.

    Examples:
        >>> grain = np.random.default_rng(0).random((40, 40, 3))
        >>> larger = synthesise_anisometric(grain, np.full((50, 75), 2.0), np.zeros((50, 75)), key=jax.random.key(0))
        >>> larger.shape
        (50, 75, 2)
    """
    steps = anisometric_steps(
        exemplar,
        scale,
        orientation,
        key=key,
        radius=radius,
        similar=similar,
        search=search,
        tileable=tileable,
        guides=guides,
        guide_weight=guide_weight,
        exemplar_frames=exemplar_frames,
        transition=transition,
    )
    *_, last = steps
    return last.sources


def anisometric_steps(
    exemplar: npt.ArrayLike,
    scale: npt.ArrayLike,
    orientation: npt.ArrayLike,
    *,
    key: Array,
    radius: int = 3,
    similar: int = SIMILAR,
    search: Search = "coherence",
    tileable: bool = False,
    guides: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    guide_weight: float = GUIDE_WEIGHT,
    exemplar_frames: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    transition: Transition | None = None,
) -> Iterator[AnisometricStep]:
    """The same step by step, with the sources so far, from coarse to fine."""
    pixels = check_exemplar(exemplar, radius)
    frames = make_frames(scale, orientation)
    own = make_frames(*exemplar_frames) if exemplar_frames is not None else None
    if own is not None and own.shape[:2] != pixels.shape[:2]:
        raise ValueError(f"exemplar_frames of shape {own.shape[:2]}: give the exemplar's, {pixels.shape[:2]}")
    if similar < 0:
        raise ValueError(f"similar: {similar} is below 0")
    pixels, guide = weigh_guides(pixels, guides, frames.shape[:2], guide_weight)
    everywhere = np.ones(pixels.shape[:2], bool)
    levels = analyse_levels(pixels, everywhere, radius=radius, coarsest=_COARSEST, similar=max(similar, 1), frames=own)
    given = Given(frames, guide, _check_transition(transition, pixels.shape[:2], frames.shape[:2]))
    tolerance = transition.tolerance if transition is not None else np.inf
    return _refine(levels, given, tolerance, key, radius, similar, search, tileable)


def make_frames(scale: npt.ArrayLike, orientation: npt.ArrayLike) -> Floats:
    """What leads from steps (down, right) of a texture as it is to steps of one that is scaled and turned.

    Args:
        scale: above 0, [row, col].
        orientation: radians, clockwise as seen, [row, col].

    Returns:
        [row, col, 2, 2].

    Raises:
        ValueError: fields of several shapes, not finite, or scales that are not above 0.

    Examples:
        >>> make_frames([[2.0]], [[0.5 * np.pi]])[0, 0].round(3) @ [0.0, 1.0]  # right becomes down
        array([2., 0.])
    """
    sizes, turns = np.asarray(scale, np.float32), np.asarray(orientation, np.float32)
    if sizes.ndim != 2 or 0 in sizes.shape or sizes.shape != turns.shape:
        raise ValueError(f"scale of shape {sizes.shape}, orientation {turns.shape}: give both as [row, col]")
    if not (np.isfinite(sizes).all() and np.isfinite(turns).all() and sizes.min() > 0):
        raise ValueError("scale, orientation: hold values that are not finite, or scales that are not above 0")
    cosine, sine = sizes * np.cos(turns), sizes * np.sin(turns)
    return np.stack([np.stack([cosine, sine], axis=-1), np.stack([-sine, cosine], axis=-1)], axis=-2)


def sample_sources(picture: npt.ArrayLike, sources: npt.ArrayLike, frames: npt.ArrayLike | None = None) -> Floats:
    """What a picture shows at sources between its pixels.

    Args:
        picture: floats [row, col, channel]: the exemplar, or another map of the same material.
        sources: (row, col), [row, col, 2], as `synthesise_anisometric` returns them.
        frames: by `make_frames`; where these make the picture smaller, the mean of what a pixel covers is taken.

    Raises:
        ValueError: arrays of another form.

    Examples:
        >>> sample_sources(np.arange(4.0).reshape(1, 4, 1), [[[0.0, 1.5]]])[0, 0, 0]
        np.float32(1.5)
    """
    pixels, places = np.asarray(picture, np.float32), np.asarray(sources, np.float32)
    if pixels.ndim != 3 or places.ndim != 3 or places.shape[2] != 2:
        raise ValueError(f"picture of shape {pixels.shape}, sources {places.shape}: give [row, col, ...] of both")
    backward = np.zeros((*places.shape[:2], 2, 2), np.float32)
    count = 1
    if frames is not None:
        backward = np.linalg.inv(np.asarray(frames, np.float32))
        count = int(np.clip(np.ceil(np.sqrt(np.abs(np.linalg.det(backward)).max()) - 1e-3), 1, _MOST_SAMPLES))
    offsets = (np.moveaxis(np.indices((count, count)), 0, -1).reshape(-1, 2) + 0.5) / count - 0.5
    total = sum(np.asarray(sample_places(pixels, places + backward @ each.astype(np.float32))) for each in offsets)
    return np.asarray(total / len(offsets), np.float32)


def _check_transition(
    transition: Transition | None, ours: tuple[int, ...], theirs: tuple[int, ...]
) -> tuple[Floats, Floats]:
    if transition is None:
        return np.zeros(ours[:2], np.float32), np.zeros(theirs[:2], np.float32)
    values = tuple(np.asarray(each, np.float32) for each in transition[:2])
    if values[0].shape != ours[:2] or values[1].shape != theirs[:2]:
        raise ValueError(
            f"transition of shapes {values[0].shape} and {values[1].shape}: give one of the exemplar's size and one of "
            f"the texture's, {ours[:2]} and {theirs[:2]}"
        )
    if not all(np.isfinite(each).all() for each in values) or not transition.tolerance > 0:
        raise ValueError("transition: holds values that are not finite, or a tolerance that is not above 0")
    return values[0], values[1]


def _refine(
    levels: list[ExemplarLevel],
    given: Given,
    tolerance: float,
    key: Array,
    radius: int,
    similar: int,
    search: Search,
    tileable: bool,
) -> Iterator[AnisometricStep]:
    givens = [given]
    for _ in levels[1:]:
        givens.append(_halve_given(givens[-1]))
    total, done = _COARSE_PASSES + _PASSES * (len(levels) - 1), 0
    sources = lay_pieces(levels[-1], givens[-1], tolerance, key, radius, tileable)
    for number in reversed(range(len(levels))):
        level, wanted = levels[number], givens[number]
        first = number == len(levels) - 1
        if not first:
            sources = _double(sources, level, wanted.frames)
        known = Known(
            level.pixels, level.valid, level.basis, level.features, level.similar[:, : 1 + similar], level.frames
        )
        everywhere = first or search == "exhaustive"
        for _ in range(_COARSE_PASSES if first else _PASSES):
            sources = np.asarray(
                decide_all(known, wanted, sources, np.float32(tolerance), radius, everywhere, tileable)
            )
            done += 1
            yield AnisometricStep(done, total, _magnify(sources, number, given.frames))


def _halve_given(given: Given) -> Given:
    def half(field: Floats) -> Floats:
        return halve(field, np.ones(field.shape[:2], bool))

    frames = halve_frames(given.frames)
    assert frames is not None
    ours, theirs = (half(each[..., None])[..., 0] for each in given.transition)
    return Given(frames, half(given.guide), (ours, theirs))


def _double(sources: Floats, level: ExemplarLevel, frames: Floats) -> Floats:
    """Sources at the next finer level: what lies between pixels of the coarser one goes on in the same direction."""
    row, column = np.indices(frames.shape[:2])
    above = 2 * sources[row // 2, column // 2] + 0.5
    away = np.stack([row % 2 - 0.5, column % 2 - 0.5], axis=-1)
    steps = np.linalg.inv(frames)
    if level.frames is not None:
        place = np.clip(np.rint(above), 0, np.array(level.valid.shape) - 1).astype(int)
        steps = level.frames[place[..., 0], place[..., 1]] @ steps
    moved = above + np.einsum("rcij,rcj->rci", steps, away)
    return np.clip(moved, 0, np.array(level.valid.shape) - 1).astype(np.float32)


def _magnify(sources: Floats, octaves: int, frames: Floats) -> Floats:
    """Sources at full resolution that go with those of a coarser one."""
    row, column = np.indices(frames.shape[:2])
    times = 2**octaves
    away = np.stack([row % times, column % times], axis=-1) - 0.5 * (times - 1)
    above = times * sources[row >> octaves, column >> octaves] + 0.5 * (times - 1)
    return (above + np.einsum("rcij,rcj->rci", np.linalg.inv(frames), away)).astype(np.float32)
