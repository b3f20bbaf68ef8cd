"""The nodes of a lattice may be seen as rows in several ways; all of them are the same nodes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxtex.photo.courses import Courses, same_courses
from jaxtex.photo.lattice import Lattice, joint_distances, list_rows, to_strips, turn_upright


def make(width, height, offset, bond="raking", angle=0.3):
    return Lattice(
        tilt=np.zeros(2), angle=angle, shear=0.0, height=height, width=width, start=np.zeros(2), offset=offset,
        course_offsets=np.zeros(1), course_lengths=np.ones((1, 1)), bond=bond, joints=(2.0, 2.0), score=0.0,
    )  # fmt: skip


@given(
    width=st.floats(20, 90), height=st.floats(20, 90), offset=st.floats(0, 1), at=st.tuples(*[st.integers(-3, 3)] * 2)
)
def test_every_node_lies_on_a_row_of_every_reading(width, height, offset, at):
    lattice = make(width, height, offset)
    d = np.array([np.cos(0.3), np.sin(0.3)])
    n = np.array([-d[1], d[0]])
    node = (at[0] + offset * at[1]) * width * d + at[1] * height * n
    for angle, pitch in list_rows(lattice)[1:]:
        across = node @ np.array([-np.sin(angle), np.cos(angle)]) / pitch
        assert across == pytest.approx(np.round(across), abs=1e-6)


def test_narrow_tiles_in_running_bond_are_found_from_their_slanting_rows():
    # Of a wall of 24 x 48 tiles the spectrum shows rows of nodes 24 apart, two courses high.
    slanting = make(np.hypot(12, 48), 24 * 48 / np.hypot(12, 48), -24 * 12 / np.hypot(12, 48) ** 2, angle=0.0)
    turned = np.arctan2(48, 12)
    found = [(abs(np.sin(angle + turned)), pitch) for angle, pitch in list_rows(slanting)]
    assert any(sine < 1e-6 and pitch == pytest.approx(48) for sine, pitch in found)


def test_a_bond_without_one_lattice_only_offers_every_second_course():
    assert list_rows(make(50, 20, 0.0, bond="irregular")) == [(0.3, 40)]


def test_slack_asks_for_closer_agreement():
    one = Courses(np.zeros(2), 0.0, 50.0, 1.0, "mask")
    other = one._replace(angle=0.04)
    assert same_courses(one, other, 256)
    assert not same_courses(one, other, 256, slack=0.3)


def test_a_stack_bond_turned_upright_has_the_same_joints():
    rng = np.random.default_rng(0)
    lattice = make(30.0, 50.0, 0.0, bond="raking", angle=1.9)._replace(start=np.array([4.0, -7.0]))
    upright = turn_upright(lattice)
    assert (upright.width, upright.height) == (50.0, 30.0)
    x, y = rng.uniform(-100, 100, (2, 200))
    was, now = (np.stack(joint_distances(each, *to_strips(each, x, y))) for each in (lattice, upright))
    np.testing.assert_allclose(now, was[::-1], atol=1e-9)


@pytest.mark.parametrize("lattice", [make(30, 50, 0.5, angle=1.9), make(30, 50, 0.0, angle=0.3)])
def test_other_lattices_are_not_turned(lattice):
    assert turn_upright(lattice) is lattice
