"""A mesh with a material, or with vertex colours, as binary glTF 2.0, by trimesh: one file that viewers, engines and
modellers open.

Positions are in metres, with y upwards. glTF's texture coordinates have v **downwards** from the picture's upper left
corner; trimesh turns those of `TexturedMesh` over. Tangents are written of flat meshes alone: where there are none, the
specification has clients derive those of MikkTSpace from the texture coordinates, as modellers do.
"""

import io
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import trimesh
from PIL import Image
from trimesh.exchange.gltf import export_glb
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from jaxtex.core.errors import InputError
from jaxtex.io.files import atomic_write_bytes
from jaxtex.io.meshes import Mesh, TexturedMesh, smooth_normals

LONGEST_SIDE = 16_384
"""Textures with a longer side are refused: graphics cards cannot hold them."""

LARGEST_FILE = 2**32 - 1
"""Bytes that a binary glTF file can count."""

# Of OpenGL, by which glTF names them.
_LINEAR, _LINEAR_MIPMAP_LINEAR, _REPEAT, _VERTICES, _INDICES = 9729, 9987, 10497, 34962, 34963
_SAMPLER = {"magFilter": _LINEAR, "minFilter": _LINEAR_MIPMAP_LINEAR, "wrapS": _REPEAT, "wrapT": _REPEAT}

_DULL = {"metallicFactor": 0, "roughnessFactor": 0.8}  # a dielectric

_IOR_OF_8_PERCENT = 1.788789  # what a dielectric has that reflects so much at right angles


class MaterialImages(NamedTuple):
    """The maps of a material as the textures of glTF, all of one size, uint8.

    Attributes:
        base_colour: [row, col, 3], encoded as sRGB.
        normal: [row, col, 3], 0.5 n + 0.5 of unit vectors: x right, y up, z out of the surface. None where the mesh's
            own are the surface's.
        surface: [row, col, 3]: ambient occlusion, roughness, metallic; each from 0 to 1 as it stands. None for a dull
            dielectric in the open.
        specular: [row, col], encoded as sRGB: from 0 to 1, reflectance at right angles as a share of 8 %. None where it
            is 4 % everywhere, as glTF has it unless told.
    """

    base_colour: npt.NDArray[np.uint8]
    normal: npt.NDArray[np.uint8] | None = None
    surface: npt.NDArray[np.uint8] | None = None
    specular: npt.NDArray[np.uint8] | None = None


def write_glb(
    path: Path | str,
    mesh: TexturedMesh,
    images: MaterialImages,
    *,
    repeat: tuple[float, float] = (1.0, 1.0),
    offset: tuple[float, float] = (0.0, 0.0),
    name: str = "material",
) -> None:
    """Write a mesh with a material to a .glb file, whole or not at all. The same input gives the same bytes.

    Textures repeat beyond their borders, and are filtered with mipmaps. Reflectance that is not 4 % everywhere goes by
    `KHR_materials_specular` and `KHR_materials_ior` (the former's section on materials with a reflectance parameter);
    clients that do not know them show 4 %.

    Args:
        path: the file.
        mesh: in metres.
        images: the material.
        repeat: how often the picture repeats where u and v go from 0 to 1, to the right and downwards.
        offset: by how much of the picture it is cut off on the left and at the top. These two go by
            `KHR_texture_transform`.
        name: of the material and the mesh.

    Raises:
        InputError: a path that does not end in .glb, arrays of other shapes or types, numbers that are not finite,
            textures beyond `LONGEST_SIDE`, more than `LARGEST_FILE`, a file that cannot be made.

    Examples:
        >>> from jaxtex.io.meshes import wall_mesh
        >>> grey = np.full((4, 8, 3), 128, np.uint8)
        >>> write_glb("wall.glb", wall_mesh(4.0, 2.0), MaterialImages(grey, grey, grey), repeat=(2, 2))
        >>> Path("wall.glb").read_bytes()[:4]
        b'glTF'
    """
    path = Path(path)
    try:
        _check_name(path)
        _check_images(images)
        _check_mesh(mesh)
        if not (np.isfinite([*repeat, *offset]).all() and min(repeat) > 0):
            raise InputError(f"repeat {repeat} and offset {offset}: give finite numbers, and repeat more than 0")
        _check_bytes([*images, mesh.vertices, mesh.faces, mesh.uv, mesh.normals])
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    atomic_write_bytes(path, _encode(mesh, images, _transform(repeat, offset), name))


