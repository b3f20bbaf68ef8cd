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
    marks = eqx.Partial(_measure, _with_visible_joints(tiling, breadth, (width, height)))
    to_outline, to_centre = (np.asarray(part) for part in on_grid(marks, height, width))
    _paint(shown, to_outline, 0.5 * breadth)
    _paint(shown, to_centre, 1.5 * breadth)
    for q, colour in (((float(tiling.tile_width), 0.0), _ALONG), ((0.0, float(tiling.tile_height)), _ACROSS)):
        ends = [np.asarray(tiling.from_lattice(jnp.asarray(end))) for end in ((0.0, 0.0), q)]
        _paint(shown, _distance_to_arrow(ends, breadth, (height, width)), breadth, colour)
    return shown


def _with_visible_joints(tiling: Tiling, breadth: float, size: tuple[int, int]) -> Tiling:
    """The tiling without those joints whose two sides could not be told apart in the picture."""
    middle = jnp.array([0.5 * size[0], 0.5 * size[1]])
    scale = jnp.sqrt(jnp.abs(jnp.linalg.det(jax.jacfwd(tiling.to_lattice)(middle))))  # plane pixels to an image pixel
    thinnest = 3.5 * breadth * scale
    return dataclasses.replace(
        tiling,
        mortar_x=jnp.where(tiling.mortar_x < thinnest, 0.0, tiling.mortar_x),
        mortar_y=jnp.where(tiling.mortar_y < thinnest, 0.0, tiling.mortar_y),
    )


def _measure(tiling: Tiling, point: Array) -> tuple[Array, Array]:
    """Distances in image pixels from a point to the nearest tile's outline and to its middle."""

    def to_outline(point: Array) -> Array:
        place = tiling.locate(tiling.to_lattice(point))
        x = jnp.minimum(place.left, place.right) - 0.5 * tiling.mortar_x
        y = jnp.minimum(place.top, place.bottom) - 0.5 * tiling.mortar_y
        return jnp.minimum(x, y)

    def to_middle(point: Array) -> Array:
        place = tiling.locate(tiling.to_lattice(point))
        return 0.5 * jnp.stack([place.left - place.right, place.top - place.bottom])

    distance, slope = jax.value_and_grad(to_outline)(point)
    offset, jacobian = to_middle(point), jax.jacfwd(to_middle)(point)
    pixels = jnp.linalg.solve(jacobian, offset)
    ahead = tiling.homography[2, :2] @ point + tiling.homography[2, 2] > 0  # nothing is seen behind the horizon
    return (
        jnp.where(ahead, jnp.abs(distance) / jnp.sqrt(slope @ slope), jnp.inf),
        jnp.where(ahead, jnp.sqrt(pixels @ pixels), jnp.inf),
    )


def _distance_to_arrow(ends: list[npt.NDArray], breadth: float, shape: tuple[int, int]) -> npt.NDArray[np.float64]:
    """Distances of all pixels from an arrow's shaft and the two strokes of its head."""
    start, end = (np.asarray(point, dtype=np.float64) for point in ends)
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


def _paint(
    shown: npt.NDArray[np.float32], distance: npt.NDArray, reach: float, colour: npt.NDArray[np.float32] = _LINE
) -> None:
    """Colour what is nearer than `reach`, with a darker rim of one more pixel."""
    for paint, opacity, breadth in ((_CASING, 0.55, reach + 1.0), (colour, 1.0, reach)):
        cover = opacity * np.clip(breadth + 0.5 - distance, 0, 1)[..., None]
        shown += cover.astype(np.float32) * (paint - shown)
