"""`jaxtex synth`: more of a texture, from a picture of it."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

if TYPE_CHECKING:
    import numpy as np

    from jaxtex.io.images import Image

_MOST_SCALES = 16
_MOST_ORIENTATIONS = 16
_MOST_ITERATIONS = 1000
_FINEST = 16


@dataclass(frozen=True, kw_only=True)
class Synth:
    """Make more of a texture from a picture of it. The result is tileable: it repeats seamlessly.

    Method heeger-bergen starts from noise and gives its pixels, and its detail of every size and direction, the
    exemplar's distributions (Heeger and Bergen 1995). It suits what has no outlines: granite, plaster, sand, fur.

    Example: jaxtex synth granite.jpg -o granite_tile.png --size 1024x1024

    Example: jaxtex synth wall.jpg -o plaster.png --region 40,60,256x256 --region 700,80,256x256 --finer 2
    """

    exemplar: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="EXEMPLAR")]
    """The picture of the texture, seen straight on and evenly lit."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The picture to write: .png, .jpg, .tif or .exr."""
    method: Literal["heeger-bergen"] = "heeger-bergen"
    """How it is made."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WxH", help_behavior_hint="")] = None
    """Its size in pixels. By default as much of the texture as the exemplar shows."""
    region: Annotated[
        tyro.conf.UseAppendAction[tuple[str, ...]], tyro.conf.arg(metavar="X,Y,WxH", help_behavior_hint="")
    ] = ()
    """A rectangle of the exemplar to learn from, its upper left corner and its size in pixels; give the option again
    for more of them, all of one size. By default the whole picture."""
    scales: int = 4
    """Number of octaves of detail, from fine to coarse, that are told apart by direction."""
    orientations: int = 4
    """Number of directions told apart."""
    iterations: int = 5
    """How often pixels and detail are given the exemplar's distributions in turn."""
    finer: int = 0
    """Octaves of detail to add beyond the exemplar's resolution: with 1, what spans 10 pixels there spans 20 here."""
    seed: int = 0
    """Another number, another piece of the texture."""

    def run(self) -> int:
        from jaxtex.cli.values import check_seed, parse_rectangle, parse_size

        seed = check_seed(self.seed)
        size = None if self.size is None else parse_size("--size", self.size)
        rectangles = [parse_rectangle("--region", word) for word in self.region]
        self._check_numbers()

        import jax
        import numpy as np

        from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
        from jaxtex.io.images import read_image, writing_image
        from jaxtex.synthesis.heeger_bergen import analyse_texture, synthesise_texture

        exemplar = read_image(self.exemplar)
        regions = _cut_regions(exemplar, rectangles)
        seen_height, seen_width = regions.shape[1:3]
        width, height = size or (seen_width * 2**self.finer, seen_height * 2**self.finer)
        self._check_scales((seen_height, seen_width), (height, width))
        _check_memory((height, width), self.orientations, regions.shape[3])
        with writing_image(self.output, size=(width, height), channels=regions.shape[3]) as write_rows:
            # Matched as sRGB-encoded values, whose steps are about equally visible.
            statistics = analyse_texture(linear_to_srgb(regions), scales=self.scales, orientations=self.orientations)
            texture = synthesise_texture(
                statistics, (height, width), key=jax.random.key(seed), iterations=self.iterations, finer=self.finer
            )
            write_rows(srgb_to_linear(np.asarray(texture)))
        print(f"{self.output}: {width} x {height} pixels, tileable")
        return 0

    def _check_numbers(self) -> None:
        from jaxtex.core.errors import InputError

        bounds = {
            "scales": (self.scales, 1, _MOST_SCALES),
            "orientations": (self.orientations, 1, _MOST_ORIENTATIONS),
            "iterations": (self.iterations, 1, _MOST_ITERATIONS),
            "finer": (self.finer, 0, _FINEST),
        }
        for name, (value, least, most) in bounds.items():
            if not least <= value <= most:
                raise InputError(f"--{name}: {value} is out of range; give a number from {least} to {most}")

    def _check_scales(self, seen: tuple[int, int], made: tuple[int, int]) -> None:
        from jaxtex.core.errors import InputError
        from jaxtex.core.pyramids import most_scales

        fit = most_scales(seen)
        if self.scales > fit:
            raise InputError(
                f"--scales: {self.scales} do not fit what is learnt from, which is {seen[1]} x {seen[0]} pixels; "
                f"give at most {fit}, or a larger region"
            )
        fit = most_scales(made)
        if self.scales + self.finer > fit:
            finer = f" and {self.finer} finer" if self.finer else ""
            raise InputError(
                f"--size: {made[1]}x{made[0]} holds {fit} scales, not {self.scales}{finer}; "
                f"give {4 * 2 ** (self.scales + self.finer)} pixels to a side at least, or fewer --scales"
            )


def _cut_regions(exemplar: "Image", rectangles: list[tuple[float, float, float, float]]) -> "np.ndarray":
    """What is learnt from, [region, row, col, channel], linear light."""
    import numpy as np

    from jaxtex.core.errors import InputError

    whole = (0.0, 0.0, float(exemplar.width), float(exemplar.height))
    regions = []
    for x, y, width, height in rectangles or [whole]:
        left, top, right, bottom = (round(edge) for edge in (x, y, x + width, y + height))
        told = f"--region: {x:g},{y:g},{width:g}x{height:g}"
        if not (0 <= left < right <= exemplar.width and 0 <= top < bottom <= exemplar.height):
            raise InputError(f"{told} lies outside {exemplar.path}, which is {exemplar.width} x {exemplar.height}")
        if exemplar.alpha is not None and exemplar.alpha[top:bottom, left:right].min() < 1:
            where = told if rectangles else str(exemplar.path)
            raise InputError(f"{where} is transparent in places; learn from --region rectangles that are opaque")
        regions.append(exemplar.pixels[top:bottom, left:right])
    sizes = sorted({f"{region.shape[1]}x{region.shape[0]}" for region in regions})
    if len(sizes) > 1:
        raise InputError(f"--region: sizes are {', '.join(sizes)}; give all regions one size")
    return np.stack(regions)


def _check_memory(shape: tuple[int, int], orientations: int, channels: int) -> None:
    """Refuse what needs more memory than this machine has."""
    from jaxtex.core.errors import InputError
    from jaxtex.synthesis.heeger_bergen import estimate_memory

    needed, there = estimate_memory(shape, orientations=orientations, channels=channels), _physical_memory()
    if needed > there:
        raise InputError(
            f"--size: {shape[1]}x{shape[0]} takes {needed / 2**30:.1f} GiB of memory, and this machine has "
            f"{there / 2**30:.1f}; make a smaller picture, which may be repeated without a seam"
        )


def _physical_memory() -> int:
    """Bytes; where the system does not tell, 16 GiB."""
    import os

    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return 16 * 2**30
