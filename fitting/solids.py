"""Solid textures from views: figures, how soon they are like their views, and a cut beside that of a real block.

    python fitting/solids.py FOLDER -o OUT --meshes MESHES

FOLDER holds the faces of a wooden cube (mokume_CN03_A.png to _F.png, and _cut2.png, an oblique cut through it) and
pictures of stone (granite_meta.png, marble006_dark.jpg, onyx003.jpg); gravel is scikit-image's. For each method,
OUT/blocks.png shows views and blocks, as figure 1 of Dischler, Ghazanfarpour and Freydier (Eurographics 1998) does;
OUT/turned.png blocks of one view turned, as figure 5; OUT/mixtures.png blocks whose views are of different materials;
OUT/hues.png blocks of three channels and of one; OUT/cut.png the cut of the cube, of blocks, of the wood model of
its faces, and a face. OUT/solids.md and OUT/convergence.png have the figures: for each iteration of relaxation,
the share of frequencies in the views' range and the distance from the views' histograms, and textures' distances from
the cut and from views. With MESHES, a folder of meshes, OUT/scene.png is that of fitting/solid_scene.py, as figure 7.
"""

import argparse
import io
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple, get_args

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

import jax
import matplotlib.pyplot as plt
import numpy as np
from skimage import data
from tables import make_table

import jaxtex as jt
from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
from jaxtex.io.files import atomic_write_bytes, atomic_write_text, prepare_folder
from jaxtex.material.wood import render_points
from jaxtex.synthesis.portilla_simoncelli import portilla_simoncelli_distance
from jaxtex.synthesis.slices import SliceStatistics
from jaxtex.synthesis.solid_optimisation import optimise_steps
from jaxtex.synthesis.solid_relaxation import measure_axis, relax_steps
from jaxtex.synthesis.solid_views import AXES, CROPS, ColourModel, align_views, analyse_views

SIDE = 128
KEY = jax.random.key(0)

Views = dict[str, np.ndarray]

METHODS: dict[str, Callable[..., np.ndarray]] = {"optimisation": jt.optimise_solid, "relaxation": jt.relax_solid}
"""Each makes encoded voxels [z, y, x, channel] of (views, side, key=key)."""

# The cube was cut along x = 0.575 (z + 0.5) - 0.375.
PLANE = {"origin": (0.7 * 256, 0, 256), "across": (-0.575, 0, -1), "down": (0, 1, 0), "size": (256, 256)}

SHIFTS = range(0, SIDE, 16)  # along x, in voxels: of parallel cuts, as a single one may miss what blocks hold

INSIDE, APART = 87, 1  # per cent: what blocks are asked for


class Progress(NamedTuple):
    """The share of frequencies in the views' range, and how far histograms are apart."""

    inside: float
    apart: float


def read_views(folder: Path) -> dict[str, Views]:
    """What blocks are made of. On the cube, x of voxels runs right along face A, y down, and z towards it."""
    stones = [
        linear_to_srgb(jt.read_image(folder / name).pixels)
        for name in ("granite_meta.png", "marble006_dark.jpg", "onyx003.jpg")
    ]
    flat, end, left = (linear_to_srgb(jt.read_image(folder / f"mokume_CN03_{face}.png").pixels) for face in "ABC")
    side = left.swapaxes(0, 1)
    return {
        "granite": dict.fromkeys(AXES, stones[0]),
        "marble": dict.fromkeys(AXES, stones[1]),
        "onyx": dict.fromkeys(AXES, stones[2]),
        "gravel": dict.fromkeys(AXES, np.repeat(data.gravel()[..., None] / 255, 3, axis=2)),
        "wood, two views": {"xy": flat, "yz": side},
        "wood, three views": {"xy": flat, "xz": end, "yz": side},
    }


def trace_relaxation(views: Views) -> list[Progress]:
    """How much the slices are like their views after each iteration: the least of all axes and channels."""
    pictures = align_views(views, SIDE).pictures
    learnt = analyse_views(pictures, SIDE, key=jax.random.fold_in(KEY, 0))
    return [measure(step.voxels, learnt) for step in relax_steps(pictures, SIDE, key=KEY)]


def measure_optimised(views: Views) -> Progress:
    """The same of the last step of optimisation."""
    pictures = align_views(views, SIDE).pictures
    learnt = analyse_views(pictures, SIDE, key=jax.random.fold_in(KEY, 0))
    *_, last = optimise_steps(pictures, SIDE, key=KEY)
    return measure(last.voxels, learnt)


def measure(voxels: jax.Array, learnt: dict[str, SliceStatistics]) -> Progress:
    measured = [measure_axis(voxels, each, AXES[axis]) for axis, each in learnt.items()]
    spans = np.array([np.ptp(each.edges, axis=1) for each in learnt.values()])
    varying = spans > 1e-3 * spans.max()  # the colours of grey pictures are nothing but rounding
    inside, apart = (np.array(each)[varying] for each in zip(*measured, strict=True))
    return Progress(float(inside.min()), float(apart.max()))


