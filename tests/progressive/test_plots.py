"""Plots of fields: they show the values where these are."""

import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.progressive.plots import plot_orientation, plot_scalar


def test_lines_of_equal_value_lie_where_the_value_is() -> None:
    across = np.linspace(0, 1, 600) * np.ones((200, 1))
    white = (plot_scalar(across) > 0.95).all(axis=-1)
    columns = np.flatnonzero(white.mean(axis=0) > 0.8)
    assert {round(across[0, column], 1) for column in columns} == {round(each / 10, 1) for each in range(1, 10)}
    assert max(abs(across[0, column] * 10 - round(across[0, column] * 10)) for column in columns) < 0.05


def test_colours_go_from_blue_to_yellow_over_the_picture() -> None:
    across = np.linspace(2, 3, 640) * np.ones((64, 1))
    picture = np.full((64, 640, 3), 0.2)
    picture[:32] = 0.6
    shown = plot_scalar(across, picture)
    assert shown[20, 2, 2] > shown[20, 2, 0]
    assert shown[20, -3, 0] > shown[20, -3, 2]
    assert shown[:28].mean() > 1.3 * shown[36:].mean()


@pytest.mark.parametrize("value", [0.0, 1e6])
def test_a_field_that_is_the_same_everywhere_is_shown_with_its_value(value: float) -> None:
    shown = plot_scalar(np.full((40, 30), value))
    assert shown.shape == (520, 390, 3)
    assert np.ptp(shown) > 0.5


def test_strokes_lie_as_the_field_does() -> None:
    for angle in (0.0, 0.6, 2.0):
        field = np.broadcast_to([np.cos(angle), np.sin(angle)], (528, 528, 2))
        light = plot_orientation(field, symmetric=True).mean(axis=2)
        down, across = np.gradient(light)
        tensor = np.array([[(across**2).sum(), (across * down).sum()], [(across * down).sum(), (down**2).sum()]])
        along = np.linalg.eigh(tensor)[1][:, 0]  # light changes least along strokes
        assert abs(along @ field[0, 0]) > 0.99
        arrows = plot_orientation(field)
        assert (arrows > 0.95).sum() > (plot_orientation(field, symmetric=True) > 0.95).sum()
        assert not np.array_equal(arrows, plot_orientation(-field))


def test_what_is_no_field_is_told() -> None:
    with pytest.raises(InputError, match="give finite numbers"):
        plot_scalar(np.full((4, 4), np.nan))
    with pytest.raises(InputError, match="give finite vectors"):
        plot_orientation(np.ones((4, 4)))
    with pytest.raises(InputError, match=r"picture is 5 x 4 pixels, the field 4 x 4"):
        plot_scalar(np.ones((4, 4)), np.ones((4, 5)))
