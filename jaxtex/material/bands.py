"""Maps of any size in bounded memory: point functions evaluated some rows at a time, from top to bottom; or some points
at a time."""

from collections.abc import Callable, Iterator
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.core.errors import InputError

MapsT = TypeVar("MapsT", bound=tuple)

LONGEST_SIDE = 65_536
"""Larger maps are refused; files of them could hardly be opened."""

# Rows and columns evaluated at a time: one shape for all sizes of maps, so that what is compiled once serves them all.
_BLOCK = (128, 1024)

BAND = _BLOCK[0]
"""Rows of a band."""

CHUNK = 1 << 14
"""Points evaluated at a time, as many as caches hold: one shape for all."""


def check_sides(size: tuple[int, int]) -> None:
    """Refuse sizes of maps that cannot be made.

    Raises:
        InputError: a size without pixels, or beyond `LONGEST_SIDE`.
    """
    told = f"size {size[0]} x {size[1]}"
    if min(size) < 1:
        raise InputError(f"{told}: holds no pixels; give at least 1 x 1")
    if max(size) > LONGEST_SIDE:
        raise InputError(f"{told}: is too large; at most {LONGEST_SIDE} pixels to a side can be made")


def count_bands(size: tuple[int, int]) -> int:
    """How many bands `in_bands` makes of a size (width, height)."""
    return -(-size[1] // _BLOCK[0])


def in_bands(
    draw: Callable[[Array, Array], MapsT],
    *,
    corner: tuple[float, float],
    extent: tuple[float, float],
    size: tuple[int, int],
) -> Iterator[MapsT]:
    """Draw maps of a rectangle, some rows at a time.

    Args:
        draw: from x [col] and y [row] of pixel centres to a named tuple of maps [row, col, ...].
        corner: the rectangle's upper left corner.
        extent: its width and height.
        size: (width, height) of the maps in pixels.

    Examples:
        >>> bands = in_bands(lambda x, y: (x[None, :] + y[:, None],), corner=(0, 0), extent=(4, 2), size=(4, 200))
        >>> [len(band[0]) for band in bands]
        [128, 72]
    """
    x = _pixel_centres(corner[0], extent[0], size[0], _BLOCK[1])
    y = _pixel_centres(corner[1], extent[1], size[1], _BLOCK[0])
    for row, down in enumerate(y):
        blocks = [draw(jnp.asarray(across), jnp.asarray(down)) for across in x]
        rows = min(_BLOCK[0], size[1] - row * _BLOCK[0])
        parts = [np.concatenate(part, axis=1)[:rows, : size[0]] for part in zip(*blocks, strict=True)]
        yield jax.tree.unflatten(jax.tree.structure(blocks[0]), parts)


def evaluate_points(function: Callable[[Any, Array], Any], model: Any, x: Array, y: Array, *, rows: int = BAND) -> Any:
    """A function of a model and one point (2,) at all points of a grid: arrays [row, col, ...].

    Args:
        function: one of a module, so that it is compiled once.
        model: its first argument, a pytree.
        x, y: [col], [row].
        rows: evaluated at once. What a model takes for each point must stay within caches, or it is ten times slower.
    """
    return _evaluate(function, model, x, y, rows)


def evaluate_chunks(function: Callable[[Array], Any], points: npt.NDArray[np.floating]) -> Any:
    """A function of points at any number of them, some at a time.

    Args:
        function: from points [CHUNK, axis], the last of them zeros where there are fewer, to arrays [CHUNK, ...].
        points: [point, axis].

    Returns:
        Arrays [point, ...].

    Examples:
        >>> evaluate_chunks(lambda points: points.sum(axis=1), np.ones((20_000, 3))).shape
        (20000,)
    """
    parts = []
    for first in range(0, max(len(points), 1), CHUNK):
        chunk = np.zeros((CHUNK, points.shape[1]), np.float32)
        count = min(CHUNK, len(points) - first)
        chunk[:count] = points[first : first + count]
        made = function(jnp.asarray(chunk))
        parts.append(jax.tree.map(lambda each, count=count: np.asarray(each)[:count], made))
    return jax.tree.map(lambda *each: np.concatenate(each), *parts)


@jax.jit
def normals_of(slope_x: Array, slope_y: Array) -> Array:
    """Unit normals (OpenGL's) [..., 3] of a relief from its slopes [...] to the right and downwards."""
    # y of the maps points down, of the normal up.
    upward = jnp.stack([-slope_x, slope_y, jnp.ones_like(slope_x)], axis=-1)
    return upward / jnp.sqrt(1.0 + slope_x**2 + slope_y**2)[..., None]


@eqx.filter_jit
def _evaluate(function: Callable[[Any, Array], Any], model: Any, x: Array, y: Array, rows: int) -> Any:
    def row(at: Array) -> Any:
        return jax.vmap(lambda across: function(model, jnp.stack([across, at])))(x)

    return jax.lax.map(row, y, batch_size=rows)


def _pixel_centres(start: float, length: float, pixels: int, block: int) -> npt.NDArray[np.float32]:
    """Where pixels have their centres, [block, pixel]; the last block is filled up with places beyond the sheet."""
    centres = start + (np.arange(-(-pixels // block) * block) + 0.5) * (length / pixels)
    return centres.astype(np.float32).reshape(-1, block)
