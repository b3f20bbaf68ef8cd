"""`jaxtex export`: a model file as one file that viewers, engines and modellers open."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

if TYPE_CHECKING:
    from jaxtex.cli.model_maps import ModelMaps
    from jaxtex.io.meshes import TexturedMesh
    from jaxtex.material.adjacent import Layout
    from jaxtex.models.files import ModelFile, TilingFile

_LONGEST_SIDE = 2048  # of textures, unless told
Switch = Annotated[tyro.conf.FlagCreatePairsOff[bool], tyro.conf.arg(help_behavior_hint="")]

_WIDTH = 2.0  # metres of the world that a texture shows, where nobody knows


@dataclass(frozen=True, kw_only=True)
class Export:
    """Make a .glb file (binary glTF 2.0) of a model file: a wall, a floor or a mesh of yours with its material on it,
    as Blender, game engines and viewers open it. Base colour, normals, roughness and what else the model knows are in
    it as textures.

    A tiling's textures repeat without a seam where its bond allows; then as many tiles as that takes are shown.

    Example: jaxtex export wall/model.json -o wall.glb --width 3 --repeat 2x1

    Example: jaxtex export oak/model.json -o chair.glb --on chair.obj

    Example: jaxtex export wall/model.json -o tower.glb --on tower.obj --tiles-in-row 6
    """

    model: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="MODEL")]
    """The model file, as 'jaxtex fit' or 'jaxtex mix' writes it."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"], metavar="FILE")]
    """The file to write: .glb."""
    on: Annotated[str, tyro.conf.arg(metavar="wall|floor|FILE")] = "wall"
    """What the material is put on: a wall that stands on the ground, a floor, or a mesh with texture coordinates (OBJ,
    GLB, PLY ...), whose lengths are taken for metres."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WxH", help_behavior_hint="")] = None
    """Size of the textures in pixels. By default as large as in the photograph, but at most 2048 to a side."""
    tiles: Annotated[str | None, tyro.conf.arg(metavar="CxR", help_behavior_hint="")] = None
    """Tilings: how many tiles the textures show, as 'jaxtex render' has it."""
    width: Annotated[float | None, tyro.conf.arg(metavar="METRES", help_behavior_hint="")] = None
    """Walls and floors: how wide in the world what the textures show is. By default by the model's scale; 2 metres
    where it has none."""
    repeat: Annotated[str, tyro.conf.arg(metavar="CxR")] = "1x1"
    """How often the textures stand side by side and one above the other; walls and floors become so much larger."""
    tiles_in_row: Annotated[int | None, tyro.conf.arg(metavar="TILES", help_behavior_hint="")] = None
    """Tilings on a mesh: lay one tiling over all its faces, so many tiles along the first of them, instead of using its
    texture coordinates. Courses are level, joints meet at shared edges, and bricks turn the corners."""
    up: Literal["x", "y", "z"] = "y"
    """Which axis points up in the mesh, with --tiles-in-row; in the GLB file it is y."""
    no_fill: Switch = False
    """Leave tiles and joints flat, each of one colour."""
    finish: Annotated[tuple[str, ...], tyro.conf.arg(metavar="PART=FINISH [...]", help_behavior_hint="")] = ()
    """Finishes of tiles and joints, or of early and late wood, as 'jaxtex render' has them."""
    seed: int = 0
    """Tilings: of the colours of tiles that the photograph does not show, and of interiors."""

    def run(self) -> int:
        from jaxtex.cli.values import parse_counts

        repeat = parse_counts("--repeat", self.repeat, "repeats")
        self._check_width()
        self._check_row(repeat)

        from jaxtex.cli.progress import progress
        from jaxtex.io.files import place_for_file
        from jaxtex.material.bands import count_bands
        from jaxtex.material.packing import pack_maps
        from jaxtex.material.scene import Scene, find_writer

        write = find_writer(place_for_file(self.output))
        file, maps, layout = self._open()
        mesh, told = self._lay(file, maps, layout, repeat)
        images = pack_maps(progress(maps.bands, "rendering maps", total=count_bands(maps.size)), size=maps.size)
        write(self.output, Scene(mesh, images, repeat, name=self.output.stem))
        print(f"{self.output}: {told}, textures of {maps.size[0]} x {maps.size[1]} pixels, {maps.shown}")
        self._print_notes(file, maps, layout, repeat)
        return 0

    def _open(self) -> "tuple[ModelFile, ModelMaps, Layout | None]":
        """The model, its maps, and how it is laid over a mesh's faces, if it is."""
        from jaxtex.cli.mixture_maps import open_mixture, read_parts
        from jaxtex.cli.model_maps import SheetOptions, open_maps, refuse
        from jaxtex.cli.values import check_seed, parse_counts, parse_finishes, parse_size
        from jaxtex.models.files import TilingFile, load_any
        from jaxtex.models.floor_files import FloorFile
        from jaxtex.models.mixture_files import MixtureFile

        size = None if self.size is None else parse_size("--size", self.size)
        tiles = None if self.tiles is None else parse_counts("--tiles", self.tiles, "tiles")
        finishes, seed = parse_finishes("--finish", self.finish), check_seed(self.seed)
        options = SheetOptions(tiles, True, seed, seams_allowed=True, fill=not self.no_fill, finishes=finishes)
        file = load_any(self.model)
        if isinstance(file, MixtureFile):
            refuse(self.model, {"--tiles-in-row": self.tiles_in_row}, "several materials")
            parts = read_parts(self.model, file)
            maps = open_mixture(self.model, parts, size=size, longest=_LONGEST_SIDE, options=options)
            return parts.base, maps, None
        layout = None
        if isinstance(file, TilingFile):
            layout = self._lay_row(file)
            options = options._replace(sheet=None if layout is None else layout.sheet)
        else:
            what = "a floor" if isinstance(file, FloorFile) else "wood, which has no tiles"
            refused = {"--tiles": tiles, "--tiles-in-row": self.tiles_in_row}
            refuse(self.model, refused, what)
        return file, open_maps(self.model, file, size=size, longest=_LONGEST_SIDE, options=options), layout

    def _lay_row(self, file: "TilingFile") -> "Layout | None":
        if self.tiles_in_row is None:
            return None
        from jaxtex.cli.values import naming
        from jaxtex.io.meshes import read_mesh
        from jaxtex.material.adjacent import lay_tiling
        from jaxtex.material.appearance import appearance_of

        mesh = read_mesh(self.on)
        faces = list(mesh.vertices[mesh.faces])
        up = [float(axis == self.up) for axis in "xyz"]
        with naming(self.on):
            return lay_tiling(faces, file.tiling, tiles=self.tiles_in_row, pattern=appearance_of(file).pattern, up=up)

    @property
    def _is_mesh(self) -> bool:
        return self.on not in ("wall", "floor")

    def _check_width(self) -> None:
        from jaxtex.core.errors import InputError

        if self.width is None:
            return
        if self._is_mesh:
            raise InputError(f"--width: is for walls and floors; {self.on} has a size of its own")
        if not (math.isfinite(self.width) and self.width > 0):
            raise InputError(f"--width: {self.width:g} is no width; give metres, more than 0")

    def _check_row(self, repeat: tuple[int, int]) -> None:
        from jaxtex.core.errors import InputError

        if self.tiles_in_row is None:
            return
        if not self._is_mesh:
            raise InputError(f"--tiles-in-row: is for meshes; for a {self.on}, give --tiles and --repeat")
        if self.tiles_in_row < 1:
            raise InputError(f"--tiles-in-row: {self.tiles_in_row} is no number of tiles; give 1 or more")
        if self.tiles is not None or repeat != (1, 1):
            raise InputError("--tiles-in-row: lays the tiling by itself; leave out --tiles and --repeat")

    def _lay(
        self, file: "ModelFile", maps: "ModelMaps", layout: "Layout | None", repeat: tuple[int, int]
    ) -> "tuple[TexturedMesh, str]":
        """What the material is put on, and what that is in words."""
        from jaxtex.io.meshes import floor_mesh, read_textured_mesh, turn_mesh, wall_mesh
        from jaxtex.material.adjacent import polygon_mesh

        if layout is not None:
            return turn_mesh(polygon_mesh(layout), up=self.up), f"{len(layout.polygons)} faces of {self.on}"
        if self._is_mesh:
            mesh = read_textured_mesh(self.on)
            return mesh, f"{len(mesh.faces)} triangles of {self.on}"
        shown = self.width or _width_of(file, maps) or _WIDTH
        width, height = shown * repeat[0], shown * maps.extent[1] / maps.extent[0] * repeat[1]
        make = wall_mesh if self.on == "wall" else floor_mesh
        return make(width, height), f"a {self.on} of {width:.3g} x {height:.3g} m"

    def _print_notes(
        self, file: "ModelFile", maps: "ModelMaps", layout: "Layout | None", repeat: tuple[int, int]
    ) -> None:
        if layout is not None:
            from jaxtex.material.mismatch import measure_mismatch

            stretch = layout.stretch[:, 0]
            drawn = f"drawn {stretch.min():.2f} to {stretch.max():.2f} times as long"
            print(f"  tiles are {layout.tile_length:.3g} long, {drawn}")
            print(f"  at shared edges, joints meet to within {measure_mismatch(layout).worst:.1g} of a tile")
        if not self._is_mesh and self.width is None and _width_of(file, maps) is None:
            print(f"  note: what the textures show is taken to be {_WIDTH:g} m wide; --width says otherwise")
        told = "so that they repeat without a seam," if maps.seamless else "note: they repeat with a seam, as"
        for change in maps.changes:
            print(f"  {told} {change}")
        if not maps.seamless and not maps.changes and repeat != (1, 1):
            print(f"  note: textures of {maps.shown} repeat with a seam")
        if not file.report["ok"]:
            print(f"  note: this model is a best guess; its fit did not succeed: {file.report['reason']}")


def _width_of(file: "ModelFile", maps: "ModelMaps") -> float | None:
    """Of what the maps show, in metres, where the model knows."""
    scale = getattr(file, "mm_per_px", None)
    return None if scale is None else scale * maps.extent[0] / 1000
