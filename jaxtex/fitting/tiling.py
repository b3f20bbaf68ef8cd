"""Photograph of a tiled surface -> fitted tiling: the whole way, step by step.

Lefebvre & Poulin 2000, section 2, with the user's clicking replaced: evidence and a learnt mask (:mod:`jaxtex.photo`),
the paper's spectrum and scanlines as the start, and least squares on the mask as the end.
"""

import dataclasses
import time
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray
from skimage import transform

from jaxtex.core.errors import InputError
from jaxtex.fitting.choices import apply_choices, check_choices, check_joints
from jaxtex.fitting.joints import mask_iou, measure_distances, measure_thickness, see_joints
from jaxtex.fitting.outcome import count_tiles, standard_errors, tiling_of, tiling_seen
from jaxtex.fitting.refine import is_certain, refine_again, refine_coarsely, refine_finely
from jaxtex.fitting.start import Fitted, Start, start_fit, with_thickness
from jaxtex.fitting.verdict import judge_fit
from jaxtex.models.tiling import Tiling, make_tiling
from jaxtex.photo.automask import WORKING_SIZE, Reading, check_surface, glance_at_mask, read_tiling
from jaxtex.photo.evidence import Evidence, find_evidence, mask_evidence, shrink
from jaxtex.photo.lattice import Lattice, turn_upright
from jaxtex.photo.seamless import find_wrap

_STARTS = 8  # lattices worth a solve
_WORTH = 0.4  # this share below the best lattice's score is no longer worth one

Report = Callable[[float, float], None]


@dataclasses.dataclass(frozen=True, eq=False)
class TilingFit:
    """What :func:`fit_tiling` found.

    ``ok`` is False where the picture shows no rectangular tiling or none was found; ``reason`` says why, and the other
    entries are the best guess. ``tiling``: the model, in pixels of the photograph; ``start``: what the spectrum and the
    scanlines gave, before least squares. ``mask`` [H, W]: the observed mask, 1 on tiles. ``rows``, ``columns``: courses
    and tiles per course in the photograph. ``iou``: intersection over union of observed and rendered mask, mean of
    tiles and joints (where tiles meet without mortar, of the edges seen and of joints as thick as these).
    ``standard_errors``: one standard deviation of each parameter that was free, so not of those that were fixed or
    that follow from a seamless picture's own size. ``evidence``: typical contrast of the
    predicted bed and head joints in the mask. ``seconds`` spent, by step.
    """

    ok: bool
    reason: str
    tiling: Tiling
    start: Tiling
    mask: NDArray[np.float32]
    rows: int
    columns: int
    iou: float
    standard_errors: dict[str, float]
    evidence: dict[str, float]
    seconds: dict[str, float]


