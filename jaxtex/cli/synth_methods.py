"""The methods of `jaxtex synth` that copy pixels, started with what the user gave."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from jaxtex.core.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from jax import Array

    from jaxtex.cli.synth import Synth
    from jaxtex.synthesis.sources import Step

_NEIGHBORHOODS = {"coherence": 7, "ashikhmin": 5, "wei-levoy": 9, "efros-leung": 11}
_LEAST_NEIGHBORHOOD = 3
_MOST_PIXELS = 1 << 23  # take some 6 GB
_MOST_PLACES = 1 << 20  # that are all compared with every pixel: more take gigabytes, and hours


def start_method(
    options: "Synth", exemplar: "np.ndarray", white: float, size: tuple[int, int] | None, key: "Array"
) -> Iterator["Step"]:
    """The method's steps, none of them done yet.

    Args:
        options: of the command, their numbers checked.
        exemplar: [row, col, channel], encoded.
        white: the encoded value that is 1 there.
        size: (width, height), if the user gave one.
        key: random key.

    Raises:
        InputError: pictures whose sizes do not go together, or with the method.
    """
    height, width = exemplar.shape[:2]
    side = options.neighborhood or _NEIGHBORHOODS.get(options.method, 0)
    if min(width, height) < side:
        smaller = ", or a smaller odd --neighborhood" if min(width, height) >= _LEAST_NEIGHBORHOOD else ""
        raise InputError(
            f"{options.exemplar}: what is learnt from is {width} x {height} pixels, and neighborhoods are {side} x "
            f"{side}; give a larger picture{smaller}"
        )
    if width * height > _MOST_PIXELS:
        raise InputError(
            f"{options.exemplar}: {width} x {height} pixels are too many to learn from; give at most "
            f"{_MOST_PIXELS >> 20} megapixels, shrunk or as a --region"
        )
    exhaustive = options.method in ("wei-levoy", "efros-leung") or (options.similar or 1) > 1
    if exhaustive and width * height > _MOST_PLACES:
        option = "--similar" if options.method == "ashikhmin" else f"--method {options.method}"
        raise InputError(
            f"{option}: compares with every pixel of what is learnt from, and {width} x {height} are too many; give at "
            "most 1024 x 1024, shrunk or as a --region, or take --method coherence"
        )
    if options.inpaint is not None:
        return _start_inpainting(options, options.inpaint, exemplar, side // 2, key)
    if options.method == "ashikhmin":
        return _start_ashikhmin(options, exemplar, white, size, side // 2, key)
    if options.method == "coherence":
        return _start_coherence(options, exemplar, size, side // 2, key)
    shape = (size[1], size[0]) if size else (height, width)
    if options.method == "quilting":
        return _start_quilting(options, exemplar, shape, key)
    if options.method == "efros-leung":
        from jaxtex.synthesis.efros_leung import efros_leung_steps

        return efros_leung_steps(exemplar, shape, key=key, radius=side // 2)
    return _start_wei_levoy(options, exemplar, shape, side // 2, key)


def encode(pixels: "np.ndarray", alpha: "np.ndarray | None", *, white: float | None = None) -> "np.ndarray":
    """Values of about even visibility, 0 to 1, of pictures of any range; transparent pixels are all alike.

    What `white` encodes becomes 1: unless given, the picture's own.
    """
    import numpy as np

    from jaxtex.core.colour import linear_to_srgb

    encoded = linear_to_srgb(np.maximum(pixels, 0)) / (white or white_of(pixels))
    if alpha is None or alpha.min() == 1:
        return encoded.astype(np.float32)
    cover = alpha[..., None]
    return np.concatenate([encoded * cover, cover], axis=2).astype(np.float32)


def white_of(*pictures: "np.ndarray") -> float:
    """The largest encoded value of pictures in linear light, at least 1."""
    from jaxtex.core.colour import linear_to_srgb

    return max(1.0, *(float(linear_to_srgb(each.max())) for each in pictures))


def _start_coherence(
    options: "Synth", exemplar: "np.ndarray", size: tuple[int, int] | None, radius: int, key: "Array"
) -> Iterator["Step"]:
    from jaxtex.io.images import read_image
    from jaxtex.synthesis.coherence import coherence_steps
    from jaxtex.synthesis.guides import GUIDE_WEIGHT

    if options.texton_mask is not None:
        return _start_masked(options.texton_mask, exemplar, _shape_of(size, exemplar), radius, key)
    if options.guide is None:
        return coherence_steps(exemplar, _shape_of(size, exemplar), key=key, radius=radius)
    guides = [read_image(path) for path in options.guide]
    both = white_of(*(image.pixels for image in guides))
    ours, theirs = (encode(image.pixels, image.alpha, white=both) for image in guides)
    if ours.shape[:2] != exemplar.shape[:2]:
        raise InputError(f"--guide: {options.guide[0]} is {_told(ours)} pixels, and the exemplar is {_told(exemplar)}")
    if ours.shape[2] != theirs.shape[2]:
        raise InputError(
            f"--guide: one of {options.guide[0]} and {options.guide[1]} is grey or transparent; make both alike"
        )
    _check_size("--guide", options.guide[1], theirs, size)
    return coherence_steps(
        exemplar,
        theirs.shape[:2],
        key=key,
        radius=radius,
        guides=(ours, theirs),
        guide_weight=options.guide_weight or GUIDE_WEIGHT,
    )


def _start_masked(
    path: Path, exemplar: "np.ndarray", shape: tuple[int, int], radius: int, key: "Array"
) -> Iterator["Step"]:
    from jaxtex.progressive.masked import masked_steps
    from jaxtex.progressive.texton_masks import read_texton_mask

    mask = read_texton_mask(path, (exemplar.shape[1], exemplar.shape[0]))
    return masked_steps(exemplar, mask, shape, key=key, radius=radius)


def _start_ashikhmin(
    options: "Synth", exemplar: "np.ndarray", white: float, size: tuple[int, int] | None, radius: int, key: "Array"
) -> Iterator["Step"]:
    from jaxtex.synthesis.ashikhmin import ashikhmin_steps
    from jaxtex.synthesis.nearest import find_similar

    count = options.similar or 1
    similar = find_similar(exemplar, radius=radius, count=count) if count > 1 else None
    shape, target, painted = _shape_of(size, exemplar), None, None
    if options.target is not None:
        target, painted = _read_target(options.target, exemplar, white)
        _check_size("--target", options.target, target, size)
        shape = target.shape[:2]
    return ashikhmin_steps(
        exemplar,
        shape,
        key=key,
        radius=radius,
        similar=similar,
        tileable=options.tileable,
        target=target,
        painted=painted,
        passes=options.passes or 1,
    )


def _start_quilting(options: "Synth", exemplar: "np.ndarray", shape: tuple[int, int], key: "Array") -> Iterator["Step"]:
    from jaxtex.synthesis.quilting import quilting_steps

    try:
        return quilting_steps(exemplar, shape, key=key, block=options.block, tileable=options.tileable)
    except ValueError as error:
        raise InputError(str(error) if options.block is None else f"--block: {error}") from None


def _start_wei_levoy(
    options: "Synth", exemplar: "np.ndarray", shape: tuple[int, int], radius: int, key: "Array"
) -> Iterator["Step"]:
    from jaxtex.synthesis.wei_levoy import wei_levoy_steps

    try:
        return wei_levoy_steps(
            exemplar, shape, key=key, radius=radius, levels=options.levels or 1, search=options.search or "full"
        )
    except ValueError as error:
        raise InputError(str(error) if options.levels is None else f"--levels: {error}") from None


def _start_inpainting(
    options: "Synth", mask: Path, exemplar: "np.ndarray", radius: int, key: "Array"
) -> Iterator["Step"]:
    from jaxtex.io.masks import read_mask
    from jaxtex.synthesis.coherence import inpaint_steps
    from jaxtex.synthesis.efros_leung import efros_leung_steps

    hole = read_mask(mask) >= 0.5
    if hole.shape != exemplar.shape[:2]:
        raise InputError(f"--inpaint: {mask} is {_told(hole)} pixels, and the picture is {_told(exemplar)}")
    if hole.all() or not hole.any():
        colour = "white" if hole.all() else "black"
        raise InputError(f"--inpaint: {mask} is all {colour}; paint what is to be filled white, and the rest black")
    try:
        if options.method == "coherence":
            return inpaint_steps(exemplar, hole, key=key, radius=radius)
        return efros_leung_steps(
            exemplar, hole.shape, key=key, radius=radius, picture=exemplar, known=~hole, usable=~hole
        )
    except ValueError as error:
        raise InputError(f"--inpaint: {mask}: {error}") from None


def _read_target(path: Path, exemplar: "np.ndarray", white: float) -> tuple["np.ndarray", "np.ndarray"]:
    """The painting in the exemplar's channels, and where it is painted."""
    import numpy as np

    from jaxtex.io.images import read_image

    image = read_image(path)
    painted = np.ones((image.height, image.width), bool) if image.alpha is None else image.alpha >= 0.5
    target = np.minimum(encode(image.pixels, None, white=white), 1)
    channels = exemplar.shape[2]
    if channels in (2, 4):
        raise InputError("--target: goes with an opaque exemplar; save the exemplar without its transparency")
    if target.shape[2] > channels:
        raise InputError(
            f"--target: {path} is coloured, and the exemplar is grey; paint in grey, or give a coloured one"
        )
    return np.broadcast_to(target, (*target.shape[:2], channels)), painted


def _shape_of(size: tuple[int, int] | None, exemplar: "np.ndarray") -> tuple[int, int]:
    return (size[1], size[0]) if size else (exemplar.shape[0], exemplar.shape[1])


def _check_size(option: str, path: Path, picture: "np.ndarray", size: tuple[int, int] | None) -> None:
    if size is not None and picture.shape[:2] != (size[1], size[0]):
        raise InputError(
            f"{option}: {path} is {_told(picture)} pixels, and --size is {size[0]}x{size[1]}; leave --size out, or "
            "give one size"
        )


def _told(picture: "np.ndarray") -> str:
    return f"{picture.shape[1]} x {picture.shape[0]}"
