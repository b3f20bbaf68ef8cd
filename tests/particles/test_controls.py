"""Particles placed under controls: each does what it says, measured on lattices and things strewn at random."""

from collections.abc import Sequence

import jax
import numpy as np
import pytest
from drawn_lattices import draw_things, lattice, measure_lattice, poisson_disc, turn
from scipy.spatial import cKDTree

from jaxtex.particles.arrangement import learn_arrangement
from jaxtex.particles.composition import Composition
from jaxtex.particles.controls import Control, combine_controls
from jaxtex.particles.fields import linear_field, map_field, radial_field
from jaxtex.particles.painting import label_composition, paint_composition
from jaxtex.particles.seeding import seed_composition
from jaxtex.particles.things import Decomposition, describe_particles

SIZE, LARGE = (220, 200), (700, 700)
SQUARE, BRICKS = [(24.7, 0.0), (0.0, 24.7)], [(40.4, 0.0), (20.2, 17.6), (-20.2, 17.6)]
DISCS = draw_things(lattice(*SQUARE, SIZE), SIZE, width=15, height=15, discs=True)
WALL = draw_things(lattice(*BRICKS[:2], SIZE), SIZE, width=34, height=12)
STREWN = draw_things(poisson_disc(SIZE, 21, np.random.default_rng(1)), SIZE, width=14, height=14, discs=True)


def seed(things: Decomposition, *controls: Control, size: tuple[int, int] = LARGE, **choices) -> Composition:
    arrangement = learn_arrangement(things)
    return seed_composition(things, arrangement, size, key=jax.random.key(0), controls=controls, **choices)


def places(composition: Composition) -> np.ndarray:
    return np.stack([composition.x, composition.y], axis=1)


def inside(composition: Composition) -> np.ndarray:
    return (composition.x >= 0) & (composition.x < LARGE[0]) & (composition.y >= 0) & (composition.y < LARGE[1])