def plot_convergence(path: Path, traces: dict[str, list[Progress]]) -> None:
    """Both measures against iterations, with what is asked of them."""
    figure, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    for name, trace in traces.items():
        iterations = range(1, len(trace) + 1)
        axes[0].plot(iterations, [100 * step.inside for step in trace], marker="o", markersize=3, label=name)
        axes[1].plot(iterations, [100 * step.apart for step in trace], marker="o", markersize=3, label=name)
    axes[0].axhline(INSIDE, color="black", linestyle="--", linewidth=1)
    axes[0].set(xlabel="iterations", ylabel="frequencies in the views' range, %", ylim=(None, 100))
    axes[1].axhline(APART, color="black", linestyle="--", linewidth=1)
    axes[1].set(xlabel="iterations", ylabel="histograms apart, % of the range", yscale="log")
    axes[0].legend(frameon=False)
    picture = io.BytesIO()
    figure.savefig(picture, dpi=120, format="png")
    plt.close(figure)
    atomic_write_bytes(path, picture.getvalue())


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


def draw_blocks(views: Views, blocks: list[np.ndarray]) -> np.ndarray:
    """A row: what was given, up to three pictures, and what was made of it."""
    given = [views[name] for name in AXES if name in views]
    shown = given[:1] if all(each is given[0] for each in given) else given
    blank = [np.ones((1, 1, 3))] * (3 - len(shown))
    return side_by_side([*[srgb_to_linear(each) for each in shown], *blank, *map(show_block, blocks)])


def make_all(materials: dict[str, Views]) -> list[list[np.ndarray]]:
    """For each of the views, the block of each method."""
    return [[make(views, SIDE, key=KEY) for make in METHODS.values()] for views in materials.values()]


def write_rows(path: Path, materials: dict[str, Views], blocks: list[list[np.ndarray]]) -> None:
    rows = [draw_blocks(views, made) for views, made in zip(materials.values(), blocks, strict=True)]
    jt.write_image(path, np.concatenate(rows))


def turn_views(views: Views) -> dict[str, Views]:
    """Figure 5: the same pictures, one of them turned."""
    flat, side = views["xy"], views["yz"]
    return {"as it is": {"xy": flat, "yz": side}, "turned": {"xy": flat.swapaxes(0, 1), "xz": side}}


def mix_views(materials: dict[str, Views]) -> dict[str, Views]:
    """Section 5: views of different materials for different directions."""
    granite, marble, wood = (materials[name]["xy"] for name in ("granite", "marble", "wood, two views"))
    return {
        "granite and wood": {"xy": granite, "yz": wood.swapaxes(0, 1)},
        "granite, marble and wood": {"xy": wood, "xz": granite, "yz": marble},
    }


