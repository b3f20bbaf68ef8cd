"""`jaxtex render`: material maps of a model file, at any resolution; of wood, blocks and carved meshes too."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

if TYPE_CHECKING:
    from jaxtex.models.files import TilingFile
    from jaxtex.models.floor_files import FloorFile


@dataclass(frozen=True, kw_only=True)
class Render:
    """Make the material maps of a model file: basecolor.png, height.exr, normal.png, roughness.png and, of tilings
    and floors, tile_id.exr. Of wood, a block of voxels (--block) or a carved mesh (--mesh) instead.

    Of a tiling, courses come out horizontal, without perspective. Tiles that the photograph shows have their own
    colours; others get colours like these. Of wood, pixels are square, and maps taller than the photograph show more
    wood; late wood stands a little higher than early wood, as on a brushed plank. Normals are OpenGL's (+Y up); heights
    are in pixels of the photograph.

    Example: jaxtex render wall/model.json -o maps --size 4096x4096 --tiles 10x20 --seamless

    Example: jaxtex render oak/model.json -o carved --mesh bunny.ply
    """

    model: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="MODEL")]
    """The model file, as 'jaxtex fit' writes it."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"], metavar="FOLDER")]
    """The folder for the results; it is made if there is none."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WxH", help_behavior_hint="")] = None
    """Size of the maps in pixels. Maps of a tiling cover the tiles exactly: pixels are square where width and height
    are to each other as the tiles' are. Maps of wood are as wide as the photographed plank. By default as large as in
    the photograph."""
    tiles: Annotated[str | None, tyro.conf.arg(metavar="CxR", help_behavior_hint="")] = None
    """Tilings: how many tiles to show: columns (of mean length, where tiles differ) and rows. By default as many as the
    photograph."""
    seamless: Annotated[tyro.conf.FlagCreatePairsOff[bool], tyro.conf.arg(help_behavior_hint="")] = False
    """Tilings: make maps that repeat without a seam: whole periods of the bond, at least the tiles asked for."""
    seed: int = 0
    """Tilings: of the colours of tiles that the photograph does not show."""
    block: Annotated[str | None, tyro.conf.arg(metavar="DxHxW", help_behavior_hint="")] = None
    """Wood: make voxels.npz, a block of so many voxels (depth, height, width), each as large as a pixel of the
    photograph; its array 'voxels' [z, y, x, channel] holds linear colours as float32. The first slice is the
    photographed face."""
    mesh: Annotated[Path | None, tyro.conf.arg(metavar="FILE", help_behavior_hint="")] = None
    """Wood: make mesh.ply, this mesh (PLY, OBJ, STL, GLB ...) carved of the wood: a colour to each vertex. Its bounding
    box is put in the middle of the photograph, and made as long as that."""

    def run(self) -> int:
        from jaxtex.cli.render_wood import WoodTask, render_wood_file
        from jaxtex.cli.values import check_seed, parse_block, parse_size, parse_tiles

        size = None if self.size is None else parse_size("--size", self.size)
        tiles = None if self.tiles is None else parse_tiles("--tiles", self.tiles)
        block = None if self.block is None else parse_block("--block", self.block)
        check_seed(self.seed)

        from jaxtex.models.files import TilingFile, load_model
        from jaxtex.models.floor_files import FloorFile

        file = load_model(self.model)
        if isinstance(file, TilingFile):
            self._refuse({"--block": block, "--mesh": self.mesh}, "a tiling; it is for wood")
            self._render_tiling(file, size, tiles)
        elif isinstance(file, FloorFile):
            self._refuse({"--tiles": tiles, "--seamless": self.seamless or None}, "a floor")
            self._refuse({"--block": block, "--mesh": self.mesh}, "a floor")
            self._render_floor(file, size)
        else:
            self._refuse({"--tiles": tiles, "--seamless": self.seamless or None}, "wood, which has no tiles")
            render_wood_file(file, self.output, WoodTask(size=size, block=block, mesh=self.mesh))
        if not file.report["ok"]:
            print(f"  note: this model is a best guess; its fit did not succeed: {file.report['reason']}")
        return 0

    def _render_floor(self, file: "FloorFile", size: tuple[int, int] | None) -> None:
        from jaxtex.cli.results_floor import write_floor_maps
        from jaxtex.io.files import prepare_folder

        width, height = size or (file.image.width, file.image.height)
        folder = prepare_folder(self.output)
        write_floor_maps(folder, file, size=(width, height))
        print(f"{folder}: maps of {width} x {height} pixels, {len(file.planks)} planks")

    def _refuse(self, options: dict[str, object], what: str) -> None:
        from jaxtex.core.errors import InputError

        given = next((option for option, value in options.items() if value is not None), None)
        if given:
            raise InputError(f"{given}: {self.model} is a model of {what}")

    def _render_tiling(self, file: "TilingFile", size: tuple[int, int] | None, tiles: tuple[int, int] | None) -> None:
        import jax

        from jaxtex.cli.progress import progress
        from jaxtex.core.errors import InputError
        from jaxtex.io.files import prepare_folder
        from jaxtex.material.appearance import appearance_of
        from jaxtex.material.bands import count_bands
        from jaxtex.material.export import write_maps
        from jaxtex.material.maps import render_maps
        from jaxtex.material.sheet import lay_photographed_sheet

        try:
            appearance = appearance_of(file)
        except InputError as error:
            raise InputError(f"{self.model}: {error}") from None
        sheet = lay_photographed_sheet(file, tiles=tiles, seamless=self.seamless, pattern=appearance.pattern)
        size = size or sheet.natural_size
        bands = render_maps(sheet, appearance, size=size, key=jax.random.key(self.seed))
        folder = prepare_folder(self.output)
        write_maps(folder, progress(bands, "rendering maps", total=count_bands(size)), size=size)
        print(f"{folder}: maps of {size[0]} x {size[1]} pixels, {sheet.columns:g} x {sheet.rows} tiles")
        stretched = size[0] / size[1] / (sheet.width / sheet.height)
        if abs(stretched - 1) > 0.01:
            fitting = f"{size[0]}x{max(round(size[0] * sheet.height / sheet.width), 1)}"
            print(f"  note: tiles are drawn {stretched:.2f} times as wide for their height; --size {fitting} would not")
        for change in sheet.changes:
            print(f"  so that they repeat without a seam, {change}")
