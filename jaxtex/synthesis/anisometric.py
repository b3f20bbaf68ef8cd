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

from jaxtex.synthesis.anisometric_pass import Floats, Given, Known, decide_all, order_pixels, sample_places
from jaxtex.synthesis.anisometric_start import lay_pieces
from jaxtex.synthesis.exemplars import Bools, ExemplarLevel, analyse_levels, halve, halve_frames
from jaxtex.synthesis.guides import GUIDE_WEIGHT, weigh_guides
from jaxtex.synthesis.neighbourhoods import check_exemplar

SIMILAR = 3
"""Places beside its own continuation that each neighbour brings as candidates, unless told: k - 1."""

_COARSEST = 32  # pixels along the shorter side of an exemplar
_PASSES, _COARSE_PASSES = 2, 6
_LEAST_SIDE = 4  # pixels of the texture's coarsest resolution
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
        >>> import jax
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
    if own is not None:  # neighbourhoods grow with things (section 5.2): as large as told where these are as usual
        usual = np.median(np.sqrt(np.linalg.det(own)))
        own, frames = own / usual, frames / usual
    if similar < 0:
        raise ValueError(f"similar: {similar} is below 0")
    pixels, guide = weigh_guides(pixels, guides, frames.shape[:2], guide_weight)
    everywhere = np.ones(pixels.shape[:2], bool)
    levels = analyse_levels(pixels, everywhere, radius=radius, coarsest=_COARSEST, similar=max(similar, 1), frames=own)
    values = _check_transition(transition, pixels.shape[:2], frames.shape[:2])
    given = Given(frames, guide, values)
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


class _Stage(NamedTuple):
    """A few passes over some pixels at one resolution.

    Attributes:
        texture, exemplar: octaves by which each is coarser than in full.
        open: the pixels, [row, col].
        passes: how many.
        everywhere: whether all of the exemplar is searched.
    """

    texture: int
    exemplar: int
    open: Bools
    passes: int
    everywhere: bool


def _plan_stages(coarsest: int, frames: list[Floats], search: Search) -> list[_Stage]:
    """Each pixel is decided where those of the texture and of the exemplar are about as large as one another: what is
    larger in the texture, at coarser resolutions of it, and once more in full, so that seams have no stairs.

    Args:
        coarsest: resolution of the exemplar.
        frames: of the texture at full exemplar resolution, from its full resolution to its coarsest.
        search: as in `synthesise_anisometric`.
    """
    stages = []
    for texture in reversed(range(len(frames))):
        # Where things would be as large as in the exemplar if this were as many octaves coarser.
        alike = -np.rint(0.5 * np.log2(np.linalg.det(frames[texture]))).astype(int)
        if texture == 0:
            alike = np.clip(alike, 0, coarsest)
        for exemplar in reversed(range(coarsest + 1)):
            there = alike == exemplar
            first = exemplar == coarsest or texture == len(frames) - 1
            if there.any():
                passes = _COARSE_PASSES if first else _PASSES
                stages.append(_Stage(texture, exemplar, there, passes, first or search == "exhaustive"))
    return stages


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
    own, ours = levels[0].frames, [given.transition[0]]
    for _ in levels[1:]:
        ours.append(_halve(ours[-1][..., None])[..., 0])
    givens = [given]
    deep = len(levels) - 1 + max(0, round(0.5 * float(np.log2(np.linalg.det(given.frames).max()))))
    while len(givens) <= deep and min(givens[-1].frames.shape[:2]) >= 2 * _LEAST_SIDE:
        givens.append(_halve_given(givens[-1]))
    stages = _plan_stages(len(levels) - 1, [each.frames for each in givens], search)
    total, done = sum(stage.passes for stage in stages), 0
    at = len(givens) - 1
    sources = lay_pieces(levels[-1], _see(givens[at], ours[-1], len(levels) - 1), tolerance, key, radius, tileable)
    sources = _rescale(sources, len(levels) - 1)
    yield AnisometricStep(0, total, _magnify(sources, at, given.frames, own, levels[0].valid.shape))
    for stage in stages:
        while at > stage.texture:
            at -= 1
            sources = _magnify(sources, 1, givens[at].frames, own, levels[0].valid.shape)
        level, wanted = levels[stage.exemplar], _see(givens[at], ours[stage.exemplar], stage.exemplar)
        alike = level.similar[:, : 1 + similar]
        known = Known(level.pixels, level.valid, level.basis, level.features, alike, level.frames)
        order = order_pixels(stage.open)
        there = _rescale(sources, -stage.exemplar)
        for _ in range(stage.passes):
            options = np.float32(tolerance), *order, radius, stage.everywhere, tileable
            there = np.asarray(decide_all(known, wanted, there, *options))
            done += 1
            sources = np.where(stage.open[..., None], _rescale(there, stage.exemplar), sources)
            yield AnisometricStep(done, total, _magnify(sources, at, given.frames, own, levels[0].valid.shape))


def _halve(field: Floats) -> Floats:
    return halve(field, np.ones(field.shape[:2], bool))


def _halve_given(given: Given) -> Given:
    """What is wanted at half the resolution; a step of the texture is then two of the exemplar."""
    frames = halve_frames(given.frames)
    assert frames is not None
    transition = given.transition[0], _halve(given.transition[1][..., None])[..., 0]
    return Given(np.float32(0.5) * frames, _halve(given.guide), transition)


def _see(given: Given, ours: Floats, octaves: int) -> Given:
    """What is wanted, in pixels of an exemplar that is some octaves coarser, whose transition values are given."""
    return given._replace(frames=given.frames * np.float32(2**octaves), transition=(ours, given.transition[1]))


def _rescale(sources: Floats, octaves: int) -> Floats:
    """The same places in an exemplar that is some octaves finer, or coarser if negative."""
    times = np.float32(2.0**octaves)
    return times * sources + np.float32(0.5) * (times - 1)


def _magnify(sources: Floats, octaves: int, frames: Floats, own: Floats | None, shape: tuple[int, ...]) -> Floats:
    """Sources at a resolution of the texture that is some octaves finer and has these frames: what lies between pixels
    of the coarser one goes on in the same direction."""
    row, column = np.indices(frames.shape[:2])
    away = np.stack([row % 2**octaves, column % 2**octaves], axis=-1) - 0.5 * (2**octaves - 1)
    above, steps = sources[row >> octaves, column >> octaves], np.linalg.inv(frames)
    if own is not None:
        place = np.clip(np.rint(above), 0, np.array(shape) - 1).astype(int)
        steps = own[place[..., 0], place[..., 1]] @ steps
    moved = above + np.einsum("rcij,rcj->rci", steps, away)
    return np.clip(moved, 0, np.array(shape) - 1).astype(np.float32)
