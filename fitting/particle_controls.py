"""Control over texture particles: whether each control does what it says, and how that looks.

    python fitting/particle_controls.py -o OUT [FOLDER]

Of scikit-image's coins, of spots and leaves that are drawn here, and of the pictures in FOLDER if one is given.
OUT/particle_controls.md says, of about 1,000 particles each, without drawing:

- density: how many times as many there are where twice and half as many are asked for;
- size: by which power of the size, which halves from side to side, the distance to the nearest neighbour changes (1);
- turned: of a field that turns by 60 degrees from top to bottom, by how many degrees neighbours' mean direction is off
  (only where they have one), and drawn particles' longer axis (median; only of slender ones);
- forbidden: centres in a disc where none may be, and how many there were before;
- distance: the least one there is, as a share of the one that is asked for, 1.3 times the mean to the nearest before;
- seen: the share of particles that are seen with probability 0.3;
- light: by which factor red is there where half is asked for.

OUT/particle_controls.png has a row for each picture: as it is arranged, smaller towards the centre, of random sizes,
turning from top to bottom, sparser from left to right, none in a disc and coloured around it. OUT/mixed.png has leaves
on the mortar of a wall.
"""

import argparse
import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

import jax
import numpy as np
from scipy.spatial import cKDTree
from skimage import data
from skimage.measure import regionprops
from tables import make_table

import jaxtex as jt
from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
from jaxtex.io.files import atomic_write_text, prepare_folder

KEY = jax.random.key(0)
SIDE = 512  # of the drawn ones, pixels
PLACED = 1000  # particles of the measured ones, about
HALF_TURN = np.radians(60)
SLENDER = 1.5  # times as long as wide: particles whose direction is seen
DIRECTED = 0.2  # of 1: how alike directions of neighbours are at least where there is one to speak of


class Exemplar(NamedTuple):
    picture: np.ndarray  # encoded, [row, col, channel]
    things: jt.Decomposition
    arrangement: object

    def seed(self, side: int, *controls: jt.Control) -> jt.Composition:
        return jt.seed_composition(self.things, self.arrangement, (side, side), key=KEY, controls=controls)


def make_exemplar(picture: np.ndarray, things: jt.Decomposition | None = None) -> Exemplar:
    found = jt.find_particles(picture) if things is None else things
    encoded = np.broadcast_to(linear_to_srgb(picture.astype(np.float32)), (*picture.shape[:2], 3))
    return Exemplar(encoded, found, jt.learn_arrangement(found))


def draw_ellipses(
    points: np.ndarray, size: tuple[int, int], radii: tuple[float, float], angles: np.ndarray, seed: int
) -> Exemplar:
    """Ellipses of one class and many colours on a dark ground with grain."""
    rng = np.random.default_rng(seed)
    row, column = np.indices(size[::-1]) + 0.5
    labels = np.zeros(size[::-1], int)
    for number, ((x, y), angle) in enumerate(zip(points, angles, strict=True), 1):
        along = (column - x) * np.cos(angle) + (row - y) * np.sin(angle)
        across = (row - y) * np.cos(angle) - (column - x) * np.sin(angle)
        labels[np.hypot(along / radii[0], across / radii[1]) < 1] = number
    colours = rng.uniform(0.6, 1.4, (len(points) + 1, 1)) * np.array([[0.25, 0.5, 0.08]])
    colours[0] = 0.05, 0.04, 0.03
    picture = colours[labels] * rng.normal(1, 0.1, (*labels.shape, 1))
    return make_exemplar(np.clip(picture, 0, 1), jt.describe_particles(labels, [0] * (len(np.unique(labels)) - 1)))


def draw_spots() -> Exemplar:
    """Slender spots on a lattice that is a little uneven, all one way."""
    rng = np.random.default_rng(0)
    row, column = np.mgrid[-1:9, -1:9].reshape(2, -1)
    points = np.stack([column * 34.0 + 17 * (row % 2), row * 30.0], axis=1) + rng.normal(0, 1.2, (100, 2))
    return draw_ellipses(points, (240, 240), (12.0, 6.0), rng.normal(0.3, 0.1, 100), 1)


def draw_leaves() -> Exemplar:
    """Leaves strewn at random, any way."""
    rng = np.random.default_rng(2)
    points = rng.uniform(0, 240, (400, 2))
    kept: list[np.ndarray] = []
    for point in points:
        if all(np.hypot(*(point - each)) > 21 for each in kept):
            kept.append(point)
    return draw_ellipses(np.array(kept), (240, 240), (9.0, 5.0), rng.uniform(0, np.pi, len(kept)), 3)


def draw_wall() -> Exemplar:
    """Bricks in white mortar."""
    rng = np.random.default_rng(4)
    row, column = np.indices((240, 320))
    course, shifted = row // 40, column + 40 * (row // 40 % 2)
    brick = shifted // 80
    labels = np.where((row % 40 >= 12) & (shifted % 80 >= 12), 1 + course * 8 + brick, 0)
    tones = rng.uniform(0.7, 1.3, (labels.max() + 1, 1)) * np.array([[0.35, 0.12, 0.08]])
    tones[0] = 0.6, 0.58, 0.54
    picture = np.clip(tones[labels] * rng.normal(1, 0.12, (240, 320, 1)), 0, 1)
    return make_exemplar(picture, jt.describe_particles(labels, [0] * (len(np.unique(labels)) - 1)))


