"""`jaxtex render`: material maps of a model file, at any resolution."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro


@dataclass(frozen=True, kw_only=True)
class Render:
    """Make the material maps of a model file: basecolor.png, height.exr, normal.png, roughness.png and tile_id.exr.

    Courses come out horizontal, without perspective. Tiles that the photograph shows have their own colours; others get
    colours like these. Normals are OpenGL's (+Y up); heights are in pixels of the photograph.

    Example: jaxtex render wall/model.json -o maps --size 4096x4096 --tiles 10x20 --seamless
    """

    model: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="MODEL")]
    """The model file, as 'jaxtex fit' writes it."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"], metavar="FOLDER")]
    """The folder for the maps; it is made if there is none."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WxH", help_behavior_hint="")] = None
    """Size of the maps in pixels, which cover the tiles exactly: pixels are square where width and height are to each
    other as the tiles' are. By default as large as the tiles are in the photograph."""
    tiles: Annotated[str | None, tyro.conf.arg(metavar="CxR", help_behavior_hint="")] = None
    """How many tiles to show: columns (of mean length, where tiles differ) and rows. By default as many as the
    photograph."""
    seamless: Annotated[tyro.conf.FlagCreatePairsOff[bool], tyro.conf.arg(help_behavior_hint="")] = False
    """Make maps that repeat without a seam: whole periods of the bond, at least the tiles asked for."""
    seed: int = 0
    """Of the colours of tiles that the photograph does not show."""

    def run(self) -> int:
        from jaxtex.cli.values import check_seed, parse_size, parse_tiles
        from jaxtex.core.errors import InputError

        size = None if self.size is None else parse_size("--size", self.size)
        tiles = None if self.tiles is None else parse_tiles("--tiles", self.tiles)
        seed = check_seed(self.seed)

        import jax

        from jaxtex.cli.progress import progress
        from jaxtex.io.files import prepare_folder
        from jaxtex.material.appearance import appearance_of
        from jaxtex.material.export import write_maps
        from jaxtex.material.maps import count_bands, render_maps
        from jaxtex.material.sheet import lay_photographed_sheet
        from jaxtex.models.files import load_model

        file = load_model(self.model)
        try:
            appearance = appearance_of(file)
        except InputError as error:
            raise InputError(f"{self.model}: {error}") from None
        sheet = lay_photographed_sheet(file, tiles=tiles, seamless=self.seamless, pattern=appearance.pattern)
        size = size or sheet.natural_size
        bands = render_maps(sheet, appearance, size=size, key=jax.random.key(seed))
        folder = prepare_folder(self.output)
        write_maps(folder, progress(bands, "rendering maps", total=count_bands(size)), size=size)
        print(f"{folder}: maps of {size[0]} x {size[1]} pixels, {sheet.columns:g} x {sheet.rows} tiles")
        if not file.report["ok"]:
            print(f"  note: this model is a best guess; its fit did not succeed: {file.report['reason']}")
        stretched = size[0] / size[1] / (sheet.width / sheet.height)
        if abs(stretched - 1) > 0.01:
            fitting = f"{size[0]}x{max(round(size[0] * sheet.height / sheet.width), 1)}"
            print(f"  note: tiles are drawn {stretched:.2f} times as wide for their height; --size {fitting} would not")
        for change in sheet.changes:
            print(f"  so that they repeat without a seam, {change}")
        return 0
