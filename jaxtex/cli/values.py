"""Words on the command line that stand for more than one number: points, sizes, colours."""

import os
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from jaxtex.core.errors import InputError

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)"
_COUNT = r"0*([1-9]\d{0,8})"


def parse_point(option: str, word: str) -> tuple[float, float]:
    """Read "x,y" in pixels.

    Args:
        option: the option's name, for the complaint.
        word: what the user typed.

    Raises:
        InputError: it is not two numbers with a comma between.

    Examples:
        >>> parse_point("--at", "12.5,40")
        (12.5, 40.0)
    """
    match = re.fullmatch(rf"\s*({_NUMBER})\s*,\s*({_NUMBER})\s*", word)
    if not match:
        raise InputError(f"{option}: '{word}' is no point; write x,y in pixels, as in 120,64.5")
    return float(match[1]), float(match[2])


def parse_pick(option: str, word: str) -> tuple[tuple[float, float], float, int]:
    """Read "x,y", "x,y:tolerance" or "x,y:tolerance:type" of a colour picked.

    Args:
        option: the option's name, for the complaint.
        word: what the user typed.

    Returns:
        the point in pixels, the tolerance in Lab (12 unless given), and the type (1 unless given).

    Raises:
        InputError: it is none of these.

    Examples:
        >>> parse_pick("--pick", "12.5,40:8")
        ((12.5, 40.0), 8.0, 1)
    """
    match = re.fullmatch(rf"([^:]*)(?::\s*({_NUMBER})\s*(?::\s*([1-3])\s*)?)?", word)
    if not match:
        raise InputError(
            f"{option}: '{word}' is no pick; write x,y:tolerance:type in pixels, Lab and 1 to 3, as in 40,31:12:1"
        )
    return parse_point(option, match[1]), float(match[2] or 12), int(match[3] or 1)


def parse_vector(option: str, word: str) -> tuple[float, float, float]:
    """Read "x,y,z" in voxels.

    Args:
        option: the option's name, for the complaint.
        word: what the user typed.

    Raises:
        InputError: it is not three numbers with commas between.

    Examples:
        >>> parse_vector("--across", "0.5,0,-1")
        (0.5, 0.0, -1.0)
    """
    match = re.fullmatch(rf"\s*({_NUMBER})\s*,\s*({_NUMBER})\s*,\s*({_NUMBER})\s*", word)
    if not match:
        raise InputError(f"{option}: '{word}' is no vector; write x,y,z in voxels, as in 0.7,0,-0.7")
    return float(match[1]), float(match[2]), float(match[3])


def parse_size(option: str, word: str) -> tuple[int, int]:
    """Read "WxH" in pixels as (width, height).

    Args:
        option: the option's name, for the complaint.
        word: what the user typed.

    Raises:
        InputError: it is not two whole numbers of 1 or more with an x between.

    Examples:
        >>> parse_size("--size", "1024x768")
        (1024, 768)
    """
    match = re.fullmatch(rf"\s*{_COUNT}\s*[x×]\s*{_COUNT}\s*", word, re.IGNORECASE)
    if not match:
        raise InputError(f"{option}: '{word}' is no size; write WIDTHxHEIGHT in pixels, as in 1024x768")
    return int(match[1]), int(match[2])


def parse_counts(option: str, word: str, what: str) -> tuple[int, int]:
    """Read "CxR": how many stand side by side, and one above the other.

    Args:
        option: the option's name, for the complaint.
        word: what the user typed.
        what: of what, in the plural.

    Raises:
        InputError: it is not two whole numbers of 1 or more with an x between.

    Examples:
        >>> parse_counts("--tiles", "12x20", "tiles")
        (12, 20)
    """
    try:
        return parse_size(option, word)
    except InputError:
        raise InputError(f"{option}: '{word}' is no number of {what}; write COLUMNSxROWS, as in 12x20") from None