def fit_tiling(
    photo: NDArray[np.floating],
    *,
    mask: NDArray[np.floating] | None = None,
    perspective: bool = True,
    fix: Mapping[str, float] | None = None,
    init: Mapping[str, float] | None = None,
    report: Report | None = None,
) -> TilingFit:
    """Fit a tiling to a photograph of a tiled wall, floor or facade.

    Parameters
    ----------
    photo
        Linear [H, W], [H, W, 1] or [H, W, 3], at least 32 x 32; any orientation and moderate perspective.
    mask
        The user's own mask [H, W], 1 on tiles and 0 on joints, in place of the automatic one.
    perspective
        Whether the view may be found to be oblique; False keeps the homography at the identity.
    fix, init
        Parameters held at, or started from, given values, in the units of the model file: ``tile_width``,
        ``tile_height``, ``angle_deg``, ``mortar_x``, ``mortar_y``, ``offset``, ``origin_x``, ``origin_y``.
    report
        Called with (done, total) as the work goes on.

    Raises
    ------
    InputError
        A picture or mask of the wrong shape, too small, or not finite; an unknown parameter or a value out of range.

    Examples
    --------
    >>> import numpy as np
    >>> y, x = np.mgrid[0:128, 0:128] + 0.5
    >>> wall = 0.2 + 0.6 * ((y % 16 > 3) & ((x + 16 * (y // 16 % 2)) % 32 > 3))
    >>> fit = fit_tiling(wall)
    >>> fit.ok, fit.tiling.bond, round(float(fit.tiling.tile_height), 1)
    (True, 'running', 16.0)
    """
    tell = report or (lambda done, total: None)
    photo, mask = _check_picture(photo, mask)
    height, width = photo.shape[:2]
    check_choices(fix or {}, init or {}, (width, height))
    began = time.perf_counter()
    tell(0, 4)
    working = shrink(photo, WORKING_SIZE)
    evidence = find_evidence(working) if mask is None else mask_evidence(shrink(mask, WORKING_SIZE))
    # A picture that repeats both ways was made to be seen straight on.
    wraps = find_wrap(working) if mask is None else (False, False)
    tell(1, 4)

    def begin(reading: Reading) -> list[Start]:
        starts = _choose_starts(reading, (width, height), perspective and not all(wraps))
        return [apply_choices(start, (width, height), fix or {}, init or {}) for start in starts]

    reading, ended, ready = _search(evidence, begin, perspective=perspective, sharp=mask is not None)
    tell(2, 4)
    if not ended:
        return _nothing(photo.shape[:2], reading, "nothing in the picture repeats like courses of tiles")
    fitted = refine_finely(ended, reading.joint, wraps=wraps, sharp=mask is not None)
    refined = time.perf_counter()
    tell(3, 4)
    verdict = judge_fit(_seen(fitted, reading.joint), reading.joint)
    fitted, joint, iou = _look_again(fitted, reading.joint, None if mask is not None else evidence)
    tiling = tiling_of(fitted.free, fitted.start, (width, height))
    check_joints(tiling, fix or {})
    rows, columns = count_tiles(tiling, (width, height))
    tell(4, 4)
    return TilingFit(
        ok=verdict.ok,
        reason=_explain(verdict.reason, fix or {}, mask),
        tiling=tiling,
        start=tiling_of(fitted.start.first, fitted.start, (width, height)),
        mask=_enlarge(joint, (height, width)),
        rows=rows,
        columns=columns,
        iou=iou,
        standard_errors=standard_errors(fitted, tiling, (width, height)),
        evidence={"beds": verdict.beds, "heads": verdict.heads},
        seconds={"start": ready - began, "refine": refined - ready, "all": time.perf_counter() - began},
    )


def _search(
    evidence: Evidence, begin: Callable[[Reading], list[Start]], *, perspective: bool, sharp: bool
) -> tuple[Reading, list[Fitted], float]:
    """What was read, where its starts ended on the coarse level, and when the reading was ready."""
    if sharp:
        # Most masks tell their tiling at a glance.
        reading = glance_at_mask(evidence)
        ready = time.perf_counter()
        ended = refine_coarsely(begin(reading), reading.joint, sharp=True)
        if is_certain(ended):
            return reading, ended, ready
    reading = read_tiling(evidence, perspective=perspective, learn=not sharp)
    ready = time.perf_counter()
    return reading, refine_coarsely(begin(reading), reading.joint, sharp=sharp), ready


def _look_again(
    fitted: Fitted, joint: NDArray[np.float32], evidence: Evidence | None
) -> tuple[Fitted, NDArray[np.float32], float]:
    """The fit with joints as thick as the photograph's colours say, the map (H, W) of such joints, and their IoU.

    There is no ``evidence`` where the joints are those of the user's own mask.
    """
    seen = _seen(fitted, joint)
    if evidence is not None:
        distances = measure_distances(seen, joint.shape)
        thickness = measure_thickness(seen, distances, evidence)
        fitted = with_thickness(fitted, thickness)
        # Where tiles meet without mortar there is nothing to learn, and the mask goes on showing their edges.
        if min(thickness) > 0:
            joint = see_joints(distances, thickness, evidence)
            fitted = refine_again(fitted, joint)
            seen = _seen(fitted, joint)
    return fitted, joint, mask_iou(seen, joint)


