"""Perspective and shear against the lattice seen in them."""

import dataclasses
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxtex.models.perspective import normalise_view, perspective_homography, split_homography
from jaxtex.models.tiling import Tiling, make_tiling

CENTRE = (64.0, 48.0)
POINTS = np.random.default_rng(7).uniform((0, 0), (128, 96), (400, 2))
angles = st.floats(-3.1, 3.1)
tilts = st.tuples(st.floats(-3e-3, 3e-3), st.floats(-3e-3, 3e-3))
shears = st.floats(-0.5, 0.5)


@jax.jit
def soft_mask(wall: Tiling, points: jax.Array) -> jax.Array:
    return jax.vmap(lambda point: wall.coverage(point, blur=0.7))(points)


normalise = jax.jit(normalise_view)
split = jax.jit(split_homography)
join = jax.jit(perspective_homography)
jacobian_at = jax.jit(lambda wall, point: jax.jacfwd(wall.to_plane)(point))


def make_wall(**changes) -> Tiling:
    return make_tiling(
        **{
            "tile_width": 40.0,
            "tile_height": 18.0,
            "angle": 0.3,
            "mortar_x": 3.0,
            "mortar_y": 2.0,
            "offset": 0.37,
            "origin": (7.0, -4.0),
            "course_offsets": (0.0, 0.1, 0.3),
            "course_lengths": ((1.0, 0.8), (0.5, 0.7)),
            **changes,
        }
    )


def project(homography, points):
    seen = np.column_stack([points, np.ones(len(points))]) @ np.asarray(homography).T
    return seen[:, :2] / seen[:, 2:]


@given(tilt=tilts, shear=shears, angle=angles)
def test_homography_is_its_formula(tilt, shear, angle):
    with jax.enable_x64():
        h = join(CENTRE, tilt, shear, angle)
        d, n = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
        from_centre = POINTS - CENTRE
        expected = CENTRE + from_centre @ (np.eye(2) + shear * np.outer(d, n)).T / (1 + from_centre @ tilt)[:, None]
        np.testing.assert_allclose(project(h, POINTS), expected, atol=1e-9)
        assert h[2, 2] == 1


@pytest.mark.parametrize("double", [False, True])
def test_no_tilt_and_no_shear_is_exactly_the_identity(double):
    with jax.enable_x64(double):
        for angle in np.linspace(-3, 3, 31):
            h = join((1511.5, 997.0), (0.0, 0.0), 0.0, angle)
            assert h.tolist() == np.eye(3).tolist()


@given(tilt=tilts, shear=shears, angle=angles)
def test_splitting_is_the_inverse(tilt, shear, angle):
    with jax.enable_x64():
        h = join(CENTRE, tilt, shear, angle)
        tilt_again, shear_again = split(h * -1.7, CENTRE, angle)
        np.testing.assert_allclose(tilt_again, tilt, atol=1e-12)
        np.testing.assert_allclose(shear_again, shear, atol=1e-12)


@given(
    rotation=angles,
    scale_x=st.floats(0.4, 2.5),
    scale_y=st.floats(0.4, 2.5),
    mirror=st.sampled_from([1.0, -1.0]),
    tilt=tilts,
    shear=shears,
    angle=angles,
)
def test_normalised_view_shows_the_same_picture(rotation, scale_x, scale_y, mirror, tilt, shear, angle):
    with jax.enable_x64():
        c, s = math.cos(rotation), math.sin(rotation)
        affine = np.array([[c * scale_x, -s * scale_y, 30.0], [s * scale_x, c * scale_y, -50.0], [0, 0, mirror]])
        affine[:2, 0] *= mirror
        h = affine @ np.asarray(join(CENTRE, tilt, shear, 0.3))
        wall = make_wall(homography=h, angle=angle)
        view = normalise(wall, CENTRE)
        np.testing.assert_allclose(
            soft_mask(view, jnp.asarray(POINTS)), soft_mask(wall, jnp.asarray(POINTS)), atol=1e-8
        )
        centre = jnp.asarray(CENTRE)
        np.testing.assert_allclose(view.to_plane(centre), CENTRE, atol=1e-9)
        tilt_seen, shear_seen = split(view.homography, CENTRE, view.angle)
        d, n = (
            np.array([jnp.cos(view.angle), jnp.sin(view.angle)]),
            np.array([-jnp.sin(view.angle), jnp.cos(view.angle)]),
        )
        np.testing.assert_allclose(jacobian_at(view, centre), np.eye(2) + shear_seen * np.outer(d, n), atol=1e-9)
        assert view.homography[2, 2] == 1
        np.testing.assert_allclose(view.homography, join(CENTRE, tilt_seen, shear_seen, view.angle), atol=1e-12)
        again = normalise(view, CENTRE)
        jax.tree.map(lambda one, two: np.testing.assert_allclose(one, two, atol=1e-8), again, view)


