"""Texton masks: by colours, proposed, painted; and refined."""

from pathlib import Path

import numpy as np
import pytest
from scipy import ndimage

from jaxtex.core.errors import InputError
from jaxtex.io.images import write_image
from jaxtex.io.masks import write_mask
from jaxtex.photo import morphology
from jaxtex.progressive import texton_masks as tm
from jaxtex.progressive.mask_proposal import propose_texton_mask
from jaxtex.progressive.plots import overlay_texton_mask

GROUND, DARK, RED = (0.5, 0.45, 0.3), (0.03, 0.02, 0.02), (0.5, 0.05, 0.04)


def rosettes(seed: int = 0) -> np.ndarray:
    """Labels of 128 x 160 pixels: discs (1) with rims (2)."""
    row, column = np.indices((128, 160))
    rng = np.random.default_rng(seed)
    labels = np.zeros((128, 160), np.uint8)
    for y in range(16, 128, 32):
        for x in range(16, 160, 32):
            away = np.hypot(row - y - rng.uniform(-4, 4), column - x - rng.uniform(-4, 4))
            labels[away < 11] = 2
            labels[away < 7] = 1
    return labels


def coloured(labels: np.ndarray) -> np.ndarray:
    grain = np.random.default_rng(1).uniform(0.85, 1.15, labels.shape)
    return np.array([GROUND, RED, DARK])[labels] * grain[..., None]


def test_each_pixel_is_of_the_type_whose_colour_it_has() -> None:
    labels = rosettes()
    picks = [tm.ColourPick(RED, 15, 1), tm.ColourPick(DARK, 15, 2)]
    assert np.array_equal(tm.pick_texton_mask(coloured(labels), picks, smoothing=0), labels)
    one = tm.pick_texton_mask(coloured(labels), picks[1:], smoothing=0)
    assert np.array_equal(one > 0, labels == 2)


def test_of_two_types_within_reach_the_nearer_counts_by_its_threshold() -> None:
    greys = np.linspace(0.05, 0.8, 60)[None]
    wide, narrow = tm.ColourPick([0.1], 60, 1), tm.ColourPick([0.5], 20, 2)
    mask = tm.pick_texton_mask(greys, [wide, narrow], smoothing=0)[0]
    assert np.array_equal(mask, tm.pick_texton_mask(greys, [narrow, wide], smoothing=0)[0])
    assert mask[0] == 1
    assert mask[np.argmin(np.abs(greys - 0.5))] == 2
    assert (mask == 2).sum() <= (tm.pick_texton_mask(greys, [narrow], smoothing=0) == 2).sum()


def test_smoothing_takes_specks_away() -> None:
    labels = rosettes()
    pixels = coloured(labels)
    specks = np.random.default_rng(2).random(labels.shape) < 0.02
    pixels[specks] = DARK
    picks = [tm.ColourPick(DARK, 25)]
    rough, smooth = (ndimage.label(tm.pick_texton_mask(pixels, picks, smoothing=each))[1] for each in (0.0, 1.5))
    assert smooth < rough / 5


@pytest.mark.parametrize("radius", [1, 2.5])
@pytest.mark.parametrize("tool", ["open", "close", "dilate", "erode"])
def test_morphology_moves_the_border_of_elements_and_keeps_their_types(tool: tm.Operation, radius: float) -> None:
    labels = rosettes()
    shaped = tm.refine_texton_mask(labels, tool, radius)
    assert np.array_equal(shaped > 0, getattr(morphology, f"{tool}_mask")(labels > 0, radius))
    both = (labels > 0) & (shaped > 0)
    assert np.array_equal(shaped[both], labels[both])
    gained = (labels == 0) & (shaped > 0)
    assert (shaped[gained] == 2).all()  # the rims are what is nearest
    assert np.array_equal(tm.refine_texton_mask(np.zeros_like(labels), tool, radius), np.zeros_like(labels))


def test_specks_of_any_value_become_what_surrounds_them() -> None:
    labels = rosettes()
    spoilt = labels.copy()
    rng = np.random.default_rng(3)
    inside = ndimage.distance_transform_edt(labels == 0) > 3
    places = np.argwhere(inside)[rng.permutation(inside.sum())[:30]]
    spoilt[tuple(places.T)] = rng.integers(1, 4, 30)
    spoilt[16:18, 16:18] = 0
    assert np.array_equal(tm.despeckle_texton_mask(spoilt, 12), tm.despeckle_texton_mask(labels, 12))
    for label in range(4):
        regions, count = ndimage.label(tm.despeckle_texton_mask(spoilt, 12) == label)
        assert count == 0 or np.bincount(regions.ravel())[1:].min() >= 12


def test_holes_become_part_of_what_is_around_them() -> None:
    labels = rosettes()
    rims = np.where(labels == 2, 2, 0)
    whole = tm.fill_texton_mask(rims)
    assert np.array_equal(whole > 0, labels > 0)
    assert set(np.unique(whole)) == {0, 2}


@pytest.mark.parametrize("dark", [True, False])
@pytest.mark.parametrize("large", [1, 3])
def test_elements_are_proposed_that_stand_out(dark: bool, large: int) -> None:
    labels = np.kron(rosettes(), np.ones((large, large), np.uint8)) > 0
    colours = np.array([GROUND, DARK] if dark else [DARK, GROUND])[labels.astype(int)]
    grain = np.random.default_rng(1).uniform(0.7, 1.3, labels.shape)
    light = np.linspace(0.7, 1.3, labels.shape[1])  # one side is darker
    mask = propose_texton_mask(colours * (grain * light)[..., None])
    assert (mask[labels] == 1).mean() > 0.85
    assert (mask[~labels] == 0).mean() > 0.95
    assert ndimage.label(mask)[1] == 20


