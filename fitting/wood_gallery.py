"""Side by side for every photograph of wood: itself, its rings, the fitted model, a carved ball.

python fitting/wood_gallery.py PHOTO ... -o gallery.png
"""

import argparse
import os
from pathlib import Path

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from numpy.typing import NDArray
from skimage.transform import resize

from jaxtex.cli.progress import progress
from jaxtex.fitting.wood import WoodFit, fit_wood
from jaxtex.io.images import read_image, write_image
from jaxtex.material.rings import draw_rings
from jaxtex.material.wood import render_points, render_wood
from jaxtex.models.wood_files import wood_from_parameters, wood_parameters

SIDE = 320


def draw_row(photo: NDArray[np.float32], fit: WoodFit) -> NDArray[np.float32]:
    """The pictures of one photograph, in linear light."""
    height, width = fit.mask.shape
    shown = np.repeat(photo, 3, axis=2) if photo.shape[2] == 1 else photo
    wood = wood_from_parameters(wood_parameters(fit.wood), seed=0)
    model = np.concatenate([band.base_colour for band in render_wood(wood, across=width, size=(width, height))])
    rings = draw_rings(photo, fit.rings, clear=fit.clear)
    ball = carve_ball(wood, (width, height))
    pictures = [shown, rings, model, ball]
    return np.concatenate([resize(each.astype(np.float32), (SIDE, SIDE)) for each in pictures], axis=1)


def carve_ball(wood, image: tuple[int, int]) -> NDArray[np.float32]:
    """A ball of the wood, as large as the photograph, under a lamp."""
    radius = 0.48 * min(image)
    y, x = (np.indices((SIDE, SIDE)) + 0.5 - SIDE / 2) * (min(image) / SIDE)
    depth = np.sqrt(np.maximum(radius**2 - x**2 - y**2, 0))
    # Towards the viewer is out of the plank's face.
    points = np.stack([x, y, -depth], axis=-1)
    colour = render_points(wood, points.reshape(-1, 3)).reshape(SIDE, SIDE, 3)
    light = np.clip((points / radius) @ (np.array([-0.5, -0.6, -0.62])), 0, 1)
    return np.where((depth > 0)[..., None], colour * (0.15 + 1.1 * light[..., None]), 0.9).astype(np.float32)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("photos", type=Path, nargs="+")
    parser.add_argument("-o", "--output", type=Path, required=True)
    args = parser.parse_args()
    rows = []
    for path in progress(args.photos, "fitting", total=len(args.photos)):
        pixels = read_image(path).pixels
        rows.append(draw_row(pixels, fit_wood(pixels)))
    write_image(args.output, np.clip(np.concatenate(rows), 0, 1))


if __name__ == "__main__":
    main()
