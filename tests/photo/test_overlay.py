"""The overlay shows the photograph, and where tiles end."""

import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.photo.morphology import outline_mask
from jaxtex.photo.overlay import overlay_mask


@pytest.mark.parametrize("channels", [(), (1,), (3,)])
def test_tiles_stay_joints_are_veiled_and_outlines_drawn(channels: tuple[int, ...]) -> None:
    picture = np.full((20, 30, *channels), 0.25)
    mask = np.ones((20, 30), bool)
    mask[:, 10:16] = False
    shown = overlay_mask(picture, mask)
    outline = outline_mask(mask)
    assert shown.shape == (20, 30, 3)
    assert (shown[mask & ~outline] == 0.25).all()
    assert len(np.unique(shown[outline], axis=0)) == 1
    veiled = shown[~mask & ~outline]
    assert (veiled[:, 0] < 0.25).all()
    assert (veiled[:, 1] > 0.25).all()
    assert (picture == 0.25).all()


def test_lines_are_broader_on_large_pictures() -> None:
    mask = np.ones((4, 4800), bool)
    mask[:, 2000:] = False
    drawn = overlay_mask(np.zeros((4, 4800)), mask)[0]
    assert (drawn == drawn[2000]).all(axis=1).sum() == 8


def test_a_mask_of_another_size_is_refused() -> None:
    with pytest.raises(InputError, match="mask: is 5 x 4 pixels, but its picture 4 x 5"):
        overlay_mask(np.zeros((5, 4)), np.ones((4, 5), bool))
