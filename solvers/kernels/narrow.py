"""Gaussian elimination on parts of a region that are narrow; see `solvers.narrow` for what it makes of them."""

import numpy as np

from solvers.kernels.policy import inlined, jit, loops
from solvers.native.prefetch import prefetch

KNOWN, BEYOND = -1, -2  # in place of a neighbour's number: the pixel is known, the image ends

# An unknown's record among the integers: how it stands, its number in another list, how many neighbours, and which;
STATE, NUMBER, DEGREE, LINKS = range(4)
# and among the numbers: d, then b of each channel, then the weights of its neighbours, in the same order.
DIAGONAL, SUMS = range(2)

# How an unknown stands.
WAITING, STACKED, ELIMINATED = range(3)

# Neighbours that a record has room for: enough for strokes and specks, and a cache line with the rest;
ROOM = 13
# and enough for what strokes that cross leave.
LARGE_ROOM = 60
SPARE = 4  # the room that an unknown leaves when it has its turn, at least
CORE_STEPS = 32  # a full matrix of n unknowns takes n^3 / CORE_STEPS times as long as a step of elimination
FEWEST = 2  # neighbours: what a stroke has at its end

u = np.uint64  # what arrays are indexed with, see solvers.kernels

WINDOW = 8  # equations at hand in `solve_in_window`

TILE = 32  # columns, see `survey`
AHEAD = 24  # unknowns: how far before its turn its pixels are asked for

ABS_BITS = np.int64(0x7FFFFFFFFFFFFFFF)  # all but the sign of a float64


@inlined
def bits_of(value):
    """The bit pattern of |value|: as integers these order like the values, with NaN on top."""
    return np.float64(value).view(np.int64) & ABS_BITS


# --- a first look -------------------------------------------------------------------------------------------------


@jit
def survey(region, first, end, step):
    """Unknowns in rows first ... end, and pixels of the tiles of 2 x TILE that hold some; `first` is even.

    Of the pairs of rows one in `step` is looked at.
    """
    width = region.shape[1]
    unknowns = pixels = np.int64(0)
    for row in range(first, end, 2 * step):
        upper, lower = region[row], region[min(row + 1, end - 1)]
        for low in range(0, width, TILE):
            a, b = upper[low : min(low + TILE, width)], lower[low : min(low + TILE, width)]
            count = np.int32(0)
            for i in range(a.shape[0]):
                count += np.int32(a[i]) + np.int32(b[i])
            if count > 0:
                pixels += a.shape[0] * min(2, end - row)
            unknowns += count
        if row + 1 == end:  # the last row was counted twice
            for i in range(width):
                unknowns -= upper[i]
    return unknowns, pixels


# --- parts -------------------------------------------------------------------------------------------------------


@jit
def locate(place, count, words, pixels, first, end):
    """The places of unknowns among words first ... end of the region, behind `count` that are known already.

    words: the region's pixels in eights; the last word may lack some.  pixels: (height * width,) bool.  place: one
    longer than there are unknowns.  Returns how many are known now.
    """
    for word in range(first, end):
        if word == words.shape[0] or words[u(word)] != 0:
            for i in range(8 * word, min(8 * word + 8, pixels.shape[0])):
                place[u(count)] = i  # if it is none, the next one comes here
                count += pixels[u(i)]
    return count


@inlined
def root_of(part, i):
    """The first unknown of those that are known to be in the part of unknown i; makes the way there shorter."""
    while part[u(i)] != i:
        part[u(i)] = part[u(part[u(i)])]
        i = np.int64(part[u(i)])
    return i


