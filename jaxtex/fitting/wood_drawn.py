"""Rings as clean as a drawing's -> the model's numbers, to a fraction of a pixel.

Every pixel of the mask counts here. Where turbulence displaces the rings, that is estimated together with them.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from jaxtex.fitting.rings import GEOMETRY, Held, canonical_rings, hold, model_count
from jaxtex.fitting.verdict import mean_iou
from jaxtex.fitting.wood_displaced import fit_displaced
from jaxtex.fitting.wood_outcome import Seen, is_early
from jaxtex.fitting.wood_phase import compare_rings, follow_rings
from jaxtex.fitting.wood_solve import Rings, fit_mask
from jaxtex.fitting.wood_start import list_starts
from jaxtex.fitting.wood_turbulence import fit_turbulence
from jaxtex.photo.ring_lines import follow_lines

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_FOUND = 0.1  # share of the mask's variance left, below which no other start is looked for
_FOLLOWED = 0.82  # overlap of the mask with displaced rings, above which none is either,
_STRAYED = 0.25  # if these are displaced by less than so many rings
_STRAYING = 0.5  # of overlap, that a displacement by a ring costs
_STANDING = 0.25  # and all of what is unexplained without it
_LEANING = 0.02  # and a tilt by a right angle
_APART = np.array([2.0, 2.0, 0.01, 0.01, 0.01])  # rings that differ by less are the same
_MOVES = 4  # towards a given middle of the ellipses
_RIGID = 0.2  # pixels: rings displaced by less are not
_HOPELESS = 0.62  # overlap that none of the first starts has where there are no rings
_STEEPEST = 0.4  # pixels of displacement from one pixel to the next: displaced more steeply, any rings would do
_NO_TILT = 1e-6  # radians: none that could be seen, but a number
_SHORTER = 1.1  # times the frequency: turbulence that is, is fitted once more
_WORTH = 0.5  # merit, at least, of rings that may turn out to be the right ones,
_AGREED = 0.85  # by their overlap with the mask, once they are displaced as finely as it shows


class _Found(NamedTuple):
    """``rings``, those of the model; ``seen`` (H, W), which ring each place belongs to; ``clear`` (H, W), where that
    can be trusted; ``overlap`` of these with the mask; ``strayed``, by how many rings they typically differ."""

    rings: Rings
    seen: Floats
    clear: Mask
    overlap: float
    strayed: float

    def is_exact(self) -> bool:
        """Whether the rings explain the mask as they stand."""
        return self.rings.unexplained < _FOUND

    def is_good(self) -> bool:
        """Whether no other start need be looked for."""
        return self.overlap > _FOLLOWED and self.strayed < _STRAYED

    def worse_than(self, other: "_Found") -> bool:
        """Whether another explains the mask better as it stands; or else, once displaced and as it stands."""
        if self.is_exact() or other.is_exact():
            return other.rings.unexplained < self.rings.unexplained
        mine, others = (each.merit() - _STANDING * min(each.rings.unexplained, 1.0) for each in (self, other))
        return others > mine

    def merit(self) -> float:
        """The overlap, less what displacement is worth, since displaced far enough any rings would do, and less what
        a lean is worth, since straight rings show none."""
        return self.overlap - _STRAYING * self.strayed - _LEANING * abs(float(np.sin(self.rings.free[2])))


def read_drawn(early: Floats, held: Held, middle: tuple[float, float] | None) -> Seen | None:
    """Fit rings to a mask of early wood (H, W), 0 to 1; None where they do not explain it.

    The ``middle`` (u, v) of the rings' ellipses may be known.
    """
    asked = held  # the axis that a known middle means may turn its signs with the rest
    found = _find_rings(early, held)
    if found is not None and middle is not None:
        found, held = _move_to(early, found, held, middle)
    if found is None or found.merit() < _WORTH:
        return None
    free, covariance, turbulence, clear = found.rings.free, found.rings.covariance, (0.0, 0.0), found.clear
    # The blur that rings were looked at through took from their displacement; what is left is followed.
    seen = follow_lines(early - early.mean(), found.seen, float(np.exp(free[4])))
    fitted = fit_turbulence(seen, clear, free[:GEOMETRY], held)
    if fitted is not None:
        turbulence = fitted.rms, fitted.frequency
    while fitted is not None and fitted.rms > _RIGID:
        displaced = fit_displaced(early, seen, clear, fitted, float(free[GEOMETRY]), held)
        free, covariance, clear = displaced.free, displaced.covariance, displaced.believed
        turbulence = displaced.rms, fitted.frequency
        seen = model_count(free, early.shape) + displaced.displacement / np.exp(free[4])
        # Lines of wide rings show long waves only; once all of the mask has been fitted to, the short ones are seen.
        again = fit_turbulence(seen, clear, free[:GEOMETRY], held)
        fitted = again if again is not None and again.frequency > _SHORTER * fitted.frequency else None
    if mean_iou(early > 0.5, is_early(seen, free[GEOMETRY])) < _AGREED:
        return None
    written, signs = canonical_rings(_turn_over(free, asked))
    if 2 not in asked and any(signs[n] < 0 for n in asked):
        # Written with a positive tilt it would change its sign: as near as it comes to that is no tilt.
        return read_drawn(early, {**asked, 2: _NO_TILT}, middle)
    return Seen(
        early=early > 0.5,
        free=written,
        covariance=covariance * np.outer(signs, signs),
        rings=seen,
        clear=clear,
        turbulence=turbulence,
    )


def _turn_over(free: Floats, held: Held) -> Floats:
    """The vector (6,) with its rotation in [0, pi), the plank turned over rather than a held yc."""
    if 1 not in held:
        return free
    xc, yc, tilt, rotation, *rest = free
    turns = int(rotation // np.pi)
    sense = -1.0 if turns % 2 else 1.0
    tilt = held.get(2, float(np.arcsin(np.sin(sense * tilt))))
    return np.array([sense * xc, yc, tilt, rotation - turns * np.pi, *rest])


def _find_rings(early: Floats, held: Held) -> _Found | None:
    """The best rings for a mask of early wood (H, W): start after start, until one explains the mask."""
    share = float(early.mean())
    logit = held.get(GEOMETRY, float(np.log(share / (1 - share))))
    best: _Found | None = None
    tried: list[Floats] = []
    for number, starts in enumerate(list_starts(early - share, held)):
        for start in starts:
            free = follow_rings(early - share, start, held)
            if any((np.abs(free - other) < _APART).all() for other in tried):
                continue
            tried.append(free)
            found = _try(early, np.append(free, logit), held)
            if found is not None and (best is None or best.worse_than(found)):
                best = found
            if best is not None and best.is_exact():
                return best
        # Straight rings with a little turbulence look like those around a pith: both kinds of starts are compared.
        if number == 1 and (best is None or best.is_good() or best.overlap < _HOPELESS):
            break
    return best


def _move_to(early: Floats, found: _Found, held: Held, middle: tuple[float, float]) -> tuple[_Found, Held]:
    """The rings found, moved until their ellipses have a given middle (u, v), and the axis held that this means."""
    for _ in range(_MOVES):
        free = found.rings.free
        c, s, lean = np.cos(free[3]), np.sin(free[3]), np.sin(free[2])
        axis = {0: middle[0] * c + middle[1] * s, 1: lean * (middle[1] * c - middle[0] * s)}
        placed = follow_rings(early - early.mean(), hold(free[:GEOMETRY], axis), {**held, **axis})
        found = _try(early, np.append(placed, free[GEOMETRY]), {**held, **axis}) or found
    return found, {**held, **axis}


def _try(early: Floats, free: Floats, held: Held) -> _Found | None:
    """The rings of a vector (6,) on the mask: as they stand where that explains it, else displaced."""
    rings = fit_mask(early, free, held)
    if not np.isfinite(rings.free).all() or rings.unexplained > _FOUND:
        # Least squares on the mask may have left the rings that were followed.
        rings = rings._replace(free=free)
    if not np.isfinite(free).all():
        return None
    spacing = float(np.exp(rings.free[4]))
    off, strength, count = compare_rings(early - early.mean(), rings.free, blur=0.5 * spacing)
    # Where no ring is seen, its neighbours tell.
    weight = ndimage.gaussian_filter(strength**2, spacing) + 1e-9
    off = ndimage.gaussian_filter(off * strength**2, spacing) / weight
    if np.median(np.hypot(*np.gradient(off))) * spacing > _STEEPEST:
        return None
    seen = count + off
    overlap = mean_iou(early > 0.5, is_early(seen, rings.free[GEOMETRY]))
    return _Found(rings, seen, _where_clear(strength, count, spacing), overlap, float(off.std()))


def _where_clear(strength: Floats, count: Floats, spacing: float) -> Mask:
    """Where the count can be trusted (H, W): away from the border and the pith, and where rings pass fast enough."""
    clear = np.zeros(count.shape, bool)
    margin = max(1, min(int(spacing), min(count.shape) // 4))
    clear[margin:-margin, margin:-margin] = True
    # Where rings pass slowly, the blur that parts them from their mirror image is too small.
    slope = np.hypot(*np.gradient(count)) * spacing
    return clear & (count > 2.0) & (slope > 0.7) & (strength > 0.3 * strength.max())
