"""Lefebvre & Poulin's table 1 once more: drawn wood -> fit -> how far each parameter is off, beside their figures.

Ten patterns of 512 x 512 pixels; each parameter is varied alone, three values in each pattern. Pictures are drawn here
in plain NumPy, so that nothing of the library stands on both sides. `--turbulence` displaces the rings of all pictures
by 0.5 to 3 pixels; no estimator can then pass the floor that is printed beside (Cramer & Rao: a mean absolute error of
0.8 standard deviations), and a parameter is left out of an average where both the floor and the fit's own standard
error are beyond the row's bar. `--noise` chooses what displaces them: plane waves in the trunk, or filtered noise on
the plank.

    python fitting/table1.py -o fitting/table1
    python fitting/table1.py -o fitting/table1-turbulent --turbulence
    python fitting/table1.py -o fitting/table1-noise --turbulence --noise filtered
"""

import argparse
import csv
import os
from pathlib import Path
from typing import Any, NamedTuple

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from numpy.typing import NDArray
from tables import make_table

from jaxtex.cli.progress import progress
from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
from jaxtex.fitting.rings import GEOMETRY
from jaxtex.fitting.wood import fit_wood
from jaxtex.fitting.wood_displaced import bound_errors
from jaxtex.models.wood import Wood

SIZE = 512
PATTERNS = 10
# Of the paper: average and greatest error, per cent.
PAPER = {
    "tilt": (8.09, 14.29),
    "orientation": (0.35, 0.6),
    "frequency": (2.47, 12.34),
    "ratio": (5.5, 10.5),
    "turbulence": (10.3, 20.63),
    "xc": (2.71, 6.56),
    "yc": (2.27, 6.50),
    "early": (3.18, 4.94),
    "late": (2.79, 3.38),
    "oblique tilt": (36.0, 36.0),  # its one example, at 30 degrees
}
BAR = {
    "tilt": 0.8,
    "orientation": 0.035,
    "frequency": 0.25,
    "ratio": 0.55,
    "turbulence": 1.0,
    "xc": 0.27,
    "yc": 0.23,
    "early": 0.32,
    "late": 0.28,
    "oblique tilt": 1.0,
}
# The three values of each parameter lie in the lower, the middle and the upper third of its range.
RANGES = {
    "tilt": (1.0, 6.0),
    "orientation": (0.0, 180.0),
    "frequency": (1 / 45, 1 / 14),
    "ratio": (0.3, 0.7),
    "turbulence": (0.5, 3.0),
    "xc": (-200.0, 200.0),
    "yc": (-100.0, 100.0),
    "early": (0.55, 0.85),
    "late": (0.15, 0.45),
}
OBLIQUE = (15.0, 30.0, 45.0, 60.0, 75.0)
WAVELENGTHS = (120.0, 200.0)


class Plank(NamedTuple):
    """Plain numbers: pixels and degrees; ``early`` and ``late``, sRGB from 0 to 1, of which the hue follows."""

    xc: float
    yc: float
    tilt: float
    rotation: float
    spacing: float
    fraction: float
    early: float
    late: float
    rms: float
    wavelength: float


def draw_base(random: np.random.Generator, *, turbulent: bool) -> Plank:
    """One of the patterns."""
    tilt = random.uniform(1.5, 6.0) if random.random() < 0.7 else random.uniform(84.0, 88.5)
    return Plank(
        xc=random.uniform(*RANGES["xc"]),
        yc=random.uniform(*RANGES["yc"]),
        tilt=tilt,
        rotation=random.uniform(*RANGES["orientation"]),
        spacing=1 / random.uniform(*RANGES["frequency"]),
        fraction=random.uniform(*RANGES["ratio"]),
        early=random.uniform(*RANGES["early"]),
        late=random.uniform(*RANGES["late"]),
        rms=random.uniform(*RANGES["turbulence"]) if turbulent else 0.0,
        wavelength=random.uniform(*WAVELENGTHS),
    )


