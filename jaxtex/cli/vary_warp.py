"""`jaxtex vary warp`: a texture whose elements change in shape from place to place."""

import math
import re
import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import tyro

from jaxtex.cli.hints import hint
from jaxtex.core.errors import InputError

if TYPE_CHECKING:
    import numpy as np

    from jaxtex.progressive.varying import VaryingTexture
    from jaxtex.progressive.warping import Direction

_MOST_SCALE = 8.0
_MOST_PIXELS = 1000.0  # that borders move
_MANY_VANISHED = 0.25  # of the elements: hardly meant


class _Growth(NamedTuple):
    pixels: float
    types: tuple[int, ...]
    direction: "Direction"


@dataclass(frozen=True, kw_only=True)
class VaryWarp:
    """Change the shapes of a texture's elements from place to place.

    The exemplar's texton mask (see 'jaxtex texton-mask') is warped, by as much as a transition function says, and a
    texture is made that goes with it (Zhang et al. 2003, section 4.3): where the transition is black, elements are as
    they were; where it is white, they have changed in full. By default it goes from left to right. What is done
    stands in the options below, in this order.

    Example: jaxtex vary warp tiger.png mask.png -o thin.png --size 512x256 --grow=-6:1:horizontal

    Example: jaxtex vary warp leopard.png mask.png -o coat.png --grow=-6:0,1 --grow=4:0 --save coat.npz

    Example: jaxtex vary warp cheese.png mask.png -o old.png --scale 2 --turn 45 --keys age.toml
    """

    exemplar: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="EXEMPLAR")]
    """The picture of the texture, seen straight on and evenly lit."""
    mask: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="MASK")]
    """Its texton mask, of its size: two to four values, the darkest of which is type 0, what is around elements."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The picture to write: .png, .jpg, .tif or .exr."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WxH", help_behavior_hint="")] = None
    """Its size in pixels. By default the exemplar's, with its elements where they are there; of a larger one, elements
    are laid out anew, as many more as it takes."""
    scale: Annotated[float | None, tyro.conf.arg(metavar="S", help_behavior_hint="")] = None
    """Make each element so many times as large, about its centre. Elements that would meet bend each other."""
    turn: Annotated[float | None, tyro.conf.arg(metavar="DEGREES", help_behavior_hint="")] = None
    """Turn each element about its centre, clockwise."""
    displace: Annotated[Path | None, tyro.conf.arg(metavar="FIELD", help_behavior_hint="")] = None
    """Bend all of it: a picture whose first two channels say how many pixels right and down of each pixel lies what it
    is to show (.exr). A small picture is a mesh, whose nodes are spread over the mask."""
    grow: Annotated[
        tyro.conf.UseAppendAction[tuple[str, ...]],
        tyro.conf.arg(metavar="PIXELS[:TYPES[:DIRECTION]]", help_behavior_hint=""),
    ] = ()
    """Move borders of elements outwards, or, below 0, inwards: by how many pixels; of which types, as 0,1 (all but 0 by
    default), borders between which stay; and whether 'horizontal' or 'vertical' alone. Give it again for more, done one
    after the other. Write --grow=-6, with =, where it is below 0."""
    transition: Annotated[Path | None, tyro.conf.arg(metavar="PICTURE", help_behavior_hint="")] = None
    """How far the change is where: a grey picture, black for not at all, white for in full, stretched over the
    result."""
    keys: Annotated[Path | None, tyro.conf.arg(metavar="KEYS.toml", help_behavior_hint="")] = None
    """Keys of the transition, as 'jaxtex field' takes them, instead of a picture."""
    neighborhood: int = 7
    """Side of the squares of pixels that are compared, an odd number."""
    mask_output: Annotated[Path | None, tyro.conf.arg(metavar="FILE", help_behavior_hint="")] = None
    """Write the warped mask, too."""
    save: Annotated[Path | None, tyro.conf.arg(metavar="V.npz", help_behavior_hint="")] = None
    """Write the texture with its mask and transition, as synthesis on meshes reads it."""
    seed: int = 0
    """Another number, other pieces of the texture."""

    def run(self) -> int:
        from jaxtex.cli import varying
        from jaxtex.cli.values import check_seed

        check_seed(self.seed)
        radius = varying.check_neighborhood(self.neighborhood)
        growths = [_parse_growth(word) for word in self.grow]
        self._check(bool(growths))
        inputs = [self.exemplar, self.mask, self.displace, self.transition]
        varying.check_files(inputs, [self.output, self.mask_output], self.save, self.keys)
        pixels = varying.read_exemplar(self.exemplar, self.neighborhood)
        labels = varying.read_mask_of(self.mask, self.exemplar, pixels)
        size = (labels.shape[1], labels.shape[0]) if self.size is None else varying.parse_made_size(self.size)
        _check_types(self.mask, labels, growths)
        if any(_shrinks(each) for each in growths):
            self._hint(labels)
        transition = varying.read_transition(self.transition, self.keys, size)
        made = self._make(pixels, labels, transition, growths, radius)
        varying.write_results(self.output, made, save=self.save, mask=self.mask_output)
        return 0

    def _hint(self, labels: "np.ndarray") -> None:
        """Tell of pinholes, which become holes where elements shrink."""
        from jaxtex.progressive.mask_measures import PINHOLE, count_holes, count_small_regions

        holes, pinholes = count_holes(labels)
        if not pinholes:
            return
        counted = f"{pinholes} {'pinhole' if pinholes == 1 else 'pinholes'}"
        told = f"{self.mask} has {counted} in its elements, of which holes are made"
        how = ["--fill"] if pinholes == holes else ["--despeckle", f"{PINHOLE}"]
        if pinholes == holes or pinholes == count_small_regions(labels, PINHOLE):
            other = self.mask.with_name(f"{self.mask.stem}_filled.png")
            words = ["jaxtex", "texton-mask", f"{self.exemplar}", "--painted", f"{self.mask}", *how, "-o", f"{other}"]
            told += f"; fill them first, as by: {shlex.join(words)}"
        hint(told)

    def _hint_vanished(self, laid: "np.ndarray", wanted: "np.ndarray") -> None:
        from jaxtex.progressive.mask_measures import count_vanished

        vanished, count = count_vanished(laid, wanted)
        if vanished > _MANY_VANISHED * count:
            told = f"--grow: {vanished} of {count} elements are so narrow that they vanish; shrink them less"
            hint(f"{told}, or a larger exemplar")

    def _make(
        self,
        pixels: "np.ndarray",
        labels: "np.ndarray",
        transition: "np.ndarray",
        growths: list[_Growth],
        radius: int,
    ) -> "VaryingTexture":
        import jax

        from jaxtex.cli.varying import filter_exemplar, lay_out
        from jaxtex.progressive.varying import VaryingTexture
        from jaxtex.synthesis.anisometric import sample_sources

        keys = jax.random.split(jax.random.key(self.seed))
        laid = lay_out(f"making more of {self.mask}", pixels, labels, transition.shape[::-1], keys[0])
        wanted = self._warp(laid, transition, growths)
        if wanted.max() == wanted.min():
            raise InputError(f"{self.mask}: only one type would be left of it; grow, shrink or bend it less")
        if growths:
            self._hint_vanished(laid, wanted)
        sources = filter_exemplar(f"making {self.output}", pixels, labels, wanted, keys[1], radius)
        return VaryingTexture.of(sample_sources(pixels, sources), mask=wanted, transition=transition)

    def _check(self, grows: bool) -> None:
        if not grows and self.scale is None and self.turn is None and self.displace is None:
            raise InputError("nothing is changed; give --grow, --scale, --turn or --displace")
        if self.scale is not None and not 1 / _MOST_SCALE <= self.scale <= _MOST_SCALE:
            raise InputError(f"--scale: {self.scale:g} is out of range; give {1 / _MOST_SCALE} to {_MOST_SCALE:g}")
        if self.turn is not None and not math.isfinite(self.turn):
            raise InputError(f"--turn: {self.turn:g} is none; give degrees")

    def _warp(self, labels: "np.ndarray", transition: "np.ndarray", growths: list[_Growth]) -> "np.ndarray":
        import numpy as np

        from jaxtex.progressive.warping import displace_elements, grow_mask, warp_mask

        if self.scale is not None or self.turn is not None:
            scale, turn = (self.scale or 1.0) ** transition, np.radians(self.turn or 0.0) * transition
            labels = warp_mask(labels, displace_elements(labels, scale=scale, turn=turn))
        if self.displace is not None:
            labels = warp_mask(labels, _read_displacement(self.displace, labels.shape) * transition[..., None])
        for growth in growths:
            labels = grow_mask(labels, growth.pixels * transition, types=growth.types, direction=growth.direction)
        return labels


def _check_types(path: Path, labels: "np.ndarray", growths: list[_Growth]) -> None:
    there = sorted(set(labels.ravel().tolist()))
    for growth in growths:
        if not set(growth.types) & set(there):
            named = " or ".join(map(str, growth.types))
            raise InputError(f"--grow: {path} has no type {named}; it has {', '.join(map(str, there))}")


def _shrinks(growth: _Growth) -> bool:
    """Whether elements lose to what is around them, so that holes in them grow."""
    return growth.pixels > 0 if 0 in growth.types else growth.pixels < 0


def _parse_growth(word: str) -> _Growth:
    match = re.fullmatch(
        r"([+-]?(?:\d+\.?\d*|\.\d+))(?::([0-3](?:,[0-3])*)(?::(all|horizontal|vertical))?)?", word.strip()
    )
    if not match or abs(float(match[1])) > _MOST_PIXELS:
        raise InputError(f"--grow: '{word}' is none; write PIXELS:TYPES:DIRECTION, as -6, -6:0,1 or -6:1:horizontal")
    types = tuple(int(each) for each in match[2].split(",")) if match[2] else (1, 2, 3)
    direction: Direction = "horizontal" if match[3] == "horizontal" else "vertical" if match[3] == "vertical" else "all"
    return _Growth(float(match[1]), types, direction)


def _read_displacement(path: Path, shape: tuple[int, ...]) -> "np.ndarray":
    """(row, col) for each pixel."""
    from jaxtex.cli.field_options import read_numbers
    from jaxtex.progressive.warping import spread_mesh

    values = read_numbers("--displace", path)
    if values.shape[2] < 2:
        raise InputError(
            f"--displace: {path} has one channel; give a picture whose first two are pixels to the right and down"
        )
    if not (2 <= values.shape[0] <= shape[0] and 2 <= values.shape[1] <= shape[1]):
        told = f"{path} is {values.shape[1]} x {values.shape[0]} pixels"
        raise InputError(f"--displace: {told}; give 2 x 2 to the size of what is made, {shape[1]} x {shape[0]}")
    return spread_mesh(values[..., 1::-1], (shape[0], shape[1]))
