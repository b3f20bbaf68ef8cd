"""Photograph of wood -> its rings, counted: the way for boards whose rings are uneven, wavy and full of pores.

Fibres show the axis of the trunk, or that the cut is end grain. A map that runs along the grain is found from a first
guess, straight or around a pith, and the dark lines across it are counted.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import signal
from skimage.filters import threshold_otsu

from jaxtex.fitting.rings import lay_plank
from jaxtex.fitting.wood_detail import read_gradation
from jaxtex.photo.directions import (
    Directions,
    compare_directions,
    directions_of,
    follow_grain,
    main_direction,
    measure_directions,
    smooth_along,
    weigh_directions,
)
from jaxtex.photo.figure import follow_figure
from jaxtex.photo.ring_lines import Ray, count_lines, even_out_rings, follow_lines, measure_spacing

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_FIBRES = 0.7  # pixels: at this scale fibres and pores are seen, which run along the trunk
_RINGS = (2.0, 4.0)  # and at these rings, which need not
_FIBROUS = 0.3  # how clearly fibres run one way on all boards that are not end grain
_ROUND = 0.25  # by which rings and rays around a pith must agree better than straight ones
_SHARP = 1.0  # pixels: at this scale rays are seen as well as rings
_RAYS = 31
_FOLDED = 0.05  # of the picture, at least, beyond where rings turn back
_LEANS = (0.02, 0.04, 0.07, 0.1, 0.15, 0.22, 0.32, 0.46, 0.68, 1.0)  # sines of the tilt of known ellipses
_PITH_REACH = (0.32, 0.64)  # of the picture's shorter side: how far around it rings are looked at


class Pith(NamedTuple):
    """The place (u, v) where the picture cuts the pith, and the plank's tilt (radians) there."""

    u: float
    v: float
    tilt: float


class Grain(NamedTuple):
    """What a photograph (H, W) shows of its rings.

    ``early`` (H, W): the mask of early wood; ``directions``: those of its rings; ``rings`` (H, W): which ring each
    place belongs to, counted from anywhere and either way; ``followed`` (H, W): likewise, place by place; ``outwards``:
    whether late wood ends sharply towards higher counts; ``clear`` (H, W): where nothing runs astray, such as knots.
    ``folded``: whether rings turn back in the picture, so that they are counted up and down again. ``spacing``,
    pixels. ``across``: the direction across the fibres, radians, or None in end grain. ``pith``: where in the picture
    rings close around it, if they do. ``agreement`` and ``crossing``: as `compare_directions` has them.
    """

    early: Mask
    directions: Directions
    rings: Floats
    followed: Floats
    outwards: bool
    clear: Mask
    folded: bool
    spacing: float
    across: float | None
    pith: Pith | None
    agreement: float
    crossing: float


def read_grain(
    light: Floats,
    *,
    across: float | None = None,
    middle: tuple[float, float] | None = None,
    figured: bool = True,
) -> Grain:
    """Read the rings of a picture's lightness (H, W), evened out.

    The direction ``across`` the fibres and the ``middle`` (u, v) of the rings' ellipses may be known. Unless
    ``figured``, rings are supposed to run through.
    """
    if across is None:
        turn, fibrous = main_direction(measure_directions(light, _FIBRES))
        across = turn if fibrous >= _FIBROUS else None
    pith, first = _guess_rings(light, across, middle)
    if pith is not None and middle is None:
        across = None  # what ran one way were rays, not fibres
    known = None if pith is None or across is not None else directions_of(first)
    rays = _lay_rays(first, None if known is None else pith, None if middle is None else across)
    spacing = min(measure_spacing(light, rays, known), float(max(light.shape)))
    directions = measure_directions(light, max(1.5, 0.1 * spacing))
    figure = follow_figure(light, across) if figured and across is not None else None
    folded = figure is not None and _folded(figure, across or 0.0) > _FOLDED
    levels = figure if figure is not None and folded else _follow_twice(directions, first)
    agreement, crossing = _judge(light, first, levels if folded else None, fibrous=across is not None)
    smooth = smooth_along(light, known or directions, float(np.clip(1.5 * spacing, 8, 40)))
    even = np.tanh(even_out_rings(smooth, spacing))
    rings = count_lines(even, levels, spacing)
    followed = follow_lines(even, rings, spacing)
    clear = compare_directions(directions, levels)[2]
    early = even > threshold_otsu(even)
    # Late wood ends sharply on its outer side, whichever way rings were counted.
    outwards, inwards = (
        read_gradation(light, each, clear, float(early.mean()))[1] for each in (followed, 0.5 - followed)
    )
    return Grain(
        early=early,
        directions=directions,
        rings=rings,
        followed=followed,
        outwards=outwards >= inwards,
        clear=clear,
        folded=folded,
        spacing=spacing,
        across=across,
        pith=pith,
        agreement=agreement,
        crossing=crossing,
    )


def _follow_twice(directions: Directions, first: Floats) -> Floats:
    """Knots and cracks bend the map: once it is known what runs astray, without them."""
    levels = follow_grain(directions, first)
    return follow_grain(directions, first, clear=compare_directions(directions, levels)[2])


