"""Meshes and voxel blocks as files."""

import numpy as np
import pytest
import trimesh

from jaxtex.core.colour import srgb_to_linear
from jaxtex.core.errors import InputError
from jaxtex.io.images import read_image
from jaxtex.io.meshes import read_mesh, write_mesh
from jaxtex.io.voxels import check_block, read_voxels, write_voxels


@pytest.mark.parametrize("kind", ["ply", "obj", "stl", "off", "glb"])
def test_meshes_of_many_kinds_are_read(tmp_path, kind):
    trimesh.creation.box(extents=(3, 2, 1)).export(tmp_path / f"box.{kind}")
    mesh = read_mesh(tmp_path / f"box.{kind}")
    assert len(mesh.faces) == 12
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), [3, 2, 1], atol=1e-6)


def test_a_mesh_comes_back_with_its_colours(tmp_path):
    trimesh.creation.icosphere(subdivisions=1).export(tmp_path / "ball.ply")
    mesh = read_mesh(tmp_path / "ball.ply")
    colours = np.random.default_rng(0).random((len(mesh.vertices), 3))
    for name in ("one.ply", "other.ply"):
        write_mesh(tmp_path / name, mesh, colours)
    read = trimesh.load_mesh(tmp_path / "one.ply", process=False)
    np.testing.assert_allclose(read.vertices, mesh.vertices, atol=1e-6)
    assert np.array_equal(read.faces, mesh.faces)
    np.testing.assert_allclose(srgb_to_linear(read.visual.vertex_colors[:, :3] / 255), colours, atol=6e-3)
    assert (tmp_path / "one.ply").read_bytes() == (tmp_path / "other.ply").read_bytes()


POINTS = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
BAD_MESHES = {
    "missing.ply": (None, "there is no such file"),
    "empty.ply": ("", "is empty"),
    "text.ply": ("a shopping list", "is no mesh that can be read"),
    "photo.xyzzy": ("a shopping list", "is no mesh that can be read"),
    "points.ply": (POINTS + "0 0 0\n1 1 1\n", "is no mesh that can be read|holds no triangles"),
    "nan.obj": ("v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "has vertices that are not finite"),
    "beyond.off": ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", "vertices that are not there|can be read"),
}


@pytest.mark.parametrize("name", BAD_MESHES)
def test_what_is_no_mesh_is_refused_in_one_line(tmp_path, name):
    text, told = BAD_MESHES[name]
    if text is not None:
        (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=told) as refusal:
        read_mesh(tmp_path / name)
    assert str(refusal.value).startswith(str(tmp_path / name))
    assert "\n" not in str(refusal.value)


def test_a_block_comes_back_and_has_no_date(tmp_path):
    voxels = np.random.default_rng(0).random((3, 4, 5, 3)).astype(np.float32)
    flat = voxels.reshape(-1, 3)
    write_voxels(tmp_path / "one.npz", [flat], shape=voxels.shape)
    write_voxels(tmp_path / "other.npz", [flat[:7], flat[7:50], flat[50:]], shape=voxels.shape)
    with np.load(tmp_path / "one.npz") as read:
        assert read.files == ["voxels"]
        assert read["voxels"].dtype == np.float32
        assert np.array_equal(read["voxels"], voxels)
    assert np.array_equal(read_voxels(tmp_path / "one.npz"), voxels)
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "other.npz").read_bytes()


def test_a_block_is_whole_or_not_there(tmp_path):
    part = np.zeros((5, 3), np.float32)
    with pytest.raises(ValueError, match="there are 5 of the 8 voxels"):
        write_voxels(tmp_path / "block.npz", [part], shape=(2, 2, 2, 3))
    with pytest.raises(ValueError, match="no part of a block"):
        write_voxels(tmp_path / "block.npz", [part[:, :1]], shape=(2, 2, 2, 3))
    assert not list(tmp_path.iterdir())


BLOCK = np.random.default_rng(1).random((3, 4, 5, 3)).astype(np.float32)


