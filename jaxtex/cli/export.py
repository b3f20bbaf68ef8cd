"""`jaxtex export`: a model file as one file that viewers, engines and modellers open."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

if TYPE_CHECKING:
    from jaxtex.cli.model_maps import ModelMaps
    from jaxtex.io.meshes import TexturedMesh
    from jaxtex.models.files import ModelFile

_LONGEST_SIDE = 2048  # of textures, unless told
_WIDTH = 2.0  # metres of the world that a texture shows, where nobody knows


@dataclass(frozen=True, kw_only=True)
class Export:
    """Make a .glb file (binary glTF 2.0) of a model file: a wall, a floor or a mesh of yours with its material on it,
    as Blender, game engines and viewers open it. Base colour, normals, roughness and what else the model knows are in
    it as textures.

    A tiling's textures repeat without a seam where its bond allows; then as many tiles as that takes are shown.

    Example: jaxtex export wall/model.json -o wall.glb --width 3 --repeat 2x1

    Example: jaxtex export oak/model.json -o chair.glb --on chair.obj
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
    seed: int = 0
    """Tilings: of the colours of tiles that the photograph does not show."""

    def run(self) -> int:
        from jaxtex.cli.values import check_seed, parse_repeats, parse_size, parse_tiles

        size = None if self.size is None else parse_size("--size", self.size)
        tiles = None if self.tiles is None else parse_tiles("--tiles", self.tiles)
        repeat = parse_repeats("--repeat", self.repeat)
        check_seed(self.seed)
        self._check_width()

        from jaxtex.cli.mixture_maps import open_mixture, read_parts
        from jaxtex.cli.model_maps import SheetOptions, open_maps, refuse
        from jaxtex.cli.progress import progress
        from jaxtex.io.files import place_for_file
        from jaxtex.material.bands import count_bands
        from jaxtex.material.packing import pack_maps
        from jaxtex.material.scene import Scene, find_writer
        from jaxtex.models.files import TilingFile, load_any
        from jaxtex.models.floor_files import FloorFile
        from jaxtex.models.mixture_files import MixtureFile

        write = find_writer(place_for_file(self.output))
        file = load_any(self.model)
        options = SheetOptions(tiles, seamless=True, seed=self.seed, seams_allowed=True)
        if isinstance(file, MixtureFile):
            parts = read_parts(self.model, file)
            file, maps = parts.base, open_mixture(self.model, parts, size=size, longest=_LONGEST_SIDE, options=options)
        else:
            if not isinstance(file, TilingFile):
                what = "a floor" if isinstance(file, FloorFile) else "wood, which has no tiles"
                refuse(self.model, {"--tiles": tiles}, what)
            maps = open_maps(self.model, file, size=size, longest=_LONGEST_SIDE, options=options)
        mesh, told = self._lay(file, maps, repeat)
        images = pack_maps(progress(maps.bands, "rendering maps", total=count_bands(maps.size)), size=maps.size)
        write(self.output, Scene(mesh, images, repeat, name=self.output.stem))
        print(f"{self.output}: {told}, textures of {maps.size[0]} x {maps.size[1]} pixels, {maps.shown}")
        self._print_notes(file, maps, repeat)
        return 0

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

    def _lay(self, file: "ModelFile", maps: "ModelMaps", repeat: tuple[int, int]) -> "tuple[TexturedMesh, str]":
        """What the material is put on, and what that is in words."""
        from jaxtex.io.meshes import floor_mesh, read_textured_mesh, wall_mesh

        if self._is_mesh:
            mesh = read_textured_mesh(self.on)
            return mesh, f"{len(mesh.faces)} triangles of {self.on}"
        shown = self.width or _width_of(file, maps) or _WIDTH
        width, height = shown * repeat[0], shown * maps.extent[1] / maps.extent[0] * repeat[1]
        make = wall_mesh if self.on == "wall" else floor_mesh
        return make(width, height), f"a {self.on} of {width:.3g} x {height:.3g} m"

    def _print_notes(self, file: "ModelFile", maps: "ModelMaps", repeat: tuple[int, int]) -> None:
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
