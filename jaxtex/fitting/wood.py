"""Picture of wood -> fitted wood: the whole way, step by step.

Lefebvre & Poulin 2000, section 3, as the start: a mask of early wood, its share and colours, and how the rings run. A
picture as clean as a drawing is fitted to the pixel (:mod:`jaxtex.fitting.wood_drawn`); on a photograph the grain is
followed first, and its rings are counted (:mod:`jaxtex.fitting.wood_grain`, :mod:`jaxtex.fitting.wood_count`).
"""

import dataclasses
import time
from collections.abc import Callable, Mapping
from typing import Any

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray
from skimage import transform

from jaxtex.core.errors import InputError
from jaxtex.fitting.rings import GEOMETRY, Held, canonical_rings, model_count
from jaxtex.fitting.verdict import mean_iou
from jaxtex.fitting.wood_choices import hold_wood
from jaxtex.fitting.wood_count import fit_count
from jaxtex.fitting.wood_detail import read_fibres, read_gradation, smooth_displacement, sum_cosines
from jaxtex.fitting.wood_drawn import read_drawn
from jaxtex.fitting.wood_grain import Grain, read_grain
from jaxtex.fitting.wood_outcome import (
    Seen,
    find_inner_wood,
    is_early,
    measure_displacement,
    read_colours,
    read_displacement,
    standard_errors,
    what_is_told,
    wood_of,
)
from jaxtex.models.wood import Wood, make_wood
from jaxtex.photo.automask import check_surface
from jaxtex.photo.directions import measure_directions, smooth_along
from jaxtex.photo.evidence import shrink
from jaxtex.photo.grain import find_early_wood, flatten_light

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

WORKING_SIZE = 512
_FEWEST = 0.02  # share of either kind of wood, at least
_FARTHEST = 0.08  # of the picture's longer side: displacement that makes a figure of a trunk's rings, at most
_FLAT = 0.5  # lightness, of 100: less contrast is none
_DRAWN = 0.97  # overlap of a mask with itself smoothed along the grain: photographs have pores and speckles
_GRAINY = 0.6  # how well edges follow the grain, at least
_CROSSED = 0.014  # share of edges that run across the grain, at most

Report = Callable[[float, float], None]


@dataclasses.dataclass(frozen=True, eq=False)
class WoodFit:
    """What :func:`fit_wood` found.

    ``ok`` is False where the picture shows no wood of one piece; ``reason`` says why, and the other entries are the
    best guess. ``wood``: the model, in pixels of the photograph. ``mask`` [H, W]: the observed mask, True on early
    wood. ``rings`` [H, W]: those seen, counted as the model counts them, turbulence and uneven widths included.
    ``displacement`` [H, W]: by how many pixels these lie further out than the model's without turbulence. ``clear``
    [H, W]: where the rings can be trusted: no knots, no cracks. ``iou``: intersection over union of observed and
    modelled mask, mean of both kinds of wood, without displacement and with the smooth one that the model has.
    ``standard_errors``: one standard deviation, by parameter; None where the picture does not tell. ``determined``:
    whether it does. ``covariance`` (6, 6): of xc, yc (pixels), tilt, rotation (radians), and the logarithms of the
    spacing and of the odds of early wood. ``seconds`` spent, by step.
    """

    ok: bool
    reason: str
    wood: Wood
    mask: Mask
    rings: NDArray[np.float32]
    displacement: NDArray[np.float32]
    clear: Mask
    iou: tuple[float, float]
    standard_errors: dict[str, Any]
    determined: dict[str, bool]
    covariance: Floats
    seconds: dict[str, float]


