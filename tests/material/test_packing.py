"""Maps packed into textures: the numbers of the PNG files, where clients look for them."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.io.raster import read_raster
from jaxtex.material.export import write_maps
from jaxtex.material.packing import pack_maps

SIZE = (7, 50)


class FullMaps(NamedTuple):
    base_colour: np.ndarray
    normal: np.ndarray
    roughness: np.ndarray
    occlusion: np.ndarray
    metallic: np.ndarray
    specular: np.ndarray


def make_maps(*, rows: int = SIZE[1]) -> FullMaps:
    random = np.random.default_rng(0)
    normal = random.normal(size=(rows, SIZE[0], 3)) + np.array([0, 0, 3])
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    single = random.random((4, rows, SIZE[0])).astype(np.float32)
    colour = 1.2 * random.random((rows, SIZE[0], 3)) - 0.1  # light may be more than white
    return FullMaps(colour.astype(np.float32), normal.astype(np.float32), *single)


def in_bands(maps: NamedTuple, rows: int) -> list[NamedTuple]:
    return [type(maps)(*(part[first : first + rows] for part in maps)) for first in range(0, SIZE[1], rows)]


class Bare(NamedTuple):
    base_colour: np.ndarray
    normal: np.ndarray
    roughness: np.ndarray


def test_numbers_are_those_of_the_png_files(tmp_path: Path) -> None:
    full = make_maps()
    maps = Bare(full.base_colour, full.normal, full.roughness)
    write_maps(tmp_path, in_bands(maps, 16), size=SIZE, fields=("base_colour", "normal", "roughness"))
    packed = pack_maps(in_bands(maps, 16), size=SIZE)
    assert np.array_equal(packed.base_colour, read_raster(tmp_path / "basecolor.png").numbers)
    assert np.array_equal(packed.normal, read_raster(tmp_path / "normal.png").numbers)
    assert np.array_equal(packed.surface[..., 1], read_raster(tmp_path / "roughness.png").numbers[..., 0])


def test_each_map_has_its_channel() -> None:
    maps = make_maps()
    packed = pack_maps(in_bands(maps, 16), size=SIZE)
    for channel, field in enumerate((maps.occlusion, maps.roughness, maps.metallic)):
        np.testing.assert_allclose(packed.surface[..., channel] / 255, field, atol=0.501 / 255)
    assert packed.specular is not None
    # The sRGB curve as IEC 61966-2-1 has it.
    encoded = packed.specular / 255
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(linear, maps.specular, atol=0.005)


@pytest.mark.parametrize("rows", [1, 49, 50])
def test_bands_do_not_matter(rows: int) -> None:
    maps = make_maps()
    for one, other in zip(pack_maps([maps], size=SIZE), pack_maps(in_bands(maps, rows), size=SIZE), strict=True):
        assert np.array_equal(one, other)


def test_maps_that_a_material_has_not_are_plain() -> None:
    full = make_maps()
    packed = pack_maps([Bare(full.base_colour, full.normal, full.roughness)], size=SIZE)
    assert (packed.surface[..., 0] == 255).all()
    assert (packed.surface[..., 2] == 0).all()
    assert packed.specular is None
    assert pack_maps([full._replace(specular=np.full_like(full.specular, 0.5))], size=SIZE).specular is None


def test_wrong_maps_are_refused() -> None:
    maps = make_maps()
    with pytest.raises(ValueError, match="50 rows were to be packed, and 49 came"):
        pack_maps([make_maps(rows=49)], size=SIZE)
    with pytest.raises(InputError, match="textures of 1 x 20000 pixels"):
        pack_maps([], size=(1, 20_000))
    with pytest.raises(InputError, match="NaN or infinite"):
        pack_maps([maps._replace(metallic=np.full_like(maps.metallic, np.nan))], size=SIZE)
    with pytest.raises(InputError, match="holds 0 to 1"):
        pack_maps([maps._replace(occlusion=maps.occlusion + 1)], size=SIZE)