def write_coloured_glb(path: Path | str, mesh: Mesh, colours: npt.NDArray[np.floating], *, name: str = "mesh") -> None:
    """Write a mesh with vertex colours to a .glb file, whole or not at all. The same input gives the same bytes.

    The material is a dull dielectric; normals are smooth.

    Args:
        path: the file.
        mesh: in metres, with y upwards.
        colours: [vertex, 3], linear light from 0 to 1, as glTF has it; what lies outside is clipped.
        name: of the mesh.

    Raises:
        InputError: a path that does not end in .glb, arrays of other shapes, numbers that are not finite, more than
            `LARGEST_FILE`, a file that cannot be made.

    Examples:
        >>> triangle = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
        >>> write_coloured_glb("sail.glb", triangle, np.eye(3))
        >>> Path("sail.glb").read_bytes()[:4]
        b'glTF'
    """
    path = Path(path)
    try:
        _check_name(path)
        _check_arrays({"vertices": mesh.vertices, "colours": colours}, mesh.faces)
        _check_bytes([mesh.vertices, mesh.faces, mesh.vertices, colours])
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    atomic_write_bytes(path, _encode_coloured(mesh, np.clip(colours, 0, 1).astype(np.float32), name))


def check_texture_size(size: tuple[int, int]) -> None:
    """Refuse sizes (width, height) that textures cannot have.

    Raises:
        InputError: no pixels, or a side beyond `LONGEST_SIDE`.
    """
    if not 1 <= min(size) <= max(size) <= LONGEST_SIDE:
        raise InputError(f"textures of {size[0]} x {size[1]} pixels cannot be made; give 1 to {LONGEST_SIDE} to a side")


def _encode(mesh: TexturedMesh, images: MaterialImages, transform: dict[str, Any], name: str) -> bytes:
    textured = trimesh.Trimesh(
        mesh.vertices,
        mesh.faces,
        vertex_normals=mesh.normals,
        visual=TextureVisuals(uv=mesh.uv, material=PBRMaterial(name=name)),
        vertex_attributes={} if mesh.tangent is None else {"_TANGENT": _tangents(mesh.tangent, len(mesh.vertices))},
        process=False,
    )
    return _export(textured, name, lambda buffers, tree: _add_material(buffers, tree, images, transform))


def _encode_coloured(mesh: Mesh, colours: npt.NDArray[np.float32], name: str) -> bytes:
    coloured = trimesh.Trimesh(
        mesh.vertices,
        mesh.faces,
        vertex_normals=smooth_normals(mesh.vertices, mesh.faces),
        vertex_attributes={"_COLOR_0": colours},
        process=False,
    )

    def add_material(_: Any, tree: dict[str, Any]) -> None:
        tree["materials"] = [{"name": name, "pbrMetallicRoughness": _DULL}]
        tree["meshes"][0]["primitives"][0]["material"] = 0

    return _export(coloured, name, add_material)


def _export(mesh: trimesh.Trimesh, name: str, add_material: Callable[[Any, dict[str, Any]], None]) -> bytes:
    scene = trimesh.Scene()
    scene.add_geometry(mesh, node_name=name, geom_name=name)
    data = export_glb(scene, include_normals=True, buffer_postprocessor=add_material, tree_postprocessor=_name_buffers)
    assert isinstance(data, bytes)
    return data


def _add_material(buffers: Any, tree: dict[str, Any], images: MaterialImages, transform: dict[str, Any]) -> None:
    """Textures and what they are for. trimesh's own materials write an image twice that serves two purposes, and know
    no extensions."""

    def use(image: npt.NDArray[np.uint8]) -> dict[str, Any]:
        number = len(tree["textures"])
        buffers[f"texture {number}"] = _encode_png(image)
        tree["images"].append({"bufferView": len(buffers) - 1, "mimeType": "image/png"})
        tree["textures"].append({"sampler": 0, "source": number})
        return {"index": number} | ({"extensions": {"KHR_texture_transform": transform}} if transform else {})

    material: dict[str, Any] = {"pbrMetallicRoughness": _DULL}
    if images.surface is not None:
        surface = use(images.surface)
        material = {"pbrMetallicRoughness": {"metallicRoughnessTexture": surface}, "occlusionTexture": surface}
    extensions: dict[str, Any] = {}
    if images.specular is not None:
        grey = np.repeat(images.specular[..., None], 3, axis=-1)
        extensions["KHR_materials_ior"] = {"ior": _IOR_OF_8_PERCENT}
        extensions["KHR_materials_specular"] = {"specularColorTexture": use(grey)}
    tree["samplers"] = [_SAMPLER]
    material["pbrMetallicRoughness"] = {"baseColorTexture": use(images.base_colour)} | material["pbrMetallicRoughness"]
    if images.normal is not None:
        material["normalTexture"] = use(images.normal)
    tree["materials"][0] |= material | ({"extensions": extensions} if extensions else {})
    used = [*extensions, *(["KHR_texture_transform"] if transform else [])]
    if used:
        tree["extensionsUsed"] = used


