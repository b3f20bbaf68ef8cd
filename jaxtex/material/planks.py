"""What planks of a floor look like beyond the rings of their wood: learnt from a photograph, to be made like it.

As with tiles (`jaxtex.material.interiors`): tone, what changes towards a plank's long sides, and grain, in
sRGB-encoded values. Where a plank's own rings could be read, grain is what they leave unexplained; where they could
not, grain is all there is, and no rings are made up.
"""

import dataclasses
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.ndimage import map_coordinates

from jaxtex.core.colour import linear_to_srgb
from jaxtex.material.grain import at_distance, in_steps, stack_regions
from jaxtex.material.wood import look_at_plank
from jaxtex.models.floor_files import PlacedWood
from jaxtex.models.wood import Wood
from jaxtex.photo.pictures import check_picture

_MARGIN = 3.0  # pixels inside of a plank's outline where photographs mix it with the joint
_REACH = 0.12, 4, 24  # of a plank's breadth, and in pixels: how far its sides show

_SQUEEZED = 16  # times that grain may be longer than broad
_SPOT = 0.5  # standard deviation of what a pixel sees, in pixels
_FLAW = 8.0  # times the median distance of colours from the plank's: farther ones are no wood
_CLEARLY = 1.5  # times as much change of light one way as the other
_FEWEST = 16  # pixels to a side of an example


@dataclasses.dataclass(frozen=True)
class PlankGrain:
    """Grain of one sort.

    Attributes:
        examples: [region, row along, col across, 3], around 0.
        squeezed: how many pixels along the plank a row of them stands for.
        fine: examples of what that leaves out, [region, row along, col across, 3], around 0.
    """

    examples: npt.NDArray[np.float32]
    squeezed: int
    fine: npt.NDArray[np.float32]


@dataclasses.dataclass(frozen=True)
class PlankInteriors:
    """What `measure_planks` learns; sRGB-encoded, lengths in pixels of the photograph.

    Attributes:
        tone: median colour of each plank, [plank, 3]; where its own rings are drawn, of what these leave unexplained.
        own: whether a plank's own rings are drawn, [plank].
        turned: whether its fibres run along its shorter side, [plank].
        contrast: of its grain, against the examples, [plank].
        grain: of planks without rings of their own, and of those with.
        profile: what colours change by towards the long sides, [pixel from the side inwards, 3].
        joint: colour of the joints, (3,).
    """

    tone: npt.NDArray[np.float32]
    own: npt.NDArray[np.bool_]
    turned: npt.NDArray[np.bool_]
    contrast: npt.NDArray[np.float32]
    grain: tuple[PlankGrain, PlankGrain]
    profile: npt.NDArray[np.float32]
    joint: npt.NDArray[np.float32]


class PlankFrame(NamedTuple):
    """A plank's middle, unit vectors across and along its fibres, as (x, y), and half its extent across and along."""

    middle: npt.NDArray[np.float64]
    across: npt.NDArray[np.float64]
    along: npt.NDArray[np.float64]
    half: tuple[float, float]


def frame_of(plank: PlacedWood, *, turned: bool) -> PlankFrame:
    """The frame of a plank: along its longer side, or along its shorter where it is turned."""
    corners = np.asarray(plank.corners, float)
    one, other = corners[1] - corners[0], corners[2] - corners[1]
    long, short = (one, other) if np.hypot(*one) >= np.hypot(*other) else (other, one)
    long, short = (side if side[np.argmax(np.abs(side))] > 0 else -side for side in (long, short))
    long, short = (short, long) if turned else (long, short)
    half = 0.5 * float(np.hypot(*short)), 0.5 * float(np.hypot(*long))
    return PlankFrame(corners.mean(axis=0), short / np.hypot(*short), long / np.hypot(*long), half)


