"""How thick the joints are: mortar is measured by its colour, not by the shades that tiles throw on themselves."""

import dataclasses

import numpy as np
import pytest

from jaxtex.fitting.joints import measure_distances, measure_thickness, see_joints
from jaxtex.models.tiling import make_tiling
from jaxtex.photo.evidence import find_evidence

SIZE, WIDTH, HEIGHT = 192, 48.0, 24.0


def lay(angle=0.0, joint=(4.0, 3.0)):
    """The tiling, and every pixel's distance from head and bed joints, by plain arithmetic."""
    tiling = make_tiling(
        tile_width=WIDTH, tile_height=HEIGHT, angle=angle, origin=(5.0, 7.0), offset=0.5, mortar_x=joint[0],
        mortar_y=joint[1], bond="running",
    )  # fmt: skip
    y, x = np.mgrid[0:SIZE, 0:SIZE] + 0.5 - np.array([7.0, 5.0])[:, None, None]
    along, across = np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x
    place = along / WIDTH - 0.5 * np.floor(across / HEIGHT)
    head = np.abs(place - np.round(place)) * WIDTH
    bed = np.abs(across / HEIGHT - np.round(across / HEIGHT)) * HEIGHT
    return tiling, head, bed


def paint(head, bed, joint, seed=0):
    """Red bricks, darker towards their borders, in light grey mortar, with grain."""
    rng = np.random.default_rng(seed)
    edge = np.minimum(head - joint[0] / 2, bed - joint[1] / 2)
    shade = 1 - 0.5 * np.exp(-np.maximum(edge, 0) / 2.5)
    brick = np.array([0.30, 0.11, 0.07]) * shade[..., None]
    picture = np.where((edge > 0)[..., None], brick, [0.45, 0.43, 0.40])
    return np.clip(picture * rng.normal(1, 0.05, (*edge.shape, 1)), 0, 1).astype(np.float32)


@pytest.mark.parametrize("angle", [0.0, 0.3])
def test_distances_are_those_of_plain_arithmetic(angle):
    tiling, head, bed = lay(angle)
    distances = measure_distances(tiling, (SIZE, SIZE))
    np.testing.assert_allclose(distances.head, head, atol=1e-3)
    np.testing.assert_allclose(distances.bed, bed, atol=1e-3)


@pytest.mark.parametrize("joint", [(3.0, 3.0), (6.0, 4.0)])
def test_mortar_is_measured_where_the_fit_was_misled(joint):
    tiling, head, bed = lay(0.2, joint)
    evidence = find_evidence(paint(head, bed, joint))
    fat = dataclasses.replace(tiling, mortar_x=tiling.mortar_x * 1.8, mortar_y=tiling.mortar_y * 1.8)
    distances = measure_distances(fat, (SIZE, SIZE))
    assert measure_thickness(fat, distances, evidence) == pytest.approx(joint, abs=0.6)


def test_the_mask_learnt_again_shows_them_so():
    joint = (4.0, 4.0)
    tiling, head, bed = lay(0.0, joint)
    evidence = find_evidence(paint(head, bed, joint))
    distances = measure_distances(tiling, (SIZE, SIZE))
    seen = see_joints(distances, joint, evidence) > 0.5
    truly = (head < joint[0] / 2) | (bed < joint[1] / 2)
    assert np.mean(seen == truly) > 0.93


def test_tiles_that_meet_have_no_mortar():
    tiling, *_ = lay(0.0, (5.0, 5.0))
    y, x = np.mgrid[0:SIZE, 0:SIZE] + 0.5
    course = np.floor((y - 7.0) / HEIGHT)
    tile = np.floor((x - 5.0) / WIDTH - 0.5 * course)
    tone = np.where((tile + course // 2) % 2 == 0, 0.2, 0.7)
    grain = np.random.default_rng(0).normal(0, 0.02, (SIZE, SIZE))
    evidence = find_evidence(np.clip(tone + grain, 0, 1)[..., None].astype(np.float32))
    assert measure_thickness(tiling, measure_distances(tiling, (SIZE, SIZE)), evidence) == (0.0, 0.0)
