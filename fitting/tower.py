"""Bricks around a tower: a fitted tiling laid over eight walls (Lefebvre & Poulin 2000, section 4.2 and figure 10).

Prints how far the joints of neighbouring walls are from meeting, and draws the tower from outside, whole and close up.

    python fitting/tower.py -o tower.png                       # the model as it was fitted
    python fitting/tower.py -o tower.png --bond running        # its bricks in running bond, as in the paper's figure
"""

import argparse
import os
from pathlib import Path

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

import jax
import numpy as np
from numpy.typing import NDArray
from raster import Floats, View, average_samples, rasterise
from scipy import ndimage
from tables import make_table

import jaxtex as jt
from jaxtex.io.meshes import TexturedMesh
from jaxtex.material.adjacent import Layout, lay_tiling, polygon_mesh
from jaxtex.material.mismatch import measure_mismatch
from jaxtex.models.bonds import bond_pattern
from jaxtex.models.files import need_tiling
from jaxtex.models.tiling import make_tiling

MODEL = Path(__file__).parents[1] / "models" / "brick-skimage.json"
BONDS = ("running", "stack", "english", "flemish")
SIDES, RADIUS, HEIGHT = 8, 1.6, 4.0  # metres, to the edges
ROWS = 12  # courses of the sheet, at least
LAMP = np.array([0.75, 0.55, 0.36])  # towards it
SKY, EXPOSURE = 0.25, 1.5
SUPERSAMPLING = 3
LEAST_PIXELS = 5  # to the height of a tile

VIEWS = (
    View(np.array([2.6, 1.9, 7.6]), np.array([0.0, 2.0, 0.0]), 2.8),
    View(np.array([1.9, 2.3, 4.2]), np.array([0.55, 1.9, 1.4]), 4.6),
)


def build_tower(sides: int = SIDES) -> list[Floats]:
    """The walls of a tower, quads with y upwards, counter-clockwise as seen from above."""
    angle = 2 * np.pi * (np.arange(sides + 1) + 0.5) / sides
    x, z = RADIUS * np.sin(angle), RADIUS * np.cos(angle)
    return [
        np.array([(x[k], 0, z[k]), (x[k + 1], 0, z[k + 1]), (x[k + 1], HEIGHT, z[k + 1]), (x[k], HEIGHT, z[k])])
        for k in range(sides)
    ]


def lay_bricks(file: jt.TilingFile, bond: str | None, tiles: float) -> tuple[Layout, jt.Appearance]:
    """The tower's walls with a model's bricks, in its own bond or another."""
    tiling = need_tiling(file).tiling
    if bond is not None:
        lengths = ("tile_width", "tile_height", "mortar_x", "mortar_y", "corner_radius")
        tiling = make_tiling(**{name: getattr(tiling, name) for name in lengths}, **bond_pattern(bond))
    appearance = jt.appearance_of(file)
    layout = lay_tiling(build_tower(), tiling, tiles=tiles, rows=ROWS, pattern=appearance.pattern)
    return layout, appearance


def describe(layout: Layout) -> str:
    """A table of the shared edges, and the worst of all."""
    measured = measure_mismatch(layout)
    rows = [
        [f"{edge.first}, {edge.second}", kind, f"{bed:.1e}", f"{head:.1e}"]
        for (edge, kind), bed, head in zip(layout.meetings, *measured, strict=True)
    ]
    stretch = 100 * (layout.stretch - 1)
    return "\n".join(
        [
            make_table(("walls", "edge", "courses off, courses", "joints off, tiles"), rows),
            "",
            f"corners: {layout.turn.style}; tiles of {1000 * layout.tile_length:.0f} mm, stretched by "
            f"{stretch.min():.2f} to {stretch.max():.2f} %",
            f"largest mismatch: {measured.worst:.1e} tile",
        ]
    )


def draw_tower(layout: Layout, appearance: jt.Appearance, view: View, *, size: tuple[int, int]) -> NDArray[np.float32]:
    """The tower in perspective under a lamp, linear light; `size` is width and height."""
    width, height = size
    fine = SUPERSAMPLING * width, SUPERSAMPLING * height
    # A pixel of the maps is about one of the picture where it is nearest.
    near = np.linalg.norm(view.target - view.eye)
    maps = render_sheet(layout, appearance, tile_pixels=0.5 * view.lens * fine[1] * layout.tile_length / near)
    mesh = polygon_mesh(layout)
    seen = rasterise(mesh.vertices, mesh.faces, view, fine)
    picture = np.ones((*seen.face.shape, 3))
    for number, face in enumerate(mesh.faces):
        here = seen.face == number
        picture[here] = shade(seen.share[here] @ mesh.uv[face], mesh, face, maps)
    return average_samples(picture, SUPERSAMPLING)


def render_sheet(layout: Layout, appearance: jt.Appearance, *, tile_pixels: float) -> jt.Maps:
    """The maps that all walls repeat, with so many pixels to the length of a tile, if that shows its height too."""
    scale = max(tile_pixels / layout.turn.pitch, LEAST_PIXELS / float(layout.sheet.tiling.tile_height))
    size = round(scale * layout.sheet.width), round(scale * layout.sheet.height)
    bands = jt.render_maps(layout.sheet, appearance, size=size, key=jax.random.key(0))
    return jt.Maps(*map(np.concatenate, zip(*bands, strict=True)))


def shade(uv: Floats, mesh: TexturedMesh, face: NDArray[np.int64], maps: jt.Maps) -> Floats:
    """Light from a wall at texture coordinates: Lambert's law, with the sheet's normals on the wall."""
    rows, columns = maps.height.shape
    places = [(1 - uv[:, 1]) * rows - 0.5, uv[:, 0] * columns - 0.5]

    def look_up(picture: NDArray[np.float32]) -> Floats:
        channels = np.moveaxis(picture, -1, 0)
        return np.stack([ndimage.map_coordinates(one, places, order=1, mode="grid-wrap") for one in channels], axis=-1)

    colour, normal = look_up(maps.base_colour), look_up(maps.normal)
    grow = np.linalg.solve(np.diff(mesh.uv[face], axis=0), np.diff(mesh.vertices[face], axis=0))  # where u and v grow
    axes = np.stack([*(grow / np.linalg.norm(grow, axis=1, keepdims=True)), mesh.normals[face[0]]])
    lit = np.clip(normal @ axes @ (LAMP / np.linalg.norm(LAMP)), 0, None)
    return EXPOSURE * colour * (lit + SKY)[:, None]


def main() -> None:
    """Lay, measure, draw."""
    parser = argparse.ArgumentParser(description="Lay a fitted tiling around a tower of eight walls.")
    parser.add_argument("model", type=Path, nargs="?", default=MODEL, help="model file of a tiling (default: bricks)")
    parser.add_argument("-o", "--output", type=Path, required=True, help="the picture to write")
    parser.add_argument("--bond", choices=BONDS, help="lay the model's tiles in this bond (default: its own)")
    parser.add_argument("--tiles", type=float, default=6, help="tiles in a row along one wall (default: 6)")
    parser.add_argument("--size", type=int, nargs=2, default=(600, 900), help="of each view, in pixels")
    chosen = parser.parse_args()
    layout, appearance = lay_bricks(jt.load_model(chosen.model), chosen.bond, chosen.tiles)
    print(describe(layout))
    views = [draw_tower(layout, appearance, view, size=tuple(chosen.size)) for view in VIEWS]
    jt.write_image(chosen.output, np.hstack(views))


if __name__ == "__main__":
    main()
