"""What the commands of `jaxtex vary` have in common."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from jaxtex.core.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from jax import Array

    from jaxtex.progressive.varying import VaryingTexture

_LEAST_SIDE = 16  # pixels of what is made
_LEAST_MEMORY = 400  # bytes that each of its pixels takes
_MOST_PIXELS = 1 << 22  # of a picture that is learnt from or made: more take gigabytes, and an hour


def read_exemplar(path: Path, side: int) -> "np.ndarray":
    """Linear light, [row, col, channel].

    Args:
        path: the picture.
        side: of the squares of pixels that are compared in it.

    Raises:
        InputError: as `read_image`; or it is partly transparent, smaller than such a square, or too large.
    """
    from jaxtex.io.images import read_image

    image = read_image(path)
    if image.alpha is not None and image.alpha.min() < 1:
        raise InputError(f"{path}: is partly transparent; fill its ground with a colour")
    if min(image.width, image.height) < side:
        raise InputError(
            f"{path}: is {image.width} x {image.height} pixels, and neighborhoods are {side} x {side}; give a larger "
            "picture, or a smaller --neighborhood"
        )
    if image.width * image.height > _MOST_PIXELS:
        raise InputError(f"{path}: has more than {_MOST_PIXELS >> 20} megapixels; shrink it, or cut a part out")
    return image.pixels


def read_mask_of(mask: Path, exemplar: Path, pixels: "np.ndarray") -> "np.ndarray":
    """The texton mask of an exemplar.

    Raises:
        InputError: as `read_texton_mask`; or its size is not that of the exemplar's pixels.
    """
    from jaxtex.progressive.texton_masks import read_texton_mask

    labels = read_texton_mask(mask)
    if labels.shape != pixels.shape[:2]:
        told = f"{labels.shape[1]} x {labels.shape[0]} pixels, and {exemplar} {pixels.shape[1]} x {pixels.shape[0]}"
        raise InputError(f"{mask}: is {told}; give a mask of its size")
    return labels


def read_transition(transition: Path | None, keys: Path | None, size: tuple[int, int]) -> "np.ndarray":
    """The transition function of a picture, [row, col], 0 to 1: from a map, from keys, or from left to right.

    Args:
        transition: a grey picture, stretched over it.
        keys: a file of keys.
        size: (width, height) of the picture.

    Raises:
        InputError: both are given, or one that cannot be read or holds no transition.
    """
    import numpy as np

    if transition is not None and keys is not None:
        raise InputError("--keys: tells the transition already; leave out --transition")
    if keys is not None:
        from jaxtex.cli.values import naming
        from jaxtex.progressive.key_files import make_field, read_keys

        read = read_keys(keys)
        if not len(read.transition):
            raise InputError(f"{keys}: has no keys of transition; give one at least")
        with naming(keys):
            return np.asarray(make_field(read, "transition", size))
    if transition is None:
        return np.broadcast_to(np.linspace(0, 1, size[0], dtype=np.float32), size[::-1])
    from jaxtex.io.images import read_image
    from jaxtex.progressive.fields import transition_field

    values = read_image(transition, colour_space="data").pixels
    if np.ptp(values, axis=2).max() > 0.02 or values.min() < 0 or values.max() > 1:
        raise InputError(f"{transition}: is no transition; give a grey picture with values from 0 (black) to 1 (white)")
    return np.asarray(transition_field(values[..., 0], size))


def parse_made_size(word: str) -> tuple[int, int]:
    """The (width, height) of --size.

    Raises:
        InputError: it is none, or out of range.
    """
    from jaxtex.cli.values import check_memory, parse_size

    width, height = parse_size("--size", word)
    if min(width, height) < _LEAST_SIDE or width * height > _MOST_PIXELS:
        raise InputError(
            f"--size: {width}x{height} is out of range; give {_LEAST_SIDE} pixels or more along each side, and at most "
            f"{_MOST_PIXELS >> 20} megapixels"
        )
    check_memory(f"--size: {width}x{height}", _LEAST_MEMORY * width * height)
    return width, height


def lay_out(what: str, exemplar: "np.ndarray", mask: "np.ndarray", size: tuple[int, int], key: "Array") -> "np.ndarray":
    """An exemplar's mask at the size (width, height) of what is made, with a progress bar."""
    from jaxtex.cli.progress import reporting
    from jaxtex.cli.synth_methods import encode
    from jaxtex.progressive.blending import lay_out_mask

    with reporting(what) as report:
        return lay_out_mask(encode(exemplar, None), mask, size[::-1], key=key, report=report)


def filter_exemplar(
    what: str, exemplar: "np.ndarray", mask: "np.ndarray", wanted: "np.ndarray", key: "Array", radius: int
) -> "np.ndarray":
    """The sources of a filtered mask, with a progress bar, of an exemplar in linear light."""
    from jaxtex.cli.progress import reporting
    from jaxtex.cli.synth_methods import encode
    from jaxtex.progressive.filtering import filter_mask_steps

    with reporting(what) as report:
        for step in filter_mask_steps(encode(exemplar, None), mask, wanted, key=key, radius=radius):
            report(step.done, step.total)
    return step.sources


def write_results(output: Path, varying: "VaryingTexture", *, save: Path | None, mask: Path | None) -> None:
    """Write the picture and, where they are asked for, the texture with its fields, and its mask; all or none."""
    from collections.abc import Callable

    from jaxtex.cli.files import write_together
    from jaxtex.io.images import write_image
    from jaxtex.progressive.texton_masks import write_texton_mask
    from jaxtex.progressive.varying import write_varying

    writers: dict[Path, Callable[[Path], None]] = {output: lambda path: write_image(path, varying.texture)}
    if save is not None:
        writers[save] = lambda path: write_varying(path, varying)
    if mask is not None:
        writers[mask] = lambda path: write_texton_mask(path, varying.mask)
    write_together(writers)
    print(f"{output}: {varying.texture.shape[1]} x {varying.texture.shape[0]} pixels")
    if save is not None:
        print(f"{save}: texture, mask and transition")
    if mask is not None:
        print(f"{mask}: its mask")


def check_files(
    inputs: Sequence[Path | None], pictures: Sequence[Path | None], save: Path | None, keys: Path | None
) -> None:
    """Refuse files that cannot be written, before work that takes long.

    Args:
        inputs: files that are read.
        pictures: image files to write; None where an option is not given.
        save: the file of the texture with its fields.
        keys: a file of keys, if it is read.

    Raises:
        InputError: as `check_names`; or a picture's extension is of no kind that can be written.
    """
    from jaxtex.cli.files import check_names
    from jaxtex.io.images import check_image_name

    check_names(inputs, [*pictures, save], keys=keys)
    for picture in pictures:
        if picture is not None:
            check_image_name(picture)


def check_neighborhood(side: int) -> int:
    """The radius of squares of pixels that are compared.

    Raises:
        InputError: the side is none that is taken.
    """
    if side not in range(3, 22, 2):
        raise InputError(f"--neighborhood: {side} is none; give an odd number from 3 to 21, as 5 or 7")
    return side // 2
