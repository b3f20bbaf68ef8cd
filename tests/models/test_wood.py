"""Wood against plain NumPy: the reference geometry, the share of early wood by brute force, and gradients."""

import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxtex.models.grids import on_grid
from jaxtex.models.wood import Wood, early_share, make_wood

OBLIQUE = {
    "ring_spacing": 23.0,
    "center": (31.0, -12.0),
    "tilt": 0.4,
    "rotation": 0.9,
    "early_fraction": 0.37,
    "turbulence_rms": 2.5,
    "turbulence_frequency": 0.01,
    "seed": 3,
}
PARAMETERS = (
    *("center", "tilt", "rotation", "ring_spacing", "early_fraction"),
    *("early_rgb", "late_rgb", "turbulence_rms", "turbulence_frequency", "gradation"),
)


def average_of_the_spot(count: float, fraction: float, width: float) -> float:
    """The hard threshold, averaged over many samples of a Gaussian of `width` rings."""
    offset = np.linspace(-8, 8, 400_001)
    weight = np.exp(-0.5 * offset**2)
    early = np.sin(2 * np.pi * (count + width * offset)) > np.cos(np.pi * fraction)
    return float((early * weight).sum() / weight.sum())


@pytest.mark.parametrize("width", [0.01, 0.1, 0.3, 0.49, 0.51, 0.7, 1.0, 3.0])
@pytest.mark.parametrize("fraction", [0.05, 0.37, 0.5, 0.9])
def test_early_share_is_the_mean_over_the_spot(fraction, width):
    counts = np.linspace(-1.3, 1.3, 14)
    expected = [average_of_the_spot(count, fraction, width) for count in counts]
    with jax.enable_x64():
        np.testing.assert_allclose(early_share(counts, fraction, width), expected, atol=1e-4)


@pytest.mark.parametrize("gradation", [0.05, 0.25])
def test_late_wood_comes_on_gradually_and_ends_sharply(gradation):
    counts = np.linspace(0, 1, 2001)[:-1]
    with jax.enable_x64():
        share = np.asarray(early_share(counts, 0.4, 0.01, gradation))
    assert share.mean() == pytest.approx(0.4, abs=1e-6)
    slope = np.gradient(share, counts)
    # Outwards: early wood begins at 0.05 with a jump, as sharp as the spot; late wood comes on at 0.45.
    assert slope[np.abs(counts - 0.05) < 0.05].max() == pytest.approx(1 / (0.01 * np.sqrt(2 * np.pi)), rel=0.02)
    assert slope.min() == pytest.approx(-1 / (np.hypot(0.01, gradation) * np.sqrt(2 * np.pi)), rel=0.15)


def test_early_share_of_all_and_nothing():
    counts = jnp.linspace(-2.0, 2.0, 41)
    for width in (0.0, 0.02, 0.4, 2.0):
        np.testing.assert_allclose(early_share(counts, 0.0, width), 0.0, atol=1e-6)
        np.testing.assert_allclose(early_share(counts, 1.0, width), 1.0, atol=1e-6)


def test_early_share_has_no_jumps():
    """Where the neighbouring rings that are summed over change, and where a wide spot is told from a narrow one."""
    with jax.enable_x64():
        for width in (0.1, 0.4, 0.5, 1.0):
            below, above = early_share(jnp.array([0.75 - 1e-12, 0.75 + 1e-12]), 0.6, width)
            assert abs(below - above) < 5e-9
        for count in (0.1, 0.25, 0.7):
            below, above = early_share(jnp.array([count, count]), 0.6, jnp.array([0.5 - 1e-12, 0.5 + 1e-12]))
            assert abs(below - above) < 5e-9


def reference_radius(wood: Wood, height: int, width: int) -> np.ndarray:
    """The formulas of the format, over a picture: the distance from the axis, turbulence aside."""
    col, row = np.meshgrid(np.arange(width), np.arange(height))
    u, v = col + 0.5 - width / 2, row + 0.5 - height / 2
    rotation, tilt, (xc, yc) = float(wood.rotation), float(wood.tilt), np.asarray(wood.center)
    s = u * np.cos(rotation) + v * np.sin(rotation)
    t = -u * np.sin(rotation) + v * np.cos(rotation)
    return np.hypot(s - xc, t * np.sin(tilt) - yc)


@pytest.mark.parametrize("tilt", [0.0, 0.4, 1.2, math.pi / 2])
@pytest.mark.parametrize("rotation", [0.0, 0.9, math.pi / 2, 3.0])
def test_the_geometry_is_that_of_the_format(tilt, rotation):
    with jax.enable_x64():
        wood = make_wood(**{**OBLIQUE, "tilt": tilt, "rotation": rotation, "turbulence_rms": 0.0})
        middle = jnp.array([26.0, 20.0])
        early = on_grid(eqx.Partial(lambda wood, at: wood.early_on_plank(at - middle, blur=1e-4), wood), 40, 52)
        radius = reference_radius(wood, 40, 52)
        wave = np.sin(2 * np.pi * radius / 23.0) - np.cos(np.pi * 0.37)
        clear = (np.abs(wave) > 1e-3) & (radius > 2)
        assert clear.mean() > 0.95
        np.testing.assert_allclose(np.asarray(early)[clear], (wave > 0)[clear], atol=1e-6)


