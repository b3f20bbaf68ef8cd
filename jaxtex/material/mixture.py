"""Several materials in one: painted masks choose where each is seen (Lefebvre & Poulin 2000, sections 4.3 and 4.4)."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.material.bands import BAND
from jaxtex.material.maps import Maps
from jaxtex.material.placement import Placement, look_at_picture

_ROUGHNESS = 0.7  # of what is kept of a photograph, which does not tell
# What stands for maps that a material has not, as textures have it: `jaxtex.material.packing`.
_PLAIN = {"specular": 0.5, "metallic": 0.0, "occlusion": 1.0, "tile_id": -1.0}


class Seen(NamedTuple):
    """Some rows of a layer.

    Attributes:
        share: how much of each pixel it covers, 0 to 1, [row, col].
        maps: of the layer.
    """

    share: npt.NDArray[np.float32]
    maps: Maps


def mix_maps(base: Iterable[NamedTuple], layers: Sequence[Iterator[Seen]]) -> Iterator[Maps]:
    """Lay layers over maps, some rows at a time from top to bottom.

    Where a layer covers a part of a pixel, all maps are mixed linearly, normals brought back to unit length; the id is
    that of what covers more than half. Memory is that of a band of each.

    Args:
        base: maps as renderers give them; what they have not is as it is of plain materials, ids are -1.
        layers: from below, as `layer_maps` and `keep_photograph` make them.

    Examples:
        >>> grey = Maps(*(np.full((2, 3, *more), 0.5, np.float32) for more in [(3,), (), (3,), (), (), (), (), ()]))
        >>> painted = keep_photograph(np.ones((2, 3, 3)), np.eye(2, 3), np.eye(3), size=(3, 2), height=0.5)
        >>> next(mix_maps([grey], [painted])).base_colour[..., 0]
        array([[1. , 0.5, 0.5],
               [0.5, 1. , 0.5]], dtype=float32)
    """
    for band, *above in zip(base, *layers, strict=True):
        mixed = _complete(band)
        for layer in above:
            mixed = _lay_over(mixed, layer)
        yield mixed


def layer_maps(
    bands: Iterator[NamedTuple],
    mask: npt.NDArray[np.float32],
    placement: Placement,
    *,
    size: tuple[int, int],
    scale: float = 1.0,
    lift: float = 0.0,
    first_id: int = 0,
) -> Iterator[Seen]:
    """A layer of a material.

    Args:
        bands: its maps, as large as those it lies over or larger; what is beyond them is cut off.
        mask: [row, col], 1 where it is seen; beyond its border it goes on as it is there.
        placement: of the maps in the mask.
        size: (width, height) of the maps.
        scale: what heights are multiplied by.
        lift: what is added to them then.
        first_id: what is added to ids.
    """
    for rows, band in zip(_bands_of(size), bands, strict=False):
        cropped = type(band)(*(each[: len(rows), : size[0]] for each in band))
        maps = _complete(cropped)
        share = look_at_picture(mask[..., None], placement, rows=rows, width=size[0], goes_on=True)[..., 0]
        identity = np.where(maps.tile_id >= 0, maps.tile_id + first_id, maps.tile_id)
        yield Seen(share, maps._replace(height=scale * maps.height + np.float32(lift), tile_id=identity))


def keep_photograph(
    pixels: npt.NDArray[np.floating],
    mask: npt.NDArray[np.floating],
    placement: Placement,
    *,
    size: tuple[int, int],
    height: float,
) -> Iterator[Seen]:
    """A layer of what a photograph shows, as a texture of colours: flat, dull, without ids.

    Args:
        pixels: linear light, [row, col, 1 or 3].
        mask: [row, col] of the photograph, 1 where it is kept.
        placement: of the maps in the photograph.
        size: (width, height) of the maps.
        height: at which it lies.

    Raises:
        InputError: the mask is not as large as the photograph.
    """
    if mask.shape != pixels.shape[:2]:
        told = f"{pixels.shape[1]} x {pixels.shape[0]}"
        raise InputError(f"the mask is {mask.shape[1]} x {mask.shape[0]} pixels, and the photograph is {told}")
    colour = np.broadcast_to(pixels, (*mask.shape, 3))
    # Colours times the mask, so that what is not kept adds nothing to what is seen along the mask's edges.
    kept = np.concatenate([colour * mask[..., None], mask[..., None]], axis=-1).astype(np.float32)
    return _keep(kept, placement, size, height)


def _keep(kept: npt.NDArray[np.float32], placement: Placement, size: tuple[int, int], height: float) -> Iterator[Seen]:
    for rows in _bands_of(size):
        seen = look_at_picture(kept, placement, rows=rows, width=size[0])
        share = seen[..., 3]
        fill = {name: np.full(share.shape, value, np.float32) for name, value in _PLAIN.items()}
        maps = Maps(
            base_colour=(seen[..., :3] / np.maximum(share, 1e-6)[..., None]).astype(np.float32),
            height=np.full(share.shape, height, np.float32),
            normal=np.broadcast_to(np.array([0, 0, 1], np.float32), (*share.shape, 3)),
            roughness=np.full(share.shape, _ROUGHNESS, np.float32),
            **fill,
        )
        yield Seen(share, maps)


def _lay_over(below: Maps, layer: Seen) -> Maps:
    share, above = layer.share, layer.maps

    def mix(one: npt.NDArray[np.float32], other: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        part = share.reshape(*share.shape, *[1] * (one.ndim - 2))
        mixed: npt.NDArray[np.float32] = (1 - part) * one + part * other
        return mixed

    mixed = Maps(*map(mix, below, above))
    length = np.sqrt(np.sum(mixed.normal**2, axis=-1, keepdims=True))
    partly = ((share > 0) & (share < 1))[..., None]
    return mixed._replace(
        normal=np.where(partly, mixed.normal / np.maximum(length, 1e-6), mixed.normal),
        tile_id=np.where(share > 0.5, above.tile_id, below.tile_id),
    )


def _complete(band: NamedTuple) -> Maps:
    """All maps of a band, with plain ones for those it has not."""
    given: dict[str, Any] = band._asdict()
    plain = {name: np.full(given["height"].shape, value, np.float32) for name, value in _PLAIN.items()}
    return Maps(**(plain | given))


def _bands_of(size: tuple[int, int]) -> Iterator[range]:
    """The rows of each band of maps of a size (width, height)."""
    return (range(first, min(first + BAND, size[1])) for first in range(0, size[1], BAND))
