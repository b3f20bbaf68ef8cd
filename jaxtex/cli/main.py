"""The command `jaxtex`: finds the command that was named, reads its options, runs it, and reports what went wrong.

Each command is a dataclass of options in a module of this package, with a method `run(self) -> int` that returns the
exit status. The module must be light (no JAX, no scikit-image, no array library at its top): `run` imports what it
needs. Only the module of the command that was named is imported at all.

Exit status: 0 done; 1 done, but the fit did not succeed (results are written and say why); 2 the input or the options
cannot be used (one line on stderr, nothing written); 130 interrupted.
"""

import difflib
import os
import sys
from collections.abc import Iterator, Sequence
from importlib import import_module
from pathlib import Path
from typing import NamedTuple, Protocol

import jaxtex
from jaxtex.cli import usage
from jaxtex.core.errors import InputError


class Options(Protocol):
    """What a command module offers: a dataclass of options that runs."""

    def run(self) -> int: ...


class Command(NamedTuple):
    """One line of the table: the words typed, where the options stand (`module:class`), and one line of help."""

    words: str
    target: str
    summary: str


# The whole command tree, in the order in which `jaxtex --help` shows it. Add a command by adding its line.
COMMANDS = (
    Command("fit tiling", "jaxtex.cli.fit:Tiling", "fit a tiling model to a photograph and make its material maps"),
    Command("fit wood", "jaxtex.cli.fit:Wood", "fit the rings of a trunk to a photograph of a plank, likewise"),
    Command("fit floor", "jaxtex.cli.fit_floor:Floor", "find the planks of a floor or fence, and fit wood to each"),
    Command("mix", "jaxtex.cli.mix:Mix", "mix models: wood in tiles, parts of the photograph, others by painted masks"),
    Command("render", "jaxtex.cli.render:Render", "make the material maps of a model file at any resolution"),
    Command("synth", "jaxtex.cli.synth:Synth", "make more of a texture, tileable, from a picture of it"),
    Command(
        "vary distort",
        "jaxtex.cli.vary_distort:VaryDistort",
        "make a texture whose things change in size and direction",
    ),
    Command("vary warp", "jaxtex.cli.vary_warp:VaryWarp", "make a texture whose elements change in shape"),
    Command("vary blend", "jaxtex.cli.vary_blend:VaryBlend", "make a texture that becomes another, shapes and colours"),
    Command("compare", "jaxtex.cli.compare:Compare", "show what each method of synth makes of a picture, on one sheet"),
    Command("field", "jaxtex.cli.field:Field", "make a field over a picture from keys: scale, transition, orientation"),
    Command(
        "texton-mask", "jaxtex.cli.texton_mask:TextonMask", "mark the elements of a texture, by colours or painted"
    ),
    Command("solid", "jaxtex.cli.solid:Solid", "make a block of voxels whose slices look like pictures of a material"),
    Command("solid-slice", "jaxtex.cli.solid_slice:SolidSlice", "show a block: a slice, an oblique cut, or all of it"),
    Command("carve", "jaxtex.cli.carve:Carve", "carve a mesh of a block: a colour to each vertex"),
    Command(
        "particles analyse", "jaxtex.cli.particles:Analyse", "take a picture apart into things: pebbles, leaves, holes"
    ),
    Command("particles show", "jaxtex.cli.particles:Show", "show what it was taken apart into, on one sheet"),
    Command("particles synth", "jaxtex.cli.particles_synth:Synth", "arrange its things anew, under control"),
    Command("export", "jaxtex.cli.export:Export", "put a model on a wall, a floor or a mesh: one file for viewers"),
    Command("rectify", "jaxtex.cli.rectify:Rectify", "straighten a photograph from four corners"),
    Command("mask auto", "jaxtex.cli.mask:Auto", "make a mask of a tiled surface with nothing said"),
    Command("mask threshold", "jaxtex.cli.mask:Threshold", "make a mask by lightness"),
    Command("mask colour", "jaxtex.cli.mask:Colour", "make a mask by colours clicked"),
    Command("mask sobel", "jaxtex.cli.mask:Sobel", "make a mask by edges"),
    Command("mask pyramid", "jaxtex.cli.mask:Pyramid", "make a mask by edges seen from afar"),
    Command("mask open", "jaxtex.cli.mask:Open", "clear bridges across the joints of a mask"),
    Command("mask close", "jaxtex.cli.mask:Close", "fill pits and cracks in the tiles of a mask"),
    Command("mask erode", "jaxtex.cli.mask:Erode", "thin the tiles of a mask"),
    Command("mask dilate", "jaxtex.cli.mask:Dilate", "widen the tiles of a mask"),
    Command("mask despeckle", "jaxtex.cli.mask:Despeckle", "drop small regions from a mask"),
    Command("info", "jaxtex.cli.info:Info", "print a model file"),
    Command("demo", "jaxtex.cli.demo:Demo", "do the whole way on a photograph of a brick wall that comes along"),
)