def vary(base: Plank, row: str, random: np.random.Generator) -> list[Plank]:
    """The pattern with one parameter at each of its values."""
    if row == "oblique tilt":
        return [base._replace(tilt=value) for value in OBLIQUE]
    low, high = RANGES[row]
    values = [low + (high - low) * (third + random.random()) / 3 for third in range(3)]
    if row == "tilt" and base.tilt > 45:
        values = [90.0 - value for value in values]
    if row == "frequency":
        return [base._replace(spacing=1 / value) for value in values]
    name = {"orientation": "rotation", "ratio": "fraction", "turbulence": "rms"}.get(row, row)
    changed = [base._replace(**{name: value}) for value in values]
    # Orientation means little on end grain, where it turns into the axis's place.
    return [each._replace(tilt=90 - each.tilt) if row == "orientation" and each.tilt > 75 else each for each in changed]


def lay_out(plank: Plank) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Across and along the grain, of pixel centres."""
    v, u = np.indices((SIZE, SIZE)) + 0.5 - SIZE / 2
    turn = np.radians(plank.rotation)
    return u * np.cos(turn) + v * np.sin(turn), v * np.cos(turn) - u * np.sin(turn)


def displace(plank: Plank, noise: str, random: np.random.Generator) -> NDArray[np.float64]:
    """How far turbulence moves the rings; in the picture, its mean is 0 and its root mean square is as wanted."""
    if plank.rms == 0:
        return np.zeros((SIZE, SIZE))
    if noise == "waves":
        across, along = lay_out(plank)
        field = np.zeros((SIZE, SIZE))
        for _ in range(48):
            direction = random.normal(size=3)
            direction *= np.exp(random.normal(0, 0.3)) / plank.wavelength / np.linalg.norm(direction)
            lean = np.radians(plank.tilt)
            depth = along * (direction[1] * np.sin(lean) + direction[2] * np.cos(lean))
            field += np.cos(2 * np.pi * (direction[0] * across + depth) + random.uniform(0, 2 * np.pi))
    else:
        frequency = np.hypot(np.fft.fftfreq(2 * SIZE)[:, None], np.fft.rfftfreq(2 * SIZE)[None])
        band = np.exp(-0.5 * ((frequency * plank.wavelength - 1) / 0.3) ** 2)
        field = np.fft.irfft2(np.fft.rfft2(random.normal(size=(2 * SIZE, 2 * SIZE))) * band)[:SIZE, :SIZE]
    field -= field.mean()
    return field * (plank.rms / field.std())


def draw_picture(plank: Plank, displacement: NDArray[np.float64]) -> NDArray[np.float32]:
    """The plank in linear light, from the geometry in the model file's description."""
    across, along = lay_out(plank)
    radius = np.hypot(across - plank.xc, along * np.sin(np.radians(plank.tilt)) - plank.yc) + displacement
    early = np.sin(2 * np.pi * radius / plank.spacing) > np.cos(np.pi * plank.fraction)
    hue = np.array([1.0, 0.75, 0.5])
    light, dark = srgb_to_linear(plank.early * hue), srgb_to_linear(plank.late * hue)
    return np.where(early[..., None], light, dark).astype(np.float32)


def find_errors(plank: Plank, wood: Wood) -> dict[str, float]:
    """Errors in the paper's units, per cent. What draws the same picture is the same."""
    xc, yc = (float(value) for value in wood.center)
    tilt, rotation = np.degrees(float(wood.tilt)), np.degrees(float(wood.rotation))
    turned = (rotation - plank.rotation + 90) % 180 - 90
    if abs((rotation - plank.rotation + 180) % 360 - 180) > 90:
        xc, yc = -xc, -yc
    off_x, off_y = _off_axis(plank, xc, yc, tilt, turned)
    ratio = [fraction / (1 - fraction) for fraction in (float(wood.early_fraction), plank.fraction)]
    colours = [np.asarray(linear_to_srgb(np.asarray(colour)))[0] for colour in (wood.early_rgb, wood.late_rgb)]
    return {
        "tilt": 100 * abs(tilt / plank.tilt - 1),
        "oblique tilt": 100 * abs(tilt / plank.tilt - 1),
        "orientation": 100 * abs(turned) / 180,
        "frequency": 100 * abs(plank.spacing / float(wood.ring_spacing) - 1),
        "ratio": 100 * abs(ratio[0] - ratio[1]) / 8,
        "turbulence": 100 * abs(float(wood.turbulence_rms) - plank.rms) / 30,
        "xc": 100 * abs(off_x) / SIZE,
        "yc": 100 * abs(off_y) / SIZE,
        "early": 100 * 255 * abs(colours[0] - plank.early) / 256,
        "late": 100 * 255 * abs(colours[1] - plank.late) / 256,
    }


