"""Histogram matching against sorting, and what it must do whatever the values are."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from jaxtex.core.histograms import look_up, match_histogram, quantile_table, table_variance

COUNT = 40_000
DRAWS = {
    "uniform": lambda random: random.random(COUNT),
    "normal": lambda random: random.normal(5, 0.1, COUNT),
    "laplace": lambda random: random.laplace(size=COUNT),
    "exponential": lambda random: random.exponential(size=COUNT),
    "long tails": lambda random: random.standard_t(2, COUNT),
    "two humps": lambda random: random.normal(0, 0.02, COUNT) + (random.random(COUNT) < 0.3),
}


def draw(name: str, seed: int) -> np.ndarray:
    return DRAWS[name](np.random.default_rng(seed)).astype(np.float32)


def match_by_sorting(values: np.ndarray, target: np.ndarray) -> np.ndarray:
    matched = np.empty_like(target)
    matched[np.argsort(values)] = np.sort(target)
    return matched


@pytest.mark.parametrize("target", DRAWS)
@pytest.mark.parametrize("source", DRAWS)
def test_as_sorting_does(source: str, target: str) -> None:
    values, aimed = draw(source, 0), draw(target, 1)
    matched = np.asarray(match_histogram(jnp.asarray(values), jnp.asarray(quantile_table(aimed))))
    exact = match_by_sorting(values, aimed)
    # In ranks: no value is more than a third of a percent of all values from where it should be.
    ascending = np.sort(aimed)
    astray = np.searchsorted(ascending, matched) - np.searchsorted(ascending, exact)
    assert np.abs(astray).max() < COUNT / 300
    if target not in ("long tails", "two humps"):  # of which few values decide, or which leap
        assert np.sqrt(np.mean((matched - exact) ** 2)) < 0.006 * aimed.std()
    assert matched.std() == pytest.approx(aimed.std(), rel=0.05)


@pytest.mark.parametrize("count", [2, 5, 24, 200])
def test_few_values_are_ranked_exactly(count: int) -> None:
    random = np.random.default_rng(count)
    values = (np.arange(count) ** 1.5 + 0.2 * random.random(count)).astype(np.float32)
    shuffled = random.permutation(values)
    table = jnp.linspace(0.0, 1.0, 4096)  # any table: look_up tells what stands at a probability
    exact = look_up(table, jnp.asarray(np.argsort(np.argsort(shuffled)) / (count - 1)))
    np.testing.assert_allclose(match_histogram(jnp.asarray(shuffled), table), exact, atol=2e-3)


def test_what_is_distributed_so_already_stays() -> None:
    values = draw("laplace", 2)
    table = jnp.asarray(quantile_table(values))
    once = match_histogram(jnp.asarray(values), table)
    assert float(jnp.sqrt(jnp.mean((once - values) ** 2))) < 0.005 * values.std()
    twice = match_histogram(once, table)
    assert float(jnp.sqrt(jnp.mean((twice - once) ** 2))) < 0.005 * values.std()


FINITE = st.floats(-1e6, 1e6, width=32)


@settings(max_examples=60, deadline=None)
@given(arrays(np.float32, 50, elements=FINITE), arrays(np.float32, 30, elements=FINITE))
def test_order_and_ends_are_kept(values: np.ndarray, target: np.ndarray) -> None:
    table = quantile_table(target, count=64)
    matched = np.asarray(match_histogram(jnp.asarray(values), jnp.asarray(table)))
    assert np.isfinite(matched).all()
    slack = 1e-5 * float(np.abs(target).max())
    assert (np.diff(matched[np.argsort(values, kind="stable")]) >= -slack).all()
    assert matched.min() >= target.min() - slack
    assert matched.max() <= target.max() + slack
    if values.max() > values.min():
        assert matched[values.argmin()] == pytest.approx(target.min(), abs=100 * slack)
        assert matched[values.argmax()] == pytest.approx(target.max(), abs=100 * slack)


def test_the_map_has_no_steps() -> None:
    values = jnp.linspace(-1, 1, 200_001)
    matched = match_histogram(values, jnp.asarray(quantile_table(np.linspace(0, 7, 1000))))
    assert float(jnp.diff(matched).max()) < 2.5 * 7 / 200_000


@pytest.mark.parametrize("value", [0.0, 1.0, -3e5, 1e-30])
def test_values_all_equal(value: float) -> None:
    table = jnp.asarray(quantile_table(draw("uniform", 0)))
    matched = match_histogram(jnp.full((4, 5), value), table)
    assert np.allclose(matched, np.median(draw("uniform", 0)), atol=1e-3)
    constant = match_histogram(jnp.asarray(draw("normal", 0)), jnp.full(512, value))
    assert np.array_equal(constant, np.full(COUNT, np.float32(value)))


def test_scale_and_shape_do_not_matter() -> None:
    values, table = jnp.asarray(draw("exponential", 3)), jnp.asarray(quantile_table(draw("normal", 4)))
    plain = match_histogram(values, table)
    np.testing.assert_allclose(match_histogram((1e-6 * values).reshape(100, 400), table).ravel(), plain, atol=1e-3)


def test_rows_of_a_batch_are_their_own() -> None:
    values = jnp.stack([jnp.asarray(draw(name, 5)) for name in DRAWS])
    tables = jnp.stack([jnp.asarray(quantile_table(draw(name, 6))) for name in DRAWS])
    together = jax.vmap(match_histogram)(values, tables)
    for row in range(len(DRAWS)):
        np.testing.assert_allclose(together[row], match_histogram(values[row], tables[row]), rtol=1e-4, atol=1e-4)


def test_tables_hold_the_quantiles() -> None:
    values = draw("long tails", 7)
    table = quantile_table(np.stack([values, -values]), count=101)
    probability = 0.5 - 0.5 * np.cos(np.pi * np.arange(101) / 100)
    np.testing.assert_allclose(table[0], np.quantile(values, probability), rtol=1e-3, atol=1e-5)
    np.testing.assert_allclose(table[1], -table[0, ::-1], rtol=1e-3, atol=1e-5)
    np.testing.assert_allclose(look_up(jnp.asarray(table[0]), jnp.asarray(probability)), table[0], rtol=1e-2, atol=1e-4)


@pytest.mark.parametrize("name", ["uniform", "normal", "laplace", "exponential"])
def test_the_variance_of_a_table(name: str) -> None:
    values = draw(name, 8)
    assert float(table_variance(jnp.asarray(quantile_table(values)))) == pytest.approx(values.var(), rel=5e-3)


@pytest.mark.parametrize(("values", "count"), [([], 5), ([1.0], 1)])
def test_no_table(values: list[float], count: int) -> None:
    with pytest.raises(ValueError, match="give at least 2 of at least 1"):
        quantile_table(values, count=count)


def test_a_single_value_is_its_own_table() -> None:
    assert quantile_table([3.0], count=4).tolist() == [3.0] * 4
