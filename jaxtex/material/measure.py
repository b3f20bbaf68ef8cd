"""Reading the appearance of tiles off the photograph that a tiling was fitted to."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.core.colour import linear_to_srgb
from jaxtex.core.errors import InputError
from jaxtex.material.appearance import Appearance, Place, choose_relief, quantise
from jaxtex.material.neighbours import measure_neighbours
from jaxtex.material.patterns import choose_pattern
from jaxtex.models.grids import on_grid
from jaxtex.models.tiling import Tiling
from jaxtex.photo.pictures import check_picture

MOST_TILES = 4096
"""More tiles than this are not kept each with its own colour: a person should be able to read the model file."""

_MARGIN = 1.5  # pixels next to a joint in which photographs mix the two


def measure_appearance(pixels: npt.ArrayLike, tiling: Tiling, *, mask: npt.ArrayLike | None = None) -> Appearance:
    """Measure the colours of tiles and joints in a photograph.

    Each tile's colour is the median of its pixels away from its joints; the joints' colour is the median of the pixels
    well inside joints. Relief is chosen by the mortar's thickness. The light is the photograph's own: even it out first
    where it varies over the picture.

    Args:
        pixels: linear light, [row, col, channel], 1 or 3 channels.
        tiling: fitted to this photograph.
        mask: [row, col], 1 = tile, 0 = joint. Pixels in tiles that it calls joint (dirt, gaps) do not count, as long as
            that leaves a quarter of the tile; pixels in joints that it calls tile do not count either.

    Returns:
        The appearance; tiles of which the picture shows less than an eighth of the usual area are not in it.

    Raises:
        InputError: pixels that are no picture, a mask of another size, or no tile to be seen.

    Examples:
        >>> from jaxtex.models.tiling import make_tiling
        >>> floor = make_tiling(tile_width=16, tile_height=16, bond="stack")
        >>> chess = np.kron(np.indices((4, 4)).sum(0) % 2, np.full((16, 16), 0.8))
        >>> measure_appearance(chess[..., None], floor).pattern
        ((0, 1), (1, 0))
    """
    picture = check_picture(pixels)
    picture = np.broadcast_to(picture, (*picture.shape[:2], 3))
    seen = _sort_pixels(tiling, *picture.shape[:2])
    evidence = np.ones(picture.shape[:2]) if mask is None else np.asarray(mask, dtype=np.float64)
    if evidence.shape != picture.shape[:2]:
        raise InputError(f"mask: has the shape {list(evidence.shape)}, and the picture {list(picture.shape[:2])}")
    tiles = _tile_colours(picture, seen, evidence)
    joint = _joint_colour(
        picture, np.asarray(seen.in_joint), np.zeros_like(evidence) if mask is None else evidence, tiles
    )
    places, colours = np.array(list(tiles)), np.clip(list(tiles.values()), 0, 1)
    pattern = choose_pattern(places[:, 0], places[:, 1], linear_to_srgb(colours))
    neighbours, trend = measure_neighbours(places, colours, pattern)
    depth, edge = choose_relief(tiling)
    return Appearance(
        tiles=_thin(tiles),
        joint=joint,
        pattern=pattern,
        neighbours=neighbours,
        trend=trend,
        joint_depth=depth,
        edge_width=edge,
    )


class _Seen(eqx.Module):
    """What one pixel shows."""

    course: Array
    tile: Array
    in_tile: Array
    in_joint: Array


def _look(tiling: Tiling, point: Array) -> _Seen:
    place = tiling.locate(tiling.to_lattice(point))
    inside_x = jnp.minimum(place.left, place.right) - 0.5 * tiling.mortar_x
    inside_y = jnp.minimum(place.top, place.bottom) - 0.5 * tiling.mortar_y
    width = place.left + place.right - tiling.mortar_x
    height = tiling.tile_height - tiling.mortar_y

    def margin(size: Array) -> Array:
        return jnp.minimum(_MARGIN + 0.05 * size, 0.25 * size)

    deep = jnp.maximum(-inside_x / tiling.mortar_x, -inside_y / tiling.mortar_y)
    return _Seen(
        course=place.course.astype(jnp.int32),
        tile=place.tile.astype(jnp.int32),
        in_tile=(inside_x > margin(width)) & (inside_y > margin(height)),
        in_joint=deep > 0.25,  # the middle half of a joint; nothing where mortar is 0, as 0 / 0 is no number
    )


def _sort_pixels(tiling: Tiling, height: int, width: int) -> _Seen:
    return on_grid(eqx.Partial(_look, tiling), height, width)


def _tile_colours(
    picture: npt.NDArray[np.float32], seen: _Seen, evidence: npt.NDArray[np.float64]
) -> dict[Place, npt.NDArray[np.floating]]:
    """The median colour of each tile that can be seen well enough."""
    inside = np.asarray(seen.in_tile)
    course, tile = np.asarray(seen.course)[inside], np.asarray(seen.tile)[inside]
    order = np.lexsort((tile, course))
    course, tile = course[order], tile[order]
    colours, clean = picture[inside][order], evidence[inside][order] > 0.5
    starts = np.flatnonzero(np.diff(course, prepend=course[:1] - 1) | np.diff(tile, prepend=tile[:1] - 1))
    if not len(starts):
        raise InputError("photograph: shows no tile of this tiling that is large enough to take a colour from")
    ends = np.append(starts[1:], len(course))
    enough = max(1.0, np.median(ends - starts) / 8)
    tiles = {}
    for start, end in zip(starts, ends, strict=True):
        if end - start < enough:
            continue
        own, kept = colours[start:end], clean[start:end]
        own = own[kept] if 4 * kept.sum() >= len(own) else own
        tiles[int(course[start]), int(tile[start])] = np.median(own, axis=0)
    return tiles


def _joint_colour(
    picture: npt.NDArray[np.float32],
    in_joint: npt.NDArray[np.bool_],
    evidence: npt.NDArray[np.float64],
    tiles: dict[Place, npt.NDArray[np.floating]],
) -> tuple[float, float, float]:
    clean = in_joint & (evidence < 0.5)
    for chosen in (clean, in_joint):
        if chosen.any():
            return quantise(np.median(picture[chosen], axis=0))
    return quantise(np.median(list(tiles.values()), axis=0))


def _thin(tiles: dict[Place, npt.NDArray[np.floating]]) -> dict[Place, tuple[float, float, float]]:
    """Not more than `MOST_TILES` tiles, evenly from all over the picture."""
    step = -(-len(tiles) // MOST_TILES)
    return {place: quantise(colour) for place, colour in list(tiles.items())[::step]}
