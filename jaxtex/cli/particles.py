"""`jaxtex particles analyse` and `show`: a picture made of things, taken apart."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from jaxtex.core.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from rich.table import Table

    from jaxtex.io.images import Image
    from jaxtex.particles.cooccurrences import Arrangement
    from jaxtex.particles.files import ParticleFolder
    from jaxtex.particles.things import Decomposition

_SHEET = "sheet.png"
_DOUBTFUL = 0.13  # of what `rate_particles` gives
_WRITTEN = ("labels.png", "particles.json", _SHEET)

MaybePath = Annotated[Path | None, tyro.conf.arg(metavar="FILE", help_behavior_hint="")]
Switch = Annotated[tyro.conf.FlagCreatePairsOff[bool], tyro.conf.arg(help_behavior_hint="")]
Colours = Annotated[tuple[str, ...], tyro.conf.arg(metavar="COLOUR [COLOUR ...]", help_behavior_hint="")]


@dataclass(frozen=True, kw_only=True)
class Analyse:
    """Take a picture apart into the things that it is made of: pebbles, coins, leaves, holes.

    With no options the things are looked for. Or say what they are:
    --colours: what colours they have, one to each class. A COLOUR is rrggbb as colour pickers show it, or x,y, a place
    in the picture to take it from; join with + what is of one class: 120,40+88,210.
    --polygons: outlines, as labelme saves them; their labels name the classes.
    --labels: a picture of the same size in which every thing is painted flat in a colour, on black; things that touch
    in two colours. Things are of a class if their colours in EXEMPLAR are alike.
    --polygons or --labels, and --find or --colours: what they leave is looked for as well.

    Writes a folder for 'jaxtex particles synth': labels.png (16 bits: each pixel the number of its thing), which may be
    mended by hand, and is not written over then; particles.json (the things' classes), a copy of the picture, and
    sheet.png to look at. Where what was found hardly looks like things, the exit status is 1.

    Example: jaxtex particles analyse coins.png -o coins

    Example: jaxtex particles analyse beach.jpg -o beach --colours c08040+118,40 e8e4d8 --ground 302820
    """

    exemplar: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="EXEMPLAR")]
    """The picture, seen straight on."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The folder to write."""
    classes: Annotated[int | None, tyro.conf.arg(metavar="K", help_behavior_hint="")] = None
    """How many classes of things there are, told by their colours. By default as many as are clearly apart, up to 4."""
    colours: Colours = ()
    """The things' colours, a COLOUR to each class."""
    ground: Colours = ()
    """The ground's colours. By default the one colour that fits best what is far from those of --colours."""
    distance: Literal["lab", "rgb"] = "lab"
    """Of --colours: compared where steps look even (CIE Lab), or by the numbers in the file."""
    smoothing: float = 1.0
    """Of --colours: the Gaussian filter that takes grain away first, its standard deviation in pixels."""
    polygons: MaybePath = None
    """A file of outlines (JSON, as labelme saves it)."""
    labels: MaybePath = None
    """A painted picture of the things."""
    smallest: Annotated[int, tyro.conf.arg(metavar="PIXELS")] = 0
    """Leave out what has fewer pixels."""
    label_classes: Switch = False
    """Each colour of --labels is a class of its own."""
    find: Switch = False
    """Look for things beside those of --polygons or --labels."""

    def run(self) -> int:
        self._check()

        from jaxtex.io.files import prepare_folder
        from jaxtex.io.images import read_image
        from jaxtex.particles.files import read_particles, write_particles

        image = read_image(self.exemplar)
        found, names = self._take_apart(image)
        found, names = self._leave_out(found, names)
        write_particles(prepare_folder(self.output), image, found, names=names)
        status = _show(read_particles(self.output), self.output / _SHEET)
        if self.colours or self.labels is not None or self.polygons is not None:
            return status
        from jaxtex.particles.segmentation import rate_particles

        if rate_particles(image.pixels, found) < _DOUBTFUL:
            print(
                f"These hardly look like things: see {self.output / _SHEET}, and say what is by --colours or --labels."
            )
            return 1
        return status

    def _check(self) -> None:
        from jaxtex.particles.files import has_mended_labels

        if self.classes is not None and self.classes < 1:
            raise InputError(f"--classes: {self.classes} is out of range; give 1 or more")
        if self.classes is not None and self.colours:
            raise InputError("--classes: goes without --colours, which give a colour to each class")
        if self.ground and not self.colours:
            raise InputError("--ground: goes with --colours; give the things' colours as well")
        for path in (self.labels, self.polygons):
            if path is not None and path.resolve() in {(self.output / name).resolve() for name in _WRITTEN}:
                raise InputError(f"--output: {path} would be written over; give another folder")
        if has_mended_labels(self.output):
            raise InputError(
                f"--output: {self.output / 'labels.png'} is not as 'particles analyse' left it, may have been mended "
                "by hand, and would be written over; give another folder, or move it away first"
            )
        if self.smallest < 0:
            raise InputError(f"--smallest: {self.smallest} is out of range; give 0 or more")
        if not 0 <= self.smoothing <= 100:
            raise InputError(f"--smoothing: {self.smoothing:g} is out of range; give 0 to 100 pixels")
        if self.polygons is not None and self.labels is not None:
            raise InputError("--labels: goes without --polygons; give one of them")
        if self.label_classes and self.labels is None:
            raise InputError("--label-classes: goes with --labels")
        if self.find and (self.colours or (self.labels is None and self.polygons is None)):
            raise InputError("--find: goes with --polygons or --labels, and without --colours")

    def _take_apart(self, image: "Image") -> tuple["Decomposition", tuple[str, ...] | None]:
        """The picture taken apart, and the names of classes if the user gave them."""
        from jaxtex.particles.scissors import join_things

        cut = self._cut(image)
        if cut is None:
            return self._look(image), None
        things, names = cut
        if not (self.find or self.colours):
            return things, names
        named = names is not None
        joined = join_things(image.pixels, things, self._look(image), named=named)
        return joined, _name_all(names, joined.kinds)

    def _leave_out(
        self, found: "Decomposition", names: tuple[str, ...] | None
    ) -> tuple["Decomposition", tuple[str, ...] | None]:
        """Without what is too small, and classes of which nothing else is there."""
        import numpy as np

        from jaxtex.particles.things import describe_particles

        large = np.array([each.area >= self.smallest for each in found.particles])
        if large.all():
            return found, names
        if not large.any():
            raise InputError(f"--smallest: nothing has {self.smallest} pixels; give fewer")
        labels = np.where(np.append(False, large)[found.labels], found.labels, 0)
        kept, kinds = np.unique(
            [each.kind for each in found.particles if each.area >= self.smallest], return_inverse=True
        )
        return describe_particles(labels, kinds), None if names is None else tuple(names[kind] for kind in kept)

    def _cut(self, image: "Image") -> tuple["Decomposition", tuple[str, ...] | None] | None:
        """What was cut out by hand, and the names of its classes if it has any."""
        from jaxtex.particles.things import describe_particles

        if self.polygons is not None:
            return _cut_polygons(self.polygons, image, self.classes)
        if self.labels is None:
            return None
        from jaxtex.cli.values import naming
        from jaxtex.io.images import read_image
        from jaxtex.particles.scissors import label_painted

        painted = read_image(self.labels, colour_space="data").pixels
        if painted.shape[:2] != image.pixels.shape[:2]:
            raise InputError(
                f"--labels: {self.labels} is {painted.shape[1]} x {painted.shape[0]}, and the exemplar "
                f"{image.width} x {image.height}; paint over a copy of the exemplar"
            )
        with naming(self.labels):
            labels = label_painted(painted)
        if not self.label_classes:
            return describe_particles(labels, _class_by_colour(image, labels, self.classes)), None
        kinds, names = _painted_classes(painted, labels)
        return describe_particles(labels, kinds), names

    def _look(self, image: "Image") -> "Decomposition":
        from jaxtex.cli.values import naming_options
        from jaxtex.particles.segmentation import find_particles

        if not self.colours:
            with naming_options(self, self.exemplar):
                return find_particles(image.pixels, kinds=self.classes)
        from jaxtex.particles.picking import pick_particles

        things = [_pick_colours("--colours", word, image.pixels) for word in self.colours]
        ground = [each for word in self.ground for each in _pick_colours("--ground", word, image.pixels)]
        with naming_options(self, self.exemplar):
            return pick_particles(
                image.pixels, things, ground or None, distance=self.distance, smoothing=self.smoothing
            )


@dataclass(frozen=True, kw_only=True)
class Show:
    """Show what a picture was taken apart into: its things, where they have their neighbours, each class's particles.

    Example: jaxtex particles show coins -o coins.png
    """

    folder: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="FOLDER")]
    """A folder that 'jaxtex particles analyse' wrote."""
    output: Annotated[Path | None, tyro.conf.arg(aliases=["-o"], metavar="SHEET", help_behavior_hint="")] = None
    """The sheet to write: .png, .jpg, .tif or .exr. By default sheet.png in the folder."""

    def run(self) -> int:
        from jaxtex.particles.files import read_particles

        sheet = self.output or self.folder / _SHEET
        if sheet.resolve().parent == self.folder.resolve() and sheet.name != _SHEET:
            raise InputError(f"--output: {sheet} is in the folder that is shown; give a place outside")
        return _show(read_particles(self.folder), sheet)


