"""What a picture was taken apart into, on one sheet: things, their neighbours, and each class's particles."""

from collections.abc import Iterator
from math import cos, sin

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw
from scipy.ndimage import find_objects
from skimage.segmentation import find_boundaries

from jaxtex.cli.contact_sheet import Cell, draw_contact_sheet, lay_out
from jaxtex.particles.arrangement import find_neighbours
from jaxtex.particles.boxes import Form
from jaxtex.particles.cooccurrences import Arrangement, Listed, Scattered, place_neighbour
from jaxtex.particles.things import Decomposition

_SIDE = 512  # pixels of a panel
_GAP = 4  # pixels between particles that are shown
_MARGIN = 12  # pixels around them
_DIM = 0.35  # how light the picture is under what is drawn on it
_GREY = 0.5  # what particles are shown on
_DOT = 2  # pixels
_CLASSES = ((0.15, 0.9, 0.3), (0.2, 0.65, 1.0), (1.0, 0.75, 0.1), (0.9, 0.35, 0.95))
_CUT = (1.0, 0.15, 0.1)  # what the picture's border cuts off
_MOST_CLASSES = 8

Pixels = npt.NDArray[np.floating]


def draw_particle_sheet(
    picture: Pixels, decomposition: Decomposition, arrangement: Arrangement, names: tuple[str, ...]
) -> npt.NDArray[np.float32]:
    """Draw the sheet.

    Args:
        picture: sRGB-encoded, 0 to 1, [row, col, channel] of 1 or 3 channels.
        decomposition: the picture taken apart.
        arrangement: what was learnt of it.
        names: of the classes.

    Returns:
        [row, col, 3], sRGB-encoded.
    """
    coloured = np.clip(np.broadcast_to(picture, (*picture.shape[:2], 3)), 0, 1)
    cells = list(_draw_cells(coloured, decomposition, arrangement, names))
    layout = lay_out(len(cells), largest=(_SIDE, _SIDE), lines=2, small=False)
    return draw_contact_sheet(cells, layout)


def tell_class(rule: Listed | Scattered) -> str:
    """How a class is arranged, in words."""
    if isinstance(rule, Scattered):
        return "too few to show an arrangement"
    if rule.turned:
        return f"{len(rule.lists)} lists of neighbours, turned with each particle"
    turned = f", turned by {np.degrees(rule.angle):.0f} degrees" if rule.angle else ""
    return f"{len(rule.lists)} lists of neighbours{turned}"


def _draw_cells(
    picture: Pixels, decomposition: Decomposition, arrangement: Arrangement, names: tuple[str, ...]
) -> Iterator[Cell]:
    whole = sum(each.complete for each in decomposition.particles)
    count = len(decomposition.particles)
    yield Cell("picture", _fit(picture), None, (f"{picture.shape[1]} x {picture.shape[0]} pixels",))
    told = (f"{count}, of which {whole} are whole", "red: cut off by the border")
    yield Cell("things", _fit(_outline(picture, decomposition)), None, told)
    yield Cell("neighbours", _link(picture, decomposition), None, ("of the same class, in each quadrant",))
    for kind, name in enumerate(names[:_MOST_CLASSES]):
        members = [each for each in decomposition.particles if each.kind == kind]
        whole = sum(each.complete for each in members)
        yield Cell(
            name, _show_members(picture, decomposition, kind), None, (f"{len(members)}, of which {whole} are whole",)
        )
        rule = arrangement.classes[kind]
        if isinstance(rule, Listed):
            yield Cell(f"{name}: neighbours", _scatter(decomposition, rule, kind), None, (tell_class(rule),))


def _colour(kind: int) -> tuple[float, float, float]:
    return _CLASSES[kind % len(_CLASSES)]


def _fit(picture: Pixels) -> Pixels:
    """Made smaller, if it is larger than a panel, and larger by a whole number, if it is much smaller."""
    largest = max(picture.shape[:2])
    if largest <= _SIDE:
        times = _SIDE // largest
        return picture.repeat(times, axis=0).repeat(times, axis=1)
    size = tuple(max(1, round(side * _SIDE / largest)) for side in picture.shape[1::-1])
    return np.asarray(_to_image(picture).resize(size, Image.Resampling.BOX)) / 255


