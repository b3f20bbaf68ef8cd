"""Reading a command's options with tyro, with its boxed complaints turned into one line each."""

import contextlib
import io
import re
from collections.abc import Iterator, Sequence
from typing import TypeVar

OptionsT = TypeVar("OptionsT")

_COLOUR = re.compile(r"\x1b\[[0-9;]*m")


class UsageError(Exception):
    """The words on the command line do not make a command."""


def parse(options: type[OptionsT], *, prog: str, arguments: Sequence[str]) -> OptionsT | None:
    """Fill the dataclass `options` from command-line words; None where help was asked for (and is printed).

    Args:
        options: a dataclass; its docstring and field docstrings become the help text.
        prog: how the command is called, for the help text: "jaxtex render".
        arguments: the words that follow.

    Raises:
        UsageError: one line that says which word is wrong and where help is.

    Examples:
        >>> from dataclasses import dataclass
        >>> @dataclass
        ... class Greet:
        ...     name: str
        >>> parse(Greet, prog="greet", arguments=["--name", "oak"])
        Greet(name='oak')
    """
    import tyro

    complaint = io.StringIO()
    try:
        with contextlib.redirect_stderr(complaint):
            return tyro.cli(options, prog=prog, args=list(arguments))
    except SystemExit as stop:
        if not stop.code:
            return None
        raise UsageError(f"{_in_one_line(complaint.getvalue())} (see {prog} --help)") from None


def _in_one_line(boxed: str) -> str:
    """What a box on the terminal says, without its frame, its footer and the help texts it repeats."""
    sections: list[list[str]] = [[]]
    for line in _unframed(boxed):
        if set(line) <= set("─-"):
            sections.append([])
        else:
            sections[-1].append(line)
    problem, *others = sections
    said = " ".join(" ".join(_without_help_texts(problem)).split()).rstrip(". ")
    for other in others:
        if other[:1] == ["Perhaps you meant:"] and len(other) > 1:
            said += f"; perhaps you meant {other[1].strip()}"
    return said[:1].lower() + said[1:]


def _unframed(boxed: str) -> Iterator[str]:
    for line in _COLOUR.sub("", boxed).splitlines():
        if line and line[0] not in "╭╰+":
            yield line.strip("│|").removeprefix(" ").rstrip()


def _without_help_texts(lines: list[str]) -> Iterator[str]:
    """Option names stand four columns in, what is said about them eight."""
    return (line for line in lines if not line.startswith(" " * 8))
