"""The page that shows a fitted tiling: how it lies on the photograph, its numbers, and what its material looks like."""

import html
import math
import shlex
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import jax
import numpy as np
import numpy.typing as npt

from jaxtex.io.images import Image
from jaxtex.material.appearance import Appearance, appearance_of
from jaxtex.material.diagram import draw_diagram
from jaxtex.material.maps import Maps, render_maps
from jaxtex.material.overlay import draw_overlay
from jaxtex.material.preview import shade_maps
from jaxtex.material.report_page import (
    LARGE,
    SMALL,
    Headline,
    Making,
    digits_for,
    embed_picture,
    fill_template,
    shrink_picture,
    write_page,
)
from jaxtex.material.sheet import Sheet, lay_photographed_sheet
from jaxtex.models.files import TilingFile, tiling_parameters, tiling_schema

_LAMP_COLUMNS = 4  # at most, in the picture under the lamp
_SWATCHES = 72
_LONG_LIST = 4  # entries; longer ones get a row to themselves


def write_report(
    path: Path | str,
    *,
    photo: Image,
    mask: npt.ArrayLike,
    file: TilingFile,
    seconds: Mapping[str, float],
    command: str | None = None,
) -> None:
    """Write the page of a fit, whole or not at all.

    Args:
        path: the file, as a rule report.html beside model.json.
        photo: the photograph that was fitted.
        mask: [row, col], 1 = tile, 0 = joint: what the fit was made on.
        file: the model file's content.
        seconds: spent on each step; times stand in this page only.
        command: the command that does it again; by default `jaxtex fit tiling` without options.

    Raises:
        InputError: the page cannot be written, or the file's appearance cannot be read.
    """
    path = Path(path)
    again = command or shlex.join(["jaxtex", "fit", "tiling", str(photo.path), "-o", str(path.parent)])
    model = shlex.quote(str(path.parent / "model.json"))
    values = {
        "width": str(photo.width),
        "height": str(photo.height),
        **_pictures(photo, np.asarray(mask, dtype=np.float32), file),
        **_palette(appearance_of(file)),
        "diagram": draw_diagram(file.tiling),
        "parameters": "".join(_parameter_rows(file)),
    }
    commands = (again, f"jaxtex render {model} -o maps --size 4096x4096 --seamless")
    write_page(
        path,
        photo=photo,
        file=file,
        headline=_headline(file),
        body=fill_template("report_tiling.html", values),
        making=Making("Again, and as maps of any size:", commands, seconds),
    )


def _headline(file: TilingFile) -> Headline:
    tiling, report = file.tiling, file.report
    verdict = f"A tiling in {tiling.bond} bond" if report["ok"] else f"No rectangular tiling: {report['reason']}"
    size = f"{float(tiling.tile_width):.1f} × {float(tiling.tile_height):.1f}"
    facts = {
        "tiles": f"{file.columns} × {file.rows}",
        "tile size": f"{size} <small>px</small>",
        "joints": f"{float(tiling.mortar_x):.3g} / {float(tiling.mortar_y):.3g} <small>px</small>",
        "direction of courses": f"{math.degrees(float(tiling.angle)):.2f}°",
        "offset": "course by course"
        if tiling.bond == "irregular"
        else f"{float(tiling.offset):.3f} <small>of a tile</small>",
    }
    if report.get("iou") is not None:
        facts["overlap with the mask"] = f"{100 * report['iou']:.0f} <small>%</small>"
    return Headline("tiling", verdict, facts)


def _pictures(photo: Image, mask: npt.NDArray[np.float32], file: TilingFile) -> dict[str, str]:
    """The page's pictures as data URIs."""
    overlay = shrink_picture(draw_overlay(photo.pixels, file.tiling), LARGE)
    return {
        "photo": embed_picture(shrink_picture(photo.pixels, LARGE), "photo.jpg"),
        "overlay": embed_picture(overlay, "overlay.jpg"),
        "mask": embed_picture(shrink_picture(mask[..., None], SMALL), "mask.png", data=True),
        **_material_pictures(file),
    }


def _material_pictures(file: TilingFile) -> dict[str, str]:
    appearance = appearance_of(file)
    seen = lay_photographed_sheet(file, pattern=appearance.pattern)
    # About as high as wide, with few tiles: relief is to be seen.
    columns = min(file.columns, _LAMP_COLUMNS)
    breadth = columns * float(np.mean(file.tiling.course_lengths) * file.tiling.tile_width)
    rows = min(file.rows, max(1, round(breadth / float(file.tiling.tile_height))))
    near = lay_photographed_sheet(file, tiles=(columns, rows), pattern=appearance.pattern)
    lit = _render(near, appearance, SMALL, file.seed)
    return {
        "material": embed_picture(_render(seen, appearance, SMALL, file.seed).base_colour, "material.png"),
        "lamp": embed_picture(shade_maps(lit, pixel=near.width / lit.height.shape[1]), "lamp.jpg"),
    }


