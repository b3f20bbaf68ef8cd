"""`jaxtex mask ...`: make a mask of tiles and joints from a photograph, or clean one (Lefebvre & Poulin, section 2)."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

if TYPE_CHECKING:
    import numpy as np

Photo = Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="PHOTO")]
Mask = Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="MASK")]
Output = Annotated[Path, tyro.conf.arg(aliases=["-o"])]
# Left out unless wanted: what happens then is said in the help itself.
MaybePath = Annotated[Path | None, tyro.conf.arg(metavar="PATH", help_behavior_hint="")]
MaybeNumber = Annotated[float | None, tyro.conf.arg(metavar="FLOAT", help_behavior_hint="")]
Switch = Annotated[tyro.conf.FlagCreatePairsOff[bool], tyro.conf.arg(help_behavior_hint="")]


@dataclass(frozen=True, kw_only=True)
class _Making(ABC):
    """A command that makes a mask of a photograph."""

    photo: Photo
    """The photograph."""
    output: Output
    """The mask to write: white on tiles, black on joints."""
    overlay: MaybePath = None
    """A picture to write for looking: the mask's outline and joints in cyan over the photograph."""

    @abstractmethod
    def make(self, pixels: "np.ndarray") -> "np.ndarray":
        """The mask of linear pixels."""

    def run(self) -> int:
        from jaxtex.cli.values import naming_options
        from jaxtex.io.images import read_image

        pixels = read_image(self.photo).pixels
        with naming_options(self, self.photo):
            mask = self.make(pixels)
        return _write(self.output, mask, self.overlay, pixels)


@dataclass(frozen=True, kw_only=True)
class _Cleaning(ABC):
    """A command that makes a mask of a mask."""

    mask: Mask
    """The mask to clean: white on tiles, black on joints."""
    output: Output
    """The mask to write; it may be the same file."""
    photo: MaybePath = None
    """The photograph to lay the outline over; without it, the overlay shows what has changed in the mask."""
    overlay: MaybePath = None
    """A picture to write for looking: the new mask's outline and joints in cyan."""

    @abstractmethod
    def clean(self, mask: "np.ndarray") -> "np.ndarray":
        """The cleaned mask."""

    def run(self) -> int:
        from jaxtex.cli.values import naming_options
        from jaxtex.io.images import read_image
        from jaxtex.io.masks import read_mask

        coverage = read_mask(self.mask)
        ground = coverage if self.photo is None else read_image(self.photo).pixels
        with naming_options(self, self.mask):
            mask = self.clean(coverage >= 0.5)
        return _write(self.output, mask, self.overlay, ground)


@dataclass(frozen=True, kw_only=True)
class Threshold(_Making):
    """Make a mask by lightness: where joints are darker, or lighter, than every tile.

    The quickest tool, and the right one for most walls. If the mask comes out with tiles black and joints white, say
    --joints light. If one side of the picture fills up, say --even-out.

    Example: jaxtex mask threshold wall.jpg --joints light -o mask.png --overlay look.png
    """

    joints: Literal["dark", "light"] = "dark"
    """Whether the joints are darker or lighter than the tiles."""
    level: MaybeNumber = None
    """The lightness that parts them, 0 (black) to 100 (white); by default the valley of the histogram (Otsu)."""
    even_out: Switch = False
    """Divide slow illumination out of the photograph first."""

    def make(self, pixels: "np.ndarray") -> "np.ndarray":
        from jaxtex.photo.segment import threshold_mask

        return threshold_mask(_lit(pixels, self.even_out), level=self.level, joints=self.joints)


