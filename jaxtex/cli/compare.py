"""`jaxtex compare`: what all methods of synthesis make of a texture, side by side.

The sheet and its table hold timings, as reports do; all else in them is the same every time.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple, get_args

import tyro

from jaxtex.cli.synth import Method

if TYPE_CHECKING:
    import numpy as np
    from jax import Array
    from rich.table import Table

    from jaxtex.cli.contact_sheet import Cell
    from jaxtex.synthesis.methods import Texture
    from jaxtex.synthesis.sources import Sources

_LEAST_SIDE = 16  # pixels: the largest neighbourhood, and two octaves
_MOST_SIDE = 1024  # of the textures
_LEARNT_FROM = 192  # pixels of the exemplar's side, unless the user says
_OCTAVES = 4
_HEADINGS = ("method", "seconds", "patches", "statistics", "copied", "pieces")
_EXPLAINED = (
    "patches: sliced Wasserstein distance",
    "statistics: Portilla-Simoncelli distance",
    "    (both are flattered by copying)",
    "copied: share of 9 x 9 windows",
    "pieces: pixels of a copied one, mean",
)


class Figures(NamedTuple):
    """What is measured of a texture.

    Attributes:
        seconds: that it took to make.
        patches: sliced Wasserstein distance to the exemplar.
        statistics: Portilla and Simoncelli's.
        copied: share of its 9 x 9 windows that stand in the exemplar as they are, 0 to 1.
        pieces: mean size in pixels of the pieces it consists of; None where it is not copied.
    """

    seconds: float
    patches: float
    statistics: float
    copied: float
    pieces: float | None


@dataclass(frozen=True, kw_only=True)
class Compare:
    """Make a texture by every method of jaxtex synth, with its default settings, and draw them all on one sheet.

    With each stand its figures, which are also printed, and written as a table (.csv) beside the sheet:

    seconds: that it took to make here. What JAX compiles anew, the first time that textures of a size are made of an
    exemplar of a size, is part of it, as it is of jaxtex synth; run it again to see how long it takes from then on.

    patches: sliced Wasserstein distance from the exemplar, of patches at four scales; 0 is alike.

    statistics: Portilla and Simoncelli's distance; 0 is alike, 1 about as far as other textures are.

    copied: share of windows of 9 x 9 pixels that stand in the exemplar as they are. Copying flatters both distances.

    pieces: pixels of the pieces that were copied, in the mean; the small picture below gives each its own colour.

    Example: jaxtex compare pebbles.jpg -o sheet.png

    Example: jaxtex compare wall.jpg -o sheet.png --region 40,80,256x256 --methods coherence quilting --seed 3
    """

    exemplar: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="EXEMPLAR")]
    """The picture of the texture, seen straight on and evenly lit."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The sheet to write: .png, .jpg, .tif or .exr."""
    size: Annotated[str, tyro.conf.arg(metavar="WxH")] = "256x256"
    """Size of the textures in pixels."""
    methods: tuple[Method, ...] = get_args(Method)
    """Which methods."""
    region: Annotated[str | None, tyro.conf.arg(metavar="X,Y,WxH", help_behavior_hint="")] = None
    """The rectangle of the exemplar to learn from, its upper left corner and its size in pixels. By default its middle,
    at most 192x192: some methods look at all of it for each pixel that they make."""
    seed: int = 0
    """Another number, other textures."""

    def run(self) -> int:
        from jaxtex.cli.values import check_seed, parse_size
        from jaxtex.core.errors import InputError

        check_seed(self.seed)
        width, height = parse_size("--size", self.size)
        if not _LEAST_SIDE <= min(width, height) <= max(width, height) <= _MOST_SIDE:
            told = f"give {_LEAST_SIDE} to {_MOST_SIDE} pixels to a side"
            raise InputError(f"--size: {width}x{height} is out of range; {told}, or use jaxtex synth")
        if not self.methods or len(set(self.methods)) < len(self.methods):
            raise InputError(f"--methods: name each once, of {', '.join(get_args(Method))}")
        return _compare(self, _read_exemplar(self.exemplar, self.region), (height, width))


def _compare(options: Compare, exemplar: "np.ndarray", shape: tuple[int, int]) -> int:
    import jax
    from rich.console import Console

    from jaxtex.cli.contact_sheet import Cell, draw_contact_sheet, lay_out
    from jaxtex.core.colour import srgb_to_linear
    from jaxtex.io.files import atomic_write_text
    from jaxtex.io.images import writing_image

    rows, columns = (max(sides) for sides in zip(exemplar.shape[:2], shape, strict=True))
    told = f"{exemplar.shape[1]} x {exemplar.shape[0]} pixels"
    cells = [Cell("exemplar", exemplar, None, (options.exemplar.name, told, *_EXPLAINED))]
    layout = lay_out(1 + len(options.methods), largest=(columns, rows), lines=len(cells[0].lines))
    table = options.output.with_suffix(".csv")
    with writing_image(options.output, size=layout.size, channels=3) as write_rows:
        made, figures = _make_all(options.methods, exemplar, shape, jax.random.key(options.seed))
        cells += [_show_cell(name, made[name], figures[name]) for name in options.methods]
        write_rows(srgb_to_linear(draw_contact_sheet(cells, layout)))
    Console(highlight=False).print(_table(figures))
    lines = [",".join(_HEADINGS), *(_csv_line(name, each) for name, each in figures.items())]
    atomic_write_text(table, "\n".join(lines) + "\n")
    print(f"{options.output}: {layout.size[0]} x {layout.size[1]} pixels\n{table}: these figures")
    return 0


