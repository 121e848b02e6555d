"""Elimination and over-relaxation on narrow parts of a region; see `solvers.narrow` for what it makes of them."""

import math

import numpy as np

from solvers.kernels.policy import inlined, jit, loops
from solvers.native.prefetch import prefetch

KNOWN, BEYOND = -1, -2  # in place of a neighbour's number: the pixel is known, the image ends

# An unknown's record among the integers: how it stands, how many neighbours, and which;
STATE, DEGREE, LINKS = range(3)
# and among the numbers: d, then b of each channel, then the weights of its neighbours, in the same order.
DIAGONAL, SUMS = range(2)

# How an unknown stands.
WAITING, STACKED, ELIMINATED = range(3)

ROOM = 14  # neighbours that a record has room for: a cache line with the rest
# Unknowns with so many neighbours are eliminated, those with the fewest first: a stroke has two or three at its end.
FEWEST, MOST = 2, 6

u = np.uint64  # what arrays are indexed with, see solvers.kernels

WINDOW = 8  # equations at hand in `solve_in_window`

# Over-relaxation of what elimination leaves.
FIRST_OMEGA = 1.2  # for the first sweeps;
LOOK = 3  # after so many it is chosen anew, and they are ended if the error is small;
SWEEPS = 90  # after so many they are given up
LARGEST_RHO = 0.9999
APART = (
    4  # equations in a row are mostly neighbours', which wait for each other: they are relaxed so far apart
)
TOGETHER = 4  # neighbours are added
Z_PRECISION = 1e-3  # the solution of A z = 1 is used as a bound: this share of it may be missing
FLOOR = 1e-14  # share of x that is rounding

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
def known_of(values, i, span, c):
    """values[i, c] of (n, span) values, 0 if i is none."""
    value = values[u(max(i, 0) * span + c)]
    return value if i >= 0 else 0.0


@inlined
def known_beside(ring, at, is_known):
    """Which of the rim's pixels lies at a place of the ring; -1 if that pixel is none of them."""
    which = np.int64(ring[u(at if is_known else 0)])
    return which if is_known else np.int64(-1)


@jit
def sum_rim(b, ring, place, near, values, rows, cols, width):
    """The same where the first guess and v are zero: b = the sum of the known values beside each unknown.

    ring: (3 * width,) int32, scratch: of the pixels in three rows, which of the rim's each is.  near: of `link`.
    values: (m, channels) float32 of the known pixels in `rows` and `cols`, in reading order: all that have an unknown
    neighbour.
    """
    channels, pixels = values.shape[1], rows.shape[0]
    flat = values.reshape(-1)
    row, next_row = np.int64(-1), np.int64(0)
    above = here = below = np.int64(0)  # where the rows begin in the ring
    entered = np.int64(0)
    ring[0] = 0
    for i in range(place.shape[0]):
        at = place[u(i)]
        if at >= next_row:
            row = at // width
            next_row = (row + 1) * width
            above, here, below = (row + 2) % 3 * width, row % 3 * width, (row + 1) % 3 * width
            while entered < pixels and rows[u(entered)] <= row + 1:
                ring[u(rows[u(entered)] % 3 * width + cols[u(entered)])] = entered
                entered += 1
        col = at - (next_row - width)
        north = known_beside(ring, above + col, near[u(i), 0] == KNOWN)
        west = known_beside(ring, here + col - 1, near[u(i), 1] == KNOWN)
        east = known_beside(ring, here + col + 1, near[u(i), 2] == KNOWN)
        south = known_beside(ring, below + col, near[u(i), 3] == KNOWN)
        for c in range(channels):
            along = np.float64(known_of(flat, north, channels, c)) + np.float64(
                known_of(flat, south, channels, c)
            )
            across = np.float64(known_of(flat, west, channels, c)) + np.float64(
                known_of(flat, east, channels, c)
            )
            b[u(i), u(c)] = along + across


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


@inlined
def sum_around(values, near, i, span, c):
    """The sum of values[p, c] over the neighbours p of unknown i."""
    north, west, east, south = near[u(i), 0], near[u(i), 1], near[u(i), 2], near[u(i), 3]
    along = known_of(values, north, span, c) + known_of(values, south, span, c)
    return along + (known_of(values, west, span, c) + known_of(values, east, span, c))


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


