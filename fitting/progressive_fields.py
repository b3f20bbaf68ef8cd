"""Figures 2 and 3 of J. Zhang et al., "Synthesis of Progressively-Variant Textures on Arbitrary Surfaces" (SIGGRAPH
2003): textures that vary by fields, and others made of these.

    python fitting/progressive_fields.py FOLDER -o OUT

FOLDER holds pictures of reptile skin and coffee beans. OUT/figure_3.png has them with their things made smaller to the
right, OUT/figure_2.png a texture that varies in scale and direction with another made of it: without its own directions
being known, and with.
"""

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

import jax
import numpy as np
import numpy.typing as npt

import jaxtex as jt
from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
from jaxtex.io.files import prepare_folder
from jaxtex.synthesis.anisometric import Transition, make_frames, sample_sources, synthesise_anisometric

EXEMPLARS = "reptile_skin.png", "coffee_beans.jpg"
SIDE = 256  # pixels of an exemplar that are used
SMALLEST = 0.45  # times as large as in the exemplar
KEY = jax.random.key(0)

Floats = npt.NDArray[np.floating]


def read_exemplar(folder: Path, name: str) -> Floats:
    """Encoded, of three channels."""
    picture = linear_to_srgb(jt.read_image(folder / name).pixels[:SIDE, :SIDE])
    return np.broadcast_to(picture, (*picture.shape[:2], 3))


def vary(exemplar: Floats, scale: Floats, orientation: Floats) -> Floats:
    sources = synthesise_anisometric(exemplar, scale, orientation, key=KEY)
    return sample_sources(exemplar, sources, make_frames(scale, orientation))


def draw_figure_3(folder: Path) -> Floats:
    """Things made smaller to the right, each beside its exemplar."""
    rows = []
    for name in EXEMPLARS:
        exemplar = read_exemplar(folder, name)
        scale = np.geomspace(1.2, SMALLEST, 2 * SIDE)[None].repeat(SIDE, axis=0)
        rows.append(np.concatenate([exemplar, np.ones((SIDE, 8, 3)), vary(exemplar, scale, 0 * scale)], axis=1))
    return np.concatenate(rows)


def draw_figure_2(folder: Path) -> Floats:
    """A varying texture, another made of it without knowledge of its directions, and with; the transition functions
    and directions of both above."""
    down, right = np.indices((SIDE, SIDE)) / (SIDE - 1)
    far, turn = right, np.radians(100) * right
    size = SMALLEST ** (0.7 * far)
    varying = vary(read_exemplar(folder, EXEMPLARS[0]), size, turn)
    wanted_far, wanted_turn = down, np.radians(60) * (right - down)
    wanted = SMALLEST ** (0.7 * wanted_far), wanted_turn
    made = []
    for known_turn in (0 * turn, turn):
        sources = synthesise_anisometric(
            varying,
            *wanted,
            key=KEY,
            exemplar_frames=(size, known_turn),
            transition=Transition(far, wanted_far),
        )
        made.append(sample_sources(varying, sources))
    fields = [draw_fields(far, turn), draw_fields(wanted_far, wanted_turn), np.ones((SIDE, SIDE, 3))]
    return np.concatenate([np.concatenate(each, axis=1) for each in (fields, [varying, *made])])


def draw_fields(transition: Floats, orientation: Floats, apart: int = 32) -> Floats:
    """A transition function in greys, with a stroke every so many pixels in the direction there."""
    drawn = (0.3 + 0.6 * transition)[..., None].repeat(3, axis=2)
    for row in range(apart // 2, len(drawn), apart):
        for column in range(apart // 2, drawn.shape[1], apart):
            along = np.linspace(-0.35, 0.35, 2 * apart)[:, None] * apart
            angle = orientation[row, column]
            place = np.rint([row, column] + along * [np.sin(angle), np.cos(angle)]).astype(int)
            drawn[place[:, 0], place[:, 1]] = 0.8, 0.2, 0.1
    return drawn


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="pictures, by the names that the script tells")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT", help="folder for what is made")
    options = parser.parse_args(words)
    prepare_folder(options.output)
    for name, draw in (("figure_3", draw_figure_3), ("figure_2", draw_figure_2)):
        jt.write_image(options.output / f"{name}.png", srgb_to_linear(np.clip(draw(options.folder), 0, 1)))


if __name__ == "__main__":
    main()