def test_the_trunk_has_its_axis_along_z():
    with jax.enable_x64():
        wood = make_wood(**OBLIQUE)
        u, v, tilt, rotation = 17.0, -29.0, 0.4, 0.9
        s, t = u * np.cos(rotation) + v * np.sin(rotation), -u * np.sin(rotation) + v * np.cos(rotation)
        trunk = wood.to_trunk(jnp.array([u, v]))
        np.testing.assert_allclose(trunk, [s, t * np.sin(tilt), t * np.cos(tilt)], rtol=1e-12)
        expected = np.hypot(trunk[0] - 31.0, trunk[1] + 12.0) + wood.turbulence(trunk)
        np.testing.assert_allclose(wood.radius(trunk), expected, atol=1e-4)
        np.testing.assert_allclose(wood.ring_count(trunk), expected / 23.0, atol=1e-5)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_turbulence_has_its_rms_and_no_mean(seed):
    wood = make_wood(ring_spacing=20.0, turbulence_rms=3.0, turbulence_frequency=0.05, seed=seed)
    # A block of a hundred wavelengths a side.
    points = np.random.default_rng(7).uniform(-1000, 1000, (60_000, 3)).astype(np.float32)
    moved = np.asarray(jax.jit(jax.vmap(wood.turbulence))(points))
    assert abs(moved.std() / 3.0 - 1) < 0.03
    assert abs(moved.mean()) < 0.1


def test_turbulence_has_its_frequency():
    wood = make_wood(ring_spacing=20.0, turbulence_rms=1.0, turbulence_frequency=0.02)
    slope = jax.jit(jax.vmap(jax.grad(wood.turbulence)))
    points = np.random.default_rng(7).uniform(-2500, 2500, (20_000, 3)).astype(np.float32)
    frequency = np.sqrt((np.asarray(slope(points)) ** 2).sum(-1).mean()) / (2 * np.pi)
    assert 0.8 < frequency / 0.02 < 1.4


def test_the_seed_draws_the_turbulence():
    one, same, other = (make_wood(ring_spacing=20.0, seed=seed) for seed in (4, 4, 5))
    assert np.array_equal(one.waves, same.waves)
    assert np.array_equal(one.phases, same.phases)
    assert not np.array_equal(one.waves, other.waves)


def test_colours_lie_between_those_of_early_and_late_wood():
    wood = make_wood(ring_spacing=20.0, early_fraction=0.5, early_rgb=(0.8, 0.6, 0.4), late_rgb=(0.4, 0.2, 0.1))
    early, edge, late = (wood.colour(jnp.array([x, 0.0, 0.0]), blur=0.3) for x in (45.0, 50.0, 55.0))
    np.testing.assert_allclose(early, [0.8, 0.6, 0.4], atol=1e-6)
    np.testing.assert_allclose(edge, [0.6, 0.4, 0.25], atol=1e-4)
    np.testing.assert_allclose(late, [0.4, 0.2, 0.1], atol=1e-6)


def test_a_spot_on_the_plank_sees_rings_stretched():
    """Where rings cross the plank at a slant, its edges are as soft as the stretched ring has them."""
    with jax.enable_x64():
        wood = make_wood(ring_spacing=20.0, tilt=0.3, center=(0.0, 0.0), early_fraction=0.5)
        along = 200.0 + np.linspace(-80, 80, 321)
        seen = jax.vmap(lambda v: wood.early_on_plank(jnp.array([0.0, v]), blur=3.0))(jnp.asarray(along))
        offset = np.linspace(-6, 6, 2001)
        weight = np.exp(-0.5 * offset**2) / np.exp(-0.5 * offset**2).sum()
        hard = np.sin(2 * np.pi * np.sin(0.3) * (along[:, None] + 3 * offset) / 20.0) > 0
        np.testing.assert_allclose(seen, hard @ weight, atol=0.01)


def plank_colour(parameters, wood: Wood, point):
    wood = Wood(**parameters, waves=wood.waves, phases=wood.phases)
    early = wood.early_on_plank(point, blur=0.8)
    return jnp.sum((wood.late_rgb + early * (wood.early_rgb - wood.late_rgb)) * jnp.array([1.0, 2.0, 3.0]))


def places() -> dict[str, tuple[dict, tuple[float, float]]]:
    """Parameters and a plank point: somewhere, exactly at the pith, on a ring's edge, midway between rings."""
    flat = {"ring_spacing": 16.0, "early_fraction": 0.5, "turbulence_rms": 0.0}
    return {
        "somewhere": (OBLIQUE, (21.0, 33.0)),
        "pith": ({**OBLIQUE, "center": (0.0, 0.0)}, (0.0, 0.0)),
        "pith of end grain": ({**flat, "center": (4.0, 8.0), "tilt": math.pi / 2}, (4.0, 8.0)),
        "edge of a ring": (flat, (48.0, 5.0)),
        "other edge": (flat, (40.0, 5.0)),
        "early wood": (flat, (36.0, 0.0)),
        "late wood": ({**flat, "tilt": 0.2}, (44.0, 0.0)),
    }


