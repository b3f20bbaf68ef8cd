"""Drawing compositions: particles where they are placed, turned and scaled, over the ground."""

import dataclasses
from collections.abc import Sequence

import numpy as np
import pytest
from scipy import ndimage

from jaxtex.core.colour import srgb_to_linear
from jaxtex.particles.composition import Composition, Exemplar, identify_exemplar
from jaxtex.particles.grounds import even_ground
from jaxtex.particles.painting import label_composition, paint_composition
from jaxtex.particles.things import Decomposition, describe_particles

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
    np.testing.assert_allclose(drawn[far], GROUND[far], atol=1e-5)


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


def scatter_discs() -> tuple[Decomposition, np.ndarray]:
    """Discs of their own colours, each with a shadow to its right on a grained ground, and rims in their colours."""
    row, column = np.indices((90, 120))
    labels, rng = np.zeros((90, 120), int), np.random.default_rng(0)
    picture = rng.uniform(0.45, 0.55, (90, 120, 3))
    for number, (y, x, radius) in enumerate([(22, 25, 9), (24, 58, 8), (62, 32, 12), (58, 82, 15), (20, 96, 8)], 1):
        away = np.hypot(row + 0.5 - y, column + 0.5 - x)
        rim = (away >= radius) & (away < radius + 4)
        picture[rim] = 0.5 * picture[rim] + 0.5 * rng.random(3)
        picture[rim & (column > x) & (np.abs(row - y) < 4)] = 0.05
        labels[away < radius], picture[away < radius] = number, rng.random(3)
    return describe_particles(labels, [0] * 5), picture.astype(np.float32)


DISCS, SCENE = scatter_discs()


def place(
    numbers: Sequence[int], x: Sequence[float], y: Sequence[float], angle: float = 0.0, periodic: bool = False
) -> Composition:
    count = len(numbers)
    exemplar = identify_exemplar(DISCS)
    zeros, ones = np.zeros(count, int), np.ones(count)
    return Composition(
        120, 90, periodic, exemplar, zeros, np.array(numbers), np.array(x), np.array(y), angle * ones, ones
    )


def test_particles_placed_as_they_were_bring_their_surroundings_back() -> None:
    boxes = [particle.box for particle in DISCS.particles]
    same = place(range(5), [box.x for box in boxes], [box.y for box in boxes])
    drawn = paint_composition(same, SCENE, DISCS, np.zeros_like(SCENE))
    evened = even_ground(SCENE, DISCS)
    away = ndimage.distance_transform_edt(DISCS.labels == 0)
    np.testing.assert_allclose(drawn[away == 0], SCENE[away == 0], atol=1e-5)
    near = (away >= 2) & (away <= 4)
    np.testing.assert_allclose(drawn[near], evened[near], atol=1e-5)


def test_shadows_turn_with_their_things() -> None:
    ground = np.full_like(SCENE, 0.5)
    drawn = paint_composition(place([3], [60.0], [45.0], np.pi / 2), SCENE, DISCS, ground)
    np.testing.assert_allclose(drawn[45 + 17, 60], 0.05, atol=0.03)
    assert np.abs(drawn[45, 60 + 17] - 0.05).min() > 0.1


def test_the_nearest_particles_halo_rules() -> None:
    """Whichever is placed first; far from the other each looks as if it were alone."""
    ground = np.full_like(SCENE, 0.5)
    x, y = [40.0, 40.0 + 9 + 12 + 7], [45.0, 45.0]
    both = paint_composition(place([0, 2], x, y), SCENE, DISCS, ground)
    np.testing.assert_allclose(paint_composition(place([2, 0], x[::-1], y), SCENE, DISCS, ground), both, atol=1e-5)
    left, right = (
        paint_composition(place([n], [at], [45.0]), SCENE, DISCS, ground) for n, at in zip((0, 2), x, strict=True)
    )
    np.testing.assert_allclose(both[40:50, 49:51], left[40:50, 49:51], atol=0.02)
    np.testing.assert_allclose(both[40:50, 54:56], right[40:50, 54:56], atol=0.02)


