"""The point model: what its functions say of each other, its gradients, its symmetries, and what it refuses."""

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
from jaxtex.models.tiling import BONDS, Tiling, make_tiling

VIEW = ((1.05, 0.1, -2.0), (-0.08, 0.97, 3.0), (4e-4, -2e-4, 1.0))
LEAVES = [field.name for field in dataclasses.fields(Tiling) if field.name != "bond"]


def make_wall(*, radius: float = 0.0, view=None, **changes) -> Tiling:
    return make_tiling(
        **{
            "tile_width": 40.0,
            "tile_height": 18.0,
            "angle": 0.3,
            "mortar_x": 3.0,
            "mortar_y": 2.0,
            "offset": 0.37,
            "origin": (7.0, -4.0),
            "homography": view,
            "corner_radius": radius,
            "course_offsets": (0.0, 0.1, 0.3),
            "course_lengths": ((1.0, 0.8), (0.5, 0.7)),
            **changes,
        }
    )


def telling_points(wall: Tiling) -> jax.Array:
    """Image points where a gradient could go wrong: on and around joints, corners, nodes and middles of tiles."""
    w, h = float(wall.tile_width), float(wall.tile_height)
    joint_x, joint_y = float(wall.mortar_x) / 2, float(wall.mortar_y) / 2
    q = []
    for course in (-2, 0, 1, 5):
        shift = float(wall.offset) * course + float(wall.course_offsets[course % len(wall.course_offsets)])
        for x in (0.0, joint_x, -joint_x, joint_x + float(wall.corner_radius), 0.25 * w, 0.4 * w):
            q += [(shift * w + x, course * h + y) for y in (0.0, joint_y, -joint_y, 0.5 * h, 0.3 * h)]
    return from_lattice(wall, jnp.asarray(q))


def draw(wall: Tiling, points: jax.Array, blur: float = 0.7) -> jax.Array:
    return jax.vmap(lambda point: wall.coverage(point, blur=blur))(points)


def gradient_by(derive):
    """The soft mask's derivatives at points, one after the other: code of one point compiles in a third of the time."""

    def gradient(wall: Tiling, points: jax.Array) -> Tiling:
        return jax.lax.map(lambda point: derive(lambda tiling: tiling.coverage(point, blur=0.7))(wall), points)

    return jax.jit(gradient)


# Compiled once for all walls of one shape.
soft_mask = jax.jit(draw)
forward_gradient, reverse_gradient = gradient_by(jax.jacfwd), gradient_by(jax.grad)
from_lattice = jax.jit(jax.vmap(Tiling.from_lattice, in_axes=(None, 0)))


CASES = pytest.mark.parametrize(
    ("radius", "view"), [(0.0, None), (0.0, VIEW), (3.0, None), (3.0, VIEW), (1.0, VIEW), (0.5, None)]
)


@CASES
def test_forward_and_reverse_gradients_agree_with_differences(radius, view):
    with jax.enable_x64():
        wall = make_wall(radius=radius, view=view)
        points = telling_points(wall)
        forward = forward_gradient(wall, points)
        reverse = reverse_gradient(wall, points)
        for name in LEAVES:
            value, by_forward = np.array(getattr(wall, name)), np.array(getattr(forward, name))
            assert np.isfinite(by_forward).all(), name
            scale = np.abs(by_forward).max() + 1e-3
            assert np.abs(by_forward - np.array(getattr(reverse, name))).max() <= 1e-9 * scale, name
            for index in np.ndindex(value.shape):
                step = 1e-5 * (1e-3 if name == "homography" and index[0] == 2 else 1.0)
                if name == "corner_radius" and radius == 0:
                    continue  # a radius cannot be negative: see the next test
                up, down = value.copy(), value.copy()
                up[index] += step
                down[index] -= step
                higher, lower = (
                    soft_mask(dataclasses.replace(wall, **{name: jnp.asarray(v)}), points) for v in (up, down)
                )
                numeric = (higher - lower) / (2 * step)
                assert np.abs(by_forward[(..., *index)] - numeric).max() <= 1e-5 * scale, (name, index)


def test_corners_begin_to_round_without_a_jump():
    with jax.enable_x64():
        wall = make_wall()
        points = telling_points(wall)
        masks = [soft_mask(dataclasses.replace(wall, corner_radius=jnp.asarray(r)), points) for r in (0.0, 1e-3, 0.1)]
        assert np.abs(masks[1] - masks[0]).max() < 1e-6
        # What is lost grows as the radius squared, so the gradient at square corners is 0.
        assert 1e-4 < np.abs(masks[2] - masks[0]).max() < 0.14 * (0.1 / 0.7) ** 2
        gradient = reverse_gradient(wall, points).corner_radius
        assert np.abs(gradient).max() == 0.0


