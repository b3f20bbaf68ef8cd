"""Files appear whole or not at all, and folders are checked before work starts."""

import errno
import os
import secrets
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from jaxtex.core.errors import InputError


@contextmanager
def replacing(path: Path | str) -> Iterator[Path]:
    """A temporary name beside `path` to write to; it takes the place of `path` when the block ends without error.

    Whatever stood at `path` stays until then, and stays for good if the block fails or is interrupted. The temporary
    name has the same extension, since writers choose their format by it.

    Args:
        path: the file to make or replace; its folder must exist.

    Raises:
        InputError: the folder does not exist, or `path` is itself a folder.

    Examples:
        >>> with replacing("notes.txt") as temporary:
        ...     _ = temporary.write_text("oak, pine")
    """
    path = place_for_file(path)
    temporary = path.with_name(f".{path.stem[:100]}.{secrets.token_hex(4)}{path.suffix}")
    try:
        yield temporary
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def replacing_together(paths: Sequence[Path | str]) -> Iterator[list[Path]]:
    """Temporary names for files of one folder that belong together; they take their places when the block ends without
    error, all or none.

    What stood there stays until then, and is put back if a file cannot take its place; at no moment is a name without a
    file that had one. The names are the same, in a folder of their own beside.

    Args:
        paths: the files to make or replace, at least one; their folder must exist.

    Raises:
        InputError: as `replacing`.
        FileNotFoundError: the block ended without writing one of them; none is replaced.
        OSError: a file cannot take its place. If one cannot be put back then either, what stood there is kept in the
            folder that the error names.

    Examples:
        >>> with replacing_together(["oak.raw", "oak.nhdr"]) as (numbers, header):
        ...     _ = numbers.write_bytes(bytes(4)), header.write_text("NRRD0004")
    """
    places = [place_for_file(path) for path in paths]
    folder = Path(tempfile.mkdtemp(prefix=f".{places[0].stem[:100]}.", dir=places[0].parent))
    new, old = folder / "new", folder / "old"
    is_needed = False  # the folder, as it holds files that are nowhere else
    try:
        new.mkdir()
        old.mkdir()
        yield [new / place.name for place in places]
        for place in places:
            if not (new / place.name).exists():
                raise FileNotFoundError(f"{place}: was not written")
        for place in places:
            _copy_if_any(place, old / place.name)
        is_needed = True
        try:
            for place in places:
                os.replace(new / place.name, place)
        except BaseException as problem:
            # Those whose new file is gone, and no others, were replaced; an interrupt may come right after that.
            replaced = [place for place in places if not (new / place.name).exists()]
            _put_back(replaced, old, problem)
            is_needed = False
            raise
        is_needed = False
    finally:
        if not is_needed:
            shutil.rmtree(folder, ignore_errors=True)


def _copy_if_any(place: Path, copy: Path) -> None:
    """A second name for the file at `place` itself, or where there are no hard links, a copy."""
    if not os.path.lexists(place):
        return
    try:
        os.link(place, copy, follow_symlinks=False)
    except OSError:
        shutil.copy2(place, copy, follow_symlinks=False)


def _put_back(places: Sequence[Path], old: Path, problem: BaseException) -> None:
    """Undo what replaced these files.

    Raises:
        OSError: some cannot be put back; the others are.
    """
    lost = []
    for place in places:
        try:
            if os.path.lexists(old / place.name):
                os.replace(old / place.name, place)
            else:
                place.unlink(missing_ok=True)
        except OSError:
            lost.append(place)
    if lost:
        names = ", ".join(place.name for place in lost)
        told = f"files cannot be replaced, and {names} cannot be put back; what stood there is kept in {old}"
        raise OSError(getattr(problem, "errno", None) or errno.EIO, told, str(places[0].parent)) from problem


def place_for_file(path: Path | str) -> Path:
    """`path` as a `Path`, once it is known that a file can stand there; for work that takes long before it writes.

    Raises:
        InputError: its folder does not exist, or `path` is itself a folder.
    """
    path = Path(path)
    if path.is_dir():
        raise InputError(f"{path}: is a folder; name a file to write")
    if not path.parent.is_dir():
        raise InputError(f"{path}: cannot be written, as there is no folder {path.parent}; make it first")
    return path


def atomic_write_bytes(path: Path | str, data: bytes) -> None:
    """Write `data` to the file `path`, whole or not at all.

    Raises:
        InputError: as `replacing`.
        OSError: the file cannot be written (no permission, no space).
    """
    with replacing(path) as temporary:
        temporary.write_bytes(data)


def atomic_write_text(path: Path | str, text: str) -> None:
    """Write `text` to the file `path` in UTF-8 with its line ends as they are, whole or not at all.

    Raises:
        InputError: as `replacing`.
        OSError: the file cannot be written (no permission, no space).
    """
    atomic_write_bytes(path, text.encode("utf-8"))


def prepare_folder(folder: Path | str) -> Path:
    """Make `folder` and the folders above it where they do not exist, before any work whose results go there.

    Returns:
        The folder as a `Path`.

    Raises:
        InputError: something else has that name, or the folder cannot be made or written to.
    """
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError):
        raise InputError(f"{folder}: is (or stands below) a file; name a folder for the results") from None
    except OSError as error:
        raise InputError(f"{folder}: this folder cannot be made ({error.strerror})") from None
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"{folder}: nothing can be written to this folder (permission denied)")
    return folder


def existing_file(path: Path | str) -> Path:
    """`path` as a `Path`, once it is known to be a file that can be read and holds something.

    Raises:
        InputError: there is no such file, it is a folder, it is empty, or it may not be read.
    """
    path = Path(path)
    try:
        if path.is_dir():
            raise InputError(f"{path}: is a folder; name a file")
        if not path.exists():
            raise InputError(f"{path}: there is no such file")
        if path.is_file() and path.stat().st_size == 0:
            raise InputError(f"{path}: is empty (0 bytes)")
        with path.open("rb"):
            return path
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
