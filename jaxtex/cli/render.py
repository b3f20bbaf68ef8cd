"""`jaxtex render`: material maps of a model file, at any resolution; of wood, blocks and carved meshes too."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

if TYPE_CHECKING:
    from jaxtex.cli.model_maps import ModelMaps, SheetOptions
    from jaxtex.material.finish import WoodFinish
    from jaxtex.models.floor_files import FloorFile
    from jaxtex.models.mixture_files import MixtureFile


Switch = Annotated[tyro.conf.FlagCreatePairsOff[bool], tyro.conf.arg(help_behavior_hint="")]


@dataclass(frozen=True, kw_only=True)
class Render:
    """Make the material maps of a model file: basecolor.png, height.exr, normal.png, roughness.png, specular.png,
    metallic.png, of tilings and floors tile_id.exr, and of tilings occlusion.png. Of wood, a block of voxels (--block)
    or a carved mesh (--mesh) instead.

    Of a tiling, courses come out horizontal, without perspective. Tiles that the photograph shows have their own
    colours; others get colours like these. Of wood, pixels are square, and maps taller than the photograph show more
    wood; late wood stands a little higher than early wood, as on a brushed plank. Normals are OpenGL's (+Y up); heights
    are in pixels of the photograph.

    Example: jaxtex render wall/model.json -o maps --size 4096x4096 --tiles 10x20 --seamless

    Example: jaxtex render oak/model.json -o carved --mesh bunny.ply
    """

    model: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="MODEL")]
    """The model file, as 'jaxtex fit' or 'jaxtex mix' writes it."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"], metavar="FOLDER")]
    """The folder for the results; it is made if there is none."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WxH", help_behavior_hint="")] = None
    """Size of the maps in pixels. Maps of a tiling cover the tiles exactly: pixels are square where width and height
    are to each other as the tiles' are. Maps of wood are as wide as the photographed plank. By default as large as in
    the photograph."""
    tiles: Annotated[str | None, tyro.conf.arg(metavar="CxR", help_behavior_hint="")] = None
    """Tilings: how many tiles to show: columns (of mean length, where tiles differ) and rows. By default as many as the
    photograph."""
    seamless: Switch = False
    """Tilings: make maps that repeat without a seam: whole periods of the bond, at least the tiles asked for. Mixtures
    repeat where they have no layers."""
    no_fill: Switch = False
    """Leave tiles and joints flat, each of one colour; of floors, leave planks with the rings of their model alone."""
    finish: Annotated[tuple[str, ...], tyro.conf.arg(metavar="PART=FINISH [...]", help_behavior_hint="")] = ()
    """What tiles and joints of tilings, and early and late wood, are finished with, such as tile=varnish joint=dull.
    Finishes are dull, satin, varnish, wet and mirror."""
    seed: int = 0
    """Tilings: of the colours of tiles that the photograph does not show, and of interiors."""
    block: Annotated[str | None, tyro.conf.arg(metavar="DxHxW", help_behavior_hint="")] = None
    """Wood: make voxels.npz, a block of so many voxels (depth, height, width), each as large as a pixel of the
    photograph; its array 'voxels' [z, y, x, channel] holds linear colours as float32. The first slice is the
    photographed face."""
    mesh: Annotated[Path | None, tyro.conf.arg(metavar="FILE", help_behavior_hint="")] = None
    """Wood: make mesh.ply, this mesh (PLY, OBJ, STL, GLB ...) carved of the wood: a colour to each vertex. Its bounding
    box is put in the middle of the photograph, and made as long as that."""

    def run(self) -> int:
        from jaxtex.cli.render_wood import WoodTask, render_wood_file
        from jaxtex.cli.values import check_seed, parse_block, parse_counts, parse_finishes, parse_size

        size = None if self.size is None else parse_size("--size", self.size)
        tiles = None if self.tiles is None else parse_counts("--tiles", self.tiles, "tiles")
        block = None if self.block is None else parse_block("--block", self.block)
        finishes = parse_finishes("--finish", self.finish)
        check_seed(self.seed)

        from jaxtex.cli.model_maps import SheetOptions, open_maps, refuse
        from jaxtex.material.finish import finish_wood
        from jaxtex.models.files import TilingFile, load_any
        from jaxtex.models.floor_files import FloorFile
        from jaxtex.models.mixture_files import MixtureFile

        file = load_any(self.model)
        of_tilings = {"--tiles": tiles, "--seamless": self.seamless or None}
        options = SheetOptions(tiles, self.seamless, self.seed, fill=not self.no_fill, finishes=finishes)
        if isinstance(file, MixtureFile):
            refuse(self.model, {"--block": block, "--mesh": self.mesh}, "a mixture; it is for wood")
            return self._render_mixture(file, size, options)
        if isinstance(file, TilingFile):
            refuse(self.model, {"--block": block, "--mesh": self.mesh}, "a tiling; it is for wood")
            self._write_maps(open_maps(self.model, file, size=size, options=options))
        elif isinstance(file, FloorFile):
            refuse(self.model, of_tilings, "a floor")
            refuse(self.model, {"--block": block, "--mesh": self.mesh}, "a floor")
            self._render_floor(file, size, finish_wood(finishes))
        else:
            refuse(self.model, of_tilings | {"--no-fill": self.no_fill or None}, "wood, which has no tiles")
            render_wood_file(file, self.output, WoodTask(size, block, self.mesh, finishes))
        if not file.report["ok"]:
            print(f"  note: this model is a best guess; its fit did not succeed: {file.report['reason']}")
        return 0

    def _render_floor(self, file: "FloorFile", size: tuple[int, int] | None, finish: "WoodFinish") -> None:
        from jaxtex.cli.results_floor import write_floor_maps
        from jaxtex.io.files import prepare_folder
        from jaxtex.material.interior_files import interiors_of_planks

        width, height = size or (file.image.width, file.image.height)
        interiors = None if self.no_fill else interiors_of_planks(self.model, file)
        folder = prepare_folder(self.output)
        write_floor_maps(folder, file, interiors, size=(width, height), finish=finish)
        print(f"{folder}: maps of {width} x {height} pixels, {len(file.planks)} planks")

    def _render_mixture(self, file: "MixtureFile", size: tuple[int, int] | None, options: "SheetOptions") -> int:
        from jaxtex.cli.mixture_maps import open_mixture, read_parts

        parts = read_parts(self.model, file)
        self._write_maps(open_mixture(self.model, parts, size=size, options=options))
        for source, reason in parts.doubts():
            print(f"  note: {source} is a best guess; its fit did not succeed: {reason}")
        return 0

    def _write_maps(self, maps: "ModelMaps") -> None:
        from jaxtex.cli.progress import progress
        from jaxtex.io.files import prepare_folder
        from jaxtex.material.bands import count_bands
        from jaxtex.material.export import write_maps

        (width, height), (along, across) = maps.size, maps.extent
        folder = prepare_folder(self.output)
        write_maps(folder, progress(maps.bands, "rendering maps", total=count_bands(maps.size)), size=maps.size)
        print(f"{folder}: maps of {width} x {height} pixels, {maps.shown}")
        stretched = width / height / (along / across)
        if abs(stretched - 1) > 0.01:
            fitting = f"{width}x{max(round(width * across / along), 1)}"
            print(f"  note: tiles are drawn {stretched:.2f} times as wide for their height; --size {fitting} would not")
        for change in maps.changes:
            print(f"  so that they repeat without a seam, {change}")
