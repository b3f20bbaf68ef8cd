"""Image files as OpenImageIO sees them: an array of numbers, the names of its channels, and attributes."""

import os
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio

from jaxtex.core.errors import InputError
from jaxtex.io.files import existing_file, replacing

MAX_PIXELS = 400_000_000
"""Larger pictures are refused: as RGB they would take 5 GB and more."""

# EXIF orientation -> the same picture upright, for arrays [row, col, ...].
_UPRIGHT: dict[object, Callable[[np.ndarray], np.ndarray]] = {
    2: lambda array: array[:, ::-1],
    3: lambda array: array[::-1, ::-1],
    4: lambda array: array[::-1],
    5: lambda array: array.swapaxes(0, 1),
    6: lambda array: array[::-1].swapaxes(0, 1),
    7: lambda array: array[::-1, ::-1].swapaxes(0, 1),
    8: lambda array: array[:, ::-1].swapaxes(0, 1),
}


@dataclass(frozen=True, eq=False)
class Raster:
    """What an image file holds, upright, but otherwise as it stands there.

    Attributes:
        numbers: [row, col, channel]; uint8 or uint16 as in the file, everything else as float32 (integers scaled to
            0 to 1).
        channels: names of the channels.
        attributes: the file's metadata, by OpenImageIO's names.
        integer: whether the file holds integers.
        premultiplied: whether the colours are multiplied by alpha, if there is one.
    """

    numbers: np.ndarray
    channels: tuple[str, ...]
    attributes: dict[str, Any]
    integer: bool
    premultiplied: bool


def read_raster(path: Path | str) -> Raster:
    """Read the first picture of an image file and turn it upright by its EXIF orientation.

    Raises:
        InputError: the file is missing, empty, damaged or no image, or larger than `MAX_PIXELS`.
    """
    path = existing_file(path)
    with _QUIET():
        # Colours come as the file has them: OpenImageIO would multiply them by alpha, and lose those where it is zero.
        wish = oiio.ImageSpec()
        wish.attribute("oiio:UnassociatedAlpha", 1)
        source = oiio.ImageInput.open(str(path), wish)
        if source is None:
            raise InputError(f"{path}: cannot be read as an image ({_first_line(oiio.geterror())})")
        try:
            spec = source.spec()
            _check_size(path, spec)
            kept = str(spec.format) in ("uint8", "uint16")
            numbers = source.read_image(oiio.UNKNOWN if kept else oiio.FLOAT)
            problem = source.geterror()
        finally:
            source.close()
    if numbers is None or problem:
        raise InputError(f"{path}: is damaged or cut short ({_first_line(problem)})")
    attributes = {attribute.name: attribute.value for attribute in spec.extra_attribs}
    upright = _UPRIGHT.get(attributes.get("Orientation"))
    return Raster(
        numbers=np.ascontiguousarray(upright(numbers)) if upright else numbers,
        channels=tuple(spec.channelnames),
        attributes=attributes,
        integer=str(spec.format) not in ("half", "float", "double"),
        premultiplied=not attributes.get("oiio:UnassociatedAlpha"),
    )


@contextmanager
def writing_raster(
    path: Path | str, *, size: tuple[int, int], channels: int | Sequence[str], kind: str, attributes: Mapping[str, Any]
) -> Iterator[Callable[[np.ndarray], None]]:
    """A function to hand an image file's rows to, some at a time from the top; the file is there when the block ends.

    Args:
        path: the file; its extension tells the format.
        size: (columns, rows).
        channels: numbers to a pixel; or their names, of which only EXR files keep others than those of colours.
        kind: OpenImageIO's name of the type in the file: "uint8", "uint16", "half", "float".
        attributes: metadata by OpenImageIO's names; those that the format has no place for are left out.

    Yields:
        A function that takes [row, col, channel] in the type to be written, or float32 where `kind` is "half".

    Raises:
        InputError: the file cannot be written; the reason is said. Nothing is left of it then.
    """
    columns, rows = size
    spec = oiio.ImageSpec(columns, rows, channels if isinstance(channels, int) else len(channels), kind)
    names = {1: ("Y",), 2: ("Y", "A")}.get(channels) if isinstance(channels, int) else channels
    if names is not None:
        spec.channelnames = tuple(names)
        spec.alpha_channel = names.index("A") if "A" in names else -1
    for name, value in attributes.items():
        if isinstance(value, np.ndarray | tuple):  # a profile's bytes; primaries
            each = "uint8" if isinstance(value, np.ndarray) else "float"
            spec.attribute(name, oiio.TypeDesc(f"{each}[{len(value)}]"), value)
        else:
            spec.attribute(name, value)
    with replacing(path) as temporary:
        target = _Target(Path(path), temporary, spec)
        try:
            yield target.write
        except BaseException:
            target.abandon()
            raise
        target.close()


class _Target:
    """An image file that is being written under a temporary name."""

    def __init__(self, path: Path, temporary: Path, spec: Any) -> None:
        self._path, self._temporary, self._rows = path, temporary, spec.height
        self._done = 0
        with _QUIET():
            self._file: Any = oiio.ImageOutput.create(str(temporary))
            if self._file is None:
                raise InputError(f"{path}: cannot be written ({_first_line(oiio.geterror())})")
            if not self._file.open(str(temporary), spec):
                raise self._problem()

    def write(self, numbers: np.ndarray) -> None:
        top, self._done = self._done, self._done + len(numbers)
        with _QUIET():
            if not self._file.write_scanlines(top, self._done, 0, np.ascontiguousarray(numbers)):
                raise self._problem()

    def close(self) -> None:
        if self._done != self._rows:
            self.abandon()
            raise ValueError(f"{self._path}: was given {self._done} of its {self._rows} rows")
        with _QUIET():
            if not self._file.close():
                raise self._problem()

    def abandon(self) -> None:
        with _QUIET():
            self._file.close()
            self._file.geterror()  # an error that nobody asks for is printed

    def _problem(self) -> InputError:
        told = self._file.geterror().replace(str(self._temporary), self._path.name)
        return InputError(f"{self._path}: cannot be written ({_first_line(told)})")


def _check_size(path: Path, spec: Any) -> None:
    if spec.deep or spec.depth > 1:
        raise InputError(f"{path}: holds a {'deep picture' if spec.deep else 'volume'}; flat pictures are read")
    if spec.width <= 0 or spec.height <= 0 or spec.nchannels <= 0:
        raise InputError(f"{path}: holds no pixels ({spec.width} x {spec.height}); save the picture again")
    if spec.width * spec.height > MAX_PIXELS:
        told = f"{spec.width:,} x {spec.height:,} pixels"
        raise InputError(f"{path}: has {told}, and at most {MAX_PIXELS:,} can be read; make it smaller or cut it")


def _first_line(text: str) -> str:
    return text.strip().partition("\n")[0].rstrip(".") or "the reason is not known"


class _Quiet:
    """Keeps what the codecs' C libraries print about damaged files off the process's stderr: errors are raised instead.

    One at a time, since stderr belongs to the whole process.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()

    @contextmanager
    def __call__(self) -> Iterator[None]:
        with self._lock:
            try:
                kept = os.dup(2)
            except OSError:  # the process has no stderr
                yield
                return
            try:
                with open(os.devnull, "wb") as nowhere:
                    os.dup2(nowhere.fileno(), 2)
                yield
            finally:
                os.dup2(kept, 2)
                os.close(kept)


_QUIET = _Quiet()
