"""How fast particles are placed and drawn, and how small compositions are. Nothing here passes or fails.

python benchmarks/particles.py            # minutes; writes benchmarks/results/particles-cpu.md
python benchmarks/particles.py --only parts --most 1000
"""

import argparse
import gzip
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np
from timing import Result, Row, clock, seconds, show, write_report

import jaxtex as jt
from jaxtex.core.colour import srgb_to_linear

KEY = jax.random.key(0)
SIDE = 1024
PLACED = 1000  # particles on a plane of that side, about
COUNTS = (100, 1000, 10_000, 100_000)


class Exemplar(NamedTuple):
    picture: np.ndarray
    things: jt.Decomposition
    arrangement: Any


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", choices=["parts", "numbers", "sizes"], help="only this part")
    parser.add_argument("--most", type=int, default=COUNTS[-1], help="particles at most (default 100000)")
    options = parser.parse_args()
    exemplars = draw_exemplars()
    parts = {
        "parts": lambda: time_parts(exemplars),
        "numbers": lambda: time_numbers(exemplars, [count for count in COUNTS if count <= options.most]),
        "sizes": lambda: compare_sizes(exemplars),
    }
    results = [part() for name, part in parts.items() if options.only in (None, name)]
    show(results)
    if options.only is None:
        write_report("particles", "Speed of texture particles", results)


def draw_exemplars() -> dict[str, Exemplar]:
    """Pictures of 200 x 200, of discs and bricks of one class, each about 32 x 32 pixels with what is around it."""
    rng = np.random.default_rng(0)
    row, column = np.mgrid[-1:8, -1:8].reshape(2, -1)
    squares = np.stack([column * 32.0, row * 32.0], axis=1) + 9.3
    halved = np.stack([column * 44.0 + 22 * (row % 2), row * 23.0], axis=1) + 9.3
    strewn: list[np.ndarray] = []
    for point in rng.uniform(-20, 220, (4000, 2)):
        if all(np.hypot(*(point - each)) > 27 for each in strewn):
            strewn.append(point)
    anywhere = rng.uniform(-20, 220, (56, 2))
    return {
        "lattice of discs": draw(squares, (22, 22), discs=True),
        "bricks": draw(halved, (38, 18), discs=False),
        "discs apart": draw(np.array(strewn), (20, 20), discs=True),
        "discs anywhere": draw(anywhere, (12, 12), discs=True),
    }


def draw(points: np.ndarray, sides: tuple[float, float], *, discs: bool) -> Exemplar:
    rng = np.random.default_rng(1)
    row, column = np.indices((200, 200)) + 0.5
    labels = np.zeros((200, 200), int)
    for number, (x, y) in enumerate(points, 1):
        u, v = 2 * np.abs(column - x) / sides[0], 2 * np.abs(row - y) / sides[1]
        labels[(np.hypot(u, v) < 1) if discs else (np.maximum(u, v) < 1)] = number
    colours = rng.uniform(0.4, 0.9, (len(points) + 1, 3))
    colours[0] = 0.2
    picture = np.clip(colours[labels] * rng.normal(1, 0.1, (200, 200, 1)), 0, 1).astype(np.float32)
    things = jt.describe_particles(labels, [0] * (len(np.unique(labels)) - 1))
    return Exemplar(picture, things, jt.learn_arrangement(things))


def seed(exemplar: Exemplar, side: int, *controls: jt.Control) -> jt.Composition:
    return jt.seed_composition(
        exemplar.things, exemplar.arrangement, (side, side), key=KEY, tileable=True, controls=controls
    )


def side_for(exemplar: Exemplar, count: int) -> int:
    """Pixels along a side of the plane that so many particles are on."""
    return round((count / sum(rule.density for rule in exemplar.arrangement.classes)) ** 0.5)


def time_parts(exemplars: dict[str, Exemplar]) -> Result:
    """From a picture to another one, all but finding its things; the ground is made once for all compositions."""
    rows: list[Row] = []
    varied = jt.Control(size=jt.radial_field((SIDE / 2, SIDE / 2), SIDE / 2, 0.8, 1.1), orientation_variation=0.3)
    for name, (picture, things, arrangement) in exemplars.items():
        exemplar = Exemplar(picture, things, arrangement)
        ground = jt.make_ground(picture, things, (SIDE, SIDE), key=KEY)
        composed, controlled = seed(exemplar, SIDE), seed(exemplar, SIDE, varied)
        placing = clock(lambda exemplar=exemplar: seed(exemplar, SIDE))
        drawing, drawing_turned = (
            clock(lambda each=each: jt.paint_composition(each, picture, things, ground))  # noqa: B023
            for each in (composed, controlled)
        )
        rows.append(
            (
                name,
                str(len(composed)),
                seconds(clock(lambda: jt.learn_arrangement(things))),  # noqa: B023
                seconds(placing),
                seconds(clock(lambda exemplar=exemplar: seed(exemplar, SIDE, varied))),
                seconds(drawing),
                seconds(drawing_turned),
                seconds(placing + drawing),
            )
        )
    head = ("picture", "particles", "learnt", "placed", "under controls", "drawn", "turned and scaled", "both")
    return f"Seconds to {SIDE} x {SIDE} pixels: placed and drawn, warm", head, rows


def time_numbers(exemplars: dict[str, Exemplar], counts: list[int]) -> Result:
    rows: list[Row] = []
    for name, exemplar in exemplars.items():
        times = []
        for count in counts:
            side = side_for(exemplar, count)
            times.append(clock(lambda side=side: seed(exemplar, side), turns=2 if count < 100_000 else 1))  # noqa: B023
        power = np.polyfit(np.log(counts), np.log(times), 1)[0] if len(counts) > 1 else np.nan
        rows.append((name, *(seconds(each) for each in times), f"{power:.2f}"))
    return "Seconds to place particles, by their number", ("picture", *map(str, counts), "grows as power"), rows


def compare_sizes(exemplars: dict[str, Exemplar]) -> Result:
    """Bytes: the composition's file against the picture that it is drawn as; the exemplar is kept once for all."""
    rows: list[Row] = []
    for name, exemplar in exemplars.items():
        composed = seed(exemplar, SIDE)
        ground = jt.make_ground(exemplar.picture, exemplar.things, (SIDE, SIDE), key=KEY)
        with tempfile.TemporaryDirectory() as folder:
            written, drawn, own = (Path(folder) / each for each in ("composition.json", "drawn.png", "own.png"))
            jt.write_composition(written, composed)
            pixels = jt.paint_composition(composed, exemplar.picture, exemplar.things, ground)
            jt.write_image(drawn, srgb_to_linear(np.clip(pixels, 0, 1)))
            jt.write_image(own, srgb_to_linear(exemplar.picture))
            raw, png = written.stat().st_size, drawn.stat().st_size
            packed = len(gzip.compress(written.read_bytes()))
            picture = own.stat().st_size
        rows.append(
            (
                name,
                *(f"{each / 1000:.0f}" for each in (png, raw, packed, picture)),
                f"{png / packed:.0f}",
                f"{png / (packed + picture):.1f}",
            )
        )
    head = ("picture", "PNG", "composition", "with gzip", "exemplar's PNG", "PNG / gzip", "PNG / (gzip + exemplar)")
    return f"Size in kB, of {SIDE} x {SIDE} pixels", head, rows


if __name__ == "__main__":
    main()
