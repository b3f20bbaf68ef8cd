"""Pictures for looking at: fields over a picture, and the outlines of texton masks."""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont
from skimage.measure import find_contours

from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
from jaxtex.core.errors import InputError
from jaxtex.photo.morphology import outline_mask
from jaxtex.photo.pictures import check_picture
from jaxtex.progressive.texton_masks import MOST_LABEL, check_texton_mask

Floats = npt.NDArray[np.floating]

_LEAST_SIDE = 512  # of a plot: smaller pictures are magnified
_RAMP = np.array([[0.17, 0.2, 0.55], [0.1, 0.55, 0.6], [0.45, 0.75, 0.35], [0.98, 0.9, 0.25]])  # sRGB, low to high
_TINT = 0.55  # how much of a picture the colours of a field cover
_FADE = 0.45  # how much nearer to grey a picture is under strokes
_LEVELS = 12  # lines about
_STROKES = 22  # along the longer side
_INK, _HALO = (255, 255, 255), (0, 0, 0)
_OUTLINES = np.array([[0.0, 0.9, 0.75], [1.0, 0.15, 0.7], [1.0, 0.8, 0.0]])  # linear light, by label from 1
_VEIL = 0.3  # of them over their elements


def plot_scalar(field: npt.ArrayLike, over: npt.ArrayLike | None = None) -> npt.NDArray[np.float32]:
    """Draw a field of numbers over a picture: colours from blue (low) to yellow (high), and lines with their values.

    Args:
        field: finite, [row, col].
        over: linear light, [row, col, channel] of the same size; grey where there is none.

    Returns:
        linear light, float32 [row, col, 3]; small ones are magnified by a whole number.

    Raises:
        InputError: another form, or a picture of another size.

    Examples:
        >>> plot_scalar(np.linspace(0, 1, 400) * np.ones((300, 1))).shape
        (600, 800, 3)
    """
    values = np.asarray(field, float)
    if values.ndim != 2 or 0 in values.shape or not np.isfinite(values).all():
        raise InputError(f"field of shape {values.shape}: give finite numbers [row, col], not empty")
    low, high = values.min(), values.max()
    part = (values - low) / (high - low) if high > low else np.full(values.shape, 0.5)
    steps = np.linspace(0, 1, len(_RAMP))
    colours = np.stack([np.interp(part, steps, channel) for channel in _RAMP.T], axis=-1)
    ground = _ground(over, values.shape)
    light = ground.mean(axis=2, keepdims=True)
    drawn, times = _magnify((1 - _TINT) * light + _TINT * colours)
    pen = ImageDraw.Draw(drawn)
    taken: list[tuple[float, float]] = []
    for level in _round_levels(low, high):
        for line in find_contours(values, level):
            places = [((x + 0.5) * times, (y + 0.5) * times) for y, x in line.tolist()]
            pen.line(places, fill=_HALO, width=3)
            pen.line(places, fill=_INK, width=1)
            _label_line(pen, places, f"{level:g}", taken, drawn.size)
    if high == low:
        _write(pen, (drawn.width / 2, drawn.height / 2), f"{low:.3g}")
    return _to_linear(drawn)


def plot_orientation(
    field: npt.ArrayLike, over: npt.ArrayLike | None = None, *, symmetric: bool = False
) -> npt.NDArray[np.float32]:
    """Draw a field of directions over a picture, as arrows, or strokes where opposite directions are the same.

    Args:
        field: (x, y) of vectors, [row, col, 2].
        over: linear light, [row, col, channel] of the same size; grey where there is none.
        symmetric: whether opposite directions are the same.

    Returns:
        linear light, float32 [row, col, 3]; small ones are magnified by a whole number.

    Raises:
        InputError: another form, or a picture of another size.

    Examples:
        >>> plot_orientation(np.broadcast_to([1.0, 0.0], (600, 800, 2))).shape
        (600, 800, 3)
    """
    vectors = np.asarray(field, float)
    if vectors.ndim != 3 or vectors.shape[2] != 2 or 0 in vectors.shape or not np.isfinite(vectors).all():
        raise InputError(f"field of shape {vectors.shape}: give finite vectors [row, col, 2], not empty")
    ground = _ground(over, vectors.shape[:2])
    drawn, times = _magnify(ground + _FADE * (0.5 - ground))
    pen = ImageDraw.Draw(drawn)
    spacing = max(1.0, max(vectors.shape[:2]) / _STROKES)
    reach = 0.38 * spacing * times
    for y, x in _grid(vectors.shape[:2], spacing):
        along = vectors[int(y), int(x)]
        along = reach * along / max(np.hypot(*along), 1e-9)
        across = np.array([-along[1], along[0]])
        middle = np.array([x, y]) * times
        lines = [[middle - along, middle + along]]
        if not symmetric:
            lines.append([middle + 0.35 * along + 0.4 * across, middle + along, middle + 0.35 * along - 0.4 * across])
        for fill, width in ((_HALO, 5), (_INK, 2)):
            for line in lines:
                pen.line([tuple(place.tolist()) for place in line], fill=fill, width=width)
    return _to_linear(drawn)


