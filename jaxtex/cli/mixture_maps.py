"""The maps of a mixture of models: its parts found, read and checked, then laid over each other."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from jaxtex.cli.model_maps import ModelMaps, SheetOptions, open_maps, refuse
from jaxtex.core.errors import InputError
from jaxtex.io.images import read_image
from jaxtex.io.masks import read_mask
from jaxtex.material.mixture import Seen, keep_photograph, layer_maps, mix_maps
from jaxtex.material.placement import Placement, over_picture
from jaxtex.material.tile_wood import Timber
from jaxtex.material.wood import render_wood
from jaxtex.models.files import ModelFile, TilingFile, load_model
from jaxtex.models.floor_files import FloorFile
from jaxtex.models.mixture_files import MixtureFile, ModelLayer, find_part
from jaxtex.models.wood_files import WoodFile


class Layer(NamedTuple):
    """What lies over the base.

    Attributes:
        mask: [row, col], 1 where it is seen.
        source: its file.
        scale: as `ModelLayer` has it.
        file: of a model; None where it is the base's photograph.
        pixels: of the photograph, linear light; None where it is a model.
    """

    mask: npt.NDArray[np.float32]
    source: Path
    scale: float = 1.0
    file: ModelFile | None = None
    pixels: npt.NDArray[np.float32] | None = None


class Parts(NamedTuple):
    """What a mixture is made of.

    Attributes:
        source: the base's file.
        base: its content.
        timber: what the base's tiles are cut of.
        layers: over it, from below.
    """

    source: Path
    base: ModelFile
    timber: Timber | None
    layers: tuple[Layer, ...]

    def doubts(self) -> Iterator[tuple[Path, str]]:
        """The files of models whose fits did not succeed, and why."""
        models = [(self.source, self.base), *((layer.source, layer.file) for layer in self.layers)]
        for source, file in models:
            if file is not None and not file.report["ok"]:
                yield source, file.report["reason"]


def read_parts(source: Path, file: MixtureFile) -> Parts:
    """Read all that a mixture names.

    Args:
        source: the mixture's file.
        file: its content.

    Raises:
        InputError: a part is missing or of the wrong kind, a mask shows nothing of its layer, or parts do not fit.
    """
    missing = next((name for name in file.names() if not find_part(source, name).exists()), None)
    if missing is not None:
        raise InputError(f"{find_part(source, missing)}: there is no such file, and {source} is made of it")
    path = find_part(source, file.base)
    base = load_model(path)
    layers = []
    for layer in file.layers:
        mask = _read_mask(find_part(source, layer.mask))
        if isinstance(layer, ModelLayer):
            part = find_part(source, layer.model)
            layers.append(Layer(mask, part, layer.scale, file=load_model(part)))
        else:
            part = find_part(source, layer.photograph)
            layers.append(Layer(mask, part, pixels=_read_photograph(part, base, mask)))
    return Parts(path, base, _read_timber(source, file, path, base), tuple(layers))


def open_mixture(
    source: Path,
    parts: Parts,
    *,
    size: tuple[int, int] | None = None,
    longest: int | None = None,
    options: SheetOptions,
) -> ModelMaps:
    """Begin to render the maps of a mixture: all is checked, and nothing rendered yet.

    Layers have pixels as large as the base's: a pixel of a layer's photograph is as long as `scale` of the base's, or
    as much as the two models' scales in millimetres say, times `scale`. What is smaller than the base is continued:
    tilings and wood go on, floors are enlarged. Faces of tiles and planks lie level. Ids of a layer follow those below.

    Args:
        source: the mixture's file, to name it in complaints.
        parts: what it is made of.
        size, longest, options: as `jaxtex.cli.model_maps.open_maps` takes them.

    Raises:
        InputError: there are no such maps.
    """
    reason = "masks do not repeat"
    if not isinstance(parts.base, TilingFile):
        seamless = options.seamless and not options.seams_allowed
        asked = {"--tiles": options.tiles, "--seamless": seamless or None, "--finish": options.finishes or None}
        refuse(source, asked, "a mixture whose base has no tiles")
    seams = bool(parts.layers) and options.seamless and isinstance(parts.base, TilingFile)
    if seams and not options.seams_allowed:
        raise InputError(f"--seamless: {source} has layers, and their {reason}; leave it out")
    below = options._replace(seamless=options.seamless and not parts.layers, timber=parts.timber)
    base = open_maps(parts.source, parts.base, size=size, longest=longest, options=below)
    if not parts.layers:
        return base
    laid, ids = [], base.ids
    for layer in parts.layers:
        shown, more = _lay(layer, parts.base, base, options, ids)
        laid.append(shown)
        ids += more
    told = f"{base.shown} and {len(laid)} layer{'s' * (len(laid) > 1)}"
    changes = (reason,) if seams else ()
    return base._replace(bands=mix_maps(base.bands, laid), shown=told, ids=ids, changes=base.changes + changes)


def _lay(
    layer: Layer, below: ModelFile, base: ModelMaps, options: SheetOptions, first_id: int
) -> tuple[Iterator[Seen], int]:
    """A layer over the base's maps, and how many ids it has."""
    placement = _place(layer.mask, below, base)
    if layer.file is None:
        assert layer.pixels is not None
        return keep_photograph(layer.pixels, layer.mask, placement, size=base.size, height=base.face), 0
    scale = layer.scale * _relative_scale(below, layer.file)
    pixel = [extent / pixels / scale for extent, pixels in zip(base.extent, base.size, strict=True)]
    maps, enlarged = _continue_maps(layer, (pixel[0], pixel[1]), base.size, options)
    scale *= enlarged
    lift = base.face - scale * maps.face
    over = layer_maps(maps.bands, layer.mask, placement, size=base.size, scale=scale, lift=lift, first_id=first_id)
    return over, maps.ids


