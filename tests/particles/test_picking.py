"""Things by their colours: classes as picked, whatever the ground is, and in both spaces."""

import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.particles.picking import pick_particles

SHAPE = 120, 160
RED, BLUE, GREY, SAND = np.array([[0.5, 0.05, 0.05], [0.05, 0.08, 0.5], [0.2, 0.2, 0.2], [0.6, 0.5, 0.3]])


def draw_spots(reds: int, blues: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """A grainy picture of spots on sand, and which of them a pixel is in: 1 red, 2 blue."""
    places = [(10 + 20 * (i % 7), 10 + 20 * (i // 7)) for i in range(reds + blues)]
    row, column = np.indices(SHAPE) + 0.5
    truth = np.zeros(SHAPE, int)
    for number, (x, y) in enumerate(places):
        truth[np.hypot(row - y, column - x) < 7] = 1 if number < reds else 2
    picture = np.stack([SAND, RED, BLUE])[truth]
    return picture * np.random.default_rng(seed).lognormal(0, 0.15, (*SHAPE, 1)), truth


@pytest.mark.parametrize("distance", ["lab", "rgb"])
@pytest.mark.parametrize("told", [True, False])
def test_each_picked_colour_is_a_class(distance: str, told: bool) -> None:
    picture, truth = draw_spots(12, 9)
    found = pick_particles(picture, [[BLUE], [RED]], [SAND] if told else None, distance=distance)
    counts = np.bincount([each.kind for each in found.particles])
    assert counts.tolist() == [9, 12]
    assert np.mean((found.labels > 0) == (truth > 0)) > 0.97


def test_a_class_may_have_several_colours_and_unpicked_things_are_ground() -> None:
    picture, truth = draw_spots(12, 9)
    assert len(pick_particles(picture, [[RED, BLUE]], [SAND]).particles) == 21
    only_red = pick_particles(picture, [[RED]], [SAND, BLUE])
    assert len(only_red.particles) == 12
    assert not np.any((only_red.labels > 0) & (truth == 2))


def test_a_colour_that_nothing_has_leaves_no_gap_in_the_classes() -> None:
    picture, _ = draw_spots(5, 0)
    found = pick_particles(picture, [[[0.0, 0.9, 0.0]], [RED]], [SAND])
    assert found.kinds == 1
    assert {each.kind for each in found.particles} == {0}


def test_grey_pictures() -> None:
    picture, _ = draw_spots(8, 0)
    assert len(pick_particles(picture.mean(axis=-1), [[[RED.mean()]]]).particles) == 8


def test_what_cannot_be_picked() -> None:
    picture, _ = draw_spots(5, 0)
    with pytest.raises(InputError, match="nothing has these colours"):
        pick_particles(np.ones((40, 40, 3)) * SAND, [[RED]], [SAND])
    with pytest.raises(ValueError, match="no colour"):
        pick_particles(picture, [])
    with pytest.raises(ValueError, match="no colour"):
        pick_particles(picture, [[]])
    with pytest.raises(InputError, match="channel"):
        pick_particles(picture, [[[0.5]]])
    with pytest.raises(ValueError, match="smoothing"):
        pick_particles(picture, [[RED]], smoothing=-1)
