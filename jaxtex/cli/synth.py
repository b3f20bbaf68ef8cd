"""`jaxtex synth`: more of a texture, from a picture of it."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

Method = Literal["coherence", "ashikhmin", "wei-levoy", "efros-leung", "quilting", "heeger-bergen"]

# Options that only some methods take.
_GOES_WITH: dict[str, tuple[Method, ...]] = {
    "neighborhood": ("coherence", "ashikhmin", "wei-levoy", "efros-leung"),
    "block": ("quilting",),
    "tileable": ("coherence", "ashikhmin", "quilting", "heeger-bergen"),
    "similar": ("ashikhmin",),
    "levels": ("wei-levoy",),
    "search": ("wei-levoy",),
    "target": ("ashikhmin",),
    "passes": ("ashikhmin",),
    "guide": ("coherence",),
    "guide_weight": ("coherence",),
    "texton_mask": ("coherence",),
    "inpaint": ("coherence", "efros-leung"),
    "also": ("coherence", "ashikhmin", "wei-levoy", "efros-leung", "quilting"),
    "blend": ("coherence", "ashikhmin", "wei-levoy", "efros-leung", "quilting"),
    "preview": ("coherence", "ashikhmin", "efros-leung", "quilting"),
    "scales": ("heeger-bergen",),
    "orientations": ("heeger-bergen",),
    "iterations": ("heeger-bergen",),
    "finer": ("heeger-bergen",),
}


@dataclass(frozen=True, kw_only=True)
class Synth:
    """Make more of a texture from a picture of it, fill a hole in it, or lay it out as a guide or a painting says.

    Methods, and what they are good for:
    coherence: anything; the default. From coarse to fine, pieces of the exemplar are brought to meet. Tileable.
    ashikhmin: pebbles, leaves, flowers (Ashikhmin 2001); at once, and the way to follow a painted --target.
    quilting: square blocks, cut where they differ least (Efros and Freeman 2001); regular textures.
    wei-levoy: pixel by pixel by the most similar neighbourhood (Wei and Levoy 2000); smooth textures.
    efros-leung: grown from a seed (Efros and Leung 1999); slow.
    heeger-bergen: noise with the exemplar's distributions (Heeger and Bergen 1995); plaster, sand, fur. Tileable.

    Example: jaxtex synth pebbles.jpg -o more.png --size 512x512

    Example: jaxtex synth colour.png -o tile.png --also normal.png height.exr

    Example: jaxtex synth flowers.jpg -o meadow.png --method ashikhmin --target painting.png --passes 5

    Example: jaxtex synth peppers.jpg -o more.png --texton-mask peppers_mask.png

    Example: jaxtex synth wall.jpg -o repaired.png --inpaint hole.png
    """

    exemplar: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="EXEMPLAR")]
    """The picture of the texture, seen straight on and evenly lit."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The picture to write: .png, .jpg, .tif or .exr."""
    method: Method = "coherence"
    """How it is made."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WxH", help_behavior_hint="")] = None
    """Its size in pixels. By default that of the target or guide, or as much of the texture as the exemplar shows."""
    region: Annotated[
        tyro.conf.UseAppendAction[tuple[str, ...]], tyro.conf.arg(metavar="X,Y,WxH", help_behavior_hint="")
    ] = ()
    """A rectangle of the exemplar to learn from, its upper left corner and its size in pixels. By default the whole
    picture. heeger-bergen takes more than one, of one size: give the option again."""
    neighborhood: Annotated[int | None, tyro.conf.arg(help_behavior_hint="")] = None
    """Side of the squares of pixels that are compared, an odd number. By default 7 (coherence), 5 (ashikhmin), 9
    (wei-levoy), 11 (efros-leung)."""
    block: Annotated[int | None, tyro.conf.arg(help_behavior_hint="")] = None
    """quilting: side of its blocks in pixels. By default a quarter of the exemplar's shorter side, at most 104
    in colour."""
    tileable: bool = False
    """Make it repeat seamlessly; coherence and heeger-bergen always do."""
    similar: Annotated[int | None, tyro.conf.arg(help_behavior_hint="")] = None
    """ashikhmin: candidates that each neighbour brings: its continuation, and places that look like that. By default 1,
    as in the paper; more follow a target more closely, with less of the texture."""
    levels: Annotated[int | None, tyro.conf.arg(help_behavior_hint="")] = None
    """wei-levoy: number of resolutions, from coarse to fine. By default 1."""
    search: Annotated[Literal["full", "tree"] | None, tyro.conf.arg(help_behavior_hint="")] = None
    """wei-levoy: all of the exemplar, or quickly by tree-structured vector quantisation. By default full."""
    target: Annotated[Path | None, tyro.conf.arg(metavar="PICTURE", help_behavior_hint="")] = None
    """ashikhmin: what the result should look like from afar, painted in the exemplar's colours; transparent where it
    does not matter."""
    passes: Annotated[int | None, tyro.conf.arg(help_behavior_hint="")] = None
    """ashikhmin: how often all pixels are chosen anew; further passes come nearer to the target. By
    default 1."""
    guide: Annotated[tuple[Path, Path] | None, tyro.conf.arg(metavar="FROM TO", help_behavior_hint="")] = None
    """coherence: two pictures, one as large as the exemplar and one as large as the result; the exemplar is copied to
    where the second looks like the first."""
    guide_weight: Annotated[float | None, tyro.conf.arg(help_behavior_hint="")] = None
    """coherence: how much the guide counts, of what colours count: more follows it more closely, and repeats more. By
    default 0.5."""
    texton_mask: Annotated[Path | None, tyro.conf.arg(metavar="MASK", help_behavior_hint="")] = None
    """coherence: a mask of the exemplar's size that marks its elements (pebbles, leaves, ...), so that these do not
    break: two to four values, each for one type of element or the ground."""
    inpaint: Annotated[Path | None, tyro.conf.arg(metavar="MASK", help_behavior_hint="")] = None
    """coherence, efros-leung: fill the exemplar where this mask of its size is white, instead of making a new
    picture."""
    also: Annotated[tuple[Path, ...], tyro.conf.arg(metavar="MAP ...", help_behavior_hint="")] = ()
    """Other maps of the exemplar's material and size (normal, height, ...), of any depth. The same pixels are copied of
    each, to OUTPUT_MAP beside the output: tile.png and normal.png make tile_normal.png."""
    blend: Annotated[float | None, tyro.conf.arg(metavar="PIXELS", help_behavior_hint="")] = None
    """Soften seams between copied pieces over about this width, in the output alone. By default nothing is softened."""
    preview: Annotated[Path | None, tyro.conf.arg(metavar="FILE", help_behavior_hint="")] = None
    """A picture to write again after each pass, to be watched meanwhile."""
    scales: Annotated[int | None, tyro.conf.arg(help_behavior_hint="")] = None
    """heeger-bergen: octaves of detail, from fine to coarse, that are told apart by direction. By default 4."""
    orientations: Annotated[int | None, tyro.conf.arg(help_behavior_hint="")] = None
    """heeger-bergen: number of directions told apart. By default 4."""
    iterations: Annotated[int | None, tyro.conf.arg(help_behavior_hint="")] = None
    """heeger-bergen: how often pixels and detail are given the exemplar's distributions in turn. By default 5."""
    finer: Annotated[int | None, tyro.conf.arg(help_behavior_hint="")] = None
    """heeger-bergen: octaves of detail to add beyond the exemplar's resolution: with 1, what spans 10 pixels there
    spans 20 here. By default 0."""
    seed: int = 0
    """Another number, another piece of the texture."""

    def run(self) -> int:
        from jaxtex.cli.values import check_seed, parse_rectangle, parse_size

        check_seed(self.seed)
        self._check_options()
        size = None if self.size is None else parse_size("--size", self.size)
        rectangles = [parse_rectangle("--region", word) for word in self.region]
        if self.method == "heeger-bergen":
            from jaxtex.cli.synth_noise import make_of_noise

            return make_of_noise(self, size, rectangles)
        from jaxtex.cli.synth_copies import make_of_copies

        return make_of_copies(self, size, rectangles)

    def _check_options(self) -> None:
        from jaxtex.core.errors import InputError

        for option, methods in _GOES_WITH.items():
            given = getattr(self, option)
            if given is not None and given is not False and given != () and self.method not in methods:
                raise InputError(
                    f"--{option.replace('_', '-')}: goes with --method {' or '.join(methods)}, not with {self.method}"
                )
        inputs = {"the exemplar": self.exemplar, "the target": self.target, "the mask": self.inpaint}
        inputs["the texton mask"] = self.texton_mask
        inputs |= dict(zip(("the first of the guides", "the second of the guides"), self.guide or (), strict=False))
        for told, path in inputs.items():
            if path is not None and path.resolve() == self.output.resolve():
                raise InputError(f"--output: {path} is {told}, which would be written over; give another name")