def parse_block(option: str, word: str) -> tuple[int, int, int]:
    """Read "DxHxW" in voxels as (depth, height, width).

    Args:
        option: the option's name, for the complaint.
        word: what the user typed.

    Raises:
        InputError: it is not three whole numbers of 1 or more with an x between.

    Examples:
        >>> parse_block("--block", "64x128x256")
        (64, 128, 256)
    """
    match = re.fullmatch(rf"\s*{_COUNT}\s*[x×]\s*{_COUNT}\s*[x×]\s*{_COUNT}\s*", word, re.IGNORECASE)
    if not match:
        raise InputError(f"{option}: '{word}' is no block; write DEPTHxHEIGHTxWIDTH in voxels, as in 256x256x256")
    return int(match[1]), int(match[2]), int(match[3])


def parse_rectangle(option: str, word: str) -> tuple[float, float, float, float]:
    """Read "X,Y,WxH" in pixels as (x, y, width, height): the upper left corner, and the size.

    Args:
        option: the option's name, for the complaint.
        word: what the user typed.

    Raises:
        InputError: the word is no such rectangle, or an empty one.

    Examples:
        >>> parse_rectangle("--region", "10,20.5,64x32")
        (10.0, 20.5, 64.0, 32.0)
    """
    number = r"\s*([-+]?(?:\d+\.?\d*|\.\d+))\s*"
    match = re.fullmatch(f"{number},{number},{number}[x×]{number}", word, re.IGNORECASE)
    if not match:
        raise InputError(f"{option}: '{word}' is no rectangle; write X,Y,WxH in pixels, such as 120,80,64x32")
    x, y, width, height = map(float, match.groups())
    if min(width, height) <= 0:
        raise InputError(f"{option}: '{word}' is empty; width and height must be more than 0")
    return x, y, width, height


def cut_rectangle(
    option: str, rectangle: tuple[float, float, float, float], path: Path, size: tuple[int, int]
) -> tuple[slice, slice]:
    """The rows and columns of a picture that a rectangle covers, to the nearest pixel.

    Args:
        option: the option's name, for the complaint.
        rectangle: (x, y, width, height), as `parse_rectangle` reads it.
        path: the picture's file, for the complaint.
        size: (width, height) of the picture.

    Raises:
        InputError: it covers no pixel, or lies outside the picture in part.

    Examples:
        >>> cut_rectangle("--region", (10, 20, 4, 8), Path("wall.png"), (64, 48))
        (slice(20, 28, None), slice(10, 14, None))
    """
    x, y, width, height = rectangle
    left, top, right, bottom = (round(edge) for edge in (x, y, x + width, y + height))
    if not (0 <= left < right <= size[0] and 0 <= top < bottom <= size[1]):
        told = f"{option}: {x:g},{y:g},{width:g}x{height:g}"
        raise InputError(f"{told} lies outside {path}, which is {size[0]} x {size[1]}")
    return slice(top, bottom), slice(left, right)


def parse_finishes(option: str, words: Sequence[str]) -> dict[str, str]:
    """Read words of the form "structure=finish".

    Args:
        option: the option's name, for the complaint.
        words: what the user typed.

    Raises:
        InputError: a word is not of that form, or a structure comes twice.

    Examples:
        >>> parse_finishes("--finish", ["tile=varnish", "joint=dull"])
        {'tile': 'varnish', 'joint': 'dull'}
    """
    finishes: dict[str, str] = {}
    for word in words:
        match = re.fullmatch(r"\s*(\w+)\s*=\s*(\w+)\s*", word)
        if not match:
            raise InputError(f"{option}: '{word}' gives no structure a finish; write structure=finish, as tile=varnish")
        if match[1] in finishes:
            raise InputError(f"{option}: {match[1]} is given twice; give it once")
        finishes[match[1]] = match[2]
    return finishes


def parse_colour(option: str, word: str) -> tuple[float, float, float]:
    """Read "#rrggbb" (or "#rgb"), as colour pickers show it, as sRGB values from 0 to 1, still encoded.

    Args:
        option: the option's name, for the complaint.
        word: what the user typed; the # may be left out, since shells want it quoted.

    Raises:
        InputError: it is no such colour.

    Examples:
        >>> parse_colour("--colour", "#ff0033")
        (1.0, 0.0, 0.2)
    """
    match = re.fullmatch(r"\s*#?([0-9a-f]{6}|[0-9a-f]{3})\s*", word, re.IGNORECASE)
    if not match:
        raise InputError(f"{option}: '{word}' is no colour; write it as colour pickers do, '#b5502f'")
    digits = match[1] if len(match[1]) == 6 else "".join(digit * 2 for digit in match[1])
    red, green, blue = (int(digits[k : k + 2], 16) / 255 for k in (0, 2, 4))
    return red, green, blue