def measure_planks(pixels: npt.ArrayLike, planks: Sequence[PlacedWood]) -> PlankInteriors | None:
    """Learn what planks look like beyond their rings.

    Args:
        pixels: linear light, [row, col, 1 or 3], with slow illumination evened out.
        planks: of a floor fitted to this photograph.

    Returns:
        None where no plank shows enough.
    """
    picture = check_picture(pixels)
    encoded = linear_to_srgb(np.clip(np.broadcast_to(picture, (*picture.shape[:2], 3)), 0, 1)).astype(np.float32)
    turned = np.array([_fibres_across(cut_plank(encoded, plank, turned=False)) for plank in planks])
    pieces = [cut_plank(encoded, plank, turned=bool(turn)) for plank, turn in zip(planks, turned, strict=True)]
    shown = [n for n, piece in enumerate(pieces) if piece is not None and min(piece.values.shape[:2]) >= _FEWEST]
    if not shown:
        return None
    cut = {n: piece for n, piece in enumerate(pieces) if n in shown and piece is not None}
    plain = np.median([np.median(cut[n].values, axis=(0, 1)) for n in shown], axis=0)
    tone = np.tile(plain.astype(np.float32), (len(planks), 1))
    rest = {}
    for n, piece in cut.items():
        left = piece.values - _rings_of(planks[n], piece) if planks[n].own else piece.values
        tone[n] = np.median(left, axis=(0, 1))
        rest[n] = left - tone[n]
    profile = _profile(list(cut.values()), [rest[n] for n in shown])
    even = {n: rest[n] - at_distance(profile, cut[n].inside)[None, :] for n in shown}
    spread = np.array([np.sqrt(np.mean(np.square(even[n]))) for n in shown])
    contrast = np.ones(len(planks), np.float32)
    contrast[shown] = np.clip(spread / max(float(np.median(spread)), 1e-4), 0.4, 2.5)
    return PlankInteriors(
        tone=tone,
        own=np.array([plank.own for plank in planks]),
        turned=turned,
        contrast=contrast,
        grain=(
            _grain([even[n] / contrast[n] for n in shown if not planks[n].own]),
            _grain([even[n] / contrast[n] for n in shown if planks[n].own]),
        ),
        profile=profile,
        joint=_joint_colour(encoded, planks),
    )


class Piece(NamedTuple):
    """A piece of a plank laid upright, [row along, col across, channel]; its points in the photograph; how far inside
    of the long sides its columns are."""

    values: npt.NDArray[np.float32]
    points: npt.NDArray[np.float64]
    inside: npt.NDArray[np.float32]


def without_fibres(wood: Wood) -> Wood:
    """Rings alone: fibres are in the grain."""
    return dataclasses.replace(wood, fibres=None)


def cut_plank(picture: npt.NDArray[np.float32], plank: PlacedWood, *, turned: bool) -> Piece | None:
    """What a picture [row, col, channel] shows of a plank, laid upright; None where it shows nothing.

    Args:
        turned: whether fibres run along the plank's shorter side.
    """
    frame = frame_of(plank, turned=turned)
    margin = min(_MARGIN, 0.1 * frame.half[0])
    u = np.arange(-frame.half[0] + margin, frame.half[0] - margin) + 0.5
    v = np.arange(-frame.half[1] + margin, frame.half[1] - margin) + 0.5
    if not len(u) or not len(v):
        return None
    points = frame.middle + u[None, :, None] * frame.across + v[:, None, None] * frame.along
    limits = np.array(picture.shape[1::-1])
    whole = np.all((points > 0) & (points < limits), axis=-1)
    columns = whole.mean(axis=0) > 0.5 * whole.mean(axis=0).max() if whole.any() else whole.any(axis=0)
    rows = whole[:, columns].all(axis=1)
    if not rows.any():
        return None
    points = points[rows][:, columns]
    at = points[..., ::-1].transpose(2, 0, 1) - 0.5
    values = [map_coordinates(channel, at, order=3, mode="mirror") for channel in np.moveaxis(picture, 2, 0)]
    inside = (frame.half[0] - np.abs(u[columns])).astype(np.float32)
    return Piece(np.stack(values, axis=-1).astype(np.float32), points, inside)


def _rings_of(plank: PlacedWood, piece: Piece) -> npt.NDArray[np.float32]:
    """The colours of a plank's rings where the piece shows it, sRGB-encoded."""
    points = piece.points.reshape(-1, 2) - plank.corners.mean(axis=0)
    colour = look_at_plank(without_fibres(plank.wood), points, spot=_SPOT).base_colour
    return linear_to_srgb(np.clip(colour, 0, 1)).reshape(piece.values.shape).astype(np.float32)


