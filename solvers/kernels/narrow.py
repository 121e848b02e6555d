"""Gaussian elimination on parts of a region that are narrow; see `solvers.narrow` for what it makes of them."""

import numpy as np

from solvers.kernels.policy import inlined, jit

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

TILE = 32  # columns, see `survey`

ABS_BITS = np.int64(0x7FFFFFFFFFFFFFFF)  # all but the sign of a float64


@inlined
def bits_of(value):
    """The bit pattern of |value|: as integers these order like the values, with NaN on top."""
    return np.float64(value).view(np.int64) & ABS_BITS


@inlined
def value_of(bits):
    """The value with this bit pattern."""
    return np.int64(bits).view(np.float64)


# --- a first look -------------------------------------------------------------------------------------------------


@jit
def survey(region, first, end):
    """Unknowns in rows first ... end, and pixels of the tiles of 2 x TILE that hold some; `first` is even."""
    width = region.shape[1]
    unknowns = pixels = np.int64(0)
    for row in range(first, end, 2):
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
def link(near, place, height, width):
    """The neighbours of all unknowns, which are numbered in reading order.

    near: (n, 4) int32, the numbers of the north, west, east and south neighbour, or KNOWN, or BEYOND.
    place: (n,) int64, row * width + column of the unknowns, ascending.
    """
    n = place.shape[0]
    above = np.int64(0)  # the first unknown not before the pixel north of this one
    row, next_row = np.int64(0), np.int64(width)
    for i in range(n):
        at = place[i]
        while at >= next_row:
            row += 1
            next_row += width
        near[i, 0] = BEYOND if row == 0 else KNOWN
        near[i, 1] = BEYOND if at == next_row - width else KNOWN
        near[i, 2] = BEYOND if at == next_row - 1 else KNOWN
        near[i, 3] = BEYOND if row == height - 1 else KNOWN
        while place[above] < at - width:
            above += 1
        if place[above] == at - width:
            near[i, 0] = above
            near[above, 3] = i
        if near[i, 1] == KNOWN and i > 0 and place[i - 1] == at - 1:
            near[i, 1] = i - 1
            near[i - 1, 2] = i


@jit
def find_parts(part, queue, starts, pairs, near, seed, count, enough):
    """Parts of the region that are connected, by breadth-first search from each first unknown in reading order.

    part: (n,) int32, the number of an unknown's part, negative where it has none yet.  queue: (n,) int32, scratch.
    starts: (n + 1,) int32, per part the number of unknowns in all parts before it.  pairs: (n,) int32, per part the
    pairs of neighbours.

    Goes on from unknown `seed` with `count` parts found, until at least `enough` more unknowns are done.  Returns the
    next seed and the number of parts.
    """
    n = part.shape[0]
    begun = tail = np.int64(starts[count])
    while seed < n and tail - begun < enough:
        if part[seed] < 0:
            head = tail
            queue[tail], part[seed] = seed, count
            tail += 1
            ends = np.int64(0)
            while head < tail:
                i = np.int64(queue[head])
                head += 1
                for side in range(4):
                    other = np.int64(near[i, side])
                    if other >= 0:
                        ends += 1
                        if part[other] < 0:
                            queue[tail], part[other] = other, count
                            tail += 1
            pairs[count] = ends // 2
            count += 1
            starts[count] = tail
        seed += 1
    return seed, count


@jit
def sort_parts(order, rank, ends, part, starts):
    """Unknowns part by part, in reading order within each.

    order: (n,) int32, their numbers.  rank: (n,) int32, where a number stands in it.  ends: (n_parts,) int32, scratch.
    """
    for k in range(ends.shape[0]):
        ends[k] = starts[k]
    for i in range(part.shape[0]):
        at = ends[part[i]]
        order[at], rank[i] = i, at
        ends[part[i]] = at + 1


# --- right-hand side and solution --------------------------------------------------------------------------------


@jit
def sum_pairs(b, place, near, values, across, down, rhs, top, low, high):
    """b_p = rhs_p + sum over q of v_pq - (f_p - f_q), in float64, for the unknowns low ... high.

    b: (n, channels) float64.  values: (rows, width, channels) f, known outside the region, first guess inside; row
    `top` of the image comes first.  across, down: v on pixel pairs (`Guidance`); rhs: like values; arrays without rows
    stand for zeros.
    """
    width, channels = values.shape[1:]
    f = values.reshape(-1)
    guided, weighed = across.shape[0] + down.shape[0] > 0, rhs.shape[0] > 0
    row, next_row = np.int64(top), (np.int64(top) + 1) * width
    for i in range(low, high):
        while place[i] >= next_row:
            row += 1
            next_row += width
        y, x = row - top, place[i] - (next_row - width)
        own = (y * width + x) * channels
        for channel in range(channels):
            at = own + channel
            here = np.float64(f[at])
            total = 0.0
            if near[i, 0] != BEYOND:
                total += np.float64(f[at - width * channels]) - here
            if near[i, 3] != BEYOND:
                total += np.float64(f[at + width * channels]) - here
            if near[i, 1] != BEYOND:
                total += np.float64(f[at - channels]) - here
            if near[i, 2] != BEYOND:
                total += np.float64(f[at + channels]) - here
            if guided:
                if near[i, 0] != BEYOND:
                    total -= np.float64(down[y - 1, x, channel])
                if near[i, 3] != BEYOND:
                    total += np.float64(down[y, x, channel])
                if near[i, 1] != BEYOND:
                    total -= np.float64(across[y, x - 1, channel])
                if near[i, 2] != BEYOND:
                    total += np.float64(across[y, x, channel])
            if weighed:
                total += np.float64(rhs[y, x, channel])
            b[i, channel] = total


