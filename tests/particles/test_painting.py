"""Drawing compositions: particles where they are placed, turned and scaled, over the ground."""

import dataclasses

import jax
import numpy as np
import pytest

from jaxtex.particles.composition import Composition, Exemplar
from jaxtex.particles.painting import label_composition, make_ground, paint_composition
from jaxtex.particles.things import describe_particles

KEY = jax.random.key(0)
LABELS = np.zeros((40, 60), int)
LABELS[10:16, 20:32], LABELS[25:33, 40:44] = 1, 2
THINGS = describe_particles(LABELS, [0, 0])
PICTURE = np.where(LABELS[..., None] > 0, [0.9, 0.1, 0.2], [0.3, 0.5, 0.4]).astype(np.float32)
PICTURE[10:16, 26:32] = 0.7  # the first particle's right half
GROUND = np.full((50, 80, 3), [0.3, 0.5, 0.4], np.float32)


def compose(*placed: tuple[int, float, float, float, float], periodic: bool = False) -> Composition:
    numbers, x, y, angles, scales = (np.array(each) for each in zip(*placed, strict=True))
    exemplar = Exemplar(60, 40, 2, "0" * 64)
    return Composition(80, 50, periodic, exemplar, np.zeros(len(x), int), numbers.astype(int), x, y, angles, scales)


def paint(*placed: tuple[int, float, float, float, float], periodic: bool = False) -> np.ndarray:
    return paint_composition(compose(*placed, periodic=periodic), PICTURE, THINGS, GROUND)


def test_particles_are_copied_where_their_boxes_are_placed() -> None:
    drawn = paint((0, 40.0, 25.0, 0.0, 1.0))
    np.testing.assert_allclose(drawn[22:28, 34:46], PICTURE[10:16, 20:32], atol=1e-6)
    far = np.ones((50, 80), bool)
    far[19:31, 31:49] = False
    np.testing.assert_array_equal(drawn[far], GROUND[far])


def test_later_particles_lie_over_earlier_ones() -> None:
    first, second = (0, 40.0, 25.0, 0.0, 1.0), (1, 40.0, 25.0, 0.0, 1.0)
    np.testing.assert_allclose(paint(first, second)[21:29, 38:42], PICTURE[25:33, 40:44], atol=1e-6)
    np.testing.assert_allclose(paint(second, first)[22:28, 34:46], PICTURE[10:16, 20:32], atol=1e-6)


def test_particles_are_turned_clockwise() -> None:
    """The right half of the first goes down."""
    drawn = paint((0, 40.0, 25.0, np.pi / 2, 1.0))
    np.testing.assert_allclose(drawn[20:24, 38:42], np.broadcast_to(PICTURE[12, 22], (4, 4, 3)), atol=1e-5)
    np.testing.assert_allclose(drawn[26:30, 38:42], np.broadcast_to(0.7, (4, 4, 3)), atol=1e-5)


@pytest.mark.parametrize("scale", [0.5, 2.0])
def test_particles_are_scaled_about_their_centres(scale: float) -> None:
    drawn = paint((0, 40.0, 25.0, 0.0, scale))
    covered = np.abs(drawn - GROUND).max(axis=2) > 0.15
    row, column = np.nonzero(covered)
    assert (column.mean() + 0.5, row.mean() + 0.5) == (pytest.approx(40, abs=0.6), pytest.approx(25, abs=0.6))
    # Edges are soft: half covered in the middle of the ramp.
    assert np.ptp(column) + 1 == pytest.approx(12 * scale, abs=3 * max(scale, 1))


def test_periodic_compositions_wrap_and_others_are_cut_off() -> None:
    wrapped, cut = (paint((0, 79.0, 1.0, 0.0, 1.0), periodic=each) for each in (True, False))
    np.testing.assert_allclose(np.roll(wrapped, (24, -39), (0, 1)), paint((0, 40.0, 25.0, 0.0, 1.0)))
    assert (cut[:, :40] == GROUND[:, :40]).all()
    np.testing.assert_allclose(cut[0, 76:], wrapped[0, 76:])


def test_labels_are_those_of_the_picture_where_they_are_placed() -> None:
    labels = label_composition(compose((1, 10.0, 12.0, 0.0, 1.0), (0, 76.5, 3.2, 0.0, 1.0), periodic=True), THINGS)
    expected = np.zeros((50, 80), int)
    expected[8:16, 8:12] = 1
    expected[0:6, 70:80] = expected[0:6, 0:2] = 2
    np.testing.assert_array_equal(labels, expected)


def test_later_labels_cover_earlier_ones_and_planes_cut_off() -> None:
    labels = label_composition(compose((0, 40.0, 25.0, 0.0, 1.0), (1, 40.0, 25.0, 0.0, 1.0)), THINGS)
    np.testing.assert_array_equal(labels[21:29, 38:42], 2)
    assert (labels == 1).sum() == 12 * 6 - 4 * 6
    cut = label_composition(compose((0, 79.0, 1.0, 0.0, 1.0), (0, -200.0, 0.0, 0.0, 1.0)), THINGS)
    assert (cut == 1).sum() == 7 * 4
    assert (cut == 2).sum() == 0


@pytest.mark.parametrize("angle", [0.0, 0.4, np.pi / 2])
@pytest.mark.parametrize("scale", [0.5, 1.0, 3.0])
def test_labels_are_turned_and_scaled(angle: float, scale: float) -> None:
    """Against which pixels' centres lie in the turned box."""
    labels = label_composition(compose((0, 40.0, 25.0, angle, scale)), THINGS)
    row, column = np.indices((50, 80)) + 0.5
    along = np.cos(angle) * (column - 40) + np.sin(angle) * (row - 25)
    across = np.cos(angle) * (row - 25) - np.sin(angle) * (column - 40)
    inside = np.maximum(np.abs(along) - 6 * scale, np.abs(across) - 3 * scale)
    assert (labels[inside < -0.8] == 1).all()
    assert (labels[inside > 0.8] == 0).all()


def test_ground_is_that_of_the_picture_without_its_things() -> None:
    grain = np.random.default_rng(0).uniform(0.3, 0.5, (40, 60, 1)).astype(np.float32)
    ground = make_ground(np.where(LABELS[..., None] > 0, 0.9, grain), THINGS, (70, 45), key=KEY)
    assert ground.shape == (45, 70, 1)
    assert ground.max() <= 0.5
    assert ground.std() == pytest.approx(grain.std(), rel=0.2)


def test_ground_in_narrow_gaps_has_the_colour_of_what_is_nearest() -> None:
    labels = np.kron(np.arange(1, 37).reshape(6, 6), np.ones((8, 8), int))
    labels[::8], labels[:, ::8] = 0, 0
    picture = np.where(labels[..., None] > 0, 0.9, 0.2)
    ground = make_ground(picture, describe_particles(labels, [0] * 36), (40, 40), key=KEY)
    np.testing.assert_allclose(ground, 0.2, atol=1e-6)


def test_pictures_of_other_sizes_are_told() -> None:
    one = compose((0, 40.0, 25.0, 0.0, 1.0))
    with pytest.raises(ValueError, match=r"picture of shape .* that of the labels"):
        paint_composition(one, PICTURE[1:], THINGS, GROUND)
    with pytest.raises(ValueError, match="ground of shape"):
        paint_composition(dataclasses.replace(one, width=81), PICTURE, THINGS, GROUND)
    with pytest.raises(ValueError, match="no pixel is ground"):
        make_ground(PICTURE, describe_particles(np.ones((40, 60), int), [0]), (20, 20), key=KEY)
