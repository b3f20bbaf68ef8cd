"""Orthogonal views of a solid texture, and what the slices of a block along each axis should be like.

J.-M. Dischler, D. Ghazanfarpour and R. Freydier, "Anisotropic solid texture synthesis using orthogonal 2D views"
(Eurographics 1998), section 4.1. Voxels are [z, y, x, channel]. View xy: row is y, column is x; view xz: row is z,
column is x; view yz: row is z, column is y.

Colours are taken apart into channels that do not vary together, the same for all views so that these agree; or, where
there is but one hue, the first of these channels alone is synthesised, and the colour follows from it.
"""

import itertools
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Literal, NamedTuple, TypeVar, get_args

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array
from scipy.ndimage import gaussian_filter1d

from jaxtex.core.histograms import match_histogram, quantile_table
from jaxtex.synthesis.neighbourhoods import check_picture
from jaxtex.synthesis.slices import SliceStatistics, analyse_crops

Floats = npt.NDArray[np.floating]
Result = TypeVar("Result")

AXES = {"xy": 0, "xz": 1, "yz": 2}
"""Of voxels [z, y, x, channel], the axis along which a view's slices follow each other."""

CROPS = 25
"""Crops of each view, unless told."""

ColourModel = Literal["decorrelated", "single-hue"]
"""As many independent channels as there are colours, or one alone that tells the colour: for textures of one hue."""

_MARGIN = 1.25  # times as large as the block is a view at the least, so that crops differ
_DIFFER = 0.01  # of the range of values: views further apart are given one histogram
_LEVELS = 256  # of the value that tells the colour
_SMOOTH = 3  # levels: standard deviation of the spot that colours are averaged over


class Palette(NamedTuple):
    """The colours [level, channel] of evenly spaced values [level]; between them they are linear."""

    values: Floats
    colours: Floats


class Views(NamedTuple):
    """Pictures of a solid that agree on what colours are.

    Attributes:
        pictures: of each view that there is, in the order of `AXES`, the independent channels, [row, col, channel].
        mean: colour, [channel].
        basis: the independent channels' directions, as columns, [channel, channel]; orthonormal. With a palette, the
            first alone.
        least, greatest: values of the views, [channel].
        apart: how far histograms of views are from each other, as they were given: the largest 1-Wasserstein distance
            of any two, as a share of the range of values.
        shared: whether they were given one histogram.
        palette: colours of the first channel's values, where that is the only one.
    """

    pictures: dict[str, Floats]
    mean: Floats
    basis: Floats
    least: Floats
    greatest: Floats
    apart: float
    shared: bool
    palette: Palette | None = None

    def to_voxels(self, channels: Array) -> npt.NDArray[np.float32]:
        """Colours [z, y, x, channel], encoded as the views are and within their range, of independent channels
        [channel, z, y, x]."""
        colours = np.empty((*channels.shape[1:], len(self.mean)), np.float32)
        # Slice by slice: at no time are there two more blocks.
        for number in range(len(colours)):
            values = self._colour(np.asarray(channels[:, number]).reshape(len(channels), -1))
            colours[number] = np.clip(values, self.least, self.greatest).reshape(colours.shape[1:])
        return colours

    def _colour(self, values: Floats) -> Floats:
        """Colours [value, channel] of independent channels [channel, value]."""
        if self.palette is None:
            return values.T @ self.basis.T + self.mean
        steps, colours = self.palette
        return np.stack([np.interp(values[0], steps, each) for each in colours.T], axis=1)


