"""`jaxtex synth --method heeger-bergen`: a texture made of noise."""

from typing import TYPE_CHECKING

from jaxtex.cli.values import check_memory, cut_rectangle
from jaxtex.core.errors import InputError

if TYPE_CHECKING:
    import numpy as np

    from jaxtex.cli.synth import Synth
    from jaxtex.io.images import Image

_MOST_SCALES = 16
_MOST_ORIENTATIONS = 16
_MOST_ITERATIONS = 1000
_FINEST = 16


def make_of_noise(
    options: "Synth", size: tuple[int, int] | None, rectangles: list[tuple[float, float, float, float]]
) -> int:
    """Run the command; `size` is (width, height), `rectangles` are regions (x, y, width, height)."""
    scales = _in_range("scales", options.scales, 4, 1, _MOST_SCALES)
    orientations = _in_range("orientations", options.orientations, 4, 1, _MOST_ORIENTATIONS)
    iterations = _in_range("iterations", options.iterations, 5, 1, _MOST_ITERATIONS)
    finer = _in_range("finer", options.finer, 0, 0, _FINEST)

    import jax
    import numpy as np

    from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
    from jaxtex.io.images import read_image, writing_image
    from jaxtex.synthesis.heeger_bergen import analyse_texture, estimate_memory, synthesise_texture

    exemplar = read_image(options.exemplar)
    regions = _cut_regions(exemplar, rectangles)
    seen_height, seen_width = regions.shape[1:3]
    width, height = size or (seen_width * 2**finer, seen_height * 2**finer)
    _check_scales(scales, finer, (seen_height, seen_width), (height, width))
    needed = estimate_memory((height, width), orientations=orientations, channels=regions.shape[3])
    check_memory(f"--size: {width}x{height}", needed)
    with writing_image(options.output, size=(width, height), channels=regions.shape[3]) as write_rows:
        # Matched as sRGB-encoded values, whose steps are about equally visible.
        statistics = analyse_texture(linear_to_srgb(regions), scales=scales, orientations=orientations)
        key = jax.random.key(options.seed)
        texture = synthesise_texture(statistics, (height, width), key=key, iterations=iterations, finer=finer)
        write_rows(srgb_to_linear(np.asarray(texture)))
    print(f"{options.output}: {width} x {height} pixels, tileable")
    return 0


def _in_range(name: str, value: int | None, default: int, least: int, most: int) -> int:
    if value is None:
        return default
    if not least <= value <= most:
        raise InputError(f"--{name}: {value} is out of range; give a number from {least} to {most}")
    return value


def _check_scales(scales: int, finer: int, seen: tuple[int, int], made: tuple[int, int]) -> None:
    from jaxtex.core.pyramids import most_scales

    fit = most_scales(seen)
    if scales > fit:
        raise InputError(
            f"--scales: {scales} do not fit what is learnt from, which is {seen[1]} x {seen[0]} pixels; "
            f"give at most {fit}, or a larger region"
        )
    fit = most_scales(made)
    if scales + finer > fit:
        told = f" and {finer} finer" if finer else ""
        raise InputError(
            f"--size: {made[1]}x{made[0]} holds {fit} scales, not {scales}{told}; "
            f"give {4 * 2 ** (scales + finer)} pixels to a side at least, or fewer --scales"
        )


def _cut_regions(exemplar: "Image", rectangles: list[tuple[float, float, float, float]]) -> "np.ndarray":
    """What is learnt from, [region, row, col, channel], linear light."""
    import numpy as np

    whole = (0.0, 0.0, float(exemplar.width), float(exemplar.height))
    regions = []
    for rectangle in rectangles or [whole]:
        inside = cut_rectangle("--region", rectangle, exemplar.path, (exemplar.width, exemplar.height))
        if exemplar.alpha is not None and exemplar.alpha[inside].min() < 1:
            x, y, width, height = rectangle
            where = f"--region: {x:g},{y:g},{width:g}x{height:g}" if rectangles else str(exemplar.path)
            raise InputError(f"{where} is transparent in places; learn from --region rectangles that are opaque")
        regions.append(exemplar.pixels[inside])
    sizes = sorted({f"{region.shape[1]}x{region.shape[0]}" for region in regions})
    if len(sizes) > 1:
        raise InputError(f"--region: sizes are {', '.join(sizes)}; give all regions one size")
    return np.stack(regions)