def fit_wood(
    photo: NDArray[np.floating],
    *,
    mask: NDArray[np.bool_] | None = None,
    fix: Mapping[str, float] | None = None,
    ellipse_center: tuple[float, float] | None = None,
    report: Report | None = None,
) -> WoodFit:
    """Fit wood to a photograph of a plank, straight-grained, flat-sawn or end grain.

    Parameters
    ----------
    photo
        Linear [H, W], [H, W, 1] or [H, W, 3], at least 32 x 32.
    mask
        The user's own mask [H, W], True on early wood (the lighter), in place of the automatic one.
    fix
        Parameters held at given values: ``xc``, ``yc``, ``ring_spacing`` (pixels of the photograph), ``tilt_deg``,
        ``rotation_deg``, ``early_fraction``.
    ellipse_center
        Where in the photograph (x, y) the rings' ellipses have their middle, as in the paper's section 3.5.
    report
        Called with (done, total) as the work goes on.

    Raises
    ------
    InputError
        A picture or mask of the wrong shape, too small, or not finite; a mask with one kind of wood only; an unknown
        parameter or a value out of range.

    Examples
    --------
    >>> import numpy as np
    >>> v, u = np.mgrid[0:160, 0:160] - 79.5
    >>> plank = 0.2 + 0.3 * (np.sin(2 * np.pi * np.hypot(u - 20, 0.3 * v + 30) / 16) > 0)
    >>> fit = fit_wood(plank)
    >>> fit.ok, round(float(fit.wood.ring_spacing), 1), round(abs(float(fit.wood.center[0])))
    (True, 16.0, 20)
    """
    tell = report or (lambda done, total: None)
    clock = _Clock()
    tell(0, 3)
    picture = check_surface(photo)
    working = shrink(picture, WORKING_SIZE)
    scale = max(picture.shape[:2]) / max(working.shape[:2])
    light = flatten_light(working) if mask is None else _as_light(mask, picture.shape[:2])
    held, pith = hold_wood(fix or {}, ellipse_center, shape=picture.shape[:2], scale=scale)
    early = find_early_wood(picture) if mask is None else np.asarray(mask) > 0.5
    if mask is not None and not _FEWEST < early.mean() < 1 - _FEWEST:
        raise InputError("the mask holds one kind of wood only; early wood is to be white, late wood black")
    if light.std() < _FLAT or not _FEWEST < early.mean() < 1 - _FEWEST:
        return _nothing(picture, early, "the picture is all of one lightness: no rings are to be seen", clock)
    tell(1, 3)
    seen = _read_if_drawn(shrink(early.astype(np.float32), WORKING_SIZE).astype(float), held, pith)
    reason = ""
    if seen is None:
        grain, seen = _read_board(light, held, pith)
        reason = _judge(grain)
        early = early if mask is not None else _enlarge(grain.early, picture.shape[:2])
    clock.note("rings")
    tell(2, 3)
    fit = _describe(picture, flatten_light(working), seen, early, scale, clock)
    tell(3, 3)
    return dataclasses.replace(fit, ok=not reason, reason=reason)


def _read_if_drawn(early: Floats, held: Held, pith: tuple[float, float] | None) -> Seen | None:
    """Rings to the pixel, from a mask (H, W) without pores and speckles; else None."""
    smooth = smooth_along(early, measure_directions(early - early.mean(), 1.5, reach=6.0), 6.0)
    if mean_iou(early > 0.5, smooth > 0.5) < _DRAWN:
        return None
    return read_drawn(early, held, pith)


def _read_board(light: Floats, held: Held, pith: tuple[float, float] | None) -> tuple[Grain, Seen]:
    """Rings as a photograph shows them: turning back where they seem to, unless no trunk has such rings."""
    grain = read_grain(light, across=held.get(3), middle=pith)
    seen = _read_photographed(grain, held)
    if grain.folded and pith is None and seen.turbulence[0] > _FARTHEST * max(light.shape):
        grain = read_grain(light, across=held.get(3), figured=False)
        seen = _read_photographed(grain, held)
    return grain, seen


def _read_photographed(grain: Grain, held: Held) -> Seen:
    """Rings as a photograph tells them: counted, and displaced as they may be."""
    counted = fit_count(grain, held)
    share = float(np.clip(grain.early.mean(), 1e-3, 1 - 1e-3))
    logit = held.get(GEOMETRY, float(np.log(share / (1 - share))))
    covariance = np.zeros((GEOMETRY + 1,) * 2)
    covariance[:GEOMETRY, :GEOMETRY] = counted.covariance
    rings = max(float(np.ptp(counted.rings)), 1.0)
    covariance[GEOMETRY, GEOMETRY] = 0.0 if GEOMETRY in held else 1 / (rings * share * (1 - share))
    free, signs = canonical_rings(np.append(counted.free, logit))
    displacement = read_displacement(counted.rings, free)
    turbulence = measure_displacement(displacement, grain.clear)
    return Seen(grain.early, free, covariance * np.outer(signs, signs), counted.rings, grain.clear, turbulence)


