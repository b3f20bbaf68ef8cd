"""Scripts of progressively-variant textures: what they grow, mark, and measure."""

from types import ModuleType

import jax
import numpy as np
import pytest
from scipy import ndimage


@pytest.mark.parametrize("script", ["reaction_diffusion"], indirect=True)
def test_coats_have_the_elements_that_their_masks_say(script: ModuleType) -> None:
    key = jax.random.key(3)
    leopard, tiger = script.grow_leopard(key), script.grow_tiger(key)
    for coat, labels in ((leopard, 3), (tiger, 2)):
        assert coat.pixels.shape == (script.SIZE, script.SIZE, 3)
        assert coat.pixels.dtype == np.float32
        assert 0 <= coat.pixels.min() < coat.pixels.max() <= 1
        shares = np.bincount(coat.mask.ravel(), minlength=labels) / coat.mask.size
        assert len(shares) == labels
        assert shares.min() > 0.1
        light = coat.pixels.mean(axis=2)
        dark = coat.mask == labels - 1
        assert light[dark].mean() < 0.3 * light[~dark].mean()
    assert ndimage.label(leopard.mask > 0)[1] > 15  # rosettes that lie apart
    # What is inside is nearer to rims than what is between.
    to_rim = ndimage.distance_transform_edt(leopard.mask != 2)
    assert to_rim[leopard.mask == 1].mean() < to_rim[leopard.mask == 0].mean()
    down, across = (np.mean(np.diff(tiger.mask.astype(int), axis=axis) != 0) for axis in (0, 1))
    assert down < 0.5 * across
    assert not np.array_equal(tiger.mask, script.grow_tiger(jax.random.key(4)).mask)


@pytest.mark.parametrize("script", ["reaction_diffusion"], indirect=True)
def test_coats_repeat_at_their_borders(script: ModuleType) -> None:
    for coat in (script.grow_leopard(jax.random.key(0)), script.grow_tiger(jax.random.key(0))):
        for axis in (0, 1):
            steps = np.abs(np.diff(coat.pixels, axis=axis, append=coat.pixels.take([0], axis))).mean(axis=2)
            seam = steps.take(-1, axis).mean()
            assert seam < 1.5 * steps.mean()


@pytest.mark.parametrize("script", ["progressive_blending"], indirect=True)
def test_strips_tell_how_many_elements_there_are_and_how_round(script: ModuleType) -> None:
    row, column = np.indices((80, 320)) % 20 - 10
    many = np.hypot(row, column) < 6
    mask = np.where(np.arange(320) < 160, np.abs(row) < 3, many).astype(np.uint8)
    area, elements, roundness = script.measure_strips(mask)
    np.testing.assert_allclose(area[[0, -1]], [5 / 20, many.mean()], atol=1e-9)
    np.testing.assert_allclose(elements[[0, -1]], [1e4 * 4 / (80 * 40), 1e4 * 8 / (80 * 40)])
    assert roundness[-1] == pytest.approx(1, abs=0.2)
    assert roundness[0] > 2


@pytest.mark.parametrize("script", ["progressive_blending"], indirect=True)
def test_going_back_is_told_as_a_share_of_the_way(script: ModuleType) -> None:
    assert script.turning_back(np.array([0.0, 0.1, 0.4, 1.0])) == 0
    assert script.turning_back(np.array([3.0, 2.0, 2.5, 1.0])) == pytest.approx(0.25)
    assert script.turning_back(np.array([0.0, 1.5, 1.0])) == pytest.approx(0.5)
    assert script.going_beyond(np.array([2.0, 3.0, 1.0])) == pytest.approx(0.5)
    assert script.going_beyond(np.array([1.0, 0.8, 1.0])) == pytest.approx(0.25)
    assert script.going_beyond(np.array([1.0, 1.2, 2.0])) == 0


@pytest.mark.parametrize("script", ["progressive_blending"], indirect=True)
def test_a_mixture_has_each_texture_where_it_is_alone(script: ModuleType) -> None:
    rng = np.random.default_rng(0)
    exemplars = [level + 0.1 * rng.random((64, 64, 3)) for level in (0.1, 0.8)]
    far = np.broadcast_to(np.linspace(0, 1, 64), (48, 64))
    made = script.mix_textures(exemplars, np.stack([1 - far, far]))
    level = made.mean(axis=(0, 2))
    np.testing.assert_allclose(level, 0.15 + 0.7 * far[0], atol=0.05)


