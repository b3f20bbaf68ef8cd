"""Reading a command's options with tyro, with its boxed complaints turned into one line each."""

import contextlib
import io
import re
import textwrap
from collections.abc import Sequence
from typing import TypeVar

OptionsT = TypeVar("OptionsT")

_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_RULE = set("─-╭╮╰╯")


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
            return tyro.cli(options, prog=prog, args=list(arguments), config=(tyro.conf.DisallowNone,))
    except SystemExit as stop:
        if not stop.code:
            return None
        raise UsageError(f"{_in_one_line(complaint.getvalue())} (see {prog} --help)") from None


def _in_one_line(boxed: str) -> str:
    """What a box on the terminal says, without its title, its footer and the help texts it repeats."""
    sections: list[list[str]] = [[]]
    for line in _COLOUR.sub("", boxed).splitlines()[1:]:
        inside = line.strip("│").rstrip()
        if set(inside.strip()) <= _RULE:
            sections.append([])
        else:
            sections[-1].append(inside)
    problem, *others = ([section for section in map(_outdented, sections) if section]) or [["cannot be read"]]
    # Option names stand four columns in, and what is said about them eight.
    said = " ".join(line.strip() for line in problem if not line.startswith(" " * 8)).rstrip(". ")
    for other in others:
        if other[0] == "Perhaps you meant:" and len(other) > 1:
            said += f"; perhaps you meant {other[1].strip()}"
    return said[:1].lower() + said[1:]


def _outdented(lines: list[str]) -> list[str]:
    return textwrap.dedent("\n".join(lines)).splitlines()
