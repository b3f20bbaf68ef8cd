"""Photographs whose tilings are known -> fits -> a table of errors, and whether they are small enough.

A folder with a manifest.csv: columns ``file``, ``class``, ``rows``, ``cols``, ``offset`` and ``angle_deg`` (courses and
tiles per course in a picture that repeats), and beside a warped picture a .json with the exact homography from the
picture it was made of (``H_base_px_to_image_px``, ``course_pitch_base_px``, ``column_pitch_base_px``, ``offset``).
Pictures of other things (folders ``natural`` and ``solids``, single boards of ``wood``, herringbone) must be refused.

    python fitting/accuracy.py FOLDER
"""

import argparse
import csv
import json
import os
import re
import time
from pathlib import Path
from typing import Any, NamedTuple

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

import jax
import numpy as np
from numpy.typing import NDArray
from tables import make_table

import jaxtex as jt
from jaxtex.cli.progress import progress

PITCH, ANGLE, OFFSET, CORNER = 0.5, 0.1, 0.02, 1.0  # %, degrees, tiles, % of the tile height
ROUGHLY = 4.0  # % of a width that the manifest itself gives as about so many tiles
FALSE_YES = 1  # pictures of other things that may be taken for tilings
_BOARDS = re.compile("flat-sawn|straight grain|quarter-sawn|end grain", re.IGNORECASE)

Record = dict[str, str]


class Result(NamedTuple):
    """What was measured of one picture, in words, and whether it is good enough (None where there is no truth)."""

    measured: str
    good: bool | None


def judge(record: Record, path: Path, photo: jt.Image, fit: jt.TilingFit) -> Result:
    """Compare a fit with what the manifest knows of the picture."""
    if is_other(record):
        return Result("refused" if not fit.ok else "taken for a tiling", not fit.ok)
    warp = path.with_suffix(".json")
    if warp.exists() and "H_base_px_to_image_px" in (truth := json.loads(warp.read_text(encoding="utf-8"))):
        error = find_corner_error(fit.tiling, truth, (photo.width, photo.height))
        return Result(f"corners {error:.2f} %", fit.ok and error <= CORNER)
    if not (record["rows"].isdecimal() and _is_number(record["angle_deg"])):
        return Result("no truth", None)
    return judge_pitches(record, photo, fit)


def is_other(record: Record) -> bool:
    """Whether the picture shows no rectangular tiling."""
    folder, kind = record["file"].split("/")[0], record["class"]
    if folder in ("natural", "solids"):
        return "coins" not in kind and "map" not in kind
    return "herringbone" in kind or (folder == "wood" and bool(_BOARDS.search(kind)))


def judge_pitches(record: Record, photo: jt.Image, fit: jt.TilingFit) -> Result:
    """A picture that repeats: its size and its numbers of tiles give the pitches."""
    checks: list[tuple[str, float, float]] = []
    tiling, columns = fit.tiling, re.match(r"~?([\d.]+)", record["cols"])
    checks.append(("height %", 100 * abs(float(tiling.tile_height) * int(record["rows"]) / photo.height - 1), PITCH))
    if columns:
        error = 100 * abs(float(tiling.tile_width) * float(columns[1]) / photo.width - 1)
        checks.append(("width %", error, ROUGHLY if record["cols"].startswith("~") else PITCH))
    angle = np.degrees(float(tiling.angle)) - float(record["angle_deg"])
    checks.append(("angle °", abs((angle + 90) % 180 - 90), ANGLE))
    if _is_number(record["offset"]):
        aside = float(tiling.offset) - float(record["offset"])
        checks.append(("offset", abs((aside + 0.5) % 1 - 0.5), OFFSET))
    named = next((bond for bond in ("english", "flemish") if bond in record["class"].lower()), None)
    good = fit.ok and all(error <= limit for _, error, limit in checks) and named in (None, tiling.bond)
    return Result(", ".join(f"{name} {error:.3f}" for name, error, _ in checks), good)


