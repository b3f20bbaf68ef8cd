"""Fields from keys: they pass through their keys, never beyond, and say what is wrong with keys."""

import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.progressive.fields import FieldKey, orientation_field, scale_field, transition_field

SIZE = 96, 64


def point(x: float, y: float, value: float | None) -> FieldKey:
    return FieldKey(((x, y),), value)


def scattered(seed: int, low: float, high: float) -> list[FieldKey]:
    rng = np.random.default_rng(seed)
    cells = rng.permutation(24)[:8]  # of 6 x 4: keys that lie apart
    return [point((cell % 6 + 0.5) / 6, (cell // 6 + 0.5) / 4, rng.uniform(low, high)) for cell in cells.tolist()]


def at(field: np.ndarray, key: FieldKey) -> np.ndarray:
    (x, y), *_ = key.places
    return field[min(int(y * SIZE[1]), SIZE[1] - 1), min(int(x * SIZE[0]), SIZE[0] - 1)]


@pytest.mark.parametrize("seed", range(4))
def test_fields_pass_through_their_keys_and_not_beyond(seed: int) -> None:
    keys = scattered(seed, 0.2, 0.9)
    values = [key.value for key in keys]
    for make in (scale_field, transition_field):
        field = make(keys, SIZE)
        assert field.shape == (64, 96)
        assert field.dtype == np.float32
        assert field.min() >= np.float32(min(values))
        assert field.max() <= np.float32(max(values))
        for key in keys:
            assert at(field, key) == pytest.approx(key.value, abs=0.03)
        assert np.abs(np.diff(field, axis=1)).max() < 0.1  # no steps


def test_between_two_keys_a_field_goes_evenly_and_beyond_it_is_level() -> None:
    field = transition_field([point(0.25, 0.5, 0.0), point(0.75, 0.5, 1.0)], SIZE)
    across = (np.arange(96) + 0.5) / 96
    assert np.abs(field[32] - np.clip(2 * across - 0.5, 0, 1)).max() < 0.06
    assert (np.diff(field[32]) >= -1e-6).all()


def test_scale_is_interpolated_as_ratios() -> None:
    field = scale_field([point(0.0, 0.5, 0.25), point(1.0, 0.5, 4.0)], (97, 3))
    assert field[1, 48] == pytest.approx(1.0, rel=1e-4)
    assert np.allclose(field[1] * field[1, ::-1], 1.0, rtol=1e-4)


def test_a_field_does_not_depend_on_the_size_of_the_picture() -> None:
    keys = scattered(1, 0.0, 1.0)
    small, large = transition_field(keys, (48, 32)), transition_field(keys, (144, 96))
    assert np.allclose(large[1::3, 1::3], small, atol=1e-6)


@pytest.mark.parametrize("make", [scale_field, transition_field])
def test_one_key_is_the_same_everywhere(make) -> None:
    assert np.allclose(make([point(0.1, 0.9, 0.7)], SIZE), 0.7)


def test_one_stroke_is_followed_along_its_length() -> None:
    stroke = FieldKey(((0.0, 0.2), (0.5, 0.2), (0.5, 1.0)), 0.3)
    field = transition_field([stroke, point(0.9, 0.1, 0.9)], SIZE)
    assert np.abs(field[12, :46] - 0.3).max() < 0.03
    assert np.abs(field[16:, 47] - 0.3).max() < 0.03


def test_strokes_have_their_own_directions() -> None:
    around = np.linspace(0, 2 * np.pi, 60)
    circle = FieldKey(
        tuple(zip((0.5 + 0.3 * np.cos(around)).tolist(), (0.5 + 0.3 * np.sin(around)).tolist(), strict=True))
    )
    field = orientation_field([circle], (80, 80))
    x, y = np.indices((80, 80))[::-1] + 0.5 - 40
    ring = np.abs(np.hypot(x, y) - 24) < 6
    expected = np.stack([-y, x], axis=-1) / np.hypot(x, y)[..., None]
    assert np.sum(field * expected, axis=-1)[ring].min() > np.cos(np.radians(8))
    assert np.allclose(np.hypot(field[..., 0], field[..., 1]), 1, atol=1e-5)


@pytest.mark.parametrize("symmetric", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_directions_pass_through_their_keys(symmetric: bool, seed: int) -> None:
    keys = scattered(seed, 0.0, 1.2)
    field = orientation_field(keys, SIZE, symmetric=symmetric)
    for key in keys:
        along = at(field, key) @ [np.cos(key.value), np.sin(key.value)]
        assert (abs(along) if symmetric else along) > np.cos(0.06)


def test_symmetric_directions_go_the_short_way_and_do_not_turn_over() -> None:
    keys = [point(0.0, 0.5, np.radians(10)), point(1.0, 0.5, np.radians(170))]
    assert np.abs(orientation_field(keys, SIZE, symmetric=True)[..., 1]).max() < np.sin(np.radians(11))
    # Turned by 280 degrees from left to right: folded angles jump on the way, the vectors must not.
    keys = [FieldKey(((part, 0.0), (part, 1.0)), np.radians(10 + 280 * part)) for part in np.linspace(0, 1, 6).tolist()]
    field = orientation_field(keys, SIZE, symmetric=True)
    assert np.sum(field[:, 1:] * field[:, :-1], axis=-1).min() > 0.9
    assert np.sum(field[1:] * field[:-1], axis=-1).min() > 0.9
    signs = [at(field, key) @ [np.cos(key.value), np.sin(key.value)] for key in keys]
    assert np.allclose(np.abs(signs), 1, atol=0.01)
    assert np.ptp(np.sign(signs)) == 0


def test_opposite_directions_still_give_unit_vectors() -> None:
    field = orientation_field([point(0.0, 0.5, 0.0), point(1.0, 0.5, np.pi)], (95, 63))
    assert np.allclose(np.hypot(field[..., 0], field[..., 1]), 1, atol=1e-5)


def test_maps_are_stretched_over_the_picture() -> None:
    ramp = np.linspace(0.5, 2.0, 16) * np.ones((4, 1))
    field = scale_field(ramp, (64, 16))
    assert field.shape == (16, 64)
    assert np.allclose(scale_field(ramp, (16, 4)), ramp, rtol=1e-6)
    assert (np.diff(field, axis=1) >= 0).all()
    angles = np.radians([[170.0, 190.0]])
    vectors = 3.0 * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    assert np.allclose(orientation_field(vectors, (4, 2), symmetric=True)[..., 0], -1, atol=0.02)


@pytest.mark.parametrize("size", [(1, 1), (1, 40), (40, 1), (2, 3)])
def test_pictures_may_be_narrow(size: tuple[int, int]) -> None:
    keys = scattered(0, 0.1, 1.0)
    assert scale_field(keys, size).shape == size[::-1]
    assert np.isfinite(orientation_field(keys, size, symmetric=True)).all()


WRONG = [
    (scale_field, [], "scale: has no keys; give one at least"),
    (scale_field, [point(0.5, 0.5, 0.0)], "scale: key 1 is 0; give a value above 0"),
    (scale_field, [point(0.5, 0.5, -1.0)], "scale: key 1 is -1; give a value above 0"),
    (scale_field, [point(0.5, 0.5, np.nan)], "scale: key 1 is nan; give a value above 0"),
    (scale_field, [point(0.5, 0.5, None)], "scale: key 1 has no value; give one above 0"),
    (transition_field, [point(0.5, 0.5, 1.0), point(0.2, 0.5, 1.5)], "key 2 is 1.5; give a value from 0 to 1"),
    (transition_field, [point(1.2, 0.5, 1.0)], r"key 1: \(1.2, 0.5\) is outside of the picture"),
    (transition_field, [FieldKey((), 1.0)], "key 1: has no place"),
    (transition_field, [FieldKey(((0.1, 0.1), (0.1, 0.1)), 1.0)], "key 1: is a stroke of no length"),
    (
        transition_field,
        [point(0.2, 0.5, 0.0), point(0.5, 0.5, 0.3), point(0.5, 0.5, 0.4)],
        r"transition: keys 2 and 3 say different values for one place, \(0.5, 0.5\); leave one out",
    ),
    (
        scale_field,
        [FieldKey(((0.1, 0.13), (0.9, 0.77)), 1.0), FieldKey(((0.1, 0.91), (0.9, 0.2)), 2.0)],
        "scale: keys 1 and 2 say different values for one place",
    ),
    (orientation_field, [], "orientation: has no keys"),
    (orientation_field, [point(0.5, 0.5, None)], "orientation: key 1 is a point without value"),
    (orientation_field, [point(0.5, 0.5, np.inf)], "orientation: key 1 is inf; give an angle"),
    (orientation_field, [point(0.5, 0.5, 0.0), point(0.5, 0.5, np.pi)], "keys 1 and 2 say different values"),
    (scale_field, np.zeros((2, 2)), "scale: a value of the map is 0; give a value above 0"),
    (scale_field, np.ones((2, 2, 1)), r"scale: a map of shape \(2, 2, 1\); give \[row, col\]"),
    (transition_field, np.full((2, 2), np.nan), "transition: the map holds a number that is not finite"),
    (orientation_field, np.zeros((2, 2, 2)), "a vector of length 0"),
    (orientation_field, np.zeros((2, 2)), r"orientation: a map of shape \(2, 2\); give \[row, col, 2\]"),
]


@pytest.mark.parametrize(("make", "given", "told"), WRONG)
def test_what_is_wrong_with_keys_is_said_in_one_line(make, given, told: str) -> None:
    with pytest.raises(InputError, match=told) as complaint:
        make(given, SIZE)
    assert "\n" not in str(complaint.value)


def test_keys_that_agree_may_meet() -> None:
    keys = [point(0.5, 0.5, 0.3), point(0.5, 0.5, 0.3), FieldKey(((0.0, 0.5), (1.0, 0.5)), 0.3), point(0.5, 0.0, 0.8)]
    assert np.allclose(transition_field(keys, SIZE)[31:33, 5:90], 0.3, atol=0.03)
    # Turned by half is the same, where that is said.
    opposite = [point(0.5, 0.5, 0.0), point(0.5, 0.5, np.pi)]
    assert np.allclose(orientation_field(opposite, SIZE, symmetric=True), [1.0, 0.0], atol=1e-6)
