"""What a fit of a tiling leaves behind, from whichever command or script it came: one folder of files.

Here and in the modules named after it, what was fitted and what it looks like come together: neither layer knows the
other.
"""

import contextlib
import dataclasses
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np
import numpy.typing as npt

from jaxtex.cli.progress import progress
from jaxtex.core.errors import InputError
from jaxtex.fitting.tiling import TilingFit
from jaxtex.io.files import prepare_folder
from jaxtex.io.images import Image, write_image
from jaxtex.io.masks import write_mask
from jaxtex.material.appearance import Appearance, appearance_of
from jaxtex.material.bands import count_bands
from jaxtex.material.export import write_maps
from jaxtex.material.interior_files import write_interiors
from jaxtex.material.interiors import Interiors, measure_interiors
from jaxtex.material.maps import render_maps
from jaxtex.material.measure import measure_appearance
from jaxtex.material.overlay import draw_overlay, draw_tiles_alone
from jaxtex.material.regions import Regions
from jaxtex.material.report import write_report
from jaxtex.material.sheet import Sheet, lay_photographed_sheet
from jaxtex.material.stocks import choose_slope
from jaxtex.models.files import SourceImage, TilingFile, save_model, tiling_parameters
from jaxtex.photo.illumination import even_out

_FEWEST = 6  # pixels to a tile, at least


@contextlib.contextmanager
def results_folder(path: Path) -> Iterator[Path]:
    """The folder `path`, made where there is none, and removed again if nothing came to stand in it.

    Raises:
        InputError: as `prepare_folder`.
    """
    made = [folder for folder in (path, *path.parents) if not folder.exists()]
    try:
        yield prepare_folder(path)
    finally:
        for folder in made:
            with contextlib.suppress(OSError):
                folder.rmdir()


class Look(NamedTuple):
    """What tiles look like, as far as the photograph shows it.

    Attributes:
        appearance: None where the fit is so far off that no tile of it can be seen.
        interiors: None where no tile can be seen as a whole, or they are not wanted.
    """

    appearance: Appearance | None
    interiors: Interiors | None

    def to_json(self, beside: str) -> dict[str, Any] | None:
        """As it stands in a model file, beside which its interiors stand under the name given."""
        if self.appearance is None:
            return None
        return self.appearance.to_json() | ({} if self.interiors is None else {"interiors": beside})


def describe_fit(
    photo: Image, fit: TilingFit, look: Look, *, seed: int, interiors: str = "interiors.npz"
) -> TilingFile:
    """A fit as a model file holds it, with the appearance of its tiles as the photograph shows them.

    Args:
        photo: the photograph that was fitted.
        fit: what `fit_tiling` made of it.
        look: what `measure_look` saw.
        seed: of all random choices that follow from the file.
        interiors: name of the file beside the model's that holds what tiles are filled with.
    """
    report = {
        "ok": fit.ok,
        "reason": fit.reason,
        "iou": fit.iou,
        "start": tiling_parameters(fit.start, rows=fit.rows, columns=fit.columns),
        "standard_errors": _by_parameter(fit.standard_errors),
        "evidence": fit.evidence,
    }
    return TilingFile(
        tiling=fit.tiling,
        image=SourceImage(photo.width, photo.height, photo.sha256),
        rows=fit.rows,
        columns=fit.columns,
        report=report,
        appearance=look.to_json(interiors),
        seed=seed,
    )


def write_fit(
    folder: Path,
    photo: Image,
    fit: TilingFit,
    *,
    size: tuple[int, int] | None,
    seed: int,
    command: str,
    regions: Regions | None = None,
    fill: bool = True,
) -> TilingFile:
    """Write model.json, mask.png, overlay.png, the material maps and report.html into an existing folder; where tiles
    are filled, interiors.npz and regions.png too.

    Args:
        folder: where to.
        photo, fit, seed: as `describe_fit`.
        size: (width, height) of the maps; None makes tiles as large as in the photograph.
        command: what to type to do it again, for the report.
        regions: where the user wants interiors learnt from.
        fill: whether tiles and joints are filled.

    Raises:
        InputError: maps of this size would not show the tiles, or a file cannot be written. In the first case nothing
            is written.
    """
    look = measure_look(photo.pixels, fit, regions=regions, fill=fill)
    file = describe_fit(photo, fit, look, seed=seed)
    sheet = lay_photographed_sheet(file)
    write_sheet(folder, sheet, appearance_of(file), look.interiors, size=size or _choose_size(sheet), seed=seed)
    if look.interiors is not None:
        write_interiors(folder / "interiors.npz", look.interiors)
        learnt = look.interiors.places[look.interiors.learnt]
        write_image(folder / "regions.png", draw_tiles_alone(photo.pixels, fit.tiling, learnt))
    write_mask(folder / "mask.png", fit.mask)
    write_image(folder / "overlay.png", draw_overlay(photo.pixels, fit.tiling))
    save_model(folder / "model.json", file)
    write_report(folder / "report.html", photo=photo, mask=fit.mask, file=file, seconds=fit.seconds, command=command)
    return file


def write_sheet(
    folder: Path,
    sheet: Sheet,
    appearance: Appearance,
    interiors: Interiors | None,
    *,
    size: tuple[int, int],
    seed: int,
) -> None:
    """Write the material maps of a sheet into an existing folder, with a bar for a person who waits.

    Raises:
        InputError: as `render_maps` and `write_maps`.
    """
    bands = render_maps(sheet, appearance, interiors=interiors, size=size, key=jax.random.key(seed))
    write_maps(folder, progress(bands, "rendering maps", total=count_bands(size)), size=size)


def _choose_size(sheet: Sheet) -> tuple[int, int]:
    """The photograph's own scale, or a multiple of it where its tiles have too few pixels to be drawn."""
    smallest = float(min(sheet.tiling.tile_height, sheet.tiling.tile_width * sheet.tiling.course_lengths.min()))
    scale = max(1, math.ceil(_FEWEST / smallest))
    width, height = sheet.natural_size
    return scale * width, scale * height


def measure_look(
    pixels: npt.NDArray[np.float32], fit: TilingFit, *, regions: Regions | None = None, fill: bool = True
) -> Look:
    """See what tiles look like in the photograph that was fitted; arguments are as `write_fit` takes them."""
    even = even_out(pixels)[0]
    try:
        appearance = measure_appearance(even, fit.tiling, mask=fit.mask)
    except InputError:
        return Look(None, None)
    if not fill:
        return Look(appearance, None)
    interiors = measure_interiors(even, fit.tiling, appearance, mask=fit.mask, regions=regions)
    if interiors is None:
        return Look(appearance, None)
    tile, joint = choose_slope(interiors.tile_grain), choose_slope([interiors.joint_grain])
    return Look(dataclasses.replace(appearance, tile_bump=tile, joint_bump=joint), interiors)


def _by_parameter(errors: dict[str, float]) -> dict[str, object]:
    """Errors under the names of the file's parameters: those of the origin are a point."""
    named: dict[str, object] = {name: float(error) for name, error in errors.items() if not name.startswith("origin")}
    origin = [errors.get("origin_x"), errors.get("origin_y")]
    if any(error is not None for error in origin):
        named["origin"] = [None if error is None else float(error) for error in origin]
    return named
