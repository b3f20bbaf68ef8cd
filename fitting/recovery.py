"""Known tilings -> hard masks, dirtied -> fits: how near the fitted parameters come to the known ones.

The counterpart of Lefebvre & Poulin's table 1, for tilings. The masks are made here in plain NumPy by asking of every
pixel's centre whether it lies in a tile: nothing of the library's renderer stands on both sides of the comparison.

    python fitting/recovery.py --count 200 --seed 0
"""

import argparse
import os
from typing import NamedTuple

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

import numpy as np
from numpy.typing import NDArray
from tables import make_table

import jaxtex as jt
from jaxtex.cli.progress import progress
from jaxtex.models.canonical import canonical

SIZE = 256
BONDS = ("stack", "running", "raking", "irregular")
FLIPPED, BLOTCHED = 0.1, 0.1
CAPTURED = {"pitch %": 1.0, "angle °": 0.5, "offset": 0.05}
MEASURES = (*CAPTURED, "joint px")


class Wall(NamedTuple):
    """A tiling in plain numbers: pixels, radians, and shifts of tile widths. ``shifts`` of the courses, repeated."""

    bond: str
    width: float
    height: float
    angle: float
    joint_x: float
    joint_y: float
    offset: float
    origin: NDArray[np.float64]
    shifts: NDArray[np.float64]


def draw_wall(bond: str, random: np.random.Generator) -> Wall:
    """A wall at random."""
    width, height = np.exp(random.uniform(np.log(24), np.log(96), 2))
    offset = {
        "stack": 0.0,
        "running": 0.5,
        "raking": random.choice([-1, 1]) * random.uniform(0.15, 0.4) % 1.0,
        "irregular": 0.0,
    }[bond]
    return Wall(
        bond=bond,
        width=width,
        height=height,
        angle=np.radians(random.uniform(-45, 45)),
        joint_x=random.uniform(2, min(12, 0.4 * width)),
        joint_y=random.uniform(2, min(12, 0.4 * height)),
        offset=offset,
        origin=random.uniform(0, SIZE, 2),
        shifts=random.uniform(0, 1, 64) if bond == "irregular" else np.zeros(1),
    )


def draw_mask(wall: Wall) -> NDArray[np.bool_]:
    """True where the centre of a pixel lies in a tile."""
    y, x = np.indices((SIZE, SIZE)) + 0.5
    x, y = x - wall.origin[0], y - wall.origin[1]
    along = np.cos(wall.angle) * x + np.sin(wall.angle) * y
    across = np.cos(wall.angle) * y - np.sin(wall.angle) * x
    course = np.floor(across / wall.height).astype(int)
    down = across - course * wall.height
    shift = wall.offset * course + wall.shifts[course % len(wall.shifts)]
    right = np.mod(along - shift * wall.width, wall.width)
    in_x = (right > wall.joint_x / 2) & (right < wall.width - wall.joint_x / 2)
    in_y = (down > wall.joint_y / 2) & (down < wall.height - wall.joint_y / 2)
    return in_x & in_y


def spoil_mask(mask: NDArray[np.bool_], random: np.random.Generator) -> NDArray[np.bool_]:
    """Blotches, each all tile or all joint, over a tenth of the mask, and a tenth of the pixels turned over."""
    spoilt, covered = mask.copy(), np.zeros_like(mask)
    y, x = np.indices(mask.shape) + 0.5
    while covered.mean() < BLOTCHED:
        centre, radius = random.uniform(0, SIZE, 2), random.uniform(4, 16)
        blotch = np.hypot(x - centre[0], y - centre[1]) < radius
        spoilt[blotch] = random.random() < 0.5
        covered |= blotch
    return spoilt ^ (random.random(mask.shape) < FLIPPED)


def tiling_of(wall: Wall) -> jt.Tiling:
    """The wall as the library's model."""
    return jt.make_tiling(
        tile_width=wall.width,
        tile_height=wall.height,
        angle=wall.angle,
        mortar_x=wall.joint_x,
        mortar_y=wall.joint_y,
        offset=wall.offset,
        origin=wall.origin,
        course_offsets=wall.shifts,
        bond=wall.bond,
    )


def find_errors(wall: Wall, found: jt.Tiling) -> dict[str, float]:
    """How far a tiling is from a wall, by measure; no number where the bond has no such thing."""
    truth = canonical(tiling_of(wall))
    pitches = [abs(float(getattr(found, name) / getattr(truth, name)) - 1) for name in ("tile_width", "tile_height")]
    joints = [abs(float(getattr(found, name) - getattr(truth, name))) for name in ("mortar_x", "mortar_y")]
    turn = np.degrees(float(found.angle) - float(truth.angle))
    aside = float(found.offset) - float(truth.offset)
    return {
        "pitch %": 100 * max(pitches),
        "angle °": abs((turn + 90) % 180 - 90),
        "offset": np.nan if wall.bond == "irregular" else abs((aside + 0.5) % 1 - 0.5),
        "joint px": max(joints),
    }


def is_captured(errors: dict[str, float]) -> bool:
    """Whether these errors are those of a fit that found the wall."""
    return not any(errors[name] > limit for name, limit in CAPTURED.items())


def summarise(name: str, trials: list[tuple[dict[str, float], dict[str, float]]]) -> list[str]:
    """One row of the table: for each measure the median and the 90 % quantile, start and refined."""
    cells = [name, str(len(trials)), f"{np.mean([is_captured(refined) for _, refined in trials]):.1%}"]
    for measure in MEASURES:
        parts = []
        for stage in range(2):
            values = np.array([trial[stage][measure] for trial in trials])
            values = values[np.isfinite(values)]
            parts.append("{:.2g}, {:.2g}".format(*np.quantile(values, (0.5, 0.9))) if len(values) else "-")
        cells.append(" → ".join(parts))
    return cells


def main() -> None:
    """Run the trials and print the table."""
    parser = argparse.ArgumentParser(description="Fit known tilings, and tell how near the fits come.")
    parser.add_argument("--count", type=int, default=200, help="how many masks (default: 200)")
    parser.add_argument("--seed", type=int, default=0, help="of the walls and their dirt (default: 0)")
    chosen = parser.parse_args()
    trials: dict[str, list[tuple[dict[str, float], dict[str, float]]]] = {bond: [] for bond in BONDS}
    for number in progress(range(chosen.count), "fitting masks"):
        random = np.random.default_rng([chosen.seed, number])
        wall = draw_wall(BONDS[number % len(BONDS)], random)
        mask = spoil_mask(draw_mask(wall), random).astype(np.float32)
        fit = jt.fit_tiling(mask, mask=mask)
        errors = find_errors(wall, fit.start), find_errors(wall, fit.tiling)
        trials[wall.bond].append(errors)
        if not (is_captured(errors[1]) and fit.ok):
            told = ", ".join(f"{name} {value:.3g}" for name, value in errors[1].items())
            print(f"mask {number} ({wall.bond}): {told}; {'ok' if fit.ok else fit.reason}", flush=True)
    print(f"\n{chosen.count} masks of {SIZE} x {SIZE}, seed {chosen.seed}; errors: median, 90 %; start → refined\n")
    rows = [summarise(bond, done) for bond, done in trials.items() if done]
    rows.append(summarise("all", [trial for done in trials.values() for trial in done]))
    print(make_table(("bond", "masks", "captured", *MEASURES), rows))


if __name__ == "__main__":
    main()