def test_halos_end_without_a_seam() -> None:
    """Over a ground of another colour, colours change little from pixel to pixel where a halo ends."""
    plain = np.where(DISCS.labels[..., None] > 0, 0.9, 0.5).astype(np.float32) * np.ones(3, np.float32)
    drawn = paint_composition(place([3], [60.0], [45.0]), plain, DISCS, np.full_like(plain, 0.3))
    away = np.hypot(*(np.indices((90, 120)) + 0.5 - np.array([45, 60])[:, None, None])) - 15
    steps = np.abs(np.diff(drawn[..., 0], axis=1))[away[:, 1:] > 4]
    assert np.ptp(drawn[..., 0][away > 4]) > 0.15
    assert steps.max() < 0.06


def test_turned_and_scaled_particles_have_no_specks() -> None:
    """Where halos have all but ended, they bring no colours that neither the picture nor the ground has."""
    bright, rng = 0.5 + 0.5 * SCENE, np.random.default_rng(2)
    many = place([0, 1, 2, 3, 4] * 60, rng.uniform(0, 600, 300), rng.uniform(0, 500, 300), periodic=True)
    turns, scales = rng.uniform(-3, 3, 300), rng.uniform(0.5, 1.5, 300)
    many = dataclasses.replace(many, width=600, height=500, angles=turns, scales=scales)
    drawn = paint_composition(many, bright, DISCS, np.full((500, 600, 3), 0.75))
    assert drawn.min() > bright.min() - 1e-3
    assert drawn.max() < bright.max() + 1e-3


def test_compositions_that_repeat_are_drawn_alike_wherever_they_begin() -> None:
    x, y, turns = np.array([10.0, 60.0, 100.0]), np.array([5.0, 45.0, 80.0]), (37, -52)
    ground = np.random.default_rng(1).random((90, 120, 3)).astype(np.float32)
    drawn = paint_composition(place([0, 2, 3], x, y, 0.5, True), SCENE, DISCS, ground)
    moved = place([0, 2, 3], (x + turns[1]) % 120, (y + turns[0]) % 90, 0.5, True)
    np.testing.assert_allclose(
        paint_composition(moved, SCENE, DISCS, np.roll(ground, turns, (0, 1))), np.roll(drawn, turns, (0, 1)), atol=1e-5
    )


def test_pictures_of_other_sizes_are_told() -> None:
    one = compose((0, 40.0, 25.0, 0.0, 1.0))
    with pytest.raises(ValueError, match=r"picture of shape .* that of the labels"):
        paint_composition(one, PICTURE[1:], THINGS, GROUND)
    with pytest.raises(ValueError, match="ground of shape"):
        paint_composition(dataclasses.replace(one, width=81), PICTURE, THINGS, GROUND)


def test_colours_are_factors_on_light() -> None:
    composed = dataclasses.replace(compose((1, 40.0, 25.0, 0.0, 1.0)), gains=np.array([[0.5, 2.0, 1.0]]))
    drawn = paint_composition(composed, PICTURE, THINGS, GROUND)
    light = srgb_to_linear(PICTURE[27, 41]) * np.array([0.5, 2.0, 1.0])
    np.testing.assert_allclose(srgb_to_linear(drawn[25, 40]), light, rtol=1e-4)
    np.testing.assert_array_equal(drawn[:10], GROUND[:10])
    grey = paint_composition(composed, PICTURE[..., :1], THINGS, GROUND[..., :1])
    assert srgb_to_linear(grey[25, 40, 0]) == pytest.approx(3.5 / 3 * srgb_to_linear(PICTURE[27, 41, 0]), rel=1e-4)


def test_on_the_ground_of_another_picture_things_lie_without_what_surrounds_them() -> None:
    wall = np.broadcast_to(np.float32([0.1, 0.9, 0.9]), GROUND.shape)
    bare, whole = (
        paint_composition(compose((0, 40.0, 25.0, 0.0, 1.0)), PICTURE, THINGS, wall, halos=halos)
        for halos in (False, True)
    )
    far = np.ones(GROUND.shape[:2], bool)
    far[20:30, 32:48] = False  # a particle of 12 x 6 with the two pixels of its edge
    np.testing.assert_array_equal(bare[far], wall[far])
    assert np.abs(whole - wall)[far].max() > 0.1
    np.testing.assert_allclose(bare[22:28, 34:46], PICTURE[10:16, 20:32], atol=1e-6)
