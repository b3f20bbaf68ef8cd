"""Compositions relaxed: particles moved until they lie around each other as those of the picture do."""

import dataclasses
from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.particles.composition import Composition, check_exemplar
from jaxtex.particles.contacts import (
    Contacts,
    forms_of,
    list_contacts,
    measure_least_gaps,
    press_apart,
    round_up,
)
from jaxtex.particles.pair_statistics import (
    Candidates,
    Goal,
    as_device,
    list_candidates,
    make_goal,
    measure_scales,
    miss_goal,
    pad_rows,
)
from jaxtex.particles.patterns import pattern_of_composition, pattern_of_picture
from jaxtex.particles.things import Decomposition

_ROUNDS = 16  # each with the neighbours of where particles are by then
_STEPS = 12  # of each round
_RATE = 0.03  # of the gradient, by which a step goes; each particle's part of what is missed is about 10 squares
_MOMENTUM = 0.8
_LONGEST = 0.05  # of the mean distance to nearest ones: no step goes further
_PRESSURE = 4.0  # how much boxes that are too close count beside what is missed
_MARGIN = 0.5  # of that distance: boxes further apart cannot be too close within a round
_AXES = 5  # along which ways are compared, turned from round to round by the golden ratio
_TURN = 0.5 * (5**0.5 - 1)


def relax_composition(
    composition: Composition,
    decomposition: Decomposition,
    *,
    fixed: npt.ArrayLike | None = None,
    rounds: int = _ROUNDS,
    report: Callable[[int, int], None] | None = None,
) -> Composition:
    """Move particles by gradient until they lie around each other, within and between classes, as in the picture.

    For each class and each other, the ways from particles to the nearest one and to those around are matched as
    distributions (see `jaxtex.particles.pair_statistics`). Boxes that come closer to each other than is usual in the
    picture are pressed apart. Particles keep their class, number, angle and scale, and none is added or taken away.
    That corrects what seeding cannot know (Dischler et al., section 5): how classes lie to each other.

    Distances are the picture's, in its pixels: what controls have made denser or larger is drawn back to these, and a
    composition is relaxed before it is drawn at another resolution.

    Args:
        composition: of the particles of `decomposition`, as `seed_composition` makes it without controls.
        decomposition: the picture taken apart.
        fixed: which particles stay where they are, bool [placed]; by default none.
        rounds: how often neighbours are looked up anew; 0 leaves all as it is.
        report: called with the number of rounds that are done, and of all.

    Returns:
        The composition with particles moved.

    Raises:
        InputError: the composition is made of another picture's particles.
        ValueError: `fixed` is not one to each particle, or `rounds` is below 0.

    Examples:
        >>> from jaxtex.particles.arrangement import learn_arrangement
        >>> from jaxtex.particles.seeding import seed_composition
        >>> from jaxtex.particles.things import describe_particles
        >>> row, column = np.indices((120, 160))
        >>> labels = np.where((row % 12 < 8) & (column % 20 < 15), 1 + row // 12 * 8 + column // 20, 0)
        >>> bricks = describe_particles(labels, [0] * 80)
        >>> wall = seed_composition(
        ...     bricks, learn_arrangement(bricks), (200, 120), key=jax.random.key(0), tileable=True
        ... )
        >>> moved = dataclasses.replace(wall, x=wall.x + np.random.default_rng(0).normal(0, 1, len(wall)))
        >>> off = [(each.x - wall.x + 10) % 20 - 10 for each in (moved, relax_composition(moved, bricks))]
        >>> bool(off[1].std() < 0.8 * off[0].std())
        True
    """
    check_exemplar(composition, decomposition)
    if rounds < 0:
        raise ValueError(f"rounds is {rounds}; give 0 or more")
    held = np.zeros(len(composition), bool) if fixed is None else np.asarray(fixed, bool)
    if held.shape != (len(composition),):
        raise ValueError(f"fixed of shape {held.shape}: give one to each of the {len(composition)} placed particles")
    if len(composition) < 2:
        return composition
    exemplar, kinds = pattern_of_picture(decomposition), decomposition.kinds
    members = np.bincount(composition.kinds, minlength=kinds)
    room, class_room = round_up(len(composition)), round_up(int(members.max()))
    own = forms_of(decomposition)
    least, scales = measure_least_gaps(exemplar, own, kinds), measure_scales(exemplar, kinds)
    known = list_candidates(exemplar, kinds, round_up(int(np.bincount(exemplar.kinds).max())))
    there = as_device(pad_rows(exemplar.points, round_up(len(exemplar.points))))
    forms = own[composition.particles]
    forms[:, :2] *= composition.scales[:, None]
    # Boxes that interlock in the picture do not elsewhere, so that what is further apart at first stays so.
    least = np.maximum(least, measure_least_gaps(pattern_of_composition(composition), forms, kinds))
    # A class of one alone tells nothing of distances.
    units = np.asarray(scales.unit).reshape(kinds, kinds).diagonal()
    several = np.bincount(exemplar.kinds, minlength=kinds) > 1
    unit = float(units[several].min()) if several.any() else 1.0
    free = as_device(pad_rows(1.0 - held.astype(float), room))
    for turn in range(rounds):
        angles = np.pi * (np.arange(_AXES) + turn * _TURN % 1) / _AXES
        axes = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        goal = make_goal(there, known, scales, axes, members.repeat(kinds))
        pattern = pattern_of_composition(composition)
        start = pad_rows(pattern.points, room)
        moved = _descend(
            as_device(start),
            free,
            list_candidates(pattern, kinds, class_room),
            goal,
            list_contacts(pattern, forms, least, _MARGIN * unit, room),
            jnp.asarray(_LONGEST * unit),
        )
        steps = np.asarray(moved, float)[: len(composition)] - pattern.points
        composition = _move(composition, np.where(held[:, None], 0.0, steps))
        if report is not None:
            report(turn + 1, rounds)
    return composition


@jax.jit
def _descend(
    start: Array, free: Array, candidates: Candidates, goal: Goal, contacts: Contacts, longest: Array
) -> Array:
    """Steps down the gradient, with momentum."""

    def miss(points: Array) -> Array:
        return miss_goal(points, candidates, goal) + _PRESSURE * press_apart(points, contacts)

    def step(state: tuple[Array, Array], _: None) -> tuple[tuple[Array, Array], None]:
        points, speed = state
        speed = _MOMENTUM * speed - _RATE * free[:, None] * jax.grad(miss)(points)
        length = jnp.sqrt(jnp.square(speed).sum(axis=1, keepdims=True) + 1e-12)
        speed *= jnp.minimum(1.0, longest / length)
        return (points + speed, speed), None

    (points, _), _ = jax.lax.scan(step, (start, jnp.zeros_like(start)), None, length=_STEPS)
    return points


def _move(composition: Composition, steps: npt.NDArray[np.floating]) -> Composition:
    x, y = composition.x + steps[:, 0], composition.y + steps[:, 1]
    if composition.periodic:
        x, y = x % composition.width, y % composition.height
    return dataclasses.replace(composition, x=x, y=y)
