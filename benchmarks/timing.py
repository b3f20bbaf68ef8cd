"""What the benchmarks share: timing a piece of work or a new process, and tables as text and as a page."""

import os
import platform
import shlex
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

HERE = Path(__file__).resolve().parent

Row = tuple[str, ...]
Result = tuple[str, Row, list[Row]]


def run(command: list[str], cache: Path) -> tuple[float, str]:
    """Wall-clock seconds and output of a new process that keeps its kernels in ``cache``."""
    kernels = {"JAX_COMPILATION_CACHE_DIR": str(cache), "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0"}
    began = time.perf_counter()
    # A fit that did not succeed ends with 1, with all its results written.
    ended = subprocess.run(command, env=os.environ | kernels, capture_output=True, text=True, check=False)
    if ended.returncode > 1:
        raise SystemExit(ended.stderr)
    return time.perf_counter() - began, ended.stdout


def rate(work: Callable[[], Any], amount: float) -> float:
    began = time.perf_counter()
    work()
    return amount / (time.perf_counter() - began)


def clock(work: Callable[[], Any], turns: int = 3) -> float:
    """Seconds of the quickest turn, after one that compiles."""
    return clock_in_turn(work, turns=turns)[0]


def clock_in_turn(*works: Callable[[], Any], turns: int = 3) -> list[float]:
    """The same of several that are to be compared: whatever else the machine does meets all of them."""
    times: list[list[float]] = [[] for _ in works]
    for _ in range(turns + 1):
        for work, taken in zip(works, times, strict=True):
            began = time.perf_counter()
            work()
            taken.append(time.perf_counter() - began)
    return [min(taken[1:]) for taken in times]


def seconds(value: float) -> str:
    return f"{value:.2f}"


def show(results: list[Result]) -> None:
    for title, head, rows in results:
        table = Table(title=title)
        for index, name in enumerate(head):
            table.add_column(name, justify="left" if index == 0 else "right")
        for row in rows:
            table.add_row(*row)
        Console().print(table)


def write_report(model: str, title: str, results: list[Result]) -> None:
    """The tables as the page results/MODEL-BACKEND.md, with what they were measured on."""
    import jax

    # Where a photograph lies is nobody's business.
    command = f"python benchmarks/{model}.py " + shlex.join(Path(word).name for word in sys.argv[1:])
    versions = f"Python {platform.python_version()}, JAX {jax.__version__}, NumPy {np.__version__}"
    lines = [f"Made by `{command.strip()}`.", "", f"{os.cpu_count()} cores, {processor()}; {versions}."]
    for heading, head, rows in results:
        lines += ["", f"## {heading}", "", "| " + " | ".join(head) + " |", "|---|" + "---:|" * (len(head) - 1)]
        lines += ["| " + " | ".join(row) + " |" for row in rows]
    name = f"{model}-{jax.default_backend()}.md"
    (HERE / "results").mkdir(exist_ok=True)
    (HERE / "results" / name).write_text(f"# {title}\n\n" + "\n".join(lines) + "\n")


def processor() -> str:
    described = Path("/proc/cpuinfo")
    if not described.exists():
        return platform.machine()
    names = [line.split(":")[1].strip() for line in described.read_text().splitlines() if line.startswith("model name")]
    return names[0] if names else platform.machine()