# --- larger parts: half of the unknowns first ---------------------------------------------------------------------
#
# Coloured like a checkerboard, the red unknowns of a part have none but black neighbours.  So all red ones are
# eliminated at once, with no book-keeping: x_r = (b_r + sum of x_p) / d_r, over up to four black p, adds 1 / d_r to the
# weight between any two of those.  The equation of a black unknown then names the eight black ones around it, straight
# ahead through one red pixel, diagonally through two.


@jit
def colour(number, members, place, order, row_length, start, n):
    """Numbers the black ones among a part's n unknowns; returns how many there are, which is no more than half of n.

    number: int32, of each unknown its number among the black ones of its part.  members: (n,) int32, the black unknowns
    of this part, then the red ones.  place: int64, row * row_length + column.
    """
    odd = np.int64(0)
    for k in range(start, start + n):
        i = order[u(k)]
        row = place[u(i)] // row_length
        number[u(i)] = (row + place[u(i)] - row * row_length) & 1
        odd += number[u(i)]
    black = np.int64(2 * odd <= n)
    blacks = odd if black else n - odd
    count, reds = np.int64(0), blacks
    for k in range(start, start + n):
        i = order[u(k)]
        is_black = np.int64(number[u(i)] == black)
        members[u(count if is_black else reds)] = i
        number[u(i)] = count
        count += is_black
        reds += 1 - is_black
    return blacks


@inlined
def share(near, i):
    """1 / d of unknown i, 0 if it is none: nothing goes to and fro through a known pixel."""
    inverse = 1.0 / neighbours(near, max(i, 0))
    return inverse if i >= 0 else 0.0


@inlined
def beyond(near, i, side):
    """The neighbour of unknown i on that side, KNOWN if i is none."""
    other = np.int64(near[u(max(i, 0)), side])
    return other if i >= 0 else np.int64(KNOWN)


@jit
def record(nodes, sums, b, near, number, members, count, width):
    """Records of a part's black unknowns, its red ones being eliminated; see `colour`."""
    stride, span, weights = LINKS + ROOM, SUMS + width + ROOM, SUMS + width
    flat, channels = b.reshape(-1), width - 1
    for v in range(count):
        i = np.int64(members[u(v)])
        links, own = v * stride + LINKS, v * span
        north, west = np.int64(near[u(i), 0]), np.int64(near[u(i), 1])
        east, south = np.int64(near[u(i), 2]), np.int64(near[u(i), 3])
        by_north, by_west = share(near, north), share(near, west)
        by_east, by_south = share(near, east), share(near, south)
        degree = np.int64(0)
        for other, weight in (
            (beyond(near, north, 0), by_north),
            (max(beyond(near, north, 1), beyond(near, west, 0)), by_north + by_west),
            (max(beyond(near, north, 2), beyond(near, east, 0)), by_north + by_east),
            (beyond(near, west, 1), by_west),
            (beyond(near, east, 2), by_east),
            (max(beyond(near, south, 1), beyond(near, west, 3)), by_south + by_west),
            (max(beyond(near, south, 2), beyond(near, east, 3)), by_south + by_east),
            (beyond(near, south, 3), by_south),
        ):
            # If it is none, the next one comes here.
            nodes[u(links + degree)] = number[u(other if other >= 0 else i)]
            sums[u(own + weights + degree)] = weight
            degree += other >= 0
        nodes[u(v * stride + DEGREE)] = degree
        sums[u(own + DIAGONAL)] = neighbours(near, i) - ((by_north + by_south) + (by_west + by_east))
        for c in range(channels):
            along = by_north * known_of(flat, north, channels, c) + by_south * known_of(
                flat, south, channels, c
            )
            across = by_west * known_of(flat, west, channels, c) + by_east * known_of(flat, east, channels, c)
            sums[u(own + SUMS + c)] = b[u(i), u(c)] + (along + across)
        sums[u(own + SUMS + width - 1)] = 1.0 + ((by_north + by_south) + (by_west + by_east))


# --- elimination, unknowns with few neighbours first --------------------------------------------------------------