def _off_axis(plank: Plank, xc: float, yc: float, tilt: float, turned: float) -> tuple[float, float]:
    """How far the axis is off: in the picture where it meets the picture there, else in the trunk."""
    lean, found = np.sin(np.radians(plank.tilt)), np.sin(np.radians(tilt))
    if not _meets(plank) or found == 0:
        return xc - plank.xc, yc - plank.yc
    turn = np.radians(turned)
    across, along = xc, yc / found
    return (
        across * np.cos(turn) - along * np.sin(turn) - plank.xc,
        across * np.sin(turn) + along * np.cos(turn) - plank.yc / lean,
    )


def _meets(plank: Plank) -> bool:
    """Whether the ellipses' middle lies in the picture."""
    turn, along = np.radians(plank.rotation), plank.yc / np.sin(np.radians(plank.tilt))
    u = plank.xc * np.cos(turn) - along * np.sin(turn)
    v = plank.xc * np.sin(turn) + along * np.cos(turn)
    return max(abs(u), abs(v)) < SIZE / 2


def find_floor(plank: Plank, displacement: NDArray[np.float64]) -> dict[str, float]:
    """Standard deviations that no unbiased estimator passes under turbulence, in the paper's units, per cent.

    They suppose that the number of rings between the axis and the picture is known. Where the axis lies deeper than
    rings can be followed to it, it is not, and a count that is one off is nearly as likely as the right one.
    """
    angles, odds = np.radians([plank.tilt, plank.rotation]), plank.fraction / (1 - plank.fraction)
    free = np.array([plank.xc, plank.yc, *angles, np.log(plank.spacing), np.log(odds)])
    covariance = bound_errors(free, displacement, rms=plank.rms, frequency=1 / plank.wavelength)
    return in_paper_units(plank, covariance[:GEOMETRY, :GEOMETRY])


def in_paper_units(plank: Plank, covariance: NDArray[np.float64]) -> dict[str, float]:
    """Standard deviations of a covariance (5, 5), per cent."""
    lean = np.radians(plank.tilt)
    sigma = np.sqrt(np.diag(covariance))
    to_y = np.zeros(GEOMETRY)
    to_y[1] = 1.0
    if _meets(plank):
        to_y[1], to_y[2] = 1 / np.sin(lean), -plank.yc * np.cos(lean) / np.sin(lean) ** 2
    deviations = {
        "tilt": 100 * sigma[2] / lean,
        "orientation": 100 * np.degrees(sigma[3]) / 180,
        "frequency": 100 * sigma[4],
        "xc": 100 * sigma[0] / SIZE,
        "yc": 100 * np.sqrt(to_y @ covariance @ to_y) / SIZE,
    }
    return {**deviations, "oblique tilt": deviations["tilt"]}


def run_row(row: str, args: argparse.Namespace) -> list[dict[str, Any]]:
    """Fit all pictures of a row of the table."""
    found = []
    jobs = []
    for number in range(args.patterns):
        random = np.random.default_rng([args.seed, number])
        base = draw_base(random, turbulent=args.turbulence)
        jobs += [(number, plank, random) for plank in vary(base, row, random)]
    for number, plank, random in progress(jobs, row, total=len(jobs)):
        displacement = displace(plank, args.noise, random)
        fit = fit_wood(draw_picture(plank, displacement))
        told = in_paper_units(plank, fit.covariance[:GEOMETRY, :GEOMETRY]).get(row, np.nan)
        found.append(
            {
                "row": row,
                "pattern": number,
                **plank._asdict(),
                "ok": fit.ok,
                "error": find_errors(plank, fit.wood)[row],
                "sigma": told,
                "floor": find_floor(plank, displacement).get(row, np.nan) if plank.rms else np.nan,
            }
        )
    return found


