"""How closely synthesis follows a field of scales and one of directions.

    python fitting/field_distortion.py -o OUT

Spots of one size are made larger from left to right, from half to twice as large, and stripes turned by 180 degrees.
OUT/distortion.png shows both, OUT/followed.png plots what was measured against what was asked, and OUT/distortion.md
says how far they are apart: the sizes of whole spots, and directions by structure tensor.
"""

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

import jax
import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from scipy import ndimage
from skimage.feature import structure_tensor
from skimage.measure import regionprops
from skimage.segmentation import clear_border
from tables import make_table

import jaxtex as jt
from jaxtex.core.colour import srgb_to_linear
from jaxtex.io.files import atomic_write_text, prepare_folder
from jaxtex.synthesis.anisometric import make_frames, sample_sources, synthesise_anisometric

SHAPE = 192, 768
RADIUS, CELL = 6.0, 24  # of spots, and of the squares that hold one each, in pixels
PERIOD = 8.0  # of stripes, in pixels
BINS = 12
SEEDS = 3

Floats = npt.NDArray[np.floating]


def draw_spots(side: int = 192) -> Floats:
    """Dark spots of one size, one in each cell of a lattice, anywhere in it: [row, col, 1]."""
    rng = np.random.default_rng(0)
    count = side // CELL
    room = CELL / 2 - RADIUS - 1
    middles = (np.indices((count, count)).reshape(2, -1).T + 0.5) * CELL + rng.uniform(-room, room, (count**2, 2))
    place = np.moveaxis(np.indices((side, side)), 0, -1)[..., None, :]
    nearest = np.sqrt(np.square(place - middles).sum(axis=-1)).min(axis=-1)
    grain = rng.normal(0, 0.02, (side, side))
    return (0.25 + 0.5 * np.clip(nearest - RADIUS + 0.5, 0, 1) + grain)[..., None]


def draw_stripes(side: int = 128) -> Floats:
    """Vertical stripes with some grain, [row, col, 1]."""
    wave = 0.5 + 0.3 * np.sin(2 * np.pi * np.arange(side) / PERIOD)
    return (wave[None] + np.random.default_rng(0).normal(0, 0.02, (side, side)))[..., None]


def ramp(first: float, last: float) -> Floats:
    return np.linspace(first, last, SHAPE[1])[None].repeat(SHAPE[0], axis=0)


def synthesise(exemplar: Floats, scale: Floats, orientation: Floats, seed: int) -> Floats:
    sources = synthesise_anisometric(exemplar, scale, orientation, key=jax.random.key(seed))
    return sample_sources(exemplar, sources, make_frames(scale, orientation))


def measure_sizes(picture: Floats, scale: Floats) -> tuple[Floats, Floats]:
    """What was asked where each whole spot is, and how many times as wide as in the exemplar it is, [spot]."""
    spots = clear_border(ndimage.label(picture[..., 0] < 0.5)[0])
    whole = [each for each in regionprops(spots) if each.area > 0.1 * np.pi * RADIUS**2 * scale.min() ** 2]
    asked = [scale[spots == each.label].mean() for each in whole]
    return np.array(asked), np.sqrt([each.area / np.pi for each in whole]) / RADIUS


def measure_directions(picture: Floats, orientation: Floats) -> tuple[Floats, Floats]:
    """Degrees by which stripes are turned, asked and measured, of pixels that are away from the border."""
    rows, mixed, columns = structure_tensor(picture[..., 0], sigma=PERIOD, order="rc")
    across = 0.5 * np.degrees(np.arctan2(2 * mixed, columns - rows))  # of the gradient, clockwise from the right
    inner = slice(int(PERIOD), -int(PERIOD), 4)
    asked = np.degrees(orientation)[inner, inner].ravel()
    off = (across[inner, inner].ravel() - asked + 90) % 180 - 90
    return asked, asked + off


def gather(asked: Floats, measured: Floats) -> tuple[Floats, Floats]:
    """Medians of what was measured, in bins of what was asked that hold equally many."""
    parts = np.array_split(np.argsort(asked), BINS)
    return np.array([np.median(asked[part]) for part in parts]), np.array([np.median(measured[part]) for part in parts])


def plot(path: Path, sizes: tuple[Floats, Floats], turns: tuple[Floats, Floats]) -> None:
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
    for axes, (asked, measured), what, slack in (
        (left, sizes, "size of spots, times the exemplar's", lambda at: 0.1 * at),
        (right, turns, "direction of stripes, degrees", lambda at: 5 + 0 * at),
    ):
        line = np.linspace(asked.min(), asked.max(), 50)
        axes.fill_between(
            line, line - slack(line), line + slack(line), alpha=0.2, label="10 %" if axes is left else "5°"
        )
        axes.plot(asked, measured, ".", markersize=3, alpha=0.5 if axes is left else 0.05)
        axes.plot(*gather(asked, measured), "k-o", markersize=4, label="median")
        axes.set(xlabel=f"asked: {what}", ylabel="measured")
        axes.legend()
    figure.savefig(path, dpi=100)
    plt.close(figure)


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT", help="folder for what is made")
    options = parser.parse_args(words)
    prepare_folder(options.output)
    scale, turn = np.exp(ramp(np.log(0.45), np.log(2.2))), ramp(0, np.pi)
    spots = [synthesise(draw_spots(), scale, 0 * scale, seed) for seed in range(SEEDS)]
    stripes = [synthesise(draw_stripes(), 0 * turn + 1, turn, seed) for seed in range(SEEDS)]
    sizes, turns = (
        tuple(np.concatenate(each) for each in zip(*(measure(picture, field) for picture in pictures), strict=True))
        for measure, field, pictures in ((measure_sizes, scale, spots), (measure_directions, turn, stripes))
    )
    inside = (sizes[0] >= 0.5) & (sizes[0] <= 2)
    asked, measured = gather(sizes[0][inside], sizes[1][inside])
    single = np.abs(sizes[1] / sizes[0] - 1)[inside]
    off = np.abs(turns[1] - turns[0])
    middle = np.abs(np.subtract(*gather(*turns)))
    table = make_table(
        ("followed", "worst bin", "mean", "of all, within"),
        [
            ("scale, 0.5 to 2", f"{np.abs(measured / asked - 1).max():.1%}", f"{single.mean():.1%}",
             f"{np.mean(single < 0.1):.0%} within 10 %"),
            ("direction", f"{middle.max():.1f}°", f"{off.mean():.1f}°", f"{np.mean(off < 5):.0%} within 5°"),
        ],
    )  # fmt: skip
    atomic_write_text(options.output / "distortion.md", f"# Fields followed\n\n{table}\n")
    print(table)
    sheet = np.concatenate([spots[0], stripes[0]])
    jt.write_image(options.output / "distortion.png", srgb_to_linear(np.clip(sheet, 0, 1).repeat(3, axis=2)))
    plot(options.output / "followed.png", sizes, turns)


if __name__ == "__main__":
    main()
