"""One page that shows a fit: how it lies on the photograph, its numbers, and what its material looks like.

The page is a single file with its pictures inside; it needs no network and no script.
"""

import base64
import html
import math
import shlex
import string
import tempfile
from collections.abc import Iterator, Mapping
from importlib import resources
from pathlib import Path
from typing import Any

import jax
import numpy as np
import numpy.typing as npt
from skimage.transform import resize_local_mean

from jaxtex.io.files import atomic_write_text
from jaxtex.io.images import Image, write_image
from jaxtex.material.appearance import Appearance, appearance_of
from jaxtex.material.diagram import draw_diagram
from jaxtex.material.maps import Maps, render_maps
from jaxtex.material.overlay import draw_overlay
from jaxtex.material.preview import shade_maps
from jaxtex.material.sheet import Sheet, lay_photographed_sheet
from jaxtex.models.files import TilingFile, tiling_parameters, tiling_schema

_LARGE, _SMALL = 1400, 900  # pixels of the longer side of pictures in the page
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
    page = resources.files("jaxtex.material").joinpath("report.html").read_text(encoding="utf-8")
    again = command or shlex.join(["jaxtex", "fit", "tiling", str(photo.path), "-o", str(path.parent)])
    model = shlex.quote(str(path.parent / "model.json"))
    values = {
        **_headline(photo, file),
        **_pictures(photo, np.asarray(mask, dtype=np.float32), file),
        **_palette(appearance_of(file)),
        "diagram": draw_diagram(file.tiling),
        "parameters": "".join(_parameter_rows(file)),
        "timings": "".join(_timing_rows(seconds)),
        "commands": "".join(
            f"<pre><code>{html.escape(line)}</code></pre>"
            for line in (again, f"jaxtex render {model} -o maps --size 4096x4096 --seamless")
        ),
        "footer": _footer(file),
    }
    atomic_write_text(path, string.Template(page).substitute(values))


def _headline(photo: Image, file: TilingFile) -> dict[str, str]:
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
    return {
        "title": html.escape(f"{photo.path.name}: fitted tiling"),
        "name": html.escape(photo.path.name),
        "kind": "good" if report["ok"] else "bad",
        "verdict": html.escape(verdict),
        "told": "" if report["ok"] else '<p class="lead">What follows is the best guess.</p>',
        "facts": "".join(f"<div><dt>{name}</dt><dd>{value}</dd></div>" for name, value in facts.items()),
        "width": str(photo.width),
        "height": str(photo.height),
        "aspect": f"{photo.width / photo.height:.4f}",
    }


def _pictures(photo: Image, mask: npt.NDArray[np.float32], file: TilingFile) -> dict[str, str]:
    """The page's pictures as data URIs."""
    small = _shrink(photo.pixels, _LARGE)
    overlay = _shrink(draw_overlay(photo.pixels, file.tiling), _LARGE)
    return {
        "photo": _data_uri(np.clip(small, 0, 1), "photo.jpg"),
        "overlay": _data_uri(np.clip(overlay, 0, 1), "overlay.jpg"),
        "mask": _data_uri(np.clip(_shrink(mask[..., None], _SMALL), 0, 1), "mask.png", data=True),
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
    lit = _render(near, appearance, _SMALL, file.seed)
    return {
        "material": _data_uri(_render(seen, appearance, _SMALL, file.seed).base_colour, "material.png"),
        "lamp": _data_uri(shade_maps(lit, pixel=near.width / lit.height.shape[1]), "lamp.jpg"),
    }


def _render(sheet: Sheet, appearance: Appearance, side: int, seed: int | None) -> Maps:
    """The maps of a sheet with square pixels, its longer side as long as told or as its tiles need."""
    scale = side / max(sheet.width, sheet.height)
    shortest = float(min(sheet.tiling.tile_width * np.min(sheet.tiling.course_lengths), sheet.tiling.tile_height))
    scale = max(scale, 4.5 / shortest)
    size = math.ceil(sheet.width * scale), math.ceil(sheet.height * scale)
    bands = render_maps(sheet, appearance, size=size, key=jax.random.key(seed or 0))
    return Maps(*(np.concatenate(part) for part in zip(*bands, strict=True)))


def _shrink(pixels: npt.NDArray[np.float32], side: int) -> npt.NDArray[np.float32]:
    height, width = pixels.shape[:2]
    scale = side / max(height, width)
    if scale >= 1:
        return pixels
    return resize_local_mean(pixels, (max(1, round(height * scale)), max(1, round(width * scale))), channel_axis=-1)


def _data_uri(pixels: npt.NDArray[np.float32], name: str, *, data: bool = False) -> str:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        write_image(path, pixels, colour_space="data" if data else "srgb")
        encoded = base64.b64encode(path.read_bytes()).decode("ascii")
    kind = "png" if path.suffix == ".png" else "jpeg"
    return f"data:image/{kind};base64,{encoded}"


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
    digits = 3 if error is None or error <= 0 else min(max(1 - math.floor(math.log10(error)), 0), 6)
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


def _timing_rows(seconds: Mapping[str, float]) -> Iterator[str]:
    for step, spent in seconds.items():
        yield f'<tr><td>{html.escape(step)}</td><td class="value">{spent:.2f}</td></tr>'


def _footer(file: TilingFile) -> str:
    versions = ", ".join(f"{name} {version}" for name, version in sorted((file.versions or {}).items()))
    parts = [f"Photograph sha256 {file.image.sha256}", f"seed {file.seed}" if file.seed is not None else "", versions]
    return html.escape(" · ".join(part for part in parts if part))