@inlined
def eliminate_one(nodes, sums, marks, stack, top, limit, v, d, width):
    """Takes unknown v out of the equations of its d neighbours.

    Those that have no more than `limit` neighbours left are put on the stack, which held `top`; returns how many it
    holds now.
    """
    stride, span, weights = LINKS + ROOM, SUMS + width + ROOM, SUMS + width
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
def crowded(nodes, v, d):
    """Whether a neighbour of v, which has d, might have no room for the others."""
    stride = LINKS + ROOM
    for p in range(d):
        q = np.int64(nodes[u(v * stride + LINKS + p)])
        if nodes[u(q * stride + DEGREE)] + d - 2 > ROOM:
            return True
    return False


@jit
def eliminate(nodes, sums, marks, stack, left, sequence, n, width):
    """Eliminates unknowns with up to `MOST` neighbours, those with few first; returns how many.

    Eliminating x_p = (b_p + sum of w_pq x_q) / d_p leaves its neighbours coupled with each other, by w_pq w_pr / d_p
    more than before.  The record of p stays as it is then, for `substitute`, but with 1 / d_p for d_p.

    First come all that have up to two neighbours, or have no more by then, next all with three, and so on.  Whoever
    loses a neighbour is looked at at once, so that a stroke is followed from its end.

    nodes, sums: a record of each unknown, with `width` channels.  marks, stack: (n,), scratch.  sequence: the unknowns
    in the order of elimination.  left: (n,), becomes those that are left.
    """
    stride = LINKS + ROOM
    for k in range(n):
        nodes[u(k * stride + STATE)] = WAITING
        left[u(k)], marks[u(k)] = k, 0
    done, remaining = np.int64(0), np.int64(n)
    for limit in range(FEWEST, MOST + 1):
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
                if d > limit or (d > 2 and crowded(nodes, v, d)):
                    continue
                # Most have three or four, and a loop of known length is left without a wrong guess of the processor.
                if d == 2:
                    top = eliminate_one(nodes, sums, marks, stack, top, limit, v, 2, width)
                elif d == 3:
                    top = eliminate_one(nodes, sums, marks, stack, top, limit, v, 3, width)
                elif d == 4:
                    top = eliminate_one(nodes, sums, marks, stack, top, limit, v, 4, width)
                else:
                    top = eliminate_one(nodes, sums, marks, stack, top, limit, v, d, width)
                sequence[u(done)] = v
                done += 1
    waiting, remaining = remaining, np.int64(0)
    for first in range(APART):
        for k in range(first, waiting, APART):
            stack[u(remaining)] = left[u(k)]
            remaining += nodes[u(left[u(k)] * stride + STATE)] == WAITING
    for k in range(remaining):
        left[u(k)] = stack[u(k)]
    return done


@jit
def substitute(nodes, sums, sequence, done, width):
    """x in place of b for the unknowns that `eliminate` eliminated; those of all others stand there already."""
    stride, span, weights = LINKS + ROOM, SUMS + width + ROOM, SUMS + width
    for k in range(done - 1, -1, -1):
        v = np.int64(sequence[k])
        links, own = v * stride + LINKS, v * span
        inverse = sums[u(own + DIAGONAL)]
        for p in range(nodes[u(v * stride + DEGREE)]):
            there = np.int64(nodes[u(links + p)]) * span
            add_channels(sums, own + SUMS, there + SUMS, sums[u(own + weights + p)], width)
        for c in range(SUMS, SUMS + width):
            sums[u(own + c)] *= inverse


# --- over-relaxation of what is left ------------------------------------------------------------------------------


@loops
def find_residual(residual, terms, values, b, x, d, n):
    """residual = b - d x in n channels."""
    for c in range(u(n)):
        residual[c] = terms[u(b) + c] - d * values[u(x) + c]


@loops
def add_neighbours(residual, values, weights, w, one, two, three, four, n):
    """residual += the sum of w x over four neighbours, in n channels."""
    for c in range(u(n)):
        residual[c] += (weights[u(w)] * values[u(one) + c] + weights[u(w + 1)] * values[u(two) + c]) + (
            weights[u(w + 2)] * values[u(three) + c] + weights[u(w + 3)] * values[u(four) + c]
        )


