"""`jaxtex synth` by methods that copy pixels of the exemplar: colours, and whatever other maps go with them."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from jaxtex.cli.other_maps import name_maps
from jaxtex.cli.progress import reporting
from jaxtex.cli.synth_methods import encode, start_method, white_of
from jaxtex.cli.values import check_memory, cut_rectangle
from jaxtex.core.errors import InputError

if TYPE_CHECKING:
    import numpy as np

    from jaxtex.cli.synth import Synth
    from jaxtex.synthesis.sources import Sources, Step

_LARGEST_NEIGHBORHOOD = 41
_MOST_PASSES = 1000
_MOST_SIMILAR = 64
_MOST_LEVELS = 8
_WIDEST_BLEND = 16
_LEAST_MEMORY = 64  # bytes that each pixel of the result takes, whatever the method

Rectangle = tuple[float, float, float, float]


class _Exemplar(NamedTuple):
    """What is learnt from.

    Attributes:
        encoded: [row, col, channel], sRGB-encoded, whose steps look even; alpha is a channel.
        white: the encoded value that is 1 there, at least 1.
        corner: its (row, col) in the file's picture.
        size: (width, height) of that picture.
    """

    encoded: "np.ndarray"
    white: float
    corner: tuple[int, int]
    size: tuple[int, int]


def make_of_copies(options: "Synth", size: tuple[int, int] | None, rectangles: list[Rectangle]) -> int:
    """Run the command; `size` is (width, height), `rectangles` are regions (x, y, width, height)."""
    _check_numbers(options)

    import jax
    import numpy as np

    from jaxtex.io.copies import write_copies

    if size is not None:
        check_memory(f"--size: {size[0]}x{size[1]}", _LEAST_MEMORY * size[0] * size[1])
    exemplar = _read_exemplar(options.exemplar, rectangles)
    maps = name_maps({"--also": options.also}, options.exemplar, exemplar.size, options.output)
    _check_outputs(options, [made for _, made in maps])
    steps = start_method(options, exemplar.encoded, exemplar.white, size, jax.random.key(options.seed))
    sources = _watch(options, exemplar, steps)
    rows, columns = np.moveaxis(sources + np.array(exemplar.corner), -1, 0)
    tileable = options.tileable or (options.method == "coherence" and options.inpaint is None)
    if options.blend is not None:
        _write_blended(options, exemplar, sources, options.blend, tileable)
    else:
        write_copies(options.exemplar, options.output, rows, columns)
    for path, output in maps:
        write_copies(path, output, rows, columns)
    told = f"{sources.shape[1]} x {sources.shape[0]} pixels" + (", tileable" if tileable else "")
    for output in (options.output, *(output for _, output in maps)):
        print(f"{output}: {told}")
    return 0


def _check_numbers(options: "Synth") -> None:
    bounds = {
        "neighborhood": (options.neighborhood, 3, _LARGEST_NEIGHBORHOOD),
        "block": (options.block, 2, math.inf),
        "passes": (options.passes, 1, _MOST_PASSES),
        "similar": (options.similar, 1, _MOST_SIMILAR),
        "levels": (options.levels, 1, _MOST_LEVELS),
        "guide-weight": (options.guide_weight, 0.01, 100),
        "blend": (options.blend, 0.3, _WIDEST_BLEND),
    }
    for name, (value, least, most) in bounds.items():
        if value is not None and not least <= value <= most:
            told = f"a number from {least} to {most}" if most < math.inf else f"{least} or more"
            raise InputError(f"--{name}: {value} is out of range; give {told}")
    if options.neighborhood is not None and options.neighborhood % 2 == 0:
        raise InputError(f"--neighborhood: {options.neighborhood} has no middle; give an odd number, as 5 or 7")
    if len(options.region) > 1:
        raise InputError(f"--region: {options.method} learns from one; heeger-bergen takes more")
    if options.guide is None and options.guide_weight is not None:
        raise InputError("--guide-weight: there is no --guide that it could be of; give both")
    if options.guide is not None and options.region:
        raise InputError("--region: does not go with --guide; cut the exemplar and its guide out alike")
    if options.texton_mask is not None and options.region:
        raise InputError("--region: does not go with --texton-mask; cut the exemplar and its mask out alike")
    if options.texton_mask is not None and options.guide is not None:
        raise InputError("--guide: does not go with --texton-mask; give one of both")
    if options.inpaint is not None:
        for name in ("size", "region", "guide", "tileable", "texton_mask"):
            if getattr(options, name):
                raise InputError(
                    f"--{name.replace('_', '-')}: does not go with --inpaint, which fills the exemplar as it is"
                )


def _read_exemplar(path: Path, rectangles: list[Rectangle]) -> _Exemplar:
    from jaxtex.io.images import read_image

    image = read_image(path)
    size = image.width, image.height
    pixels = encode(image.pixels, image.alpha)
    white = white_of(image.pixels)
    if not rectangles:
        return _Exemplar(pixels, white, (0, 0), size)
    inside = cut_rectangle("--region", rectangles[0], path, size)
    return _Exemplar(pixels[inside], white, (inside[0].start, inside[1].start), size)


def _check_outputs(options: "Synth", maps: list[Path]) -> None:
    """All files are known to be writable then, and none written over another; `maps` are the other maps'."""
    from jaxtex.cli.files import check_names
    from jaxtex.io.copies import check_copies

    check_copies(options.exemplar, options.output)
    if options.preview is not None:
        check_copies(options.exemplar, options.preview)
    inputs = [options.exemplar, options.target, options.inpaint, options.texton_mask]
    check_names([*inputs, *(options.guide or ()), *options.also], [options.output, *maps, options.preview])


