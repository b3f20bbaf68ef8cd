"""Things cut out by hand: polygons, or a painted picture in which each thing has a colour of its own.

J.-M. Dischler, K. Maritaud, B. Lévy and D. Ghazanfarpour, "Texture particles" (Eurographics 2002), section 2.1, where
some things are cut out with scissors and others found by their colours.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage
from skimage.draw import polygon2mask
from skimage.measure import label

from jaxtex.core.errors import InputError
from jaxtex.io.files import existing_file
from jaxtex.particles.things import Decomposition, Labels, describe_particles
from jaxtex.photo.pictures import check_picture, to_lab

_MOST_COVERED = 0.5  # of a thing that was found: where scissors took more of it, it is the thing that they cut


class Polygon(NamedTuple):
    """A thing's outline.

    Attributes:
        points: [corner, 2], (x right, y down) in pixels from the picture's upper left corner.
        name: of its class; "" if it has none.
    """

    points: npt.NDArray[np.float64]
    name: str = ""


def cut_polygons(polygons: Sequence[Polygon], shape: tuple[int, int]) -> Labels:
    """Label what is inside of outlines, 1, 2 ...; where they overlap, the later one has it.

    Args:
        polygons: the outlines.
        shape: rows and columns of the picture.

    Raises:
        InputError: an outline without three corners, or around no pixel that no later one has.

    Examples:
        >>> corners = np.array([[2.0, 1.0], [6.0, 1.0], [6.0, 4.0], [2.0, 4.0]])
        >>> cut_polygons([Polygon(corners)], (5, 8)).sum(axis=1)
        array([0, 4, 4, 4, 0])
    """
    labels = np.zeros(shape, np.int32)
    for number, (points, _) in enumerate(polygons, 1):
        corners = np.asarray(points, float)
        if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3 or not np.isfinite(corners).all():
            raise InputError(f"polygon {number} of {len(polygons)}: is no outline; give at least three corners (x, y)")
        labels[polygon2mask(shape, corners[:, ::-1] - 0.5)] = number
    missing = sorted(set(range(1, len(polygons) + 1)) - set(np.unique(labels).tolist()))
    if missing:
        raise InputError(f"polygon {missing[0]} of {len(polygons)}: holds no pixel of the picture; it is elsewhere")
    return labels


def label_painted(painted: npt.ArrayLike) -> Labels:
    """Number the things of a painted picture: each connected area of one colour is one; black is the ground.

    Soft edges of strokes are given to what is next to them.

    Args:
        painted: numbers [row, col] or [row, col, channel].

    Raises:
        InputError: nothing is painted, or nothing that is three pixels wide.

    Examples:
        >>> label_painted(np.repeat([[0, 7, 9]], 3, axis=0).repeat(3, axis=1))[0]
        array([0, 0, 0, 1, 1, 1, 2, 2, 2], dtype=int32)
    """
    values = np.asarray(painted)
    values = values[..., None] if values.ndim == 2 else values
    if values.ndim != 3 or 0 in values.shape:
        raise InputError(f"labels of shape {values.shape}: give a picture [row, col] or [row, col, channel]")
    colours, which = np.unique(values.reshape(-1, values.shape[2]), axis=0, return_inverse=True)
    which = which.reshape(values.shape[:2])
    wide = ndimage.maximum_filter(which, 3, mode="nearest") == ndimage.minimum_filter(which, 3, mode="nearest")
    # Areas grow back to where they were before from what is three pixels wide of them.
    areas = label(which, background=-1, connectivity=1)
    kept = np.isin(areas, np.unique(areas[wide]))
    nearest = ndimage.distance_transform_edt(~kept, return_distances=False, return_indices=True) if kept.any() else None
    if nearest is None:
        raise InputError("labels: no area of one colour is three pixels wide; paint things flat, without soft brushes")
    areas = areas[tuple(nearest)]
    black = ~np.any(colours, axis=1)[which[tuple(nearest)]]
    numbers, labels = np.unique(np.where(black, 0, areas), return_inverse=True)
    labels = labels.reshape(areas.shape) + (0 if numbers[0] == 0 else 1)
    if labels.max() == 0:
        raise InputError("labels: all is black, so there are no things; paint each in a colour, on black")
    return labels.astype(np.int32)


def join_things(pixels: npt.ArrayLike, cut: Decomposition, found: Decomposition, *, named: bool) -> Decomposition:
    """Things cut out by hand, and with them those that were found elsewhere.

    Args:
        pixels: the picture, linear light, [row, col] or [row, col, channel].
        cut: what was cut out. It covers what was found; things that are more than half covered are gone.
        found: what was found.
        named: whether classes of what was cut are classes of their own. If not, each thing goes with the class of what
            was found whose colour is nearest.

    Raises:
        ValueError: pictures of several sizes.

    Examples:
        >>> row, column = np.indices((8, 24))
        >>> found = describe_particles(np.where((row > 1) & (row < 6) & (column % 12 < 6), 1 + column // 12, 0), [0, 0])
        >>> cut = describe_particles(np.where((row > 1) & (column < 7), 1, 0), [0])
        >>> len(join_things(np.where(found.labels > 0, 0.8, 0.1), cut, found, named=False).particles)
        2
    """
    picture = check_picture(pixels)
    if not picture.shape[:2] == cut.labels.shape == found.labels.shape:
        raise ValueError(f"labels of {cut.labels.shape} and {found.labels.shape}: give those of {picture.shape[:2]}")
    count = len(found.particles)
    area = np.bincount(found.labels.ravel(), minlength=count + 1)
    covered = np.bincount(found.labels[cut.labels > 0], minlength=count + 1)
    stays = covered <= _MOST_COVERED * area
    stays[0] = False
    others = np.where((cut.labels == 0) & stays[found.labels], found.labels, 0)
    labels = np.where(cut.labels > 0, cut.labels, np.where(others > 0, others + len(cut.particles), 0))
    kinds_found = np.array([each.kind for each in found.particles], int)
    kinds_cut = np.array([each.kind for each in cut.particles], int)
    if named:
        kinds_found = kinds_found + cut.kinds
    elif found.particles:
        kinds_cut = _nearest_kind(to_lab(picture), cut.labels, len(kinds_cut), found.labels, kinds_found)
    kinds = np.concatenate([kinds_cut, kinds_found[stays[1:]]])
    return describe_particles(labels, np.unique(kinds, return_inverse=True)[1])


def read_polygons(path: Path | str, size: tuple[int, int] | None = None) -> list[Polygon]:
    """Read outlines as labelme saves them: JSON, with "shapes", each with "label" and "points" [[x, y], ...].

    Args:
        path: the file. Rectangles may be given by two corners.
        size: width and height of the picture that they are of.

    Raises:
        InputError: there is no such file, it holds no polygons, or they are of a picture of another size; the message
            names the file and the shape.

    Examples:
        >>> text = '{"shapes": [{"label": "leaf", "points": [[2, 1], [6, 1], [6, 4]]}]}'
        >>> _ = Path("leaves.json").write_text(text)
        >>> read_polygons("leaves.json")[0].name
        'leaf'
    """
    file = existing_file(path)
    try:
        document = json.loads(file.read_text(encoding="utf-8"))
    except ValueError as error:  # JSONDecodeError, UnicodeDecodeError, or an integer of thousands of digits
        raise InputError(f"{path}: is no JSON ({error})") from None
    except RecursionError:
        raise InputError(f"{path}: has brackets too deep in each other; save outlines as labelme does") from None
    shapes = document.get("shapes") if isinstance(document, dict) else None
    if not isinstance(shapes, list) or not shapes:
        raise InputError(f'{path}: has no "shapes", or none in them; save outlines as labelme does')
    told = document.get("imageWidth"), document.get("imageHeight")
    if size is not None and None not in told and told != size:
        raise InputError(f"{path}: is of a picture of {told[0]} x {told[1]}; this one is {size[0]} x {size[1]}")
    return [_read_polygon(path, number, shape) for number, shape in enumerate(shapes, 1)]


def _read_polygon(path: Path | str, number: int, shape: Any) -> Polygon:
    try:
        points = np.array(shape["points"], float)
        name = shape.get("label")
    except (KeyError, TypeError, ValueError, AttributeError):
        raise InputError(f'{path}: shape {number} has no "points" [[x, y], ...]') from None
    if shape.get("shape_type") == "rectangle" and points.shape == (2, 2):
        (left, top), (right, bottom) = points
        return Polygon(np.array([[left, top], [right, top], [right, bottom], [left, bottom]]), str(name or ""))
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 3 or shape.get("shape_type", "polygon") != "polygon":
        raise InputError(f"{path}: shape {number} is no polygon; cut things out with three corners or more")
    return Polygon(points, str(name) if name is not None else "")


def _nearest_kind(
    lab: npt.NDArray[np.float32],
    cut: Labels,
    count: int,
    found: Labels,
    kinds: npt.NDArray[np.intp],
) -> npt.NDArray[np.intp]:
    def means(labels: Labels, numbers: npt.NDArray[np.intp]) -> npt.NDArray[np.float64]:
        return np.stack([ndimage.mean(lab[..., i], labels, numbers) for i in range(3)], axis=1)

    by_kind = np.append(-1, kinds)[found]
    classes = np.unique(kinds)
    away = means(cut, np.arange(1, count + 1))[:, None] - means(by_kind, classes)[None]
    return classes[np.argmin(np.square(away).sum(axis=-1), axis=1)]