def _read_exemplar(path: Path, region: str | None) -> "np.ndarray":
    """What is learnt from, [row, col, channel], encoded."""
    from jaxtex.cli.synth_methods import encode
    from jaxtex.cli.values import cut_rectangle, parse_rectangle
    from jaxtex.core.errors import InputError
    from jaxtex.io.images import read_image

    rectangle = None if region is None else parse_rectangle("--region", region)
    image = read_image(path)
    size = image.width, image.height
    inside = cut_rectangle("--region", rectangle or _middle(*size), path, size)
    height, width = image.pixels[inside].shape[:2]
    if min(height, width) < _LEAST_SIDE:
        raise InputError(
            f"{path if region is None else '--region'}: {width} x {height} pixels are too few to learn from; give "
            f"{_LEAST_SIDE} to a side"
        )
    if image.alpha is not None and image.alpha[inside].min() < 1:
        raise InputError(f"{path}: is transparent where it is learnt from; give a --region that is opaque")
    return encode(image.pixels[inside], None)


def _middle(width: int, height: int) -> tuple[float, float, float, float]:
    across, down = min(width, _LEARNT_FROM), min(height, _LEARNT_FROM)
    return (width - across) // 2, (height - down) // 2, across, down


def _make_all(
    methods: tuple[Method, ...], exemplar: "np.ndarray", shape: tuple[int, int], key: "Array"
) -> tuple[dict[Method, "Texture"], dict[Method, Figures]]:
    """Textures and their figures, by method; a person sees the table of these grow on stderr meanwhile."""
    import time

    from rich.console import Console
    from rich.live import Live

    from jaxtex.synthesis.methods import METHODS

    made: dict[Method, Texture] = {}
    figures: dict[Method, Figures] = {}
    with Live(console=Console(stderr=True, highlight=False), auto_refresh=False, transient=True) as live:
        for name in methods:
            live.update(_table(figures, running=name), refresh=True)
            start = time.perf_counter()
            made[name] = METHODS[name](exemplar, shape, key=key)
            figures[name] = _measure(exemplar, made[name], time.perf_counter() - start)
    return made, figures


def _measure(exemplar: "np.ndarray", texture: "Texture", seconds: float) -> Figures:
    import jax

    from jaxtex.core.pyramids import most_scales
    from jaxtex.synthesis.copying import measure_pieces, verbatim_share
    from jaxtex.synthesis.distances import sliced_wasserstein
    from jaxtex.synthesis.portilla_simoncelli import portilla_simoncelli_distance

    pixels, sources = texture
    scales = min(_OCTAVES, most_scales(exemplar.shape[:2]), most_scales(pixels.shape[:2]))
    return Figures(
        seconds,
        sliced_wasserstein(exemplar, pixels, key=jax.random.key(0), scales=scales).total,
        portilla_simoncelli_distance(exemplar, pixels, scales=scales).total,
        verbatim_share(exemplar, pixels),
        None if sources is None else measure_pieces(sources).mean_size,
    )


def _table(figures: dict[Method, Figures], *, running: Method | None = None) -> "Table":
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    for heading in _HEADINGS:
        table.add_column(heading, no_wrap=True, justify="left" if heading == "method" else "right")
    for name, each in figures.items():
        table.add_row(name, *_show(each).values())
    if running is not None:
        table.add_row(running, "...")
    return table


def _show(figures: Figures) -> dict[str, str]:
    """In few digits, by the names of the headings."""
    return {
        "seconds": f"{figures.seconds:.{0 if figures.seconds >= 10 else 2}f}",
        "patches": f"{figures.patches:.3f}",
        "statistics": f"{figures.statistics:.3f}",
        "copied": f"{100 * figures.copied:.0f} %",
        "pieces": "" if figures.pieces is None else f"{figures.pieces:.{0 if figures.pieces >= 10 else 1}f}",
    }


def _csv_line(name: Method, figures: Figures) -> str:
    return ",".join([name, *("" if each is None else f"{each:.6g}" for each in figures)])


def _show_cell(name: Method, texture: "Texture", figures: Figures) -> "Cell":
    from jaxtex.cli.contact_sheet import Cell

    shown = _show(figures)
    lines = [f"{shown.pop('seconds')} s", *(f"{heading} {value}" for heading, value in shown.items() if value)]
    small = None if texture.sources is None else _colour_pieces(texture.sources)
    return Cell(name, texture.pixels, small, tuple(lines))


def _colour_pieces(sources: "Sources") -> "np.ndarray":
    """Each piece in a colour of its own, drawn at random, and always the same."""
    import numpy as np

    from jaxtex.synthesis.copying import coherent_pieces

    labels = coherent_pieces(sources)
    return np.random.default_rng(0).random((int(labels.max()) + 1, 3))[labels]
