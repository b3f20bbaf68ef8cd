"""What is inside of tiles and joints: learnt from a photograph, so that others like them can be made.

Of a tile's face there are, from coarse to fine: its colour (`Appearance`), where its edges really are (`edges`), how
colours change towards each of its four sides, and its grain, for which Heeger and Bergen's algorithm takes examples.
All of it is in sRGB-encoded values, in which grain is about as strong on dark tiles as on bright ones.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from jaxtex.core.colour import linear_to_srgb
from jaxtex.core.errors import InputError
from jaxtex.material.appearance import Appearance
from jaxtex.material.cells import Cell, cut_cells
from jaxtex.material.clean import choose_clean
from jaxtex.material.edges import SIDES, measure_outlines
from jaxtex.material.grain import (
    face_colour,
    in_steps,
    joint_profile,
    joint_strips,
    stack_regions,
    tile_grain,
    tile_profile,
)
from jaxtex.material.patterns import class_of
from jaxtex.material.regions import Regions, cut_grain, cut_joints, find_tiles
from jaxtex.models.tiling import Tiling
from jaxtex.photo.pictures import check_picture

_CONTRAST = 0.4, 2.5  # of a tile's grain against the usual: no more is believed
_FARTHEST = 0.15  # of a tile: how far from the tiling's an edge is believed to be
_WOBBLE = 0.15  # of a joint: how far outlines are believed to stray besides
_NOISE = 0.7  # pixels: standard deviation of where a mask has an edge
_THINNEST = 1.5  # pixels: where joints are thinner, edges are where the tiling has them
_SMALLEST = 3  # pixels to a side of a face: smaller ones show nothing
_PAINTED = 0.6  # of a tile and the joints around it that must be painted over to count
_GAP = 0.25  # of a joint: what is left of it between any two tiles


@dataclasses.dataclass(frozen=True)
class Interiors:
    """What `measure_interiors` learns; all values sRGB-encoded, lengths in plane pixels.

    Attributes:
        places: (course, tile) of the tiles measured, [tile, 2].
        learnt: whether grain was learnt from the tile, [tile].
        kind: which of `tile_grain` each tile's grain is like, [tile].
        contrast: how strong it is, against the examples, [tile].
        offset: by how much the mean of each tile's inside is off the tile's colour, [tile, 3].
        shift: how far outside of the tiling's edges each tile ends, [tile, side] in the order of `SIDES`.
        wobble, wobble_length: how far outlines stray besides: standard deviation and correlation length.
        tile_grain: examples of each kind, [region, row, col, 3], around 0.
        joint_grain: examples of joints, [region, row, col, 3], around 0; none where joints are too thin.
        tile_profile: what a tile's colour changes by towards its sides, [side, pixel from the edge inwards, 3].
        joint_profile: what a joint's changes by towards tiles, [side of the tile, pixel from the edge outwards, 3].
    """

    places: npt.NDArray[np.int32]
    learnt: npt.NDArray[np.bool_]
    kind: npt.NDArray[np.int32]
    contrast: npt.NDArray[np.float32]
    offset: npt.NDArray[np.float32]
    shift: npt.NDArray[np.float32]
    wobble: float
    wobble_length: float
    tile_grain: tuple[npt.NDArray[np.float32], ...]
    joint_grain: npt.NDArray[np.float32]
    tile_profile: npt.NDArray[np.float32]
    joint_profile: npt.NDArray[np.float32]


def measure_interiors(
    pixels: npt.ArrayLike,
    tiling: Tiling,
    appearance: Appearance,
    *,
    mask: npt.ArrayLike,
    regions: Regions | None = None,
) -> Interiors | None:
    """Learn what is inside of tiles and joints (Lefebvre & Poulin 2000, section 2.4).

    The paper has the user select regions; here they may be selected, and otherwise are chosen: see
    `jaxtex.material.clean`.

    Args:
        pixels: linear light, [row, col, 1 or 3], with slow illumination evened out.
        tiling: fitted to this photograph.
        appearance: measured on it.
        mask: [row, col], 1 = tile, 0 = joint.
        regions: where to learn from.

    Returns:
        None where the picture shows no tile as a whole.

    Raises:
        InputError: a region shows nothing that can be learnt from.
    """
    regions = regions or Regions()
    layers = _layers(pixels, np.asarray(mask), regions.painted)
    cells = [cell for cell in cut_cells(layers, tiling, list(appearance.tiles)) if _shows_a_face(cell)]
    if not cells:
        return None
    masks = [np.clip(cell.values[..., 3], 0, 1) for cell in cells]
    painted = [np.maximum(np.rint(cell.values[..., 4]), 0).astype(int) for cell in cells]
    cells = [cell._replace(values=cell.values[..., :3]) for cell in cells]
    joint = float(tiling.mortar_x), float(tiling.mortar_y)
    places = np.array([cell.place for cell in cells], np.int32)
    outline = measure_outlines(cells, masks, reach=max(joint))
    shift = _plausible(outline.shift, places, cells, joint)
    cells = [_move_edges(cell, own) for cell, own in zip(cells, shift, strict=True)]
    kind = class_of(appearance.pattern, *places.T)
    clean = np.sort(np.concatenate([_clean_of(cells, masks, kind == each) for each in np.unique(kind)]))
    profile = tile_profile([cells[n] for n in clean])
    grains = [tile_grain(cell, profile) for cell in cells]
    contrast = _contrast(grains, clean)
    if regions.painted is not None:
        clean, kind = _follow_paint(painted, cells)
    even = [grain / strength for grain, strength in zip(grains, contrast, strict=True)]
    examples = tuple(_examples(even, clean, kind, each) for each in range(int(kind.max()) + 1))
    if regions.tiles:
        clean = find_tiles(tiling, cells, regions.tiles)
        examples = (stack_regions([cut_grain(tiling, cells, even, each) for each in regions.tiles], all_of_them=True),)
        kind = np.zeros_like(kind)
    strips = joint_strips(cells, masks, joint)
    if regions.joints:
        strips = cut_joints(layers[..., :3], tiling, regions.joints)
    joint_colour = linear_to_srgb(np.array(appearance.joint)).astype(np.float32)
    return Interiors(
        places=places,
        learnt=np.isin(np.arange(len(cells)), clean),
        kind=kind.astype(np.int32),
        contrast=contrast,
        offset=_offsets(cells, grains, appearance),
        shift=shift,
        wobble=min(outline.wobble, _WOBBLE * min(joint)),
        wobble_length=outline.length,
        tile_grain=tuple(in_steps(each) for each in examples),
        joint_grain=in_steps(strips),
        tile_profile=profile,
        joint_profile=joint_profile(cells, masks, joint_colour, 0.5 * max(joint)),
    )


def _layers(pixels: npt.ArrayLike, mask: npt.NDArray, painted: npt.NDArray[np.int32] | None) -> npt.NDArray[np.float32]:
    """sRGB-encoded colours, the mask, and what is painted, as one picture [row, col, 5]."""
    picture = check_picture(pixels)
    encoded = linear_to_srgb(np.clip(np.broadcast_to(picture, (*picture.shape[:2], 3)), 0, 1))
    kinds = np.ones(picture.shape[:2]) if painted is None else painted
    return np.concatenate([encoded, mask[..., None], kinds[..., None]], axis=-1).astype(np.float32)


def _follow_paint(
    painted: Sequence[npt.NDArray[np.int_]], cells: Sequence[Cell]
) -> tuple[npt.NDArray[np.int_], npt.NDArray[np.int_]]:
    """Tiles that are painted over, and the kind of every tile: as painted, or that of the painted one most like it."""
    share = np.array([[np.mean(each == kind) for kind in range(max(map(np.max, painted)) + 1)] for each in painted])
    chosen = np.flatnonzero(1 - share[:, 0] > _PAINTED)
    if not len(chosen):
        raise InputError("painted regions: cover no tile that the photograph shows as a whole; paint over whole tiles")
    kinds = np.unique(np.argmax(share[chosen, 1:], axis=1), return_inverse=True)[1]
    colours = np.array([face_colour(cell) for cell in cells])
    nearest = np.argmin(np.square(colours[:, None] - colours[chosen][None]).sum(axis=-1), axis=1)
    kind = kinds[nearest]
    kind[chosen] = kinds
    return chosen, kind


def _plausible(
    shift: npt.NDArray[np.float32], places: npt.NDArray[np.int32], cells: Sequence[Cell], joint: tuple[float, float]
) -> npt.NDArray[np.float32]:
    """Shifts of edges that leave tiles and the joints between them; on the average none, as the tiling has it."""
    shift = shift - np.median(shift)
    thickness = np.repeat(joint, 2)
    faces = 2 * np.repeat([(cell.left.max(), cell.top.max()) for cell in cells], 2, axis=1)
    farthest = np.minimum(_FARTHEST * (faces + thickness), thickness)
    # What is no more than a mask's uncertainty is taken for that: machine-made tiles lie in line.
    sure = np.maximum(0.0, 1.0 - (_NOISE / np.maximum(np.abs(shift), 1e-6)) ** 2)
    shift = np.clip(shift * sure, -np.minimum(farthest, 0.25 * faces), farthest)
    shift[:, thickness < _THINNEST] = 0.0
    shift[:, 2:] = np.minimum(shift[:, 2:], 0.5 * (1 - _GAP) * joint[1])
    number = {place: n for n, place in enumerate(map(tuple, places.tolist()))}
    for (course, tile), n in number.items():
        left = number.get((course, tile - 1))
        taken = shift[n, 0] + (shift[left, 1] if left is not None else 0.0)
        over = max(0.0, taken - (1 - _GAP) * joint[0])
        shift[n, 0] -= over if left is None else 0.5 * over
        if left is not None:
            shift[left, 1] -= 0.5 * over
        if (course, tile + 1) not in number:
            shift[n, 1] = min(shift[n, 1], (1 - _GAP) * joint[0])
    return shift.astype(np.float32)


def _shows_a_face(cell: Cell) -> bool:
    sides = np.minimum(cell.top, cell.bottom), np.minimum(cell.left, cell.right)
    return all(int(np.sum(side > 0)) >= _SMALLEST for side in sides)


def _clean_of(
    cells: Sequence[Cell], masks: Sequence[npt.NDArray[np.float32]], chosen: npt.NDArray[np.bool_]
) -> npt.NDArray[np.int_]:
    """The clean ones of the tiles of one kind: another kind may be another way."""
    numbers = np.flatnonzero(chosen)
    return numbers[choose_clean([cells[n] for n in numbers.tolist()], [masks[n] for n in numbers.tolist()])]


def _move_edges(cell: Cell, shift: npt.NDArray[np.float32]) -> Cell:
    return cell._replace(**{name: getattr(cell, name) + shift[n] for n, name in enumerate(SIDES)})


def _contrast(grains: Sequence[npt.NDArray[np.float32]], clean: npt.NDArray[np.int_]) -> npt.NDArray[np.float32]:
    """How strong each tile's grain is, against that of the usual clean tile."""
    spread = np.array([np.sqrt(np.mean(np.square(grain))) for grain in grains])
    return np.clip(spread / max(float(np.median(spread[clean])), 1e-4), *_CONTRAST).astype(np.float32)


def _offsets(
    cells: Sequence[Cell], grains: Sequence[npt.NDArray[np.float32]], appearance: Appearance
) -> npt.NDArray[np.float32]:
    """Of the means of tiles from their colours, which are medians, and rounded."""
    colours = linear_to_srgb(np.array([appearance.tiles[cell.place] for cell in cells]))
    means = [face_colour(cell) + grain.mean(axis=(0, 1)) for cell, grain in zip(cells, grains, strict=True)]
    return (np.array(means) - colours).astype(np.float32)


def _examples(
    grains: Sequence[npt.NDArray[np.float32]], clean: npt.NDArray[np.int_], kind: npt.NDArray[np.int_], wanted: int
) -> npt.NDArray[np.float32]:
    own = np.flatnonzero(kind == wanted)
    chosen = np.intersect1d(own, clean) if np.isin(own, clean).any() else own
    return stack_regions([grains[n] for n in (chosen if len(chosen) else clean)])