@inlined
def relax_one(values, residual, terms, edges, links, weights, k, width, omega):
    """Gauss-Seidel on equation k, over-relaxed by omega; leaves b - A x from before in `residual`.  See `relax`."""
    x, b = k * width, k * (width + 1)
    d = terms[u(b + width)]
    find_residual(residual, terms, values, b, x, d, width)
    for p in range(edges[u(k)], edges[u(k + 1)], TOGETHER):
        one, two, three, four = links[u(p)], links[u(p + 1)], links[u(p + 2)], links[u(p + 3)]
        add_neighbours(residual, values, weights, p, one, two, three, four, width)
    add_scaled(values, x, residual, 0, omega / d, width)


@inlined
def gather(values, terms, edges, links, weights, nodes, sums, marks, left, n, width):
    """The equations of the n unknowns that are left, one behind the other; see `relax`."""
    stride, span = LINKS + ROOM, SUMS + width + ROOM
    for k in range(n):
        marks[u(left[u(k)])] = k * width
    end = np.int64(0)
    for k in range(n):
        v = np.int64(left[u(k)])
        own = v * span
        for c in range(width):
            values[u(k * width + c)] = 0.0
            terms[u(k * (width + 1) + c)] = sums[u(own + SUMS + c)]
        terms[u(k * (width + 1) + width)] = sums[u(own + DIAGONAL)]
        edges[u(k)] = end
        for p in range(nodes[u(v * stride + DEGREE)]):
            links[u(end)] = marks[u(nodes[u(v * stride + LINKS + p)])]
            weights[u(end)] = sums[u(own + SUMS + width + p)]
            end += 1
        while end % TOGETHER != 0:
            links[u(end)], weights[u(end)] = k * width, 0.0
            end += 1
    edges[u(n)] = end


@jit
def relax(values, residual, terms, edges, links, weights, nodes, sums, marks, left, n, width, precision):
    """x in place of b for the n unknowns that `eliminate` left, by sweeps of over-relaxation; returns how many.

    All is known of the convergence that there is to know while it goes on, since A z = 1 is solved beside A x = b, as
    the last channel, whose right-hand side is s after elimination.  For a matrix like this (Collatz 1942), Jacobi's
    iteration contracts by rho <= 1 - min s_i / (d_i z_i), which gives the best omega (Young 1954); and if all residuals
    |r_i| <= t s_i, then the error is at most t z.

    values, residual, terms, edges, links, weights: scratch; of each equation x, of one b - A x, of each b and d, where
    its neighbours begin, and of each neighbour where its x lies, and w.  precision: of x, absolute.  Returns -1 if
    `SWEEPS` were too few.
    """
    gather(values, terms, edges, links, weights, nodes, sums, marks, left, n, width)
    omega = FIRST_OMEGA
    for sweep in range(1, SWEEPS + 1):
        worst, missing, softest, largest, hardest = 0.0, 0.0, 0.0, 0.0, 1.0
        look = sweep % LOOK == 0
        for k in range(n):
            # Of known length the loops over channels become vectors.
            if width == 4:
                relax_one(values, residual, terms, edges, links, weights, k, 4, omega)
            else:
                relax_one(values, residual, terms, edges, links, weights, k, width, omega)
            if look:
                term = k * (width + 1) + width
                s, d, last = terms[u(term - 1)], terms[u(term)], width - 1
                z = values[u(k * width + last)]
                softest, hardest = max(softest, z), min(hardest, s / (d * z))
                missing = max(missing, abs(residual[u(last)]) / s)
                for c in range(last):
                    worst = max(worst, abs(residual[u(c)]) / s)
                    largest = max(largest, abs(values[u(k * width + c)]))
        if not look:
            continue
        if worst * softest <= max(precision, FLOOR * largest) and missing <= Z_PRECISION:
            span = SUMS + width + ROOM
            for k in range(n):
                for c in range(width):
                    sums[u(left[u(k)] * span + SUMS + c)] = values[u(k * width + c)]
            return sweep
        rho = min(max(1.0 - hardest, 0.0), LARGEST_RHO)  # while z is on its way it may say anything
        omega = 2.0 / (1.0 + math.sqrt(1.0 - rho * rho))
    return -1


