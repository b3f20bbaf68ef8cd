"""Evidence, course families, scanlines, seamless pictures."""

import numpy as np
import pytest

from jaxtex.photo.automask import auto_mask, read_tiling
from jaxtex.photo.courses import all_views, find_courses
from jaxtex.photo.evidence import find_evidence, find_ridges, mask_evidence, shrink
from jaxtex.photo.lattice import Lattice, joint_distances
from jaxtex.photo.seamless import find_wrap


def brick_mask(height=128, width=160, pitch=(32.0, 16.0), angle=0.0):
    y, x = np.mgrid[0:height, 0:width] + 0.5
    along, across = np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x
    course = np.floor(across / pitch[1])
    place = along / pitch[0] - 0.5 * course
    head = np.abs(place - np.round(place)) * pitch[0] < 2
    bed = np.abs(across / pitch[1] - np.round(across / pitch[1])) * pitch[1] < 2
    return (~(head | bed)).astype(np.float32)


@pytest.mark.parametrize("angle", [0.0, 0.25, -0.6])
def test_the_spectrum_finds_the_courses(angle):
    evidence = mask_evidence(brick_mask(angle=angle))
    found = find_courses(evidence.joints, views=all_views(False), per_map=3)
    turn = [abs((each.angle - angle + np.pi / 2) % np.pi - np.pi / 2) for each in found]
    assert any(t < 0.03 and abs(each.height - 16.0) < 0.5 for t, each in zip(turn, found, strict=True))


def test_reading_a_mask_gives_pitches_and_bond():
    best = read_tiling(mask_evidence(brick_mask()), perspective=False, learn=False).lattices[0]
    assert best.height == pytest.approx(16.0, rel=0.02)
    assert best.width == pytest.approx(32.0, rel=0.02)
    assert abs(best.offset % 1.0 - 0.5) < 0.05


def test_distances_to_joints_agree_with_a_plain_loop():
    lattice = Lattice(
        np.zeros(2), 0.0, 0.0, 10.0, 20.0, np.array([3.0, 4.0]), 0.0, np.array([0.0, 0.25]),
        np.array([[1.0, 1.0], [0.5, 0.5]]), "english", (1.0, 1.0), 0.0,
    )  # fmt: skip
    points = np.random.default_rng(0).uniform(-60, 60, (50, 2))
    head, bed = joint_distances(lattice, points[:, 0], points[:, 1])
    for (x, y), to_head, to_bed in zip(points, head, bed, strict=True):
        course = int(np.floor((y - 4.0) / 10.0))
        length = (20.0, 10.0)[course % 2]
        shift = 3.0 + 20.0 * (0.0, 0.25)[course % 2]
        joints = shift + length * np.arange(-30, 31)
        assert to_head == pytest.approx(np.abs(joints - x).min())
        assert to_bed == pytest.approx(min(y - 4.0 - 10.0 * course, 14.0 + 10.0 * course - y))


def test_ridges_have_the_right_sign():
    channel = np.zeros((40, 40), np.float32)
    channel[:, 20] = -1.0
    dark, light = find_ridges(channel, 2.0)
    assert dark[20, 20] == dark.max() > 0
    assert light[20, 20] == 0


@pytest.mark.parametrize(("tile", "joint"), [(0.2, 0.7), (0.7, 0.2)])
def test_the_automatic_mask_works_for_light_and_dark_joints(tile, joint):
    truth = brick_mask(192, 192, (48.0, 24.0))
    picture = np.where(truth > 0, tile, joint) + np.random.default_rng(1).normal(0, 0.02, truth.shape)
    found = auto_mask(np.clip(picture, 0, 1)[..., None])
    assert found.shape == truth.shape
    assert found.dtype == bool
    assert np.mean(found == (truth > 0)) > 0.9


def test_the_automatic_mask_finds_the_edges_of_a_checker():
    y, x = np.mgrid[0:192, 0:192]
    checker = np.where((x // 32 + y // 32) % 2, 0.8, 0.1) + np.random.default_rng(2).normal(0, 0.01, x.shape)
    found = auto_mask(np.clip(checker, 0, 1)[..., None])
    to_edge = np.minimum(np.abs((x + 0.5) % 32 - 16), np.abs((y + 0.5) % 32 - 16))
    assert found[to_edge < 10].mean() > 0.9
    assert found[16:-16, 16:-16][(to_edge > 15.4)[16:-16, 16:-16]].mean() < 0.3


def test_seams_are_found():
    noise = np.random.default_rng(3).normal(size=(96, 96, 1))
    smooth = np.fft.ifft2(
        np.fft.fft2(noise[..., 0]) * np.exp(-40 * np.hypot(*np.meshgrid(np.fft.fftfreq(96), np.fft.fftfreq(96))))
    ).real
    assert find_wrap(smooth[..., None]) == (True, True)
    assert find_wrap(smooth[:70, :, None]) == (True, False)
    assert find_wrap(smooth[:, 20:80, None]) == (False, True)
    assert find_wrap(np.ones((64, 64, 1))) == (False, False)


def test_shrinking_keeps_small_pictures_and_bounds_large_ones():
    picture = np.random.default_rng(4).uniform(size=(50, 100, 3))
    np.testing.assert_allclose(shrink(picture, 100), picture, rtol=1e-6)
    assert shrink(picture, 40).shape == (20, 40, 3)


def test_evidence_of_a_grey_picture_has_no_colour_maps():
    evidence = find_evidence(np.random.default_rng(5).uniform(size=(64, 64, 1)))
    assert set(evidence.joints) == {"dark lightness", "light lightness", "edges"}
    assert all(np.isfinite(each).all() for each in evidence.joints.values())