def in_parts(voxels: np.ndarray, *cuts: int) -> list[np.ndarray]:
    return np.split(voxels.reshape(-1, voxels.shape[-1]), cuts)


@pytest.mark.parametrize("cuts", [(), (7, 50), range(1, 60)])
def test_a_stack_is_the_slices_across_z(tmp_path, cuts):
    write_voxels(tmp_path / "oak.v2.exr", in_parts(BLOCK, *cuts), shape=BLOCK.shape)
    names = [f"oak.v2.000{z}.exr" for z in range(3)]
    assert sorted(path.name for path in tmp_path.iterdir()) == names
    for name, across in zip(names, BLOCK, strict=True):
        image = read_image(tmp_path / name)
        assert image.colour_space == "linear"
        np.testing.assert_allclose(image.pixels, across, atol=5e-4)


@pytest.mark.parametrize("channels", [1, 2, 3])
def test_bare_numbers_are_as_their_header_says(tmp_path, channels):
    block = BLOCK[..., :channels]
    write_voxels(tmp_path / "oak.raw", in_parts(block, 11), shape=block.shape)
    header = (tmp_path / "oak.nhdr").read_text().splitlines()
    assert header[0] == "NRRD0004"
    fields = dict(line.split(": ") for line in header[1:] if not line.startswith("#"))
    sizes = [int(word) for word in fields["sizes"].split()]
    assert (fields["type"], fields["endian"], fields["encoding"]) == ("float", "little", "raw")
    assert len(sizes) == int(fields["dimension"]) == len(fields["kinds"].split())
    numbers = np.fromfile(tmp_path / fields["data file"], "<f4").reshape(sizes, order="F")
    expected = np.moveaxis(block, (0, 1, 2, 3), (3, 2, 1, 0))
    assert np.array_equal(numbers, expected if channels > 1 else expected[0])


def test_a_grid_volume_is_as_mitsuba_documents_it(tmp_path):
    write_voxels(tmp_path / "oak.vol", in_parts(BLOCK, 11), shape=BLOCK.shape)
    data = (tmp_path / "oak.vol").read_bytes()
    assert data[:4] == b"VOL\3"
    kind, nx, ny, nz, channels = np.frombuffer(data[4:24], "<i4")
    assert (kind, nx, ny, nz, channels) == (1, 5, 4, 3, 3)
    np.testing.assert_allclose(np.frombuffer(data[24:48], "<f4"), [0, 0, 0, 1, 0.8, 0.6])
    numbers = np.frombuffer(data[48:], "<f4")
    for x, y, z, c in np.ndindex(5, 4, 3, 3):
        assert numbers[((z * ny + y) * nx + x) * channels + c] == BLOCK[z, y, x, c]


@pytest.mark.parametrize("channels", range(1, 8))
def test_grid_volumes_have_channels_that_mitsuba_reads(tmp_path, channels):
    block = np.ones((2, 2, 2, channels), np.float32)
    if channels in (1, 3, 6):
        write_voxels(tmp_path / "oak.vol", in_parts(block), shape=block.shape)
        assert (tmp_path / "oak.vol").stat().st_size == 48 + block.nbytes
        return
    for write in (check_block, lambda path, shape: write_voxels(path, in_parts(block), shape=shape)):
        with pytest.raises(InputError, match=f"oak.vol: the block has {channels} channels, and Mitsuba reads 1, 3 or"):
            write(tmp_path / "oak.vol", block.shape)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("kind", ["npz", "exr", "raw", "vol"])
def test_a_block_that_fails_leaves_the_files_as_they_were(tmp_path, kind):
    path = tmp_path / f"block.{kind}"
    write_voxels(path, in_parts(BLOCK), shape=BLOCK.shape)
    before = {each.name: each.read_bytes() for each in tmp_path.iterdir()}
    for part in (BLOCK.reshape(-1, 3)[:-1], np.zeros((61, 3), np.float32)):
        with pytest.raises(ValueError, match=r"part of a block|59 of the 60 voxels"):
            write_voxels(path, [part], shape=BLOCK.shape)
        assert {each.name: each.read_bytes() for each in tmp_path.iterdir()} == before
    write_voxels(path, in_parts(BLOCK * 2), shape=BLOCK.shape)
    assert sorted(each.name for each in tmp_path.iterdir()) == sorted(before)