# --- solution -----------------------------------------------------------------------------------------------------


@jit
def unfold(x, z, sums, b, near, members, count, n, width):
    """x and z of a part's n unknowns: the black ones' from their records, the red ones' from their neighbours'.

    Returns the largest z.
    """
    span, largest = SUMS + width + ROOM, 0.0
    for v in range(count):
        largest = max(largest, take(x, z, sums, v * span + SUMS, members[u(v)]))
    flat, channels = x.reshape(-1), width - 1
    for k in range(count, n):
        i = np.int64(members[u(k)])
        inverse = 1.0 / neighbours(near, i)
        for c in range(channels):
            x[u(i), u(c)] = inverse * (b[u(i), u(c)] + sum_around(flat, near, i, channels, c))
        z[u(i)] = inverse * (1.0 + sum_around(z, near, i, 1, 0))
        largest = max(largest, z[u(i)])
    return largest


@inlined
def take(x, z, sums, own, i):
    """x and z of unknown i from what lies from `own` on; returns z."""
    channels = x.shape[1]
    for c in range(channels):
        x[u(i), u(c)] = sums[u(own + c)]
    z[u(i)] = sums[u(own + channels)]
    return z[u(i)]


@jit
def solve_parts(
    x, z, softness, sweeps, nodes, sums, values, terms, edges, links, weights, marks, stack, left, sequence, members,
    window, number, b, near, order, rank, starts, place, row_length, first, end, precision,
):  # fmt: skip
    """Solves A x = b, and A z = 1, on the parts first ... end of the region.

    x, b: (n, channels) float64.  z: (n,) float64.  softness: per part, a bound of z.  sweeps: per part, how many it
    took; -1 if it is not solved, since more would have been needed.  The arrays in between are scratch for the largest
    part, `number` for all unknowns; see `eliminate`, `relax`, `colour` and `solve_in_window`.  near, order, rank,
    starts: of `link` and `sort_parts`.  place: (n,) int64, row * row_length + column.  precision: of x, absolute.
    """
    channels = b.shape[1]
    width = channels + 1  # the last one is for A z = 1
    for part in range(first, end):
        start = np.int64(starts[u(part)])
        n = np.int64(starts[u(part + 1)]) - start
        sweeps[u(part)] = 0
        if n == 1:
            i = np.int64(order[u(start)])
            inside = neighbours(near, i)
            softness[u(part)] = z[u(i)] = 1.0 / inside
            for c in range(channels):
                x[u(i), u(c)] = b[u(i), u(c)] / inside
            continue
        reach = reach_of(near, order, rank, start, n)
        largest = 0.0
        if reach < WINDOW:
            solve_in_window(sums, window, b, near, order, rank, start, n, reach, width)
            for k in range(n):
                at = k * (WINDOW + width) + WINDOW
                largest = max(largest, take(x, z, sums, at, order[u(start + k)]))
        else:
            count = colour(number, members, place, order, row_length, start, n)
            record(nodes, sums, b, near, number, members, count, width)
            done = eliminate(nodes, sums, marks, stack, left, sequence, count, width)
            if done < count:
                sweeps[u(part)] = relax(
                    values, window, terms, edges, links, weights, nodes, sums, marks, left, count - done, width,
                    precision,
                )  # fmt: skip
            if sweeps[u(part)] >= 0:
                substitute(nodes, sums, sequence, done, width)
                # What was missing of z is as of the last look, hence twice.
                largest = unfold(x, z, sums, b, near, members, count, n, width) * (1.0 + 2.0 * Z_PRECISION)
        softness[u(part)] = largest


@jit
def find_residuals(largest, x, b, near, part, first, end):
    """Per part the bit pattern of the largest |b - A x| at its unknowns, of which first ... end are looked at now."""
    flat, channels = x.reshape(-1), x.shape[1]
    for i in range(first, end):
        inside, k = neighbours(near, i), np.int64(part[u(i)])
        worst = largest[u(k)]
        for c in range(channels):
            r = (b[u(i), u(c)] - inside * x[u(i), u(c)]) + sum_around(flat, near, i, channels, c)
            worst = max(worst, bits_of(r))
        largest[u(k)] = worst
