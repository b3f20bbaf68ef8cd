"""Contact sheets of what all methods of synthesis make of every picture of a folder.

    python fitting/natural.py FOLDER -o OUT

OUT/NAME.png is the sheet of `jaxtex compare` for each picture, OUT/natural.csv its figures for all of them, and
OUT/index.md shows the sheets and the medians. JAX compiles once for exemplars of a size, so that the first picture's
seconds are longer; the medians are of what methods take from then on.
"""

import argparse
import csv
import io
import os
import statistics
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from tables import make_table

from jaxtex.cli.compare import Compare
from jaxtex.cli.progress import progress
from jaxtex.core.errors import InputError
from jaxtex.io.files import atomic_write_text, prepare_folder

ENDINGS = {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".exr"}
FIGURES = ["seconds", "patches", "statistics", "copied", "pieces"]


def read_figures(sheet: Path) -> list[dict[str, str]]:
    """The table beside a sheet, with the exemplar's name."""
    with sheet.with_suffix(".csv").open(encoding="utf-8", newline="") as table:
        return [{"exemplar": sheet.stem, **row} for row in csv.DictReader(table)]


def find_medians(rows: Sequence[dict[str, str]]) -> list[list[str]]:
    """For each method, the medians of its figures."""
    lines = []
    for method in dict.fromkeys(row["method"] for row in rows):
        values = {name: [float(row[name]) for row in rows if row["method"] == method and row[name]] for name in FIGURES}
        lines.append([method, *(f"{statistics.median(each):.3g}" if each else "" for each in values.values())])
    return lines


def write_index(folder: Path, sheets: Sequence[Path]) -> None:
    """One page and one table of all sheets."""
    rows = [row for sheet in sheets for row in read_figures(sheet)]
    table = io.StringIO()
    writer = csv.DictWriter(table, rows[0], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    atomic_write_text(folder / "natural.csv", table.getvalue())
    pictures = [f"## {sheet.stem}\n\n![{sheet.stem}]({sheet.name})\n" for sheet in sheets]
    medians = make_table(["method", *FIGURES], find_medians(rows))
    page = ["# All methods, side by side\n", f"Medians over {len(sheets)} exemplars:\n", medians, "", *pictures]
    atomic_write_text(folder / "index.md", "\n".join(page))


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="pictures of textures")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT", help="folder for the sheets")
    options = parser.parse_args(words)
    paths = sorted(path for path in options.folder.iterdir() if path.suffix.lower() in ENDINGS)
    if not paths:
        parser.error(f"{options.folder}: holds no pictures")
    prepare_folder(options.output)
    sheets: list[Path] = []
    for path in progress(paths, "comparing"):
        sheet = options.output / f"{path.stem}.png"
        try:
            Compare(exemplar=path, output=sheet).run()
        except InputError as error:
            print(error)
            continue
        sheets.append(sheet)
        write_index(options.output, sheets)  # each time, as all of them take long


if __name__ == "__main__":
    main()