@jit
def link(near, part, place, height, width, above, first, end):
    """The neighbours of unknowns first ... end, which are numbered in reading order.

    near: (n, 4) int32, the numbers of the north, west, east and south neighbour, or KNOWN, or BEYOND.  part: (n,)
    int32, a lower number in the same part, or an unknown's own if there is none: what `number_parts` starts from.
    place: (n,) int64, row * width + column of the unknowns, ascending.

    above: the first unknown not before the pixel north of this one, or any before that; returns that of the next.
    """
    row = place[first] // width
    next_row = (row + 1) * width
    for i in range(first, end):
        at = place[u(i)]
        while at >= next_row:
            row += 1
            next_row += width
        north = np.int64(BEYOND if row == 0 else KNOWN)
        west = np.int64(BEYOND if at == next_row - width else KNOWN)
        near[u(i), 2] = BEYOND if at == next_row - 1 else KNOWN
        near[u(i), 3] = BEYOND if row == height - 1 else KNOWN
        root = np.int64(i)
        part[u(i)] = i
        if west == KNOWN and i > 0 and place[u(i - 1)] == at - 1:
            west = np.int64(i - 1)
            near[u(west), 2] = i
            root = root_of(part, west)
            part[u(i)] = root
        while place[u(above)] < at - width:
            above += 1
        if place[u(above)] == at - width:
            north = above
            near[u(north), 3] = i
            other = root_of(part, north)
            part[u(max(root, other))] = min(root, other)
        near[u(i), 0], near[u(i), 1] = north, west
    return above


@jit
def number_parts(part, starts, pairs, near, count, first, end):
    """Numbers of the parts of unknowns first ... end, `count` parts having been found in those before.

    Parts are numbered in the order of their first unknowns.  part: of `link`; becomes the part's number.  starts: (n +
    1,) int32, the size of part k goes to starts[k + 1].  pairs: (n,) int32, the pairs of neighbours in each.
    """
    for i in range(first, end):
        ahead = np.int64(part[u(i)])
        k = count
        if ahead == i:
            starts[u(k + 1)], pairs[u(k)] = 0, 0
            count += 1
        else:
            k = np.int64(part[u(ahead)])  # a number already
        part[u(i)] = k
        starts[u(k + 1)] += 1
        for side in range(2):
            pairs[u(k)] += near[u(i), side] >= 0
    return count


@jit
def sort_parts(order, rank, ends, part, starts):
    """Unknowns part by part, in reading order within each.

    order: (n,) int32, their numbers.  rank: (n,) int32, where a number stands in it.  ends: (n_parts,) int32, scratch.
    starts: (n_parts + 1,) int32, of `number_parts`; becomes where each part begins, and where the last one ends.
    """
    starts[0] = 0
    for k in range(ends.shape[0]):
        ends[u(k)] = starts[u(k)]
        starts[u(k + 1)] += starts[u(k)]
    for i in range(part.shape[0]):
        k = part[u(i)]
        at = ends[u(k)]
        order[u(at)], rank[u(i)] = i, at
        ends[u(k)] = at + 1


# --- right-hand side and solution --------------------------------------------------------------------------------


@jit
def sum_pairs(b, place, values, across, down, rhs, height, top, low, high):
    """b_p = rhs_p + sum over q of v_pq - (f_p - f_q), in float64, for the unknowns low ... high.

    b: (n, channels) float64.  values: (rows, width, channels) f, known outside the region, first guess inside; row
    `top` of the image of this height comes first.  across, down: v on pixel pairs (`Guidance`); rhs: like values;
    arrays without rows stand for zeros.
    """
    width, channels = values.shape[1:]
    line = width * channels
    f, v_across, v_down, more = values.reshape(-1), across.reshape(-1), down.reshape(-1), rhs.reshape(-1)
    guided, weighed = across.shape[0] + down.shape[0] > 0, rhs.shape[0] > 0
    row, next_row = np.int64(top), (np.int64(top) + 1) * width
    for i in range(low, high):
        at = place[u(i)]
        while at >= next_row:
            row += 1
            next_row += width
        y, x = row - top, at - (next_row - width)
        own, pair = (y * width + x) * channels, (y * (width - 1) + x) * channels

        ahead = (place[u(min(i + AHEAD, high - 1))] - top * width) * channels
        prefetch(f, ahead)
        prefetch(f, ahead - line)
        prefetch(f, ahead + line)
        if guided:
            prefetch(v_down, ahead)
            prefetch(v_down, ahead - line)
            prefetch(v_across, ahead - y * channels)
        if weighed:
            prefetch(more, ahead)

        north, south, west, east = row > 0, row < height - 1, x > 0, x < width - 1
        # In place of a pixel beyond the edge stands the pixel itself.
        above, below, left, right = north * line, south * line, west * channels, east * channels
        for c in range(channels):
            o, p = own + c, pair + c
            here = np.float64(f[u(o)])
            total = (np.float64(f[u(o - above)]) - here) + (np.float64(f[u(o + below)]) - here)
            total += (np.float64(f[u(o - left)]) - here) + (np.float64(f[u(o + right)]) - here)
            if guided:
                if north:
                    total -= np.float64(v_down[u(o - line)])
                if south:
                    total += np.float64(v_down[u(o)])
                if west:
                    total -= np.float64(v_across[u(p - channels)])
                if east:
                    total += np.float64(v_across[u(p)])
            if weighed:
                total += np.float64(more[u(o)])
            b[u(i), u(c)] = total


