"""A pass of k-coherent search in scaled and turned neighbourhoods as loops over pixels, compiled by Numba for one
thread: the comparison of the benchmark. Decisions are those of `jaxtex.synthesis.anisometric_pass` but for rounding."""

import numba
import numpy as np

from jaxtex.synthesis.exemplars import neighbourhood_taps, neighbourhood_weights

compiled = numba.njit(cache=False)


def decide_all(known, wanted, sources, tolerance, order, counts, radius, everywhere, tileable):
    """In place of the function of that name, for exemplars without frames of their own."""
    shape = known.valid.shape
    return decide(
        np.asarray(known.pixels),
        known.valid,
        np.asarray(known.basis),
        np.asarray(known.features).reshape(*shape, -1),
        np.asarray(known.similar),
        wanted.frames,
        np.linalg.inv(wanted.frames),
        wanted.guide,
        *wanted.transition,
        np.array(sources, np.float32),
        tolerance,
        order,
        counts,
        neighbourhood_taps(radius),
        neighbourhood_weights(radius),
        everywhere,
        tileable,
    )


@compiled
def inside(at, side, tileable):
    return at % side if tileable else min(max(at, 0), side - 1)


@compiled
def sample(picture, row, column, channels, found, tileable):
    """Bilinear, into `found`."""
    rows, columns = picture.shape[:2]
    top, left = int(np.floor(row)), int(np.floor(column))
    down, right = np.float32(row - top), np.float32(column - left)
    above, below = inside(top, rows, tileable), inside(top + 1, rows, tileable)
    before, after = inside(left, columns, tileable), inside(left + 1, columns, tileable)
    for channel in range(channels):
        upper = (1 - right) * picture[above, before, channel] + right * picture[above, after, channel]
        lower = (1 - right) * picture[below, before, channel] + right * picture[below, after, channel]
        found[channel] = (1 - down) * upper + down * lower


@compiled
def describe(pixels, basis, guide, sources, frame, back, taps, weights, row, column, feature, seen, tileable):
    """The components of a pixel's neighbourhood, into `feature`."""
    rows, columns = sources.shape[:2]
    colours = pixels.shape[2] - guide.shape[2]
    feature[:] = 0
    for tap in range(len(taps)):
        y = row + frame[0, 0] * taps[tap, 0] + frame[0, 1] * taps[tap, 1]
        x = column + frame[1, 0] * taps[tap, 0] + frame[1, 1] * taps[tap, 1]
        near_y, near_x = int(np.rint(y)), int(np.rint(x))
        if not tileable:
            near_y, near_x = min(max(near_y, 0), rows - 1), min(max(near_x, 0), columns - 1)
        away_y, away_x = y - near_y, x - near_x
        source = sources[near_y % rows, near_x % columns]
        from_y = source[0] + back[0, 0] * away_y + back[0, 1] * away_x
        from_x = source[1] + back[1, 0] * away_y + back[1, 1] * away_x
        sample(pixels, from_y, from_x, colours, seen, False)
        if guide.shape[2]:
            sample(guide, y, x, guide.shape[2], seen[colours:], tileable)
        for channel in range(len(seen)):
            value = seen[channel] * weights[tap]
            for component in range(len(feature)):
                feature[component] += value * basis[tap * len(seen) + channel, component]


@compiled
def choose(valid, features, similar, ours, value, tolerance, sources, back, row, column, feature, look, best, tileable):
    """The best of the places that neighbours lead to, into `best`; how far it is."""
    rows, columns = sources.shape[:2]
    height, width = valid.shape
    least = np.float32(np.inf)
    for down in range(-1, 2):
        for right in range(-1, 2):
            source = sources[inside(row + down, rows, tileable), inside(column + right, columns, tileable)]
            y = source[0] - back[0, 0] * down - back[0, 1] * right
            x = source[1] - back[1, 0] * down - back[1, 1] * right
            whole_y, whole_x = min(max(int(np.rint(y)), 0), height - 1), min(max(int(np.rint(x)), 0), width - 1)
            for number in range(similar.shape[1]):
                place = similar[whole_y * width + whole_x, number]
                to_y, to_x = place // width + y - whole_y, place % width + x - whole_x
                if to_y < 0 or to_x < 0 or to_y > height - 1 or to_x > width - 1:
                    continue
                near = int(np.rint(to_y)), int(np.rint(to_x))
                if not valid[near] or abs(ours[near] - value) >= tolerance:
                    continue
                sample(features, to_y, to_x, features.shape[2], look, False)
                distance = np.float32(0)
                for component in range(len(look)):
                    distance += (look[component] - feature[component]) ** 2
                if number:
                    distance *= np.float32(1.5)
                if distance < least:
                    least = distance
                    best[0], best[1] = to_y, to_x
    return least


@compiled
def search(valid, features, ours, value, tolerance, feature, least, best):
    """All places, into `best` where one is clearly nearer."""
    nearest = np.float32(np.inf)
    found = 0, 0
    for y in range(valid.shape[0]):
        for x in range(valid.shape[1]):
            if not valid[y, x] or abs(ours[y, x] - value) >= tolerance:
                continue
            distance = np.float32(0)
            for component in range(len(feature)):
                distance += (features[y, x, component] - feature[component]) ** 2
                if distance >= nearest:
                    break
            if distance < nearest:
                nearest, found = distance, (y, x)
    if 2 * nearest < least:
        best[0], best[1] = found


@compiled
def decide(
    pixels,
    valid,
    basis,
    features,
    similar,
    frames,
    backward,
    guide,
    ours,
    theirs,
    sources,
    tolerance,
    order,
    counts,
    taps,
    weights,
    everywhere,
    tileable,
):
    feature, look = np.empty(basis.shape[1], np.float32), np.empty(basis.shape[1], np.float32)
    seen, best = np.empty(pixels.shape[2], np.float32), np.empty(2, np.float32)
    for turn in range(len(counts)):
        former = sources.copy()
        for number in range(counts[turn]):
            row, column = order[turn, number]
            back, value = backward[row, column], theirs[row, column]
            frame = frames[row, column]
            describe(pixels, basis, guide, former, frame, back, taps, weights, row, column, feature, seen, tileable)
            best[:] = former[row, column]
            least = choose(
                valid,
                features,
                similar,
                ours,
                value,
                tolerance,
                former,
                back,
                row,
                column,
                feature,
                look,
                best,
                tileable,
            )
            if everywhere:
                search(valid, features, ours, value, tolerance, feature, least, best)
            sources[row, column] = best
    return sources
