"""Feature-based warping: texton masks whose elements grow, shrink, move, turn or bend from place to place.

J. Zhang et al., "Synthesis of Progressively-Variant Textures on Arbitrary Surfaces" (SIGGRAPH 2003), section 4.3 and
figures 5 and 6: dilation and erosion whose extent follows the transition function, and image warping by meshes, fields
and radial basis functions, with contours and centres of elements as features. `jaxtex.progressive.filtering` makes a
texture that goes with the mask.

Departures: masks are dilated and eroded by thresholding signed distances, so extents are any number of pixels and
change smoothly. Contours are found by marching squares rather than by border following (Suzuki and Abe 1985).
"""

from collections.abc import Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy import ndimage
from scipy.interpolate import RBFInterpolator
from scipy.spatial import cKDTree
from skimage.measure import find_contours, regionprops

from jaxtex.progressive.texton_masks import Labels, check_texton_mask

Direction = Literal["all", "horizontal", "vertical"]

_SMOOTHING = 0.7  # pixels, standard deviation: stairs that pixels make of borders do not grow with them
_LEAST = 1e-3  # pixels; a pixel is at least as far on its own side of a border
_END = 7  # points of a contour, some 5 pixels, that tell which way it goes where it leaves the picture
_LEAST_HALF = 0.1  # radians of half an arc, which is no longer told from a line
_SPECK = 6  # pixels: what is left of an element that is smaller vanishes
_CONTOUR_STEP = 3  # pixels between features along a contour
_NEIGHBOURS = 48  # features that count for a pixel
_NODE_STEP = 3  # pixels, at most, between places where the plane's bending is found by them
_BORDER_STEP = 16  # pixels between features that hold the picture's border

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Complexes = npt.NDArray[np.complex128]


def grow_mask(
    mask: npt.ArrayLike, amounts: npt.ArrayLike, *, types: Sequence[int] = (1, 2, 3), direction: Direction = "all"
) -> Labels:
    """Let elements of some types grow, or shrink, by an amount that varies from place to place.

    What they gain is of the type that is nearest there, and likewise what they lose: where elements of the types 0 and
    1 shrink, those of other types beside them widen (figure 6). What is left of an element that vanishes does not stay
    as a speck.

    Args:
        mask: labels 0 to 3, [row, col].
        amounts: pixels by which borders move outwards, or inwards if negative: a number, or [row, col].
        types: that grow together; borders between them do not move. 0 is what is around elements.
        direction: "horizontal" moves borders along rows alone, "vertical" along columns (figure 5).

    Returns:
        uint8 [row, col].

    Raises:
        InputError: no texton mask.
        ValueError: amounts of another shape or not finite, types that there are not.

    Examples:
        >>> grow_mask([[0] * 8 + [1] * 8], 2, direction="horizontal")
        array([[0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1]], dtype=uint8)
    """
    labels = check_texton_mask(mask)
    extent = np.asarray(amounts, np.float64)
    if extent.shape not in ((), labels.shape) or not np.isfinite(extent).all():
        raise ValueError(f"amounts of shape {extent.shape}: give a finite number, or one for each of {labels.shape}")
    if not types or not set(types) <= {0, 1, 2, 3}:
        raise ValueError(f"types: {tuple(types)} are none; give some of 0 to 3")
    inside = np.isin(labels, tuple(types))
    if inside.all() or not inside.any():
        return labels
    distance = signed_distance(inside, direction)
    grown = distance + extent > 0
    grown = _drop_specks(grown, inside)
    grown = ~_drop_specks(~grown, ~inside)
    return _relabel(labels, inside, grown, direction)


