"""Khronos' glTF validator, where it is installed: `npm install --no-save --prefix .venv gltf-validator`."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

SCRIPT = Path(__file__).parent / "validate_gltf.cjs"
ERROR, WARNING, INFORMATION, HINT = range(4)
"""How grave an issue is, as reports number it."""


def find_validator() -> Path | None:
    """The folder of the npm package, if there is Node to run it: in $GLTF_VALIDATOR, or beside the environment."""
    named = os.environ.get("GLTF_VALIDATOR")
    package = Path(named) if named else Path(sys.prefix) / "node_modules" / "gltf-validator"
    return package.resolve() if shutil.which("node") and (package / "package.json").exists() else None


def validate(path: Path) -> dict[str, Any]:
    """The validator's report on a file; its `issues` has `messages` with `code`, `severity`, `pointer`."""
    package = find_validator()
    assert package, "there is no validator"
    words = ["node", str(SCRIPT), str(package), str(path)]
    report: dict[str, Any] = json.loads(subprocess.run(words, check=True, capture_output=True).stdout)
    return report


def complaints(report: dict[str, Any]) -> list[str]:
    """Errors and warnings of a report, one a line."""
    issues = report["issues"]["messages"]
    return [f"{each['code']} {each.get('pointer')}" for each in issues if each["severity"] <= WARNING]