@dataclass(frozen=True, kw_only=True)
class Colour(_Making):
    """Make a mask by colour: click on a few joints, or tiles, and everything that looks alike is of their kind.

    For joints as light as the tiles but of another hue, and for tiles of several colours. Give as many points and
    colours as it takes; raise the tolerance until the joints hang together, then clean with despeckle.

    Example: jaxtex mask colour wall.jpg --at 40,210 312,98 --tolerance 15 -o mask.png
    """

    at: Annotated[tuple[str, ...], tyro.conf.arg(metavar="X,Y [X,Y ...]", help_behavior_hint="")] = ()
    """Points to take colours from, in pixels from the photograph's top left corner (x to the right, y down)."""
    colour: Annotated[tuple[str, ...], tyro.conf.arg(metavar="RRGGBB [RRGGBB ...]", help_behavior_hint="")] = ()
    """Colours, as colour pickers show them: 'b5502f' or '#b5502f'."""
    tolerance: float = 12.0
    """How far a colour may be from a picked one, in Lab: 2 is just visible, 10 a shade, 50 another colour."""
    picked: Literal["joints", "tiles"] = "joints"
    """What you clicked on."""
    even_out: Switch = False
    """Divide slow illumination out of the photograph first."""

    def make(self, pixels: "np.ndarray") -> "np.ndarray":
        import numpy as np

        from jaxtex.cli.values import naming, parse_colour, parse_point
        from jaxtex.core.colour import srgb_to_linear
        from jaxtex.core.errors import InputError
        from jaxtex.photo.pictures import luminance
        from jaxtex.photo.segment import colour_mask, pick_colours

        if not self.at and not self.colour:
            raise InputError("--at, --colour: nothing is picked; give points x,y or colours rrggbb")
        points = [parse_point("--at", word) for word in self.at]
        named = srgb_to_linear(np.array([parse_colour("--colour", word) for word in self.colour]).reshape(-1, 3))
        pixels = _lit(pixels, self.even_out)
        if pixels.shape[-1] == 1:
            named = luminance(named[:, None])
        with naming("--at"):
            picks = [*pick_colours(pixels, points), *named] if points else named
        return colour_mask(pixels, np.array(picks), tolerance=self.tolerance, picked=self.picked)


@dataclass(frozen=True, kw_only=True)
class Sobel(_Making):
    """Make a mask by edges: joint is where colour changes fast.

    For tiles that differ from each other more than from their joints, and for tiles with no joints between them. Each
    joint has two edges; 'jaxtex mask open' with a radius a little over half the joint fills it.

    Example: jaxtex mask sobel floor.jpg -o edges.png
    """

    smooth: float = 1.0
    """Standard deviation, in pixels, of the blur applied first. More of it passes over grain and rounds corners."""
    strength: MaybeNumber = None
    """How fast colour must change, in Lab per pixel; lower gives more edges. By default the picture decides (Otsu)."""

    def make(self, pixels: "np.ndarray") -> "np.ndarray":
        from jaxtex.photo.edges import sobel_edges

        return sobel_edges(pixels, smooth=self.smooth, strength=self.strength)


@dataclass(frozen=True, kw_only=True)
class Pyramid(_Making):
    """Make a mask by the edges that are seen from afar: found on a reduced picture, followed down to full size.

    Passes over grain, pores and scratches that sobel stops at, and draws thin lines. Each joint has two edges;
    'jaxtex mask open' with a radius a little over half the joint fills it.

    Example: jaxtex mask pyramid rough.jpg --levels 3 -o edges.png
    """

    levels: int = 2
    """How often the picture is halved. Each level more passes over details twice as large, at last over joints too."""
    strength: MaybeNumber = None
    """How fast colour must change on the smallest picture; lower gives more edges. By default it decides (Otsu)."""

    def make(self, pixels: "np.ndarray") -> "np.ndarray":
        from jaxtex.photo.edges import pyramid_edges

        return pyramid_edges(pixels, levels=self.levels, strength=self.strength)


@dataclass(frozen=True, kw_only=True)
class Auto(_Making):
    """Make a mask of a tiled surface with nothing said: the lattice is found, and taught what joints look like here.

    For light and dark joints, and for tiles told apart by colour alone. It is what 'jaxtex fit tiling' does when no
    mask is given.

    Example: jaxtex mask auto wall.jpg -o mask.png --overlay look.png
    """

    def make(self, pixels: "np.ndarray") -> "np.ndarray":
        from jaxtex.photo.automask import auto_mask

        return auto_mask(pixels)