@inlined
def add_known(b, i, values, rows, cols, width, k, wanted):
    """b_i += the value of the known pixel at place `wanted`, which comes k-th or later; returns which it is."""
    while k < rows.shape[0] - 1 and rows[u(k)] * width + cols[u(k)] < wanted:
        k += 1
    for c in range(values.shape[1]):
        b[u(i), u(c)] += np.float64(values[u(k), u(c)])
    return k


@jit
def sum_rim(b, place, near, values, rows, cols, width):
    """The same where the first guess and v are zero: b = the sum of the known values beside each unknown.

    near: of `link`.  values: (m, channels) of the known pixels in `rows` and `cols`, in reading order: all that have an
    unknown neighbour.
    """
    north, west, east, south = np.int64(0), np.int64(0), np.int64(0), np.int64(0)
    for i in range(place.shape[0]):
        at = place[u(i)]
        for c in range(values.shape[1]):
            b[u(i), u(c)] = 0.0
        if near[u(i), 0] == KNOWN:
            north = add_known(b, i, values, rows, cols, width, north, at - width)
        if near[u(i), 1] == KNOWN:
            west = add_known(b, i, values, rows, cols, width, west, at - 1)
        if near[u(i), 2] == KNOWN:
            east = add_known(b, i, values, rows, cols, width, east, at + 1)
        if near[u(i), 3] == KNOWN:
            south = add_known(b, i, values, rows, cols, width, south, at + width)


@jit
def add_at(guess, solution, place, low, high, top):
    """guess += solution at the unknowns low ... high.

    guess: (rows, width, channels), of which row `top` of the image comes first.  solution: (n, channels) float64.
    """
    width, channels = guess.shape[1:]
    flat, before = guess.reshape(-1), top * width
    for i in range(low, high):
        prefetch(flat, (place[u(min(i + AHEAD, high - 1))] - before) * channels)
        at = (place[u(i)] - before) * channels
        for c in range(channels):
            flat[u(at + c)] += solution[u(i), u(c)]


# --- elimination in reading order --------------------------------------------------------------------------------


@loops
def add_scaled(sums, to, others, a, factor, n):
    """sums[to ...] += factor * others[a ...], n of them."""
    for k in range(u(n)):
        sums[u(to) + k] += factor * others[u(a) + k]


@inlined
def add_channels(sums, to, a, factor, width):
    """sums[to ...] += factor * sums[a ...], `width` of them; four, for three channels, in one go."""
    if width == 4:
        add_scaled(sums, to, sums, a, factor, 4)
    else:
        add_scaled(sums, to, sums, a, factor, width)


@inlined
def add_row(sums, to, others, a, factor, width):
    """sums[to ...] += factor * others[a ...], a row of the window.  In two pieces of whole vectors: LLVM would make one
    loop of them, with masks, and what is stored through a mask takes long to be read again.
    """
    add_scaled(sums, to, others, a, factor, WINDOW)
    if width == 4:
        add_scaled(sums, to + WINDOW, others, a + WINDOW, factor, 4)
    else:
        add_scaled(sums, to + WINDOW, others, a + WINDOW, factor, width)


@loops
def scale(sums, to, others, a, factor, n):
    """sums[to ...] = factor * others[a ...], n of them."""
    for k in range(u(n)):
        sums[u(to) + k] = factor * others[u(a) + k]


@inlined
def scale_row(sums, to, others, a, factor, width):
    """The same for a row of the window."""
    scale(sums, to, others, a, factor, WINDOW)
    if width == 4:
        scale(sums, to + WINDOW, others, a + WINDOW, factor, 4)
    else:
        scale(sums, to + WINDOW, others, a + WINDOW, factor, width)


@inlined
def neighbours(near, i):
    """How many neighbours of unknown i are inside the image."""
    inside = 0.0
    for side in range(4):
        inside += near[u(i), side] != BEYOND
    return inside


