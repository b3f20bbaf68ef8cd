"""The maps of a model file, whatever its model."""

import dataclasses
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import jax

from jaxtex.cli.values import naming
from jaxtex.core.errors import InputError
from jaxtex.material.appearance import Appearance, appearance_of
from jaxtex.material.finish import finish_tiling, finish_wood
from jaxtex.material.floor import render_floor
from jaxtex.material.interior_files import interiors_of_planks, interiors_of_tiles
from jaxtex.material.maps import render_maps
from jaxtex.material.placement import Placement, over_photograph, over_picture, over_plank
from jaxtex.material.sheet import Sheet, lay_photographed_sheet
from jaxtex.material.tile_wood import Timber
from jaxtex.material.wood import render_wood
from jaxtex.models.files import ModelFile, TilingFile
from jaxtex.models.floor_files import FloorFile


class ModelMaps(NamedTuple):
    """Maps about to be rendered.

    Attributes:
        bands: some rows at a time, from the top.
        size: (width, height) in pixels.
        extent: (width, height) of what they show, in pixels of the photograph.
        shown: what they show, in words.
        seamless: whether they repeat without a seam.
        changes: what had to give way for that, or why they cannot, in words.
        placement: of the maps in the photograph; `jaxtex.material.placement`.
        face: how high faces of tiles or planks lie, in pixels of the photograph.
        ids: how many ids there are.
    """

    bands: Iterator[NamedTuple]
    size: tuple[int, int]
    extent: tuple[float, float]
    shown: str
    placement: Placement
    face: float = 0.0
    ids: int = 0
    seamless: bool = False
    changes: tuple[str, ...] = ()


class SheetOptions(NamedTuple):
    """What may be asked of the maps of a tiling.

    Attributes:
        tiles, seamless, seed: as `jaxtex render` has them.
        fill: whether tiles and joints are filled, where the file names interiors.
        finishes: names of finishes by structure.
        timber: what tiles are cut of, where they are to be of wood.
        sheet: laid already; otherwise the photograph's.
        seams_allowed: where no seamless maps can be made, to make others.
    """

    tiles: tuple[int, int] | None = None
    seamless: bool = False
    seed: int = 0
    seams_allowed: bool = False
    fill: bool = True
    finishes: Mapping[str, str] = MappingProxyType({})
    timber: Timber | None = None
    sheet: Sheet | None = None


def open_maps(
    source: Path,
    file: ModelFile,
    *,
    size: tuple[int, int] | None = None,
    longest: int | None = None,
    options: SheetOptions,
) -> ModelMaps:
    """Begin to render the maps of a model file: all is checked, and nothing rendered yet.

    Args:
        source: the model file, to name it in complaints.
        file: its content.
        size: (width, height) of the maps in pixels; None stands for the photograph's scale.
        longest: the longer side where no size is given, if the photograph's scale gives more.
        options: of tilings.

    Raises:
        InputError: there are no such maps.
    """
    if isinstance(file, TilingFile):
        return _open_tiling(source, file, size, longest, options)
    image = file.image.width, file.image.height
    size = size or _at_most(longest, image)
    finish = finish_wood(options.finishes)
    if isinstance(file, FloorFile):
        interiors = interiors_of_planks(source, file) if options.fill else None
        key = jax.random.key(options.seed)
        bands: Iterator[NamedTuple] = render_floor(
            file.planks, image=image, size=size, interiors=interiors, key=key, finish=finish
        )
        placement, planks = over_picture(image, size=size), len(file.planks)
        return ModelMaps(bands, size, image, f"{planks} planks", placement, ids=planks)
    bands = render_wood(file.wood, across=image[0], size=size, finish=finish)
    extent = image[0], image[0] * size[1] / size[0]
    return ModelMaps(bands, size, extent, "wood", over_plank(image, size=size))


def refuse(source: Path, options: Mapping[str, object], what: str) -> None:
    """Refuse options that the model has no use for.

    Args:
        source: the model file.
        options: by name; None stands for one that was not given.
        what: the kind of model, in words.

    Raises:
        InputError: one was given.
    """
    given = next((option for option, value in options.items() if value is not None), None)
    if given:
        raise InputError(f"{given}: {source} is a model of {what}")


def _open_tiling(
    source: Path, file: TilingFile, size: tuple[int, int] | None, longest: int | None, options: SheetOptions
) -> ModelMaps:
    timber = options.timber
    with naming(source):
        appearance = appearance_of(file)
        if timber is not None:
            appearance = dataclasses.replace(appearance, tile_specular=0.5, tile_metallic=0.0)  # as wood has it
            timber = timber._replace(bare="tile" not in options.finishes)
        appearance = finish_tiling(appearance, options.finishes)
    sheet, reasons = _lay(file, appearance, options)
    size = size or _at_most(longest, sheet.natural_size)
    interiors = interiors_of_tiles(source, file) if options.fill else None
    key = jax.random.key(options.seed)
    image = file.image.width, file.image.height
    return ModelMaps(
        render_maps(sheet, appearance, interiors=interiors, size=size, key=key, timber=timber),
        size,
        (sheet.width, sheet.height),
        f"{sheet.columns:g} x {sheet.rows} tiles" + ("" if timber is None else " of wood"),
        over_photograph(sheet, file.tiling, image=image, size=size),
        face=appearance.joint_depth,
        ids=int(sheet.table().identity.max()) + 1,
        seamless=sheet.seamless,
        changes=sheet.changes + reasons,
    )


def _lay(file: TilingFile, appearance: Appearance, options: SheetOptions) -> tuple[Sheet, tuple[str, ...]]:
    """The sheet, and why it is not seamless although it should be."""
    if options.sheet is not None:
        return options.sheet, ()
    lay = partial(lay_photographed_sheet, file, tiles=options.tiles, pattern=appearance.pattern)
    try:
        return lay(seamless=options.seamless), ()
    except InputError as error:
        if not (options.seamless and options.seams_allowed):
            raise
        return lay(seamless=False), (str(error).partition(";")[0],)


def _at_most(longest: int | None, size: tuple[int, int]) -> tuple[int, int]:
    """A size, or one of about the same ratio whose longer side is the longest allowed."""
    if longest is None or max(size) <= longest:
        return size
    width, height = (max(1, round(side * longest / max(size))) for side in size)
    return width, height