def signed_distance(inside: npt.ArrayLike, direction: Direction = "all") -> Floats:
    """How many pixels it is from each to the border of a region: above 0 inside, below 0 outside.

    Args:
        inside: bool [row, col].
        direction: "horizontal" looks along the row alone, "vertical" along the column.

    Returns:
        [row, col]. The border runs midway between pixels; of "all" directions, stairs that pixels make of it are
        smoothed, and what the picture cuts closes beyond a side or a corner of it as a circle where it bends so. Where
        no border is seen, it is as far away as any can be.

    Examples:
        >>> signed_distance([[False, False, True, True, True, True]], "horizontal").tolist()
        [[-1.5, -0.5, 0.5, 1.5, 2.5, 3.5]]
    """
    within = np.asarray(inside, bool)
    if direction == "all":
        distance = np.where(within, 1, -1) * _distance_to_contours(within)
        smooth = ndimage.gaussian_filter(distance, _SMOOTHING, mode="nearest")
        return np.where(within, np.maximum(smooth, _LEAST), np.minimum(smooth, -_LEAST))
    farthest = float(np.hypot(*within.shape))
    distance = np.where(within, _distance_to(~within, direction) - 0.5, 0.5 - _distance_to(within, direction))
    return np.clip(distance, -farthest, farthest)


def warp_mask(mask: npt.ArrayLike, displacement: npt.ArrayLike) -> Labels:
    """Move what a mask shows, by a field or by a mesh.

    Args:
        mask: labels 0 to 3, [row, col].
        displacement: how many pixels down and right of each pixel lies what it is to show, [row, col, 2]. An array of
            the mask's size is a field; one that is smaller is a mesh, whose nodes are spread over the picture
            evenly, first and last at its borders, with splines between them.

    Returns:
        uint8 [row, col]. Beyond the picture, what is at its border goes on.

    Raises:
        InputError: no texton mask.
        ValueError: a displacement of another form, larger than the mask, or not finite.

    Examples:
        >>> warp_mask([[0, 1, 0, 0]] * 4, np.broadcast_to([0.0, -2.0], (2, 2, 2)))[0]
        array([0, 0, 0, 1], dtype=uint8)
    """
    labels = check_texton_mask(mask)
    moves = np.asarray(displacement, np.float64)
    if moves.ndim != 3 or moves.shape[2] != 2 or not np.isfinite(moves).all():
        raise ValueError(f"displacement of shape {moves.shape}: give finite numbers, [row, col, 2]")
    moves = spread_mesh(moves, labels.shape)
    pixels = np.indices(labels.shape, np.float64)
    places = pixels + np.moveaxis(moves, -1, 0)
    values = np.unique(labels)
    depths = [
        ndimage.map_coordinates(signed_distance(labels == each), places, order=1, mode="nearest") for each in values
    ]
    return values[np.argmax(depths, axis=0)]


def spread_mesh(nodes: npt.ArrayLike, shape: tuple[int, ...]) -> Floats:
    """A field that has given values at the nodes of a mesh.

    Args:
        nodes: [row, col, channel], spread over the picture evenly, first and last at its borders.
        shape: (rows, columns) of the field, as many as nodes or more.

    Returns:
        [*shape, channel], splines between nodes.

    Raises:
        ValueError: fewer than 2 nodes down or across, or more than pixels.

    Examples:
        >>> spread_mesh([[[0.0], [2.0]], [[0.0], [2.0]]], (2, 3))[0, :, 0].tolist()
        [0.0, 1.0, 2.0]
    """
    values = np.asarray(nodes, np.float64)
    if not (2 <= values.shape[0] <= shape[0] and 2 <= values.shape[1] <= shape[1]):
        raise ValueError(f"{values.shape[:2]} nodes: give 2 to {shape[0]} rows and 2 to {shape[1]} columns")
    if values.shape[:2] == tuple(shape):
        return values
    step = [(count - 1) / (side - 1) for count, side in zip(values.shape[:2], shape, strict=True)]
    order = min(3, min(values.shape[:2]) - 1)
    at = np.indices(shape, np.float64) * np.array(step)[:, None, None]
    channels = [ndimage.map_coordinates(each, at, order=order, mode="nearest") for each in np.moveaxis(values, -1, 0)]
    return np.stack(channels, axis=-1)


