"""What the documents say about the tree is true."""

import re
import shlex
from importlib import import_module
from pathlib import Path

import pytest

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


def test_the_commands_in_the_readme_can_be_given() -> None:
    from jaxtex.cli.main import COMMANDS
    from jaxtex.cli.usage import parse

    lines = re.findall(r"^    jaxtex (.+)", (ROOT / "README.md").read_text(encoding="utf-8"), re.M)
    shown = set()
    for words in (shlex.split(line, comments=True) for line in lines):
        if words[1:] == ["--help"]:
            assert words[0] in {each.words.split()[0] for each in COMMANDS}
            continue
        command = next(each for each in COMMANDS if words[: each.words.count(" ") + 1] == each.words.split())
        module, _, name = command.target.partition(":")
        arguments = words[command.words.count(" ") + 1 :]
        assert parse(getattr(import_module(module), name), prog=command.words, arguments=arguments) is not None
        shown.add(command.words)
    assert {"fit tiling", "fit wood", "render", "info", "demo"} <= shown
    assert {"vary distort", "vary warp", "vary blend"} <= shown
