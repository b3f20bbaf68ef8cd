"""Interiors in files: back as they were, the same bytes, and a clear word about whatever is not right."""

import dataclasses

import numpy as np
import pytest
from drawn_interiors import draw_grain, make_appearance, make_interiors

from jaxtex.core.errors import InputError
from jaxtex.io.arrays import read_arrays, write_arrays
from jaxtex.material.interior_files import interiors_of_planks, interiors_of_tiles, write_interiors
from jaxtex.material.planks import PlankGrain, PlankInteriors
from jaxtex.models.files import SourceImage, TilingFile
from jaxtex.models.floor_files import FloorFile, PlacedWood
from jaxtex.models.tiling import make_tiling
from jaxtex.models.wood import make_wood

REPORT = {"ok": True, "reason": "", "iou": None, "start": None, "standard_errors": {}}
PHOTO = SourceImage(64, 48, "0" * 64)
TILES = make_interiors(
    kind=(np.arange(20) % 2).astype(np.int32),
    shift=np.random.default_rng(0).normal(size=(20, 4)).astype(np.float32),
    wobble=0.75,
    wobble_length=3.0,
    tile_grain=(draw_grain(), draw_grain(height=20, seed=1)),
)
NONE = np.zeros((0, 1, 1, 3), np.float32)
PLANKS = PlankInteriors(
    tone=np.random.default_rng(0).random((3, 3)).astype(np.float32),
    own=np.array([True, False, False]),
    turned=np.array([False, False, True]),
    contrast=np.array([1, 0.5, 2], np.float32),
    grain=(PlankGrain(draw_grain(), 8, draw_grain()), PlankGrain(NONE, 1, NONE)),
    profile=np.linspace(-0.2, 0, 15, dtype=np.float32).reshape(5, 3),
    joint=np.array([0.1, 0.1, 0.05], np.float32),
)


def tiling_file(name="interiors.npz"):
    named = {} if name is None else {"interiors": name}
    wall = make_tiling(tile_width=24.0, tile_height=12.0, mortar_x=2.0, mortar_y=2.0)
    return TilingFile(wall, PHOTO, 4, 5, REPORT, appearance=make_appearance().to_json() | named)


def floor_file(planks=3, name="interiors.npz"):
    corners = np.array([[0.0, 0], [20, 0], [20, 48], [0, 48]])
    woods = tuple(PlacedWood(corners, make_wood(ring_spacing=9.0), True) for _ in range(planks))
    return FloorFile(woods, PHOTO, REPORT | {"interiors": name})


def assert_same(found, expected):
    for field in dataclasses.fields(expected):
        one, other = getattr(found, field.name), getattr(expected, field.name)
        if field.name in ("grain", "tile_grain"):
            for a, b in zip(one, other, strict=True):
                if isinstance(a, PlankGrain):
                    assert a.squeezed == b.squeezed
                    a, b = a.examples, b.examples
                assert a.shape == b.shape
                np.testing.assert_allclose(a, b, atol=0.51 / 255)
        else:
            np.testing.assert_array_equal(one, other, err_msg=field.name)
            assert np.asarray(one).dtype == np.asarray(other).dtype


def test_tiles_come_back_as_they_were(tmp_path):
    write_interiors(tmp_path / "interiors.npz", TILES)
    found = interiors_of_tiles(tmp_path / "model.json", tiling_file())
    assert_same(found, TILES)
    # What is read is what is written: nothing is lost a second time.
    write_interiors(tmp_path / "again.npz", found)
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "interiors.npz").read_bytes()


def test_planks_come_back_as_they_were(tmp_path):
    write_interiors(tmp_path / "interiors.npz", PLANKS)
    assert_same(interiors_of_planks(tmp_path / "model.json", floor_file()), PLANKS)


def test_grain_beyond_what_is_kept_stops_there(tmp_path):
    strong = make_interiors(tile_grain=(np.full((1, 8, 8, 3), 2.0, np.float32),))
    write_interiors(tmp_path / "interiors.npz", strong)
    (grain,) = interiors_of_tiles(tmp_path / "model.json", tiling_file()).tile_grain
    np.testing.assert_allclose(grain, 127 / 255, rtol=1e-6)


