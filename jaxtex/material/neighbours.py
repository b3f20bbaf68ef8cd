"""How the colours of tiles hang together: from neighbour to neighbour, and from course to course."""

import math

import numpy as np
import numpy.typing as npt
from scipy.special import ndtri
from scipy.stats import rankdata

from jaxtex.material.draw import STRONGEST, principal_axes, to_logit
from jaxtex.material.patterns import Pattern, class_of

_SURE = 3.0  # standard errors from nothing: less is taken for chance
_FEWEST = 12  # pairs of neighbours, or tiles


def measure_neighbours(
    places: npt.NDArray[np.int_], colours: npt.NDArray[np.floating], pattern: Pattern
) -> tuple[tuple[float, float], tuple[float, float, float]]:
    """Measure how alike neighbouring tiles are, and how tiles change from course to course.

    Args:
        places: (course, tile) of the tiles seen, [tile, 2].
        colours: theirs, linear light, [tile, 3].
        pattern: which tiles share a class of colours; it is compared with the others of the class.

    Returns:
        `neighbours` and `trend` of an `Appearance`; zeros where chance alone may have made them.

    Examples:
        >>> places = np.stack(np.indices((20, 5)), axis=-1).reshape(-1, 2)
        >>> noise = np.random.default_rng(0).normal(0.0, 0.01, (100, 1))
        >>> darker = 0.5 - 0.01 * places[:, :1] + noise
        >>> neighbours, trend = measure_neighbours(places, np.repeat(darker, 3, axis=1), ((0,),))
        >>> neighbours, trend[0] < -0.01
        ((0.0, 0.0), True)
    """
    label = class_of(pattern, *places.T)
    values = to_logit(colours)
    values = values - np.stack([values[label == each].mean(axis=0) for each in label])
    if len(values) < _FEWEST:
        return (0.0, 0.0), (0.0, 0.0, 0.0)
    trend = _trend(places[:, 0].astype(float), values)
    rest = values - trend * (places[:, :1] - places[:, 0].mean())
    first = rest @ principal_axes(rest)[1][:, -1]
    score = np.asarray(ndtri((rankdata(first) - 0.5) / len(first)))
    red, green, blue = trend.tolist()
    return (_correlation(places, score, (0, 1)), _correlation(places, score, (1, 0))), (red, green, blue)


def _trend(course: npt.NDArray[np.float64], values: npt.NDArray[np.floating]) -> npt.NDArray[np.floating]:
    """Change of values [tile, channel] by course, [channel]."""
    place = course - course.mean()
    spread = float(place @ place)
    if spread == 0:
        return np.zeros(values.shape[1])
    slope = place @ values / spread
    axis = slope / max(float(np.linalg.norm(slope)), 1e-12)
    left = values @ axis - place * np.linalg.norm(slope)
    error = math.sqrt(float(left @ left) / max(len(left) - 2, 1) / spread)
    # As the axis was chosen after the fact, three channels have three chances.
    return slope if np.linalg.norm(slope) > (_SURE + 1.0) * error else np.zeros_like(slope)


def _correlation(places: npt.NDArray[np.int_], score: npt.NDArray[np.floating], step: tuple[int, int]) -> float:
    """Of normal scores between tiles and those a step away."""
    number = {place: n for n, place in enumerate(map(tuple, places.tolist()))}
    pairs = [
        (n, number[c + step[0], t + step[1]]) for (c, t), n in number.items() if (c + step[0], t + step[1]) in number
    ]
    if len(pairs) < _FEWEST or not score.any():
        return 0.0
    one, other = np.array(pairs).T
    found = float(np.mean(score[one] * score[other]) / np.mean(np.square(score)))
    return float(np.clip(found, -STRONGEST, STRONGEST)) if abs(found) > _SURE / math.sqrt(len(pairs)) else 0.0
