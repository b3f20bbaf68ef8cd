"""Photograph -> mask of tiles and joints, with nobody clicking.

A lattice tells which pixels should be joint and which tile, up to its own error. From these labels a linear
discriminant learns what joints look like in *this* photograph: lighter, darker, of another colour, a groove, an edge or
all of it together. The discriminant, not the lattice, then makes the mask, so that missing joints stay missing.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.typing import NDArray
from skimage import transform

from jaxtex.core.errors import InputError
from jaxtex.photo.courses import Map, all_views, find_courses, same_courses
from jaxtex.photo.evidence import Evidence, find_evidence, shrink
from jaxtex.photo.lattice import Lattice, joint_distances, list_rows, to_strips
from jaxtex.photo.pictures import check_picture
from jaxtex.photo.scanlines import scan_courses

WORKING_SIZE = 512
_ROUNDS = 2
_SMALLEST = 32  # pixels
_LONGEST = 6  # times as long as wide
_RECONSIDERED = 3  # lattices whose nodes are tried in other rows
_SHRINKAGE = 0.02  # of the within-class covariance towards its diagonal


class Reading(NamedTuple):
    """What was read off a photograph: ``joint`` (H, W), probability that a pixel is joint, at the working size, and
    ``lattices``, guesses at the tiling in its pixels, best first."""

    joint: Map
    lattices: list[Lattice]


def read_tiling(evidence: Evidence, *, perspective: bool = True, learn: bool = True) -> Reading:
    """Find lattices in the evidence, learn from the best what joints look like, and look again in what was learnt.

    Without ``learn`` the only feature is itself the probability of a joint: the user's mask.
    """
    views = all_views(perspective)
    if not learn:
        return Reading(evidence.features[..., 0], find_lattices(evidence.joints, views, per_map=4, drawn=True))
    lattices = find_lattices(evidence.joints, views, per_map=2)
    joint: Map = np.full(evidence.features.shape[:2], 0.5, np.float32)
    for _ in range(_ROUNDS):
        if not lattices:
            break
        odds = learn_joints(evidence.features, _nearness(lattices[0], joint.shape))
        joint = probability(odds)
        # In the odds, unlike in the probability, faint joints still stand out. The view is known by now.
        known = [lattice.tilt * max(joint.shape) / 2 for lattice in lattices[:3]]
        lattices = find_lattices({"learnt": odds - odds.mean()}, [views[0], *known], per_map=4)
    return Reading(joint, lattices)


def glance_at_mask(evidence: Evidence) -> Reading:
    """What the strongest courses of the user's mask say, seen straight on: much sooner than :func:`read_tiling`."""
    lattices = find_lattices(evidence.joints, all_views(False), per_map=1, drawn=True, reconsidered=0)
    return Reading(evidence.features[..., 0], lattices)


def find_lattices(
    joints: dict[str, Map],
    views: list[NDArray[np.float64]],
    *,
    per_map: int,
    drawn: bool = False,
    reconsidered: int = _RECONSIDERED,
) -> list[Lattice]:
    """All guesses from all maps (H, W), best first.

    ``drawn`` as in :func:`scan_courses`; ``reconsidered``: how many of the best are tried in other rows too.
    """
    families = find_courses(joints, views=views, per_map=per_map)
    lattices: list[Lattice] = []
    extent = max(next(iter(joints.values())).shape)
    found = [
        (lattice, family)
        for family in families
        for lattice in scan_courses(joints[family.evidence], family, drawn=drawn)
    ]
    found.sort(key=lambda each: -each[0].score)
    # Shifted courses of narrow tiles look like courses that slant: nodes tell which courses they may lie on.
    for lattice, family in found[:reconsidered]:
        for angle, height in list_rows(lattice):
            other = family._replace(angle=angle, height=height)
            if not any(same_courses(other, known, extent, slack=0.3) for known in families):
                families.append(other)
                lattices += scan_courses(joints[other.evidence], other, drawn=drawn)
    lattices += [lattice for lattice, _ in found]
    return sorted(lattices, key=lambda lattice: -lattice.score)