def test_a_model_that_names_no_interiors_has_none(tmp_path):
    assert interiors_of_tiles(tmp_path / "model.json", tiling_file(name=None)) is None
    assert interiors_of_planks(tmp_path / "model.json", floor_file(name=None)) is None
    plain = dataclasses.replace(tiling_file(), appearance=None)
    assert interiors_of_tiles(tmp_path / "model.json", plain) is None


@pytest.mark.parametrize("name", ["other.npz", "../interiors.npz", "/etc/passwd", "", 3, ["interiors.npz"]])
def test_only_files_beside_the_model_are_read(tmp_path, name):
    (tmp_path / "below").mkdir()
    write_interiors(tmp_path / "interiors.npz", TILES)
    with pytest.raises(InputError, match=r"which are not beside it; put them there, or give --no-fill") as error:
        interiors_of_tiles(tmp_path / "below" / "model.json", tiling_file(name=name))
    assert str(error.value).startswith(f"{tmp_path / 'below' / 'model.json'}: names the interiors {name!r}")


def test_interiors_of_another_kind_or_schema_are_refused(tmp_path):
    path = tmp_path / "interiors.npz"
    write_interiors(path, PLANKS)
    with pytest.raises(InputError, match="holds no interiors of tiles that this version knows"):
        interiors_of_tiles(tmp_path / "model.json", tiling_file())
    write_interiors(path, TILES)
    with pytest.raises(InputError, match="holds no interiors of planks that this version knows"):
        interiors_of_planks(tmp_path / "model.json", floor_file())
    write_arrays(path, {**read_arrays(path), "schema": 2})
    with pytest.raises(InputError, match="holds no interiors of tiles"):
        interiors_of_tiles(tmp_path / "model.json", tiling_file())
    write_interiors(path, PLANKS)
    with pytest.raises(InputError, match="its interiors are those of 3 planks; fit the photograph again"):
        interiors_of_planks(tmp_path / "model.json", floor_file(planks=4))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("places", None),
        ("kinds", None),
        ("tile_grain_1", None),
        ("places", np.zeros((0, 2), np.int32)),
        ("places", np.zeros((20, 3), np.int32)),
        ("kind", np.full(20, 2, np.int32)),
        ("kind", np.full(20, -1, np.int32)),
        ("kind", np.zeros(19, np.int32)),
        ("contrast", np.full(20, np.nan)),
        ("shift", np.zeros((20, 3))),
        ("wobble", "much"),
        ("wobble", np.zeros(3)),
        ("wobble", np.nan),
        ("wobble_length", np.inf),
        ("tile_grain_0", np.zeros((1, 8, 8, 3), np.float32)),
        ("tile_grain_0", np.zeros((8, 8, 3), np.int8)),
        ("joint_grain", np.zeros((1, 8, 8, 4), np.int8)),
        ("tile_profile", np.zeros((4, 0, 3))),
        ("tile_profile", np.zeros((3, 5, 3))),
        ("joint_profile", np.array([["a"]])),
    ],
)
def test_damaged_interiors_are_named(tmp_path, name, value):
    path = tmp_path / "interiors.npz"
    write_interiors(path, TILES)
    arrays = read_arrays(path)
    del arrays[name]
    write_arrays(path, arrays | ({} if value is None else {name: value}))
    with pytest.raises(InputError, match=r"interiors\.npz: is damaged .*; fit the photograph again"):
        interiors_of_tiles(tmp_path / "model.json", tiling_file())


def test_interiors_of_another_photograph_are_refused(tmp_path):
    write_interiors(tmp_path / "interiors.npz", dataclasses.replace(TILES, places=TILES.places + 100))
    with pytest.raises(InputError, match="fit the photograph again"):
        interiors_of_tiles(tmp_path / "model.json", tiling_file())


def test_a_file_that_is_no_archive_is_named(tmp_path):
    (tmp_path / "interiors.npz").write_text("a shopping list")
    with pytest.raises(InputError, match=r"interiors\.npz: is no archive of arrays, or damaged"):
        interiors_of_tiles(tmp_path / "model.json", tiling_file())
