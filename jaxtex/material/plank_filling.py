"""The grain that planks of a floor are given at the resolution of its maps."""

import dataclasses
import math
from collections.abc import Sequence

import jax
import numpy as np
import numpy.typing as npt
from jax import Array

from jaxtex.core.colour import linear_to_srgb, srgb_to_linear
from jaxtex.material.grain import at_distance
from jaxtex.material.planks import PlankFrame, PlankInteriors, frame_of
from jaxtex.material.stocks import choose_side, choose_slope, make_grain, relief_of
from jaxtex.models.floor_files import PlacedWood


@dataclasses.dataclass(frozen=True)
class PlankFilling:
    """Stocks of grain, and which piece of them each plank takes.

    Attributes:
        interiors: of the planks.
        stocks: [row along, col across, 4] for planks without rings of their own, and with: changes of sRGB-encoded
            colour, and relief in pixels of the photograph. Rows are as long as those of the examples.
        fine: likewise, of the grain that such rows leave out, [row, col, 3]: they are as long as columns are broad.
        frames: of the planks.
        first: the stock's (row, col) at each plank's middle, [plank, 2].
        pixel: breadth of a map's pixel in pixels of the photograph.
    """

    interiors: PlankInteriors
    stocks: tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]
    fine: tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]
    frames: tuple[PlankFrame, ...]
    first: npt.NDArray[np.float64]
    pixel: float

    @property
    def joint(self) -> npt.NDArray[np.float32]:
        """The joints' colour, sRGB-encoded, (3,)."""
        return self.interiors.joint

    def finish(
        self, number: int, points: npt.NDArray[np.float64], colour: npt.NDArray, height: npt.NDArray
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
        """Colours (linear light) and heights of a plank's points, with its tone and grain.

        Args:
            number: of the plank.
            points: [point, 2], (x, y) from its middle, in pixels of the photograph.
            colour, height: of the rings.
        """
        own, frame = bool(self.interiors.own[number]), self.frames[number]
        u, v = points @ frame.across, points @ frame.along
        grain = self.interiors.contrast[number] * self._grain_at(number, own, u, v)
        side = at_distance(self.interiors.profile, frame.half[0] - np.abs(u))
        encoded = self.interiors.tone[number] + grain[:, :3] + side
        if own:
            encoded = encoded + linear_to_srgb(np.clip(colour, 0, 1))
        relief = grain[:, 3] + height if own else grain[:, 3]
        return srgb_to_linear(np.clip(encoded, 0, 1)).astype(np.float32), relief.astype(np.float32)

    def _grain_at(self, number: int, own: bool, u: npt.NDArray, v: npt.NDArray) -> npt.NDArray[np.float32]:
        """Across the plank the nearest pixel of the stock, along it between two."""
        stock = self.stocks[own]
        rows, columns = stock.shape[:2]
        along = v / (self.pixel * self.interiors.grain[own].squeezed) + self.first[number, 0]
        column = np.floor(u / self.pixel + self.first[number, 1]).astype(int) % columns
        low = np.floor(along).astype(int)
        share = (along - low)[:, None].astype(np.float32)
        grain = stock[low % rows, column] * (1 - share) + stock[(low + 1) % rows, column] * share
        fine = self.fine[own]
        row = np.floor(v / self.pixel + self.first[number, 0]).astype(int)
        grain[:, :3] += fine[row % len(fine), column % fine.shape[1]]
        return grain


def fill_planks(
    planks: Sequence[PlacedWood], interiors: PlankInteriors, *, pixel: tuple[float, float], key: Array
) -> PlankFilling:
    """Make the stocks, and give every plank its piece.

    Args:
        planks: of the floor.
        interiors: as measured on it.
        pixel: breadth and height of the maps' pixels in pixels of the photograph; grain is made for squares.
        key: random key.
    """
    step = math.sqrt(pixel[0] * pixel[1])
    frames = tuple(frame_of(plank, turned=bool(turn)) for plank, turn in zip(planks, interiors.turned, strict=True))
    breadth = 2 * max(frame.half[0] for frame in frames) / step
    stocks, fine = [], []
    for sort, grain in enumerate(interiors.grain):
        length = 2 * max(frame.half[1] for frame in frames) / (step * grain.squeezed)
        colour = make_grain(
            grain.examples, (step, step), choose_side(breadth, length), key=jax.random.fold_in(key, sort)
        )
        relief = relief_of(colour, [grain.examples], choose_slope([grain.examples]))
        stocks.append(np.concatenate([colour, relief[..., None]], axis=-1).astype(np.float32))
        own_key = jax.random.fold_in(key, len(interiors.grain) + 1 + sort)
        fine.append(make_grain(grain.fine, (step, step), choose_side(breadth, breadth), key=own_key))
    side = np.array([stock.shape[0] for stock in stocks])[interiors.own.astype(int)]
    chance = np.asarray(jax.random.uniform(jax.random.fold_in(key, len(stocks)), (len(planks), 2)))
    return PlankFilling(
        interiors, (stocks[0], stocks[1]), (fine[0], fine[1]), frames, np.floor(chance * side[:, None]), step
    )