@dataclass(frozen=True, kw_only=True)
class Open(_Cleaning):
    """Open a mask: specks of tile, and bridges across joints, that are thinner than a disk become joint.

    Fills the joints of an edge mask. Tiles keep their size, but their corners are rounded.

    Example: jaxtex mask open edges.png --radius 4 -o mask.png
    """

    radius: float
    """Of the disk, in pixels."""

    def clean(self, mask: "np.ndarray") -> "np.ndarray":
        from jaxtex.photo.morphology import open_mask

        return open_mask(mask, self.radius)


@dataclass(frozen=True, kw_only=True)
class Close(_Cleaning):
    """Close a mask: pits and cracks in the tiles that are thinner than a disk become tile.

    Keep the radius below half the thickness of the joints, or these close too.

    Example: jaxtex mask close mask.png --radius 2 -o mask.png
    """

    radius: float
    """Of the disk, in pixels."""

    def clean(self, mask: "np.ndarray") -> "np.ndarray":
        from jaxtex.photo.morphology import close_mask

        return close_mask(mask, self.radius)


@dataclass(frozen=True, kw_only=True)
class Erode(_Cleaning):
    """Erode a mask: tiles lose a rim, joints grow by as much on either side.

    Example: jaxtex mask erode mask.png --radius 1 -o mask.png
    """

    radius: float
    """Breadth of the rim, in pixels."""

    def clean(self, mask: "np.ndarray") -> "np.ndarray":
        from jaxtex.photo.morphology import erode_mask

        return erode_mask(mask, self.radius)


@dataclass(frozen=True, kw_only=True)
class Dilate(_Cleaning):
    """Dilate a mask: tiles gain a rim, joints lose as much on either side.

    Example: jaxtex mask dilate mask.png --radius 1 -o mask.png
    """

    radius: float
    """Breadth of the rim, in pixels."""

    def clean(self, mask: "np.ndarray") -> "np.ndarray":
        from jaxtex.photo.morphology import dilate_mask

        return dilate_mask(mask, self.radius)


@dataclass(frozen=True, kw_only=True)
class Despeckle(_Cleaning):
    """Drop small regions from a mask: first the specks of joint within tiles, then the specks of tile within joints.

    Changes nothing else: outlines of what stays are kept to the pixel.

    Example: jaxtex mask despeckle mask.png --area 200 -o mask.png
    """

    area: int
    """Regions of fewer pixels than this go. A quarter of the smallest tile is safe."""

    def clean(self, mask: "np.ndarray") -> "np.ndarray":
        from jaxtex.photo.morphology import remove_small_regions

        return remove_small_regions(mask, self.area)


def _lit(pixels: "np.ndarray", evenly: bool) -> "np.ndarray":
    from jaxtex.photo.illumination import even_out

    return even_out(pixels)[0] if evenly else pixels


def _write(output: Path, mask: "np.ndarray", overlay: Path | None, ground: "np.ndarray") -> int:
    """Write the mask and, where it is asked for, the overlay: both or neither."""
    from jaxtex.cli.files import write_together
    from jaxtex.core.errors import InputError
    from jaxtex.io.images import write_image
    from jaxtex.io.masks import write_mask
    from jaxtex.photo.overlay import overlay_mask

    writers: dict[Path, Callable[[Path], None]] = {output: lambda path: write_mask(path, mask)}
    if overlay is not None:
        if overlay.absolute() == output.absolute():
            raise InputError(f"{overlay}: is to be both the mask and the overlay; give them two names")
        picture = overlay_mask(ground, mask)
        writers[overlay] = lambda path: write_image(path, picture)
    write_together(writers)
    print(f"{output}: {mask.mean():.0%} tile, {1 - mask.mean():.0%} joint")
    return 0