def _show(folder: "ParticleFolder", sheet: Path) -> int:
    from rich.console import Console

    from jaxtex.cli.particle_sheet import draw_particle_sheet
    from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
    from jaxtex.io.images import write_image
    from jaxtex.particles.arrangement import learn_arrangement

    arrangement = learn_arrangement(folder.decomposition)
    picture = linear_to_srgb(folder.image.pixels)
    drawn = draw_particle_sheet(picture, folder.decomposition, arrangement, folder.names)
    write_image(sheet, srgb_to_linear(drawn))
    console = Console(highlight=False, markup=False)
    console.print(_table(folder, arrangement))
    print(f"look at {sheet}")
    return 0


def _table(folder: "ParticleFolder", arrangement: "Arrangement") -> "Table":
    from rich.table import Table

    from jaxtex.cli.particle_sheet import tell_class

    table = Table()
    for heading in ("class", "particles", "whole", "of the picture", "arrangement"):
        table.add_column(heading, justify="left" if heading in ("class", "arrangement") else "right")
    pixels = folder.decomposition.labels.size
    for kind, (name, rule) in enumerate(zip(folder.names, arrangement.classes, strict=True)):
        members = [each for each in folder.decomposition.particles if each.kind == kind]
        share = 100 * sum(each.area for each in members) / pixels
        whole = sum(each.complete for each in members)
        table.add_row(name, str(len(members)), str(whole), f"{share:.0f} %", tell_class(rule))
    return table


