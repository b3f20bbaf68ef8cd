"""`jaxtex carve`: a mesh carved of a solid texture, with a colour to each vertex or with a picture laid on it."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from jaxtex.core.errors import InputError

if TYPE_CHECKING:
    from jaxtex.io.meshes import Mesh
    from jaxtex.models.solid import Solid

_BYTES = 90  # that each pixel of a texture takes at the most


@dataclass(frozen=True, kw_only=True)
class Carve:
    """Carve a mesh of a solid texture: each vertex gets the colour of the block of voxels where it lies, or --texture
    lays a picture on the mesh each of whose pixels does.

    The middle of the mesh is put to the middle of the block. The mesh's axes are x right, y up, z towards the viewer;
    the block's are x right, y down, z away. Beyond the block, the texture repeats. Detail finer than what is
    coloured fades: the finer the mesh or the larger the picture, the more shows.

    Example: jaxtex carve granite.npz --mesh bunny.ply -o granite_bunny.ply

    Example: jaxtex carve granite.npz --mesh statue.obj -o statue.glb --scale 4 --vary 1

    Example: jaxtex carve granite.npz --mesh statue.obj -o statue.glb --texture 2048
    """

    block: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="BLOCK")]
    """The block of voxels, .npz, as 'jaxtex solid' or 'jaxtex render --block' writes it."""
    mesh: Path
    """The mesh: PLY, OBJ, STL, GLB ..."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The mesh to write: .glb, or with a colour to each vertex also .ply (8-bit sRGB)."""
    texture: Annotated[int | None, tyro.conf.arg(metavar="PIXELS", help_behavior_hint="")] = None
    """Lay a square picture of so many pixels to a side on the mesh instead of colouring its vertices. The mesh is
    unwrapped by the package xatlas (pip install 'jaxtex[bake]'), which takes about a second for 10 000 triangles and
    does not tell how far it is."""
    scale: float = 1.0
    """How many times as long as the block the mesh's bounding box is, by the longest sides of both. Larger numbers make
    the texture finer."""
    vary: Annotated[int | None, tyro.conf.arg(metavar="SEED", help_behavior_hint="")] = None
    """Repeat the block at random offsets, so that no period shows: for textures without long lines, such as granite.
    Another number, another piece. By default it repeats as it is."""

    def run(self) -> int:
        from jaxtex.cli.solids import read_solid
        from jaxtex.cli.values import naming

        self._check()
        solid = read_solid(self.block, vary=self.vary)

        from jaxtex.io.meshes import read_mesh

        mesh = read_mesh(self.mesh)
        with naming(f"{self.mesh} carved of {self.block}"):
            (self._colour if self.texture is None else self._bake)(solid, mesh)
        return 0

    def _check(self) -> None:
        from jaxtex.cli.values import check_memory
        from jaxtex.io.files import place_for_file

        kind = self.output.suffix.lower()
        if kind not in (".ply", ".glb"):
            raise InputError(f"{self.output}: cannot be written as '{self.output.suffix}'; name it .ply or .glb")
        if self.output.resolve() == self.mesh.resolve():
            raise InputError(f"{self.output}: is the mesh to carve; give the carved one another name")
        place_for_file(self.output)
        if self.texture is None:
            return
        if kind != ".glb":
            raise InputError(f"--texture: {self.output} would hold no picture; name it .glb")

        from jaxtex.material.baking import LARGEST_SIDE, SMALLEST_SIDE

        if not SMALLEST_SIDE <= self.texture <= LARGEST_SIDE:
            raise InputError(f"--texture: {self.texture} is out of range; give {SMALLEST_SIDE} to {LARGEST_SIDE}")
        check_memory(f"--texture: {self.texture}", _BYTES * self.texture**2)

    def _colour(self, solid: "Solid", mesh: "Mesh") -> None:
        from jaxtex.io.gltf import write_coloured_glb
        from jaxtex.io.meshes import write_mesh
        from jaxtex.material.solid import carve_solid

        colours = carve_solid(solid, mesh, scale=self.scale)
        (write_mesh if self.output.suffix.lower() == ".ply" else write_coloured_glb)(self.output, mesh, colours)
        print(f"{self.output}: a mesh of {len(mesh.vertices)} coloured vertices")

    def _bake(self, solid: "Solid", mesh: "Mesh") -> None:
        from jaxtex.cli.progress import reporting
        from jaxtex.io.gltf import MaterialImages, write_glb
        from jaxtex.io.images import to_bytes
        from jaxtex.material.baking import bake_solid

        assert self.texture is not None
        with reporting(f"making {self.output}") as report:
            baked = bake_solid(solid, mesh, side=self.texture, scale=self.scale, report=report)
        write_glb(self.output, baked.mesh, MaterialImages(to_bytes(baked.picture, colour_space="srgb")), name="mesh")
        print(
            f"{self.output}: a mesh of {len(mesh.faces)} triangles, its texture {self.texture} x {self.texture} pixels"
        )
        print(f"  a pixel is {baked.texel:.2g} voxels long")