def parse_assignments(option: str, words: Sequence[str]) -> dict[str, float]:
    """Read words of the form "name=number".

    Args:
        option: the option's name, for the complaint.
        words: what the user typed.

    Raises:
        InputError: a word is no such assignment, or a name comes twice.

    Examples:
        >>> parse_assignments("--fix", ["angle_deg=0", "mortar_x=4.5"])
        {'angle_deg': 0.0, 'mortar_x': 4.5}
    """
    values: dict[str, float] = {}
    for word in words:
        match = re.fullmatch(rf"\s*(\w+)\s*=\s*({_NUMBER}(?:e[+-]?\d+)?)\s*", word, re.IGNORECASE)
        if not match:
            raise InputError(f"{option}: '{word}' gives no parameter a number; write name=number, without spaces")
        if match[1] in values:
            raise InputError(f"{option}: {match[1]} is given twice; give it once")
        values[match[1]] = float(match[2])
    return values


@contextmanager
def naming(where: object) -> Iterator[None]:
    """Have complaints from within begin with the option or the file that they are about.

    Examples:
        >>> with naming("--open"):
        ...     raise InputError("radius: -2 is out of range")
        Traceback (most recent call last):
        jaxtex.core.errors.InputError: --open: radius: -2 is out of range
    """
    try:
        yield
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


@contextmanager
def naming_options(options: object, path: Path, **sources: object) -> Iterator[None]:
    """Have complaints of the library that begin with an argument's name begin with the option of that name, and all
    that begin with no option, with a file.

    Args:
        options: of the command, a dataclass.
        path: of the file that is dealt with.
        sources: of arguments that come from elsewhere than the option of their name: what complaints name instead.

    Examples:
        >>> from dataclasses import make_dataclass
        >>> for told in ("radius: -2 is out of range", "picture: is grey", "size 8 x 8: is too small"):
        ...     try:
        ...         with naming_options(make_dataclass("Cut", ["radius"])(-2), Path("b.png"), size="--under: a.png of"):
        ...             raise InputError(told)
        ...     except InputError as error:
        ...         print(error)
        --radius: -2 is out of range
        b.png: picture: is grey
        --under: a.png of 8 x 8: is too small
    """
    try:
        yield
    except InputError as error:
        told = str(error)
        name = re.split(r"\W", told, maxsplit=1)[0]
        given_by = {each: "--" + each.replace("_", "-") for each in vars(options)} | sources
        if name in given_by:
            raise InputError(f"{given_by[name]}{told.removeprefix(name)}") from None
        raise InputError(told if told.startswith("--") else f"{path}: {told}") from None


def check_seed(seed: int, *, option: str = "--seed") -> int:
    """`seed` itself, once it is known to be one.

    Args:
        seed: what the user typed.
        option: the option's name, for the complaint.

    Raises:
        InputError: it is negative, or has more than 32 bits.
    """
    if not 0 <= seed < 2**32:
        raise InputError(f"{option}: {seed} is out of range; give a whole number from 0 to {2**32 - 1}")
    return seed


def check_memory(asked: str, needed: int) -> None:
    """Refuse what needs more memory than this machine has.

    Args:
        asked: what the user asks for, as "--size: 40000x40000".
        needed: bytes.

    Raises:
        InputError: it does.
    """
    there = _physical_memory()
    if needed > there:
        raise InputError(
            f"{asked} takes {needed / 2**30:.1f} GiB of memory, and this machine has {there / 2**30:.1f}; ask for less"
        )


def _physical_memory() -> int:
    """Bytes; where the system does not tell, 16 GiB."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return 16 * 2**30