def _pick_colours(option: str, word: str, pixels: "np.ndarray") -> "np.ndarray":
    """The linear colours [colour, channel] that a word names: rrggbb, or x,y; several joined with +."""
    import numpy as np

    from jaxtex.cli.values import naming, parse_colour, parse_point
    from jaxtex.core.colour import srgb_to_linear
    from jaxtex.photo.pictures import luminance
    from jaxtex.photo.segment import pick_colours

    colours = []
    for part in word.split("+"):
        if "," in part:
            point = parse_point(option, part)
            with naming(f"{option}: '{part}'"):
                colours.append(pick_colours(pixels, [point])[0])
            continue
        named = srgb_to_linear(np.array([parse_colour(option, part)], np.float32))
        colours.append(luminance(named[:, None])[0] if pixels.shape[-1] == 1 else named[0])
    return np.array(colours).reshape(len(colours), pixels.shape[-1])


def _cut_polygons(path: Path, image: "Image", kinds: int | None) -> tuple["Decomposition", tuple[str, ...] | None]:
    from jaxtex.cli.values import naming
    from jaxtex.particles.scissors import cut_polygons, read_polygons
    from jaxtex.particles.things import describe_particles

    polygons = read_polygons(path, (image.width, image.height))
    with naming(path):
        labels = cut_polygons(polygons, (image.height, image.width))
    names = tuple(dict.fromkeys(each.name for each in polygons))
    if names == ("",):
        return describe_particles(labels, _class_by_colour(image, labels, kinds)), None
    return describe_particles(labels, [names.index(each.name) for each in polygons]), names


def _class_by_colour(image: "Image", labels: "np.ndarray", kinds: int | None) -> "np.ndarray":
    from jaxtex.cli.values import naming
    from jaxtex.particles.kinds import class_things
    from jaxtex.photo.pictures import to_lab

    with naming(image.path):
        return class_things(to_lab(image.pixels), labels, kinds)


def _painted_classes(painted: "np.ndarray", labels: "np.ndarray") -> tuple[list[int], tuple[str, ...]]:
    """The class of each painted thing, by its paint, and that as a name."""
    import numpy as np

    levels = np.rint(255 * np.broadcast_to(painted, (*labels.shape, 3))).astype(int)
    paints = []
    for number in range(1, int(labels.max()) + 1):
        colours, counts = np.unique(levels[labels == number], axis=0, return_counts=True)
        red, green, blue = colours[np.argmax(counts)]
        paints.append(f"{red:02x}{green:02x}{blue:02x}")
    names = tuple(sorted(set(paints)))
    return [names.index(paint) for paint in paints], names


def _name_all(names: Sequence[str] | None, count: int) -> tuple[str, ...] | None:
    """Names of the classes that were cut out, and of those that were found beside them."""
    if names is None:
        return None
    return (*names, *(f"found {number}" for number in range(count - len(names))))
