"""`jaxtex fit ...`: fit a model to a photograph, and make its material."""

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

if TYPE_CHECKING:
    from jaxtex.models.files import TilingFile
    from jaxtex.models.wood_files import WoodFile

Assignments = Annotated[tuple[str, ...], tyro.conf.arg(metavar="NAME=NUMBER [...]", help_behavior_hint="")]
Rectangles = Annotated[tuple[str, ...], tyro.conf.arg(metavar="X,Y,WxH [...]", help_behavior_hint="")]
Switch = Annotated[tyro.conf.FlagCreatePairsOff[bool], tyro.conf.arg(help_behavior_hint="")]


@dataclass(frozen=True, kw_only=True)
class Tiling:
    """Fit a tiling to a photograph of a tiled wall, floor or facade, and make its material.

    Writes model.json, mask.png, overlay.png (look at this one first), the maps basecolor.png, height.exr, normal.png,
    roughness.png, specular.png, metallic.png, occlusion.png and tile_id.exr, what tiles and joints are filled with,
    interiors.npz, where that was learnt, regions.png, and report.html. The exit status is 1 where the picture shows no
    rectangular tiling; the best guess is written all the same.

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
    no_fill: Switch = False
    """Leave tiles and joints flat, each of one colour."""
    tile_region: Rectangles = ()
    """Parts of the photograph, each inside of one tile, that interiors of tiles are learnt from. By default clean tiles
    are chosen: without highlights, shadows or dirt."""
    joint_region: Rectangles = ()
    """Likewise for joints, each inside of one joint."""
    regions: Annotated[Path | None, tyro.conf.arg(metavar="PATH", help_behavior_hint="")] = None
    """Or a picture as large as the photograph, painted over whole tiles that may be learnt from: black where not, and
    each grey a kind of its own, which the tiles painted so, and others like them, are filled with."""
    seed: int = 0
    """Of the colours of tiles that the photograph does not show."""

    def run(self) -> int:
        from jaxtex.cli.values import check_seed, parse_assignments, parse_rectangle, parse_size
        from jaxtex.core.errors import InputError

        seed = check_seed(self.seed)
        size = None if self.size is None else parse_size("--size", self.size)
        tile_regions = tuple(parse_rectangle("--tile-region", word) for word in self.tile_region)
        joint_regions = tuple(parse_rectangle("--joint-region", word) for word in self.joint_region)
        if self.regions and tile_regions:
            raise InputError("--regions: and --tile-region both say where to learn from; give one of them")
        if self.no_fill and (tile_regions or joint_regions or self.regions):
            raise InputError("--no-fill: learns nothing from regions; leave out one or the other")
        fix, init = parse_assignments("--fix", self.fix), parse_assignments("--init", self.init)

        from jaxtex.cli.progress import reporting
        from jaxtex.cli.results import results_folder, write_fit
        from jaxtex.fitting.tiling import fit_tiling
        from jaxtex.io.images import read_image
        from jaxtex.io.masks import read_mask
        from jaxtex.material.regions import Regions, check_rectangles, read_painted

        photo = read_image(self.photo)
        mask = None if self.mask is None else read_mask(self.mask)
        painted = None
        if self.regions is not None:
            painted = read_painted(read_mask(self.regions), photo.pixels.shape[:2], str(self.regions))
        regions = Regions(tile_regions, joint_regions, painted)
        check_rectangles(regions, photo.pixels.shape[:2])
        with results_folder(self.output) as folder:
            with reporting("fitting the tiling") as report:
                fit = fit_tiling(
                    photo.pixels, mask=mask, perspective=not self.no_perspective, fix=fix, init=init, report=report
                )
            file = write_fit(
                folder,
                photo,
                fit,
                size=size,
                seed=seed,
                command=self._as_typed(),
                regions=regions,
                fill=not self.no_fill,
            )
        for line in _summary(self.photo, folder, file):
            print(line)
        return 0 if fit.ok else 1

    def _as_typed(self) -> str:
        flags = ["--no-perspective"] if self.no_perspective else []
        flags += ["--no-fill"] if self.no_fill else []
        options = {
            "--mask": [self.mask] if self.mask else [],
            "--fix": self.fix,
            "--init": self.init,
            "--tile-region": self.tile_region,
            "--joint-region": self.joint_region,
            "--regions": [self.regions] if self.regions else [],
            "--size": [self.size] if self.size else [],
            "--seed": [self.seed] if self.seed else [],
        }
        return _retype("tiling", self.photo, self.output, flags, options)


@dataclass(frozen=True, kw_only=True)
class Wood:
    """Fit the rings of a trunk to a photograph of a plank of one piece, along the grain or across, and make its
    material.

    Writes model.json, mask.png (early wood, the lighter, white), overlay.png (early wood outlined; look at this one
    first), rings.png (the rings, to be counted), the maps basecolor.png, height.exr, normal.png, roughness.png,
    specular.png and metallic.png, and report.html. 'jaxtex render' makes blocks and carved meshes of the model. The
    exit status is 1 where the picture shows no wood of one piece; the best guess is written all the same.

    Example: jaxtex fit wood plank.jpg -o plank

    Example: jaxtex fit wood plank.jpg -o plank --fix tilt_deg=12
    """

    photo: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="PHOTO")]
    """The photograph, seen straight on; see 'jaxtex rectify --help'."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"], metavar="FOLDER")]
    """The folder for the results; it is made if there is none."""
    mask: Annotated[Path | None, tyro.conf.arg(metavar="PATH", help_behavior_hint="")] = None
    """Your own mask, white on early wood (the lighter) and black on late wood, as large as the photograph. By default
    it is found."""
    fix: Assignments = ()
    """Parameters to hold: xc, yc (the trunk's axis, pixels from the photograph's middle, across the grain and into the
    depth), ring_spacing (pixels), tilt_deg (0 along the grain, 90 end grain), rotation_deg (in the photograph: 0
    vertical grain, 90 horizontal), early_fraction (of a ring)."""
    ellipse_center: Annotated[str | None, tyro.conf.arg(metavar="X,Y", help_behavior_hint="")] = None
    """Where in the photograph the rings have their middle, in pixels: the pith of end grain, the middle of ellipses."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WxH", help_behavior_hint="")] = None
    """Size of the maps in pixels; they are as wide as the photographed plank. By default as large as the photograph."""
    seed: int = 0
    """Of the turbulence's waves."""

    def run(self) -> int:
        from jaxtex.cli.values import check_seed, parse_assignments, parse_point, parse_size

        seed = check_seed(self.seed)
        size = None if self.size is None else parse_size("--size", self.size)
        fix = parse_assignments("--fix", self.fix)
        middle = None if self.ellipse_center is None else parse_point("--ellipse-center", self.ellipse_center)

        from jaxtex.cli.progress import reporting
        from jaxtex.cli.results import results_folder
        from jaxtex.cli.results_wood import write_wood_fit
        from jaxtex.fitting.wood import fit_wood
        from jaxtex.io.images import read_image
        from jaxtex.io.masks import read_mask
        from jaxtex.material.bands import check_sides

        if size is not None:
            check_sides(size)  # before the fit, which takes its time
        photo = read_image(self.photo)
        mask = None if self.mask is None else read_mask(self.mask) > 0.5
        with results_folder(self.output) as folder:
            with reporting("fitting the wood") as report:
                fit = fit_wood(photo.pixels, mask=mask, fix=fix, ellipse_center=middle, report=report)
            file = write_wood_fit(folder, photo, fit, held=fix, size=size, seed=seed, command=self._as_typed())
        for line in _wood_summary(self.photo, folder, file):
            print(line)
        return 0 if fit.ok else 1

    def _as_typed(self) -> str:
        options = {
            "--mask": [self.mask] if self.mask else [],
            "--fix": self.fix,
            "--ellipse-center": [self.ellipse_center] if self.ellipse_center else [],
            "--size": [self.size] if self.size else [],
            "--seed": [self.seed] if self.seed else [],
        }
        return _retype("wood", self.photo, self.output, [], options)


