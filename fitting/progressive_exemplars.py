"""What `progressive.py` draws its figures from: photographs, grown coats, and their texton masks."""

from functools import cache
from pathlib import Path

import jax
import numpy as np
import numpy.typing as npt
from reaction_diffusion import grow_leopard, grow_tiger

import jaxtex as jt
from jaxtex.core.colour import linear_to_srgb

SIDE = 256  # pixels of an exemplar that are used
KEY = jax.random.key(0)

Floats = npt.NDArray[np.floating]
Labels = npt.NDArray[np.uint8]


def read_picture(folder: Path, name: str) -> Floats:
    """A photograph's corner, encoded, of three channels."""
    pixels = jt.read_image(folder / name).pixels[:SIDE, :SIDE]
    return np.broadcast_to(linear_to_srgb(pixels), (*pixels.shape[:2], 3))


@cache
def read_exemplar(folder: Path, name: str) -> tuple[Floats, Labels]:
    """A photograph's corner or a coat, encoded, of three channels; and its texton mask."""
    if name in ("leopard", "tiger"):
        coat = grow_leopard(KEY) if name == "leopard" else grow_tiger(KEY)
        return linear_to_srgb(coat.pixels), coat.mask
    return read_picture(folder, name), jt.propose_texton_mask(jt.read_image(folder / name).pixels[:SIDE, :SIDE])


def draw_mask(mask: npt.NDArray) -> Floats:
    return np.repeat(mask[..., None] / max(1, mask.max()), 3, axis=2)
