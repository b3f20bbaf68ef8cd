"""jaxtex: pictures of a material become something a person can control, by differentiable models in JAX.

The way of the data, one package per step::

    photograph -> photo    (mask: 1 = tile, 0 = joint)
               -> fitting  (start by FFT and scanlines, refined by least squares)
               -> models   (differentiable; evaluated at a point)
               -> material (base colour, height, normal, roughness, ids at any resolution)
               -> io       (files)

`core` holds the mathematics they share, and `cli` puts them on the command line (`jaxtex --help`). All public names are
flat: `import jaxtex as jt`, then `jt.read_image(...)`. Importing the package is quick: a name brings in its module, and
JAX with it, only when it is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jaxtex.core.errors import InputError as InputError
    from jaxtex.io.images import Image as Image
    from jaxtex.io.images import read_image as read_image
    from jaxtex.io.images import write_image as write_image
    from jaxtex.io.masks import read_mask as read_mask
    from jaxtex.io.masks import write_mask as write_mask

__version__ = "0.1.0"

# Public name -> module that defines it. A name added here is also added to the block for type checkers above;
# tests/test_public.py holds the two to one another.
_PUBLIC = {
    "InputError": "jaxtex.core.errors",
    "Image": "jaxtex.io.images",
    "read_image": "jaxtex.io.images",
    "read_mask": "jaxtex.io.masks",
    "write_image": "jaxtex.io.images",
    "write_mask": "jaxtex.io.masks",
}

__all__ = ["__version__", *_PUBLIC]


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'jaxtex' has no attribute {name!r}")
    value = getattr(import_module(_PUBLIC[name]), name)
    globals()[name] = value  # the next look-up finds it without coming here
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_PUBLIC})