def _profile(pieces: Sequence[Piece], rest: Sequence[npt.NDArray[np.float32]]) -> npt.NDArray[np.float32]:
    """What colours change by towards the long sides, [pixel from the side inwards, channel]; it ends at 0."""
    breadth = 2 * float(np.median([piece.inside.max() for piece in pieces]))
    reach = int(np.clip(round(_REACH[0] * breadth), *_REACH[1:]))
    at = np.arange(reach) + 0.5
    curves = []
    for piece, left in zip(pieces, rest, strict=True):
        mean = left.mean(axis=0)
        order = np.argsort(piece.inside, kind="stable")
        curves.append(np.stack([np.interp(at, piece.inside[order], each[order]) for each in mean.T], axis=-1))
    profile = np.median(curves, axis=0)
    fade = np.clip(2.0 - 2.0 * at / reach, 0, 1)
    return ((profile - profile[-1]) * fade[:, None]).astype(np.float32)


def _grain(pieces: Sequence[npt.NDArray[np.float32]]) -> PlankGrain:
    """Examples of grain, shortened along the fibres until it is about as long as broad, as sub-bands see it best."""
    if not pieces:
        none = np.zeros((0, 1, 1, 3), np.float32)
        return PlankGrain(none, 1, none)
    pieces = [_without_flaws(piece) for piece in pieces]
    light = [piece.mean(axis=2) for piece in pieces]
    along = math.sqrt(np.mean([np.mean(np.square(np.diff(each, axis=0))) for each in light]))
    across = math.sqrt(np.mean([np.mean(np.square(np.diff(each, axis=1))) for each in light]))
    squeezed = int(2 ** np.clip(round(math.log2(max(across / max(along, 1e-6), 1.0)) * 2.0), 0, math.log2(_SQUEEZED)))
    short = [_shorten(piece, squeezed) for piece in pieces]
    fine = [piece - lengthen(each, squeezed, len(piece)) for piece, each in zip(pieces, short, strict=True)]
    return PlankGrain(in_steps(stack_regions(short)), squeezed, in_steps(stack_regions(fine)))


def _fibres_across(piece: Piece | None) -> bool:
    """Whether light changes less across a piece than along it, by more than chance."""
    if piece is None or min(piece.values.shape[:2]) < 2:
        return False
    light = piece.values.mean(axis=2)
    along, across = (float(np.mean(np.square(np.diff(light, axis=axis)))) for axis in (0, 1))
    return along > _CLEARLY * across


def _shorten(piece: npt.NDArray[np.float32], times: int) -> npt.NDArray[np.float32]:
    rows = max(len(piece) // times, 1)
    return piece[: rows * times].reshape(rows, -1, *piece.shape[1:]).mean(axis=1)


def lengthen(piece: npt.NDArray[np.float32], times: int, rows: int) -> npt.NDArray[np.float32]:
    """A piece [row, col, channel] that was shortened along its rows at its full length again, linear between them."""
    along = np.clip((np.arange(rows) + 0.5) / times - 0.5, 0, len(piece) - 1)
    low = along.astype(int)
    share = (along - low)[:, None, None].astype(np.float32)
    return piece[low] * (1 - share) + piece[np.minimum(low + 1, len(piece) - 1)] * share


def _without_flaws(piece: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Grain whose colours are no farther from their median than those of sound wood: nails and knots are evened out."""
    distance = np.sqrt(np.square(piece).sum(axis=2, keepdims=True))
    farthest = _FLAW * float(np.median(distance))
    return (piece * np.minimum(1.0, farthest / np.maximum(distance, 1e-6))).astype(np.float32)


def _joint_colour(picture: npt.NDArray[np.float32], planks: Sequence[PlacedWood]) -> npt.NDArray[np.float32]:
    """The dark quarter of what is seen along the planks' outlines."""
    seen = []
    for plank in planks:
        corners = np.asarray(plank.corners, float)
        for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            points = start + (end - start) * np.linspace(0, 1, 256)[:, None]
            points = points[np.all((points >= 1) & (points < np.array(picture.shape[1::-1]) - 1), axis=1)].astype(int)
            seen.append(picture[points[:, 1], points[:, 0]])
    colours = np.concatenate(seen)
    if not len(colours):
        return np.full(3, 0.1, np.float32)
    light = colours.mean(axis=1)
    return np.median(colours[light <= np.quantile(light, 0.25)], axis=0).astype(np.float32)
