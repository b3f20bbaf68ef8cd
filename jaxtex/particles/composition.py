"""Compositions: which particle of a picture lies where: a value that is saved, edited by hand, drawn at any size.

The file's format is described, key by key, by the JSON Schema `composition-1.json` in `jaxtex/models/schema`.
"""

import dataclasses
import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from jaxtex.core.errors import InputError
from jaxtex.models.envelope import read_envelope, write_envelope
from jaxtex.particles.things import Decomposition

_COLUMNS = ("class", "particle", "x", "y", "angle", "scale", "red", "green", "blue")

Numbers = npt.NDArray[np.intp]
Lengths = npt.NDArray[np.float64]


class Exemplar(NamedTuple):
    """Which decomposition the particles of a composition are from.

    Attributes:
        width, height: of its label image, pixels.
        particles: how many it has.
        sha256: of its label image's numbers, hexadecimal.
    """

    width: int
    height: int
    particles: int
    sha256: str


@dataclasses.dataclass(frozen=True, eq=False)
class Composition:
    """Particles placed on a plane. What comes later lies over what comes first.

    Attributes:
        width, height: of the plane, pixels.
        periodic: whether it repeats to all sides without a seam.
        exemplar: where the particles are from.
        kinds: the class of each placed particle, [placed].
        particles: its number in the decomposition, from 0 (so its label less 1), [placed].
        x, y: where the centre of its box lies, in pixels; it may be a little outside, [placed].
        angles: radians by which it is turned from how it lies in the exemplar, clockwise as seen, [placed].
        scales: how many times as large as in the exemplar it is, [placed].
        gains: factors on its linear red, green and blue, [placed, 3]; 1 unless given.
        versions: of the software that wrote the file; by default of the software that runs.

    Raises:
        ValueError: sizes or scales that are not above 0, numbers below 0 or not finite, arrays of several lengths.
    """

    width: int
    height: int
    periodic: bool
    exemplar: Exemplar
    kinds: Numbers
    particles: Numbers
    x: Lengths
    y: Lengths
    angles: Lengths
    scales: Lengths
    gains: Lengths = dataclasses.field(default_factory=lambda: np.ones((1, 3)))
    versions: Mapping[str, str] | None = None

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise ValueError(f"a composition of {self.width} x {self.height} pixels; give a size of at least 1 x 1")
        for name, dtype in (("kinds", np.intp), ("particles", np.intp), *((name, float) for name in _REAL)):
            values = np.asarray(getattr(self, name), dtype)
            if values.shape != np.shape(self.x) or values.ndim != 1:
                raise ValueError(f"{name} of shape {values.shape}: give one to each placed particle")
            if not np.isfinite(values).all() or (name not in _SIGNED and values.size and values.min() < 0):
                raise ValueError(f"{name}: holds a number that is below 0 or not finite")
            object.__setattr__(self, name, values)
        if (self.scales <= 0).any():
            raise ValueError("scales: holds 0; give numbers above 0")
        gains = np.asarray(self.gains, float)
        if gains.shape not in ((1, 3), (len(self), 3)):
            raise ValueError(f"gains of shape {gains.shape}: give three to each placed particle")
        if not np.isfinite(gains).all() or (gains < 0).any():
            raise ValueError("gains: holds a number that is below 0 or not finite")
        object.__setattr__(self, "gains", np.broadcast_to(gains, (len(self), 3)))

    def __len__(self) -> int:
        """How many particles are placed."""
        return len(self.x)

    def select(self, keep: npt.ArrayLike) -> "Composition":
        """Some of the particles, the others taken away.

        Args:
            keep: one yes or no to each placed particle, or the numbers of those that stay, in the order in which they
                shall lie over each other.

        Raises:
            ValueError: neither of these.

        Examples:
            >>> things = Exemplar(640, 480, 2, "0" * 64)
            >>> two = Composition(300, 100, False, things, [0, 0], [0, 1], [30.0, 80.0], [9.0, 20.0], [0, 0], [1, 1])
            >>> two.select(two.x > 50).particles, two.select([1, 0]).particles
            (array([1]), array([1, 0]))
        """
        chosen = np.asarray(keep)
        if chosen.dtype == bool and chosen.shape != self.x.shape:
            raise ValueError(
                f"keep of shape {chosen.shape}: give yes or no to each of the {len(self)} placed particles"
            )
        chosen = np.flatnonzero(chosen) if chosen.dtype == bool else self._check_places(chosen)
        columns: dict[str, Any] = {name: getattr(self, name)[chosen] for name in _ARRAYS}
        return dataclasses.replace(self, **columns)

    def without(self, placed: npt.ArrayLike) -> "Composition":
        """The rest, when some particles are taken away.

        Args:
            placed: their numbers among those that are placed, from 0.

        Raises:
            ValueError: a number that is not there.
        """
        return self.select(~np.isin(np.arange(len(self)), self._check_places(np.atleast_1d(placed))))

    def with_particle(
        self,
        kind: int,
        particle: int,
        x: float,
        y: float,
        *,
        angle: float = 0.0,
        scale: float = 1.0,
        gain: Sequence[float] = (1.0, 1.0, 1.0),
    ) -> "Composition":
        """The same with one more particle, over all others.

        Args:
            kind, particle: its class, and its number in the decomposition.
            x, y: where the centre of its box lies, pixels.
            angle: radians by which it is turned, clockwise as seen.
            scale: how many times as large as in the exemplar it is.
            gain: factors on linear red, green and blue.

        Raises:
            ValueError: as for the whole composition.

        Examples:
            >>> things = Exemplar(640, 480, 2, "0" * 64)
            >>> none = Composition(300, 100, False, things, [], [], [], [], [], [])
            >>> none.with_particle(0, 1, 30.0, 20.0).with_particle(0, 0, 80.0, 9.0).without(0).x
            array([80.])
        """
        new = (kind, particle, x, y, angle, scale, gain)
        columns: dict[str, Any] = {
            name: np.concatenate([getattr(self, name), np.asarray(value, float)[None]])
            for name, value in zip(_ARRAYS, new, strict=True)
        }
        return dataclasses.replace(self, **columns)

    def _check_places(self, placed: npt.ArrayLike) -> Numbers:
        numbers = np.asarray(placed)
        if not np.issubdtype(numbers.dtype, np.integer) and numbers.size:
            raise ValueError(f"placed particles {numbers.tolist()}: give whole numbers")
        if numbers.ndim != 1 or (numbers.size and not 0 <= numbers.min() <= numbers.max() < len(self)):
            raise ValueError(f"placed particles {numbers.tolist()}: give numbers from 0 to {len(self) - 1}")
        return numbers.astype(np.intp)

    def rescaled(self, factor: float) -> "Composition":
        """The same at another resolution: sizes are rounded to whole pixels, and places follow them.

        Raises:
            ValueError: a factor that is not above 0.

        Examples:
            >>> things = Exemplar(640, 480, 1, "0" * 64)
            >>> one = Composition(300, 100, False, things, [0], [0], [30.0], [20.0], [0.0], [1.0])
            >>> two = one.rescaled(2.0)
            >>> two.width, two.height, two.x, two.scales
            (600, 200, array([60.]), array([2.]))
        """
        if not (np.isfinite(factor) and factor > 0):
            raise ValueError(f"factor is {factor}; give a number above 0")
        width, height = (max(1, round(each * factor)) for each in (self.width, self.height))
        return dataclasses.replace(
            self,
            width=width,
            height=height,
            x=self.x * (width / self.width),
            y=self.y * (height / self.height),
            scales=self.scales * factor,
        )