@pytest.mark.parametrize("name", places())
def test_gradients_forward_reverse_and_numeric_agree(name):
    with jax.enable_x64():
        arguments, point = places()[name]
        wood, at = make_wood(**arguments), jnp.array(point)
        parameters = {name: getattr(wood, name) for name in PARAMETERS}
        function = jax.jit(lambda parameters: plank_colour(parameters, wood, at))
        forward, reverse = jax.jacfwd(function)(parameters), jax.grad(function)(parameters)
        for parameter in PARAMETERS:
            # The pith is rounded on a hundredth of a pixel, so steps must be much shorter.
            step = 1e-6
            flat = parameters[parameter].ravel()
            numeric = []
            for k in range(flat.size):
                ends = [flat.at[k].add(sign * step).reshape(parameters[parameter].shape) for sign in (1, -1)]
                high, low = (function({**parameters, parameter: end}) for end in ends)
                numeric.append((high - low) / (2 * step))
            assert np.isfinite(forward[parameter]).all(), parameter
            np.testing.assert_allclose(forward[parameter], reverse[parameter], rtol=1e-9, atol=1e-11)
            np.testing.assert_allclose(forward[parameter].ravel(), numeric, rtol=1e-4, atol=1e-5, err_msg=parameter)


def test_gradients_in_the_point_are_finite_at_the_pith():
    wood = make_wood(ring_spacing=20.0, center=(3.0, 0.0))
    assert np.isfinite(jax.grad(lambda at: wood.early_on_plank(at, blur=0.5))(jnp.array([3.0, 0.0]))).all()
    assert np.isfinite(jax.grad(wood.radius)(jnp.array([3.0, 0.0, 1.0]))).all()


@pytest.mark.parametrize("dtype", [jnp.float32, jnp.float64])
def test_jit_is_eager_in_either_precision(dtype):
    with jax.enable_x64():
        wood = jax.tree.map(lambda leaf: leaf.astype(dtype), make_wood(**OBLIQUE))
        at = jnp.array([20.0, 11.0], dtype)
        tolerance = 1e-3 if dtype == jnp.float32 else 1e-10
        for function in (
            lambda wood, at: wood.early_on_plank(at, blur=0.5),
            lambda wood, at: wood.colour(wood.to_trunk(at), blur=0.5),
            lambda wood, at: wood.ring_count(wood.to_trunk(at)),
        ):
            eager, compiled = function(wood, at), jax.jit(function)(wood, at)
            assert eager.dtype == compiled.dtype == dtype
            np.testing.assert_allclose(eager, compiled, atol=tolerance)


def test_single_precision_is_close_to_double():
    def draw() -> np.ndarray:
        return np.asarray(on_grid(eqx.Partial(Wood.early_on_plank, make_wood(**OBLIQUE), blur=jnp.array(0.7)), 30, 40))

    single = draw()
    assert single.dtype == np.float32
    with jax.enable_x64():
        np.testing.assert_allclose(single, draw(), atol=2e-4)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"ring_spacing": 0.0}, r"ring_spacing is 0.0; it must be at least 1e-06"),
        ({"ring_spacing": -3}, r"ring_spacing is -3.0; it must be at least 1e-06"),
        ({"ring_spacing": math.inf}, "ring_spacing is inf; it must be finite"),
        ({"ring_spacing": (3.0, 4.0)}, r"ring_spacing has the shape \(2,\); it must be one number"),
        ({"early_fraction": 1.2}, "early_fraction is 1.2; it must be at least 0 and at most 1"),
        ({"early_fraction": math.nan}, "early_fraction is nan; it must be finite"),
        ({"turbulence_rms": -1.0}, "turbulence_rms is -1.0; it must be at least 0"),
        ({"turbulence_frequency": -0.1}, "turbulence_frequency is -0.1; it must be at least 0"),
        ({"center": (1.0, 2.0, 3.0)}, r"center has the shape \(3,\); it must be \(2,\)"),
        ({"center": (math.nan, 0.0)}, r"center is \[nan, 0.0\]; it must be finite"),
        ({"tilt": math.inf}, "tilt is inf; it must be finite"),
        ({"early_rgb": 0.5}, r"early_rgb has the shape \(\); it must be \(3,\)"),
        ({"late_rgb": (0.1, 0.2)}, r"late_rgb has the shape \(2,\); it must be \(3,\)"),
    ],
)
def test_numbers_that_are_no_wood_are_refused(changes, told):
    with pytest.raises(ValueError, match=told):
        make_wood(**{**OBLIQUE, **changes})
