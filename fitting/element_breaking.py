"""Whether elements break: textures made with the mask of their exemplar's elements, and without.

    python fitting/element_breaking.py FOLDER -o OUT

FOLDER holds pictures made of things. OUT/breaking.png has a row for each: the picture, what is told as its elements,
and what is made of it, without and with mask. OUT/breaking.md says how far the elements' areas, and their perimeter²
over area, are from the exemplar's: Wasserstein distances in octaves, means of some seeds. One half of the exemplar
against the other tells how far apart such distributions are by chance.
"""

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

import jax
import numpy as np
import numpy.typing as npt
from element_shapes import find_elements, learn_classes, measure_apart
from tables import make_table

import jaxtex as jt
from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
from jaxtex.io.files import atomic_write_text, prepare_folder
from jaxtex.progressive.masked import synthesise_masked
from jaxtex.synthesis.coherence import synthesise_coherence

PICTURES = (
    "pebbles_coloured.jpg",
    "coffee_beans.jpg",
    "pebbles_sh3.jpg",
    "coins_sk.png",
    "field_cobbles.jpg",
    "reptile_skin.png",
    "cheese_holes.png",
    "terrazzo018.png",
    "terrazzo009.png",
    "gravel_gray_sk.png",
)
LARGEST = 384  # pixels along either side of what is learnt from
CLEARLY = 0.9  # of the distances without mask

Bools = npt.NDArray[np.bool_]


def find_mask(path: Path, pixels: np.ndarray, cache: Path | None) -> Bools:
    """A picture's things, found anew only if they are not in the cache."""
    kept = cache / f"{path.name}.npy" if cache else None
    if kept is not None and kept.exists():
        return np.load(kept)
    mask = jt.find_particles(pixels).labels > 0
    if kept is not None:
        np.save(kept, mask)
    return mask


def compare(picture: np.ndarray, mask: Bools, seeds: int) -> tuple[list[np.ndarray], np.ndarray, int]:
    """Cells of the sheet; distances of areas and of compactness, without mask, with, and by chance, [3, 2]; and how
    many whole elements the exemplar has."""
    classes = learn_classes(picture, mask)
    own = find_elements(picture, classes)
    encoded = linear_to_srgb(picture)
    cells, apart = [encoded, own.mask[..., None].astype(np.float32)], np.zeros((seeds, 2, 2))
    for seed in range(seeds):
        key, shape = jax.random.key(seed), mask.shape
        both = synthesise_coherence(encoded, shape, key=key), synthesise_masked(encoded, mask, shape, key=key)
        for number, sources in enumerate(both):
            made = picture[sources[..., 0], sources[..., 1]]
            apart[seed, number] = measure_apart(find_elements(made, classes), own)
            if seed == 0:
                cells.append(linear_to_srgb(made))
    half = picture.shape[1] // 2
    chance = measure_apart(find_elements(picture[:, :half], classes), find_elements(picture[:, half:], classes))
    return cells, np.array([*apart.mean(axis=0), chance]), len(own.areas)


def fit_in(picture: np.ndarray) -> np.ndarray:
    cell = np.ones((LARGEST, LARGEST, 3), np.float32)
    cell[: picture.shape[0], : picture.shape[1]] = picture
    return cell


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="pictures made of things")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT", help="folder for what is made")
    parser.add_argument("--only", nargs="+", metavar="NAME", default=PICTURES, help="these pictures alone")
    parser.add_argument("--seeds", type=int, default=3, help="textures made of each picture; by default 3")
    parser.add_argument("--cache", type=Path, metavar="FOLDER", help="where masks are kept, to be found only once")
    options = parser.parse_args(words)
    prepare_folder(options.output)
    rows, lines, closer = [], [], 0
    for name in options.only:
        pixels = jt.read_image(options.folder / name).pixels
        mask = find_mask(options.folder / name, pixels, options.cache)
        inside = slice(LARGEST), slice(LARGEST)
        cells, apart, count = compare(pixels[inside], mask[inside], options.seeds)
        rows.append(np.concatenate([fit_in(each) for each in cells], axis=1))
        ratio = float(np.sqrt(np.prod(apart[1] / apart[0])))
        closer += ratio < CLEARLY
        lines.append(
            [name, str(count), *(f"{plain:.3f} / {masked:.3f} / {chance:.3f}" for plain, masked, chance in apart.T)]
        )
        lines[-1].append(f"{ratio:.2f}")
        print(" ".join(lines[-1]), flush=True)
    head = ("picture", "elements", "areas: plain / mask / halves", "perimeter²/area: the same", "mask / plain")
    told = f"With mask, {closer} of {len(lines)} are clearly closer: below {CLEARLY} in the mean of both."
    table = make_table(head, lines)
    atomic_write_text(options.output / "breaking.md", f"# Elements, with mask and without\n\n{table}\n\n{told}\n")
    print(f"{table}\n{told}")
    jt.write_image(options.output / "breaking.png", srgb_to_linear(np.concatenate(rows)))


if __name__ == "__main__":
    main()
