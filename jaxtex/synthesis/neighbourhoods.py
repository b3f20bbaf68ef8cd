"""Square neighbourhoods of pixels: how far apart two are, and what is drawn where nothing decides.

Distances are sums of squared differences of 8-bit colours, in integers, so that they are the same in whatever order
they are summed. Draws are integer hashes of a pixel's number, so that a pixel's draws do not depend on which pixels
are computed together with it. Places of an exemplar are numbered row * columns + column.
"""

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array, lax

Shape = tuple[int, int]

FARTHEST = np.int32(2**31 - 1)

# Four channels of 8 bits to a word: a pixel is looked up at once, which is what all time goes to.
_PER_WORD = 4

# Loops over as many taps are unrolled: quicker to run, slower to compile.
_UNROLLED = 25

_GOLDEN = 0x9E3779B9


def square_offsets(radius: int) -> npt.NDArray[np.int32]:
    """The (row, col) offsets of the square of 2 radius + 1 pixels around a pixel, [tap, 2], in scanline order.

    The first `causal_taps` come before the pixel in scanline order; the one after these is the pixel itself.
    """
    steps = np.arange(-radius, radius + 1)
    return np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2).astype(np.int32)


def causal_taps(radius: int) -> int:
    """How many pixels of that square come before its centre: those of the L-shaped neighbourhood.

    Examples:
        >>> causal_taps(2), len(square_offsets(2))
        (12, 25)
    """
    return 2 * radius * (radius + 1)


def check_picture(picture: npt.ArrayLike, name: str) -> npt.NDArray[np.float32]:
    """A picture as floats [row, col, channel].

    Raises:
        ValueError: an array of another form, or NaN or infinite values.
    """
    pixels = np.asarray(picture, np.float32)
    if pixels.ndim != 3 or 0 in pixels.shape:
        raise ValueError(f"{name} of shape {pixels.shape}: give [row, col, channel], none of them empty")
    if not np.isfinite(pixels).all():
        raise ValueError(f"{name}: some values are NaN or infinite; replace them")
    return pixels


def check_exemplar(exemplar: npt.ArrayLike, radius: int) -> npt.NDArray[np.float32]:
    """An exemplar that holds at least one whole neighbourhood, as floats [row, col, channel].

    Raises:
        ValueError: as `check_picture`; a radius below 1; sides below 2 radius + 1 or beyond 32768 pixels; so large a
            neighbourhood that distances overflow.
    """
    pixels = check_picture(exemplar, "exemplar")
    side, least, most = 2 * radius + 1, min(pixels.shape[:2]), max(pixels.shape[:2])
    if radius < 1:
        raise ValueError(f"radius: {radius} leaves no neighbours; give 1 or more")
    if least < side:
        raise ValueError(
            f"exemplar of {pixels.shape[1]} x {pixels.shape[0]} pixels holds no neighbourhood of {side} x {side}; "
            f"give a larger one, or a radius of at most {(least - 1) // 2}"
        )
    if most > 32768:
        raise ValueError(f"exemplar: {most} pixels along a side are too many; give at most 32768")
    if 2 * side**2 * pixels.shape[2] * 255**2 >= FARTHEST:  # of two squares: a target weighs as much as all pixels
        raise ValueError(f"radius: {radius} with {pixels.shape[2]} channels is too large; give a smaller radius")
    return pixels


def check_shape(shape: Shape) -> Shape:
    """The size of an output, (rows, columns).

    Raises:
        ValueError: not two whole numbers of at least 1.
    """
    if len(shape) != 2 or any(int(side) != side or side < 1 for side in shape):
        raise ValueError(f"shape: {tuple(shape)} is no size; give (rows, columns), each at least 1")
    return int(shape[0]), int(shape[1])


def quantise(picture: npt.NDArray[np.floating]) -> npt.NDArray[np.uint8]:
    """Values 0..1 as 8-bit numbers; what lies beyond is clipped."""
    return np.round(np.clip(picture, 0.0, 1.0) * 255.0).astype(np.uint8)


