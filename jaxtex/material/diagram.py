"""A tiling's parameters as a small drawing, after figure 2 of Lefebvre & Poulin (2000)."""

from collections.abc import Iterator

import numpy as np

from jaxtex.models.tiling import Tiling

_WIDTH, _HEIGHT = 420.0, 230.0  # of the tiles drawn, at most, in units of the drawing
_TOP, _LEFT, _BOTTOM, _RIGHT = 34.0, 96.0, 44.0, 84.0  # for dimensions around them
_COURSES = 3
_TICK = 5.0


def draw_diagram(tiling: Tiling) -> str:
    """Draw three courses of a tiling, upright and to scale, with its dimensions, as an SVG element.

    Lines and text have the classes ``tile``, ``first``, ``dimension`` and ``label``, for a style sheet to colour.

    Examples:
        >>> from jaxtex.models.tiling import make_tiling
        >>> draw_diagram(make_tiling(tile_width=60, tile_height=20, mortar_x=4, mortar_y=4))[:4]
        '<svg'
    """
    pitch = float(tiling.tile_width), float(tiling.tile_height)
    across = max(2.0, 0.9 * _WIDTH / _HEIGHT * _COURSES * pitch[1] / pitch[0])  # tiles, so that the drawing is not tall
    scale = min(_WIDTH / (across * pitch[0]), _HEIGHT / (_COURSES * pitch[1]))
    width, height = across * pitch[0] * scale, _COURSES * pitch[1] * scale
    size = f"{width + _LEFT + _RIGHT:.0f} {height + _TOP + _BOTTOM:.0f}"
    parts = [
        f'<svg viewBox="{-_LEFT:g} {-_TOP:g} {size}" role="img" aria-label="The tiling and its dimensions">',
        f'<clipPath id="courses"><rect width="{width:.2f}" height="{height:.2f}"/></clipPath>',
        '<g clip-path="url(#courses)">',
        *_tiles(tiling, across, scale),
        "</g>",
        *_dimensions(tiling, scale, (width, height)),
        "</svg>",
    ]
    return "".join(parts)


def _tiles(tiling: Tiling, across: float, scale: float) -> Iterator[str]:
    width, height = float(tiling.tile_width) * scale, float(tiling.tile_height) * scale
    gap_x, gap_y = float(tiling.mortar_x) * scale, float(tiling.mortar_y) * scale
    radius = float(tiling.corner_radius) * scale
    lengths = np.asarray(tiling.course_lengths)
    for course in range(_COURSES):
        row = lengths[course % len(lengths)]
        start = _shift(tiling, course)
        start -= np.ceil(start / row.sum()) * row.sum()
        tile = 0
        while start < across:
            length = float(row[tile % len(row)])
            kind = "tile first" if course == 0 and tile == np.argmax(row) else "tile"
            yield (
                f'<rect class="{kind}" x="{start * width + 0.5 * gap_x:.2f}" y="{course * height + 0.5 * gap_y:.2f}" '
                f'width="{length * width - gap_x:.2f}" height="{height - gap_y:.2f}" rx="{radius:.2f}"/>'
            )
            start, tile = start + length, tile + 1


def _dimensions(tiling: Tiling, scale: float, size: tuple[float, float]) -> Iterator[str]:
    width, height = float(tiling.tile_width) * scale, float(tiling.tile_height) * scale
    gap_x, gap_y = float(tiling.mortar_x) * scale, float(tiling.mortar_y) * scale
    first = np.asarray(tiling.course_lengths)[0]
    longest = int(np.argmax(first))  # the tile whose length is the tile width
    begin, end = float(first[:longest].sum()) * width, float(first[: longest + 1].sum()) * width
    yield _across(begin, end, -12, "tile width", above=True)
    yield _line(-14, 0, -14, height) + _line(-14 - _TICK, 0, -14 + _TICK, 0)
    yield _line(-14 - _TICK, height, -14 + _TICK, height)
    yield _label(-24, 0.5 * height, "tile height", anchor="end")
    shift = (_shift(tiling, _COURSES - 1) - _shift(tiling, _COURSES - 2)) % 1.0
    if shift > 0.01:
        left = _shift(tiling, _COURSES - 2) % 1.0 * width
        right = left + shift * width
        yield _across(left, right, size[1] + 14, "offset", above=False)
        yield _line(left, size[1] - 2 * height, left, size[1] + 14, dashed=True)
        yield _line(right, size[1] - height, right, size[1] + 14, dashed=True)
    if gap_y > 0:
        edge = size[0] + 8
        yield _line(edge, height - 0.5 * gap_y, edge, height + 0.5 * gap_y)
        yield _line(edge - _TICK, height - 0.5 * gap_y, edge + _TICK, height - 0.5 * gap_y)
        yield _line(edge - _TICK, height + 0.5 * gap_y, edge + _TICK, height + 0.5 * gap_y)
        yield _label(edge + 10, height, "bed joint", anchor="start")
    if gap_x > 0:
        left, right = end - 0.5 * gap_x, end + 0.5 * gap_x
        yield _line(left, -_TICK, left, 0) + _line(right, -_TICK, right, 0)
        yield _label(right + 6, -12, "head joint", anchor="start")


def _shift(tiling: Tiling, course: int) -> float:
    """Of a course against course 0, in tile widths."""
    offsets = np.asarray(tiling.course_offsets)
    return float(tiling.offset) * course + float(offsets[course % len(offsets)] - offsets[0])


def _across(start: float, end: float, y: float, text: str, *, above: bool) -> str:
    ticks = "".join(_line(x, y - _TICK, x, y + _TICK) for x in (start, end))
    return _line(start, y, end, y) + ticks + _label(0.5 * (start + end), y + (-9 if above else 20), text)


def _line(x1: float, y1: float, x2: float, y2: float, *, dashed: bool = False) -> str:
    kind = "dimension dashed" if dashed else "dimension"
    return f'<line class="{kind}" x1="{x1:.2f}" y1="{y1:.2f}" x2="{x2:.2f}" y2="{y2:.2f}"/>'


def _label(x: float, y: float, text: str, *, anchor: str = "middle") -> str:
    return (
        f'<text class="label" x="{x:.2f}" y="{y:.2f}" text-anchor="{anchor}" dominant-baseline="middle">{text}</text>'
    )