def _render(sheet: Sheet, appearance: Appearance, side: int, seed: int | None) -> Maps:
    """The maps of a sheet with square pixels, its longer side as long as told or as its tiles need."""
    scale = side / max(sheet.width, sheet.height)
    shortest = float(min(sheet.tiling.tile_width * np.min(sheet.tiling.course_lengths), sheet.tiling.tile_height))
    scale = max(scale, 4.5 / shortest)
    size = math.ceil(sheet.width * scale), math.ceil(sheet.height * scale)
    bands = render_maps(sheet, appearance, size=size, key=jax.random.key(seed or 0))
    return Maps(*(np.concatenate(part) for part in zip(*bands, strict=True)))


def _palette(appearance: Appearance) -> dict[str, str]:
    """The tiles' colours from dark to light, evenly thinned, and the joints'."""
    described = appearance.to_json()
    colours = [colour for course in described["tiles"] for colour in course["colours"] if colour]
    colours.sort(
        key=lambda colour: sum(weight * int(colour[at : at + 2], 16) for weight, at in ((3, 1), (6, 3), (1, 5)))
    )
    step = max(1, math.ceil(len(colours) / _SWATCHES))
    chips = [f'<i style="background:{colour}" title="{colour}"></i>' for colour in colours[::step]]
    joint = f'<i class="joint" style="background:{described["joint"]}" title="joints {described["joint"]}"></i>'
    classes = 1 + max(map(max, appearance.pattern))
    repeat = f" They alternate between {classes} sorts." if classes > 1 else ""
    told = f"Of {len(colours)} tiles, from dark to light; the joints stand apart.{repeat}"
    return {"swatches": "".join([*chips, joint]), "palette": told}


def _parameter_rows(file: TilingFile) -> Iterator[str]:
    described = tiling_schema()["$defs"]["parameters"]["properties"]
    fitted = tiling_parameters(file.tiling, rows=file.rows, columns=file.columns, mm_per_px=file.mm_per_px)
    errors, start = file.report["standard_errors"], file.report["start"] or {}
    for name, value in fitted.items():
        if isinstance(value, list):
            yield _list_row(name, value, errors.get(name), start.get(name), described.get(name, {}))
        else:
            yield _number_row(name, value, errors.get(name), start.get(name), described.get(name, {}))


def _number_row(name: str, value: Any, error: float | None, start: Any, described: Mapping[str, Any]) -> str:
    if isinstance(value, str | int):
        return _row(name, value, None, start, None, described)
    digits = digits_for(error)
    change = f"{value - start:+.{digits}f}" if isinstance(start, int | float) else None
    began = f"{start:.{digits}f}" if isinstance(start, int | float) else None
    return _row(name, f"{value:.{digits}f}", None if error is None else f"{error:.2g}", began, change, described)


def _list_row(name: str, value: list[Any], error: Any, start: Any, described: Mapping[str, Any]) -> str:
    if name == "homography" and start == value and np.array_equal(value, np.eye(3)):
        return _row(name, "identity", None, "identity", None, described)
    if len(value) > _LONG_LIST:
        return f'<tr><td><code>{name}</code></td><td class="long" colspan="5">{_show(value)}</td></tr>'
    return _row(name, _show(value), _show(error), _show(start), None, described)


def _show(value: Any) -> str | None:
    """A list in few digits; rows of a matrix on lines of their own."""
    if value is None:
        return None
    if isinstance(value, list):
        between = "<br>" if any(isinstance(item, list) for item in value) else ", "
        return between.join(_show(item) or "–" for item in value)
    return f"{value:.4g}"


def _row(name: str, value: Any, error: Any, start: Any, change: Any, described: Mapping[str, Any]) -> str:
    meaning = html.escape(described.get("title", "")) + (f" ({_unit(name)})" if _unit(name) else "")
    cells = [f"<td><code>{name}</code></td>", f'<td class="value">{value}</td>']
    cells += [f"<td>{'' if cell is None else cell}</td>" for cell in (error, start, change)]
    return f'<tr>{"".join(cells)}<td class="meaning">{meaning}</td></tr>'


def _unit(name: str) -> str:
    return {
        "tile_width": "px",
        "tile_height": "px",
        "mortar_x": "px",
        "mortar_y": "px",
        "corner_radius": "px",
        "origin": "px",
        "angle_deg": "clockwise",
    }.get(name, "")
