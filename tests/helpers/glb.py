"""Binary glTF read without the library that wrote it."""

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np


def read_chunks(path: Path) -> tuple[dict[str, Any], bytes]:
    """The two chunks of a binary glTF file, as section 4.4 of the specification has them."""
    data = path.read_bytes()
    magic, version, length, json_length, json_type = struct.unpack_from("<4sIII4s", data)
    assert (magic, version, length, json_type) == (b"glTF", 2, len(data), b"JSON")
    assert json_length % 4 == 0
    tree = json.loads(data[20 : 20 + json_length])
    binary_length, binary_type = struct.unpack_from("<I4s", data, 20 + json_length)
    binary = data[28 + json_length :]
    assert binary_type == b"BIN\0"
    assert len(binary) == binary_length == tree["buffers"][0]["byteLength"]
    for view in tree["bufferViews"]:
        assert view["byteOffset"] % 4 == 0
        assert view["byteOffset"] + view["byteLength"] <= binary_length
    return tree, binary


def read_attribute(tree: dict[str, Any], binary: bytes, name: str) -> np.ndarray:
    (primitive,) = tree["meshes"][0]["primitives"]
    accessor = tree["accessors"][primitive["indices"] if name == "indices" else primitive["attributes"][name]]
    width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor["type"]]
    kind = {5125: "<u4", 5126: "<f4"}[accessor["componentType"]]
    start = tree["bufferViews"][accessor["bufferView"]]["byteOffset"] + accessor.get("byteOffset", 0)
    return np.frombuffer(binary, kind, accessor["count"] * width, start).reshape(-1, width)
