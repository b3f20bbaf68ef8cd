"""`jaxtex field`: how a texture is to vary over a picture, from a few keys."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from jaxtex.cli.hints import hint

if TYPE_CHECKING:
    import numpy as np

    from jaxtex.progressive.key_files import FieldKeys, FieldKind

_LEAST_MEMORY = 64  # bytes that each pixel of the field takes


@dataclass(frozen=True, kw_only=True)
class Field:
    """Make a field over a picture from a few keys: scale, transition or orientation, at each pixel.

    The file of keys has a table for each: [[scale]] (0.125 to 16), [[transition]] (0 to 1) or [[orientation]] (degrees,
    clockwise from the x axis), with a place, at = [x, y] or stroke = [[x, y], ...], in parts of the picture's width and
    height, and a value. A stroke of orientation without value has its own direction. Instead of keys, map = "grey.png"
    with low and high gives all of a field; symmetric = true says that the texture looks the same turned by half.

    Example: jaxtex field keys.toml -o scale.exr --kind scale --size 512x512 --preview look.png

    Example: jaxtex field keys.toml -o flow.exr --kind orientation --over hide.png --preview look.png
    """

    keys: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="KEYS.toml")]
    """The file of keys."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The field to write, .exr: one channel; for orientation x in red and y in green, from -1 to 1."""
    kind: Annotated[Literal["scale", "transition", "orientation"] | None, tyro.conf.arg(help_behavior_hint="")] = None
    """Which field. By default the one that the file has keys of."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WxH", help_behavior_hint="")] = None
    """Its size in pixels. By default that of the picture of --over."""
    over: Annotated[Path | None, tyro.conf.arg(metavar="PICTURE", help_behavior_hint="")] = None
    """A picture of that size to show the preview over."""
    preview: Annotated[Path | None, tyro.conf.arg(metavar="PATH", help_behavior_hint="")] = None
    """A picture to write for looking: lines of equal value, or arrows (strokes where symmetric)."""

    def run(self) -> int:
        import numpy as np

        from jaxtex.cli.field_options import LEAST_SCALE, MOST_SCALE, has_extreme_scales
        from jaxtex.cli.files import check_names, write_together
        from jaxtex.cli.values import check_memory, naming
        from jaxtex.core.errors import InputError
        from jaxtex.io.images import check_image_name, read_image, write_image
        from jaxtex.progressive.key_files import make_field, read_keys
        from jaxtex.progressive.plots import plot_orientation, plot_scalar

        if self.output.suffix.lower() != ".exr":
            raise InputError(f"{self.output}: a field is written as .exr, whose numbers are not cut at 0 and 1")
        check_names([self.over], [self.output, self.preview], keys=self.keys)
        if self.preview is not None:
            check_image_name(self.preview)
        keys = read_keys(self.keys)
        kind = self.kind or _only_kind(self.keys, keys)
        ground = None if self.over is None else read_image(self.over).pixels
        size = self._find_size(ground)
        check_memory(f"--size: {size[0]}x{size[1]}", _LEAST_MEMORY * size[0] * size[1])
        with naming(self.keys):
            field = make_field(keys, kind, size)
        # The third channel makes it a picture of colours, which every program opens.
        values = field if field.ndim == 2 else np.concatenate([field, np.zeros_like(field[..., :1])], axis=-1)
        writers: dict[Path, Callable[[Path], None]] = {
            self.output: lambda path: write_image(path, values, colour_space="data")
        }
        if self.preview is not None:
            oriented = kind == "orientation"
            plot = plot_orientation(field, ground, symmetric=keys.symmetric) if oriented else plot_scalar(field, ground)
            writers[self.preview] = lambda path: write_image(path, plot)
        write_together(writers)
        told = f", {field.min():.3g} to {field.max():.3g}" if field.ndim == 2 else ""
        print(f"{self.output}: {kind}, {field.shape[1]} x {field.shape[0]}{told}")
        if kind == "scale" and has_extreme_scales(field):
            hint(
                f"'jaxtex vary distort' takes scales from {LEAST_SCALE} to {MOST_SCALE:g} alone; change "
                f"the values in {self.keys}"
            )
        return 0

    def _find_size(self, ground: "np.ndarray | None") -> tuple[int, int]:
        from jaxtex.cli.values import parse_size
        from jaxtex.core.errors import InputError

        if self.size is not None:
            size = parse_size("--size", self.size)
        elif ground is not None:
            size = ground.shape[1], ground.shape[0]
        else:
            raise InputError("--size: not given; give the size of the field, or a picture to show it over with --over")
        if ground is not None and ground.shape[1::-1] != size:
            raise InputError(
                f"--over: {self.over} is {ground.shape[1]} x {ground.shape[0]} pixels, the field {size[0]} x {size[1]};"
                " give them one size"
            )
        return size


def _only_kind(path: Path, keys: "FieldKeys") -> "FieldKind":
    from jaxtex.core.errors import InputError
    from jaxtex.progressive.key_files import KINDS

    there = [kind for kind in KINDS if len(getattr(keys, kind))]
    if len(there) != 1:
        raise InputError(f"{path}: has keys of {' and '.join(there) or 'no field'}; name the field with --kind")
    return there[0]
