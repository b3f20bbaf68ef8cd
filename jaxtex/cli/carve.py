"""`jaxtex carve`: a mesh carved of a solid texture."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro


@dataclass(frozen=True, kw_only=True)
class Carve:
    """Carve a mesh of a solid texture: each vertex gets the colour of the block of voxels where it lies.

    The middle of the mesh is put to the middle of the block. The mesh's axes are x right, y up, z towards the viewer;
    the block's are x right, y down, z away. Beyond the block, the texture repeats. The finer the mesh, the more it
    shows: detail finer than its triangles fades.

    Example: jaxtex carve granite.npz --mesh bunny.ply -o granite_bunny.ply

    Example: jaxtex carve granite.npz --mesh statue.obj -o statue.glb --scale 4 --vary 1
    """

    block: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="BLOCK")]
    """The block of voxels, .npz, as 'jaxtex solid' or 'jaxtex render --block' writes it."""
    mesh: Path
    """The mesh: PLY, OBJ, STL, GLB ..."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The mesh to write, with a colour to each vertex: .ply (8-bit sRGB) or .glb."""
    scale: float = 1.0
    """How many times as long as the block the mesh's bounding box is, by the longest sides of both. Larger numbers make
    the texture finer."""
    vary: Annotated[int | None, tyro.conf.arg(metavar="SEED", help_behavior_hint="")] = None
    """Repeat the block at random offsets, so that no period shows: for textures without long lines, such as granite.
    Another number, another piece. By default it repeats as it is."""

    def run(self) -> int:
        from jaxtex.cli.solids import read_solid
        from jaxtex.core.errors import InputError
        from jaxtex.io.files import place_for_file

        kind = self.output.suffix.lower()
        if kind not in (".ply", ".glb"):
            raise InputError(f"{self.output}: cannot be written as '{self.output.suffix}'; name it .ply or .glb")
        place_for_file(self.output)
        solid = read_solid(self.block, vary=self.vary)

        from jaxtex.io.gltf import write_coloured_glb
        from jaxtex.io.meshes import read_mesh, write_mesh
        from jaxtex.material.solid import carve_solid

        mesh = read_mesh(self.mesh)
        try:
            colours = carve_solid(solid, mesh, scale=self.scale)
        except InputError as error:
            raise InputError(f"{self.mesh} carved of {self.block}: {error}") from None
        (write_mesh if kind == ".ply" else write_coloured_glb)(self.output, mesh, colours)
        print(f"{self.output}: a mesh of {len(mesh.vertices)} coloured vertices")
        return 0