def align_views(
    views: Mapping[str, npt.ArrayLike],
    side: int,
    *,
    shared: bool | None = None,
    colours: ColourModel = "decorrelated",
) -> Views:
    """Take the colours of views apart, and give the views one histogram where theirs differ.

    Args:
        views: at least one of "xy", "xz" and "yz": floats [row, col, channel] in an encoding whose steps look even, all
            with as many channels, each at least 1.25 times `side` pixels high and wide.
        side: voxels along each edge of the block.
        shared: whether all views are given one histogram, half-way between theirs. Slices of all axes hold the same
            voxels, so that views with different histograms cannot all be met. Unless told, where they differ by more
            than a hundredth of the range of values.
        colours: "decorrelated", or "single-hue", a third of the work: only the channel that varies most is
            synthesised, and each of its values has the mean colour of the views' pixels of that value. A second hue of
            the same value is lost.

    Raises:
        ValueError: no view, or one of another name; another model of colours; pictures of another form, hardly larger
            than the block, with different numbers of channels, NaN or infinite values, or all of one colour.

    Examples:
        >>> grain = np.random.default_rng(0).random((40, 40, 3))
        >>> align_views({"xy": grain, "xz": grain}, 16).pictures["xz"].shape
        (40, 40, 3)
    """
    given = _check_views(views, side)
    if colours not in get_args(ColourModel):
        raise ValueError(f"colours: {colours!r} is none of {', '.join(get_args(ColourModel))}")
    pooled = np.concatenate([each.reshape(-1, each.shape[2]) for each in given.values()])
    mean, basis = _decorrelate(pooled)
    palette = None
    if colours == "single-hue":
        basis = basis[:, :1]
        palette = _make_palette(pooled, mean, basis)
    pictures = apply_once(lambda picture: (picture - mean) @ basis, given)
    apart = _histograms_apart(list(pictures.values()))
    shared = apart > _DIFFER if shared is None else shared
    if shared:
        pictures = _share_histogram(pictures)
    return Views(pictures, mean, basis, pooled.min(axis=0), pooled.max(axis=0), apart, shared, palette)


def analyse_views(
    pictures: Mapping[str, Floats], side: int, *, key: Array, crops: int = CROPS
) -> dict[str, SliceStatistics]:
    """Learn what slices of a block should be like.

    Args:
        pictures: of `Views`.
        side: voxels along each edge of the block.
        key: random key: where the crops are taken.
        crops: of each view, spread over it.

    Returns:
        The statistics of slices across each axis that has a view.

    Raises:
        ValueError: crops that are all of one colour; fewer than two.

    Examples:
        >>> views = align_views({"xz": np.random.default_rng(0).random((40, 40, 3))}, 16)
        >>> analyse_views(views.pictures, 16, key=jax.random.key(0))["xz"].average.shape
        (3, 16, 9)
    """
    if crops < 2:
        raise ValueError(f"crops: {crops} show no range; give at least 2")
    statistics = {}
    for name, picture in pictures.items():
        corners = _spread_corners(picture.shape[:2], side, crops, jax.random.fold_in(key, AXES[name]))
        cut = np.stack([picture[row : row + side, column : column + side] for row, column in corners])
        if np.ptp(cut, axis=(1, 2)).max() == 0:
            raise ValueError(
                f"view {name}: its crops of {side} x {side} pixels are all of one colour; give a larger block, or a "
                "picture with texture everywhere"
            )
        statistics[name] = analyse_crops(cut, picture.reshape(-1, picture.shape[2]))
    return statistics


def apply_once(work: Callable[[Any], Result], pictures: Mapping[str, Any]) -> dict[str, Result]:
    """Work on the pictures of views; on one that stands for several views, once."""
    results = {id(picture): work(picture) for picture in {id(each): each for each in pictures.values()}.values()}
    return {name: results[id(picture)] for name, picture in pictures.items()}


def _check_views(views: Mapping[str, npt.ArrayLike], side: int) -> dict[str, Floats]:
    if not views or not set(views) <= set(AXES):
        raise ValueError(f"views {sorted(views)}: give at least one of xy, xz and yz")
    for name, view in views.items():
        check_picture(view, f"view {name}")
    given = {name: views[name] for name in AXES if name in views}
    pictures: dict[str, Floats] = apply_once(partial(np.asarray, dtype=np.float64), given)
    channels = {name: each.shape[2] for name, each in pictures.items()}
    if len(set(channels.values())) > 1:
        raise ValueError(f"views with {channels} channels: give as many in each")
    for name, each in pictures.items():
        if min(each.shape[:2]) < _MARGIN * side:
            raise ValueError(
                f"view {name} of {each.shape[1]} x {each.shape[0]} pixels: its crops of {side} x {side} would all be "
                f"the same or nearly; give a larger picture, or a block of at most {int(min(each.shape[:2]) / _MARGIN)}"
            )
        if np.ptp(each, axis=(0, 1)).max() == 0:
            raise ValueError(f"view {name}: is all of one colour; give a picture of a texture")
    if side < 4:
        raise ValueError(f"side: {side} voxels are too few; give at least 4")
    return pictures


