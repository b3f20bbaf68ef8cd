"""Which tiles of a photograph may stand for the others: none with highlights, shadows, dirt or clipped light."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from jaxtex.material.cells import Cell

_FAR = 4.0  # robust standard deviations from the median of all tiles: what lies farther is an artefact
_SMALLEST = 0.02  # sRGB-encoded: differences below can hardly be seen, however equal the tiles otherwise are
_CLIPPED = 0.004, 0.996  # sRGB-encoded: beyond, the camera saw nothing


def choose_clean(cells: Sequence[Cell], masks: Sequence[npt.NDArray[np.float32]]) -> npt.NDArray[np.int_]:
    """Choose the tiles whose interiors can be trusted (Lefebvre & Poulin 2000, section 2.4: "avoid unsatisfactory
    regions with artifacts such as occlusions, highlights, shadows").

    A tile is left out where it is far from the others in one of these: how much its brightest places exceed it
    (highlights), its darkest fall below it (holes, shadows), its lightness changes from one side to the other (shadow
    borders, lamps), the mask calls it joint (dirt, things in front of it), or light is clipped. Far is four robust
    standard deviations from the median of all tiles, so that what all tiles have is no artefact. How light or dark a
    tile is as a whole does not count: such tiles there are.

    Args:
        cells: tiles, sRGB-encoded.
        masks: of each cell, [row, col]: 1 = tile, 0 = joint.

    Returns:
        Numbers of the clean ones; never less than a quarter of all, the least odd ones.
    """
    oddness = np.array([_measure(cell, mask) for cell, mask in zip(cells, masks, strict=True)])
    middle = np.median(oddness, axis=0)
    spread = 1.4826 * np.median(np.abs(oddness - middle), axis=0)
    worst = ((oddness - middle) / np.maximum(spread, _SMALLEST / _FAR)).max(axis=1)
    fewest = -(-len(cells) // 4)
    return np.flatnonzero(worst <= max(_FAR, np.sort(worst)[fewest - 1]))


def _measure(cell: Cell, mask: npt.NDArray[np.float32]) -> tuple[float, ...]:
    """Of a tile: highlights, holes, change of lightness from side to side, dirt, clipped light."""
    rows, columns = (cell.top > 0) & (cell.bottom > 0), (cell.left > 0) & (cell.right > 0)
    face = cell.values[rows][:, columns]
    light = face.mean(axis=2)
    low, middle, high = np.quantile(light, [0.02, 0.5, 0.98])
    across, down = _slope(light.mean(axis=0)), _slope(light.mean(axis=1))
    dirt = float(np.mean(mask[rows][:, columns] < 0.5))
    clipped = float(np.mean((face < _CLIPPED[0]) | (face > _CLIPPED[1])))
    return high - middle, middle - low, np.hypot(across, down), dirt, clipped


def _slope(profile: npt.NDArray[np.floating]) -> float:
    """Change from one end to the other of the straight line through a profile."""
    place = np.linspace(-0.5, 0.5, len(profile))
    return float(place @ profile / max(float(place @ place), 1e-12))
