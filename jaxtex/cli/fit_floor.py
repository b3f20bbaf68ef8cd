"""`jaxtex fit floor`: the planks of a floor, and the wood of each."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

if TYPE_CHECKING:
    from jaxtex.fitting.floor import FloorFit


@dataclass(frozen=True, kw_only=True)
class Floor:
    """Find the planks of a floor, a fence or parquet seen straight on, and fit wood to each of them.

    Writes model.json, overlay.png (look at this one first), the maps basecolor.png, height.exr, normal.png,
    roughness.png, specular.png, metallic.png and tile_id.exr (the planks' numbers), and what planks are filled with,
    interiors.npz. The exit status is 1 where the picture shows no planks of wood; the best guess is written all the
    same.

    Example: jaxtex fit floor floor.jpg -o floor

    Example: jaxtex fit floor floor.jpg -o floor --wood board.jpg
    """

    photo: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="PHOTO")]
    """The photograph. Planks may run in any direction; 'jaxtex rectify' straightens what is seen at an angle."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"], metavar="FOLDER")]
    """The folder for the results; it is made if there is none."""
    wood: Annotated[Path | None, tyro.conf.arg(metavar="PATH", help_behavior_hint="")] = None
    """Another photograph, of one board: all planks are made of its wood, each cut elsewhere from the trunk."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WxH", help_behavior_hint="")] = None
    """Size of the maps in pixels. By default that of the photograph."""
    no_fill: Annotated[tyro.conf.FlagCreatePairsOff[bool], tyro.conf.arg(help_behavior_hint="")] = False
    """Leave planks with the rings of their model alone: two tones and fibres."""
    seed: int = 0
    """Of the turbulence, and of where planks are cut from the wood of another photograph."""

    def run(self) -> int:
        from jaxtex.cli.values import check_seed, parse_size

        seed = check_seed(self.seed)
        size = None if self.size is None else parse_size("--size", self.size)

        from jaxtex.cli.progress import reporting
        from jaxtex.cli.results import results_folder
        from jaxtex.cli.results_floor import write_floor_fit
        from jaxtex.core.errors import InputError
        from jaxtex.fitting.floor import fit_floor
        from jaxtex.fitting.wood import fit_wood
        from jaxtex.io.images import read_image
        from jaxtex.material.bands import check_sides

        if size is not None:
            check_sides(size)
        photo = read_image(self.photo)
        other = None if self.wood is None else read_image(self.wood)
        with results_folder(self.output) as folder:
            board = None
            if other is not None:
                fit = fit_wood(other.pixels)
                if not fit.ok:
                    raise InputError(f"{self.wood}: shows no wood: {fit.reason}; give a photograph of one board")
                board = fit.wood
            with reporting("fitting the floor") as report:
                floor = fit_floor(photo.pixels, wood=board, seed=seed, report=report)
            write_floor_fit(folder, photo, floor, size=size, seed=seed, fill=not self.no_fill and other is None)
        for line in _summary(self.photo, folder, floor, self.wood):
            print(line)
        return 0 if floor.ok else 1


def _origin(own: int, count: int, other: Path | None) -> str:
    if other is not None:
        return f"that of {other}, cut elsewhere for each"
    if not own:
        return "could not be read off any of them; grain is the photograph's"
    rest = "" if own == count else "; the others share what these have in common"
    return f"read off {own} of {count}{rest}"


def _summary(photo: Path, folder: Path, floor: "FloorFit", other: Path | None) -> list[str]:
    import math

    own = sum(plank.own for plank in floor.planks)
    lines = [f"{photo}: {len(floor.planks)} planks"]
    if not floor.ok:
        lines = [f"{photo}: no floor of wood: {floor.reason}; the best guess is {len(floor.planks)} planks"]
    if floor.planks:
        lines += [
            f"  joints  {len(floor.joints)} across, at {(math.degrees(floor.turn) + 90) % 180:.2f} degrees",
            f"  wood    {_origin(own, len(floor.planks), other)}",
        ]
    return [*lines, f"Open {folder / 'overlay.png'}"]