def _decorrelate(pixels: Floats) -> tuple[Floats, Floats]:
    """The mean colour, and principal axes as columns."""
    mean = pixels.mean(axis=0)
    centred = pixels - mean
    _, axes = np.linalg.eigh(centred.T @ centred)
    axes = axes[:, ::-1]
    largest = np.take_along_axis(axes, np.abs(axes).argmax(axis=0)[None], axis=0)
    return mean, axes * np.sign(largest)


def _make_palette(pixels: Floats, mean: Floats, axis: Floats) -> Palette:
    """The mean colours of pixels [pixel, channel] of like value along an axis [channel, 1].

    Only how far they are off the axis is averaged over neighbouring values, as the axis itself is known: at the ends,
    where neighbours are on one side, colours would draw inwards. Where no value is near, what is off is interpolated.
    """
    values = (pixels - mean) @ axis
    off = pixels - mean - values @ axis.T
    levels = np.linspace(values.min(), values.max(), _LEVELS)
    number = np.rint((values[:, 0] - levels[0]) / (levels[-1] - levels[0]) * (_LEVELS - 1)).astype(int)
    sums = np.stack([np.bincount(number, each, _LEVELS) for each in (np.ones(len(off)), *off.T)], axis=1)
    weight, *totals = gaussian_filter1d(sums, _SMOOTH, axis=0, mode="constant").T
    near = np.flatnonzero(weight > 0)
    tints = np.stack([np.interp(np.arange(_LEVELS), near, each[near] / weight[near]) for each in totals], axis=1)
    return Palette(levels, mean + levels[:, None] * axis.T + tints)


def _histograms_apart(views: list[Floats]) -> float:
    """The largest distance of two views' histograms, as a share of the range of the channel that varies most."""
    shares = (np.arange(1024) + 0.5) / 1024
    quantiles = [np.quantile(each.reshape(-1, each.shape[2]), shares, axis=0) for each in views]
    span = np.ptp(np.concatenate([each.reshape(-1, each.shape[2]) for each in views]), axis=0).max()
    distances = [np.abs(a - b).mean(axis=0).max() / span for a, b in itertools.combinations(quantiles, 2)]
    return float(max(distances, default=0.0))


def _share_histogram(views: dict[str, Floats]) -> dict[str, Floats]:
    """Views whose values are moved, in order, to the mean of their quantiles: the distribution nearest to all."""
    tables = np.mean([quantile_table(each.reshape(-1, each.shape[2]).T) for each in views.values()], axis=0)
    tables = jnp.asarray(tables, jnp.float32)

    def match(picture: Floats) -> Floats:
        values = jnp.asarray(np.moveaxis(picture, -1, 0), jnp.float32)
        moved = [match_histogram(channel, table) for channel, table in zip(values, tables, strict=True)]
        return np.stack(moved, axis=-1).astype(np.float64)

    return apply_once(match, views)


def _spread_corners(shape: tuple[int, ...], side: int, count: int, key: Array) -> npt.NDArray[np.int_]:
    """Where crops begin, (row, col): one at random in each cell of a grid over all that there are."""
    across = int(np.ceil(np.sqrt(count)))
    cells = np.stack(np.divmod(np.arange(across**2), across), axis=1)
    order = np.asarray(jax.random.permutation(jax.random.fold_in(key, 0), across**2))[:count]
    jitter = np.asarray(jax.random.uniform(jax.random.fold_in(key, 1), (count, 2)))
    span = np.array(shape[:2]) - side + 1
    return np.minimum((cells[order] + jitter) / across * span, span - 1).astype(int)
