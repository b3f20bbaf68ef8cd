"""Progress of long work on the terminal: shown on stderr, only to a person, only when the work takes a while."""

import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sized
from contextlib import contextmanager
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from rich.progress import Progress

ItemT = TypeVar("ItemT")

PATIENCE = 2.0  # seconds before a bar appears


def progress(items: Iterable[ItemT], what: str, *, total: int | None = None) -> Iterator[ItemT]:
    """Pass `items` on, one by one, with a bar for those already done.

    Args:
        items: what to work through; `range(n)` to count.
        what: what the work does, as a person would say it: "rendering maps".
        total: how many items there are, where `len(items)` does not tell.

    Examples:
        >>> sum(progress(range(4), "adding"))
        6
    """
    if total is None and isinstance(items, Sized):
        total = len(items)
    with reporting(what) as report:
        for done, item in enumerate(items):
            report(done, total)
            yield item


@contextmanager
def reporting(what: str) -> Iterator[Callable[[float, float | None], None]]:
    """A function `report(done, total)` to hand to long work that tells how far it is; the bar ends with the block.

    Args:
        what: what the work does.

    Examples:
        >>> with reporting("refining") as report:
        ...     report(3, 10)
    """
    bar = _Bar(what)
    try:
        yield bar.report
    finally:
        bar.close()


class _Bar:
    """A rich progress bar that is only built once there is someone to look at it and something to wait for."""

    def __init__(self, what: str) -> None:
        self._what = what
        self._start = time.monotonic()
        self._shown: Progress | None = None

    def report(self, done: float, total: float | None) -> None:
        if self._shown is None:
            if not sys.stderr.isatty() or time.monotonic() - self._start < PATIENCE:
                return
            self._shown = _rich_bar()
            self._shown.add_task(self._what, total=total)
            self._shown.start()
        self._shown.update(self._shown.task_ids[0], completed=done, total=total)

    def close(self) -> None:
        if self._shown is not None:
            self._shown.stop()


def _rich_bar() -> "Progress":
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:>3.0f} %"))
    return Progress(*columns, TimeRemainingColumn(), console=Console(stderr=True), transient=True)
