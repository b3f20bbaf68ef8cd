"""Material maps of a sheet, from functions of one point.

What a pixel shows is the mean over the rectangle it covers, exactly so but for rounded corners and for what tiles and
joints are filled with: a flat map made at half the resolution is the larger map with each four pixels averaged.
"""

from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.core.errors import InputError
from jaxtex.material import filled, flat
from jaxtex.material.appearance import Appearance
from jaxtex.material.bands import BAND, check_sides, evaluate_points, in_bands, normals_of
from jaxtex.material.bands import LONGEST_SIDE as LONGEST_SIDE
from jaxtex.material.interiors import Interiors
from jaxtex.material.sheet import Sheet
from jaxtex.material.tables import Material, make_material
from jaxtex.material.tile_wood import ROWS, Timber

MOST_TILES = 4_000_000
"""More are refused; the ids of up to 16 million would be exact."""

_FEWEST = 4  # pixels across the narrowest tile


class Maps(NamedTuple):
    """Some rows of the maps of a sheet.

    Attributes:
        base_colour: linear light, [row, col, 3], 0 to 1.
        height: in plane pixels above the joints' floor, [row, col].
        normal: unit vectors, [row, col, 3]: x right, y up, z out of the sheet (OpenGL's).
        roughness: 0 to 1, [row, col].
        tile_id: the id of the tile at the pixel's centre as a whole number from 0, -1 in joints, [row, col].
        specular: how strongly what is no metal reflects, 0 to 1, [row, col]; 0.5 stands for 4 % seen straight on.
        metallic: 0 to 1, [row, col].
        occlusion: how much of an even sky lights the place, 0 to 1, [row, col].
    """

    base_colour: npt.NDArray[np.float32]
    height: npt.NDArray[np.float32]
    normal: npt.NDArray[np.float32]
    roughness: npt.NDArray[np.float32]
    tile_id: npt.NDArray[np.float32]
    specular: npt.NDArray[np.float32]
    metallic: npt.NDArray[np.float32]
    occlusion: npt.NDArray[np.float32]


def render_maps(
    sheet: Sheet,
    appearance: Appearance,
    *,
    size: tuple[int, int],
    key: Array,
    interiors: Interiors | None = None,
    timber: Timber | None = None,
) -> Iterator[Maps]:
    """Render the material maps of a sheet, some rows at a time from top to bottom.

    The maps cover the sheet exactly: where `size` has another ratio of sides, pixels are not square, and heights and
    slopes stay those of the sheet. Memory is that of a band of 128 rows, and of the stocks that interiors
    are cut from (1.4 GB while the largest are made), whatever the size. The maps of a seamless
    sheet go on, beyond their last row and column, with their first.

    Args:
        size: (width, height) in pixels.
        key: random key of the colours of tiles that were not seen, and of interiors; a tile's colour depends on nothing
            else, its interior on the resolution too.
        interiors: what tiles and joints are filled with. Without them they are flat.
        timber: wood that tiles are made of, in place of what fills them. Joints stay; tiles' edges become straight.

    Raises:
        InputError: a size without pixels, beyond `LONGEST_SIDE`, or with too few pixels for the sheet's tiles.

    Examples:
        >>> import jax
        >>> grey = Appearance(tiles={(0, 0): (0.3, 0.3, 0.3)}, joint=(0.5, 0.5, 0.5), joint_depth=2.0, edge_width=2.0)
        >>> from jaxtex.material.sheet import lay_sheet
        >>> from jaxtex.models.tiling import make_tiling
        >>> sheet = lay_sheet(make_tiling(tile_width=60, tile_height=20, offset=0.5), tiles=(2, 4))
        >>> rows = list(render_maps(sheet, grey, size=(64, 200), key=jax.random.key(0)))
        >>> [part.height.shape for part in rows]
        [(128, 64), (72, 64)]
    """
    _check_size(sheet, size)
    material = partial(make_material, sheet, appearance, interiors, size=size, key=key, timber=timber)
    return _render_bands(sheet, appearance, material, size)


