"""What the documents say about the tree is true."""

import re
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


def test_the_commands_in_the_readme_are_there() -> None:
    from jaxtex.cli.main import COMMANDS

    shown = set(
        re.findall(r"^    jaxtex (\w[\w-]*(?: tiling| wood)?)", (ROOT / "README.md").read_text(encoding="utf-8"), re.M)
    )
    assert {"fit tiling", "fit wood", "render", "info", "demo"} <= shown
    assert shown <= {command.words for command in COMMANDS} | {command.words.split()[0] for command in COMMANDS}