def compare_hues(path: Path, materials: dict[str, Views]) -> list[list[str]]:
    """Section 4.1: three independent channels, or one that tells the colour. Beside them, how far the middle slice
    across z is from its view."""
    blocks, lines = [], []
    for name, views in materials.items():
        made = [jt.relax_solid(views, SIDE, key=KEY, colours=each) for each in get_args(ColourModel)]
        apart = [jt.sliced_wasserstein(views["xy"], block[SIDE // 2], key=KEY).total for block in made]
        blocks.append(made)
        lines.append([name, *(f"{each:.3f}" for each in apart)])
    write_rows(path, materials, blocks)
    return lines


def compare_slices(materials: dict[str, Views], blocks: list[list[np.ndarray]]) -> list[list[str]]:
    """How far slices are from their views, by patches and by statistics: means of three across each axis."""
    lines = []
    for (name, views), made in zip(materials.items(), blocks, strict=True):
        for method, voxels in zip(METHODS, made, strict=True):
            pairs = [
                (view, np.take(voxels, SIDE * third // 6, axis=AXES[axis]))
                for axis, view in views.items()
                for third in (1, 3, 5)
            ]
            patches = np.mean([jt.sliced_wasserstein(*pair, key=KEY).total for pair in pairs])
            statistics = np.mean([portilla_simoncelli_distance(*pair).total for pair in pairs])
            lines.append([name, method, f"{patches:.3f}", f"{statistics:.3f}"])
    return lines


def fit_cube(source: Path) -> jt.Wood:
    """The wood model of the cube: end grain (face B) tells where the middle of the rings is, face C, held to that, the
    rest. The depth below C, and C's columns, are B's columns and rows."""
    end, side = (jt.read_image(source / f"mokume_CN03_{face}.png").pixels for face in "BC")
    across, along = (float(each) for each in jt.fit_wood(end).wood.center)
    return jt.fit_wood(side, fix={"xc": along, "yc": across + side.shape[0] / 2}).wood


def cut_model(wood: jt.Wood) -> np.ndarray:
    """The model in the plane of the cut, encoded."""
    (width, height), half = PLANE["size"], 128.0
    rows, columns = np.mgrid[:height, :width] + 0.5
    x, y, z = (
        start + columns * across + rows * down
        for start, across, down in zip(PLANE["origin"], PLANE["across"], PLANE["down"], strict=True)
    )
    below_face = np.stack([z - half, y - half, x], axis=-1).reshape(-1, 3)
    return linear_to_srgb(render_points(wood, below_face).reshape(height, width, 3))


def compare_cuts(source: Path, folder: Path, made: dict[str, list[np.ndarray]]) -> list[list[str]]:
    """Mean distances of cuts from the real one. The cube was photographed lying on its side, as its fibres show.
    Upright, the cut is like face E: columns go against z, rows down."""
    lying, face = (linear_to_srgb(jt.read_image(source / f"mokume_CN03_{name}.png").pixels) for name in ("cut2", "E"))
    truth = np.rot90(lying)
    pieces = [face[row : row + SIDE, column : column + SIDE] for row in (0, SIDE) for column in (0, SIDE)]
    made = made | {
        "face E as it is": [face],
        "a piece of face E, repeated": [np.tile(piece, (2, 2, 1)) for piece in pieces],
    }
    shown = [
        np.pad(srgb_to_linear(each), ((0, 0), (0, 8), (0, 0)), constant_values=1)
        for each in (truth, *(cuts[0] for cuts in made.values()))
    ]
    jt.write_image(folder / "cut.png", np.concatenate(shown, axis=1))
    return [
        [
            name,
            f"{np.mean([jt.sliced_wasserstein(truth, each, key=KEY).total for each in cuts]):.3f}",
            f"{np.mean([portilla_simoncelli_distance(truth, each).total for each in cuts]):.3f}",
        ]
        for name, cuts in made.items()
    ]


def cut_blocks(materials: dict[str, Views], blocks: list[list[np.ndarray]]) -> dict[str, list[np.ndarray]]:
    """Parallel cuts through all blocks of wood, encoded."""
    cuts = {}
    for name, made in zip(materials, blocks, strict=True):
        for method, voxels in zip(METHODS, made, strict=True):
            if "wood" in name:
                solid = jt.make_solid(srgb_to_linear(voxels))
                planes = [PLANE | {"origin": (PLANE["origin"][0] + shift, *PLANE["origin"][1:])} for shift in SHIFTS]
                cuts[f"block of {name}, {method}"] = [
                    linear_to_srgb(np.asarray(jt.cut_solid(solid, **plane))) for plane in planes
                ]
    return cuts


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="pictures of solids")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT", help="folder for what is made")
    parser.add_argument("--meshes", type=Path, metavar="MESHES", help="folder of meshes that are carved of the blocks")
    options = parser.parse_args(words)
    out = options.output
    prepare_folder(out)
    materials = read_views(options.folder)
    traces = {name: trace_relaxation(views) for name, views in materials.items()}
    plot_convergence(out / "convergence.png", traces)
    blocks = make_all(materials)
    write_rows(out / "blocks.png", materials, blocks)
    for name, others in (("turned", turn_views(materials["wood, two views"])), ("mixtures", mix_views(materials))):
        write_rows(out / f"{name}.png", others, make_all(others))
    model = {"wood model fitted to faces B and C": [cut_model(fit_cube(options.folder))]}
    cuts = compare_cuts(options.folder, out, cut_blocks(materials, blocks) | model)
    hues = compare_hues(out / "hues.png", materials)
    convergence = [
        [name, str(number), f"{100 * step.inside:.1f} %", f"{100 * step.apart:.2f} %"]
        for name, trace in traces.items()
        for number, step in enumerate(trace, 1)
    ]
    for name, views in materials.items():
        end = measure_optimised(views)
        convergence.append([name, "optimised", f"{100 * end.inside:.1f} %", f"{100 * end.apart:.2f} %"])
    head = ["block", "iterations", "in range, least of axes and channels", "histograms apart, most"]
    page = [
        f"Of a crop that is held out, {100 - 200 / CROPS:.0f} % of the frequencies are in the range of the others.\n",
        make_table(head, convergence),
        "\n![convergence](convergence.png)\n\nDistances from the real cut:\n",
        make_table(["cut", "patches", "statistics"], cuts),
        "\nDistances of slices from their views:\n",
        make_table(["block", "method", "patches", "statistics"], compare_slices(materials, blocks)),
        "\nPatches of a slice from those of its view:\n",
        make_table(["block", *get_args(ColourModel)], hues),
        "",
    ]
    atomic_write_text(out / "solids.md", "\n".join(page))
    print("\n".join(page))
    if options.meshes is not None:
        from solid_scene import main as draw_scene  # it takes its materials from here

        draw_scene([str(options.folder), "--meshes", str(options.meshes), "-o", str(out / "scene.png")])


if __name__ == "__main__":
    main()
