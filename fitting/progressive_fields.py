"""Figures 2 and 3 of Zhang et al., drawn by `progressive.py`: textures that vary by fields, and one made of another."""

from pathlib import Path

import numpy as np
from progressive_exemplars import KEY, SIDE, Floats, read_picture

from jaxtex.synthesis.anisometric import Transition, make_frames, sample_sources, synthesise_anisometric

EXEMPLARS = "reptile_skin.png", "coffee_beans.jpg"
SMALLEST = 0.45  # times as large as in the exemplar


def vary(exemplar: Floats, scale: Floats, orientation: Floats) -> Floats:
    sources = synthesise_anisometric(exemplar, scale, orientation, key=KEY)
    return sample_sources(exemplar, sources, make_frames(scale, orientation))


def draw_figure_3(folder: Path) -> Floats:
    """Things made smaller to the right, each beside its exemplar."""
    rows = []
    for name in EXEMPLARS:
        exemplar = read_picture(folder, name)
        scale = np.geomspace(1.2, SMALLEST, 2 * SIDE)[None].repeat(SIDE, axis=0)
        rows.append(np.concatenate([exemplar, np.ones((SIDE, 8, 3)), vary(exemplar, scale, 0 * scale)], axis=1))
    return np.concatenate(rows)


def draw_figure_2(folder: Path) -> Floats:
    """A varying texture, another made of it without knowledge of its directions, and with; the transition functions
    and directions of both above."""
    down, right = np.indices((SIDE, SIDE)) / (SIDE - 1)
    far, turn = right, np.radians(100) * right
    size = SMALLEST ** (0.7 * far)
    varying = vary(read_picture(folder, EXEMPLARS[0]), size, turn)
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
