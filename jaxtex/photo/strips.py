"""A map of likely joints, resampled along the courses of one family."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from jaxtex.photo.courses import Courses, Map

_HARMONICS = 4
_PHASES = 96
_LONGEST = 360  # samples along the longer side


class Strips(NamedTuple):
    """A map laid out along its courses.

    ``values`` (rows q_y, columns q_x), zero mean, 0 outside the picture; ``inside``, 1 where the picture is; samples
    ``spacing`` apart from ``corner`` (q_x, q_y); bed joints at ``bed + j height``.
    """

    values: Map
    inside: Map
    corner: NDArray[np.float64]
    spacing: float
    bed: float
    height: float


def lay_strips(joints: Map, courses: Courses) -> Strips:
    """Resample a map (H, W) along the courses, and place the bed joints by the phase of its row means."""
    height, width = joints.shape
    d = np.array([np.cos(courses.angle), np.sin(courses.angle)])
    n = np.array([-d[1], d[0]])
    low, high = _extent(width, height, courses.tilt, d, n)
    spacing = max(1.0, float((high - low).max()) / _LONGEST)
    qx, qy = np.meshgrid(np.arange(low[0], high[0], spacing), np.arange(low[1], high[1], spacing))
    px, py = qx * d[0] + qy * n[0], qx * d[1] + qy * n[1]
    depth = 1.0 - (px * courses.tilt[0] + py * courses.tilt[1])
    safe = np.where(depth > 0.2, depth, np.inf)
    x, y = px / safe + width / 2 - 0.5, py / safe + height / 2 - 0.5
    inside = (depth > 0.2) & (x > 0) & (y > 0) & (x < width - 1) & (y < height - 1)
    smooth = ndimage.gaussian_filter(joints, 0.4 * spacing) if spacing > 1 else joints
    values = ndimage.map_coordinates(smooth, [y, x], order=1, mode="nearest")
    values = np.where(inside, values - values[inside].mean(), 0.0).astype(np.float32)
    pitch, bed = _place_beds(values, inside, low[1], spacing, courses.height)
    return Strips(values, inside.astype(np.float32), low, spacing, bed, pitch)


def _extent(width: int, height: int, tilt: NDArray, d: NDArray, n: NDArray) -> tuple[NDArray, NDArray]:
    """Bounds of the picture in (q_x, q_y)."""
    t = np.linspace(-1, 1, 17)
    sides = [np.stack([t, np.full(17, s)], 1) for s in (-1, 1)] + [np.stack([np.full(17, s), t], 1) for s in (-1, 1)]
    border = np.concatenate(sides) * np.array([width / 2, height / 2])
    plane = border / np.maximum(1.0 + border @ tilt, 0.2)[:, None]
    q = np.stack([plane @ d, plane @ n], 1)
    # A far corner of a steep view would ask for a huge grid; what lies beyond the picture's size is left out.
    reach = float(np.hypot(height, width))
    return np.floor(np.maximum(q.min(0), -reach)) + 0.5, np.ceil(np.minimum(q.max(0), reach))


def _place_beds(
    values: Map, inside: NDArray[np.bool_], first: float, spacing: float, height: float
) -> tuple[float, float]:
    """Pitch near ``height`` and place of the bed joints, by the energy of the row means' harmonics."""
    count = inside.sum(1)
    rows = values.sum(1) / np.maximum(count, 1) * (count > 0.25 * count.max())
    at = first + spacing * np.arange(len(rows))
    # The spectrum's peak leaves a drift of half a period over the picture open.
    pitches = height * (1 + np.linspace(-0.4, 0.4, 41) * height / (spacing * len(rows)))
    k = np.arange(1, _HARMONICS + 1)
    amplitudes = np.exp(-2j * np.pi * k[None, :, None] * at / pitches[:, None, None]) @ rows
    best = int(np.argmax((np.abs(amplitudes) ** 2).sum(1)))
    phases = np.arange(_PHASES) / _PHASES
    response = (amplitudes[best][:, None] * np.exp(2j * np.pi * k[:, None] * phases)).real.sum(0)
    return float(pitches[best]), float(phases[np.argmax(response)] * pitches[best])
