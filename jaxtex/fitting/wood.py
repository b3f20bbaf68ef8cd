"""Picture of wood -> fitted wood: the whole way, step by step.

Lefebvre & Poulin 2000, section 3, as the start: a mask of early wood, its share and colours, and the spectrum; but the
spectrum piece by piece, so that tilt and axis follow from how the rings bend. Then the rings are counted, and the model
is fitted to the mask by least squares.
"""

import dataclasses
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from skimage import transform

from jaxtex.core.errors import InputError
from jaxtex.fitting.rings import GEOMETRY, canonical_rings
from jaxtex.fitting.verdict import mean_iou
from jaxtex.fitting.wood_phase import compare_rings, follow_rings
from jaxtex.fitting.wood_solve import Rings, fit_mask
from jaxtex.fitting.wood_start import list_starts
from jaxtex.models.wood import Wood, make_wood
from jaxtex.photo.automask import check_surface
from jaxtex.photo.evidence import shrink
from jaxtex.photo.grain import find_early_wood

Floats = NDArray[np.float64]

WORKING_SIZE = 512
_FOUND = 0.1  # share of the mask's variance left, below which no other start is looked for
_TRIED = 2  # starts of each batch whose mask is fitted
_NOT_WOOD = 0.75  # share left above which nothing has been found
_FEWEST = 0.02  # share of either kind of wood, at least

Report = Callable[[float, float], None]


@dataclasses.dataclass(frozen=True, eq=False)
class WoodFit:
    """What :func:`fit_wood` found.

    ``ok`` is False where the picture shows no rings, or none that the model could follow; ``reason`` says why, and the
    other entries are the best guess. ``wood``: the model, in pixels of the photograph. ``mask`` [H, W]: the observed
    mask, 1 on early wood. ``displacement`` [H, W]: by how many pixels the observed rings lie further out than those of
    the model without turbulence. ``iou``: intersection over union of observed and modelled mask, mean of both kinds of
    wood, without and with that displacement. ``standard_errors``: one standard deviation, by parameter.
    ``covariance`` (6, 6): of xc, yc, tilt, rotation (radians), and the logarithms of spacing and of the odds of early
    wood. ``seconds`` spent.
    """

    ok: bool
    reason: str
    wood: Wood
    mask: NDArray[np.bool_]
    displacement: NDArray[np.float32]
    iou: tuple[float, float]
    standard_errors: dict[str, float]
    covariance: Floats
    seconds: dict[str, float]


def fit_wood(
    photo: NDArray[np.floating], *, mask: NDArray[np.bool_] | None = None, report: Report | None = None
) -> WoodFit:
    """Fit wood to a photograph of a plank, straight-grained, flat-sawn or end grain.

    Parameters
    ----------
    photo
        Linear [H, W], [H, W, 1] or [H, W, 3], at least 32 x 32.
    mask
        The user's own mask [H, W], True on early wood (the lighter), in place of the automatic one.
    report
        Called with (done, total) as the work goes on.

    Raises
    ------
    InputError
        A picture or mask of the wrong shape, too small, or not finite; a mask with one kind of wood only.

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
    began = time.perf_counter()
    tell(0, 3)
    picture = check_surface(photo)
    early = find_early_wood(picture) if mask is None else _check_mask(mask, picture.shape[:2])
    working = shrink(early.astype(np.float32), WORKING_SIZE).astype(float)
    scale = max(early.shape) / max(working.shape)
    share = float(working.mean())
    if not _FEWEST < share < 1 - _FEWEST:
        return _nothing(picture, early, "the picture shows one kind of wood only, if it is wood", began)
    tell(1, 3)
    rings = _find_rings(working)
    tell(2, 3)
    if rings is None:
        return _nothing(picture, early, "nothing in the picture repeats like rings", began)
    displacement, clear, iou = _displace(working, rings)
    colours = _read_colours(picture, early)
    wood, errors = _describe(rings, _read_turbulence(displacement, clear), colours, scale)
    ok = rings.unexplained < _NOT_WOOD
    reason = "" if ok else f"its rings explain only {1 - rings.unexplained:.0%} of what is light and dark"
    tell(3, 3)
    return WoodFit(
        ok=ok,
        reason=reason,
        wood=wood,
        mask=early,
        displacement=(transform.resize(displacement, early.shape, order=1) * scale).astype(np.float32),
        iou=iou,
        standard_errors=errors,
        covariance=rings.covariance,
        seconds={"all": time.perf_counter() - began},
    )


def _find_rings(early: Floats) -> Rings | None:
    """The best rings for a mask of early wood (H, W): start after start, until one explains the mask."""
    share = float(early.mean())
    logit = np.log(share / (1 - share))
    best: Rings | None = None
    for starts in list_starts(early - share):
        followed = sorted((follow_rings(early - share, start) for start in starts), key=lambda each: -each[1])
        for free, _ in followed[:_TRIED]:
            rings = fit_mask(early, np.append(free[:GEOMETRY], logit))
            if np.isfinite(rings.free).all() and (best is None or rings.unexplained < best.unexplained):
                best = rings
        if best is not None and best.unexplained < _FOUND:
            break
    if best is None:
        return None
    free, signs = canonical_rings(best.free)
    return best._replace(free=free, covariance=best.covariance * np.outer(signs, signs))


def _displace(early: Floats, rings: Rings) -> tuple[Floats, NDArray[np.bool_], tuple[float, float]]:
    """How far the observed rings lie outside the fitted ones (H, W), pixels; where that is clear (H, W), away from the
    border and the pith; and the IoU without and with it."""
    spacing = float(np.exp(rings.free[4]))
    off, strength, count = compare_rings(early - early.mean(), rings.free, blur=0.5 * spacing)
    # Where no ring is seen, its neighbours tell.
    weight = ndimage.gaussian_filter(strength**2, spacing) + 1e-9
    smooth = ndimage.gaussian_filter(off * strength**2, spacing) / weight
    fraction = 1 / (1 + np.exp(-rings.free[5]))
    modelled = [np.sin(2 * np.pi * each) > np.cos(np.pi * fraction) for each in (count, count + smooth)]
    clear = np.zeros(early.shape, bool)
    margin = min(int(spacing), min(early.shape) // 4)
    clear[margin:-margin, margin:-margin] = True
    # Where rings pass slowly, the blur that parts them from their mirror image is too small.
    slope = np.hypot(*np.gradient(count)) * spacing
    clear &= (count > 2.0) & (slope > 0.7) & (strength > 0.3 * strength.max())
    return smooth * spacing, clear, (mean_iou(early > 0.5, modelled[0]), mean_iou(early > 0.5, modelled[1]))


def _read_colours(picture: NDArray[np.float32], early: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Linear colours (3,) of early and late wood: the middle half of each, away from their borders (section 3.1)."""
    return _middle_colour(picture, early, dark=False), _middle_colour(picture, ~early, dark=True)