@pytest.mark.parametrize("script", ["progressive_blending"], indirect=True)
def test_labels_blended_change_where_weights_are_equal(script: ModuleType) -> None:
    masks = [np.zeros((40, 80), np.uint8), np.ones((40, 80), np.uint8)]
    far = np.broadcast_to(np.linspace(0, 1, 80), (40, 80))
    blended, blurred, mask = script.blend_labels(masks, np.stack([1 - far, far]))
    np.testing.assert_allclose(blended, far)
    assert np.abs(blurred - far).max() < 0.05
    np.testing.assert_array_equal(mask, far > 0.5)


@pytest.mark.parametrize("script", ["progressive_blending"], indirect=True)
def test_edges_that_lie_apart_are_left_at_half_their_strength(script: ModuleType) -> None:
    one, other = np.zeros((2, 40, 120, 1))
    one[:, 60:], other[10:] = 1, 1.7
    halves, middle = np.full((2, 40, 120), 0.5), slice(20, 100)
    assert script.kept_edges(np.stack([one, one]), halves, middle) == pytest.approx(1)
    assert script.kept_edges(np.stack([one, other]), halves, middle) == pytest.approx(0.5, abs=0.03)
    assert script.kept_edges(np.stack([one, 1 - one]), halves, middle) == pytest.approx(0, abs=1e-9)


def spots_on_a_slope(size: float = 9.0) -> tuple[np.ndarray, np.ndarray]:
    """Spots, lighter than what is around but not than the ground elsewhere; linear light, and where they are."""
    row, column = np.indices((128, 128))
    spots = np.hypot(row % 32 - 16, column % 32 - 16) < size
    noise = 0.01 * np.random.default_rng(0).normal(size=spots.shape)
    return np.clip(0.1 + 0.5 * row / 128 + 0.15 * spots + noise, 0, 1)[..., None], spots


@pytest.mark.parametrize("script", ["element_shapes"], indirect=True)
def test_elements_are_told_on_uneven_ground(script: ModuleType) -> None:
    picture, spots = spots_on_a_slope()
    classes = script.learn_classes(picture, spots)
    found = script.find_elements(picture, classes)
    assert classes.view[1]
    assert (found.mask == spots).mean() > 0.97
    assert len(found.areas) == 16
    assert script.measure_apart(script.join_elements([found, found]), found) == (0, 0)


@pytest.mark.parametrize("script", ["element_shapes"], indirect=True)
def test_elements_that_are_larger_are_as_far_apart_as_that(script: ModuleType) -> None:
    picture, spots = spots_on_a_slope()
    classes = script.learn_classes(picture, spots)
    own, larger = (script.find_elements(spots_on_a_slope(size)[0], classes) for size in (9.0, 12.0))
    areas, shapes = script.measure_apart(larger, own)
    assert areas == pytest.approx(2 * np.log2(12 / 9), abs=0.2)
    assert shapes < 0.1


@pytest.mark.parametrize("script", ["element_shapes"], indirect=True)
def test_elements_that_are_copied_in_one_piece_are_whole(script: ModuleType) -> None:
    """The same moved by 8 pixels; and one in which every second row of spots is of two halves of others."""
    mask = spots_on_a_slope()[1]
    there = np.moveaxis(np.indices(mask.shape), 0, 2)
    broken = there.copy()
    parted = (there[..., 0] // 32 % 2 == 0) & (there[..., 1] % 32 < 16)
    broken[parted] = (broken[parted] + np.array([32, 0])) % 128
    assert script.share_whole(mask, (there + 8) % 128) == 1
    assert script.share_whole(mask, broken) == 0.5


@pytest.mark.parametrize("script", ["progressive_masks"], indirect=True)
def test_what_is_lit_is_marked_without_bridges_and_holes(script: ModuleType) -> None:
    row, column = np.indices((80, 80)) % 40 - 20
    things = np.hypot(row, column) < 14
    seen = things & ~((np.abs(row) < 2) & (np.abs(column) < 2)) | (row == 0)  # a hole in each, a thread between them
    mask = script.mask_lit(seen[..., None].repeat(3, axis=2) * 0.8, 40, 3)
    assert (mask != things).mean() < 0.03
    assert ndimage.label(mask)[1] == 4


@pytest.mark.parametrize("script", ["progressive_masks"], indirect=True)
def test_ellipses_are_painted_where_they_are_told(script: ModuleType) -> None:
    mask = script.paint((((100, 60, 20, 10), (200, 200, 5, 5)), ((110, 60, 5, 5),)))
    assert (mask == 2).sum() == pytest.approx(25 * np.pi, rel=0.05)
    assert (mask == 1).sum() == pytest.approx((200 + 25 - 25) * np.pi, rel=0.05)
    assert (mask[60, [79, 81, 104, 106, 119, 121]] == [0, 1, 1, 2, 1, 0]).all()
    assert (mask[[49, 51, 69, 71], 100] == [0, 1, 1, 0]).all()
