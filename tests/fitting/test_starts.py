"""Vectors, user's choices and seamless pictures: what surrounds a solve."""

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxtex.core.errors import InputError
from jaxtex.fitting.choices import apply_choices, check_choices
from jaxtex.fitting.parameters import SCALARS, from_free, place, read_free, to_free
from jaxtex.fitting.start import start_fit
from jaxtex.fitting.wrap import repeat_with_picture
from jaxtex.photo.lattice import Lattice

VALUES = dict.fromkeys(SCALARS, 0.0) | {"tile_width": 40.0, "tile_height": 20.0, "mortar_x": 3.0, "offset": 0.5}


def lattice(**changes) -> Lattice:
    plain = Lattice(
        tilt=np.zeros(2),
        angle=0.0,
        shear=0.0,
        height=20.0,
        width=40.0,
        start=np.array([-7.0, -130.0]),
        offset=0.5,
        course_offsets=np.zeros(1),
        course_lengths=np.ones((1, 1)),
        bond="raking",
        joints=(3.0, 3.0),
        score=1.0,
    )
    return plain._replace(**changes)


@given(
    st.floats(1.0, 1e4),
    st.floats(0.01, 50.0),
    st.floats(-3.0, 3.0),
    st.lists(st.floats(-0.5, 0.5), min_size=1, max_size=5),
)
def test_free_vectors_go_there_and_back(pitch, thickness, angle, offsets):
    values = VALUES | {"tile_width": pitch, "mortar_y": thickness, "angle": angle}
    free = to_free(values, np.array(offsets))
    back, back_offsets = read_free(free)
    for name in ("tile_width", "mortar_y", "angle", "offset"):
        assert back[name] == pytest.approx(values[name], rel=1e-9, abs=1e-9)
    np.testing.assert_allclose(back_offsets, offsets)
    in_jax, _ = from_free(jnp.asarray(free))
    assert float(in_jax["tile_width"]) == pytest.approx(pitch, rel=1e-5)


@pytest.mark.parametrize("bond", ["raking", "irregular", "english"])
def test_a_start_moved_to_the_middle_is_the_same_lattice(bond):
    more = {
        "raking": {},
        "irregular": {"offset": 0.0, "course_offsets": np.linspace(0, 0.9, 13)},
        "english": {
            "offset": 0.0,
            "course_offsets": np.array([0.0, 0.25]),
            "course_lengths": np.array([[1.0, 1.0], [0.5, 0.5]]),
        },
    }[bond]
    guess = lattice(bond=bond, **more)
    start = start_fit(guess, (256.0, 256.0), perspective=False)
    values, offsets = read_free(start.free)
    moved = round((values["origin_y"] - guess.start[1]) / 20.0)
    assert abs(values["origin_y"]) <= 20.0
    for course in range(13):
        before = (
            guess.start[0] / 40.0 + guess.offset * course + guess.course_offsets[course % len(guess.course_offsets)]
        )
        own = course - moved
        after = values["origin_x"] / 40.0 + values["offset"] * own + offsets[own % len(offsets)]
        period = start.course_lengths[own % 2].sum() if bond == "english" else 1.0
        assert (before - after) / period == pytest.approx(round((before - after) / period), abs=1e-9)


def test_a_fixed_parameter_does_not_move_and_an_initial_one_may():
    start = start_fit(lattice(), (256.0, 256.0), perspective=False)
    chosen = apply_choices(start, (512, 512), {"tile_width": 90.0}, {"angle_deg": 10.0})
    values, _ = read_free(chosen.free)
    assert values["tile_width"] == pytest.approx(45.0)
    assert values["angle"] == pytest.approx(np.radians(10.0))
    assert chosen.moving[place("tile_width")] == 0
    assert chosen.moving[place("angle")] == 1


@pytest.mark.parametrize(
    ("fix", "init", "told"),
    [
        ({"width": 3.0}, {}, "no parameter 'width'"),
        ({"tile_width": 1.0}, {}, "too small"),
        ({}, {"mortar_x": -1.0}, "negative"),
        ({"offset": np.nan}, {}, "not a finite number"),
        ({"offset": "0.5"}, {}, "not a number"),
        ({"tile_width": 5000.0}, {}, "more than twice the photograph"),
        ({"offset": 0.5}, {"offset": 0.4}, "both fixed and started"),
    ],
)
def test_choices_out_of_range_are_refused(fix, init, told):
    with pytest.raises(InputError, match=told):
        check_choices(fix, init, (512, 512))


def test_a_seamless_picture_makes_the_pitches_exact():
    near = VALUES | {"tile_width": 63.5, "tile_height": 32.2, "angle": 0.002, "offset": 0.497}
    exact = repeat_with_picture(near, (512.0, 512.0), (True, True), "regular")
    assert exact is not None
    assert exact["tile_width"] == pytest.approx(64.0)
    assert exact["tile_height"] == pytest.approx(32.0)
    assert exact["angle"] == pytest.approx(0.0, abs=1e-12)
    assert exact["offset"] == pytest.approx(0.5)


def test_courses_alone_are_made_whole_where_tiles_do_not_come_out_even():
    near = VALUES | {"tile_width": 117.0, "tile_height": 57.2, "angle": 0.001, "offset": 0.5}
    exact = repeat_with_picture(near, (512.0, 512.0), (True, True), "regular")
    assert exact is not None
    assert exact["tile_height"] == pytest.approx(512 / 9, rel=1e-3)
    assert exact["tile_width"] == pytest.approx(117.0, rel=1e-2)


def test_a_lattice_far_from_whole_is_left_alone():
    assert repeat_with_picture(VALUES | {"tile_height": 20.8}, (512.0, 512.0), (True, True), "regular") is None