def _middle_colour(picture: NDArray[np.float32], mask: NDArray[np.bool_], *, dark: bool) -> Floats:
    inner = ndimage.binary_erosion(mask, iterations=1)
    pixels = picture[inner if inner.sum() > 100 else mask]
    light = pixels.mean(axis=1)
    # The borders between both kinds are mixed: the paper's quartiles lie well inside each of them.
    pure = light <= np.median(light) if dark else light >= np.median(light)
    return np.broadcast_to(np.median(pixels[pure], axis=0), 3).astype(float)


def _describe(
    rings: Rings, turbulence: tuple[float, float], colours: tuple[Floats, Floats], scale: float
) -> tuple[Wood, dict[str, float]]:
    """The fitted wood in pixels of the photograph, and its standard errors."""
    xc, yc, tilt, rotation, log_spacing, logit = rings.free
    spacing, fraction = np.exp(log_spacing) * scale, 1 / (1 + np.exp(-logit))
    rms, frequency = turbulence
    wood = make_wood(
        center=(xc * scale, yc * scale),
        tilt=tilt,
        rotation=rotation,
        ring_spacing=spacing,
        early_fraction=fraction,
        early_rgb=colours[0],
        late_rgb=colours[1],
        turbulence_rms=rms * scale,
        turbulence_frequency=frequency / scale,
    )
    sigma = np.sqrt(np.maximum(np.diag(rings.covariance), 0.0))
    units: dict[str, Any] = {
        "xc": scale,
        "yc": scale,
        "tilt_deg": np.degrees(1.0),
        "rotation_deg": np.degrees(1.0),
        "ring_spacing": spacing,
        "early_fraction": fraction * (1 - fraction),
    }
    return wood, {name: float(one * unit) for one, (name, unit) in zip(sigma, units.items(), strict=True)}


def _read_turbulence(displacement: Floats, clear: NDArray[np.bool_]) -> tuple[float, float]:
    """Root mean square (pixels) and mean frequency (cycles per pixel) of a displacement (H, W) where it is clear, its
    mean left aside."""
    if not clear.any():
        return 0.0, 0.0
    height, width = displacement.shape
    free = np.where(clear, displacement - displacement[clear].mean(), 0.0)
    power = np.abs(np.fft.rfft2(free * np.outer(np.hanning(height), np.hanning(width)))) ** 2
    radius = np.hypot(np.fft.fftfreq(height)[:, None], np.fft.rfftfreq(width)[None])
    return float(free[clear].std()), float((radius * power).sum() / max(float(power.sum()), 1e-30))


def _check_mask(mask: NDArray[np.bool_], shape: tuple[int, ...]) -> NDArray[np.bool_]:
    mask = np.asarray(mask)
    if mask.shape != shape:
        raise InputError(f"the mask has shape {mask.shape}; it must be that of the photograph, {shape}")
    return mask > 0.5


def _nothing(picture: NDArray[np.float32], early: NDArray[np.bool_], reason: str, began: float) -> WoodFit:
    """No guess at all: rings as wide as the picture."""
    wood = make_wood(ring_spacing=float(max(early.shape)), early_rgb=(0.5,) * 3, late_rgb=(0.2,) * 3)
    nowhere = np.zeros(early.shape, np.float32)
    seconds = {"all": time.perf_counter() - began}
    return WoodFit(False, reason, wood, early, nowhere, (0.0, 0.0), {}, np.zeros((6, 6)), seconds)
