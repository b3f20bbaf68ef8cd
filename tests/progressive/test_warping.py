import itertools

import numpy as np
import pytest
from scipy import ndimage

from jaxtex.core.errors import InputError
from jaxtex.progressive.warping import displace_elements, grow_mask, signed_distance, spread_mesh, warp_mask


def disks(rows: int = 60, columns: int = 90, apart: int = 30, radius: float = 9.0) -> np.ndarray:
    away = np.indices((rows, columns)) % apart - apart / 2
    return (np.hypot(*away) < radius).astype(np.uint8)


def rings() -> np.ndarray:
    """Type 1 within type 2 within 0."""
    return disks(radius=11) * 2 - disks(radius=6)


@pytest.mark.parametrize("direction", ["all", "horizontal", "vertical"])
@pytest.mark.parametrize("types", [(1,), (0, 1), (2,)])
def test_nothing_grows_by_nothing(direction: str, types: tuple[int, ...]) -> None:
    rng = np.random.default_rng(0)
    speckled = rng.integers(0, 3, (20, 30))
    for mask in (rings(), speckled):
        np.testing.assert_array_equal(grow_mask(mask, 0.0, types=types, direction=direction), mask)


@pytest.mark.parametrize("direction", ["all", "horizontal", "vertical"])
def test_what_grows_more_covers_what_grows_less(direction: str) -> None:
    mask = ndimage.gaussian_filter(np.random.default_rng(1).normal(size=(50, 70)), 3) > 0
    covered = [grow_mask(mask, amount, direction=direction) > 0 for amount in np.linspace(-6, 6, 49)]
    for less, more in itertools.pairwise(covered):
        assert not (less & ~more).any()
    areas = np.array([each.mean() for each in covered])
    assert areas[-1] > areas[24] > areas[0]
    assert len(np.unique(areas[:25])) > 6


def test_disks_grow_by_pixels_between_whole_ones_too() -> None:
    mask = disks(30, 30)
    for amount in (-4.5, -2.25, -0.5, 0.5, 1.75, 3.0):
        radius = np.sqrt(grow_mask(mask, amount).sum() / np.pi)
        assert radius == pytest.approx(np.sqrt(mask.sum() / np.pi) + amount, abs=0.5)


def test_extent_follows_the_place() -> None:
    mask = np.zeros((20, 200), np.uint8)
    mask[8:12] = 1
    amounts = np.broadcast_to(np.linspace(0, 5, 200), mask.shape)
    breadth = grow_mask(mask, amounts).sum(axis=0)
    assert (np.diff(breadth) >= 0).all()
    np.testing.assert_allclose(breadth, 4 + 2 * amounts[0], atol=1.6)


def test_along_rows_alone_heights_stay() -> None:
    mask = disks()
    for amount in (-3.0, 4.0):
        grown = grow_mask(mask, amount, direction="horizontal")
        np.testing.assert_array_equal(grown.T, grow_mask(mask.T, amount, direction="vertical"))
        before, after = mask.any(axis=1), grown.any(axis=1)
        if amount > 0:
            np.testing.assert_array_equal(before, after)
        widest = mask[15] > 0
        assert grown[15].sum() == widest.sum() + 2 * amount * ndimage.label(widest)[1]


def test_borders_within_a_group_stay_and_losses_go_to_neighbours() -> None:
    mask = rings()
    shrunk = grow_mask(mask, -2.0, types=(0, 1))
    assert set(np.unique(shrunk)) == {0, 1, 2}
    assert ((shrunk == mask) | (shrunk == 2)).all()
    assert (shrunk == 2).sum() > (mask == 2).sum()
    outwards = grow_mask(mask, 2.0, types=(1, 2))
    assert ((outwards == 1) == (mask == 1)).all()
    assert (outwards[mask == 0].max(), (outwards == 2).sum() > (mask == 2).sum()) == (2, True)


@pytest.mark.parametrize("turns", range(4))
@pytest.mark.parametrize("amount", [-8.0, -5.0])
def test_what_the_picture_cuts_leaves_no_tail(turns: int, amount: float) -> None:
    away = np.hypot(*(np.indices((60, 60)) - 29.8))
    for cut in (8, 10, 12):
        disk, shrunk = (np.rot90((away < 14.3 + by)[:, : 31 + cut], turns) for by in (0.0, amount))
        made = np.rot90(grow_mask(disk, amount), -turns) > 0
        true = np.rot90(shrunk, -turns)
        assert made[:, -1].sum() <= true[:, -1].sum() + 2
        assert np.sum(made != true) < 0.2 * true.sum()


@pytest.mark.parametrize("turns", range(4))
def test_what_the_picture_cuts_at_a_corner_leaves_no_tail(turns: int) -> None:
    away = np.hypot(*(np.indices((60, 60)) - 29.8))
    for rows, columns, amount in ((39, 39, -8.0), (38, 42, -8.0), (41, 41, -8.0), (39, 39, -5.0), (36, 36, -8.0)):
        disk, true = (np.rot90((away < 14.3 + by)[:rows, :columns], turns) for by in (0.0, amount))
        made = grow_mask(disk, amount) > 0
        border = np.pad(np.zeros((rows - 2, columns - 2), bool), 1, constant_values=True)
        border = np.rot90(border, turns)
        assert made[border].sum() <= true[border].sum() + 2
        assert np.sum(made != true) < 0.12 * true.sum()


