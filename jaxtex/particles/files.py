"""A picture taken apart, as a folder that can be looked at, mended and read again.

The folder holds a copy of the picture's file, `labels.png` (each pixel the number of its particle, 0 for the ground),
and `particles.json` (the class of each particle). Labels may be painted over with any editor that keeps 16 bits.
"""

import hashlib
import json
import shutil
from pathlib import Path
from typing import NamedTuple

import numpy as np

from jaxtex.core.errors import InputError
from jaxtex.io.files import prepare_folder, replacing, replacing_together
from jaxtex.io.images import Image, read_image, write_image
from jaxtex.models.envelope import SourceImage, read_envelope, write_envelope
from jaxtex.particles.things import Decomposition, describe_particles

_LABELS, _PARTICLES, _PICTURE = "labels.png", "particles.json", "picture"
_MOST = 2**16 - 1  # particles: what 16 bits number


class ParticleFolder(NamedTuple):
    """What such a folder holds.

    Attributes:
        image: the picture.
        decomposition: taken apart.
        names: of its classes.
    """

    image: Image
    decomposition: Decomposition
    names: tuple[str, ...]


def write_particles(
    folder: Path | str, image: Image, decomposition: Decomposition, *, names: tuple[str, ...] | None = None
) -> None:
    """Write a picture taken apart to a folder.

    Args:
        folder: it is made where it does not exist; files of these names in it are replaced.
        image: the picture, as `read_image` reads it; its file is copied.
        decomposition: the picture taken apart.
        names: of the classes, for people; "class 0" and so on by default.

    Raises:
        InputError: a folder that cannot be made, more than 65535 particles.
        ValueError: a picture of another size than the labels', or another number of names than of classes.

    Examples:
        >>> from jaxtex.io.images import write_image
        >>> row, column = np.indices((32, 32))
        >>> write_image("spot.png", np.where(np.hypot(row - 16, column - 16) < 8, 0.1, 0.7)[..., None])
        >>> image = read_image("spot.png")
        >>> write_particles("spot", image, describe_particles((image.pixels[..., 0] < 0.5).astype(int), [0]))
        >>> read_particles("spot").names
        ('class 0',)
    """
    if (image.height, image.width) != decomposition.labels.shape:
        raise ValueError(f"image of {image.width} x {image.height}: give the one with the labels")
    names = tuple(f"class {kind}" for kind in range(decomposition.kinds)) if names is None else names
    if len(names) != decomposition.kinds:
        raise ValueError(f"{len(names)} names: give one to each of {decomposition.kinds} classes")
    if len(decomposition.particles) > _MOST:
        raise InputError(f"picture: has {len(decomposition.particles)} things; {_MOST} can be kept in a folder")
    folder = prepare_folder(folder)
    picture = folder / f"{_PICTURE}{image.path.suffix.lower()}"
    if not (picture.exists() and picture.samefile(image.path)):
        with replacing(picture) as place:
            shutil.copyfile(image.path, place)
    numbers = decomposition.labels[..., None].astype(np.float32) / _MOST
    source = SourceImage(image.width, image.height, image.sha256)
    with replacing_together([folder / _LABELS, folder / _PARTICLES]) as (labels, particles):
        write_image(labels, numbers, colour_space="data", bits=16)
        content = {
            "picture": picture.name,
            "labels_sha256": _hash(labels),
            "classes": list(names),
            "particles": [{"class": each.kind} for each in decomposition.particles],
        }
        write_envelope(particles, "particles", image=source, content=content, versions=None, seed=None)


def has_mended_labels(folder: Path | str) -> bool:
    """Whether a folder has labels other than `write_particles` left there, which a person may have mended.

    Labels of which particles.json does not tell what was written, as older ones, are among them.

    Examples:
        >>> has_mended_labels("nowhere")
        False
    """
    folder = Path(folder)
    if not (folder / _LABELS).exists():
        return False
    try:
        document = json.loads((folder / _PARTICLES).read_bytes())
    except (OSError, ValueError, RecursionError):  # brackets nested too deep are no file of ours either
        return True
    written = document.get("labels_sha256") if isinstance(document, dict) else None
    return written != _hash(folder / _LABELS)


def _hash(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def read_particles(folder: Path | str) -> ParticleFolder:
    """Read what `write_particles` wrote; particles are measured anew on the labels.

    Raises:
        InputError: there is no such folder, a file of it is missing or damaged, or labels are not of the picture's
            size or have numbers without a class; the message names the file.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"{folder}: there is no such folder; jaxtex particles analyse makes one of a picture")
    if not (folder / _PARTICLES).exists():
        raise InputError(f"{folder}: holds no {_PARTICLES}; jaxtex particles analyse makes such a folder")
    document = read_envelope(folder / _PARTICLES, ("particles",))
    image = read_image(folder / Path(document["picture"]).name)
    marks = read_image(folder / _LABELS, colour_space="data").pixels
    if marks.shape != (image.height, image.width, 1):
        raise InputError(
            f"{folder / _LABELS}: is {marks.shape[1]} x {marks.shape[0]} with {marks.shape[2]} channels; "
            f"it must be grey, {image.width} x {image.height} as the picture"
        )
    labels = np.rint(marks[..., 0].astype(np.float64) * _MOST).astype(np.int32)
    kinds = [each["class"] for each in document["particles"]]
    if labels.max() > len(kinds):
        raise InputError(
            f"{folder / _LABELS}: has a particle {labels.max()}, but {folder / _PARTICLES} gives {len(kinds)} of them "
            "a class; add its line there"
        )
    if max(kinds, default=0) >= len(document["classes"]):
        raise InputError(f"{folder / _PARTICLES}: a particle is of class {max(kinds)}, which has no name in classes")
    there = np.unique(labels[labels > 0])
    if not there.size:
        raise InputError(f"{folder / _LABELS}: is all 0, so there are no particles")
    used, dense = np.unique([kinds[number - 1] for number in there], return_inverse=True)
    names = tuple(str(document["classes"][kind]) for kind in used)
    return ParticleFolder(image, describe_particles(labels, dense), names)