def assert_equal(one: Composition, other: Composition) -> None:
    for name in ("kinds", "particles", "x", "y", "angles", "scales", "gains"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_controls_that_ask_for_nothing_change_nothing_but_the_chances() -> None:
    whole = seed(WALL)
    assert (whole.scales == 1).all()
    assert (whole.angles == 0).all()
    assert (whole.gains == 1).all()
    assert_equal(seed(WALL, Control(size=2.0, classes=[])), whole)
    for control in (Control(), Control(size=3.0, where=0.0)):
        made = seed(WALL, control)
        assert (made.scales == 1).all()
        turned, stretched, missing = measure_lattice(places(made), BRICKS, LARGE)
        assert turned < 2
        assert max(stretched, missing) < 0.02
        assert inside(made).sum() == pytest.approx(inside(whole).sum(), rel=0.03)


@pytest.mark.parametrize("things", [DISCS, WALL, STREWN], ids=["lattice", "wall", "strewn"])
@pytest.mark.parametrize("density", [0.25, 0.5, 2.0, 4.0])
def test_density_is_particles_per_area(things: Decomposition, density: float) -> None:
    made, plain = seed(things, Control(density=density)), seed(things)
    assert inside(made).sum() / inside(plain).sum() == pytest.approx(density, rel=0.12)
    assert (made.scales == 1).all()


def test_what_is_hardly_there_is_left_out_at_random() -> None:
    counts = [inside(seed(STREWN, Control(density=density))).sum() for density in (1.0, 1 / 16, 1 / 32, 0.0)]
    assert counts[1] == pytest.approx(counts[0] / 16, rel=0.2)
    assert counts[2] == pytest.approx(counts[1] / 2, rel=0.4)
    assert counts[3] == 0


@pytest.mark.parametrize("factor", [{"density": 2.0}, {"density": 0.5}, {"size": 1.5}, {"size": 0.6}])
def test_lattices_stay_lattices(factor: dict) -> None:
    spacing = factor.get("size", 1.0) * factor.get("density", 1.0) ** -0.5
    vectors = [(spacing * x, spacing * y) for x, y in BRICKS]
    turned, stretched, missing = measure_lattice(places(seed(WALL, Control(**factor))), vectors, LARGE)
    assert turned < 2
    assert stretched < 0.02
    assert missing < 0.05


@pytest.mark.parametrize("angle", [25.0, -70.0, 180.0])
def test_orientation_turns_particles_with_their_surroundings(angle: float) -> None:
    made = seed(WALL, Control(orientation=np.radians(angle)))
    np.testing.assert_allclose(made.angles, np.radians(angle))
    turned, stretched, missing = measure_lattice(places(made), turn(BRICKS, angle), LARGE)
    assert turned < 2
    assert stretched < 0.02
    assert missing < 0.05


def test_size_and_angle_follow_their_fields_exactly() -> None:
    size, angle = linear_field((0, 0), (700, 0), 1.0, 0.5), linear_field((0, 0), (0, 700), 0.0, 0.6)
    made = seed(DISCS, Control(size=size, orientation=angle))
    x, y = np.clip(places(made), 0, 700).T
    np.testing.assert_allclose(made.scales, size(x, y))
    np.testing.assert_allclose(made.angles, angle(x, y))


def test_spacing_follows_the_size() -> None:
    size = linear_field((0, 0), (700, 0), 1.2, 0.4)
    made = seed(STREWN, Control(size=size))
    made = made.select(inside(made))
    nearest = cKDTree(places(made)).query(places(made), 2)[0][:, 1]
    slope, start = np.polyfit(size(made.x, made.y), nearest, 1)
    plain = seed(STREWN)
    usual = cKDTree(places(plain)).query(places(plain), 2)[0][:, 1].mean()
    assert slope == pytest.approx(usual, rel=0.15)
    assert abs(start) < 0.15 * usual


def test_lattices_turn_with_the_place() -> None:
    """A square lattice whose rows bend: the way to the nearest one is turned as the field says."""
    made = seed(DISCS, Control(orientation=linear_field((0, 0), (700, 0), 0.0, 0.5)))
    points = places(made)
    _, index = cKDTree(points).query(points, 5)
    inner = ((points > 60) & (points < 640)).all(axis=1)
    ways = (points[index[inner][:, 1:]] - points[inner][:, None]) @ np.array([1, 1j])
    expected = np.exp(4j * made.angles[inner])
    off = np.angle((ways / np.abs(ways)) ** 4 * expected.conj()[:, None]) / 4
    assert abs(np.degrees(off.mean())) < 2
    assert np.degrees(np.median(np.abs(off))) < 6


def test_no_centre_lies_where_none_may_and_the_rest_is_kept() -> None:
    whole = seed(STREWN)
    mask = np.zeros((700, 700), bool)
    mask[200:400, 300:500] = True
    for part, expected in ((map_field(~mask, LARGE), ~mask), (map_field(mask, LARGE), mask)):
        made = seed(STREWN, Control(probability=part))
        row, column = (np.clip(np.floor(each), 0, 699).astype(int) for each in (whole.y, whole.x))
        assert_equal(made, whole.select(expected[row, column]))
        assert 0 < len(made) < len(whole)
    by_region = seed(STREWN, Control(probability=0.0, where=map_field(mask, LARGE)))
    assert_equal(by_region, seed(STREWN, Control(probability=map_field(~mask, LARGE))))


def test_who_is_seen_is_seen_at_all_higher_probabilities() -> None:
    whole = seed(STREWN)
    seen = []
    for probability in (0.2, 0.5, 0.8):
        made = seed(STREWN, Control(probability=probability))
        assert len(made) / len(whole) == pytest.approx(probability, abs=0.06)
        seen.append({tuple(each) for each in places(made)})
    assert seen[0] < seen[1] < seen[2] < {tuple(each) for each in places(whole)}


@pytest.mark.parametrize("tileable", [False, True])
def test_centres_keep_their_distance(tileable: bool) -> None:
    made = seed(STREWN, Control(least_distance=40.0), Control(least_distance=30.0), tileable=tileable)
    box = LARGE if tileable else None
    assert cKDTree(places(made), boxsize=box).query(places(made), 2)[0][:, 1].min() >= 40
    assert inside(made).sum() > 0.3 * np.prod(LARGE) / 40**2


def test_a_denser_disc_is_denser_and_the_rest_is_not() -> None:
    disc = radial_field((350, 350), 200, 1.0, 0.0, softness=0.0)
    made, plain = seed(STREWN, Control(density=3.0, where=disc)), seed(STREWN)
    within = [(np.hypot(*(places(each) - 350).T) < 180).sum() for each in (made, plain)]
    beyond = [(inside(each) & (np.hypot(*(places(each) - 350).T) > 230)).sum() for each in (made, plain)]
    assert within[0] / within[1] == pytest.approx(3, rel=0.15)
    assert beyond[0] / beyond[1] == pytest.approx(1, rel=0.1)


def draw_two_sorts() -> Decomposition:
    points = poisson_disc(SIZE, 21, np.random.default_rng(1))
    things = draw_things(points, SIZE, width=14, height=14, discs=True)
    count = len(things.particles)
    return describe_particles(things.labels, np.arange(count) % 2)


def test_classes_are_controlled_apart() -> None:
    things = draw_two_sorts()
    plain = seed(things)
    made = seed(things, Control(classes=[1], density=0.5, colour=(2.0, 0.0, 1.0)))
    of_class = made.kinds == 1
    assert_equal(made.select(~of_class), plain.select(plain.kinds == 0))
    assert (inside(made) & of_class).sum() / (inside(plain) & (plain.kinds == 1)).sum() == pytest.approx(0.5, rel=0.1)
    np.testing.assert_array_equal(made.gains[of_class], np.broadcast_to([2.0, 0.0, 1.0], (of_class.sum(), 3)))
    assert (made.gains[~of_class] == 1).all()


def test_particles_are_chosen_by_weight() -> None:
    members = learn_arrangement(STREWN).classes[0].members
    chosen = members[3]
    half = radial_field((0, 350), 350, 1.0, 0.0, softness=0.0)
    only = {number: 0.0 for number in members if number != chosen}
    made = seed(STREWN, Control(weights=only, where=half))
    within = np.hypot(made.x, made.y - 350) < 330
    assert (made.particles[within] == chosen).all()
    beyond = made.particles[np.hypot(made.x, made.y - 350) > 370]
    assert (beyond == chosen).mean() < 3 / len(members)
    shares = seed(STREWN, Control(weights={chosen: len(members) - 1.0})).particles == chosen
    assert shares.mean() == pytest.approx(0.5, abs=0.06)
    never = seed(STREWN, Control(weights={chosen: 0.0})).particles
    assert chosen not in never


def test_variations_are_as_large_as_is_said() -> None:
    made, plain = seed(STREWN, Control(size_variation=0.4, orientation_variation=0.3)), seed(STREWN)
    assert 0.6 <= made.scales.min() < 0.64
    assert 1.36 < made.scales.max() <= 1.4
    assert -0.3 <= made.angles.min() < -0.27
    assert 0.27 < made.angles.max() <= 0.3
    assert np.corrcoef(made.scales, made.angles)[0, 1] == pytest.approx(0, abs=0.15)
    assert inside(made).sum() == pytest.approx(inside(plain).sum(), rel=0.1)


def test_things_of_random_sizes_stay_where_they_are_and_do_not_overlap() -> None:
    made = seed(DISCS, Control(size_variation=0.6))
    turned, stretched, missing = measure_lattice(places(made), SQUARE, LARGE)
    assert turned < 2
    assert stretched < 0.02
    assert missing < 0.2
    radii = 7.5 * made.scales
    points = places(made)
    for index, near in enumerate(cKDTree(points).query(points, 5)[1][:, 1:]):
        gaps = np.hypot(*(points[near] - points[index][None]).T) - radii[near] - radii[index]
        # Of the smaller box with its clearance, on either side, as for all particles.
        assert gaps.min() > -0.15 * 2 * radii.max()


def test_several_controls_act_together() -> None:
    x = np.array([0.0, 10.0])
    half = Control(size=3.0, density=4.0, probability=0.0, orientation=0.4, colour=(3.0, 1.0, 1.0), where=0.5)
    both = combine_controls([half, Control(size=0.5, orientation=-0.1, least_distance=3.0)], x, x)
    np.testing.assert_allclose(both.size, 1.0)
    np.testing.assert_allclose(both.spacing, 2.5**-0.5)
    np.testing.assert_allclose(both.orientation, 0.1)
    np.testing.assert_allclose(both.probability, 0.5)
    np.testing.assert_allclose(both.gains, [[2.0, 1.0, 1.0]] * 2)
    np.testing.assert_allclose(both.least_distance, 3.0)


def test_wraps_of_an_angle_are_no_jumps() -> None:
    """Particles around a centre, as arctan2 has them: nothing happens where its angles jump by a whole turn."""
    made = seed(DISCS, Control(orientation=lambda x, y: np.arctan2(y - 350.5, x - 350.5)))
    points = places(made)
    gaps = [
        cKDTree(points).query(350.5 + 250 * np.array([[np.cos(a), np.sin(a)]]))[0][0]
        for a in np.linspace(-0.2, 0.2, 41)
    ]
    across_the_jump = [
        cKDTree(points).query(350.5 - 250 * np.array([[np.cos(a), np.sin(a)]]))[0][0]
        for a in np.linspace(-0.2, 0.2, 41)
    ]
    assert np.mean(across_the_jump) == pytest.approx(np.mean(gaps), rel=0.35)


def test_dots_of_one_picture_lie_on_the_joints_of_another() -> None:
    """Figure 11: leaves are kept only where they are centred on the mortar."""
    bricks = seed(WALL)
    joints = label_composition(bricks, WALL) == 0
    assert 0.2 < joints.mean() < 0.7
    dots, anywhere = seed(STREWN, Control(density=2.0), Control(probability=map_field(joints, LARGE))), seed(STREWN)
    row, column = (np.clip(np.floor(each), 0, 699).astype(int) for each in (dots.y, dots.x))
    assert joints[row, column].all()
    assert inside(dots).sum() / inside(anywhere).sum() == pytest.approx(2 * joints.mean(), rel=0.15)
    picture, ground = np.where(STREWN.labels > 0, 1.0, 0.0)[..., None], np.full((*joints.shape, 1), 0.5, np.float32)
    drawn = paint_composition(dots, picture, STREWN, ground)[..., 0]
    assert (drawn[row, column][inside(dots)] > 0.9).all()


@pytest.mark.parametrize(
    ("controls", "complaint"),
    [
        ([Control(size=0.0)], "size is 0; give 0.001 to 1000"),
        (
            [Control(size=linear_field((0, 0), (700, 0), 1.0, -1.0))],
            r"size is -?\d.* at \(\d+, 1\); give 0.001 to 1000",
        ),
        ([Control(probability=1.5)], "probability is 1.5; give 0 to 1"),
        ([Control(density=-1.0)], "density is -1; give 0 or more"),
        ([Control(where=lambda x, y: x)], r"where is \d.* at \(\d+, 1\); give 0 to 1"),
        ([Control(size_variation=1.0)], "size_variation is 1; give 0 to 0.95"),
        ([Control(orientation=np.nan)], "orientation: holds a number that is not finite"),
        ([Control(classes=[1])], r"classes \[1\] of control 1: name classes from 0 to 0"),
        ([Control(weights={999: 1.0})], r"weights of particles \[999\] in control 1: name particles from 0 to"),
        (
            [Control(weights=dict.fromkeys(range(len(STREWN.particles)), 0.0))],
            "weights: leave no complete particle",
        ),
    ],
)
def test_controls_that_cannot_be_are_told(controls: Sequence[Control], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        seed(STREWN, *controls)


def test_wrong_numbers_are_told_when_a_control_is_made() -> None:
    with pytest.raises(ValueError, match="colour: has 2 numbers"):
        Control(colour=(1.0, 2.0))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="weights: that of particle 3 is -1"):
        Control(weights={3: -1.0})