@jit
def reach_of(near, order, rank, start, n):
    """How far apart neighbours in a part are, in reading order; the part's n unknowns begin at `start` in `order`."""
    reach = np.int64(0)
    for at in range(start, start + n):
        i = order[u(at)]
        north, west = near[u(i), 0], near[u(i), 1]
        if west >= 0:
            reach = max(reach, np.int64(1))
        if north >= 0:
            reach = max(reach, at - rank[u(north)])
    return reach


@inlined
def enter(window, b, near, order, rank, start, k, width):
    """Writes the equation of a part's unknown k into the window: what is known of it, and of earlier unknowns."""
    span, slot = WINDOW + width, k % WINDOW
    own, i = slot * span, np.int64(order[u(start + k)])
    for j in range(u(WINDOW)):
        window[u(own) + j] = 0.0
    window[u(own + slot)] = neighbours(near, i)
    for side in range(2):
        other = np.int64(near[u(i), side])
        if other >= 0:
            there = (rank[u(other)] - start) % WINDOW
            window[u(own + there)] = window[u(there * span + slot)] = -1.0
    for c in range(width - 1):
        window[u(own + WINDOW + c)] = b[u(i), u(c)]
    window[u(own + WINDOW + width - 1)] = 1.0


@jit
def solve_in_window(sums, window, b, near, order, rank, start, n, reach, width):
    """Solves A x = b on a part in which neighbours are at most `reach` < WINDOW apart, eliminating in reading order.

    Eliminating an unknown changes no equation but the next `reach`.  The window holds those: row and column of unknown
    k are its k mod WINDOW, and `width` channels of b follow.  Row k of `sums` is what its equation was at its turn, by
    d_k; x takes the place of b there.
    """
    span = WINDOW + width
    entered = np.int64(0)
    for k in range(n):
        last = min(k + reach, n - 1)
        while entered <= last:
            enter(window, b, near, order, rank, start, entered, width)
            entered += 1
        slot = k % WINDOW
        own, row = slot * span, k * span
        inverse = 1.0 / window[u(own + slot)]
        scale_row(sums, row, window, own, inverse, width)
        for other in range(k + 1, last + 1):
            there = other % WINDOW * span
            weight = window[u(there + slot)]
            add_row(window, there, sums, row, -weight, width)
            window[u(there + slot)] = 0.0
    for back in range(n):
        k = n - 1 - back
        row = k * span
        for other in range(k + 1, min(k + reach, n - 1) + 1):
            weight = sums[u(row + other % WINDOW)]
            add_channels(sums, row + WINDOW, other * span + WINDOW, -weight, width)


# --- elimination, unknowns with few neighbours first --------------------------------------------------------------


@inlined
def eliminate_one(nodes, sums, marks, stack, top, limit, v, d, width, room):
    """Takes unknown v out of the equations of its d neighbours.

    Those that have no more than `limit` neighbours left are put on the stack, which held `top`; returns how many it
    holds now.
    """
    stride, span, weights = LINKS + room, SUMS + width + room, SUMS + width
    links, own = v * stride + LINKS, v * span
    inverse = 1.0 / sums[u(own + DIAGONAL)]
    sums[u(own + DIAGONAL)] = inverse
    nodes[u(v * stride + STATE)] = ELIMINATED
    for p in range(d):
        q, weight = np.int64(nodes[u(links + p)]), sums[u(own + weights + p)]
        base, there = q * stride + LINKS, q * span
        share = weight * inverse
        sums[u(there + DIAGONAL)] -= share * weight
        add_channels(sums, there + SUMS, own + SUMS, share, width)
        # Where each neighbour of q stands in its record.  What was marked before is wrong, and found to be so.
        degree = np.int64(nodes[u(q * stride + DEGREE)])
        for at in range(degree):
            marks[u(nodes[u(base + at)])] = at
        # q forgets v, and comes to know the others.
        degree -= 1
        s, last = np.int64(marks[u(v)]), np.int64(nodes[u(base + degree)])
        nodes[u(base + s)], marks[u(last)] = last, s
        sums[u(there + weights + s)] = sums[u(there + weights + degree)]
        for o in range(d):
            if o != p:
                r = np.int64(nodes[u(links + o)])
                more = (weight * sums[u(own + weights + o)]) * inverse
                s = np.int64(marks[u(r)])
                if s < degree and nodes[u(base + s)] == r:
                    sums[u(there + weights + s)] += more
                else:
                    nodes[u(base + degree)], sums[u(there + weights + degree)] = r, more
                    degree += 1
        nodes[u(q * stride + DEGREE)] = degree
        if degree <= limit and nodes[u(q * stride + STATE)] == WAITING:
            nodes[u(q * stride + STATE)] = STACKED
            stack[u(top)] = q
            top += 1
    return top