@CASES
def test_single_precision_gradients_are_finite_and_close(radius, view):
    wall = make_wall(radius=radius, view=view)
    points = telling_points(wall)
    single = reverse_gradient(wall, points)
    assert {leaf.dtype for leaf in jax.tree.leaves(wall)} == {jnp.dtype(jnp.float32)}
    assert {leaf.dtype for leaf in jax.tree.leaves(single)} == {jnp.dtype(jnp.float32)}
    with jax.enable_x64():
        double_wall = jax.tree.map(lambda leaf: jnp.asarray(np.asarray(leaf, np.float64)), wall)
        double = reverse_gradient(double_wall, jnp.asarray(np.asarray(points, np.float64)))
    for name in LEAVES:
        exact, rounded = np.asarray(getattr(double, name)), np.asarray(getattr(single, name))
        assert np.abs(rounded - exact).max() <= 2e-3 * (np.abs(exact).max() + 1e-3), name


def test_compiled_equals_eager():
    wall = make_wall(radius=2.0, view=VIEW)
    points = telling_points(wall)[::17]
    eager = jnp.stack([wall.coverage(point, blur=0.7) for point in points])
    np.testing.assert_allclose(soft_mask(wall, points), eager, atol=2e-5)


def test_a_batch_of_tilings_equals_one_by_one():
    walls = [make_wall(radius=radius) for radius in (0.0, 2.0)]
    points = telling_points(walls[1])
    together = jax.jit(jax.vmap(draw, in_axes=(0, None)))(
        jax.tree.map(lambda *leaves: jnp.stack(leaves), *walls), points
    )
    for one, wall in zip(together, walls, strict=True):
        np.testing.assert_allclose(one, soft_mask(wall, points), atol=2e-5)


def test_leaves_and_structure_survive_the_pytree_round_trip():
    wall = make_wall(radius=2.0, view=VIEW)
    leaves, structure = jax.tree.flatten(wall)
    assert len(leaves) == len(LEAVES)
    assert eqx.tree_equal(jax.tree.unflatten(structure, leaves), wall)
    assert jax.tree.structure(wall) != jax.tree.structure(dataclasses.replace(wall, bond="raking"))


def test_numbers_and_arrays_make_the_same_leaves():
    """Or the same computation would be compiled twice."""
    plain, arrays = (
        make_tiling(tile_width=40, tile_height=18.0),
        make_tiling(tile_width=jnp.array(40.0), tile_height=np.float32(18.0)),
    )
    assert [leaf.aval for leaf in jax.tree.leaves(plain)] == [leaf.aval for leaf in jax.tree.leaves(arrays)]


@given(x=st.floats(-200, 200), y=st.floats(-200, 200))
def test_lattice_and_picture_are_inverse(x, y):
    with jax.enable_x64():
        wall = make_wall(view=VIEW)
        point = jnp.array([x, y])
        np.testing.assert_allclose(wall.from_lattice(wall.to_lattice(point)), point, atol=1e-8)


