"""Solid textures by optimisation: steps against plain loops, things that stay whole, blocks that go on at faces."""

import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree

from jaxtex.synthesis import solid_optimisation
from jaxtex.synthesis.exemplars import analyse_levels, look_around, neighbourhood_weights
from jaxtex.synthesis.solid_optimisation import optimise_solid, optimise_steps
from jaxtex.synthesis.solid_relaxation import relax_solid
from jaxtex.synthesis.solid_views import AXES, align_views

KEY = jax.random.key(3)
RADIUS, SPACING = 3, 2


def draw_balls(side: int = 96) -> np.ndarray:
    """A slice through dark balls in light ground, [row, col, 1]."""
    rng = np.random.default_rng(1)
    discs: list[tuple[np.ndarray, float]] = []
    for centre, height in zip(rng.uniform(0, side, (90, 2)), rng.uniform(0, 1, 90), strict=True):
        radius = 6 * np.sqrt(1 - height**2)
        if all(np.hypot(*(centre - other)) > radius + its + 1.5 for other, its in discs):
            discs.append((centre, radius))
    row, column = np.indices((side, side))
    away = np.min([np.hypot(row - y, column - x) - radius for (y, x), radius in discs], axis=0)
    return (0.2 + 0.6 * np.clip(away + 0.5, 0, 1))[..., None]


def draw_lines(side: int = 64) -> np.ndarray:
    """Coloured lines along rows."""
    noise = np.random.default_rng(0).normal(size=(side, side, 3))
    smooth = gaussian_filter(noise, (0.7, 8, 0), mode="wrap")
    return np.clip(0.5 + 0.1 * smooth / smooth.std() + 0.01 * noise, 0, 1)


@pytest.fixture(scope="module")
def balls() -> np.ndarray:
    return optimise_solid(dict.fromkeys(AXES, draw_balls()), 32, key=KEY, iterations=4)


def test_slices_look_like_places_of_their_views(balls: np.ndarray) -> None:
    """Each neighbourhood is more like some place of the view than those of noise with the same frequencies and
    colours are, which shows no balls."""
    view = draw_balls().astype(np.float32)
    noise = relax_solid(dict.fromkeys(AXES, view), 32, key=KEY)
    inside = np.s_[RADIUS:-RADIUS, RADIUS:-RADIUS]
    there = cKDTree(look_around(view, RADIUS).reshape(*view.shape[:2], -1)[inside].reshape(-1, 49))
    for axis in range(3):
        made, relaxed = (
            np.mean([there.query(look_around(each, RADIUS)[::5, :, 0])[0] for each in np.moveaxis(block, axis, 0)[::4]])
            for block in (balls, noise)
        )
        assert made < 0.87 * relaxed


def test_blocks_go_on_at_their_faces(balls: np.ndarray) -> None:
    for axis in range(3):
        steps = np.square(np.diff(balls, axis=axis)).mean(axis=tuple(set(range(4)) - {axis}))
        across = np.square(np.take(balls, 0, axis) - np.take(balls, -1, axis)).mean()
        assert across < 1.5 * steps.max()


def test_grain_runs_where_the_views_say() -> None:
    """Lines along x in xy and xz; across x, the third view is left as these make it."""
    lines = draw_lines()
    block = optimise_solid({"xy": lines, "xz": lines[::-1]}, 17, key=KEY, iterations=3)
    along_z, along_y, along_x = (np.square(block - np.roll(block, 1, axis)).mean() for axis in range(3))
    assert along_x < 0.3 * min(along_y, along_z)


def test_the_same_key_makes_the_same_block() -> None:
    views = {"xy": draw_lines(), "xz": draw_lines()[::-1]}
    first, second, other = (optimise_solid(views, 17, key=jax.random.key(seed), iterations=2) for seed in (0, 0, 1))
    np.testing.assert_array_equal(first, second)
    assert first.shape == (17, 17, 17, 3)
    assert np.abs(first - other).max() > 0.05


def test_steps_go_from_coarse_to_fine() -> None:
    views = align_views({"xy": draw_lines(80)}, 50)
    steps = list(optimise_steps(views.pictures, 50, key=KEY, iterations=2))
    assert [step.voxels.shape[1:] for step in steps] == [(25, 25, 25)] * 2 + [(50, 50, 50)] * 2
    assert [(step.done, step.total) for step in steps] == [(number, 4) for number in (1, 2, 3, 4)]