def _seen(fitted: Fitted, joint: NDArray[np.float32]) -> Tiling:
    """The fitted tiling in the pixels of a map of joints (H, W)."""
    return tiling_seen(fitted.free, fitted.start, (joint.shape[1], joint.shape[0]))


def _explain(reason: str, fix: Mapping[str, float], mask: NDArray[np.float32] | None) -> str:
    """Why the fit did not succeed, with what the user may have had to do with it."""
    if reason and fix:
        reason += f"; held: {', '.join(f'{name}={value:g}' for name, value in fix.items())}"
    if reason and mask is not None and mask.mean() < 0.5:
        reason += "; most of the mask is joint (0, black): is it the wrong way round?"
    return reason


def _check_picture(
    photo: NDArray[np.floating], mask: NDArray[np.floating] | None
) -> tuple[NDArray[np.float32], NDArray[np.float32] | None]:
    photo = check_surface(photo)
    if mask is None:
        return photo, None
    mask = np.asarray(mask, np.float32)
    if mask.shape != photo.shape[:2]:
        raise InputError(f"the mask has shape {mask.shape}; it must be that of the photograph, {photo.shape[:2]}")
    if not np.isfinite(mask).all() or mask.min() < 0 or mask.max() > 1:
        raise InputError("the mask must lie between 0 (joint) and 1 (tile)")
    if mask.max() - mask.min() < 0.5:
        raise InputError("the mask is the same everywhere; it must be 1 on tiles and 0 on joints")
    return photo, mask


def _choose_starts(reading: Reading, size: tuple[int, int], perspective: bool) -> list[Start]:
    scale = max(reading.joint.shape) / max(size)
    working = (size[0] * scale, size[1] * scale)
    best = reading.lattices[0].score if reading.lattices else 0.0
    worth: list[Lattice] = []
    for lattice in map(turn_upright, reading.lattices):
        free = lattice.bond == "irregular"
        family = [other for other in worth if _same_courses(lattice, other)]
        # The likeliest courses may be laid in several bonds; others must not be crowded out by them.
        likeliest = not worth or bool(family and family[0] is worth[0])
        rivals = sum((other.bond == "irregular") == free for other in family)
        room = rivals < (1 if free else _STARTS // 2 if likeliest else 2)
        if lattice.score >= best - _WORTH * max(abs(best), 0.5) and room and not _alike(lattice, family):
            worth.append(lattice)
    return [start_fit(lattice, working, perspective=perspective) for lattice in worth[:_STARTS]]


def _same_courses(a: Lattice, b: Lattice) -> bool:
    turn = abs((a.angle - b.angle + np.pi / 2) % np.pi - np.pi / 2)
    return bool(turn < 0.02 and abs(np.log(a.height / b.height)) < 0.02 and np.abs(a.tilt - b.tilt).max() * 256 < 0.02)


def _alike(lattice: Lattice, family: list[Lattice]) -> bool:
    """Whether a lattice would be refined to what one of its family is."""
    return any(abs(np.log(lattice.width / other.width)) < 0.02 and lattice.bond == other.bond for other in family)


def _enlarge(joint: NDArray[np.float32], shape: tuple[int, int]) -> NDArray[np.float32]:
    return 1.0 - transform.resize(joint, shape, order=1).astype(np.float32)


def _nothing(shape: tuple[int, int], reading: Reading, reason: str) -> TilingFit:
    """No guess at all: one tile as large as the picture."""
    height, width = shape
    tile = make_tiling(tile_width=float(width), tile_height=float(height), bond="stack")
    mask = _enlarge(reading.joint, shape)
    return TilingFit(False, reason, tile, tile, mask, 1, 1, 0.0, {}, {"beds": 0.0, "heads": 0.0}, {})
