"""`jaxtex vary distort`: a texture whose things are as large, and lie as, fields say."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import tyro

from jaxtex.cli.progress import reporting
from jaxtex.core.errors import InputError

if TYPE_CHECKING:
    import numpy as np

    from jaxtex.io.images import Image
    from jaxtex.progressive.varying import VaryingTexture

_LEAST_MEMORY = 400  # bytes that each pixel of the result takes
_MOST_APART = 0.2  # of their size may things change across a border over which a texture repeats


@dataclass(frozen=True, kw_only=True)
class VaryDistort:
    """Make more of a texture, with things larger or smaller and turned from place to place.

    Neighbourhoods of pixels are scaled and turned before they are compared (Zhang et al. 2003, section 4.1), so things
    stay whole while they vary. Scale and orientation are numbers, the same everywhere, or maps, or both come from keys:
    points and strokes with values.

    Example: jaxtex vary distort pebbles.jpg -o shore.png --size 1024x256 --scale size.exr

    Example: jaxtex vary distort reptile.png -o skin.png --keys skin.toml --save skin.npz

    Example: jaxtex vary distort coins.png -o piles.png --size 768x256 --scale size.exr --texton-mask coins_mask.png

    Example: jaxtex vary distort bricks.png -o slanted.png --orientation 30 --also rough.png --normals normal.png
    """

    exemplar: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="EXEMPLAR")]
    """The picture of the texture, seen straight on and evenly lit."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The picture to write: .png, .jpg, .tif or .exr."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WxH", help_behavior_hint="")] = None
    """Its size in pixels. By default the exemplar's."""
    scale: Annotated[str | None, tyro.conf.arg(metavar="NUMBER|MAP", help_behavior_hint="")] = None
    """How many times as large as in the exemplar things are: a number, or a picture of one channel that holds such
    numbers (.exr), from 0.125 to 16. It is stretched over the result. By default 1. What grey levels stand for is said
    by --keys."""
    orientation: Annotated[str | None, tyro.conf.arg(metavar="DEGREES|MAP", help_behavior_hint="")] = None
    """How far things are turned, clockwise: degrees, or a picture whose first two channels are (x, y) of the direction
    in which the exemplar's rows are to run, y down (.exr, of numbers from -1 to 1). By default 0."""
    keys: Annotated[Path | None, tyro.conf.arg(metavar="KEYS.toml", help_behavior_hint="")] = None
    """Keys of scale, orientation or both, as `jaxtex field` takes them."""
    texton_mask: Annotated[Path | None, tyro.conf.arg(metavar="MASK", help_behavior_hint="")] = None
    """A mask of the exemplar's size that marks its elements, so that these do not break: two to four values, each for
    one type of element or the ground."""
    also: Annotated[tuple[Path, ...], tyro.conf.arg(metavar="MAP ...", help_behavior_hint="")] = ()
    """Other maps of the exemplar's material and size (height, roughness, ...), of any depth. The same is made of the
    numbers in each, in OUTPUT_MAP beside the output: made.png and height.png make made_height.png. Heights stay as they
    are, so slopes are gentler where things are larger and steeper where they are smaller; normals keep theirs."""
    normals: Annotated[tuple[Path, ...], tyro.conf.arg(metavar="MAP ...", help_behavior_hint="")] = ()
    """Likewise maps of normals, whose directions turn as things do: x right in red, y up in green (OpenGL's)."""
    tileable: bool = False
    """Make it repeat seamlessly; the fields must do so, too."""
    neighborhood: int = 7
    """Side of the squares of pixels that are compared, an odd number."""
    save: Annotated[Path | None, tyro.conf.arg(metavar="V.npz", help_behavior_hint="")] = None
    """Write the texture with its fields too, as other commands of `vary` and synthesis on meshes read it."""
    seed: int = 0
    """Another number, another piece of the texture."""

    def run(self) -> int:
        from jaxtex.cli.field_options import read_fields
        from jaxtex.cli.values import check_memory, check_seed, parse_size
        from jaxtex.cli.varying import check_neighborhood
        from jaxtex.io.images import read_image

        check_seed(self.seed)
        radius = check_neighborhood(self.neighborhood)
        image = read_image(self.exemplar)
        maps = self._name_maps(image)
        size = (image.width, image.height) if self.size is None else parse_size("--size", self.size)
        check_memory(f"--size: {size[0]}x{size[1]}", _LEAST_MEMORY * size[0] * size[1])
        scale, orientation = read_fields(self.scale, self.orientation, self.keys, size)
        self._check_neighbourhoods(image)
        if self.tileable:
            _check_repeating(scale, _angles_of(orientation))
        sources = self._synthesise(image, scale, _angles_of(orientation), radius)
        self._write(image, _Made(sources, scale, orientation), maps)
        return 0

    def _name_maps(self, image: "Image") -> list[tuple[Path, Path]]:
        """Other maps, and the files that they are written to; all files are known to be writable then."""
        import numpy as np

        from jaxtex.cli.files import check_names
        from jaxtex.cli.other_maps import name_maps
        from jaxtex.io.copies import check_copies
        from jaxtex.io.raster import read_raster

        check_copies(self.exemplar, self.output)
        others = {"--also": self.also, "--normals": self.normals}
        maps = name_maps(others, self.exemplar, (image.width, image.height), self.output)
        fields = [Path(word) for word in (self.scale, self.orientation) if word]
        inputs = [self.exemplar, self.texton_mask, *fields, *self.also, *self.normals]
        check_names(inputs, [self.output, self.save, *(made for _, made in maps)], keys=self.keys)
        for option, paths in others.items():
            for path in paths:
                raster = read_raster(path)
                if option == "--normals" and len(raster.channels) < 3:
                    raise InputError(f"--normals: {path} has fewer than three channels; give x, y and z")
                if not np.isfinite(raster.numbers).all():  # they would spread to what is mixed with them
                    raise InputError(f"{option}: {path} holds numbers that are NaN or infinite; replace them")
        return maps

    def _check_neighbourhoods(self, image: "Image") -> None:
        if min(image.width, image.height) < self.neighborhood:
            raise InputError(
                f"{self.exemplar}: is {image.width} x {image.height} pixels, and neighborhoods are {self.neighborhood} "
                f"x {self.neighborhood}; give a larger picture, or a smaller --neighborhood"
            )

    def _synthesise(self, image: "Image", scale: "np.ndarray", angles: "np.ndarray", radius: int) -> "np.ndarray":
        import jax

        from jaxtex.cli.synth_methods import encode
        from jaxtex.progressive.masked import mark_elements
        from jaxtex.progressive.texton_masks import read_texton_mask
        from jaxtex.synthesis.anisometric import anisometric_steps

        exemplar = encode(image.pixels, image.alpha)
        if self.texton_mask is not None:
            exemplar = mark_elements(exemplar, read_texton_mask(self.texton_mask, (image.width, image.height)))
        steps = anisometric_steps(
            exemplar,
            scale,
            angles,
            key=jax.random.key(self.seed),
            radius=radius,
            tileable=self.tileable,
        )
        with reporting(f"making {self.output}") as report:
            for step in steps:
                report(step.done, step.total)
        return step.sources

    def _write(self, image: "Image", made: "_Made", maps: list[tuple[Path, Path]]) -> None:
        from collections.abc import Callable

        from jaxtex.cli.files import write_together
        from jaxtex.io.copies import write_as_deep
        from jaxtex.io.raster import read_raster
        from jaxtex.progressive.varying import write_varying

        picture = made.show(_with_alpha(image))
        seen = picture if image.alpha is None else _unweigh(picture, -1)
        deep = read_raster(self.exemplar)
        writers: dict[Path, Callable[[Path], None]] = {self.output: lambda path: write_as_deep(deep, path, seen)}
        for source, output in maps:
            writers[output] = partial(_write_map, source, made=made, turns=source in self.normals)
        if self.save is not None:
            varying = self._gather(picture[..., : image.pixels.shape[2]], made)
            writers[self.save] = lambda path: write_varying(path, varying)
        write_together(writers)
        told = f"{picture.shape[1]} x {picture.shape[0]} pixels" + (", tileable" if self.tileable else "")
        for output in (self.output, *(output for _, output in maps)):
            print(f"{output}: {told}")
        if self.save is not None:
            print(f"{self.save}: texture, {'mask, ' if self.texton_mask else ''}scale and orientation")

    def _gather(self, texture: "np.ndarray", made: "_Made") -> "VaryingTexture":
        import numpy as np

        from jaxtex.progressive.texton_masks import read_texton_mask
        from jaxtex.progressive.varying import VaryingTexture

        mask = None
        if self.texton_mask is not None:
            row, column = np.moveaxis(np.rint(made.sources).astype(int), -1, 0)
            mask = read_texton_mask(self.texton_mask)[row, column]
        return VaryingTexture.of(texture, mask=mask, orientation=made.orientation, scale=made.scale)


