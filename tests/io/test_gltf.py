"""Binary glTF: what clients find in the file, read without the library that wrote it, with trimesh, and by Khronos."""

import io
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from glb import read_attribute, read_chunks
from gltf_validator import complaints, find_validator, validate
from PIL import Image

from jaxtex.core.errors import InputError
from jaxtex.io import gltf
from jaxtex.io.gltf import MaterialImages, write_coloured_glb, write_glb
from jaxtex.io.meshes import Mesh, TexturedMesh, floor_mesh, wall_mesh

ROWS, COLUMNS = 6, 10
BALL = trimesh.creation.icosphere(subdivisions=2)
SPHERE = TexturedMesh(BALL.vertices, BALL.faces, BALL.vertices[:, :2], np.array(BALL.vertex_normals))


def make_images(*, specular: bool = False) -> MaterialImages:
    random = np.random.default_rng(0)
    colour, normal, surface = random.integers(0, 256, (3, ROWS, COLUMNS, 3), dtype=np.uint8)
    return MaterialImages(colour, normal, surface, surface[..., 0] if specular else None)


def read_texture(tree: dict[str, Any], binary: bytes, use: dict[str, Any]) -> np.ndarray:
    image = tree["images"][tree["textures"][use["index"]]["source"]]
    assert image["mimeType"] == "image/png"
    view = tree["bufferViews"][image["bufferView"]]
    return np.asarray(Image.open(io.BytesIO(binary[view["byteOffset"] :][: view["byteLength"]])))