def test_stacks_of_other_depths_do_not_mix(tmp_path):
    write_voxels(tmp_path / "oak.exr", in_parts(BLOCK), shape=BLOCK.shape)
    (tmp_path / "oak.final.exr").touch()
    with pytest.raises(InputError, match=r"oak.0001.exr to oak.0002.exr of another stack"):
        write_voxels(tmp_path / "oak.exr", in_parts(BLOCK[:1]), shape=(1, 4, 5, 3))
    for each in ("oak.0001.exr", "oak.0002.exr"):
        (tmp_path / each).unlink()
    write_voxels(tmp_path / "oak.exr", in_parts(BLOCK[:1]), shape=(1, 4, 5, 3))
    with pytest.raises(InputError, match="the block has 2 channels, and slices hold 1"):
        write_voxels(tmp_path / "elm.exr", in_parts(BLOCK[..., :2]), shape=(3, 4, 5, 2))


@pytest.mark.parametrize("name", ["block.vdb", "block.nhdr", "block"])
def test_other_formats_are_told_which_there_are(tmp_path, name):
    with pytest.raises(InputError, match=r"cannot be written as .*; name it \.npz, \.exr, \.raw, \.vol"):
        write_voxels(tmp_path / name, in_parts(BLOCK), shape=BLOCK.shape)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("kind", [np.float16, np.float64, ">f4"])
def test_blocks_of_any_precision_are_read_in_single(tmp_path, kind):
    np.savez_compressed(tmp_path / "block.npz", voxels=np.full((1, 2, 3, 1), 0.25, kind), other=np.arange(3))
    read = read_voxels(tmp_path / "block.npz")
    assert read.dtype == np.float32
    assert np.array_equal(read, np.full((1, 2, 3, 1), 0.25))


BAD_BLOCKS = {
    "holds no array 'voxels'": {"block": np.zeros((2, 2, 2, 3))},
    r"voxels of shape \(2, 2, 2\) are no block": {"voxels": np.zeros((2, 2, 2))},
    r"voxels of shape \(2, 0, 2, 3\) are no block": {"voxels": np.zeros((2, 0, 2, 3))},
    "voxels are uint8": {"voxels": np.zeros((2, 2, 2, 3), np.uint8)},
    "NaN or infinite numbers, the first at z 1, y 0, x 1": {"voxels": np.array([[[[0.0], [0]]], [[[0], [np.nan]]]])},
    "NaN or infinite numbers, the first at z 0": {"voxels": np.full((1, 1, 1, 3), 1e300)},
    "is no archive": {"voxels": np.array([{"pickled": 1}])},
}


@pytest.mark.parametrize("told", BAD_BLOCKS)
def test_what_is_no_block_is_refused_in_one_line(tmp_path, told):
    path = tmp_path / "block.npz"
    np.savez(path, **BAD_BLOCKS[told])
    with pytest.raises(InputError, match=told) as refusal:
        read_voxels(path)
    assert str(refusal.value).startswith(str(path))
    assert "\n" not in str(refusal.value)


def test_files_that_are_no_blocks_are_refused(tmp_path):
    whole = tmp_path / "whole.npz"
    np.savez(whole, voxels=np.zeros((4, 4, 4, 3)))
    (tmp_path / "cut.npz").write_bytes(whole.read_bytes()[:700])
    (tmp_path / "text.npz").write_text("a shopping list")
    np.save(tmp_path / "one.npy", np.zeros((2, 2, 2, 3)))
    (tmp_path / "empty.npz").touch()
    for name, told in {
        "none.npz": "no such file",
        "empty.npz": "is empty",
        "cut.npz": "no archive",
        "text.npz": "no archive",
        "one.npy": "no archive",
    }.items():
        with pytest.raises(InputError, match=told) as refusal:
            read_voxels(tmp_path / name)
        assert "\n" not in str(refusal.value)
