"""`jaxtex info`: print a model file."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

if TYPE_CHECKING:
    from jaxtex.models.files import TilingFile


@dataclass(frozen=True)
class Info:
    """Print a model file: its parameters with their errors and where the fit began, and how the fit went.

    Example: jaxtex info fitted/model.json
    """

    model: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="MODEL")]
    """The model file (model.json)."""

    def run(self) -> int:
        from rich.console import Console

        from jaxtex.models.files import load_model

        file = load_model(self.model)
        console = Console(highlight=False, markup=False)
        for line in _headlines(self.model, file):
            console.print(line)
        console.print(_parameter_table(file))
        return 0


def _headlines(path: Path, file: "TilingFile") -> list[str]:
    report, (width, height, sha256) = file.report, file.image
    lines = [
        f"{path}: a tiling in {file.tiling.bond} bond",
        f"photograph: {width} x {height} pixels, sha256 {sha256[:16]}...",
        f"fit: {'ok' if report['ok'] else 'not ok'}: {report['reason']}",
    ]
    if report["iou"] is not None:
        lines.append(f"overlap of its joints with those seen: {100 * report['iou']:.1f} %")
    if file.appearance is not None:
        lines.append(f"appearance: {', '.join(file.appearance) or 'none'}")
    if file.seed is not None:
        lines.append(f"seed: {file.seed}")
    if file.versions:
        lines.append("written by " + ", ".join(f"{name} {version}" for name, version in file.versions.items()))
    return lines


def _parameter_table(file: "TilingFile") -> Any:
    from rich.table import Table

    from jaxtex.models.files import tiling_parameters, tiling_schema

    described = tiling_schema()["$defs"]["parameters"]["properties"]
    values = tiling_parameters(file.tiling, rows=file.rows, columns=file.columns, mm_per_px=file.mm_per_px)
    errors, start = file.report["standard_errors"], file.report["start"] or {}
    table = Table("parameter", "value", "±", "start", "meaning", box=None, pad_edge=False)
    for column in table.columns[:-1]:
        column.no_wrap = True
    for name, value in values.items():
        started = _show(start.get(name))
        table.add_row(name, _show(value), _show(errors.get(name)), started, described[name]["title"])
    return table


def _show(value: Any) -> str:
    """A parameter in few digits; rows of a matrix on lines of their own."""
    if value is None:
        return ""
    if isinstance(value, list):
        between = "\n" if any(isinstance(item, list) for item in value) else " "
        return between.join(_show(item) or "-" for item in value)
    return f"{value:.6g}" if isinstance(value, float) else str(value)
