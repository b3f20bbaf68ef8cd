"""Named arrays in one `.npz` file: what stands beside a model file that JSON is no place for."""

import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.io.files import existing_file, replacing

_DATE = (1980, 1, 1, 0, 0, 0)  # the same arrays give the same bytes


def write_arrays(path: Path | str, arrays: Mapping[str, npt.ArrayLike]) -> None:
    """Write arrays to a compressed `.npz` file, whole or not at all; `numpy.load` reads it.

    Raises:
        InputError: the file cannot be made.

    Examples:
        >>> write_arrays("grain.npz", {"steps": np.arange(3), "kind": 2})
        >>> {name: array.tolist() for name, array in read_arrays("grain.npz").items()}
        {'steps': [0, 1, 2], 'kind': 2}
    """
    with replacing(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in arrays.items():
            with archive.open(zipfile.ZipInfo(f"{name}.npy", date_time=_DATE), "w") as file:
                np.lib.format.write_array(file, np.asarray(array, order="C"), allow_pickle=False)


def read_arrays(path: Path | str) -> dict[str, npt.NDArray]:
    """Read all arrays of a `.npz` file.

    Raises:
        InputError: there is no such file, or it is damaged.
    """
    path = existing_file(path)
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            return dict(archive)
    except Exception as error:  # a damaged archive raises whatever comes to it
        raise InputError(f"{path}: is no archive of arrays, or damaged ({type(error).__name__})") from None
