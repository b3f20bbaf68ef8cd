"""What a photograph shows of wood beyond its rings: how gradually late wood comes on, fibres and pores, and the smooth
displacement of the rings that were counted."""

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray
from scipy import fft, ndimage

from jaxtex.models.wood import Wood, early_share
from jaxtex.models.wood_detail import Displacement, Fibres
from jaxtex.photo.directions import measure_directions, smooth_along
from jaxtex.photo.pictures import lightness

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_ALONG = 16  # cosines along the grain
_MOST_COSINES = 2048
_PHASES = 48  # places in a ring at which its profile is measured
_BLURS = np.geomspace(0.02, 0.2, 8)  # rings: how soft a photograph may show the sharp edge
_GRADATIONS = np.linspace(0.0, 0.25, 11)
_CLOSE = 256  # pixels along a side of the piece in which fibres are measured
_REACH = 16.0  # pixels along the grain over which fibres are averaged out
_LAGS = 16  # pixels across the grain at most, in which fibres' breadth is read
_HALF = 0.5
_SMOOTH = 0.005  # contrast: fibres of less are none
_MOST_PORES = 0.2
_STRONGEST = 0.2  # contrast of fibres: what is stronger is no grain
_OUTLIER = -2.5  # standard deviations: darker is a pore
_NORMAL = 0.0062  # share of those where there are none


def read_gradation(light: Floats, rings: Floats, clear: Mask, fraction: float) -> tuple[float, float]:
    """How gradually late wood comes on, a standard deviation in rings, in a picture's lightness (H, W); and how much
    of that lightness rings explain which end so."""
    told = clear & np.isfinite(rings)
    number = ((rings[told] % 1) * _PHASES).astype(int) % _PHASES
    count = np.bincount(number, minlength=_PHASES)
    if count.min() == 0:
        return 0.0, 0.0
    profile = np.bincount(number, weights=light[told], minlength=_PHASES) / count
    places = (np.arange(_PHASES) + 0.5) / _PHASES
    blur, gradation = (each[:, None] for each in np.stack(np.meshgrid(_BLURS, _GRADATIONS), -1).reshape(-1, 2).T)
    shapes = np.asarray(early_share(places[None], fraction, blur, gradation), float)
    shapes = shapes - shapes.mean(1, keepdims=True)
    # Each shape as strong as it fits best: what is then left is least where it explains most.
    explained = np.maximum(shapes @ (profile - profile.mean()), 0) / np.linalg.norm(shapes, axis=1)
    best = int(np.argmax(explained))
    return float(gradation[best, 0]), float(explained[best])


def read_fibres(picture: NDArray[np.float32], inner: tuple[Mask, Mask]) -> Fibres | None:
    """The fibres in the middle of a linear picture (H, W, C), as fine as it shows them; None where wood is smooth.

    They are what differs along the grain, away from the borders of rings: on ``inner`` early and late wood (H, W).
    Streaks much longer than the reach of that, some of the model's own among them, are left to the rings: seen once too
    seldom, fibres look better than seen twice.
    """
    height, width = picture.shape[:2]
    near = np.s_[tuple(slice((n - min(n, _CLOSE)) // 2, (n + min(n, _CLOSE)) // 2) for n in (height, width))]
    light = np.log(np.maximum(picture[near].mean(axis=2, dtype=float), 1e-4))
    directions = measure_directions(lightness(picture[near]).astype(float), 2.0)
    fine = light - smooth_along(light, directions, _REACH)
    parts = [fine[each[near]] for each in inner]
    seen = np.concatenate(parts)
    if len(seen) == 0:
        return None
    spread = float(np.median(np.abs(seen))) / 0.6745
    if spread < _SMOOTH:
        return None
    breadth = _measure_breadth(np.clip(fine, -3 * spread, 3 * spread), np.angle(directions.across) / 2)
    pores = [float(np.mean(each < _OUTLIER * spread)) - _NORMAL if len(each) else 0.0 for each in parts]
    return Fibres(
        contrast=jnp.asarray(min(spread, _STRONGEST)),
        width=jnp.asarray(max(breadth, 1.0)),
        pores=jnp.asarray(np.clip(pores, 0.0, _MOST_PORES), float),
    )


def _measure_breadth(fine: Floats, across: Floats) -> float:
    """Pixels across the grain, whose direction is ``across`` (H, W), that streaks (H, W) are broad."""
    place, heading = np.indices(fine.shape).astype(float), np.stack([np.sin(across), np.cos(across)])
    before, power = 1.0, float((fine**2).mean())
    for lag in range(1, _LAGS):
        alike = (
            float((ndimage.map_coordinates(fine, place + lag * heading, order=1, mode="mirror") * fine).mean()) / power
        )
        if alike < _HALF:
            # The correlation of smoothed noise has fallen to a half at half a breadth.
            return 2 * (lag - (_HALF - alike) / (before - alike))
        before = alike
    return 2.0 * _LAGS


def smooth_displacement(displacement: Floats, clear: Mask, wood: Wood, *, scale: float) -> Displacement:
    """The cosine series nearest to a displacement (H, W) in pixels of the model, at places ``scale`` of them apart.

    Across the grain, where rings are uneven, it has finer waves than along it. Where the displacement is not clear,
    what is nearest counts.
    """
    height, width = displacement.shape
    terms = _count_cosines(wood, np.array([height, width]), scale)
    if clear.any():
        nearest = ndimage.distance_transform_edt(~clear, return_distances=False, return_indices=True)
        displacement = displacement[tuple(nearest)]
    # Waves that the series has not would come back as ripples.
    smooth = ndimage.gaussian_filter(displacement, np.array([height, width]) / terms / 4)
    kept = fft.dctn(smooth, norm="forward")[: terms[0], : terms[1]]
    kept[1:] *= 2
    kept[:, 1:] *= 2
    extent = jnp.asarray([width * scale, height * scale], float)
    return Displacement(jnp.asarray(kept, float), extent, middle=jnp.zeros(2), turn=jnp.zeros(()))


def sum_cosines(field: Displacement, shape: tuple[int, ...]) -> Floats:
    """The displacement (H, W) all over its picture."""
    terms = np.asarray(field.cosines)
    down, right = (
        np.cos(np.pi * np.outer((np.arange(n) + 0.5) / n, np.arange(k)))
        for n, k in zip(shape, terms.shape, strict=True)
    )
    return down @ terms @ right.T


def _count_cosines(wood: Wood, sides: NDArray[np.int_], scale: float) -> NDArray[np.int_]:
    """How many cosines a displacement has down and to the right: two for each ring, and few along the grain."""
    turn, lean = float(wood.rotation), float(np.sin(wood.tilt))
    across = np.array([np.sin(turn), np.cos(turn)]) ** 2
    rings = 2 * sides * scale / float(wood.ring_spacing)
    wanted = _ALONG + (np.maximum(rings, _ALONG) - _ALONG) * (across + lean**2 * (1 - across))
    wanted *= min(1.0, np.sqrt(_MOST_COSINES / wanted.prod()))
    return np.clip(np.round(wanted).astype(int), 2, sides)
