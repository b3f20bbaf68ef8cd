"""What the documents and the commands' help say about the tree is true."""

import inspect
import re
import shlex
from importlib import import_module
from pathlib import Path

import pytest

from jaxtex.cli.main import COMMANDS, Command, main
from jaxtex.cli.usage import parse

ROOT = Path(__file__).parents[1]
DOCUMENTS = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("models/*.md")])


def test_the_table_of_modules_is_complete() -> None:
    table = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    told = {name for line in table.splitlines() if line.startswith("| `") for name in re.findall("`([a-z_.]+)`", line)}
    modules = {path.relative_to(ROOT / "jaxtex").with_suffix("") for path in (ROOT / "jaxtex").glob("*/*.py")}
    names = {".".join(module.parts) for module in modules if module.name != "__init__"}
    assert names - told == set()
    assert {name for name in told if name.count(".") == 1 and not name.startswith("jaxtex")} - names == set()


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_links_between_documents_lead_somewhere(document: Path) -> None:
    links = re.findall(r"\]\(([^)#]+)", document.read_text(encoding="utf-8"))
    assert [link for link in links if "//" not in link and not (document.parent / link).exists()] == []


def find_command(words: list[str]) -> Command:
    return next(each for each in COMMANDS if words[: each.words.count(" ") + 1] == each.words.split())


def options_of(command: Command) -> type:
    module, _, name = command.target.partition(":")
    return getattr(import_module(module), name)


def can_be_given(command: Command, words: list[str]) -> bool:
    return parse(options_of(command), prog=command.words, arguments=words[command.words.count(" ") + 1 :]) is not None


def test_the_commands_in_the_readme_can_be_given() -> None:
    lines = re.findall(r"^    jaxtex (.+)", (ROOT / "README.md").read_text(encoding="utf-8"), re.M)
    shown = set()
    for words in (shlex.split(line, comments=True) for line in lines):
        if words[1:] == ["--help"]:
            assert words[0] in {each.words.split()[0] for each in COMMANDS}
            continue
        command = find_command(words)
        assert can_be_given(command, words)
        shown.add(command.words)
    assert {"fit tiling", "fit wood", "render", "info", "demo"} <= shown
    assert {"vary distort", "vary warp", "vary blend"} <= shown


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command.words)
def test_the_examples_in_a_command_s_help_can_be_given(command: Command) -> None:
    """Each is a line of its own, and of that command."""
    examples = re.findall(r"^Example: (.+)$", inspect.getdoc(options_of(command)) or "", re.M)
    assert examples
    for example in examples:
        program, *words = shlex.split(example)
        assert program == "jaxtex"
        assert find_command(words) == command
        assert can_be_given(command, words)


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command.words)
def test_help_tells_no_default_or_choice_that_is_nothing(command: Command, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*command.words.split(), "--help"]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "default: )" not in shown
    assert "{None" not in shown