def uses_of(tree: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """The material's references to textures by name."""
    (material,) = tree["materials"]
    specular = material.get("extensions", {}).get("KHR_materials_specular", {})
    return {key: value for part in (material, material["pbrMetallicRoughness"], specular) for key, value in part.items()
            if key.endswith("Texture")}  # fmt: skip


def test_textures_are_the_images_texel_for_texel(tmp_path: Path) -> None:
    images = make_images(specular=True)
    write_glb(tmp_path / "wall.glb", wall_mesh(4, 3), images)
    tree, binary = read_chunks(tmp_path / "wall.glb")
    found = {name: read_texture(tree, binary, use) for name, use in uses_of(tree).items()}
    assert np.array_equal(found["baseColorTexture"], images.base_colour)
    assert np.array_equal(found["normalTexture"], images.normal)
    assert np.array_equal(found["metallicRoughnessTexture"], images.surface)
    assert np.array_equal(found["specularColorTexture"], np.stack([images.specular] * 3, axis=-1))
    loaded = trimesh.load_scene(tmp_path / "wall.glb").geometry["material"].visual.material
    assert np.array_equal(np.asarray(loaded.baseColorTexture), images.base_colour)
    assert np.array_equal(np.asarray(loaded.normalTexture), images.normal)
    assert np.array_equal(np.asarray(loaded.metallicRoughnessTexture), images.surface)
    assert np.array_equal(np.asarray(loaded.occlusionTexture), images.surface)


def test_factors_leave_the_textures_as_they_are(tmp_path: Path) -> None:
    write_glb(tmp_path / "wall.glb", wall_mesh(4, 3), make_images(specular=True))
    material = read_chunks(tmp_path / "wall.glb")[0]["materials"][0]
    surface, extensions = material["pbrMetallicRoughness"], material["extensions"]
    assert surface.get("baseColorFactor", [1, 1, 1, 1]) == [1, 1, 1, 1]
    assert surface.get("metallicFactor", 1) == surface.get("roughnessFactor", 1) == 1
    assert material["normalTexture"].get("scale", 1) == material["occlusionTexture"].get("strength", 1) == 1
    assert material.get("emissiveFactor", [0, 0, 0]) == [0, 0, 0]
    # Reflectance at right angles by the index of refraction: 8 % where the texture is 1.
    ior = extensions["KHR_materials_ior"]["ior"]
    assert ((ior - 1) / (ior + 1)) ** 2 == pytest.approx(0.08, abs=1e-6)
    assert set(extensions["KHR_materials_specular"]) == {"specularColorTexture"}


def test_a_base_colour_alone_is_a_dull_dielectric(tmp_path: Path) -> None:
    colour = make_images().base_colour
    write_glb(tmp_path / "wall.glb", wall_mesh(4, 3), MaterialImages(colour))
    tree, binary = read_chunks(tmp_path / "wall.glb")
    assert set(uses_of(tree)) == {"baseColorTexture"}
    assert np.array_equal(read_texture(tree, binary, uses_of(tree)["baseColorTexture"]), colour)
    assert tree["materials"][0]["pbrMetallicRoughness"]["metallicFactor"] == 0
    assert "occlusionTexture" not in tree["materials"][0]


def test_occlusion_shares_the_image_of_roughness(tmp_path: Path) -> None:
    write_glb(tmp_path / "wall.glb", wall_mesh(4, 3), make_images())
    tree, _ = read_chunks(tmp_path / "wall.glb")
    uses = uses_of(tree)
    assert uses["occlusionTexture"] == uses["metallicRoughnessTexture"]
    assert len(tree["images"]) == len(tree["textures"]) == len({image["bufferView"] for image in tree["images"]}) == 3
    assert "extensionsUsed" not in tree


def test_textures_repeat_and_have_mipmaps(tmp_path: Path) -> None:
    write_glb(tmp_path / "wall.glb", wall_mesh(4, 3), make_images(specular=True))
    tree, _ = read_chunks(tmp_path / "wall.glb")
    # GL_LINEAR, GL_LINEAR_MIPMAP_LINEAR, GL_REPEAT
    assert tree["samplers"] == [{"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}]
    assert [texture["sampler"] for texture in tree["textures"]] == [0, 0, 0, 0]


def test_every_texture_is_transformed_alike(tmp_path: Path) -> None:
    write_glb(tmp_path / "a.glb", wall_mesh(4, 3), make_images(specular=True), repeat=(3, 2.5), offset=(0.25, 0))
    tree, _ = read_chunks(tmp_path / "a.glb")
    uses = uses_of(tree)
    assert len(uses) == 5
    for use in uses.values():
        assert use["extensions"] == {"KHR_texture_transform": {"offset": [0.25, 0.0], "scale": [3.0, 2.5]}}
    used = ["KHR_materials_ior", "KHR_materials_specular", "KHR_texture_transform"]
    assert tree["extensionsUsed"] == used
    assert "extensionsRequired" not in tree


def test_the_mesh_is_the_same(tmp_path: Path) -> None:
    write_glb(tmp_path / "ball.glb", SPHERE, make_images(), name="ball")
    tree, binary = read_chunks(tmp_path / "ball.glb")
    assert np.array_equal(read_attribute(tree, binary, "POSITION"), SPHERE.vertices.astype(np.float32))
    assert np.array_equal(read_attribute(tree, binary, "indices").reshape(-1, 3), SPHERE.faces)
    np.testing.assert_allclose(read_attribute(tree, binary, "NORMAL"), SPHERE.normals, atol=1e-6)
    np.testing.assert_allclose(read_attribute(tree, binary, "TEXCOORD_0"), SPHERE.uv * [1, -1] + [0, 1], atol=1e-6)
    assert "TANGENT" not in tree["meshes"][0]["primitives"][0]["attributes"]
    loaded = trimesh.load_scene(tmp_path / "ball.glb", process=False).geometry["ball"]
    np.testing.assert_allclose(loaded.visual.uv, SPHERE.uv, atol=1e-6)
    targets = {view.get("target") for view in tree["bufferViews"]}
    assert targets == {None, 34962, 34963}  # images; GL_ARRAY_BUFFER, GL_ELEMENT_ARRAY_BUFFER


def find_texture_coordinate(tree: dict[str, Any], binary: bytes, point: np.ndarray) -> np.ndarray:
    """By plain barycentric coordinates: (u, v) of the file at a point of its first triangle that holds it."""
    vertices, uv = read_attribute(tree, binary, "POSITION"), read_attribute(tree, binary, "TEXCOORD_0")
    for face in read_attribute(tree, binary, "indices").reshape(-1, 3):
        weights, *_ = np.linalg.lstsq(np.vstack([vertices[face].T, np.ones(3)]), np.append(point, 1.0), rcond=None)
        if weights.min() >= -1e-6:
            return weights @ uv[face]
    raise AssertionError(f"no triangle holds {point}")


@pytest.mark.parametrize("texel", [(0, 0), (0, COLUMNS - 1), (ROWS - 1, 0), (ROWS - 1, COLUMNS - 1), (2, 7)])
@pytest.mark.parametrize("on", ["wall", "floor"])
def test_the_centre_of_a_texel_lies_where_a_viewer_looks_for_it(
    tmp_path: Path, on: str, texel: tuple[int, int]
) -> None:
    width, height = 5.0, 3.0
    make = wall_mesh if on == "wall" else floor_mesh
    write_glb(tmp_path / "a.glb", make(width, height), make_images())
    row, column = texel
    # From the upper left as the viewer sees it: of a wall from +z, of a floor from above with -z ahead.
    right, down = (column + 0.5) / COLUMNS * width, (row + 0.5) / ROWS * height
    x = right - width / 2
    point = np.array([x, height - down, 0.0] if on == "wall" else [x, 0.0, down - height / 2])
    u, v = find_texture_coordinate(*read_chunks(tmp_path / "a.glb"), point)
    # glTF: (0, 0) is the upper left corner of the image's first texel.
    assert u * COLUMNS == pytest.approx(column + 0.5, abs=1e-4)
    assert v * ROWS == pytest.approx(row + 0.5, abs=1e-4)


@pytest.mark.parametrize(("make", "normal"), [(wall_mesh, [0, 0, 1]), (floor_mesh, [0, 1, 0])])
def test_a_rectangle_faces_the_viewer_and_its_frame_is_that_of_normal_maps(tmp_path: Path, make, normal) -> None:
    write_glb(tmp_path / "a.glb", make(4, 3), make_images())
    tree, binary = read_chunks(tmp_path / "a.glb")
    a, b, c = read_attribute(tree, binary, "POSITION")[read_attribute(tree, binary, "indices").reshape(-1, 3)[0]]
    np.testing.assert_allclose(np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a)), normal, atol=1e-6)
    assert (read_attribute(tree, binary, "NORMAL") == normal).all()
    tangent = read_attribute(tree, binary, "TANGENT")
    # Along growing u; the bitangent points to the image's upper side, as glTF's normal maps have +Y up.
    vertices, uv = read_attribute(tree, binary, "POSITION"), read_attribute(tree, binary, "TEXCOORD_0")
    along = vertices[uv[:, 0] == 1].mean(axis=0) - vertices[uv[:, 0] == 0].mean(axis=0)
    upward = vertices[uv[:, 1] == 0].mean(axis=0) - vertices[uv[:, 1] == 1].mean(axis=0)
    np.testing.assert_allclose(tangent[0, :3], along / np.linalg.norm(along), atol=1e-6)
    bitangent = np.cross(normal, tangent[0, :3]) * tangent[0, 3]
    np.testing.assert_allclose(bitangent, upward / np.linalg.norm(upward), atol=1e-6)


def test_the_same_input_gives_the_same_bytes_in_every_process(tmp_path: Path) -> None:
    code = (
        "import sys; sys.path[:0] = sys.argv[2:]; import numpy as np\n"
        "from jaxtex.io.gltf import *; from jaxtex.io.meshes import wall_mesh\n"
        "image = np.arange(60, dtype=np.uint8).reshape(4, 5, 3)\n"
        "images = MaterialImages(image, image[::-1].copy(), 255 - image, image[..., 0].copy())\n"
        "write_glb(sys.argv[1], wall_mesh(2, 1), images, repeat=(2, 2))\n"
    )
    for seed in ("1", "2"):
        environment = {"PYTHONHASHSEED": seed}
        subprocess.run(
            [sys.executable, "-c", code, str(tmp_path / f"{seed}.glb"), *sys.path], check=True, env=environment
        )
    assert (tmp_path / "1.glb").read_bytes() == (tmp_path / "2.glb").read_bytes()


GREY = np.zeros((4, 4, 3), np.uint8)
GOOD = MaterialImages(GREY, GREY, GREY)
WALL = wall_mesh(2, 1)


@pytest.mark.parametrize(
    ("mesh", "images", "options", "told"),
    [
        (WALL, GOOD._replace(normal=np.zeros((4, 5, 3), np.uint8)), {}, r"normal: is uint8 of shape \(4, 5, 3\)"),
        (WALL, GOOD._replace(surface=np.zeros((4, 4, 3))), {}, "surface: is float64"),
        (WALL, GOOD._replace(specular=GREY), {}, "specular: is uint8 of shape"),
        (WALL, MaterialImages(*[GREY[:0]] * 3), {}, "textures of 4 x 0 pixels"),
        (WALL, MaterialImages(*[np.zeros((1, 20_000, 3), np.uint8)] * 3), {}, "textures of 20000 x 1 pixels"),
        (WALL._replace(faces=np.array([[0, 1, 4]])), GOOD, {}, "faces of the mesh name vertices from 0 to 4 of 4"),
        (WALL._replace(faces=np.empty((0, 3), int)), GOOD, {}, "faces of the mesh are of shape"),
        (WALL._replace(uv=WALL.uv[:3]), GOOD, {}, "uv of the mesh are of shape"),
        (WALL._replace(vertices=WALL.vertices * np.nan), GOOD, {}, "vertices of the mesh are not finite"),
        (WALL._replace(vertices=WALL.vertices * 1e300), GOOD, {}, "vertices of the mesh are not finite"),
        (WALL, GOOD, {"repeat": (0, 1)}, "give finite numbers"),
        (WALL, GOOD, {"offset": (np.inf, 1)}, "give finite numbers"),
    ],
)
def test_what_cannot_be_written_is_refused(tmp_path: Path, mesh, images, options, told: str) -> None:
    with pytest.raises(InputError, match=told):
        write_glb(tmp_path / "a.glb", mesh, images, **options)
    assert not list(tmp_path.iterdir())


def test_files_that_cannot_be_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for path, told in ((tmp_path / "a.gltf", "name it .glb"), (tmp_path / "no" / "a.glb", "there is no folder")):
        with pytest.raises(InputError, match=told):
            write_glb(path, WALL, GOOD)
    monkeypatch.setattr(gltf, "LARGEST_FILE", 100)
    with pytest.raises(InputError, match="at most 4 GiB"):
        write_glb(tmp_path / "a.glb", WALL, GOOD)
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(
    find_validator() is None, reason="needs Node and gltf-validator (make test installs it where there is npm)"
)
@pytest.mark.parametrize("specular", [False, True])
@pytest.mark.parametrize(("mesh", "expected"), [(WALL, []), (floor_mesh(2, 1), []), (SPHERE, ["TANGENT"])])
def test_khronos_has_nothing_to_say(tmp_path: Path, mesh: TexturedMesh, expected: list[str], specular: bool) -> None:
    write_glb(tmp_path / "a.glb", mesh, make_images(specular=specular), repeat=(2, 3), offset=(0, 0.5), name="Mauer ü")
    found = complaints(validate(tmp_path / "a.glb"))
    # Where a mesh has no tangents, the validator warns that clients derive them; they do.
    assert [line.partition(" ")[0] for line in found] == ["MESH_PRIMITIVE_GENERATED_TANGENT_SPACE" for _ in expected]


BALL_MESH = Mesh(np.asarray(BALL.vertices), np.asarray(BALL.faces))
COLOURS = np.random.default_rng(1).uniform(0, 1, (len(BALL.vertices), 3))


def test_vertex_colours_are_linear_and_the_mesh_is_the_same(tmp_path: Path) -> None:
    for name in ("one.glb", "other.glb"):
        write_coloured_glb(tmp_path / name, BALL_MESH, 1.5 * COLOURS - 0.1)
    assert (tmp_path / "one.glb").read_bytes() == (tmp_path / "other.glb").read_bytes()
    tree, binary = read_chunks(tmp_path / "one.glb")
    expected = np.clip(1.5 * COLOURS - 0.1, 0, 1)
    np.testing.assert_allclose(read_attribute(tree, binary, "COLOR_0"), expected, atol=1e-6)
    assert np.array_equal(read_attribute(tree, binary, "POSITION"), BALL.vertices.astype(np.float32))
    assert np.array_equal(read_attribute(tree, binary, "indices").reshape(-1, 3), BALL.faces)
    outwards = BALL.vertices / np.linalg.norm(BALL.vertices, axis=1, keepdims=True)
    np.testing.assert_allclose(read_attribute(tree, binary, "NORMAL"), outwards, atol=0.03)
    (primitive,) = tree["meshes"][0]["primitives"]
    assert set(primitive["attributes"]) == {"POSITION", "NORMAL", "COLOR_0"}
    assert tree["materials"][primitive["material"]]["pbrMetallicRoughness"]["metallicFactor"] == 0


@pytest.mark.parametrize(
    ("name", "colours", "told"),
    [
        ("a.ply", COLOURS, "name it .glb"),
        ("a.glb", COLOURS[1:], "colours of the mesh are of shape"),
        ("a.glb", COLOURS * np.nan, "colours of the mesh are not finite"),
    ],
)
def test_vertex_colours_that_cannot_be_written_are_refused(
    tmp_path: Path, name: str, colours: np.ndarray, told: str
) -> None:
    with pytest.raises(InputError, match=told):
        write_coloured_glb(tmp_path / name, BALL_MESH, colours)
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(
    find_validator() is None, reason="needs Node and gltf-validator (make test installs it where there is npm)"
)
def test_khronos_has_nothing_to_say_of_colours_alone(tmp_path: Path) -> None:
    write_coloured_glb(tmp_path / "a.glb", BALL_MESH, COLOURS)
    write_glb(tmp_path / "b.glb", SPHERE, MaterialImages(make_images().base_colour))
    assert complaints(validate(tmp_path / "a.glb")) == complaints(validate(tmp_path / "b.glb")) == []
