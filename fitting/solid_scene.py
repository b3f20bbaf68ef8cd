"""Meshes carved of solid textures, in one picture with the views they were made of, as colour plate 2 of Dischler,
Ghazanfarpour and Freydier (Eurographics 1998).

    python fitting/solid_scene.py FOLDER --meshes MESHES -o scene.png

FOLDER holds pictures as fitting/solids.py takes them; MESHES the bunny, the teapot, the cow and the
armadillo. Each pixel has the colour of the solid where it sees the mesh: no detail is lost between vertices.
"""

import argparse
import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

import numpy as np
from raster import Floats, View, average_samples, look_at, project, rasterise
from skimage.transform import resize
from solids import KEY, METHODS, read_views

import jaxtex as jt
from jaxtex.cli.progress import progress
from jaxtex.core.colour import srgb_to_linear
from jaxtex.io.meshes import read_mesh, smooth_normals
from jaxtex.material.carving import place_mesh

SIDE = 192
SIZE = 1200, 560
SAMPLES = 2
STRIP = 150  # pixels, to the views below the picture
VIEW = View(np.array([0.0, 2.5, 8.5]), np.array([0.0, 0.68, 0.0]), 4.9)
LAMP = np.array([-4.0, 7.0, 5.0])
LAMP_RADIUS, LAMP_LIGHT, SKY_LIGHT = 0.5, 0.95, 0.6
GLOSS, SHININESS = 0.08, 60.0
LAMPS, SKY_LAMPS, SHADOW_SIZE = 12, 40, (900, 900)
GROUND = 0.62, 0.60, 0.57
MOST_SKY = 0.9  # of how the ground fades into what is behind


class Thing(NamedTuple):
    """What stands in the scene: a mesh's file, how tall it is, where, and how it is turned (degrees).

    `repeated` is how often the block fits into the longest side of the mesh.
    """

    file: str
    material: str
    height: float
    place: tuple[float, float]
    turn: float
    repeated: float


THINGS = (
    Thing("stanford_bunny.obj", "marble", 1.55, (-2.55, 0.0), 10, 1.5),
    Thing("utah_teapot.obj", "wood, two views", 1.15, (-0.85, 0.55), -20, 1.3),
    Thing("armadillo_43k.ply", "granite", 1.75, (0.95, -0.15), -15, 1.5),
    Thing("spot.obj", "onyx", 1.45, (2.55, 0.2), 145, 1.3),
)


class Scene(NamedTuple):
    """All triangles together.

    Attributes:
        vertices, normals: [vertex, 3], y up.
        faces: [face, 3].
        points: where vertices lie in their solid, [vertex, 3].
        thing: of each face, its number.
    """

    vertices: Floats
    normals: Floats
    faces: np.ndarray
    points: Floats
    thing: np.ndarray


def place_things(folder: Path, things: Sequence[Thing]) -> Scene:
    """Put meshes on the ground."""
    parts, first = [], 0
    for number, thing in enumerate(things):
        mesh = read_mesh(folder / thing.file)
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        middle = (low + high) / 2
        points = place_mesh(mesh, longest=thing.repeated * SIDE) + SIDE / 2
        angle = np.radians(thing.turn)
        turned = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
        stood = (mesh.vertices - [middle[0], low[1], middle[2]]) * (thing.height / (high - low)[1]) @ turned.T
        vertices = stood + np.array([thing.place[0], 0, thing.place[1]])
        owner = np.full(len(mesh.faces), number)
        parts.append(Scene(vertices, smooth_normals(vertices, mesh.faces), mesh.faces + first, points, owner))
        first += len(vertices)
    return Scene(*map(np.concatenate, zip(*parts, strict=True)))


def list_lamps() -> list[tuple[Floats, float]]:
    """Where light comes from, and how strong it is: points of a lamp, and of a sky that is brightest at the top."""
    rng = np.random.default_rng(0)
    around = rng.normal(size=(LAMPS, 3))
    lamp = [(LAMP + LAMP_RADIUS * each, LAMP_LIGHT / LAMPS) for each in around]
    number = np.arange(SKY_LAMPS) + 0.5
    up, angle = np.sqrt(number / SKY_LAMPS), np.pi * (3 - np.sqrt(5)) * number
    level = np.sqrt(1 - up**2)
    sky = 12 * np.stack([level * np.cos(angle), up, level * np.sin(angle)], axis=1)
    return lamp + [(each, SKY_LIGHT / SKY_LAMPS / height) for each, height in zip(sky, up, strict=True)]


def light_points(scene: Scene, points: Floats, normals: Floats) -> tuple[Floats, Floats]:
    """How much light falls on points [point, 3], and how much of it they reflect as a polished surface does."""
    diffuse, glossy = np.zeros(len(points)), np.zeros(len(points))
    to_eye = VIEW.eye - points
    to_eye /= np.linalg.norm(to_eye, axis=1, keepdims=True)
    for number, (lamp, light) in progress(list(enumerate(list_lamps())), "lighting", total=LAMPS + SKY_LAMPS):
        to_lamp = lamp - points
        to_lamp /= np.linalg.norm(to_lamp, axis=1, keepdims=True)
        aside = np.einsum("pk,pk->p", normals, to_lamp)
        lit = np.where(is_lit(scene, points + 0.01 * normals, lamp), np.clip(aside, 0, None), 0)
        diffuse += light * lit
        if number < LAMPS:
            half = to_lamp + to_eye
            half /= np.linalg.norm(half, axis=1, keepdims=True)
            shine = np.clip(np.einsum("pk,pk->p", normals, half), 0, None) ** SHININESS
            glossy += GLOSS * SHININESS / 8 * light * shine * (lit > 0)
    return diffuse, glossy