def test_what_goes_on_beyond_the_picture_shrinks_at_its_border_as_elsewhere() -> None:
    stripes = np.broadcast_to(np.arange(80) % 20 < 10, (50, 80))
    for mask in (stripes, stripes.T):
        grown = grow_mask(mask, -2.0)
        middle = grown[25:26] if mask is stripes else grown[:, 25:26]
        np.testing.assert_array_equal(grown, np.broadcast_to(middle, grown.shape))
    thin = np.hypot(*(np.indices((60, 30)) - np.array([30, 40])[:, None, None])) < 14.3
    assert grow_mask(thin, 5.0)[:, -1].sum() == pytest.approx(2 * np.sqrt(19.3**2 - 11**2), abs=4)


def test_what_vanishes_leaves_no_specks() -> None:
    mask = disks()
    for amount in np.linspace(-9, -7, 9):
        areas = np.bincount(ndimage.label(grow_mask(mask, amount))[0].ravel())[1:]
        assert not (areas < 6).any()
    assert not grow_mask(mask, -10).any()
    lone = np.zeros((9, 9), np.uint8)
    lone[4, 4] = 1
    assert grow_mask(lone, 0.0).sum() == 1  # nothing is left of what was larger


def test_distances_are_those_to_a_line() -> None:
    row, column = np.indices((40, 40))
    along = (row + column - 39.5) / np.sqrt(2)
    inner = np.s_[8:-8, 8:-8]
    np.testing.assert_allclose(signed_distance(along > 0)[inner], along[inner], atol=0.35)
    np.testing.assert_allclose(signed_distance(along > 0, "vertical")[inner], (row + column - 39.5)[inner])


def test_no_border_is_far_away() -> None:
    everywhere = signed_distance(np.ones((3, 4), bool), "horizontal")
    np.testing.assert_allclose(everywhere, 5.0)
    np.testing.assert_allclose(signed_distance(np.zeros((3, 4), bool)), -5.0)


def test_a_field_and_a_mesh_move_alike() -> None:
    mask = rings()
    np.testing.assert_array_equal(warp_mask(mask, np.zeros((2, 2, 2))), mask)
    shift = warp_mask(mask, np.broadcast_to([3.0, -5.0], (*mask.shape, 2)))
    np.testing.assert_array_equal(shift[:-3, 5:], mask[3:, :-5])
    np.testing.assert_array_equal(shift, warp_mask(mask, np.broadcast_to([3.0, -5.0], (3, 4, 2))))


def test_meshes_are_met_at_their_nodes() -> None:
    nodes = np.random.default_rng(0).normal(size=(4, 5, 2))
    field = spread_mesh(nodes, (31, 41))
    np.testing.assert_allclose(field[::10, ::10], nodes, atol=1e-9)
    steps = np.abs(np.diff(field, axis=1)).max()
    assert steps < 0.5 * np.abs(np.diff(nodes, axis=1)).max()


def test_elements_are_scaled_where_they_stand() -> None:
    mask = disks(apart=30, radius=7)
    scale = np.broadcast_to(np.linspace(0.5, 1.6, 90), mask.shape)
    made = warp_mask(mask, displace_elements(mask, scale=scale))
    labels, count = ndimage.label(mask)
    assert ndimage.label(made)[1] == count
    for number in range(1, count + 1):
        centre = np.rint(ndimage.center_of_mass(mask, labels, number)).astype(int)
        new = ndimage.label(made)[0] == ndimage.label(made)[0][tuple(centre)]
        times = np.sqrt(new.sum() / (labels == number).sum())
        assert times == pytest.approx(scale[tuple(centre)], rel=0.12)
        np.testing.assert_allclose(ndimage.center_of_mass(new), centre, atol=0.7)


def test_elements_turn_clockwise_and_move() -> None:
    mask = np.zeros((61, 61), np.uint8)
    mask[28:33, 18:43] = 1
    turned = warp_mask(mask, displace_elements(mask, turn=np.radians(30), shift=(4, -3)))
    row, column = np.nonzero(turned)
    np.testing.assert_allclose([row.mean(), column.mean()], [34, 27], atol=0.5)
    lean = 0.5 * np.arctan2(2 * np.cov(column, row)[0, 1], column.var() - row.var())
    assert np.degrees(lean) == pytest.approx(30, abs=3)
    assert turned.sum() == pytest.approx(mask.sum(), rel=0.1)


def test_where_no_element_stands_nothing_moves() -> None:
    np.testing.assert_allclose(displace_elements(np.zeros((40, 50)), scale=3.0), 0, atol=1e-9)
    cut = np.zeros((40, 50), np.uint8)
    cut[:8, 20:30] = 1  # at the border, its centre is not known
    np.testing.assert_allclose(displace_elements(cut, scale=3.0), 0, atol=1e-9)


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (lambda mask: grow_mask(mask, np.ones((3, 3))), "amounts of shape"),
        (lambda mask: grow_mask(mask, np.nan), "amounts of shape"),
        (lambda mask: grow_mask(mask, 1.0, types=()), "types"),
        (lambda mask: grow_mask(mask, 1.0, types=(4,)), "types"),
        (lambda mask: warp_mask(mask, np.zeros((5, 5, 3))), "displacement of shape"),
        (lambda mask: warp_mask(mask, np.zeros((1, 5, 2))), "nodes"),
        (lambda mask: warp_mask(mask, np.zeros((500, 5, 2))), "nodes"),
        (lambda mask: displace_elements(mask, scale=0.0), "scale"),
        (lambda mask: displace_elements(mask, turn=np.zeros(3)), "turn of shape"),
        (lambda mask: displace_elements(mask, shift=1.0), "shift of shape"),
    ],
)
def test_wrong_arguments_are_named(wrong, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        wrong(disks())


def test_what_is_no_mask_is_refused() -> None:
    for act in (lambda mask: grow_mask(mask, 1), lambda mask: warp_mask(mask, np.zeros((2, 2, 2))), displace_elements):
        with pytest.raises(InputError, match="texton mask"):
            act(np.full((4, 4), 7))
