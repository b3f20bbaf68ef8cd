"""`jaxtex solid`: a block of voxels whose slices look like pictures of a material, seen along its axes."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

import tyro

from jaxtex.core.errors import InputError

if TYPE_CHECKING:
    import numpy as np

    from jaxtex.synthesis.solid_relaxation import SolidStep
    from jaxtex.synthesis.solid_views import Views


class _Memory(NamedTuple):
    """Bytes at the most: of the process itself, each voxel, each of its channels, and each pixel of a picture."""

    process: int
    voxel: int
    channel: int
    pixel: int


_MEMORY = {"optimisation": _Memory(820 << 20, 41, 12, 600), "relaxation": _Memory(512 << 20, 0, 17, 150)}
_MOST_PIXELS = 1 << 22
_FEWEST, _MOST = 8, 512
_LARGEST_SHRINK = 100


@dataclass(frozen=True, kw_only=True)
class Solid:
    """Make a solid texture: a block of voxels whose slices look like two or three pictures, seen along its axes.

    Give pictures of the same material, cut along and across. For a material that looks alike from everywhere (granite),
    give one picture alone: it stands for all three. The block repeats seamlessly along all axes.

    The picture --xy is of slices with rows along y and columns along x; --xz has rows along z and columns along x; --yz
    has rows along z and columns along y. With two pictures, slices across the third axis are left as the two make them.

    Writes OUT.npz with the array 'voxels' [z, y, x, channel], linear colours as float32. 'jaxtex carve' cuts meshes of
    it, 'jaxtex solid-slice' shows it. For other programs: OUT.exr writes slices across z as OUT.0000.exr and so on;
    OUT.raw writes two files, bare float32 as OUT.raw and its header as OUT.nhdr, which ParaView and 3D Slicer open;
    OUT.vol a grid volume of Mitsuba. Files of these names are replaced.

    Example: jaxtex solid --xy granite.jpg -n 128 -o granite.npz

    Example: jaxtex solid --xy flat.png --xz end.png --yz side.png -n 128 -o oak.npz --preview oak.png
    """

    xy: Annotated[Path | None, tyro.conf.arg(metavar="PICTURE", help_behavior_hint="")] = None
    """What slices across z look like."""
    xz: Annotated[Path | None, tyro.conf.arg(metavar="PICTURE", help_behavior_hint="")] = None
    """What slices across y look like."""
    yz: Annotated[Path | None, tyro.conf.arg(metavar="PICTURE", help_behavior_hint="")] = None
    """What slices across x look like."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The block to write: .npz, or for other programs .exr, .raw or .vol."""
    side: Annotated[int, tyro.conf.arg(aliases=["-n"], metavar="VOXELS")] = 128
    """Voxels along each edge, of a pixel each. The pictures must be larger, by a quarter at least."""
    method: Literal["optimisation", "relaxation"] = "optimisation"
    """'optimisation' puts the block together of what the pictures show around each place, so that grains and things
    stay whole and edges sharp. 'relaxation' gives noise the pictures' frequencies and colours: several times as quick,
    and as good for even grain."""
    shrink: float = 1.0
    """Make the pictures so many times smaller first: for patterns that are too large for the block."""
    iterations: Annotated[int | None, tyro.conf.arg(help_behavior_hint="")] = None
    """How often all slices are gone over: 'optimisation' does so at each of some sizes of the block, 8 times unless
    told, 'relaxation' at most 10 times."""
    histogram: Literal["auto", "shared", "own"] = "auto"
    """Voxels belong to slices of all axes, so pictures of different colours cannot all be met. 'shared' moves them to
    what lies between before the start, 'own' does not, and 'auto' does where they differ."""
    colours: Literal["decorrelated", "single-hue"] = "decorrelated"
    """'single-hue' is for materials whose colour is told by how light they are: less work and memory, and no false
    hues; of several hues all but one are lost."""
    seed: int = 0
    """Another number, another piece of the material."""
    preview: Annotated[Path | None, tyro.conf.arg(metavar="FILE", help_behavior_hint="")] = None
    """A picture of the middle slices across z, y and x, written again after each iteration."""

    def run(self) -> int:
        from jaxtex.cli.values import check_seed

        check_seed(self.seed)
        self._check()

        from jaxtex.core.colour import srgb_to_linear
        from jaxtex.io.voxels import write_voxels

        views, last = self._make()
        encoded = views.to_voxels(last.voxels)
        parts = (srgb_to_linear(each).reshape(-1, each.shape[-1]) for each in encoded)
        write_voxels(self.output, parts, shape=encoded.shape)
        self._tell(views, last)
        return 0

    def _check(self) -> None:
        from jaxtex.io.files import place_for_file
        from jaxtex.io.voxels import check_block, find_taken

        given = [path for path in (self.xy, self.xz, self.yz) if path is not None]
        if not given:
            raise InputError("--xy: give a picture; one alone stands for all three views")
        if not _FEWEST <= self.side <= _MOST:
            raise InputError(f"--side: {self.side} is out of range; give a number from {_FEWEST} to {_MOST}")
        if not 1 <= self.shrink <= _LARGEST_SHRINK:
            raise InputError(f"--shrink: {self.shrink:g} is out of range; give a number from 1 to {_LARGEST_SHRINK}")
        if self.iterations is not None and self.iterations < 1:
            raise InputError(f"--iterations: {self.iterations} is out of range; give 1 or more")
        if self.preview is not None and self.preview.resolve() in {each.resolve() for each in given}:
            raise InputError(f"--preview: {self.preview} would be written over; give another name")
        check_block(self.output, (self.side, self.side, self.side, 3))
        if self.preview is not None:
            given.append(place_for_file(self.preview))
        if taken := find_taken(self.output, self.side, given):
            raise InputError(f"--output: {taken} would be one of the files of {self.output}; give another name")

    def _read_views(self) -> "dict[str, np.ndarray]":
        """sRGB-encoded. A view alone is that of all axes; grey ones beside coloured ones are coloured grey."""
        import numpy as np

        from jaxtex.core.colour import linear_to_srgb
        from jaxtex.io.images import read_image
        from jaxtex.photo.evidence import shrink

        paths = {"xy": self.xy, "xz": self.xz, "yz": self.yz}
        images = {name: read_image(path) for name, path in paths.items() if path is not None}
        for name, image in images.items():
            if image.width * image.height > _MOST_PIXELS:
                raise InputError(
                    f"--{name}: {paths[name]} has {image.width} x {image.height} pixels, and blocks have at most "
                    f"{_MOST} voxels along an edge; give at most {_MOST_PIXELS >> 20} megapixels, shrunk or cropped"
                )
            if image.alpha is not None and image.alpha.min() < 1:
                raise InputError(f"--{name}: {paths[name]} is transparent in places; give an opaque picture")
        most = max(image.pixels.shape[2] for image in images.values())
        pictures = {
            name: shrink(image.pixels, round(max(image.width, image.height) / self.shrink))
            for name, image in images.items()
        }
        self._check_memory(pictures, most)
        views = {
            name: linear_to_srgb(np.broadcast_to(picture, (*picture.shape[:2], most)))
            for name, picture in pictures.items()
        }
        return views if len(views) > 1 else dict.fromkeys(paths, *views.values())

    def _check_memory(self, pictures: "dict[str, np.ndarray]", channels: int) -> None:
        from jaxtex.cli.values import check_memory

        memory = _MEMORY[self.method]
        each = memory.voxel + memory.channel * (1 if self.colours == "single-hue" else channels)
        pixels = sum(picture.shape[0] * picture.shape[1] for picture in pictures.values())
        needed = memory.process + each * self.side**3 + memory.pixel * pixels
        check_memory(f"--side: {self.side}", needed)

    def _make(self) -> "tuple[Views, SolidStep]":
        from jaxtex.cli.progress import reporting

        with reporting(f"making {self.output}") as report:
            views, steps = self._begin()
            for step in steps:
                report(step.done, step.total)
                if self.preview is not None:
                    self._show(views, step)
        return views, step

    def _begin(self) -> "tuple[Views, Iterator[SolidStep]]":
        import jax

        from jaxtex.synthesis.solid_optimisation import optimise_steps
        from jaxtex.synthesis.solid_relaxation import relax_steps
        from jaxtex.synthesis.solid_views import align_views

        shared = {"auto": None, "shared": True, "own": False}[self.histogram]
        begin = optimise_steps if self.method == "optimisation" else relax_steps
        given = {} if self.iterations is None else {"iterations": self.iterations}
        try:
            views = align_views(self._read_views(), self.side, shared=shared, colours=self.colours)
            return views, begin(views.pictures, self.side, key=jax.random.key(self.seed), **given)
        except ValueError as error:
            raise InputError(str(error)) from None

    def _show(self, views: "Views", step: "SolidStep") -> None:
        import numpy as np

        from jaxtex.core.colour import srgb_to_linear
        from jaxtex.io.images import write_image

        assert self.preview is not None
        middle = step.voxels.shape[1] // 2
        across = (step.voxels[:, middle], step.voxels[:, :, middle], step.voxels[:, :, :, middle])
        shown = np.concatenate([views.to_voxels(each[:, None])[0] for each in across], axis=1)
        write_image(self.preview, srgb_to_linear(shown))

    def _tell(self, views: "Views", last: "SolidStep") -> None:
        from jaxtex.cli.solids import tell_format

        print(f"{self.output}: a block of {self.side} x {self.side} x {self.side} voxels, tileable")
        tell_format(self.output, (self.side, self.side, self.side, len(views.mean)))
        if self.method == "relaxation" and last.done > 1:
            print(f"  {last.done} iterations; the last changed values by {100 * last.change:.1f} % of their spread")
        rows, columns = next(iter(views.pictures.values())).shape[:2]
        if min(rows, columns) >= 2 * self.side:
            print(
                f"  a voxel is a pixel: the block shows {self.side} x {self.side} pixels of {columns} x {rows}; with "
                f"--shrink {min(rows, columns) / (2 * self.side):.2g} it shows more, smaller"
            )
        if len(views.pictures) > 1 and views.apart > 0:
            met = "moved to one between them" if views.shared else "left as they are"
            print(f"  the pictures' histograms lie up to {100 * views.apart:.1f} % of the range apart: {met}")
