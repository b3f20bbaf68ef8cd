"""Several files written by one command: all of them or none."""

from collections.abc import Callable, Mapping
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