@inlined
def crowded(nodes, v, room):
    """Whether a neighbour of v might have no room for the others."""
    stride = LINKS + room
    d = np.int64(nodes[u(v * stride + DEGREE)])
    for p in range(d):
        q = np.int64(nodes[u(v * stride + LINKS + p)])
        if nodes[u(q * stride + DEGREE)] + d - 2 > room:
            return True
    return False


@jit
def eliminate(nodes, sums, marks, stack, left, sequence, n, width, room, effort):
    """Eliminates unknowns, those with few neighbours first, as long as there is room; returns how many.

    Eliminating x_p = (b_p + sum of w_pq x_q) / d_p leaves its neighbours coupled with each other, by w_pq w_pr / d_p
    more than before.  The record of p stays as it is then, for `substitute`, but with 1 / d_p for d_p.

    First come all that have up to two neighbours, or have no more by then, next all with three, and so on.  Whoever
    loses a neighbour is looked at at once, so that a stroke is followed from its end.

    nodes, sums: a record of each unknown, with `room` for neighbours and `width` channels.  marks, stack, left: (n,),
    scratch.  sequence: the unknowns in the order of elimination.  effort: steps to take at most; returns -1 if it takes
    more.
    """
    stride = LINKS + room
    for k in range(n):
        nodes[u(k * stride + STATE)] = WAITING
        left[u(k)], marks[u(k)] = k, 0
    done, remaining = np.int64(0), np.int64(n)
    for limit in range(FEWEST, room - SPARE + 1):
        waiting, remaining = remaining, np.int64(0)
        for k in range(waiting):
            seed = np.int64(left[u(k)])
            at = seed * stride
            if nodes[u(at + STATE)] != WAITING:
                continue
            left[u(remaining)] = seed
            remaining += 1
            if nodes[u(at + DEGREE)] > limit:
                continue
            stack[0] = seed
            top = np.int64(1)
            while top > 0:
                top -= 1
                v = np.int64(stack[u(top)])
                at = v * stride
                nodes[u(at + STATE)] = WAITING
                d = np.int64(nodes[u(at + DEGREE)])
                if d > limit or (d > 2 and crowded(nodes, v, room)):
                    continue
                effort -= (d + 1) * (d + 1)
                if effort < 0:
                    return -1
                # Most have two or three, and a loop of known length is left without a wrong guess of the processor.
                if d == 2:
                    top = eliminate_one(nodes, sums, marks, stack, top, limit, v, 2, width, room)
                elif d == 3:
                    top = eliminate_one(nodes, sums, marks, stack, top, limit, v, 3, width, room)
                else:
                    top = eliminate_one(nodes, sums, marks, stack, top, limit, v, d, width, room)
                sequence[u(done)] = v
                done += 1
    return done


@jit
def substitute(nodes, sums, sequence, done, width, room):
    """x in place of b for the unknowns that `eliminate` eliminated; those of all others stand there already."""
    stride, span, weights = LINKS + room, SUMS + width + room, SUMS + width
    for k in range(done - 1, -1, -1):
        v = np.int64(sequence[k])
        links, own = v * stride + LINKS, v * span
        inverse = sums[u(own + DIAGONAL)]
        for p in range(nodes[u(v * stride + DEGREE)]):
            there = np.int64(nodes[u(links + p)]) * span
            add_channels(sums, own + SUMS, there + SUMS, sums[u(own + weights + p)], width)
        for c in range(SUMS, SUMS + width):
            sums[u(own + c)] *= inverse


