"""A course family -> guesses at the whole tiling: tile width, lean, bond.

The counterpart of Lefebvre & Poulin 2000, section 2.2, which follows scanlines through the rotated mask. Here every
course is averaged across its height into one scanline; the scanlines' common period gives the tile width whatever the
bond, and the place of the joints in each course gives the bond.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from jaxtex.photo.courses import Courses, Map
from jaxtex.photo.lattice import MEASUREMENTS, Lattice, joint_distances
from jaxtex.photo.peaks import parabola_top
from jaxtex.photo.strips import Strips, lay_strips

_HARMONICS = 4
_PHASES = 96
_ROOTS = np.exp(2j * np.pi * np.arange(_PHASES) / _PHASES)
_SHEARS = np.linspace(-0.5, 0.5, 21)
_MARGIN = 0.22  # share of a course's height at either side that may belong to the bed joint
_FEWEST_TILES = 1.3  # tiles along the longest scanline
_WIDTHS = 4  # tile widths tried for each lean
_BY_HAND, _DRAWN = 0.08, 0.02  # courses nearer to a regular bond (upper quartile, in tiles) are laid in it
_JOINT_SHARES = (0.06, 0.12, 0.24)  # joint thickness tried, as a share of the course's height

Array = NDArray[np.float64]


class Scanlines(NamedTuple):
    """One scanline per course: ``number`` (J,) of the course, ``length`` (J,) inside the picture, ``spectra``
    (S, J, F) for every lean, ``size``: samples of the padded transform, ``columns``: samples of the scanline."""

    number: NDArray[np.intp]
    length: Array
    spectra: NDArray[np.complex64]
    size: int
    columns: int


class Response(NamedTuple):
    """How well each scanline agrees with joints of unit energy at each phase of a period.

    ``waves`` (J, K): the correlation's Fourier coefficients along the phase; ``energy`` (J,): the scanlines' own.
    """

    waves: NDArray[np.complex128]
    energy: Array

    def by_phase(self) -> Array:
        """The correlation (J, PHASES)."""
        return (self.waves @ _turns(self.waves.shape[1], np.arange(_PHASES))).real


class Bond(NamedTuple):
    """How head joints of successive courses stand to each other; ``phase``: of course 0, in tile widths; ``fit``:
    share of the scanlines' energy that it explains."""

    name: str
    phase: float
    offset: float
    course_offsets: Array
    course_lengths: Array
    fit: float


def scan_courses(joints: Map, courses: Courses, *, drawn: bool, most: int = 4) -> list[Lattice]:
    """Guesses at the whole tiling for one course family in the map (H, W) it was found in, best first.

    ``drawn``: courses lie where they were drawn, in a mask, rather than where a mason's hand put them.
    """
    strips = lay_strips(joints, courses)
    scanlines = take_scanlines(strips)
    if len(scanlines.number) < 2:
        return []
    guesses = []
    for lean, width in find_widths(scanlines):
        guesses += [(bond, lean, width) for bond in guess_bonds(scanlines, lean, width, _DRAWN if drawn else _BY_HAND)]
    guesses.sort(key=lambda guess: -guess[0].fit)
    # Irregular bonds always explain most; each kind is judged on the map before any is left out.
    free = [guess for guess in guesses if guess[0].name == "irregular"][:most]
    regular = [guess for guess in guesses if guess[0].name != "irregular"][: 2 * most]
    samples = _sample(strips)
    lattices = [_judge(_to_lattice(guess, strips, courses), samples, strips.spacing) for guess in regular + free]
    lattices.sort(key=lambda lattice: -lattice.score)
    # Where heads are thin, only the full fit can tell whether each course has its own shift.
    best_free = next((lattice for lattice in lattices if lattice.bond == "irregular"), None)
    if drawn and best_free is not None and all(best_free is not lattice for lattice in lattices[:most]):
        lattices[most - 1] = best_free
    return lattices[:most]


