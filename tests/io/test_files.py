"""Files appear whole or not at all."""

import os
from pathlib import Path

import pytest

from jaxtex.core.errors import InputError
from jaxtex.io.files import (
    atomic_write_bytes,
    atomic_write_text,
    existing_file,
    prepare_folder,
    replacing,
    replacing_together,
)


def test_text_is_written_as_it_is(tmp_path: Path) -> None:
    atomic_write_text(tmp_path / "a.json", "tuile: é\r\n")
    assert (tmp_path / "a.json").read_bytes() == "tuile: é\r\n".encode()
    atomic_write_bytes(tmp_path / "a.json", b"\0new")
    assert (tmp_path / "a.json").read_bytes() == b"\0new"
    assert os.listdir(tmp_path) == ["a.json"]


@pytest.mark.parametrize("problem", [RuntimeError, KeyboardInterrupt])
def test_a_block_that_fails_changes_nothing(tmp_path: Path, problem: type[BaseException]) -> None:
    (tmp_path / "a.png").write_text("old")

    def write_half() -> None:
        with replacing(tmp_path / "a.png") as temporary:
            assert (temporary.parent, temporary.suffix) == (tmp_path, ".png")
            temporary.write_text("half of the new")
            raise problem

    with pytest.raises(problem):
        write_half()
    assert (tmp_path / "a.png").read_text() == "old"
    assert os.listdir(tmp_path) == ["a.png"]


@pytest.mark.parametrize("missing", ["a", "b", "c"])
def test_files_that_belong_together_are_replaced_together(tmp_path: Path, missing: str) -> None:
    places = [tmp_path / name for name in "abc"]
    for place in places[:2]:
        place.write_text("old")

    def write(names: str) -> None:
        with replacing_together(places) as temporary:
            for path in temporary:
                if path.name in names:
                    path.write_text("new")

    with pytest.raises(FileNotFoundError):
        write("abc".replace(missing, ""))
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a": "old", "b": "old"}
    write("abc")
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == dict.fromkeys("abc", "new")


def test_files_are_as_readable_as_others(tmp_path: Path) -> None:
    (tmp_path / "plain").write_text("")
    atomic_write_text(tmp_path / "ours", "")
    assert (tmp_path / "ours").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_names_as_long_as_they_may_be(tmp_path: Path) -> None:
    atomic_write_text(tmp_path / f"{'n' * 250}.json", "{}")
    assert os.listdir(tmp_path) == [f"{'n' * 250}.json"]


def test_where_no_file_can_be(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is a folder"):
        atomic_write_text(tmp_path, "")
    with pytest.raises(InputError, match="there is no folder"):
        atomic_write_text(tmp_path / "none" / "a.json", "")


def test_folders_are_made_with_those_above_them(tmp_path: Path) -> None:
    assert prepare_folder(str(tmp_path / "a" / "b")) == tmp_path / "a" / "b"
    assert prepare_folder(tmp_path / "a" / "b").is_dir()


def test_folders_that_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "file" / "below", tmp_path / ("n" * 300)):
        with pytest.raises(InputError, match="folder"):
            prepare_folder(folder)


def test_what_is_no_file_to_read(tmp_path: Path) -> None:
    (tmp_path / "empty").write_text("")
    for path, told in (
        (tmp_path, "is a folder"),
        (tmp_path / "none", "no such file"),
        (tmp_path / "empty", r"is empty \(0 bytes\)"),
        (tmp_path / "empty" / "below", "no such file|cannot be read"),
        (tmp_path / ("n" * 300), "cannot be read"),
    ):
        with pytest.raises(InputError, match=told):
            existing_file(path)
