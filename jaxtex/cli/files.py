"""Files of one command: none written over another, and all of them written or none."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path


def write_together(writers: Mapping[Path, Callable[[Path], None]]) -> None:
    """Write several files under temporary names; only when all are whole do they get their own.

    Args:
        writers: for each file, what writes it to a path.

    Raises:
        InputError: one of them cannot be written.

    Examples:
        >>> write_together({Path("a.txt"): lambda path: path.write_text("a"), Path("b.txt"): Path.touch})
        >>> Path("a.txt").read_text(), Path("b.txt").exists()
        ('a', True)
    """
    from jaxtex.core.errors import InputError
    from jaxtex.io.files import replacing

    with ExitStack() as files:
        for path, write in writers.items():
            temporary = files.enter_context(replacing(path))
            try:
                write(temporary)
            except InputError as error:
                raise InputError(str(error).replace(str(temporary), str(path))) from None


def check_names(inputs: Sequence[Path | None], outputs: Sequence[Path | None], *, keys: Path | None = None) -> None:
    """Refuse to write over what is read, to write two things to one file, or to where no file can be; before work that
    takes long.

    Args:
        inputs, outputs: files; None where an option is not given.
        keys: a file of keys among the inputs, with the pictures that it names.

    Raises:
        InputError: that is so, or the keys cannot be read.
    """
    from jaxtex.core.errors import InputError
    from jaxtex.io.files import place_for_file
    from jaxtex.progressive.key_files import list_maps

    maps = [] if keys is None else [keys, *list_maps(keys)]
    read = {each.resolve() for each in (*inputs, *maps) if each is not None}
    written: set[Path] = set()
    for output in outputs:
        if output is not None:
            place_for_file(output)
            if output.resolve() in read | written:
                raise InputError(f"{output}: would be written over; give another name")
            written.add(output.resolve())
