"""`jaxtex vary blend`: a texture that becomes another, elements and colours together."""

import math
import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from jaxtex.cli.hints import hint
from jaxtex.core.errors import InputError

if TYPE_CHECKING:
    import numpy as np

_DARKEST = 1e-3  # of weights that are summed up
_LIKE = 8.0  # times as large as those of another texture: elements that still turn into these one by one
_CLEAR = 5.0  # steps of CIE Lab lightness by which elements are clearly lighter or darker than what is around them


@dataclass(frozen=True, kw_only=True)
class VaryBlend:
    """Make a texture that goes over from one to another, or to several one after the other, in the shapes of its
    elements and in their colours.

    A mask between the exemplars' texton masks (see 'jaxtex texton-mask') is made; each exemplar is laid out again by
    that mask, and then colours are blended (Zhang et al. 2003, section 4.3). So elements of all lie in the same places,
    and none shines through another. By default the first is at the left and the last at the right.

    Example: jaxtex vary blend spots.png stripes.png -o coat.png --masks spots_mask.png stripes_mask.png --size 512x128

    Example: jaxtex vary blend red.jpg yellow.jpg -o peppers.png --masks r.png y.png --keys ripe.toml --save peppers.npz

    Example: jaxtex vary blend a.png b.png c.png -o abc.png --masks ma.png mb.png mc.png --weights wa.png wb.png wc.png
    """

    exemplars: Annotated[
        tuple[Path, ...],
        tyro.conf.Positional,
        tyro.conf.arg(metavar="EXEMPLAR EXEMPLAR [...]", help_behavior_hint="(required)"),
    ]
    """Pictures of the textures, two or more."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The picture to write: .png, .jpg, .tif or .exr."""
    masks: Annotated[tuple[Path, ...], tyro.conf.arg(metavar="MASK MASK [...]")]
    """Their texton masks, in the same order: each of its exemplar's size, all with the same types of elements. Elements
    of one become elements of the next; where these are dark in one and light in the other, contrast is lost halfway,
    and where they have more than 8 times the area in one, clear elements are."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WxH", help_behavior_hint="")] = None
    """Its size in pixels. By default that of the smallest exemplar."""
    transition: Annotated[Path | None, tyro.conf.arg(metavar="PICTURE", help_behavior_hint="")] = None
    """Where which texture is: a grey picture, from black for the first to white for the last, stretched over the
    result. It should be smooth."""
    keys: Annotated[Path | None, tyro.conf.arg(metavar="KEYS.toml", help_behavior_hint="")] = None
    """Keys of the transition, as 'jaxtex field' takes them, instead of a picture."""
    weights: Annotated[tuple[Path, ...], tyro.conf.arg(metavar="PICTURE ...", help_behavior_hint="")] = ()
    """One grey picture for each texture instead of a transition: how much there is of it where, beside the others."""
    neighborhood: int = 7
    """Side of the squares of pixels that are compared, an odd number."""
    mask_output: Annotated[Path | None, tyro.conf.arg(metavar="FILE", help_behavior_hint="")] = None
    """Write the mask of the blend, too."""
    save: Annotated[Path | None, tyro.conf.arg(metavar="V.npz", help_behavior_hint="")] = None
    """Write the texture with its mask and transition, as synthesis on meshes reads it."""
    seed: int = 0
    """Another number, other pieces of the textures."""

    def run(self) -> int:
        from jaxtex.cli import varying
        from jaxtex.cli.values import check_seed

        check_seed(self.seed)
        radius = varying.check_neighborhood(self.neighborhood)
        self._check()
        inputs = [*self.exemplars, *self.masks, *self.weights, self.transition]
        varying.check_files(inputs, [self.output, self.mask_output], self.save, self.keys)
        pictures = [varying.read_exemplar(each, self.neighborhood) for each in self.exemplars]
        if len({each.shape[2] for each in pictures}) > 1:
            pictures = [each.repeat(3 // each.shape[2], axis=2) for each in pictures]
        masks = [varying.read_mask_of(*each) for each in zip(self.masks, self.exemplars, pictures, strict=True)]
        self._check_types(masks)
        smallest = min(each.shape[1] for each in pictures), min(each.shape[0] for each in pictures)
        size = smallest if self.size is None else varying.parse_made_size(self.size)
        weights = self._read_weights(size)
        self._hint_contrasts(pictures, masks)
        self._hint_areas(masks)
        texture, mask = self._blend(pictures, masks, weights, radius)

        import numpy as np

        from jaxtex.progressive.varying import VaryingTexture

        far = np.einsum("nrc,n->rc", weights, np.linspace(0, 1, len(weights), dtype=np.float32))
        made = VaryingTexture.of(texture, mask=mask, transition=np.clip(far, 0, 1))
        varying.write_results(self.output, made, save=self.save, mask=self.mask_output)
        return 0

    def _check(self) -> None:
        count = len(self.exemplars)
        if count < 2:
            raise InputError(f"{count} exemplars are no blend; give two or more")
        if len(self.masks) != count:
            raise InputError(f"--masks: {len(self.masks)} for {count} exemplars; give one for each, in the same order")
        if self.weights and len(self.weights) != count:
            raise InputError(f"--weights: {len(self.weights)} for {count} exemplars; give one for each")
        if self.weights and (self.transition is not None or self.keys is not None):
            raise InputError("--weights: tell all that a transition does; leave out --transition and --keys")

    def _check_types(self, masks: list["np.ndarray"]) -> None:
        import numpy as np

        types = [np.unique(each).tolist() for each in masks]
        for path, each in zip(self.masks[1:], types[1:], strict=True):
            if each != types[0]:
                raise InputError(f"{path}: has types {each}, and {self.masks[0]} {types[0]}; give them the same types")

    def _hint_areas(self, masks: list["np.ndarray"]) -> None:
        """Tell of elements that are much larger in one texture than in another: halfway they are clusters."""
        from jaxtex.progressive.mask_measures import measure_element_area

        kinds = range(1, int(masks[0].max()) + 1)
        for kind in kinds:
            found = [measure_element_area(each, kind) for each in masks]
            told = [each for each in found if each]
            if told and max(told) > _LIKE * min(told):
                small, large = found.index(min(told)), found.index(max(told))
                part = math.sqrt(found[small] / found[large])
                what = "elements" if len(kinds) == 1 else f"elements of type {kind}"
                hint(
                    f"{what} of {self.masks[large]} have some {found[large]:.0f} pixels and those of "
                    f"{self.masks[small]} {found[small]:.0f}, so there are no clear ones halfway; scale one exemplar "
                    f"and its mask first, {self.exemplars[large]} to {part:.0%} or {self.exemplars[small]} to "
                    f"{1 / part:.0%}"
                )
                return

    def _hint_contrasts(self, pictures: list["np.ndarray"], masks: list["np.ndarray"]) -> None:
        """Tell of elements that are dark in one texture and light in another: halfway they look like their ground."""
        from jaxtex.progressive.mask_measures import measure_contrast

        contrasts = [measure_contrast(*each) for each in zip(pictures, masks, strict=True)]
        dark, light = contrasts.index(min(contrasts)), contrasts.index(max(contrasts))
        if contrasts[dark] < -_CLEAR and contrasts[light] > _CLEAR:
            told = (
                f"elements are darker than what is around them in {self.exemplars[dark]} and lighter in "
                f"{self.exemplars[light]}, so they fade halfway"
            )
            if masks[dark].max() == 1:  # of more types, inverting would leave one
                name, mask = self.exemplars[dark], self.masks[dark]
                other = mask.with_name(f"{mask.stem}_inverted.png")
                words = shlex.join(["jaxtex", "texton-mask", f"{name}", "--painted", f"{mask}", "--invert"])
                told += f"; if a mask marks gaps, turn it round, as by: {words} -o {shlex.quote(str(other))}"
            hint(told)

    def _read_weights(self, size: tuple[int, int]) -> "np.ndarray":
        """[texture, row, col]."""
        import numpy as np

        from jaxtex.cli.varying import read_transition
        from jaxtex.progressive.blending import transition_weights

        if not self.weights:
            return transition_weights(read_transition(self.transition, self.keys, size), len(self.exemplars))
        shares = np.stack([read_transition(each, None, size) for each in self.weights])
        total = shares.sum(axis=0)
        if total.min() < _DARKEST:
            raise InputError("--weights: are all black in one place; let one at least be brighter there")
        return shares / total[None]

    def _blend(
        self, pictures: list["np.ndarray"], masks: list["np.ndarray"], weights: "np.ndarray", radius: int
    ) -> tuple["np.ndarray", "np.ndarray"]:
        """The texture in linear light, and its mask."""
        import jax
        import numpy as np

        from jaxtex.cli.synth_methods import encode, white_of
        from jaxtex.cli.varying import filter_exemplar, lay_out
        from jaxtex.core.colour import srgb_to_linear
        from jaxtex.progressive.blending import Blend, blend_masks

        size = weights.shape[2], weights.shape[1]
        keys = jax.random.split(jax.random.key(self.seed), (len(pictures), 2))
        white = white_of(*pictures)
        encoded = [encode(each, None, white=white) for each in pictures]
        laid = [
            lay_out(f"making more of {path}", picture, mask, size, own[0])
            for path, picture, mask, own in zip(self.masks, pictures, masks, keys, strict=True)
        ]
        between = blend_masks(laid, weights)
        sources = [
            filter_exemplar(f"laying out {path}", picture, mask, between, own[1], radius)
            for path, picture, mask, own in zip(self.exemplars, pictures, masks, keys, strict=True)
        ]
        shown = Blend(between, sources, weights).show(encoded)
        return srgb_to_linear(np.maximum(shown, 0) * white), between