def _check_size(sheet: Sheet, size: tuple[int, int]) -> None:
    check_sides(size)
    shortest = float(np.min(sheet.tiling.course_lengths))
    if sheet.along / shortest * sheet.rows > MOST_TILES:
        raise InputError(f"{sheet.columns:g} x {sheet.rows} tiles: are too many; at most {MOST_TILES:,} can be made")
    across = size[0] / sheet.along * shortest
    along = size[1] / sheet.rows
    if min(across, along) < _FEWEST:
        raise InputError(
            f"size {size[0]} x {size[1]}: is too small for {sheet.columns:g} x {sheet.rows} tiles, as it leaves "
            f"{min(across, along):.2g} pixels to a tile; give at least {_FEWEST}, or fewer tiles"
        )


def _render_bands(
    sheet: Sheet, appearance: Appearance, make: Callable[[], Material], size: tuple[int, int]
) -> Iterator[Maps]:
    material = make()  # now, when the first row is asked for
    finish = _Finish(
        *(
            np.array([getattr(appearance, f"{part}_{name}") for part in ("tile", "joint")], np.float32)
            for name in ("roughness", "specular", "metallic")
        )
    )
    render = _render_flat if material.filling is None else _render_filled
    extent = sheet.width, sheet.height
    yield from in_bands(lambda x, y: render(material, finish, x, y), corner=sheet.corner, extent=extent, size=size)


class _Finish(NamedTuple):
    """Of tiles and of joints, (2,) each."""

    roughness: npt.NDArray[np.float32]
    specular: npt.NDArray[np.float32]
    metallic: npt.NDArray[np.float32]

    def over(self, joint: npt.NDArray[np.float32]) -> dict[str, npt.NDArray[np.float32]]:
        """As maps, by how much of each pixel is joint."""
        return {name: pair[0] + joint * (pair[1] - pair[0]) for name, pair in self._asdict().items()}


def _render_flat(material: Material, finish: _Finish, x: Array, y: Array) -> Maps:
    # One kernel for each: a map of one value per pixel is compiled into a single loop, all of them together are not,
    # and take five times as long.
    slopes = [evaluate_points(function, material, x, y) for function in (flat.slope_x, flat.slope_y)]
    names = ("base_colour", "height", "joint", "tile_id", "occlusion")
    maps = {name: np.asarray(evaluate_points(getattr(flat, name), material, x, y)) for name in names}
    return Maps(normal=np.asarray(normals_of(*slopes)), **finish.over(maps.pop("joint")), **maps)


def _render_filled(material: Material, finish: _Finish, x: Array, y: Array) -> Maps:
    rows = (BAND, BAND) if material.wood is None else ROWS
    seen = evaluate_points(filled.look, material, x, y, rows=rows[0])
    # Slopes are those of the height as it stands in the map, which takes a pixel more on all sides.
    around = [
        jnp.concatenate([at[:1] - step, at, at[-1:] + step]) for at, step in zip((x, y), material.pixel, strict=True)
    ]
    height = np.asarray(evaluate_points(filled.height, material, *around, rows=rows[1]))
    pixel = np.asarray(material.pixel)
    slope_x = (height[1:-1, 2:] - height[1:-1, :-2]) / (2 * pixel[0])
    slope_y = (height[2:, 1:-1] - height[:-2, 1:-1]) / (2 * pixel[1])
    maps = finish.over(np.asarray(seen.joint))
    if material.wood is not None and material.wood.bare:
        maps["roughness"] = maps["roughness"] + (1 - seen.joint) * (seen.roughness - finish.roughness[0])
    return Maps(
        base_colour=np.asarray(seen.base_colour),
        height=height[1:-1, 1:-1],
        normal=np.asarray(normals_of(jnp.asarray(slope_x), jnp.asarray(slope_y))),
        tile_id=np.asarray(seen.tile_id),
        occlusion=np.asarray(seen.occlusion),
        **maps,
    )