def learn_joints(features: Map, near: NDArray[np.floating]) -> Map:
    """Log-odds (H, W), within +-8, that a pixel is joint: a discriminant of ``features`` (H, W, F), taught by how
    ``near`` (H, W) pixels are to the nearest joint's centre line, in thicknesses of that joint."""
    spread = features.reshape(-1, features.shape[-1])
    spread = (spread - spread.mean(0)) / np.maximum(spread.std(0), 1e-6)
    joint, tile = spread[(near < 0.3).ravel()], spread[(near > 0.9).ravel()]
    if min(len(joint), len(tile)) < 30:
        return np.zeros(near.shape, np.float32)
    direction, _ = part(joint, tile)
    odds = (spread - (joint.mean(0) + tile.mean(0)) / 2) @ direction
    return np.clip(odds, -8, 8).reshape(near.shape).astype(np.float32)


def part(some: NDArray[np.floating], others: NDArray[np.floating]) -> tuple[NDArray[np.float64], float]:
    """Fisher's discriminant of two classes of features, (N, F) and (M, F): the direction (F,) along which they lie
    furthest apart, and how far, in standard deviations within a class."""
    apart = (some.mean(0) - others.mean(0)).astype(float)
    within = np.atleast_2d((np.cov(some.T) + np.cov(others.T)) / 2)
    within = within + _SHRINKAGE * np.diag(np.diag(within) + 1e-3)
    direction = np.linalg.solve(within, apart)
    return direction, float(np.sqrt(apart @ direction))


def probability(odds: Map) -> Map:
    """Of log-odds."""
    return (1 / (1 + np.exp(-odds))).astype(np.float32)


def _nearness(lattice: Lattice, shape: tuple[int, int]) -> NDArray[np.floating]:
    height, width = shape
    x, y = np.meshgrid(np.arange(width) + 0.5 - width / 2, np.arange(height) + 0.5 - height / 2)
    head, bed = joint_distances(lattice, *to_strips(lattice, x, y))
    return np.minimum(head / lattice.joints[0], bed / lattice.joints[1])


def auto_mask(pixels: NDArray[np.floating]) -> NDArray[np.bool_]:
    """Mask [H, W] of a tiled surface, True on tiles, from its picture alone.

    Args:
        pixels: linear [H, W], [H, W, 1] or [H, W, 3], at least 32 x 32.

    Raises:
        InputError: as `check_surface`; or nothing in the picture repeats.
    """
    picture = check_surface(pixels)
    reading = read_tiling(find_evidence(shrink(picture, WORKING_SIZE)))
    if not reading.lattices:
        raise InputError("nothing in the picture repeats like courses of tiles; make the mask by lightness or colour")
    return transform.resize(reading.joint, picture.shape[:2], order=1) < 0.5


def check_surface(pixels: npt.ArrayLike) -> Map:
    """A picture (H, W, 1 or 3) that is large enough, and not too long, for courses to be looked for in it.

    Raises:
        InputError: it is not, or is no picture: see `check_picture`.
    """
    if isinstance(pixels, str | Path):
        raise InputError(f"{pixels}: is a path; read the picture with read_image and hand in its pixels")
    if np.asarray(pixels).dtype.kind in "iu":
        raise InputError("picture: holds whole numbers; it must be linear light, 1 being white (see read_image)")
    picture = check_picture(pixels)
    height, width = picture.shape[:2]
    if min(height, width) < _SMALLEST:
        raise InputError(f"the picture has {width} x {height} pixels; it must have {_SMALLEST} x {_SMALLEST} at least")
    if max(height, width) > _LONGEST * min(height, width):
        raise InputError(f"the picture has {width} x {height} pixels, too long for its width; fit a piece of it")
    # Exposure is anybody's choice: what counts are differences.
    return picture / max(float(np.quantile(picture, 0.999)), 1.0)
