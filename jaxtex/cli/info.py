"""`jaxtex info`: print a model file."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

if TYPE_CHECKING:
    from collections.abc import Mapping

    from jaxtex.models.files import ModelFile, TilingFile
    from jaxtex.models.floor_files import FloorFile
    from jaxtex.models.mixture_files import MixtureFile
    from jaxtex.models.wood_files import WoodFile

_LONGEST_LIST = 4  # entries shown in full
_ASSUMED = "not seen"  # for the error of a parameter that the photograph does not tell
_HELD = "held"  # likewise, of one that the user held
_WIDE = 110  # characters: room for what the parameters mean


@dataclass(frozen=True)
class Info:
    """Print a model file, of a tiling or of wood: its parameters with their errors and where the fit began, and how the
    fit went. What the photograph does not tell has "not seen" for an error. Of a mixture, print what it is made of.

    Example: jaxtex info fitted/model.json
    """

    model: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="MODEL")]
    """The model file (model.json)."""

    def run(self) -> int:
        from rich.console import Console

        from jaxtex.models.files import load_any
        from jaxtex.models.mixture_files import MixtureFile

        file = load_any(self.model)
        console = Console(highlight=False, markup=False)
        if isinstance(file, MixtureFile):
            for line in _mixture_lines(self.model, file):
                console.print(line)
            return 0
        for line in _headlines(self.model, file):
            console.print(line)
        console.print(_table(file, meaning=console.width >= _WIDE))
        return 0


def _mixture_lines(path: Path, file: "MixtureFile") -> list[str]:
    """What a mixture is made of, from below; the parts' own parameters are in their files."""
    from jaxtex.models.mixture_files import ModelLayer

    lines = [f"{path}: a mixture", f"base: {file.base}"]
    if file.wood is not None:
        lines.append(f"wood in its tiles: {file.wood.model}, {file.wood.scale:g} times as large as photographed")
    for layer in file.layers:
        if isinstance(layer, ModelLayer):
            scale = "" if layer.scale == 1 else f", {layer.scale:g} times as large as photographed"
            lines.append(f"layer where {layer.mask} is white: {layer.model}{scale}")
        else:
            lines.append(f"kept where {layer.mask} is white: {layer.photograph}")
    return [*lines, *_written_by(file.versions)]


def _written_by(versions: "Mapping[str, str] | None") -> list[str]:
    listed = ", ".join(f"{name} {version}" for name, version in (versions or {}).items())
    return [f"written by {listed}"] if listed else []


def _headlines(path: Path, file: "ModelFile") -> list[str]:
    from jaxtex.models.files import TilingFile
    from jaxtex.models.floor_files import FloorFile

    report, (width, height, sha256) = file.report, file.image
    tiling = file if isinstance(file, TilingFile) else None
    floor = file if isinstance(file, FloorFile) else None
    kind = "wood" if floor is None else f"a floor of {len(floor.planks)} planks"
    lines = [
        f"{path}: {kind if tiling is None else f'a tiling in {tiling.tiling.bond} bond'}",
        f"photograph: {width} x {height} pixels, sha256 {sha256[:16]}...",
        ": ".join(part for part in ("fit", "ok" if report["ok"] else "not ok", report["reason"]) if part),
    ]
    if report["iou"] is not None:
        compared = "early wood with that" if tiling is None else "joints with those"
        lines.append(f"overlap of its {compared} seen: {100 * report['iou']:.1f} %")
    if tiling is not None:
        lines += _appearance_lines(tiling)
    if file.seed is not None:
        lines.append(f"seed: {file.seed}")
    return lines + _written_by(file.versions)


def _appearance_lines(file: "TilingFile") -> list[str]:
    if file.appearance is None:
        return []
    plain = {name: _show(value) for name, value in file.appearance.items() if not isinstance(value, list)}
    told = [*(f"{name} {value}" for name, value in plain.items()), f"{len(file.appearance.get('tiles', []))} courses"]
    return [f"appearance (to be edited in the file): {', '.join(told)}"]


def _table(file: "ModelFile", *, meaning: bool) -> Any:
    from jaxtex.models.floor_files import FloorFile

    return _plank_table(file) if isinstance(file, FloorFile) else _parameter_table(file, meaning=meaning)


def _plank_table(file: "FloorFile") -> Any:
    """A line to each plank."""
    import math

    from rich.table import Table

    table = Table("plank", "middle", "rings apart", "across the grain", "wood read off it", box=None, pad_edge=False)
    for number, plank in enumerate(file.planks):
        x, y = plank.corners.mean(axis=0)
        across = f"{math.degrees(float(plank.wood.rotation)):.0f} degrees"
        spacing = _show(float(plank.wood.ring_spacing), 3)
        table.add_row(str(number), f"{x:.0f} {y:.0f}", spacing, across, "yes" if plank.own else "no")
    return table


def _parameter_table(file: "TilingFile | WoodFile", *, meaning: bool) -> Any:
    from rich.table import Table

    from jaxtex.models.files import TilingFile

    errors, start = file.report["standard_errors"], file.report["start"] or {}
    determined = {} if isinstance(file, TilingFile) else file.determined
    held = file.report.get("held") or ()
    table = Table("parameter", "value", "±", *(["start"] if start else []), box=None, pad_edge=False)
    for column in table.columns:
        column.no_wrap = True
    if meaning:
        table.add_column("meaning")
    for name, (value, title) in _list_parameters(file).items():
        error = _show(errors.get(name), digits=2) if determined.get(name, True) else _ASSUMED
        started = [_show(start.get(name))] if start else []
        table.add_row(name, _show(value), _HELD if name in held else error, *started, *([title] if meaning else []))
    return table


def _list_parameters(file: "TilingFile | WoodFile") -> dict[str, tuple[Any, str]]:
    """Values, and what the schema says about them."""
    from jaxtex.models.files import TilingFile, tiling_parameters, tiling_schema
    from jaxtex.models.wood_files import list_parameters

    if not isinstance(file, TilingFile):
        return list_parameters(file.wood)
    described = tiling_schema()["$defs"]["parameters"]["properties"]
    values = tiling_parameters(file.tiling, rows=file.rows, columns=file.columns, mm_per_px=file.mm_per_px)
    return {name: (value, described[name]["title"]) for name, value in values.items()}


def _show(value: Any, digits: int = 6) -> str:
    """A parameter in few digits; rows of a matrix on lines of their own."""
    if value is None:
        return ""
    if isinstance(value, list):
        if len(value) > _LONGEST_LIST:
            return f"{_show(value[:2], 3)} ... ({len(value)})"
        between = "\n" if any(isinstance(item, list) for item in value) else " "
        return between.join(_show(item, min(digits, 5)) or "-" for item in value)
    return f"{value:.{digits}g}" if isinstance(value, float) else str(value)
