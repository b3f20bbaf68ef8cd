"""Boxes that come close to each other: by how much they are apart, of many pairs at once, and as a penalty."""

from typing import NamedTuple, overload

import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array
from scipy.spatial import cKDTree

from jaxtex.particles.boxes import form_of
from jaxtex.particles.pair_statistics import as_device, pad_rows
from jaxtex.particles.patterns import Pattern
from jaxtex.particles.things import Decomposition

Floats = npt.NDArray[np.floating]

_CLOSEST = 0.1  # of all particles: how many are closer to another one than others are kept apart


class Contacts(NamedTuple):
    """Pairs of boxes.

    Attributes:
        first, second: numbers of points, [pair].
        wraps: what is added to the way from the first to the second where the plane repeats, [pair, (x, y)].
        forms: half the width, half the height, cosine and sine of each point's box, [point, 4].
        least: pixels that the boxes of a pair are to be apart at least, below 0 where they may overlap, [pair].
    """

    first: Array
    second: Array
    wraps: Array
    forms: Array
    least: Array


@overload
def gaps_between(ways: Array, first: Array, second: Array) -> Array: ...
@overload
def gaps_between(ways: Floats, first: Floats, second: Floats) -> Floats: ...
def gaps_between(ways: Array | Floats, first: Array | Floats, second: Array | Floats) -> Array | Floats:
    """By how much boxes are apart, as `boxes.gap_between` has it: of many pairs at once, of NumPy or of JAX.

    Args:
        ways: from the first box's centre to the second one's, [pair, (x, y)].
        first, second: half the width, half the height, cosine and sine of the boxes, [pair, 4].

    Examples:
        >>> brick = jnp.array([[10.0, 4.0, 1.0, 0.0]])
        >>> gaps_between(jnp.array([[24.0, 3.0]]), brick, brick).tolist()
        [4.0]
    """
    (across, down, cosine, sine), (other_across, other_down, other_cosine, other_sine) = first.T, second.T
    along, aslant = abs(cosine * other_cosine + sine * other_sine), abs(sine * other_cosine - cosine * other_sine)
    x, y = ways.T
    # How many pairs there are changes from call to call, for which JAX would compile anew each time.
    stack = np.stack if isinstance(ways, np.ndarray) else jnp.stack
    return stack(
        [
            abs(x * cosine + y * sine) - across - other_across * along - other_down * aslant,
            abs(y * cosine - x * sine) - down - other_across * aslant - other_down * along,
            abs(x * other_cosine + y * other_sine) - other_across - across * along - down * aslant,
            abs(y * other_cosine - x * other_sine) - other_down - across * aslant - down * along,
        ]
    ).max(axis=0)


def forms_of(decomposition: Decomposition) -> Floats:
    """Half the width, half the height, cosine and sine of each particle's box, [particle, 4]."""
    return np.array([form_of(particle.box) for particle in decomposition.particles], float).reshape(-1, 4)


def measure_least_gaps(pattern: Pattern, forms: Floats, kinds: int) -> Floats:
    """How close boxes of two classes come as a rule, pixels, [class, class]; 0 where none are near each other."""
    pairs, wraps = _pair_up(pattern, forms, 0.0)
    whole = pattern.known[pairs].all(axis=1)
    pairs, wraps = pairs[whole], wraps[whole]
    gaps = _measure(pattern, forms, pairs, wraps)
    least = np.zeros((kinds, kinds))
    for kind in range(kinds):
        for other in range(kind, kinds):
            of_both = (np.sort(pattern.kinds[pairs], axis=1) == np.array([[kind, other]])).all(axis=1)
            closest = np.full(len(forms), np.inf)
            for side in (0, 1):
                np.minimum.at(closest, pairs[of_both, side], gaps[of_both])
            closest = closest[np.isfinite(closest)]
            least[kind, other] = least[other, kind] = np.quantile(closest, _CLOSEST) if len(closest) else 0.0
    return least


def list_contacts(pattern: Pattern, forms: Floats, least: Floats, margin: float, points: int) -> Contacts:
    """All pairs of boxes that are less than a margin further apart than they have to be.

    Args:
        pattern: points.
        forms: of their boxes, as `Contacts` has them.
        least: pixels that boxes of two classes are to be apart at least, [class, class].
        margin: pixels.
        points: length that `forms` is padded to.
    """
    pairs, wraps = _pair_up(pattern, forms, max(0.0, float(least.max())) + margin)
    asked = least[pattern.kinds[pairs[:, 0]], pattern.kinds[pairs[:, 1]]]
    near = _measure(pattern, forms, pairs, wraps) < asked + margin
    room = round_up(int(near.sum()))
    # What it is padded with is one point and itself, which need not be apart.
    least_of = np.full(room, -np.inf)
    least_of[: near.sum()] = asked[near]
    columns = (pad_rows(each, room) for each in (pairs[near, 0], pairs[near, 1], wraps[near]))
    first, second, shifts = (as_device(each) for each in columns)
    return Contacts(first, second, shifts, as_device(pad_rows(forms, points)), as_device(least_of))


def round_up(count: int) -> int:
    """A length to pad to: there are two to each doubling, so that few are compiled for."""
    return int(np.ceil(2.0 ** (0.5 * np.ceil(2 * np.log2(max(count, 16))))))


def press_apart(points: Array, contacts: Contacts) -> Array:
    """By how much boxes are closer than they are to be: half of square pixels, summed; differentiable in `points`."""
    ways = points[contacts.second] - points[contacts.first] + contacts.wraps
    gaps = gaps_between(ways, contacts.forms[contacts.first], contacts.forms[contacts.second])
    return 0.5 * jnp.square(jnp.maximum(contacts.least - gaps, 0.0)).sum()


def _pair_up(pattern: Pattern, forms: Floats, margin: float) -> tuple[npt.NDArray[np.intp], Floats]:
    """All pairs of points whose boxes may be that near, and what is added to the ways between them."""
    reach = 2 * float(np.hypot(forms[:, 0], forms[:, 1]).max(initial=0.0)) + margin
    if pattern.period is not None:
        reach = min(reach, 0.49 * min(pattern.period))
    pairs = cKDTree(pattern.points, boxsize=pattern.period).query_pairs(reach, output_type="ndarray")
    ways = pattern.points[pairs[:, 1]] - pattern.points[pairs[:, 0]]
    if pattern.period is None:
        return pairs, np.zeros_like(ways)
    return pairs, -np.round(ways / np.array(pattern.period)[None]) * np.array(pattern.period)[None]


def _measure(pattern: Pattern, forms: Floats, pairs: npt.NDArray[np.intp], wraps: Floats) -> Floats:
    first, second = pairs.T
    along = pattern.points[second] - pattern.points[first] + wraps
    return gaps_between(along, forms[first], forms[second])