def _encode_png(image: npt.NDArray[np.uint8]) -> bytes:
    """A PNG file, filled up to a multiple of four bytes."""
    file = io.BytesIO()
    Image.fromarray(image).save(file, format="PNG")
    file.write(bytes(-file.tell() % 4))
    return file.getvalue()


def _name_buffers(tree: dict[str, Any]) -> None:
    """What buffers are for, and which hold tangents and colours: to trimesh attributes that glTF does not know."""
    views, accessors = tree["bufferViews"], tree["accessors"]
    for mesh in tree["meshes"]:
        (primitive,) = mesh["primitives"]
        attributes = primitive["attributes"]
        for attribute in ("TANGENT", "COLOR_0"):
            if f"_{attribute}" in attributes:
                attributes[attribute] = attributes.pop(f"_{attribute}")
        for accessor in attributes.values():
            views[accessors[accessor]["bufferView"]]["target"] = _VERTICES
        views[accessors[primitive["indices"]]["bufferView"]]["target"] = _INDICES


def _tangents(tangent: npt.NDArray[np.float64], count: int) -> npt.NDArray[np.float32]:
    """[vertex, 4]; the fourth number says that v grows to the left of u as seen from outside."""
    return np.tile(np.array([*tangent, 1], np.float32), (count, 1))


def _transform(repeat: tuple[float, float], offset: tuple[float, float]) -> dict[str, list[float]]:
    """The properties of `KHR_texture_transform` that are not what they are anyway."""
    properties = {"offset": (offset, (0.0, 0.0)), "scale": (repeat, (1.0, 1.0))}
    return {key: [float(x) for x in value] for key, (value, plain) in properties.items() if tuple(value) != plain}


def _check_images(images: MaterialImages) -> None:
    rows, columns = (*images.base_colour.shape, 0, 0)[:2]
    for field, image in images._asdict().items():
        shape = (rows, columns) if field == "specular" else (rows, columns, 3)
        if image is not None and (image.shape != shape or image.dtype != np.uint8):
            raise InputError(f"{field}: is {image.dtype} of shape {image.shape}; give uint8 of shape {shape}")
    check_texture_size((columns, rows))


def _check_name(path: Path) -> None:
    if path.suffix.lower() != ".glb":
        raise InputError(f"cannot be written as '{path.suffix}'; name it .glb")


def _check_bytes(arrays: Iterable[npt.NDArray | None]) -> None:
    if sum(array.nbytes for array in arrays if array is not None) > LARGEST_FILE:
        raise InputError("cannot be written, as glTF files hold at most 4 GiB; give a smaller mesh or textures")


def _check_mesh(mesh: TexturedMesh) -> None:
    _check_arrays({"vertices": mesh.vertices, "uv": mesh.uv, "normals": mesh.normals}, mesh.faces)


def _check_arrays(fields: dict[str, npt.NDArray], faces: npt.NDArray[np.int64]) -> None:
    """Those of vertices, and the faces between them."""
    count = len(fields["vertices"])
    shapes = {name: (count, 2 if name == "uv" else 3) for name in fields} | {"faces": (len(faces), 3)}
    for name, array in (fields | {"faces": faces}).items():
        if array.shape != shapes[name] or 0 in array.shape:
            raise InputError(f"{name} of the mesh are of shape {array.shape}; give {shapes[name]}")
        # Files hold single precision.
        with np.errstate(over="ignore"):
            if not np.isfinite(array.astype(np.float32)).all():
                raise InputError(f"{name} of the mesh are not finite in single precision")
    if faces.min() < 0 or faces.max() >= count:
        raise InputError(f"faces of the mesh name vertices from {faces.min()} to {faces.max()} of {count}")