def is_lit(scene: Scene, points: Floats, lamp: Floats) -> np.ndarray:
    """Whether a lamp sees points: whether anything is nearer to it there."""
    distance = np.linalg.norm(lamp - [0.0, 0.6, 0.0])
    view = View(lamp, np.array([0.0, 0.6, 0.0]), distance / 4.2)
    depth = rasterise(scene.vertices, scene.faces, view, SHADOW_SIZE).away
    pixels, away = project(points, view, SHADOW_SIZE)
    columns, rows = np.floor(pixels).astype(int).T
    inside = (columns >= 0) & (columns < SHADOW_SIZE[0]) & (rows >= 0) & (rows < SHADOW_SIZE[1])
    nearest = depth[np.where(inside, rows, 0), np.where(inside, columns, 0)]
    return ~inside | (away < nearest + 0.02)


def draw_scene(scene: Scene, solids: Sequence[jt.Solid], size: tuple[int, int] = SIZE) -> np.ndarray:
    """The picture, linear light."""
    fine = SAMPLES * size[0], SAMPLES * size[1]
    seen = rasterise(scene.vertices, scene.faces, VIEW, fine)
    picture = np.zeros((*seen.face.shape, 3))
    met = seen.face >= 0
    faces, share = scene.faces[seen.face[met]], seen.share[met]
    place, normal, point = (
        np.einsum("pk,pkc->pc", share, each[faces]) for each in (scene.vertices, scene.normals, scene.points)
    )
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    towards = np.einsum("pk,pk->p", normal, VIEW.eye - place)
    normal *= np.where(towards < 0, -1.0, 1.0)[:, None]
    colour = np.empty_like(place)
    owner = scene.thing[seen.face[met]]
    for number, solid in enumerate(solids):
        colour[owner == number] = jt.evaluate_solid(solid, point[owner == number].astype(np.float32))
    diffuse, glossy = light_points(
        scene,
        np.concatenate([place, ground := meet_ground(fine)[~met]]),
        np.concatenate([normal, np.broadcast_to([0.0, 1.0, 0.0], ground.shape)]),
    )
    picture[met] = colour * diffuse[: len(place), None] + glossy[: len(place), None]
    fading = np.clip((np.linalg.norm(ground, axis=1) - 4) / 14, 0, MOST_SKY)[:, None]
    picture[~met] = (1 - fading) * np.array(GROUND) * diffuse[len(place) :, None] + fading * np.array(
        [0.80, 0.82, 0.85]
    )
    return average_samples(picture, SAMPLES)


def meet_ground(size: tuple[int, int]) -> Floats:
    """Where the ray of each pixel meets the ground, or what is as far away as that is at most, [row, col, 3]."""
    rows, columns = np.mgrid[: size[1], : size[0]] + 0.5
    focal = 0.5 * VIEW.lens * size[1]
    across, up = (columns - size[0] / 2) / focal, (size[1] / 2 - rows) / focal
    rays = np.stack([across, up, np.ones_like(up)], axis=-1) @ look_at(VIEW)
    return VIEW.eye + rays * (VIEW.eye[1] / np.maximum(-rays[..., 1], 0.05))[..., None]


def show_views(materials: Sequence[dict[str, np.ndarray]], width: int) -> np.ndarray:
    """A strip with the views of each solid."""
    strip, part = np.ones((STRIP, width, 3)), width // len(materials)
    for number, views in enumerate(materials):
        given = list({id(each): each for each in views.values()}.values())
        side = STRIP - 20
        row = np.concatenate(
            [
                np.pad(
                    resize(srgb_to_linear(each[:256, :256]), (side, side), anti_aliasing=True),
                    ((10, 10), (5, 5), (0, 0)),
                    constant_values=1,
                )
                for each in given
            ],
            axis=1,
        )
        start = number * part + (part - row.shape[1]) // 2
        strip[:, start : start + row.shape[1]] = row
    return strip


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="pictures of solids")
    parser.add_argument("--meshes", type=Path, required=True, metavar="MESHES", help="folder of meshes")
    parser.add_argument("-o", "--output", type=Path, required=True, help="the picture to write")
    parser.add_argument("--method", choices=METHODS, default="optimisation", help="how blocks are made (%(default)s)")
    options = parser.parse_args(words)
    materials = read_views(options.folder)
    scene = place_things(options.meshes, THINGS)
    chosen = [materials[thing.material] for thing in THINGS]
    make = METHODS[options.method]
    blocks = [make(views, SIDE, key=KEY) for views in progress(chosen, "carving", total=len(chosen))]
    picture = draw_scene(scene, [jt.make_solid(srgb_to_linear(block)) for block in blocks])
    jt.write_image(options.output, np.concatenate([picture, show_views(chosen, picture.shape[1])]))


if __name__ == "__main__":
    main()