def take_scanlines(strips: Strips) -> Scanlines:
    """Average each course across its height, away from the bed joints, for every lean of the head joints."""
    rows, columns = strips.values.shape
    size = 2 * columns
    at = (strips.corner[1] + strips.spacing * np.arange(rows) - strips.bed) / strips.height
    course = np.floor(at).astype(int)
    within = at - course
    central = (within > _MARGIN) & (within < 1 - _MARGIN)
    # Samples come course by course, so that a course is a run of them.
    numbers, first, count = np.unique(course[central], return_index=True, return_counts=True)
    length = np.add.reduceat(strips.inside[central].sum(1), first) / count
    keep = (count * strips.spacing > 0.5 * (1 - 2 * _MARGIN) * strips.height) & (length > 0.15 * columns)
    spectrum = fft.rfft(strips.values[central], n=size, axis=1)[:, : size // 4]
    frequency = (fft.rfftfreq(size)[: size // 4] / strips.spacing).astype(np.float32)
    lean = 2j * np.pi * frequency * ((within[central] - 0.5) * strips.height).astype(np.float32)[:, None]
    leaned, step = spectrum * np.exp(lean * _SHEARS[0]), np.exp(lean * (_SHEARS[1] - _SHEARS[0]))
    spectra = np.empty((len(_SHEARS), int(keep.sum()), spectrum.shape[1]), np.complex64)
    for index in range(len(_SHEARS)):
        spectra[index] = (np.add.reduceat(leaned, first) / count[:, None])[keep]
        leaned = leaned * step
    return Scanlines(numbers[keep], length[keep], spectra, size, columns)


def find_widths(scanlines: Scanlines) -> list[tuple[int, float]]:
    """Likely (index of lean, tile width in samples): peaks of the courses' summed spectra with their harmonics."""
    power = (np.abs(scanlines.spectra) ** 2).sum(1)
    lowest = max(int(np.ceil(_FEWEST_TILES * scanlines.size / scanlines.length.max())), 1)
    highest = power.shape[1] // _HARMONICS * 2
    if highest <= lowest + 2:
        return []
    bins = np.arange(lowest, highest)
    padded = np.pad(power, ((0, 0), (0, _HARMONICS * highest)))
    combs = np.sum([padded[:, k * bins] for k in range(1, _HARMONICS + 1)], axis=0)
    upright = len(_SHEARS) // 2
    best = int(np.argmax(combs.max(1)))
    leans = [upright] if combs[best].max() < 1.05 * combs[upright].max() else [upright, best]
    found = []
    for lean in leans:
        comb = combs[lean].copy()
        for _ in range(_WIDTHS):
            peak = int(np.argmax(comb))
            if not np.isfinite(comb[peak]):
                break
            found.append((lean, scanlines.size / (bins[peak] + _between(combs[lean], peak))))
            comb[max(peak - 2, 0) : peak + 3] = -np.inf
        # Joints in turn above and below, or courses of headers, can drown a frequency in its double.
        longest = scanlines.length.max() / _FEWEST_TILES
        widths = np.array([width for at, width in found if at == lean])
        doubled = [2 * width for width in widths if 2 * width < longest]
        found += [(lean, width) for width in doubled if np.abs(widths / width - 1).min() > 0.02]
    return found


def guess_bonds(scanlines: Scanlines, lean: int, width: float, aligned: float) -> list[Bond]:
    """One guess per kind of bond: common offset, English, Flemish, and every course by itself."""
    response = _respond(scanlines, lean, width, (1.0,))
    by_phase = response.by_phase()
    regular = _regular(scanlines, response, np.ones((1, 1)))
    bonds = [regular]
    irregular, deviation = _irregular(scanlines, by_phase, response.energy, regular)
    if deviation > aligned:
        bonds.append(irregular)
    if len(scanlines.number) >= 4 and width >= 12:
        headers = _respond(scanlines, lean, width / 2, (1.0,))
        bonds.append(_english(scanlines, by_phase, headers.by_phase(), response.energy))
        # A Flemish course repeats after a stretcher and a header of half its length.
        pair = _respond(scanlines, lean, width, (2 / 3, 1 / 3))
        bonds.append(_regular(scanlines, pair, np.array([[1.0, 0.5]])))
    return bonds


def _respond(scanlines: Scanlines, lean: int, period: float, pattern: tuple[float, ...]) -> Response:
    """The response to joints ``pattern`` apart, in shares of the period, which is in samples."""
    lines = fft.irfft(scanlines.spectra[lean], n=scanlines.size, axis=1)[:, : scanlines.columns]
    k = np.arange(1, max(2, int(min(12, period / 3))) + 1)
    # A mild low-pass: joints are not lines, and they jitter.
    soft = np.exp(-2 * (np.pi * k * max(0.04, 1.0 / period)) ** 2)
    shape = soft * np.exp(-2j * np.pi * k[:, None] * np.cumsum(pattern)).sum(1)
    waves = np.exp(-2j * np.pi * np.outer(np.arange(scanlines.columns), k) / period)
    norm = np.sqrt((np.abs(shape) ** 2).sum() / 2 * scanlines.length)
    return Response((lines @ waves) * shape.conj() / norm[:, None], (lines**2).sum(1))


def _turns(harmonics: int, phases: NDArray[np.intp]) -> NDArray[np.complex128]:
    """exp(2 pi i k phase) for the first harmonics k = 1, 2, ... and phases counted in steps: (K, *phases.shape)."""
    k = np.arange(1, harmonics + 1).reshape(-1, *(1,) * phases.ndim)
    return _ROOTS[(k * phases) % _PHASES]


def _explained(energy: Array, total: float) -> float:
    """Share of the scanlines' energy explained when all courses share one contrast."""
    return max(total, 0.0) ** 2 / max(float(energy.sum()) * len(energy), 1e-12)


def _regular(scanlines: Scanlines, response: Response, lengths: Array) -> Bond:
    steps = np.arange(_PHASES)
    turned = _turns(response.waves.shape[1], scanlines.number[:, None] * steps)  # (K, J, offsets)
    summed = np.einsum("jk,kjo->ko", response.waves, turned)
    totals = (_turns(len(summed), steps).T @ summed).real
    first, offset = np.unravel_index(int(np.argmax(totals)), totals.shape)
    period = float(lengths[0].sum())
    name = "raking" if lengths.shape[1] == 1 else "flemish"
    return Bond(
        name,
        float(first) / _PHASES * period,
        float(offset) / _PHASES * period,
        np.zeros(1),
        lengths,
        _explained(response.energy, float(totals.max())),
    )


def _english(scanlines: Scanlines, stretchers: Array, headers: Array, energy: Array) -> Bond:
    """Courses of stretchers and of headers in turn; rows of ``course_lengths`` say which is which."""
    odd = scanlines.number % 2 == 1
    guesses = []
    for headers_odd in (True, False):
        head = odd if headers_odd else ~odd
        long, short = stretchers[~head].sum(0), headers[head].sum(0)
        total = float(long.max() + short.max())
        guesses.append((total, headers_odd, float(np.argmax(long)) / _PHASES, float(np.argmax(short)) / _PHASES / 2))
    total, headers_odd, long_phase, short_phase = max(guesses)
    offsets = np.array([0.0, (short_phase - long_phase) % 0.5])
    lengths = np.array([[1.0, 1.0], [0.5, 0.5]])
    if not headers_odd:
        offsets, lengths = offsets[::-1], lengths[::-1]
    return Bond("english", long_phase, 0.0, offsets, lengths, _explained(energy, total))


def _irregular(scanlines: Scanlines, by_phase: Array, energy: Array, regular: Bond) -> tuple[Bond, float]:
    """Every course at its own best phase, and how far that is from the regular bond (upper quartile, in tiles)."""
    first, count = int(scanlines.number[0]), int(np.ptp(scanlines.number)) + 1
    phases = np.zeros(count)
    best = np.argmax(by_phase, axis=1) / _PHASES
    phases[scanlines.number - first] = best
    aside = best - regular.phase - regular.offset * scanlines.number
    deviation = float(np.quantile(np.abs(aside - np.round(aside)), 0.75))
    # Entry j mod C belongs to course j.
    offsets = np.roll((phases - phases[0]) % 1.0, first % count)
    total = float(by_phase.max(1).sum())
    bond = Bond("irregular", float(phases[0]), 0.0, offsets, np.ones((1, 1)), _explained(energy, total))
    return bond, deviation


def _to_lattice(guess: tuple[Bond, int, float], strips: Strips, courses: Courses) -> Lattice:
    bond, lean, samples = guess
    shear = float(_SHEARS[lean])
    # A Flemish period holds one and a half stretchers.
    width = samples * strips.spacing / float(bond.course_lengths[0].sum() if bond.name == "flemish" else 1.0)
    # Scanlines were leaned about each course's middle; the lattice leans as a whole.
    start_x = bond.phase * width + strips.corner[0] - shear * (strips.bed + strips.height / 2)
    return Lattice(
        tilt=courses.tilt,
        angle=courses.angle,
        shear=shear,
        height=strips.height,
        width=width,
        start=np.array([start_x, strips.bed]),
        offset=bond.offset - shear * strips.height / width,
        course_offsets=bond.course_offsets,
        course_lengths=bond.course_lengths,
        bond=bond.name,
        joints=(0.1 * strips.height,) * 2,
        score=-np.inf,
    )


class _Samples(NamedTuple):
    """Samples of the strips inside the picture: where they lie, and ``values``, zero mean; all (N,)."""

    along: Array
    across: Array
    values: Map


def _sample(strips: Strips) -> _Samples:
    # Every second sample of a low-passed map tells as much.
    rows, columns = np.nonzero(strips.inside[::2, ::2])
    values = strips.values[::2, ::2][rows, columns]
    along, across = (first + 2 * strips.spacing * at for first, at in zip(strips.corner, (columns, rows), strict=True))
    return _Samples(along, across, values - values.mean())


def _judge(lattice: Lattice, samples: _Samples, spacing: float) -> Lattice:
    """Score a guess on the whole map: bed and head joints as two regressors, with the best of a few thicknesses.

    The score is minus the Bayesian information criterion, for each of a number of measurements that is the same for all
    guesses: misfit comes joint by joint, so it is that of joints in a picture rather than that of pixels.
    """
    along = samples.along - lattice.shear * samples.across
    to_head, to_bed = (each.astype(np.float32) for each in joint_distances(lattice, along, samples.across))
    values, total = samples.values, max(_product(samples.values, samples.values), 1e-12)
    scored = []
    for share in _JOINT_SHARES:
        thickness = max(share * lattice.height, 2 * spacing)
        reach = np.float32(0.72 * thickness)  # the Gaussian of this width has the joint's area
        bed = np.exp(-((to_bed / reach) ** 2))
        head = (1 - bed) * np.exp(-((to_head / reach) ** 2))
        joints = [bed - bed.mean(), head - head.mean()]
        overlap = np.array([[_product(one, other) for other in joints] for one in joints])
        agreement = np.array([_product(one, values) for one in joints])
        gain = np.linalg.solve(overlap + 1e-9 * np.eye(2), agreement)
        # Joints that read less than tiles are none.
        scored.append((float(gain @ agreement) / total if gain.min() > 0 else 0.0, thickness))
    explained, thickness = max(scored)
    score = -np.log(max(1 - explained, 1e-6)) - lattice.freedoms * np.log(MEASUREMENTS) / MEASUREMENTS
    return lattice._replace(score=float(score), joints=(thickness, thickness))


def _product(a: Map, b: Map) -> float:
    """Inner product, without the threads that a linear algebra library would start for it."""
    return float(np.einsum("n,n->", a, b))


def _between(values: Array, at: int) -> float:
    """By how much of a sample the peak lies beside a sample; 0 at the ends."""
    return float(parabola_top(*values[at - 1 : at + 2])) if 0 < at < len(values) - 1 else 0.0
