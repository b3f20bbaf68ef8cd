"""`jaxtex mix`: a mixture of models as a file that names them."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

if TYPE_CHECKING:
    from jaxtex.models.mixture_files import MixtureFile


@dataclass(frozen=True, kw_only=True)
class Mix:
    """Mix materials: wood inside the tiles of a tiling, parts of the photograph kept as they are, other models where a
    mask is white. The result is a small file that names its parts; 'jaxtex render', 'jaxtex export' and 'jaxtex info'
    open it like any model.

    A mask as large as the photograph that the model was fitted to lies over that photograph, however it is turned or
    seen in perspective, and goes on beyond its border as it is there; a mask of any other size is stretched over the
    maps. White shows the layer, black what is below. Later layers lie over earlier ones, and kept parts of the
    photograph over all of them.

    Example: jaxtex mix tiles/model.json -o parquet.json --wood oak/model.json --wood-scale 0.5

    Example: jaxtex mix wall/model.json -o hall.json --layer low.png=tiles/model.json --keep door.png=wall.jpg
    """

    model: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="MODEL")]
    """The model file of what lies below, as 'jaxtex fit' writes it."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"], metavar="FILE")]
    """The file to write: .json. It names the others relative to its own folder."""
    wood: Annotated[Path | None, tyro.conf.arg(metavar="MODEL", help_behavior_hint="")] = None
    """Tilings: a model of wood, of which each tile is cut, its grain along the tile's longer side."""
    wood_scale: Annotated[float | None, tyro.conf.arg(metavar="S", help_behavior_hint="")] = None
    """How many times as large as in its photograph the wood is, against the tiling in its own. By default 1."""
    keep: Annotated[tuple[str, ...], tyro.conf.arg(metavar="MASK=PHOTO [...]", help_behavior_hint="")] = ()
    """Keep what the photograph shows where the mask is white: a picture, a door, a letter box. The photograph is that
    of MODEL, and the mask is painted over it."""
    layer: Annotated[tuple[str, ...], tyro.conf.arg(metavar="MASK=MODEL[@S] [...]", help_behavior_hint="")] = ()
    """Show another model where the mask is white; with @S, S times as large as in its photograph. Where a tiling or
    wood ends, it goes on; a floor is enlarged if it does not reach."""

    def run(self) -> int:
        from jaxtex.core.errors import InputError
        from jaxtex.io.files import place_for_file

        if self.wood is None and self.wood_scale is not None:
            raise InputError("--wood-scale: there is no wood; name a model of it by --wood")
        if self.wood is None and not self.keep and not self.layer:
            raise InputError("nothing is mixed; give --wood, --layer or --keep")
        if self.output.suffix != ".json":
            raise InputError(f"{self.output}: is no name of a mixture; end it in .json")
        file = self._mixture()

        from jaxtex.cli.mixture_maps import read_parts
        from jaxtex.models.files import save_model

        read_parts(place_for_file(self.output), file)  # whatever is wrong with them is told now
        save_model(self.output, file)
        count = len(file.layers)
        layers = f"{count} layer{'s' * (count > 1)} over it" if count else ""
        told = " and ".join(part for part in ("wood in its tiles" if file.wood else "", layers) if part)
        print(f"{self.output}: {self.model} with {told}")
        return 0

    def _mixture(self) -> "MixtureFile":
        from jaxtex.models.mixture_files import MixedWood, MixtureFile, ModelLayer, PhotographLayer, name_beside

        def name(part: Path | str) -> str:
            return name_beside(self.output, part)

        scale = 1.0 if self.wood_scale is None else _check_scale("--wood-scale", self.wood_scale)
        models = [(mask, *_parse_scale("--layer", model)) for mask, model in _parse_pairs("--layer", self.layer)]
        kept = _parse_pairs("--keep", self.keep)
        return MixtureFile(
            base=name(self.model),
            wood=None if self.wood is None else MixedWood(name(self.wood), scale),
            layers=(
                *(ModelLayer(name(mask), name(model), times) for mask, model, times in models),
                *(PhotographLayer(name(mask), name(photo)) for mask, photo in kept),
            ),
        )


def _parse_pairs(option: str, words: Sequence[str]) -> list[tuple[str, str]]:
    from jaxtex.core.errors import InputError

    pairs = []
    for word in words:
        mask, _, other = word.partition("=")
        if not mask or not other:
            wanted = "MASK=PHOTO" if option == "--keep" else "MASK=MODEL"
            raise InputError(f"{option}: '{word}' does not name two files; write {wanted}, without spaces")
        pairs.append((mask, other))
    return pairs


def _parse_scale(option: str, word: str) -> tuple[str, float]:
    """The name of a file and the scale in words such as model.json@0.5."""
    match = re.fullmatch(r"(.+)@([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)", word, re.IGNORECASE)
    return (match[1], _check_scale(option, float(match[2]))) if match else (word, 1.0)


def _check_scale(option: str, scale: float) -> float:
    from jaxtex.core.errors import InputError

    if not (math.isfinite(scale) and scale > 0):
        raise InputError(f"{option}: {scale:g} is no scale; give a number above 0")
    return scale
