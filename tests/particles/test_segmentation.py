"""Finding things: on grounds of any kind, touching or not, of one class or several."""

import numpy as np
import pytest
from scipy import ndimage

from jaxtex.core.errors import InputError
from jaxtex.particles.ground import split_touching
from jaxtex.particles.segmentation import find_particles


def draw_discs(places: list[tuple[int, int]], radius: float, shape: tuple[int, int]) -> np.ndarray:
    row, column = np.indices(shape) + 0.5
    return np.min([np.hypot(row - y, column - x) for x, y in places], axis=0) < radius


def scatter(seed: int, count: int, apart: float, shape: tuple[int, int]) -> list[tuple[int, int]]:
    rng, places = np.random.default_rng(seed), []
    while len(places) < count:
        place = rng.integers(0, shape[::-1])
        if all(np.hypot(*(place - other)) > apart for other in places):
            places.append(place)
    return [tuple(each) for each in places]


PLACES = scatter(0, 30, 22, (150, 200))


@pytest.mark.parametrize(("thing", "ground"), [(0.6, 0.05), (0.03, 0.5)])
def test_things_are_found_on_noise_and_under_a_slope_of_light(thing: float, ground: float) -> None:
    things = draw_discs(PLACES, 8, (150, 200))
    noise = np.random.default_rng(1).lognormal(0, 0.1, things.shape)
    light = np.linspace(0.6, 1.4, 200)[None]
    found = find_particles(np.where(things, thing, ground) * noise * light)
    assert len(found.particles) == 30
    assert np.mean((found.labels > 0) == things) > 0.97


def test_kinds_are_told_by_colour() -> None:
    shape = (150, 200)
    red, blue = draw_discs(PLACES[:15], 8, shape), draw_discs(PLACES[15:], 8, shape)
    picture = np.full((*shape, 3), 0.7)
    picture[red], picture[blue] = (0.6, 0.05, 0.05), (0.05, 0.1, 0.6)
    found = find_particles(picture)
    assert (len(found.particles), found.kinds) == (30, 2)
    colours = [
        {each.kind for each, own in zip(found.particles, mean_of(found.labels, kind), strict=True) if own > 0.5}
        for kind in (red, blue)
    ]
    assert sorted(map(len, colours)) == [1, 1]
    assert colours[0] != colours[1]
    assert find_particles(picture, kinds=1).kinds == 1


def mean_of(labels: np.ndarray, mask: np.ndarray) -> np.ndarray:
    return ndimage.mean(mask, labels, np.arange(1, labels.max() + 1))


def test_touching_things_are_parted_where_they_are_narrow() -> None:
    row, column = np.indices((40, 200))
    chain = np.hypot(row - 20, column % 18 - 9) < 10
    labels = split_touching(chain)
    assert abs(labels.max() - 11) <= 1
    cuts = np.flatnonzero(np.diff(labels[20]) != 0)
    assert np.all(np.abs((cuts + 1) % 18 - 18 * ((cuts + 1) % 18 > 9)) <= 1)
    assert ((labels > 0) == chain).all()


def test_a_thing_with_a_waist_that_is_hardly_narrower_stays_whole() -> None:
    row, column = np.indices((40, 60))
    peanut = np.minimum(np.hypot(row - 20, column - 27), np.hypot(row - 20, column - 33)) < 12
    assert split_touching(peanut).max() == 1


def test_what_is_cut_off_is_told() -> None:
    things = draw_discs(
        [(0, 30), (30, 30), (60, 30), (90, 32), (30, 62), (60, 60), (92, 60), (30, 88), (60, 90)], 9, (110, 110)
    )
    found = find_particles(np.where(things, 0.1, 0.6))
    assert sorted(each.complete for each in found.particles) == [False] + [True] * 8


@pytest.mark.parametrize(
    ("picture", "complaint"),
    [
        (np.full((64, 64), 0.4), "all of one colour"),
        (np.random.default_rng(0).random((8, 64)), "too small"),
        (np.full((64, 64), np.nan), "NaN"),
    ],
)
def test_where_nothing_can_be_found_it_is_told(picture: np.ndarray, complaint: str) -> None:
    with pytest.raises(InputError, match=complaint):
        find_particles(picture)


def test_no_kind_is_told() -> None:
    with pytest.raises(InputError, match="kinds: 0"):
        find_particles(np.random.default_rng(0).random((64, 64)), kinds=0)
