import jax
import numpy as np
import pytest

from jaxtex.synthesis import anisometric_refinement
from jaxtex.synthesis.anisometric import synthesise_anisometric
from jaxtex.synthesis.anisometric_refinement import refine_anisometric


def test_borders_come_nearer_to_where_guides_have_them() -> None:
    rng = np.random.default_rng(0)
    ours = (np.hypot(*(np.indices((64, 64)) % 16 - 8)) < 5).astype(np.float32)
    theirs = (np.hypot(*(np.indices((48, 60)) % 20 - 10)) < 7).astype(np.float32)
    exemplar = ours[..., None] * 0.6 + 0.1 * rng.random((64, 64, 3))
    frames = np.ones(theirs.shape), np.zeros(theirs.shape)
    guides = ours[..., None], theirs[..., None]
    first = synthesise_anisometric(exemplar, *frames, key=jax.random.key(0), guides=guides, guide_weight=1.0)
    again = refine_anisometric(exemplar, first, *frames, radius=1, guides=guides, guide_weight=1.0)

    def missed(sources: np.ndarray) -> float:
        at = np.rint(sources).astype(int)
        return float(np.mean(ours[at[..., 0], at[..., 1]] != theirs))

    assert missed(again) < missed(first)
    assert (again >= 0).all()
    assert (again <= 63).all()


@pytest.mark.parametrize(("side", "count"), [(40, 1), (68, 1), (69, 2), (136, 2), (137, 3)])
def test_small_exemplars_are_searched_all_at_once(side: int, count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    def analyse(pixels: np.ndarray, *given: object, coarsest: int, **options: object) -> None:
        sides = [side]
        while sides[-1] >= 2 * coarsest:
            sides.append(-(-sides[-1] // 2))
        assert len(sides) == count
        assert (sides[-1] - 4) ** 2 <= 4096
        raise InterruptedError

    monkeypatch.setattr(anisometric_refinement, "analyse_levels", analyse)
    with pytest.raises(InterruptedError):
        refine_anisometric(np.zeros((side, side, 1)), np.zeros((4, 4, 2)), np.ones((4, 4)), np.zeros((4, 4)))


def test_wrong_arguments_are_named() -> None:
    exemplar, fields = np.random.default_rng(0).random((20, 20, 3)), (np.ones((8, 9)), np.zeros((8, 9)))
    sources = np.full((8, 9, 2), 5.0)
    with pytest.raises(ValueError, match="sources of shape"):
        refine_anisometric(exemplar, sources[:7], *fields)
    with pytest.raises(ValueError, match="similar"):
        refine_anisometric(exemplar, sources, *fields, similar=-1)
    with pytest.raises(ValueError, match="exemplar"):
        refine_anisometric(exemplar[:3], sources, *fields)
