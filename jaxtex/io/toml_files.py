"""Files that people write by hand, as TOML, and what is wrong with them."""

import difflib
import math
import tomllib
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from jaxtex.core.errors import InputError
from jaxtex.io.files import existing_file

_MOST = 2**63  # whole numbers that TOML has are less


def read_toml(path: Path | str, what: str) -> dict[str, Any]:
    """Read a TOML file.

    Args:
        path: the file.
        what: it should be, as "a file of keys (keys.toml)".

    Raises:
        InputError: there is no such file, it is no TOML, or has whole numbers of more bits than TOML's.

    Examples:
        >>> _ = Path("keys.toml").write_text("[[scale]]\\nvalue = 2\\n")
        >>> read_toml("keys.toml", "a file of keys")
        {'scale': [{'value': 2}]}
    """
    path = existing_file(path)
    try:
        document = tomllib.loads(path.read_bytes().decode("utf-8-sig"))  # some editors write a byte order mark first
    except UnicodeDecodeError:
        raise InputError(f"{path}: is not a text file; give {what}") from None
    except ValueError as error:  # TOMLDecodeError, or an integer of thousands of digits
        raise InputError(f"{path}: is no TOML ({error}); correct it there") from None
    except RecursionError:
        raise InputError(f"{path}: has brackets too deep in each other; correct it there") from None
    # Python reads hexadecimal digits by the thousand, and then cannot say the number that they make.
    for name, entry in document.items():
        if any(type(each) is int and not -_MOST <= each < _MOST for each in _values_in(entry)):
            raise InputError(f"{path}: {name}: holds a whole number of more than 64 bits; give a smaller one")
    return document


def _values_in(entry: Any) -> Iterator[Any]:
    """All values in an entry, in its lists and tables too."""
    waiting = [entry]
    while waiting:
        value = waiting.pop()
        yield value
        if isinstance(value, dict | list):
            waiting.extend(value.values() if isinstance(value, dict) else value)


def tables_of(document: Mapping[str, Any], name: str, path: Path | str, what: str) -> list[dict[str, Any]]:
    """The tables [[name]] of a file; none where it has none.

    Args:
        document: as read.
        name: of the tables.
        path: of the file, for the message.
        what: each of them is, as "key".

    Raises:
        InputError: something else has that name.

    Examples:
        >>> tables_of({"scale": [{"value": 2}]}, "scale", "keys.toml", "key")
        [{'value': 2}]
    """
    tables = document.get(name, [])
    if not isinstance(tables, list) or not all(isinstance(each, dict) for each in tables):
        raise InputError(f"{path}: {name}: write [[{name}]] above each {what}")
    return tables


def check_names(where: str, table: Mapping[str, Any], known: Collection[str]) -> None:
    """Refuse entries that nothing is made of.

    Args:
        where: the table stands, for the message.
        table: its entries.
        known: names that there may be.

    Raises:
        InputError: there is another one; a name that is like it is told.

    Examples:
        >>> check_names("keys.toml", {"scael": 2}, {"scale", "value"})
        Traceback (most recent call last):
        jaxtex.core.errors.InputError: keys.toml: scael is not known; did you mean scale?
    """
    for name in table:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"known are {', '.join(sorted(known))}"
            raise InputError(f"{where}: {name} is not known; {hint}")


def is_number(value: Any) -> bool:
    """Whether an entry is a finite number, and no integer beyond what floating-point numbers hold.

    Examples:
        >>> is_number(2), is_number(True), is_number(math.inf), is_number(10**400)
        (True, False, False, False)
    """
    if not isinstance(value, int | float) or isinstance(value, bool):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:
        return False