@jit
def add_at(guess, solution, place, low, high, top):
    """guess += solution at the unknowns low ... high.

    guess: (rows, width, channels), of which row `top` of the image comes first.  solution: (n, channels) float64.
    """
    width, channels = guess.shape[1:]
    flat = guess.reshape(-1)
    for i in range(low, high):
        at = (place[i] - top * width) * channels
        for channel in range(channels):
            flat[at + channel] += solution[i, channel]


# --- elimination -------------------------------------------------------------------------------------------------


@inlined
def add_scaled(sums, to, a, factor, width):
    """sums[to ...] += factor * sums[a ...], `width` of them; four, for three channels, without a loop."""
    if width == 4:
        a0, a1, a2, a3 = sums[u(a)], sums[u(a + 1)], sums[u(a + 2)], sums[u(a + 3)]
        t0, t1, t2, t3 = sums[u(to)], sums[u(to + 1)], sums[u(to + 2)], sums[u(to + 3)]
        sums[u(to)] = t0 + factor * a0
        sums[u(to + 1)] = t1 + factor * a1
        sums[u(to + 2)] = t2 + factor * a2
        sums[u(to + 3)] = t3 + factor * a3
    else:
        for c in range(width):
            sums[u(to + c)] += factor * sums[u(a + c)]


@inlined
def position(nodes, base, degree, wanted):
    """Where `wanted` stands among the neighbours that begin at `base`; `degree` if it is none of them."""
    s = np.int64(0)
    while s < degree and nodes[u(base + s)] != wanted:
        s += 1
    return s


@inlined
def eliminate_one(nodes, sums, v, width, room):
    """Takes unknown v out of the equations of its neighbours."""
    stride, span, weights = LINKS + room, SUMS + width + room, SUMS + width
    d = np.int64(nodes[u(v * stride + DEGREE)])
    links, own = v * stride + LINKS, v * span
    inverse = 1.0 / sums[u(own + DIAGONAL)]
    sums[u(own + DIAGONAL)] = inverse
    nodes[u(v * stride + STATE)] = ELIMINATED
    for p in range(d):
        q, weight = np.int64(nodes[u(links + p)]), sums[u(own + weights + p)]
        base, there = q * stride + LINKS, q * span
        share = weight * inverse
        sums[u(there + DIAGONAL)] -= share * weight
        add_scaled(sums, there + SUMS, own + SUMS, share, width)
        # q forgets v, and comes to know the others.
        degree = np.int64(nodes[u(q * stride + DEGREE)]) - 1
        s = position(nodes, base, degree, v)
        nodes[u(base + s)] = nodes[u(base + degree)]
        sums[u(there + weights + s)] = sums[u(there + weights + degree)]
        for o in range(d):
            if o != p:
                r = np.int64(nodes[u(links + o)])
                more = (weight * sums[u(own + weights + o)]) * inverse
                s = position(nodes, base, degree, r)
                if s < degree:
                    sums[u(there + weights + s)] += more
                else:
                    nodes[u(base + s)], sums[u(there + weights + s)] = r, more
                    degree += 1
        nodes[u(q * stride + DEGREE)] = degree


@inlined
def crowded(nodes, v, room):
    """Whether a neighbour of v might have no room for the others."""
    stride = LINKS + room
    d = np.int64(nodes[u(v * stride + DEGREE)])
    full = False
    for p in range(d):
        q = np.int64(nodes[u(v * stride + LINKS + p)])
        full |= nodes[u(q * stride + DEGREE)] + d - 2 > room
    return full


