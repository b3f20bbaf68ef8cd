"""Ashikhmin's and Wei and Levoy's synthesis as loops over pixels, compiled by Numba for one thread: the comparison of
the benchmark. Draws are those of `jaxtex.synthesis`, so that results are the same, bit for bit."""

import numba
import numpy as np

compiled = numba.njit(cache=False)


@compiled
def mix(word):
    word = np.uint32(word)
    word = np.uint32((word ^ (word >> np.uint32(16))) * np.uint32(0x7FEB352D))
    word = np.uint32((word ^ (word >> np.uint32(15))) * np.uint32(0x846CA68B))
    return word ^ (word >> np.uint32(16))


@compiled
def random_place(word, number, rows, columns, radius):
    bits = mix(np.uint32(word + np.uint32(0x9E3779B9) * np.uint32(number)))
    row = radius + ((bits >> np.uint32(16)) * np.uint32(rows - 2 * radius) >> np.uint32(16))
    column = radius + ((bits & np.uint32(0xFFFF)) * np.uint32(columns - 2 * radius) >> np.uint32(16))
    return np.int32(row * columns + column)


@compiled
def causal_distance(exemplar, made, v, u, y, x, radius, least):
    """Over the pixels made so far; given up, row by row, once beyond the least distance known."""
    columns, channels = made.shape[1], made.shape[2]
    distance = np.int32(0)
    for dy in range(max(-radius, -y), 1):
        last = radius + 1 if dy < 0 else 0
        for dx in range(max(-radius, -x), min(last, columns - x)):
            for channel in range(channels):
                step = np.int32(exemplar[v + dy, u + dx, channel]) - np.int32(made[y + dy, x + dx, channel])
                distance += step * step
        if distance > least:
            break
    return distance


@compiled
def suggest(candidates, sources, y, x, word, rows, columns, radius):
    """The candidates of a pixel, without duplicates; returns how many."""
    count, tap = 0, 0
    for dy in range(-radius, 1):
        for dx in range(-radius, radius + 1 if dy < 0 else 0):
            tap += 1
            if y + dy < 0 or x + dx < 0 or x + dx >= sources.shape[1]:
                continue
            v, u = sources[y + dy, x + dx] // columns - dy, sources[y + dy, x + dx] % columns - dx
            if radius <= v < rows - radius and radius <= u < columns - radius:
                place = np.int32(v * columns + u)
            else:
                place = random_place(word, tap, rows, columns, radius)
            known = False
            for other in range(count):
                if candidates[other] == place:
                    known = True
                    break
            if not known:
                candidates[count] = place
                count += 1
    return count


@compiled
def synthesise_ashikhmin(exemplar, shape, seed, radius):
    """Places [row, col] of the exemplar uint8 [row, col, channel]; `seed` is two words."""
    rows, columns, channels = exemplar.shape
    sources = np.empty(shape, np.int32)
    made = np.empty((shape[0], shape[1], channels), np.uint8)
    candidates = np.empty(2 * radius * (radius + 1), np.int32)
    for y in range(shape[0]):
        for x in range(shape[1]):
            word = mix(np.uint32(seed[0] + mix(np.uint32(seed[1] + np.uint32(y * shape[1] + x)))))
            count = suggest(candidates, sources, y, x, word, rows, columns, radius)
            best = candidates[0] if count else random_place(word, 0, rows, columns, radius)
            if count > 1:
                least = np.int32(2**31 - 1)
                for number in range(count):
                    place = candidates[number]
                    distance = causal_distance(exemplar, made, place // columns, place % columns, y, x, radius, least)
                    if distance < least or (distance == least and place < best):
                        best, least = place, distance
            sources[y, x] = best
            for channel in range(channels):
                made[y, x, channel] = exemplar[best // columns, best % columns, channel]
    return sources


@compiled
def synthesise_wei_levoy(exemplar, shape, first, radius, give_up):
    """Places [row, col] of an exhaustive search; `first` is the first pixel's place. `give_up` leaves a candidate as
    soon as it is known to be worse than the best."""
    rows, columns, channels = exemplar.shape
    sources = np.empty(shape, np.int32)
    made = np.empty((shape[0], shape[1], channels), np.uint8)
    for y in range(shape[0]):
        for x in range(shape[1]):
            best, least = first, np.int32(2**31 - 1)
            if x + y > 0:
                for v in range(radius, rows - radius):
                    for u in range(radius, columns - radius):
                        enough = least if give_up else np.int32(2**31 - 1)
                        distance = causal_distance(exemplar, made, v, u, y, x, radius, enough)
                        if distance < least:
                            best, least = np.int32(v * columns + u), distance
            sources[y, x] = best
            for channel in range(channels):
                made[y, x, channel] = exemplar[best // columns, best % columns, channel]
    return sources
