"""Solid textures from views: figures, how soon they are like their views, and a cut beside that of a real block.

    python fitting/solids.py FOLDER -o OUT

FOLDER holds the faces of a wooden cube (mokume_CN03_A.png to _F.png, and _cut2.png, an oblique cut through it) and
pictures of stone (granite_meta.png, marble006_dark.jpg). OUT/blocks.png shows views and blocks, as figure 1 of
Dischler, Ghazanfarpour and Freydier (Eurographics 1998) does; OUT/turned.png blocks of one view turned, as figure 5;
OUT/cut.png the cube's cut beside that of a block. OUT/solids.md has the figures: for each iteration and axis, the share
of frequencies in the views' range and the distance from the views' histograms, and textures' distances from the cut.
"""

import argparse
import os
from pathlib import Path

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

import jax
import numpy as np
from tables import make_table

import jaxtex as jt
from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
from jaxtex.io.files import atomic_write_text, prepare_folder
from jaxtex.synthesis.portilla_simoncelli import portilla_simoncelli_distance
from jaxtex.synthesis.solid_relaxation import measure_axis, relax_steps
from jaxtex.synthesis.solid_views import AXES, CROPS, analyse_views

SIDE = 128
KEY = jax.random.key(0)

Views = dict[str, np.ndarray]


def read_views(folder: Path) -> dict[str, Views]:
    """What blocks are made of. On the cube, x of voxels runs right along face A, y down, and z towards it."""
    stones = [
        linear_to_srgb(jt.read_image(folder / name).pixels) for name in ("granite_meta.png", "marble006_dark.jpg")
    ]
    flat, end, left = (linear_to_srgb(jt.read_image(folder / f"mokume_CN03_{face}.png").pixels) for face in "ABC")
    side = left.swapaxes(0, 1)
    return {
        "granite": dict.fromkeys(AXES, stones[0]),
        "marble": dict.fromkeys(AXES, stones[1]),
        "wood, two views": {"xy": flat, "yz": side},
        "wood, three views": {"xy": flat, "xz": end, "yz": side},
    }


def synthesise(views: Views, name: str, lines: list[list[str]]) -> np.ndarray:
    """Encoded voxels [z, y, x, channel]; adds what is measured after each iteration to the table."""
    learnt = analyse_views(views, SIDE, key=jax.random.fold_in(KEY, 0))
    for step in relax_steps(learnt, key=jax.random.fold_in(KEY, 1)):
        inside, apart = [], []
        for axis, statistics in learnt.statistics.items():
            here = measure_axis(step.voxels, statistics, AXES[axis])
            inside.append(float(here[0].min()))
            apart.append(float(here[1].max()))
        lines.append([name, str(step.done), f"{100 * min(inside):.1f} %", f"{100 * max(apart):.2f} %"])
    return learnt.to_voxels(step.voxels)


def show_block(voxels: np.ndarray) -> np.ndarray:
    return np.asarray(jt.draw_block(jt.make_solid(srgb_to_linear(voxels)), size=(384, 384)))


def side_by_side(pictures: list[np.ndarray]) -> np.ndarray:
    """Linear pictures in a row on white, cut to 384 pixels."""
    cells = []
    for picture in pictures:
        cell = np.ones((384, 384, 3), np.float32)
        rows, columns = (min(384, each) for each in picture.shape[:2])
        cell[:rows, :columns] = picture[:rows, :columns]
        cells.append(cell)
    return np.concatenate(cells, axis=1)


def write_turned(folder: Path, views: Views) -> None:
    """Figure 5: the same pictures, one of them turned."""
    flat, side = views["xy"], views["yz"]
    turned = {"xy": flat.swapaxes(0, 1), "xz": side}
    blocks = [jt.synthesise_solid(each, SIDE, key=KEY) for each in ({"xy": flat, "yz": side}, turned)]
    jt.write_image(folder / "turned.png", side_by_side([show_block(each) for each in blocks]))


def compare_cuts(source: Path, folder: Path, blocks: dict[str, np.ndarray]) -> list[list[str]]:
    """The cube was cut along x = 0.575 (z + 0.5) - 0.375 and photographed lying on its side, as its fibres show.
    Upright, the cut is like face E: columns go against z, rows down."""
    lying, face = (linear_to_srgb(jt.read_image(source / f"mokume_CN03_{name}.png").pixels) for name in ("cut2", "E"))
    truth = np.rot90(lying)
    plane = {"origin": (0.7 * 256, 0, 256), "across": (-0.575, 0, -1), "down": (0, 1, 0), "size": (256, 256)}
    made = {}
    for name, voxels in blocks.items():
        cut = jt.cut_solid(jt.make_solid(srgb_to_linear(voxels)), **plane)
        made[f"block of {name}"] = linear_to_srgb(np.asarray(cut))
    made |= {"face E as it is": face, "a piece of face E, repeated": np.tile(face[:SIDE, :SIDE], (2, 2, 1))}
    shown = [srgb_to_linear(each) for each in (truth, *made.values())]
    jt.write_image(folder / "cut.png", side_by_side(shown))
    return [
        [
            name,
            f"{jt.sliced_wasserstein(truth, each, key=KEY).total:.3f}",
            f"{portilla_simoncelli_distance(truth, each).total:.3f}",
        ]
        for name, each in made.items()
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="pictures of solids")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT", help="folder for what is made")
    options = parser.parse_args()
    prepare_folder(options.output)
    convergence: list[list[str]] = []
    rows, blocks = [], {}
    for name, views in read_views(options.folder).items():
        blocks[name] = voxels = synthesise(views, name, convergence)
        seen = [srgb_to_linear(each) for each in ([*views.values()] if "wood" in name else [views["xy"]])]
        rows.append(side_by_side([*seen, *[np.ones((1, 1, 3))] * (3 - len(seen)), show_block(voxels)]))
    jt.write_image(options.output / "blocks.png", np.concatenate(rows))
    write_turned(options.output, read_views(options.folder)["wood, two views"])
    wood = {name: voxels for name, voxels in blocks.items() if "wood" in name}
    cuts = compare_cuts(options.folder, options.output, wood)
    head = ["block", "iterations", "in range, least of axes and channels", "histograms apart, most"]
    page = [
        f"Of a crop that is held out, {100 - 200 / CROPS:.0f} % of the frequencies are in the range of the others.\n",
        make_table(head, convergence),
        "\nDistances from the real cut:\n",
        make_table(["cut", "patches", "statistics"], cuts),
        "",
    ]
    atomic_write_text(options.output / "solids.md", "\n".join(page))
    print("\n".join(page))


if __name__ == "__main__":
    main()
