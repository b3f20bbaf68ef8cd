"""How fast textures are analysed and synthesised. Nothing here passes or fails; ratios within one run are what counts.

python benchmarks/heeger_bergen.py            # a minute; writes benchmarks/results/heeger_bergen-cpu.md
python benchmarks/heeger_bergen.py --help
"""

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from timing import Result, Row, run, seconds, show, write_report


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", choices=["process", "sizes"], help="only this part")
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        print(json.dumps([clock(lambda: synthesise(granite(256))) for _ in range(2)]))
        return
    with tempfile.TemporaryDirectory() as folder:
        parts = {"process": lambda: time_process(Path(folder)), "sizes": time_sizes}
        results = [part() for name, part in parts.items() if options.only in (None, name)]
    show(results)
    if options.only is None:
        write_report("heeger_bergen", "Speed of Heeger and Bergen's texture synthesis", results)


def granite(size: int, seed: int = 0) -> np.ndarray:
    """Coloured grain of several sizes, [size, size, 3]."""
    rng = np.random.default_rng(seed)
    radius = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None])
    spectra = np.fft.rfft2(rng.normal(size=(3, size, size))) / (radius + 0.02)
    grain = np.fft.irfft2(spectra, (size, size))
    grain = np.exp(0.4 * grain / grain.std())
    return (0.3 * np.einsum("crk,cd->rkd", grain, [[1, 0.9, 0.8], [0.1, 0, -0.1], [0, 0.1, 0]])).astype(np.float32)


def synthesise(exemplar: np.ndarray) -> Any:
    """Analysis and synthesis: 4 scales, 4 orientations, 5 iterations."""
    import jax

    from jaxtex.synthesis.heeger_bergen import analyse_texture, synthesise_texture

    texture = synthesise_texture(analyse_texture(exemplar[None]), exemplar.shape[:2], key=jax.random.key(0))
    return jax.block_until_ready(texture)


def clock(work: Callable[[], Any]) -> float:
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def time_process(folder: Path) -> Result:
    """A new process with an empty cache of kernels and with a full one; the second texture in it is warm."""
    own = [sys.executable, str(Path(__file__).resolve()), "--worker"]
    cold, cached = (json.loads(run(own, folder / "kernels")[1].splitlines()[-1]) for _ in range(2))
    rows: list[Row] = [("analysis and synthesis", seconds(cold[0]), seconds(cached[0]), seconds(cached[1]))]
    head = ("seconds", "cold, imports included", "kernels from the cache", "warm")
    return "A texture of 256 x 256 in a new process", head, rows


def time_sizes() -> Result:
    """Textures of several sizes, against the same algorithm in NumPy, the best of some turns each."""
    from numpy_heeger_bergen import synthesise_numpy

    rows: list[Row] = []
    for size in (128, 256, 512, 1024):
        exemplar = granite(size)
        made, plain = np.asarray(synthesise(exemplar)), synthesise_numpy(exemplar, (size, size))
        apart = float(np.abs(made.std((0, 1)) - plain.std((0, 1))).max() / plain.std())
        assert apart < 0.02, f"the two textures' contrasts differ by {apart}"
        turns = 5 if size < 1024 else 2
        ours = min(clock(lambda exemplar=exemplar: synthesise(exemplar)) for _ in range(turns))
        theirs = min(
            clock(lambda exemplar=exemplar, size=size: synthesise_numpy(exemplar, (size, size))) for _ in range(turns)
        )
        rows.append((f"{size} x {size}", f"{ours:.3f}", f"{theirs:.3f}", f"{theirs / ours:.1f}"))
    head = ("texture", "jaxtex, s", "NumPy, s", "NumPy against jaxtex")
    return "RGB, 4 scales, 4 orientations, 5 iterations, analysis included, warm", head, rows


if __name__ == "__main__":
    main()