PROBLEM = 2
INTERRUPTED = 130
PIPE_CLOSED = 141


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line `argv` (default: the process's own) and return the exit status.

    Examples:
        >>> main(["--version"])
        jaxtex 0.1.0
        0
    """
    words = list(sys.argv[1:] if argv is None else argv)
    try:
        status = _dispatch(words)
        sys.stdout.flush()
        return status
    except (usage.UsageError, InputError) as error:
        return _complain(error)
    except KeyboardInterrupt:
        print("jaxtex: interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or the interpreter complains while it closes
        return PIPE_CLOSED
    except ValueError as error:
        if not _raised_by_jaxtex(error):
            raise
        return _complain(error)
    except OSError as error:
        if error.filename is None:
            raise
        return _complain(f"{os.fsdecode(error.filename)}: {error.strerror or type(error).__name__}")


def _dispatch(words: list[str]) -> int:
    if not words or words[0] in ("-h", "--help"):
        print(_overview())
        return 0 if words else PROBLEM
    if words[0] == "--version":
        print(f"jaxtex {jaxtex.__version__}")
        return 0
    command, arguments = _find_command(words)
    if command is None:
        print(_overview(words[0]))
        return 0
    module, _, name = command.target.partition(":")
    options: type[Options] = getattr(import_module(module), name)
    parsed = usage.parse(options, prog=f"jaxtex {command.words}", arguments=arguments)
    if parsed is None:
        return 0
    _set_up_jax()
    return parsed.run()


def _find_command(words: list[str]) -> tuple[Command | None, list[str]]:
    """The command that `words` begin with and the words after it; no command where a group's help is asked for."""
    for command in COMMANDS:
        length = len(command.words.split())
        if words[:length] == command.words.split():
            return command, words[length:]
    first = words[0]
    inside = [command.words for command in COMMANDS if command.words.split()[0] == first]
    if inside:
        rest = words[1] if len(words) > 1 else ""
        if rest in ("-h", "--help"):
            return None, []
        told = f"'{first}' needs one of its commands" if not rest else f"'{first}' has no command '{rest}'"
        raise usage.UsageError(f"{told}: {', '.join(inside)} (see jaxtex {first} --help)")
    kind = "option" if first.startswith("-") else "command"
    close = difflib.get_close_matches(first, {command.words.split()[0] for command in COMMANDS}, n=1)
    hint = f"; perhaps you meant '{close[0]}'" if close else ""
    raise usage.UsageError(f"there is no {kind} '{first}'{hint} (see jaxtex --help)")


def _overview(group: str = "") -> str:
    """The help text of `jaxtex`, or of one of its groups."""
    shown = [command for command in COMMANDS if not group or command.words.split()[0] == group]
    return "\n".join(_overview_lines(group, shown))


def _overview_lines(group: str, shown: list[Command]) -> Iterator[str]:
    yield f"usage: {f'jaxtex {group}'.strip()} COMMAND [OPTIONS]"
    yield ""
    if not group:
        yield "Turn pictures of a material into models that a person can control."
        yield ""
    yield "commands:"
    width = max((len(command.words) for command in shown), default=0)
    for command in shown:
        yield f"  {command.words:<{width}}  {command.summary}"
    yield ""
    yield "jaxtex COMMAND --help shows what a command takes; jaxtex --version tells the version."


def _complain(what: object) -> int:
    print("jaxtex: error:", " ".join(str(what).split()), file=sys.stderr)
    return PROBLEM


def _raised_by_jaxtex(error: BaseException) -> bool:
    """Whether our own code raised it: such an error speaks to the user. One raised inside another library is a bug of
    ours, and its traceback is what a report of it needs."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    return trace is not None and trace.tb_frame.f_globals.get("__name__", "").split(".")[0] == "jaxtex"


def _set_up_jax() -> None:
    """Have JAX keep what it compiles for the next run, unless the user has said where (or that it should not).

    JAX reads these variables when it is first imported, which is after this.
    """
    # Each kernel read back from the cache would be announced on stderr as an error: its compiler's preferences (such as
    # +prefer-no-gather) are no features of the processor. Errors that matter come as exceptions.
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
    # NumPy's products here are small; waking a second thread for each costs many times what it saves.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if "JAX_COMPILATION_CACHE_DIR" in os.environ:
        return
    folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "jaxtex" / "xla"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return  # a read-only home: compile anew each time
    if os.access(folder, os.W_OK):
        os.environ["JAX_COMPILATION_CACHE_DIR"] = str(folder)
        os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0.1")