def is_left_out(each: dict[str, Any], bar: float) -> bool:
    """Whether the fit says, and rightly, that this picture does not tell the parameter to within the bar."""
    return bool(not each["sigma"] <= bar and each["floor"] > bar)


def middle_error(row: str, planks: list[dict[str, Any]]) -> float:
    """The average error of who always answers the middle of the range: what a test must tell from a fit."""
    answers = []
    for each in planks:
        plank = Plank(**{name: each[name] for name in Plank._fields})
        if row in ("tilt", "oblique tilt"):
            middle = 45.0 if row != "tilt" else 3.5 if plank.tilt < 45 else 86.5
            answers.append(100 * abs(middle / plank.tilt - 1))
        elif row == "frequency":
            answers.append(100 * abs(np.mean(RANGES[row]) * plank.spacing - 1))
        else:
            name = {"orientation": "rotation", "ratio": "fraction", "turbulence": "rms"}.get(row, row)
            middle, value = float(np.mean(RANGES[row])), float(getattr(plank, name))
            if row == "ratio":
                middle, value = middle / (1 - middle), value / (1 - value)
            scale = {"orientation": 180, "ratio": 8, "turbulence": 30, "early": 1, "late": 1}.get(row, SIZE)
            answers.append(100 * abs(middle - value) / scale)
    return float(np.mean(answers))


def summarise(found: list[dict[str, Any]], *, turbulent: bool) -> str:
    """The table in Markdown."""
    rows = []
    for row in dict.fromkeys(each["row"] for each in found):
        bar = PAPER[row][0] / 2 if turbulent else BAR[row]
        all_of_row = [each for each in found if each["row"] == row]
        mine = [each for each in all_of_row if not is_left_out(each, bar)]
        if not mine:
            rows.append([row, *(f"{each:g}" for each in (*PAPER[row], bar)), *[""] * 7, f"all {len(all_of_row)}"])
            continue
        # What is known of one normal error: its mean absolute value is 0.8 standard deviations.
        errors, floors = (np.array([each[name] for each in mine]) for name in ("error", "floor"))
        known = not np.isnan(floors).all()
        rows.append(
            [
                row,
                f"{PAPER[row][0]:g}",
                f"{PAPER[row][1]:g}",
                f"{bar:g}",
                f"{errors.mean():.4f}",
                f"{np.median(errors):.4f}",
                f"{errors.std():.4f}",
                f"{errors.max():.4f}",
                f"{0.8 * np.nanmean(floors):.3f}" if known else "",
                f"{errors.mean() / (0.8 * np.nanmean(floors)):.2f}" if known else "",
                f"{middle_error(row, mine):.2f}",
                f"{len(all_of_row) - len(mine)} of {len(all_of_row)}",
            ]
        )
    head = ["parameter", "paper avg", "paper max", "bar", "avg %", "median", "std", "max"]
    head += ["floor", "avg/floor", "middle", "left out"]
    return make_table(head, rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True, help="writes OUTPUT.csv and OUTPUT.md")
    parser.add_argument("--patterns", type=int, default=PATTERNS)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--turbulence", action="store_true", help="displace the rings of all pictures")
    parser.add_argument("--noise", choices=("waves", "filtered"), default="waves")
    parser.add_argument("--rows", nargs="+", choices=list(PAPER), default=list(PAPER))
    args = parser.parse_args()
    found: list[dict[str, Any]] = []
    with args.output.with_suffix(".csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, ["row", "pattern", *Plank._fields, "ok", "error", "sigma", "floor"])
        writer.writeheader()
        for row in args.rows:
            # A row at a time: the whole takes an hour.
            found += run_row(row, args)
            writer.writerows(each for each in found if each["row"] == row)
            file.flush()
    table = summarise(found, turbulent=args.turbulence)
    args.output.with_suffix(".md").write_text(table + "\n", encoding="utf-8")
    print(table)


if __name__ == "__main__":
    main()
