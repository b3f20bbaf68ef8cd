"""Animal coats grown by reaction and diffusion: exemplars whose elements are known, to put beside photographs.

    python fitting/reaction_diffusion.py -o OUT

OUT/leopard.png and OUT/tiger.png are the coats, OUT/leopard_mask.png and OUT/tiger_mask.png their texton masks.

Two chemicals react and spread as in R. A. Barrio et al., "A two-dimensional numerical study of spatial pattern
formation in interacting Turing systems" (1999). Spots, and then pieces of their rims, follow each other in a cascade as
in G. Turk, "Generating textures on arbitrary surfaces using reaction-diffusion" (SIGGRAPH 1991); stripes run one way
as the second chemical spreads along them less, as in A. Witkin and M. Kass, "Reaction-diffusion textures" (SIGGRAPH
1991). Hairs are noise that is smoothed along them, and they carry the colours past the outlines of the pattern.
"""

import argparse
from functools import partial
from pathlib import Path
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array
from scipy import ndimage

import jaxtex as jt
from jaxtex.core.colour import srgb_to_linear

SIZE = 256  # pixels along each side; coats repeat at their borders

_ALPHA, _BETA = 0.899, -0.91  # Barrio et al., where spots and stripes can both grow
_RATIO = 0.516  # how fast the first chemical spreads beside the second
_TIME_STEP = 0.1
_SPOTS = 0.02, 0.2  # their cubic and quadratic rates
_STRIPES = 3.5, 0.0

_HAIR_LENGTH, _HAIR_BREADTH = 5.0, 0.6  # pixels, standard deviations
_STRAY = 1.5  # pixels by which hairs carry colours along themselves
_SHADING = 0.12  # how much lighter or darker hairs are, in sRGB

Floats = npt.NDArray[np.floating]
Labels = npt.NDArray[np.uint8]


class Coat(NamedTuple):
    """An exemplar, and what is known of it.

    Attributes:
        pixels: linear light, float32 [row, col, 3].
        mask: uint8 [row, col]. Leopard: 0 between rosettes, 1 inside them, 2 their dark rims. Tiger: 1 in stripes.
    """

    pixels: Floats
    mask: Labels


@partial(jax.jit, static_argnames=("steps", "rates"))
def react(start: Array, spread: Array, *, rates: tuple[float, float], steps: int) -> Array:
    """Let two chemicals react and spread on a torus.

    Args:
        start: how much more than at rest there is of both, [chemical, row, col].
        spread: how fast the second spreads down and across, [axis, row, col] or sizes that fit; pixels squared per
            time. The first spreads about half as fast as the second where that is fastest, all ways alike.
        rates: of the cubic and of the quadratic reaction.
        steps: of time.

    Returns:
        How much there is then, [chemical, row, col].
    """
    cubic, quadratic = rates
    first = _RATIO * spread.max(axis=0)

    def flow(amount: Array, rate: Array, axis: int) -> Array:
        onward = 0.5 * (rate + jnp.roll(rate, -1, axis)) * (jnp.roll(amount, -1, axis) - amount)
        return onward - jnp.roll(onward, 1, axis)

    def step(_: int, amounts: Array) -> Array:
        u, v = amounts
        both = cubic * _ALPHA * u * v * v + quadratic * u * v
        du = flow(u, first, 0) + flow(u, first, 1) + _ALPHA * u + v - both
        dv = flow(v, spread[0], 0) + flow(v, spread[1], 1) + _BETA * v - _ALPHA * u + both
        return amounts + _TIME_STEP * jnp.stack([du, dv])

    return jax.lax.fori_loop(0, steps, step, start)


def grow_leopard(key: Array) -> Coat:
    """Rosettes: rims of dark pieces around places that are a little darker than what is between them.

    Args:
        key: random key; another key, another coat.

    Returns:
        A coat of SIZE x SIZE pixels; mask: 0 between rosettes, 1 inside them, 2 their dark rims.
    """
    spots_key, pieces_key, size_key, hair_key = jax.random.split(key, 4)
    spots = _grow(spots_key, 88, np.full((2, 1, 1), 2.0), _SPOTS, 6000)
    # Broad hills about the spots, of unlike sizes, whose slopes are the rims.
    hills = _spread_evenly(ndimage.gaussian_filter(spots, 6.0, mode="wrap")) + 0.05 * _noise(size_key, 14.0)
    pieces = _grow(pieces_key, 224, np.full((2, 1, 1), 2.0), _STRIPES, 1200)
    rim = 1.0 - np.square((hills - 0.62) / 0.17) + 0.75 * pieces
    inside = hills > 0.62
    mask = np.where(rim > 0.45, 2, inside).astype(np.uint8)
    palette = np.array([[0.86, 0.69, 0.44], [0.74, 0.5, 0.25], [0.13, 0.09, 0.07]])
    return _colour(hair_key, mask, palette, hair_direction=0.35)