_REAL = ("x", "y", "angles", "scales")
_SIGNED = ("x", "y", "angles")
_ARRAYS = ("kinds", "particles", *_REAL, "gains")


def identify_exemplar(decomposition: Decomposition) -> Exemplar:
    """By what a composition knows the decomposition that its particles are from."""
    height, width = decomposition.labels.shape
    digest = hashlib.sha256(np.ascontiguousarray(decomposition.labels, "<i4").tobytes()).hexdigest()
    return Exemplar(width, height, len(decomposition.particles), digest)


def check_exemplar(composition: Composition, decomposition: Decomposition) -> None:
    """See that a composition is made of a decomposition's particles.

    Raises:
        InputError: it is made of others', or an edit has given a particle a number or a class that is not its own.
    """
    if composition.exemplar != identify_exemplar(decomposition):
        there = composition.exemplar
        told = f"{there.particles} particles of a picture of {there.width} x {there.height} pixels"
        raise InputError(f"this composition is made of {told}, and not of these; give the ones it was made of")
    kinds = np.array([particle.kind for particle in decomposition.particles], np.intp)
    for index, (kind, particle) in enumerate(zip(composition.kinds, composition.particles, strict=True)):
        if particle >= len(kinds):
            raise InputError(f"placed[{index}]: particle is {particle}; it must be at most {len(kinds) - 1}")
        if kinds[particle] != kind:
            raise InputError(f"placed[{index}]: class is {kind}; particle {particle} is of class {kinds[particle]}")