def displace_elements(
    mask: npt.ArrayLike,
    *,
    scale: npt.ArrayLike = 1.0,
    turn: npt.ArrayLike = 0.0,
    shift: npt.ArrayLike = (0.0, 0.0),
) -> Floats:
    """The displacement that scales, turns and shifts each element about its own centre, for `warp_mask`.

    Contours and centres of elements are features; between these, radial basis functions (thin plates) bend the plane.
    The picture's border stays, and so do elements that touch it. Elements are the connected regions of a type but 0.

    Args:
        mask: labels 0 to 3, [row, col].
        scale: how many times as large, above 0; a number, or [row, col], read at the centres. What is scaled so much
            that it meets its neighbours folds the plane; `grow_mask` joins it.
        turn: radians, clockwise as seen; a number, or [row, col].
        shift: (row, col) in pixels, or [row, col, 2].

    Returns:
        [row, col, 2], 0 where no element is near.

    Raises:
        InputError: no texton mask.
        ValueError: fields of another shape or not finite, scales that are not above 0.

    Examples:
        >>> disk = np.hypot(*(np.indices((41, 41)) - 20)) < 6
        >>> twice = warp_mask(disk, displace_elements(disk, scale=2.0))
        >>> round(twice.sum() / disk.sum())
        4
    """
    labels = check_texton_mask(mask)
    sizes, turns = _spread(scale, labels.shape, "scale"), _spread(turn, labels.shape, "turn")
    moves = _spread(shift, (*labels.shape, 2), "shift")
    if sizes.min() <= 0:
        raise ValueError("scale: holds values that are not above 0")
    was, becomes = [_hold_border(labels.shape)], [_hold_border(labels.shape)]
    for centre, contour, whole in _find_features(labels):
        at = tuple(np.clip(np.rint(centre), 0, np.array(labels.shape) - 1).astype(int))
        cosine, sine = sizes[at] * np.cos(turns[at]), sizes[at] * np.sin(turns[at])
        moved = centre + moves[at] + (contour - centre) @ np.array([[cosine, -sine], [sine, cosine]])
        was.append(contour)
        becomes.append(moved if whole else contour)
    there, target = np.concatenate(was), np.concatenate(becomes)
    target, kept = np.unique(target, axis=0, return_index=True)
    bend = RBFInterpolator(target, there[kept] - target, neighbors=min(_NEIGHBOURS, len(target)))
    counts = [min(side, side // _NODE_STEP + 2) for side in labels.shape]
    nodes = np.meshgrid(
        *(np.linspace(0, side - 1, n) for side, n in zip(labels.shape, counts, strict=True)), indexing="ij"
    )
    return spread_mesh(bend(np.stack(nodes, axis=-1).reshape(-1, 2)).reshape(*counts, 2), labels.shape)


def _distance_to_contours(within: Bools) -> Floats:
    """From each pixel to the nearest contour of a region."""
    contours = find_contours(within.astype(np.float64), 0.5)
    if not contours:
        return np.full(within.shape, float(np.hypot(*within.shape)))
    points = [point for each in contours for point in (each, 0.5 * (each[1:] + each[:-1]))]
    points += _close_beyond(contours, within.shape)
    pixels = np.moveaxis(np.indices(within.shape), 0, -1)
    return np.asarray(cKDTree(np.concatenate(points)).query(pixels)[0])


def _close_beyond(contours: Sequence[Floats], shape: tuple[int, ...]) -> list[Floats]:
    """Arcs beyond the picture that close what is cut by its border, where its contours bend to each other there.

    Without them such an element would seem as deep at the border as it is wide there, and leave a tail when it shrinks.
    """
    cut = [each for each in contours if len(each) > 2 * _END and not np.array_equal(each[0], each[-1])]
    # Complex numbers x + iy, y upwards: what is beyond the picture lies to the left of who goes around it clockwise.
    lines = [line[:, 1] - 1j * line[:, 0] for each in cut for line in (each[::-1], each)]
    far = complex(shape[1] - 1, 1 - shape[0])
    ends = sorted(lines, key=lambda line: -np.angle(line[-1] - 0.5 * far))
    arcs = [_close(one, other, far) for one, other in zip(ends, ends[1:] + ends[:1], strict=True)]
    return [np.stack([-arc.imag, arc.real], axis=-1) for arc in arcs]


def _close(one: Complexes, other: Complexes, far: complex) -> Complexes:
    """The arc, if there is one, on which two contours whose ends follow on each other around the picture go on.

    Args:
        one, other: points at x + iy that lead to the ends.
        far: the lower right pixel of the picture.
    """
    was, way = (
        np.array([line[last] - line[first] for line in (one, other)])
        for first, last in ((-2 * _END, -_END), (-_END, -1))
    )
    chord, none = other[-1] - one[-1], np.empty(0, np.complex128)
    half = 0.5 * np.sum(np.angle([way[0] / chord, -chord / way[1]]) % (2 * np.pi))
    middle = 0.5 * (one[-1] + other[-1])
    is_one_side = middle.real in (0, far.real) or middle.imag in (0, far.imag)
    bend = np.sum(np.angle([was[0] / way[0], way[1] / was[1]]))
    if bend <= 0 or half >= (0.5 if is_one_side else 0.75) * np.pi:
        return none
    half = max(half - 0.25 * bend, _LEAST_HALF)  # ways are those a little before the ends
    radius = 0.5 * abs(chord) / np.sin(half)
    turn = np.arange(-half, half, 0.5 / radius)
    arc = middle + chord / abs(chord) * radius * (np.sin(turn) + 1j * (np.cos(turn) - np.cos(half)))
    depth = np.minimum.reduce([arc.real, far.real - arc.real, -arc.imag, arc.imag - far.imag])
    return arc if depth.max() < 1 else none


def _distance_to(region: Bools, direction: Direction) -> Floats:
    """From each pixel to the nearest of a region in its row or column, pixel centre to pixel centre."""
    if not region.any():
        return np.full(region.shape, np.inf)
    return np.asarray(ndimage.distance_transform_edt(~region, sampling=_sampling(region.shape, direction)))


def _sampling(shape: tuple[int, ...], direction: Direction) -> tuple[float, float]:
    """How long steps down and right are; where only one direction counts, steps in the other lead beyond all others."""
    far = 4.0 * sum(shape)
    return (far if direction == "horizontal" else 1.0, far if direction == "vertical" else 1.0)


def _drop_specks(region: Bools, before: Bools) -> Bools:
    """A region without the specks that are left of what was larger."""
    parts, count = ndimage.label(region)
    area = np.bincount(parts.ravel(), minlength=count + 1)
    old, _ = ndimage.label(before)
    was = ndimage.maximum(np.where(before, np.bincount(old.ravel())[old], 0), parts, np.arange(count + 1))
    dropped = (area < _SPECK) & (area < was)
    dropped[0] = False
    return region & ~dropped[parts]


def _relabel(labels: Labels, before: Bools, after: Bools, direction: Direction) -> Labels:
    """What a region gains and loses takes the label that is nearest on the side that it goes to."""
    made = labels.copy()
    for side, changed in ((before, after & ~before), (~before, before & ~after)):
        if changed.any():
            sampling = _sampling(labels.shape, direction)
            row, column = ndimage.distance_transform_edt(
                ~side, sampling=sampling, return_distances=False, return_indices=True
            )
            made[changed] = labels[row[changed], column[changed]]
    return made


def _spread(values: npt.ArrayLike, shape: tuple[int, ...], name: str) -> Floats:
    given = np.asarray(values, np.float64)
    if given.shape not in (shape, shape[2:]) or not np.isfinite(given).all():
        raise ValueError(f"{name} of shape {given.shape}: give finite numbers, {shape[2:]} or {shape}")
    return np.broadcast_to(given, shape)


def _find_features(labels: Labels) -> list[tuple[Floats, Floats, bool]]:
    """The centre of each element [2], points at it and around it [feature, 2], and whether all of it is seen."""
    features = []
    for value in np.unique(labels[labels > 0]):
        for region in regionprops(ndimage.label(labels == value)[0]):
            top, left, bottom, right = region.bbox
            contours = find_contours(np.pad(region.image, 1).astype(float), 0.5)
            points = [each[:-1:_CONTOUR_STEP] + np.array([top - 1, left - 1]) for each in contours]
            centre = np.array(region.centroid)
            whole = min(top, left) > 0 and bottom < labels.shape[0] and right < labels.shape[1]
            features.append((centre, np.concatenate([centre[None], *points]), whole))
    return features


def _hold_border(shape: tuple[int, ...]) -> Floats:
    rows, columns = (np.linspace(0, side - 1, max(2, side // _BORDER_STEP)) for side in shape)
    edges = [[(row, each) for row in rows] for each in (0, shape[1] - 1)]
    edges += [[(each, column) for column in columns[1:-1]] for each in (0, shape[0] - 1)]
    return np.concatenate([np.array(edge).reshape(-1, 2) for edge in edges])
