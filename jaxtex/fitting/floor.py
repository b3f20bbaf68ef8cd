"""Photograph of a floor -> its planks, and the wood of each.

Lefebvre & Poulin 2000, section 4.4: a tiling for the planks, and the wood model in each of them.
"""

import dataclasses
import time
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from jaxtex.core.errors import InputError
from jaxtex.fitting.wood import WoodFit, fit_wood
from jaxtex.models.wood import Wood, make_wood, trunk_coordinates
from jaxtex.models.wood_files import canonical_wood
from jaxtex.photo.automask import check_surface
from jaxtex.photo.directions import main_direction, measure_directions
from jaxtex.photo.evidence import shrink
from jaxtex.photo.grain import flatten_light
from jaxtex.photo.planks import find_planks, turn_picture

Floats = NDArray[np.float64]

_SIZE = 1024  # pixels along the longer side, at which joints are looked for
_INSET = 0.04  # of a plank's breadth: as far as joints and their shadows reach
_SMALLEST = 32  # pixels: smaller planks tell too little of their wood
_LONGEST = 4  # times as long as broad: so much of a plank is read, about its middle
_SIZES = 4  # pixels: sides of larger planks are multiples of so many
_MOST = 48  # planks whose wood is fitted one by one
_MAZE = 0.5  # pixels of displacement from one pixel to the next, typically
_STEEP = np.pi / 4  # tilt of no plank
_WOODEN = 0.5  # share of the planks that must be wood
_FIBRES = 0.7  # pixels: at this scale they are seen
_FIBROUS = 0.3  # how clearly fibres run one way on a plank

Report = Callable[[float, float], None]


@dataclasses.dataclass(frozen=True, eq=False)
class FloorPlank:
    """``corners`` (4, 2): (x, y) in pixels of the photograph, in order around the plank; they may lie beyond its
    border. ``wood``: the plank's point (0, 0) is the middle of its corners, its u and v those of the photograph.
    ``own``: whether the wood was read off this plank; else it is what the other planks have in common, in this one's
    colours, or another photograph's."""

    corners: Floats
    wood: Wood
    own: bool


@dataclasses.dataclass(frozen=True, eq=False)
class FloorFit:
    """What :func:`fit_floor` found.

    ``ok`` is False where the picture shows no planks of wood; ``reason`` says why. ``turn``: radians, across the planks
    is (cos, sin) in the picture; ``joints``: their places across, in pixels from the picture's middle; ``evidence``:
    how many times the clearest joint stands out of what is nearby. ``seconds`` spent, by step.
    """

    ok: bool
    reason: str
    planks: tuple[FloorPlank, ...]
    turn: float
    joints: Floats
    evidence: float
    seconds: dict[str, float]


def fit_floor(
    photo: NDArray[np.floating],
    *,
    wood: Wood | None = None,
    seed: int = 0,
    report: Report | None = None,
) -> FloorFit:
    """Find the planks of a floor, fence or parquet seen straight on, and fit wood to each of them.

    Joints are straight lines: parallel ones with ends between them, or, where grain runs both ways, crossing ones.

    Parameters
    ----------
    photo
        Linear [H, W], [H, W, 1] or [H, W, 3], at least 32 x 32; planks may run in any direction.
    wood
        Wood of another photograph, for all planks; each is cut elsewhere from its trunk.
    seed
        Of where such planks are cut.
    report
        Called with (done, total) as the work goes on.

    Raises
    ------
    InputError
        A picture of the wrong shape, too small, or not finite.

    Examples
    --------
    >>> import numpy as np
    >>> v, u = np.mgrid[0:192, 0:192]
    >>> grain = 0.4 + 0.1 * np.sin(2 * np.pi * (u + 3 * np.sin(v / 20 + u // 64)) / 9)
    >>> grain *= np.random.default_rng(0).normal(1, 0.05, grain.shape)
    >>> fit = fit_floor(np.where(u % 64 < 2, 0.02, grain))
    >>> len(fit.planks)
    3
    """
    tell = report or (lambda done, total: None)
    began = time.perf_counter()
    picture = check_surface(photo)
    working = shrink(picture, _SIZE)
    scale = max(picture.shape[:2]) / max(working.shape[:2])
    found = find_planks(flatten_light(working))
    seconds = {"planks": time.perf_counter() - began}
    corners = found.corners * scale
    if len(found.joints) == 0:
        reason = "no straight joints are to be seen between planks"
        return FloorFit(False, reason, (), found.turn, found.joints, found.evidence, seconds)
    began = time.perf_counter()
    if wood is not None:
        random = np.random.default_rng(seed)
        turned = turn_picture(picture.astype(float), found.turn)
        pieces = [_cut_out(turned, each, picture.shape, found.turn)[0] for each in corners]
        runs = [_across(piece) for piece in pieces]
        woods = [_cut_elsewhere(wood, across + found.turn, random) for across in runs]
        planks = tuple(FloorPlank(each, one, False) for each, one in zip(corners, woods, strict=True))
        wooden = _share_of_wood(pieces)
    else:
        planks, wooden = _fit_planks(picture, corners, found.turn, tell)
    seconds["wood"] = time.perf_counter() - began
    reason = "" if wooden >= _WOODEN else f"only {wooden:.0%} of what lies between the joints looks like wood"
    return FloorFit(not reason, reason, planks, found.turn, found.joints * scale, found.evidence, seconds)


