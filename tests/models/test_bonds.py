"""Named bonds, by what a mason would check."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxtex.models.bonds import bond_pattern
from jaxtex.models.tiling import make_tiling


def head_joints(bond: str, course: int, **changes) -> list[float]:
    """Where a walk of three stretchers along a course meets head joints, in stretchers."""
    with jax.enable_x64():
        wall = make_tiling(tile_width=1.0, tile_height=1.0, **bond_pattern(bond, **changes))
        x = np.arange(-0.0625, 3, 0.125)
        places = jax.vmap(wall.locate)(jnp.stack([jnp.asarray(x), jnp.full_like(x, course + 0.5)], axis=1))
        changed = np.flatnonzero(np.diff(np.asarray(places.tile)))
        return [round(float(x[i] + places.right[i]), 6) for i in changed]


def test_stack_has_its_head_joints_in_line():
    assert head_joints("stack", 0) == head_joints("stack", 1) == [0.0, 1.0, 2.0]


def test_running_has_them_over_the_middle_of_tiles():
    assert head_joints("running", 0) == head_joints("running", 2) == [0.0, 1.0, 2.0]
    assert head_joints("running", 1) == head_joints("running", -1) == [0.5, 1.5, 2.5]


def test_english_has_courses_of_stretchers_and_of_headers():
    assert head_joints("english", 0) == head_joints("english", 2) == [0.0, 1.0, 2.0]
    assert head_joints("english", 1) == head_joints("english", -3) == [0.25, 0.75, 1.25, 1.75, 2.25, 2.75]


def test_flemish_centres_headers_on_the_stretchers_above_and_below():
    assert head_joints("flemish", 0) == head_joints("flemish", -2) == [0.0, 1.0, 1.5, 2.5]
    # The header [0.25, 0.75] lies over the stretcher [0, 1]; the stretcher [0.75, 1.75] over the header [1, 1.5].
    assert head_joints("flemish", 1) == [0.25, 0.75, 1.75, 2.25]


def test_headers_of_another_length_stay_centred_at_the_origin():
    joints = head_joints("flemish", 1, header=0.6)
    assert joints[0] == pytest.approx(0.2)
    assert joints[1] == pytest.approx(0.8)
    assert head_joints("english", 1, header=0.4)[:2] == [0.2, 0.6]


@pytest.mark.parametrize("bond", ["raking", "irregular", "herringbone"])
def test_bonds_without_a_pattern_of_their_own_are_refused(bond):
    with pytest.raises(ValueError, match=f"bond '{bond}' has no pattern of its own; these have: stack, running"):
        bond_pattern(bond)