def pack_colours(levels: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint32]:
    """8-bit colours [..., channel] as words of four channels each, [word, ...]; missing channels are 0.

    Examples:
        >>> pack_colours(np.array([[1, 2, 3]], np.uint8))
        array([[197121]], dtype=uint32)
    """
    words = np.zeros((-(-levels.shape[-1] // _PER_WORD), *levels.shape[:-1]), np.uint32)
    for channel in range(levels.shape[-1]):
        words[channel // _PER_WORD] |= levels[..., channel].astype(np.uint32) << np.uint32(8 * (channel % _PER_WORD))
    return words


def squared_difference(first: Array, second: Array) -> Array:
    """Sum of the squared differences of two words' channels."""

    def channel(word: Array, number: int) -> Array:
        return ((word >> (8 * number)) & 0xFF).astype(jnp.int32)

    return sum(
        (jnp.square(channel(first, number) - channel(second, number)) for number in range(_PER_WORD)),
        start=jnp.zeros((), jnp.int32),
    )


def measure_places(
    colours: Sequence[Array], places: Array, steps: npt.NDArray[np.int32], window: Sequence[Array], weight: Array
) -> Array:
    """How far neighbourhoods of an exemplar are from neighbourhoods of an output: sums of squared differences.

    Args:
        colours: of the exemplar, one word after another, each [place].
        places: the neighbourhoods' centres in the exemplar, [candidate, lane].
        steps: what leads from a centre's number to its taps', [tap].
        window: the output's colours at these taps, one word after another, each [tap, lane].
        weight: whether a tap counts, boolean [tap, lane].

    Returns:
        int32 [candidate, lane].
    """
    leads = jnp.asarray(steps)

    def add(tap: Array, total: Array) -> Array:
        here = places + leads[tap]
        apart = [
            squared_difference(each.at[here].get(mode="promise_in_bounds"), seen[tap][None])
            for each, seen in zip(colours, window, strict=True)
        ]
        return total + jnp.where(weight[tap][None], sum(apart[1:], start=apart[0]), 0)

    return lax.fori_loop(0, len(steps), add, jnp.zeros(places.shape, jnp.int32), unroll=len(steps) <= _UNROLLED)


def choose_place(places: Array, distance: Array) -> Array:
    """The nearest of the candidates [candidate, lane] of each lane; of several, the one with the lowest number."""
    least = jnp.min(distance, axis=0)
    return jnp.min(jnp.where(distance == least[None], places, FARTHEST), axis=0)


def pass_seed(key: Array, number: int) -> Array:
    """Two words from which all draws of a pass follow, uint32 [2]."""
    return jax.random.bits(jax.random.fold_in(key, number), (2,), jnp.uint32)


def pixel_bits(seed: Array, pixel: Array) -> Array:
    """The word of each pixel, uint32, from its number row * columns + column."""
    return mix_bits(seed[0] + mix_bits(seed[1] + pixel.astype(jnp.uint32)))


def draw_bits(word: Array, number: Array | int) -> Array:
    """A pixel's draw of some number, uint32."""
    return mix_bits(word + jnp.uint32(_GOLDEN) * jnp.asarray(number, jnp.uint32))


def mix_bits(word: Array) -> Array:
    """A bijection of 32-bit words without visible pattern: C. Wellons' lowbias32 ("Prospecting for hash functions")."""
    word = (word ^ (word >> 16)) * jnp.uint32(0x7FEB352D)
    word = (word ^ (word >> 15)) * jnp.uint32(0x846CA68B)
    return word ^ (word >> 16)


def draw_place(bits: Array, shape: Shape, radius: int) -> Array:
    """A random place of an exemplar of this shape whose neighbourhood is whole: its row is the word's upper half, its
    column the lower, multiplied and shifted."""
    rows, columns = (np.uint32(side - 2 * radius) for side in shape)
    row = radius + ((bits >> 16) * rows >> 16)
    column = radius + ((bits & 0xFFFF) * columns >> 16)
    return (row * np.uint32(shape[1]) + column).astype(jnp.int32)