def write_composition(path: Path | str, composition: Composition) -> None:
    """Write a composition as JSON, whole or not at all: one line to each placed particle, angles in degrees.

    The same composition gives the same bytes.

    Raises:
        InputError: the folder does not exist.

    Examples:
        >>> things = Exemplar(640, 480, 1, "0" * 64)
        >>> one = Composition(300, 100, False, things, [0], [0], [30.0], [20.0], [0.0], [1.0])
        >>> write_composition("wall.json", one)
        >>> read_composition("wall.json").x
        array([30.])
    """
    # Twelve digits behind the point, so that radians and back give the same number.
    angles = np.round(np.degrees(composition.angles), 12)
    placed = (composition.kinds, composition.particles, composition.x, composition.y, angles, composition.scales)
    columns = (*placed, *composition.gains.T)
    content = {
        "size": [composition.width, composition.height],
        "periodic": bool(composition.periodic),
        "exemplar": composition.exemplar._asdict(),
        "columns": list(_COLUMNS),
        "placed": [list(row) for row in zip(*(column.tolist() for column in columns), strict=True)],
    }
    write_envelope(path, "composition", image=None, content=content, versions=composition.versions, seed=None)


def read_composition(path: Path | str) -> Composition:
    """Read a composition's file.

    Raises:
        InputError: there is no such file, it is damaged, of another kind or version, or one of its entries is missing
            or wrong; the message names the file and the entry.
    """
    document = read_envelope(path, ("composition",))
    _check_rows(path, document)
    rows = np.array(document["placed"], float).reshape(-1, len(_COLUMNS))
    kinds, particles, x, y, angles, scales, *gains = rows.T.copy()
    return Composition(
        width=int(document["size"][0]),
        height=int(document["size"][1]),
        periodic=document["periodic"],
        exemplar=Exemplar(**{name: document["exemplar"][name] for name in Exemplar._fields}),
        kinds=kinds.astype(np.intp),
        particles=particles.astype(np.intp),
        x=x,
        y=y,
        angles=np.radians(angles),
        scales=scales,
        gains=np.stack(gains, axis=1),
        versions=document.get("versions"),
    )


def _check_rows(path: Path | str, document: Mapping[str, Any]) -> None:
    """What the schema's part of JSON Schema cannot say of a list with columns."""
    if tuple(document["columns"]) != _COLUMNS:
        raise InputError(f"{path}: columns is {document['columns']}; it must be {', '.join(_COLUMNS)}")
    most = np.iinfo(np.int32).max
    for index, (kind, particle, _, _, _, scale, *gains) in enumerate(document["placed"]):
        for name, value in (("class", kind), ("particle", particle)):
            if value != int(value) or not 0 <= value <= most:
                raise InputError(f"{path}: placed[{index}]: {name} is {value}; it must be a whole number from 0")
        if not 1e-3 <= scale <= 1e3:
            raise InputError(f"{path}: placed[{index}]: scale is {scale:g}; it must be from 0.001 to 1000")
        for name, gain in zip(("red", "green", "blue"), gains, strict=True):
            if gain < 0:
                raise InputError(f"{path}: placed[{index}]: {name} is {gain}; it must be at least 0")