def _judge(grain: Grain) -> str:
    """Why the grain is not that of one piece of wood; empty where it is."""
    if grain.pith is not None and grain.across is None:
        return ""
    if grain.agreement < _GRAINY:
        return "nothing in the picture runs like the grain of wood"
    if grain.crossing > _CROSSED:
        return "edges run across the grain: this may be a floor (jaxtex fit floor), a wall or tiles (jaxtex fit tiling)"
    return ""


def _describe(
    picture: NDArray[np.float32], light: Floats, seen: Seen, early: Mask, scale: float, clock: "_Clock"
) -> WoodFit:
    shape = picture.shape[:2]
    rings = _enlarge(seen.rings, shape)
    displacement = read_displacement(seen.rings, seen.free) * scale
    logit = float(seen.free[GEOMETRY])
    inner = find_inner_wood(rings, logit)
    wood = wood_of(seen.free, seen.turbulence, read_colours(picture, inner, early), scale=scale)
    field = smooth_displacement(displacement, seen.clear, wood, scale=scale)
    gradation, _ = read_gradation(light, seen.rings, seen.clear, float(wood.early_fraction))
    wood = dataclasses.replace(
        wood,
        gradation=jnp.asarray(gradation),
        fibres=read_fibres(picture, inner),
        displacement=field if seen.turbulence[0] > 0 else None,
    )
    errors = standard_errors(seen, scale=scale)
    unit = np.array([scale, scale, 1.0, 1.0, 1.0, 1.0])
    rigid = model_count(seen.free, seen.rings.shape)
    displaced = rigid + sum_cosines(field, seen.rings.shape) / float(wood.ring_spacing)
    overlaps = [mean_iou(seen.early, is_early(each, logit)) for each in (rigid, displaced)]
    clock.note("description")
    return WoodFit(
        ok=True,
        reason="",
        wood=wood,
        mask=early,
        rings=rings.astype(np.float32),
        displacement=_enlarge(displacement, shape).astype(np.float32),
        clear=_enlarge(seen.clear, shape),
        iou=(overlaps[0], overlaps[1]),
        standard_errors=errors,
        determined=what_is_told(errors, wood),
        covariance=seen.covariance * np.outer(unit, unit),
        seconds=clock.seconds,
    )


class _Clock:
    """Seconds spent, step by step."""

    def __init__(self) -> None:
        self.began = time.perf_counter()
        self.seconds: dict[str, float] = {}

    def note(self, step: str) -> None:
        now = time.perf_counter()
        self.seconds[step], self.began = now - self.began, now


def _as_light(mask: NDArray[np.bool_], shape: tuple[int, ...]) -> Floats:
    """A user's mask as the lightness (H, W) that would give it, at working size."""
    mask = np.asarray(mask)
    if mask.shape != shape:
        raise InputError(f"the mask has shape {mask.shape}; it must be that of the photograph, {shape}")
    light = 20.0 * shrink((mask > 0.5).astype(np.float32), WORKING_SIZE).astype(float)
    return light - light.mean()


def _enlarge(each: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    if each.shape == tuple(shape):
        return each
    if each.dtype == bool:
        return transform.resize(each.astype(float), shape, order=1) > 0.5
    return transform.resize(each, shape, order=1)


def _nothing(picture: NDArray[np.float32], early: Mask, reason: str, clock: _Clock) -> WoodFit:
    """No guess at all: rings as wide as the picture, all of its one colour."""
    colour = np.broadcast_to(np.clip(picture.mean(axis=(0, 1)), 0, None), 3)
    wood = make_wood(ring_spacing=float(max(early.shape)), early_rgb=colour, late_rgb=colour)
    nowhere = np.zeros(early.shape, np.float32)
    errors: dict[str, Any] = dict.fromkeys(("tilt_deg", "rotation_deg", "ring_spacing", "early_fraction"))
    errors = {"center": [None, None], **errors}
    clock.note("rings")
    determined = what_is_told(errors, wood) | {"turbulence_rms": False}
    return WoodFit(
        ok=False,
        reason=reason,
        wood=wood,
        mask=early,
        rings=nowhere,
        displacement=nowhere,
        clear=np.zeros(early.shape, bool),
        iou=(0.0, 0.0),
        standard_errors=errors,
        determined=determined,
        covariance=np.full((GEOMETRY + 1,) * 2, np.inf),
        seconds=clock.seconds,
    )
