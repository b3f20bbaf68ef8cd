"""`jaxtex rectify`: straighten a photograph from four corners."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro


@dataclass(frozen=True)
class Rectify:
    """Straighten a photograph: the rectangle between four corners, seen in perspective, becomes an upright picture.

    Mark the corners of something that is a rectangle in the world: a wall, a window, a block of tiles. The larger it
    is in the photograph, the better. What is marked is cut out; what lies outside is left away.

    Example: jaxtex rectify wall.jpg --corners 102,80 900,130 870,700 60,640 -o upright.png
    """

    photo: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="PHOTO")]
    """The photograph."""
    corners: Annotated[tuple[str, str, str, str], tyro.conf.arg(metavar="X,Y X,Y X,Y X,Y")]
    """The four corners in pixels from the photograph's top left corner (x to the right, y down), in any order."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The picture to write: .png, .jpg, .tif or .exr."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WxH", help_behavior_hint="")] = None
    """Its size in pixels; give it where you know the real proportions. By default as long as the marked edges are."""

    def run(self) -> int:
        from jaxtex.cli.values import parse_point, parse_size
        from jaxtex.io.images import read_image, write_image
        from jaxtex.photo.rectify import rectify

        corners = [parse_point("--corners", word) for word in self.corners]
        size = None if self.size is None else parse_size("--size", self.size)
        upright, _ = rectify(read_image(self.photo).pixels, corners, size=size)
        write_image(self.output, upright)
        print(f"{self.output}: {upright.shape[1]} x {upright.shape[0]} pixels")
        return 0
