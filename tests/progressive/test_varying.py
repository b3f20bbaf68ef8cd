"""Varying textures: files give back what was written, and say what is wrong."""

from pathlib import Path

import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.io.arrays import read_arrays, write_arrays
from jaxtex.progressive.varying import VaryingTexture, read_varying, write_varying


def drawn(channels: int = 3) -> VaryingTexture:
    rng = np.random.default_rng(0)
    angle = rng.uniform(0, 7, (5, 8))
    return VaryingTexture.of(
        rng.random((5, 8, channels)),
        mask=rng.integers(0, 4, (5, 8)),
        transition=rng.random((5, 8)),
        orientation=np.stack([np.cos(angle), np.sin(angle)], axis=-1),
        scale=rng.uniform(0.5, 2, (5, 8)),
    )


@pytest.mark.parametrize("channels", [1, 3])
def test_a_file_gives_back_what_was_written(tmp_path: Path, channels: int) -> None:
    varying = drawn(channels)
    write_varying(tmp_path / "coat.npz", varying)
    assert sorted(np.load(tmp_path / "coat.npz")) == ["mask", "orientation", "scale", "texture", "transition"]
    read = read_varying(tmp_path / "coat.npz")
    for name in VaryingTexture._fields:
        one, other = getattr(varying, name), getattr(read, name)
        assert one.dtype == other.dtype == (np.uint8 if name == "mask" else np.float32)
        assert np.array_equal(one, other)


WRONG = {
    "texture": (np.zeros((5, 8, 2)), "texture has 2 channels; give 1 or 3"),
    "mask": (np.zeros((5, 9), np.uint8), "mask is 9 x 5, its texture 8 x 5"),
    "mask ": (np.full((5, 8), 4), "mask holds labels beside 0 to 3"),
    "mask  ": (np.full((5, 8), 0.5), "mask holds labels beside 0 to 3"),
    "transition": (np.full((5, 8), 1.1), "transition holds values outside 0 to 1"),
    "transition ": (np.full((5, 8), np.nan), "transition holds what is no finite number"),
    "orientation": (np.full((5, 8, 2), 1.0), "vectors whose length is not 1"),
    "orientation ": (np.ones((5, 8)), r"orientation of shape \(5, 8\): give 3 dimensions"),
    "orientation  ": (np.ones((5, 8, 3)) / np.sqrt(3), "orientation has 3 channels; give x and y"),
    "scale": (np.zeros((5, 8)), "scale holds values that are not above 0"),
}


@pytest.mark.parametrize(("name", "wrong", "told"), [(name, *rest) for name, rest in WRONG.items()])
def test_what_is_wrong_is_said(tmp_path: Path, name: str, wrong: np.ndarray, told: str) -> None:
    arrays = drawn()._asdict() | {name.strip(): wrong}
    with pytest.raises(ValueError, match=told):
        VaryingTexture.of(**arrays)
    with pytest.raises(ValueError, match=told):
        write_varying(tmp_path / "coat.npz", VaryingTexture(**arrays))
    assert not (tmp_path / "coat.npz").exists()
    write_arrays(tmp_path / "coat.npz", arrays)
    with pytest.raises(InputError, match=f"coat.npz: .*{told}"):
        read_varying(tmp_path / "coat.npz")


def test_arrays_must_be_those_that_are_known(tmp_path: Path) -> None:
    path = tmp_path / "coat.npz"
    write_varying(path, drawn())
    arrays = read_arrays(path)
    write_arrays(path, {**arrays, "height": np.zeros(3)})
    with pytest.raises(InputError, match="height is not known"):
        read_varying(path)
    del arrays["mask"]
    write_arrays(path, arrays)
    with pytest.raises(InputError, match="holds no mask; a varying texture holds texture, mask"):
        read_varying(path)
