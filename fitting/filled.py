"""How much filled walls and floors look like their photographs: a page to look at, and figures.

    python fitting/filled.py PHOTO ... -o OUT

For every photograph OUT/filled.html shows it, a rectified part of it, and the same part synthesised at once and at four
times its resolution. The table OUT/filled.md compares synthesised interiors with the photograph's: distances of

- tiles' mean colours (Wasserstein's distance between their distributions, the mean of three channels),
- the interiors' spectra (radial means of power; mean absolute difference of the decimal logarithms),
- the histograms of their gradients (Wasserstein's distance),

all of sRGB-encoded values from 0 to 1. Beside ours stand (a) tiles of one flat colour each, and (b) the interior of one
tile pasted into all: the mean over the choice of that tile. Photographs whose name is given with `floor:` before it are
taken for floors of planks.
"""

import argparse
import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import jax
import numpy as np
from numpy.typing import NDArray
from scipy.stats import wasserstein_distance
from tables import make_table

import jaxtex as jt
from jaxtex.cli.progress import progress
from jaxtex.cli.results import describe_fit, measure_look
from jaxtex.cli.results_floor import describe_floor
from jaxtex.core.colour import linear_to_srgb
from jaxtex.io.files import atomic_write_text
from jaxtex.material.cells import cut_box, cut_cells
from jaxtex.material.planks import cut_plank
from jaxtex.material.report_page import embed_picture, shrink_picture

SIDE = 480  # pixels of a picture on the page
INSET = 0.12  # of a tile's shorter side: so far inside of its edges interiors begin
PART = 4.0  # tiles: about the root of how many the part shows
FLOOR = 1e-8  # of power: far below the noise of 8 bits
RADII = 16  # of the radial mean of a spectrum

Floats = NDArray[np.floating]


class Faces(NamedTuple):
    """Interiors of tiles, sRGB-encoded: [row, col, 3] each."""

    faces: list[Floats]

    @property
    def means(self) -> Floats:
        return np.array([face.mean(axis=(0, 1)) for face in self.faces])

    @property
    def light(self) -> list[Floats]:
        return [face.mean(axis=2) for face in self.faces]

    def spectrum(self) -> Floats:
        """Decimal logarithm of the radial mean of the power of what differs from the tile's mean, the mean of tiles."""
        return np.mean([np.log10(np.maximum(radial_power(light), FLOOR)) for light in self.light], axis=0)

    def gradients(self) -> Floats:
        """Magnitudes of the gradient, of all tiles."""
        return np.concatenate([np.hypot(*np.gradient(light)).ravel() for light in self.light])


class Distances(NamedTuple):
    """Of interiors from the photograph's."""

    colour: float
    spectrum: float
    gradient: float


def radial_power(light: Floats) -> Floats:
    window = np.outer(np.hanning(light.shape[0] + 2)[1:-1], np.hanning(light.shape[1] + 2)[1:-1])
    power = np.abs(np.fft.fft2((light - light.mean()) * window)) ** 2 / np.sum(window**2)
    frequency = np.hypot(np.fft.fftfreq(light.shape[0])[:, None], np.fft.fftfreq(light.shape[1])[None, :])
    at = np.minimum((frequency / 0.5 * RADII).astype(int), RADII)  # the last is beyond the axes' Nyquist frequency
    count = np.bincount(at.ravel(), minlength=RADII + 1)
    return (np.bincount(at.ravel(), power.ravel(), minlength=RADII + 1) / np.maximum(count, 1))[:RADII]