def on_plane(composed: jt.Composition) -> jt.Composition:
    x, y = composed.x, composed.y
    return composed.select((x >= 0) & (x < composed.width) & (y >= 0) & (y < composed.height))


def nearest_ways(composed: jt.Composition) -> tuple[np.ndarray, np.ndarray]:
    """From each particle to the nearest of its class, as complex numbers; 0 where there is none, and which have one."""
    ways = np.zeros(len(composed), complex)
    for kind in np.unique(composed.kinds):
        own = np.flatnonzero(composed.kinds == kind)
        if len(own) > 1:
            points = np.stack([composed.x[own], composed.y[own]], axis=1)
            index = cKDTree(points).query(points, 2)[1][:, 1]
            ways[own] = (points[index] - points) @ np.array([1, 1j])
    return ways, np.abs(ways) > 0


def measure_density(exemplar: Exemplar, side: int) -> str:
    counts = [len(on_plane(exemplar.seed(side, jt.Control(density=density)))) for density in (1.0, 2.0, 0.5)]
    return f"{counts[1] / counts[0]:.2f}, {counts[2] / counts[0]:.2f}"


def measure_size(exemplar: Exemplar, side: int) -> str:
    """The slope, in logarithms, over bands of the plane: mean distances are in proportion to sizes."""
    size = jt.linear_field((0, 0), (side, 0), 1.0, 0.5)
    composed = on_plane(exemplar.seed(side, jt.Control(size=size)))
    ways, there = nearest_ways(composed)
    order = np.array_split(np.argsort(composed.x[there]), 8)
    distances = [np.abs(ways[there])[band].mean() for band in order]
    sizes = [composed.scales[there][band].mean() for band in order]
    return f"{np.polyfit(np.log(sizes), np.log(distances), 1)[0]:.2f}"


def measure_turn(exemplar: Exemplar, side: int) -> tuple[str, str]:
    field = jt.linear_field((0, 0), (0, side), 0.0, HALF_TURN)
    plain, turned = (on_plane(exemplar.seed(side, *each)) for each in ((), (jt.Control(orientation=field),)))
    best, off = 0.0, "-"
    for fold in (2, 4, 6):
        ways, there = nearest_ways(plain)
        usual = np.mean((ways[there] / np.abs(ways[there])) ** fold)
        ways, there = nearest_ways(turned)
        back = ways[there] / np.abs(ways[there]) * np.exp(-1j * turned.angles[there])
        if abs(usual) > max(best, DIRECTED):
            best, off = abs(usual), f"{abs(np.degrees(np.angle(np.mean(back**fold) / usual))) / fold:.1f}"
    boxes = [each.box for each in exemplar.things.particles]
    labels = jt.label_composition(turned, exemplar.things)
    errors = []
    for region in regionprops(labels):
        box = boxes[turned.particles[region.label - 1]]
        if box.width > SLENDER * box.height and region.area > 0.8 * exemplar_area(exemplar, turned, region.label - 1):
            # scikit-image measures from the rows' direction, downward.
            seen = np.pi / 2 - region.orientation
            y = np.clip(turned.y[region.label - 1], 0, side)
            wanted = own_axis(exemplar, turned.particles[region.label - 1]) + field(np.zeros(()), y)
            errors.append(abs((seen - wanted + np.pi / 2) % np.pi - np.pi / 2))
    return off, f"{np.degrees(np.median(errors)):.1f}" if len(errors) > 10 else "-"


def exemplar_area(exemplar: Exemplar, composed: jt.Composition, index: int) -> float:
    return exemplar.things.particles[composed.particles[index]].area * composed.scales[index] ** 2


def own_axis(exemplar: Exemplar, number: int) -> float:
    """A particle's longer axis in the picture, from its pixels, as that of drawn ones is measured."""
    return np.pi / 2 - regionprops((exemplar.things.labels == number + 1).astype(int))[0].orientation


def measure_forbidden(exemplar: Exemplar, side: int) -> str:
    centre, radius = (0.5 * side, 0.5 * side), 0.25 * side
    kept = jt.radial_field(centre, radius, 0.0, 1.0, softness=0.0)
    counts = [
        int((np.hypot(each.x - centre[0], each.y - centre[1]) < radius).sum())
        for each in (exemplar.seed(side, jt.Control(probability=kept)), exemplar.seed(side))
    ]
    return f"{counts[0]} of {counts[1]}"


def measure_distance(exemplar: Exemplar, side: int) -> str:
    ways, there = nearest_ways(on_plane(exemplar.seed(side)))
    asked = 1.3 * float(np.abs(ways[there]).mean())
    ways, there = nearest_ways(exemplar.seed(side, jt.Control(least_distance=asked)))
    return f"{np.abs(ways[there]).min() / asked:.2f}"


