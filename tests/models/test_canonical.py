"""The same picture before and after: canonical form and moved origins."""

import dataclasses
import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxtex.models.bonds import bond_pattern
from jaxtex.models.canonical import canonical, nearest_node
from jaxtex.models.tiling import Tiling, make_tiling

VIEW = np.array([[1.05, 0.1, -2.0], [-0.08, 0.97, 3.0], [4e-4, -2e-4, 1.0]])
# Rows of one length, of lengths that share multiples, and of lengths that share none.
ALIKE = [[[1.0]], [[0.8]], [[1.0, 0.5]], [[0.5, 1.0], [1.0, 0.5]], [[2.0], [1.0]], [[1.0, 1.0], [0.5, 0.5]]]
UNLIKE = [[[1.0], [0.47]], [[0.6, 1.0], [0.3, 0.4], [0.9, 1.3]]]
offsets = st.lists(st.floats(-2, 2), min_size=1, max_size=4)
COMMON_CYCLE = 24


@jax.jit
def soft_mask(wall: Tiling, points: jax.Array) -> jax.Array:
    return jax.vmap(lambda point: wall.coverage(point, blur=0.7))(points)


def mask_of(wall: Tiling, points: np.ndarray) -> np.ndarray:
    """The soft mask, in double precision; cyclic arrays are repeated to one shape, so that it is compiled once."""
    lengths = np.asarray(wall.course_lengths, np.float64)
    lengths = np.tile(lengths, (6 // lengths.shape[0], 6 // lengths.shape[1]))
    shifts = np.asarray(wall.course_offsets, np.float64)
    assert COMMON_CYCLE % len(shifts) == 0
    shifts = np.tile(shifts, COMMON_CYCLE // len(shifts))
    same_shape = dataclasses.replace(wall, course_lengths=lengths, course_offsets=shifts, bond="irregular")
    with jax.enable_x64():
        as_double = jax.tree.map(lambda leaf: jnp.asarray(np.asarray(leaf, np.float64)), same_shape)
        return np.asarray(soft_mask(as_double, jnp.asarray(points)))


# Far enough to see all courses of the longest cycle, on both sides of the origin.
POINTS = np.random.default_rng(5).uniform(-420, 420, (700, 2))


def double_wall(**changes) -> Tiling:
    arguments = {
        "tile_width": 40.0,
        "tile_height": 18.0,
        "mortar_x": 3.0,
        "mortar_y": 2.0,
        "origin": (7.0, -4.0),
        "corner_radius": 1.5,
        **changes,
    }
    with jax.enable_x64():
        return jax.tree.map(np.asarray, make_tiling(**arguments))


def assert_is_canonical(wall: Tiling) -> None:
    assert -math.pi / 2 < wall.angle <= math.pi / 2
    if wall.bond == "stack":
        assert -math.pi / 4 < wall.angle <= math.pi / 4
    assert 0 <= wall.offset < 1
    assert wall.homography[2, 2] == 1
    assert wall.course_lengths[0].max() == wall.course_lengths.max() == 1
    assert wall.course_offsets[0] == 0
    assert (wall.course_offsets >= 0).all()
    periods = np.resize(wall.course_lengths.sum(axis=1), wall.course_offsets.size)
    assert (wall.course_offsets < periods).all()


@given(
    angle=st.floats(-10, 10),
    offset=st.floats(-3, 3),
    course_offsets=offsets,
    course_lengths=st.sampled_from(ALIKE),
    scale=st.sampled_from([1.0, 2.5, -0.3]),
)
def test_canonical_form_shows_the_same_picture(angle, offset, course_offsets, course_lengths, scale):
    wall = double_wall(
        angle=angle,
        offset=offset,
        course_offsets=course_offsets,
        course_lengths=course_lengths,
        homography=VIEW * scale,
        bond="irregular",
    )
    written = canonical(wall)
    assert_is_canonical(written)
    np.testing.assert_allclose(mask_of(written, POINTS), mask_of(wall, POINTS), atol=1e-7)
    assert eqx.tree_equal(canonical(written), written)


@given(
    angle=st.floats(-10, 10),
    offset=st.floats(0, 0.99),
    course_offsets=offsets,
    course_lengths=st.sampled_from(UNLIKE),
)
def test_canonical_form_of_rows_that_share_no_length(angle, offset, course_offsets, course_lengths):
    wall = double_wall(angle=angle, offset=offset, course_offsets=course_offsets, course_lengths=course_lengths)
    written = canonical(wall)
    np.testing.assert_allclose(mask_of(written, POINTS), mask_of(wall, POINTS), atol=1e-7)
    assert_is_canonical(written)
    assert eqx.tree_equal(canonical(written), written)


@given(angle=st.floats(-10, 10), whole=st.integers(-3, 3), single=st.booleans())
def test_a_stack_bond_is_written_with_its_courses_closest_to_horizontal(angle, whole, single):
    shifts = {"offset": 0.8 * whole, "course_offsets": [0.3, 0.3 + 0.8]}
    wall = double_wall(angle=angle, course_lengths=[[0.8]], bond="stack", **shifts)
    if single:
        wall = jax.tree.map(lambda leaf: leaf.astype(np.float32), wall)
    written = canonical(wall)
    assert_is_canonical(written)
    assert written.course_offsets.tolist() == [0.0]
    assert {leaf.dtype for leaf in jax.tree.leaves(written)} == {np.dtype(np.float32 if single else np.float64)}
    np.testing.assert_allclose(mask_of(written, POINTS), mask_of(wall, POINTS), atol=2e-2 if single else 1e-7)


@pytest.mark.parametrize("angle", [math.pi / 2, -math.pi / 2, math.pi, 0.0, math.pi / 4, -math.pi / 4])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("bond", ["stack", "running"])
def test_angles_at_the_end_of_the_range(angle, dtype, bond):
    wall = double_wall(angle=angle, **bond_pattern(bond))
    wall = jax.tree.map(lambda leaf: leaf.astype(dtype), wall)
    written = canonical(wall)
    limit = math.pi / 4 if bond == "stack" else math.pi / 2
    assert written.angle.dtype == dtype
    assert -limit < float(written.angle) <= float(dtype(limit))
    np.testing.assert_allclose(mask_of(written, POINTS), mask_of(wall, POINTS), atol=1e-3)
    assert eqx.tree_equal(canonical(written), written)


def test_an_offset_that_rounds_to_one_is_none():
    written = canonical(make_tiling(tile_width=40.0, tile_height=18.0, offset=-1e-9))
    assert float(written.offset) == 0.0


def test_patterns_are_written_once():
    written = canonical(
        double_wall(course_lengths=[[1.0, 0.5] * 2] * 2, course_offsets=[0.25, 1.75, 0.5, 0.0], offset=0.5)
    )
    assert written.course_lengths.tolist() == [[1.0, 0.5]]
    assert written.course_offsets.tolist() == [0.0, 0.0, 0.25, 1.25]
    written = canonical(double_wall(course_lengths=[[1.0], [0.5]], course_offsets=[0.25, 0.5]))
    assert written.course_offsets.tolist() == [0.0, 0.25]


def test_what_has_no_canonical_form_is_refused():
    with pytest.raises(ValueError, match=r"offset 1\.2 cannot be brought into \[0, 1\)"):
        canonical(double_wall(offset=1.2, course_lengths=[[1.0, 0.4871934]]))
    with pytest.raises(ValueError, match="H33 = 0"):
        canonical(double_wall(homography=[[1, 0, 5], [0, 1, 7], [1e-3, 1e-3, 0]]))


@given(
    angle=st.floats(-1.5, 1.5),
    offset=st.floats(0, 0.99),
    course_offsets=offsets,
    course_lengths=st.sampled_from(ALIKE + UNLIKE),
    x=st.floats(-300, 300),
    y=st.floats(-300, 300),
)
def test_moving_the_origin_changes_nothing(angle, offset, course_offsets, course_lengths, x, y):
    wall = double_wall(
        angle=angle,
        offset=offset,
        course_offsets=course_offsets,
        course_lengths=course_lengths,
        homography=VIEW,
        bond="irregular",
    )
    moved = nearest_node(wall, (x, y))
    np.testing.assert_allclose(mask_of(moved, POINTS), mask_of(wall, POINTS), atol=1e-7)
    assert moved.course_offsets[0] == 0
    assert moved.course_lengths[0].max() == moved.course_lengths.max()
    # No start of a pattern of a course like course 0 is nearer.
    with jax.enable_x64():
        q = np.asarray(moved.to_lattice(jnp.array([x, y])))
    cycle, period = len(moved.course_lengths), moved.course_lengths[0].sum()
    for course in range(-12 * cycle, 13 * cycle, cycle):
        shift = moved.offset * course + moved.course_offsets[course % len(moved.course_offsets)]
        nearest = shift + period * round((q[0] / moved.tile_width - shift) / period)
        distance = math.hypot(nearest * moved.tile_width - q[0], course * moved.tile_height - q[1])
        assert distance >= math.hypot(*q) - 1e-6
    assert eqx.tree_equal(nearest_node(moved, (x, y)), moved)


def test_the_origin_moves_to_where_the_point_is():
    wall = double_wall(angle=0.4, **bond_pattern("english"))
    moved = nearest_node(wall, (200.0, 150.0))
    assert math.dist(moved.origin, (200.0, 150.0)) < 0.5 * math.hypot(40.0, 2 * 18.0)
    assert moved.course_lengths.tolist() == [[1.0], [0.5]]
    assert moved.bond == "english"