def grow_tiger(key: Array) -> Coat:
    """Dark stripes that run down, of unlike breadths, and fork and end.

    Args:
        key: random key; another key, another coat.

    Returns:
        A coat of SIZE x SIZE pixels; mask: 1 in stripes.
    """
    stripes_key, breadth_key, hair_key = jax.random.split(key, 3)
    spread = np.array([1.15, 2.0])[:, None, None]
    stripes = _grow(stripes_key, 112, spread, _STRIPES, 1800)
    mask = (stripes + 0.35 * _noise(breadth_key, 16.0) > 0.35).astype(np.uint8)
    palette = np.array([[0.85, 0.52, 0.2], [0.11, 0.08, 0.07]])
    return _colour(hair_key, mask, palette, hair_direction=1.35)


def _grow(key: Array, side: int, spread: Floats, rates: tuple[float, float], steps: int) -> Floats:
    """A pattern [row, col] of mean 0 and deviation 1, grown on a torus of side x side and magnified to SIZE."""
    start = 0.1 * jax.random.normal(key, (2, side, side))
    pattern = np.asarray(react(start, jnp.asarray(spread, start.dtype), rates=rates, steps=steps))[0]
    centres = (np.arange(SIZE) + 0.5) * (side / SIZE) - 0.5
    large = ndimage.map_coordinates(pattern, np.meshgrid(centres, centres, indexing="ij"), order=3, mode="grid-wrap")
    return (large - large.mean()) / large.std()


def _spread_evenly(values: Floats) -> Floats:
    """The same order of values, with as many of each from 0 to 1."""
    return values.ravel().argsort().argsort().reshape(values.shape) / values.size


def _noise(key: Array, smoothing: float) -> Floats:
    """Periodic noise [row, col] of deviation 1, smoothed by so many pixels."""
    white = np.asarray(jax.random.normal(key, (SIZE, SIZE)))
    smooth = ndimage.gaussian_filter(white, smoothing, mode="wrap")
    return smooth / smooth.std()


def _colour(key: Array, mask: Labels, palette: Floats, *, hair_direction: float) -> Coat:
    """Fur: hairs lie in one direction (radians from the right, downwards), a little bent, and shine unevenly."""
    shade_key, stray_key, bend_key, tone_key = jax.random.split(key, 4)
    angle = hair_direction + 0.25 * _noise(bend_key, 24.0)
    along = np.stack([np.sin(angle), np.cos(angle)])
    hairs, strays = (_comb(each, along) for each in (shade_key, stray_key))
    place = np.indices(mask.shape) + _STRAY * strays * along
    shares = [
        ndimage.map_coordinates(
            ndimage.gaussian_filter((mask == label).astype(float), 0.7, mode="wrap"), place, order=1, mode="grid-wrap"
        )
        for label in range(len(palette))
    ]
    shares = np.stack(shares, axis=-1)
    colours = shares / shares.sum(axis=-1, keepdims=True) @ palette
    shading = 1.0 + _SHADING * hairs + 0.05 * _noise(tone_key, 20.0)
    pixels = srgb_to_linear(np.clip(colours * shading[..., None], 0.0, 1.0))
    return Coat(np.asarray(pixels, np.float32), mask)


def _comb(key: Array, along: Floats) -> Floats:
    """Noise of deviation 1, smoothed along a direction: the mean of what is passed along each pixel's hair."""
    grain = _noise(key, _HAIR_BREADTH)
    steps = np.arange(-2 * _HAIR_LENGTH, 2 * _HAIR_LENGTH + 1)
    weights = np.exp(-0.5 * np.square(steps / _HAIR_LENGTH))
    rows_columns = np.indices(grain.shape)
    hairs = sum(
        weight * ndimage.map_coordinates(grain, rows_columns + step * along, order=1, mode="grid-wrap")
        for step, weight in zip(steps, weights, strict=True)
    )
    return hairs / hairs.std()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder to write to")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    key = jax.random.key(options.seed)
    for name, coat in (("leopard", grow_leopard(key)), ("tiger", grow_tiger(key))):
        jt.write_image(options.output / f"{name}.png", coat.pixels)
        jt.write_mask(options.output / f"{name}_mask.png", coat.mask / coat.mask.max())
        print(f"{name}: {', '.join(f'{share:.0%}' for share in np.bincount(coat.mask.ravel()) / coat.mask.size)}")


if __name__ == "__main__":
    main()
