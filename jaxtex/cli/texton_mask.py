"""`jaxtex texton-mask`: which pixels of an exemplar belong to its elements."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from jaxtex.cli.hints import hint

if TYPE_CHECKING:
    import numpy as np

_NEARLY_ALL = 0.97  # of a mask is of one type: hardly meant

Radius = Annotated[float, tyro.conf.arg(metavar="RADIUS", help_behavior_hint="")]


@dataclass(frozen=True, kw_only=True)
class TextonMask:
    """Mark the elements of a texture: spots, stripes, leaves, pebbles.

    By colours picked in the exemplar, of up to three types; or by a painted mask; with neither, the colours are chosen
    whose regions make the best elements. Then the mask is refined, in the order of the options below: inverted, specks
    dropped, holes filled, closed, opened, dilated, eroded. It is black where there is no element, and types go from
    there to white.

    Look at --overlay. Where colours were chosen with nothing said, things may be missing, as among pebbles of several
    colours: pick a gap between them then, and invert: --pick X,Y:30 --smoothing 0.7 --invert --open 1.5.

    Example: jaxtex texton-mask hide.png -o mask.png --pick 40,31:12 --open 1.5 --overlay look.png

    Example: jaxtex texton-mask leopard.png -o mask.png --pick 40,31:15:1 --pick 52,30:20:2 --despeckle 20

    Example: jaxtex texton-mask pebbles.jpg -o mask.png --pick 130,4:30 --smoothing 0.7 --invert --open 1.5

    Example: jaxtex texton-mask flowers.jpg -o mask.png --painted dots.png
    """

    exemplar: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="EXEMPLAR")]
    """The picture of the texture."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The mask to write."""
    pick: Annotated[
        tyro.conf.UseAppendAction[tuple[str, ...]], tyro.conf.arg(metavar="X,Y[:TOL[:TYPE]]", help_behavior_hint="")
    ] = ()
    """A place of an element, in pixels; how far colours may be from its colour, in Lab (2 is just visible, 10 a shade,
    50 another colour; 12 by default); and which type of element it is, 1 to 3 (1 by default). Give it again for
    more."""
    painted: Annotated[Path | None, tyro.conf.arg(metavar="MASK", help_behavior_hint="")] = None
    """A painted mask of the exemplar's size, of two to four grey values, the darkest of which is no element."""
    smoothing: float = 1.0
    """Standard deviation, in pixels, of the blur before colours are compared with picked ones."""
    invert: Annotated[tyro.conf.FlagCreatePairsOff[bool], tyro.conf.arg(help_behavior_hint="")] = False
    """What is no element becomes one, and elements none; for things that lie close, of which gaps are told best."""
    despeckle: Annotated[int, tyro.conf.arg(metavar="AREA", help_behavior_hint="")] = 0
    """Regions of fewer pixels, elements and holes alike, become what is nearest to them."""
    fill: Annotated[tyro.conf.FlagCreatePairsOff[bool], tyro.conf.arg(help_behavior_hint="")] = False
    """Holes within elements become part of them."""
    close: Radius = 0.0
    """Elements gain pits and cracks that hold no disk of this radius, in pixels."""
    open: Radius = 0.0
    """Elements lose specks and bridges that hold no disk of this radius."""
    dilate: Radius = 0.0
    """Elements gain a rim of this breadth."""
    erode: Radius = 0.0
    """Elements lose a rim of this breadth."""
    overlay: Annotated[Path | None, tyro.conf.arg(metavar="PATH", help_behavior_hint="")] = None
    """A picture to write for looking: the elements outlined over the exemplar, by type cyan, magenta, yellow."""

    def run(self) -> int:
        import numpy as np

        from jaxtex.cli.files import check_names, write_together
        from jaxtex.core.errors import InputError
        from jaxtex.io.images import check_image_name, read_image, write_image
        from jaxtex.progressive.plots import overlay_texton_mask
        from jaxtex.progressive.texton_masks import write_texton_mask

        if self.pick and self.painted is not None:
            raise InputError("--painted does not go with --pick; give one of them")
        check_names([self.exemplar, self.painted], [self.output, self.overlay])
        check_image_name(self.output)
        if self.overlay is not None:
            check_image_name(self.overlay)
        pixels = read_image(self.exemplar).pixels
        mask = self._refine(self._make(pixels))
        if np.ptp(mask) == 0:
            raise InputError(f"{self.output}: all of it would be of one type; pick other colours, or refine it less")
        writers: dict[Path, Callable[[Path], None]] = {self.output: lambda path: write_texton_mask(path, mask)}
        if self.overlay is not None:
            picture = overlay_texton_mask(pixels, mask)
            writers[self.overlay] = lambda path: write_image(path, picture)
        write_together(writers)
        shares = [f"{np.mean(mask == label):.0%} of type {label}" for label in range(1, int(mask.max()) + 1)]
        print(f"{self.output}: {', '.join(shares) or 'no elements'}, {np.mean(mask == 0):.0%} none")
        if max(np.mean(mask == label) for label in np.unique(mask)) > _NEARLY_ALL:
            told = "nearly all of it is of one type; is that so? --overlay shows it, and tolerances of --pick change it"
            hint(f"{self.output}: {told}")
        return 0

    def _make(self, pixels: "np.ndarray") -> "np.ndarray":
        from jaxtex.cli.values import naming, parse_pick
        from jaxtex.core.errors import InputError
        from jaxtex.progressive.mask_proposal import propose_texton_mask
        from jaxtex.progressive.texton_masks import ColourPick, pick_texton_mask, read_texton_mask

        if self.painted is not None:
            return read_texton_mask(self.painted, pixels.shape[1::-1])
        if not self.pick:
            with naming(self.exemplar):
                return propose_texton_mask(pixels)
        from jaxtex.photo.segment import pick_colours

        if not 0 <= self.smoothing <= 100:
            raise InputError(f"--smoothing: {self.smoothing:g} is out of range; give 0 to 100 pixels")
        picks = []
        for word in self.pick:
            point, tolerance, label = parse_pick("--pick", word)
            with naming(f"--pick: '{word}'"):
                picks.append(ColourPick(pick_colours(pixels, [point])[0], tolerance, label))
        with naming("--pick"):
            return pick_texton_mask(pixels, picks, smoothing=self.smoothing)

    def _refine(self, mask: "np.ndarray") -> "np.ndarray":
        from jaxtex.cli.values import naming
        from jaxtex.progressive import texton_masks

        if self.invert:
            mask = texton_masks.invert_texton_mask(mask)
        if self.despeckle:
            with naming("--despeckle"):
                mask = texton_masks.despeckle_texton_mask(mask, self.despeckle)
        if self.fill:
            mask = texton_masks.fill_texton_mask(mask)
        steps: tuple[tuple[texton_masks.Operation, float], ...] = (
            ("close", self.close),
            ("open", self.open),
            ("dilate", self.dilate),
            ("erode", self.erode),
        )
        for operation, radius in steps:
            with naming(f"--{operation}"):
                mask = texton_masks.refine_texton_mask(mask, operation, radius) if radius else mask
        return mask
