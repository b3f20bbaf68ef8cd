"""Making a mask by value: the threshold of a histogram, and colours picked by clicking.

Both look at each pixel alone. Uneven light is best divided out first (`jaxtex.photo.illumination.even_out`) and specks
are best dropped afterwards (`jaxtex.photo.morphology`).
"""

from typing import Literal

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.photo.pictures import check_picture, lightness, part_histogram, to_lab

Mask = npt.NDArray[np.bool_]


def threshold_mask(
    pixels: npt.ArrayLike, *, level: float | None = None, joints: Literal["dark", "light"] = "dark"
) -> Mask:
    """Part tiles from joints at one lightness.

    Args:
        pixels: linear light, ``[H, W]`` or ``[H, W, C]`` with C 1 or 3.
        level: CIE lightness L* from 0 (black) to 100 (white) at which to part them; by default the valley of the
            histogram found by Otsu's method.
        joints: whether the joints are the dark part or the light one.

    Returns:
        bool ``[H, W]``, True = tile.

    Raises:
        InputError: no picture, a level out of range, or a picture of one single lightness.

    Source: Lefebvre & Poulin, section 2 (histogram thresholding); Otsu, "A threshold selection method from gray-level
    histograms" (1979). Departs from the paper in that lightness, not the file's grey value, is compared: the same level
    then means the same to the eye whatever encoding the file has.

    Examples:
        >>> import numpy as np
        >>> threshold_mask(np.array([[0.02, 0.5, 0.6]])).astype(int).tolist()
        [[0, 1, 1]]
    """
    light = lightness(pixels)
    _check_choice("joints", joints, ("dark", "light"))
    if level is None:
        if light.min() == light.max():
            raise InputError(
                f"picture: has one single lightness, {light.min():.1f}, so nothing parts tiles from joints"
            )
        level = part_histogram(light)
    elif not 0 <= level <= 100:
        raise InputError(f"level: {level:g} is out of range; lightness goes from 0 (black) to 100 (white)")
    return light > level if joints == "dark" else light <= level


def colour_mask(
    pixels: npt.ArrayLike,
    picks: npt.ArrayLike,
    *,
    tolerance: float = 12.0,
    picked: Literal["joints", "tiles"] = "joints",
) -> Mask:
    """Part tiles from joints by colours a person has picked: whatever looks like one of them is of their kind.

    Args:
        pixels: linear light, ``[H, W]`` or ``[H, W, C]`` with C 1 or 3.
        picks: ``[n, C]`` colours, linear light; `pick_colours` gives them for points clicked.
        tolerance: the largest distance in CIE L*a*b* (Delta E 1976) that still looks like a pick. 2 is just visible, 10
            a shade, 50 another colour.
        picked: which kind the picks show.

    Returns:
        bool ``[H, W]``, True = tile.

    Raises:
        InputError: no picture, no picks, colours with other channels than the picture, or a negative tolerance.

    Source: Lefebvre & Poulin, section 2, name the mask tools; distance as in CIE 15:2004, section 8.2.1.

    Examples:
        >>> import numpy as np
        >>> wall = np.array([[[0.5, 0.1, 0.1], [0.6, 0.6, 0.6], [0.5, 0.12, 0.1]]])
        >>> colour_mask(wall, pick_colours(wall, [(1.5, 0.5)], radius=0)).astype(int).tolist()
        [[1, 0, 1]]
    """
    picture = check_picture(pixels)
    _check_choice("picked", picked, ("joints", "tiles"))
    colours = np.atleast_2d(np.asarray(picks, float))
    if colours.size == 0:
        raise InputError("picks: none given; pick at least one point or colour")
    if colours.ndim != 2 or colours.shape[1] != picture.shape[2]:
        raise InputError(f"picks: must have shape [n, {picture.shape[2]}] like the picture, not {list(colours.shape)}")
    if not tolerance >= 0:
        raise InputError(f"tolerance: {tolerance:g} is out of range; give a distance in Lab of 0 or more")
    lab, centres = to_lab(picture), to_lab(colours[:, None])[:, 0]
    alike = np.zeros(lab.shape[:2], bool)
    for centre in centres:
        alike |= np.linalg.norm(lab - centre, axis=-1) <= tolerance
    return alike if picked == "tiles" else ~alike


def pick_colours(pixels: npt.ArrayLike, points: npt.ArrayLike, *, radius: int = 2) -> npt.NDArray[np.float32]:
    """The colours at points clicked, each the median of a small square, so that grain does not decide.

    Args:
        pixels: linear light, ``[H, W]`` or ``[H, W, C]`` with C 1 or 3.
        points: ``[n, 2]``, (x right, y down) in pixels; pixel (row r, column c) covers x from c to c + 1 and y from r
            to r + 1.
        radius: the square is 2·radius + 1 pixels wide, cut at the frame.

    Returns:
        ``[n, C]`` linear colours.

    Raises:
        InputError: no picture, or a point outside it.

    Examples:
        >>> import numpy as np
        >>> pick_colours(np.array([[0.1, 0.25, 0.9]]), [(1.5, 0.5)]).tolist()
        [[0.25]]
    """
    picture = check_picture(pixels)
    height, width, _ = picture.shape
    places = np.atleast_2d(np.asarray(points, float))
    if places.ndim != 2 or places.shape[1] != 2:
        raise InputError(f"points: must have shape [n, 2], (x, y) each, not {list(places.shape)}")
    colours = []
    for x, y in places:
        if not (0 <= x <= width and 0 <= y <= height):
            raise InputError(f"points: ({x:g}, {y:g}) lies outside the picture, which is {width} x {height} pixels")
        row, column = min(int(y), height - 1), min(int(x), width - 1)
        square = picture[max(0, row - radius) : row + radius + 1, max(0, column - radius) : column + radius + 1]
        colours.append(np.median(square, axis=(0, 1)))
    return np.array(colours, np.float32)


def _check_choice(name: str, value: str, choices: tuple[str, ...]) -> None:
    if value not in choices:
        raise InputError(f"{name}: must be one of {', '.join(choices)}, not {value!r}")