@given(x=st.floats(-300, 300), y=st.floats(-300, 300))
def test_a_place_is_inside_its_tile(x, y):
    with jax.enable_x64():
        wall = make_wall()
        place = wall.locate(jnp.array([x, y]))
        assert min(place.left, place.right, place.top, place.bottom) >= -1e-9
        assert abs(place.top + place.bottom - 18.0) < 1e-9
        lengths = wall.course_lengths[int(place.course) % 2]
        number = int(place.tile) % 2
        assert abs(place.left + place.right - 40.0 * lengths[number]) < 1e-9
        start = (0.37 * place.course + wall.course_offsets[int(place.course) % 3]) * 40.0
        start += (int(place.tile) // 2 * lengths.sum() + (lengths[0] if number else 0.0)) * 40.0
        assert abs(start + place.left - x) < 1e-9


def test_reference_geometry_of_the_plain_tiling():
    """Course floor(q_y / height), tile floor(q_x / width - offset * course)."""
    with jax.enable_x64():
        wall = make_tiling(tile_width=40.0, tile_height=18.0, offset=0.37, angle=0.3, origin=(7.0, -4.0))
        points = np.random.default_rng(3).uniform(-300, 300, (200, 2))
        for point in points:
            c, s = math.cos(0.3), math.sin(0.3)
            dx, dy = point - [7.0, -4.0]
            q = np.array([c * dx + s * dy, -s * dx + c * dy])
            place = wall.locate(wall.to_lattice(jnp.asarray(point)))
            course = math.floor(q[1] / 18.0)
            assert (int(place.course), int(place.tile)) == (course, math.floor(q[0] / 40.0 - 0.37 * course))


POINTS = np.stack(np.meshgrid(np.linspace(-50, 50, 21), np.linspace(-40, 60, 19)), -1).reshape(-1, 2)
angles = st.floats(-3.1, 3.1)
radii = st.sampled_from([0.0, 2.0])


def simple_wall(**changes) -> Tiling:
    return make_wall(**{"course_offsets": (0.0,), "course_lengths": ((1.0,),), **changes})


def assert_same_mask(wall: Tiling, points, other: Tiling, other_points) -> None:
    mask, other_mask = soft_mask(wall, jnp.asarray(points)), soft_mask(other, jnp.asarray(other_points))
    np.testing.assert_allclose(mask, other_mask, atol=1e-9)


@given(angle=angles, radius=radii, along=st.integers(-9, 9), across=st.integers(-9, 9))
def test_moving_the_origin_by_a_lattice_vector_changes_nothing(angle, radius, along, across):
    with jax.enable_x64():
        wall = simple_wall(angle=angle, radius=radius)
        q_x, q_y = (along + 0.37 * across) * 40.0, across * 18.0
        c, s = math.cos(angle), math.sin(angle)
        moved = simple_wall(angle=angle, radius=radius, origin=(7.0 + c * q_x - s * q_y, -4.0 + s * q_x + c * q_y))
        assert_same_mask(wall, POINTS, moved, POINTS)


@given(angle=angles, turn=angles, radius=radii)
def test_turning_picture_and_tiling_together_changes_nothing(angle, turn, radius):
    with jax.enable_x64():
        c, s = math.cos(turn), math.sin(turn)
        rotation = np.array([[c, -s], [s, c]])
        wall = make_wall(angle=angle, radius=radius)
        turned = make_wall(angle=angle + turn, radius=radius, origin=rotation @ [7.0, -4.0])
        assert_same_mask(wall, POINTS, turned, POINTS @ rotation.T)


@given(angle=angles, radius=radii)
def test_half_a_turn_shows_the_same_lattice(angle, radius):
    with jax.enable_x64():
        wall = simple_wall(angle=angle, radius=radius)
        # Course j becomes -1 - j, whose tiles end where those of j began.
        turned = simple_wall(angle=angle + math.pi, radius=radius, course_offsets=(0.37,))
        assert_same_mask(wall, POINTS, turned, POINTS)


@given(scale=st.floats(0.3, 4.0))
def test_scaling_picture_and_tiling_together_changes_nothing(scale):
    with jax.enable_x64():
        wall = make_wall(radius=2.0)
        factors = {name: float(getattr(wall, name)) * scale for name in ("tile_width", "tile_height", "mortar_x")}
        larger = make_wall(radius=2.0 * scale, mortar_y=2.0 * scale, origin=(7.0 * scale, -4.0 * scale), **factors)
        mask = soft_mask(larger, jnp.asarray(POINTS * scale), 0.7 * scale)
        np.testing.assert_allclose(mask, soft_mask(wall, jnp.asarray(POINTS)), atol=1e-9)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"tile_width": 0.0}, "tile_width must be > 0, not 0"),
        ({"tile_height": -3}, "tile_height must be > 0, not -3"),
        ({"tile_width": math.nan}, "tile_width must be finite"),
        ({"origin": (0.0, math.inf)}, "origin must be finite"),
        ({"mortar_x": -1.0}, "mortar_x must be >= 0, not -1"),
        ({"mortar_x": 40.0}, "mortar_x = 40 leaves nothing of a shortest tile of 40"),
        ({"mortar_y": 25.0}, "mortar_y = 25 leaves nothing of a course of 18"),
        ({"corner_radius": 9.0}, "corner_radius = 9 is more than half a tile's shorter side, 16"),
        ({"corner_radius": -0.1}, "corner_radius must be >= 0"),
        ({"course_lengths": ((1.0, 0.0),)}, "course_lengths must be > 0"),
        ({"course_lengths": (1.0, 0.5)}, r"course_lengths has shape \(2,\); it must be nxn"),
        ({"course_offsets": ()}, r"course_offsets has shape \(0,\); it must be n"),
        ({"tile_width": (40.0, 41.0)}, r"tile_width has shape \(2,\); it must be a single number"),
        ({"origin": (1.0, 2.0, 3.0)}, r"origin has shape \(3,\); it must be 2"),
        ({"homography": np.eye(2)}, r"homography has shape \(2, 2\); it must be 3x3"),
        ({"homography": ((1, 0, 5), (2, 0, 7), (0, 0, 1))}, "homography is singular"),
        ({"bond": "herringbone"}, "bond 'herringbone' is not one of stack, running"),
    ],
)
def test_what_is_no_tiling_is_refused(changes, told):
    good = {"tile_width": 40.0, "tile_height": 18.0, "mortar_x": 2.0, "mortar_y": 2.0}
    with pytest.raises(ValueError, match=told):
        make_tiling(**{**good, **changes})


@pytest.mark.parametrize(
    ("pattern", "name"),
    [
        ({}, "stack"),
        ({"offset": -0.99}, "stack"),
        ({"offset": 0.51}, "running"),
        ({"offset": 1.5}, "running"),
        ({"offset": 0.3}, "raking"),
        ({"course_offsets": (0.0, 0.2)}, "irregular"),
        ({"course_lengths": ((1.0,), (0.5,))}, "irregular"),
        *[(bond_pattern(bond), bond) for bond in ("stack", "running", "english", "flemish")],
        *[({"bond": bond}, bond) for bond in BONDS],
    ],
)
def test_bonds_are_named_by_their_arrays_unless_told(pattern, name):
    assert make_tiling(tile_width=40, tile_height=18, **pattern).bond == name
