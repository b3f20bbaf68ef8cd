"""Every method of synthesis in one form, with its default settings: to be compared with the others.

Heeger and Bergen's textures are made of noise; those of all other methods are pixels of the exemplar, and a source map
tells which.
"""

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.core.pyramids import most_scales
from jaxtex.synthesis.ashikhmin import synthesise_ashikhmin
from jaxtex.synthesis.coherence import synthesise_coherence
from jaxtex.synthesis.efros_leung import synthesise_efros_leung
from jaxtex.synthesis.heeger_bergen import analyse_texture, synthesise_texture
from jaxtex.synthesis.neighbourhoods import Shape
from jaxtex.synthesis.quilting import synthesise_quilting
from jaxtex.synthesis.sources import Sources, copy_sources
from jaxtex.synthesis.wei_levoy import synthesise_wei_levoy

_SCALES = 4


class Texture(NamedTuple):
    """What a method makes.

    Attributes:
        pixels: float32 [row, col, channel], 0 to 1, encoded as the exemplar is.
        sources: where they are copied from, [row, col, 2]; None where they are not.
    """

    pixels: npt.NDArray[np.float32]
    sources: Sources | None


class Method(Protocol):
    """Makes a texture of a shape (rows, columns) like an exemplar.

    The exemplar is float [row, col, channel], 0 to 1, in an encoding whose steps look even. The method raises
    `ValueError` where it is too small.
    """

    def __call__(self, exemplar: npt.ArrayLike, shape: Shape, *, key: Array) -> Texture: ...


def _copying(synthesise: Callable[..., Sources | Array]) -> Method:
    def method(exemplar: npt.ArrayLike, shape: Shape, *, key: Array) -> Texture:
        sources = np.asarray(synthesise(exemplar, shape, key=key))
        return Texture(copy_sources(np.asarray(exemplar, np.float32), sources), sources)

    return method


def _match_histograms(exemplar: npt.ArrayLike, shape: Shape, *, key: Array) -> Texture:
    """Heeger and Bergen's method, with fewer scales where four do not fit; clipped, as a file would do."""
    pixels = np.asarray(exemplar, np.float32)
    scales = min(_SCALES, most_scales(pixels.shape[:2]), most_scales(shape))
    made = synthesise_texture(analyse_texture(pixels[None], scales=scales), shape, key=key)
    return Texture(np.clip(np.asarray(made), 0, 1), None)


METHODS: dict[str, Method] = {
    "coherence": _copying(synthesise_coherence),
    "ashikhmin": _copying(synthesise_ashikhmin),
    "wei-levoy": _copying(synthesise_wei_levoy),
    "efros-leung": _copying(synthesise_efros_leung),
    "quilting": _copying(synthesise_quilting),
    "heeger-bergen": _match_histograms,
}
