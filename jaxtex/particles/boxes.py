"""Boxes that lean: how far they reach along a direction, and how much two of them overlap."""

from math import cos, sin
from typing import NamedTuple

from jaxtex.particles.things import Box


class Form(NamedTuple):
    """A box without its place, in the numbers that are asked for again and again.

    Attributes:
        across, down: half its width and half its height.
        cosine, sine: of the angle by which its width is turned from the picture's rows.
    """

    across: float
    down: float
    cosine: float
    sine: float

    def grown(self, margin: float) -> "Form":
        """The box with a margin around it."""
        return self._replace(across=self.across + margin, down=self.down + margin)

    def changed(self, scale: float, angle: float) -> "Form":
        """The box larger by a factor and turned by radians."""
        c, s = cos(angle), sin(angle)
        return Form(
            scale * self.across, scale * self.down, self.cosine * c - self.sine * s, self.sine * c + self.cosine * s
        )


def form_of(box: Box) -> Form:
    """A box's form.

    Examples:
        >>> form_of(Box(6.0, 3.5, 6.0, 3.0, 0.0))
        Form(across=3.0, down=1.5, cosine=1.0, sine=0.0)
    """
    return Form(0.5 * box.width, 0.5 * box.height, cos(box.angle), sin(box.angle))


def reach_along(form: Form, cosine: float, sine: float) -> tuple[float, float]:
    """How far a box reaches from its centre along the two axes of a frame: half the sides of what it fits in there.

    Args:
        form: the box.
        cosine, sine: of the frame's angle.

    Examples:
        >>> reach_along(Form(3.0, 1.5, 1.0, 0.0), 0.0, 1.0)
        (1.5, 3.0)
    """
    along = abs(form.cosine * cosine + form.sine * sine)
    aslant = abs(form.sine * cosine - form.cosine * sine)
    return form.across * along + form.down * aslant, form.across * aslant + form.down * along


def overlap_share(dx: float, dy: float, first: Form, second: Form) -> float:
    """How much two boxes overlap, by separating axes: on the axis that tells them apart best, how deep one lies in the
    other, as a share of the smaller one there. 0 or less if they are apart, 1 or more if one lies within the other.

    Args:
        dx, dy: from the first box's centre to the second one's.
        first, second: the boxes.

    Examples:
        >>> brick = Form(10.0, 4.0, 1.0, 0.0)
        >>> overlap_share(15.0, 0.0, brick, brick), overlap_share(24.0, 0.0, brick, brick)
        (0.25, -0.2)
    """
    least = 2.0
    for away, half, reach in _separating_axes(dx, dy, first, second):
        share = 0.5 * (half + reach - away) / min(half, reach)
        if share <= 0.0:
            return share
        least = min(least, share)
    return least


def gap_between(dx: float, dy: float, first: Form, second: Form) -> float:
    """How many pixels two boxes are apart on the separating axis that tells them apart best; below 0 if they overlap.

    Args:
        dx, dy: from the first box's centre to the second one's.
        first, second: the boxes.

    Examples:
        >>> brick = Form(10.0, 4.0, 1.0, 0.0)
        >>> gap_between(24.0, 3.0, brick, brick)
        4.0
    """
    return max(away - half - reach for away, half, reach in _separating_axes(dx, dy, first, second))


def _separating_axes(dx: float, dy: float, first: Form, second: Form) -> tuple[tuple[float, float, float], ...]:
    """Along each side of both boxes: how far apart centres are, and how far each box reaches from its own."""
    along = abs(first.cosine * second.cosine + first.sine * second.sine)
    aslant = abs(first.sine * second.cosine - first.cosine * second.sine)
    return (
        (abs(dx * first.cosine + dy * first.sine), first.across, second.across * along + second.down * aslant),
        (abs(dy * first.cosine - dx * first.sine), first.down, second.across * aslant + second.down * along),
        (abs(dx * second.cosine + dy * second.sine), second.across, first.across * along + first.down * aslant),
        (abs(dy * second.cosine - dx * second.sine), second.down, first.across * aslant + first.down * along),
    )
