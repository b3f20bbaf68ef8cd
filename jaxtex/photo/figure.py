"""The figure of a flat-sawn board: the map whose levels follow its rings where these close, or turn back.

Along the grain rings are drawn out to many times their width; the tips at which they turn are faint beside the fibres
that run through them. Seen squeezed along the grain they are as round as on end grain. The directions there, known but
for their sense, are made to point the same way from place to place; around the middle of closed rings all of them then
point outwards, and a map with these slopes closes around it.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, sparse
from scipy.sparse.linalg import spsolve
from skimage.restoration import unwrap_phase

from jaxtex.photo.directions import difference_matrices, measure_directions

Array = NDArray[np.float64]

_SQUEEZE = 4  # times, along the grain
_SCALE, _REACH = 2.0, 7.0  # pixels: of edges, and over which their directions are averaged
_NODES = 2  # every so many pixels across the grain, and squeezed ones along it
_EVEN = 0.05  # weight of even slopes, where directions weigh 1
_FLATTEST = 0.1  # pixels a pixel
_STIFF = 0.003  # how much the map resists any slope


def follow_figure(light: Array, across: float) -> Array:
    """The map (H, W), in pixels across the grain, whose levels are the rings of a picture's lightness (H, W).

    ``across`` the fibres, radians. Rings are taken to be evenly wide.
    """
    squeezed, inside, place = _squeeze(light, across)
    directions = measure_directions(squeezed, _SCALE, reach=_REACH)
    twice = np.ma.array(np.angle(directions.across), mask=~inside)
    sense = np.exp(0.5j * np.asarray(unwrap_phase(twice, rng=0).filled(0.0)))
    weight = inside * np.abs(directions.across) / directions.energy
    levels = ndimage.map_coordinates(_climb(sense, weight), place, order=1, mode="nearest")
    # Where directions disagree all slopes are less than wanted.
    return levels / max(float(np.median(np.hypot(*np.gradient(levels)))), _FLATTEST)


def _squeeze(light: Array, across: float) -> tuple[Array, NDArray[np.bool_], Array]:
    """A picture (H, W) turned, so that rows run along the grain, and squeezed along it; where it is that; and where in
    it each pixel has gone (2, H, W)."""
    height, width = light.shape
    c, s = np.cos(across), np.sin(across)
    rows = int(width * abs(c) + height * abs(s))
    columns = max(int(width * abs(s) + height * abs(c)) // _SQUEEZE, 2 * _NODES) * _SQUEEZE
    a, t = np.meshgrid(np.arange(rows) + 0.5 - rows / 2, np.arange(columns) + 0.5 - columns / 2, indexing="ij")
    u, v = a * c + t * s, a * s - t * c
    there = np.stack([v + height / 2 - 0.5, u + width / 2 - 0.5])
    inside = (np.abs(u) < width / 2) & (np.abs(v) < height / 2)
    turned = ndimage.map_coordinates(light, there, order=1, mode="nearest")
    shape = rows, columns // _SQUEEZE, _SQUEEZE
    v, u = np.indices(light.shape) + 0.5
    u, v = u - width / 2, v - height / 2
    place = np.stack([u * c + v * s + rows / 2 - 0.5, (u * s - v * c + columns / 2) / _SQUEEZE - 0.5])
    return turned.reshape(shape).mean(2), inside.reshape(shape).all(2), place


def _climb(sense: NDArray[np.complex128], weight: Array) -> Array:
    """The map (H, W) that climbs by 1 a pixel in directions (H, W), complex, by linear least squares."""
    shape = tuple(n // _NODES + 1 for n in weight.shape)
    near = np.ix_(*(np.arange(n - 1) * _NODES + _NODES // 2 for n in shape))
    x, y, known = sense.real[near].ravel(), sense.imag[near].ravel(), weight[near].ravel()
    right, down = difference_matrices((shape[0], shape[1]), _NODES)
    ahead = sparse.diags_array(known * x) @ right + sparse.diags_array(known * y) @ down
    aside = sparse.diags_array(-known * y) @ right + sparse.diags_array(known * x) @ down
    stiff = _STIFF * (right.T @ right + down.T @ down) + 1e-8 * sparse.eye_array(shape[0] * shape[1])
    normal = (_EVEN * ahead.T @ ahead + aside.T @ aside + stiff).tocsc()
    levels = spsolve(normal, _EVEN * ahead.T @ known).reshape(shape)
    place = (np.indices(weight.shape) + 0.5) / _NODES
    return ndimage.map_coordinates(levels, place, order=1, mode="nearest")