def _watch(options: "Synth", exemplar: _Exemplar, steps: Iterator["Step"]) -> "Sources":
    """The last step's source map, with progress and a preview on the way."""
    import numpy as np

    from jaxtex.io.images import write_image
    from jaxtex.synthesis.sources import copy_sources

    with reporting(f"making {options.output}") as report:
        for step in steps:
            report(step.done, step.total)
            if options.preview is not None:
                seen = np.maximum(step.sources, 0) if options.inpaint is None else _own_where_known(step.sources)
                write_image(options.preview, _colours_of(exemplar, copy_sources(exemplar.encoded, seen)))
    return _own_where_known(step.sources)


def _own_where_known(sources: "Sources") -> "Sources":
    """Pixels that a method kept as they are, which have no source, are their own."""
    import numpy as np

    rows, columns = np.indices(sources.shape[:2])
    return np.where(sources < 0, np.dstack([rows, columns]), sources).astype(np.int32)


def _colours_of(exemplar: _Exemplar, encoded: "np.ndarray") -> "np.ndarray":
    """Linear light, and alpha."""
    import numpy as np

    from jaxtex.core.colour import srgb_to_linear

    if encoded.shape[2] in (1, 3):
        return srgb_to_linear(encoded * exemplar.white)
    colours, alpha = encoded[..., :-1], encoded[..., -1:]
    colours = np.divide(colours, alpha, out=np.zeros_like(colours), where=alpha > 0)
    return np.concatenate([srgb_to_linear(colours * exemplar.white), alpha], axis=2)


def _write_blended(options: "Synth", exemplar: _Exemplar, sources: "Sources", width: float, tileable: bool) -> None:
    """Blended as it looks; colours under alpha have been multiplied by it."""
    from jaxtex.io.copies import write_as_deep
    from jaxtex.io.raster import read_raster
    from jaxtex.synthesis.sources import blend_seams

    blended = blend_seams(exemplar.encoded, sources, width=width, repeats=tileable)
    write_as_deep(read_raster(options.exemplar), options.output, _colours_of(exemplar, blended))