def test_stripes_are_proposed_too() -> None:
    stripes = (np.indices((120, 120))[1] % 20 < 7) & (np.indices((120, 120))[0] % 60 > 8)
    mask = propose_texton_mask(np.where(stripes[..., None], DARK, GROUND))
    assert ((mask == 1) == stripes).mean() > 0.9


@pytest.mark.parametrize("labels", [[0, 1], [0, 1, 2], [0, 1, 2, 3]])
def test_files_give_back_what_was_written(tmp_path: Path, labels: list[int]) -> None:
    mask = np.random.default_rng(0).choice(labels, (9, 12)).astype(np.uint8)
    mask[0, : len(labels)] = labels
    tm.write_texton_mask(tmp_path / "mask.png", mask)
    read = tm.read_texton_mask(tmp_path / "mask.png", (12, 9))
    assert read.dtype == np.uint8
    assert np.array_equal(read, mask)


def test_labels_as_bare_numbers_and_other_greys_are_read_in_order(tmp_path: Path) -> None:
    mask = np.random.default_rng(0).integers(0, 4, (9, 12))
    write_mask(tmp_path / "bare.png", mask / 255)
    assert np.array_equal(tm.read_texton_mask(tmp_path / "bare.png"), mask)
    write_mask(tmp_path / "greys.png", np.array([0.1, 0.2, 0.75, 0.9])[mask])
    assert np.array_equal(tm.read_texton_mask(tmp_path / "greys.png"), mask)


def test_lossy_masks_are_read(tmp_path: Path) -> None:
    mask = np.kron(np.array([[0, 1, 0], [1, 1, 0]]), np.ones((16, 16)))  # edges on the blocks of the file
    write_mask(tmp_path / "mask.jpg", mask)
    assert np.array_equal(tm.read_texton_mask(tmp_path / "mask.jpg"), mask)


def test_what_is_no_mask_is_told(tmp_path: Path) -> None:
    write_mask(tmp_path / "soft.png", np.linspace(0, 1, 64).reshape(8, 8))
    write_mask(tmp_path / "plain.png", np.zeros((8, 8)))
    write_mask(tmp_path / "mask.png", np.eye(8))
    write_image(tmp_path / "colour.png", np.random.default_rng(0).random((8, 8, 3)))
    for name, told in (
        ("soft.png", "holds 64 grey levels, a texton mask up to four"),
        ("plain.png", "holds one value alone"),
        ("colour.png", "is coloured"),
    ):
        with pytest.raises(InputError, match=f"{name}: {told}"):
            tm.read_texton_mask(tmp_path / name)
    with pytest.raises(InputError, match=r"mask.png: texton mask is 8 x 8 pixels, its picture 9 x 8"):
        tm.read_texton_mask(tmp_path / "mask.png", (9, 8))


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: tm.pick_texton_mask(np.zeros((4, 4, 3)), []), "none given"),
        (lambda: tm.pick_texton_mask(np.zeros((4, 4, 3)), [tm.ColourPick([1.0])]), "pick 1: a colour of shape"),
        (lambda: tm.pick_texton_mask(np.zeros((4, 4)), [tm.ColourPick([1.0], 0)]), "tolerance 0 is out of range"),
        (lambda: tm.pick_texton_mask(np.zeros((4, 4)), [tm.ColourPick([1.0], 5, 4)]), "type 4 is out of range"),
        (lambda: tm.pick_texton_mask(np.zeros((4, 4)), [tm.ColourPick([1.0], 5)]), "nothing has these colours"),
        (lambda: tm.refine_texton_mask(np.full((4, 4), 4), "open", 1), "beside the labels 0 to 3"),
        (lambda: tm.refine_texton_mask(np.eye(4), "erode", -1), "radius: -1 is out of range"),
        (lambda: tm.despeckle_texton_mask(np.eye(4), 40), "no region of the mask has 40 pixels"),
        (lambda: tm.despeckle_texton_mask(np.eye(4), -4), "area: -4 is out of range"),
        (lambda: propose_texton_mask(np.full((40, 40), 0.5)), "all of one colour"),
        (lambda: propose_texton_mask(np.zeros((8, 40))), "too small"),
        (lambda: overlay_texton_mask(np.zeros((8, 8)), np.eye(4)), "texton mask is 4 x 4 pixels, its picture 8 x 8"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(call, told: str) -> None:
    with pytest.raises(InputError, match=told) as complaint:
        call()
    assert "\n" not in str(complaint.value)


@pytest.mark.parametrize("channels", [1, 3])
def test_overlays_leave_what_is_no_element_as_it_is(channels: int) -> None:
    labels = rosettes()
    pixels = coloured(labels)[..., :channels].astype(np.float32)
    shown = overlay_texton_mask(pixels, labels)
    assert shown.shape == (*labels.shape, 3)
    assert np.array_equal(shown[labels == 0], np.broadcast_to(pixels, shown.shape)[labels == 0])
    assert np.abs(shown - pixels)[labels > 0].max(axis=-1).min() > 0


def test_an_unknown_operation_is_named_with_those_there_are() -> None:
    with pytest.raises(ValueError, match="'opening' is not known; give open, close, dilate, erode"):
        tm.refine_texton_mask(np.eye(4), "opening", 1)  # type: ignore[arg-type]
