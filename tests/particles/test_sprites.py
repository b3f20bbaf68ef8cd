"""Particles cut out with their surroundings, transformed, and where they come to lie."""

import itertools

import numpy as np
import pytest
from scipy import ndimage

from jaxtex.particles.sprites import Cut, Sprite, SpriteSheet, find_places, transform_cut, transform_sprite
from jaxtex.particles.things import Decomposition, describe_particles

ROW, COLUMN = np.indices((90, 120))


def scatter_discs() -> Decomposition:
    labels = np.zeros((90, 120), int)
    for number, (row, column, radius) in enumerate(
        [(20, 25, 9), (22, 48, 8), (60, 30, 12), (55, 80, 15), (15, 100, 6)]
    ):
        labels[np.hypot(ROW - row, COLUMN - column) < radius] = number + 1
    return describe_particles(labels, [0] * 5)


DISCS = scatter_discs()
PICTURE = np.random.default_rng(0).random((90, 120, 2)).astype(np.float32)
SHEET = SpriteSheet(PICTURE, PICTURE, DISCS)


def lie_where_they_were(number: int) -> tuple[Sprite, tuple[slice, slice]]:
    sprite, box = SHEET[number], DISCS.particles[number].box
    top, left = round(box.y - sprite.y), round(box.x - sprite.x)
    rows, columns = sprite.cover.shape
    return sprite, (slice(top, top + rows), slice(left, left + columns))


@pytest.mark.parametrize("number", range(5))
def test_sprites_hold_no_other_thing(number: int) -> None:
    sprite, there = lie_where_they_were(number)
    labels = DISCS.labels[there]
    other = (labels > 0) & (labels != number + 1)
    assert not sprite.halo[other].any()
    assert not sprite.cover[other].any()
    own = labels == number + 1
    assert (sprite.cover[own & ~ndimage.binary_dilation(other)] == 1).all()
    np.testing.assert_array_equal(sprite.pixels, PICTURE[there])


def test_things_that_touch_are_cut_where_they_touch() -> None:
    """Half of what is beneath shows through their last pixels."""
    labels = np.where((ROW > 20) & (ROW < 50) & (COLUMN > 20) & (COLUMN < 80), 1 + (COLUMN >= 50), 0)
    pair = describe_particles(labels, [0, 0])
    sprite = SpriteSheet(PICTURE, PICTURE, pair)[0]
    across = sprite.cover[int(sprite.y)]
    last = np.nonzero(across)[0][-1]
    assert sprite.x + 14.5 == last + 1  # the particle's own last column
    np.testing.assert_array_equal(across[last - 3 : last + 2], [1, 1, 1, 0.5, 0])


@pytest.mark.parametrize("number", range(5))
def test_halos_are_whole_where_nothing_else_is_as_near_and_end_before_it(number: int) -> None:
    sprite, there = lie_where_they_were(number)
    own = ndimage.distance_transform_edt(DISCS.labels != number + 1)[there]
    others = ndimage.distance_transform_edt((DISCS.labels == 0) | (DISCS.labels == number + 1))[there]
    np.testing.assert_allclose(sprite.away, own, atol=1e-5)
    border = np.minimum(np.minimum(ROW, 89 - ROW), np.minimum(COLUMN, 119 - COLUMN))[there]
    near = (own < others) & (own <= 2.5) & (border > 3)
    assert near.sum() > 50
    np.testing.assert_allclose(sprite.halo[near], 1, atol=1e-5)
    assert not sprite.halo[(own > 0) & (own >= 2 * others)].any()


def test_halos_fade_to_nothing_at_their_ends() -> None:
    sprite = SHEET[3]
    for edge in (sprite.halo[0], sprite.halo[-1], sprite.halo[:, 0], sprite.halo[:, -1]):
        assert edge.max() < 0.02


