"""`jaxtex fit ...`: fit a model to a photograph, and make its material."""

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

if TYPE_CHECKING:
    from jaxtex.models.files import TilingFile

Assignments = Annotated[tuple[str, ...], tyro.conf.arg(metavar="NAME=NUMBER [...]", help_behavior_hint="")]
Switch = Annotated[tyro.conf.FlagCreatePairsOff[bool], tyro.conf.arg(help_behavior_hint="")]


@dataclass(frozen=True, kw_only=True)
class Tiling:
    """Fit a tiling to a photograph of a tiled wall, floor or facade, and make its material.

    Writes model.json, mask.png, overlay.png (look at this one first), the maps basecolor.png, height.exr, normal.png,
    roughness.png and tile_id.exr, and report.html. The exit status is 1 where the picture shows no rectangular tiling;
    the best guess is written all the same.

    Example: jaxtex fit tiling wall.jpg -o wall
    """

    photo: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="PHOTO")]
    """The photograph; it need not be straight, and may be seen at an angle."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"], metavar="FOLDER")]
    """The folder for the results; it is made if there is none."""
    mask: Annotated[Path | None, tyro.conf.arg(metavar="PATH", help_behavior_hint="")] = None
    """Your own mask, white on tiles and black on joints, as large as the photograph; see 'jaxtex mask --help'. By
    default it is found."""
    fix: Assignments = ()
    """Parameters to hold: tile_width, tile_height, mortar_x, mortar_y, origin_x, origin_y (pixels of the photograph),
    angle_deg (degrees, clockwise), offset (of tile_width)."""
    init: Assignments = ()
    """Parameters to start from, of the same names."""
    no_perspective: Switch = False
    """Take the photograph as seen straight on."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WxH", help_behavior_hint="")] = None
    """Size of the maps in pixels. By default tiles are as large as in the photograph."""
    seed: int = 0
    """Of the colours of tiles that the photograph does not show."""

    def run(self) -> int:
        from jaxtex.cli.values import check_seed, parse_assignments, parse_size

        seed = check_seed(self.seed)
        size = None if self.size is None else parse_size("--size", self.size)
        fix, init = parse_assignments("--fix", self.fix), parse_assignments("--init", self.init)

        from jaxtex.cli.progress import reporting
        from jaxtex.cli.results import results_folder, write_fit
        from jaxtex.fitting.tiling import fit_tiling
        from jaxtex.io.images import read_image
        from jaxtex.io.masks import read_mask

        photo = read_image(self.photo)
        mask = None if self.mask is None else read_mask(self.mask)
        with results_folder(self.output) as folder:
            with reporting("fitting the tiling") as report:
                fit = fit_tiling(
                    photo.pixels, mask=mask, perspective=not self.no_perspective, fix=fix, init=init, report=report
                )
            file = write_fit(folder, photo, fit, size=size, seed=seed, command=self._as_typed())
        for line in _summary(self.photo, folder, file):
            print(line)
        return 0 if fit.ok else 1

    def _as_typed(self) -> str:
        options = {
            "--mask": [self.mask] if self.mask else [],
            "--fix": self.fix,
            "--init": self.init,
            "--size": [self.size] if self.size else [],
            "--seed": [self.seed] if self.seed else [],
        }
        words = ["jaxtex", "fit", "tiling", self.photo, "-o", self.output]
        words += ["--no-perspective"] if self.no_perspective else []
        words += [word for name, values in options.items() if values for word in (name, *values)]
        return shlex.join(map(str, words))


def _summary(photo: Path, folder: Path, file: "TilingFile") -> list[str]:
    from jaxtex.models.files import tiling_parameters

    found = tiling_parameters(file.tiling, rows=file.rows, columns=file.columns)
    lines = [f"{photo}: no tiling: {file.report['reason']}; the best guess is"] if not file.report["ok"] else []
    lines += [
        f"{photo}: a tiling in {found['bond']} bond" if file.report["ok"] else f"  {found['bond']} bond",
        f"  {file.rows} courses of {file.columns} tiles",
        f"  tiles   {found['tile_width']:.2f} x {found['tile_height']:.2f} pixels, joint included",
        f"  joints  {found['mortar_x']:.2f} pixels between tiles, {found['mortar_y']:.2f} between courses",
        f"  angle   {found['angle_deg']:.2f} degrees",
        "  offset  each course has its own"
        if found["bond"] == "irregular"
        else f"  offset  {found['offset']:.3f} of a tile from course to course",
    ]
    return [*lines, f"Open {folder / 'report.html'}"]