def distances(seen: Faces, made: Faces) -> Distances:
    spectra = [faces.spectrum() for faces in (seen, made)]
    colour = [wasserstein_distance(one, other) for one, other in zip(seen.means.T, made.means.T, strict=True)]
    gradients = [faces.gradients() for faces in (seen, made)]
    gradient = wasserstein_distance(*(each[:: max(1, len(each) // 200_000)] for each in gradients))
    return Distances(float(np.mean(colour)), float(np.abs(np.subtract(*spectra)).mean()), float(gradient))


def pasted(seen: Faces, number: int) -> Faces:
    """One tile's interior in all of them."""
    face = seen.faces[number]
    rows, columns = (max(each.shape[axis] for each in seen.faces) for axis in (0, 1))
    tiled = np.tile(face, (-(-rows // face.shape[0]), -(-columns // face.shape[1]), 1))
    return Faces([tiled[: each.shape[0], : each.shape[1]] for each in seen.faces])


def encode(picture: Floats) -> NDArray[np.float32]:
    encoded = linear_to_srgb(np.clip(np.broadcast_to(picture, (*picture.shape[:2], 3)), 0, 1))
    return encoded.astype(np.float32)


class Trial(NamedTuple):
    """A photograph and what was made of it: pictures for the page in linear light, interiors for the figures."""

    name: str
    photo: Floats
    part: Floats
    once: Floats
    fourfold: Floats
    seen: Faces
    filled: Faces
    flat: Faces


def try_wall(path: Path) -> Trial:
    """Fit a tiling, and synthesise it."""
    photo = jt.read_image(path)
    fit = jt.fit_tiling(photo.pixels)
    look = measure_look(photo.pixels, fit)
    file = describe_fit(photo, fit, look, seed=0)
    appearance = look.appearance
    if appearance is None or look.interiors is None:
        raise jt.InputError(f"{path}: no tile can be seen as a whole")
    places = [(int(course), int(tile)) for course, tile in look.interiors.places]

    def faces(picture: Floats, tiling: jt.Tiling) -> dict[tuple[int, int], Floats]:
        inside = {}
        for cell in cut_cells(encode(picture), tiling, places):
            depths = np.minimum(cell.top, cell.bottom), np.minimum(cell.left, cell.right)
            margin = INSET * 2 * min(depth.max() for depth in depths)
            rows, columns = (depth > margin for depth in depths)
            inside[cell.place] = cell.values[rows][:, columns]
        return inside

    sheet = jt.lay_photographed_sheet(file)
    onto_map = sheet.as_picture()
    even = jt.even_out(photo.pixels)[0]
    maps = [render(sheet, appearance, interiors, 1) for interiors in (look.interiors, None)]
    seen, filled, flat = faces(even, fit.tiling), *(faces(each, onto_map) for each in maps)
    shared = [place for place in places if place in filled]
    small = jt.lay_photographed_sheet(file, tiles=part_of(sheet))
    return Trial(
        name=path.stem,
        photo=photo.pixels,
        part=straighten(even, fit.tiling, small),
        once=render(small, appearance, look.interiors, 1),
        fourfold=render(small, appearance, look.interiors, 4),
        seen=Faces([seen[place] for place in shared]),
        filled=Faces([filled[place] for place in shared]),
        flat=Faces([flat[place] for place in shared]),
    )


def part_of(sheet: jt.Sheet) -> tuple[int, int]:
    """How many tiles (columns, rows) make about a square of a few."""
    aspect = sheet.width / sheet.columns * sheet.rows / sheet.height
    columns = min(math.ceil(PART / max(aspect, 1.0) ** 0.5), int(sheet.columns))
    return columns, min(max(1, round(columns * aspect)), sheet.rows)


def render(sheet: jt.Sheet, appearance: jt.Appearance, interiors: jt.Interiors | None, times: int) -> Floats:
    size = times * sheet.natural_size[0], times * sheet.natural_size[1]
    bands = jt.render_maps(sheet, appearance, interiors=interiors, size=size, key=jax.random.key(0))
    return np.concatenate([band.base_colour for band in bands])


def straighten(picture: Floats, tiling: jt.Tiling, sheet: jt.Sheet) -> Floats:
    """What the picture shows where the sheet is."""
    corner = np.array(sheet.corner)
    return np.clip(cut_box(picture, tiling, corner, corner + np.array([sheet.width, sheet.height])), 0, 1)


def try_floor(path: Path) -> Trial:
    """Fit a floor, and synthesise it."""
    photo = jt.read_image(path)
    fit = jt.fit_floor(photo.pixels)
    file = describe_floor(photo, fit, seed=0)
    even = jt.even_out(photo.pixels)[0]
    interiors = jt.measure_planks(even, file.planks)
    if interiors is None:
        raise jt.InputError(f"{path}: no plank can be seen well enough")
    image = photo.width, photo.height

    def draw(times: int, interiors: jt.PlankInteriors | None) -> Floats:
        size = times * image[0], times * image[1]
        bands = jt.render_floor(file.planks, image=image, size=size, interiors=interiors, key=jax.random.key(0))
        return np.concatenate([band.base_colour for band in bands])

    def faces(picture: Floats) -> Faces:
        pieces = [
            cut_plank(encode(picture), plank, turned=bool(turned))
            for plank, turned in zip(file.planks, interiors.turned, strict=True)
        ]
        return Faces([piece.values for piece in pieces if piece is not None and min(piece.values.shape[:2]) > 8])

    once = draw(1, interiors)
    top, left = (max(0, (side - SIDE) // 2) for side in photo.pixels.shape[:2])
    part = np.s_[top : top + SIDE, left : left + SIDE]
    four = np.s_[4 * top : 4 * (top + SIDE), 4 * left : 4 * (left + SIDE)]
    return Trial(
        name=path.stem,
        photo=photo.pixels,
        part=even[part],
        once=once[part],
        fourfold=draw(4, interiors)[four],
        seen=faces(even),
        filled=faces(once),
        flat=faces(draw(1, None)),
    )


def figures(trial: Trial) -> list[list[str]]:
    """Rows of the table."""
    ours, flat = distances(trial.seen, trial.filled), distances(trial.seen, trial.flat)
    choices = np.linspace(0, len(trial.seen.faces) - 1, min(12, len(trial.seen.faces))).astype(int)
    paste = Distances(*np.mean([distances(trial.seen, pasted(trial.seen, n)) for n in choices], axis=0))
    rows = []
    for name, mine, one, other in zip(Distances._fields, ours, flat, paste, strict=True):
        closer = "yes" if mine < min(one, other) else "no"
        rows.append([trial.name, name, *(f"{each:.5f}" for each in (mine, one, other)), closer])
    return rows


def show(trial: Trial) -> str:
    """The trial as a row of the page."""
    pictures = {
        "photograph": shrink_picture(trial.photo, SIDE),
        "a part of it, rectified": trial.part,
        "synthesised": trial.once,
        "at four times the resolution": trial.fourfold,
    }
    cells = []
    for words, picture in pictures.items():
        shown = np.clip(np.broadcast_to(picture, (*picture.shape[:2], 3)), 0, 1).astype(np.float32)
        source = embed_picture(shown, "picture.jpg")
        cells.append(f'<figure><img src="{source}" alt="{words}"><figcaption>{words}</figcaption></figure>')
    return f"<h2>{trial.name}</h2><div>{''.join(cells)}</div>"


PAGE = """<!doctype html><meta charset="utf-8"><title>Filled walls and floors</title>
<style>
body {{ font: 15px/1.4 sans-serif; margin: 2em }}
div {{ display: flex; gap: 8px }}
figure {{ margin: 0; flex: 1 }}
img {{ width: 100% }}
</style>
<h1>Filled walls and floors</h1>{body}
"""


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("photos", nargs="+", metavar="PHOTO", help="photographs of walls; floor:PHOTO of floors")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT", help="folder for page and table")
    options = parser.parse_args(words)
    options.output.mkdir(parents=True, exist_ok=True)
    rows, shown = [], []
    for name in progress(options.photos, "fitting and filling"):
        path = Path(name.removeprefix("floor:"))
        trial = try_floor(path) if name.startswith("floor:") else try_wall(path)
        rows += figures(trial)
        shown.append(show(trial))
    table = make_table(["photograph", "distance of", "filled", "flat", "pasted", "filled is closest"], rows)
    print(table)
    atomic_write_text(options.output / "filled.md", table + "\n")
    atomic_write_text(options.output / "filled.html", PAGE.format(body="\n".join(shown)))


if __name__ == "__main__":
    main()
