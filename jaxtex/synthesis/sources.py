"""Source maps: which pixel of the exemplar each pixel of a synthesised texture is copied from.

Synthesis that copies returns such a map, int32 [row, col, 2] of (row, col) in the exemplar, and no colours. So every
other map of the same material (normal, height, at any bit depth) follows the one that was looked at.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Sources = npt.NDArray[np.int32]


class Step(NamedTuple):
    """How far synthesis is.

    Attributes:
        done, total: steps; they take about equally long.
        sources: the source map so far.
    """

    done: int
    total: int
    sources: Sources


def last_of(steps: Iterator[Step]) -> Sources:
    """The source map that the last of some steps leaves."""
    *_, last = steps
    return last.sources


def magnify_places(
    places: npt.NDArray[np.int32], columns: int, octaves: int, shape: tuple[int, int], exemplar: tuple[int, int]
) -> Sources:
    """The source map at full resolution that goes with places at a coarser one.

    Args:
        places: of the exemplar at that resolution, numbered row * columns + column, [row, col].
        columns: of the exemplar there.
        octaves: by how many the resolution is coarser; sides are halved and rounded up.
        shape: (rows, columns) of the source map.
        exemplar: (rows, columns) of the exemplar at full resolution.
    """
    coarse = np.stack(np.divmod(places, np.int32(columns)), axis=-1)
    row, column = np.indices(shape, np.int32)
    fine = np.stack([row, column], axis=-1) % 2**octaves
    return np.minimum(
        coarse[row >> octaves, column >> octaves] * 2**octaves + fine, np.array(exemplar, np.int32) - 1
    ).astype(np.int32)


def copy_sources(picture: npt.ArrayLike, sources: npt.ArrayLike) -> npt.NDArray[Any]:
    """What a source map copies.

    Args:
        picture: [row, col, ...] of any type: the exemplar, or another map of the same material.
        sources: [row, col, 2].

    Raises:
        ValueError: the source map is of another form, or leads outside of the picture.

    Examples:
        >>> copy_sources([[1, 2], [3, 4]], [[[0, 1], [1, 1], [0, 0]]])
        array([[2, 4, 1]])
    """
    pixels, places = np.asarray(picture), np.asarray(sources)
    if places.ndim != 3 or places.shape[2] != 2 or not np.issubdtype(places.dtype, np.integer):
        raise ValueError(f"sources of shape {places.shape} and type {places.dtype}: give whole numbers [row, col, 2]")
    if pixels.ndim < 2 or ((places < 0) | (places >= pixels.shape[:2])).any():
        raise ValueError(f"sources lead outside of a picture of shape {pixels.shape}")
    return pixels[places[..., 0], places[..., 1]]


def blend_seams(
    picture: npt.ArrayLike, sources: npt.ArrayLike, *, width: float = 1.0, repeats: bool = True
) -> npt.NDArray[np.floating]:
    """The same with soft seams: a pixel is the mean of what the pieces around it would show there.

    Each neighbour votes for the pixel of the exemplar that continues its own piece, with a Gaussian weight. Inside of
    a piece all votes are for one pixel, which is copied as it stands; M. Ashikhmin ("Synthesizing natural textures",
    I3D 2001, section 5) suggests to blur seams alone.

    Args:
        picture, sources: of `copy_sources`; the picture of floats.
        width: standard deviation of the weight, in pixels.
        repeats: whether the texture goes on at the opposite border; beyond its borders are no votes otherwise.

    Raises:
        ValueError: as `copy_sources`; a width that is not above 0.
    """
    pixels, places = np.asarray(picture), np.asarray(sources)
    if not width > 0:
        raise ValueError(f"width: {width} is not above 0")
    total = np.zeros_like(copy_sources(pixels, places), dtype=np.result_type(pixels, np.float32))
    weights = np.zeros(places.shape[:2], total.dtype)
    reach = int(np.ceil(2 * width))
    rows, columns = np.ogrid[: places.shape[0], : places.shape[1]]
    for down in range(-reach, reach + 1):
        for right in range(-reach, reach + 1):
            votes = np.add(np.roll(places, (down, right), axis=(0, 1)), [down, right])
            inside = ((votes >= 0) & (votes < pixels.shape[:2])).all(axis=2)
            if not repeats:
                inside &= (rows - down >= 0) & (rows - down < len(rows))
                inside &= (columns - right >= 0) & (columns - right < columns.size)
            weight = np.where(inside, np.exp(-(down**2 + right**2) / (2 * width**2)), 0).astype(total.dtype)
            votes = np.where(inside[..., None], votes, 0)
            total += weight.reshape(*weight.shape, *[1] * (total.ndim - 2)) * pixels[votes[..., 0], votes[..., 1]]
            weights += weight
    return total / weights.reshape(*weights.shape, *[1] * (total.ndim - 2))
