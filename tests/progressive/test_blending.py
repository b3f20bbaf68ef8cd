import jax
import numpy as np
import pytest
from scipy import ndimage

from jaxtex.core.errors import InputError
from jaxtex.progressive.blending import blend_masks, blend_textures, lay_out_mask, transition_weights
from jaxtex.progressive.compactness import measure_raggedness
from jaxtex.synthesis.anisometric import sample_sources

KEY = jax.random.key(0)


def grain(seed: int, size: float, level: float, shape: tuple[int, int] = (64, 64)) -> np.ndarray:
    """A mask of random blobs: how large, and the level that they are cut at; larger is fewer."""
    noise = ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=shape), size, mode="wrap")
    return (noise > level * noise.std()).astype(np.uint8)


def alone(which: int, count: int, shape: tuple[int, int]) -> np.ndarray:
    return np.broadcast_to(np.eye(count)[which][:, None, None], (count, *shape))


@pytest.mark.parametrize("which", [0, 1, 2])
def test_a_texture_alone_has_its_own_mask(which: int) -> None:
    masks = [grain(0, 3, 1.0), grain(1, 2, 0.0), grain(2, 4, 0.5)]
    made = blend_masks(masks, alone(which, 3, (64, 64)))
    np.testing.assert_array_equal(made, masks[which])


def test_elements_cover_the_weighted_mean() -> None:
    masks = [grain(0, 3, 1.2, (160, 160)), grain(1, 3, -0.4, (160, 160))]
    ends = [each.mean() for each in masks]
    covered = []
    for share in np.linspace(0, 1, 6):
        made = blend_masks(masks, np.broadcast_to([[[1 - share]], [[share]]], (2, 160, 160)))
        covered.append(made.mean())
        assert made.mean() == pytest.approx((1 - share) * ends[0] + share * ends[1], abs=0.04)
    assert (np.diff(covered) > 0).all()


def test_shapes_change_all_the_way() -> None:
    """Labels that are blended and thresholded would be the first mask's up to the middle, and then the other's."""
    masks = [grain(0, 3, 0.8), grain(1, 3, 0.8)]
    apart = []
    for share in np.linspace(0, 1, 9):
        made = blend_masks(masks, np.broadcast_to([[[1 - share]], [[share]]], (2, 64, 64)))
        apart.append(np.mean(made != masks[0]))
    assert (np.diff(apart) > 0).all()
    assert np.diff(apart).max() < 0.5 * apart[-1]


def test_elements_are_no_more_ragged_between_textures_than_in_them() -> None:
    """Disks of two sizes: where they meet, those that run together are parted."""
    masks = [
        (np.hypot(*(np.indices((96, 96)) % size - 0.5 * size)) < 0.38 * size).astype(np.uint8) for size in (12, 32)
    ]
    made = blend_masks(masks, np.full((2, 96, 96), 0.5))
    assert np.mean(made != masks[0]) > 0.1
    ragged = measure_raggedness(ndimage.label(made)[0])
    own = max(measure_raggedness(ndimage.label(each)[0]).max() for each in masks)
    assert np.mean(ragged[ragged > 0]) < 1.2 * own


def test_three_labels_stay_three() -> None:
    one = grain(0, 4, 0.0) + grain(0, 4, 1.0)
    other = grain(1, 3, 0.3) + grain(1, 3, 1.2)
    made = blend_masks([one, other], np.full((2, 64, 64), 0.5))
    for label in range(3):
        mean = 0.5 * np.mean(one == label) + 0.5 * np.mean(other == label)
        assert np.mean(made == label) == pytest.approx(mean, abs=0.1)


def test_weights_follow_the_transition() -> None:
    far = np.linspace(0, 1, 41)[None]
    weights = transition_weights(far, 4)
    np.testing.assert_allclose(weights.sum(axis=0), 1, atol=1e-6)
    np.testing.assert_allclose(np.einsum("nrc,n->rc", weights, np.linspace(0, 1, 4)), far, atol=1e-6)
    assert (weights > 0).sum(axis=0).max() == 2
    np.testing.assert_allclose(transition_weights(far), [1 - far, far], atol=1e-6)


