"""The page that shows fitted wood: how its rings lie on the photograph, its numbers, and the plank they make."""

import html
import shlex
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from jaxtex.core.colour import linear_to_srgb
from jaxtex.io.images import Image
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
from jaxtex.material.wood import render_wood
from jaxtex.models.wood_files import WoodFile, list_parameters, wood_parameters

END_GRAIN = 85.0
"""Degrees of tilt from which a plank is cut across the trunk, and its grain has no direction."""

_NOTES = {
    "center": "px",
    "ring_spacing": "px",
    "turbulence_rms": "px",
    "fibres.width": "px",
    "early_rgb": "shown in sRGB",
    "late_rgb": "shown in sRGB",
}


class WoodPictures(NamedTuple):
    """Drawings of a fit that the page shows.

    Attributes:
        mask: 1 = early wood, 0 = late wood, [row, col].
        overlay: early wood outlined over the photograph, linear light, [row, col, 3].
        rings: the rings drawn over the photograph, likewise.
    """

    mask: npt.NDArray
    overlay: npt.NDArray[np.float32]
    rings: npt.NDArray[np.float32]


def write_wood_report(
    path: Path | str,
    *,
    photo: Image,
    pictures: WoodPictures,
    file: WoodFile,
    seconds: Mapping[str, float],
    command: str | None = None,
) -> None:
    """Write the page of a fit of wood, whole or not at all.

    Args:
        path: the file, as a rule report.html beside model.json.
        photo: the photograph that was fitted.
        pictures: the fit, drawn.
        file: the model file's content. Parameters named by `held` in its report are shown as held by hand.
        seconds: spent on each step; times stand in this page only.
        command: the command that does it again; by default `jaxtex fit wood` without options.

    Raises:
        InputError: the page cannot be written.
    """
    path = Path(path)
    again = command or shlex.join(["jaxtex", "fit", "wood", str(photo.path), "-o", str(path.parent)])
    model = shlex.quote(str(path.parent / "model.json"))
    values = {
        "width": str(photo.width),
        "height": str(photo.height),
        **_embed(photo, pictures, file),
        "untold": _untold(file),
        "parameters": "".join(_parameter_rows(file)),
    }
    commands = (
        again,
        f"jaxtex render {model} -o maps --size 4096x4096",
        f"jaxtex render {model} -o block --block 256x256x256",
        f"jaxtex render {model} -o carved --mesh MESH.ply",
    )
    write_page(
        path,
        photo=photo,
        file=file,
        headline=_headline(file),
        body=fill_template("report_wood.html", values),
        making=Making("Again; as maps of any size; as a block of voxels; and carved as any mesh:", commands, seconds),
    )


def _headline(file: WoodFile) -> Headline:
    found, report = wood_parameters(file.wood), file.report
    spacing = f"{found['ring_spacing']:.1f}"
    along = "end grain" if found["tilt_deg"] > END_GRAIN else f"{(found['rotation_deg'] + 90) % 180:.1f}°"
    verdict = f"Wood, its rings {spacing} pixels apart" if report["ok"] else f"No one piece of wood: {report['reason']}"
    values = {
        "ring_spacing": ("ring spacing", f"{spacing} <small>px</small>"),
        "rotation_deg": ("direction of grain", along),
        "tilt_deg": ("tilt against the trunk", f"{found['tilt_deg']:.1f}°"),
        "early_fraction": ("early wood", f"{100 * found['early_fraction']:.0f} <small>%</small>"),
        "turbulence_rms": ("turbulence", f"{found['turbulence_rms']:.1f} <small>px</small>"),
    }
    doubt = " <small>not told</small>"
    facts = {
        title: value + ("" if file.determined.get(name, True) else doubt) for name, (title, value) in values.items()
    }
    if report.get("iou") is not None:
        facts["overlap with the mask"] = f"{100 * report['iou']:.0f} <small>%</small>"
    return Headline("wood", verdict, facts)


def _embed(photo: Image, pictures: WoodPictures, file: WoodFile) -> dict[str, str]:
    """The page's pictures as data URIs."""
    mask = np.asarray(pictures.mask, np.float32)[..., None]
    return {
        "photo": embed_picture(shrink_picture(photo.pixels, LARGE), "photo.jpg"),
        "overlay": embed_picture(shrink_picture(pictures.overlay, LARGE), "overlay.jpg"),
        "rings": embed_picture(shrink_picture(pictures.rings, LARGE), "rings.jpg"),
        "mask": embed_picture(shrink_picture(mask, SMALL), "mask.png", data=True),
        "plank": embed_picture(_render_plank(file), "plank.jpg"),
    }


def _render_plank(file: WoodFile) -> npt.NDArray[np.float32]:
    """What the photograph shows, rendered; its longer side at most as long as those of pictures in the page."""
    width, height = file.image.width, file.image.height
    scale = min(1.0, LARGE / max(width, height))
    size = max(1, round(width * scale)), max(1, round(height * scale))
    bands = render_wood(file.wood, across=width, size=size)
    return np.concatenate([band.base_colour for band in bands])


def _untold(file: WoodFile) -> str:
    names = [f"<code>{name}</code>" for name, told in file.determined.items() if not told]
    if not names:
        return "The photograph tells all of them."
    return f"The photograph does not tell {', '.join(names)}: other values would draw the same rings nearly as well."


def _parameter_rows(file: WoodFile) -> Iterator[str]:
    errors, held = file.report["standard_errors"], file.report.get("held") or ()
    for name, (value, title) in list_parameters(file.wood).items():
        told = "held by hand" if name in held else _told(file.determined.get(name))
        shown = _colour_chip(value) if name.endswith("_rgb") else _show_numbers(value, errors.get(name))
        note = f" ({_NOTES[name]})" if name in _NOTES else ""
        cells = (
            f"<td><code>{name}</code></td>",
            f'<td class="value">{shown}</td>',
            f"<td>{_show_errors(errors.get(name))}</td>",
            f'<td style="text-align: left">{told}</td>',
            f'<td class="meaning">{html.escape(title)}{note}</td>',
        )
        yield f"<tr>{''.join(cells)}</tr>"


def _told(determined: bool | None) -> str:
    if determined is None:
        return ""
    return "tells" if determined else '<span class="untold">does not tell</span>'


def _show_numbers(value: Any, error: Any) -> str:
    numbers = value if isinstance(value, list) else [value]
    errors = error if isinstance(error, list) else [error] * len(numbers)
    return ", ".join(
        # Without an error four digits are shown: a frequency is a small number.
        f"{number:.4g}" if one is None else f"{number:.{digits_for(one)}f}"
        for number, one in zip(numbers, errors, strict=True)
    )


def _show_errors(error: Any) -> str:
    if error is None:
        return ""
    return ", ".join("–" if one is None else f"{one:.2g}" for one in (error if isinstance(error, list) else [error]))


def _colour_chip(linear: list[float]) -> str:
    encoded = np.clip(np.round(255 * linear_to_srgb(np.clip(linear, 0, 1))), 0, 255).astype(int)
    colour = "#" + "".join(f"{channel:02x}" for channel in encoded)
    return f'<span class="swatches"><i style="background:{colour}"></i>{colour}</span>'