@pytest.mark.parametrize(("angle", "scale"), [(0.3, 1.0), (-2.0, 1.7), (1.0, 2.5)])
def test_transformed_pieces_are_sampled_linearly(angle: float, scale: float) -> None:
    """Against scipy's interpolation, point by point."""
    planes = np.random.default_rng(1).random((9, 14, 3)).astype(np.float32)
    turned = transform_cut(Cut(planes, 6.0, 4.5), angle, scale)
    row, column = np.indices(turned.planes.shape[:2]) + 0.5
    along, down = column - turned.x, row - turned.y
    right = (np.cos(angle) * along + np.sin(angle) * down) / scale + 6.0
    below = (np.cos(angle) * down - np.sin(angle) * along) / scale + 4.5
    for number in range(3):
        padded = np.pad(planes[..., number], 3)
        expected = ndimage.map_coordinates(padded, [below + 2.5, right + 2.5], order=1)
        np.testing.assert_allclose(turned.planes[..., number], expected, atol=2e-5)


def test_transformed_pieces_hold_as_much_as_their_scale_says() -> None:
    planes = np.zeros((30, 40, 1), np.float32)
    planes[10:20, 10:30] = 1
    for angle, scale in itertools.product((0.0, 0.7), (0.3, 0.5, 2.0)):
        turned = transform_cut(Cut(planes, 20.0, 15.0), angle, scale)
        assert turned.planes.sum() == pytest.approx(200 * scale**2, rel=0.03)


def test_distances_of_larger_sprites_are_larger_and_colours_unmixed() -> None:
    """What the picture holds where there is neither cover nor halo is not seen."""
    spoiled = PICTURE.copy()
    spoiled[DISCS.labels == 2] = 100.0
    sprite = transform_sprite(SpriteSheet(spoiled, spoiled, DISCS)[0], 0.4, 2.0)
    seen = (sprite.halo > 0) | (sprite.cover > 0)
    assert sprite.pixels[seen].max() <= 1 + 1e-4
    row, column = np.nonzero(sprite.cover >= 0.999)
    across = np.hypot(row + 0.5 - sprite.y, column + 0.5 - sprite.x)
    assert across.max() == pytest.approx(18, abs=2)
    ring = (sprite.halo > 0.5) & (sprite.away > 1)
    row, column = np.nonzero(ring)
    away = np.hypot(row + 0.5 - sprite.y, column + 0.5 - sprite.x) - 17.5
    np.testing.assert_allclose(sprite.away[ring], away, atol=2.0)


@pytest.mark.parametrize("periodic", [False, True])
def test_places_are_those_of_a_loop(periodic: bool) -> None:
    cut = Cut(np.arange(15.0, dtype=np.float32).reshape(3, 5, 1), 2.5, 1.5)
    for x, y in itertools.product((-9.0, 0.0, 4.0, 6.4, 15.0), (-1.0, 2.6, 8.0)):
        drawn, expected = np.full((8, 7), -1.0), np.full((8, 7), -1.0)
        part, places = find_places(cut, x, y, (7, 8), periodic)
        drawn[places] = cut.planes[part][..., 0]
        for row, column in np.ndindex(3, 5):
            down, right = round(y - 1.5) + row, round(x - 2.5) + column
            if periodic or (0 <= down < 8 and 0 <= right < 7):
                expected[down % 8, right % 7] = cut.planes[row, column, 0]
        np.testing.assert_array_equal(drawn, expected)


def test_what_is_wider_than_a_plane_that_repeats_is_seen_around_its_centre() -> None:
    """No pixel of the plane is named twice."""
    cut = Cut(np.arange(20.0 * 4, dtype=np.float32).reshape(20, 4, 1), 2.0, 14.0)
    part, (row, column) = find_places(cut, 3.0, 2.0, (7, 8), True)
    assert part == (slice(10, 18), slice(0, 4))
    assert sorted(row.ravel()) == list(range(8))
    drawn = np.zeros((8, 7))
    drawn[row, column] = cut.planes[part][..., 0]
    assert drawn[2, 3] == cut.planes[14, 2, 0]