def _place(mask: npt.NDArray[np.float32], below: ModelFile, base: ModelMaps) -> Placement:
    """Of the base's maps in a mask: one as large as the photograph lies over it, any other is stretched over maps."""
    shape = mask.shape[1], mask.shape[0]
    return base.placement if shape == (below.image.width, below.image.height) else over_picture(shape, size=base.size)


def _relative_scale(below: ModelFile, file: ModelFile) -> float:
    """Pixels of the base's photograph to a pixel of the layer's, as far as both models know how large they are."""
    own, other = (getattr(each, "mm_per_px", None) for each in (file, below))
    return float(own / other) if own and other else 1.0


def _continue_maps(
    layer: Layer, pixel: tuple[float, float], size: tuple[int, int], options: SheetOptions
) -> tuple[ModelMaps, float]:
    """Maps of a layer that are at least of a size, and how much they had to be enlarged for that.

    Args:
        pixel: breadth and height of a pixel in pixels of the layer's photograph.
    """
    file = layer.file
    assert file is not None
    extent = pixel[0] * size[0], pixel[1] * size[1]
    plain = SheetOptions(seed=options.seed, fill=options.fill)
    try:
        if isinstance(file, WoodFile):
            bands = render_wood(file.wood, across=extent[0], size=size)
            return ModelMaps(bands, size, extent, "wood", np.eye(3)), 1.0
        if isinstance(file, FloorFile):
            image = file.image.width, file.image.height
            enlarged = max(1.0, *(wanted / there for wanted, there in zip(extent, image, strict=True)))
            at = _pixels(image, (pixel[0] / enlarged, pixel[1] / enlarged))
            return open_maps(layer.source, file, size=at, options=plain), enlarged
        length = float(file.tiling.tile_width) * float(np.mean(file.tiling.course_lengths))
        pitch = length, float(file.tiling.tile_height)
        tiles = _pixels(extent, pitch)
        at = _pixels((tiles[0] * pitch[0], tiles[1] * pitch[1]), pixel)
        return open_maps(layer.source, file, size=at, options=plain._replace(tiles=tiles)), 1.0
    except InputError as error:
        told = str(error).removeprefix(f"{layer.source}: ")
        raise InputError(f"{layer.source}: as a layer, {told}") from None


def _pixels(extent: tuple[float, float], pixel: tuple[float, float]) -> tuple[int, int]:
    """How many pixels cover an extent; what rounding adds is not one more."""
    across, along = (max(1, math.ceil(length / step - 1e-6)) for length, step in zip(extent, pixel, strict=True))
    return across, along


def _read_mask(path: Path) -> npt.NDArray[np.float32]:
    mask = read_mask(path)
    if not mask.max() > 0:
        raise InputError(f"{path}: is black everywhere, so that nothing of its layer is seen; paint white where it is")
    return mask


def _read_photograph(path: Path, base: ModelFile, mask: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    photo, fitted = read_image(path), (base.image.width, base.image.height)
    if (photo.width, photo.height) != fitted:
        told = f"{photo.width} x {photo.height} pixels, and the base was fitted to {fitted[0]} x {fitted[1]}"
        raise InputError(f"{path}: is {told}; name the photograph it was fitted to")
    if mask.shape != photo.pixels.shape[:2]:
        told = f"{mask.shape[1]} x {mask.shape[0]} pixels, and not {fitted[0]} x {fitted[1]} as the photograph"
        raise InputError(f"{path}: its mask is {told}; paint the mask over the photograph")
    return np.clip(photo.pixels, 0, 1)


def _read_timber(source: Path, file: MixtureFile, path: Path, base: ModelFile) -> Timber | None:
    if file.wood is None:
        return None
    if not isinstance(base, TilingFile):
        raise InputError(f"{path}: has no tiles that wood could be inside of; name a model of a tiling, or no wood")
    part = find_part(source, file.wood.model)
    wood = load_model(part)
    if not isinstance(wood, WoodFile):
        raise InputError(f"{part}: is no model of wood; fit one by jaxtex fit wood")
    return Timber(wood.wood, (wood.image.width, wood.image.height), file.wood.scale)
