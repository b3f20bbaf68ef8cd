"""Pictures written some rows at a time."""

import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.io.images import write_image, writing_image


@pytest.mark.parametrize(
    ("name", "space", "channels"),
    [("a.png", "srgb", 3), ("a.png", "data", 1), ("a.exr", "data", 1), ("a.tif", "srgb", 3)],
)
def test_rows_in_pieces_make_the_same_file_as_all_at_once(tmp_path, name, space, channels):
    pixels = np.random.default_rng(0).random((37, 11, channels))
    write_image(tmp_path / f"whole_{name}", pixels, colour_space=space)
    with writing_image(tmp_path / name, size=(11, 37), channels=channels, colour_space=space) as write_rows:
        for top in range(0, 37, 7):
            write_rows(pixels[top : top + 7])
    assert (tmp_path / name).read_bytes() == (tmp_path / f"whole_{name}").read_bytes()


@pytest.mark.parametrize("name", ["a.png", "a.exr"])
def test_a_failure_halfway_leaves_the_older_file(tmp_path, name):
    (tmp_path / name).write_text("older")

    def write_a_part():
        with writing_image(tmp_path / name, size=(4, 8), channels=1, colour_space="data") as write_rows:
            write_rows(np.zeros((2, 4)))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_a_part()
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "older"


def test_missing_rows_and_bad_rows_leave_nothing(tmp_path):
    def write(*rows):
        with writing_image(tmp_path / "a.png", size=(4, 8), channels=1, colour_space="data") as write_rows:
            for row in rows:
                write_rows(row)

    with pytest.raises(ValueError, match="was given 2 of its 8 rows"):
        write(np.zeros((2, 4)))
    with pytest.raises(InputError, match=r"a\.png: is NaN or infinite"):
        write(np.zeros((2, 4)), np.full((6, 4), np.nan))
    with pytest.raises(InputError, match=r"a\.png: data from 2 to 2 do not fit"):
        write(np.full((8, 4), 2.0))
    assert not list(tmp_path.iterdir())