def _outline(picture: Pixels, decomposition: Decomposition) -> Pixels:
    """The ground dark, edges of things in their class's colour, of those that are cut off red."""
    drawn = picture * np.where(decomposition.labels > 0, 1, _DIM)[..., None]
    colours = [(0.0, 0.0, 0.0), *(_colour(each.kind) if each.complete else _CUT for each in decomposition.particles)]
    edges = find_boundaries(decomposition.labels, mode="inner")
    # Edges must be seen in the panel too.
    for _ in range(max(picture.shape[:2]) // (2 * _SIDE)):
        edges |= find_boundaries(edges, mode="outer") & (decomposition.labels > 0)
    drawn[edges] = np.array(colours)[decomposition.labels[edges]]
    return drawn


def _link(picture: Pixels, decomposition: Decomposition) -> Pixels:
    """A line from each complete particle's centre towards each of its neighbours'."""
    dim = _to_image(_fit(picture) * _DIM)
    scale = dim.width / picture.shape[1]
    pen = ImageDraw.Draw(dim)
    for number, others in find_neighbours(decomposition).items():
        box = decomposition.particles[number].box
        for other in others:
            end = decomposition.particles[other].box
            ink = _levels(_colour(decomposition.particles[number].kind))
            pen.line([(scale * box.x, scale * box.y), (scale * end.x, scale * end.y)], fill=ink)
    return np.asarray(dim) / 255


def _show_members(picture: Pixels, decomposition: Decomposition, kind: int) -> Pixels:
    """A class's complete particles side by side on grey, largest first, as many as there is room for."""
    panel = np.full((_SIDE, _SIDE, 3), _GREY)
    numbers = [i for i, each in enumerate(decomposition.particles) if each.kind == kind and each.complete]
    numbers.sort(key=lambda i: -decomposition.particles[i].area)
    row = column = _MARGIN
    shelf = 0
    around = find_objects(decomposition.labels)
    for number in numbers:
        rows, columns = around[number]
        height, width = rows.stop - rows.start, columns.stop - columns.start
        if column + width > _SIDE - _MARGIN:
            row, column, shelf = row + shelf + _GAP, _MARGIN, 0
        if row + height > _SIDE - _MARGIN or width > _SIDE - 2 * _MARGIN:
            continue
        cover = decomposition.labels[rows, columns, None] == number + 1
        place = panel[row : row + height, column : column + width]
        place[:] = np.where(cover, picture[rows, columns], place)
        column, shelf = column + width + _GAP, max(shelf, height)
    return panel


def _scatter(decomposition: Decomposition, rule: Listed, kind: int) -> Pixels:
    """Where all lists have neighbours, around a particle of the class's mean size in the middle."""
    boxes = [each.box for each in decomposition.particles if each.kind == kind]
    width, height = (
        float(np.mean(sides)) for sides in zip(*((each.width, each.height) for each in boxes), strict=True)
    )
    form = Form(0.5 * width, 0.5 * height, 1.0, 0.0)
    frame = (1.0, 0.0) if rule.turned else (cos(rule.angle), sin(rule.angle))
    places = np.array([place_neighbour(entry, form, form, *frame) for entries in rule.lists for entry in entries])
    scale = (0.5 * _SIDE - _MARGIN) / max(np.abs(places).max(), width, height)
    panel = Image.new("RGB", (_SIDE, _SIDE), (24, 24, 24))
    pen = ImageDraw.Draw(panel)
    middle, half = 0.5 * _SIDE, (0.5 * scale * width, 0.5 * scale * height)
    corners = [(middle - half[0], middle - half[1]), (middle + half[0], middle + half[1])]
    pen.rectangle(corners, outline=(160, 160, 160))
    for x, y in middle + scale * places:
        pen.ellipse([(x - _DOT, y - _DOT), (x + _DOT, y + _DOT)], fill=_levels(_colour(kind)))
    return np.asarray(panel) / 255


def _levels(colour: tuple[float, float, float]) -> tuple[int, int, int]:
    red, green, blue = (round(255 * each) for each in colour)
    return red, green, blue


def _to_image(picture: Pixels) -> Image.Image:
    return Image.fromarray(np.rint(255 * np.clip(picture, 0, 1)).astype(np.uint8))
