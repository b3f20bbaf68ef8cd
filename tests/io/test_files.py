"""Files appear whole or not at all."""

import os
from collections.abc import Callable
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


def fail_replacing(monkeypatch: pytest.MonkeyPatch, fails: Callable[[Path, Path], bool]) -> None:
    replace = os.replace

    def replace_some(source: Path, place: Path) -> None:
        if fails(source, place):
            raise PermissionError(f"{place}: held by another program")
        replace(source, place)

    monkeypatch.setattr(os, "replace", replace_some)


def write_together(places: list[Path]) -> None:
    with replacing_together(places) as temporary:
        for path in temporary:
            path.write_text("new")


def read_all(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.iterdir()}


def test_files_stay_where_none_of_the_new_ones_was_written(tmp_path: Path) -> None:
    places = [tmp_path / name for name in "abc"]
    for place in places[:2]:
        place.write_text("old")
    with pytest.raises(FileNotFoundError, match="a: was not written"), replacing_together(places):
        pass
    assert read_all(tmp_path) == {"a": "old", "b": "old"}


@pytest.mark.parametrize("links", [True, False])
@pytest.mark.parametrize("held", ["a", "b", "c", "d"])
def test_files_are_put_back_where_one_cannot_be_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, held: str, links: bool
) -> None:
    (tmp_path / "target").write_text("elsewhere")
    places = [tmp_path / name for name in "abcd"]
    places[0].write_text("old")
    places[1].symlink_to("target")
    places[3].write_text("old")

    def refuse(*_: object, **__: object) -> None:
        raise OSError("no hard links")

    if not links:
        monkeypatch.setattr(os, "link", refuse)
    fail_replacing(monkeypatch, lambda _, place: place.name == held)
    with pytest.raises(PermissionError, match="held by another program"):
        write_together(places)
    assert read_all(tmp_path) == {"a": "old", "b": "elsewhere", "d": "old", "target": "elsewhere"}
    assert places[1].is_symlink()


def test_what_cannot_be_put_back_is_kept_and_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    places = [tmp_path / name for name in "abc"]
    for place in places:
        place.write_text(f"old {place.name}")
    fail_replacing(monkeypatch, lambda source, place: place.name == "c" or source == source.parent.parent / "old" / "a")
    with pytest.raises(OSError, match="a cannot be put back; what stood there is kept in") as refusal:
        write_together(places)
    (kept,) = (path for path in tmp_path.iterdir() if path.is_dir())
    assert str(kept / "old") in str(refusal.value.strerror)
    assert refusal.value.filename == str(tmp_path)
    assert (kept / "old" / "a").read_text() == "old a"
    assert [place.read_text() for place in places] == ["new", "old b", "old c"]


def test_no_name_is_without_a_file_while_files_are_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    places = [tmp_path / name for name in "ab"]
    for place in places:
        place.write_text("old")
    seen = []

    def look(*_: Path) -> bool:
        seen.append([place.read_text() for place in places])
        return False

    fail_replacing(monkeypatch, look)
    write_together(places)
    assert seen == [["old", "old"], ["new", "old"]]
    assert read_all(tmp_path) == {"a": "new", "b": "new"}


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
