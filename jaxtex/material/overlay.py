"""A fitted tiling drawn over its photograph, so that a person sees at once whether it lies on the joints."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.models.grids import on_grid
from jaxtex.models.tiling import Tiling
from jaxtex.photo.pictures import check_picture

_LINE = np.array([0.0, 0.9, 0.75], np.float32)  # linear light: a cyan that brick, stone and wood seldom have
_CASING = np.array([0.0, 0.02, 0.03], np.float32)  # beside the lines, so that they show on light ground as well
_ALONG = np.array([1.0, 0.03, 0.1], np.float32)
_ACROSS = np.array([1.0, 0.6, 0.0], np.float32)
_DIMMED = 0.1  # of its light, linear
_BREADTH = 1 / 900  # of the lines, as a fraction of the picture's longer side


def draw_overlay(pixels: npt.ArrayLike, tiling: Tiling) -> npt.NDArray[np.float32]:
    """Draw a tiling over a picture.

    Tiles are outlined; joints that are too thin for two lines get one along their middle. A dot stands in the middle of
    each tile, and at the origin two arrows, as long as a tile is along (red) and across (amber) the courses.

    Args:
        pixels: linear light, [row, col] or [row, col, channel] with 1 or 3 channels.
        tiling: fitted to this picture.

    Returns:
        float32 [row, col, 3], linear light.

    Raises:
        InputError: no picture.

    Examples:
        >>> from jaxtex.models.tiling import make_tiling
        >>> draw_overlay(np.full((40, 60), 0.5), make_tiling(tile_width=20, tile_height=10)).shape
        (40, 60, 3)
    """
    picture = check_picture(pixels)
    height, width = picture.shape[:2]
    shown = np.repeat(picture, 3, axis=2) if picture.shape[2] == 1 else picture.copy()
    breadth = max(1.2, _BREADTH * max(height, width))
    shared, origin, tips = _prepare(tiling, jnp.asarray(breadth), jnp.array([0.5 * width, 0.5 * height]))
    to_outline, to_middle = (np.asarray(part) for part in on_grid(eqx.Partial(_measure, shared), height, width))
    paint_lines(shown, to_outline, 0.5 * breadth)
    paint_lines(shown, to_middle, 1.5 * breadth)
    for tip, colour in zip(tips, (_ALONG, _ACROSS), strict=True):
        paint_lines(
            shown, _distance_to_arrow(np.asarray(origin), np.asarray(tip), breadth, (height, width)), breadth, colour
        )
    return shown


def draw_tiles_alone(pixels: npt.ArrayLike, tiling: Tiling, places: npt.NDArray[np.integer]) -> npt.NDArray[np.float32]:
    """A picture in which some tiles stand out, and all else is dark.

    Args:
        pixels: linear light, [row, col] or [row, col, channel] with 1 or 3 channels.
        tiling: fitted to this picture.
        places: (course, tile) of the tiles, [tile, 2].

    Returns:
        float32 [row, col, 3], linear light.

    Examples:
        >>> from jaxtex.models.tiling import make_tiling
        >>> floor = make_tiling(tile_width=20, tile_height=10)
        >>> draw_tiles_alone(np.full((20, 40), 0.5), floor, np.array([[0, 1]]))[5, ::10, 0].round(2)
        array([0.05, 0.05, 0.5 , 0.5 ], dtype=float32)
    """
    picture = check_picture(pixels)
    shown = np.broadcast_to(picture, (*picture.shape[:2], 3)).copy()
    place = np.asarray(on_grid(eqx.Partial(_place, tiling), *picture.shape[:2])).astype(np.int64)
    number = place[..., 0] * 2**32 + place[..., 1]
    shown[~np.isin(number, places[:, 0].astype(np.int64) * 2**32 + places[:, 1])] *= _DIMMED
    return shown


def paint_lines(
    shown: npt.NDArray[np.float32],
    distance: npt.NDArray,
    reach: npt.ArrayLike,
    colour: npt.NDArray[np.float32] = _LINE,
    *,
    opacity: npt.ArrayLike = 1.0,
) -> None:
    """Colour what is near a line, anti-aliased, in place; with a darker rim of one more pixel.

    Args:
        shown: what to paint on, linear light, [row, col, 3].
        distance: of each pixel from the line, in pixels, [row, col].
        reach: half the line's breadth in pixels, one number or [row, col].
        colour: (3,), linear light.
        opacity: of the line, 0 to 1, one number or [row, col].

    Examples:
        >>> shown = np.ones((1, 4, 3), np.float32)
        >>> paint_lines(shown, np.array([[0.0, 1.0, 2.0, 3.0]]), 0.5, np.zeros(3, np.float32))
        >>> shown[0, :, 0].round(2)
        array([0.  , 0.45, 1.  , 1.  ], dtype=float32)
    """
    for paint, strength, breadth in ((_CASING, 0.55, np.add(reach, 1.0)), (colour, 1.0, np.asarray(reach))):
        cover = strength * np.asarray(opacity) * np.clip(breadth + 0.5 - distance, 0, 1)
        shown += cover[..., None].astype(np.float32) * (paint - shown)


@eqx.filter_jit
def _prepare(tiling: Tiling, breadth: Array, middle: Array) -> tuple[Tiling, Array, tuple[Array, Array]]:
    """The tiling as it is drawn, and where in the picture its origin and the tips of its arrows are.

    Joints whose two sides could not be told apart are closed, and the homography is scaled to be positive on this side
    of the horizon.
    """
    plane_per_pixel = jnp.sqrt(jnp.abs(jnp.linalg.det(jax.jacfwd(tiling.to_lattice)(middle))))
    thinnest = 3.5 * breadth * plane_per_pixel
    h = tiling.homography
    drawn = dataclasses.replace(
        tiling,
        mortar_x=jnp.where(tiling.mortar_x < thinnest, 0.0, tiling.mortar_x),
        mortar_y=jnp.where(tiling.mortar_y < thinnest, 0.0, tiling.mortar_y),
        homography=h * jnp.sign(h[2, 0] * middle[0] + h[2, 1] * middle[1] + h[2, 2]),
    )
    origin, along, across = (
        tiling.from_lattice(jnp.asarray(q)) for q in ((0.0, 0.0), (tiling.tile_width, 0.0), (0.0, tiling.tile_height))
    )
    return drawn, origin, (along, across)


def _measure(tiling: Tiling, point: Array) -> tuple[Array, Array]:
    """Distances in image pixels from a point to the nearest tile's outline and to its middle."""
    ((x_dx, x_dy), (y_dx, y_dy)) = jax.jacfwd(tiling.to_lattice)(point)
    place = tiling.locate(tiling.to_lattice(point))
    x = (jnp.minimum(place.left, place.right) - 0.5 * tiling.mortar_x) / jnp.sqrt(x_dx**2 + x_dy**2)
    y = (jnp.minimum(place.top, place.bottom) - 0.5 * tiling.mortar_y) / jnp.sqrt(y_dx**2 + y_dy**2)
    # From the tile's middle, in lattice coordinates, and then in the picture's.
    along, across = 0.5 * (place.left - place.right), 0.5 * (place.top - place.bottom)
    from_middle = jnp.sqrt((y_dy * along - x_dy * across) ** 2 + (x_dx * across - y_dx * along) ** 2)
    to_middle = from_middle / jnp.abs(x_dx * y_dy - x_dy * y_dx)
    h = tiling.homography
    ahead = h[2, 0] * point[0] + h[2, 1] * point[1] + h[2, 2] > 0  # nothing is seen behind the horizon
    return jnp.where(ahead, jnp.abs(jnp.minimum(x, y)), jnp.inf), jnp.where(ahead, to_middle, jnp.inf)


