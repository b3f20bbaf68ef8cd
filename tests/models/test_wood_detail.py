"""Fibres as strong, as long and as many as they say; a displacement that is its own cosine series."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxtex.models.wood import make_wood
from jaxtex.models.wood_detail import Displacement, Fibres


# Compiled once for all fibres.
@jax.jit
def tone_at(fibres: Fibres, points: jax.Array, early: float, blur: float) -> jax.Array:
    return jax.vmap(lambda at: fibres.tone(at, early, blur=blur))(points)


def tones(fibres: Fibres, points: np.ndarray, blur: float = 0.0) -> np.ndarray:
    """In green light, on early wood."""
    return np.asarray(tone_at(fibres, jnp.asarray(points, float), 1.0, blur))[:, 1]


def make_fibres(contrast: float = 0.1, width: float = 2.0, pores: float = 0.0) -> Fibres:
    return Fibres(jnp.asarray(contrast), jnp.asarray(width), jnp.array([pores, 0.0]))


def anywhere(count: int = 40_000) -> np.ndarray:
    return np.random.default_rng(0).uniform(-2000, 2000, (count, 3))


@pytest.mark.parametrize("contrast", [0.02, 0.1, 0.2])
@pytest.mark.parametrize("width", [1.0, 7.0])
def test_fibres_have_their_contrast(contrast, width):
    seen = tones(make_fibres(contrast, width), anywhere())
    assert seen.mean() == pytest.approx(1.0, abs=0.1 * contrast)
    assert seen.std() == pytest.approx(contrast, rel=0.1)


@pytest.mark.parametrize("pores", [0.02, 0.1, 0.2])
def test_pores_take_their_share(pores):
    seen = tones(make_fibres(0.0, 2.0, pores), anywhere())
    assert (seen < 0.8).mean() == pytest.approx(pores, rel=0.3)


def test_late_wood_has_pores_of_its_own():
    late = tone_at(make_fibres(0.0, 2.0, 0.2), jnp.asarray(anywhere()), 0.0, 0.0)
    assert float(jnp.abs(late - 1).max()) == 0.0


def test_fibres_run_along_the_trunk():
    start = anywhere()
    fibres = make_fibres()
    alike = {
        axis: np.corrcoef(tones(fibres, start), tones(fibres, start + 4.0 * np.eye(3)[axis]))[0, 1] for axis in range(3)
    }
    assert alike[2] > 0.9
    assert max(alike[0], alike[1]) < 0.5


def test_a_wide_spot_sees_no_fibres():
    points = anywhere()
    seen = [tones(make_fibres(0.2, 2.0, 0.1), points, blur=blur).std() for blur in (0.0, 1.0, 3.0, 30.0)]
    assert seen == sorted(seen, reverse=True)
    assert seen[0] > 0.2
    assert seen[-1] < 1e-3


@pytest.mark.parametrize("dtype", [jnp.float32, jnp.float64])
def test_detail_has_finite_gradients_in_either_precision(dtype):
    with jax.enable_x64():
        field = Displacement(
            jnp.array([[1.0, -2.0], [0.5, 0.25]]), jnp.array([90.0, 60.0]), jnp.zeros(2), jnp.zeros(())
        )
        wood = make_wood(ring_spacing=20.0, gradation=0.1, fibres=make_fibres(0.1, 2.0, 0.1), displacement=field)
        wood = jax.tree.map(lambda leaf: jnp.asarray(leaf, dtype), wood)

        def total(wood, at):
            return jnp.sum(wood.colour(wood.to_trunk(at), blur=0.5))

        slopes_at = jax.jit(jax.value_and_grad(total))
        for at in ([0.0, 0.0], [24.0, 60.0], [200.0, -13.5]):
            value, slopes = slopes_at(wood, jnp.asarray(at, dtype))
            assert value.dtype == dtype
            assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(slopes))


def test_a_displacement_is_its_series_and_fades_beyond_its_picture():
    cosines = np.random.default_rng(1).normal(size=(4, 3))
    field = Displacement(jnp.asarray(cosines), jnp.array([90.0, 60.0]), jnp.zeros(2), jnp.zeros(()))
    for u, v in ((-45.0, -30.0), (10.0, 3.0), (44.0, 29.0)):
        value, weight = field(jnp.array(u), jnp.array(v), jnp.array(0.0))
        x, y = u / 90 + 0.5, v / 60 + 0.5
        told = sum(cosines[i, j] * np.cos(np.pi * i * y) * np.cos(np.pi * j * x) for i in range(4) for j in range(3))
        assert value == pytest.approx(told, abs=1e-5)
        assert weight == 1.0
    weights = [field(jnp.array(u), jnp.array(0.0), jnp.array(0.0))[1] for u in (45.0, 50.0, 60.0, 100.0)]
    assert weights == sorted(weights, reverse=True)
    assert weights[-1] < 1e-3
    assert field(jnp.array(0.0), jnp.array(0.0), jnp.array(60.0))[1] < 1e-3


def test_a_displacement_moves_and_turns_with_its_picture():
    cosines, extent, turn = jnp.asarray(np.random.default_rng(2).normal(size=(3, 4))), jnp.array([90.0, 60.0]), 0.7
    middle = jnp.array([12.0, -5.0])
    upright = Displacement(cosines, extent, jnp.zeros(2), jnp.zeros(()))
    placed = Displacement(cosines, extent, middle, jnp.array(turn))
    for x, y in ((0.0, 0.0), (30.0, -20.0), (70.0, 10.0)):
        u, v = x * np.cos(turn) - y * np.sin(turn) + middle[0], x * np.sin(turn) + y * np.cos(turn) + middle[1]
        expected = upright(jnp.array(x), jnp.array(y), jnp.array(0.0))
        np.testing.assert_allclose(placed(u, v, jnp.array(0.0)), expected, atol=1e-4)


@pytest.mark.parametrize(("tilt", "rotation"), [(0.0, 0.0), (0.4, 0.9), (np.pi / 2, 2.0)])
def test_rings_of_a_plank_are_displaced_where_it_was_seen(tilt, rotation):
    with jax.enable_x64():
        field = Displacement(jnp.array([[3.0]]), jnp.array([100.0, 100.0]), jnp.zeros(2), jnp.zeros(()))
        given = {"ring_spacing": 20.0, "center": (4.0, 9.0), "tilt": tilt, "rotation": rotation}
        turbulent = {"turbulence_rms": 2.0, "turbulence_frequency": 0.02}
        plain, displaced = make_wood(**given), make_wood(**given, **turbulent, displacement=field)
        for point in ([0.0, 0.0], [31.0, -44.0]):
            at = plain.to_trunk(jnp.array(point))
            assert displaced.radius(at) - plain.radius(at) == pytest.approx(3.0, abs=1e-9)
        # Far from its picture there is turbulence instead.
        far = plain.to_trunk(jnp.array([900.0, 700.0]))
        assert displaced.radius(far) - plain.radius(far) == pytest.approx(float(displaced.turbulence(far)), abs=1e-9)


def test_the_seed_moves_fibres():
    one, other = (make_wood(ring_spacing=20.0, fibres=make_fibres(), seed=seed) for seed in (1, 2))
    points = jnp.asarray(anywhere(500))
    look = jax.jit(lambda wood: jax.vmap(lambda at: wood.colour(at, blur=0.5))(points))
    seen = [look(wood) for wood in (one, other)]
    assert abs(np.corrcoef(seen[0][:, 0], seen[1][:, 0])[0, 1]) < 0.999


@pytest.mark.parametrize(
    ("detail", "told"),
    [
        ({"fibres": make_fibres(width=0.0)}, "fibres.width is 0"),
        ({"fibres": make_fibres(pores=0.375)}, r"fibres.pores is \[0.375"),
        ({"fibres": make_fibres(contrast=np.nan)}, "fibres.contrast is nan"),
        ({"displacement": Displacement(jnp.ones(3), jnp.ones(2), jnp.zeros(2), jnp.zeros(()))}, "must be a matrix"),
        ({"displacement": Displacement(jnp.ones((2, 2)), jnp.zeros(2), jnp.zeros(2), jnp.zeros(()))}, "extent is"),
    ],
)
def test_detail_that_is_none_is_refused(detail, told):
    with pytest.raises(ValueError, match=told):
        make_wood(ring_spacing=20.0, **detail)