@jit
def condense(large_nodes, large_sums, nodes, sums, n, width, room, large_room):
    """Those unknowns that `eliminate` left, in records with more room.  The old ones know their new number."""
    stride, span, weights = LINKS + room, SUMS + width + room, SUMS + width
    large_stride, large_span = LINKS + large_room, SUMS + width + large_room
    count = 0
    for v in range(n):
        if nodes[v * stride + STATE] != ELIMINATED:
            nodes[v * stride + NUMBER] = count
            count += 1
    for v in range(n):
        if nodes[v * stride + STATE] == ELIMINATED:
            continue
        number = np.int64(nodes[v * stride + NUMBER])
        degree = nodes[v * stride + DEGREE]
        large_nodes[number * large_stride + DEGREE] = degree
        for p in range(degree):
            q = np.int64(nodes[v * stride + LINKS + p])
            large_nodes[number * large_stride + LINKS + p] = nodes[q * stride + NUMBER]
        for k in range(weights + degree):
            large_sums[number * large_span + k] = sums[v * span + k]


@jit
def expand(sums, nodes, large_sums, n, width, room, large_room):
    """The values of the unknowns that `condense` took along, back to where they came from."""
    for v in range(n):
        if nodes[v * (LINKS + room) + STATE] != ELIMINATED:
            there = np.int64(nodes[v * (LINKS + room) + NUMBER]) * (SUMS + width + large_room)
            own = v * (SUMS + width + room)
            for c in range(SUMS, SUMS + width):
                sums[own + c] = large_sums[there + c]


@jit
def solve_core(core, nodes, sums, n, size, width, room):
    """x in place of b for the `size` unknowns that `eliminate` left, by a full matrix; `core` has room for it."""
    stride, span, weights = LINKS + room, SUMS + width + room, SUMS + width
    count = 0
    for v in range(n):
        if nodes[v * stride + STATE] != ELIMINATED:
            nodes[v * stride + NUMBER] = count
            count += 1
    for v in range(n):
        if nodes[v * stride + STATE] == ELIMINATED:
            continue
        own = np.int64(nodes[v * stride + NUMBER])
        for j in range(size):
            core[own, j] = 0.0
        core[own, own] = sums[v * span + DIAGONAL]
        for p in range(nodes[v * stride + DEGREE]):
            q = np.int64(nodes[v * stride + LINKS + p])
            core[own, np.int64(nodes[q * stride + NUMBER])] = -sums[v * span + weights + p]
        for c in range(width):
            core[own, size + c] = sums[v * span + SUMS + c]
    for j in range(size):
        pivot = core[j, j + 1 : size + width]
        for i in range(j + 1, size):
            factor = core[i, j] / core[j, j]
            if factor != 0.0:
                row = core[i, j + 1 : size + width]
                for k in range(row.shape[0]):
                    row[k] -= factor * pivot[k]
    for back in range(1, size + 1):
        i = size - back
        for c in range(size, size + width):
            for j in range(i + 1, size):
                core[i, c] -= core[i, j] * core[j, c]
            core[i, c] /= core[i, i]
    for v in range(n):
        if nodes[v * stride + STATE] != ELIMINATED:
            for c in range(width):
                sums[v * span + SUMS + c] = core[np.int64(nodes[v * stride + NUMBER]), size + c]


@jit
def solve_records(
    nodes, sums, large_nodes, large_sums, marks, stack, waiting, sequence, core, n, width, effort
):
    """x in place of b in the records of one part; whether that took no more than `effort` steps, and no more scratch.

    nodes, sums: records with `ROOM`.  large_nodes, large_sums: scratch, records with `LARGE_ROOM`.
    """
    done = eliminate(nodes, sums, marks, stack, waiting, sequence, n, width, ROOM, effort)
    left = n - done
    if done < 0 or left * (LINKS + LARGE_ROOM) > large_nodes.shape[0]:
        return False
    if left > 0:
        condense(large_nodes, large_sums, nodes, sums, n, width, ROOM, LARGE_ROOM)
        order = sequence[done:]
        more = eliminate(
            large_nodes, large_sums, marks, stack, waiting, order, left, width, LARGE_ROOM, effort
        )
        size = left - more
        if more < 0 or size > core.shape[0] or size * size * size > CORE_STEPS * effort:
            return False
        if size > 0:
            solve_core(core, large_nodes, large_sums, left, size, width, LARGE_ROOM)
        substitute(large_nodes, large_sums, order, more, width, LARGE_ROOM)
        expand(sums, nodes, large_sums, n, width, ROOM, LARGE_ROOM)
    substitute(nodes, sums, sequence, done, width, ROOM)
    return True