def _folded(levels: Floats, across: float) -> float:
    """How much of a map (H, W) climbs the other way across the grain, 0 to 0.5."""
    down, right = np.gradient(levels)
    outwards = float((right * np.cos(across) + down * np.sin(across) > 0).mean())
    return min(outwards, 1 - outwards)


def _judge(light: Floats, first: Floats, figure: Floats | None, *, fibrous: bool) -> tuple[float, float]:
    """How well edges of any size follow the grain at best, and how many run across it at least.

    Where rings turn back, they follow the board's ``figure``.
    """
    sharp = [measure_directions(light, scale, reach=1.5 * scale + 1) for scale in (_FIBRES, *_RINGS)]
    judged = [compare_directions(each, follow_grain(each, first) if figure is None else figure) for each in sharp]
    # Pores of end grain lie any way. Where there are fibres, the finer edges tell: bricks look like stripes from afar.
    crossings = [crossing for _, crossing, _ in (judged[:-1] if fibrous else judged)]
    return max(agreement for agreement, _, _ in judged), min(crossings)


def _guess_rings(light: Floats, across: float | None, middle: tuple[float, float] | None) -> tuple[Pith | None, Floats]:
    """The pith, where rings close around one, and a first map of rings (H, W), in pixels from anywhere."""
    u, v = lay_plank(*light.shape)
    scales = [measure_directions(light, scale) for scale in _RINGS]
    if middle is not None:
        return _guess_ellipses(scales[0], across, middle)
    place, gain = _vote_for_pith(measure_directions(light, _SHARP))
    if gain > _ROUND:
        return Pith(*place, np.pi / 2), np.hypot(u - place[0], v - place[1])
    turns = [main_direction(each)[0] for each in scales] + ([] if across is None else [across])
    straight = [u * np.cos(turn) + v * np.sin(turn) for turn in turns]
    return None, max(straight, key=lambda rings: compare_directions(scales[0], rings)[0])


def _guess_ellipses(directions: Directions, across: float | None, middle: tuple[float, float]) -> tuple[Pith, Floats]:
    """Rings around a known middle (u, v), whose tilt is the one that the directions near it show."""
    u, v = lay_plank(*directions.energy.shape)
    turn = across or 0.0
    aside = (u - middle[0]) * np.cos(turn) + (v - middle[1]) * np.sin(turn)
    along = (v - middle[1]) * np.cos(turn) - (u - middle[0]) * np.sin(turn)
    leans = _LEANS if across is not None else (1.0,)
    rings = {lean: np.hypot(aside, lean * along) for lean in leans}
    lean = max(leans, key=lambda each: compare_directions(directions, rings[each])[0])
    return Pith(*middle, float(np.arcsin(lean))), rings[lean]


def _vote_for_pith(directions: Directions) -> tuple[tuple[float, float], float]:
    """The place (u, v) in the picture around which directions are most nearly those of rings and rays, and by how much
    that describes them better than running one way.

    Rays and the cracks along them point at the pith as surely as rings go around it: at four times their angle, both
    are the same.
    """
    near = np.s_[1::2, 1::2]
    weight = weigh_directions(directions)[near]
    seen = weight * np.exp(2j * np.angle(directions.across[near]))
    rows, columns = (2 * np.arange(-n + 1, n) for n in seen.shape)
    away = np.exp(4j * np.arctan2(rows[:, None], columns[None]))
    best = -np.inf, 0
    for reach in _PITH_REACH:
        window = np.exp(-0.5 * (rows[:, None] ** 2 + columns[None] ** 2) / (reach * min(directions.energy.shape)) ** 2)
        pointing, running, known = (
            signal.correlate(part, kernel, mode="same", method="fft")
            for part, kernel in ((seen, away * window), (seen, window + 0j), (weight.astype(complex), window + 0j))
        )
        gain = (pointing.real - np.abs(running)) / np.maximum(known.real, 0.3 * known.real.max())
        if float(gain.max()) > best[0]:
            best = float(gain.max()), int(gain.argmax())
    u, v = lay_plank(*directions.energy.shape)
    return (float(u[near].flat[best[1]]), float(v[near].flat[best[1]])), best[0]


def _lay_rays(rings: Floats, pith: Pith | None, across: float | None) -> list[Ray]:
    """Lines across the grain, where that is not known across most of the rings: side by side, or from the pith
    outwards."""
    height, width = rings.shape
    reach = np.arange(0.0, np.hypot(height, width))
    if pith is not None:
        row, column = pith.v + height / 2 - 0.5, pith.u + width / 2 - 0.5
        turns = np.linspace(0, 2 * np.pi, _RAYS, endpoint=False)
        return [(row + reach * np.sin(turn), column + reach * np.cos(turn)) for turn in turns]
    down, right = (float(slope.mean()) for slope in np.gradient(rings))
    if across is not None:
        down, right = np.sin(across), np.cos(across)
    reach = reach - reach.mean()
    return [
        ((height - 1) / 2 + reach * down + aside * right, (width - 1) / 2 + reach * right - aside * down)
        for aside in np.linspace(-0.4, 0.4, _RAYS) * max(height, width)
    ]
