"""Fits of wood and floors to real photographs, beside what is known of them.

    python fitting/wood_accuracy.py DATA

DATA holds folders of photographs. Known are the direction of the grain, judged by eye from the photographs and written
down here, how many rings there are across some of them, the pith of one, and where planks meet; other folders hold
pictures that are no wood.
"""

import argparse
import os
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from tables import make_table

from jaxtex.cli.progress import progress
from jaxtex.fitting.floor import fit_floor
from jaxtex.fitting.wood import WoodFit, fit_wood
from jaxtex.io.images import read_image


class Board(NamedTuple):
    """``across``: degrees, 0 for upright grain; None on end grain. ``rings`` across the picture, or from the pith to
    the bark. ``pith``: shares of the width and the height."""

    across: float | None
    rings: int | None = None
    pith: tuple[float, float] | None = None


BOARDS = {
    "wood/texture_wood_godot.png": Board(90, rings=9),
    "wood/wood_1_mw.png": Board(0, rings=35),
    "wood/wood2_cathedral.png": Board(90),
    "wood/green_wood_cathedral.png": Board(90),
    "wood/wood_color_mx.jpg": Board(90),
    "wood/tree_cut_endgrain.jpg": Board(None, rings=25, pith=(0.45, 0.51)),
    "solids/mokume_CN03_A.png": Board(0),
    "solids/mokume_CN03_B.png": Board(None, rings=9),
    "solids/mokume_CN03_C.png": Board(15, rings=9),
    "solids/mokume_CN03_D.png": Board(None, rings=9),
    "solids/mokume_CN03_E.png": Board(165, rings=9),
    "solids/mokume_CN03_F.png": Board(0),
}
# Where planks meet, in per cent across them, and whether more joints than these are right.
FLOORS = {
    "wood/planks003.jpg": ((14.5, 28, 42, 54, 69, 88), False),
    "wood/woodfloor043.jpg": ((25, 51, 75), True),
    "wood/parquet_3x3.jpg": ((33.5, 67), False),
    "wood/fence_lo.jpg": (tuple(14.3 * n for n in range(1, 7)), False),
}


def describe_board(name: str, board: Board, fit: WoodFit) -> list[str]:
    """A line of the table of boards."""
    wood = fit.wood
    height, width = fit.mask.shape
    across = np.degrees(float(wood.rotation))
    turned = "" if board.across is None else f"{abs((across - board.across + 90) % 180 - 90):.1f}"
    # From the pith to the bark where there is a pith: as far as the nearest border.
    reach = (
        min(height, width) / 2
        if board.pith
        else abs(np.cos(wood.rotation)) * width + abs(np.sin(wood.rotation)) * height
    )
    counted = float(reach) / float(wood.ring_spacing)
    pith = ""
    if board.pith is not None:
        at = float(wood.center[0]) + width / 2, float(wood.center[1]) + height / 2
        pith = f"{100 * np.hypot(at[0] / width - board.pith[0], (at[1] / height - board.pith[1]) * height / width):.1f}"
    rings = "" if board.rings is None else f"{counted:.1f} ({board.rings})"
    told = ", ".join(name for name, known in fit.determined.items() if not known)
    return [
        name,
        "yes" if fit.ok else f"no: {fit.reason}",
        turned,
        rings,
        pith,
        *(f"{each:.2f}" for each in fit.iou),
        told,
    ]


def describe_floor(name: str, joints: tuple[float, ...], more: bool, data: Path) -> list[str]:
    """A line of the table of floors."""
    pixels = read_image(data / name).pixels
    fit = fit_floor(pixels)
    height, width = pixels.shape[:2]
    span = abs(np.cos(fit.turn)) * width + abs(np.sin(fit.turn)) * height
    # Counted along (cos, sin); the picture's own sense is from left to right, or from the top.
    places = np.sort(100 * (fit.joints / span * np.sign(np.cos(fit.turn) + np.sin(fit.turn)) + 0.5))
    worst = max(float(np.abs(places - joint).min()) for joint in joints) if len(places) else np.inf
    extra = "" if more else str(len(places) - len(joints))
    return [name, "yes" if fit.ok else f"no: {fit.reason}", f"{worst:.2f}", extra, f"{len(fit.planks)}"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    args = parser.parse_args()
    boards = [
        describe_board(name, board, fit_wood(read_image(args.data / name).pixels))
        for name, board in progress(list(BOARDS.items()), "boards", total=len(BOARDS))
    ]
    head = ["board", "ok", "axis off °", "rings (known)", "pith off %", "IoU rigid", "IoU displaced", "not told"]
    print(make_table(head, boards), end="\n\n")
    floors = [
        describe_floor(name, joints, more, args.data)
        for name, (joints, more) in progress(list(FLOORS.items()), "floors", total=len(FLOORS))
    ]
    print(make_table(["floor", "ok", "worst joint %", "joints too many", "planks"], floors), end="\n\n")
    others = sorted(path for folder in ("tilings", "natural") for path in (args.data / folder).glob("*.[jp][pn]g"))
    taken = []
    for path in progress(others, "not wood", total=len(others)):
        fit = fit_wood(read_image(path).pixels)
        taken += [path.name] if fit.ok else []
    print(f"of {len(others)} pictures that are no wood, {len(others) - len(taken)} refused; taken: {taken or 'none'}")


if __name__ == "__main__":
    main()
