"""Where a particle has a neighbour, from box to box, and how the particles of a picture are arranged.

J.-M. Dischler, K. Maritaud, B. Lévy and D. Ghazanfarpour, "Texture particles" (Eurographics 2002), section 2.2 and
figure 4.
"""

from collections.abc import Sequence
from math import cos, hypot, sin
from statistics import median
from typing import NamedTuple

from jaxtex.particles.boxes import Form, form_of, reach_along
from jaxtex.particles.companions import Companion
from jaxtex.particles.things import Box

_SIGNS = ((1, 1), (-1, 1), (-1, -1), (1, -1))
"""To which sides of a particle its quadrants 0 to 3 lie, along its frame's x and y."""


class Cooccurrence(NamedTuple):
    """Where a particle has a neighbour, in the particle's frame (see `place_neighbour`).

    Attributes:
        quadrant: 0 to 3, clockwise as seen from the frame's x-axis, which is in 0; its y-axis is in 1.
        dx, dy: from box to box along the frame's axes. Where the boxes are apart, pixels between them. Where they
            overlap, less than 0: by how much they do, as a share of how much they could; -1 where centres are level.
    """

    quadrant: int
    dx: float
    dy: float


class Listed(NamedTuple):
    """A class whose particles have neighbours in all quadrants.

    Attributes:
        members: its complete particles, numbers from 0 in the decomposition.
        lists: of co-occurrences, one for each complete particle that has neighbours.
        owners: whose list each is, as an index in `members`.
        neighbours: to each entry of each list the particle that it was seen of, as an index in `members`; -1 where that
            is none of them, since it is cut off or mirrored.
        coherent: whether a particle is best surrounded by those that were around it in the picture: where things nearly
            touch, which of them fit together is no matter of chance.
        turned: whether each particle's frame is turned as its own box is.
        angle: by which all frames are turned otherwise, radians.
        clearance: pixels between the boxes of neighbours, of most at least; 0 where boxes overlap.
        overlap: by how much they do, as a share (see `overlap_share`): the median over all particles.
        rooms: how far each member's centre is from the nearest one's, in pixels.
        groups: of members, each with what is nearest to it (see `jaxtex.particles.companions`).
        density: particles per pixel.
    """

    members: tuple[int, ...]
    lists: tuple[tuple[Cooccurrence, ...], ...]
    owners: tuple[int, ...]
    neighbours: tuple[tuple[int, ...], ...]
    coherent: bool
    turned: bool
    angle: float
    clearance: float
    overlap: float
    rooms: tuple[float, ...]
    groups: tuple[tuple[Companion, ...], ...]
    density: float


class Scattered(NamedTuple):
    """A class too small to show an arrangement: only how far its particles are from each other is known.

    Attributes:
        members: its complete particles, numbers from 0 in the decomposition; perhaps none.
        distances: between centres of particles, pixels; of a single one, the picture's width and height.
        density: particles per pixel.
    """

    members: tuple[int, ...]
    distances: tuple[float, ...]
    density: float


class Arrangement(NamedTuple):
    """How the particles of a picture are arranged.

    Attributes:
        classes: each class's way, by its number.
    """

    classes: tuple[Listed | Scattered, ...]


def cooccurrence_of(box: Box, other: Box, angle: float) -> Cooccurrence:
    """Where another box lies as seen from a box, in a frame turned by `angle`; `place_neighbour` undoes it."""
    cosine, sine = cos(angle), sin(angle)
    x, y = other.x - box.x, other.y - box.y
    x, y = x * cosine + y * sine, y * cosine - x * sine
    reaches = zip(reach_along(form_of(box), cosine, sine), reach_along(form_of(other), cosine, sine), strict=True)
    dx, dy = (_gap(abs(away), sum(reach)) for away, reach in zip((x, y), reaches, strict=True))
    if x > 0:
        return Cooccurrence(0 if y >= 0 else 3, dx, dy)
    if x < 0:
        return Cooccurrence(1 if y > 0 else 2, dx, dy)
    return Cooccurrence(1 if y > 0 else 3, dx, dy)


def place_neighbour(entry: Cooccurrence, form: Form, other: Form, cosine: float, sine: float) -> tuple[float, float]:
    """Where a neighbour lies: the way from a particle's centre to its own, along the picture's x and y.

    Along each axis of the frame, boxes that are apart stay as many pixels apart, whatever their sizes. Boxes that
    overlap do so by the same share of how much they could, so that rows stay rows if sizes vary. (Section 2.2 does not
    say how negative distances are meant.)

    Args:
        entry: of the particle's list.
        form: the particle's box.
        other: the neighbour's box.
        cosine, sine: of the angle of the particle's frame.

    Examples:
        >>> place_neighbour(Cooccurrence(0, 5.0, -1.0), Form(8.0, 4.0, 1.0, 0.0), Form(6.0, 3.0, 1.0, 0.0), 1.0, 0.0)
        (19.0, 0.0)
    """
    (across, down), (other_across, other_down) = reach_along(form, cosine, sine), reach_along(other, cosine, sine)
    toward_x, toward_y = _SIGNS[entry.quadrant]
    x = toward_x * _away(entry.dx, across + other_across)
    y = toward_y * _away(entry.dy, down + other_down)
    return x * cosine - y * sine, x * sine + y * cosine


def usual_distance(rule: Listed | Scattered, forms: Sequence[Form]) -> float:
    """How far the nearest neighbour is as a rule, centre to centre, in pixels.

    Args:
        rule: how a class is arranged.
        forms: the boxes of its particles.

    Examples:
        >>> usual_distance(Scattered((0, 1), (20.0,), 0.01), [])
        20.0
    """
    if isinstance(rule, Scattered):
        return min(rule.distances)
    form = sorted(forms, key=lambda form: form.across * form.down)[len(forms) // 2]
    frame = (form.cosine, form.sine) if rule.turned else (cos(rule.angle), sin(rule.angle))
    return median(min(hypot(*place_neighbour(entry, form, form, *frame)) for entry in each) for each in rule.lists)


def _gap(away: float, reach: float) -> float:
    return away - reach if away >= reach else away / reach - 1.0


def _away(gap: float, reach: float) -> float:
    return reach + gap if gap >= 0 else reach * (1.0 + gap)
