"""Photographs -> named models: fits every photograph of a folder, and writes model files, previews and a table.

Without a folder it fits the photographs of tilings that PyPI wheels ship, which makes what stands in models/.

    python fitting/gallery.py                     # models/
    python fitting/gallery.py FOLDER -o OUT
"""

import argparse
import os
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

import jax
import numpy as np
import skimage
from numpy.typing import NDArray
from skimage import transform
from tables import make_table

import jaxtex as jt
from jaxtex.cli.progress import progress
from jaxtex.cli.results import Look, describe_fit, measure_look
from jaxtex.material.interior_files import write_interiors

MODELS = Path(__file__).parents[1] / "models"
SIDE = 320  # pixels of each of the three pictures of a preview
ENDINGS = {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".exr"}
INTRODUCTION = """# Fitted models

Each photograph, the tiling that was fitted to it drawn over it, and the material that the model makes of it, under a
lamp. Made by `python fitting/gallery.py`; to use one:

    jaxtex info models/brick-skimage.json
    jaxtex render models/brick-skimage.json -o maps --size 4096x4096 --tiles 12x36 --seamless

"""


class Source(NamedTuple):
    """A photograph, the name of the model to be made of it, and where it comes from."""

    name: str
    path: Path
    origin: str


def list_shipped() -> list[Source]:
    """The photographs of tilings in wheels on PyPI."""
    folder = Path(skimage.__file__).parent / "data"
    shipped = f"scikit-image {version('scikit-image')}: skimage/data"
    return [Source("brick-skimage", folder / "brick.png", f"{shipped}/brick.png, from CC0Textures, licence CC0")]


def list_folder(folder: Path) -> list[Source]:
    """The photographs of a folder."""
    paths = sorted(path for path in folder.iterdir() if path.suffix.lower() in ENDINGS)
    return [Source(path.stem, path, path.name) for path in paths]


def fit_all(sources: list[Source], output: Path) -> Iterator[list[str]]:
    """Fit every photograph; a row of the table for each."""
    for source in progress(sources, "fitting photographs"):
        try:
            photo = jt.read_image(source.path)
            fit = jt.fit_tiling(photo.pixels)
        except jt.InputError as error:
            yield [source.name, "", "", "", f"cannot be used: {error}", source.origin]
            continue
        if not fit.ok:
            yield [source.name, "", "", "", f"no tiling: {fit.reason}", source.origin]
            continue
        look, beside = measure_look(photo.pixels, fit), f"{source.name}.npz"
        file = describe_fit(photo, fit, look, seed=0, interiors=beside)
        jt.save_model(output / f"{source.name}.json", file)
        if look.interiors is not None:
            write_interiors(output / beside, look.interiors)
        jt.write_image(output / f"{source.name}.png", draw_preview(photo, file, look))
        parameters = jt.tiling_parameters(fit.tiling, rows=fit.rows, columns=fit.columns)
        size = "{tile_width:.1f} x {tile_height:.1f}".format(**parameters)
        yield [
            f"[{source.name}]({source.name}.json)",
            f"![]({source.name}.png)",
            fit.tiling.bond,
            size,
            f"{fit.rows} courses of {fit.columns}",
            source.origin,
        ]


def draw_preview(photo: jt.Image, file: jt.TilingFile, look: Look) -> NDArray[np.float32]:
    """The photograph, the tiling over it, and its material under a lamp, side by side."""
    appearance = jt.appearance_of(file)
    sheet = jt.lay_photographed_sheet(file)
    width, height = sheet.natural_size
    scale = 2 * SIDE / max(width, height)
    size = (max(1, round(scale * width)), max(1, round(scale * height)))
    bands = jt.render_maps(sheet, appearance, interiors=look.interiors, size=size, key=jax.random.key(0))
    maps = jt.Maps(*map(np.concatenate, zip(*bands, strict=True)))
    lit = jt.shade_maps(maps, pixel=sheet.width / size[0])
    return np.hstack(
        [_fit_square(picture) for picture in (photo.pixels, jt.draw_overlay(photo.pixels, file.tiling), lit)]
    )


def _fit_square(picture: NDArray[np.floating]) -> NDArray[np.float32]:
    """A picture in the middle of a white square."""
    height, width = picture.shape[:2]
    scale = SIDE / max(height, width)
    shape = (max(1, round(scale * height)), max(1, round(scale * width)))
    small = transform.resize(picture, shape, anti_aliasing=scale < 1)
    square = np.ones((SIDE, SIDE, 3), np.float32)
    top, left = (SIDE - shape[0]) // 2, (SIDE - shape[1]) // 2
    square[top : top + shape[0], left : left + shape[1]] = np.clip(small, 0, 1)
    return square


def main() -> None:
    """Fit, write, and tell."""
    parser = argparse.ArgumentParser(description="Make model files of all photographs of a folder.")
    parser.add_argument("folder", type=Path, nargs="?", help="photographs (default: those that PyPI wheels ship)")
    parser.add_argument("-o", "--output", type=Path, default=MODELS, help="where to (default: models/)")
    chosen = parser.parse_args()
    if chosen.folder and chosen.output == MODELS:
        parser.error("give a folder of your own with -o: models/ holds what can be made anew from packages")
    sources = list_folder(chosen.folder) if chosen.folder else list_shipped()
    chosen.output.mkdir(parents=True, exist_ok=True)
    head = ("model", "photograph, tiling, material", "bond", "tile, pixels", "found", "where the photograph comes from")
    table = make_table(head, list(fit_all(sources, chosen.output)))
    (chosen.output / "README.md").write_text(INTRODUCTION + table + "\n", encoding="utf-8")
    print(table)


if __name__ == "__main__":
    main()
