"""Masks by edges: where edges are, which ones count, and that no direction is favoured."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from scipy import ndimage
from skimage import data

from jaxtex.core.errors import InputError
from jaxtex.photo.edges import pyramid_edges, sobel_edges
from jaxtex.photo.pictures import lightness

DETECTORS = [sobel_edges, pyramid_edges]
every_detector = pytest.mark.parametrize("detect", DETECTORS, ids=lambda detect: detect.__name__)
Detector = Callable[..., np.ndarray]


def grid(*, joint: float = 0.12, noise: float = 0.0, slant: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Joints 8 pixels wide every 32, and the distance of each pixel's centre to the nearest edge of one."""
    rows, columns = np.indices((128, 128)) + 0.5
    rows = rows + slant * columns
    across, down = (np.abs((axis - 16) % 32 - 16) for axis in (columns, rows))
    truth = (across > 4) & (down > 4)
    inside = ndimage.distance_transform_edt(truth)
    outside = ndimage.distance_transform_edt(~truth)
    picture = np.where(truth, 0.5, joint) * (1 + noise * np.random.default_rng(0).normal(size=truth.shape))
    return np.clip(picture, 0, None), np.maximum(inside, outside) - 0.5


@every_detector
@pytest.mark.parametrize("slant", [0.0, 0.3])
def test_every_edge_is_found_where_it_is(detect: Detector, slant: float) -> None:
    picture, distance = grid(slant=slant)
    edges = ~detect(picture)
    assert distance[edges].max() <= (2 if detect is pyramid_edges else 2.6)
    near = ndimage.distance_transform_edt(~edges)
    straight = distance < 1
    # The corners of the joints are round to any detector; all else must be covered.
    assert np.mean(near[straight] <= 1.5) > 0.95


def test_the_pyramid_passes_over_grain_that_sobel_stops_at() -> None:
    picture, distance = grid(joint=0.3, noise=0.3)
    tiles = distance > 6
    false_sobel, false_pyramid = (np.mean(~detect(picture)[tiles]) for detect in DETECTORS)
    assert false_pyramid < 0.02
    assert false_pyramid < false_sobel / 4
    near = ndimage.distance_transform_edt(pyramid_edges(picture))
    assert np.mean(near[distance < 1] <= 1.5) > 0.9


def test_more_levels_pass_over_finer_things() -> None:
    stripes = np.tile(np.arange(128) // 2 % 2 * 0.3 + 0.1, (64, 1))
    stripes[:, 64:] += 0.3
    assert (~pyramid_edges(stripes, levels=0)).any(axis=0).sum() > 40
    coarse = np.flatnonzero((~pyramid_edges(stripes, levels=3)).any(axis=0))
    assert coarse.size > 0
    assert np.abs(coarse - 63.5).max() <= 4


@every_detector
def test_tiles_of_equal_lightness_have_edges_too(detect: Detector) -> None:
    red, green = np.array([0.42, 0.15, 0.10]), np.array([0.15, 0.22, 0.17])
    assert np.ptp(lightness(np.stack([red, green])[None])) < 1
    rows, columns = np.indices((64, 64)) // 32
    edges = ~detect(np.where(((rows + columns) % 2 == 0)[..., None], red, green))
    assert edges[10, 30:34].any()
    assert edges[30:34, 50].any()
    assert not edges[:26, :26].any()


@every_detector
def test_no_direction_is_favoured(detect: Detector) -> None:
    photo = (data.brick()[200:328, 100:228] / 255.0) ** 2.2
    edges = detect(photo)
    assert 0.02 < np.mean(~edges) < 0.5
    turned = [detect(photo.T).T, detect(photo[::-1])[::-1], detect(photo[:, ::-1])[:, ::-1]]
    assert max(np.mean(edges != other) for other in turned) < 1e-3


@every_detector
def test_less_strength_never_gives_fewer_edges(detect: Detector) -> None:
    photo = (data.gravel()[:96, :96] / 255.0) ** 2.2
    masks = [detect(photo, strength=strength) for strength in (0.5, 2.0, 8.0, 1000.0)]
    for more, fewer in pairwise(masks):
        assert (fewer | ~more).all()
    assert masks[-1].all()
    assert not masks[0].all()


def test_blunt_edges_are_followed_to_full_size() -> None:
    blunt = ndimage.gaussian_filter1d(np.tile([0.05] * 32 + [0.4] * 32, (32, 1)), 6)
    steepest = np.argmax(np.gradient(lightness(blunt)[0]))
    assert sobel_edges(blunt, strength=10).all()
    edges = ~pyramid_edges(blunt, levels=2, strength=20)
    assert edges.any(axis=1).all()
    assert np.abs(np.flatnonzero(edges.any(axis=0)) - steepest).max() <= 1


def test_crests_are_thin() -> None:
    picture, _ = grid()
    assert np.mean(~pyramid_edges(picture)) < 0.6 * np.mean(~sobel_edges(picture))


@pytest.mark.parametrize("shape", [(33, 47), (32, 65), (8, 9)])
def test_odd_sizes_keep_their_shape(shape: tuple[int, int]) -> None:
    picture = np.random.default_rng(0).random(shape)
    assert sobel_edges(picture).shape == shape
    assert pyramid_edges(picture, levels=2 if min(shape) >= 32 else 0).shape == shape


@every_detector
def test_a_picture_of_one_colour_is_refused(detect: Detector) -> None:
    with pytest.raises(InputError, match="one single colour"):
        detect(np.full((64, 64, 3), 0.3))


@every_detector
@pytest.mark.parametrize("strength", [0, -1, float("nan")])
def test_strengths_out_of_range_are_refused(detect: Detector, strength: float) -> None:
    with pytest.raises(InputError, match=r"strength: .* out of range"):
        detect(np.eye(64), strength=strength)


@pytest.mark.parametrize("levels", [-1, 4])
def test_levels_out_of_range_are_refused(levels: int) -> None:
    with pytest.raises(InputError, match=f"levels: {levels} is out of range; a picture of this size has 0 to 3"):
        pyramid_edges(np.eye(64), levels=levels)


def test_negative_smoothing_is_refused() -> None:
    with pytest.raises(InputError, match="smooth: -1"):
        sobel_edges(np.eye(64), smooth=-1)