def _check_repeating(scale: "np.ndarray", angles: "np.ndarray") -> None:
    """Things that are larger, or turned further, on one side of a border than beyond it would be cut there."""
    import numpy as np

    from jaxtex.synthesis.anisometric import make_frames

    frames = make_frames(scale, angles)
    for axis, sides in enumerate(("upper and lower", "left and right")):
        one, other = (np.take(frames, at, axis=axis) for at in (0, -1))
        if np.any(np.linalg.norm(one - other, axis=(1, 2)) > _MOST_APART * np.linalg.norm(one, axis=(1, 2))):
            raise InputError(
                f"--tileable: scales or directions are not the same along the {sides} borders; give fields that "
                "repeat, or leave --tileable out"
            )


class _Made(NamedTuple):
    """What comes from where.

    Attributes:
        sources: (row, col) of the exemplar, between pixels too, [row, col, 2].
        scale: [row, col].
        orientation: (x, y), [row, col, 2].
    """

    sources: "np.ndarray"
    scale: "np.ndarray"
    orientation: "np.ndarray"

    def show(self, picture: "np.ndarray") -> "np.ndarray":
        """The same of the exemplar or of another map of it, [row, col, channel]."""
        from jaxtex.synthesis.anisometric import make_frames, sample_sources

        return sample_sources(picture, self.sources, make_frames(self.scale, _angles_of(self.orientation)))