def _fit_planks(
    picture: NDArray[np.float32], corners: Floats, turn: float, tell: Report
) -> tuple[tuple[FloorPlank, ...], float]:
    """The planks, and on which share of those large enough to tell fibres are seen."""
    turned = turn_picture(picture.astype(float), turn)
    fits: list[WoodFit | None] = []
    cuts = [_cut_out(turned, each, picture.shape, turn) for each in corners]
    pieces = [piece for piece, _ in cuts]
    order = np.argsort([-piece.size for piece in pieces])[:_MOST]
    for number, piece in enumerate(pieces):
        tell(number, len(pieces))
        large = number in order and min(piece.shape[:2]) >= _SMALLEST
        fits.append(_fit_piece(piece) if large else None)
    tell(len(pieces), len(pieces))
    read = [_calmed(fit.wood) if fit is not None and _is_plank(fit) else None for fit in fits]
    shared = _share([wood for wood in read if wood is not None])
    planks = []
    for each, (piece, off), own in zip(corners, cuts, read, strict=True):
        wood = _in_colours_of(shared, piece) if own is None else own
        planks.append(FloorPlank(each, _placed(wood, turn, off), own is not None))
    return tuple(planks), _share_of_wood(pieces)


def _share_of_wood(pieces: list[Floats]) -> float:
    """On which share of the pieces large enough to tell fibres are seen."""
    large = [piece for piece in pieces if min(piece.shape[:2]) >= _SMALLEST // 2]
    fibrous = [main_direction(measure_directions(flatten_light(piece), _FIBRES))[1] > _FIBROUS for piece in large]
    return float(np.mean(fibrous)) if fibrous else 0.0


def _is_plank(fit: WoodFit) -> bool:
    """Whether a piece shows wood cut along the trunk; floors of end grain are no planks."""
    return fit.ok and float(fit.wood.tilt) < _STEEP


def _calmed(wood: Wood) -> Wood:
    """Wood whose turbulence, beyond the piece that was seen, does not bend rings more than they run."""
    bends = 2 * np.pi * float(wood.turbulence_frequency) * float(wood.turbulence_rms)
    return dataclasses.replace(wood, turbulence_rms=wood.turbulence_rms * min(1.0, _MAZE / max(bends, 1e-9)))


def _across(piece: Floats) -> float:
    """Across the grain of an upright piece, radians; where no grain is seen, across the floor's planks."""
    if min(piece.shape[:2]) >= _SMALLEST // 2:
        turn, fibrous = main_direction(measure_directions(flatten_light(piece), _FIBRES))
        if fibrous > _FIBROUS:
            return turn
    return 0.0


def _fit_piece(piece: Floats) -> WoodFit | None:
    try:
        return fit_wood(piece)
    except InputError:
        return None


def _cut_out(turned: Floats, corners: Floats, shape: tuple[int, ...], turn: float) -> tuple[Floats, Floats]:
    """The inside of a plank, upright (h, w, channels), as much of it as the picture shows and as is worth reading; and
    how far from the plank's middle that piece has its own (2,)."""
    c, s = np.cos(turn), np.sin(turn)
    middle = np.array([turned.shape[1], turned.shape[0]]) / 2
    placed = (corners - [shape[1] / 2, shape[0] / 2]) @ np.array([[c, -s], [s, c]]) + middle
    low, high = placed.min(0), placed.max(0)
    inset = max(2.0, _INSET * float((high - low).min()))
    first = np.maximum(np.ceil(low + inset), 0).astype(int)
    last = np.minimum(np.floor(high - inset), 2 * middle).astype(int)
    first, last = np.minimum(first, 2 * middle.astype(int) - 1), np.maximum(last, first + 1)
    longest = _LONGEST * int((last - first).min())
    spare = np.maximum(last - first - longest, 0)
    first, last = first + spare // 2, last - (spare - spare // 2)
    # Fits are compiled for each size that pieces have, and no two planks are as broad to the pixel.
    odd = np.where(last - first > _SMALLEST, (last - first) % _SIZES, 0)
    first, last = first + odd // 2, last - (odd - odd // 2)
    piece = turned[first[1] : last[1], first[0] : last[0]]
    known = ~np.isnan(piece)
    filling = np.nanmean(piece, axis=(0, 1)) if known.any() else np.zeros(piece.shape[2])
    return np.where(known, piece, filling), (first + last) / 2 - (low + high) / 2


def _share(woods: list[Wood]) -> Wood:
    """What planks have in common: the middle of each of their numbers."""
    if not woods:
        return make_wood(ring_spacing=20.0)
    numbers: dict[str, Any] = {
        name: np.median([np.asarray(getattr(wood, name)) for wood in woods], axis=0)
        for name in ("ring_spacing", "early_fraction", "early_rgb", "late_rgb", "turbulence_rms")
    }
    numbers["turbulence_frequency"] = float(np.median([float(wood.turbulence_frequency) for wood in woods]))
    numbers["gradation"] = float(np.median([float(wood.gradation) for wood in woods]))
    fibres = [wood.fibres for wood in woods if wood.fibres is not None]
    shared = jax.tree.map(lambda *each: jnp.asarray(np.median(each, axis=0)), *fibres) if fibres else None
    return make_wood(**numbers, center=(-10 * float(numbers["ring_spacing"]), 0.0), fibres=shared)


def _in_colours_of(wood: Wood, piece: Floats) -> Wood:
    """Shared wood, as light as a plank is."""
    mean = 0.5 * (np.asarray(wood.early_rgb) + np.asarray(wood.late_rgb))
    ratio = np.clip(piece.reshape(-1, piece.shape[2]).mean(0) / np.maximum(mean, 1e-6), 0.2, 5.0)
    return dataclasses.replace(wood, early_rgb=wood.early_rgb * ratio, late_rgb=wood.late_rgb * ratio)


def _placed(wood: Wood, turn: float, off: Floats) -> Wood:
    """Wood of an upright piece in the picture where it lies turned, about the middle of its plank instead of a point
    that is ``off`` from there (2,)."""
    across, along, _ = trunk_coordinates(*jnp.asarray(off), tilt=wood.tilt, rotation=wood.rotation)
    center = wood.center + jnp.stack([across, along])
    field = wood.displacement
    if field is not None:
        c, s = np.cos(turn), np.sin(turn)
        middle = jnp.asarray([c * off[0] - s * off[1], s * off[0] + c * off[1]])
        field = dataclasses.replace(field, middle=middle, turn=jnp.asarray(turn))
    moved = dataclasses.replace(wood, center=center, rotation=wood.rotation + turn, displacement=field)
    return canonical_wood(moved)


def _cut_elsewhere(wood: Wood, across: float, random: np.random.Generator) -> Wood:
    """Another photograph's wood on a plank whose grain runs a given way, cut somewhere near where that was."""
    spacing = float(wood.ring_spacing)
    moved = wood.center + random.uniform(-1, 1, 2) * np.array([10 * spacing, spacing])
    return canonical_wood(dataclasses.replace(wood, center=moved, rotation=jnp.asarray(across), displacement=None))
