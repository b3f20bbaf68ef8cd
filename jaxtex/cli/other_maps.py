"""Other maps of an exemplar's material (normals, heights, ...), from which the same is made as from the exemplar."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from jaxtex.core.errors import InputError


def name_maps(
    options: Mapping[str, Sequence[Path]], exemplar: Path, size: tuple[int, int], output: Path
) -> list[tuple[Path, Path]]:
    """Each map, and the file that it is written to, OUTPUT_MAP beside the output; known to be writable.

    Args:
        options: maps by the option that they are given with.
        exemplar: the picture that they go along with.
        size: its width and height.
        output: what is made of it.

    Raises:
        InputError: a map cannot be read or is of another size, its file cannot be written, is another one's too, or
            something that is read.
    """
    from jaxtex.io.copies import FORMATS, check_copies
    from jaxtex.io.raster import read_raster

    inputs = {path.resolve() for paths in options.values() for path in paths}
    maps: list[tuple[Path, Path]] = []
    for option, path in ((option, path) for option, paths in options.items() for path in paths):
        if path.suffix.lower() not in FORMATS:
            told = f"{', '.join(FORMATS[:-1])} or {FORMATS[-1]}"
            raise InputError(f"{option}: {path}: the result is of its format; convert it to {told} first")
        height, width = read_raster(path).numbers.shape[:2]
        if (width, height) != size:
            told = f"{size[0]} x {size[1]}"
            raise InputError(
                f"{option}: {path} is {width} x {height} pixels, and the exemplar is {told}; give one size"
            )
        made = output.with_name(f"{output.stem}_{path.stem}{path.suffix}")
        if made in [each for _, each in maps]:
            raise InputError(f"{option}: two maps would be written to {made}; rename one of them")
        if output.resolve() in inputs or made.resolve() in {exemplar.resolve(), *inputs}:
            raise InputError(
                f"{option}: {path}, another map or the exemplar would be written over; give another --output"
            )
        check_copies(path, made)
        maps.append((path, made))
    return maps