def _retype(
    model: str, photo: Path, output: Path, flags: Sequence[str], options: Mapping[str, Sequence[object]]
) -> str:
    """What to type to do it again."""
    words = ["jaxtex", "fit", model, photo, "-o", output, *flags]
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


def _wood_summary(photo: Path, folder: Path, file: "WoodFile") -> list[str]:
    from jaxtex.material.report_wood import END_GRAIN
    from jaxtex.models.wood_files import wood_parameters

    found, report = wood_parameters(file.wood), file.report
    runs = f"along {(found['rotation_deg'] + 90) % 180:.2f} degrees, across {found['rotation_deg']:.2f} degrees"
    untold = [name for name, told in file.determined.items() if not told]
    lines = [
        f"{photo}: wood" if report["ok"] else f"{photo}: no one piece of wood: {report['reason']}; the best guess is",
        f"  rings   {found['ring_spacing']:.2f} pixels apart, {100 * found['early_fraction']:.0f} % early wood",
        f"  grain   {'end grain' if found['tilt_deg'] > END_GRAIN else runs}",
        f"  tilt    {found['tilt_deg']:.2f} degrees against the trunk's axis",
    ]
    lines += [f"  the picture does not tell: {', '.join(untold)}"] if untold else []
    return [*lines, f"Open {folder / 'report.html'}"]
