"""Point functions evaluated on the pixel centres of a picture, in bounded memory."""

import math
from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jax import Array
from jax.typing import ArrayLike

from jaxtex.models.tiling import Tiling

# Pixels evaluated at a time: what they need stays in the processor's cache, and is the same for every picture.
_BLOCK = 1 << 18


def on_grid(function: Callable[[Array], Any], height: int, width: int) -> Any:
    """Evaluate a function of one image point at all pixel centres (c + 0.5, r + 0.5).

    Args:
        function: from a point (2,), x right and y down, to an array or a pytree of arrays. Give numbers that change
            from call to call as array leaves (a module's bound method, or `eqx.Partial`): it compiles once per shape
            then. A plain function compiles once per function.
        height, width: the picture's size in pixels.

    Returns:
        The function's value with two leading axes [height, width]; points have the precision of the function's leaves.

    Raises:
        ValueError: the picture has no pixels.

    Examples:
        >>> on_grid(lambda point: point[0] + 10 * point[1], 2, 3).tolist()
        [[5.5, 6.5, 7.5], [15.5, 16.5, 17.5]]
    """
    if min(height, width) < 1:
        raise ValueError(f"a picture of {width} x {height} pixels has no points; both must be at least 1")
    as_arrays = jax.tree.map(lambda leaf: jnp.asarray(leaf) if eqx.is_array_like(leaf) else leaf, function)
    return _evaluate(as_arrays, height, width)


@eqx.filter_jit
def _evaluate(function: Callable[[Array], Any], height: int, width: int) -> Any:
    leaves = jax.tree.leaves(eqx.filter(function, eqx.is_inexact_array))
    dtype = jnp.result_type(*leaves) if leaves else jnp.result_type(float)
    x = jnp.arange(width, dtype=dtype) + 0.5

    def evaluate_row(at: Array) -> Any:
        return jax.vmap(lambda across: function(jnp.stack([across, at])))(x)

    # Blocks of equal height, the last one going over the edge: a rest of its own would be compiled a second time.
    blocks = math.ceil(height * width / _BLOCK)
    rows = math.ceil(height / blocks)
    y = jnp.arange(blocks * rows, dtype=dtype) + 0.5
    in_blocks = jax.lax.map(jax.vmap(evaluate_row), y.reshape(blocks, rows))
    return jax.tree.map(lambda leaf: leaf.reshape(blocks * rows, *leaf.shape[2:])[:height], in_blocks)


def coverage_grid(tiling: Tiling, height: int, width: int, *, blur: ArrayLike = 0.5) -> Array:
    """The soft mask of a tiling: `Tiling.coverage` at every pixel, 1 = tile, 0 = joint.

    Args:
        tiling: the model.
        height, width: the picture's size in pixels.
        blur: standard deviation of the anti-aliasing Gaussian in pixels, > 0.

    Returns:
        [height, width] in the precision of the tiling's leaves; differentiable in every one of them.

    Raises:
        ValueError: the picture has no pixels, or the blur is not positive.

    Examples:
        >>> from jaxtex.models.tiling import make_tiling
        >>> mask = coverage_grid(make_tiling(tile_width=8, tile_height=4, mortar_x=2, mortar_y=2), 64, 64)
        >>> mask.shape, round(float(mask.mean()), 2)  # (6 * 2) / (8 * 4)
        ((64, 64), 0.38)
    """
    width_of_spot = jnp.asarray(blur, dtype=jnp.result_type(*jax.tree.leaves(tiling)))
    if not isinstance(width_of_spot, jax.core.Tracer) and not bool(width_of_spot > 0):
        raise ValueError(f"blur is {float(width_of_spot):g} pixels; it must be > 0")
    return on_grid(eqx.Partial(Tiling.coverage, tiling, blur=width_of_spot), height, width)
