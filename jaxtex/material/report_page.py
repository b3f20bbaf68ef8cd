"""What the pages that show fits have in common: their frame, how pictures stand in them, tables and numbers.

A page is a single file with its pictures inside; it needs no network and no script.
"""

import base64
import html
import math
import string
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from skimage.transform import resize_local_mean

from jaxtex.io.files import atomic_write_text
from jaxtex.io.images import Image, write_image
from jaxtex.models.files import ModelFile

LARGE, SMALL = 1400, 900
"""Pixels of the longer side of pictures in a page."""


class Headline(NamedTuple):
    """How a page begins.

    Attributes:
        model: what was fitted, in one word.
        verdict: what was found, in one line of plain text.
        facts: the most important numbers by name, as HTML.
    """

    model: str
    verdict: str
    facts: Mapping[str, str]


class Making(NamedTuple):
    """How what a page shows was made.

    Attributes:
        again: what the commands do, in plain text.
        commands: to be typed.
        seconds: spent on each step; times stand in the page only.
    """

    again: str
    commands: Sequence[str]
    seconds: Mapping[str, float]


def write_page(path: Path, *, photo: Image, file: ModelFile, headline: Headline, body: str, making: Making) -> None:
    """Write a page, whole or not at all.

    Args:
        path: the file.
        photo: the photograph that was fitted.
        file: the model file's content.
        headline: how the page begins.
        body: its middle, as HTML; see `fill_template`.
        making: how it ends.

    Raises:
        InputError: the page cannot be written.
    """
    ok = file.report["ok"]
    values = {
        "title": html.escape(f"{photo.path.name}: fitted {headline.model}"),
        "kicker": f"Fitted {headline.model}",
        "name": html.escape(photo.path.name),
        "kind": "good" if ok else "bad",
        "verdict": html.escape(headline.verdict),
        "told": "" if ok else '<p class="lead">What follows is the best guess.</p>',
        "facts": "".join(f"<div><dt>{name}</dt><dd>{value}</dd></div>" for name, value in headline.facts.items()),
        "aspect": f"{photo.width / photo.height:.4f}",
        "body": body,
        "again": html.escape(making.again),
        "commands": "".join(f"<pre><code>{html.escape(line)}</code></pre>" for line in making.commands),
        "timings": "".join(_timing_rows(making.seconds)),
        "footer": _footer(file),
    }
    atomic_write_text(path, fill_template("report.html", values))


def fill_template(name: str, values: Mapping[str, str]) -> str:
    """A template of this package, its names filled in.

    Args:
        name: of the file.
        values: HTML by name; all names of the template.
    """
    text = resources.files("jaxtex.material").joinpath(name).read_text(encoding="utf-8")
    return string.Template(text).substitute(values)


def shrink_picture(pixels: npt.NDArray[np.float32], side: int) -> npt.NDArray[np.float32]:
    """A picture [row, col, channel] made smaller by averaging, so that its longer side has at most `side` pixels.

    Examples:
        >>> shrink_picture(np.ones((40, 80, 3), np.float32), 20).shape
        (10, 20, 3)
    """
    height, width = pixels.shape[:2]
    scale = side / max(height, width)
    if scale >= 1:
        return pixels
    return resize_local_mean(pixels, (max(1, round(height * scale)), max(1, round(width * scale))), channel_axis=-1)


def embed_picture(pixels: npt.NDArray[np.float32], name: str, *, data: bool = False) -> str:
    """A picture as a data URI, values beyond 0 and 1 cut off.

    Args:
        pixels: linear light, or data, [row, col, channel].
        name: of a file of the kind it is to be, photo.jpg or mask.png.
        data: whether values are written as they stand.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        write_image(path, np.clip(pixels, 0, 1), colour_space="data" if data else "srgb")
        encoded = base64.b64encode(path.read_bytes()).decode("ascii")
    kind = "png" if path.suffix == ".png" else "jpeg"
    return f"data:image/{kind};base64,{encoded}"


def digits_for(error: float | None) -> int:
    """How many digits behind the point a number with this standard error deserves: two of the error's own.

    Examples:
        >>> digits_for(0.0123), digits_for(40.0), digits_for(None)
        (3, 0, 3)
    """
    return 3 if error is None or error <= 0 else min(max(1 - math.floor(math.log10(error)), 0), 6)


def _timing_rows(seconds: Mapping[str, float]) -> Iterator[str]:
    for step, spent in seconds.items():
        yield f'<tr><td>{html.escape(step)}</td><td class="value">{spent:.2f}</td></tr>'


def _footer(file: ModelFile) -> str:
    versions = ", ".join(f"{name} {version}" for name, version in sorted((file.versions or {}).items()))
    parts = [f"Photograph sha256 {file.image.sha256}", f"seed {file.seed}" if file.seed is not None else "", versions]
    return html.escape(" · ".join(part for part in parts if part))
