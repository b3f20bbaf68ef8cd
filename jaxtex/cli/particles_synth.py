"""`jaxtex particles synth`: the things of a picture, arranged anew under a person's control."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from jaxtex.cli.hints import hint
from jaxtex.core.errors import InputError

if TYPE_CHECKING:
    import numpy as np

    from jaxtex.particles.composition import Composition
    from jaxtex.particles.controls import Control
    from jaxtex.particles.files import ParticleFolder

_SIZE = 1024, 1024
_BYTES = 100  # of memory to a pixel, at the most
_LIKE = 0.02  # by which shapes of pictures that are stretched over each other may differ
_HALF = 0.5  # what is lighter in a mask is white

MaybePath = Annotated[Path | None, tyro.conf.arg(metavar="FILE", help_behavior_hint="")]


@dataclass(frozen=True, kw_only=True)
class Synth:
    """Arrange the things of a picture anew, as they were arranged there: any size, tileable, under control.

    --control takes a file of wishes, a [[control]] table for each, with any of these lines:
    classes = [0], which classes; where = {map = "mask.png"}, in which part; by default all and everywhere.
    density = 2, how many times as many, though they may overlap; size = 0.5, how large they are and how far apart, so
    that half the size is four times as many, but with density = 0.25; orientation = 30, degrees; colour = [1, 0.5,
    0.5], times as much red, green and blue; probability = 0.5, of being seen; least_distance = 40, pixels between
    centres; size_variation = 0.3 and orientation_variation = 90, at random; weights = {3 = 0}, of single things.
    Each number may be one for each place: {from = 1, to = 0.4, start = [0, 0], end = [1, 0]}, {inside = 0, outside = 1,
    centre = [0.5, 0.5], radius = 0.3}, in parts of the picture's sides, or {map = "grey.png", low = 0, high = 2}.

    --save keeps what was placed as a file, a line to each thing: move, turn, scale, colour, add or remove things there,
    and draw it again with --composition, at any --scale.

    Two pictures are mixed by laying one's things over the other's picture: see --under, --mask and --avoid.

    Example: jaxtex particles synth coins -o more.png --size 1024x1024 --tileable

    Example: jaxtex particles synth coins -o edited.png --composition edited.json --scale 2

    Example: jaxtex particles synth leaves -o mixed.png --under wall.png --avoid bricks.png
    """

    folder: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="FOLDER")]
    """A folder that 'jaxtex particles analyse' wrote."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The picture to write: .png, .jpg, .tif or .exr."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WxH", help_behavior_hint="")] = None
    """Its size in pixels. By default 1024x1024, or that of --under."""
    tileable: bool = False
    """Make it repeat seamlessly. Regular rows do so best in sizes that are multiples of their spacing."""
    control: MaybePath = None
    """What is wanted otherwise than in the picture, and where: controls.toml."""
    germ: Annotated[str | None, tyro.conf.arg(metavar="X,Y", help_behavior_hint="")] = None
    """Where each class begins, in pixels. By default anywhere."""
    order: Annotated[tuple[int, ...], tyro.conf.arg(metavar="CLASS [CLASS ...]", help_behavior_hint="")] = ()
    """Classes by their numbers, from below; those that are not named are left out."""
    relax: bool = True
    """Move things after they are placed, until they lie to each other as in the picture, those of several classes
    too. Under --control or --avoid, which ask for something else, they stay where they are placed."""
    ground: Annotated[Literal["coherence", "patches", "noise", "heap"] | None, tyro.conf.arg(help_behavior_hint="")] = (
        None
    )
    """How what the things lie on is made: as 'jaxtex synth' does, of lapped patches, as noise of fine grain, or as
    more things further down. By default what suits the picture."""
    under: MaybePath = None
    """A picture to lay the things over, in place of the ground."""
    avoid: MaybePath = None
    """A mask of the output's size or shape: things whose centres lie on white are left out."""
    mask: MaybePath = None
    """A mask to write: white where things are, black where the ground is seen."""
    save: MaybePath = None
    """A file to write what was placed to (JSON)."""
    composition: MaybePath = None
    """Draw what such a file says, in place of an arrangement of its own."""
    scale: float = 1.0
    """Draw it so many times as large; more detail than the picture's there is not."""
    seed: int = 0
    """Another number, another arrangement."""

    def run(self) -> int:
        from jaxtex.cli.values import check_seed

        check_seed(self.seed)
        self._check()

        import numpy as np

        from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
        from jaxtex.io.images import write_image
        from jaxtex.io.masks import write_mask
        from jaxtex.particles.composition import write_composition
        from jaxtex.particles.files import read_particles
        from jaxtex.particles.painting import label_composition, paint_composition

        folder = read_particles(self.folder)
        below = self._read_below()
        placed = self._place(folder, below)
        picture = linear_to_srgb(folder.image.pixels)
        if below is not None and below.shape[-1] > picture.shape[-1]:
            picture = np.repeat(picture, below.shape[-1], axis=-1)
        if below is not None and below.shape[-1] < picture.shape[-1]:
            below = np.repeat(below, picture.shape[-1], axis=-1)
        ground = self._make_ground(picture, folder, placed) if below is None else below
        drawn = paint_composition(placed, picture, folder.decomposition, ground, halos=below is None)
        write_image(self.output, srgb_to_linear(drawn))
        if self.mask is not None:
            write_mask(self.mask, label_composition(placed, folder.decomposition) > 0)
        if self.save is not None:
            write_composition(self.save, placed)
        print(f"{len(placed)} {'thing' if len(placed) == 1 else 'things'} placed; look at {self.output}")
        if not len(placed):
            hint(f"nothing is placed; {self._tell_why_none()}")
        return 0

    def _tell_why_none(self) -> str:
        if self.composition is not None:
            return f"{self.composition} has no line of a thing"
        why = []
        if self.control is not None:
            why.append(f"in {self.control} a density or probability may be 0 everywhere (black, in a map)")
        if self.avoid is not None:
            why.append(f"{self.avoid} may be white everywhere (white is kept free)")
        return ", or ".join(why) or "give a larger --size"

    def _check(self) -> None:
        from jaxtex.io.files import place_for_file
        from jaxtex.io.images import check_image_name

        if not 0.01 <= self.scale <= 100:
            raise InputError(f"--scale: {self.scale:g} is out of range; give 0.01 to 100")
        given: dict[str, object] = {"--size": self.size, "--germ": self.germ, "--control": self.control}
        given |= {"--avoid": self.avoid, "--order": self.order or None, "--tileable": self.tileable or None}
        for option, value in given.items():
            if self.composition is not None and value is not None:
                raise InputError(f"{option}: goes without --composition, whose file says where things are")
        if self.under is not None and self.ground is not None:
            raise InputError("--ground: goes without --under, which is the ground")
        if self.under is not None and self.scale != 1:
            raise InputError("--scale: goes without --under; the output has that picture's size")
        if self.under is not None and self.size is not None:
            raise InputError("--size: goes without --under; the output has that picture's size")
        outputs = [path for path in (self.output, self.mask, self.save) if path is not None]
        inputs = (self.under, self.avoid, self.composition, self.control, *_files_of(self.folder))
        taken = {path.resolve() for path in inputs if path is not None}
        for number, path in enumerate(outputs):
            if path.resolve() in taken | {each.resolve() for each in outputs[:number]}:
                raise InputError(f"{path}: would be written over; give another name")
            place_for_file(path)
        for picture in (self.output, self.mask):
            if picture is not None:
                check_image_name(picture)

    def _read_below(self) -> "np.ndarray | None":
        if self.under is None:
            return None
        from jaxtex.core.colour import linear_to_srgb
        from jaxtex.io.images import read_image

        return linear_to_srgb(read_image(self.under).pixels)

    def _place(self, folder: "ParticleFolder", below: "np.ndarray | None") -> "Composition":
        from jaxtex.cli.values import check_memory, parse_size

        if self.composition is not None:
            placed = _read_placed(self.composition, folder).rescaled(self.scale)
            if below is not None and below.shape[:2] != (placed.height, placed.width):
                raise InputError(
                    f"--under: {self.under} is {below.shape[1]} x {below.shape[0]}, and what {self.composition} says "
                    f"{placed.width} x {placed.height}; give pictures of one size"
                )
            check_memory(f"--scale: {self.scale:g}", _BYTES * placed.width * placed.height)
            return placed
        size = _SIZE if self.size is None else parse_size("--size", self.size)
        size = size if below is None else (below.shape[1], below.shape[0])
        asked = f"{self._tell_size()} {size[0]} x {size[1]}" + (f", --scale {self.scale:g}" if self.scale != 1 else "")
        check_memory(f"{asked}:", round(_BYTES * size[0] * size[1] * self.scale**2))
        return self._seed(folder, size).rescaled(self.scale)

    def _seed(self, folder: "ParticleFolder", size: tuple[int, int]) -> "Composition":
        import jax

        from jaxtex.cli.progress import reporting
        from jaxtex.cli.values import naming_options, parse_point
        from jaxtex.particles.arrangement import learn_arrangement
        from jaxtex.particles.relaxation import relax_composition
        from jaxtex.particles.seeding import seed_composition

        germ = None if self.germ is None else parse_point("--germ", self.germ)
        controls = self._controls(size)
        arrangement = learn_arrangement(folder.decomposition)
        with naming_options(self, self.folder, size=self._tell_size(), controls=self.control):
            placed = seed_composition(
                folder.decomposition,
                arrangement,
                size,
                key=jax.random.fold_in(jax.random.key(self.seed), 0),
                tileable=self.tileable,
                germ=germ,
                order=self.order or None,
                controls=controls,
            )
        if not self.relax or self.control is not None or self.avoid is not None:
            return placed
        with reporting("relaxing") as report:
            return relax_composition(placed, folder.decomposition, report=report)

    def _tell_size(self) -> str:
        """Where the size comes from."""
        if self.under is not None:
            return f"--under: {self.under} of"
        return "--size, by default" if self.size is None else "--size"

    def _controls(self, size: tuple[int, int]) -> "tuple[Control, ...]":
        from jaxtex.io.masks import read_mask
        from jaxtex.particles.control_files import read_controls
        from jaxtex.particles.controls import Control
        from jaxtex.particles.fields import map_field

        controls = () if self.control is None else read_controls(self.control, size)
        if self.avoid is not None:
            mask = read_mask(self.avoid)
            if abs(mask.shape[1] * size[1] / (mask.shape[0] * size[0]) - 1) > _LIKE:
                raise InputError(
                    f"--avoid: {self.avoid} is {mask.shape[1]} x {mask.shape[0]}, and the output {size[0]} x "
                    f"{size[1]}; give a mask of that shape"
                )
            controls = (*controls, Control(probability=map_field(mask < _HALF, size)))
        return controls

    def _make_ground(self, picture: "np.ndarray", folder: "ParticleFolder", placed: "Composition") -> "np.ndarray":
        import jax

        from jaxtex.particles.grounds import make_ground

        key = jax.random.fold_in(jax.random.key(self.seed), 1)
        return make_ground(
            picture, folder.decomposition, (placed.width, placed.height), key=key, fill=self.ground, scale=self.scale
        )


def _files_of(folder: Path) -> tuple[Path, ...]:
    return tuple(path for path in folder.glob("*") if path.stem in ("labels", "particles", "picture"))


def _read_placed(path: Path, folder: "ParticleFolder") -> "Composition":
    """A composition's file, once it is known to be of this folder's particles."""
    from jaxtex.cli.values import naming
    from jaxtex.particles.composition import check_exemplar, read_composition

    placed = read_composition(path)
    with naming(path):
        check_exemplar(placed, folder.decomposition)
    return placed
