"""Fields that options name: numbers, pictures of numbers, files of keys."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

from jaxtex.cli.values import naming
from jaxtex.core.errors import InputError

if TYPE_CHECKING:
    import numpy as np

    from jaxtex.progressive.key_files import FieldKind

LEAST_SCALE, MOST_SCALE = 0.125, 16.0
"""How many times as large as in the exemplar things can be made."""


def read_fields(
    scale: str | None, orientation: str | None, keys: Path | None, size: tuple[int, int]
) -> tuple["np.ndarray", "np.ndarray"]:
    """Scale [row, col] and orientation (x, y), [row, col, 2], of a picture.

    Args:
        scale, orientation: what the user typed for --scale and --orientation: a number (degrees), or a picture of
            numbers, which is stretched over the picture. Where nothing tells one of them, it is 1, or 0 degrees.
        keys: a file of keys of either or both.
        size: (width, height) of the picture.

    Raises:
        InputError: a file that cannot be read or holds no such field, scales that are out of range, or something told
            twice; the message names the option or the file of keys.
    """
    from jaxtex.progressive.fields import orientation_field, scale_field
    from jaxtex.progressive.key_files import make_field, read_keys

    given = None if keys is None else read_keys(keys)
    options: dict[FieldKind, str | None] = {"scale": scale, "orientation": orientation}
    told = [name for name in options if given is not None and len(getattr(given, name))]
    if given is not None and not told:
        raise InputError(f"{keys}: has no keys of scale or orientation; give one at least")
    for name in told:
        if options[name] is not None:
            raise InputError(f"--{name}: {keys} tells it already; leave out one of them")
    with naming(keys):
        fields = {name: make_field(given, name, size) for name in told if given is not None}
    if "scale" not in fields:
        values = _read_scale(scale or "1")
        with naming(f"--scale: {scale}"):
            fields["scale"] = scale_field(values, size)
    if "orientation" not in fields:
        directions = _read_orientation(orientation or "0")
        with naming(f"--orientation: {orientation}"):
            fields["orientation"] = orientation_field(directions, size)
    if has_extreme_scales(fields["scale"]):
        least, most = fields["scale"].min(), fields["scale"].max()
        source = f"{keys}: scale" if "scale" in told else f"--scale: {scale}"
        raise InputError(f"{source} goes from {least:g} to {most:g}; give values from {LEAST_SCALE} to {MOST_SCALE:g}")
    return fields["scale"], fields["orientation"]


def has_extreme_scales(scale: "np.ndarray") -> bool:
    """Whether there are scales at which nothing is made."""
    return bool(scale.min() < LEAST_SCALE or scale.max() > MOST_SCALE)


def read_numbers(option: str, path: Path, *, advice: str = "") -> "np.ndarray":
    """The numbers of a picture that are no colours and may be beyond 0 to 1, [row, col, channel].

    Args:
        option: the option's name, for the complaint.
        path: the picture.
        advice: what else can be done with a picture of whole numbers.

    Raises:
        InputError: as `read_image`; or the file holds whole numbers, which can only stand for 0 to 1.
    """
    from jaxtex.io.images import read_image
    from jaxtex.io.raster import read_raster

    if read_raster(path).integer:
        raise InputError(
            f"{option}: {path} holds levels, from 0 (black) to 1 (white), and no numbers of any size; give an .exr of "
            f"such{advice}"
        )
    return read_image(path, colour_space="data").pixels


def _read_scale(word: str) -> "np.ndarray":
    """A number, or those in a picture, [row, col]."""
    import numpy as np

    scale = _number(word)
    if scale is None:
        values = _read_map("--scale", word, ", low = 0.5, high = 2")
        if np.ptp(values, axis=2).any():
            raise InputError(f"--scale: {word} has several channels that differ; give a picture of one")
        return values[..., 0]
    if not LEAST_SCALE <= scale <= MOST_SCALE:
        raise InputError(f"--scale: {scale:g} is out of range; give {LEAST_SCALE} to {MOST_SCALE:g}")
    return np.full((1, 1), scale)


def _read_orientation(word: str) -> "np.ndarray":
    """Degrees, or the directions in a picture, [row, col, (x, y)]."""
    import numpy as np

    degrees = _number(word)
    if degrees is None:
        values = _read_map("--orientation", word)
        if values.shape[2] < 2:
            raise InputError(f"--orientation: {word} has one channel; give a picture whose first two are x and y")
        return values[..., :2]
    if not np.isfinite(degrees):
        raise InputError(f"--orientation: {degrees:g} is no direction; give degrees")
    angle = np.radians(degrees)
    return np.array([[[np.cos(angle), np.sin(angle)]]])


def _number(word: str) -> float | None:
    try:
        return float(word)
    except ValueError:
        return None


def _read_map(option: str, word: str, levels: str = "") -> "np.ndarray":
    """A picture of numbers; of other pictures, a file of keys can say what `levels` stand for."""
    path = Path(word)
    if not path.suffix:
        raise InputError(f"{option}: '{word}' is neither a number nor a picture")
    # One line, which is TOML as it stands; names in it are taken from the folder of the file.
    table = f"{option.removeprefix('--')} = [{{map = {json.dumps(word, ensure_ascii=False)}{levels}}}]"
    advice = (
        ", as 'jaxtex field' makes, or say what it stands for, at the top of a file of keys (--keys) in the folder "
        f"where you are: {table}"
    )
    return read_numbers(option, path, advice=advice)
