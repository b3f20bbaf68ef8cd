"""Photographs that the commands are tried on."""

from pathlib import Path

import numpy as np
import pytest


@pytest.fixture(scope="session")
def wall_photo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A brick wall, 200 x 200 pixels: bricks of 48 x 18 in running bond, light joints of 4 pixels, seen straight on."""
    from jaxtex.io.images import write_image

    random = np.random.default_rng(0)
    y, x = np.indices((200, 200)) + 0.5
    course, down = np.divmod(y - 7, 18)
    tile, right = np.divmod(x - 11 - 24 * (course % 2), 48)
    in_tile = (np.abs(down - 9) < 7) & (np.abs(right - 24) < 22)
    shades = random.uniform(0.7, 1.3, (32, 32))[course.astype(int), tile.astype(int)]
    colour = np.where(in_tile[..., None], shades[..., None] * np.array([0.3, 0.12, 0.08]), 0.5)
    path = tmp_path_factory.mktemp("photographs") / "wall.png"
    write_image(path, np.clip(colour + random.normal(0, 0.01, colour.shape), 0, 1))
    return path


@pytest.fixture
def no_maps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Maps of tilings are not what is looked at."""
    monkeypatch.setattr("jaxtex.cli.results.write_sheet", lambda *_, **__: None)