def overlay_texton_mask(pixels: npt.ArrayLike, mask: npt.ArrayLike) -> npt.NDArray[np.float32]:
    """Draw the outlines of elements over their picture, and a veil over them: cyan, magenta and yellow by type.

    Args:
        pixels: linear light, [row, col] or [row, col, channel] of 1 or 3 channels.
        mask: labels [row, col], 0 to 3.

    Returns:
        linear light, float32 [row, col, 3].

    Raises:
        InputError: no picture, no mask, or two of different sizes.

    Examples:
        >>> overlay_texton_mask(np.full((4, 4), 0.5), np.zeros((4, 4), np.uint8))[0, 0].tolist()
        [0.5, 0.5, 0.5]
    """
    picture = check_picture(pixels)
    labels = check_texton_mask(mask, picture.shape[1::-1])
    shown = np.repeat(picture, 3 // picture.shape[2], axis=2)
    for label in range(1, MOST_LABEL + 1):
        elements = labels == label
        colour = _OUTLINES[label - 1].astype(np.float32)
        shown[elements] += _VEIL * (colour - shown[elements])
    for label in range(1, MOST_LABEL + 1):
        elements = labels == label
        if elements.any():
            # On the element's side, so that outlines of types that touch do not cover each other.
            shown[outline_mask(elements) & elements] = _OUTLINES[label - 1]
    return shown


def _ground(over: npt.ArrayLike | None, shape: tuple[int, ...]) -> Floats:
    """What is drawn over, sRGB-encoded [row, col, 3]."""
    if over is None:
        return np.full((*shape, 3), 0.5)
    picture = check_picture(over)
    if picture.shape[:2] != shape:
        raise InputError(
            f"picture is {picture.shape[1]} x {picture.shape[0]} pixels, the field {shape[1]} x {shape[0]};"
            " give them one size"
        )
    encoded = np.asarray(linear_to_srgb(np.clip(picture, 0, 1)), float)
    return np.repeat(encoded, 3 // picture.shape[2], axis=2)


def _magnify(picture: Floats) -> tuple[Image.Image, int]:
    levels = np.rint(255 * np.clip(picture, 0, 1)).astype(np.uint8)
    times = max(1, -(-_LEAST_SIDE // max(picture.shape[:2])))
    image = Image.fromarray(levels)
    return image.resize((times * image.width, times * image.height), Image.Resampling.NEAREST), times


def _to_linear(drawn: Image.Image) -> npt.NDArray[np.float32]:
    return np.asarray(srgb_to_linear(np.asarray(drawn) / 255), np.float32)


def _round_levels(low: float, high: float) -> list[float]:
    """Round numbers strictly between two, about as many as wanted."""
    if high == low:
        return []
    raw = (high - low) / _LEVELS
    power = 10.0 ** np.floor(np.log10(raw))
    step = float(power * next(each for each in (1, 2, 5, 10) if each * power >= raw))
    numbers = np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step
    return [float(f"{number:.12g}") for number in numbers if low < number < high]


def _label_line(
    pen: ImageDraw.ImageDraw,
    places: list[tuple[float, float]],
    text: str,
    taken: list[tuple[float, float]],
    size: tuple[int, int],
) -> None:
    """A line's value at the first of its places, from the middle on, that is free and not at the border."""
    middle = len(places) // 2
    for x, y in [*places[middle:], *places[:middle]]:
        inside = 24 < x < size[0] - 24 and 12 < y < size[1] - 12
        if inside and all(abs(x - other[0]) > 56 or abs(y - other[1]) > 24 for other in taken):
            taken.append((x, y))
            _write(pen, (x, y), text)
            return


def _write(pen: ImageDraw.ImageDraw, place: tuple[float, float], text: str) -> None:
    pen.text(place, text, fill=_INK, font=ImageFont.load_default(16), anchor="mm", stroke_width=2, stroke_fill=_HALO)


def _grid(shape: tuple[int, ...], spacing: float) -> Iterator[tuple[float, float]]:
    """(y, x) of evenly spaced places, the same distance from opposite borders."""
    rows, columns = (max(1, round(side / spacing)) for side in shape[:2])
    for row in range(rows):
        for column in range(columns):
            yield (row + 0.5) * shape[0] / rows, (column + 0.5) * shape[1] / columns