def find_corner_error(tiling: jt.Tiling, truth: dict[str, Any], size: tuple[int, int]) -> float:
    """Largest distance, in % of the tile height, of the lattice's corners in the picture from the true ones.

    The homography tells the true lattice but for where it begins; that is taken from the fit.
    """
    width, height = size
    x, y = np.meshgrid(np.linspace(0, width, 40), np.linspace(0, height, 40))
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    to_base = np.linalg.inv(np.array(truth["H_base_px_to_image_px"]))
    base = points @ to_base[:, :2].T + to_base[:, 2]
    base = base[:, :2] / base[:, 2:] / [truth["column_pitch_base_px"], truth["course_pitch_base_px"]]
    found = np.asarray(jax.vmap(tiling.to_lattice)(points)) / [float(tiling.tile_width), float(tiling.tile_height)]
    true, found = _number_nodes(base, truth["offset"]), _number_nodes(found, float(tiling.offset))
    change = np.round(np.linalg.lstsq(np.c_[true, np.ones(len(true))], found, rcond=None)[0][:2])
    if abs(abs(np.linalg.det(change)) - 1) > 1e-6:
        return float("inf")  # another lattice
    aside = found - true @ change
    aside -= np.median(aside, axis=0)

    def to_image(nodes: NDArray[np.float64]) -> NDArray[np.float64]:
        along = nodes[:, 0] + float(tiling.offset) * nodes[:, 1]
        q = np.stack([along * float(tiling.tile_width), nodes[:, 1] * float(tiling.tile_height)], axis=1)
        return np.asarray(jax.vmap(tiling.from_lattice)(q))

    tile = np.linalg.norm(to_image(found + np.array([-float(tiling.offset), 1.0])) - points, axis=1)
    return float(100 * np.max(np.linalg.norm(to_image(found - aside) - points, axis=1)) / np.median(tile))


def _number_nodes(tiles: NDArray[np.float64], offset: float) -> NDArray[np.float64]:
    """Points in tile widths and heights -> coordinates that are whole at the lattice's nodes."""
    return np.stack([tiles[:, 0] - offset * tiles[:, 1], tiles[:, 1]], axis=1)


def _is_number(word: str) -> bool:
    return bool(re.fullmatch(r"-?\d+\.?\d*", word))


def main() -> None:
    """Fit every picture of the folder that can be judged, and print the table."""
    parser = argparse.ArgumentParser(description="Fit photographs of known tilings, and tell how good the fits are.")
    parser.add_argument("folder", type=Path, help="with a manifest.csv")
    folder = parser.parse_args().folder
    with (folder / "manifest.csv").open(encoding="utf-8", newline="") as file:
        records = [record for record in csv.DictReader(file) if record["file"].split("/")[0] != "meshes"]
    rows, tilings, others = [], [], []
    for record in progress(records, "fitting photographs"):
        path = folder / record["file"]
        photo = jt.read_image(path)
        began = time.perf_counter()
        fit = jt.fit_tiling(photo.pixels)
        seconds = time.perf_counter() - began
        result = judge(record, path, photo, fit)
        if result.good is not None:
            (others if is_other(record) else tilings).append(result.good)
        verdict = {True: "pass", False: "FAIL", None: ""}[result.good]
        rows.append(
            [record["file"], fit.tiling.bond, "yes" if fit.ok else "no", result.measured, verdict, f"{seconds:.1f}"]
        )
    print(make_table(("photograph", "bond", "tiling?", "measured", "", "s"), rows))
    print(f"\ntilings within their limits: {sum(tilings)} of {len(tilings)}")
    passed = "pass" if others.count(False) <= FALSE_YES else "FAIL"
    print(f"other things refused: {sum(others)} of {len(others)} ({passed}: all but {FALSE_YES} must be)")


if __name__ == "__main__":
    main()