def measure_probability(exemplar: Exemplar, side: int) -> str:
    counts = [len(exemplar.seed(side, jt.Control(probability=probability))) for probability in (0.3, 1.0)]
    return f"{counts[0] / counts[1]:.2f}"


def measure_light(exemplar: Exemplar) -> str:
    """Where particles are seen, and there is red."""
    black = np.zeros((SIDE, SIDE, 3), np.float32)
    plain, dimmed = exemplar.seed(SIDE), exemplar.seed(SIDE, jt.Control(colour=(0.5, 1.0, 1.0)))
    before = srgb_to_linear(jt.paint_composition(plain, exemplar.picture, exemplar.things, black))[..., 0]
    plain_labels, labels = (jt.label_composition(each, exemplar.things) for each in (plain, dimmed))
    after = srgb_to_linear(jt.paint_composition(dimmed, exemplar.picture, exemplar.things, black))[..., 0]
    # The same particles, however chance has placed them.
    return f"{after[labels > 0].mean() / before[plain_labels > 0].mean():.2f}"


def measure(name: str, exemplar: Exemplar) -> list[str]:
    density = sum(rule.density for rule in exemplar.arrangement.classes)
    side = round((PLACED / density) ** 0.5)
    return [
        name,
        measure_density(exemplar, side),
        measure_size(exemplar, side),
        *measure_turn(exemplar, side),
        measure_forbidden(exemplar, side),
        measure_distance(exemplar, side),
        measure_probability(exemplar, side),
        measure_light(exemplar),
    ]


def draw_row(exemplar: Exemplar) -> np.ndarray:
    centre = (0.5 * SIDE, 0.5 * SIDE)
    around = jt.radial_field(centre, 0.35 * SIDE, 1.0, 0.0, softness=0.0)
    choices = [
        [],
        [jt.Control(size=jt.radial_field(centre, 0.6 * SIDE, 0.35, 1.0))],
        [jt.Control(size_variation=0.6)],
        [jt.Control(orientation=jt.linear_field((0, 0), (0, SIDE), 0.0, HALF_TURN))],
        [jt.Control(density=jt.linear_field((0, 0), (SIDE, 0), 1.0, 0.1))],
        [jt.Control(probability=0.0, where=jt.radial_field(centre, 0.2 * SIDE, 1.0, 0.0, softness=0.0)),
         jt.Control(colour=(1.6, 0.6, 0.4), where=around)],
    ]  # fmt: skip
    ground = jt.make_ground(exemplar.picture, exemplar.things, (SIDE, SIDE), key=KEY)
    drawn = [
        jt.paint_composition(exemplar.seed(SIDE, *controls), exemplar.picture, exemplar.things, ground)
        for controls in choices
    ]
    return np.concatenate(drawn, axis=1)


def draw_mixed(wall: Exemplar, leaves: Exemplar) -> np.ndarray:
    """A wall with all leaves, and with those alone whose centres are on its mortar."""
    bricks = wall.seed(SIDE)
    ground = jt.make_ground(wall.picture, wall.things, (SIDE, SIDE), key=KEY)
    drawn = jt.paint_composition(bricks, wall.picture, wall.things, ground)
    mortar = jt.map_field(jt.label_composition(bricks, wall.things) == 0, (SIDE, SIDE))
    strewn = jt.Control(density=2.0, size=0.8), jt.Control(probability=mortar)
    mixed = [
        jt.paint_composition(leaves.seed(SIDE, *controls), leaves.picture, leaves.things, drawn, halos=False)
        for controls in (strewn[:1], strewn)
    ]
    return np.concatenate([drawn, *mixed], axis=1)


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?", help="pictures made of things")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT", help="folder for what is made")
    options = parser.parse_args(words)
    prepare_folder(options.output)
    coins = srgb_to_linear(data.coins()[..., None] / 255.0)
    exemplars = {"coins": make_exemplar(coins), "spots": draw_spots(), "leaves": draw_leaves()}
    names = (
        sorted(path for path in options.folder.iterdir() if path.suffix in (".png", ".jpg")) if options.folder else []
    )
    exemplars |= {path.name: make_exemplar(jt.read_image(path).pixels) for path in names}
    head = ["picture", "density", "size", "turned", "drawn", "forbidden", "distance", "seen", "light"]
    rows = []
    for name, exemplar in exemplars.items():
        rows.append(measure(name, exemplar))
        print(*rows[-1], sep=" | ", flush=True)
    atomic_write_text(options.output / "particle_controls.md", make_table(head, rows) + "\n")
    sheet = np.concatenate([draw_row(each) for each in exemplars.values()])
    jt.write_image(options.output / "particle_controls.png", np.clip(srgb_to_linear(sheet), 0, 1))
    jt.write_image(options.output / "mixed.png", srgb_to_linear(draw_mixed(draw_wall(), exemplars["leaves"])))


if __name__ == "__main__":
    main()
