"""Synthesis pixel by pixel, as the papers have it: loops over rows and columns, one candidate after another. What the
wavefronts of `jaxtex.synthesis` are compared with."""

from collections.abc import Iterator

import jax
import numpy as np
from scipy.ndimage import gaussian_filter

from jaxtex.synthesis.neighbourhoods import pass_seed
from jaxtex.synthesis.wei_levoy import coarsening, halve

Place = tuple[int, int]

WORD = 2**32 - 1


def mix(word: int) -> int:
    word &= WORD
    word = (word ^ (word >> 16)) * 0x7FEB352D & WORD
    word = (word ^ (word >> 15)) * 0x846CA68B & WORD
    return word ^ (word >> 16)


def draw(word: int, number: int) -> int:
    return mix(word + 0x9E3779B9 * number)


def draw_place(bits: int, shape: tuple[int, int], radius: int) -> Place:
    rows, columns = (side - 2 * radius for side in shape)
    return radius + ((bits >> 16) * rows >> 16), radius + ((bits & 0xFFFF) * columns >> 16)


class PlainAshikhmin:
    """Ashikhmin's synthesis; arguments as of `synthesise_ashikhmin`. `passes` yields source maps."""

    def __init__(
        self,
        exemplar,
        shape,
        *,
        key,
        radius=2,
        similar=None,
        tileable=False,
        target=None,
        painted=None,
        even_rows=False,
    ):
        blurred = gaussian_filter(np.float32(exemplar), (2 * radius, 2 * radius, 0))
        self.levels, self.afar = (np.round(np.clip(each, 0, 1) * 255).astype(int) for each in (exemplar, blurred))
        self.shape, self.key, self.radius, self.similar, self.tileable = shape, key, radius, similar, tileable
        self.target = None if target is None else np.round(np.clip(target, 0, 1) * 255).astype(int)
        self.painted = np.zeros(shape, bool) if target is None else np.ones(shape, bool) if painted is None else painted
        self.even_rows = even_rows
        self.offsets = [(dy, dx) for dy in range(-radius, radius + 1) for dx in range(-radius, radius + 1)]
        self.causal = 2 * radius * (radius + 1)

    def passes(self, count: int, start: np.ndarray | None = None) -> Iterator[np.ndarray]:
        whole = [(y, x) for y in range(self.shape[0]) for x in range(self.shape[1])]
        sources = None if start is None else {at: tuple(start[at]) for at in whole}
        for number in range(count) if start is None else range(1, count + 1):
            key = jax.random.fold_in(self.key, number)
            if sources is None:
                sources = self.go_over({}, whole, key, 0, first=True)
                if self.tileable:
                    sources = self.join_borders(sources, key)
            else:
                sources = self.go_over(sources, whole, key, 0)
            yield np.array([sources[at] for at in whole], np.int32).reshape(*self.shape, 2)

    def join_borders(self, sources: dict[Place, Place], key) -> dict[Place, Place]:
        near, far = (
            [min(reach * self.radius, side // part) for side in self.shape] for reach, part in ((8, 4), (10, 2))
        )

        def across(axis: int, reach: int, wide: int) -> list[int]:
            side = self.shape[axis]
            return [at % side for at in range(side - reach, side - reach + wide)]

        def inside(axis: int) -> list[int]:
            return list(range(near[axis], self.shape[axis] - near[axis]))

        emptied = [across(axis, near[axis], 2 * near[axis]) for axis in (0, 1)]
        visited = [across(axis, far[axis], min(20 * self.radius, self.shape[axis])) for axis in (0, 1)]
        strips = [
            ((inside(0), emptied[1]), (inside(0), visited[1])),
            ((emptied[0], inside(1)), (visited[0], inside(1))),
            ((emptied[0], emptied[1]), (visited[0], visited[1])),
        ]
        for index, (empty, visit) in enumerate(strips):
            holes = {(y, x) for y in empty[0] for x in empty[1]}
            sources = {at: source for at, source in sources.items() if at not in holes}
            for turn in range(2):
                order = [(y, x) for y in visit[0] for x in visit[1]]
                sources = self.go_over(sources, order, key, 1 + 2 * index + turn)
        return sources

    def go_over(
        self, former: dict[Place, Place], order: list[Place], key, scan: int, first: bool = False
    ) -> dict[Place, Place]:
        """Visit pixels in this order, which is scanline order of a rectangle that may go on at the opposite border.
        What lies around the rectangle is seen as it was, also where it is the rectangle's own other end."""
        seed = [int(word) for word in np.asarray(pass_seed(key, scan))]
        sources = dict(former)
        tall = len({y for y, _ in order})
        wide = len(order) // max(tall, 1)
        for number, at in enumerate(order):
            row, column = divmod(number, wide)
            seen = {}
            for tap, (dy, dx) in enumerate(self.offsets):
                y, x = at[0] + dy, at[1] + dx
                inside = 0 <= row + dy < tall and 0 <= column + dx < wide
                if not inside and not (self.tileable and not first) and not self.holds(y, x):
                    continue
                place = (y % self.shape[0], x % self.shape[1])
                if place in (known := sources if inside else former):
                    seen[tap] = known[place]
            word = mix(seed[0] + mix(seed[1] + at[0] * self.shape[1] + at[1]))
            sources[at] = self.choose(at, seen, word, first)
        return sources

    def holds(self, y: int, x: int) -> bool:
        return 0 <= y < self.shape[0] and 0 <= x < self.shape[1]

    def choose(self, at: Place, seen: dict[int, Place], word: int, first: bool) -> Place:
        compared = {tap: self.levels[place] for tap, place in seen.items() if tap != self.causal}
        if first:
            compared = {tap: level for tap, level in compared.items() if tap < self.causal}
        groups = []
        for tap, (y, x) in seen.items():
            candidate = (y - self.offsets[tap][0], x - self.offsets[tap][1])
            bits = draw(word, tap + 1)
            if not self.is_valid(*candidate) or (first and self.gives_way(candidate[0], mix(~bits))):
                candidate = self.random_place(bits)
            group = [candidate] if self.similar is None else [tuple(each) for each in self.similar[candidate]]
            groups.append((1, group))
        if self.painted[at] and seen:
            groups.append((4, [self.random_place(draw(word, len(self.offsets) + 1))]))
        best = None
        for times, group in groups:
            for place in group:
                distance = sum(
                    int(((self.levels[place[0] + self.offsets[t][0], place[1] + self.offsets[t][1]] - c) ** 2).sum())
                    for t, c in compared.items()
                )
                if self.painted[at]:
                    distance += self.causal * int(((self.afar[place] - self.target[at]) ** 2).sum())
                best = min(best or (times * distance, place), (times * distance, place))
        return self.random_place(draw(word, 0)) if best is None else best[1]

    def is_valid(self, *place: int) -> bool:
        return all(
            self.radius <= each < side - self.radius for each, side in zip(place, self.levels.shape[:2], strict=True)
        )

    def gives_way(self, row: int, bits: int) -> bool:
        if not self.even_rows:
            return False
        rows = self.levels.shape[0]
        distance = (rows - 1 - self.radius - row) / max(rows - 1 - 2 * self.radius, 1)
        return bits > int((distance ** (1 / distance) if distance > 0 else 0.0) * WORD)

    def random_place(self, bits: int) -> Place:
        return draw_place(bits, self.levels.shape[:2], self.radius)


def synthesise_plain_wei_levoy(exemplar, shape, *, key, radius, levels) -> np.ndarray:
    """Wei and Levoy's synthesis with exhaustive search; arguments as of `synthesise_wei_levoy`."""
    pyramid, sizes = [np.asarray(exemplar, np.float32)], [shape]
    for _ in range(levels - 1):
        pyramid.append(halve(pyramid[-1]))
        sizes.append(tuple((side + 1) // 2 for side in sizes[-1]))
    taps = [(0, dy, dx) for dy in range(-radius, 1) for dx in range(-radius, radius + 1) if (dy, dx) < (0, 0)]
    half = radius // 2
    above = [(1, dy, dx) for dy in range(-half, half + 1) for dx in range(-half, half + 1)]
    sources = None
    for level in reversed(range(levels)):
        all_taps = taps if sources is None else taps + above
        shift = coarsening(len(all_taps) * pyramid[0].shape[2])
        there = [np.round(np.clip(each, 0, 1) * 255).astype(int) >> shift for each in pyramid[level : level + 2]]
        parent = {} if sources is None else {at: there[1][source] for at, source in sources.items()}
        seed = [int(word) for word in np.asarray(pass_seed(key, level))]
        rows, columns = there[0].shape[:2]
        valid = [(y, x) for y in range(radius, rows - radius) for x in range(radius, columns - radius)]
        known, sources = [{}, parent], {}
        for y in range(sizes[level][0]):
            for x in range(sizes[level][1]):
                seen = []
                for up, dy, dx in all_taps:
                    at = (y // 2**up + dy, x // 2**up + dx)
                    if at in known[up]:
                        seen.append((up, dy, dx, known[up][at]))
                distances = [
                    sum(int(((there[up][v // 2**up + dy, u // 2**up + dx] - c) ** 2).sum()) for up, dy, dx, c in seen)
                    for v, u in valid
                ]
                word = mix(seed[0] + mix(seed[1] + y * sizes[level][1] + x))
                chosen = draw_place(draw(word, 0), (rows, columns), radius)
                sources[y, x] = valid[int(np.argmin(distances))] if seen else chosen
                known[0][y, x] = there[0][sources[y, x]]
    return np.array([sources[y, x] for y in range(shape[0]) for x in range(shape[1])]).reshape(*shape, 2)
