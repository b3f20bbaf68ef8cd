"""Whether elements break: textures made with the mask of their exemplar's elements, and without.

    python fitting/element_breaking.py FOLDER -o OUT

FOLDER holds pictures made of things. OUT/breaking.png has a row for each: the picture, what is told as its elements,
and what is made of it, without mask and with: alike everywhere, and larger from left to right, from 0.6 to 1.7 times.
OUT/breaking.md says how far the elements' areas (over the square of the scale where they are), and their perimeter²
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
from jaxtex.progressive.masked import mark_elements, synthesise_masked
from jaxtex.synthesis.anisometric import make_frames, sample_sources, synthesise_anisometric
from jaxtex.synthesis.coherence import synthesise_coherence
from jaxtex.synthesis.sources import copy_sources

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
LARGEST = 320  # pixels along either side of what is learnt from
SPAN = 0.53  # natural logarithm of how much larger than the exemplar's things become
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
    """Cells of the sheet; distances of areas and of compactness, without mask and with it, alike everywhere and of
    several scales, and by chance, [5, 2]; and how many whole elements the exemplar has."""
    classes = learn_classes(picture, mask)
    own = find_elements(picture, classes)
    encoded = linear_to_srgb(picture)
    cells, apart = [encoded, own.mask[..., None].astype(np.float32)], np.zeros((seeds, 4, 2))
    alike = np.ones(mask.shape)
    scale = np.exp(np.linspace(-SPAN, SPAN, mask.shape[1]))[None].repeat(mask.shape[0], axis=0)
    for seed in range(seeds):
        number = 0
        for field in (alike, scale):
            for with_mask in (False, True):
                made = synthesise(picture, mask if with_mask else None, field, seed)
                apart[seed, number] = measure_apart(find_elements(made, classes, field), own)
                number += 1
                if seed == 0:
                    cells.append(linear_to_srgb(np.maximum(made, 0)))
    half = picture.shape[1] // 2
    chance = measure_apart(find_elements(picture[:, :half], classes), find_elements(picture[:, half:], classes))
    return cells, np.array([*apart.mean(axis=0), chance]), len(own.areas)


def synthesise(picture: np.ndarray, mask: Bools | None, scale: np.ndarray, seed: int) -> np.ndarray:
    """More of a picture, as large as it, with what `jaxtex synth` and `jaxtex vary distort` do by themselves."""
    key, exemplar = jax.random.key(seed), linear_to_srgb(picture)
    if np.ptp(scale) == 0:
        shape = scale.shape
        if mask is None:
            return copy_sources(picture, synthesise_coherence(exemplar, shape, key=key))
        return copy_sources(picture, synthesise_masked(exemplar, mask, shape, key=key))
    if mask is not None:
        exemplar = mark_elements(exemplar, mask)
    flat = np.zeros_like(scale)
    return sample_sources(picture, synthesise_anisometric(exemplar, scale, flat, key=key), make_frames(scale, flat))


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
    rows, lines, closer = [], [], np.zeros(2, int)
    for name in options.only:
        pixels = jt.read_image(options.folder / name).pixels
        mask = find_mask(options.folder / name, pixels, options.cache)
        inside = slice(LARGEST), slice(LARGEST)
        cells, apart, count = compare(pixels[inside], mask[inside], options.seeds)
        rows.append(np.concatenate([fit_in(each) for each in cells], axis=1))
        ratios = [float(np.sqrt(np.prod(apart[n + 1] / apart[n]))) for n in (0, 2)]
        closer += np.array(ratios) < CLEARLY
        told = (f"{a:.3f} {b:.3f}" for n in (0, 2) for a, b in apart[n : n + 2].T)
        lines.append([name, str(count), *told, " ".join(f"{each:.3f}" for each in apart[4])])
        lines[-1] += [f"{ratio:.2f}" for ratio in ratios]
        print(" ".join(lines[-1]), flush=True)
    both = "areas: plain, mask", "shapes: plain, mask"
    head = ("picture", "elements", *both, *(f"scaled {each}" for each in both), "halves", "mask/plain", "scaled")
    told = (
        f"With mask, {closer[0]} of {len(lines)} are clearly closer, and {closer[1]} of those that are scaled: below "
        f"{CLEARLY} in the mean of both."
    )
    table = make_table(head, lines)
    atomic_write_text(options.output / "breaking.md", f"# Elements, with mask and without\n\n{table}\n\n{told}\n")
    print(f"{table}\n{told}")
    jt.write_image(options.output / "breaking.png", srgb_to_linear(np.concatenate(rows)))


if __name__ == "__main__":
    main()
