"""Where the pixels of maps lie in a picture, and what of the picture each of them sees.

A placement is a 3 x 3 matrix from a map's point (x, y, 1), in pixels from the maps' upper left corner, to a point of
the picture, in its pixels, times its depth. Depth is more than 0 in front of the camera.
"""

import numpy as np
import numpy.typing as npt
from scipy.ndimage import map_coordinates

from jaxtex.material.sheet import Sheet
from jaxtex.models.tiling import Tiling

Placement = npt.NDArray[np.float64]

_MOST = 32  # samples to a pixel's side


def over_photograph(sheet: Sheet, tiling: Tiling, *, image: tuple[int, int], size: tuple[int, int]) -> Placement:
    """Of a sheet's maps in the photograph that its tiling was fitted to.

    Args:
        sheet: of the tiling.
        tiling: as the photograph shows it: turned, and in perspective.
        image: (width, height) of the photograph.
        size: (width, height) of the maps.

    Examples:
        >>> from jaxtex.material.sheet import lay_sheet
        >>> from jaxtex.models.tiling import make_tiling
        >>> wall = make_tiling(tile_width=60, tile_height=20, origin=(7.0, 5.0))
        >>> over_photograph(lay_sheet(wall, tiles=(2, 3)), wall, image=(150, 80), size=(240, 120)) @ [2, 2, 1]
        array([8., 6., 1.])
    """
    c, s = np.cos(float(tiling.angle)), np.sin(float(tiling.angle))
    homography = np.asarray(tiling.homography, np.float64)
    x, y = np.asarray(tiling.origin, np.float64)
    to_lattice = _scale_and_shift((sheet.width / size[0], sheet.height / size[1]), sheet.corner)
    to_plane = np.array([[c, -s, x], [s, c, y], [0, 0, 1]])
    # Depth is known but for its sign: what the photograph shows lies in front of the camera.
    front = np.sign(homography[2] @ [0.5 * image[0], 0.5 * image[1], 1.0])
    placement: Placement = front * np.linalg.inv(homography) @ to_plane @ to_lattice
    return placement


def over_picture(image: tuple[int, int], *, size: tuple[int, int]) -> Placement:
    """Of maps over the whole of a picture, which is stretched.

    Args:
        image: (width, height) of the picture.
        size: (width, height) of the maps.
    """
    return _scale_and_shift((image[0] / size[0], image[1] / size[1]), (0.0, 0.0))


def over_plank(image: tuple[int, int], *, size: tuple[int, int]) -> Placement:
    """Of a plank's maps, as `render_wood` makes them as wide as the photograph: the middle is the photograph's.

    Args:
        image: (width, height) of the photograph.
        size: (width, height) of the maps.
    """
    scale = image[0] / size[0]
    return _scale_and_shift((scale, scale), (0.0, 0.5 * (image[1] - size[1] * scale)))


def look_at_picture(
    picture: npt.NDArray[np.float32], placement: Placement, *, rows: range, width: int, goes_on: bool = False
) -> npt.NDArray[np.float32]:
    """What some rows of maps see of a picture.

    Between the picture's pixels values are bilinear. Where a map's pixel covers several of them, it sees the mean of
    samples that lie a pixel apart at most (32 by 32 of them at most).

    Args:
        picture: [row, col, channel].
        placement: of the maps.
        rows: which of the maps' rows.
        width: of the maps.
        goes_on: whether the picture goes on, beyond its border, as it is there; else there is 0. Behind the camera
            there is 0 in any case.

    Returns:
        [row, col, channel].

    Examples:
        >>> picture = np.arange(4, dtype=np.float32).reshape(1, 4, 1)
        >>> look_at_picture(picture, over_picture((4, 1), size=(2, 1)), rows=range(1), width=2).ravel()
        array([0.5, 2.5], dtype=float32)
    """
    seen = np.zeros((len(rows), width, picture.shape[2]), np.float32)
    count = _count_samples(picture, placement, rows, width)
    for n in range(count**2):
        down, right = divmod(n, count)
        x, y = _place(placement, rows, width, ((right + 0.5) / count, (down + 0.5) / count))
        there = np.isfinite(x) if goes_on else _is_inside(picture, x, y)
        at = np.stack([y[there] - 0.5, x[there] - 0.5])
        for channel, values in enumerate(np.moveaxis(picture, 2, 0)):
            seen[there, channel] += map_coordinates(values, at, order=1, mode="nearest")
    return seen / np.float32(count**2)


def _count_samples(picture: npt.NDArray[np.float32], placement: Placement, rows: range, width: int) -> int:
    """How many samples a pixel takes along each of its sides: as many as the picture's pixels that one is wide which
    sees the picture; 1 where none does."""
    x, y = _place(placement, rows, width, (0.0, 0.5))
    after = _place(placement, rows, width, (1.0, 0.5)), _place(placement, rows, width, (0.5, 1.0))
    above = _place(placement, rows, width, (0.5, 0.0))
    there = _is_inside(picture, x, y)
    if not there.any():
        return 1
    across = np.hypot(after[0][0] - x, after[0][1] - y)[there].max()
    along = np.hypot(after[1][0] - above[0], after[1][1] - above[1])[there].max()
    return int(np.clip(np.ceil(np.nan_to_num(max(across, along), nan=_MOST) - 1e-6), 1, _MOST))


def _place(
    placement: Placement, rows: range, width: int, within: tuple[float, float]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Points of the picture (x, y) at a place within each pixel of some rows; not a number behind the camera."""
    across, down = np.arange(width) + within[0], np.asarray(rows) + within[1]
    x, y, depth = (
        placement[k, 0] * across[None, :] + (placement[k, 1] * down + placement[k, 2])[:, None] for k in range(3)
    )
    depth = np.where(depth > 0, depth, np.nan)
    return x / depth, y / depth


def _is_inside(picture: npt.NDArray[np.float32], x: npt.NDArray, y: npt.NDArray) -> npt.NDArray[np.bool_]:
    return (x >= 0) & (x <= picture.shape[1]) & (y >= 0) & (y <= picture.shape[0])


def _scale_and_shift(scale: tuple[float, float], shift: tuple[float, float]) -> Placement:
    return np.array([[scale[0], 0.0, shift[0]], [0.0, scale[1], shift[1]], [0.0, 0.0, 1.0]])
