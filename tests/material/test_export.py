"""Maps as files: what stands in them, and that they come whole or not at all."""

import jax
import numpy as np
import pytest

from jaxtex.io.images import read_image
from jaxtex.material.appearance import Appearance
from jaxtex.material.export import MAP_NAMES, write_maps
from jaxtex.material.maps import Maps, render_maps
from jaxtex.material.sheet import lay_sheet
from jaxtex.models.tiling import make_tiling

SIZE = (150, 200)


def make_bands():
    wall = make_tiling(tile_width=64.0, tile_height=32.0, mortar_x=6.0, mortar_y=4.0, offset=0.5)
    appearance = Appearance(
        tiles={(0, 0): (0.5, 0.2, 0.1), (1, 0): (0.3, 0.3, 0.1)}, joint=(0.8, 0.8, 0.7), joint_depth=3.0, edge_width=2.0
    )
    return list(render_maps(lay_sheet(wall, tiles=(3, 4)), appearance, size=SIZE, key=jax.random.key(0)))


def test_the_files_hold_the_maps(tmp_path):
    bands = make_bands()
    assert len(bands) == 2
    paths = write_maps(tmp_path, bands, size=SIZE)
    assert [path.name for path in paths] == list(MAP_NAMES)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(MAP_NAMES)
    maps = Maps(*(np.concatenate(part) for part in zip(*bands, strict=True)))
    data = {path.stem: read_image(path, colour_space="data") for path in paths}
    colour = read_image(tmp_path / "basecolor.png")
    assert colour.colour_space == "srgb"
    np.testing.assert_allclose(colour.pixels, maps.base_colour, atol=0.01)
    assert np.array_equal(data["height"].pixels[..., 0], maps.height)
    assert np.array_equal(data["tile_id"].pixels[..., 0], maps.tile_id)
    np.testing.assert_allclose(data["roughness"].pixels[..., 0], maps.roughness, atol=0.51 / 255)
    np.testing.assert_allclose(data["normal"].pixels, 0.5 * maps.normal + 0.5, atol=0.51 / 255)
    flat = maps.normal[..., 2] == 1
    assert np.array_equal(np.unique(np.rint(255 * data["normal"].pixels[flat]), axis=0), [[128, 128, 255]])


def test_only_the_base_colour_is_marked_as_srgb(tmp_path):
    write_maps(tmp_path, make_bands(), size=SIZE)
    assert [name for name in MAP_NAMES if b"sRGB" in (tmp_path / name).read_bytes()] == ["basecolor.png"]
    for name in ("height.exr", "tile_id.exr"):
        assert read_image(tmp_path / name).colour_space == "data"


def test_the_same_maps_make_the_same_bytes(tmp_path):
    for folder in ("one", "other"):
        (tmp_path / folder).mkdir()
        write_maps(tmp_path / folder, make_bands(), size=SIZE)
    for name in MAP_NAMES:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "other" / name).read_bytes()


def test_an_interruption_leaves_what_was_there(tmp_path):
    (tmp_path / "height.exr").write_text("older")

    def interrupted():
        yield make_bands()[0]
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_maps(tmp_path, interrupted(), size=SIZE)
    assert [path.name for path in tmp_path.iterdir()] == ["height.exr"]
    assert (tmp_path / "height.exr").read_text() == "older"
