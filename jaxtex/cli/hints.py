"""Hints: what a command that goes on anyway tells its user."""

import sys


def hint(told: str) -> None:
    """Say one line on stderr, where it is in nobody's way who reads what was made from stdout.

    Examples:
        >>> hint("mask.png has 2 pinholes")  # on stderr: jaxtex: hint: mask.png has 2 pinholes
    """
    print(f"jaxtex: hint: {told}", file=sys.stderr)