def test_a_blend_begins_and_ends_as_its_textures() -> None:
    masks = [grain(0, 3, 1.0), grain(1, 3, -0.2)]
    colours = np.array([[[0.1, 0.1, 0.2], [0.6, 0.2, 0.1]], [[0.2, 0.5, 0.2], [0.9, 0.9, 0.6]]])
    exemplars = [own[mask] for own, mask in zip(colours, masks, strict=True)]
    far = np.clip((np.arange(96) - 24) / 48, 0, 1)
    weights = transition_weights(np.broadcast_to(far, (48, 96)))
    blend = blend_textures(exemplars, masks, weights, key=KEY)
    shown = blend.show(exemplars)
    assert (shown.shape, blend.mask.shape) == ((48, 96, 3), (48, 96))
    for part, own in ((np.s_[:, :16], colours[0]), (np.s_[:, -16:], colours[1])):
        assert np.mean(np.abs(shown[part] - own[blend.mask[part]]).max(axis=2) < 0.05) > 0.93
    # No ghosts: in the middle there are two colours as well, each the mean of both textures'.
    middle = shown[:, 46:50]
    mean = colours.mean(axis=0)[blend.mask[:, 46:50]]
    assert np.mean(np.abs(middle - mean).max(axis=2) < 0.08) > 0.85


def test_a_mask_is_cut_or_grown_to_size() -> None:
    mask = grain(0, 3, 0.5)
    exemplar = mask[..., None] * 0.8
    np.testing.assert_array_equal(lay_out_mask(exemplar, mask, (40, 50), key=KEY), mask[:40, :50])
    told = []
    larger = lay_out_mask(exemplar, mask, (80, 100), key=KEY, report=lambda done, total: told.append((done, total)))
    assert larger.shape == (80, 100)
    assert larger.mean() == pytest.approx(mask.mean(), abs=0.12)
    assert told[-1][0] == told[-1][1]


def test_wrong_arguments_are_named() -> None:
    mask, half = grain(0, 3, 0.5), np.full((2, 64, 64), 0.5)
    with pytest.raises(InputError, match="size"):
        blend_masks([mask, mask[:32]], half)
    with pytest.raises(ValueError, match="weights of shape"):
        blend_masks([mask, mask], half[:, :32])
    with pytest.raises(ValueError, match="sum to 1"):
        blend_masks([mask, mask], 0.8 * half)
    with pytest.raises(ValueError, match="sum to 1"):
        blend_masks([mask, mask], half + np.array([0.7, -0.7])[:, None, None])
    with pytest.raises(ValueError, match="one for each"):
        blend_textures([mask[..., None]], [mask, mask], half, key=KEY)
    with pytest.raises(InputError, match="type"):
        blend_textures([mask[..., None]] * 2, [mask, 2 * mask], half, key=KEY)
    with pytest.raises(ValueError, match="transition"):
        transition_weights([[0.0, 1.5]])
    with pytest.raises(ValueError, match="count"):
        transition_weights([[0.0, 1.0]], 1)


def test_sources_show_other_maps_as_well() -> None:
    mask = grain(5, 3, 0.3)
    exemplar = mask[..., None].repeat(3, axis=2) * 0.9
    blend = blend_textures([exemplar, exemplar], [mask, mask], np.full((2, 48, 96), 0.5), key=KEY)
    heights = [np.full((64, 64, 1), 1.0), np.full((64, 64, 1), 3.0)]
    np.testing.assert_allclose(blend.show(heights), 2.0, atol=1e-5)
    np.testing.assert_allclose(
        blend.show([exemplar] * 2),
        0.5 * sum(sample_sources(exemplar, each) for each in blend.sources),
        atol=1e-6,
    )
