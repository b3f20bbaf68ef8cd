"""What was seen of the rings -> the fitted `Wood`, its standard errors, and what the picture does not tell."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from jaxtex.fitting.rings import GEOMETRY, model_count
from jaxtex.models.wood import Wood, make_wood

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

# A parameter is determined where its standard error is at most this.
_TOLD = {"tilt_deg": 5.0, "rotation_deg": 5.0, "early_fraction": 0.1}
_TOLD_RINGS = {"center": 1.0, "ring_spacing": 0.1}  # in ring spacings


class Seen(NamedTuple):
    """What one of the ways of reading a picture (H, W) at working size came to.

    ``early`` (H, W): the mask of early wood; ``free`` (6,) as :mod:`jaxtex.fitting.rings` has it, canonical;
    ``covariance`` (6, 6), infinite for what the picture does not tell; ``rings`` (H, W): those seen, as the model
    counts them; ``clear`` (H, W): where that can be trusted; ``turbulence``: root mean square, pixels, and frequency,
    cycles per pixel, of the displacement.
    """

    early: Mask
    free: Floats
    covariance: Floats
    rings: Floats
    clear: Mask
    turbulence: tuple[float, float]


def is_early(count: Floats, logit: float) -> Mask:
    """Which places (H, W) are early wood, by their ring count and the logit of early wood's share."""
    return np.sin(2 * np.pi * count) > np.cos(np.pi / (1 + np.exp(-logit)))


def read_displacement(count: Floats, free: Floats) -> Floats:
    """What is added to the distance (H, W), pixels, that a vector's rings be those counted (H, W)."""
    return (count - model_count(free, count.shape)) * float(np.exp(free[4]))


def measure_displacement(displacement: Floats, clear: Mask) -> tuple[float, float]:
    """Root mean square (pixels) and mean frequency (cycles per pixel) of a displacement (H, W) where it is clear, its
    mean left aside."""
    if not clear.any():
        return 0.0, 0.0
    height, width = displacement.shape
    free = np.where(clear, displacement - displacement[clear].mean(), 0.0)
    power = np.abs(np.fft.rfft2(free * np.outer(np.hanning(height), np.hanning(width)))) ** 2
    radius = np.hypot(np.fft.fftfreq(height)[:, None], np.fft.rfftfreq(width)[None])
    return float(free[clear].std()), float((radius * power).sum() / max(float(power.sum()), 1e-30))


def find_inner_wood(rings: Floats, logit: float) -> tuple[Mask, Mask]:
    """The middle half of early and of late wood (H, W), by their count of rings (H, W)."""
    fraction = 1 / (1 + np.exp(-logit))
    aside = np.abs((rings - 0.25 + 0.5) % 1 - 0.5)
    return aside < 0.25 * fraction, aside > 0.25 + 0.25 * fraction


def read_colours(picture: NDArray[np.float32], inner: tuple[Mask, Mask], early: Mask) -> tuple[Floats, Floats]:
    """Linear colours (3,) of early and late wood in a picture (H, W, C): those of the middle half of each.

    Section 3.1 takes quartiles of lightness; these would count fibres as rings. Where the count of rings does not tell
    the lighter wood, the mask of ``early`` wood (H, W) does.
    """
    counted, masked = ([_colour_of(picture, each) for each in pair] for pair in (inner, (early, ~early)))
    light, dark = counted if counted[0].mean() > counted[1].mean() else masked
    return light, dark


def wood_of(free: Floats, turbulence: tuple[float, float], colours: tuple[Floats, Floats], *, scale: float) -> Wood:
    """The wood of a vector (6,) in pixels that are ``scale`` times as large as the photograph's."""
    xc, yc, tilt, rotation, log_spacing, logit = free
    rms, frequency = turbulence
    return make_wood(
        center=(xc * scale, yc * scale),
        tilt=tilt,
        rotation=rotation,
        ring_spacing=np.exp(log_spacing) * scale,
        early_fraction=1 / (1 + np.exp(-logit)),
        early_rgb=colours[0],
        late_rgb=colours[1],
        turbulence_rms=rms * scale,
        turbulence_frequency=frequency / scale,
    )


def standard_errors(seen: Seen, *, scale: float) -> dict[str, Any]:
    """One standard deviation of each parameter under its name in model files; None where the picture does not tell."""
    sigma = np.sqrt(np.maximum(np.diag(seen.covariance), 0.0))
    fraction = 1 / (1 + np.exp(-seen.free[GEOMETRY]))
    spacing = np.exp(seen.free[4]) * scale
    units = (scale, scale, np.degrees(1.0), np.degrees(1.0), spacing, fraction * (1 - fraction))
    xc, yc, tilt, rotation, spaced, early = (
        float(one * unit) if np.isfinite(one) else None for one, unit in zip(sigma, units, strict=True)
    )
    return {
        "center": [xc, yc],
        "tilt_deg": tilt,
        "rotation_deg": rotation,
        "ring_spacing": spaced,
        "early_fraction": early,
    }


def what_is_told(errors: dict[str, Any], wood: Wood) -> dict[str, bool]:
    """By a parameter's name, whether the picture tells it."""
    spacing = float(wood.ring_spacing)
    limits = _TOLD | {name: rings * spacing for name, rings in _TOLD_RINGS.items()}

    def told(name: str) -> bool:
        numbers = errors[name] if isinstance(errors[name], list) else [errors[name]]
        return all(number is not None and number <= limits[name] for number in numbers)

    turbulent = float(wood.turbulence_rms) > 0
    names = ("center", "tilt_deg", "rotation_deg", "ring_spacing", "early_fraction")
    return {name: told(name) for name in names} | {
        "early_rgb": True,
        "late_rgb": True,
        "turbulence_rms": True,
        "turbulence_frequency": turbulent,
    }


def _colour_of(picture: NDArray[np.float32], mask: Mask) -> Floats:
    pixels = picture[mask] if mask.any() else picture.reshape(-1, picture.shape[2])
    return np.broadcast_to(np.median(pixels, axis=0), 3).astype(float)