@jit
def eliminate(nodes, sums, stack, sequence, n, width, room, effort):
    """Eliminates unknowns, those with few neighbours first, as long as there is room; returns how many.

    Eliminating x_p = (b_p + sum of w_pq x_q) / d_p leaves its neighbours coupled with each other, by w_pq w_pr / d_p
    more than before.  The record of p stays as it is then, for `substitute`, but with 1 / d_p for d_p.

    First come all that have up to two neighbours, or have no more by then, next all with three, and so on.  Whoever
    loses a neighbour is looked at at once, so that a stroke is followed from its end.

    nodes, sums: a record of each unknown, with `room` for neighbours and `width` channels.  stack: (n,), scratch.
    sequence: the unknowns in the order of elimination.  effort: steps to take at most; returns -1 if it takes more.
    """
    stride = LINKS + room
    for k in range(n):
        nodes[k * stride + STATE] = WAITING
    done = np.int64(0)
    for limit in range(FEWEST, room - SPARE + 1):
        for seed in range(n):
            at = seed * stride
            if nodes[u(at + STATE)] != WAITING or nodes[u(at + DEGREE)] > limit:
                continue
            stack[0] = seed
            top = 1
            while top > 0:
                top -= 1
                v = np.int64(stack[top])
                at = v * stride
                nodes[u(at + STATE)] = WAITING
                d = np.int64(nodes[u(at + DEGREE)])
                if d > limit or (d > 2 and crowded(nodes, v, room)):
                    continue
                effort -= (d + 1) * (d + 1)
                if effort < 0:
                    return -1
                eliminate_one(nodes, sums, v, width, room)
                sequence[done] = v
                done += 1
                for p in range(d):
                    q = np.int64(nodes[u(at + LINKS + p)])
                    if nodes[u(q * stride + STATE)] == WAITING and nodes[u(q * stride + DEGREE)] <= limit:
                        stack[top] = q
                        nodes[u(q * stride + STATE)] = STACKED
                        top += 1
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
            add_scaled(sums, own + SUMS, there + SUMS, sums[u(own + weights + p)], width)
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
def solve_records(nodes, sums, large_nodes, large_sums, stack, sequence, core, n, width, effort):
    """x in place of b in the records of one part; whether that took no more than `effort` steps, and no more scratch.

    nodes, sums: records with `ROOM`.  large_nodes, large_sums: scratch, records with `LARGE_ROOM`.
    """
    done = eliminate(nodes, sums, stack, sequence, n, width, ROOM, effort)
    left = n - done
    if done < 0 or left * (LINKS + LARGE_ROOM) > large_nodes.shape[0]:
        return False
    if left > 0:
        condense(large_nodes, large_sums, nodes, sums, n, width, ROOM, LARGE_ROOM)
        order = sequence[done:]
        more = eliminate(large_nodes, large_sums, stack, order, left, width, LARGE_ROOM, effort)
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
def solve_parts(
    b, solved, nodes, sums, large_nodes, large_sums, stack, sequence, core,
    near, order, rank, starts, first, end, effort,
):  # fmt: skip
    """Solves A x = b on the parts first ... end of the region; x takes the place of b.

    b: (n, channels) float64.  solved: per part, whether it was: it is not if that takes more than `effort` steps per
    unknown, or more scratch.  The arrays in between are scratch for the largest part; see `solve_records`.  near,
    order, rank, starts: of `link` and `find_parts`.

    Returns the bit pattern of a bound of the largest error: max A^-1 1 times the largest residual, per part.
    """
    channels = b.shape[1]
    width = channels + 1  # the last one is for A z = 1
    stride, span, weights = LINKS + ROOM, SUMS + width + ROOM, SUMS + width
    largest = np.int64(0)
    for part in range(first, end):
        start = np.int64(starts[part])
        n = np.int64(starts[part + 1]) - start
        for v in range(n):
            i = np.int64(order[start + v])
            degree, inside = np.int64(0), np.int64(0)
            for side in range(4):
                other = np.int64(near[i, side])
                inside += other != BEYOND
                if other >= 0:
                    nodes[v * stride + LINKS + degree] = rank[other] - start
                    sums[v * span + weights + degree] = 1.0
                    degree += 1
            nodes[v * stride + DEGREE] = degree
            sums[v * span + DIAGONAL] = inside
            for c in range(channels):
                sums[v * span + SUMS + c] = b[i, c]
            sums[v * span + SUMS + channels] = 1.0
        solved[part] = solve_records(
            nodes, sums, large_nodes, large_sums, stack, sequence, core, n, width, effort * n
        )
        if not solved[part]:
            continue
        softest, residual = np.int64(0), np.int64(0)
        for v in range(n):
            i = np.int64(order[start + v])
            softest = max(softest, bits_of(sums[v * span + SUMS + channels]))
            for c in range(channels):
                x = sums[v * span + SUMS + c]
                r = b[i, c]
                for side in range(4):
                    other = np.int64(near[i, side])
                    if other >= 0:
                        r += sums[(np.int64(rank[other]) - start) * span + SUMS + c] - x
                    elif other == KNOWN:
                        r -= x
                residual = max(residual, bits_of(r))
        for v in range(n):
            for c in range(channels):
                b[np.int64(order[start + v]), c] = sums[v * span + SUMS + c]
        largest = max(largest, bits_of(value_of(softest) * value_of(residual)))
    return largest