@jit
def record(nodes, sums, b, near, order, rank, start, n, width):
    """Records of a part's n unknowns, which begin at `start` in `order`."""
    stride, span, weights = LINKS + ROOM, SUMS + width + ROOM, SUMS + width
    for v in range(n):
        i = np.int64(order[u(start + v)])
        links, own = v * stride + LINKS, v * span
        degree = np.int64(0)
        for side in range(4):
            other = np.int64(near[u(i), side])
            if other >= 0:
                nodes[u(links + degree)], sums[u(own + weights + degree)] = rank[u(other)] - start, 1.0
                degree += 1
        nodes[u(v * stride + DEGREE)] = degree
        sums[u(own + DIAGONAL)] = neighbours(near, i)
        for c in range(width - 1):
            sums[u(own + SUMS + c)] = b[u(i), u(c)]
        sums[u(own + SUMS + width - 1)] = 1.0


@inlined
def take(x, sums, span, channel, order, start, n):
    """x of a part's n unknowns, that of unknown k from k * span + channel; returns the largest of what is behind it."""
    channels = x.shape[1]
    largest = 0.0
    for k in range(n):
        i, own = np.int64(order[u(start + k)]), k * span + channel
        for c in range(channels):
            x[u(i), u(c)] = sums[u(own + c)]
        largest = max(largest, sums[u(own + channels)])
    return largest


@jit
def solve_parts(
    x, softness, solved, nodes, sums, large_nodes, large_sums, marks, stack, waiting, sequence, core, window,
    b, near, order, rank, starts, first, end, effort,
):  # fmt: skip
    """Solves A x = b on the parts first ... end of the region.

    x, b: (n, channels) float64.  softness: per part, max A^-1 1.  solved: per part, whether it was: it is not if that
    takes more than `effort` steps per unknown, or more scratch.  The arrays in between are scratch for the largest
    part; see `solve_records`, and `solve_in_window`.  near, order, rank, starts: of `link` and `sort_parts`.
    """
    channels = b.shape[1]
    width = channels + 1  # the last one is for A z = 1
    for part in range(first, end):
        start = np.int64(starts[u(part)])
        n = np.int64(starts[u(part + 1)]) - start
        solved[u(part)] = True
        if n == 1:
            i = np.int64(order[u(start)])
            inside = neighbours(near, i)
            softness[u(part)] = 1.0 / inside
            for c in range(channels):
                x[u(i), u(c)] = b[u(i), u(c)] / inside
            continue
        reach = reach_of(near, order, rank, start, n)
        if reach < WINDOW:
            span, channel = WINDOW + width, np.int64(WINDOW)
            solve_in_window(sums, window, b, near, order, rank, start, n, reach, width)
        else:
            span, channel = SUMS + width + ROOM, np.int64(SUMS)
            record(nodes, sums, b, near, order, rank, start, n, width)
            solved[u(part)] = solve_records(
                nodes,
                sums,
                large_nodes,
                large_sums,
                marks,
                stack,
                waiting,
                sequence,
                core,
                n,
                width,
                effort * n,
            )
        softness[u(part)] = take(x, sums, span, channel, order, start, n)


@jit
def find_residuals(largest, x, b, near, part, first, end):
    """Per part the bit pattern of the largest |b - A x| at its unknowns, of which first ... end are looked at now."""
    for i in range(first, end):
        inside, k = neighbours(near, i), np.int64(part[u(i)])
        # In place of a neighbour that is none stands the unknown itself.
        north, west, east, south = near[u(i), 0], near[u(i), 1], near[u(i), 2], near[u(i), 3]
        if north < 0:
            north, inside = i, inside + 1.0
        if west < 0:
            west, inside = i, inside + 1.0
        if east < 0:
            east, inside = i, inside + 1.0
        if south < 0:
            south, inside = i, inside + 1.0
        worst = largest[u(k)]
        for c in range(x.shape[1]):
            others = (x[u(north), u(c)] + x[u(south), u(c)]) + (x[u(west), u(c)] + x[u(east), u(c)])
            r = (b[u(i), u(c)] - inside * x[u(i), u(c)]) + others
            worst = max(worst, bits_of(r))
        largest[u(k)] = worst
