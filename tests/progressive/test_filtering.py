import jax
import numpy as np
import pytest
from scipy import ndimage

from jaxtex.core.errors import InputError
from jaxtex.progressive.filtering import filter_mask, filter_mask_steps
from jaxtex.progressive.warping import grow_mask
from jaxtex.synthesis.anisometric import sample_sources

KEY = jax.random.key(0)


def blobs(seed: int, shape: tuple[int, int] = (64, 64)) -> tuple[np.ndarray, np.ndarray]:
    """Dark and light regions with grain, and the mask of the light ones."""
    rng = np.random.default_rng(seed)
    mask = ndimage.gaussian_filter(rng.normal(size=shape), 4, mode="wrap") > 0
    colours = np.where(mask[..., None], [0.8, 0.7, 0.4], [0.2, 0.3, 0.4])
    return (colours + 0.05 * rng.normal(size=colours.shape)).clip(0, 1), mask.astype(np.uint8)


def test_an_exemplar_comes_out_of_its_own_mask() -> None:
    exemplar, mask = blobs(0)
    sources = filter_mask(exemplar, mask, mask, key=KEY)
    same = np.moveaxis(np.indices(mask.shape), 0, -1)
    assert np.mean(np.abs(sources - same).max(axis=2) < 0.5) > 0.6
    at = np.rint(sources).astype(int)
    assert np.mean(mask[at[..., 0], at[..., 1]] == mask) > 0.98


def test_colours_go_with_another_mask() -> None:
    exemplar, mask = blobs(0)
    _, wanted = blobs(1, (48, 80))
    sources = filter_mask(exemplar, mask, wanted, key=KEY)
    shown = sample_sources(exemplar, sources)
    assert shown.shape == (48, 80, 3)
    assert np.mean((shown[..., 0] > 0.5) == wanted) > 0.95
    along = np.abs(np.diff(sources, axis=1) - [0, 1]).max(axis=2) < 0.5
    assert along.mean() > 0.4  # of pieces, not of single pixels


def test_three_types_each_get_their_colour() -> None:
    exemplar, mask = blobs(2)
    core = mask + (ndimage.distance_transform_edt(mask) > 3)
    exemplar = np.where((core == 2)[..., None], [0.9, 0.1, 0.1], exemplar)
    wanted = grow_mask(core, 1.5, types=(2,))
    shown = sample_sources(exemplar, filter_mask(exemplar, core, wanted, key=KEY))
    red = (shown[..., 0] - shown[..., 1]) > 0.5
    assert np.mean(red == (wanted == 2)) > 0.94


def test_more_weight_brings_borders_nearer() -> None:
    exemplar, mask = blobs(3)
    _, wanted = blobs(4)
    missed = []
    for weight in (0.3, 3.0):
        at = np.rint(filter_mask(exemplar, mask, wanted, key=KEY, mask_weight=weight)).astype(int)
        missed.append(np.mean(mask[at[..., 0], at[..., 1]] != wanted))
    assert missed[1] < 0.5 * missed[0]


def test_steps_count_up_to_their_total() -> None:
    exemplar, mask = blobs(0, (40, 40))
    steps = list(filter_mask_steps(exemplar, mask, mask, key=KEY))
    assert [each.done for each in steps] == list(range(len(steps)))
    assert {each.total for each in steps} == {len(steps) - 1}
    assert {each.sources.shape for each in steps} == {(40, 40, 2)}


def test_masks_that_do_not_go_together_are_refused() -> None:
    exemplar, mask = blobs(0, (32, 32))
    with pytest.raises(InputError, match="30 x 32"):
        filter_mask(exemplar, mask[:, :30], mask, key=KEY)
    with pytest.raises(InputError, match="type 2"):
        filter_mask(exemplar, mask, mask * 2, key=KEY)
    with pytest.raises(InputError, match="one value"):
        filter_mask(exemplar, mask * 0, mask * 0, key=KEY)
    with pytest.raises(ValueError, match="exemplar"):
        filter_mask(exemplar[:5], mask[:5], mask, key=KEY)


def test_a_type_may_be_wanted_nowhere() -> None:
    exemplar, mask = blobs(0, (40, 40))
    shown = sample_sources(exemplar, filter_mask(exemplar, mask, np.zeros((30, 30)), key=KEY))
    assert shown[..., 0].mean() < 0.25