@pytest.mark.parametrize("name", AXES)
def test_places_are_the_nearest_of_all(name: str) -> None:
    """Against a plain loop over all places, none of them yet used more than others."""
    rng = np.random.default_rng(0)
    level = analyse_levels(
        rng.random((14, 15, 2)).astype(np.float32), np.ones((14, 15), bool), radius=RADIUS, coarsest=14
    )[0]
    voxels = rng.random((2, 5, 6, 7)).astype(np.float32)
    slices = np.moveaxis(voxels, (AXES[name] + 1, 0), (0, -1))
    lattice = tuple(-(-side // SPACING) for side in slices.shape[1:3])
    places = rng.choice(np.flatnonzero(level.valid), (len(slices), *lattice)).astype(np.int32)
    exemplar = solid_optimisation._gather(level)
    found, distance = solid_optimisation._find_places(voxels, places, exemplar, AXES[name], True)

    weights = neighbourhood_weights(RADIUS)[:, None]
    row, column = np.indices((14, 15)) // 4
    cell = (row * 4 + column).ravel()
    usual = np.bincount(cell, level.valid.ravel()) * places.size / level.valid.sum()
    views = (look_around(level.pixels, RADIUS) * weights).reshape(level.valid.size, -1) @ np.asarray(level.basis)
    for number, row, column in np.ndindex(found.shape):
        wrapped = np.pad(slices[number], [(9, 9), (9, 9), (0, 0)], mode="wrap")
        y, x = (9 - RADIUS + SPACING * each for each in (row, column))
        window = wrapped[y : y + 7, x : x + 7].reshape(49, 2) * weights
        away = np.square(views - window.ravel() @ np.asarray(level.basis)).sum(axis=1)
        assert distance[number, row, column] == pytest.approx(away[found[number, row, column]], rel=1e-3)
        if number == 0:
            # Who is placed later in the first slice does not count yet: only where the others were.
            used = np.bincount(cell[places[1:].ravel()], minlength=len(usual))
            burden = np.where(level.valid.ravel(), np.maximum(used / np.maximum(usual, 1), 1)[cell], np.inf)
            best = np.argmin(away * burden)
            assert away[found[number, row, column]] * burden[found[number, row, column]] == pytest.approx(
                away[best] * burden[best], rel=1e-3
            )


@pytest.mark.parametrize("name", AXES)
def test_means_are_those_of_what_places_say(name: str) -> None:
    """Against a plain loop over neighbourhoods and their pixels."""
    rng = np.random.default_rng(0)
    axis = AXES[name]
    level = analyse_levels(
        rng.random((12, 13, 2)).astype(np.float32), np.ones((12, 13), bool), radius=RADIUS, coarsest=12
    )[0]
    places = rng.choice(np.flatnonzero(level.valid), (5, 3, 4)).astype(np.int32)
    slices = np.zeros((5, 6, 7, 3))
    distance = rng.random(places.shape).astype(np.float32)
    near = neighbourhood_weights(RADIUS).reshape(7, 7) ** 2
    spread = np.asarray(level.features).var(axis=0).sum()
    for number, row, column in np.ndindex(places.shape):
        at = divmod(places[number, row, column], 13)
        count = (distance[number, row, column] / spread + 0.01) ** -0.6
        for y, x in np.ndindex(7, 7):
            colour = level.pixels[at[0] + y - RADIUS, at[1] + x - RADIUS]
            target = number, (SPACING * row + y - RADIUS) % 6, (SPACING * column + x - RADIUS) % 7
            slices[target] += count * near[y, x] * np.append(colour, 1)
    total = jnp.zeros(np.moveaxis(slices, (0, -1), (axis + 1, 0)).shape)
    exemplar = solid_optimisation._gather(level)
    summed = solid_optimisation._add_places(total, places, distance, exemplar, axis)
    np.testing.assert_allclose(np.moveaxis(summed, (axis + 1, 0), (0, -1)), slices, rtol=1e-4)


def test_the_known_place_is_found_among_options() -> None:
    """In slices that are pieces of the view, neighbours' continuations lead to where the pieces are from."""
    rng = np.random.default_rng(0)
    picture = rng.random((40, 40, 3)).astype(np.float32)
    level = analyse_levels(picture, np.ones((40, 40), bool), radius=RADIUS, coarsest=40)[0]
    voxels = np.moveaxis(np.stack([picture[6:34, 5:33]] * 4), -1, 0)
    lattice = SPACING * np.arange(14)
    right = (6 + lattice[:, None]) * 40 + 5 + lattice[None]
    places = np.where(rng.random((4, 14, 14)) < 0.3, right[None], 20 * 40 + 20).astype(np.int32)
    exemplar = solid_optimisation._gather(level)
    for _ in range(6):
        places, _ = solid_optimisation._find_places(voxels, places, exemplar, 0, False)
    inside = np.s_[:, 2:-2, 2:-2]  # where neighbourhoods do not wrap
    assert np.mean(np.asarray(places)[inside] == np.broadcast_to(right, places.shape)[inside]) > 0.98


@pytest.mark.parametrize("sides", [(12, 14), (13, 11)])
def test_options_continue_what_neighbours_are_taken_from(sides: tuple[int, int]) -> None:
    """Against plain loops; where a block's faces meet, too."""
    rng = np.random.default_rng(0)
    shape, lattice = (9, 10), tuple(-(-side // SPACING) for side in sides)
    beside = rng.integers(0, 90, (3, *lattice)).astype(np.int32)
    similar = rng.integers(0, 90, (90, 2)).astype(np.int32)
    options = solid_optimisation._list_options(jnp.asarray(beside), jnp.asarray(similar), shape, sides)
    for index, (row, column) in enumerate(np.ndindex(lattice)):
        expected = []
        for y, x in itertools.product((-1, 0, 1), repeat=2):
            other = (row + y) % lattice[0], (column + x) % lattice[1]
            away = [
                min((SPACING * (own - its) + wrap * side for wrap in (-1, 0, 1)), key=abs)
                for own, its, side in zip((row, column), other, sides, strict=True)
            ]
            for place in similar[beside[1][other]]:
                down, right = place // 10 + away[0], place % 10 + away[1]
                inside = 0 <= down < 9 and 0 <= right < 10
                expected.append(down * 10 + right if inside else beside[1][row, column])
        expected += [*similar[beside[0][row, column]], *similar[beside[2][row, column]]]
        assert options[index].tolist() == expected


@pytest.mark.parametrize(("coarse_side", "side"), [(16, 32), (9, 17), (9, 18)])
def test_finer_places_are_where_the_enlarged_block_shows_them(coarse_side: int, side: int) -> None:
    """A block that is a ramp, taken from a view that is one, is still that of the finer view."""
    picture = np.indices((64, 64)).sum(axis=0, dtype=np.float32)[..., None]
    fine, coarse = analyse_levels(picture, np.ones((64, 64), bool), radius=RADIUS, coarsest=32)
    lattice = -(-coarse_side // SPACING)
    row, column = np.indices((lattice, lattice)) * SPACING
    places = jnp.asarray(np.broadcast_to((row + 5) * 32 + column + 6, (coarse_side, lattice, lattice)), jnp.int32)
    below = np.asarray(solid_optimisation._descend(places, coarse, fine, side))
    voxels = np.broadcast_to(coarse.pixels[5:, 6:][:coarse_side, :coarse_side, 0], (1, *(coarse_side,) * 3))
    shown = np.asarray(solid_optimisation._enlarge(jnp.asarray(voxels), side))[0][:, ::SPACING, ::SPACING]
    inside = np.s_[:, 2:-2, 2:-2]  # the ramp ends where the block begins again
    away = np.abs(picture.ravel()[below] - shown)[inside]
    assert below.shape == (side, -(-side // SPACING), -(-side // SPACING))
    assert away.max() < (1.1 if side == 2 * coarse_side else 2.6)  # steps of 2 a pixel along the diagonal


def test_places_are_shared_out() -> None:
    """Of a view that is nearly flat in nine places of ten, the flat ones are not used more often than that."""
    rng = np.random.default_rng(0)
    picture = (0.01 * rng.random((40, 40, 1)) + 0.5).astype(np.float32)
    picture[:, :8] = rng.random((40, 8, 1))
    level = analyse_levels(picture, np.ones((40, 40), bool), radius=RADIUS, coarsest=40)[0]
    exemplar = solid_optimisation._gather(level)
    voxels = np.full((1, 24, 24, 24), 0.505, np.float32)
    places = rng.choice(np.flatnonzero(level.valid), (24, 12, 12)).astype(np.int32)
    for _ in range(3):
        places, _ = solid_optimisation._find_places(voxels, places, exemplar, 0, True)
    row, column = np.divmod(np.asarray(places), 40)
    used = np.bincount((row // 4 * 10 + column // 4).ravel(), minlength=100)
    flat = used.reshape(10, 10)[1:-1, 4:-1]
    assert flat.max() < 4 * flat.mean()


def test_textures_finer_than_coarse_levels_are_made() -> None:
    stripes = np.broadcast_to(np.array([0.2, 0.8])[np.arange(96) % 2, None], (96, 96, 1))
    block = optimise_solid({"xy": stripes}, 32, key=KEY, iterations=2)
    assert np.abs(np.diff(block, axis=2)).mean() > 0.4


def test_the_scale_of_values_does_not_matter() -> None:
    view = draw_lines()[:24, :24, :1]
    one, other = (optimise_solid({"xy": scale * view}, 16, key=KEY, iterations=1) for scale in (1, 2.0**-20))
    np.testing.assert_allclose(other * 2.0**20, one, atol=1e-3)


def test_single_precision_stays_single() -> None:
    with jax.enable_x64(True):
        views = align_views({"xy": draw_lines()[:24, :24, :1]}, 16)
        (step,) = optimise_steps(views.pictures, 16, key=jax.random.key(0), iterations=1)
        assert step.voxels.dtype == jnp.float32


@pytest.mark.parametrize(("side", "iterations", "complaint"), [(16, 0, "iterations: 0"), (6, 1, "side: 6 voxels")])
def test_what_cannot_be_made_is_told(side: int, iterations: int, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        optimise_solid({"xy": draw_lines()}, side, key=KEY, iterations=iterations)
