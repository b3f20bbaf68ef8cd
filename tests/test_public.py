"""The flat public interface: complete, documented, and free of JAX until it is used."""

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import jaxtex

NAMES = [name for name in jaxtex.__all__ if name != "__version__"]


@pytest.mark.parametrize("name", NAMES)
def test_every_public_name_exists_and_says_what_it_is(name: str) -> None:
    value = getattr(jaxtex, name)
    assert inspect.getdoc(value), f"jaxtex.{name} has no docstring"
    assert value.__module__.startswith("jaxtex.")
    assert name in dir(jaxtex)


def test_type_checkers_see_the_same_names_from_the_same_modules() -> None:
    tree = ast.parse(Path(inspect.getfile(jaxtex)).read_text(encoding="utf-8"))
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    seen = {alias.asname: node.module for node in imports for alias in node.names if alias.asname}
    assert seen == jaxtex._PUBLIC


def test_unknown_names_are_refused() -> None:
    with pytest.raises(AttributeError, match="no attribute 'fit_everything'"):
        _ = jaxtex.fit_everything


@pytest.mark.parametrize(
    "statement",
    [
        "import jaxtex; dir(jaxtex)",
        "from jaxtex.cli.main import main; main(['--help'])",
        "import jaxtex; jaxtex.read_image, jaxtex.write_mask",
    ],
)
def test_jax_is_not_imported_before_it_is_needed(statement: str) -> None:
    code = f"{statement}\nimport sys; sys.exit('jax' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)
