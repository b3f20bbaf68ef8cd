"""Where one thing may end and another begin: how strong edges and dark lines are, and the patches between them.

P. Arbelaez, M. Maire, C. Fowlkes and J. Malik, "Contour detection and hierarchical image segmentation" (IEEE PAMI 33,
2011), section 3: edges are looked for in all directions, at several widths, in lightness, colour and texture.
Departures: filters are long Gaussian derivatives instead of half discs with histograms; texture is how rough a place
is; and a dark line, such as a joint or a shadow between two things, counts as an edge itself.
"""

import numpy as np
import numpy.typing as npt
from scipy import fft, ndimage
from skimage.morphology import h_minima
from skimage.segmentation import watershed

Map = npt.NDArray[np.float32]
Labels = npt.NDArray[np.int32]

_WIDTHS = 1.0, 2.0, 4.0  # pixels, standard deviation across an edge
_LONG = 2.5  # times that along it: what is shorter is texture
_DIRECTIONS = 8
_FAINT = 2.0  # steps of CIE Lab: spread at which an edge counts half of what it would count were there no noise
_SHALLOW = 0.02  # of edge strength: how much deeper than its rim a patch is at least


def find_edges(lab: Map) -> Map:
    """How strong an edge there is at each pixel of a picture in CIE Lab, [row, col].

    Returns:
        From 0 (even) to about 1 (a clean step, as strong as all that varies around it), whatever the contrast.
    """
    light = lab[..., 0]
    rough = np.sqrt(ndimage.gaussian_filter(np.square(light - ndimage.gaussian_filter(light, 1.0)), 2.0))
    channels = np.moveaxis(np.concatenate([lab, rough[..., None]], axis=2), 2, 0).astype(np.float32)
    return np.mean([_find_edges_at(channels, width) for width in _WIDTHS], axis=0, dtype=np.float32)


def part_at_edges(edges: Map) -> Labels:
    """Patches within which there is no edge to speak of, numbered from 1, by watershed."""
    middles, _ = ndimage.label(h_minima(edges, _SHALLOW))
    return watershed(edges, middles).astype(np.int32)


def _find_edges_at(channels: Map, width: float) -> Map:
    """The strongest of all directions, of channels [channel, row, col]."""
    pad = int(np.ceil(4 * _LONG * width))
    padded = np.pad(channels, ((0, 0), (pad, pad), (pad, pad)), mode="symmetric")
    shape = tuple(fft.next_fast_len(side, real=True) for side in padded.shape[1:])
    spectrum = fft.rfft2(padded, shape)
    rows, columns = 2 * np.pi * fft.fftfreq(shape[0])[:, None], 2 * np.pi * fft.rfftfreq(shape[1])[None]

    def filtered(which: npt.NDArray[np.complexfloating], response: npt.NDArray[np.number]) -> Map:
        whole = fft.irfft2(which * response.astype(np.complex64), shape)
        return whole[..., pad : pad + channels.shape[1], pad : pad + channels.shape[2]]

    strongest = np.zeros(channels.shape[1:], np.float32)
    for angle in np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS:
        across = width * (np.cos(angle) * columns + np.sin(angle) * rows)
        along = width * _LONG * (np.cos(angle) * rows - np.sin(angle) * columns)
        blur = np.exp(-0.5 * (across**2 + along**2))
        step = np.square(filtered(spectrum, 1j * across * blur)).sum(axis=0)
        dark = np.maximum(filtered(spectrum[0], -(across**2) * blur), 0)
        np.maximum(strongest, step + dark**2, out=strongest)
    mean = ndimage.gaussian_filter(channels, (0, 2 * width, 2 * width))
    square = ndimage.gaussian_filter(np.square(channels), (0, 2 * width, 2 * width))
    spread = np.maximum(square - np.square(mean), 0).sum(axis=0)
    return np.sqrt(strongest / (spread + _FAINT**2))