@given(angle=angles)
def test_a_view_without_perspective_stays_as_it_is(angle):
    with jax.enable_x64():
        wall = make_wall(angle=angle, corner_radius=2.0)
        view = normalise(wall, CENTRE)
        jax.tree.map(lambda one, two: np.testing.assert_allclose(one, two, atol=1e-12), view, wall)


def test_lengths_are_those_of_the_image_at_the_centre():
    with jax.enable_x64():
        wall = make_wall(homography=perspective_homography((0.0, 0.0), (2e-3, 1e-3), 0.2, 0.1), corner_radius=2.0)
        view = normalise_view(wall, CENTRE)
        centre = jnp.asarray(CENTRE)
        step = 1e-5 * jnp.array([jnp.cos(view.angle), jnp.sin(view.angle)])
        # A step along the courses in the image moves as many tiles on as its length over tile_width.
        q = (view.to_lattice(centre + step) - view.to_lattice(centre - step)) / (2e-5 * view.tile_width)
        np.testing.assert_allclose(q, [1 / view.tile_width, 0], atol=1e-9)
        old = (wall.to_lattice(centre + step) - wall.to_lattice(centre - step)) / (2e-5 * wall.tile_width)
        np.testing.assert_allclose(q, old, atol=1e-9)


def test_scale_and_rotation_move_into_all_lengths():
    with jax.enable_x64():
        c, s = 1.7 * math.cos(0.4), 1.7 * math.sin(0.4)
        wall = make_wall(homography=[[c, -s, 30.0], [s, c, -50.0], [0, 0, 1]], corner_radius=2.0)
        view = normalise(wall, CENTRE)
        for name in ("tile_width", "tile_height", "mortar_x", "mortar_y", "corner_radius"):
            np.testing.assert_allclose(getattr(view, name), getattr(wall, name) / 1.7, rtol=1e-12)
        np.testing.assert_allclose(view.angle, 0.3 - 0.4, atol=1e-12)
        np.testing.assert_allclose(view.homography, np.eye(3), atol=1e-12)
        np.testing.assert_allclose(
            soft_mask(view, jnp.asarray(POINTS)), soft_mask(wall, jnp.asarray(POINTS)), atol=1e-8
        )


def test_views_are_differentiable():
    with jax.enable_x64():
        wall = make_wall(homography=perspective_homography((10.0, 20.0), (2e-3, 1e-3), 0.2, 0.1))

        def summary(wall: Tiling) -> jax.Array:
            view = normalise_view(wall, CENTRE)
            return jnp.concatenate([jnp.ravel(leaf) for leaf in jax.tree.leaves(view)])

        forward, reverse = jax.jit(jax.jacfwd(summary))(wall), jax.jit(jax.jacrev(summary))(wall)
        evaluate = jax.jit(summary)
        for name in (field.name for field in dataclasses.fields(wall) if field.name != "bond"):
            by_forward, value = getattr(forward, name), np.array(getattr(wall, name))
            np.testing.assert_allclose(by_forward, getattr(reverse, name), rtol=1e-9, atol=1e-9)
            for index in np.ndindex(value.shape):
                step = 1e-8 if name == "homography" and index[0] == 2 else 1e-5
                up, down = value.copy(), value.copy()
                up[index] += step
                down[index] -= step
                higher, lower = (evaluate(dataclasses.replace(wall, **{name: jnp.asarray(v)})) for v in (up, down))
                np.testing.assert_allclose(
                    by_forward[(..., *index)], (higher - lower) / (2 * step), rtol=1e-5, atol=1e-5, err_msg=name
                )
