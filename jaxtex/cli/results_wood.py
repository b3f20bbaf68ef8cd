"""What a fit of wood leaves behind: one folder of files, as `jaxtex.cli.results` makes it of tilings."""

from collections.abc import Collection
from pathlib import Path

import numpy as np

from jaxtex.cli.render_wood import write_plank
from jaxtex.fitting.wood import WoodFit
from jaxtex.io.images import Image, write_image
from jaxtex.io.masks import write_mask
from jaxtex.material.report_wood import WoodPictures, write_wood_report
from jaxtex.material.rings import draw_early_wood, draw_rings
from jaxtex.models.envelope import SourceImage
from jaxtex.models.files import save_model
from jaxtex.models.wood_files import WoodFile, wood_from_parameters, wood_parameters

COVARIANCE_OF = ("xc", "yc", "tilt", "rotation", "log ring_spacing", "logit early_fraction")
"""The numbers that a fit's covariance is of: lengths in pixels, angles in radians."""


def describe_wood(photo: Image, fit: WoodFit, *, held: Collection[str], seed: int) -> WoodFile:
    """A fit as a model file holds it, with the turbulence of a seed.

    Parameters that the user held are listed under `held` in the report; the photograph was not asked about them, so
    they have no standard errors.

    Args:
        photo: the photograph that was fitted.
        fit: what `fit_wood` made of it.
        held: the names that `fit_wood` was given to fix.
        seed: of the turbulence.
    """
    # The fit knows how strong and how fine the turbulence is; its waves are drawn for the form that the file holds.
    wood = wood_from_parameters(wood_parameters(fit.wood), seed=seed)
    names = [name for name in fit.determined if name in held or (name == "center" and {"xc", "yc"} <= set(held))]
    report = {
        "ok": fit.ok,
        "reason": fit.reason,
        "iou": fit.iou[1],
        "start": None,
        "standard_errors": {name: error for name, error in fit.standard_errors.items() if name not in names},
        "iou_rigid": fit.iou[0],
        "covariance": fit.covariance,
        "covariance_of": list(COVARIANCE_OF),
        "held": names,
    }
    return WoodFile(
        wood=wood,
        image=SourceImage(photo.width, photo.height, photo.sha256),
        determined={name: bool(told) for name, told in fit.determined.items() if name not in names},
        report=report,
        seed=seed,
    )


def write_wood_fit(
    folder: Path,
    photo: Image,
    fit: WoodFit,
    *,
    held: Collection[str],
    size: tuple[int, int] | None,
    seed: int,
    command: str,
) -> WoodFile:
    """Write model.json, mask.png, overlay.png, rings.png, the plank's maps and report.html into an existing folder.

    Args:
        folder: where to.
        photo, fit, held, seed: as `describe_wood`.
        size: (width, height) of the maps; None makes them as large as the photograph.
        command: what to type to do it again, for the report.

    Raises:
        InputError: maps of this size cannot be made, or a file cannot be written. In the first case nothing is written.
    """
    file = describe_wood(photo, fit, held=held, seed=seed)
    fraction = float(fit.wood.early_fraction)
    pictures = WoodPictures(
        mask=np.asarray(fit.mask),
        overlay=draw_early_wood(photo.pixels, fit.rings, fraction, clear=fit.clear),
        rings=draw_rings(photo.pixels, fit.rings, clear=fit.clear),
    )
    write_plank(folder, file, size=size or (photo.width, photo.height))
    write_mask(folder / "mask.png", pictures.mask)
    write_image(folder / "overlay.png", pictures.overlay)
    write_image(folder / "rings.png", pictures.rings)
    save_model(folder / "model.json", file)
    write_wood_report(
        folder / "report.html", photo=photo, pictures=pictures, file=file, seconds=fit.seconds, command=command
    )
    return file
