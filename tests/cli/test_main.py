"""The shell of the command line: what it says, what it returns, and what it leaves alone."""

import dataclasses
import inspect
import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

from jaxtex.cli import main as shell
from jaxtex.cli.main import COMMANDS, Command, main
from jaxtex.core.errors import InputError


@dataclasses.dataclass(frozen=True)
class Try:
    """Do what a test asks for."""

    what: str = "nothing"
    """What to do."""
    times: int = 1
    """How often."""

    def run(self) -> int:
        match self.what:
            case "refuse":
                raise InputError("wall.png: holds\nno pixels")
            case "value error":
                raise ValueError("not raised by the library")
            case "interrupt":
                raise KeyboardInterrupt
            case "open":
                Path("/no/such/folder/file").read_text()
            case "fail":
                raise RuntimeError("a bug")
            case "unfitted":
                return 1
        sys.stdout.write(f"{self.what} {self.times}\n")
        return 0


@pytest.fixture(autouse=True)
def table(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Two commands of this module, so that the shell is tested alone."""
    monkeypatch.setitem(sys.modules, "try_commands", sys.modules[__name__])
    commands = (Command("do one", "try_commands:Try", "first"), Command("other", "try_commands:Try", "second"))
    monkeypatch.setattr(shell, "COMMANDS", commands)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(os, "environ", dict(os.environ))


def error_line(capsys: pytest.CaptureFixture[str]) -> str:
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("jaxtex: error: ")
    assert captured.err.endswith("\n")
    assert captured.err.count("\n") == 1
    return captured.err.removeprefix("jaxtex: error: ").strip()


def test_a_command_reads_its_options_and_runs(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["do", "one", "--what", "count", "--times", "3"]) == 0
    assert capsys.readouterr().out == "count 3\n"
    assert main(["other"]) == 0
    assert capsys.readouterr().out == "nothing 1\n"


def test_help_lists_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    told = capsys.readouterr().out
    assert "do one" in told
    assert "second" in told
    assert main(["do", "-h"]) == 0
    told = capsys.readouterr().out
    assert "do one" in told
    assert "second" not in told


def test_a_commands_own_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["do", "one", "--help"]) == 0
    captured = capsys.readouterr()
    assert "usage: jaxtex do one" in captured.out
    assert "How often." in captured.out
    assert captured.err == ""


def test_no_command_shows_the_help_and_is_an_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 2
    assert "commands:" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["othr"], "there is no command 'othr'; perhaps you meant 'other' (see jaxtex --help)"),
        (["--colour"], "there is no option '--colour' (see jaxtex --help)"),
        (["do"], "'do' needs one of its commands: do one (see jaxtex do --help)"),
        (["do", "two"], "'do' has no command 'two': do one (see jaxtex do --help)"),
        (["other", "--tims", "3"], "unrecognized options: --tims, 3; perhaps you meant --times INT"),
        (["other", "--times", "three"], "error parsing --times: invalid literal for int() with base 10: 'three'"),
        (["other", "--times"], "missing value for argument '--times'. Expected 1 values"),
        (["other", "more"], "unrecognized options: more"),
        (["other", "--what", "refuse"], "wall.png: holds no pixels"),
        (["other", "--what", "open"], "/no/such/folder/file: No such file or directory"),
    ],
)
def test_what_cannot_be_used_is_one_line_and_status_two(words, told, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(words) == 2
    line = error_line(capsys)
    assert line.startswith(told)
    assert line.endswith(("--help)", told))


@pytest.mark.parametrize(("columns", "encoding"), [("40", "ascii"), ("200", "utf-8")])
def test_usage_errors_read_the_same_on_every_terminal(columns: str, encoding: str) -> None:
    environment = {**os.environ, "COLUMNS": columns, "PYTHONIOENCODING": encoding}
    command = [sys.executable, "-m", "jaxtex", "info", "model.json", "--no-such-option"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "--no-such-option" in done.stderr


def test_a_fit_that_did_not_succeed_returns_its_status() -> None:
    assert main(["other", "--what", "unfitted"]) == 1


def test_interrupting_leaves_no_traceback(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["other", "--what", "interrupt"]) == 130
    assert capsys.readouterr().err == "jaxtex: interrupted\n"


@pytest.mark.parametrize(("what", "kind"), [("fail", RuntimeError), ("value error", ValueError)])
def test_bugs_keep_their_traceback(what: str, kind: type[Exception]) -> None:
    with pytest.raises(kind):
        main(["other", "--what", what])


def test_compiled_code_is_kept_in_the_users_cache(tmp_path: Path) -> None:
    os.environ.pop("JAX_COMPILATION_CACHE_DIR", None)
    main(["other"])
    assert os.environ["JAX_COMPILATION_CACHE_DIR"] == str(tmp_path / "jaxtex" / "xla")
    assert (tmp_path / "jaxtex" / "xla").is_dir()


def test_the_users_own_cache_is_respected(tmp_path: Path) -> None:
    os.environ["JAX_COMPILATION_CACHE_DIR"] = "elsewhere"
    main(["other"])
    assert os.environ["JAX_COMPILATION_CACHE_DIR"] == "elsewhere"
    assert not (tmp_path / "jaxtex").exists()


def test_the_users_own_level_of_logging_is_respected() -> None:
    os.environ.pop("TF_CPP_MIN_LOG_LEVEL", None)
    main(["other"])
    assert os.environ["TF_CPP_MIN_LOG_LEVEL"] == "3"
    os.environ["TF_CPP_MIN_LOG_LEVEL"] = "0"
    main(["other"])
    assert os.environ["TF_CPP_MIN_LOG_LEVEL"] == "0"


def test_a_cache_that_cannot_be_is_done_without(tmp_path: Path) -> None:
    os.environ.pop("JAX_COMPILATION_CACHE_DIR", None)
    (tmp_path / "jaxtex").write_text("a file where the folder should be")
    assert main(["other"]) == 0
    assert "JAX_COMPILATION_CACHE_DIR" not in os.environ


def test_a_reader_that_closes_the_pipe_is_no_error() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-m", "jaxtex", "--help"]
    done = subprocess.run(command, stdout=writing, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writing)
    assert (done.returncode, done.stderr) == (141, "")


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command.words)
def test_every_line_of_the_table_is_a_command(command: Command) -> None:
    module, _, name = command.target.partition(":")
    options = getattr(import_module(module), name)
    assert dataclasses.is_dataclass(options)
    assert options.__doc__
    assert list(inspect.signature(options.run).parameters) == ["self"]
    assert Path(inspect.getfile(options)).parent == Path(inspect.getfile(shell)).parent


def test_command_modules_are_light() -> None:
    """Importing all of them brings in none of the heavy libraries, so that help is quick."""
    modules = sorted({command.target.partition(":")[0] for command in COMMANDS})
    heavy = {"jax", "equinox", "optimistix", "skimage", "scipy", "trimesh"}
    code = f"import {', '.join(modules)}, sys; sys.exit(' '.join({heavy!r} & set(sys.modules)) or 0)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
