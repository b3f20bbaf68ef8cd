"""Anisometric synthesis: things as large and turned as fields say, and each decision as a plain loop makes it."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter, label, map_coordinates

from jaxtex.synthesis.anisometric import Transition, make_frames, sample_sources, synthesise_anisometric
from jaxtex.synthesis.anisometric_pass import Given, Known, decide_all, order_pixels
from jaxtex.synthesis.anisometric_start import lay_pieces
from jaxtex.synthesis.exemplars import analyse_levels, neighbourhood_taps, neighbourhood_weights

KEY = jax.random.key(0)
RNG = np.random.default_rng(0)


def draw_stripes(rows: int, columns: int, period: float) -> np.ndarray:
    """Vertical stripes, with a little grain."""
    column = np.arange(columns)[None, :, None]
    grain = RNG.normal(0, 0.02, (rows, columns, 1))
    return (0.5 + 0.4 * np.sin(2 * np.pi * column / period) + grain).astype(np.float32)


def find_wave(picture: np.ndarray) -> tuple[float, float]:
    """(cycles per pixel, direction in radians modulo pi) of the strongest wave."""
    rows, columns = picture.shape[:2]
    window = np.hanning(rows)[:, None] * np.hanning(columns)[None]
    power = np.abs(np.fft.fft2((picture[..., 0] - picture.mean()) * window, (512, 512)))
    row, column = np.unravel_index(power.argmax(), power.shape)
    y, x = np.fft.fftfreq(512)[[row, column]]
    return float(np.hypot(x, y)), float(np.arctan2(y, x) % np.pi)


@pytest.mark.parametrize(("scale", "degrees"), [(1.0, 0), (2.0, 0), (0.5, 0), (1.0, 30), (1.5, 115)])
def test_waves_are_as_long_and_turned_as_asked(scale: float, degrees: float) -> None:
    exemplar = draw_stripes(72, 80, 8)
    fields = np.full((96, 96), scale), np.full((96, 96), np.radians(degrees))
    made = sample_sources(exemplar, synthesise_anisometric(exemplar, *fields, key=KEY), make_frames(*fields))
    frequency, direction = find_wave(made)
    assert frequency == pytest.approx(1 / (8 * scale), rel=0.06)
    assert np.degrees((direction - np.radians(degrees) + 0.5 * np.pi) % np.pi - 0.5 * np.pi) == pytest.approx(0, abs=3)
    assert made.std() > 0.8 * exemplar.std()


def test_scale_changes_along_the_picture() -> None:
    exemplar = draw_stripes(80, 80, 8)
    scale = np.exp(np.linspace(np.log(0.6), np.log(1.8), 256))[None].repeat(64, axis=0)
    made = sample_sources(exemplar, synthesise_anisometric(exemplar, scale, 0 * scale, key=KEY))
    for left in (0, 96, 192):
        frequency, _ = find_wave(made[:, left : left + 64])
        assert 1 / frequency == pytest.approx(8 * scale[0, left + 32], rel=0.12)


@pytest.mark.parametrize("scale", [0.5, 1.0, 2.0])
def test_spots_are_as_large_as_asked_and_whole(scale: float) -> None:
    exemplar = draw_spots()
    side = 144 if scale > 1 else 96
    fields = np.full((side, side), scale), np.zeros((side, side))
    areas = []
    for key in jax.random.split(KEY, 3):
        made = sample_sources(exemplar, synthesise_anisometric(exemplar, *fields, key=key), make_frames(*fields))
        labels, _ = label(made[..., 0] < 0.5)
        border = np.concatenate([labels[[0, -1]].ravel(), labels[:, [0, -1]].ravel()])
        areas.append(np.bincount(labels.ravel())[np.setdiff1d(labels, border)])
    radii = np.sqrt(np.concatenate(areas) / np.pi) / (5 * scale)
    assert np.median(radii) == pytest.approx(1, abs=0.08)
    assert np.mean(np.abs(radii - 1) < 0.2) > 0.8


def test_seams_of_what_is_enlarged_have_no_stairs() -> None:
    exemplar = gaussian_filter(np.random.default_rng(0).random((64, 64, 1)), (1.5, 1.5, 0))
    sources = synthesise_anisometric(exemplar, np.full((128, 128), 2.0), np.zeros((128, 128)), key=KEY)
    goes_on = np.abs(np.diff(sources, axis=1) - [0, 0.5]).max(axis=2) < 0.1
    seams = 1 - goes_on.mean()
    # Were seams decided at half the resolution, they would all lie between its pixels, and none within one.
    assert seams > 0.02
    assert 1 - goes_on[:, ::2].mean() > 0.5 * seams


def test_parts_of_the_exemplar_are_used_about_equally_often() -> None:
    """By fit alone some of 16 parts came up three times as often as they should, with these keys."""
    exemplar = gaussian_filter(np.random.default_rng(0).random((96, 96, 1)), (2, 2, 0))
    fields = np.ones((160, 160)), np.zeros((160, 160))
    for key in jax.random.split(KEY, 2):
        sources = synthesise_anisometric(exemplar / exemplar.std(), *fields, key=key)
        counts = np.histogram2d(*sources.reshape(-1, 2).T, bins=4, range=[[0, 96]] * 2)[0]
        assert counts.std() < 0.6 * counts.mean()
        assert counts.max() < 2.2 * counts.mean()


def draw_spots() -> np.ndarray:
    """Dark spots of radius 5, one in each square of 20 pixels."""
    rng = np.random.default_rng(0)
    middles = (np.indices((6, 6)).reshape(2, -1).T + 0.5) * 20 + rng.uniform(-3, 3, (36, 2))
    place = np.moveaxis(np.indices((120, 120)), 0, -1)[..., None, :]
    nearest = np.sqrt(np.square(place - middles).sum(axis=-1)).min(axis=-1)
    return (0.25 + 0.5 * np.clip(nearest - 4.5, 0, 1) + rng.normal(0, 0.02, (120, 120)))[..., None]


@pytest.mark.parametrize("scale", [0.05, 16.0])
def test_scales_far_from_the_exemplars(scale: float) -> None:
    sources = synthesise_anisometric(draw_spots(), np.full((9, 30), scale), np.zeros((9, 30)), key=KEY)
    assert sources.shape == (9, 30, 2)
    assert ((sources >= 0) & (sources <= 119)).all()


def test_pieces_to_begin_with_lie_in_the_exemplar() -> None:
    level = analyse_levels(draw_stripes(40, 48, 8), np.ones((40, 48), bool), radius=3, coarsest=32)[0]
    frames = make_frames(np.geomspace(0.8, 3, 90)[None].repeat(60, axis=0), np.full((60, 90), 0.5))
    wanted = Given(frames, np.zeros((60, 90, 0), np.float32), (np.zeros((40, 48), np.float32), np.zeros((60, 90))))
    sources = lay_pieces(level, wanted, 0.1, KEY, 3, False)
    assert ((sources > 3) & (sources < [36, 44])).all(axis=-1).mean() > 0.99  # none is cut off at the border
    assert np.linalg.norm(np.diff(sources, axis=1), axis=-1).min() > 0.25  # neither is a pixel repeated


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans(), st.booleans(), st.booleans())
def test_a_pass_decides_as_a_plain_loop_does(seed: int, tileable: bool, everywhere: bool, framed: bool) -> None:
    rng = np.random.default_rng(seed)
    exemplar = rng.random((20, 22, 2)).astype(np.float32)
    own = make_frames(rng.uniform(0.8, 1.2, (20, 22)), rng.uniform(-0.4, 0.4, (20, 22))) if framed else None
    level = analyse_levels(exemplar, np.ones((20, 22), bool), radius=2, coarsest=20, similar=2, frames=own)[0]
    known = Known(level.pixels, level.valid, level.basis, level.features, level.similar, level.frames)
    frames = make_frames(rng.uniform(0.6, 1.6, (7, 9)), rng.uniform(-1, 1, (7, 9)))
    values = rng.random((20, 22)).astype(np.float32), rng.random((7, 9)).astype(np.float32)
    wanted = Given(frames, rng.random((7, 9, 0)).astype(np.float32), values)
    some = rng.random((7, 9)) < 0.8
    sources = rng.uniform(2, 17, (7, 9, 2)).astype(np.float32)
    got = np.asarray(decide_all(known, wanted, sources, np.float32(0.4), *order_pixels(some), 2, everywhere, tileable))
    expected = decide_plainly(known, wanted, sources, some, 2, everywhere, tileable)
    same = np.abs(got - expected).max(axis=-1) < 1e-3
    assert same.mean() > 0.95  # but for near ties


def decide_plainly(
    known: Known, wanted: Given, sources: np.ndarray, some: np.ndarray, radius: int, everywhere: bool, tileable: bool
) -> np.ndarray:
    tolerance = 0.4
    sources = sources.copy()
    rows, columns = sources.shape[:2]
    ends = np.array(known.valid.shape) - 1
    weights, taps = neighbourhood_weights(radius)[:, None], neighbourhood_taps(radius)
    basis, features = np.asarray(known.basis), np.asarray(known.features).reshape(*known.valid.shape, -1)
    for first in ((0, 0), (1, 1), (0, 1), (1, 0)):
        before = sources.copy()
        for row in range(first[0], rows, 2):
            for column in range(first[1], columns, 2):
                at = np.array([row, column])
                frame, value = wanted.frames[tuple(at)], wanted.transition[1][tuple(at)]
                places = at + taps @ frame.T
                pixels = np.rint(places).astype(int)
                pixels = pixels if tileable else np.clip(pixels, 0, [rows - 1, columns - 1])
                theirs = before[pixels[:, 0] % rows, pixels[:, 1] % columns]
                steps = (places - pixels) @ np.linalg.inv(frame).T
                if known.frames is not None:
                    own = np.clip(np.rint(theirs), 0, ends).astype(int)
                    steps = np.einsum("nij,nj->ni", known.frames[own[:, 0], own[:, 1]], steps)
                window = [
                    map_coordinates(each, (theirs + steps).T, order=1, mode="nearest")
                    for each in np.moveaxis(known.pixels, 2, 0)
                ]
                feature = (np.stack(window, axis=1) * weights).ravel() @ basis
                best, least = before[tuple(at)], np.inf
                for step in np.ndindex(3, 3):
                    away = np.array(step) - 1
                    beside = (
                        (at + away) % [rows, columns] if tileable else np.clip(at + away, 0, [rows - 1, columns - 1])
                    )
                    theirs = before[tuple(beside)]
                    back = np.linalg.inv(frame) @ away
                    if known.frames is not None:
                        back = known.frames[tuple(np.clip(np.rint(theirs), 0, ends).astype(int))] @ back
                    goes_on = theirs - back
                    whole = np.clip(np.rint(goes_on), 0, ends).astype(int)
                    for number, place in enumerate(np.asarray(known.similar)[whole[0] * (ends[1] + 1) + whole[1]]):
                        option = np.array(np.divmod(place, ends[1] + 1)) + goes_on - whole
                        near = np.clip(np.rint(option), 0, ends).astype(int)
                        apart = abs(wanted.transition[0][tuple(near)] - value)
                        if (
                            (option < 0).any()
                            or (option > ends).any()
                            or not known.valid[tuple(near)]
                            or apart >= tolerance
                        ):
                            continue
                        look = np.array(
                            [map_coordinates(each, option[:, None], order=1)[0] for each in np.moveaxis(features, 2, 0)]
                        )
                        distance = np.square(look - feature).sum() * (1.5 if number else 1)
                        if distance < least:
                            best, least = option, distance
                if everywhere:
                    usable = known.valid & (np.abs(wanted.transition[0] - value) < tolerance)
                    far = np.where(usable, np.square(features - feature).sum(axis=-1), np.inf)
                    if 2 * far.min() < least:
                        best = np.array(np.unravel_index(far.argmin(), far.shape))
                if some[row, column]:
                    sources[row, column] = best
    return sources


def test_only_places_of_a_like_transition_value_are_used() -> None:
    exemplar = np.concatenate([draw_stripes(64, 128, 6), draw_stripes(64, 128, 13)], axis=1)
    ours = np.linspace(0, 1, 256, dtype=np.float32)[None].repeat(64, axis=0)
    theirs = np.linspace(0, 1, 96, dtype=np.float32)[:, None].repeat(80, axis=1)
    ones = np.ones((96, 80))
    sources = synthesise_anisometric(exemplar, ones, 0 * ones, key=KEY, transition=Transition(ours, theirs, 0.1))
    place = np.clip(np.rint(sources), 0, [63, 255]).astype(int)
    apart = np.abs(ours[place[..., 0], place[..., 1]] - theirs)
    assert np.quantile(apart, 0.98) < 0.11
    made = sample_sources(exemplar, sources)
    assert 1 / find_wave(made[:40])[0] == pytest.approx(6, rel=0.1)
    assert 1 / find_wave(made[-40:])[0] == pytest.approx(13, rel=0.1)


def test_what_varies_in_the_exemplar_is_straightened() -> None:
    """An exemplar of half circles, whose own orientation is known, makes straight stripes."""
    row, column = np.indices((96, 160)) - np.array([95.0, 79.5])[:, None, None]
    circles = (0.5 + 0.4 * np.sin(2 * np.pi * np.hypot(row, column) / 8))[..., None]
    own = np.ones(row.shape), np.arctan2(row, column)
    ones = np.ones((80, 80))
    usable = Transition(np.where(np.hypot(row, column) > 30, 0, 1).astype(np.float32), 0 * ones.astype(np.float32))
    sources = synthesise_anisometric(circles, ones, 0 * ones, key=KEY, exemplar_frames=own, transition=usable)
    frequency, direction = find_wave(sample_sources(circles, sources))
    assert 1 / frequency == pytest.approx(8, rel=0.06)
    assert abs((np.degrees(direction) + 90) % 180 - 90) < 4


def test_tileable_textures_have_no_seam() -> None:
    grain = np.random.default_rng(1).random((96, 96, 1))
    exemplar = np.asarray(map_coordinates(grain[..., 0], np.indices((96, 96)) / 4, order=3))[..., None]
    ones = np.ones((96, 96))
    made = sample_sources(exemplar, synthesise_anisometric(exemplar, ones, 0 * ones, key=KEY, tileable=True))
    steps = np.abs(np.diff(np.concatenate([made, made[:1]]), axis=0)).mean(axis=(1, 2))
    assert steps[-1] < 1.5 * np.median(steps)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_sources_between_pixels_are_bilinear(dtype: type) -> None:
    picture = np.random.default_rng(2).random((9, 12, 3)).astype(dtype)
    sources = np.random.default_rng(3).uniform(-1, 12, (5, 6, 2))
    expected = [
        map_coordinates(each, np.moveaxis(sources, -1, 0), order=1, mode="nearest") for each in picture.T.swapaxes(1, 2)
    ]
    np.testing.assert_allclose(sample_sources(picture, sources), np.stack(expected, axis=-1), atol=1e-5)


def test_a_texture_made_smaller_is_a_mean_of_what_it_covers() -> None:
    picture = np.random.default_rng(2).random((40, 40, 1))
    sources = np.stack(np.meshgrid(4.5 + 4 * np.arange(6), 4.5 + 4 * np.arange(6), indexing="ij"), axis=-1)
    frames = make_frames(np.full((6, 6), 0.25), np.zeros((6, 6)))
    small = sample_sources(picture, sources, frames)
    blocks = picture[3:27, 3:27].reshape(6, 4, 6, 4).mean(axis=(1, 3))
    np.testing.assert_allclose(small[..., 0], blocks, atol=1e-5)


def test_same_seed_same_texture() -> None:
    exemplar, ones = draw_stripes(48, 48, 7), np.ones((40, 40))
    first, second = (synthesise_anisometric(exemplar, ones, 0 * ones, key=KEY) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    assert not np.array_equal(first, synthesise_anisometric(exemplar, ones, 0 * ones, key=jax.random.key(1)))


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"scale": np.zeros((8, 8))}, "above 0"),
        ({"scale": np.full((8, 8), np.nan)}, "finite"),
        ({"scale": np.ones((8, 9))}, "shape"),
        ({"exemplar": np.ones((4, 40, 1))}, "neighbourhood"),
        ({"similar": -1}, "similar"),
        ({"exemplar_frames": (np.ones((8, 8)), np.ones((8, 8)))}, "exemplar_frames"),
        (
            {"exemplar": np.ones((9, 9, 1)), "exemplar_frames": (np.ones((9, 9)), np.full((9, 9), 0.8))},
            "no neighbourhood",
        ),
        ({"transition": Transition(np.ones((8, 8)), np.ones((8, 8)))}, "transition"),
        ({"transition": Transition(np.ones((48, 48)), np.ones((8, 8)), 0.0)}, "tolerance"),
        ({"guides": (np.ones((48, 48, 1)), np.ones((9, 8, 1)))}, "guides"),
        ({"guide_weight": 0.0}, "guide_weight"),
    ],
)
def test_what_cannot_be_made(change: dict, told: str) -> None:
    wanted = {"exemplar": np.ones((48, 48, 1)), "scale": np.ones((8, 8)), "orientation": np.zeros((8, 8)), **change}
    with pytest.raises(ValueError, match=told):
        synthesise_anisometric(**wanted, key=KEY)


def test_frames_turn_clockwise_as_seen() -> None:
    frame = make_frames([[2.0]], [[np.radians(90)]])[0, 0]
    np.testing.assert_allclose(frame @ [0, 1], [2, 0], atol=1e-6)  # to the right becomes down
    np.testing.assert_allclose(frame @ [1, 0], [0, -2], atol=1e-6)
    assert jnp.asarray(frame).dtype == jnp.float32


def test_double_precision() -> None:
    exemplar, fields = draw_stripes(16, 16, 8), (np.full((12, 12), 1.5), np.full((12, 12), 0.5))
    with jax.enable_x64():
        made = synthesise_anisometric(exemplar, *fields, key=jax.random.key(0), similar=1)
    assert made.shape == (12, 12, 2)
    assert ((made >= 0) & (made <= 15)).all()