def _write_map(source: Path, output: Path, *, made: _Made, turns: bool) -> None:
    import numpy as np

    from jaxtex.io.copies import write_like
    from jaxtex.io.raster import read_raster
    from jaxtex.progressive.normal_maps import is_signed, turn_normals

    raster = read_raster(source)
    alpha = raster.channels.index("A") if "A" in raster.channels and not raster.premultiplied else None

    def show(numbers: "np.ndarray") -> "np.ndarray":
        shown = made.show(numbers) if alpha is None else _unweigh(made.show(_weigh(numbers, alpha)), alpha)
        if turns:
            most = np.iinfo(numbers.dtype).max if np.issubdtype(numbers.dtype, np.integer) else 1
            half, middle = (1, 0) if most == 1 and is_signed(numbers[..., :3]) else (most / 2, most / 2)
            turned = turn_normals((shown[..., :3] - middle) / half, _angles_of(made.orientation))
            shown[..., :3] = middle + half * turned
        return shown

    write_like(source, output, show)


def _angles_of(orientation: "np.ndarray") -> "np.ndarray":
    import numpy as np

    return np.arctan2(orientation[..., 1], orientation[..., 0])


def _with_alpha(image: "Image") -> "np.ndarray":
    """Linear light; with alpha, multiplied by it, and followed by it."""
    import numpy as np

    if image.alpha is None:
        return image.pixels
    return _weigh(np.concatenate([image.pixels, image.alpha[..., None]], axis=2), -1)


def _weigh(picture: "np.ndarray", alpha: int) -> "np.ndarray":
    """All channels multiplied by that of alpha, but for itself, so that what is not seen is not mixed in."""
    import numpy as np

    weighted = picture.astype(np.float32) * picture[..., alpha, None]
    weighted[..., alpha] = picture[..., alpha]
    return weighted


def _unweigh(picture: "np.ndarray", alpha: int) -> "np.ndarray":
    """What was multiplied by alpha before, multiplied no more; 0 where alpha is."""
    import numpy as np

    cover = picture[..., alpha, None]
    plain = np.divide(picture, cover, out=np.zeros_like(picture), where=cover > 0)
    plain[..., alpha] = picture[..., alpha]
    return plain
