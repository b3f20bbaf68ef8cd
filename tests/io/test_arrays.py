"""Arrays in files: back as they were, the same bytes each time, and nothing from damaged files but a complaint."""

import zipfile
from pathlib import Path

import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.io.arrays import read_arrays, write_arrays

ARRAYS = {
    "steps": np.arange(24, dtype=np.int8).reshape(2, 3, 4),
    "floats": np.linspace(0, 1, 7, dtype=np.float32),
    "turned": np.asfortranarray(np.arange(6.0).reshape(2, 3)),
    "none": np.zeros((0, 1, 1, 3), np.float32),
    "flags": np.array([True, False]),
    "number": 2,
    "word": "tiles",
}


def test_arrays_come_back_as_they_were(tmp_path: Path) -> None:
    write_arrays(tmp_path / "a.npz", ARRAYS)
    found = read_arrays(tmp_path / "a.npz")
    assert list(found) == list(ARRAYS)
    for name, array in ARRAYS.items():
        assert np.array_equal(found[name], array)
        assert found[name].dtype == np.asarray(array).dtype
        assert found[name].shape == np.shape(array)
    with np.load(tmp_path / "a.npz") as archive:
        assert np.array_equal(archive["turned"], ARRAYS["turned"])


def test_the_same_arrays_are_the_same_bytes_without_a_date(tmp_path: Path) -> None:
    for name in ("a.npz", "b.npz"):
        write_arrays(tmp_path / name, ARRAYS)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    with zipfile.ZipFile(tmp_path / "a.npz") as archive:
        assert {entry.date_time[0] for entry in archive.infolist()} == {1980}
    assert [path.name for path in sorted(tmp_path.iterdir())] == ["a.npz", "b.npz"]


def test_a_file_that_cannot_be_written_leaves_the_older_one(tmp_path: Path) -> None:
    write_arrays(tmp_path / "a.npz", {"x": 1})
    with pytest.raises(ValueError, match=r"[Oo]bject"):
        write_arrays(tmp_path / "a.npz", {"x": np.array([object()])})
    assert read_arrays(tmp_path / "a.npz")["x"] == 1
    assert len(list(tmp_path.iterdir())) == 1
    with pytest.raises(InputError):
        write_arrays(tmp_path / "none" / "a.npz", {"x": 1})


def damage(path: Path, kind: str) -> None:
    data = path.read_bytes()
    match kind:
        case "cut":
            path.write_bytes(data[: len(data) // 2])
        case "empty":
            path.write_bytes(b"")
        case "text":
            path.write_text("a shopping list")
        case "flipped":
            path.write_bytes(data[:60] + bytes(255 - byte for byte in data[60:90]) + data[90:])
        case "array":
            with path.open("wb") as file:
                np.save(file, np.arange(3))
        case "pickled":
            np.savez(path, x=np.array([{"a": 1}]))


@pytest.mark.parametrize("kind", ["cut", "empty", "text", "flipped", "array", "pickled"])
def test_damaged_files_are_named(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "a.npz"
    write_arrays(path, ARRAYS)
    damage(path, kind)
    with pytest.raises(InputError) as error:
        read_arrays(path)
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)


def test_what_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.npz: there is no such file"):
        read_arrays(tmp_path / "none.npz")
    with pytest.raises(InputError, match="is a folder"):
        read_arrays(tmp_path)
