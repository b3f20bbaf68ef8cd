"""What the fit of a floor leaves behind: one folder of files."""

import math
from pathlib import Path

import jax

from jaxtex.cli.progress import progress
from jaxtex.fitting.floor import FloorFit
from jaxtex.io.images import Image, write_image
from jaxtex.material.bands import count_bands
from jaxtex.material.export import write_maps
from jaxtex.material.finish import BARE_WOOD, WoodFinish
from jaxtex.material.floor import FloorMaps, draw_planks, render_floor
from jaxtex.material.interior_files import write_interiors
from jaxtex.material.planks import PlankInteriors, measure_planks
from jaxtex.models.envelope import SourceImage
from jaxtex.models.files import save_model
from jaxtex.models.floor_files import FloorFile, PlacedWood, wood_of_plank
from jaxtex.models.wood_files import wood_parameters
from jaxtex.photo.illumination import even_out


def describe_floor(photo: Image, fit: FloorFit, *, seed: int, interiors: str | None = None) -> FloorFile:
    """A fit as a model file holds it, beside which its interiors stand under the name given."""
    planks = tuple(
        # A file keeps but the seed of the turbulence.
        PlacedWood(plank.corners, wood_of_plank(wood_parameters(plank.wood), seed=seed, number=number), plank.own)
        for number, plank in enumerate(fit.planks)
    )
    report = {
        "ok": fit.ok,
        "reason": fit.reason,
        "iou": None,
        "start": None,
        "standard_errors": {},
        "across_deg": math.degrees(fit.turn) % 180,
        "joints": fit.joints,
        "evidence": fit.evidence,
    }
    report |= {} if interiors is None else {"interiors": interiors}
    return FloorFile(planks, SourceImage(photo.width, photo.height, photo.sha256), report, seed)


def write_floor_fit(
    folder: Path, photo: Image, fit: FloorFit, *, size: tuple[int, int] | None, seed: int, fill: bool = True
) -> FloorFile:
    """Write model.json, overlay.png and the material maps into an existing folder; where planks are filled,
    interiors.npz too.

    Args:
        folder: where to.
        photo, fit, seed: as `describe_floor`.
        size: (width, height) of the maps; None stands for the photograph's.
        fill: whether planks have what the photograph shows beyond their rings.

    Raises:
        InputError: no maps of this size can be made, or a file cannot be written.
    """
    file = describe_floor(photo, fit, seed=seed)
    interiors = measure_planks(even_out(photo.pixels)[0], file.planks) if fill and file.planks else None
    if interiors is not None:
        write_interiors(folder / "interiors.npz", interiors)
        file = describe_floor(photo, fit, seed=seed, interiors="interiors.npz")
    write_floor_maps(folder, file, interiors, size=size or (photo.width, photo.height))
    write_image(folder / "overlay.png", draw_planks(photo.pixels, file.planks))
    save_model(folder / "model.json", file)
    return file


def write_floor_maps(
    folder: Path,
    file: FloorFile,
    interiors: PlankInteriors | None,
    *,
    size: tuple[int, int],
    finish: WoodFinish = BARE_WOOD,
) -> None:
    """Write the maps of a floor into an existing folder.

    Raises:
        InputError: as `render_floor` and `write_maps`.
    """
    image, key = (file.image.width, file.image.height), jax.random.key(file.seed)
    bands = render_floor(file.planks, image=image, size=size, interiors=interiors, key=key, finish=finish)
    shown = progress(bands, "rendering maps", total=count_bands(size))
    write_maps(folder, shown, size=size, fields=FloorMaps._fields)
