"""Progress bars: seen by a person who waits, by nobody else."""

import contextlib
import io

import pytest

from jaxtex.cli import progress as module
from jaxtex.cli.progress import progress, reporting


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_items_pass_through_in_order() -> None:
    assert list(progress("oak", "sawing")) == ["o", "a", "k"]
    assert list(progress(iter(range(3)), "sawing", total=3)) == [0, 1, 2]


def test_silent_where_nobody_looks(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(module, "PATIENCE", 0.0)
    list(progress(range(3), "sawing"))
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(("patience", "shown"), [(0.0, True), (60.0, False)])
def test_shown_only_to_who_waits(monkeypatch: pytest.MonkeyPatch, patience: float, shown: bool) -> None:
    monkeypatch.setattr(module, "PATIENCE", patience)
    monkeypatch.setenv("TERM", "xterm")
    with contextlib.redirect_stderr(Terminal()) as terminal:
        assert list(progress(range(4), "sawing")) == [0, 1, 2, 3]
    assert ("sawing" in terminal.getvalue()) == shown


def saw_until_interrupted() -> None:
    with reporting("sawing") as report:
        report(1, None)
        raise KeyboardInterrupt


def test_the_terminal_is_given_back_when_the_work_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "PATIENCE", 0.0)
    monkeypatch.setenv("TERM", "xterm")
    with contextlib.redirect_stderr(Terminal()) as terminal, pytest.raises(KeyboardInterrupt):
        saw_until_interrupted()
    hidden, back = terminal.getvalue().rfind("\x1b[?25l"), terminal.getvalue().rfind("\x1b[?25h")
    assert 0 <= hidden < back  # the cursor
