"""`jaxtex solid-slice`: a picture of a solid texture, cut by a plane or seen as a block."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

import tyro

if TYPE_CHECKING:
    from jaxtex.models.solid import Solid

Vector = tuple[float, float, float]

_UNITS: dict[str, Vector] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_ACROSS_AND_DOWN = {"x": ("y", "z"), "y": ("x", "z"), "z": ("x", "y")}  # of a slice's picture
_OF_BLOCKS = 512, 512  # pixels of their pictures


class _Plane(NamedTuple):
    origin: Vector
    across: Vector
    down: Vector
    size: tuple[int, int]


@dataclass(frozen=True, kw_only=True)
class SolidSlice:
    """Cut a solid texture by a plane, or draw its block with a corner cut away (--block).

    Points are x,y,z in voxels from the block's corner: x right, y down, z away. A slice across z shows x to the right
    and y down, one across y x and z, one across x y and z. Beyond the block, the texture repeats. By default the middle
    slice across z.

    Example: jaxtex solid-slice oak.npz -o slice.png --axis y --at 10

    Example: jaxtex solid-slice oak.npz -o cut.png --origin 0,0,64 --across 0.7,0,-0.7 --down 0,1,0 --size 256x256

    Example: jaxtex solid-slice oak.npz -o oak.png --block
    """

    voxels: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="BLOCK")]
    """The block of voxels, .npz, as 'jaxtex solid' or 'jaxtex render --block' writes it."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The picture to write: .png, .jpg, .tif or .exr."""
    axis: Annotated[Literal["x", "y", "z"] | None, tyro.conf.arg(help_behavior_hint="")] = None
    """Show a slice of voxels across this axis."""
    at: Annotated[int | None, tyro.conf.arg(metavar="VOXEL", help_behavior_hint="")] = None
    """Which slice, from 0. By default the middle one."""
    origin: Annotated[str | None, tyro.conf.arg(metavar="X,Y,Z", help_behavior_hint="")] = None
    """An oblique cut: where the picture's upper left corner lies. By default at 0,0,0."""
    across: Annotated[str | None, tyro.conf.arg(metavar="X,Y,Z", help_behavior_hint="")] = None
    """An oblique cut: the way from a pixel to the next on its right. 1,0,0 is one voxel; shorter steps enlarge."""
    down: Annotated[str | None, tyro.conf.arg(metavar="X,Y,Z", help_behavior_hint="")] = None
    """An oblique cut: the way from a pixel to the next below."""
    block: bool = False
    """Draw the block from outside instead."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WxH", help_behavior_hint="")] = None
    """Size of the picture in pixels. By default a slice is as large as the block, an oblique cut a square of the
    block's longest side, and a picture of the block 512x512."""
    vary: Annotated[int | None, tyro.conf.arg(metavar="SEED", help_behavior_hint="")] = None
    """Repeat the block at random offsets, so that no period shows: for textures without long lines, such as granite.
    Another number, another piece. By default it repeats as it is."""

    def run(self) -> int:
        from jaxtex.cli.solids import read_solid
        from jaxtex.cli.values import naming, parse_size
        from jaxtex.io.files import place_for_file
        from jaxtex.io.images import write_image

        self._check_options()
        size = None if self.size is None else parse_size("--size", self.size)
        vectors = self._parse_vectors()
        place_for_file(self.output)
        solid = read_solid(self.voxels, vary=self.vary)

        from jaxtex.material.solid import cut_solid, draw_block

        with naming(self.voxels):
            if self.block:
                picture = draw_block(solid, size=size or _OF_BLOCKS)
            else:
                plane = self._place_slice(solid, size) if not vectors else _place_cut(solid, vectors, size)
                picture = cut_solid(solid, **plane._asdict())
        write_image(self.output, picture)
        print(f"{self.output}: {picture.shape[1]} x {picture.shape[0]} pixels")
        return 0

    def _check_options(self) -> None:
        from jaxtex.core.errors import InputError

        kinds = ("block",), ("axis", "at"), ("origin", "across", "down")
        given = [[f"--{name}" for name in kind if getattr(self, name) not in (None, False)] for kind in kinds]
        if len(asked := [options[0] for options in given if options]) > 1:
            raise InputError(f"{' and '.join(asked)}: ask for different pictures; give one of them")
        if (self.across is None) != (self.down is None) or (self.origin is not None and self.across is None):
            raise InputError("--across and --down: an oblique cut takes both; give the two directions of the picture")

    def _parse_vectors(self) -> dict[str, Vector]:
        """Of an oblique cut; none for other pictures."""
        from jaxtex.cli.values import parse_vector

        words = {"origin": self.origin, "across": self.across, "down": self.down}
        return {name: parse_vector(f"--{name}", word) for name, word in words.items() if word is not None}

    def _place_slice(self, solid: "Solid", size: tuple[int, int] | None) -> _Plane:
        from jaxtex.core.errors import InputError

        sides = dict(zip("xyz", solid.size, strict=True))
        axis = self.axis or "z"
        across, down = _ACROSS_AND_DOWN[axis]
        at = sides[axis] // 2 if self.at is None else self.at
        if not 0 <= at < sides[axis]:
            raise InputError(f"--at: there is no slice {at} across {axis}; give 0 to {sides[axis] - 1}")
        x, y, z = ((at + 0.5) * component for component in _UNITS[axis])
        return _Plane((x, y, z), _UNITS[across], _UNITS[down], size or (sides[across], sides[down]))


def _place_cut(solid: "Solid", vectors: dict[str, Vector], size: tuple[int, int] | None) -> _Plane:
    longest = max(solid.size)
    return _Plane(
        vectors.get("origin", (0.0, 0.0, 0.0)), vectors["across"], vectors["down"], size or (longest, longest)
    )