def _distance_to_arrow(
    start: npt.NDArray, end: npt.NDArray, breadth: float, shape: tuple[int, int]
) -> npt.NDArray[np.float64]:
    """Distances of all pixels from an arrow's shaft and the two strokes of its head."""
    back = start - end
    back *= 6 * breadth / max(float(np.hypot(*back)), 1e-9)
    turn = np.array([[np.cos(0.5), -np.sin(0.5)], [np.sin(0.5), np.cos(0.5)]])
    tips = (end + turn @ back, end + turn.T @ back)
    return np.minimum.reduce([_distance_to_segment(end, other, shape) for other in (start, *tips)])


def _distance_to_segment(a: npt.NDArray, b: npt.NDArray, shape: tuple[int, int]) -> npt.NDArray[np.float64]:
    y, x = np.indices(shape) + 0.5
    direction = b - a
    along = ((x - a[0]) * direction[0] + (y - a[1]) * direction[1]) / max(float(direction @ direction), 1e-9)
    along = np.clip(along, 0, 1)
    return np.hypot(x - a[0] - along * direction[0], y - a[1] - along * direction[1])


def _place(tiling: Tiling, point: Array) -> Array:
    place = tiling.locate(tiling.to_lattice(point))
    return jnp.stack([place.course, place.tile])
