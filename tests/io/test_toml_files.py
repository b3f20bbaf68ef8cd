"""Files written by hand: what editors add to them, and what is wrong with them."""

from pathlib import Path

import pytest

from jaxtex.core.errors import InputError
from jaxtex.io.toml_files import read_toml


def test_a_byte_order_mark_is_no_content(tmp_path: Path) -> None:
    path = tmp_path / "keys.toml"
    path.write_bytes(b"\xef\xbb\xbfvalue = 2\n")
    assert read_toml(path, "a file of keys") == {"value": 2}


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"value = \xff", "is not a text file; give a file of keys"),
        (b"value 2", "is no TOML"),
        (b"value = " + 5000 * b"[", "brackets too deep in each other"),
        (b"value = " + 5000 * b"9", "is no TOML"),
        (b"value = 0x" + 5000 * b"f", "value: holds a whole number of more than 64 bits"),
        (b"[[scale]]\nat = [0, 0x8000_0000_0000_0000]", "scale: holds a whole number of more than 64 bits"),
    ],
)
def test_faults_are_told(tmp_path: Path, content: bytes, told: str) -> None:
    path = tmp_path / "keys.toml"
    path.write_bytes(content)
    with pytest.raises(InputError, match=told) as complaint:
        read_toml(path, "a file of keys")
    assert str(complaint.value).startswith(f"{path}: ")


def test_whole_numbers_of_64_bits_are_read(tmp_path: Path) -> None:
    path = tmp_path / "keys.toml"
    path.write_bytes(b"value = [-9223372036854775808, 0x7fff_ffff_ffff_ffff]")
    assert read_toml(path, "a file of keys") == {"value": [-(2**63), 2**63 - 1]}
